//! The nodes of a scene and where they are in the world.

use glam::{DAffine3, DMat4, DQuat, DVec3};
use serde_json::Value;

use super::document::Document;
use crate::scene::error::SceneError;
use crate::scene::warnings::Warnings;
use crate::scene::world::Transform;

/// The extension that hides nodes, with all below them.
pub const VISIBILITY: &str = "KHR_node_visibility";

/// A node of the scene.
pub struct PlacedNode {
    /// Index in the file.
    pub node: usize,
    /// From the node's space to world space; finite, and not always invertible.
    pub to_world: Transform,
}

/// All nodes below a scene that are not hidden, parents before children, in the file's order. The
/// hierarchy has been validated, so this ends, however deep it is.
pub fn placed_nodes(
    document: &Document,
    scene: usize,
    warnings: &mut Warnings,
) -> Result<Vec<PlacedNode>, SceneError> {
    let root = &document.root;
    let local = |node| local_transform(document, node);
    let mut placed = Vec::new();
    let mut open = starts(document, scene, warnings)?;
    open.reverse();
    while let Some((node, parent)) = open.pop() {
        if document.value["nodes"][node]["extensions"][VISIBILITY]["visible"] == false {
            continue;
        }
        let to_world = parent * local(node)?;
        let place = Transform(to_world);
        if !to_world.is_finite() {
            let label = document.label("nodes", node);
            return Err(SceneError::new(label, "its transform is not finite", "export it again"));
        }
        placed.push(PlacedNode { node, to_world: place });
        let children = root.nodes[node].children.iter().flatten().rev();
        open.extend(children.map(|child| (child.value(), to_world)));
    }
    Ok(placed)
}

/// The nodes that a scene lists, each once, with what moves them. A scene should list nodes without
/// parents alone; a node that has one stands where its parent puts it, and comes with that if the
/// scene lists it too.
fn starts(
    document: &Document,
    scene: usize,
    warnings: &mut Warnings,
) -> Result<Vec<(usize, DAffine3)>, SceneError> {
    let nodes = &document.root.nodes;
    let listed: Vec<usize> =
        document.root.scenes[scene].nodes.iter().map(|node| node.value()).collect();
    let parents = parents(document);
    let mut waits = vec![false; nodes.len()];
    listed.iter().for_each(|&node| waits[node] = true);
    let comes_with_another = below(document, &parents, &waits);
    let mut starts = Vec::with_capacity(listed.len());
    for node in listed {
        let label = || document.label("nodes", node);
        if comes_with_another[node] || !std::mem::take(&mut waits[node]) {
            let text = "is listed by the scene although it comes with another: shown once";
            warnings.add(&label(), text);
            continue;
        }
        if parents[node].is_some() {
            warnings.add(&label(), "is listed by the scene without its parent, which moves it");
        }
        let above = parents[node].map(|parent| to_world(document, parent, &parents));
        starts.push((node, above.transpose()?.unwrap_or(DAffine3::IDENTITY)));
    }
    Ok(starts)
}

/// The parent of every node that has one.
pub fn parents(document: &Document) -> Vec<Option<usize>> {
    let nodes = &document.root.nodes;
    let mut parents = vec![None; nodes.len()];
    for (parent, node) in nodes.iter().enumerate() {
        for child in node.children.iter().flatten() {
            parents[child.value()] = Some(parent);
        }
    }
    parents
}

/// From the space of a node to the world.
pub fn to_world(
    document: &Document,
    node: usize,
    parents: &[Option<usize>],
) -> Result<DAffine3, SceneError> {
    let mut to_world = DAffine3::IDENTITY;
    let mut open = Some(node);
    while let Some(node) = open {
        to_world = local_transform(document, node)? * to_world;
        open = parents[node];
    }
    Ok(to_world)
}

/// Which nodes are somewhere below one that the scene lists.
fn below(document: &Document, parents: &[Option<usize>], listed: &[bool]) -> Vec<bool> {
    let mut below = vec![false; listed.len()];
    let mut open: Vec<usize> = (0..listed.len()).filter(|&node| parents[node].is_none()).collect();
    while let Some(node) = open.pop() {
        for child in document.root.nodes[node].children.iter().flatten() {
            below[child.value()] = below[node] || listed[node];
            open.push(child.value());
        }
    }
    below
}

/// Where a node is in its parent's space. In double precision: the typed document has but single,
/// in which a scene a kilometer from the origin stands on a grid of a tenth of a millimeter.
fn local_transform(document: &Document, node: usize) -> Result<DAffine3, SceneError> {
    const UNIT_TOLERANCE: f64 = 1e-2;
    let value = &document.value["nodes"][node];
    let at = |key: &str| format!("{}, {key}", document.label("nodes", node));
    if let Some(matrix) = numbers(&value["matrix"]) {
        let matrix = DMat4::from_cols_array(&matrix);
        let last = matrix.row(3).to_array();
        if matrix.is_finite() && last != [0.0, 0.0, 0.0, 1.0] {
            let problem = "must have the last row 0 0 0 1";
            let remedy = "glTF matrices are affine and listed by column";
            return Err(SceneError::new(at("matrix"), problem, remedy));
        }
        return Ok(DAffine3::from_mat4(matrix));
    }
    let rotation = numbers(&value["rotation"]).map_or(DQuat::IDENTITY, DQuat::from_array);
    if (rotation.length() - 1.0).abs() > UNIT_TOLERANCE {
        let problem = format!("must have length 1, not {}", rotation.length());
        return Err(SceneError::new(at("rotation"), problem, "normalize it"));
    }
    Ok(DAffine3::from_scale_rotation_translation(
        numbers(&value["scale"]).map_or(DVec3::ONE, DVec3::from_array),
        rotation.normalize(),
        numbers(&value["translation"]).map_or(DVec3::ZERO, DVec3::from_array),
    ))
}

/// The numbers of an array that the typed document has found to be one of so many; none if it is
/// not there.
fn numbers<const N: usize>(array: &Value) -> Option<[f64; N]> {
    let numbers: Option<Vec<f64>> = array.as_array()?.iter().map(Value::as_f64).collect();
    numbers?.try_into().ok()
}
