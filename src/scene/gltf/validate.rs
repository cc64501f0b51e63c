//! Checks on the raw JSON before anything follows an index in it.
//!
//! The `gltf` crate cuts indices to 32 bits, accepts node cycles, and panics on some indices that
//! are out of range, so all of that is settled here.

use std::collections::BTreeSet;

use serde_json::Value;

use super::extension::EXTENSION;
use crate::scene::error::SceneError;

/// Extensions that are read.
const EXTENSIONS: [&str; 6] = [
    EXTENSION,
    "KHR_implicit_shapes",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_transmission",
];

/// Checks version, required extensions, indices and the node hierarchy.
pub fn check(value: &Value) -> Result<(), SceneError> {
    let version = value["asset"]["version"].as_str().unwrap_or("");
    if version.split('.').next() != Some("2") {
        let problem = format!("is `{version}`");
        return Err(SceneError::new("asset.version", problem, "only glTF 2.0 is read"));
    }
    for name in items(&value["extensionsRequired"]).filter_map(Value::as_str) {
        if !EXTENSIONS.contains(&name) {
            let remedy = format!("export without it; known are {}", EXTENSIONS.join(", "));
            let problem = format!("`{name}` is not supported");
            return Err(SceneError::new("extensionsRequired", problem, remedy));
        }
    }
    check_indices(value)?;
    check_primitives(value)?;
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
    index: &Value,
    target: &str,
    target_len: usize,
    field: impl Fn() -> String,
) -> Result<(), SceneError> {
    if index.is_null() || index.as_u64().is_some_and(|index| index < target_len as u64) {
        return Ok(());
    }
    let problem = format!("{index} is not an index into the file's {target_len} {target}");
    Err(SceneError::new(field(), problem, "export the scene again"))
}

fn check_indices(value: &Value) -> Result<(), SceneError> {
    const LINKS: [(&str, &str, &str); 8] = [
        ("nodes", "mesh", "meshes"),
        ("nodes", "camera", "cameras"),
        ("nodes", "skin", "skins"),
        ("nodes", "children", "nodes"),
        ("scenes", "nodes", "nodes"),
        ("accessors", "bufferView", "bufferViews"),
        ("bufferViews", "buffer", "buffers"),
        ("skins", "skeleton", "nodes"),
    ];
    check_index(&value["scene"], "scenes", len(&value["scenes"]), || "scene".to_owned())?;
    for (array, field, target) in LINKS {
        let target_len = len(&value[target]);
        for (index, element) in items(&value[array]).enumerate() {
            let name = || format!("{}, {field}", label(value, array, index));
            match &element[field] {
                Value::Array(links) => {
                    for link in links {
                        check_index(link, target, target_len, name)?;
                    }
                }
                link => check_index(link, target, target_len, name)?,
            }
        }
    }
    let lights = len(&value["extensions"]["KHR_lights_punctual"]["lights"]);
    for (index, node) in items(&value["nodes"]).enumerate() {
        let light = &node["extensions"]["KHR_lights_punctual"]["light"];
        check_index(light, "lights", lights, || {
            format!("{}, KHR_lights_punctual.light", label(value, "nodes", index))
        })?;
    }
    Ok(())
}

fn check_primitives(value: &Value) -> Result<(), SceneError> {
    let accessors = len(&value["accessors"]);
    let materials = len(&value["materials"]);
    for (mesh, object) in items(&value["meshes"]).enumerate() {
        for (index, primitive) in items(&object["primitives"]).enumerate() {
            let name = |field: &str| {
                format!("{}, primitive {index}, {field}", label(value, "meshes", mesh))
            };
            check_index(&primitive["indices"], "accessors", accessors, || name("indices"))?;
            check_index(&primitive["material"], "materials", materials, || name("material"))?;
            for (attribute, accessor) in primitive["attributes"].as_object().into_iter().flatten() {
                check_index(accessor, "accessors", accessors, || name(attribute))?;
            }
        }
    }
    Ok(())
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
    check_roots(value, &parents)
}

/// Refuses scenes that list a node twice, or one that has a parent.
fn check_roots(value: &Value, parents: &[usize]) -> Result<(), SceneError> {
    for (scene, object) in items(&value["scenes"]).enumerate() {
        let mut seen = BTreeSet::new();
        for root in items(&object["nodes"]).filter_map(Value::as_u64) {
            let root = root as usize;
            if !seen.insert(root) || parents[root] != usize::MAX {
                let place = format!("{}, nodes", label(value, "scenes", scene));
                let node = label(value, "nodes", root);
                let problem = format!("lists {node}, which is listed twice or has a parent");
                return Err(SceneError::new(place, problem, "a scene lists its root nodes once"));
            }
        }
    }
    Ok(())
}
