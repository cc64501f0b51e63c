//! The library's errors as Python's classes, with the library's own text.

use std::io;
use std::path::Path;

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;
use sunstone::{Error, ImageError, RenderError, SceneError, SettingsError, ThreadsError};

use crate::words::in_python;

/// A class of `sunstone/_errors.py`.
pub struct Class {
    name: &'static str,
    class: PyOnceLock<Py<PyType>>,
}

/// `sunstone.Error`.
pub static ERROR: Class = Class::named("Error");
/// `sunstone.SceneError`.
pub static SCENE_ERROR: Class = Class::named("SceneError");
/// `sunstone.RenderError`.
pub static RENDER_ERROR: Class = Class::named("RenderError");

impl Class {
    const fn named(name: &'static str) -> Self {
        Self { name, class: PyOnceLock::new() }
    }

    /// An error of this class that says so.
    pub fn says(&self, text: impl ToString) -> PyErr {
        let text = in_python(&text.to_string());
        Python::attach(|py| match self.class.import(py, "sunstone._errors", self.name) {
            Ok(class) => PyErr::from_type(class.clone(), text),
            Err(error) => error,
        })
    }
}

/// What is wrong with a scene.
pub fn of_scene(error: SceneError) -> PyErr {
    SCENE_ERROR.says(error)
}

/// What is wrong with an option, which the library calls otherwise than Python in two cases.
pub fn of_settings(SettingsError { setting, rule }: SettingsError) -> PyErr {
    let option = match setting {
        "samples" => "spp",
        "path_length_max" => "max_path_length",
        option => option,
    };
    RENDER_ERROR.says(format!("{option} {rule}"))
}

/// What keeps a world from being placed, or a render from beginning.
pub fn of_render(error: RenderError) -> PyErr {
    match error {
        RenderError::Scene(error) => of_scene(error),
        RenderError::Settings(error) => of_settings(error),
        RenderError::Memory(error) => RENDER_ERROR.says(error),
    }
}

/// What keeps threads from starting.
pub fn of_threads(error: ThreadsError) -> PyErr {
    RENDER_ERROR.says(error)
}

/// Whatever the library says of a world that is made in code.
pub fn of_any(error: impl Into<Error>) -> PyErr {
    match error.into() {
        Error::Scene(error) => of_scene(error),
        Error::Settings(error) => of_settings(error),
        Error::Threads(error) => of_threads(error),
        Error::Image(error) => of_image(error),
        Error::Part(error) => RENDER_ERROR.says(error),
        Error::Memory(error) => RENDER_ERROR.says(error),
    }
}

/// What is wrong with a file of an image, or with the image for that file.
pub fn of_image(error: ImageError) -> PyErr {
    let text = error.to_string();
    match error {
        ImageError::Write { path, source, .. } | ImageError::Read { path, source } => {
            of_system(&path, &source, text)
        }
        ImageError::NotAFile { path, what } => match what {
            "a folder" => os_error(libc_codes::EISDIR, text, &path),
            _ => os_error(libc_codes::EINVAL, text, &path),
        },
        ImageError::ReadOnly { path } => os_error(libc_codes::EACCES, text, &path),
        ImageError::Malformed { .. }
        | ImageError::Unwritable { .. }
        | ImageError::Extension { .. }
        | ImageError::OneWay { .. }
        | ImageError::Image { .. }
        | ImageError::NoBand { .. }
        | ImageError::NoChannel { .. }
        | ImageError::NoPixel { .. }
        | ImageError::Sensor(_)
        | ImageError::Mismatch { .. } => ERROR.says(text),
    }
}

/// What the system says of a file; Python makes a FileNotFoundError of it, say, by the number.
pub fn of_system(path: &Path, source: &io::Error, text: String) -> PyErr {
    match source.raw_os_error() {
        Some(number) => os_error(number, text, path),
        None => PyOSError::new_err(text),
    }
}

/// Python writes the number before the text and the path behind it.
fn os_error(number: i32, text: String, path: &Path) -> PyErr {
    let path = path.display().to_string();
    let text = text.replace(&format!(" (os error {number})"), "").replace(&format!(" {path}"), "");
    let text = text.strip_prefix(&format!("{path} ")).unwrap_or(&text);
    PyOSError::new_err((number, in_python(text), path))
}

/// The numbers that every Unix has given these since the first.
mod libc_codes {
    pub const EACCES: i32 = 13;
    pub const EISDIR: i32 = 21;
    pub const EINVAL: i32 = 22;
}
