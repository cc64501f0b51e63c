//! Images: the library's planes, and arrays of shape (height, width, channels, components).

use std::path::PathBuf;
use std::sync::Arc;

use numpy::{
    PyArray3, PyArray4, PyArrayMethods, PyReadonlyArray3, PyReadonlyArray4, PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use sunstone::internals::image::layers::{Layer, LayerKind};
use sunstone::internals::image::png;
use sunstone::internals::image::visualize::{Map, View, panels, visualize};
use sunstone::internals::spectrum::Curves;
use sunstone::{Band, Bands, Color, ImageError, StokesImage, Stop};

use crate::errors::{ERROR, of_image};
use crate::wait::wait_for;

/// Pixels that are moved at a time, so that they stay in the cache for all planes.
const CHUNK: usize = 1024;

/// The array of the values of an image.
pub type Array<'py> = Bound<'py, PyArray4<f32>>;
/// A band as Python has it: its name, and its center and width in nanometers.
pub type Row = (String, f32, f32);
/// Layers by name, each an array of shape (height, width, channels).
pub type Layers<'py> = Vec<(&'static str, Bound<'py, PyArray3<f32>>)>;
/// What an image is to Python: values, variances, what the channels stand for, metadata, layers.
pub type Parts<'py> =
    (Array<'py>, Option<Array<'py>>, Option<Channels>, Vec<(String, String)>, Layers<'py>);

/// What the channels of an image stand for; of red, green and blue Python has None.
#[derive(Clone, FromPyObject, IntoPyObject)]
pub enum Channels {
    /// One wavelength in nanometers.
    Wavelength(f32),
    /// Responses, as files hold them.
    Responses(String),
    /// Bands.
    Bands(Vec<Row>),
}

impl Channels {
    fn of(color: &Color) -> Option<Self> {
        match color {
            Color::Rgb => None,
            Color::Mono { wavelength_nm } => Some(Self::Wavelength(*wavelength_nm)),
            Color::Responses(curves) => Some(Self::Responses(curves.to_text())),
            Color::Bands(bands) => {
                let row = |band: &Band| (band.name.clone(), band.center_nm, band.width_nm);
                Some(Self::Bands(bands.list().iter().map(row).collect()))
            }
        }
    }
}

fn color_of(channels: Option<Channels>) -> PyResult<Color> {
    Ok(match channels {
        None => Color::Rgb,
        Some(Channels::Wavelength(wavelength_nm)) => Color::Mono { wavelength_nm },
        Some(Channels::Responses(text)) => {
            let curves = Curves::from_text(&text);
            let problem = "responses: this is not what Image.responses of an image has";
            Color::Responses(Arc::new(curves.ok_or_else(|| ERROR.says(problem))?))
        }
        Some(Channels::Bands(rows)) => {
            let band = |(name, center_nm, width_nm)| Band { name, center_nm, width_nm };
            let bands = Bands::new(rows.into_iter().map(band).collect());
            Color::Bands(Arc::new(bands.map_err(|fault| ERROR.says(fault))?))
        }
    })
}

/// Bands with their numbers as they are stored, if an image can have them.
#[pyfunction]
pub fn checked_bands(rows: Vec<Row>) -> PyResult<Option<Channels>> {
    color_of(Some(Channels::Bands(rows))).map(|color| Channels::of(&color))
}

/// The names of channels, and the wavelengths in nanometers that they stand for, if they do.
#[pyfunction]
pub fn about_channels(channels: Option<Channels>) -> PyResult<(Vec<String>, Vec<Option<f32>>)> {
    let color = color_of(channels)?;
    let wavelengths = (0..color.channels()).map(|channel| color.wavelength_of(channel)).collect();
    Ok((color.channel_names(), wavelengths))
}

/// The channel that has a wavelength in nanometers, and the wavelength that it stands for.
#[pyfunction]
pub fn channel_at(channels: Option<Channels>, wavelength_nm: f32) -> PyResult<(usize, f32)> {
    let color = color_of(channels)?;
    let none = || of_image(ImageError::NoBand { what: color.to_string(), wavelength_nm });
    color.channel_at(wavelength_nm).ok_or_else(none)
}

/// The parts of an image; its planes are copied once, into arrays of Python's own.
pub fn parts(py: Python<'_>, image: StokesImage) -> PyResult<Parts<'_>> {
    let stokes = array(py, &image.planes, image.shape())?;
    let variance = match &image.variance {
        Some(planes) => Some(array(py, planes, image.shape())?),
        None => None,
    };
    let layers = layers_of(py, &image)?;
    Ok((stokes, variance, Channels::of(&image.color), image.metadata, layers))
}

fn layers_of<'py>(py: Python<'py>, image: &StokesImage) -> PyResult<Layers<'py>> {
    let layer = |layer: &Layer| {
        let channels = layer.planes.len();
        let array = PyArray3::zeros(py, [image.height, image.width, channels], false);
        {
            let mut writable = array.readwrite();
            let values = writable.as_slice_mut()?;
            for (channel, plane) in layer.planes.iter().enumerate() {
                let places = values[channel..].iter_mut().step_by(channels);
                places.zip(plane).for_each(|(place, value)| *place = *value);
            }
        }
        Ok((layer.kind.name(), array))
    };
    image.layers.iter().map(layer).collect()
}

/// The layer of a name that an array is.
fn layer(name: &str, array: &PyReadonlyArray3<f32>, size: [usize; 2]) -> PyResult<Layer> {
    let kind: LayerKind = name.parse().map_err(|text: String| ERROR.says(text))?;
    let channels = kind.channels().len();
    let (&[height, width, count], [wanted_height, wanted_width]) = (array.shape(), size) else {
        return Err(ERROR.says(format!("the layer {name} has not three axes")));
    };
    if [height, width, count] != [wanted_height, wanted_width, channels] {
        return Err(ERROR.says(format!(
            "the layer {name} has the shape ({height}, {width}, {count}): must be \
             ({wanted_height}, {wanted_width}, {channels})"
        )));
    }
    let values = array.as_slice()?;
    let plane = |channel: usize| values[channel..].iter().step_by(channels).copied().collect();
    Ok(Layer { kind, planes: (0..channels).map(plane).collect() })
}

fn array<'py>(
    py: Python<'py>,
    planes: &[Vec<f32>],
    shape @ [.., channels, components]: [usize; 4],
) -> PyResult<Array<'py>> {
    let array = PyArray4::zeros(py, shape, false);
    {
        let mut writable = array.readwrite();
        let values = writable.as_slice_mut()?;
        let stride = channels * components;
        let offset = |plane: usize| plane % channels * components + plane / channels;
        py.detach(|| {
            for (part, values) in values.chunks_mut(CHUNK * stride).enumerate() {
                for (index, plane) in planes.iter().enumerate() {
                    let places = values[offset(index)..].iter_mut().step_by(stride);
                    places.zip(&plane[part * CHUNK..]).for_each(|(place, value)| *place = *value);
                }
            }
        });
    }
    Ok(array)
}

/// The planes of an array.
fn planes(array: &PyReadonlyArray4<f32>) -> PyResult<Vec<Vec<f32>>> {
    let &[_, _, channels, components] = array.shape() else { return Ok(Vec::new()) };
    let (values, stride) = (array.as_slice()?, channels * components);
    let offset = |plane: usize| plane % channels * components + plane / channels;
    let plane = |index: usize| values.iter().skip(offset(index)).step_by(stride).copied().collect();
    Ok((0..stride).map(plane).collect())
}

fn image(
    stokes: &PyReadonlyArray4<f32>,
    variance: Option<&PyReadonlyArray4<f32>>,
    channels_of: Option<Channels>,
    metadata: Vec<(String, String)>,
) -> PyResult<StokesImage> {
    let &[height, width, channels, components] = stokes.shape() else {
        return Err(ERROR.says("an image has four axes: height, width, channels, components"));
    };
    let color = color_of(channels_of)?;
    if channels != color.channels() {
        let expected = color.channels();
        return Err(
            ERROR.says(format!("an image of {color} has {expected} channels, not {channels}"))
        );
    }
    let variance = variance.map(planes).transpose()?;
    let planes = planes(stokes)?;
    Ok(StokesImage {
        width,
        height,
        color,
        components,
        planes,
        variance,
        layers: Vec::new(),
        metadata,
    })
}

/// Writes an image in the format that the extension names.
#[pyfunction]
pub fn save_image(
    py: Python,
    path: PathBuf,
    stokes: PyReadonlyArray4<f32>,
    variance: Option<PyReadonlyArray4<f32>>,
    channels: Option<Channels>,
    metadata: Vec<(String, String)>,
    layers: Vec<(String, PyReadonlyArray3<f32>)>,
) -> PyResult<()> {
    let mut image = image(&stokes, variance.as_ref(), channels, metadata)?;
    let size = [image.height, image.width];
    image.layers =
        layers.iter().map(|(name, array)| layer(name, array, size)).collect::<PyResult<_>>()?;
    let saved = wait_for(
        py,
        None,
        &Stop::default(),
        |_| Ok(()),
        move |pool, _| pool.threads.run(|| image.save(&path)),
    )?;
    saved.map_err(of_image)
}

/// Reads an image in the format that the extension names.
#[pyfunction]
pub fn load_image(py: Python<'_>, path: PathBuf) -> PyResult<Parts<'_>> {
    let load = move || StokesImage::load(&path);
    let image =
        wait_for(py, None, &Stop::default(), |_| Ok(()), move |pool, _| pool.threads.run(load))?;
    parts(py, image.map_err(of_image)?)
}

/// A map with its legend, or the panels, as a PNG.
#[pyfunction]
pub fn picture<'py>(
    py: Python<'py>,
    stokes: PyReadonlyArray4<f32>,
    channels: Option<Channels>,
    map: Option<&str>,
    exposure: f32,
    full_scale: bool,
) -> PyResult<Bound<'py, PyBytes>> {
    let map: Option<Map> =
        map.map(str::parse).transpose().map_err(|text: String| ERROR.says(text))?;
    let image = image(&stokes, None, channels, Vec::new())?;
    let bytes = py.detach(move || {
        let mut view = if full_scale { View::default() } else { View::fitted(&image) };
        view.exposure_ev = exposure;
        let picture = match map {
            Some(map) => visualize(&image, map, &view)?,
            None => panels(&image, &view)?,
        };
        Ok(png::encode(&picture))
    });
    let bytes = bytes.map_err(of_image)?.map_err(|error| ERROR.says(error))?;
    Ok(PyBytes::new(py, &bytes))
}
