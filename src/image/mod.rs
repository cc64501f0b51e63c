//! Floor 2: Stokes images, and the files, pictures and words they become. Nothing here renders.
//!
//! | module | holds |
//! |---|---|
//! | [`rows`] | an image as whoever writes it sees it, row by row |
//! | [`atomic`] | a file is written as a whole or not at all |
//! | [`mod@format`] | the list of formats |
//! | [`exr`] | OpenEXR, which keeps everything |
//! | [`hdr`] | the paper's storage: a set of Radiance pictures |
//! | [`npy`] | NumPy arrays in |
//! | [`png`], [`picture`] | previews and pictures |
//! | [`texels`] | pictures that surfaces are painted with, in |
//! | [`visualize`], [`palette`] | maps of polarization with their legends |
//! | [`analyzed`] | what analyzers let pass |
//! | [`live`] | what is shown of a render on its way |
//! | [`mosaic`] | what cameras of polarization record |
//! | [`page`] | what pages have in common |
//! | [`view`] | a page to look at images in |
//! | [`compare`] | how far apart two images are, and whether noise explains it |
//! | [`inspect`] | words about an image |

pub mod analyzed;
pub mod atomic;
pub mod compare;
pub mod cut;
pub mod error;
pub mod exr;
mod font;
pub mod format;
pub mod hdr;
pub mod inspect;
pub mod layers;
mod legend;
pub mod live;
pub mod mosaic;
pub mod npy;
pub mod page;
pub mod palette;
pub mod picture;
pub mod png;
mod rgbe;
pub mod rows;
mod source;
mod stokes_image;
pub mod texels;
pub mod view;
pub mod visualize;

use std::path::{Path, PathBuf};

pub use atomic::folder_of;
pub use error::OutputError;
pub use format::extension;
pub use source::read_bytes;
pub use stokes_image::StokesImage;

use format::named_by;
use layers::Layer;
use rows::Rows;

/// Writes an image in the format that the extension names ([`format::FORMATS`]).
pub fn save(image: &dyn Rows, path: &Path) -> Result<(), OutputError> {
    named_by(path, "written", |format| format.write)?(image, path)
}

/// The files that [`save`] would write.
pub fn files_of(path: &Path) -> Result<Vec<PathBuf>, OutputError> {
    named_by(path, "written", |format| format.write.map(|_| (format.files)(path)))
}

/// Reads an image in the format that the extension names ([`format::FORMATS`]).
pub fn load(path: &Path) -> Result<StokesImage, OutputError> {
    named_by(path, "read", |format| format.read)?(path)
}

/// Checks before a long render that [`save`] knows the extension and can write there.
pub fn check_savable(path: &Path) -> Result<(), OutputError> {
    files_of(path)?.iter().try_for_each(|file| atomic::probe_writable(file))
}

/// Refuses to write an image whose planes are not what its size and color promise.
fn check_image(image: &StokesImage, path: &Path) -> Result<(), OutputError> {
    check_shape(image).map_err(|reason| OutputError::unwritable(path, reason))
}

/// Says what is wrong with an image whose planes are not what its size and color promise.
fn check_shape(image: &StokesImage) -> Result<(), &'static str> {
    let planes = image.components.saturating_mul(image.color.channels());
    let pixels = image.width.saturating_mul(image.height);
    let whole =
        |list: &[Vec<f32>]| list.len() == planes && list.iter().all(|plane| plane.len() == pixels);
    if pixels == 0 {
        return Err("the image has no pixels");
    }
    if !matches!(image.components, 1 | 4) {
        return Err("an image has 1 or 4 Stokes components");
    }
    if !whole(&image.planes) || !image.variance.as_deref().is_none_or(whole) {
        return Err("the planes of the image do not match its size");
    }
    let fits = |layer: &Layer| {
        let is_whole = layer.planes.iter().all(|plane| plane.len() == pixels);
        layer.planes.len() == layer.kind.channels().len() && is_whole
    };
    if !image.layers.iter().all(fits) {
        return Err("the layers of the image do not match its size");
    }
    Ok(())
}
