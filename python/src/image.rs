//! Images: the library's planes, and arrays of shape (height, width, channels, components).

use std::path::PathBuf;

use numpy::{PyArray4, PyArrayMethods, PyReadonlyArray4, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use sunstone::internals::image::png;
use sunstone::internals::image::visualize::{Map, View, panels, visualize};
use sunstone::{Color, StokesImage, Stop};

use crate::errors::{ERROR, of_image};
use crate::wait::wait_for;

/// Pixels that are moved at a time, so that they stay in the cache for all planes.
const CHUNK: usize = 1024;

/// The array of the values of an image.
pub type Array<'py> = Bound<'py, PyArray4<f32>>;
/// What an image is to Python: values, variances, wavelength in nanometers if there is one, and
/// metadata.
pub type Parts<'py> = (Array<'py>, Option<Array<'py>>, Option<f32>, Vec<(String, String)>);

/// The parts of an image; its planes are copied once, into arrays of Python's own.
pub fn parts(py: Python<'_>, image: StokesImage) -> PyResult<Parts<'_>> {
    let stokes = array(py, &image.planes, image.shape())?;
    let variance = match &image.variance {
        Some(planes) => Some(array(py, planes, image.shape())?),
        None => None,
    };
    let wavelength_nm = match &image.color {
        Color::Rgb => None,
        Color::Mono { wavelength_nm } => Some(*wavelength_nm),
        Color::Bands(bands) => {
            return Err(ERROR.says(format!(
                "the image has {bands}, and Image holds RGB or one wavelength: colour-science's \
                 read_spectral_image_Fichet2021 reads them all, and `sunstone visualize \
                 --wavelength` shows one"
            )));
        }
    };
    Ok((stokes, variance, wavelength_nm, image.metadata))
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
    wavelength_nm: Option<f32>,
    metadata: Vec<(String, String)>,
) -> PyResult<StokesImage> {
    let &[height, width, channels, components] = stokes.shape() else {
        return Err(ERROR.says("an image has four axes: height, width, channels, components"));
    };
    let color = match wavelength_nm {
        Some(wavelength_nm) => Color::Mono { wavelength_nm },
        None => Color::Rgb,
    };
    if channels != color.channels() {
        let expected = color.channels();
        return Err(
            ERROR.says(format!("an image of {color} has {expected} channels, not {channels}"))
        );
    }
    let variance = variance.map(planes).transpose()?;
    let planes = planes(stokes)?;
    Ok(StokesImage { width, height, color, components, planes, variance, metadata })
}

/// Writes an image in the format that the extension names.
#[pyfunction]
pub fn save_image(
    py: Python,
    path: PathBuf,
    stokes: PyReadonlyArray4<f32>,
    variance: Option<PyReadonlyArray4<f32>>,
    wavelength_nm: Option<f32>,
    metadata: Vec<(String, String)>,
) -> PyResult<()> {
    let image = image(&stokes, variance.as_ref(), wavelength_nm, metadata)?;
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
    wavelength_nm: Option<f32>,
    map: Option<&str>,
    exposure: f32,
    full_scale: bool,
) -> PyResult<Bound<'py, PyBytes>> {
    let map: Option<Map> =
        map.map(str::parse).transpose().map_err(|text: String| ERROR.says(text))?;
    let image = image(&stokes, None, wavelength_nm, Vec::new())?;
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
