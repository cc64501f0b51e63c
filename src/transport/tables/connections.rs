//! Connections under test: rays between two vertices with what they would carry.

use crate::geometry::RayColumns;
use crate::math::LANES;
use crate::scene::baked::NONE;

use super::states::LightState;

/// A line that must be free.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// One end, off its surface.
    pub origin: [f32; 3],
    /// Towards the other, unit length.
    pub direction: [f32; 3],
    /// Its length.
    pub t_max: f32,
    /// The medium around its origin, a row of the scene's media or `NONE`.
    pub inside: u32,
}

impl Segment {
    /// Between two points that are off their surfaces; `inside` is the medium around the first.
    #[inline(always)]
    pub fn between(from: [f32; 3], to: [f32; 3], inside: u32) -> Self {
        let mut offset = [0.0; 3];
        for axis in 0..3 {
            offset[axis] = to[axis] - from[axis];
        }
        let [x, y, z] = offset;
        let t_max = (x * x + y * y + z * z).sqrt();
        let inverse = 1.0 / t_max;
        Self { origin: from, direction: [x * inverse, y * inverse, z * inverse], t_max, inside }
    }
}

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
    /// The medium around the rays' origins: a row of the scene's media, or `NONE`.
    pub inside: Vec<u32>,
    /// Polarization of the light that is carried: a row of `states`, or `NONE`.
    pub state: Vec<u32>,
    /// Polarized light, along the connection towards the sensor's side.
    pub states: Vec<LightState<N>>,
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
            inside: vec![NONE; capacity + LANES],
            state: vec![NONE; capacity + LANES],
            states: Vec::new(),
            blocked: vec![0; capacity + LANES],
        }
    }

    /// Removes all rows.
    pub fn clear(&mut self) {
        self.len = 0;
        self.states.clear();
    }

    /// Appends a row of unpolarized light.
    #[inline(always)]
    pub fn push(&mut self, segment: Segment, value: [f32; N], target: u32) {
        if self.len + LANES >= self.t_max.len() {
            self.grow();
        }
        let row = self.len;
        for axis in 0..3 {
            self.rays.origin[axis][row] = segment.origin[axis];
            self.rays.direction[axis][row] = segment.direction[axis];
        }
        self.t_max[row] = segment.t_max;
        self.inside[row] = segment.inside;
        self.state[row] = NONE;
        self.value[row] = value;
        self.target[row] = target;
        self.len += 1;
    }

    /// Appends a row of light in a state of polarization.
    pub fn push_polarized(
        &mut self,
        segment: Segment,
        value: [f32; N],
        target: u32,
        state: LightState<N>,
    ) {
        self.push(segment, value, target);
        self.state[self.len - 1] = self.states.len() as u32;
        self.states.push(state);
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
        self.inside.resize(capacity, NONE);
        self.state.resize(capacity, NONE);
        self.blocked.resize(capacity, 0);
    }
}
