//! An image as those see it who write it: row by row, so that it need not be in memory as a whole
//! beside whatever it is made from.

use std::borrow::Cow;

use super::StokesImage;
use super::layers::LayerKind;
use crate::spectrum::Color;

/// What an image consists of.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// What the channels stand for.
    pub color: Color,
    /// Number of Stokes components: 1 (intensity only) or 4.
    pub components: usize,
    /// Whether the squared standard error of every value is known.
    pub has_variance: bool,
    /// What is known of pixels besides their light.
    pub layers: Vec<LayerKind>,
}

impl Frame {
    /// Values of a pixel, without variances.
    pub fn planes(&self) -> usize {
        self.components * self.color.channels()
    }

    /// Planes of values and, if they are known, of variances.
    pub fn planes_of_light(&self) -> usize {
        self.planes() * if self.has_variance { 2 } else { 1 }
    }

    /// Numbers of a row: its values, their variances if they are known, and its layers.
    pub fn numbers_of_row(&self) -> usize {
        let of_layers: usize = self.layers.iter().map(|kind| kind.channels().len()).sum();
        (self.planes_of_light() + of_layers) * self.width
    }
}

/// Something of which the rows of an image can be had.
pub trait Rows: Sync {
    /// What the image consists of.
    fn frame(&self) -> Frame;

    /// What is known of its making, in the order in which it is shown.
    fn metadata(&self) -> &[(String, String)];

    /// Writes the numbers of row `y`, counted from the top, to `numbers`, which has room for
    /// [`Frame::numbers_of_row`]: plane by plane in the order of [`StokesImage::planes`], each from
    /// the left, then the variances likewise, then the channels of the layers.
    fn row(&self, y: usize, numbers: &mut [f32]);

    /// The whole image: its own planes if it has them, else new ones.
    fn whole(&self) -> Cow<'_, StokesImage>;

    /// Says what is wrong with an image that does not hold what its frame promises: only one whose
    /// planes are there can be so.
    fn fault(&self) -> Option<&'static str>;
}

/// Whether all values are zero.
pub fn is_black(image: &dyn Rows) -> bool {
    let frame = image.frame();
    let mut numbers = vec![0.0; frame.numbers_of_row()];
    let values = frame.planes() * frame.width;
    (0..frame.height).all(|y| {
        image.row(y, &mut numbers);
        numbers[..values].iter().all(|&value| value == 0.0)
    })
}
