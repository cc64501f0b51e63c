//! What is wrong with a scene, where, and how to mend it.

use std::collections::HashSet;
use std::io;
use std::path::Path;

use crate::files;
use crate::math::Fault;
use crate::math::text::{excerpt, sentence};

/// Most troubles that one error tells; the others are counted.
const TOLD_MAX: usize = 10;
/// Most characters of each part of what is told: names and values are a file's.
const CHARACTERS_MAX: usize = 1000;

/// A scene that cannot be loaded or baked. It displays as
/// `file: node, mesh, material or camera, field: what is wrong` and a second line with the remedy;
/// if several things are wrong, as a list of such lines.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", self.text())]
pub struct SceneError {
    file: String,
    /// At least one.
    troubles: Vec<Trouble>,
    /// How many more there are.
    more: usize,
}

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Trouble {
    place: String,
    problem: String,
    remedy: String,
    /// Whether it may be gone a moment later.
    may_pass: bool,
}

impl SceneError {
    /// An error at a place within the file, with the way to mend it.
    pub(super) fn new(
        place: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        let [place, problem, remedy] = [place.into(), problem.into(), remedy.into()]
            .map(|part| excerpt(&part, CHARACTERS_MAX));
        let trouble = Trouble { place, problem, remedy, may_pass: false };
        Self { file: String::new(), troubles: vec![trouble], more: 0 }
    }

    /// The same error, which is that the system cannot read something.
    #[must_use]
    pub(super) fn of_system(mut self, error: io::ErrorKind) -> Self {
        self.troubles.iter_mut().for_each(|it| it.may_pass = files::may_pass(error));
        self
    }

    /// Whether the same scene may be read a moment later.
    pub(crate) fn may_pass(&self) -> bool {
        self.more == 0 && self.troubles.iter().all(|trouble| trouble.may_pass)
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
        self.file = excerpt(&file.display().to_string(), CHARACTERS_MAX);
        self
    }

    /// Which object and field of the scene the (first) error is about; empty if the whole file.
    pub fn place(&self) -> &str {
        &self.troubles[0].place
    }

    /// What is wrong.
    pub(super) fn problem(&self) -> &str {
        &self.troubles[0].problem
    }

    /// How to mend it.
    pub fn remedy(&self) -> &str {
        &self.troubles[0].remedy
    }

    fn text(&self) -> String {
        let file = if self.file.is_empty() { String::new() } else { format!("{}: ", self.file) };
        if let [only] = &self.troubles[..] {
            let help = only.help().map_or_else(String::new, |help| format!("\n{help}"));
            let line = match only.place.is_empty() {
                true => sentence(&self.file, &only.problem),
                false => format!("{file}{}", only.line()),
            };
            return format!("{line}{help}");
        }
        let mut lines = vec![format!("{file}{} things are wrong", self.troubles.len() + self.more)];
        for (index, trouble) in self.troubles.iter().enumerate() {
            lines.push(format!("  {}", trouble.line()));
            // Troubles of one kind have one remedy, which is told behind the last of them.
            let is_said_again =
                self.troubles.get(index + 1).is_some_and(|next| next.remedy == trouble.remedy);
            lines.extend(trouble.help().filter(|_| !is_said_again));
        }
        if self.more > 0 {
            lines.push(format!("  and {} more", self.more));
        }
        lines.join("\n")
    }
}

impl Trouble {
    fn line(&self) -> String {
        sentence(&self.place, &self.problem)
    }

    fn help(&self) -> Option<String> {
        (!self.remedy.is_empty()).then(|| format!("  help: {}", self.remedy))
    }
}

/// Everything that is wrong, so that a user hears of it at once and not of one after the other.
#[derive(Default)]
pub(super) struct Findings {
    troubles: Vec<Trouble>,
    seen: HashSet<Trouble>,
    more: usize,
}

impl Findings {
    /// What went well; what did not is kept in mind, once.
    pub fn note<T>(&mut self, result: Result<T, SceneError>) -> Option<T> {
        let error = match result {
            Ok(value) => return Some(value),
            Err(error) => error,
        };
        self.more += error.more;
        for trouble in error.troubles {
            if !self.seen.insert(trouble.clone()) {
                continue;
            }
            if self.troubles.len() < TOLD_MAX {
                self.troubles.push(trouble);
            } else {
                self.more += 1;
            }
        }
        None
    }

    /// All that has been noted as one error.
    pub fn result(self) -> Result<(), SceneError> {
        let Self { troubles, more, .. } = self;
        if troubles.is_empty() {
            return Ok(());
        }
        Err(SceneError { file: String::new(), troubles, more })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_found_is_told_once_and_not_without_end() {
        let mut findings = Findings::default();
        for number in [1, 1, 2] {
            findings.note::<()>(Err(SceneError::new(format!("node {number}"), "bad", "mend it")));
        }
        let error = findings.result().unwrap_err().in_file(Path::new("a.gltf"));
        let expected = "a.gltf: 2 things are wrong\n  node 1: bad\n  node 2: bad\n  help: mend it";
        assert_eq!(error.to_string(), expected);
        assert_eq!((error.place(), error.remedy()), ("node 1", "mend it"));

        let mut many = Findings::default();
        for number in 0..50 {
            many.note::<()>(Err(SceneError::new(format!("node {number}"), "bad", "")));
        }
        let text = many.result().unwrap_err().to_string();
        assert!(text.starts_with("50 things are wrong\n") && text.ends_with("\n  and 40 more"));
        assert_eq!(Findings::default().note(Ok(7)), Some(7));
        assert!(Findings::default().result().is_ok());
    }

    #[test]
    fn names_of_files_and_objects_do_not_act_on_terminals() {
        let error = SceneError::new("node 0 \"\x1b[2J\nerror: \"", "bad", "");
        let text = error.in_file(Path::new("a\n.gltf")).to_string();
        assert_eq!(text, "a\\n.gltf: node 0 \"\\u{1b}[2J\\nerror: \": bad");
    }
}
