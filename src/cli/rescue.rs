//! Writing an image that took hours: where it was to go, or else where it can.

use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;
use std::{env, fs, io};

use super::CliError;
use super::files::say;
use crate::image::rows::Rows;
use crate::image::{self, OutputError};

/// Time before a second try: a disk may have been full for a moment.
const PAUSE: Duration = Duration::from_secs(1);

/// Writes an image. If that fails, tries again, in the folder made anew if it is gone; then under
/// a free name in the current folder and that of temporary files.
///
/// # Errors
/// When the image is not under the name that was asked for: with the reason, and where it is.
pub(super) fn save(image: &dyn Rows, path: &Path) -> Result<(), CliError> {
    save_by(|path| image::save(image, path), path)
}

/// The same for whatever `write` writes to a path.
///
/// # Errors
/// As those of [`save`].
pub(super) fn save_by(
    mut write: impl FnMut(&Path) -> Result<(), OutputError>,
    path: &Path,
) -> Result<(), CliError> {
    let Err(error) = write(path) else { return Ok(()) };
    if !matches!(
        error,
        OutputError::Write { .. } | OutputError::NotAFile { .. } | OutputError::ReadOnly { .. }
    ) {
        return Err(error.into());
    }
    if is_missing(&error) && fs::create_dir_all(image::folder_of(path)).is_ok() {
        say(format_args!("warning: the folder of {} was gone: made anew", path.display()));
    } else {
        say(format_args!("warning: {error}: trying again"));
        thread::sleep(PAUSE);
    }
    let Err(error) = write(path) else { return Ok(()) };
    for folder in [PathBuf::from("."), env::temp_dir()] {
        let Some(other) = free_name(&folder, path) else { continue };
        match write(&other) {
            Ok(()) => {
                let other = fs::canonicalize(&other).unwrap_or(other);
                let text = format!("{error}\n  it is in {}", other.display());
                return Err(CliError::System(text));
            }
            Err(error) => say(format_args!("warning: {error}")),
        }
    }
    Err(error.into())
}

fn is_missing(error: &OutputError) -> bool {
    matches!(error, OutputError::Write { source, .. } if source.kind() == io::ErrorKind::NotFound)
}

/// The name of a file in a folder, with a number if it is taken.
fn free_name(folder: &Path, path: &Path) -> Option<PathBuf> {
    const TRIED: u32 = 1000;
    let (stem, extension) = (path.file_stem()?, path.extension()?);
    let numbered = |number: u32| {
        let mut name = stem.to_owned();
        if number > 0 {
            name.push(format!("-{number}"));
        }
        name.push(".");
        name.push(extension);
        folder.join(name)
    };
    let is_free = |path: &PathBuf| {
        let files = image::files_of(path).unwrap_or_else(|_| vec![path.clone()]);
        files.iter().all(|file| !file.exists())
    };
    (0..TRIED).map(numbered).find(is_free)
}
