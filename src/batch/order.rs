//! A job that has been checked, what it depends on, and whether it has been done.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use sha2::{Digest, Sha256};

use super::gate::locked;
use super::results::Record;
use super::values::Values;
use crate::image;
use crate::math::text::excerpt;
use crate::render::settings::SAMPLES_MAX;
use crate::render::{BUILD, Options, Part, Settings, SettingsError};
use crate::scene::{Edit, View};

/// A job in which nothing can be wrong but what its scene and the machine know.
#[derive(Clone, Debug)]
pub struct Order {
    /// Its place among all, from 0.
    pub index: usize,
    /// What it is called.
    pub name: String,
    /// The values of the sweep, by the names of its axes.
    pub values: Values,
    /// The scene, from the current folder.
    pub scene: PathBuf,
    /// The same as the job file has it.
    pub scene_name: PathBuf,
    /// What is seen of it.
    pub view: View,
    /// What is other than in the scene file.
    pub edits: Vec<Edit>,
    /// In words, which of the settings the scene asks for, if it does.
    pub asked: Option<String>,
    /// What is rendered of it: an image, or a part of one.
    pub settings: Settings,
    /// Where that goes, from the current folder.
    pub output: PathBuf,
    /// The same as the job file has it.
    pub output_name: String,
}

/// What the files of parts end with.
const PART: &str = "part";
/// Most characters of a name, and of values, in what is said of a job.
const NAME: usize = 60;
const VALUES: usize = 400;
/// Width and height that progress reckons with where only the scene knows.
const EDGE: u64 = 512;

impl Order {
    /// How it is called in what is said of it.
    pub fn label(&self) -> String {
        let name = excerpt(&self.name, NAME);
        let part = self.settings.part.map_or(String::new(), |part| format!(", part {part}"));
        if self.values.is_empty() {
            return format!("\"{name}\"{part}");
        }
        let values = self.values.iter().map(|(name, value)| format!("{name} {value}"));
        let values = values.collect::<Vec<_>>().join(", ");
        format!("\"{name}\" ({}){part}", excerpt(&values, VALUES))
    }

    /// The order of a part of the image, whose file is beside that of the image:
    /// `out/a.exr.2-of-7.part`.
    ///
    /// # Errors
    /// When the settings allow of no parts.
    pub fn part(&self, part: Part) -> Result<Self, SettingsError> {
        let settings = Settings::new(Options { part: Some(part), ..self.settings.options() })?;
        let suffix = format!(".{}-of-{}.{PART}", part.number(), part.of());
        let mut output = self.output.clone().into_os_string();
        output.push(&suffix);
        let output_name = format!("{}{suffix}", self.output_name);
        Ok(Self { settings, output: output.into(), output_name, ..self.clone() })
    }

    /// The files that it makes.
    ///
    /// # Errors
    /// When no format is called as the output ends.
    pub fn files(&self) -> Result<Vec<PathBuf>, image::OutputError> {
        match self.settings.part {
            Some(_) => Ok(vec![self.output.clone()]),
            None => image::files_of(&self.output),
        }
    }

    /// Whether one of its files is there, of whatever run.
    pub fn is_there(&self) -> bool {
        self.files().is_ok_and(|files| files.iter().any(|file| file.is_file()))
    }

    /// What the whole image takes, in samples, as far as is known before the scene is.
    pub fn cost_of_image(&self) -> u64 {
        let options = &*self.settings;
        let [width, height] = match (options.width.map(u64::from), options.height.map(u64::from)) {
            (Some(width), Some(height)) => [width, height],
            (Some(edge), None) | (None, Some(edge)) => [edge; 2],
            (None, None) => [EDGE; 2],
        };
        let samples = options.iterations.unwrap_or(options.samples).clamp(1, SAMPLES_MAX);
        (width * height * u64::from(samples)).max(1)
    }

    /// What this takes of it.
    pub fn cost(&self) -> u64 {
        self.cost_of_image().div_ceil(self.settings.part.map_or(1, |part| part.of().into()))
    }

    /// What decides on its image beside the files that it reads: options, edits and the program.
    pub fn key(&self) -> String {
        let Self { scene_name: scene, view, edits, settings, .. } = self;
        let edits: Vec<_> =
            edits.iter().map(|edit| (&edit.target, edit.value.to_string())).collect();
        // Debug output tells floats apart to the last bit.
        let text = format!("{scene:?} {view:?} {edits:?} {settings:?} {BUILD}");
        hex(Sha256::digest(text.as_bytes()).as_slice())
    }

    /// Whether a record is of this very job and everything is still as it says.
    pub fn is_done_by(&self, record: &Record, folder: &Path, checksums: &Checksums) -> bool {
        let is_as_before = |(path, checksum): (&String, &String)| {
            checksums.of(&folder.join(path)).is_ok_and(|now| now == *checksum)
        };
        record.error.is_none()
            && record.key == self.key()
            && record.inputs.iter().all(is_as_before)
            && record.checksum.is_some()
            && self.checksum().ok() == record.checksum
    }

    /// The SHA-256 of its file as it is now, of its files in turn if there are several.
    ///
    /// # Errors
    /// When one cannot be read.
    pub fn checksum(&self) -> io::Result<String> {
        checksum_of(&self.files().map_err(io::Error::other)?)
    }
}

/// The SHA-256 of an image, of its files in turn if it is of several.
///
/// # Errors
/// When one cannot be read.
pub fn checksum_of_image(path: &Path) -> io::Result<String> {
    checksum_of(&image::files_of(path).map_err(io::Error::other)?)
}

fn checksum_of(files: &[PathBuf]) -> io::Result<String> {
    let mut digest = Sha256::new();
    // A format may leave files away: those of Stokes components that were not measured.
    let (first, others) = files.split_first().ok_or(io::ErrorKind::NotFound)?;
    add_file(&mut digest, first)?;
    for file in others.iter().filter(|file| file.exists()) {
        add_file(&mut digest, file)?;
    }
    Ok(hex(digest.finalize().as_slice()))
}

/// Checksums of files that do not change while the program runs.
#[derive(Default)]
pub struct Checksums(Mutex<HashMap<PathBuf, String>>);

impl Checksums {
    /// That of a file.
    pub fn of(&self, path: &Path) -> io::Result<String> {
        if let Some(known) = locked(&self.0).get(path) {
            return Ok(known.clone());
        }
        let sum = checksum(path)?;
        locked(&self.0).insert(path.to_owned(), sum.clone());
        Ok(sum)
    }

    /// Those of the files of a scene, by their paths from a folder if they are in it.
    pub fn of_all(&self, paths: &[PathBuf], folder: &Path) -> io::Result<BTreeMap<String, String>> {
        let real = folder.canonicalize()?;
        let named = |path: &PathBuf| {
            let path = path.canonicalize()?;
            let name = path.strip_prefix(&real).unwrap_or(&path).to_string_lossy().into_owned();
            Ok((name, self.of(&path)?))
        };
        paths.iter().map(named).collect()
    }
}

/// The SHA-256 of a file as `sha256sum` prints it.
fn checksum(path: &Path) -> io::Result<String> {
    let mut digest = Sha256::new();
    add_file(&mut digest, path)?;
    Ok(hex(digest.finalize().as_slice()))
}

fn add_file(digest: &mut Sha256, path: &Path) -> io::Result<()> {
    let mut file = File::open(path)?;
    let mut block = vec![0; 1 << 16];
    loop {
        match io::Read::read(&mut file, &mut block)? {
            0 => return Ok(()),
            count => digest.update(&block[..count]),
        }
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
