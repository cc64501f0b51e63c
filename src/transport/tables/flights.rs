//! Segments on their way: through media, and through surfaces that let light straight on.

use crate::geometry::{HitColumns, RayColumns};
use crate::math::LANES;
use crate::math::columns::{Column, columns};

columns! {
    /// Segments that are followed through surfaces; those that arrive drop out.
    pub table FlightTable<const N: usize> of Flight {
        /// The row of the table that the flight is made for.
        pub row: Vec<u32>,
        /// From the segment's start.
        pub rays: RayColumns,
        /// What it has met last.
        pub hits: HitColumns,
        /// Where it ends.
        pub t_max: Column,
    } beside {
        /// Of all segments, by the row that they are made for.
        pub progress: Vec<Progress<N>> = Vec::new(),
    }
}

/// How far a segment has come.
#[derive(Clone, Copy, Debug)]
pub struct Progress<const N: usize> {
    /// Distance from its start.
    pub travelled: f32,
    /// Where it had come to before that.
    pub from: f32,
    /// Optical depth so far.
    pub depth: [f32; N],
    /// The same of what is drawn: minus the logarithm of the probability of coming so far.
    pub drawn: [f32; N],
    /// Of that, at the wavelength that distances are drawn for, what is left until the path meets a
    /// particle.
    pub left: f32,
    /// The probability with which roulette lets the path go on from the particle that it has met.
    pub survival: f32,
    /// Surfaces so far that might have scattered it.
    pub crossed: u32,
    /// The probability with which paths pass what it has crossed.
    pub chance: f32,
    /// Whether it has ended.
    pub is_over: bool,
}

impl<const N: usize> FlightTable<N> {
    /// Removes all rows, makes room for `rows`, and starts as many segments.
    pub fn start(&mut self, rows: usize) {
        self.len = 0;
        self.reserve(rows + LANES);
        self.progress.clear();
        let start = Progress {
            travelled: 0.0,
            from: 0.0,
            depth: [0.0; N],
            drawn: [0.0; N],
            left: 0.0,
            survival: 1.0,
            crossed: 0,
            chance: 1.0,
            is_over: false,
        };
        self.progress.resize(rows, start);
    }
}
