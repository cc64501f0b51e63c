//! What is wrong with a scene, where, and how to mend it.

use std::path::Path;

use crate::math::Fault;

/// A scene that cannot be loaded or baked. It displays as
/// `file: node, mesh, material or camera, field: what is wrong` and a second line with the remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", self.text())]
pub struct SceneError {
    file: String,
    place: String,
    problem: String,
    remedy: String,
}

impl SceneError {
    /// An error at a place within the file, with the way to mend it.
    pub(super) fn new(
        place: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            file: String::new(),
            place: place.into(),
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }

    /// The error that a fault is in the object of this name.
    pub(super) fn at(name: &str, fault: Fault) -> Self {
        let separator = if fault.field.is_empty() { "" } else { ", " };
        Self::new(format!("{name}{separator}{}", fault.field), fault.problem, fault.remedy)
    }

    /// The error that a fault is, in a field of what the caller knows.
    pub(crate) fn alone(fault: Fault) -> Self {
        Self::new(fault.field, fault.problem, fault.remedy)
    }

    /// The same error with the file's name; none if that is empty.
    #[must_use]
    pub(super) fn in_file(mut self, file: &Path) -> Self {
        self.file = file.display().to_string();
        self
    }

    /// Which object and field of the scene the error is about; empty if the whole file.
    pub fn place(&self) -> &str {
        &self.place
    }

    /// How to mend it.
    pub fn remedy(&self) -> &str {
        &self.remedy
    }

    fn text(&self) -> String {
        let heads = [&self.file, &self.place].into_iter().filter(|part| !part.is_empty());
        let mut text: String = heads.map(|part| format!("{part}: ")).collect();
        text += &self.problem;
        if !self.remedy.is_empty() {
            text += "\n  help: ";
            text += &self.remedy;
        }
        text
    }
}
