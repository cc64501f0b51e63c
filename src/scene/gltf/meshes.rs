//! Meshes: from primitives of any triangle mode to checked, indexed triangles.

use std::sync::Arc;

use glam::Vec3;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use super::extension::{Body, MESH};
use super::{Import, accessors};
use crate::scene::error::SceneError;
use crate::scene::world::{Boundary, Geometry, Mesh, Name, Skin, Transform};

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
        place: Transform,
    ) -> Result<(), SceneError> {
        let object = &self.document.root.meshes[mesh];
        let label = self.document.label("meshes", mesh);
        Body::of(&self.document.value["meshes"][mesh], &label, &MESH)?;
        if object.weights.is_some() {
            self.warn(format!("{label}: morph targets are ignored"));
        }
        for (index, primitive) in object.primitives.iter().enumerate() {
            let part = format!("{label}, primitive {index}");
            let geometry = self.geometry((mesh, index), primitive, &part)?;
            let material = primitive.material.map(|material| material.value());
            let skin = Skin { material: self.material(material, &part)?, boundary };
            let name = Name(format!("{}, {part}", node.label()));
            let put = self.world.put_mesh(name, Mesh(geometry), skin, place);
            put.map_err(|fault| node.place(fault))?;
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
        let geometry = self.read_geometry(primitive, positions.value(), place)?;
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
    ) -> Result<Arc<Geometry>, SceneError> {
        let at = format!("{place}, POSITION");
        let vectors = |accessor: usize, at: &str| -> Result<Vec<Vec3>, SceneError> {
            let vectors = accessors::vectors(self.document, accessor, at)?;
            Ok(vectors.into_iter().map(Vec3::from_array).collect())
        };
        let positions = vectors(positions, &at)?;
        let corners = match primitive.indices {
            Some(accessor) => {
                accessors::indices(self.document, accessor.value(), &format!("{place}, indices"))?
            }
            None => (0..positions.len() as u32).collect(),
        };
        let mut geometry = Geometry::new(positions, triangles(primitive.mode, &corners, place)?);
        if let Some(accessor) = primitive.attributes.get(&Checked::Valid(Semantic::Normals)) {
            let normals = vectors(accessor.value(), &format!("{place}, NORMAL"))?;
            geometry.normals = normals.into_iter().map(Vec3::normalize_or_zero).collect();
        }
        let (geometry, dropped) =
            self.world.cleaned(geometry).map_err(|fault| match fault.field.as_str() {
                "positions" => SceneError::at(place, fault.of("POSITION")),
                "triangles" => SceneError::at(place, fault.of("indices")),
                "normals" => SceneError::at(place, fault.of("NORMAL")),
                _ => SceneError::at(place, fault),
            })?;
        self.warn_about(primitive, &geometry, dropped, place);
        Ok(geometry)
    }

    /// Says what is not rendered as it stands in the file.
    fn warn_about(&mut self, primitive: &Primitive, geometry: &Geometry, dropped: usize, at: &str) {
        if dropped > 0 && primitive.mode == Checked::Valid(Mode::Triangles) {
            self.warn(format!("{at}: {dropped} triangles with two equal corners are dropped"));
        }
        let behind = geometry.corners_behind();
        if behind > 0 {
            self.warn(format!(
                "{at}: {behind} corners have a normal on the back of their triangle (or none); it \
                 is mirrored to the front"
            ));
        }
        for semantic in primitive.attributes.keys() {
            if let Checked::Valid(Semantic::Colors(_)) = semantic {
                self.warn(format!("{at}: vertex colors are ignored"));
            }
        }
    }
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
