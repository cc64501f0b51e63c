//! A small good glTF document, and loading what tests make of it.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use sunstone::internals::scene::{World, load};

/// A path in the build's scratch folder that no other test uses.
pub fn scratch(name: &str) -> PathBuf {
    static NEXT: AtomicUsize = AtomicUsize::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(std::process::id().to_string());
    fs::create_dir_all(&folder).unwrap();
    folder.join(format!("{number}-{name}"))
}

/// Writes a file, loads it, and removes it again.
pub fn load_bytes(name: &str, bytes: &[u8]) -> Result<World, String> {
    let path = scratch(name);
    fs::write(&path, bytes).unwrap();
    let world = load(&path).map_err(|error| error.to_string());
    fs::remove_file(&path).unwrap();
    world
}

/// Loads a document.
pub fn load_json(document: &Value) -> Result<World, String> {
    load_bytes("scene.gltf", document.to_string().as_bytes())
}

/// The bytes of 4 positions, 4 normals (a unit square in xy that faces +z) and 6 indices.
pub fn square_bytes() -> Vec<u8> {
    let positions: [[f32; 3]; 4] =
        [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let normals = [[0.0f32, 0.0, 1.0]; 4];
    let floats = positions.as_flattened().iter().chain(normals.as_flattened());
    let indices = [0u16, 1, 2, 0, 2, 3];
    let indices = indices.iter().flat_map(|index| index.to_le_bytes());
    floats.flat_map(|float| float.to_le_bytes()).chain(indices).collect()
}

/// Bytes as a data URI.
pub fn data_uri(bytes: &[u8]) -> String {
    format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes))
}

/// A camera before a square that emits and an analytic sphere of glass with a stand-in mesh.
pub fn good() -> Value {
    json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["SUNSTONE_polarization", "KHR_implicit_shapes", "KHR_lights_punctual"],
        "extensions": {
            "KHR_implicit_shapes": {"shapes": [{"type": "sphere", "sphere": {"radius": 0.5}}]},
            "KHR_lights_punctual": {"lights": [
                {"name": "bulb", "type": "point", "intensity": 683.0},
            ]},
        },
        "scene": 0,
        "scenes": [{"name": "good", "nodes": [0, 1, 2, 3]}],
        "nodes": [
            {"name": "eye", "camera": 0, "translation": [0.0, 0.0, 5.0]},
            {"name": "panel", "mesh": 0},
            {"name": "ball", "mesh": 1, "translation": [0.0, 0.0, 2.0],
             "extensions": {"SUNSTONE_polarization": {"shape": 0}}},
            {"name": "lamp", "translation": [0.0, 3.0, 0.0],
             "extensions": {"KHR_lights_punctual": {"light": 0}}},
        ],
        "cameras": [{"name": "lens", "type": "perspective",
                     "perspective": {"yfov": 0.7, "aspectRatio": 1.0, "znear": 0.1}}],
        "meshes": [
            {"name": "square", "primitives": [
                {"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}]},
            {"name": "stand-in", "primitives": [
                {"attributes": {"POSITION": 0}, "indices": 2, "material": 1}]},
        ],
        "materials": [
            {"name": "glow", "emissiveFactor": [1.0, 0.5, 0.25],
             "extensions": {"SUNSTONE_polarization": {"bsdf": "diffuse", "reflectance": 0.5}}},
            {"name": "glass",
             "extensions": {"SUNSTONE_polarization": {"bsdf": "dielectric", "ior": 1.5}}},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
             "min": [-1.0, -1.0, 0.0], "max": [1.0, 1.0, 0.0]},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 48},
            {"buffer": 0, "byteOffset": 96, "byteLength": 12},
        ],
        "buffers": [{"byteLength": 108, "uri": data_uri(&square_bytes())}],
    })
}

/// The document as a .glb file, its first buffer in the binary chunk.
pub fn glb(mut document: Value, binary: &[u8]) -> Vec<u8> {
    document["buffers"] = json!([{"byteLength": binary.len()}]);
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut binary = binary.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let length = 12 + 8 + text.len() + 8 + binary.len();
    let mut bytes = b"glTF".to_vec();
    for word in [2, length as u32, text.len() as u32] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(b"JSON");
    bytes.extend(&text);
    bytes.extend((binary.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(&binary);
    bytes
}
