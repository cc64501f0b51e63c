//! A finished Stokes image: what the film develops and what the outputs write.

use crate::spectrum::Color;

/// Stokes values per pixel and channel, with what is known of their error and origin.
#[derive(Clone, Debug, PartialEq)]
pub struct StokesImage {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// What the channels stand for.
    pub color: Color,
    /// Number of Stokes components: 1 (intensity only) or 4.
    pub components: usize,
    /// One plane per component and channel, `component * channels + channel`; rows from the top,
    /// pixels from the left. S1..S3 are in the film frame: x to the right, y up, light towards
    /// the sensor (`polarization`).
    pub planes: Vec<Vec<f32>>,
    /// Squared standard error of every value, in the layout of `planes`.
    pub variance: Option<Vec<Vec<f32>>>,
    /// Facts about the render (scene, command, seed, ...) in the order in which they are shown.
    pub metadata: Vec<(String, String)>,
}

impl StokesImage {
    /// A black image.
    pub fn new(width: usize, height: usize, color: Color, components: usize) -> Self {
        let planes = vec![vec![0.0; width * height]; components * color.channels()];
        Self { width, height, color, components, planes, variance: None, metadata: Vec::new() }
    }

    /// The plane of one Stokes component and channel.
    pub fn plane(&self, component: usize, channel: usize) -> &[f32] {
        &self.planes[component * self.color.channels() + channel]
    }
}
