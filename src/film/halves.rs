//! How much better a whole sequence is than its blocks tell.
//!
//! Blocks of a low-discrepancy sequence are stratified among each other: the error of the whole
//! falls faster than with the root of their number, and their spread overestimates it, by thousands
//! where pixels are smooth. How fast it falls shows in how far the whole is from its first half,
//! and that from its own: the mean square of such a difference is the variance of the half less
//! that of the whole. Two of them tell the variance of noise, which falls with the samples, from
//! that of what is smooth, which falls with their cube (Owen 1997, "Scrambled net variance for
//! integrals of smooth functions"). Taken over tiles of pixels, as one alone says little, their sum
//! bounds what the blocks say.

/// Edge of a tile in pixels.
const TILE: usize = 8;

/// The share of what blocks say that is left by the halves, above which noise explains the
/// difference, and the blocks, which are more, know better.
const SHARE_MAX: f64 = 0.7;
/// Least part of the mean square of the last difference that is taken for the variance: where that
/// falls with the fourth power of the samples.
const PART_MIN: f64 = 1.0 / 15.0;

/// The means after some numbers of iterations, each twice the last or more.
pub struct Halves {
    /// The latest last.
    latest: [Half; 3],
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
        Self { latest: [half(), half(), half()] }
    }

    /// Takes notice of the means so far.
    pub fn keep(&mut self, mean: &[f64], iterations: u64) {
        let [.., latest] = &self.latest;
        if iterations < 2 * latest.iterations {
            return;
        }
        self.latest.rotate_left(1);
        let [.., latest] = &mut self.latest;
        latest.iterations = iterations;
        for (to, &from) in latest.mean.iter_mut().zip(mean) {
            *to = from as f32;
        }
    }

    /// Narrows the variances that blocks state of a plane of pixels, whose values are at
    /// `index_of` each among the means of `iterations`.
    pub fn narrow(
        &self,
        variances: &mut [f32],
        width: usize,
        (mean, iterations): (&[f64], u64),
        index_of: impl Fn(usize) -> usize,
    ) {
        let is_half = |half: &Half| half.iterations > 0 && 2 * half.iterations <= iterations;
        let Some(last) = self.latest.iter().rposition(is_half) else { return };
        let half = &self.latest[last];
        let quarter = self.latest[..last].last().filter(|quarter| {
            // Elsewhere variances fall in steps that none of these powers describes.
            4 * quarter.iterations == iterations && 2 * half.iterations == iterations
        });
        let part = Part::new(iterations, half, quarter.is_some());
        let height = variances.len() / width.max(1);
        for (top, left) in tiles(width, height) {
            let lines = top..height.min(top + TILE);
            let pixels =
                lines.flat_map(|y| (left..width.min(left + TILE)).map(move |x| y * width + x));
            let (mut stated, mut last, mut before) = (0.0, 0.0, 0.0);
            for pixel in pixels.clone() {
                let index = index_of(pixel);
                let of_half = f64::from(half.mean[index]);
                stated += f64::from(variances[pixel]);
                last += (mean[index] - of_half).powi(2);
                before += quarter.map_or(0.0, |it| (of_half - f64::from(it.mean[index])).powi(2));
            }
            let share = part.of(last, before) / stated;
            if share < SHARE_MAX {
                pixels.for_each(|pixel| variances[pixel] *= share as f32);
            }
        }
    }
}

/// How the variance of the whole follows from squared differences: a multiple of each.
struct Part {
    of_last: f64,
    of_before: f64,
}

impl Part {
    /// For a whole of so many iterations. With `a` for the variance of noise and `b` for that of
    /// what is smooth, the half's is `2 a + 8 b` and that of the quarter of the samples, if there
    /// is one, `4 a + 64 b`; without it all is noise.
    fn new(iterations: u64, half: &Half, has_quarter: bool) -> Self {
        if has_quarter {
            return Self { of_last: 9.0 / 7.0, of_before: -1.0 / 7.0 };
        }
        let over = iterations as f64 / half.iterations as f64;
        Self { of_last: 1.0 / (over - 1.0), of_before: 0.0 }
    }

    /// The variance of the whole, by the sum of the squares of how far it is from the half, and the
    /// half from the quarter.
    fn of(&self, last: f64, before: f64) -> f64 {
        (self.of_last * last + self.of_before * before).max(PART_MIN * last)
    }
}

/// The corners of all tiles.
fn tiles(width: usize, height: usize) -> impl Iterator<Item = (usize, usize)> {
    let lefts = move |top| (0..width).step_by(TILE).map(move |left| (top, left));
    (0..height).step_by(TILE).flat_map(lefts)
}
