//! The nodes of a scene and where they are in the world.

use glam::{DAffine3, DMat4, DQuat, DVec3};
use gltf::json;

use super::document::Document;
use crate::scene::error::SceneError;
use crate::scene::world::Transform;

/// A node of the scene.
pub struct PlacedNode {
    /// Index in the file.
    pub node: usize,
    /// From the node's space to world space; finite and invertible.
    pub to_world: Transform,
}

/// All nodes below a scene, parents before children, in the file's order. The hierarchy has been
/// validated, so this ends, however deep it is.
pub fn placed_nodes(document: &Document, scene: usize) -> Result<Vec<PlacedNode>, SceneError> {
    let root = &document.root;
    let mut placed = Vec::new();
    let mut open: Vec<(usize, DAffine3)> =
        root.scenes[scene].nodes.iter().rev().map(|n| (n.value(), DAffine3::IDENTITY)).collect();
    while let Some((node, parent)) = open.pop() {
        let label = || document.label("nodes", node);
        let to_world = parent * local_transform(&root.nodes[node], &label())?;
        let place = Transform(to_world);
        place.check().map_err(|fault| SceneError::at(&label(), fault))?;
        placed.push(PlacedNode { node, to_world: place });
        let children = root.nodes[node].children.iter().flatten().rev();
        open.extend(children.map(|child| (child.value(), to_world)));
    }
    Ok(placed)
}

fn local_transform(node: &json::Node, label: &str) -> Result<DAffine3, SceneError> {
    const UNIT_TOLERANCE: f64 = 1e-2;
    if let Some(matrix) = node.matrix {
        let matrix = DMat4::from_cols_array(&matrix.map(f64::from));
        let last = matrix.row(3).to_array();
        if matrix.is_finite() && last != [0.0, 0.0, 0.0, 1.0] {
            let problem = "must have the last row 0 0 0 1";
            let remedy = "glTF matrices are affine and listed by column";
            return Err(SceneError::new(format!("{label}, matrix"), problem, remedy));
        }
        return Ok(DAffine3::from_mat4(matrix));
    }
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |q| DQuat::from_array(q.0.map(f64::from)));
    if (rotation.length() - 1.0).abs() > UNIT_TOLERANCE {
        let problem = format!("must have length 1, not {}", rotation.length());
        return Err(SceneError::new(format!("{label}, rotation"), problem, "normalize it"));
    }
    Ok(DAffine3::from_scale_rotation_translation(
        node.scale.map_or(DVec3::ONE, vector),
        rotation.normalize(),
        node.translation.map_or(DVec3::ZERO, vector),
    ))
}
