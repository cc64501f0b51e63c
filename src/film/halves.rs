//! How much better a whole sequence is than its blocks tell.
//!
//! Blocks of a low-discrepancy sequence are stratified among each other: the error of the whole
//! falls faster than with the root of their number, and their spread overestimates it, by thousands
//! where pixels are smooth. How fast it falls shows in how far the whole is from its first half:
//! the mean square of that difference is the variance of the half less that of the whole. Taken
//! over tiles of pixels, as one alone says little, it bounds what the blocks say.

use super::record::{Column, Fact, Record};

use crate::image::OutputError;

/// Edge of a tile in pixels.
pub const TILE: usize = 8;

/// The share of what blocks say that is left by the halves, above which noise explains the
/// difference, and the blocks, which are more, know better.
const SHARE_MAX: f64 = 0.5;

/// The means after some numbers of iterations, each twice the last or more.
pub struct Halves {
    /// The latest last.
    latest: [Half; 2],
}

/// The means after so many iterations; none yet for zero.
struct Half {
    iterations: u64,
    mean: Vec<f32>,
}

impl Halves {
    /// None yet, of so many values.
    pub fn new(values: usize) -> Self {
        let half = || Half { iterations: 0, mean: vec![0.0; values] };
        Self { latest: [half(), half()] }
    }

    /// Takes notice of the means so far.
    pub fn keep(&mut self, mean: &[f64], iterations: u64) {
        if iterations < 2 * self.latest[1].iterations {
            return;
        }
        self.latest.swap(0, 1);
        let latest = &mut self.latest[1];
        latest.iterations = iterations;
        for (to, &from) in latest.mean.iter_mut().zip(mean) {
            *to = from as f32;
        }
    }

    /// Facts and columns from which [`Halves::restore`] makes the same.
    pub fn state(&self) -> (Vec<Fact>, Vec<(String, Column<'_>)>) {
        let facts = self.latest.iter().enumerate();
        let facts = facts.map(|(index, half)| (name_of(index), half.iterations.to_string()));
        let columns = self.latest.iter().enumerate();
        let columns =
            columns.map(|(index, half)| (name_of(index), Column::Singles(half.mean.as_slice())));
        (facts.collect(), columns.collect())
    }

    /// Becomes what has been recorded of others with so many values.
    ///
    /// # Errors
    /// When the record lacks something, or the system refuses.
    pub fn restore(&mut self, record: &mut Record, values: usize) -> Result<(), OutputError> {
        for (index, half) in self.latest.iter_mut().enumerate() {
            let name = name_of(index);
            half.iterations = u64::from(record.number(&name)?);
            half.mean = record.singles(&name, values)?;
        }
        Ok(())
    }

    /// What is left, tile by tile, of the variances that blocks state of a plane of pixels, whose
    /// values are at `index_of` each among the means of `iterations`; nothing if no half tells.
    pub fn shares(
        &self,
        [width, height]: [usize; 2],
        (mean, iterations): (&[f64], u64),
        variance_of: impl Fn(usize) -> f32,
        index_of: impl Fn(usize) -> usize,
    ) -> Option<Vec<f32>> {
        let is_half = |half: &&Half| half.iterations > 0 && 2 * half.iterations <= iterations;
        let half = self.latest.iter().rev().find(is_half)?;
        // For an error that falls with the root of the iterations from there on.
        let scale = 1.0 / (iterations as f64 / half.iterations as f64 - 1.0);
        let share = |(top, left)| {
            let lines = top..height.min(top + TILE);
            let pixels =
                lines.flat_map(|y| (left..width.min(left + TILE)).map(move |x| y * width + x));
            let (mut stated, mut found) = (0.0, 0.0);
            for pixel in pixels {
                let index = index_of(pixel);
                stated += f64::from(variance_of(pixel));
                found += (mean[index] - f64::from(half.mean[index])).powi(2) * scale;
            }
            let share = found / stated;
            if share < SHARE_MAX { share as f32 } else { 1.0 }
        };
        Some(tiles(width, height).map(share).collect())
    }
}

/// What the column of a half is called, and the fact of its iterations.
fn name_of(index: usize) -> String {
    format!("half {index}")
}

/// The corners of all tiles.
fn tiles(width: usize, height: usize) -> impl Iterator<Item = (usize, usize)> {
    let lefts = move |top| (0..width).step_by(TILE).map(move |left| (top, left));
    (0..height).step_by(TILE).flat_map(lefts)
}
