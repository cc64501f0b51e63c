//! Written scenes on the disk: .gltf with files beside, or .glb with all in it.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::meshes::Meshes;
use super::stored::{Found, Stored, data_uri, fill};
use crate::image::{OutputError, atomic, extension};

/// A scene as glTF.
pub struct Written {
    /// Without its buffer, and with URIs left open.
    pub(super) document: Value,
    /// The buffer.
    pub(super) bytes: Vec<u8>,
    pub(super) stored: Stored,
    /// What is stored and an image of the document.
    pub(super) images: Vec<usize>,
    pub(super) warnings: Vec<String>,
}

impl Written {
    /// What is not written as it is, a sentence each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Writes the file: .glb with all in it, others as .gltf with pictures and tables in files
    /// beside, unless they lie in its folder already. Returns which of these have been written; no
    /// file that is there is replaced by another.
    ///
    /// # Errors
    /// When the system refuses that, or a file of the scene has changed since it was read.
    pub fn save(&self, path: &Path) -> Result<Vec<PathBuf>, OutputError> {
        let mut document = self.document.clone();
        if extension(path) == "glb" {
            fill(&mut document, &self.stored.as_data()?.uris);
            return atomic::write(path, &self.glb(document, path)?).map(|()| Vec::new());
        }
        let Found { uris, mut files } = self.stored.beside(path)?;
        fill(&mut document, &uris);
        if !self.images.is_empty() {
            let images: Vec<Value> =
                self.images.iter().map(|image| json!({"uri": uris[*image]})).collect();
            document["images"] = Value::Array(images);
        }
        if !self.bytes.is_empty() {
            let uri = data_uri("application/octet-stream", &self.bytes);
            document["buffers"] = json!([{"byteLength": self.bytes.len(), "uri": uri}]);
        }
        let beside = files.iter().map(|(path, _)| path.clone()).collect();
        // Whoever finds the scene finds what it refers to.
        files.push((path.to_owned(), text_of(&document).into_bytes()));
        atomic::write_set(&files)?;
        Ok(beside)
    }

    /// The bytes of a .glb file.
    fn glb(&self, mut document: Value, path: &Path) -> Result<Vec<u8>, OutputError> {
        const STEP: usize = 4;
        let mut meshes = Meshes::after(self.bytes.clone());
        let before = document["bufferViews"].as_array().map_or(0, Vec::len);
        let mut images = Vec::new();
        for number in &self.images {
            let (bytes, kind) = self.stored.held(*number)?;
            let view = before + meshes.view(&bytes);
            images.push(json!({"bufferView": view, "mimeType": kind}));
        }
        if !images.is_empty() {
            document["images"] = Value::Array(images);
            match document["bufferViews"].as_array_mut() {
                Some(views) => views.append(&mut meshes.views),
                None => document["bufferViews"] = Value::Array(meshes.views),
            }
        }
        let mut binary = meshes.bytes;
        binary.resize(binary.len().next_multiple_of(STEP), 0);
        if !binary.is_empty() {
            document["buffers"] = json!([{"byteLength": binary.len()}]);
        }
        let mut text = text_of(&document).into_bytes();
        text.resize(text.len().next_multiple_of(STEP), b' ');
        let mut chunks = vec![(b"JSON", text), (b"BIN\0", binary)];
        chunks.retain(|(_, data)| !data.is_empty());
        let length = 12 + chunks.iter().map(|(_, data)| 8 + data.len()).sum::<usize>();
        let too_long = || OutputError::unwritable(path, "a .glb has at most 4 GiB: write a .gltf");
        let word = |length: usize| u32::try_from(length).map_err(|_| too_long());
        let mut bytes = [&b"glTF"[..], &2_u32.to_le_bytes(), &word(length)?.to_le_bytes()].concat();
        for (kind, data) in chunks {
            bytes.extend(word(data.len())?.to_le_bytes());
            bytes.extend(kind);
            bytes.extend(data);
        }
        Ok(bytes)
    }
}

fn text_of(document: &Value) -> String {
    format!("{document:#}")
}
