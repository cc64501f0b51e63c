//! Sums over iterations, with one owner and a fixed order, in double precision.

use crate::spectrum::Color;

use super::StokesImage;

/// Stokes values per pixel, summed over iterations.
///
/// Iterations come in replicates: independent randomizations of the random sequences. Within one,
/// samples are stratified and their spread says nothing about the error of their mean; between
/// replicates it does, so variances are taken there.
pub struct Film {
    width: usize,
    height: usize,
    color: Color,
    components: usize,
    /// Sums of the current replicate, pixel by pixel, `component * channels + channel` within.
    sums: Vec<f64>,
    /// Mean over the finished replicates.
    mean: Vec<f64>,
    /// Sum of squared deviations from the mean over the finished replicates, if wanted.
    deviations: Option<Vec<f64>>,
    /// Finished replicates.
    replicates: u32,
    /// Weight of the finished replicates: their iterations.
    iterations: u64,
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
        let values = width * height * components * color.channels();
        Self {
            width,
            height,
            color,
            components,
            sums: vec![0.0; values],
            mean: vec![0.0; values],
            deviations: with_variance.then(|| vec![0.0; values]),
            replicates: 0,
            iterations: 0,
        }
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
        for index in 0..self.sums.len() {
            let value = self.sums[index] / f64::from(iterations);
            let difference = value - self.mean[index];
            self.mean[index] += difference * share;
            if let Some(deviations) = &mut self.deviations {
                deviations[index] += weight * difference * difference;
            }
            self.sums[index] = 0.0;
        }
    }

    /// The image of the finished replicates; variances where there are two or more of them.
    pub fn develop(&self) -> StokesImage {
        let mut image = StokesImage::new(self.width, self.height, self.color, self.components);
        image.planes = self.planes(&self.mean, 1.0);
        // Replicates are of nearly equal size: the squared standard error of the weighted mean.
        let degrees = f64::from(self.replicates.max(2) - 1) * self.iterations.max(1) as f64;
        image.variance = (self.deviations.as_ref())
            .filter(|_| self.replicates > 1)
            .map(|deviations| self.planes(deviations, 1.0 / degrees));
        image
    }

    /// The image so far, without variances: the finished replicates and the current one, of which
    /// `iterations` have been added.
    pub fn preview(&self, iterations: u32) -> StokesImage {
        let mut image = StokesImage::new(self.width, self.height, self.color, self.components);
        let all = (self.iterations + u64::from(iterations)).max(1) as f64;
        let finished = self.iterations as f64 / all;
        let values = self.mean.iter().zip(&self.sums);
        let values: Vec<f64> = values.map(|(mean, sum)| mean * finished + sum / all).collect();
        image.planes = self.planes(&values, 1.0);
        image
    }

    fn planes(&self, values: &[f64], factor: f64) -> Vec<Vec<f32>> {
        let stride = self.values_per_pixel();
        let plane = |offset: usize| {
            values[offset..].iter().step_by(stride).map(|value| (value * factor) as f32).collect()
        };
        (0..stride).map(plane).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two values, three replicates: mean and squared standard error by hand.
    #[test]
    fn replicates_give_mean_and_error() {
        let mut film = Film::new(2, 1, Color::Mono { wavelength_nm: 550.0 }, 1, true);
        for value in [1.0, 2.0, 6.0] {
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
        let variance = &image.variance.expect("three replicates")[0];
        assert!((variance[0] - 14.0 / 6.0).abs() < 1e-6, "{}", variance[0]);
        assert_eq!(variance[1], 0.0);
    }
}
