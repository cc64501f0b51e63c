//! The files that a scene refers to: beside it or below, unless the user allows others. Whoever
//! opens the scene of a stranger does not mean to open his own files with it.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};
use std::{fs, io};

use crate::image::read_bytes;
use crate::math::text::excerpt;
use crate::scene::error::SceneError;

/// Most characters of a URI that an error quotes.
const URI: usize = 200;

/// What a scene may read, and has read.
pub struct Files {
    /// Where relative paths start.
    folder: PathBuf,
    allow_outside: bool,
    read: Mutex<Vec<ReadFile>>,
}

/// A file that has been read, and what tells whether it still holds the same: half the BLAKE3 of
/// what was read of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadFile {
    /// Where it is.
    pub path: PathBuf,
    /// The checksum.
    pub checksum: u128,
}

impl Files {
    /// Those of the scene at a path, which has been read from there or might stand there.
    pub fn of_scene(path: &Path, allow_outside: bool) -> Self {
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
            _ => PathBuf::from("."),
        };
        let scene = ReadFile { path: path.to_owned(), checksum: 0 };
        Self { folder, allow_outside, read: Mutex::new(vec![scene]) }
    }

    /// Notes what the scene itself holds.
    pub fn note_scene(&self, bytes: &[u8]) {
        self.list()[0].checksum = digest(bytes);
    }

    fn list(&self) -> MutexGuard<'_, Vec<ReadFile>> {
        self.read.lock().expect("no thread panics while it holds the lock")
    }

    /// The scene and all that has been read for it.
    pub fn read(&self) -> Vec<ReadFile> {
        self.list().clone()
    }

    /// The same scene, which has read so much, and goes on by itself.
    pub fn again(&self) -> Self {
        let Self { folder, allow_outside, .. } = self;
        let (folder, allow_outside) = (folder.clone(), *allow_outside);
        Self { folder, allow_outside, read: Mutex::new(self.read()) }
    }

    /// The first bytes of what a URI refers to, `limit` at most; `place` is where it stands.
    pub fn bytes(&self, uri: &str, place: &str, limit: u64) -> Result<Vec<u8>, SceneError> {
        let name = String::from_utf8_lossy(&percent_decoded(uri)).into_owned();
        match name.contains("://") {
            true => Err(not_relative(uri, place)),
            false => self.named(&name, place, limit),
        }
    }

    /// Whether there is a file or folder of a path relative to that of the scene.
    pub fn has(&self, path: &Path) -> bool {
        self.folder.join(path).exists()
    }

    /// The first bytes of the file of a name, `limit` at most; `place` is where it stands.
    pub fn named(&self, name: &str, place: &str, limit: u64) -> Result<Vec<u8>, SceneError> {
        let refuse = |problem: String, remedy: &str| SceneError::new(place, problem, remedy);
        let shown = excerpt(name, URI);
        if !self.allow_outside && is_absolute(name) {
            return Err(not_relative(name, place));
        }
        let failed = |error: io::Error| {
            let path = excerpt(&self.folder.join(name).display().to_string(), URI);
            let refused =
                refuse(format!("cannot read {path}: {error}"), "put the file beside the scene");
            refused.of_system(error.kind())
        };
        let path = fs::canonicalize(self.folder.join(name)).map_err(failed)?;
        let folder = fs::canonicalize(&self.folder).map_err(failed)?;
        if !self.allow_outside && !path.starts_with(folder) {
            let problem = format!("`{shown}` lies outside the folder of the scene");
            let remedy = "put the file beside the scene, or trust the scene: --allow-outside";
            return Err(refuse(problem, remedy));
        }
        let bytes = read_bytes(&path, limit).map_err(failed)?;
        let file = ReadFile { path, checksum: digest(&bytes) };
        let mut read = self.list();
        if !read.contains(&file) {
            read.push(file);
        }
        Ok(bytes)
    }
}

/// Half the BLAKE3 of some bytes.
fn digest(bytes: &[u8]) -> u128 {
    let whole = blake3::hash(bytes);
    whole.as_bytes()[..16].iter().fold(0, |half, &byte| half << 8 | u128::from(byte))
}

/// The error that a name is no path to be read.
fn not_relative(name: &str, place: &str) -> SceneError {
    let problem = format!("`{}` is not a path relative to the scene", excerpt(name, URI));
    SceneError::new(place, problem, "put the file beside the scene")
}

fn is_absolute(name: &str) -> bool {
    Path::new(name).is_absolute() || name.starts_with('/')
}

/// A URI's text with its %xx resolved; what is no valid escape stays as it is.
pub fn percent_decoded(uri: &str) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let hex = tail.get(..2).and_then(|hex| std::str::from_utf8(hex).ok());
        let escaped = hex.filter(|hex| hex.bytes().all(|digit| digit.is_ascii_hexdigit()));
        match escaped.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) if *first == b'%' => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            _ => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    bytes
}
