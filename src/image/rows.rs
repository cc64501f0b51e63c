//! An image as those see it who write it: row by row, so that it need not be in memory as a whole
//! beside whatever it is made from.

use std::borrow::Cow;

use super::StokesImage;
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
}

impl Frame {
    /// Values of a pixel, without variances.
    pub fn planes(&self) -> usize {
        self.components * self.color.channels()
    }

    /// Numbers of a row: its values, and their variances if they are known.
    pub fn numbers_of_row(&self) -> usize {
        self.planes() * self.width * if self.has_variance { 2 } else { 1 }
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
    /// the left, then the variances likewise.
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
