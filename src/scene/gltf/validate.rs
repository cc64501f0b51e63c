//! Checks on the raw JSON before anything follows an index in it.
//!
//! The `gltf` crate cuts indices to 32 bits, accepts node cycles, and panics on some indices that
//! are out of range, so all of that is settled here.

use std::collections::BTreeSet;

use serde_json::Value;

use super::extension::EXTENSION;
use super::hierarchy::VISIBILITY;
use super::instances::INSTANCING;
use super::luminaires::EXT_LIGHTS;
use crate::math::text::excerpt;
use crate::scene::error::{Findings, SceneError};

/// Most characters of a value that an error quotes.
const VALUE: usize = 60;

/// Extensions that are read, and those that show nothing: other materials to choose, and who made
/// what.
const EXTENSIONS: [&str; 24] = [
    EXTENSION,
    EXT_LIGHTS,
    INSTANCING,
    "EXT_texture_webp",
    "KHR_implicit_shapes",
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_anisotropy",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_materials_variants",
    "KHR_mesh_quantization",
    VISIBILITY,
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
];

/// What a file may require that nobody reads here, and what to do about it.
const REMEDIES: [(&str, &str); 4] = [
    ("KHR_draco_mesh_compression", "decompress the meshes: gltf-pipeline -i in.glb -o out.glb"),
    ("EXT_meshopt_compression", "decompress the meshes: gltfpack -noq -i in.glb -o out.glb"),
    ("KHR_meshopt_compression", "decompress the meshes: gltfpack -noq -i in.glb -o out.glb"),
    ("KHR_texture_basisu", "export it with textures as PNG or JPEG"),
];

/// Refuses what the file requires and nobody reads, each with what to do about it.
pub fn check_required(value: &Value) -> Result<(), SceneError> {
    let mut findings = Findings::default();
    let required = items(&value["extensionsRequired"]).filter_map(Value::as_str);
    for name in required.filter(|name| !EXTENSIONS.contains(name)) {
        findings.note::<()>(Err(unsupported("extensionsRequired", name)));
    }
    findings.result()
}

/// The error that something is in the form of an extension that nobody reads here.
pub fn unsupported(place: &str, name: &str) -> SceneError {
    let remedy = match REMEDIES.iter().find(|(known, _)| *known == name) {
        Some((_, remedy)) => (*remedy).to_owned(),
        None => format!("export without; known are {}", EXTENSIONS.join(", ")),
    };
    SceneError::new(place, format!("`{}` is not supported", excerpt(name, VALUE)), remedy)
}

/// The extension that a buffer's contents come from, if nobody reads it here: it stands with the
/// buffer, or with what is seen of it.
pub fn compression_of_buffer(value: &Value, buffer: usize) -> Option<&'static str> {
    let views = items(&value["bufferViews"]).filter(|view| view["buffer"] == buffer);
    std::iter::once(&value["buffers"][buffer]).chain(views).find_map(compression)
}

/// The extension that an object has its contents in, if nobody reads it here.
pub fn compression(object: &Value) -> Option<&'static str> {
    let extensions = &object["extensions"];
    REMEDIES.iter().map(|(name, _)| *name).find(|name| extensions[*name].is_object())
}

/// Checks version, indices and the node hierarchy.
pub fn check(value: &Value) -> Result<(), SceneError> {
    let version = value["asset"]["version"].as_str().unwrap_or("");
    if version.split('.').next() != Some("2") {
        let problem = format!("is `{}`", excerpt(version, VALUE));
        return Err(SceneError::new("asset.version", problem, "only glTF 2.0 is read"));
    }
    let mut findings = Findings::default();
    check_indices(value, &mut findings);
    check_primitives(value, &mut findings);
    findings.result()?;
    check_hierarchy(value)
}

/// The extensions that the file uses and nobody reads, by name.
pub fn unknown_extensions(value: &Value) -> BTreeSet<&str> {
    let mut names: BTreeSet<&str> =
        items(&value["extensionsUsed"]).filter_map(Value::as_str).collect();
    let mut open = vec![value];
    while let Some(next) = open.pop() {
        open.extend(items(next));
        for (key, inner) in next.as_object().into_iter().flatten() {
            match key.as_str() {
                "extras" => {}
                "extensions" => {
                    names.extend(inner.as_object().into_iter().flatten().map(|(name, _)| &**name));
                    open.push(inner);
                }
                _ => open.push(inner),
            }
        }
    }
    names.retain(|name| !EXTENSIONS.contains(name));
    names
}

/// How errors call an element of one of the file's arrays: kind, index and name.
pub fn label(value: &Value, array: &str, index: usize) -> String {
    let kind = match array {
        "meshes" => "mesh",
        _ => array.strip_suffix('s').unwrap_or(array),
    };
    match value[array][index]["name"].as_str() {
        Some(name) => format!("{kind} {index} \"{name}\""),
        None => format!("{kind} {index}"),
    }
}

/// The elements of an array; none if it is not one.
fn items(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

fn len(value: &Value) -> usize {
    value.as_array().map_or(0, Vec::len)
}

/// Checks one index, if it is there.
fn check_index(
    findings: &mut Findings,
    index: &Value,
    (target, target_len): (&str, usize),
    field: impl Fn() -> String,
) {
    if index.is_null() || index.as_u64().is_some_and(|index| index < target_len as u64) {
        return;
    }
    let index = excerpt(&index.to_string(), VALUE);
    let problem = format!("{index} is not an index into the file's {target_len} {target}");
    findings.note::<()>(Err(SceneError::new(field(), problem, "export the scene again")));
}

fn check_indices(value: &Value, findings: &mut Findings) {
    const LINKS: [(&str, &str, &str); 8] = [
        ("nodes", "/mesh", "meshes"),
        ("nodes", "/camera", "cameras"),
        ("nodes", "/children", "nodes"),
        ("scenes", "/nodes", "nodes"),
        ("accessors", "/bufferView", "bufferViews"),
        ("accessors", "/sparse/indices/bufferView", "bufferViews"),
        ("accessors", "/sparse/values/bufferView", "bufferViews"),
        ("bufferViews", "/buffer", "buffers"),
    ];
    let scenes = ("scenes", len(&value["scenes"]));
    check_index(findings, &value["scene"], scenes, || "scene".to_owned());
    for (array, field, target) in LINKS {
        let target = (target, len(&value[target]));
        for (index, element) in items(&value[array]).enumerate() {
            let field_name = field[1..].replace('/', ".");
            let name = || format!("{}, {field_name}", label(value, array, index));
            match element.pointer(field) {
                None => {}
                Some(Value::Array(links)) => {
                    links.iter().for_each(|link| check_index(findings, link, target, name));
                }
                Some(link) => check_index(findings, link, target, name),
            }
        }
    }
    let lights = ("lights", len(&value["extensions"]["KHR_lights_punctual"]["lights"]));
    for (index, node) in items(&value["nodes"]).enumerate() {
        let light = &node["extensions"]["KHR_lights_punctual"]["light"];
        check_index(findings, light, lights, || {
            format!("{}, KHR_lights_punctual.light", label(value, "nodes", index))
        });
    }
}

fn check_primitives(value: &Value, findings: &mut Findings) {
    let accessors = ("accessors", len(&value["accessors"]));
    let materials = ("materials", len(&value["materials"]));
    for (mesh, object) in items(&value["meshes"]).enumerate() {
        for (index, primitive) in items(&object["primitives"]).enumerate() {
            let name = |field: &str| {
                format!("{}, primitive {index}, {field}", label(value, "meshes", mesh))
            };
            check_index(findings, &primitive["indices"], accessors, || name("indices"));
            check_index(findings, &primitive["material"], materials, || name("material"));
            for (attribute, accessor) in primitive["attributes"].as_object().into_iter().flatten() {
                check_index(findings, accessor, accessors, || name(attribute));
            }
            for target in items(&primitive["targets"]).filter_map(Value::as_object).flatten() {
                check_index(findings, target.1, accessors, || name("targets"));
            }
        }
    }
}

/// Refuses nodes with several parents, or that are their own ancestors.
fn check_hierarchy(value: &Value) -> Result<(), SceneError> {
    const NONE: usize = usize::MAX;
    const TREE: &str = "glTF nodes must form trees; instances share a mesh, not a node";
    let count = len(&value["nodes"]);
    let children = |node: usize| {
        let children = items(&value["nodes"][node]["children"]);
        children.filter_map(|child| child.as_u64().map(|child| child as usize))
    };
    let mut parents = vec![NONE; count];
    for node in 0..count {
        for child in children(node) {
            if parents[child] != NONE {
                let place = label(value, "nodes", child);
                let first = label(value, "nodes", parents[child]);
                let second = label(value, "nodes", node);
                let problem = format!("is a child of both {first} and {second}");
                return Err(SceneError::new(place, problem, TREE));
            }
            parents[child] = node;
        }
    }
    // With one parent each, whoever cannot be reached from a node without a parent is in a cycle
    // or below one.
    let mut reached = vec![false; count];
    let mut open: Vec<usize> = (0..count).filter(|&node| parents[node] == NONE).collect();
    while let Some(node) = open.pop() {
        reached[node] = true;
        open.extend(children(node));
    }
    if let Some(node) = reached.iter().position(|reached| !reached) {
        let place = format!("{}, children", label(value, "nodes", node));
        return Err(SceneError::new(place, "the node is in a cycle of nodes", TREE));
    }
    Ok(())
}
