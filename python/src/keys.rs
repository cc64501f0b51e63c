//! Keyword arguments of something that is made: each is used, or refused by name.

use pyo3::exceptions::{PyOverflowError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyList, PyTuple};

use sunstone::internals::math::text::sentence;

use crate::errors::SCENE_ERROR;

/// What is left of the keyword arguments of an object.
pub struct Keys<'py> {
    /// What errors call the object.
    place: String,
    left: Bound<'py, PyDict>,
}

impl<'py> Keys<'py> {
    /// Those of an object that errors call so.
    pub fn of(place: impl Into<String>, keys: &Bound<'py, PyDict>) -> PyResult<Self> {
        Ok(Self { place: place.into(), left: keys.copy()? })
    }

    /// Takes the value of a key, if it is there.
    pub fn take<T>(&self, key: &str) -> PyResult<Option<T>>
    where
        T: for<'a> FromPyObject<'a, 'py>,
    {
        let Some(value) = self.left.get_item(key)? else { return Ok(None) };
        self.left.del_item(key)?;
        if value.is_none() {
            return Ok(None);
        }
        extract(&self.place_of(key), &value).map(Some).map_err(|error| {
            // An error of arithmetics says less than one of the value.
            match error.is_instance_of::<PyOverflowError>(value.py()) {
                true => SCENE_ERROR.says(error.value(value.py())),
                false => error,
            }
        })
    }

    /// Whether a key is there still.
    pub fn has(&self, key: &str) -> PyResult<bool> {
        Ok(self.left.get_item(key)?.is_some_and(|value| !value.is_none()))
    }

    /// Takes what is true or false.
    pub fn flag(&self, key: &str) -> PyResult<bool> {
        self.flag_or(key, false)
    }

    /// Takes what is true or false, or else is what it is `by_default`.
    pub fn flag_or(&self, key: &str, by_default: bool) -> PyResult<bool> {
        let Some(value) = self.left.get_item(key)? else { return Ok(by_default) };
        self.left.del_item(key)?;
        if value.is_none() {
            return Ok(by_default);
        }
        flag(&self.place_of(key), &value)
    }

    /// Takes the value of a key that must be there.
    pub fn need<T>(&self, key: &str, remedy: &str) -> PyResult<T>
    where
        T: for<'a> FromPyObject<'a, 'py>,
    {
        self.take(key)?.ok_or_else(|| self.refuse(key, "is missing", remedy))
    }

    /// What errors call a part of the object.
    pub fn place_of(&self, part: &str) -> String {
        format!("{}, {part}", self.place)
    }

    /// Takes an object within this one.
    pub fn part(&self, key: &str) -> PyResult<Option<Keys<'py>>> {
        let part: Option<Bound<PyDict>> = self.take(key)?;
        part.map(|part| Keys::of(self.place_of(key), &part)).transpose()
    }

    /// Refuses what nothing has taken.
    pub fn finish(self, what: &str) -> PyResult<()> {
        match self.left.keys().iter().next() {
            Some(key) => {
                Err(self.refuse(&key.str()?.to_string(), &format!("means nothing for {what}"), ""))
            }
            None => Ok(()),
        }
    }

    /// Refuses the value of a key, or the whole if the key is empty.
    pub fn refuse(&self, key: &str, problem: &str, remedy: &str) -> PyErr {
        let separator = if key.is_empty() { "" } else { ", " };
        let help = match remedy {
            "" => String::new(),
            remedy => format!("\n  help: {remedy}"),
        };
        let place = format!("{}{separator}{key}", self.place);
        SCENE_ERROR.says(sentence(&place, problem) + &help)
    }

    /// The error of the library for a part of this object that it has refused to make.
    pub fn fault(&self, fault: &sunstone::particles::Fault) -> PyErr {
        self.refuse(&fault.field, &fault.problem, &fault.remedy)
    }
}

/// A value as what is wanted; if it is none, the error says where it stands.
pub fn extract<'py, T>(place: &str, value: &Bound<'py, PyAny>) -> PyResult<T>
where
    T: for<'a> FromPyObject<'a, 'py>,
{
    if holds_truth(value) {
        let text = sentence(place, "must be a number, not True or False");
        return Err(PyTypeError::new_err(text));
    }
    value.extract::<T>().map_err(|error| named(place, value, error.into()))
}

/// What is true or false, and nothing else.
pub fn flag(place: &str, value: &Bound<PyAny>) -> PyResult<bool> {
    value.extract::<bool>().map_err(|error| named(place, value, error))
}

/// Whether a value is true or false, which Python takes for 1 and 0, or a list with such.
pub fn holds_truth(value: &Bound<PyAny>) -> bool {
    if let Ok(list) = value.cast::<PyList>() {
        return list.iter().any(|item| holds_truth(&item));
    }
    if let Ok(tuple) = value.cast::<PyTuple>() {
        return tuple.iter().any(|item| holds_truth(&item));
    }
    value.is_instance_of::<PyBool>()
}

/// The same error, which says where the value stands.
fn named(place: &str, value: &Bound<PyAny>, error: PyErr) -> PyErr {
    let text = sentence(place, &error.value(value.py()).to_string());
    PyErr::from_type(error.get_type(value.py()), text)
}
