//! Rays that cross boundaries between media which do not bend them, one piece after the other.

use crate::geometry::{HitColumns, RayColumns};
use crate::math::LANES;

/// Rows on their way through a piece of their segment; those that arrive drop out.
pub struct FlightTable<const N: usize> {
    /// Number of rows in use.
    pub len: usize,
    /// The row of the table that the flight is made for.
    pub row: Vec<u32>,
    /// The current piece.
    pub rays: RayColumns,
    /// What it meets.
    pub hits: HitColumns,
    /// The medium in which it lies.
    pub inside: Vec<u32>,
    /// Distance from the segment's start to the piece's.
    pub travelled: Vec<f32>,
    /// Optical depth so far, by the row that the flight is made for.
    pub depth: Vec<[f32; N]>,
    /// Optical depth, at the wavelength that distances are drawn for, left until the path meets
    /// a particle; by the row that the flight is made for.
    pub left: Vec<f32>,
}

impl<const N: usize> FlightTable<N> {
    /// An empty table for `capacity` rows; it grows if more come.
    pub fn new(capacity: usize) -> Self {
        let padded = capacity + LANES;
        Self {
            len: 0,
            row: vec![0; padded],
            rays: RayColumns::new(capacity),
            hits: HitColumns::new(capacity),
            inside: vec![0; padded],
            travelled: vec![0.0; padded],
            depth: Vec::new(),
            left: Vec::new(),
        }
    }

    /// Removes all rows, and starts `rows` optical depths at zero.
    pub fn clear(&mut self, rows: usize) {
        self.len = 0;
        self.depth.clear();
        self.depth.resize(rows, [0.0; N]);
        if rows + LANES > self.row.len() {
            *self = Self { depth: std::mem::take(&mut self.depth), ..Self::new(rows) };
        }
        self.left.resize(rows + LANES, 0.0);
    }

    /// Appends a row at the start of its segment.
    #[inline(always)]
    pub fn push(&mut self, row: u32, origin: [f32; 3], direction: [f32; 3], inside: u32) {
        let to = self.len;
        for axis in 0..3 {
            self.rays.origin[axis][to] = origin[axis];
            self.rays.direction[axis][to] = direction[axis];
        }
        self.row[to] = row;
        self.inside[to] = inside;
        self.travelled[to] = 0.0;
        self.len += 1;
    }
}
