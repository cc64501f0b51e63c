//! Pictures that surfaces are painted with, and of what is around scenes, as they come: PNG, JPEG,
//! WebP, BMP, OpenEXR and Radiance. Values of the first four keep the width that their file has,
//! and color profiles are ignored, as glTF asks for.

mod encode;

use std::fmt;
use std::io::Cursor;
use std::sync::LazyLock;

use ::exr::meta::header::Header;
use ::exr::prelude as exr_files;
use image::{DynamicImage, ImageError, ImageFormat, ImageReader, Limits};

use super::{StokesImage, exr, rgbe};
use crate::math::elementary::pow;
use crate::math::text::listed;

/// Most columns and rows of a picture.
const SIDE_MAX: u32 = 1 << 15;
/// The colors of an OpenEXR file.
const RGB: [&str; 3] = ["R", "G", "B"];
/// The channels of polarized environments.
pub const STOKES_WANTED: &str = "a polarized environment has S0.R, S0.G and S0.B to S3.R, S3.G and \
                                 S3.B, one that is not R, G and B, or Y";
/// How to mend an OpenEXR file that is damaged.
const EXR_AGAIN: &str = "it may be cut off or damaged: write it again";
/// Most memory that the reading of one may take.
const BYTES_MAX: u64 = 1 << 32;

/// A picture in memory: rows from the top, each from the left.
#[derive(Clone, PartialEq)]
pub struct Texels {
    width: u32,
    height: u32,
    /// Values of a texel: grey, grey and alpha, red green and blue, or these and alpha.
    channels: usize,
    values: Values,
}

/// The values as the file has them.
#[derive(Clone, PartialEq)]
enum Values {
    /// From 0 to 255.
    Bytes(Vec<u8>),
    /// From 0 to 65535.
    Words(Vec<u16>),
    /// Linear.
    Floats(Vec<f32>),
}

/// What the values of a picture are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Coding {
    /// Integers are encoded as sRGB is (IEC 61966-2-1), but for alpha; floats are linear.
    Srgb,
    /// All are linear.
    Linear,
}

impl fmt::Debug for Texels {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { width, height, channels, .. } = self;
        write!(f, "Texels {width} x {height} x {channels}")
    }
}

/// What the bytes of two formats start with.
const OPENEXR: &[u8] = b"\x76\x2f\x31\x01";
const RADIANCE: &[u8] = b"#?R";

/// Formats that are known by name and not read, with the bytes that they start with.
const UNREAD: [(&[u8], &str); 11] = [
    (b"II*\0", "TIFF"),
    (b"MM\0*", "TIFF"),
    (b"8BPS", "Photoshop"),
    (b"\0\0\0\x0cJXL ", "JPEG XL"),
    (b"\xff\x0a", "JPEG XL"),
    (b"\0\0\0\x0cjP  ", "JPEG 2000"),
    (b"\xabKTX 20", "KTX2, which is mostly Basis Universal"),
    (b"\xabKTX 11", "KTX"),
    (b"sB", "Basis Universal"),
    (b"DDS ", "DDS"),
    (b"GIF8", "GIF"),
];

impl Texels {
    /// Decodes the bytes of a file, whose format they tell.
    ///
    /// # Errors
    /// What is wrong, and the way to mend it.
    pub fn decode(bytes: &[u8]) -> Result<Self, [String; 2]> {
        const FORMATS: &str = "save it as PNG, JPEG, WebP, BMP, OpenEXR or Radiance HDR";
        let told = |problem: String| [problem, FORMATS.to_owned()];
        if bytes.starts_with(RADIANCE) {
            let told = |problem| [format!("is a Radiance picture, and {problem}"), FORMATS.into()];
            let picture = rgbe::decode(bytes).map_err(told)?;
            return Ok(Self::of_colors(picture.width, picture.pixels));
        }
        if bytes.starts_with(OPENEXR) {
            return Self::decode_exr(bytes);
        }
        let format = match image::guess_format(bytes) {
            Ok(
                format @ (ImageFormat::Bmp
                | ImageFormat::Png
                | ImageFormat::Jpeg
                | ImageFormat::WebP),
            ) => format,
            _ if bytes.is_empty() => return Err(told("is empty".to_owned())),
            _ => {
                let known = UNREAD.iter().find(|(start, _)| bytes.starts_with(start));
                let problem = match known {
                    Some((_, name)) => format!("is {name}, which is not read"),
                    None => "is of a format that is not known".to_owned(),
                };
                return Err(told(problem));
            }
        };
        let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
        let mut limits = Limits::no_limits();
        limits.max_image_width = Some(SIDE_MAX);
        limits.max_image_height = Some(SIDE_MAX);
        limits.max_alloc = Some(BYTES_MAX);
        reader.limits(limits);
        reader.decode().map(Self::of_image).map_err(|error| undecoded(format, &error))
    }

    fn of_image(image: DynamicImage) -> Self {
        let (width, height) = (image.width(), image.height());
        let (channels, values) = match image {
            DynamicImage::ImageLuma8(it) => (1, Values::Bytes(it.into_raw())),
            DynamicImage::ImageLumaA8(it) => (2, Values::Bytes(it.into_raw())),
            DynamicImage::ImageRgb8(it) => (3, Values::Bytes(it.into_raw())),
            DynamicImage::ImageRgba8(it) => (4, Values::Bytes(it.into_raw())),
            DynamicImage::ImageLuma16(it) => (1, Values::Words(it.into_raw())),
            DynamicImage::ImageLumaA16(it) => (2, Values::Words(it.into_raw())),
            DynamicImage::ImageRgb16(it) => (3, Values::Words(it.into_raw())),
            DynamicImage::ImageRgba16(it) => (4, Values::Words(it.into_raw())),
            other => (4, Values::Floats(other.into_rgba32f().into_raw())),
        };
        Self { width, height, channels, values }
    }

    /// Linear ones of red, green and blue, in rows of a width.
    pub fn of_colors(width: usize, colors: Vec<[f32; 3]>) -> Self {
        let height = (colors.len() / width) as u32;
        let values = Values::Floats(colors.into_flattened());
        Self { width: width as u32, height, channels: 3, values }
    }

    /// Bytes of red, green, blue and alpha, in rows of a width.
    pub fn of_bytes(width: u32, texels: Vec<[u8; 4]>) -> Self {
        let height = texels.len() as u32 / width;
        Self { width, height, channels: 4, values: Values::Bytes(texels.into_flattened()) }
    }

    /// The Stokes vectors of the bytes of a file, if they are OpenEXR with those, as films are
    /// written.
    ///
    /// # Errors
    /// When they cannot be read: what is wrong, and the way to mend it.
    pub fn stokes_vectors(bytes: &[u8]) -> Result<Option<StokesImage>, [String; 2]> {
        if !bytes.starts_with(OPENEXR) {
            return Ok(None);
        }
        // What is wrong with the header is told by who reads the file as a picture.
        let names = exr::check_header(bytes).map(|meta| names_of(&meta.headers));
        let names = names.unwrap_or_default().concat();
        let is_of_polarization = |name: &String| {
            let name = name.rsplit_once('.').map_or(name.as_str(), |(layer, _)| layer);
            ["S1", "S2", "S3"].contains(&name)
        };
        if !names.iter().any(is_of_polarization) {
            return Ok(None);
        }
        exr::decode(bytes).map(Some).map_err(|error| {
            let wanted = (0..4).flat_map(|s| RGB.map(|color| format!("S{s}.{color}")));
            let missing: Vec<String> = wanted.filter(|name| !names.contains(name)).collect();
            let (problem, remedy) = match missing.len() {
                0 => (format!("cannot be read: {error}"), EXR_AGAIN),
                12 => (format!("has the channels {}", listed(&names)), STOKES_WANTED),
                _ => (format!("lacks {}", listed(&missing)), STOKES_WANTED),
            };
            [format!("is an OpenEXR file of Stokes vectors that {problem}"), remedy.to_owned()]
        })
    }

    /// Red, green and blue, or a gray `Y`, with or without alpha, of the first part that has them.
    fn decode_exr(bytes: &[u8]) -> Result<Self, [String; 2]> {
        let unread = |error: String| {
            [format!("is an OpenEXR file that cannot be read: {error}"), EXR_AGAIN.to_owned()]
        };
        let meta = exr::check_header(bytes).map_err(unread)?;
        let parts = names_of(&meta.headers);
        let has = |part: &[String], name: &str| part.iter().any(|own| own == name);
        // A `Y` beside chroma is not all of a color.
        let is_gray = |part: &Vec<String>| has(part, "Y") && !has(part, "RY") && !has(part, "BY");
        let read = if parts.iter().any(|part| RGB.iter().all(|color| has(part, color))) {
            Self::decode_exr_of_colors(bytes)
        } else if parts.iter().any(is_gray) {
            Self::decode_exr_of_gray(bytes)
        } else {
            let problem =
                format!("is an OpenEXR file with the channels {}", listed(parts.concat()));
            let remedy = "save it with the channels R, G and B, or with one, Y; A may be beside \
                          them";
            return Err([problem, remedy.to_owned()]);
        };
        read.map_err(|error| unread(error.to_string()))
    }

    /// Room for the linear texels of a picture.
    fn blank(size: exr_files::Vec2<usize>, channels: usize) -> Self {
        let values = Values::Floats(vec![0.0; channels * size.width() * size.height()]);
        Self { width: size.width() as u32, height: size.height() as u32, channels, values }
    }

    /// Puts as many of some linear values into a place as its texel has.
    fn put(&mut self, place: exr_files::Vec2<usize>, texel: &[f32]) {
        let count = self.channels;
        let at = count * (place.y() * self.width as usize + place.x());
        if let Values::Floats(values) = &mut self.values {
            values[at..at + count].copy_from_slice(&texel[..count]);
        }
    }

    fn decode_exr_of_colors(bytes: &[u8]) -> Result<Self, exr_files::Error> {
        use exr_files::{ReadChannels, ReadLayers};
        let image = exr_files::read()
            .no_deep_data()
            .largest_resolution_level()
            .rgba_channels(
                |size, (_, _, _, alpha)| Self::blank(size, if alpha.is_some() { 4 } else { 3 }),
                |texels, place, (red, green, blue, alpha): (f32, f32, f32, f32)| {
                    texels.put(place, &[red, green, blue, alpha]);
                },
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))?;
        Ok(image.layer_data.channel_data.pixels)
    }

    fn decode_exr_of_gray(bytes: &[u8]) -> Result<Self, exr_files::Error> {
        use exr_files::{ReadChannels, ReadLayers, ReadSpecificChannel};
        let image = exr_files::read()
            .no_deep_data()
            .largest_resolution_level()
            .specific_channels()
            .required("Y")
            .optional("A", 1.0)
            .collect_pixels(
                |size, (_, alpha)| Self::blank(size, if alpha.is_some() { 2 } else { 1 }),
                |texels, place, (gray, alpha): (f32, f32)| texels.put(place, &[gray, alpha]),
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))?;
        Ok(image.layer_data.channel_data.pixels)
    }

    /// Columns and rows; none is zero.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Whether texels have an alpha of their own.
    pub fn has_alpha(&self) -> bool {
        self.channels.is_multiple_of(2)
    }

    /// Linear red, green, blue and alpha of the texel in a column and a row, which there are.
    #[inline]
    pub fn at(&self, column: u32, row: u32, coding: Coding) -> [f32; 4] {
        let first = self.channels * (row as usize * self.width as usize + column as usize);
        let all = first..first + self.channels;
        match (&self.values, coding) {
            (Values::Floats(of), _) => texel(&of[all], |it| it, |it| it),
            (Values::Bytes(of), Coding::Srgb) => {
                let decoded = &*DECODED;
                texel(&of[all], |it| decoded[usize::from(it)], |it| f32::from(it) / 255.0)
            }
            (Values::Bytes(of), Coding::Linear) => {
                let linear = |it| f32::from(it) / 255.0;
                texel(&of[all], linear, linear)
            }
            (Values::Words(of), Coding::Srgb) => {
                let color = |it| decoded(f64::from(it) / 65535.0);
                texel(&of[all], color, |it| f32::from(it) / 65535.0)
            }
            (Values::Words(of), Coding::Linear) => {
                let linear = |it| f32::from(it) / 65535.0;
                texel(&of[all], linear, linear)
            }
        }
    }

    /// The first value that is no amount of light, in words: what it is, in which column and row.
    pub fn find_unusable(&self) -> Option<String> {
        let Values::Floats(values) = &self.values else { return None };
        let (at, what) =
            values.iter().enumerate().find_map(|(at, value)| Some((at, flaw(*value)?)))?;
        let texel = at / self.channels;
        let [column, row] = [texel % self.width as usize, texel / self.width as usize];
        Some(format!("has {what} in column {column}, row {row}"))
    }
}

/// Red, green, blue and alpha of a texel's values: of grey, grey and alpha, colors, or these and
/// alpha.
#[inline(always)]
fn texel<T: Copy>(values: &[T], color: impl Fn(T) -> f32, alpha: impl Fn(T) -> f32) -> [f32; 4] {
    match *values {
        [red, green, blue] => [color(red), color(green), color(blue), 1.0],
        [red, green, blue, a] => [color(red), color(green), color(blue), alpha(a)],
        [grey, a] => [color(grey), color(grey), color(grey), alpha(a)],
        [grey, ..] => [color(grey), color(grey), color(grey), 1.0],
        [] => [0.0; 4],
    }
}

/// What is wrong with an amount of light, if anything is.
pub fn flaw(value: f32) -> Option<&'static str> {
    match value {
        _ if value.is_nan() => Some("a value that is not a number"),
        _ if value.is_infinite() => Some("an infinite value"),
        _ if value < 0.0 => Some("a negative value"),
        _ => None,
    }
}

/// The channels of every part of an OpenEXR file.
fn names_of(headers: &[Header]) -> Vec<Vec<String>> {
    let of_part = |header: &Header| {
        header.channels.list.iter().map(|channel| channel.name.to_string()).collect()
    };
    headers.iter().map(of_part).collect()
}

/// Why a PNG, JPEG or WebP cannot be read, and the way to mend it.
fn undecoded(format: ImageFormat, error: &ImageError) -> [String; 2] {
    let name = match format {
        ImageFormat::Png => "PNG",
        ImageFormat::Jpeg => "JPEG",
        ImageFormat::Bmp => "BMP",
        _ => "WebP",
    };
    // Words of others may go over several lines.
    let error_text = error.to_string();
    let words: Vec<&str> = error_text.split_whitespace().collect();
    let remedy = match error {
        ImageError::Limits(_) => format!("save it {SIDE_MAX} pixels wide and high at most"),
        _ => "it may be cut off or damaged: save it again".to_owned(),
    };
    [format!("is a {name} that cannot be read: {}", words.join(" ")), remedy]
}

/// What bytes of sRGB stand for.
static DECODED: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| decoded(byte as f64 / 255.0)));

/// The linear value of an sRGB one, both from 0 to 1.
fn decoded(value: f64) -> f32 {
    let linear = match value <= 0.04045 {
        true => value / 12.92,
        false => pow((value + 0.055) / 1.055, 2.4),
    };
    linear as f32
}

#[cfg(test)]
mod tests {
    use image::{ImageBuffer, Luma, LumaA, Rgb, Rgba};

    use super::*;

    fn written(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn texels_are_where_they_were_written_in_every_width() {
        let bytes = ImageBuffer::from_fn(3, 2, |x, y| Rgb([x as u8, y as u8, 255]));
        let words = ImageBuffer::from_fn(3, 2, |x, y| Rgba([x as u16, y as u16, 65535, 32768]));
        for format in [ImageFormat::Png, ImageFormat::WebP, ImageFormat::Bmp] {
            let texels = Texels::decode(&written(&bytes.clone().into(), format)).unwrap();
            assert_eq!((texels.size(), texels.has_alpha()), ([3, 2], false));
            assert_eq!(texels.at(2, 1, Coding::Linear), [2.0 / 255.0, 1.0 / 255.0, 1.0, 1.0]);
        }
        let texels = Texels::decode(&written(&words.into(), ImageFormat::Png)).unwrap();
        let alpha = 32768.0 / 65535.0;
        assert_eq!(texels.at(2, 1, Coding::Linear), [2.0 / 65535.0, 1.0 / 65535.0, 1.0, alpha]);
        assert_eq!(texels.at(2, 1, Coding::Srgb)[3], alpha);
    }

    #[test]
    fn grey_is_all_three_and_jpeg_is_near() {
        let grey = ImageBuffer::from_pixel(16, 16, Luma([200_u8]));
        for format in [ImageFormat::Png, ImageFormat::Jpeg] {
            let texels = Texels::decode(&written(&grey.clone().into(), format)).unwrap();
            let [red, green, blue, alpha] = texels.at(7, 9, Coding::Linear);
            assert!((red - 200.0 / 255.0).abs() < 0.01, "{format:?}: {red}");
            assert_eq!([green, blue, alpha], [red, red, 1.0]);
        }
        let faint = ImageBuffer::from_pixel(1, 1, LumaA([10_u8, 51]));
        let texels = Texels::decode(&written(&faint.into(), ImageFormat::Png)).unwrap();
        assert!(texels.has_alpha());
        assert_eq!(texels.at(0, 0, Coding::Linear)[3], 0.2);
    }

    #[test]
    fn srgb_is_decoded_by_its_inverse() {
        // IEC 61966-2-1 the other way round.
        let encoded = |linear: f64| match linear <= 0.003_130_8 {
            true => 12.92 * linear,
            false => 1.055 * linear.powf(1.0 / 2.4) - 0.055,
        };
        for byte in 0..=255_u8 {
            let linear = f64::from(DECODED[usize::from(byte)]);
            let error = (255.0 * encoded(linear) - f64::from(byte)).abs();
            assert!(error < 1e-4, "{byte}: {linear}");
        }
        assert_eq!([DECODED[0], DECODED[255]], [0.0, 1.0]);
    }

    #[test]
    fn what_is_not_read_is_told_by_name() {
        for (start, name) in UNREAD {
            let [problem, remedy] = Texels::decode(&[start, &[0; 40]].concat()).unwrap_err();
            assert!(problem.contains(name) && remedy.contains("PNG"), "{problem}");
        }
        let cut_off =
            written(&ImageBuffer::from_pixel(9, 9, Luma([1_u8])).into(), ImageFormat::Png);
        for bytes in [&[][..], b"text", &cut_off[..cut_off.len() / 2], b"\x76\x2f\x31\x01"] {
            assert!(Texels::decode(bytes).is_err());
        }
    }
}
