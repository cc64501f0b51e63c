//! The files that a written scene refers to: pictures, and measured tables. A .glb holds them;
//! beside a .gltf they are files of their own, if they do not lie in its folder already. What has
//! no file, as pictures that were read out of another .glb, gets one.

use std::collections::{BTreeSet, HashMap};
use std::fs;
use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use crate::image::OutputError;
use crate::image::atomic::folder_of;
use crate::scene::world::{Picture, World, half_hash};

/// What stands in the document for the URI of a file until it is known; no key of glTF begins so.
const OPEN: &str = "\0stored";
/// What files are, by the bytes that they start with: what their names end in, and their type.
const FORMATS: [(&[u8], &str, &str); 6] = [
    (b"BM", "bmp", "image/bmp"),
    (b"\x89PNG", "png", "image/png"),
    (b"\xff\xd8\xff", "jpg", "image/jpeg"),
    (b"RIFF", "webp", "image/webp"),
    (b"\x76\x2f\x31\x01", "exr", "image/x-exr"),
    (b"#?R", "hdr", "image/vnd.radiance"),
];
/// What all others are.
const OTHER: (&str, &str) = ("pbsdf", "application/octet-stream");

/// What is stored, each once.
#[derive(Default)]
pub struct Stored {
    items: Vec<Item>,
    by_checksum: HashMap<u128, usize>,
}

enum Item {
    /// In memory.
    Bytes(Vec<u8>),
    /// In a file whose bytes had a checksum when it was read.
    File(PathBuf, u128),
}

/// Where all that is stored is to be found.
pub struct Found {
    /// By number: URIs, relative to the scene or with the data in them.
    pub uris: Vec<String>,
    /// What has to be written for that.
    pub files: Vec<(PathBuf, Vec<u8>)>,
}

impl Stored {
    /// The number of a picture: of its file if the world was read from that, or of new bytes.
    ///
    /// # Errors
    /// When it cannot be encoded: why.
    pub fn picture(&mut self, picture: &Picture, world: &World) -> Result<usize, String> {
        self.number_of(picture.checksum, world, || picture.encode().map(|(bytes, _)| bytes))
    }

    /// The same of a file that is in memory as it is.
    pub fn file(&mut self, bytes: &[u8], world: &World) -> Result<usize, String> {
        self.number_of(half_hash(bytes), world, || Ok(bytes.to_vec()))
    }

    fn number_of(
        &mut self,
        checksum: u128,
        world: &World,
        bytes: impl FnOnce() -> Result<Vec<u8>, String>,
    ) -> Result<usize, String> {
        if let Some(known) = self.by_checksum.get(&checksum) {
            return Ok(*known);
        }
        let of_world = world.checksums().iter().position(|known| *known == checksum);
        let item = match of_world {
            Some(at) => Item::File(world.files()[at].clone(), checksum),
            None => Item::Bytes(bytes()?),
        };
        self.items.push(item);
        self.by_checksum.insert(checksum, self.items.len() - 1);
        Ok(self.items.len() - 1)
    }

    /// Whether an item is a picture of a format that glTF itself knows.
    pub fn is_of_gltf(&self, number: usize) -> bool {
        let (kind, _) = format_of(&self.head(number));
        ["png", "jpg", "webp"].contains(&kind)
    }

    /// Whether it is WebP.
    pub fn is_webp(&self, number: usize) -> bool {
        format_of(&self.head(number)).0 == "webp"
    }

    /// The first bytes of an item; none of a file that is gone, which is told when it is read.
    fn head(&self, number: usize) -> Vec<u8> {
        const BYTES: u64 = 16;
        match &self.items[number] {
            Item::Bytes(bytes) => bytes[..bytes.len().min(BYTES as usize)].to_vec(),
            Item::File(path, _) => crate::image::read_bytes(path, BYTES).unwrap_or_default(),
        }
    }

    /// All of an item.
    fn bytes(&self, number: usize) -> Result<Vec<u8>, OutputError> {
        match &self.items[number] {
            Item::Bytes(bytes) => Ok(bytes.clone()),
            Item::File(path, checksum) => {
                let bytes = fs::read(path).map_err(|error| OutputError::read(path, error))?;
                match half_hash(&bytes) == *checksum {
                    true => Ok(bytes),
                    false => {
                        let reason = "it has changed since the scene was read";
                        Err(OutputError::malformed(path, "a file of the scene", reason))
                    }
                }
            }
        }
    }

    /// The bytes of an item, and its type.
    pub fn held(&self, number: usize) -> Result<(Vec<u8>, &'static str), OutputError> {
        let bytes = self.bytes(number)?;
        let (_, kind) = format_of(&bytes);
        Ok((bytes, kind))
    }

    /// All of it as URIs that hold the data.
    pub fn as_data(&self) -> Result<Found, OutputError> {
        let uri = |number| {
            let (bytes, kind) = self.held(number)?;
            Ok(format!("data:{kind};base64,{}", STANDARD.encode(bytes)))
        };
        let uris = (0..self.items.len()).map(uri).collect::<Result<_, OutputError>>()?;
        Ok(Found { uris, files: Vec::new() })
    }

    /// All of it as files beside a scene. No file that is there is replaced by another.
    pub fn beside(&self, scene: &Path) -> Result<Found, OutputError> {
        let folder = folder_of(scene);
        let mut beside = Beside { taken: BTreeSet::new(), files: Vec::new(), folder: &folder };
        beside.taken.extend(scene.file_name().map(|name| name.to_string_lossy().to_lowercase()));
        let here = fs::canonicalize(&folder).ok();
        let stem = scene.file_stem().and_then(|stem| stem.to_str()).unwrap_or("scene");
        let mut uris = Vec::new();
        for (number, item) in self.items.iter().enumerate() {
            let name = match item {
                Item::File(path, _) => {
                    let lies_here =
                        here.as_ref().and_then(|here| uri_of(path.strip_prefix(here).ok()?));
                    if let Some(uri) = lies_here {
                        uris.push(uri);
                        continue;
                    }
                    path.file_name().and_then(|name| name.to_str()).map(str::to_owned)
                }
                Item::Bytes(_) => None,
            };
            let bytes = self.bytes(number)?;
            let name = name.unwrap_or_else(|| format!("{stem}.{}", format_of(&bytes).0));
            uris.push(beside.put(&name, bytes)?);
        }
        Ok(Found { uris, files: beside.files })
    }
}

/// Files that are put beside a scene.
struct Beside<'a> {
    folder: &'a Path,
    /// Their names and that of the scene, in small letters: some systems do not tell these apart.
    taken: BTreeSet<String>,
    files: Vec<(PathBuf, Vec<u8>)>,
}

impl Beside<'_> {
    /// Puts a file there by a name, or by one with a number if another file has that; its URI.
    fn put(&mut self, name: &str, bytes: Vec<u8>) -> Result<String, OutputError> {
        let (stem, end) = name.rsplit_once('.').unwrap_or((name, ""));
        let separator = if end.is_empty() { "" } else { "." };
        let numbered = (1..).map(|number: u64| format!("{stem}-{number}{separator}{end}"));
        for name in [name.to_owned()].into_iter().chain(numbered) {
            if !self.taken.insert(name.to_lowercase()) {
                continue;
            }
            let path = self.folder.join(&name);
            let uri = uri_of(Path::new(&name)).unwrap_or(name);
            match fs::metadata(&path) {
                Ok(found) if found.len() == bytes.len() as u64 => {
                    let there = fs::read(&path).map_err(|error| OutputError::read(&path, error))?;
                    if there == bytes {
                        return Ok(uri);
                    }
                }
                Ok(_) => {}
                // Whatever else is wrong with the name is told when it is written.
                Err(_) => {
                    self.files.push((path, bytes));
                    return Ok(uri);
                }
            }
        }
        unreachable!("there is always one more number")
    }
}

/// What stands for the URI of a number.
pub fn open(number: usize) -> Value {
    json!({ OPEN: number })
}

/// Puts URIs where they are left open.
pub fn fill(value: &mut Value, uris: &[String]) {
    let number = value.get(OPEN).and_then(Value::as_u64);
    if let Some(uri) = number.and_then(|number| uris.get(number as usize)) {
        *value = json!(uri);
        return;
    }
    match value {
        Value::Array(items) => items.iter_mut().for_each(|item| fill(item, uris)),
        Value::Object(map) => map.values_mut().for_each(|item| fill(item, uris)),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

/// The bytes of a file as a URI that holds them.
pub fn data_uri(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", STANDARD.encode(bytes))
}

/// What some bytes are: what their file's name ends in, and their type.
fn format_of(bytes: &[u8]) -> (&'static str, &'static str) {
    let known = FORMATS.iter().find(|(start, ..)| bytes.starts_with(start));
    known.map_or(OTHER, |(_, end, kind)| (*end, *kind))
}

/// A relative path as a URI; none if it is not Unicode.
fn uri_of(path: &Path) -> Option<String> {
    let mut uri = String::new();
    for component in path.components() {
        let Component::Normal(name) = component else { return None };
        if !uri.is_empty() {
            uri.push('/');
        }
        for byte in name.to_str()?.bytes() {
            match byte {
                b'-' | b'.' | b'_' | b'~' => uri.push(char::from(byte)),
                _ if byte.is_ascii_alphanumeric() => uri.push(char::from(byte)),
                _ => uri.push_str(&format!("%{byte:02X}")),
            }
        }
    }
    (!uri.is_empty()).then_some(uri)
}

#[cfg(test)]
mod tests {
    use super::super::super::files::percent_decoded;
    use super::*;

    #[test]
    fn names_of_files_survive_as_uris() {
        for name in ["a.png", "a b%20c#d?.png", "data:x,y", "ä/ö\u{1f600}.exr", "..x/%", "a/b/c"]
        {
            let uri = uri_of(Path::new(name)).unwrap();
            assert!(uri.is_ascii() && !uri.contains([':', ' ', '#', '?']), "{uri}");
            assert_eq!(percent_decoded(&uri), name.as_bytes());
        }
        for name in ["../a.png", "/a.png", ""] {
            assert_eq!(uri_of(Path::new(name)), None, "{name}");
        }
    }

    #[test]
    fn what_is_left_open_is_filled() {
        let mut value = json!({"a": [open(1), {"b": open(0), "c": 1}], "d": "e"});
        fill(&mut value, &["x".to_owned(), "y".to_owned()]);
        assert_eq!(value, json!({"a": ["y", {"b": "x", "c": 1}], "d": "e"}));
    }
}
