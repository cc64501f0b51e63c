//! NumPy arrays as monochromatic Stokes images: the form in which reference renders are kept.

use std::path::Path;

use super::error::OutputError;
use super::exr::WAVELENGTH_UNSTATED_NM;
use super::source;
use crate::image::StokesImage;
use crate::spectrum::Color;

const FORMAT: &str = "NumPy";

/// Reads an array by [`read_npy`]. A file named `stokes.npy` with a `stderr.npy` beside it gets its
/// variance from there.
pub fn read(path: &Path) -> Result<StokesImage, OutputError> {
    let stderr = path.with_file_name("stderr.npy");
    if path.file_name().is_some_and(|name| name == "stokes.npy") && stderr.exists() {
        return read_npy_with_stderr(path, &stderr);
    }
    read_npy(path)
}

/// Reads a little-endian float32 array in C order of shape (height, width, 4), or (height, width)
/// and (height, width, 1) for intensity alone. The wavelength, which the file does not know, is
/// taken as 550 nm.
pub fn read_npy(path: &Path) -> Result<StokesImage, OutputError> {
    let bytes = source::read(path)?;
    decode(&bytes).map_err(|reason| OutputError::malformed(path, FORMAT, reason))
}

/// Reads a Stokes array with the standard errors of its values from a second array.
pub fn read_npy_with_stderr(path: &Path, stderr: &Path) -> Result<StokesImage, OutputError> {
    let mut image = read_npy(path)?;
    let errors = read_npy(stderr)?;
    let size = |image: &StokesImage| (image.width, image.height, image.components);
    if size(&image) != size(&errors) {
        let reason = format!("its shape is not that of {}", path.display());
        return Err(OutputError::malformed(stderr, FORMAT, reason));
    }
    let squared = |plane: Vec<f32>| plane.into_iter().map(|error| error * error).collect();
    image.variance = Some(errors.planes.into_iter().map(squared).collect());
    Ok(image)
}

fn decode(bytes: &[u8]) -> Result<StokesImage, String> {
    let (header, data) = split(bytes).ok_or("it is no .npy file or is cut short")?;
    let field = |key: &str| {
        let rest = &header[header.find(&format!("'{key}':"))? + key.len() + 3..];
        Some(rest.trim_start())
    };
    if !field("descr").is_some_and(|value| value.starts_with("'<f4'")) {
        return Err("its type is not little-endian float32 ('<f4')".to_owned());
    }
    if !field("fortran_order").is_some_and(|value| value.starts_with("False")) {
        return Err("it is not in C order".to_owned());
    }
    let shape = field("shape").and_then(parse_shape).ok_or("its shape is not readable")?;
    let (height, width, components) = match *shape.as_slice() {
        [height, width] => (height, width, 1),
        [height, width, components @ (1 | 4)] => (height, width, components),
        _ => return Err(format!("its shape {shape:?} is not (height, width, 4)")),
    };
    let values = height.checked_mul(width).and_then(|pixels| pixels.checked_mul(components));
    let length = values.and_then(|values| values.checked_mul(4));
    if length != Some(data.len()) || data.is_empty() {
        return Err(format!("its shape {shape:?} does not match its {} bytes", data.len()));
    }
    let color = Color::Mono { wavelength_nm: WAVELENGTH_UNSTATED_NM };
    let mut image = StokesImage::new(width, height, color, components);
    let (words, _) = data.as_chunks::<4>();
    for (pixel, stokes) in words.chunks_exact(components).enumerate() {
        for (component, &word) in stokes.iter().enumerate() {
            image.planes[component][pixel] = f32::from_le_bytes(word);
        }
    }
    Ok(image)
}

/// The header's text and the data after it.
fn split(bytes: &[u8]) -> Option<(&str, &[u8])> {
    let rest = bytes.strip_prefix(b"\x93NUMPY")?;
    let (length, rest) = match *rest {
        [1, _, a, b, ..] => (usize::from(u16::from_le_bytes([a, b])), &rest[4..]),
        [2 | 3, _, a, b, c, d, ..] => (u32::from_le_bytes([a, b, c, d]) as usize, &rest[6..]),
        _ => return None,
    };
    let (header, data) = rest.split_at_checked(length)?;
    Some((std::str::from_utf8(header).ok()?, data))
}

fn parse_shape(text: &str) -> Option<Vec<usize>> {
    let inside = text.strip_prefix('(')?.split(')').next()?;
    let numbers = inside.split(',').map(str::trim).filter(|number| !number.is_empty());
    numbers.map(|number| number.parse().ok()).collect()
}
