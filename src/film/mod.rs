//! Floor 3: where measured light is added up, over iterations, with one owner and without an error
//! that the order would change, in two doubles a value. No render loop.

mod developed;
mod halves;
pub mod record;
mod state;

use crate::math::exact::ExactSums;
use crate::spectrum::Color;

pub use self::developed::Developed;
use self::halves::Halves;
pub use self::state::recorded_values;

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

    /// Stokes components of a pixel.
    pub fn components(&self) -> usize {
        self.components
    }

    /// Adds to one value of a pixel.
    #[inline(always)]
    pub fn add_value(&mut self, pixel: usize, plane: usize, value: f32) {
        self.sums.add(pixel * self.values_per_pixel() + plane, &[value]);
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

    /// Adds a block that others have made.
    fn take_block(&mut self, sums: &[f64], iterations: u32) {
        self.sums = ExactSums::of_columns(sums.to_vec(), vec![0.0; sums.len()]);
        self.finish_block(iterations);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::StokesImage;
    use crate::image::rows::Rows;

    const MONO: Color = Color::Mono { wavelength_nm: 550.0 };

    fn of(rows: &dyn Rows) -> StokesImage {
        rows.whole().into_owned()
    }

    /// Two values, three replicates: mean and squared standard error by hand.
    #[test]
    fn replicates_give_mean_and_error() {
        let mut film = Film::new([2, 1], MONO, 1, Variances::Replicates, false);
        let mut plain = Film::new([2, 1], MONO, 1, Variances::None, false);
        for value in [1.0, 2.0, 6.0] {
            plain.add(0, &[value * 4.0]);
            plain.add(1, &[4.0]);
            assert_eq!(of(&plain.so_far(4)).planes[0][1], 1.0);
            plain.finish_block(4);
            film.add(0, &[value * 4.0]);
            film.add(1, &[2.0]);
            film.add(1, &[2.0]);
            let preview = of(&film.so_far(4));
            film.finish_block(4);
            assert_eq!(preview.planes, of(&film.developed()).planes);
        }
        film.add(0, &[30.0]);
        assert_eq!(of(&film.so_far(3)).planes, [vec![66.0 / 15.0, 12.0 / 15.0]]);
        film.add(0, &[-30.0]);
        let image = of(&film.developed());
        assert_eq!(image.planes, [vec![3.0, 1.0]]);
        assert_eq!(of(&plain.developed()).planes, image.planes);
        assert!(of(&plain.developed()).variance.is_none());
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
            assert_eq!(of(&film.developed()), of(&later.developed()));
            assert_eq!(of(&film.so_far(0)).planes[0], of(&later.so_far(0)).planes[0]);
        }
    }
}
