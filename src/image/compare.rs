//! How far apart two images are, and whether their noise explains it.
//!
//! Two images -> per Stokes component: errors, and where standard errors are known, z-scores.
//!
//! The second image is the reference. The relative mean squared error divides by
//! `S0^2 + (0.01 mean S0)^2` of the reference for every component, for S1..S3 pass through zero.
//! A z-score is a difference over the combined standard error of both images; an image without
//! variance counts as exact. Limits are what images that differ by Gaussian noise of the stated
//! variance exceed in one of a thousand comparisons; variances that are estimated from few runs
//! have heavier tails (16 runs: an rms z of 1.07 is expected). Channels of one pixel may share all
//! of their noise, so that a limit counts pixels and not channels.

use std::fmt;

use serde::Serialize;

use super::check_shape;
use super::error::OutputError;
use super::legend::{arrange, with_legend_of};
use super::palette::{BLUE_WHITE_RED, NO_LIGHT, sample};
use super::picture::Picture;
use super::visualize::{luminance_at, range_of, signed_legend};
use crate::image::StokesImage;
use crate::math::statistics::{chi_square_limit, maximum_limit};
use crate::spectrum::Color;

/// Side of the blocks over which differences are added up.
const BLOCK: usize = 8;
/// The chance that mere noise exceeds a limit.
const FALSE_ALARM: f64 = 1e-3;
/// Where both images claim to be exact, differences up to this share of S0 are rounding.
const ROUNDING: f64 = 1e-5;
/// The share of a Gaussian beyond three standard errors.
const SHARE_BEYOND_3: f64 = 0.002_699_8;

/// What a comparison of two images found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Number of color channels, which each component pools.
    pub channels: usize,
    /// One entry per Stokes component that both images have.
    pub components: Vec<ComponentComparison>,
}

/// The comparison of one Stokes component.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComponentComparison {
    /// `S0` to `S3`.
    pub name: String,
    /// Mean of the first image.
    pub mean_first: f64,
    /// Mean of the second image.
    pub mean_second: f64,
    /// Root of the mean squared difference.
    pub rmse: f64,
    /// Mean squared difference relative to the reference's S0.
    pub relative_mse: f64,
    /// Largest absolute difference.
    pub max_abs: f64,
    /// Values that are not finite in either image; they are left out of everything else.
    pub non_finite: usize,
    /// Whether the noise explains the differences; absent where no variance is known.
    pub significance: Option<Significance>,
}

/// Differences in units of their standard errors.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Significance {
    /// Number of z-scores.
    pub count: usize,
    /// Root of the mean squared z-score; about 1 if noise explains the differences.
    pub rms_z: f64,
    /// What `rms_z` stays below.
    pub rms_z_limit: f64,
    /// Share of z-scores beyond 3 either way.
    pub share_beyond_3: f64,
    /// The share that Gaussian noise has there.
    pub share_beyond_3_expected: f64,
    /// The z-score of the sum over the worst block of 8 x 8 pixels, which finds faint bias.
    pub worst_block_z: f64,
    /// What the absolute value of `worst_block_z` stays below.
    pub worst_block_z_limit: f64,
    /// Upper left pixel (x, y) of the worst block.
    pub worst_block: (usize, usize),
    /// Values that differ though both images claim to be exact there.
    pub exact_mismatches: usize,
}

/// The difference of every Stokes component that both images have, first minus second, on one
/// signed scale that 99 percent of all differences stay within. RGB is combined by luminance.
pub fn difference_picture(
    first: &StokesImage,
    second: &StokesImage,
) -> Result<Picture, OutputError> {
    check_pair(first, second)?;
    let differences: Vec<Vec<f32>> = (0..first.components.min(second.components))
        .map(|component| {
            let value = |image, pixel| luminance_at(image, component, pixel);
            let pixels = 0..first.width * first.height;
            pixels.map(|pixel| value(first, pixel) - value(second, pixel)).collect()
        })
        .collect();
    let range = range_of(differences.iter().flatten().copied());
    let color = |&difference: &f32| match difference.is_finite() {
        true => sample(BLUE_WHITE_RED, 0.5 + 0.5 * difference / range),
        false => NO_LIGHT,
    };
    let draw = |(component, plane): (usize, &Vec<f32>)| {
        let pixels = plane.iter().map(color).collect();
        let picture = Picture { width: first.width, height: first.height, pixels };
        let title = format!("difference of S{component}");
        with_legend_of(first, &picture, signed_legend(title, range, "not finite"))
    };
    let pictures: Vec<Picture> = differences.iter().enumerate().map(draw).collect();
    Ok(arrange(&pictures, 2))
}

/// Compares an image with a reference of the same size. Where one of them has the intensity alone
/// only S0 is compared; a monochromatic image is compared with an RGB image that is all grey.
pub fn compare(first: &StokesImage, second: &StokesImage) -> Result<Comparison, OutputError> {
    let channels = check_pair(first, second)?;
    let pair = Pair { first, second, channels };
    let count = first.components.min(second.components);
    Ok(Comparison {
        width: first.width,
        height: first.height,
        channels,
        components: (0..count).map(|component| pair.compare(component)).collect(),
    })
}

/// The relative mean squared error that a reference owes to its own noise, per Stokes component;
/// nothing where its variance is not known.
pub fn relative_variance(reference: &StokesImage) -> Option<Vec<f64>> {
    let channels = reference.color.channels();
    let pair = Pair { first: reference, second: reference, channels };
    let variance = reference.variance.as_deref()?;
    let floor = pair.floor();
    let of_plane = |(index, plane): (usize, &Vec<f32>)| {
        let relative = |(pixel, variance): (usize, &f32)| {
            f64::from(*variance) / (pair.scale(index % channels, pixel) + floor)
        };
        let finite = plane.iter().enumerate().map(relative).filter(|value| value.is_finite());
        finite.sum::<f64>() / plane.len().max(1) as f64
    };
    let planes: Vec<f64> = variance.iter().enumerate().map(of_plane).collect();
    let components = planes.chunks(channels);
    Some(components.map(|planes| planes.iter().sum::<f64>() / channels as f64).collect())
}

/// The number of channels to be compared, if the images go together.
fn check_pair(first: &StokesImage, second: &StokesImage) -> Result<usize, OutputError> {
    for image in [first, second] {
        check_shape(image).map_err(|reason| OutputError::Image { reason })?;
    }
    let mismatch = |reason: &str| {
        let reason = reason.to_owned();
        OutputError::Mismatch { first: in_words(first), second: in_words(second), reason }
    };
    if (first.width, first.height) != (second.width, second.height) {
        return Err(mismatch("their sizes differ"));
    }
    if let Some(difference) = first.color.difference(&second.color) {
        return Err(mismatch(&difference));
    }
    let channels = first.color.channels().min(second.color.channels());
    for image in [first, second] {
        if image.color.channels() != channels && !is_grey(image) {
            return Err(mismatch("one is monochromatic and the other is not grey"));
        }
    }
    Ok(channels)
}

/// What an image is: its color and its size.
pub fn in_words(image: &StokesImage) -> String {
    let color = match &image.color {
        Color::Rgb => "an RGB image".to_owned(),
        Color::Mono { .. } => "a monochromatic image".to_owned(),
        Color::Bands(bands) => format!("an image of {bands}"),
        Color::Responses(curves) => format!("an image by {curves}"),
    };
    format!("{color} of {} x {} pixels", image.width, image.height)
}

/// Whether all channels of an RGB image are the same, as when Mitsuba renders one wavelength.
fn is_grey(image: &StokesImage) -> bool {
    image
        .planes
        .chunks(image.color.channels())
        .all(|planes| planes.iter().all(|plane| plane.iter().zip(&planes[0]).all(|(a, b)| a == b)))
}

struct Pair<'a> {
    first: &'a StokesImage,
    second: &'a StokesImage,
    channels: usize,
}

impl Pair<'_> {
    fn compare(&self, component: usize) -> ComponentComparison {
        let floor = self.floor();
        let mut result = ComponentComparison {
            name: format!("S{component}"),
            mean_first: self.mean(self.first, component),
            mean_second: self.mean(self.second, component),
            rmse: 0.0,
            relative_mse: 0.0,
            max_abs: 0.0,
            non_finite: 0,
            significance: self.significance(component),
        };
        let mut count = 0_usize;
        for channel in 0..self.channels {
            for pixel in 0..self.first.width * self.first.height {
                let Some(difference) = self.difference(component, channel, pixel) else {
                    result.non_finite += 1;
                    continue;
                };
                let scale = self.scale(channel, pixel) + floor;
                count += 1;
                result.rmse += difference * difference;
                if scale > 0.0 {
                    result.relative_mse += difference * difference / scale;
                }
                result.max_abs = result.max_abs.max(difference.abs());
            }
        }
        let count = count.max(1) as f64;
        result.rmse = (result.rmse / count).sqrt();
        result.relative_mse /= count;
        result
    }

    /// What squares are divided by to be relative, beside [`Self::scale`].
    fn floor(&self) -> f64 {
        (0.01 * self.mean(self.second, 0)).powi(2)
    }

    /// The square of the reference's S0.
    fn scale(&self, channel: usize, pixel: usize) -> f64 {
        f64::from(self.second.plane(0, channel)[pixel]).powi(2)
    }

    fn mean(&self, image: &StokesImage, component: usize) -> f64 {
        let planes = (0..self.channels).map(|channel| image.plane(component, channel));
        let finite = planes.flatten().filter(|value| value.is_finite());
        let (sum, count) =
            finite.fold((0.0, 0_usize), |(sum, n), &value| (sum + f64::from(value), n + 1));
        sum / count.max(1) as f64
    }

    /// First minus second; nothing where either is not finite.
    fn difference(&self, component: usize, channel: usize, pixel: usize) -> Option<f64> {
        let value = |image: &StokesImage| f64::from(image.plane(component, channel)[pixel]);
        Some(value(self.first) - value(self.second)).filter(|difference| difference.is_finite())
    }

    /// The squared standard error of a difference.
    fn variance(&self, component: usize, channel: usize, pixel: usize) -> f64 {
        let of = |image: &StokesImage| {
            let planes = image.variance.as_deref().unwrap_or_default();
            let plane = planes.get(component * image.color.channels() + channel);
            plane.map_or(0.0, |plane| f64::from(plane[pixel]))
        };
        of(self.first) + of(self.second)
    }

    fn significance(&self, component: usize) -> Option<Significance> {
        if self.first.variance.is_none() && self.second.variance.is_none() {
            return None;
        }
        let mut tally = Tally::default();
        let (mut worst_z, mut worst_block) = (0.0_f64, (0, 0));
        for channel in 0..self.channels {
            for y in (0..self.first.height).step_by(BLOCK) {
                for x in (0..self.first.width).step_by(BLOCK) {
                    let z = self.block(&mut tally, component, channel, (x, y));
                    if z.abs() > worst_z.abs() {
                        (worst_z, worst_block) = (z, (x, y));
                    }
                }
            }
        }
        let blocks = self.first.width.div_ceil(BLOCK) * self.first.height.div_ceil(BLOCK);
        let count = tally.count.max(1) as f64;
        Some(Significance {
            count: tally.count,
            rms_z: (tally.squares / count).sqrt(),
            rms_z_limit: chi_square_limit(tally.count.div_ceil(self.channels), FALSE_ALARM),
            share_beyond_3: tally.beyond_3 as f64 / count,
            share_beyond_3_expected: SHARE_BEYOND_3,
            worst_block_z: worst_z,
            worst_block_z_limit: maximum_limit(blocks * self.channels, FALSE_ALARM),
            worst_block,
            exact_mismatches: tally.exact_mismatches,
        })
    }

    /// Counts the pixels of a block and returns the z-score of its sum.
    fn block(
        &self,
        tally: &mut Tally,
        component: usize,
        channel: usize,
        (left, top): (usize, usize),
    ) -> f64 {
        let (mut sum, mut variance_sum) = (0.0, 0.0);
        for y in top..(top + BLOCK).min(self.first.height) {
            for x in left..(left + BLOCK).min(self.first.width) {
                let pixel = y * self.first.width + x;
                let variance = self.variance(component, channel, pixel);
                let Some(difference) = self.difference(component, channel, pixel) else {
                    continue;
                };
                if variance > 0.0 && variance.is_finite() {
                    tally.add(difference / variance.sqrt());
                    sum += difference;
                    variance_sum += variance;
                } else {
                    let s0 = f64::from(self.second.plane(0, channel)[pixel]).abs();
                    tally.exact_mismatches += usize::from(difference.abs() > ROUNDING * s0);
                }
            }
        }
        if variance_sum > 0.0 { sum / variance_sum.sqrt() } else { 0.0 }
    }
}

#[derive(Default)]
struct Tally {
    count: usize,
    squares: f64,
    beyond_3: usize,
    exact_mismatches: usize,
}

impl Tally {
    fn add(&mut self, z: f64) {
        self.count += 1;
        self.squares += z * z;
        self.beyond_3 += usize::from(z.abs() > 3.0);
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let color = if self.channels == 1 { "one channel" } else { "all channels pooled" };
        writeln!(
            f,
            "{} x {} pixels, {color}; the second is the reference",
            self.width, self.height
        )?;
        writeln!(
            f,
            "     {:>12} {:>12} {:>12} {:>12} {:>12}",
            "mean first", "mean second", "rmse", "relative mse", "max |diff|"
        )?;
        for row in &self.components {
            writeln!(
                f,
                "{:<4} {:>12.5e} {:>12.5e} {:>12.5e} {:>12.5e} {:>12.5e}",
                row.name, row.mean_first, row.mean_second, row.rmse, row.relative_mse, row.max_abs
            )?;
        }
        for row in self.components.iter().filter(|row| row.non_finite > 0) {
            writeln!(f, "{}: {} values are not finite", row.name, row.non_finite)?;
        }
        if self.components.iter().all(|row| row.significance.is_none()) {
            return write!(f, "no variance is known: whether noise explains this is open");
        }
        self.write_significance(f)
    }
}

impl Comparison {
    fn write_significance(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "\n     {:>8} {:>8} {:>9} {:>9}   worst 8 x 8 block",
            "rms z", "limit", "|z| > 3", "expected"
        )?;
        let rows = self.components.iter().filter_map(|row| Some((row, row.significance.as_ref()?)));
        for (row, found) in rows {
            if found.count == 0 {
                writeln!(
                    f,
                    "{:<4} exact in both images, {} values differ",
                    row.name, found.exact_mismatches
                )?;
                continue;
            }
            let (x, y) = found.worst_block;
            writeln!(
                f,
                "{:<4} {:>8.4} {:>8.4} {:>8.3}% {:>8.3}%   z = {:+.2} (limit {:.2}) at {x}, {y}",
                row.name,
                found.rms_z,
                found.rms_z_limit,
                100.0 * found.share_beyond_3,
                100.0 * found.share_beyond_3_expected,
                found.worst_block_z,
                found.worst_block_z_limit,
            )?;
            if found.exact_mismatches > 0 {
                let count = found.exact_mismatches;
                writeln!(f, "     {count} values differ where both images claim to be exact")?;
            }
        }
        write!(f, "noise alone exceeds a limit in 1 of 1000 comparisons")
    }
}
