//! What is done to measure: renders on the clock, one module for each report.

mod clock;
pub mod error;
pub mod overhead;
pub mod scaling;
pub mod subject;
pub mod table1;
pub mod wavelengths;

pub use clock::processors;
pub use subject::Subject;

use crate::image::OutputError;
use crate::render::threads::ThreadsError;
use crate::render::{Options, RenderError, SettingsError};
use crate::scene::SceneError;

/// What ends a measurement early.
#[derive(Debug, thiserror::Error)]
pub enum MeasureError {
    /// A render is refused.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Threads could not be started.
    #[error(transparent)]
    Threads(#[from] ThreadsError),
    /// Images do not match.
    #[error(transparent)]
    Output(#[from] OutputError),
}

impl From<SettingsError> for MeasureError {
    fn from(error: SettingsError) -> Self {
        Self::Render(RenderError::Settings(error))
    }
}

impl From<SceneError> for MeasureError {
    fn from(error: SceneError) -> Self {
        Self::Render(RenderError::Scene(error))
    }
}

/// What the channels of a render stand for, and what light is carried at if it is not that.
fn color_in_words(options: &Options) -> String {
    match options.spectral {
        Some(spectral) => format!("{} of {} wavelengths", options.color, spectral.wavelengths),
        None => options.color.to_string(),
    }
}

/// Is told how far a measurement is.
pub trait Watch {
    /// What is measured now.
    fn at(&self, what: &str);
    /// Another of its rounds is done.
    fn round(&self);
}
