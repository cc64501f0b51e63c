//! Meshes of a written scene: each column of each geometry once.

use std::collections::HashMap;
use std::sync::Arc;

use bytemuck::{Pod, cast_slice};
use serde_json::{Value, json};

use crate::scene::world::Geometry;

/// `componentType` of accessors.
const FLOATS: u32 = 5126;
const INDICES: u32 = 5125;

/// The columns of a geometry, by the names of attributes.
const INDEX: &str = "indices";
const OPAQUE: &str = "COLOR_0 without alpha";

/// Accessors, and the bytes that they are of.
#[derive(Default)]
pub struct Meshes {
    pub bytes: Vec<u8>,
    pub views: Vec<Value>,
    pub accessors: Vec<Value>,
    /// Accessors by the address of a geometry and the name of a column.
    known: HashMap<(usize, &'static str), usize>,
}

/// Which colors of vertices count for a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tint {
    None,
    Color,
    ColorAndAlpha,
}

impl Meshes {
    /// None, and views that follow some bytes.
    pub fn after(bytes: Vec<u8>) -> Self {
        Self { bytes, ..Self::default() }
    }

    /// A primitive of a mesh.
    pub fn primitive(
        &mut self,
        geometry: &Arc<Geometry>,
        (material, tint): (usize, Tint),
    ) -> Value {
        let key = Arc::as_ptr(geometry).addr();
        let mut attributes = json!({});
        let mut add = |name: &'static str, accessor: Option<usize>| {
            if let Some(accessor) = accessor {
                attributes[name] = json!(accessor);
            }
        };
        let [low, high] = geometry.bounds().map(|bound| bound.as_vec3().to_array());
        let positions = self.column((key, "POSITION"), &geometry.positions, (FLOATS, "VEC3"));
        if let Some(positions) = positions {
            self.accessors[positions]["min"] = json!(low);
            self.accessors[positions]["max"] = json!(high);
        }
        add("POSITION", positions);
        add("NORMAL", self.column((key, "NORMAL"), &geometry.normals, (FLOATS, "VEC3")));
        add("TANGENT", self.column((key, "TANGENT"), &geometry.tangents, (FLOATS, "VEC4")));
        let sets = [&geometry.texture_coordinates, &geometry.texture_coordinates_1];
        for (name, set) in ["TEXCOORD_0", "TEXCOORD_1"].into_iter().zip(sets) {
            add(name, self.column((key, name), set, (FLOATS, "VEC2")));
        }
        match tint {
            Tint::None => {}
            Tint::Color => {
                let opaque: Vec<glam::Vec3> =
                    geometry.colors.iter().map(|color| color.truncate()).collect();
                add("COLOR_0", self.column((key, OPAQUE), &opaque, (FLOATS, "VEC3")));
            }
            Tint::ColorAndAlpha => {
                add("COLOR_0", self.column((key, "COLOR_0"), &geometry.colors, (FLOATS, "VEC4")));
            }
        }
        let corners = geometry.triangles.as_flattened();
        let indices = self.column((key, INDEX), corners, (INDICES, "SCALAR"));
        json!({"attributes": attributes, "indices": indices, "material": material})
    }

    /// The accessor of a column; none if it is empty. All numbers are of four bytes.
    fn column<T: Pod>(
        &mut self,
        key: (usize, &'static str),
        rows: &[T],
        (component, kind): (u32, &str),
    ) -> Option<usize> {
        if rows.is_empty() {
            return None;
        }
        if let Some(known) = self.known.get(&key) {
            return Some(*known);
        }
        let words: &[u32] = cast_slice(rows);
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let view = self.view(&bytes);
        self.accessors.push(json!({"bufferView": view, "componentType": component,
            "count": rows.len(), "type": kind}));
        self.known.insert(key, self.accessors.len() - 1);
        Some(self.accessors.len() - 1)
    }

    /// A view of more bytes.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        const STEP: usize = 4;
        let (at, length) = (self.bytes.len(), bytes.len());
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(STEP), 0);
        self.views.push(json!({"buffer": 0, "byteOffset": at, "byteLength": length}));
        self.views.len() - 1
    }
}
