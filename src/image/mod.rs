//! Floor 2: Stokes images, and the files, pictures and words they become. Nothing here renders.
//!
//! | module | holds |
//! |---|---|
//! | [`atomic`] | a file is written as a whole or not at all |
//! | [`exr`] | OpenEXR, which keeps everything |
//! | [`hdr`] | the paper's storage: a set of Radiance pictures |
//! | [`npy`] | NumPy arrays in |
//! | [`png`], [`picture`] | previews and pictures |
//! | [`visualize`], [`palette`] | maps of polarization with their legends |
//! | [`compare`] | how far apart two images are, and whether noise explains it |
//! | [`inspect`] | words about an image |

pub mod atomic;
pub mod compare;
pub mod error;
pub mod exr;
mod font;
pub mod hdr;
pub mod inspect;
mod legend;
pub mod npy;
pub mod palette;
pub mod picture;
pub mod png;
mod rgbe;
mod stokes_image;
pub mod visualize;

use std::path::Path;

pub use error::OutputError;
pub use stokes_image::StokesImage;

const SAVABLE: &str = ".exr, .hdr, .png";

/// Writes an image in the format that the extension names: `.exr` (everything), `.hdr` (the
/// paper's set of files) or `.png` (a preview of S0 at exposure 0).
pub fn save(image: &StokesImage, path: &Path) -> Result<(), OutputError> {
    match extension(path).as_str() {
        "exr" => exr::write(image, path),
        "hdr" => hdr::write(image, path),
        "png" => png::write_preview(image, path, 0.0),
        _ => Err(OutputError::Extension { path: path.to_owned(), known: SAVABLE }),
    }
}

/// Reads an image in the format that the extension names: `.exr`, `.hdr` or `.npy`. A file named
/// `stokes.npy` with a `stderr.npy` beside it gets its variance from there.
pub fn load(path: &Path) -> Result<StokesImage, OutputError> {
    let known = ".exr, .hdr, .npy (a PNG preview does not hold what was rendered)";
    match extension(path).as_str() {
        "exr" => exr::read(path),
        "hdr" => hdr::read(path),
        "npy" => {
            let stderr = path.with_file_name("stderr.npy");
            match path.file_name().is_some_and(|name| name == "stokes.npy") && stderr.exists() {
                true => npy::read_npy_with_stderr(path, &stderr),
                false => npy::read_npy(path),
            }
        }
        _ => Err(OutputError::Extension { path: path.to_owned(), known }),
    }
}

/// Checks before a long render that [`save`] knows the extension and can write there.
pub fn check_savable(path: &Path) -> Result<(), OutputError> {
    match extension(path).as_str() {
        "exr" | "png" => atomic::probe_writable(path),
        "hdr" => (0..4).try_for_each(|i| atomic::probe_writable(&hdr::component_path(path, i))),
        _ => Err(OutputError::Extension { path: path.to_owned(), known: SAVABLE }),
    }
}

/// The extension in lower case, without the dot; empty if there is none.
pub fn extension(path: &Path) -> String {
    path.extension().map(|part| part.to_string_lossy().to_lowercase()).unwrap_or_default()
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
    Ok(())
}
