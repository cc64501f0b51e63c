//! Floor 3: where measured light is added up, over iterations, with one owner and without an error
//! that the order would change, in two doubles a value. No render loop.

mod analyzed;
mod halves;
pub mod record;
mod state;

use rayon::prelude::*;

use crate::image::StokesImage;
use crate::math::exact::ExactSums;
use crate::spectrum::Color;

pub use self::analyzed::spread;
use self::halves::Halves;

/// Stokes values per pixel, summed over iterations.
///
/// Iterations come in replicates: independent randomizations of the random sequences. Within one,
/// samples are stratified and their spread says nothing about the error of their mean; between
/// replicates it does, so variances are taken there. Where blocks of one randomization stand for
/// replicates, what they overestimate is taken back (`halves`).
///
/// Without variances, sums do not depend on the order in which light comes, nor on how iterations
/// are grouped ([`ExactSums`]). Variances depend on their blocks and the order of these: a film
/// that begins with a later one keeps them as they are, to be added to the film of the earlier ones
/// ([`Film::take`]).
pub struct Film {
    width: usize,
    height: usize,
    color: Color,
    components: usize,
    variances: Variances,
    /// Sums, pixel by pixel, `component * channels + channel` within: of the current block if
    /// variances are wanted, else of all.
    sums: ExactSums,
    finished: Finished,
    /// Finished blocks.
    blocks: u32,
    /// Weight of the finished blocks: their iterations.
    iterations: u64,
}

/// Where variances come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variances {
    /// They are not wanted.
    None,
    /// From replicates, independent of each other.
    Replicates,
    /// From blocks of one sequence.
    Blocks,
}

/// What is kept of the finished blocks.
enum Finished {
    /// Nothing but their sums.
    Sums,
    /// What the variances need.
    Means {
        /// Mean over the blocks.
        mean: Vec<f64>,
        /// Sum of squared deviations from the mean.
        deviations: Vec<f64>,
        /// What tells how much better than blocks a sequence is; if they are of one.
        halves: Option<Halves>,
    },
    /// The blocks themselves, as there are earlier ones elsewhere.
    Blocks(Vec<Block>),
}

/// The sums of some iterations.
struct Block {
    iterations: u32,
    sums: Vec<f64>,
}

impl Film {
    /// A black film. If it `begins_later`, it is for a part of an image of which other films have
    /// the iterations before.
    pub fn new(
        [width, height]: [u32; 2],
        color: Color,
        components: usize,
        variances: Variances,
        begins_later: bool,
    ) -> Self {
        let (width, height) = (width as usize, height as usize);
        let values = width * height * components * color.channels();
        let finished = match (variances, begins_later) {
            (Variances::None, _) => Finished::Sums,
            (Variances::Replicates | Variances::Blocks, true) => Finished::Blocks(Vec::new()),
            (Variances::Replicates | Variances::Blocks, false) => Finished::Means {
                mean: vec![0.0; values],
                deviations: vec![0.0; values],
                halves: (variances == Variances::Blocks).then(|| Halves::new(values)),
            },
        };
        let sums = ExactSums::new(values);
        let (blocks, iterations) = (0, 0);
        Self { width, height, color, components, variances, sums, finished, blocks, iterations }
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Values per pixel.
    pub fn values_per_pixel(&self) -> usize {
        self.components * self.color.channels()
    }

    /// Adds to the values of a pixel; the first are those of S0.
    #[inline(always)]
    pub fn add(&mut self, pixel: usize, values: &[f32]) {
        self.sums.add(pixel * self.values_per_pixel(), values);
    }

    /// Adds sums of neighbors in a row, from the one at `first` on, to the pixels from `pixel` on.
    #[inline(always)]
    pub fn add_row(&mut self, pixel: usize, sums: &ExactSums, first: usize, count: usize) {
        let stride = self.values_per_pixel();
        self.sums.add_sums(pixel * stride, sums, first * stride, count * stride);
    }

    /// Ends a replicate or block of `iterations` iterations: its mean joins the others, weighted by
    /// its iterations (West 1979, "Updating mean and variance estimates").
    pub fn finish_block(&mut self, iterations: u32) {
        self.blocks += 1;
        self.iterations += u64::from(iterations);
        let sums = &mut self.sums;
        let (mean, deviations, halves) = match &mut self.finished {
            Finished::Sums => return,
            Finished::Blocks(blocks) => {
                let rounded = (0..sums.len()).map(|index| sums.get(index)).collect();
                blocks.push(Block { iterations, sums: rounded });
                sums.clear();
                return;
            }
            Finished::Means { mean, deviations, halves } => (mean, deviations, halves),
        };
        let share = f64::from(iterations) / self.iterations as f64;
        let weight = f64::from(iterations) * (1.0 - share);
        for (index, (mean, deviation)) in mean.iter_mut().zip(deviations).enumerate() {
            let difference = sums.get(index) / f64::from(iterations) - *mean;
            *mean += difference * share;
            *deviation += weight * difference * difference;
        }
        sums.clear();
        if let Some(halves) = halves {
            halves.keep(mean, self.iterations);
        }
    }

    /// The image of the finished blocks; variances where there are two or more of them.
    pub fn develop(&self) -> StokesImage {
        let mut image = StokesImage::new(self.width, self.height, self.color, self.components);
        let iterations = self.iterations.max(1) as f64;
        let (mean, deviations, halves) = match &self.finished {
            Finished::Sums => {
                image.planes = self.planes(|index| self.sums.get(index) / iterations);
                return image;
            }
            Finished::Blocks(blocks) => return self.of_blocks(blocks).develop(),
            Finished::Means { mean, deviations, halves } => (mean, deviations, halves),
        };
        image.planes = self.planes(|index| mean[index]);
        // Blocks are of nearly equal size: the squared standard error of the weighted mean.
        let degrees = f64::from(self.blocks.max(2) - 1) * iterations;
        let of_mean = |index: usize| deviations[index] * (1.0 / degrees);
        image.variance = (self.blocks > 1).then(|| self.planes(of_mean));
        if let (Some(planes), Some(halves)) = (&mut image.variance, halves) {
            let stride = self.values_per_pixel();
            planes.par_iter_mut().enumerate().for_each(|(plane, variances)| {
                let index_of = |pixel: usize| pixel * stride + plane;
                halves.narrow(variances, self.width, (mean, self.iterations), index_of);
            });
        }
        image
    }

    /// The image so far, without variances: the finished blocks and the current one, of which
    /// `iterations` have been added.
    pub fn preview(&self, iterations: u32) -> StokesImage {
        let mut image = StokesImage::new(self.width, self.height, self.color, self.components);
        let all = (self.iterations + u64::from(iterations)).max(1) as f64;
        let share = self.iterations as f64 / all;
        let of_finished = |index: usize| match &self.finished {
            Finished::Sums => 0.0,
            Finished::Means { mean, .. } => mean[index] * share,
            Finished::Blocks(blocks) => {
                blocks.iter().map(|block| block.sums[index]).sum::<f64>() / all
            }
        };
        image.planes = self.planes(|index| of_finished(index) + self.sums.get(index) / all);
        image
    }

    /// A film that has nothing but some blocks of this one.
    fn of_blocks(&self, blocks: &[Block]) -> Self {
        let size = [self.width as u32, self.height as u32];
        let mut film = Self::new(size, self.color, self.components, self.variances, false);
        blocks.iter().for_each(|block| film.take_block(&block.sums, block.iterations));
        film
    }

    /// Adds a block that others have made.
    fn take_block(&mut self, sums: &[f64], iterations: u32) {
        self.sums = ExactSums::of_columns(sums.to_vec(), vec![0.0; sums.len()]);
        self.finish_block(iterations);
    }

    fn planes(&self, value_at: impl Fn(usize) -> f64 + Sync) -> Vec<Vec<f32>> {
        let stride = self.values_per_pixel();
        let value_at = &value_at;
        let plane = |offset: usize| {
            (offset..self.sums.len()).step_by(stride).map(|index| value_at(index) as f32).collect()
        };
        (0..stride).into_par_iter().map(plane).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MONO: Color = Color::Mono { wavelength_nm: 550.0 };

    /// Two values, three replicates: mean and squared standard error by hand.
    #[test]
    fn replicates_give_mean_and_error() {
        let mut film = Film::new([2, 1], MONO, 1, Variances::Replicates, false);
        let mut plain = Film::new([2, 1], MONO, 1, Variances::None, false);
        for value in [1.0, 2.0, 6.0] {
            plain.add(0, &[value * 4.0]);
            plain.add(1, &[4.0]);
            assert_eq!(plain.preview(4).planes[0][1], 1.0);
            plain.finish_block(4);
            film.add(0, &[value * 4.0]);
            film.add(1, &[2.0]);
            film.add(1, &[2.0]);
            let preview = film.preview(4);
            film.finish_block(4);
            assert_eq!(preview.planes, film.develop().planes);
        }
        film.add(0, &[30.0]);
        assert_eq!(film.preview(3).planes, [vec![66.0 / 15.0, 12.0 / 15.0]]);
        film.add(0, &[-30.0]);
        let image = film.develop();
        assert_eq!(image.planes, [vec![3.0, 1.0]]);
        assert_eq!(plain.develop().planes, image.planes);
        assert!(plain.develop().variance.is_none());
        let variance = &image.variance.expect("three replicates")[0];
        assert!((variance[0] - 14.0 / 6.0).abs() < 1e-6, "{}", variance[0]);
        assert_eq!(variance[1], 0.0);
    }

    /// Blocks that a later film keeps give what they give in one that has seen them.
    #[test]
    fn later_blocks_are_developed_alike() {
        for variances in [Variances::Replicates, Variances::Blocks] {
            let mut films = [false, true].map(|later| Film::new([1, 1], MONO, 4, variances, later));
            for (value, iterations) in [(0.3, 1), (0.7, 2), (0.1, 2), (1.9, 4)] {
                for film in &mut films {
                    film.add(0, &[value, 0.1 * value]);
                    film.finish_block(iterations);
                }
            }
            let [film, later] = films;
            assert_eq!(film.develop(), later.develop());
            assert_eq!(film.preview(0).planes[0], later.preview(0).planes[0]);
        }
    }
}
