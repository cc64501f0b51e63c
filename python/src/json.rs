//! JSON of Python's values, and back: what scenes and job files are made of.

use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyMappingProxy, PyString, PyTuple};
use serde_json::{Map, Number, Value};
use sunstone::Edit;
use sunstone::internals::math::text::sentence;

use crate::errors::SCENE_ERROR;

/// Deepest nesting: what is deeper is likely to contain itself.
const DEPTH_MAX: usize = 64;

/// Edits by target.
pub fn edits(edits: &Bound<PyDict>) -> PyResult<Vec<Edit>> {
    let edit = |(target, value): (Bound<PyAny>, Bound<PyAny>)| {
        let target: String = target.extract()?;
        let value = of_python(&target, &value, 0)?;
        Ok(Edit { target, value })
    };
    edits.iter().map(edit).collect()
}

/// A value as JSON; `place` is what errors call it.
fn of_python(place: &str, value: &Bound<PyAny>, depth: usize) -> PyResult<Value> {
    let refuse = |problem: &str| Err(SCENE_ERROR.says(sentence(place, problem)));
    if depth > DEPTH_MAX {
        return refuse("is nested too deeply");
    }
    if value.is_none() {
        return Ok(Value::Null);
    }
    if let Ok(is) = value.cast::<PyBool>() {
        return Ok(is.is_true().into());
    }
    if value.is_instance_of::<PyInt>() {
        let small = value.extract::<i64>().map(Number::from);
        return match small.or_else(|_| value.extract::<u64>().map(Number::from)) {
            Ok(number) => Ok(Value::Number(number)),
            Err(_) => refuse("the number is too large"),
        };
    }
    if let Ok(number) = value.cast::<PyFloat>() {
        return match Number::from_f64(number.extract()?) {
            Some(number) => Ok(Value::Number(number)),
            None => refuse("must be finite"),
        };
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Value::String(text.extract()?));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let items = value.try_iter()?.map(|item| of_python(place, &item?, depth + 1));
        return Ok(Value::Array(items.collect::<PyResult<_>>()?));
    }
    if let Ok(table) = value.cast::<PyDict>() {
        let item = |(key, value): (Bound<PyAny>, Bound<PyAny>)| {
            Ok((key.extract::<String>()?, of_python(place, &value, depth + 1)?))
        };
        let table: Map<String, Value> = table.iter().map(item).collect::<PyResult<_>>()?;
        return Ok(Value::Object(table));
    }
    refuse(&format!("cannot be a {}", value.get_type().name()?))
}

/// JSON as values that cannot be changed: lists are tuples, objects are mappings to be read.
pub fn to_python<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    match value {
        Value::Null => Ok(py.None().into_bound(py)),
        Value::Bool(is) => is.into_bound_py_any(py),
        Value::Number(number) => match (number.as_i64(), number.as_u64()) {
            (Some(number), _) => number.into_bound_py_any(py),
            (None, Some(number)) => number.into_bound_py_any(py),
            (None, None) => number.as_f64().into_bound_py_any(py),
        },
        Value::String(text) => text.into_bound_py_any(py),
        Value::Array(items) => {
            let items = items.iter().map(|item| to_python(py, item));
            Ok(PyTuple::new(py, items.collect::<PyResult<Vec<_>>>()?)?.into_any())
        }
        Value::Object(table) => {
            let items = table.iter().map(|(key, value)| (key.as_str(), value));
            Ok(PyMappingProxy::new(py, dict(py, items)?.as_mapping()).into_any())
        }
    }
}

/// The items of an object in their order, as [`to_python`] has them.
pub fn dict<'py, 'a>(
    py: Python<'py>,
    items: impl Iterator<Item = (&'a str, &'a Value)>,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (key, value) in items {
        dict.set_item(key, to_python(py, value)?)?;
    }
    Ok(dict)
}
