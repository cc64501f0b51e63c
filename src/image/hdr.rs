//! The storage of the paper (section 4.2): a set of Radiance pictures.
//!
//! `NAME.S0.hdr` holds S0; `NAME.S1.hdr` to `NAME.S3.hdr` hold S' = S / S0 + 1 (eq. 14), which a
//! format without signs can say; where S0 is 0, S' is 1. An image of intensity alone is one file.
//!
//! The price is precision. A channel of S0 is off by at most 1/255 of the largest channel of its
//! pixel; S/S0 is off by at most 1/128 where a channel of S' comes to 255/128 and 1/256 elsewhere,
//! so 1/128 always; a channel of S0 that rounds to 0 takes its S1..S3 along. Values that a
//! physical Stokes vector cannot have are clipped: S0 < 0 to 0, S/S0 < -1 to -1. Variances are not
//! stored. For the full precision there is [`super::exr`].
//!
//! Metadata, the wavelength and the number of components stand in the header of `NAME.S0.hdr`,
//! where other programs pass over them.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use super::error::OutputError;
use super::exr::{FRAME, HANDEDNESS};
use super::rgbe::{self, RgbePicture};
use super::{atomic, check_image, source};
use crate::image::StokesImage;
use crate::spectrum::Color;

const FORMAT: &str = "Radiance HDR";
const METADATA: &str = "# sunstone ";
const COMPONENTS: &str = "SUNSTONE_COMPONENTS=";
const WAVELENGTH: &str = "SUNSTONE_WAVELENGTH_NM=";

/// The file of one component in the set that `path` names (`NAME.hdr` or `NAME.S0.hdr`).
pub fn component_path(path: &Path, component: usize) -> PathBuf {
    let mut stem = path.with_extension("");
    if stem.extension().is_some_and(|part| part == "S0") {
        stem.set_extension("");
    }
    let mut name = OsString::from(stem);
    name.push(format!(".S{component}.hdr"));
    PathBuf::from(name)
}

/// Writes the set of files that `path` names: all of them or none.
pub fn write(image: &StokesImage, path: &Path) -> Result<(), OutputError> {
    check_image(image, path)?;
    if image.color.is_of_many() {
        let reason = format!("Radiance pictures do not hold {}; write an .exr file", image.color);
        return Err(OutputError::unwritable(path, reason));
    }
    if image.width.max(image.height) > usize::from(u16::MAX) {
        return Err(OutputError::unwritable(path, "Radiance pictures end at 65535 pixels a side"));
    }
    let files: Vec<(PathBuf, Vec<u8>)> = (0..image.components)
        .map(|component| {
            let pixels = pixels_of(image, component);
            let header = header_of(image, component);
            let bytes = rgbe::encode(image.width, image.height, &pixels, &header);
            (component_path(path, component), bytes)
        })
        .collect();
    atomic::write_set(&files)
}

/// Reads the set of files that `path` names. A `NAME.hdr` that stands alone is an ordinary picture
/// and gives an image of intensity alone.
pub fn read(path: &Path) -> Result<StokesImage, OutputError> {
    let first_path = component_path(path, 0);
    let first_path = if first_path.exists() { first_path } else { path.to_owned() };
    let first = read_picture(&first_path)?;
    let color = match header_value::<f32>(&first.header, WAVELENGTH) {
        Some(wavelength_nm) => Color::Mono { wavelength_nm },
        None => Color::Rgb,
    };
    let components = match header_value::<usize>(&first.header, COMPONENTS) {
        Some(components) => components,
        None => 1 + (1..4).filter(|&i| component_path(path, i).exists()).count(),
    };
    if !matches!(components, 1 | 4) {
        let reason = format!("it has {components} components, not 1 or 4");
        return Err(OutputError::malformed(&first_path, FORMAT, reason));
    }
    let channels = color.channels();
    let mut image = StokesImage::new(first.width, first.height, color, components);
    image.metadata = first.header.iter().filter_map(|line| metadata_pair(line)).collect();
    for (channel, plane) in image.planes.iter_mut().take(channels).enumerate() {
        *plane = first.pixels.iter().map(|pixel| pixel[channel]).collect();
    }
    for component in 1..components {
        let path = component_path(path, component);
        let picture = read_picture(&path)?;
        if (picture.width, picture.height) != (image.width, image.height) {
            let reason = "its size is not that of S0";
            return Err(OutputError::malformed(&path, FORMAT, reason));
        }
        for channel in 0..channels {
            let restore = |(pixel, s0): (&[f32; 3], &f32)| (pixel[channel] - 1.0) * s0;
            let plane = picture.pixels.iter().zip(image.plane(0, channel)).map(restore).collect();
            image.planes[component * channels + channel] = plane;
        }
    }
    Ok(image)
}

/// The stored values of a component: S0 as it is, the others as S' (eq. 14).
fn pixels_of(image: &StokesImage, component: usize) -> Vec<[f32; 3]> {
    let last = image.color.channels() - 1;
    let stored = |pixel: usize, channel: usize| {
        let value = image.plane(component, channel)[pixel];
        let s0 = image.plane(0, channel)[pixel];
        match component {
            0 => value,
            _ if s0 > 0.0 && value.is_finite() => value / s0 + 1.0,
            _ => 1.0,
        }
    };
    (0..image.width * image.height)
        .map(|pixel| [0, 1, 2].map(|channel: usize| stored(pixel, channel.min(last))))
        .collect()
}

fn header_of(image: &StokesImage, component: usize) -> Vec<String> {
    let what = match component {
        0 => "S0".to_owned(),
        _ => format!("S{component}/S0 + 1"),
    };
    let mut lines = vec![
        format!("SOFTWARE=Sunstone {}", env!("CARGO_PKG_VERSION")),
        format!("# holds {what}"),
        format!("# frame: {FRAME}"),
        format!("# handedness: {HANDEDNESS}"),
        format!("{COMPONENTS}{}", image.components),
    ];
    if let Color::Mono { wavelength_nm } = image.color {
        lines.push(format!("{WAVELENGTH}{wavelength_nm}"));
    }
    if component == 0 {
        let pair = |(key, value): &(String, String)| {
            format!("{METADATA}{}", serde_json::Value::from(vec![key.as_str(), value.as_str()]))
        };
        lines.extend(image.metadata.iter().map(pair));
    }
    lines
}

fn metadata_pair(line: &str) -> Option<(String, String)> {
    serde_json::from_str(line.strip_prefix(METADATA)?).ok()
}

fn header_value<T: std::str::FromStr>(header: &[String], key: &str) -> Option<T> {
    header.iter().find_map(|line| line.strip_prefix(key)?.trim().parse().ok())
}

fn read_picture(path: &Path) -> Result<RgbePicture, OutputError> {
    let bytes = source::read(path)?;
    rgbe::decode(&bytes).map_err(|reason| OutputError::malformed(path, FORMAT, reason))
}
