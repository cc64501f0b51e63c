//! Where files really are, so that two names of one are known as that.

use std::collections::HashMap;
use std::fs;
use std::path::{Component, Path, PathBuf};

/// Paths without links, dots and what is between them, as far as they are there; with those of
/// their folders.
#[derive(Default)]
pub struct Reals(HashMap<PathBuf, PathBuf>);

impl Reals {
    /// That of a path.
    pub fn of(&mut self, path: &Path) -> PathBuf {
        let (Some(name), Some(folder)) = (path.file_name(), path.parent()) else {
            return real(path);
        };
        let folder = self.0.entry(folder.to_owned()).or_insert_with(|| real(folder));
        real(&folder.join(name))
    }
}

fn real(path: &Path) -> PathBuf {
    let start = std::env::current_dir().unwrap_or_default().join(path);
    if let Ok(real) = fs::canonicalize(&start) {
        return real;
    }
    let mut real = PathBuf::new();
    for part in start.components() {
        match part {
            Component::ParentDir => drop(real.pop()),
            Component::CurDir => {}
            Component::Prefix(_) | Component::RootDir | Component::Normal(_) => {
                real.push(part);
                // A link, if it is one that leads somewhere.
                if fs::symlink_metadata(&real).is_ok_and(|found| found.is_symlink()) {
                    real = fs::canonicalize(&real).unwrap_or(real);
                }
            }
        }
    }
    real
}
