//! Sensor paths that have merged with photons, and what may follow their vertices yet.

use std::ops::Range;

use crate::geometry::{HitColumns, SurfaceColumns};
use crate::math::columns::{Column, Columns};
use crate::math::{F32s, LANES, Vector, lanes};
use crate::scattering::phase::half_sine2;
use crate::scattering::surface::model::reflect;
use crate::scattering::{Met, Scene};
use crate::scene::baked::NONE;

use super::vectors;

/// Rows of sensor paths that have merged. An emitter can follow, and any other path where they are
/// scattered so near to a peak that photons from there have not counted.
pub struct MergedRows {
    /// Rows, and whether there may be a peak.
    parts: Vec<(Range<usize>, bool)>,
    /// Where the peaks of these rows are.
    peak: [Column; 3],
    /// Up to which `half_sine2` about that photons have not counted.
    end: Column,
}

impl MergedRows {
    /// None, of so many rows of paths at most.
    pub fn new(rows: usize) -> Self {
        Self { parts: Vec::new(), peak: vectors(rows), end: Columns::with_room(rows) }
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.parts.clear();
    }

    /// Adds rows that have come along these directions to what they have met.
    pub fn push<const N: usize>(
        &mut self,
        rows: Range<usize>,
        (directions, surfaces): (&[Column; 3], &SurfaceColumns),
        (scene, met): (&Scene<N>, Met),
    ) {
        let may_peak = scene.may_peak(met);
        for first in rows.clone().step_by(LANES).filter(|_| may_peak) {
            let direction = Vector::load(directions, first);
            let peak = match met {
                Met::Surface(_) => {
                    reflect(direction, Vector::load(&surfaces.shading_normal, first))
                }
                Met::Medium(_) => direction,
            };
            peak.store(&mut self.peak, first, rows.end);
            for row in (first..rows.end).take(LANES) {
                self.end[row] = scene.peak_at(met, surfaces.primitive[row]);
            }
        }
        self.parts.push((rows, may_peak));
    }

    /// Whether a path that has merged ends at what its new direction hits.
    pub fn ends(&self, row: usize, directions: &[Column; 3]) -> bool {
        let of_row = self.parts.iter().find(|(rows, _)| rows.contains(&row));
        of_row.is_some_and(|&(_, may_peak)| !may_peak || self.leaves_peak(directions, row) & 1 == 1)
    }

    /// Ends the paths at what their new directions hit, but for those that stay in the peak, and
    /// forgets them.
    pub fn end(&mut self, hits: &mut HitColumns, directions: &[Column; 3]) {
        for (rows, may_peak) in std::mem::take(&mut self.parts) {
            if !may_peak {
                hits.primitive[rows].fill(NONE);
                continue;
            }
            for first in rows.clone().step_by(LANES) {
                let ends = self.leaves_peak(directions, first);
                for row in
                    (first..rows.end).take(LANES).filter(|row| ends >> (row - first) & 1 == 1)
                {
                    hits.primitive[row] = NONE;
                }
            }
        }
    }

    /// Which of the eight rows from `first` on go on no nearer to the peak than to its end, a bit
    /// each.
    fn leaves_peak(&self, directions: &[Column; 3], first: usize) -> u32 {
        let [peak, to] = [&self.peak, directions].map(|columns| Vector::load(columns, first));
        let end: F32s = lanes::load(&self.end, first);
        half_sine2(peak, to).simd_ge(end).to_bitmask()
    }
}
