//! Where segments go straight on through surfaces.

use std::ops::Range;

use crate::geometry::{Hit, HitColumns, Ray, RayColumns, SurfaceColumns};
use crate::math::Real;
use crate::math::columns::{Column, Rows, columns};
use crate::polarization::SpheroidBlock;
use crate::scattering::Side;
use crate::scattering::surface::{Crossed, SurfaceKind};

columns! {
    /// Crossings, those of a segment in the order of its ray; each with what it does to light.
    pub table CrossingTable<const N: usize> {
        /// The row of the table that the segment belongs to.
        pub row: Vec<u32>,
        /// The segment.
        pub rays: RayColumns,
        /// Where it crosses.
        pub hits: HitColumns,
        /// The surfaces there.
        pub surfaces: SurfaceColumns,
        /// The share of unpolarized light that passes.
        pub transmittance: Vec<[f32; N]>,
        /// The probability with which paths pass.
        pub chance: Column,
        /// Elements a, c and s of the kernels; of an achromatic kind, the first alone counts.
        pub kernels: Vec<[[f32; 3]; N]>,
        /// The x axis of the kernels' frames.
        pub axis: [Column; 3],
    } beside {
        /// Crossings of surfaces of one kind, next to each other; no segment has two in one part.
        pub parts: Vec<CrossingPart> = Vec::new(),
    }
}

/// Rows of one kind of surface.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossingPart {
    /// The kind.
    pub kind: Crossed,
    /// The rows.
    pub rows: Range<usize>,
}

/// A part with its table.
#[derive(Clone, Copy)]
pub struct Crossing<'a, const N: usize> {
    /// All crossings.
    pub crossings: &'a CrossingTable<N>,
    /// Those that are meant.
    pub part: &'a CrossingPart,
    /// Whose paths cross there.
    pub side: Side,
}

impl<const N: usize> CrossingTable<N> {
    /// Removes all rows.
    pub fn clear(&mut self) {
        self.len = 0;
        self.parts.clear();
    }

    /// Appends the crossing of the segment `ray` at `hit`; what it does to light is not known yet.
    pub fn push(&mut self, row: u32, ray: Ray, hit: Hit) {
        self.reserve(1);
        self.row[self.len] = row;
        self.rays.set(self.len, ray);
        self.hits.set(self.len, hit);
        self.len += 1;
    }

    /// Makes a part of the rows from `first` on.
    pub fn close_part(&mut self, kind: Crossed, first: usize) {
        if first < self.len {
            self.parts.push(CrossingPart { kind, rows: first..self.len });
        }
    }

    /// The kernels of a row of a kind.
    #[inline(always)]
    pub fn kernels<F: Real>(&self, row: usize, kind: SurfaceKind) -> [SpheroidBlock<F>; N] {
        let of = &self.kernels[row];
        let kernel = |n: usize| {
            let elements = of[if kind.passes_alike() { 0 } else { n }];
            let [a, c, s] = elements.map(|element| F::splat(f64::from(element)));
            SpheroidBlock { a, b: F::one(), c, d: c, s }
        };
        std::array::from_fn(kernel)
    }
}
