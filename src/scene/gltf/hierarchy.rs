//! The nodes of a scene and where they are in the world.

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use gltf::json;

use super::document::Document;
use crate::scene::error::SceneError;

/// A node of the scene.
pub struct PlacedNode {
    /// Index in the file.
    pub node: usize,
    /// From the node's space to world space; finite and invertible.
    pub to_world: DAffine3,
}

/// How much the axes of a similarity may differ in length, and from right angles.
const SIMILARITY_TOLERANCE: f64 = 1e-4;

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
        if !is_invertible(&to_world) {
            let problem = "its transform is singular or not finite";
            let remedy = "give it, and its parents, a scale that is not zero along any axis";
            return Err(SceneError::new(label(), problem, remedy));
        }
        placed.push(PlacedNode { node, to_world });
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

/// Whether a transform is finite and keeps volumes from vanishing.
fn is_invertible(transform: &DAffine3) -> bool {
    const LEAST_RELATIVE_VOLUME: f64 = 1e-9;
    let axes = axes(&transform.matrix3);
    let volume = axes[0].length() * axes[1].length() * axes[2].length();
    let determinant = transform.matrix3.determinant().abs();
    transform.is_finite()
        && volume.is_normal()
        && determinant.is_normal()
        && determinant > LEAST_RELATIVE_VOLUME * volume
}

/// Whether it is made of rotation, reflection, translation and one scale for all axes.
pub fn is_similarity(transform: &DAffine3) -> bool {
    let axes = axes(&transform.matrix3);
    let length = axes[0].length();
    let same = |axis: &DVec3| (axis.length() / length - 1.0).abs() <= SIMILARITY_TOLERANCE;
    axes.iter().all(same) && is_orthogonal(transform)
}

/// Whether the axes are at right angles to each other.
pub fn is_orthogonal(transform: &DAffine3) -> bool {
    let [x, y, z] = axes(&transform.matrix3).map(DVec3::normalize);
    [x.dot(y), y.dot(z), z.dot(x)].iter().all(|cos| cos.abs() <= SIMILARITY_TOLERANCE)
}

fn axes(matrix: &DMat3) -> [DVec3; 3] {
    [matrix.x_axis, matrix.y_axis, matrix.z_axis]
}
