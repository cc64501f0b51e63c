//! Subpaths alive, one row each.

use crate::geometry::RayColumns;

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

/// Partial weights (Georgiev et al. 2012; Georgiev, "Implementing vertex connection and
/// merging", technical report 2012).
pub struct MisColumns {
    /// Density per steradian of the current direction; infinite after a specular event and from
    /// the sensor. Used by `path`.
    pub pdf_w: Column,
    /// dVCM: reciprocal of the density of the last segment, times the density of connecting
    /// instead.
    pub d_vcm: Column,
    /// dVC: what the connections at all earlier vertices add up to.
    pub d_vc: Column,
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
