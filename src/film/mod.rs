//! Floor 3: where measured light is added up, over iterations, with one owner and without an error
//! that the order would change, in two doubles a value. No render loop.

mod developed;
pub mod filter;
mod halves;
pub mod lattice;
pub mod layout;
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
///
/// Where iterations have wavelengths of their own, one more pixel measures these ([`Gauge`]).
pub struct Film {
    width: usize,
    height: usize,
    color: Color,
    components: usize,
    variances: Variances,
    gauge: Gauge,
    /// Sums, pixel by pixel, with the planes of a pixel in the order of [`Film::place`]: of the
    /// current block if variances are wanted, else of all.
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

/// Whether a film keeps what its channels would have measured if each had the same from every
/// wavelength that it responds to, of which the mean is one.
///
/// The wavelengths of some iterations fall into channels more or less often than they do on the
/// average. The image is divided by that, so that bands of one spectrum are alike after a few
/// iterations (a ratio estimator: Cochran 1977, "Sampling Techniques", chapter 6). Its bias falls
/// as one over the iterations, and is zero where what a channel measures follows the density that
/// wavelengths are chosen by. Channels whose responses have both signs, as those of RGB, always add
/// one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gauge {
    /// All iterations have the same wavelengths.
    None,
    /// A pixel behind the last, in the channels of its first component.
    Kept,
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
        (variances, gauge): (Variances, Gauge),
        begins_later: bool,
    ) -> Self {
        let (width, height) = (width as usize, height as usize);
        let pixels = width * height + gauge.pixels();
        let values = pixels * components * color.channels();
        // Where wavelengths differ, all pixels share what halves would tell: they know too little.
        let is_one_sequence = variances == Variances::Blocks && gauge == Gauge::None;
        let finished = match (variances, begins_later) {
            (Variances::None, _) => Finished::Sums,
            (Variances::Replicates | Variances::Blocks, true) => Finished::Blocks(Vec::new()),
            (Variances::Replicates | Variances::Blocks, false) => Finished::Means {
                mean: vec![0.0; values],
                deviations: vec![0.0; values],
                halves: is_one_sequence.then(|| Halves::new(values)),
            },
        };
        let sums = ExactSums::new(values);
        let (blocks, iterations) = (0, 0);
        Self {
            width,
            height,
            color,
            components,
            variances,
            gauge,
            sums,
            finished,
            blocks,
            iterations,
        }
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

    /// Where a plane, `component * channels + channel`, is among the values of a pixel: the
    /// components of a channel stand together, as they are added to together.
    #[inline(always)]
    fn place(&self, plane: usize) -> usize {
        let channels = self.color.channels();
        plane % channels * self.components + plane / channels
    }

    /// Adds to the first components of a channel of a pixel.
    #[inline(always)]
    pub fn add(&mut self, pixel: usize, channel: usize, components: &[f32]) {
        let first = pixel * self.values_per_pixel() + channel * self.components;
        self.sums.add(first, components);
    }

    /// Adds to the gauge, which is kept: a value for every channel.
    pub fn add_to_gauge(&mut self, values: &[f32]) {
        assert_eq!(self.gauge, Gauge::Kept, "a film has the gauge that it was made with");
        let pixel = self.width * self.height;
        for (channel, met) in values.iter().enumerate() {
            self.add(pixel, channel, &[*met]);
        }
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

impl Gauge {
    /// Pixels that it takes.
    pub fn pixels(self) -> usize {
        match self {
            Self::None => 0,
            Self::Kept => 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::StokesImage;
    use crate::image::rows::Rows;

    const MONO: Color = Color::Mono { wavelength_nm: 550.0 };

    fn black(size: [u32; 2], components: usize, variances: Variances, later: bool) -> Film {
        Film::new(size, MONO, components, (variances, Gauge::None), later)
    }

    fn of(rows: &dyn Rows) -> StokesImage {
        rows.whole().into_owned()
    }

    /// Two values, three replicates: mean and squared standard error by hand.
    #[test]
    fn replicates_give_mean_and_error() {
        let mut film = black([2, 1], 1, Variances::Replicates, false);
        let mut plain = black([2, 1], 1, Variances::None, false);
        for value in [1.0, 2.0, 6.0] {
            plain.add(0, 0, &[value * 4.0]);
            plain.add(1, 0, &[4.0]);
            assert_eq!(of(&plain.so_far(4)).planes[0][1], 1.0);
            plain.finish_block(4);
            film.add(0, 0, &[value * 4.0]);
            film.add(1, 0, &[2.0]);
            film.add(1, 0, &[2.0]);
            let preview = of(&film.so_far(4));
            film.finish_block(4);
            assert_eq!(preview.planes, of(&film.developed()).planes);
        }
        film.add(0, 0, &[30.0]);
        assert_eq!(of(&film.so_far(3)).planes, [vec![66.0 / 15.0, 12.0 / 15.0]]);
        film.add(0, 0, &[-30.0]);
        let image = of(&film.developed());
        assert_eq!(image.planes, [vec![3.0, 1.0]]);
        assert_eq!(of(&plain.developed()).planes, image.planes);
        assert!(of(&plain.developed()).variance.is_none());
        let variance = &image.variance.expect("three replicates")[0];
        assert!((variance[0] - 14.0 / 6.0).abs() < 1e-6, "{}", variance[0]);
        assert_eq!(variance[1], 0.0);
    }

    /// A band that is met every other time measures what one does that is met each time.
    #[test]
    fn bands_are_divided_by_their_gauge() {
        for variances in [Variances::None, Variances::Replicates, Variances::Blocks] {
            for later in [false, true] {
                let kinds = (variances, Gauge::Kept);
                let mut film = Film::new([2, 1], Color::Rgb, 4, kinds, later);
                for iteration in 0..6 {
                    let met = [1.0, (iteration % 2) as f32 * 0.5, 0.0];
                    for (channel, met) in met.into_iter().enumerate() {
                        film.add(0, channel, &[3.0 * met]);
                        film.add(1, channel, &[met, 0.0, 0.5 * met]);
                    }
                    film.add_to_gauge(&met);
                    let so_far = of(&film.so_far(1));
                    assert_eq!(so_far.planes[0], [3.0, 1.0]);
                    film.finish_block(1);
                }
                assert_eq!(film.unmeasured(), [2]);
                let image = of(&film.developed());
                assert_eq!(image.planes[..3], [[3.0, 1.0], [3.0, 1.0], [0.0, 0.0]]);
                assert_eq!(image.planes[6..9], [[0.0, 0.5], [0.0, 0.5], [0.0, 0.0]]);
            }
        }
    }

    /// Blocks that a later film keeps give what they give in one that has seen them.
    #[test]
    fn later_blocks_are_developed_alike() {
        for variances in [Variances::Replicates, Variances::Blocks] {
            let mut films = [false, true].map(|later| black([1, 1], 4, variances, later));
            for (value, iterations) in [(0.3, 1), (0.7, 2), (0.1, 2), (1.9, 4)] {
                for film in &mut films {
                    film.add(0, 0, &[value, 0.1 * value]);
                    film.finish_block(iterations);
                }
            }
            let [film, later] = films;
            assert_eq!(of(&film.developed()), of(&later.developed()));
            assert_eq!(of(&film.so_far(0)).planes[0], of(&later.so_far(0)).planes[0]);
        }
    }
}
