//! Connections under test: rays between two vertices with what they would carry.

use crate::geometry::{Ray, RayColumns};
use crate::math::columns::{Column, columns};
use crate::math::{Vector, lanes};
use crate::scattering::Side;
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
    /// Which end is its origin.
    pub from: Side,
}

/// What a connection would carry.
#[derive(Clone, Copy, Debug)]
pub struct Cargo<const N: usize> {
    /// Intensity, weight included.
    pub value: [f32; N],
    /// The weight among all strategies.
    pub weight: f32,
}

impl Segment {
    /// Between two points that are off their surfaces; `inside` is the medium around the first,
    /// which belongs to the subpath of `side`.
    #[inline(always)]
    pub fn between(side: Side, from: [f32; 3], to: [f32; 3], inside: u32) -> Self {
        let mut offset = [0.0; 3];
        for axis in 0..3 {
            offset[axis] = to[axis] - from[axis];
        }
        let [x, y, z] = offset;
        let t_max = (x * x + y * y + z * z).sqrt();
        let inverse = 1.0 / t_max;
        Self {
            origin: from,
            direction: [x * inverse, y * inverse, z * inverse],
            t_max,
            inside,
            from: side,
        }
    }

    /// The row of a connection that has not been traced.
    #[inline(always)]
    fn carrying<const N: usize>(self, cargo: Cargo<N>, target: u32, state: u32) -> Connection<N> {
        let Cargo { value, weight } = cargo;
        let Self { origin, direction, t_max, inside, from } = self;
        let rays = Ray { origin, direction };
        let from_sensor = u32::from(from == Side::Sensor);
        Connection { rays, t_max, value, weight, target, inside, state, blocked: 0, from_sensor }
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
        /// The weight among all strategies that is part of that.
        pub weight: Column,
        /// Where it goes: the row of the sensor path, or the pixel.
        pub target: Vec<u32>,
        /// The medium around the ray's origin: a row of the scene's media, or `NONE`.
        pub inside: Vec<u32> = NONE,
        /// 1 where the ray starts at the sensor's end, against the light; else 0.
        pub from_sensor: Vec<u32>,
        /// Polarization of the light that is carried: a row of `states`, or `NONE`.
        pub state: Vec<u32> = NONE,
        /// After tracing: not 0 if something is in the way, [`crate::geometry::CROSSES`] where that
        /// lets the connection pass.
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

    /// Where the light of a row travels.
    #[inline(always)]
    pub fn along_light(&self, row: usize) -> Vector<f32> {
        let ray: Vector<f32> = lanes::row_of(&self.rays.direction, row).into();
        if self.from_sensor[row] == 1 { -ray } else { ray }
    }

    /// Appends a row of unpolarized light.
    #[inline(always)]
    pub fn push(&mut self, segment: Segment, cargo: Cargo<N>, target: u32) {
        self.push_row(segment.carrying(cargo, target, NONE));
    }

    /// Appends a row of light in a state of polarization.
    pub fn push_polarized(
        &mut self,
        segment: Segment,
        cargo: Cargo<N>,
        target: u32,
        state: LightState<N>,
    ) {
        self.push_row(segment.carrying(cargo, target, self.states.len() as u32));
        self.states.push(state);
    }
}
