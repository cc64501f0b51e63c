//! What moves the vertices of a mesh: morph targets, skins, and places that make it flat.

use glam::{DAffine3, DMat3, DMat4, DVec3, Vec3};
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;

use super::accessors;
use super::animations::index_of;
use super::document::Document;
use super::hierarchy::{self, PlacedNode};
use crate::scene::error::SceneError;
use crate::scene::world::Transform;

const AGAIN: &str = "export the scene again";

/// Numbers of a matrix that take vertices out of all range.
const LARGE: f64 = 1e30;

/// How a mesh that hangs on a node is moved, vertex by vertex.
pub struct Pose {
    /// The node.
    pub node: usize,
    /// How much of each morph target is added.
    weights: Vec<f32>,
    motion: Motion,
}

/// Where morphed vertices go.
enum Motion {
    None,
    /// All by one matrix, which cannot be inverted.
    Flat(DAffine3),
    /// By the joints of a skin: from the space of the mesh to that of the place.
    Skin(Vec<DAffine3>),
}

/// Positions, and normals if there are any.
pub struct Vertices {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
}

impl Pose {
    /// That of a mesh on a node, if it is moved, and where it then stands.
    pub fn of(
        document: &Document,
        placed: &PlacedNode,
        mesh: usize,
    ) -> Result<(Option<Self>, Transform), SceneError> {
        let node = &document.root.nodes[placed.node];
        let of_mesh = document.root.meshes[mesh].weights.as_deref();
        let weights = node.weights.as_deref().or(of_mesh).unwrap_or_default().to_vec();
        let label = || document.label("nodes", placed.node);
        if weights.iter().any(|weight| !weight.is_finite()) {
            return Err(SceneError::new(format!("{}, weights", label()), "are not finite", AGAIN));
        }
        let pose = |weights: Vec<f32>, motion| Some(Self { node: placed.node, weights, motion });
        if let Some(skin) = node.skin {
            let (joints, place) = joints(document, skin.value(), &label())?;
            return Ok((pose(weights, Motion::Skin(joints)), place));
        }
        let place = placed.to_world;
        if let Err(fault) = place.check() {
            if place.0.matrix3.to_cols_array().iter().any(|number| number.abs() > LARGE) {
                return Err(SceneError::at(&label(), fault));
            }
            let there = DAffine3::from_translation(place.0.translation);
            let flat = DAffine3::from_mat3(place.0.matrix3);
            return Ok((pose(weights, Motion::Flat(flat)), Transform(there)));
        }
        let is_morphed = weights.iter().any(|weight| *weight != 0.0);
        Ok((is_morphed.then(|| pose(weights, Motion::None)).flatten(), place))
    }

    /// Whether the mesh has no volume left, whatever it had.
    pub fn is_flat(&self) -> bool {
        matches!(self.motion, Motion::Flat(_))
    }

    /// Whether fronts of triangles come to lie on their backs: they are to be turned round, as
    /// those of a mesh in a mirror.
    pub fn mirrors(&self) -> bool {
        match &self.motion {
            Motion::None | Motion::Flat(_) => false,
            Motion::Skin(joints) => {
                joints.iter().map(|joint| joint.matrix3.determinant()).sum::<f64>() < 0.0
            }
        }
    }

    /// Moves the vertices of a primitive.
    pub fn apply(
        &self,
        document: &Document,
        primitive: &Primitive,
        vertices: &mut Vertices,
        place: &str,
    ) -> Result<(), SceneError> {
        self.morph(document, primitive, vertices, place)?;
        match &self.motion {
            Motion::None => Ok(()),
            Motion::Flat(flat) => {
                for position in &mut vertices.positions {
                    *position = flat.transform_point3(position.as_dvec3()).as_vec3();
                }
                vertices.normals.clear();
                Ok(())
            }
            Motion::Skin(joints) => skin(document, primitive, vertices, (joints, place)),
        }
    }

    fn morph(
        &self,
        document: &Document,
        primitive: &Primitive,
        vertices: &mut Vertices,
        place: &str,
    ) -> Result<(), SceneError> {
        let targets = primitive.targets.iter().flatten().zip(&self.weights).enumerate();
        for (index, (target, &weight)) in targets.filter(|(_, (_, weight))| **weight != 0.0) {
            let Vertices { positions, normals } = vertices;
            for (accessor, to, name) in
                [(target.positions, positions, "POSITION"), (target.normals, normals, "NORMAL")]
            {
                let Some(accessor) = accessor.filter(|_| !to.is_empty()) else { continue };
                let at = format!("{place}, target {index}, {name}");
                check_count(document, accessor.value(), to.len(), &at)?;
                let moves = accessors::vectors(document, accessor.value(), &at)?;
                for (to, by) in to.iter_mut().zip(moves) {
                    *to += weight * Vec3::from_array(by);
                }
            }
        }
        Ok(())
    }
}

/// Refuses, before they are read, elements that are not as many as the vertices.
fn check_count(
    document: &Document,
    accessor: usize,
    vertices: usize,
    place: &str,
) -> Result<(), SceneError> {
    let claimed = accessors::count(document, accessor);
    if claimed == vertices as u64 {
        return Ok(());
    }
    let problem = format!("{claimed} elements for {vertices} vertices");
    Err(SceneError::new(place, problem, "export the mesh again"))
}

/// From the space of a skinned mesh to that of its place, for every joint, and the place: near the
/// first joint, as the mesh's own node has no part in it.
fn joints(
    document: &Document,
    index: usize,
    node: &str,
) -> Result<(Vec<DAffine3>, Transform), SceneError> {
    let skins = document.value["skins"].as_array().map_or(0, Vec::len);
    if index >= skins {
        let problem = format!("{index} is not an index into the file's {skins} skins");
        return Err(SceneError::new(format!("{node}, skin"), problem, AGAIN));
    }
    let skin = &document.value["skins"][index];
    let label = document.label("skins", index);
    let nodes = document.root.nodes.len();
    let parents = hierarchy::parents(document);
    let mut to_world = Vec::new();
    for joint in skin["joints"].as_array().into_iter().flatten() {
        let joint = index_of(joint, nodes, || format!("{label}, joints"))?;
        to_world.push(hierarchy::to_world(document, joint, &parents)?);
    }
    let Some(first) = to_world.first() else {
        return Err(SceneError::new(label, "has no joints", AGAIN));
    };
    let origin = first.translation;
    let bound = match &skin["inverseBindMatrices"] {
        none if none.is_null() => vec![DAffine3::IDENTITY; to_world.len()],
        accessor => {
            let place = format!("{label}, inverseBindMatrices");
            let accessor = index_of(accessor, document.root.accessors.len(), || place.clone())?;
            let matrices = accessors::matrices(document, accessor, &place)?;
            let affine = |matrix: &[f32; 16]| {
                DAffine3::from_mat4(DMat4::from_cols_array(&matrix.map(f64::from)))
            };
            if matrices.len() < to_world.len() {
                let problem = format!("{} matrices for {} joints", matrices.len(), to_world.len());
                return Err(SceneError::new(place, problem, AGAIN));
            }
            matrices.iter().map(affine).collect()
        }
    };
    let home = DAffine3::from_translation(-origin);
    let joints: Vec<DAffine3> =
        to_world.iter().zip(bound).map(|(to_world, bound)| home * *to_world * bound).collect();
    match joints.iter().all(|joint| joint.is_finite()) && origin.is_finite() {
        true => Ok((joints, Transform(DAffine3::from_translation(origin)))),
        false => Err(SceneError::new(label, "moves joints to what is not finite", AGAIN)),
    }
}

/// Moves vertices with the joints of a skin, by their weights.
fn skin(
    document: &Document,
    primitive: &Primitive,
    vertices: &mut Vertices,
    (joints, place): (&[DAffine3], &str),
) -> Result<(), SceneError> {
    let count = vertices.positions.len();
    let mut sums = vec![(0.0, DAffine3 { matrix3: DMat3::ZERO, translation: DVec3::ZERO }); count];
    for set in 0.. {
        let find = |semantic: Semantic| primitive.attributes.get(&Checked::Valid(semantic));
        let (rows, weights) = match (find(Semantic::Joints(set)), find(Semantic::Weights(set))) {
            (Some(rows), Some(weights)) => (rows.value(), weights.value()),
            (None, None) if set > 0 => break,
            (_, _) => {
                let problem = "has a skin, and no JOINTS and WEIGHTS that go together";
                return Err(SceneError::new(place, problem, "export the mesh again"));
            }
        };
        let [at_rows, at_weights] =
            ["JOINTS", "WEIGHTS"].map(|name| format!("{place}, {name}_{set}"));
        check_count(document, rows, count, &at_rows)?;
        check_count(document, weights, count, &at_weights)?;
        let rows = accessors::fours(document, rows, &at_rows)?;
        let weights = accessors::fours(document, weights, &at_weights)?;
        for ((sum, rows), weights) in sums.iter_mut().zip(rows).zip(weights) {
            for (row, weight) in rows.into_iter().zip(weights).filter(|(_, it)| *it != 0.0) {
                let Some(joint) = joints.get(row as usize) else {
                    let problem = format!("{row} is not one of the {} joints", joints.len());
                    return Err(SceneError::new(at_rows, problem, "export the mesh again"));
                };
                add(sum, joint, f64::from(weight));
            }
        }
    }
    let Vertices { positions, normals } = vertices;
    for ((share, matrix), position) in sums.iter().zip(positions.iter_mut()) {
        // What no joint has a share in goes with the first.
        let moved = match *share == 0.0 {
            true => joints[0].transform_point3(position.as_dvec3()),
            false => matrix.transform_point3(position.as_dvec3()) / *share,
        };
        *position = moved.as_vec3();
    }
    for ((share, matrix), normal) in sums.iter().zip(normals) {
        let matrix = if *share == 0.0 { joints[0].matrix3 } else { matrix.matrix3 };
        *normal = (of_normals(matrix) * normal.as_dvec3()).normalize_or_zero().as_vec3();
    }
    Ok(())
}

fn add((share, matrix): &mut (f64, DAffine3), joint: &DAffine3, weight: f64) {
    *share += weight;
    matrix.matrix3 += joint.matrix3 * weight;
    matrix.translation += joint.translation * weight;
}

/// What takes normals along: the transposed inverse, of any positive length.
fn of_normals(matrix: DMat3) -> DMat3 {
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * matrix.determinant().signum()
}
