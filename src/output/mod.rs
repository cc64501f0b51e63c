//! Floor 8: files, pictures and reports.
//!
//! Everything takes a [`StokesImage`] and gives a file, a picture or words; nothing here renders.
//!
//! | module | holds |
//! |---|---|
//! | [`atomic`] | a file is written as a whole or not at all |
//! | [`exr`] | OpenEXR, which keeps everything |
//! | [`png`], [`picture`] | previews and pictures |

pub mod atomic;
pub mod error;
pub mod exr;
pub mod palette;
pub mod picture;
pub mod png;

use std::path::Path;

pub use error::OutputError;

use crate::film::image::StokesImage;

/// Refuses an image whose planes are not what its size and color promise.
fn check_image(image: &StokesImage, path: &Path) -> Result<(), OutputError> {
    let planes = image.components * image.color.channels();
    let pixels = image.width.saturating_mul(image.height);
    let whole =
        |list: &[Vec<f32>]| list.len() == planes && list.iter().all(|plane| plane.len() == pixels);
    if pixels == 0 {
        return Err(OutputError::unwritable(path, "the image has no pixels"));
    }
    if !matches!(image.components, 1 | 4) {
        return Err(OutputError::unwritable(path, "an image has 1 or 4 Stokes components"));
    }
    if !whole(&image.planes) || !image.variance.as_deref().is_none_or(whole) {
        return Err(OutputError::unwritable(path, "its planes do not match its size"));
    }
    Ok(())
}
