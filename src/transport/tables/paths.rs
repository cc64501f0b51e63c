//! Subpaths alive, one row each.

use crate::geometry::RayColumns;
use crate::math::{F32s, lanes};
use crate::transport::mis::{PartialWeights, TurnDensities};

use super::carriers::CarrierTable;
use super::media::MediaColumns;
use super::partition::Partition;
use super::{Channels, Column, channels, column, gather, identifiers};

/// The subpaths of one side that are still being extended.
pub struct PathTable<const N: usize, C> {
    /// Number of rows in use.
    pub len: usize,
    /// The current segment: from the last vertex on.
    pub rays: RayColumns,
    /// Who the rows are.
    pub identity: IdentityColumns,
    /// Scalar throughput: what both modes share, times the gains that polarizing events before
    /// the last depolarizer have brought.
    pub beta: Channels<N>,
    /// What weighs strategies against each other.
    pub mis: MisColumns,
    /// Media, if the scene has any.
    pub media: MediaColumns<N>,
    /// Polarization, for the rows that have any.
    pub carriers: C,
}

/// Names of rows that survive every reordering.
pub struct IdentityColumns {
    /// Place in the chunk: where measurements go, and which light path a sensor path meets.
    pub slot: Vec<u32>,
    /// Seed of the path's random sequences.
    pub seed: Vec<u32>,
    /// Index in those sequences.
    pub iteration: Vec<u32>,
}

/// Partial weights, and what the unidirectional heuristic takes in their place.
pub struct MisColumns {
    /// Density per steradian of the current direction; infinite after a specular event and from
    /// the sensor. Used by `path`.
    pub pdf_w: Column,
    /// [`PartialWeights::d_vcm`].
    pub d_vcm: Column,
    /// [`PartialWeights::d_vc`].
    pub d_vc: Column,
}

impl MisColumns {
    /// The partial weights of eight rows.
    #[inline(always)]
    pub fn load(&self, row: usize) -> PartialWeights<F32s> {
        PartialWeights { d_vcm: lanes::load(&self.d_vcm, row), d_vc: lanes::load(&self.d_vc, row) }
    }

    /// Those of one row.
    #[inline(always)]
    pub fn row(&self, row: usize) -> PartialWeights<f32> {
        PartialWeights { d_vcm: self.d_vcm[row], d_vc: self.d_vc[row] }
    }

    /// Those of one row, in all lanes.
    #[inline(always)]
    pub fn splat(&self, row: usize) -> PartialWeights<F32s> {
        let PartialWeights { d_vcm, d_vc } = self.row(row);
        PartialWeights { d_vcm: F32s::splat(d_vcm), d_vc: F32s::splat(d_vc) }
    }

    /// Sets the partial weights of the rows from `row` on that lie before `end`, eight at most.
    #[inline(always)]
    pub fn store(&mut self, row: usize, end: usize, weights: PartialWeights<F32s>) {
        lanes::store(&mut self.d_vcm, row, end, weights.d_vcm);
        lanes::store(&mut self.d_vc, row, end, weights.d_vc);
    }

    /// Sets those of one row.
    #[inline(always)]
    pub fn set_row(&mut self, row: usize, weights: PartialWeights<f32>) {
        self.d_vcm[row] = weights.d_vcm;
        self.d_vc[row] = weights.d_vc;
    }

    /// Sends eight rows on from vertices that connect.
    #[inline(always)]
    pub fn depart(&mut self, row: usize, end: usize, turn: TurnDensities<F32s>) {
        self.store(row, end, self.load(row).depart(turn));
        lanes::store(&mut self.pdf_w, row, end, turn.pdf);
    }

    /// Sends eight rows on from specular events; `measure` is the cosine of the direction.
    #[inline(always)]
    pub fn depart_specular(&mut self, row: usize, end: usize, measure: F32s) {
        self.store(row, end, self.load(row).depart_specular(measure));
        lanes::store(&mut self.pdf_w, row, end, F32s::splat(f32::INFINITY));
    }
}

impl<const N: usize, C: CarrierTable> PathTable<N, C> {
    /// An empty table for `capacity` rows, with or without media.
    pub fn new(capacity: usize, with_media: bool) -> Self {
        Self {
            len: 0,
            rays: RayColumns::new(capacity),
            identity: IdentityColumns {
                slot: identifiers(capacity),
                seed: identifiers(capacity),
                iteration: identifiers(capacity),
            },
            beta: channels(capacity),
            mis: MisColumns {
                pdf_w: column(capacity),
                d_vcm: column(capacity),
                d_vc: column(capacity),
            },
            media: MediaColumns::new(capacity, with_media),
            carriers: C::new(capacity),
        }
    }

    /// Takes the rows that `partition` keeps from another table, in its order.
    pub fn gather(&mut self, from: &Self, partition: &Partition) {
        let order = &partition.order;
        self.len = order.len();
        for axis in 0..3 {
            gather(&mut self.rays.origin[axis], &from.rays.origin[axis], order, 0);
            gather(&mut self.rays.direction[axis], &from.rays.direction[axis], order, 0);
        }
        gather(&mut self.identity.slot, &from.identity.slot, order, 0);
        gather(&mut self.identity.seed, &from.identity.seed, order, 0);
        gather(&mut self.identity.iteration, &from.identity.iteration, order, 0);
        for channel in 0..N {
            gather(&mut self.beta[channel], &from.beta[channel], order, 0);
        }
        gather(&mut self.mis.pdf_w, &from.mis.pdf_w, order, 0);
        gather(&mut self.mis.d_vcm, &from.mis.d_vcm, order, 0);
        gather(&mut self.mis.d_vc, &from.mis.d_vc, order, 0);
        self.media.gather(&from.media, order);
        for part in &partition.parts {
            self.carriers.gather(&from.carriers, order, part);
        }
    }
}
