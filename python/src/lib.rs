//! Sunstone from Python: what `sunstone/*.py` builds on. Nothing here renders or knows optics; it
//! turns Python's values into the library's, waits with the interpreter free, and hands back
//! arrays.
//!
//! | module | holds |
//! |---|---|
//! | `errors` | the library's errors as Python's |
//! | `threads` | pools, which no fork can take along |
//! | `wait` | work on another thread, and the interpreter free meanwhile |
//! | `options` | what `render` is asked for |
//! | `scene` | a placed world: loaded, described, edited, rendered |
//! | `batch` | many renders from one job file |
//! | `cell` | a value that threads replace without losing what others put there |
//! | `image` | arrays to images and back, files, pictures |
//! | `words` | the library's texts, with options as Python calls them |
//! | `json` | values of scene files and job files |
//! | `keys` | keyword arguments, each used or refused |
//! | `material`, `medium`, `geometry`, `place` | what worlds are made of |
//! | `world` | worlds made in code |

mod batch;
mod cell;
mod errors;
mod geometry;
mod image;
mod json;
mod keys;
mod material;
mod medium;
mod options;
mod place;
mod scene;
mod spectra;
mod textures;
mod threads;
mod wait;
mod words;
mod world;

use pyo3::prelude::*;

/// The native part of the package `sunstone`.
#[pymodule]
mod _sunstone {
    use pyo3::exceptions::PyImportError;
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::batch::Batch;
    #[pymodule_export]
    use super::cell::Cell;
    #[pymodule_export]
    use super::geometry::Geometry;
    #[pymodule_export]
    use super::image::{
        about_channels, channel_at, checked_bands, load_image, picture, save_image,
    };

    #[pymodule_export]
    use super::scene::{Scene, keys_of, load};
    #[pymodule_export]
    use super::world::World;

    /// `sunstone/_processor.py` has asked before this was loaded, as instructions that the
    /// processor does not know may come before any line of ours. What it cannot see, this may.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        if let Some(text) = sunstone::internals::cli::processor::refusal() {
            return Err(PyImportError::new_err(text));
        }
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
