//! Sensor paths that have merged with photons, and what may follow their vertices yet.

use std::ops::Range;

use crate::geometry::HitColumns;
use crate::math::columns::Column;
use crate::math::{F32s, LANES, Vector};
use crate::scattering::phase::half_sine2;
use crate::scene::baked::NONE;

use super::vectors;

/// Rows of sensor paths that have merged. An emitter can follow, and any other path where they are
/// scattered by so little that photons from there have not counted.
pub struct MergedRows {
    /// Rows, and up to which `half_sine2` photons have not counted.
    parts: Vec<(Range<usize>, f32)>,
    /// Directions of these rows before they were scattered.
    came_along: [Column; 3],
}

impl MergedRows {
    /// None, of so many rows of paths at most.
    pub fn new(rows: usize) -> Self {
        Self { parts: Vec::new(), came_along: vectors(rows) }
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.parts.clear();
    }

    /// Adds rows that come along these directions, with the end of their phase function's peak.
    pub fn push(&mut self, rows: Range<usize>, directions: &[Column; 3], peak: f32) {
        if peak > 0.0 {
            for (kept, direction) in self.came_along.iter_mut().zip(directions) {
                kept[rows.clone()].copy_from_slice(&direction[rows.clone()]);
            }
        }
        self.parts.push((rows, peak));
    }

    /// Whether a path that has merged ends at what its new direction hits.
    pub fn ends(&self, row: usize, directions: &[Column; 3]) -> bool {
        let of_row = self.parts.iter().find(|(rows, _)| rows.contains(&row));
        of_row.is_some_and(|&(_, peak)| {
            peak == 0.0 || leaves_peak(&self.came_along, directions, row, peak) & 1 == 1
        })
    }

    /// Ends the paths at what their new directions hit, but for those that stay in the peak, and
    /// forgets them.
    pub fn end(&mut self, hits: &mut HitColumns, directions: &[Column; 3]) {
        for (rows, peak) in self.parts.drain(..) {
            if peak == 0.0 {
                hits.primitive[rows].fill(NONE);
                continue;
            }
            for first in rows.clone().step_by(LANES) {
                let ends = leaves_peak(&self.came_along, directions, first, peak);
                for row in
                    (first..rows.end).take(LANES).filter(|row| ends >> (row - first) & 1 == 1)
                {
                    hits.primitive[row] = NONE;
                }
            }
        }
    }
}

/// Which of the eight rows from `first` on turn by no less than to the end of the peak, a bit each.
fn leaves_peak(came_along: &[Column; 3], directions: &[Column; 3], first: usize, peak: f32) -> u32 {
    let [from, to] = [came_along, directions].map(|columns| Vector::load(columns, first));
    half_sine2(from, to).simd_ge(F32s::splat(peak)).to_bitmask()
}
