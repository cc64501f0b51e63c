//! The one error of this floor: every message names the file, and says how to mend it if it can.

use std::io;
use std::path::{Path, PathBuf};

use crate::math::Fault;

/// What can go wrong with a file that this floor reads or writes.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// A file could not be written.
    #[error("cannot write {}: {source}; {remedy}", path.display())]
    Write {
        /// The file that was to be written.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
        /// What the user can do about it.
        remedy: String,
    },
    /// The name to be written is taken by something that is not a file.
    #[error("cannot write {}: it is {what}; choose the name of a file", path.display())]
    NotAFile {
        /// The name that was to be written.
        path: PathBuf,
        /// What stands there: a folder, a device.
        what: &'static str,
    },
    /// The file that stands under the name may be read and not written.
    #[error(
        "cannot write {}: the file that is there is read-only; make it writable or choose another \
         name", path.display()
    )]
    ReadOnly {
        /// The name that was to be written.
        path: PathBuf,
    },
    /// A file could not be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file that was to be read.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// A file was read but is not what its name promises.
    #[error("{} is not a usable {format} file: {reason}", path.display())]
    Malformed {
        /// The file that was read.
        path: PathBuf,
        /// The format it was read as.
        format: &'static str,
        /// What is wrong with it.
        reason: String,
    },
    /// The image cannot be stored in the format, or at all.
    #[error("cannot write {}: {reason}", path.display())]
    Unwritable {
        /// The file that was to be written.
        path: PathBuf,
        /// What is wrong with the image.
        reason: String,
    },
    /// The extension of the name says nothing to Sunstone.
    #[error("cannot tell the format of {}: the extension must be one of {known}", path.display())]
    Extension {
        /// The name that was given.
        path: PathBuf,
        /// The extensions that would do.
        known: String,
    },
    /// The format can be written and not read, or the other way round.
    #[error(
        "{}: .{extension} files cannot be {verb}; those that can end in {known}", path.display()
    )]
    OneWay {
        /// The name that was given.
        path: PathBuf,
        /// Its extension.
        extension: &'static str,
        /// What cannot be done with it.
        verb: &'static str,
        /// The extensions that would do.
        known: String,
    },
    /// An image that cannot be shown or judged as was asked.
    #[error("the image cannot be used: {reason}")]
    Image {
        /// What is wrong with it.
        reason: &'static str,
    },
    /// A wavelength that is in none of the channels.
    #[error(
        "the image has {what}, and none of that has {wavelength_nm} nm; `inspect` lists the bands \
         of an image"
    )]
    NoBand {
        /// What the channels of the image stand for.
        what: String,
        /// What was asked for.
        wavelength_nm: f32,
    },
    /// A channel that is not there.
    #[error("the image has no channel that is called `{name}`; it has {known}")]
    NoChannel {
        /// What was asked for.
        name: String,
        /// The channels, in words.
        known: String,
    },
    /// A pixel that is not there.
    #[error(
        "the image has no pixel {x},{y}: it is {width} x {height} pixels, counted from 0,0 at the \
         upper left"
    )]
    NoPixel {
        /// How many pixels it is from the left.
        x: usize,
        /// And from the top.
        y: usize,
        /// Width of the image in pixels.
        width: usize,
        /// Its height.
        height: usize,
    },
    /// A sensor that is none.
    #[error("there is no such sensor: {0}")]
    Sensor(Fault),
    /// Two images that do not go together.
    #[error("cannot compare {first} with {second}: {reason}")]
    Mismatch {
        /// What the first image is.
        first: String,
        /// What the second image is.
        second: String,
        /// Which property differs.
        reason: String,
    },
}

impl OutputError {
    /// Wraps what the operating system said when `path` was written.
    pub fn write(path: &Path, source: io::Error) -> Self {
        let remedy = remedy(path, &source);
        Self::Write { path: path.to_owned(), source, remedy }
    }

    /// Wraps what the operating system said when `path` was read.
    pub fn read(path: &Path, source: io::Error) -> Self {
        Self::Read { path: path.to_owned(), source }
    }

    /// What the operating system said, if it is that.
    pub fn of_system(&self) -> Option<&io::Error> {
        match self {
            Self::Write { source, .. } | Self::Read { source, .. } => Some(source),
            Self::NotAFile { .. }
            | Self::ReadOnly { .. }
            | Self::Malformed { .. }
            | Self::Unwritable { .. }
            | Self::Extension { .. }
            | Self::OneWay { .. }
            | Self::Image { .. }
            | Self::NoBand { .. }
            | Self::NoChannel { .. }
            | Self::NoPixel { .. }
            | Self::Sensor(_)
            | Self::Mismatch { .. } => None,
        }
    }

    /// Says what is wrong with the contents of `path`.
    pub fn malformed(path: &Path, format: &'static str, reason: impl ToString) -> Self {
        Self::Malformed { path: path.to_owned(), format, reason: reason.to_string() }
    }

    /// Says why an image cannot be written to `path`.
    pub fn unwritable(path: &Path, reason: impl ToString) -> Self {
        Self::Unwritable { path: path.to_owned(), reason: reason.to_string() }
    }
}

fn remedy(path: &Path, error: &io::Error) -> String {
    let folder = super::atomic::folder_of(path);
    let folder = folder.display();
    match error.kind() {
        io::ErrorKind::NotFound => format!("create the folder {folder} first"),
        io::ErrorKind::NotADirectory => format!("{folder} is not a folder; choose another name"),
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            format!("make the folder {folder} writable or choose another")
        }
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            format!("free space on the disk that holds {folder} or choose another")
        }
        io::ErrorKind::InvalidFilename => "choose a shorter or plainer name".to_owned(),
        _ => format!("check the folder {folder}"),
    }
}
