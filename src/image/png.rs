//! PNG: previews of the intensity, and the pictures of the visualizations.

use std::path::Path;

use super::error::OutputError;
use super::mosaic::RawImage;
use super::palette::encode_srgb;
use super::picture::Picture;
use super::{atomic, check_image};
use crate::image::StokesImage;
use crate::math::elementary::{exp2, log2};

/// S0 as a picture: linear values times two to the power `exposure_ev`, clipped, sRGB encoded.
/// Monochromatic images are grey, and bands in color where they tell it; the mean of others, and of
/// responses, is grey; what is not a number is black.
pub fn preview(image: &StokesImage, exposure_ev: f32) -> Picture {
    let image = image.shown();
    let gain = exp2(exposure_ev);
    let channels = image.color.channels();
    let pixels = (0..image.width * image.height)
        .map(|pixel| {
            [0, 1, 2].map(|i| encode_srgb(gain * image.plane(0, i.min(channels - 1))[pixel]))
        })
        .collect();
    Picture { width: image.width, height: image.height, pixels }
}

/// Exposure of a preview, in whole stops: 0, unless almost all of it would be black or white then.
/// Lights in candela and lux are, in watts, hundreds of times darker than lamps that are stated in
/// these.
pub fn exposure(image: &StokesImage) -> f32 {
    const DARK: f32 = 0.02;
    const BRIGHT: f32 = 1.0;
    const GOAL: f32 = 0.8;
    let image = image.shown();
    let channels = image.color.channels();
    let brightest = |pixel: usize| {
        (0..channels).map(|channel| image.plane(0, channel)[pixel]).fold(0.0, f32::max)
    };
    let values = (0..image.width * image.height).map(brightest);
    let mut values: Vec<f32> = values.filter(|value| value.is_finite()).collect();
    let Some(last) = values.len().checked_sub(1) else { return 0.0 };
    let mut of_share = |hundredths: usize| {
        *values.select_nth_unstable_by(last * hundredths / 100, f32::total_cmp).1
    };
    let (low, high) = (of_share(10), of_share(99));
    let is_off = (high > 0.0 && high < DARK) || low > BRIGHT;
    if is_off { log2(GOAL / high).floor() } else { 0.0 }
}

/// Writes the preview of an image.
pub fn write_preview(
    image: &StokesImage,
    path: &Path,
    exposure_ev: f32,
) -> Result<(), OutputError> {
    check_image(image, path)?;
    write(&preview(image, exposure_ev), path)
}

/// Writes a picture.
pub fn write(picture: &Picture, path: &Path) -> Result<(), OutputError> {
    let bytes = encode(picture).map_err(|error| OutputError::unwritable(path, error))?;
    atomic::write(path, &bytes)
}

/// Writes a raw image as it is: its numbers are those of the file.
pub fn write_raw(raw: &RawImage, path: &Path) -> Result<(), OutputError> {
    let bytes = encode_raw(raw).map_err(|error| OutputError::unwritable(path, error))?;
    atomic::write(path, &bytes)
}

fn encode_raw(raw: &RawImage) -> Result<Vec<u8>, ::png::EncodingError> {
    let size = |length: usize| u32::try_from(length).unwrap_or(u32::MAX);
    let mut bytes = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut bytes, size(raw.width), size(raw.height));
    encoder.set_color(::png::ColorType::Grayscale);
    encoder.add_text_chunk("Description".to_owned(), raw.description.clone())?;
    let data: Vec<u8> = match raw.bits {
        8 => raw.values.iter().map(|&value| value as u8).collect(),
        _ => raw.values.iter().flat_map(|value| value.to_be_bytes()).collect(),
    };
    let depth = if raw.bits == 8 { ::png::BitDepth::Eight } else { ::png::BitDepth::Sixteen };
    encoder.set_depth(depth);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&data)?;
    writer.finish()?;
    Ok(bytes)
}

/// A picture as the bytes of a file, with one grey channel if all of it is grey.
pub fn encode(picture: &Picture) -> Result<Vec<u8>, ::png::EncodingError> {
    let size = |length: usize| u32::try_from(length).unwrap_or(u32::MAX);
    let mut bytes = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut bytes, size(picture.width), size(picture.height));
    let grey = picture.pixels.iter().all(|[r, g, b]| r == g && g == b);
    let data: Vec<u8> = match grey {
        true => picture.pixels.iter().map(|pixel| pixel[0]).collect(),
        false => picture.pixels.as_flattened().to_vec(),
    };
    encoder.set_color(if grey { ::png::ColorType::Grayscale } else { ::png::ColorType::Rgb });
    encoder.set_depth(::png::BitDepth::Eight);
    encoder.set_source_srgb(::png::SrgbRenderingIntent::RelativeColorimetric);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&data)?;
    writer.finish()?;
    Ok(bytes)
}
