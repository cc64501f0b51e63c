//! Connections under test: rays between two vertices with what they would carry.

use crate::geometry::{Ray, RayColumns};
use crate::math::columns::{Column, columns};
use crate::math::{F32s, LANES, U32s, Vector, lanes};
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

/// Eight connections of unpolarized light, between points that are off their surfaces.
pub struct ConnectionLanes<const N: usize> {
    /// One end.
    pub origin: Vector<F32s>,
    /// Towards the other, unit length.
    pub direction: Vector<F32s>,
    /// The length.
    pub t_max: F32s,
    /// Intensity, weight included.
    pub value: [F32s; N],
    /// The weight among all strategies.
    pub weight: F32s,
    /// Where each goes.
    pub target: U32s,
    /// The media around the origins.
    pub inside: U32s,
    /// Which end the origin is.
    pub from: Side,
}

impl<const N: usize> ConnectionLanes<N> {
    /// Where they carry anything, of the first `live`.
    #[inline(always)]
    pub fn carrying(&self, live: usize) -> F32s {
        let zero = F32s::splat(0.0);
        let carries = |n: usize| self.value[n].simd_gt(zero);
        lanes::first(live) & (1..N).fold(carries(0), |any, n| any | carries(n))
    }

    /// One of them.
    pub fn lane(&self, lane: usize) -> (Segment, Cargo<N>) {
        let of = |lanes: F32s| lanes.as_array()[lane];
        let segment = Segment {
            origin: self.origin.lane(lane).into(),
            direction: self.direction.lane(lane).into(),
            t_max: of(self.t_max),
            inside: self.inside.as_array()[lane],
            from: self.from,
        };
        (segment, Cargo { value: self.value.map(of), weight: of(self.weight) })
    }
}

/// The lanes of a mask, one after the other; `SPARSE` if others are between them.
struct Order<const SPARSE: bool> {
    lanes: [usize; LANES],
}

impl<const SPARSE: bool> Order<SPARSE> {
    #[inline(always)]
    fn new(bits: u32) -> Self {
        let (mut lanes, mut len) = ([0; LANES], 0);
        for lane in 0..LANES {
            lanes[len & (LANES - 1)] = lane;
            len += if SPARSE { (bits >> lane & 1) as usize } else { 1 };
        }
        Self { lanes }
    }

    /// Writes the lanes to the rows from `row` on, and anything to the rest of eight rows.
    #[inline(always)]
    fn store<T: Copy + Default>(&self, column: &mut [T], row: usize, values: [T; LANES]) {
        let in_order = || lanes::each(|place| values[self.lanes[place] & (LANES - 1)]);
        let values = if SPARSE { in_order() } else { values };
        column[row..row + LANES].copy_from_slice(&values);
    }

    #[inline(always)]
    fn store_vector(&self, columns: &mut [Column; 3], row: usize, vector: Vector<F32s>) {
        let [x, y, z] = columns;
        self.store(x, row, vector.x.to_array());
        self.store(y, row, vector.y.to_array());
        self.store(z, row, vector.z.to_array());
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

    /// Appends the lanes in the mask.
    #[inline(always)]
    pub fn push_lanes(&mut self, lanes: &ConnectionLanes<N>, keep: F32s) {
        let bits = keep.to_bitmask();
        self.reserve(LANES);
        if bits & (bits + 1) == 0 {
            self.store_lanes(lanes, &Order::<false>::new(bits));
        } else {
            self.store_lanes(lanes, &Order::<true>::new(bits));
        }
        self.len += bits.count_ones() as usize;
    }

    #[inline(always)]
    fn store_lanes<const SPARSE: bool>(
        &mut self,
        lanes: &ConnectionLanes<N>,
        order: &Order<SPARSE>,
    ) {
        let row = self.len;
        order.store_vector(&mut self.rays.origin, row, lanes.origin);
        order.store_vector(&mut self.rays.direction, row, lanes.direction);
        order.store(&mut self.t_max, row, lanes.t_max.to_array());
        let values = lanes.value.map(F32s::to_array);
        for (value, &lane) in self.value[row..row + LANES].iter_mut().zip(&order.lanes) {
            *value = lanes::row_of_lanes(&values, lane & (LANES - 1));
        }
        order.store(&mut self.weight, row, lanes.weight.to_array());
        order.store(&mut self.target, row, lanes.target.to_array());
        order.store(&mut self.inside, row, lanes.inside.to_array());
        let from_sensor = u32::from(lanes.from == Side::Sensor);
        self.from_sensor[row..row + LANES].fill(from_sensor);
        self.state[row..row + LANES].fill(NONE);
    }

    /// Has the light of a row be in a state of polarization.
    pub fn set_state(&mut self, row: usize, state: LightState<N>) {
        self.state[row] = self.states.len() as u32;
        self.states.push(state);
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
