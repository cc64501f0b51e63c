//! Whether noise explains differences.
//!
//! Errors are estimated from independent replicates of whole cells of pixels, so no assumption is
//! made about the correlation of pixels (light paths splat into many). A score is the difference
//! over its combined standard error, with the heavier tails of errors that are estimated from few
//! replicates taken out, so that scores of correct renders are standard normal numbers as far as
//! the means of the replicates are Gaussian. Those of single pixels are not where few samples
//! carry most of the light, which is why cells, and many samples a replicate, are preferred to
//! many replicates.

use sunstone::internals::image::StokesImage;

/// What rounding may make of equal values.
pub const ROUNDING: f64 = 1e-5;
/// Standard errors below this share of S0 are rounding and not noise.
const NOISE_MIN: f64 = 2e-6;

/// A number known with an error.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    pub mean: f64,
    /// Squared standard error of the mean.
    pub variance: f64,
    /// Degrees of freedom of `variance`.
    pub degrees: f64,
}

impl Estimate {
    /// From the values of independent replicates.
    pub fn of(samples: &[f64]) -> Self {
        let count = samples.len() as f64;
        let mean = samples.iter().sum::<f64>() / count;
        let squares: f64 = samples.iter().map(|sample| (sample - mean).powi(2)).sum();
        Self { mean, variance: squares / (count * (count - 1.0)), degrees: count - 1.0 }
    }

    /// A number without error.
    pub fn exact(mean: f64) -> Self {
        Self { mean, variance: 0.0, degrees: 1.0 }
    }

    /// The score of the difference to `other`; none where both are known so well that rounding
    /// takes the place of noise, at light of intensity `s0`.
    ///
    /// Degrees of freedom after Welch 1947; the tail of Student's t is mapped to that of a normal
    /// number after Wallace 1959.
    pub fn score(&self, other: &Self, s0: f64) -> Option<f64> {
        let variance = self.variance + other.variance;
        if variance.sqrt() <= NOISE_MIN * s0 || variance == 0.0 {
            return None;
        }
        let spread = |e: &Self| e.variance * e.variance / e.degrees;
        let degrees = variance * variance / (spread(self) + spread(other));
        let t = (self.mean - other.mean) / variance.sqrt();
        let shrink = (8.0 * degrees + 1.0) / (8.0 * degrees + 3.0);
        Some(t.signum() * shrink * (degrees * (t * t / degrees).ln_1p()).sqrt())
    }
}

/// Square cells of a film: the masked pixels of each, cells without any left out.
pub fn cells(width: usize, height: usize, edge: usize, mask: &[bool]) -> Vec<Vec<usize>> {
    let mut cells = Vec::new();
    for top in (0..height).step_by(edge) {
        for left in (0..width).step_by(edge) {
            let rows = top..(top + edge).min(height);
            let row = |y: usize| (left..(left + edge).min(width)).map(move |x| y * width + x);
            cells.push(rows.flat_map(row).filter(|&pixel| mask[pixel]).collect());
        }
    }
    cells.retain(|cell: &Vec<usize>| !cell.is_empty());
    cells
}

/// The mean over a cell as the replicates know it.
pub fn estimate(images: &[StokesImage], plane: usize, cell: &[usize]) -> Estimate {
    let mean = |image: &StokesImage| {
        let values = cell.iter().map(|&pixel| f64::from(image.planes[plane][pixel]));
        values.sum::<f64>() / cell.len() as f64
    };
    Estimate::of(&images.iter().map(mean).collect::<Vec<f64>>())
}

/// The mean over a cell of an image of independent pixels, which states their variances or is
/// exact; each variance is an estimate with `degrees` degrees of freedom.
pub fn estimate_stated(
    image: &StokesImage,
    plane: usize,
    cell: &[usize],
    degrees: f64,
) -> Estimate {
    let count = cell.len() as f64;
    let sum = |values: &[f32]| cell.iter().map(|&pixel| f64::from(values[pixel])).sum::<f64>();
    let mean = sum(&image.planes[plane]) / count;
    let Some(variance) = image.variance.as_ref().map(|planes| &planes[plane]) else {
        return Estimate::exact(mean);
    };
    let squares: f64 = cell.iter().map(|&pixel| f64::from(variance[pixel]).powi(2)).sum();
    let total = sum(variance);
    let degrees = if squares > 0.0 { degrees * total * total / squares } else { degrees };
    Estimate { mean, variance: total / (count * count), degrees }
}

/// Limits of the root mean square of `count` scores: four of its standard deviations, and a tenth
/// for means that are not quite Gaussian.
pub fn rms_limits(count: usize) -> [f64; 2] {
    let deviation = 1.0 / (2.0 * count.max(1) as f64).sqrt();
    [0.9 - 4.0 * deviation, 1.1 + 4.0 * deviation]
}

/// Mean of S0 over an image and its channels.
pub fn mean_s0(image: &StokesImage) -> f64 {
    let planes = &image.planes[..image.color.channels()];
    let sum: f64 = planes.iter().flatten().map(|&value| f64::from(value)).sum();
    sum / (image.width * image.height * planes.len()) as f64
}

/// Root of the mean of the squares.
pub fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}

/// The largest absolute value.
pub fn worst(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |worst, value| value.abs().max(worst))
}
