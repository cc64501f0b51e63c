//! OpenEXR: the file that keeps everything.
//!
//! One unnamed part, 32-bit float, linear, scan lines, ZIP. The channels:
//!
//! | image | channels |
//! |---|---|
//! | RGB, Stokes | `R G B` and `S0.R S0.G S0.B` ... `S3.B` (Mitsuba's names; `R G B` repeat S0) |
//! | RGB, intensity | `R G B` |
//! | monochromatic, Stokes | `Y` and `S0` ... `S3` (`Y` repeats S0 so that viewers show it) |
//! | monochromatic, intensity | `Y` and `S0` |
//! | bands, Stokes | `S0.550,000000nm` ... |
//! | responses, Stokes | `S0.NAME` ... |
//! | squared standard errors, if known | `variance.S0.R` ..., `variance.S0` ... |
//! | layers, if there are any | `depth.Z`, `normal.X` ..., `material.id` ... |
//!
//! An image of a part of its film, which its metadata name, is the data window in the display
//! window that the film is; `pixelAspectRatio` is theirs, too.
//!
//! Metadata are string attributes `sunstone.KEY`. Six keys are the format's own: `frame`,
//! `handedness`, `wavelength_nm` (a float), `bands` (JSON), `responses` (JSON: the curves, each
//! with the factor by which its values are multiplied) and `order`, the order of the metadata.
//! What is written is read back bit for bit.

mod bits;
mod blocks;
mod deflate;
mod header;
mod spectral;

use std::collections::HashMap;
use std::io::{self, BufReader, Cursor};
use std::path::Path;
use std::sync::Arc;

use ::exr::image::read::read as read_with;
use ::exr::meta::header::Header;
use ::exr::meta::{BlockDescription, MetaData};
use ::exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, ChannelDescription, Compression, FlatImage,
    FlatSamples, ImageAttributes, Layer as FileLayer, LayerAttributes, LineOrder, ReadChannels,
    ReadLayers, SampleType, Text, Vec2,
};

use super::cut::{CROP, Cut, PIXEL_ASPECT};
use super::error::OutputError;
use super::layers::{Layer, LayerKind};
use super::rows::{Frame, Rows};
use super::{atomic, source};
use crate::image::StokesImage;
use crate::spectrum::{Color, Curves};

/// The frame of S1..S3 in every file that Sunstone writes.
pub const FRAME: &str = "right-handed (x, y, k): x to the right in the image, y up, k along the \
                         light towards the sensor; S1 > 0 along x, S2 > 0 along x + y";
/// The sign of S3 in every file that Sunstone writes.
pub const HANDEDNESS: &str = "S3 > 0 is right circular: the field turns clockwise as seen by the \
                              receiver; phasors exp(+i w t)";

const FORMAT: &str = "EXR";
const KEY_PREFIX: &str = "sunstone.";
/// Keys that no metadata can have.
const OWN_KEYS: [&str; 6] = ["bands", "frame", "handedness", "order", "responses", "wavelength_nm"];
/// The attribute that holds response curves.
const RESPONSES: &str = "sunstone.responses";
/// The wavelength given to a monochromatic file that does not name its own.
pub(super) const WAVELENGTH_UNSTATED_NM: f32 = 550.0;
/// No lossless EXR compression that is worth its name packs tighter than this; a header that
/// promises more pixels than the file could hold is refused before memory is asked for.
const EXPANSION_MAX: usize = 4096;
/// Decoded bytes that are granted to any file, however small.
const DECODED_BYTES_FREE: usize = 64 << 20;

/// Writes an image with everything that it knows, a few blocks of rows at a time.
pub fn write(image: &dyn Rows, path: &Path) -> Result<(), OutputError> {
    let unwritable = |reason: String| OutputError::unwritable(path, reason);
    if let Some(fault) = image.fault() {
        return Err(unwritable(fault.to_owned()));
    }
    let frame = image.frame();
    let (names, planes): (Vec<String>, Vec<usize>) = channels(&frame).into_iter().unzip();
    let header = header_of(image, names).with_attributes(attributes(image, path)?);
    let mut refused = None;
    let written = atomic::write_with(path, |file| {
        blocks::write(file, header, image, &planes).map_err(|error| match error {
            ::exr::error::Error::Io(error) => error,
            error => {
                refused = Some(error.to_string());
                io::Error::other("it is refused")
            }
        })
    });
    refused.map_or(written, |reason| Err(unwritable(reason)))
}

/// The bytes of a file of these channels, by their names in order: each with the plane of a row
/// that it holds. It has no metadata.
///
/// # Errors
/// When they cannot be written: why.
pub fn encode(image: &dyn Rows, channels: Vec<(String, usize)>) -> Result<Vec<u8>, String> {
    let (names, planes): (Vec<String>, Vec<usize>) = channels.into_iter().unzip();
    let mut bytes = Cursor::new(Vec::new());
    blocks::write(&mut bytes, header_of(image, names), image, &planes)
        .map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}

/// The same of an image with all its channels.
///
/// # Errors
/// As [`encode`].
pub fn encode_whole(image: &StokesImage) -> Result<Vec<u8>, String> {
    encode(image, channels(&image.frame()))
}

/// The header of a file of channels of these names, without attributes of its part.
fn header_of(image: &dyn Rows, names: Vec<String>) -> Header {
    let described = |name| ChannelDescription::named(Text::new_or_panic(name), SampleType::F32);
    let list = names.into_iter().map(described).collect();
    let frame = image.frame();
    Header::new(Text::default(), (frame.width, frame.height), list)
        .with_encoding(Compression::ZIP16, BlockDescription::ScanLines, LineOrder::Increasing)
        .with_shared_attributes(shared_attributes(image))
}

/// The channels of an image in the order of the file, by their names: each with the plane of a row
/// that it holds.
fn channels(frame: &Frame) -> Vec<(String, usize)> {
    let mut channels: Vec<(String, usize)> = match frame.color {
        Color::Rgb => RGB_NAMES.map(str::to_owned).into_iter().zip(0..).collect(),
        Color::Mono { .. } => vec![("Y".to_owned(), 0)],
        Color::Bands(_) | Color::Responses(_) => Vec::new(),
    };
    let names = stokes_names(&frame.color, frame.components);
    if frame.color != Color::Rgb || frame.components == 4 {
        channels.extend(names.iter().cloned().zip(0..));
    }
    if frame.has_variance {
        channels.extend(names.iter().map(|name| variance_name(name)).zip(frame.planes()..));
    }
    let layers = frame.layers.iter().flat_map(|kind| kind.channel_names());
    channels.extend(layers.zip(frame.planes_of_light()..));
    channels.sort();
    channels
}

/// Reads an image that Sunstone, or the `stokes` integrator of Mitsuba 3, has written.
///
/// Alpha and other channels beside the known ones are left unread. 16-bit files are widened.
pub fn read(path: &Path) -> Result<StokesImage, OutputError> {
    decode(&source::read(path)?).map_err(|reason| OutputError::malformed(path, FORMAT, reason))
}

/// The same from the bytes of a file; what is wrong with it otherwise.
pub fn decode(bytes: &[u8]) -> Result<StokesImage, String> {
    check_header(bytes)?;
    let file: FlatImage = read_with()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| error.to_string())?;
    match file.layer_data.as_slice() {
        [layer] => assemble(layer),
        layers => Err(format!("it has {} parts, not one", layers.len())),
    }
}

const RGB_NAMES: [&str; 3] = ["R", "G", "B"];

/// The channel names of all planes, in the order of [`StokesImage::planes`].
fn stokes_names(color: &Color, components: usize) -> Vec<String> {
    (0..components)
        .flat_map(|component| match color {
            Color::Rgb => RGB_NAMES.map(|name| format!("S{component}.{name}")).to_vec(),
            Color::Mono { .. } => vec![format!("S{component}")],
            Color::Bands(bands) => spectral::names(component, bands),
            Color::Responses(curves) => {
                curves.channels().map(|name| format!("S{component}.{name}")).collect()
            }
        })
        .collect()
}

/// Whether a channel is of S1, S2 or S3, of whatever color.
fn is_of_polarization(name: &str) -> bool {
    let component = name.split('.').next();
    component.is_some_and(|it| ["S1", "S2", "S3"].contains(&it))
}

fn variance_name(name: &str) -> String {
    format!("variance.{name}")
}

/// The part of its film that an image shows, by its metadata; all of it if they do not say that.
fn cut_of(image: &dyn Rows) -> Cut {
    let Frame { width, height, .. } = image.frame();
    let size = [width as u32, height as u32];
    let cut = fact(image, CROP).and_then(Cut::from_text).filter(|cut| cut.size == size);
    cut.unwrap_or(Cut::whole(size))
}

fn fact<'a>(image: &'a dyn Rows, name: &str) -> Option<&'a str> {
    let mut facts = image.metadata().iter();
    facts.find(|(key, _)| key == name).map(|(_, value)| value.as_str())
}

/// The whole film, as what the image is a part of, and the shape of its pixels.
fn shared_attributes(image: &dyn Rows) -> ImageAttributes {
    let [width, height] = cut_of(image).film.map(|side| side as usize);
    let mut attributes = ImageAttributes::with_size((width, height));
    let aspect = fact(image, PIXEL_ASPECT).and_then(|text| text.parse().ok());
    attributes.pixel_aspect = aspect.unwrap_or(1.0);
    attributes
}

fn attributes(image: &dyn Rows, path: &Path) -> Result<LayerAttributes, OutputError> {
    let text = |value: &str| Text::from_slice_unchecked(value.as_bytes());
    let software_name = Some(text(concat!("Sunstone ", env!("CARGO_PKG_VERSION"))));
    let [x, y] = cut_of(image).start.map(|start| start as i32);
    let layer_position = Vec2(x, y);
    let mut attributes =
        LayerAttributes { software_name, layer_position, ..LayerAttributes::default() };
    let other = &mut attributes.other;
    for (key, value) in image.metadata() {
        let name = format!("{KEY_PREFIX}{key}");
        let refused =
            |why| OutputError::unwritable(path, format!("the metadata key {key:?} {why}"));
        if name.len() > 255 || key.contains('\0') {
            return Err(refused("is too long or holds a zero byte"));
        }
        if OWN_KEYS.contains(&key.as_str()) {
            return Err(refused("is the format's own"));
        }
        if other.insert(text(&name), AttributeValue::Text(text(value))).is_some() {
            return Err(refused("is there twice"));
        }
    }
    let keys: Vec<&str> = image.metadata().iter().map(|(key, _)| key.as_str()).collect();
    let order = serde_json::Value::from(keys).to_string();
    for (name, value) in [("order", order.as_str()), ("frame", FRAME), ("handedness", HANDEDNESS)] {
        other.insert(text(&format!("sunstone.{name}")), AttributeValue::Text(text(value)));
    }
    let frame = image.frame();
    match &frame.color {
        Color::Rgb => {}
        Color::Mono { wavelength_nm } => {
            other.insert(text("sunstone.wavelength_nm"), AttributeValue::F32(*wavelength_nm));
        }
        Color::Bands(bands) => {
            for (name, value) in spectral::attributes(frame.components, bands) {
                other.insert(text(name), AttributeValue::Text(text(&value)));
            }
        }
        Color::Responses(curves) => {
            other.insert(text(RESPONSES), AttributeValue::Text(text(&curves.to_text())));
        }
    }
    Ok(attributes)
}

/// The headers of a file, unless they would make the decoder ask for absurd amounts of memory.
pub(super) fn check_header(bytes: &[u8]) -> Result<MetaData, String> {
    let meta = MetaData::read_from_buffered(BufReader::new(bytes), false)
        .map_err(|error| error.to_string())?;
    let decoded_max = bytes.len().saturating_mul(EXPANSION_MAX).max(DECODED_BYTES_FREE);
    let mut decoded = 0_usize;
    for header in &meta.headers {
        let size = header.layer_size;
        let samples = size.x().saturating_mul(size.y());
        let pixel = header.channels.list.len().saturating_mul(4);
        decoded = decoded.saturating_add(samples.saturating_mul(pixel));
    }
    if decoded > decoded_max {
        return Err("the header promises far more pixels than the file can hold".to_owned());
    }
    Ok(meta)
}

fn assemble(layer: &FileLayer<AnyChannels<FlatSamples>>) -> Result<StokesImage, String> {
    let attributes = &layer.attributes.other;
    let (width, height) = (layer.size.x(), layer.size.y());
    let list = &layer.channel_data.list;
    let by_name: HashMap<String, &AnyChannel<FlatSamples>> =
        list.iter().map(|channel| (channel.name.to_string(), channel)).collect();
    let is_there = |name: &String| by_name.contains_key(name);
    let (color, components, names) = match with_responses(attributes, is_there)? {
        Some(found) => found,
        None => match spectral::layout(by_name.keys().map(String::as_str), attributes)? {
            Some((bands, components, names)) => (Color::Bands(Arc::new(bands)), components, names),
            None => few_channels(attributes, is_there).ok_or_else(|| unknown_channels(list))?,
        },
    };
    // Others drop channels: what is left of a Stokes image is no image of intensity.
    if components == 1 && by_name.keys().any(|name| is_of_polarization(name)) {
        return Err(unknown_channels(list));
    }
    let plane = |name: &String| plane_values(by_name.get(name).copied(), name, width * height);
    let planes = names.iter().map(plane).collect::<Result<Vec<_>, _>>()?;
    let variance_names: Vec<String> =
        stokes_names(&color, components).iter().map(|name| variance_name(name)).collect();
    let variance = match variance_names.iter().all(|name| by_name.contains_key(name)) {
        true => Some(variance_names.iter().map(plane).collect::<Result<Vec<_>, _>>()?),
        false => None,
    };
    let is_whole = |kind: &LayerKind| kind.channel_names().all(|name| by_name.contains_key(&name));
    let layer = |kind: LayerKind| {
        let planes = kind.channel_names().map(|name| plane(&name)).collect::<Result<_, _>>()?;
        Ok::<_, String>(Layer { kind, planes })
    };
    let kinds = LayerKind::ALL.into_iter().filter(is_whole);
    let layers = kinds.map(layer).collect::<Result<Vec<_>, _>>()?;
    let metadata = metadata(attributes);
    Ok(StokesImage { width, height, color, components, planes, variance, layers, metadata })
}

/// What channels stand for, their components and names.
type Channels = (Color, usize, Vec<String>);

/// Those of an image of responses; none if there are no responses in the file.
fn with_responses(
    attributes: &HashMap<Text, AttributeValue>,
    is_there: impl Fn(&String) -> bool,
) -> Result<Option<Channels>, String> {
    let Some(AttributeValue::Text(text)) = attributes.get(RESPONSES.as_bytes()) else {
        return Ok(None);
    };
    let curves = Curves::from_text(&String::from_utf8_lossy(text.as_slice()));
    let curves = curves.ok_or_else(|| format!("its {RESPONSES} are damaged"))?;
    let color = Color::Responses(Arc::new(curves));
    let found = [4, 1].into_iter().find_map(|components| {
        let names = stokes_names(&color, components);
        names.iter().all(&is_there).then_some((components, names))
    });
    let (components, names) =
        found.ok_or_else(|| format!("it has not the channels that its {RESPONSES} name"))?;
    Ok(Some((color, components, names)))
}

/// Those of RGB images and of one wavelength.
fn few_channels(
    attributes: &HashMap<Text, AttributeValue>,
    is_there: impl Fn(&String) -> bool,
) -> Option<Channels> {
    let wavelength_nm = match attributes.get("sunstone.wavelength_nm".as_bytes()) {
        Some(AttributeValue::F32(wavelength_nm)) => *wavelength_nm,
        _ => WAVELENGTH_UNSTATED_NM,
    };
    let mono = || Color::Mono { wavelength_nm };
    let rgb: Vec<String> = RGB_NAMES.map(str::to_owned).to_vec();
    let layouts = [
        (Color::Rgb, 4, stokes_names(&Color::Rgb, 4)),
        (mono(), 4, stokes_names(&mono(), 4)),
        (Color::Rgb, 1, rgb),
        (mono(), 1, stokes_names(&mono(), 1)),
        (mono(), 1, vec!["Y".to_owned()]),
    ];
    layouts.into_iter().find(|(_, _, names)| names.iter().all(&is_there))
}

fn plane_values(
    channel: Option<&AnyChannel<FlatSamples>>,
    name: &str,
    pixels: usize,
) -> Result<Vec<f32>, String> {
    let values: Vec<f32> =
        channel.map(|channel| channel.sample_data.values_as_f32().collect()).unwrap_or_default();
    match values.len() == pixels {
        true => Ok(values),
        false => Err(format!("the channel {name} is subsampled or incomplete")),
    }
}

fn unknown_channels(list: &[AnyChannel<FlatSamples>]) -> String {
    let found: Vec<String> = list.iter().map(|channel| channel.name.to_string()).collect();
    format!(
        "its channels are {}; wanted are R G B, or S0.R S0.G S0.B ... S3.B, or S0 ... S3, or Y, or \
         S0.550,000000nm and the like",
        found.join(" ")
    )
}

/// The metadata in their own order; keys that the order does not list follow by name.
fn metadata(attributes: &HashMap<Text, AttributeValue>) -> Vec<(String, String)> {
    let text = |value: &Text| String::from_utf8_lossy(value.as_slice()).into_owned();
    let order: Vec<String> = match attributes.get("sunstone.order".as_bytes()) {
        Some(AttributeValue::Text(order)) => serde_json::from_str(&text(order)).unwrap_or_default(),
        _ => Vec::new(),
    };
    let rank: HashMap<&String, usize> = order.iter().enumerate().map(|(i, key)| (key, i)).collect();
    let mut pairs: Vec<(String, String)> = attributes
        .iter()
        .filter_map(|(name, value)| match (text(name).strip_prefix(KEY_PREFIX), value) {
            (Some(key), AttributeValue::Text(value)) if !OWN_KEYS.contains(&key) => {
                Some((key.to_owned(), text(value)))
            }
            _ => None,
        })
        .collect();
    pairs.sort_by_cached_key(|(key, _)| {
        (rank.get(key).copied().unwrap_or(usize::MAX), key.to_owned())
    });
    pairs
}
