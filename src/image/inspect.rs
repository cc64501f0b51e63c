//! What is in an image, in words.

use std::fmt::Write;
use std::path::Path;

use super::check_shape;
use super::error::OutputError;
use super::visualize::{dop, stokes_at};
use crate::image::StokesImage;
use crate::math::elementary::hypot;
use crate::math::text::printable;
use crate::spectrum::Color;

/// P may exceed S0 by this share before a pixel counts as unphysical: rounding of 32-bit floats.
const ROUNDING: f32 = 1e-5;

/// Describes the image in a file that [`super::load`] reads.
pub fn inspect_image(path: &Path) -> Result<String, OutputError> {
    let image = super::load(path)?;
    Ok(format!("{}\n{}", path.display(), describe(&image)))
}

/// What a pixel has, as comma-separated values: a line for every channel with its name, the
/// wavelength in nanometers that it stands for (nothing of red, green and blue), its Stokes vector
/// and the standard errors of that, if they are known. Pixels are counted from 0 at the upper left.
///
/// # Errors
/// When there is no such pixel.
pub fn pixel(image: &StokesImage, [x, y]: [usize; 2]) -> Result<String, OutputError> {
    let StokesImage { width, height, .. } = *image;
    check_shape(image).map_err(|reason| OutputError::Image { reason })?;
    if x >= width || y >= height {
        return Err(OutputError::NoPixel { x, y, width, height });
    }
    let names = image.component_names();
    let errors = image.variance.iter().flat_map(|_| names);
    let errors: String = errors.map(|name| format!(",stderr_{name}")).collect();
    let mut text = format!("channel,wavelength_nm,{}{errors}\n", names.join(","));
    for (channel, name) in image.channel_names().iter().enumerate() {
        let wavelength = image.color.wavelength_of(channel).map(|nm| nm.to_string());
        let of = |planes: &Vec<Vec<f32>>| -> Vec<f32> {
            let planes = planes.iter().skip(channel).step_by(image.color.channels());
            planes.map(|plane| plane[y * width + x]).collect()
        };
        let errors = image.variance.iter().flat_map(of).map(f32::sqrt);
        let numbers = of(&image.planes).into_iter().chain(errors).map(|value| value.to_string());
        let cells = [quoted(name), wavelength.unwrap_or_default()].into_iter().chain(numbers);
        text += &(cells.collect::<Vec<_>>().join(",") + "\n");
    }
    Ok(text)
}

/// A name as a cell of comma-separated values.
fn quoted(name: &str) -> String {
    let name = printable(name);
    match name.contains([',', '"', '\n']) {
        true => format!("\"{}\"", name.replace('"', "\"\"")),
        false => name,
    }
}

/// Size, color, the range of S0, how polarized it is, and the metadata, a line each.
pub fn describe(image: &StokesImage) -> String {
    let mut text = format!("  {:<12} {} x {} pixels\n", "size", image.width, image.height);
    let mut line = |name: &str, value: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {name:<12} {value}");
    };
    line(
        "color",
        match &image.color {
            Color::Rgb => "RGB, linear sRGB primaries".to_owned(),
            Color::Mono { wavelength_nm } => format!("one wavelength, {wavelength_nm} nm"),
            Color::Bands(bands) => format!("{bands}, each averaged over its width"),
            Color::Responses(curves) => format!("{curves}, radiance times response"),
        },
    );
    line(
        "components",
        match image.components {
            1 => "S0 (intensity alone)".to_owned(),
            _ => "S0 S1 S2 S3 (x right, y up, light towards the sensor)".to_owned(),
        },
    );
    for (channel, plane) in image.channel_names().iter().zip(&image.planes) {
        match image.color {
            Color::Mono { .. } => line("S0", range(plane)),
            Color::Rgb | Color::Bands(_) | Color::Responses(_) => {
                line(&format!("S0.{channel}"), range(plane));
            }
        }
    }
    if image.components == 4 {
        polarization(image, &mut line);
    }
    line(
        "variance",
        match &image.variance {
            None => "not stored".to_owned(),
            Some(variance) => relative_error(image, variance),
        },
    );
    for layer in &image.layers {
        for (name, plane) in layer.kind.channel_names().zip(&layer.planes) {
            line(&name, range(plane));
        }
    }
    for (key, value) in &image.metadata {
        line(key, value.replace('\n', "\n               "));
    }
    text
}

fn range(plane: &[f32]) -> String {
    let finite: Vec<f32> = plane.iter().copied().filter(|value| value.is_finite()).collect();
    let odd = plane.len() - finite.len();
    let note = if odd > 0 { format!("; {odd} values are not finite") } else { String::new() };
    if finite.is_empty() {
        return format!("no finite values{note}");
    }
    let min = finite.iter().copied().fold(f32::INFINITY, f32::min);
    let max = finite.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    format!("min {min:.6}, mean {:.6}, max {max:.6}{note}", mean(&finite))
}

fn mean(values: &[f32]) -> f64 {
    values.iter().map(|&value| f64::from(value)).sum::<f64>() / values.len().max(1) as f64
}

fn polarization(image: &StokesImage, line: &mut impl FnMut(&str, String)) {
    let pixels = image.width * image.height;
    let degrees: Vec<f32> = (0..pixels)
        .map(|pixel| stokes_at(image, pixel))
        .filter(|stokes| stokes[0] > 0.0 && stokes.iter().all(|value| value.is_finite()))
        .map(dop)
        .collect();
    let lit = degrees.len();
    let largest = degrees.iter().copied().fold(0.0, f32::max);
    line("DoP", format!("mean {:.4} over {lit} lit pixels, max {largest:.4}", mean(&degrees)));
    let violations = (0..pixels)
        .filter(|&pixel| (0..image.color.channels()).any(|c| is_unphysical(image, pixel, c)))
        .count();
    let share = 100.0 * violations as f64 / pixels.max(1) as f64;
    line("unphysical", format!("{violations} pixels ({share:.2}%) have P > S0 in some channel"));
}

fn is_unphysical(image: &StokesImage, pixel: usize, channel: usize) -> bool {
    let [s0, s1, s2, s3] = [0, 1, 2, 3].map(|i| image.plane(i, channel)[pixel]);
    hypot(hypot(s1, s2), s3) > s0 * (1.0 + ROUNDING)
}

/// The root of the summed variance of S0 over its sum: the error of an average pixel.
fn relative_error(image: &StokesImage, variance: &[Vec<f32>]) -> String {
    let channels = image.color.channels();
    let sum = |planes: &[Vec<f32>]| -> f64 {
        planes.iter().take(channels).map(|plane| mean(plane)).sum::<f64>() / channels as f64
    };
    let error = sum(variance).sqrt() / sum(&image.planes);
    format!("stored; the rms error of S0 is {:.3}% of its mean", 100.0 * error)
}
