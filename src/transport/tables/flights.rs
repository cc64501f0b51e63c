//! Rays that cross boundaries between media which do not bend them, one piece after the other.

use crate::geometry::{HitColumns, RayColumns};
use crate::math::LANES;
use crate::math::columns::{Column, columns};

columns! {
    /// Rows on their way through a piece of their segment; those that arrive drop out.
    pub table FlightTable<const N: usize> of Flight {
        /// The row of the table that the flight is made for.
        pub row: Vec<u32>,
        /// The current piece.
        pub rays: RayColumns,
        /// What it meets, once traced.
        pub hits: HitColumns,
        /// The medium in which it lies.
        pub inside: Vec<u32>,
        /// Distance from the segment's start to the piece's.
        pub travelled: Column,
    } beside {
        /// Optical depth so far, by the row that the flight is made for.
        pub depth: Vec<[f32; N]> = Vec::new(),
        /// Optical depth, at the wavelength that distances are drawn for, left until the path meets
        /// a particle; by the row that the flight is made for.
        pub left: Vec<f32> = Vec::new(),
    }
}

impl<const N: usize> FlightTable<N> {
    /// Removes all rows, makes room for `rows`, and starts as many optical depths at zero.
    pub fn clear(&mut self, rows: usize) {
        self.len = 0;
        self.reserve(rows);
        self.depth.clear();
        self.depth.resize(rows, [0.0; N]);
        self.left.resize(rows + LANES, 0.0);
    }
}
