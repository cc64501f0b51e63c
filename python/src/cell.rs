//! A value that threads may replace at once without losing what another has put there.

use std::mem;
use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;

/// A value that is replaced only if it is still the one that was seen.
///
/// It is locked only by threads that hold the interpreter's lock, as the one that forks does: it is
/// never locked in the child.
#[pyclass(frozen, module = "sunstone._sunstone")]
pub struct Cell(Mutex<Py<PyAny>>);

#[pymethods]
impl Cell {
    /// Of a value.
    #[new]
    fn new(value: Py<PyAny>) -> Self {
        Self(Mutex::new(value))
    }

    /// The value.
    #[getter]
    fn value(&self, py: Python) -> Py<PyAny> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone_ref(py)
    }

    /// Replaces the value if it is still this one; tells whether it was.
    fn swap(&self, old: &Bound<PyAny>, new: Py<PyAny>) -> bool {
        let mut value = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_it = value.is(old);
        let before = is_it.then(|| mem::replace(&mut *value, new));
        // What ends with it may run anything.
        drop(value);
        drop(before);
        is_it
    }
}
