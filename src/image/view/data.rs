//! What the page knows beside pixels: names, colors, scales and legends, as JSON.

use serde::Serialize;

use super::super::page::{self, Colors};
use super::super::visualize::{View, signed_range};
use super::Named;
use crate::math::text::printable;

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
    variance: bool,
    metadata: Vec<(String, String)>,
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
        Self {
            name: printable(name),
            width: image.width,
            height: image.height,
            channels: image.channel_names(),
            components: image.components,
            variance: image.variance.is_some(),
            metadata: image.metadata.clone(),
        }
    }
}
