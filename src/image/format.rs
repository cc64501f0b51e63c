//! The formats of images, each a line of one list.

use std::path::{Path, PathBuf};

use super::error::OutputError;
use super::rows::Rows;
use super::{StokesImage, exr, hdr, npy, png};

/// Writes an image under a name.
pub type Write = fn(&dyn Rows, &Path) -> Result<(), OutputError>;
/// Reads the image of a name.
pub type Read = fn(&Path) -> Result<StokesImage, OutputError>;

/// A format that images are written in, read from, or both.
pub struct Format {
    /// The extension of its files' names, in lower case, without the dot.
    pub extension: &'static str,
    /// What it is and keeps, as help.
    pub summary: &'static str,
    /// Whether variances are kept.
    pub keeps_variance: bool,
    /// Whether layers are kept.
    pub keeps_layers: bool,
    /// Whether images of bands and of responses can be written.
    pub takes_many: bool,
    /// Writes an image.
    pub write: Option<Write>,
    /// Reads one.
    pub read: Option<Read>,
    /// The files that an image of a name becomes.
    pub files: fn(&Path) -> Vec<PathBuf>,
}

/// All formats.
pub static FORMATS: [Format; 4] = [
    Format {
        extension: "exr",
        summary: "OpenEXR, 32-bit float, with all Stokes components, variances and metadata.",
        keeps_variance: true,
        keeps_layers: true,
        takes_many: true,
        write: Some(exr::write),
        read: Some(exr::read),
        files: one_file,
    },
    Format {
        extension: "hdr",
        summary: "Radiance pictures NAME.S0.hdr to NAME.S3.hdr, S0 and S/S0 + 1, as Jarabo and \
                  Gutierrez 2016 store them, with 8 bits of precision.",
        keeps_variance: false,
        keeps_layers: false,
        takes_many: false,
        write: Some(|image, path| hdr::write(&image.whole(), path)),
        read: Some(hdr::read),
        files: |path| (0..4).map(|component| hdr::component_path(path, component)).collect(),
    },
    Format {
        extension: "png",
        summary: "A preview: S0 alone, as sRGB, at exposure 0 unless that is black or white.",
        keeps_variance: false,
        keeps_layers: false,
        takes_many: true,
        write: Some(|image, path| {
            let image = image.whole();
            png::write_preview(&image, path, png::exposure(&image))
        }),
        read: None,
        files: one_file,
    },
    Format {
        extension: "npy",
        summary: "A NumPy array of one wavelength; beside stokes.npy, stderr.npy if it is there.",
        keeps_variance: true,
        keeps_layers: false,
        takes_many: false,
        write: None,
        read: Some(npy::read),
        files: one_file,
    },
];

fn one_file(path: &Path) -> Vec<PathBuf> {
    vec![path.to_owned()]
}

/// The extension in lower case, without the dot; empty if there is none.
pub fn extension(path: &Path) -> String {
    path.extension().map(|part| part.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// What the format that a file's extension names has, among those that have it; `verb` is what
/// images are that can be used so, "read" or "written".
pub fn named_by<T>(
    path: &Path,
    verb: &'static str,
    of: impl Fn(&'static Format) -> Option<T>,
) -> Result<T, OutputError> {
    let extension = extension(path);
    let path = path.to_owned();
    let Some(format) = FORMATS.iter().find(|format| format.extension == extension) else {
        return Err(OutputError::Extension { path, known: extensions(of) });
    };
    of(format).ok_or_else(|| {
        let (extension, known) = (format.extension, extensions(of));
        OutputError::OneWay { path, extension, verb, known }
    })
}

/// The extensions of the formats that have something, for messages.
pub fn extensions<T>(of: impl Fn(&'static Format) -> Option<T>) -> String {
    let names = FORMATS.iter().filter(|format| of(format).is_some());
    names.map(|format| format!(".{}", format.extension)).collect::<Vec<_>>().join(", ")
}

impl Format {
    /// What writes images of bands and of responses, if that can be.
    pub fn writes_many(&self) -> Option<Write> {
        self.write.filter(|_| self.takes_many)
    }

    /// What writes images and their layers, if these are kept.
    pub fn writes_layers(&self) -> Option<Write> {
        self.write.filter(|_| self.keeps_layers)
    }

    /// What writes images and their variances, if that is kept.
    pub fn writes_variance(&self) -> Option<Write> {
        self.write.filter(|_| self.keeps_variance)
    }
}
