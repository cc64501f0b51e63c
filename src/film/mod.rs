//! Floor 3: where measured light is added up, over iterations, with one owner and a fixed order, in
//! double precision. No files, no render loop.

mod analyzed;
mod halves;

use rayon::prelude::*;

use crate::spectrum::Color;

use crate::image::StokesImage;

pub use self::analyzed::spread;
use self::halves::Halves;

/// Stokes values per pixel, summed over iterations.
///
/// Iterations come in replicates: independent randomizations of the random sequences. Within one,
/// samples are stratified and their spread says nothing about the error of their mean; between
/// replicates it does, so variances are taken there. Where blocks of one randomization stand for
/// replicates, what they overestimate is taken back (`halves`).
pub struct Film {
    width: usize,
    height: usize,
    color: Color,
    components: usize,
    /// Sums, pixel by pixel, `component * channels + channel` within: of the current replicate if
    /// variances are wanted, else of all.
    sums: Vec<f64>,
    /// What the variances need, if they are wanted.
    finished: Option<Finished>,
    /// Finished replicates.
    replicates: u32,
    /// Weight of the finished replicates: their iterations.
    iterations: u64,
}

/// The finished replicates.
struct Finished {
    /// Mean over them.
    mean: Vec<f64>,
    /// Sum of squared deviations from the mean.
    deviations: Vec<f64>,
    /// What tells how much better than blocks a sequence is; if there are blocks.
    halves: Option<Halves>,
}

impl Film {
    /// A black film. `with_variance` keeps what the variances need.
    pub fn new(
        width: u32,
        height: u32,
        color: Color,
        components: usize,
        with_variance: bool,
    ) -> Self {
        let (width, height) = (width as usize, height as usize);
        let values = || vec![0.0; width * height * components * color.channels()];
        Self {
            width,
            height,
            color,
            components,
            sums: values(),
            finished: with_variance.then(|| Finished {
                mean: values(),
                deviations: values(),
                halves: None,
            }),
            replicates: 0,
            iterations: 0,
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

    /// Adds to the values of a pixel; the first are those of S0.
    #[inline(always)]
    pub fn add(&mut self, pixel: usize, values: &[f32]) {
        let start = pixel * self.values_per_pixel();
        let sums = &mut self.sums[start..start + values.len()];
        for (sum, &value) in sums.iter_mut().zip(values) {
            *sum += f64::from(value);
        }
    }

    /// Ends a replicate of `iterations` iterations: its mean joins the others, weighted by its
    /// iterations (West 1979, "Updating mean and variance estimates").
    pub fn finish_replicate(&mut self, iterations: u32) {
        self.replicates += 1;
        self.iterations += u64::from(iterations);
        let share = f64::from(iterations) / self.iterations as f64;
        let weight = f64::from(iterations) * (1.0 - share);
        let Some(Finished { mean, deviations, .. }) = &mut self.finished else { return };
        let finished = mean.iter_mut().zip(deviations);
        for (sum, (mean, deviation)) in self.sums.iter_mut().zip(finished) {
            let difference = *sum / f64::from(iterations) - *mean;
            *mean += difference * share;
            *deviation += weight * difference * difference;
            *sum = 0.0;
        }
    }

    /// The same where it is a block of the one sequence of all.
    pub fn finish_block(&mut self, iterations: u32) {
        self.finish_replicate(iterations);
        let Some(Finished { mean, halves, .. }) = &mut self.finished else { return };
        let halves = halves.get_or_insert_with(|| Halves::new(mean.len()));
        halves.keep(mean, self.iterations);
    }

    /// The image of the finished replicates; variances where there are two or more of them.
    pub fn develop(&self) -> StokesImage {
        let mut image = StokesImage::new(self.width, self.height, self.color, self.components);
        let iterations = self.iterations.max(1) as f64;
        let Some(Finished { mean, deviations, halves }) = &self.finished else {
            image.planes = self.planes(|index| self.sums[index] / iterations);
            return image;
        };
        image.planes = self.planes(|index| mean[index]);
        // Replicates are of nearly equal size: the squared standard error of the weighted mean.
        let degrees = f64::from(self.replicates.max(2) - 1) * iterations;
        let of_mean = |index: usize| deviations[index] * (1.0 / degrees);
        image.variance = (self.replicates > 1).then(|| self.planes(of_mean));
        if let (Some(planes), Some(halves)) = (&mut image.variance, halves) {
            let stride = self.values_per_pixel();
            planes.par_iter_mut().enumerate().for_each(|(plane, variances)| {
                let index_of = |pixel: usize| pixel * stride + plane;
                halves.narrow(variances, self.width, (mean, self.iterations), index_of);
            });
        }
        image
    }

    /// The image so far, without variances: the finished replicates and the current one, of which
    /// `iterations` have been added.
    pub fn preview(&self, iterations: u32) -> StokesImage {
        let mut image = StokesImage::new(self.width, self.height, self.color, self.components);
        let all = (self.iterations + u64::from(iterations)).max(1) as f64;
        let share = self.iterations as f64 / all;
        let of_finished = |index: usize| match &self.finished {
            Some(finished) => finished.mean[index] * share,
            None => 0.0,
        };
        image.planes = self.planes(|index| of_finished(index) + self.sums[index] / all);
        image
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

    /// Two values, three replicates: mean and squared standard error by hand.
    #[test]
    fn replicates_give_mean_and_error() {
        let mut film = Film::new(2, 1, Color::Mono { wavelength_nm: 550.0 }, 1, true);
        let mut plain = Film::new(2, 1, Color::Mono { wavelength_nm: 550.0 }, 1, false);
        for value in [1.0, 2.0, 6.0] {
            plain.add(0, &[value * 4.0]);
            plain.add(1, &[4.0]);
            assert_eq!(plain.preview(4).planes[0][1], 1.0);
            plain.finish_replicate(4);
            film.add(0, &[value * 4.0]);
            film.add(1, &[2.0]);
            film.add(1, &[2.0]);
            let preview = film.preview(4);
            film.finish_replicate(4);
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
}
