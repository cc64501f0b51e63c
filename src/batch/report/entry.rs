//! What a page has of one job.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::figures::{Figures, finite};
use super::link::link;
use super::thumbnail::Thumbnail;
use crate::batch::order::checksum_of_image;
use crate::batch::results::Record;
use crate::batch::values::Values;
use crate::image;
use crate::math::text::{excerpt, printable};

/// Most characters of a name, and of a cause.
const NAME: usize = 1000;
const CAUSE: usize = 10_000;

/// A job on the page.
#[derive(Serialize)]
pub struct Entry {
    jobs: String,
    index: usize,
    name: String,
    values: Values,
    output: String,
    /// The address of the image from the page.
    link: Option<String>,
    seconds: f64,
    /// Why there is no image.
    pub error: Option<String>,
    /// Why the image that was rendered cannot be shown.
    pub problem: Option<String>,
    /// Whether the image is not the one that was rendered.
    pub changed: bool,
    /// Whether it has failed, and there is an image of a former run under its name.
    pub former: bool,
    image: Option<Shown>,
}

/// An image on the page.
#[derive(Serialize)]
struct Shown {
    width: usize,
    height: usize,
    channels: Vec<String>,
    /// The bands or responses that it has, in words; what is shown is what the eye sees of them, or
    /// their mean.
    many: Option<String>,
    components: usize,
    #[serde(flatten)]
    figures: Figures,
    thumbnail: Thumbnail,
}

/// Where images are looked for, and what becomes of them.
pub struct Place {
    folder: PathBuf,
    /// The same without links and dots; nothing if it is not there.
    real: Option<PathBuf>,
    page: Option<PathBuf>,
    allow_outside: bool,
    edge: usize,
}

impl Place {
    /// Images of a folder for a page in another.
    pub fn new(folder: &Path, page: &Path, allow_outside: bool, edge: usize) -> Self {
        let [real, page] = [folder, page].map(|path| path.canonicalize().ok());
        Self { folder: folder.to_owned(), real, page, allow_outside, edge }
    }

    /// What the files of a record take, in bytes.
    pub fn bytes_of(&self, record: &Record) -> u64 {
        let files = image::files_of(&self.folder.join(&record.output)).unwrap_or_default();
        let bytes = |file: &PathBuf| fs::metadata(file).map_or(0, |found| found.len());
        files.iter().map(bytes).fold(0, u64::saturating_add)
    }

    /// The files of an image, which are there, without links to them.
    fn files(&self, record: &Record) -> Result<Vec<PathBuf>, String> {
        let path = self.folder.join(&record.output);
        let files = image::files_of(&path).map_err(|error| error.to_string())?;
        for file in &files {
            let found = match fs::metadata(file) {
                Ok(found) => found,
                // Those of Stokes components that were not measured.
                Err(_) if file != &files[0] => continue,
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                    return Err("the image is gone; start the batch again to render it".to_owned());
                }
                Err(error) => return Err(format!("the image cannot be read: {error}")),
            };
            if !found.is_file() {
                return Err("it is not a file".to_owned());
            }
            let is_inside =
                |real: &PathBuf| file.canonicalize().is_ok_and(|it| it.starts_with(real));
            if !self.allow_outside && !self.real.as_ref().is_some_and(is_inside) {
                let text = "it is outside of the folder of the batch; allow it by --allow-outside";
                return Err(text.to_owned());
            }
        }
        Ok(files)
    }

    /// The address of a file.
    fn link(&self, file: &Path) -> Option<String> {
        let folder = file.parent()?.canonicalize().ok()?;
        link(self.page.as_ref()?, &folder.join(file.file_name()?))
    }
}

impl Entry {
    /// Reads the image of a record, if there is to be one.
    pub fn new(record: &Record, place: &Place) -> Self {
        let mut entry = Self {
            jobs: excerpt(&record.jobs, NAME),
            index: record.index,
            name: excerpt(&record.name, NAME),
            values: record.values.clone(),
            output: excerpt(&record.output, NAME),
            link: None,
            seconds: record.seconds,
            error: record.error.as_ref().map(|text| cause(text)),
            problem: None,
            changed: false,
            former: false,
            image: None,
        };
        if entry.error.is_some() {
            let files = place.files(record).unwrap_or_default();
            entry.former = !files.is_empty();
            entry.link = files.first().and_then(|file| place.link(file));
        } else if let Err(text) = entry.read(record, place) {
            entry.problem = Some(cause(&text));
        }
        entry
    }

    fn read(&mut self, record: &Record, place: &Place) -> Result<(), String> {
        let files = place.files(record)?;
        self.link = files.first().and_then(|file| place.link(file));
        let path = place.folder.join(&record.output);
        let checksum = checksum_of_image(&path).map_err(|error| error.to_string())?;
        self.changed = record.checksum.as_ref().is_some_and(|before| *before != checksum);
        self.image = Some(Shown::read(&path, place.edge)?);
        Ok(())
    }

    /// The scales that fit its image.
    pub fn scales(&self) -> Option<(f32, f32)> {
        self.image.as_ref().and_then(|image| image.thumbnail.scales)
    }

    /// The small copy of its image.
    pub fn pixels(&self) -> Option<&[u8]> {
        self.image.as_ref().map(|image| &*image.thumbnail.pixels)
    }
}

impl Shown {
    fn read(path: &Path, edge: usize) -> Result<Self, String> {
        let whole = image::load(path).map_err(|error| error.to_string())?;
        let image = whole.shown();
        let many = whole.color.is_of_many().then(|| whole.color.to_string());
        let channels = match &many {
            Some(many) if image.color.channels() == 1 => vec![format!("mean of {many}")],
            Some(_) | None => image.channel_names(),
        };
        let is_finite = finite(&image);
        Ok(Self {
            width: image.width,
            height: image.height,
            channels,
            many,
            components: image.components,
            figures: Figures::new(&image, &is_finite),
            thumbnail: Thumbnail::new(&image, &is_finite, edge),
        })
    }
}

/// A cause as it may be shown, in its lines.
fn cause(text: &str) -> String {
    printable(&text.chars().take(CAUSE).collect::<String>())
}
