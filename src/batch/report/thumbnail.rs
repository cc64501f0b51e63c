//! Small copies of images, in a byte a value.
//!
//! A pixel of a copy is the mean light of the pixels that it stands for. S0 is stored by channel as
//! sRGB codes of its share of [`Thumbnail::white`]; polarization, of luminance alone, as degree,
//! angle and ellipticity, in which a byte tells weak polarization from none.

use std::f32::consts::{FRAC_PI_4, PI};

use serde::Serialize;

use crate::image::StokesImage;
use crate::image::palette::encode_srgb;
use crate::image::visualize::{View, aolp, dop, range_of, signed_range, stokes_at};
use crate::math::elementary::{atan2, hypot};

/// The code of an ellipticity of 0; those from 0 to twice this are -45 to 45 degrees.
const LINEAR: f32 = 127.0;
/// In place of an ellipticity, where there is no light.
const NO_LIGHT: u8 = 255;

/// A small copy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Thumbnail {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// The intensity of the largest code: 99 percent of the values are below.
    pub white: f32,
    /// Where degrees end, and the colors of S1 to S3, if the image has them.
    #[serde(skip)]
    pub scales: Option<(f32, f32)>,
    /// Planes of codes: S0 by channel, then degree, angle and ellipticity if the image has them.
    #[serde(skip)]
    pub pixels: Vec<u8>,
}

impl Thumbnail {
    /// That of an image whose longer side is `edge` pixels at most, of the pixels that are finite.
    pub fn new(image: &StokesImage, is_finite: &[bool], edge: usize) -> Self {
        let small = shrunk(image, is_finite, edge);
        let channels = small.color.channels();
        let intensities = || small.planes[..channels].iter().flatten().copied();
        let white = range_of(intensities());
        let mut pixels: Vec<u8> = intensities().map(|value| encode_srgb(value / white)).collect();
        let is_polarized = small.components == 4;
        if is_polarized {
            let lights: Vec<[f32; 4]> =
                (0..small.width * small.height).map(|pixel| stokes_at(&small, pixel)).collect();
            for code in [degree_code, angle_code, ellipticity_code] {
                pixels.extend(lights.iter().map(|stokes| code(*stokes)));
            }
        }
        let scales = || (View::fitted(&small).degree_max, signed_range(&small));
        let scales = is_polarized.then(scales);
        Self { width: small.width, height: small.height, white, scales, pixels }
    }
}

/// The square of the code is the degree.
fn degree_code(stokes: [f32; 4]) -> u8 {
    (255.0 * dop(stokes).clamp(0.0, 1.0).sqrt()).round() as u8
}

/// 256 codes for 180 degrees.
fn angle_code(stokes: [f32; 4]) -> u8 {
    ((256.0 / PI * aolp(stokes)).round() as u32 % 256) as u8
}

fn ellipticity_code(stokes: [f32; 4]) -> u8 {
    if stokes[0] <= 0.0 {
        return NO_LIGHT;
    }
    let angle = 0.5 * atan2(stokes[3], hypot(stokes[1], stokes[2]));
    (LINEAR + LINEAR / FRAC_PI_4 * angle).round() as u8
}

/// The image in fewer pixels, none of which is not finite.
fn shrunk(image: &StokesImage, is_finite: &[bool], edge: usize) -> StokesImage {
    let long = image.width.max(image.height);
    let shrunk = |side: usize| match long <= edge {
        true => side,
        false => ((side * edge + long / 2) / long).max(1),
    };
    let (width, height) = (shrunk(image.width), shrunk(image.height));
    let mut small = StokesImage::new(width, height, image.color.clone(), image.components);
    for (plane, small) in image.planes.iter().zip(&mut small.planes) {
        for (at, value) in small.iter_mut().enumerate() {
            let columns = range(at % width, width, image.width);
            let rows = range(at / width, height, image.height);
            let pixels = rows.flat_map(|row| columns.clone().map(move |x| row * image.width + x));
            let mut count = 0_u32;
            let mut sum = 0.0;
            for pixel in pixels.filter(|pixel| is_finite[*pixel]) {
                count += 1;
                sum += f64::from(plane[pixel]);
            }
            *value = (sum / f64::from(count.max(1))) as f32;
        }
    }
    small
}

/// The pixels of a side for which one of a shorter side stands.
fn range(at: usize, short: usize, long: usize) -> std::ops::Range<usize> {
    at * long / short..(at + 1) * long / short
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Color;

    const MONO: Color = Color::Mono { wavelength_nm: 550.0 };

    fn thumbnail(image: &StokesImage, edge: usize) -> Thumbnail {
        let is_finite = super::super::figures::finite(image);
        Thumbnail::new(image, &is_finite, edge)
    }

    #[test]
    fn a_pixel_is_the_mean_light_of_those_it_stands_for() {
        let mut image = StokesImage::new(5, 3, MONO, 4);
        image.planes[0].fill(2.0);
        image.planes[0][0] = f32::NAN;
        // Crossed polarizations cancel.
        for (pixel, value) in image.planes[1].iter_mut().enumerate() {
            *value = if pixel % 2 == 0 { 1.0 } else { -1.0 };
        }
        let small = shrunk(&image, &super::super::figures::finite(&image), 1);
        assert_eq!((small.width, small.height), (1, 1));
        // 14 pixels: 7 of each.
        let means: Vec<f32> = small.planes.iter().map(|plane| plane[0]).collect();
        assert_eq!(means, [2.0, 0.0, 0.0, 0.0]);
        let small = thumbnail(&image, 4);
        assert_eq!((small.width, small.height, small.white), (4, 2, 2.0));
    }

    #[test]
    fn codes_are_of_degree_angle_and_ellipticity() {
        let codes = |stokes: [f32; 4]| {
            let mut image = StokesImage::new(1, 1, MONO, 4);
            for (plane, value) in image.planes.iter_mut().zip(stokes) {
                plane[0] = value;
            }
            thumbnail(&image, 64).pixels
        };
        assert_eq!(codes([0.5, 0.5, 0.0, 0.0]), [255, 255, 0, 127]);
        assert_eq!(codes([0.5, -0.005, 0.0, 0.0]), [255, 26, 128, 127]);
        assert_eq!(codes([0.5, 0.0, 0.5, 0.0]), [255, 255, 64, 127]);
        assert_eq!(codes([0.5, 0.0, 0.0, -0.5]), [255, 255, 0, 0]);
        assert_eq!(codes([0.5, 0.0, 0.0, 0.5]), [255, 255, 0, 254]);
        assert_eq!(codes([0.0; 4]), [0, 0, 0, 255]);
        assert_eq!(codes([f32::NAN, 1.0, 0.0, 0.0]), [0, 0, 0, 255]);
        // An angle just below 180 degrees is 0 again.
        assert_eq!(codes([1.0, 1.0, -1e-4, 0.0])[2], 0);
    }

    #[test]
    fn sides_are_as_long_as_they_may_be() {
        let of = |width, height| {
            let small = thumbnail(&StokesImage::new(width, height, Color::Rgb, 1), 64);
            assert_eq!(small.pixels.len(), 3 * small.width * small.height);
            (small.width, small.height, small.scales.is_some())
        };
        assert_eq!(of(64, 32), (64, 32, false));
        assert_eq!(of(1920, 1080), (64, 36, false));
        assert_eq!(of(1, 10_000), (1, 64, false));
    }
}
