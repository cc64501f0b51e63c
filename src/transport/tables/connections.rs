//! Connections under test: rays between two vertices with what they would carry.

use crate::geometry::RayColumns;
use crate::math::LANES;

/// Rows to be traced for visibility and then gathered.
pub struct ConnectionTable<const N: usize> {
    /// Number of rows in use.
    pub len: usize,
    /// From one end, along unit directions.
    pub rays: RayColumns,
    /// Length to test, in scene units.
    pub t_max: Vec<f32>,
    /// Intensity carried if nothing is in the way; weight included.
    pub value: Vec<[f32; N]>,
    /// Where it goes: the row of the sensor path, or the pixel.
    pub target: Vec<u32>,
    /// After tracing: not 0 if something is in the way.
    pub blocked: Vec<u32>,
}

impl<const N: usize> ConnectionTable<N> {
    /// An empty table for `capacity` rows; it grows if more come.
    pub fn new(capacity: usize) -> Self {
        Self {
            len: 0,
            rays: RayColumns::new(capacity),
            t_max: vec![0.0; capacity + LANES],
            value: vec![[0.0; N]; capacity + LANES],
            target: vec![0; capacity + LANES],
            blocked: vec![0; capacity + LANES],
        }
    }

    /// Removes all rows.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Appends a row.
    #[inline(always)]
    pub fn push(
        &mut self,
        origin: [f32; 3],
        direction: [f32; 3],
        t_max: f32,
        value: [f32; N],
        target: u32,
    ) {
        if self.len + LANES >= self.t_max.len() {
            self.grow();
        }
        let row = self.len;
        for axis in 0..3 {
            self.rays.origin[axis][row] = origin[axis];
            self.rays.direction[axis][row] = direction[axis];
        }
        self.t_max[row] = t_max;
        self.value[row] = value;
        self.target[row] = target;
        self.len += 1;
    }

    #[cold]
    fn grow(&mut self) {
        let capacity = 2 * self.t_max.len();
        for axis in 0..3 {
            self.rays.origin[axis].resize(capacity, 0.0);
            self.rays.direction[axis].resize(capacity, 0.0);
        }
        self.t_max.resize(capacity, 0.0);
        self.value.resize(capacity, [0.0; N]);
        self.target.resize(capacity, 0);
        self.blocked.resize(capacity, 0);
    }
}
