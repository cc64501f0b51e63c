//! Structure-of-arrays tables, declared by [`crate::math::columns`]: structs of public columns and
//! groups of columns, so that a stage borrows just what it reads and writes.

pub mod carriers;
pub mod classes;
pub mod connections;
pub mod crossings;
pub mod flights;
pub mod kernels;
pub mod measured;
pub mod media;
pub mod merged;
pub mod nearest_photons;
pub mod partition;
pub mod paths;
mod photon_candidates;
pub mod photon_grid;
pub mod photon_maps;
pub mod photon_queries;
mod photon_sort;
pub mod photons;
pub mod pieces;
pub mod states;
pub mod vertices;

use crate::math::columns::{Channels, Column, Columns};

/// One column per wavelength.
pub fn channels<const N: usize>(capacity: usize) -> Channels<N> {
    Columns::with_room(capacity)
}

/// Three columns: a vector per row.
pub fn vectors(capacity: usize) -> [Column; 3] {
    Columns::with_room(capacity)
}
