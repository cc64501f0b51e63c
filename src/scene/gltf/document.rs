//! From a file to its validated JSON and its buffers.

use std::collections::BTreeSet;
use std::io::ErrorKind;
use std::path::Path;
use std::slice;
use std::sync::Arc;

use base64::Engine;
use gltf::json;
use gltf::json::extensions::scene::khr_lights_punctual::Light;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::animations;
use super::edit::{self, Edit};
use super::files::{Files, percent_decoded};
use super::textures::Pictures;
use super::validate;
use crate::image::read_bytes;
use crate::scene::error::{Findings, SceneError};
use crate::scene::warnings::Warnings;

/// A glTF file in memory.
pub struct Document {
    /// The JSON as it is; the extension's keys and extras are read from here.
    pub value: Value,
    /// The same, typed. Every index in it that the loader follows is within range.
    pub root: json::Root,
    /// The buffers, each at least as long as its `byteLength`.
    pub buffers: Arc<Vec<Vec<u8>>>,
    /// What else it may read, and has.
    pub files: Files,
    /// The pictures that have been decoded.
    pub pictures: Arc<Pictures>,
}

impl Document {
    /// Reads and validates a .gltf or .glb file and everything that it refers to.
    pub fn read(path: &Path, allow_outside: bool) -> Result<Self, SceneError> {
        Self::parse(&bytes_of(path)?, Files::of_scene(path, allow_outside))
    }

    /// Validates the bytes of a scene, and reads everything that it refers to.
    pub fn parse(bytes: &[u8], files: Files) -> Result<Self, SceneError> {
        files.note_scene(bytes);
        let (mut value, binary) = json_of(bytes)?;
        validate::check(&value)?;
        show_all(&mut value);
        let root = typed(&value)?;
        let mut buffers = Vec::with_capacity(root.buffers.len());
        let mut findings = Findings::default();
        for (index, buffer) in root.buffers.iter().enumerate() {
            let label = validate::label(&value, "buffers", index);
            let read = match (validate::compression_of_buffer(&value, index), &buffer.uri) {
                (Some(name), None) if index > 0 || binary.is_none() => {
                    Err(validate::unsupported(&label, name))
                }
                _ => read_buffer(buffer, index, &label, &files, binary),
            };
            buffers.extend(findings.note(read));
        }
        if buffers.len() < root.buffers.len() {
            findings.note(validate::check_required(&value));
            findings.result()?;
        }
        forget_data(&mut value);
        let (buffers, pictures) = (Arc::new(buffers), Arc::default());
        Ok(Self { value, root, buffers, files, pictures })
    }

    /// The same document after edits, with the same buffers.
    pub fn edited(&self, edits: &[Edit]) -> Result<Self, SceneError> {
        let value = edit::applied(&self.value, edits)?;
        validate::check(&value)?;
        let root = typed(&value).map_err(|error| self.told_of_edits(edits, error))?;
        let (buffers, pictures) = (Arc::clone(&self.buffers), Arc::clone(&self.pictures));
        Ok(Self { value, root, buffers, files: self.files.again(), pictures })
    }

    /// The same document with the nodes where animations have them at a time in seconds.
    pub fn moved(&self, time: f64, warnings: &mut Warnings) -> Result<Self, SceneError> {
        let value = animations::moved(self, time, warnings)?;
        let root = typed(&value)?;
        let (buffers, pictures) = (Arc::clone(&self.buffers), Arc::clone(&self.pictures));
        Ok(Self { value, root, buffers, files: self.files.again(), pictures })
    }

    /// The same error, which names the edit if one alone makes it.
    fn told_of_edits(&self, edits: &[Edit], error: SceneError) -> SceneError {
        let of_edit = |edit: &Edit| {
            let value = edit::applied(&self.value, slice::from_ref(edit)).ok()?;
            let error = typed(&value).err()?;
            let problem = format!("{} {}", error.place(), error.problem());
            Some(SceneError::new(&edit.target, problem, "give such a value as glTF has there"))
        };
        edits.iter().find_map(of_edit).unwrap_or(error)
    }

    /// The text of a file beside the scene, or of a data URI; `field` is what refers to it.
    pub fn read_text(&self, uri: &str, field: &str) -> Result<String, SceneError> {
        let bytes = self.read_bytes(uri, field)?;
        String::from_utf8(without_mark(&bytes).to_vec())
            .map_err(|_| SceneError::new(field, "is not text", "is it a CSV?"))
    }

    /// The bytes of a file beside the scene, or of a data URI; `field` is what refers to it.
    pub fn read_bytes(&self, uri: &str, field: &str) -> Result<Vec<u8>, SceneError> {
        const BYTES_MAX: u64 = 1 << 26;
        let bytes = match uri.strip_prefix("data:") {
            Some(data) => decode_data_uri(data, field.to_owned())?,
            None => self.files.bytes(uri, field, BYTES_MAX)?,
        };
        if bytes.len() as u64 == BYTES_MAX {
            let problem = format!("is larger than {BYTES_MAX} bytes");
            return Err(SceneError::new(field, problem, "make it smaller"));
        }
        Ok(bytes)
    }

    /// The bytes of a picture or a luminaire, of a file beside the scene, a data URI or a buffer
    /// view.
    pub fn image_bytes(&self, image: &Value, label: &str) -> Result<Vec<u8>, SceneError> {
        const AGAIN: &str = "export the scene again";
        if let Some(uri) = image["uri"].as_str() {
            return self.bytes_of(uri, &format!("{label}, uri"));
        }
        let view = image["bufferView"].as_u64().map(|view| view as usize);
        let Some(view) = view.and_then(|view| self.root.buffer_views.get(view)) else {
            let problem = "has neither `uri` nor `bufferView`";
            return Err(SceneError::new(label, problem, AGAIN));
        };
        let start = view.byte_offset.unwrap_or_default().0 as usize;
        let end = start.checked_add(view.byte_length.0 as usize);
        let bytes = end.and_then(|end| self.buffers[view.buffer.value()].get(start..end));
        bytes.map(<[u8]>::to_vec).ok_or_else(|| {
            SceneError::new(format!("{label}, bufferView"), "is outside of its buffer", AGAIN)
        })
    }

    /// The bytes of a file beside the scene, or of a data URI; `field` is what refers to it.
    pub fn bytes_of(&self, uri: &str, field: &str) -> Result<Vec<u8>, SceneError> {
        match uri.strip_prefix("data:") {
            Some(data) => decode_data_uri(data, field.to_owned()),
            None => self.files.bytes(uri, field, u64::MAX),
        }
    }

    /// How errors call an element of one of the file's arrays: kind, index and name.
    pub fn label(&self, array: &str, index: usize) -> String {
        validate::label(&self.value, array, index)
    }
}

/// The JSON of a .gltf or .glb file, not validated, without what it refers to.
pub fn read_json(path: &Path) -> Result<Value, SceneError> {
    Ok(json_of(&bytes_of(path)?)?.0)
}

/// The bytes of a scene file.
pub fn bytes_of(path: &Path) -> Result<Vec<u8>, SceneError> {
    read_bytes(path, u64::MAX).map_err(|error| {
        let problem = format!("cannot read it: {error}");
        let remedy = match error.kind() {
            ErrorKind::OutOfMemory => "use a smaller file",
            _ => "is the path right?",
        };
        SceneError::new("", problem, remedy).of_system(error.kind())
    })
}

/// The JSON of a file, and its binary chunk if it has one.
fn json_of(bytes: &[u8]) -> Result<(Value, Option<&[u8]>), SceneError> {
    let (text, binary) = if bytes.starts_with(b"glTF") { split_glb(bytes)? } else { (bytes, None) };
    let value: Value = serde_json::from_slice(without_mark(text)).map_err(|error| {
        let remedy = match text {
            [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => "it is text in UTF-16: save it as UTF-8",
            _ => "a scene is a glTF 2.0 file, .gltf or .glb",
        };
        SceneError::new("", format!("is not glTF: {error}"), remedy)
    })?;
    Ok((value, binary))
}

/// Text without the mark that some editors put before UTF-8.
fn without_mark(text: &[u8]) -> &[u8] {
    text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text)
}

/// Gives a file without scenes, which is a library of its nodes, one of all of them.
fn show_all(value: &mut Value) {
    let is_empty = |list: &Value| list.as_array().is_none_or(Vec::is_empty);
    if !is_empty(&value["scenes"]) || is_empty(&value["nodes"]) {
        return;
    }
    let nodes = value["nodes"].as_array().into_iter().flatten();
    let children = nodes.filter_map(|node| node["children"].as_array()).flatten();
    let children: BTreeSet<u64> = children.filter_map(Value::as_u64).collect();
    let count = value["nodes"].as_array().map_or(0, Vec::len) as u64;
    let roots: Vec<u64> = (0..count).filter(|node| !children.contains(node)).collect();
    value["scenes"] = serde_json::json!([{ "nodes": roots }]);
}

/// Takes the contents of buffers out of the JSON, which edits copy: they have been read.
fn forget_data(value: &mut Value) {
    for buffer in objects(value, "buffers") {
        let is_data = |uri: &&mut Value| uri.as_str().is_some_and(|uri| uri.starts_with("data:"));
        if let Some(uri) = buffer.get_mut("uri").filter(is_data) {
            *uri = Value::from("data:");
        }
    }
}

/// The typed document, without what nobody reads: errors in that are no reason to refuse the rest.
fn typed(value: &Value) -> Result<json::Root, SceneError> {
    const UNREAD: [&str; 5] = ["animations", "images", "samplers", "skins", "textures"];
    let mut read = value.clone();
    if let Some(root) = read.as_object_mut() {
        UNREAD.iter().for_each(|name| drop(root.remove(*name)));
    }
    // glTF lets a scene be empty, the `gltf` crate does not.
    for scene in objects(&mut read, "scenes") {
        scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
    }
    for material in objects(&mut read, "materials") {
        material.remove("occlusionTexture");
    }
    json::Root::deserialize(&read).map_err(|error| type_error(&read, &error))
}

/// The objects of one of the document's arrays.
fn objects<'a>(
    document: &'a mut Value,
    array: &str,
) -> impl Iterator<Item = &'a mut Map<String, Value>> {
    let array = document.get_mut(array).and_then(Value::as_array_mut);
    array.into_iter().flatten().filter_map(Value::as_object_mut)
}

/// The JSON chunk and the binary chunk of a .glb file.
fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), SceneError> {
    const HEADER: usize = 12;
    let broken = |problem: String| {
        SceneError::new("glb container", problem, "the file is cut off or damaged: export it again")
    };
    let (Some(version), Some(length)) = (u32_at(bytes, 4), u32_at(bytes, 8)) else {
        return Err(broken("the header is cut off".to_owned()));
    };
    if version != 2 {
        let remedy = "only glTF 2.0 is read";
        return Err(SceneError::new("glb container", format!("has version {version}"), remedy));
    }
    let Some(mut rest) = bytes.get(HEADER..length) else {
        let problem = format!("claims {length} bytes, but the file has {}", bytes.len());
        return Err(broken(problem));
    };
    let mut chunks = Vec::new();
    while !rest.is_empty() && chunks.len() < 2 {
        let chunk = u32_at(rest, 0).and_then(|len| Some((rest.get(4..8)?, rest.get(8..8 + len)?)));
        let Some((kind, data)) = chunk else {
            return Err(broken(format!("chunk {} is cut off", chunks.len())));
        };
        chunks.push((kind, data));
        rest = &rest[8 + data.len()..];
    }
    match chunks[..] {
        [(b"JSON", text), (b"BIN\0", binary)] => Ok((text, Some(binary))),
        [(b"JSON", text), ..] => Ok((text, None)),
        _ => Err(broken("does not begin with a JSON chunk".to_owned())),
    }
}

fn u32_at(bytes: &[u8], offset: usize) -> Option<usize> {
    let word = bytes.get(offset..offset + 4)?.try_into().ok()?;
    usize::try_from(u32::from_le_bytes(word)).ok()
}

/// The bytes of a buffer, wherever they are.
fn read_buffer(
    buffer: &json::Buffer,
    index: usize,
    label: &str,
    files: &Files,
    binary: Option<&[u8]>,
) -> Result<Vec<u8>, SceneError> {
    let claimed = buffer.byte_length.0;
    let bytes = match (&buffer.uri, binary) {
        (None, Some(binary)) if index == 0 => binary.to_vec(),
        (None, _) => {
            let problem = "has no uri, and the file has no binary chunk for it";
            return Err(SceneError::new(label, problem, "export the scene again"));
        }
        (Some(uri), _) => match uri.strip_prefix("data:") {
            Some(data) => decode_data_uri(data, format!("{label}, uri"))?,
            None => files.bytes(uri, &format!("{label}, uri"), claimed)?,
        },
    };
    if (bytes.len() as u64) < claimed {
        let problem = format!("claims {claimed} bytes, but there are {}", bytes.len());
        return Err(SceneError::new(format!("{label}, byteLength"), problem, "export it again"));
    }
    Ok(bytes)
}

/// The bytes of a data URI, of what follows `data:` in it.
pub fn decode_data_uri(data: &str, place: String) -> Result<Vec<u8>, SceneError> {
    let Some((_, text)) = data.split_once(";base64,") else {
        let Some((_, text)) = data.split_once(',') else {
            let problem = "is a data URI without a comma";
            return Err(SceneError::new(place, problem, "encode it as base64"));
        };
        return Ok(percent_decoded(text));
    };
    // Padding is optional: not every exporter writes it.
    let engine = base64::engine::GeneralPurpose::new(
        &base64::alphabet::STANDARD,
        base64::engine::GeneralPurposeConfig::new()
            .with_decode_padding_mode(base64::engine::DecodePaddingMode::Indifferent),
    );
    engine.decode(text).map_err(|error| {
        SceneError::new(place, format!("is not base64: {error}"), "export the scene again")
    })
}

/// The error of the typed parser, with the names of the objects that it is about if these are
/// found.
fn type_error(value: &Value, error: &serde_json::Error) -> SceneError {
    let mut findings = Findings::default();
    note_bad::<json::Node>(value, "nodes", &mut findings);
    note_bad::<json::Material>(value, "materials", &mut findings);
    note_bad::<json::Mesh>(value, "meshes", &mut findings);
    note_bad::<json::Camera>(value, "cameras", &mut findings);
    note_bad::<json::Accessor>(value, "accessors", &mut findings);
    note_bad::<json::buffer::View>(value, "bufferViews", &mut findings);
    note_bad::<json::Buffer>(value, "buffers", &mut findings);
    note_bad::<json::Scene>(value, "scenes", &mut findings);
    note_bad::<Light>(&value["extensions"]["KHR_lights_punctual"], "lights", &mut findings);
    match findings.result() {
        Err(found) => found,
        Ok(()) => not_typed("", error),
    }
}

/// Notes the elements of an array that do not parse.
fn note_bad<T: DeserializeOwned>(value: &Value, array: &str, findings: &mut Findings) {
    for (index, element) in value[array].as_array().into_iter().flatten().enumerate() {
        let parsed = T::deserialize(element).map(drop);
        findings
            .note(parsed.map_err(|error| not_typed(&validate::label(value, array, index), &error)));
    }
}

fn not_typed(place: &str, error: &serde_json::Error) -> SceneError {
    SceneError::new(place, format!("is not glTF 2.0: {error}"), "export the scene again")
}
