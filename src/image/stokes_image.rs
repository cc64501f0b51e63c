//! A finished Stokes image: what the film develops and what the outputs write.

use std::borrow::Cow;
use std::path::Path;

use crate::math::text::{excerpt, listed};
use crate::spectrum::{Color, RGB_WAVELENGTHS_NM, rgb_of_bands};

use super::exr::WAVELENGTH_UNSTATED_NM;
use super::layers::{self, Layer};
use super::rows::{Frame, Rows};
use super::{OutputError, analyzed, check_shape};
use crate::polarization::Analyzer;

/// What the metadata call the channel that an image was made of.
const CHANNEL: &str = "channel";
/// Most characters of a name that an error shows.
const NAME: usize = 60;

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
    /// What is known of pixels besides their light: what the camera sees first.
    pub layers: Vec<Layer>,
    /// Facts about the render (integrator, seed, ...; the program adds scene, command and seconds),
    /// in the order in which they are shown.
    pub metadata: Vec<(String, String)>,
}

impl StokesImage {
    /// A black image.
    pub fn new(width: usize, height: usize, color: Color, components: usize) -> Self {
        let planes = vec![vec![0.0; width * height]; components * color.channels()];
        let (variance, layers, metadata) = (None, Vec::new(), Vec::new());
        Self { width, height, color, components, planes, variance, layers, metadata }
    }

    /// Height, width, channels and Stokes components: the shape of [`StokesImage::to_array`].
    pub fn shape(&self) -> [usize; 4] {
        [self.height, self.width, self.color.channels(), self.components]
    }

    /// All values in one array: rows from the top, pixels from the left, then channels, then Stokes
    /// components, the last index fastest. [`StokesImage::plane`] gives them without a copy.
    pub fn to_array(&self) -> Vec<f32> {
        interleaved(&self.planes, self.shape())
    }

    /// The squared standard errors in the layout of [`StokesImage::to_array`], if they are known.
    pub fn variance_to_array(&self) -> Option<Vec<f32>> {
        self.variance.as_ref().map(|planes| interleaved(planes, self.shape()))
    }

    /// What the channels are called: `R`, `G` and `B`, or the wavelength, or the bands or
    /// responses.
    pub fn channel_names(&self) -> Vec<String> {
        self.color.channel_names()
    }

    /// The image of the band that has a wavelength in nanometers, as of light of one wavelength:
    /// that of its center. An image of one wavelength is its own, if it is that.
    ///
    /// # Errors
    /// When no band has it.
    pub fn at_wavelength(&self, wavelength_nm: f32) -> Result<Self, OutputError> {
        let Some((channel, center_nm)) = self.color.channel_at(wavelength_nm) else {
            return Err(OutputError::NoBand { what: self.color.to_string(), wavelength_nm });
        };
        let image = self.of_channel(channel, center_nm);
        Ok(match self.color.is_of_many() {
            true => image.called(&self.channel_names()[channel]),
            false => image,
        })
    }

    /// What it is called as a channel of another image, if it is one.
    pub fn channel(&self) -> Option<&str> {
        self.metadata.iter().find(|(key, _)| key == CHANNEL).map(|(_, name)| name.as_str())
    }

    /// The image of the channel of a layer, or of that which has a name, as of light of one
    /// wavelength: that which
    /// the channel stands for, which is the center of a band, the mean of a response, and of red,
    /// green and blue that at which indices of refraction are taken.
    ///
    /// # Errors
    /// When no channel has it.
    pub fn at_channel(&self, name: &str) -> Result<Self, OutputError> {
        if let Some(plane) = layers::plane(&self.layers, name) {
            return Ok(self.of_layer(plane).called(name));
        }
        let names = self.channel_names();
        let Some(channel) = names.iter().position(|known| known == name) else {
            let layers = self.layers.iter().flat_map(|layer| layer.kind.channel_names());
            let known: Vec<String> = names.iter().cloned().chain(layers).collect();
            let (name, known) = (excerpt(name, NAME), listed(&known));
            return Err(OutputError::NoChannel { name, known });
        };
        let colors = RGB_WAVELENGTHS_NM.get(channel).copied();
        let wavelength_nm = self.color.wavelength_of(channel).or(colors);
        let image = self.of_channel(channel, wavelength_nm.unwrap_or(WAVELENGTH_UNSTATED_NM));
        Ok(image.called(name))
    }

    /// The same, with its name as a channel of another.
    fn called(mut self, name: &str) -> Self {
        self.metadata.retain(|(key, _)| key != CHANNEL);
        self.metadata.push((CHANNEL.to_owned(), name.to_owned()));
        self
    }

    /// A plane of a layer as intensities.
    fn of_layer(&self, plane: &[f32]) -> Self {
        let color = Color::Mono { wavelength_nm: WAVELENGTH_UNSTATED_NM };
        let (planes, metadata) = (vec![plane.to_vec()], self.metadata.clone());
        Self { planes, metadata, ..Self::new(self.width, self.height, color, 1) }
    }

    fn of_channel(&self, channel: usize, wavelength_nm: f32) -> Self {
        let channels = self.color.channels();
        let of_channel = |planes: &Vec<Vec<f32>>| -> Vec<Vec<f32>> {
            planes.iter().skip(channel).step_by(channels).cloned().collect()
        };
        Self {
            width: self.width,
            height: self.height,
            color: Color::Mono { wavelength_nm },
            components: self.components,
            planes: of_channel(&self.planes),
            variance: self.variance.as_ref().map(of_channel),
            layers: Vec::new(),
            metadata: self.metadata.clone(),
        }
    }

    /// An image that can be shown in red, green and blue or in grey: of bands what the eye sees of
    /// them, or their mean where they do not tell that; of responses their mean, and of three that
    /// are called red, green and blue, these as if they were those of sRGB.
    pub(crate) fn shown(&self) -> Cow<'_, Self> {
        let (middle, seen) = match &self.color {
            Color::Rgb | Color::Mono { .. } => return Cow::Borrowed(self),
            Color::Responses(_) if self.channel_names() == ["red", "green", "blue"] => {
                return Cow::Owned(Self { color: Color::Rgb, ..self.clone() });
            }
            Color::Bands(bands) => {
                (mean_of(bands.ends_nm().map(|nm| nm as f32)), rgb_of_bands(bands))
            }
            Color::Responses(curves) => (mean_of(curves.ends_nm()), None),
        };
        let channels = self.color.channels();
        let (color, weights): (Color, Vec<Vec<f32>>) = match seen {
            Some(weights) => {
                let of_channel = |i: usize| weights.iter().map(|weight| weight[i]).collect();
                (Color::Rgb, [0, 1, 2].map(of_channel).to_vec())
            }
            None => {
                let mean = vec![1.0 / channels as f32; channels];
                (Color::Mono { wavelength_nm: middle }, vec![mean])
            }
        };
        let mixed = |planes: &[Vec<f32>]| -> Vec<Vec<f32>> {
            weights.iter().map(|weights| mix(planes, weights)).collect()
        };
        Cow::Owned(Self {
            width: self.width,
            height: self.height,
            color,
            components: self.components,
            planes: self.planes.chunks(channels).flat_map(mixed).collect(),
            variance: None,
            layers: Vec::new(),
            metadata: self.metadata.clone(),
        })
    }

    /// What the Stokes components are called.
    pub fn component_names(&self) -> &'static [&'static str] {
        &["S0", "S1", "S2", "S3"][..self.components]
    }

    /// What the metadata say under a name.
    pub fn metadata(&self, name: &str) -> Option<&str> {
        self.metadata.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    /// Writes the image in the format that the extension names: `.exr` (everything), `.hdr` (the
    /// paper's set of files) or `.png` (a preview of S0).
    ///
    /// # Errors
    /// When the extension is another or the file cannot be written; nothing is left half-way.
    pub fn save(&self, path: &Path) -> Result<(), OutputError> {
        super::save(self, path)
    }

    /// Reads an image in the format that the extension names: `.exr`, `.hdr` or `.npy`.
    ///
    /// # Errors
    /// When the extension is another, or the file is not what it promises.
    pub fn load(path: &Path) -> Result<Self, OutputError> {
        super::load(path)
    }

    /// The light behind an ideal analyzer in the film's frame, as if it had been rendered so. The
    /// variances are not kept, as they do not follow from those of the components.
    ///
    /// # Errors
    /// When the image holds intensity alone.
    pub fn behind(&self, analyzer: Analyzer) -> Result<Self, OutputError> {
        analyzed::behind(self, analyzer)
    }

    /// The plane of one Stokes component and channel.
    pub fn plane(&self, component: usize, channel: usize) -> &[f32] {
        &self.planes[component * self.color.channels() + channel]
    }
}

impl Rows for StokesImage {
    fn frame(&self) -> Frame {
        let Self { width, height, components, .. } = *self;
        let (color, has_variance) = (self.color.clone(), self.variance.is_some());
        let layers = self.layers.iter().map(|layer| layer.kind).collect();
        Frame { width, height, color, components, has_variance, layers }
    }

    fn metadata(&self) -> &[(String, String)] {
        &self.metadata
    }

    fn row(&self, y: usize, numbers: &mut [f32]) {
        let layers = self.layers.iter().flat_map(|layer| &layer.planes);
        let planes = self.planes.iter().chain(self.variance.iter().flatten()).chain(layers);
        for (numbers, plane) in numbers.chunks_exact_mut(self.width).zip(planes) {
            numbers.copy_from_slice(&plane[y * self.width..][..self.width]);
        }
    }

    fn whole(&self) -> Cow<'_, StokesImage> {
        Cow::Borrowed(self)
    }

    fn fault(&self) -> Option<&'static str> {
        check_shape(self).err()
    }
}

fn mean_of([one, two]: [f32; 2]) -> f32 {
    0.5 * (one + two)
}

/// The sum of planes times weights.
fn mix(planes: &[Vec<f32>], weights: &[f32]) -> Vec<f32> {
    let mut sums = vec![0.0; planes.first().map_or(0, Vec::len)];
    for (plane, weight) in planes.iter().zip(weights) {
        sums.iter_mut().zip(plane).for_each(|(sum, value)| *sum += weight * value);
    }
    sums
}

fn interleaved(planes: &[Vec<f32>], [height, width, channels, components]: [usize; 4]) -> Vec<f32> {
    let of_pixel = |pixel: usize| {
        let of_channel = move |channel: usize| {
            (0..components).map(move |component| planes[component * channels + channel][pixel])
        };
        (0..channels).flat_map(of_channel)
    };
    (0..height * width).flat_map(of_pixel).collect()
}
