//! Writing a file as a whole or not at all.
//!
//! bytes -> a temporary file in the folder of the target -> fsync -> rename over the target. A
//! reader (or a crash) never sees half a file, and a failure leaves the former file untouched.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::error::OutputError;
use crate::files::temporary;

/// Writes `bytes` to `path`, replacing a file that is there.
///
/// A symbolic link is followed, so that the file it points to is replaced and not the link.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    write_set(&[(path.to_owned(), bytes.to_vec())])
}

/// Writes several files that belong together: none of them is replaced before all are on the disk.
pub fn write_set(files: &[(PathBuf, Vec<u8>)]) -> Result<(), OutputError> {
    let mut staged = Vec::with_capacity(files.len());
    for (path, bytes) in files {
        staged.push((path, Staged::new(path, |file| file.write_all(bytes))?));
    }
    for (path, file) in staged {
        file.commit().map_err(|error| OutputError::write(path, error))?;
    }
    Ok(())
}

/// Writes what `fill` writes to `path`, as [`write`] does: for what is too large to be in memory
/// twice.
pub fn write_with(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), OutputError> {
    let staged = Staged::new(path, fill)?;
    staged.commit().map_err(|error| OutputError::write(path, error))
}

/// Checks that `path` could be written, by creating and removing a temporary file beside it.
///
/// To be called before a long render, so that hours of work do not end in "no such folder".
pub fn probe_writable(path: &Path) -> Result<(), OutputError> {
    Staged::new(path, |_| Ok(())).map(drop)
}

/// Checks that `path` is the name of nothing that could not be replaced. Nothing is written.
pub fn probe_name(path: &Path) -> Result<(), OutputError> {
    resolve(path).map(drop)
}

/// The folder in which `path` lies; `.` where the name has none.
pub fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// A complete temporary file that waits to take its name; removed if it is dropped before.
struct Staged {
    temporary: PathBuf,
    target: PathBuf,
    committed: bool,
}

impl Staged {
    fn new(
        path: &Path,
        fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> Result<Self, OutputError> {
        let target = resolve(path)?;
        let failed = |error| OutputError::write(path, error);
        let (file, temporary) = temporary::create(&folder_of(&target)).map_err(failed)?;
        let staged = Self { temporary, target, committed: false };
        staged.fill(file, fill).map_err(failed)?;
        Ok(staged)
    }

    fn fill(
        &self,
        file: File,
        fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut writer = BufWriter::new(file);
        fill(&mut writer)?;
        let file = writer.into_inner().map_err(io::IntoInnerError::into_error)?;
        if let Ok(former) = fs::metadata(&self.target) {
            file.set_permissions(former.permissions())?;
        }
        file.sync_all()
    }

    fn commit(mut self) -> io::Result<()> {
        fs::rename(&self.temporary, &self.target)?;
        self.committed = true;
        // Makes the new name itself durable. Not every file system can sync a folder, and the file
        // is complete under its name either way, so a refusal here is no failure.
        let _ = File::open(folder_of(&self.target)).and_then(|folder| folder.sync_all());
        Ok(())
    }
}

impl Drop for Staged {
    fn drop(&mut self) {
        if !self.committed {
            // Nothing sensible can be done if even the removal fails; the first error is reported.
            let _ = fs::remove_file(&self.temporary);
        }
    }
}

/// Most bytes of a file's name, on all systems that are in use.
const NAME_MAX: usize = 255;

/// Follows a link, and refuses what is not a file, as renaming over a device would destroy it, what
/// may not be written, as renaming does not ask, and names that no file can have.
fn resolve(path: &Path) -> Result<PathBuf, OutputError> {
    let not_a_file = |what| OutputError::NotAFile { path: path.to_owned(), what };
    // Where the folder is not there yet, the system says nothing of the name.
    if path.components().any(|part| part.as_os_str().len() > NAME_MAX) {
        let error = io::Error::from(ErrorKind::InvalidFilename);
        return Err(OutputError::write(path, error));
    }
    if path.file_name().is_none() {
        return Err(not_a_file("a folder"));
    }
    match fs::metadata(path) {
        Ok(found) if found.is_dir() => Err(not_a_file("a folder")),
        Ok(found) if !found.is_file() => Err(not_a_file("a device or pipe")),
        Ok(found) if found.permissions().readonly() || is_denied(path) => {
            Err(OutputError::ReadOnly { path: path.to_owned() })
        }
        Ok(_) => fs::canonicalize(path).map_err(|error| OutputError::write(path, error)),
        Err(error) => match error.kind() {
            // With a zero byte; with a file for a folder.
            ErrorKind::InvalidInput | ErrorKind::InvalidFilename | ErrorKind::NotADirectory => {
                Err(OutputError::write(path, error))
            }
            _ => Ok(path.to_owned()),
        },
    }
}

/// Whether the system refuses to open a file for writing. Nothing is written.
fn is_denied(path: &Path) -> bool {
    let opened = OpenOptions::new().append(true).open(path);
    opened.is_err_and(|error| error.kind() == ErrorKind::PermissionDenied)
}
