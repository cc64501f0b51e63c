//! Triangles of arrays.

use std::sync::Arc;

use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArrayLike2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use sunstone::glam::{Vec2, Vec3};

use crate::errors::SCENE_ERROR;
use crate::keys::extract;

/// Three numbers in a row, of any type.
type Vectors<'py> = PyArrayLike2<'py, f32, AllowTypeChange>;

/// Triangles, kept once for all that show them.
#[pyclass(frozen, module = "sunstone")]
pub struct Geometry(pub Arc<sunstone::world::Geometry>);

#[pymethods]
impl Geometry {
    /// Of (n, 3) positions, (m, 3) rows of these, normals or none, and (n, 2) coordinates for
    /// textures or none.
    #[new]
    #[pyo3(signature = (positions, triangles, normals=None, uv=None))]
    fn new(
        positions: Vectors,
        triangles: &Bound<PyAny>,
        normals: Option<Vectors>,
        uv: Option<Vectors>,
    ) -> PyResult<Self> {
        let vectors = |name, array: &Vectors| rows(name, array, Vec3::from_array);
        let geometry = sunstone::world::Geometry {
            positions: vectors("positions", &positions)?,
            normals: match &normals {
                Some(normals) => vectors("normals", normals)?,
                None => Vec::new(),
            },
            texture_coordinates: match &uv {
                Some(uv) => rows("uv", uv, Vec2::from_array)?,
                None => Vec::new(),
            },
            triangles: corners(triangles)?,
            ..sunstone::world::Geometry::default()
        };
        Ok(Self(Arc::new(geometry)))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let (py, this) = (slf.py(), slf.get());
        let parts = (this.positions(py)?, this.triangles(py)?, this.normals(py)?, this.uv(py)?);
        (slf.get_type(), parts).into_pyobject(py)
    }

    /// It never changes, so it is its own copy.
    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<PyAny>) -> Py<Self> {
        slf
    }

    fn __repr__(&self) -> String {
        let (triangles, vertices) = (self.0.triangles.len(), self.0.positions.len());
        format!("<sunstone.Geometry of {triangles} triangles, {vertices} vertices>")
    }

    /// A parallelogram about a center, by its half edges; pictures on it are upright along these.
    #[staticmethod]
    fn quad(center: [f32; 3], u: [f32; 3], v: [f32; 3]) -> Self {
        let [center, u, v] = [center, u, v].map(Vec3::from_array);
        let corners = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
        Self(Arc::new(sunstone::world::Geometry {
            texture_coordinates: corners.map(Vec2::from_array).to_vec(),
            ..sunstone::world::Geometry::quad(center, u, v)
        }))
    }

    /// A box along the axes, by its least and greatest corner.
    #[staticmethod]
    fn cuboid(low: [f32; 3], high: [f32; 3]) -> Self {
        let [low, high] = [low, high].map(Vec3::from_array);
        Self(Arc::new(sunstone::world::Geometry::cuboid(low, high)))
    }

    /// The positions.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        array(py, self.0.positions.iter().flat_map(|position| position.to_array()), 3)
    }

    /// The normals, if there are any.
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f32>>>> {
        match self.0.normals.is_empty() {
            true => Ok(None),
            false => {
                array(py, self.0.normals.iter().flat_map(|normal| normal.to_array()), 3).map(Some)
            }
        }
    }

    /// The coordinates for textures, if there are any.
    #[getter]
    fn uv<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f32>>>> {
        let uv = &self.0.texture_coordinates;
        match uv.is_empty() {
            true => Ok(None),
            false => array(py, uv.iter().flat_map(|pair| pair.to_array()), 2).map(Some),
        }
    }

    /// The triangles.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        array(py, self.0.triangles.iter().flatten().copied(), 3)
    }
}

/// Rows of corners; any numbers that are whole.
fn corners(triangles: &Bound<PyAny>) -> PyResult<Vec<[u32; 3]>> {
    if let Ok(exact) = triangles.extract::<PyReadonlyArray2<u32>>() {
        return rows("triangles", &exact, |triangle| triangle);
    }
    let numbers: PyArrayLike2<f64, AllowTypeChange> = extract("triangles", triangles)?;
    let whole = |number: f64| (number as u32, f64::from(number as u32) == number);
    let triangles = rows("triangles", &numbers, |triangle| triangle.map(whole))?;
    match triangles.as_flattened().iter().find(|(_, is_whole)| !is_whole) {
        Some(_) => {
            let text = "triangles: must be whole numbers from 0 to 4294967295";
            Err(SCENE_ERROR.says(text))
        }
        None => Ok(triangles.into_iter().map(|it| it.map(|(row, _)| row)).collect()),
    }
}

fn rows<T: numpy::Element + Copy, R, const K: usize>(
    name: &str,
    array: &PyReadonlyArray2<T>,
    row: impl Fn([T; K]) -> R,
) -> PyResult<Vec<R>> {
    let array = array.as_array();
    match array.shape() {
        [_, columns] if *columns == K => {
            Ok(array.outer_iter().map(|it| row(std::array::from_fn(|k| it[k]))).collect())
        }
        shape => {
            let text = format!("{name}: must have the shape (count, {K}), not {shape:?}");
            Err(SCENE_ERROR.says(text))
        }
    }
}

fn array<T: numpy::Element>(
    py: Python<'_>,
    values: impl Iterator<Item = T>,
    columns: usize,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    let values = PyArray1::from_iter(py, values);
    values.reshape([values.len()? / columns, columns])
}
