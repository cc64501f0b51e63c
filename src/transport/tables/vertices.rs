//! Light vertices that sensor paths and the sensor connect to.

use glam::Vec3;

use crate::math::columns::{Channels, Column, columns};
use crate::math::{F32s, lanes};
use crate::scattering::Scene;
use crate::transport::mis::PartialWeights;

use super::states::LightState;

columns! {
    /// Vertices of light paths on surfaces that connect and in media. At depolarizers they carry
    /// power and no Stokes vector: what leaves those does not depend on the polarization of what
    /// arrived.
    pub table VertexTable<const N: usize> {
        /// Where.
        pub position: [Column; 3],
        /// Geometric normal, to the front; zero in a medium.
        pub geometric_normal: [Column; 3],
        /// Shading normal.
        pub shading_normal: [Column; 3],
        /// How far off the surface rays start and end; zero in a medium.
        pub offset: Column,
        /// Where the light came from: away from the surface, unit length.
        pub given: [Column; 3],
        /// Throughput times what of the scattering function no direction changes.
        pub power: Channels<N>,
        /// 1 if the back scatters too, else 0.
        pub two_sided: Column,
        /// [`PartialWeights::d_vcm`] on arrival.
        pub d_vcm: Column,
        /// [`PartialWeights::d_vc`] on arrival.
        pub d_vc: Column,
        /// Slot of the path.
        pub slot: Vec<u32>,
        /// Segments from the emitter.
        pub path_length: Vec<u32>,
        /// The medium around the vertex: a row of the scene's media, or `NONE`.
        pub inside: Vec<u32>,
        /// The medium behind a surface that light goes through; without meaning elsewhere.
        pub beyond: Vec<u32>,
        /// What was met: its place among the scene's events.
        pub event: Vec<u32>,
        /// On a surface, the row in the table of its model.
        pub row: Vec<u32>,
        /// Polarization of the arriving light where the vertex does not undo it: a row of `states`,
        /// or `NONE`.
        pub state: Vec<u32>,
    } beside {
        /// Polarized light on arrival.
        pub states: Vec<LightState<N>> = Vec::new(),
    }
}

impl<const N: usize> VertexTable<N> {
    /// Takes all rows of another table, ordered by slot and, within, by path length; `ends[s]`
    /// of the order becomes the first row after those of slot `s`. Rows must come in by path
    /// length.
    pub fn take_by_slot(&mut self, from: &mut Self, order: &mut SlotOrder, slots: usize) {
        order.sort(&from.slot[..from.len], slots);
        self.take(from, &order.order);
        std::mem::swap(&mut self.states, &mut from.states);
    }

    /// The partial weights of eight rows.
    #[inline(always)]
    pub fn weights(&self, row: usize) -> PartialWeights<F32s> {
        PartialWeights { d_vcm: lanes::load(&self.d_vcm, row), d_vc: lanes::load(&self.d_vc, row) }
    }

    /// Sets the partial weights of the rows from `row` on that lie before `end`, eight at most.
    #[inline(always)]
    pub fn store_weights(&mut self, row: usize, end: usize, weights: PartialWeights<F32s>) {
        lanes::store(&mut self.d_vcm, row, end, weights.d_vcm);
        lanes::store(&mut self.d_vc, row, end, weights.d_vc);
    }

    /// The medium in which a connection of a row along a direction starts.
    #[inline(always)]
    pub fn inside_towards(&self, scene: &Scene<N>, row: usize, direction: Vec3) -> u32 {
        let of = |columns| Vec3::from(lanes::row_of(columns, row));
        let passes = || {
            let normal = of(&self.geometric_normal);
            normal.dot(of(&self.given)) * normal.dot(direction) < 0.0
        };
        match scene.events[self.event[row] as usize].met.passes_any_way() && passes() {
            true => self.beyond[row],
            false => self.inside[row],
        }
    }

    /// Removes all rows.
    pub fn clear(&mut self) {
        self.len = 0;
        self.states.clear();
    }
}

/// A stable counting sort by slot.
#[derive(Default)]
pub struct SlotOrder {
    /// For every new row, the old one.
    pub order: Vec<u32>,
    /// For every slot, the first row after its own.
    pub ends: Vec<u32>,
}

impl SlotOrder {
    fn sort(&mut self, slot_of_row: &[u32], slots: usize) {
        self.ends.clear();
        self.ends.resize(slots, 0);
        for &slot in slot_of_row {
            self.ends[slot as usize] += 1;
        }
        let mut sum = 0;
        for end in &mut self.ends {
            sum += std::mem::replace(end, sum);
        }
        self.order.clear();
        self.order.resize(slot_of_row.len(), 0);
        for (row, &slot) in slot_of_row.iter().enumerate() {
            let place = &mut self.ends[slot as usize];
            self.order[*place as usize] = row as u32;
            *place += 1;
        }
    }

    /// The rows of a slot.
    #[inline(always)]
    pub fn rows_of(&self, slot: usize) -> std::ops::Range<usize> {
        let start = if slot == 0 { 0 } else { self.ends[slot - 1] };
        start as usize..self.ends[slot] as usize
    }
}
/// The light paths of a chunk.
pub struct LightPaths<'a, const N: usize> {
    /// Their vertices, by slot.
    pub vertices: &'a VertexTable<N>,
    /// Which are whose.
    pub order: &'a SlotOrder,
    /// Most segments from the emitter to a vertex that is connected to.
    pub length_max: u32,
}
