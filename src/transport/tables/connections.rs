//! Connections under test: rays between two vertices with what they would carry.

use crate::geometry::{Ray, RayColumns};
use crate::math::columns::{Column, columns};
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

    /// The row of a connection that has not been traced.
    #[inline(always)]
    fn carrying<const N: usize>(self, value: [f32; N], target: u32, state: u32) -> Connection<N> {
        let Self { origin, direction, t_max, inside } = self;
        let rays = Ray { origin, direction };
        Connection { rays, t_max, value, target, inside, state, blocked: 0 }
    }
}

columns! {
    /// Rows to be traced for visibility and then measured.
    pub table ConnectionTable<const N: usize> of Connection {
        /// From one end, along unit directions.
        pub rays: RayColumns,
        /// Length to test, in scene units.
        pub t_max: Column,
        /// Intensity carried if nothing is in the way; weight included.
        pub value: Vec<[f32; N]>,
        /// Where it goes: the row of the sensor path, or the pixel.
        pub target: Vec<u32>,
        /// The medium around the ray's origin: a row of the scene's media, or `NONE`.
        pub inside: Vec<u32> = NONE,
        /// Polarization of the light that is carried: a row of `states`, or `NONE`.
        pub state: Vec<u32> = NONE,
        /// After tracing: not 0 if something is in the way.
        pub blocked: Vec<u32>,
    } beside {
        /// Polarized light, along the connection towards the sensor's side.
        pub states: Vec<LightState<N>> = Vec::new(),
    }
}

impl<const N: usize> ConnectionTable<N> {
    /// Removes all rows.
    pub fn clear(&mut self) {
        self.len = 0;
        self.states.clear();
    }

    /// Appends a row of unpolarized light.
    #[inline(always)]
    pub fn push(&mut self, segment: Segment, value: [f32; N], target: u32) {
        self.push_row(segment.carrying(value, target, NONE));
    }

    /// Appends a row of light in a state of polarization.
    pub fn push_polarized(
        &mut self,
        segment: Segment,
        value: [f32; N],
        target: u32,
        state: LightState<N>,
    ) {
        self.push_row(segment.carrying(value, target, self.states.len() as u32));
        self.states.push(state);
    }
}
