//! Figures of a whole image.

use serde::Serialize;

use crate::image::StokesImage;

/// What an image is on average.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// The means of all Stokes components and, within these, channels over the pixels that are
    /// finite; nothing if none is.
    pub mean: Option<Vec<Vec<f64>>>,
    /// Pixels of which a value is not finite.
    pub not_finite: usize,
}

impl Figures {
    /// Those of an image, of which a pixel counts where it is finite.
    pub fn new(image: &StokesImage, is_finite: &[bool]) -> Self {
        let count = is_finite.iter().filter(|is| **is).count();
        let mean = |plane: &[f32]| {
            let finite = plane.iter().zip(is_finite).filter(|(_, is)| **is);
            finite.map(|(value, _)| f64::from(*value)).sum::<f64>() / count as f64
        };
        let channels = image.color.channels();
        let of_component = |planes: &[Vec<f32>]| planes.iter().map(|plane| mean(plane)).collect();
        let means = || image.planes.chunks(channels).map(of_component).collect();
        Self { mean: (count > 0).then(means), not_finite: is_finite.len() - count }
    }
}

/// Where all values of an image are numbers.
pub fn finite(image: &StokesImage) -> Vec<bool> {
    let mut is_finite = vec![true; image.width * image.height];
    for plane in &image.planes {
        for (is, value) in is_finite.iter_mut().zip(plane) {
            *is &= value.is_finite();
        }
    }
    is_finite
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Color;

    #[test]
    fn pixels_that_are_not_finite_do_not_count() {
        let mut image = StokesImage::new(2, 2, Color::Rgb, 1);
        image.planes = vec![vec![1.0, 2.0, 3.0, f32::NAN], vec![0.5; 4], vec![f32::MAX; 4]];
        image.planes[1][0] = f32::INFINITY;
        let figures = Figures::new(&image, &finite(&image));
        let max = f64::from(f32::MAX);
        assert_eq!(figures.mean, Some(vec![vec![2.5, 0.5, max]]));
        assert_eq!(figures.not_finite, 2);
        image.planes[0].fill(f32::NAN);
        assert_eq!(Figures::new(&image, &finite(&image)).mean, None);
    }
}
