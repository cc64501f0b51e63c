//! Meshes: from primitives of any triangle mode to checked, indexed triangles.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use super::extension::{Body, MESH};
use super::{Import, accessors};
use crate::scene::error::SceneError;
use crate::scene::world::{Boundary, Geometry, MadeOf, Mesh, Transform};

/// Most vertices and corners that the meshes of a scene may have together: what a file of a few
/// kilobytes can ask for must not fill the memory. (Copies of a mesh are counted where they are
/// made.)
const ELEMENTS_MAX: u64 = 1 << 27;
/// What a part of a mesh instance counts for beside its vertices and corners.
const ELEMENTS_OF_PART: u64 = 1 << 8;

impl Import<'_> {
    /// Adds the parts of a mesh instance, all with the same media on their two sides.
    pub fn add_mesh(
        &mut self,
        mesh: usize,
        node: &Body,
        boundary: Boundary,
        to_world: DAffine3,
    ) -> Result<(), SceneError> {
        let object = &self.document.root.meshes[mesh];
        let label = self.document.label("meshes", mesh);
        Body::of(&self.document.value["meshes"][mesh], &label, &MESH)?;
        if object.weights.is_some() {
            self.warn(format!("{label}: morph targets are ignored"));
        }
        for (index, primitive) in object.primitives.iter().enumerate() {
            let place = format!("{label}, primitive {index}");
            let geometry = self.geometry((mesh, index), primitive, &place)?;
            let material = primitive.material.map(|material| material.value());
            let material = self.material(material, &place)?;
            self.check_boundary(node, &boundary, material)?;
            let (order, name) = self.identity(format!("{}, {place}", node.label()));
            let (transform, mesh, of) = (Transform(to_world), Mesh(geometry), MadeOf(material));
            self.entities.spawn((order, name, transform, mesh, of, boundary));
        }
        Ok(())
    }

    /// The triangles of a primitive, read once.
    fn geometry(
        &mut self,
        key: (usize, usize),
        primitive: &Primitive,
        place: &str,
    ) -> Result<Arc<Geometry>, SceneError> {
        self.count_elements(ELEMENTS_OF_PART, place)?;
        if let Some(geometry) = self.geometries.get(&key) {
            return Ok(Arc::clone(geometry));
        }
        let Some(&positions) = primitive.attributes.get(&Checked::Valid(Semantic::Positions))
        else {
            let remedy = "export the mesh with vertex positions";
            return Err(SceneError::new(place, "has no POSITION", remedy));
        };
        // Counted before anything is read.
        let corners = primitive.indices.unwrap_or(positions).value();
        let claims = [positions.value(), corners].map(|a| accessors::count(self.document, a));
        self.count_elements(claims[0].saturating_add(claims[1]), place)?;
        let geometry = Arc::new(self.read_geometry(primitive, positions.value(), place)?);
        self.geometries.insert(key, Arc::clone(&geometry));
        Ok(geometry)
    }

    /// Adds to the vertices and corners so far; refuses what is too much.
    fn count_elements(&mut self, more: u64, place: &str) -> Result<(), SceneError> {
        self.elements = self.elements.saturating_add(more);
        if self.elements > ELEMENTS_MAX {
            let problem = format!("brings the scene above {ELEMENTS_MAX} vertices and corners");
            return Err(SceneError::new(place, problem, "use smaller or fewer meshes"));
        }
        Ok(())
    }

    fn read_geometry(
        &mut self,
        primitive: &Primitive,
        positions: usize,
        place: &str,
    ) -> Result<Geometry, SceneError> {
        let at = format!("{place}, POSITION");
        let positions: Vec<Vec3> = accessors::vectors(self.document, positions, &at)?
            .into_iter()
            .map(Vec3::from_array)
            .collect();
        if let Some(vertex) = positions.iter().position(|position| !position.is_finite()) {
            let problem = format!("vertex {vertex} is not finite");
            return Err(SceneError::new(at, problem, "clean the mesh up and export it again"));
        }
        let corners = match primitive.indices {
            Some(accessor) => {
                let at = format!("{place}, indices");
                let corners = accessors::indices(self.document, accessor.value(), &at)?;
                let vertices = positions.len();
                if let Some(index) = corners.iter().find(|&&index| index as usize >= vertices) {
                    let problem = format!("{index} is not one of the {vertices} vertices");
                    return Err(SceneError::new(at, problem, "export the mesh again"));
                }
                corners
            }
            None => (0..positions.len() as u32).collect(),
        };
        let triangles = triangles(primitive.mode, &corners, place)?;
        let triangles = self.with_area(triangles, &positions, primitive, place)?;
        let normals = self.read_normals(primitive, &positions, &triangles, place)?;
        for semantic in primitive.attributes.keys() {
            if let Checked::Valid(Semantic::Colors(_)) = semantic {
                self.warn(format!("{place}: vertex colors are ignored"));
            }
        }
        Ok(Geometry { positions, normals, triangles })
    }

    /// Drops triangles with two corners in one place, which strips and the poles of spheres are
    /// full of; refuses those whose three corners are in line.
    fn with_area(
        &mut self,
        mut triangles: Vec<[u32; 3]>,
        positions: &[Vec3],
        primitive: &Primitive,
        place: &str,
    ) -> Result<Vec<[u32; 3]>, SceneError> {
        let corners = |triangle: &[u32; 3]| triangle.map(|index| positions[index as usize]);
        let is_line = |triangle: &[u32; 3]| {
            let [a, b, c] = corners(triangle);
            a == b || b == c || c == a
        };
        let flat = triangles.iter().position(|triangle| {
            !is_line(triangle) && scaled_normal(corners(triangle)) == DVec3::ZERO
        });
        if let Some(index) = flat {
            let problem = format!("triangle {index} has no area: its corners are in line");
            return Err(SceneError::new(place, problem, "dissolve it in the modeling program"));
        }
        let before = triangles.len();
        triangles.retain(|triangle| !is_line(triangle));
        let dropped = before - triangles.len();
        if triangles.is_empty() {
            let problem = "has no triangle with an area";
            return Err(SceneError::new(place, problem, "remove it or export it again"));
        }
        if dropped > 0 && primitive.mode == Checked::Valid(Mode::Triangles) {
            self.warn(format!("{place}: {dropped} triangles with two equal corners are dropped"));
        }
        Ok(triangles)
    }

    /// Unit normals per vertex, or none.
    fn read_normals(
        &mut self,
        primitive: &Primitive,
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        place: &str,
    ) -> Result<Vec<Vec3>, SceneError> {
        let Some(accessor) = primitive.attributes.get(&Checked::Valid(Semantic::Normals)) else {
            return Ok(Vec::new());
        };
        let at = format!("{place}, NORMAL");
        let normals = accessors::vectors(self.document, accessor.value(), &at)?;
        if normals.len() != positions.len() {
            let problem = format!("{} normals for {} vertices", normals.len(), positions.len());
            return Err(SceneError::new(at, problem, "export the mesh again"));
        }
        let normals: Vec<Vec3> =
            normals.into_iter().map(|n| Vec3::from_array(n).normalize_or_zero()).collect();
        let behind = triangles.iter().flat_map(|triangle| {
            let front = scaled_normal(triangle.map(|index| positions[index as usize]));
            triangle.map(|index| front.dot(normals[index as usize].as_dvec3()) <= 0.0)
        });
        let behind = behind.filter(|behind| *behind).count();
        if behind > 0 {
            self.warn(format!(
                "{place}: {behind} corners have a normal on the back of their triangle (or none); \
                 it is mirrored to the front"
            ));
        }
        Ok(normals)
    }
}

/// The normal of a triangle, of any length; zero only if its area is.
fn scaled_normal([a, b, c]: [Vec3; 3]) -> DVec3 {
    let (ab, ac) = (b.as_dvec3() - a.as_dvec3(), c.as_dvec3() - a.as_dvec3());
    ab.normalize_or_zero().cross(ac.normalize_or_zero())
}

/// Triangles out of a list, strip or fan of corners.
fn triangles(
    mode: Checked<Mode>,
    corners: &[u32],
    place: &str,
) -> Result<Vec<[u32; 3]>, SceneError> {
    let count = corners.len();
    let refuse = |problem: String| Err(SceneError::new(place, problem, "export it as triangles"));
    let rows = match mode {
        Checked::Valid(Mode::Triangles) if count.is_multiple_of(3) => {
            corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect()
        }
        Checked::Valid(Mode::Triangles) => {
            return refuse(format!("{count} corners do not make whole triangles"));
        }
        Checked::Valid(Mode::TriangleStrip) => {
            let turn = |(i, c): (usize, &[u32])| {
                if i % 2 == 0 { [c[0], c[1], c[2]] } else { [c[0], c[2], c[1]] }
            };
            corners.windows(3).enumerate().map(turn).collect()
        }
        Checked::Valid(Mode::TriangleFan) => {
            let hub = corners.first().copied().unwrap_or_default();
            corners.windows(2).skip(1).map(|c| [c[0], c[1], hub]).collect()
        }
        _ => return refuse("is made of points or lines, not triangles".to_owned()),
    };
    Ok(rows)
}
