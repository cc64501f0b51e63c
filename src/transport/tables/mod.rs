//! Structure-of-arrays tables. A column is a plain vector, padded by one packet so that the last
//! rows can be read eight at a time; a table is a struct of public column groups, so that a stage
//! borrows just what it reads and writes.

pub mod carriers;
pub mod classes;
pub mod connections;
pub mod flights;
pub mod kernels;
pub mod measured;
pub mod media;
pub mod nearest_photons;
pub mod partition;
pub mod paths;
pub mod photon_grid;
pub mod photon_maps;
pub mod photon_queries;
mod photon_sort;
pub mod photons;
pub mod states;
pub mod vertices;

use crate::math::LANES;

/// One float per row.
pub type Column = Vec<f32>;

/// One float per row and wavelength.
pub type Channels<const N: usize> = [Column; N];

/// A column for `capacity` rows.
pub fn column(capacity: usize) -> Column {
    vec![0.0; capacity + LANES]
}

/// One column per wavelength.
pub fn channels<const N: usize>(capacity: usize) -> Channels<N> {
    std::array::from_fn(|_| column(capacity))
}

/// Three columns: a vector per row.
pub fn vectors(capacity: usize) -> [Column; 3] {
    std::array::from_fn(|_| column(capacity))
}

/// One identifier per row.
pub fn identifiers(capacity: usize) -> Vec<u32> {
    vec![0; capacity + LANES]
}

/// Copies the rows `order` of `from` to the rows from `start` on.
#[inline(always)]
pub fn gather<T: Copy>(to: &mut [T], from: &[T], order: &[u32], start: usize) {
    for (to, &row) in to[start..start + order.len()].iter_mut().zip(order) {
        *to = from[row as usize];
    }
}
