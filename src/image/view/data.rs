//! What the page knows beside pixels: names, colors, scales and legends, as JSON.

use serde::Serialize;

use super::super::page::{self, Colors};
use super::super::visualize::{View, signed_range};
use super::Named;
use crate::math::text::printable;
use crate::spectrum::{Band, Color, rgb_of_bands};

/// All of it, as text that may stand in a script element.
pub fn json(images: &[Named]) -> String {
    page::json_text(&Data::new(images))
}

#[derive(Serialize)]
struct Data {
    images: Vec<ImageData>,
    #[serde(flatten)]
    colors: Colors,
}

#[derive(Serialize)]
struct ImageData {
    name: String,
    width: usize,
    height: usize,
    channels: Vec<String>,
    components: usize,
    /// Those that the channels are, if they are bands.
    bands: Option<Vec<BandData>>,
    /// What red, green and blue take of every band, where bands tell these.
    weights: Option<Vec<[f32; 3]>>,
    variance: bool,
    metadata: Vec<(String, String)>,
}

#[derive(Serialize)]
struct BandData {
    center_nm: f32,
    width_nm: f32,
}

impl Data {
    fn new(images: &[Named]) -> Self {
        let is_polarized = |named: &&Named| named.image.components == 4;
        let polarized: Vec<&Named> = images.iter().filter(is_polarized).collect();
        // Both sides of a divider share their scales.
        let fitted = polarized.iter().map(|named| View::fitted(named.image).degree_max);
        let range = polarized.iter().map(|named| signed_range(named.image)).fold(0.0, f32::max);
        let colors = fitted.reduce(f32::max).map(|degree_max| (degree_max, range));
        Self { images: images.iter().map(ImageData::new).collect(), colors: Colors::new(colors) }
    }
}

impl ImageData {
    fn new(Named { name, image }: &Named) -> Self {
        let bands = match &image.color {
            Color::Rgb | Color::Mono { .. } | Color::Responses(_) => None,
            Color::Bands(bands) => Some(bands),
        };
        let data = |band: &Band| BandData { center_nm: band.center_nm, width_nm: band.width_nm };
        Self {
            name: printable(name),
            width: image.width,
            height: image.height,
            channels: image.channel_names(),
            components: image.components,
            bands: bands.map(|bands| bands.list().iter().map(data).collect()),
            weights: bands.and_then(|bands| rgb_of_bands(bands)),
            variance: image.variance.is_some(),
            metadata: image.metadata.clone(),
        }
    }
}
