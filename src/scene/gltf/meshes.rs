//! Meshes: from primitives of any triangle mode to checked, indexed triangles.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use glam::{Vec3, Vec4};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index};

use super::extension::{Body, MESH};
use super::hierarchy::PlacedNode;
use super::poses::{Pose, Vertices};
use super::{Import, Part, accessors, instances, validate};
use crate::scene::error::{Findings, SceneError};
use crate::scene::world::{Boundary, Geometry, Mesh, Name, Transform};

/// Most vertices and corners that the meshes of a scene may have together: what a file of a few
/// kilobytes can ask for must not fill the memory. (Copies of a mesh are counted where they are
/// made.)
const ELEMENTS_MAX: u64 = 1 << 27;
/// What a part of a mesh instance counts for beside its vertices and corners.
const ELEMENTS_OF_PART: u64 = 1 << 8;

/// What has been read of a primitive, with what is to be said about it.
#[derive(Clone)]
pub struct ReadGeometry {
    geometry: Arc<Geometry>,
    /// Triangles without area, which are left out.
    dropped: usize,
    /// Corners whose normal is on the back.
    behind: usize,
}

/// A primitive of a mesh, and how its vertices are moved.
type Posed<'a> = (usize, usize, Option<&'a Pose>);

/// What has been read of all meshes of a file, by mesh and primitive.
#[derive(Default)]
pub struct ReadGeometries(Mutex<BTreeMap<(usize, usize, bool), Slot>>);

/// What has been read of one primitive, if it has been.
type Slot = Arc<Mutex<Option<ReadGeometry>>>;

impl ReadGeometries {
    /// What there is at a place. Who is the first to ask has it locked until it is filled, so that
    /// worlds which are made at the same time share it too.
    fn at(&self, key: (usize, usize, bool)) -> Slot {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(all.entry(key).or_default())
    }
}

impl Import<'_> {
    /// Adds the parts of a mesh instance, all with the same media on their two sides.
    pub fn add_mesh(
        &mut self,
        mesh: usize,
        node: &Body,
        boundary: Boundary,
        placed: &PlacedNode,
    ) -> Result<(), SceneError> {
        let object = &self.document.root.meshes[mesh];
        let label = self.document.label("meshes", mesh);
        Body::of(&self.document.value["meshes"][mesh], &label, &MESH)?;
        let (pose, place) = Pose::of(self.document, placed, mesh)?;
        let pose = pose.as_ref();
        if pose.is_some_and(Pose::is_flat) {
            self.warnings.add(node.label(), "has a scale of zero, which makes its mesh flat");
        }
        let mut places = instances::places(self.document, placed, node, place)?;
        let all = places.len();
        places.retain(|(_, place)| place.check().is_ok());
        let text = "of no size skipped";
        self.warnings.add_counted(node.label(), all - places.len(), ["copy", "copies"], text);
        let mut findings = Findings::default();
        for (index, primitive) in object.primitives.iter().enumerate() {
            let part = format!("{label}, primitive {index}");
            self.count_elements(ELEMENTS_OF_PART * places.len() as u64, &part)?;
            let geometry = self.geometry((mesh, index, pose), primitive, &part);
            if let Ok(None) = geometry {
                continue;
            }
            let material = primitive.material.map(|it| it.value());
            let first = places.first().map_or(Transform::IDENTITY, |(_, place)| *place);
            let skin = self.skin(material, boundary, (&part, &first));
            let (geometry, skin) = (findings.note(geometry), findings.note(skin));
            let (Some(Some(geometry)), Some(skin)) = (geometry, skin) else { continue };
            for (instance, place) in &places {
                let name = Name(format!("{}{instance}, {part}", node.label()));
                let mesh = Mesh(Arc::clone(&geometry));
                let put = self.world.put_mesh(name, mesh, skin, *place);
                findings.note(put.map_err(|fault| match fault.field.starts_with("TEXCOORD_") {
                    true => SceneError::at(&part, fault),
                    false => node.place(fault),
                }));
            }
        }
        findings.result()
    }

    /// The triangles of a primitive, read once; nothing if there are none to be rendered.
    fn geometry(
        &mut self,
        (mesh, index, pose): Posed,
        primitive: &Primitive,
        place: &str,
    ) -> Result<Part, SceneError> {
        let key = (mesh, index, pose.map(|pose| pose.node));
        if let Some(known) = self.geometries.get(&key) {
            return known.clone();
        }
        let geometry = match is_of_triangles(primitive.mode, place) {
            Ok(true) => self.read_geometry((mesh, index, pose), primitive, place),
            Ok(false) => {
                self.has_lines = true;
                self.warnings.add(place, "points and lines have no surface and are skipped");
                Ok(None)
            }
            Err(error) => Err(error),
        };
        self.geometries.insert(key, geometry.clone());
        geometry
    }

    /// Adds to the vertices and corners so far; refuses what is too much.
    fn count_elements(&mut self, more: u64, place: &str) -> Result<(), SceneError> {
        self.elements = self.elements.saturating_add(more);
        if self.is_full() {
            let problem = format!("brings the scene above {ELEMENTS_MAX} vertices and corners");
            return Err(SceneError::new(place, problem, "use smaller or fewer meshes"));
        }
        Ok(())
    }

    /// Whether the file has asked for more vertices and corners than any may.
    pub fn is_full(&self) -> bool {
        self.elements > ELEMENTS_MAX
    }

    fn read_geometry(
        &mut self,
        (mesh, index, pose): Posed,
        primitive: &Primitive,
        place: &str,
    ) -> Result<Part, SceneError> {
        let Some(positions) = primitive.attributes.get(&Checked::Valid(Semantic::Positions)) else {
            let remedy = "export the mesh with vertex positions";
            return Err(SceneError::new(place, "has no POSITION", remedy));
        };
        let value = &self.document.value;
        let (mesh_value, accessor) =
            (&value["meshes"][mesh], &value["accessors"][positions.value()]);
        let compression = validate::compression(&mesh_value["primitives"][index]);
        if let (Some(name), true) = (compression, accessor["bufferView"].is_null()) {
            return Err(validate::unsupported(place, name));
        }
        // Counted before anything is read.
        let corners = primitive.indices.unwrap_or(*positions).value();
        let claims = [positions.value(), corners].map(|a| accessors::count(self.document, a));
        self.count_elements(claims[0].saturating_add(claims[1]), place)?;
        if pose.is_some() {
            let read = self.cleaned(primitive, *positions, (pose, place))?;
            self.warn_about(primitive, &read, place);
            return Ok((!read.geometry.triangles.is_empty()).then_some(read.geometry));
        }
        let shared = self.shared.at((mesh, index, self.has_coordinates));
        let mut shared = shared.lock().unwrap_or_else(PoisonError::into_inner);
        let read = match &*shared {
            Some(read) => {
                self.world.keep_in_mind(&read.geometry);
                read.clone()
            }
            None => shared.insert(self.cleaned(primitive, *positions, (None, place))?).clone(),
        };
        drop(shared);
        self.warn_about(primitive, &read, place);
        Ok((!read.geometry.triangles.is_empty()).then_some(read.geometry))
    }

    /// The triangles of a primitive as they stand in the buffers, but for those without area.
    fn cleaned(
        &mut self,
        primitive: &Primitive,
        positions: Index<Accessor>,
        (pose, place): (Option<&Pose>, &str),
    ) -> Result<ReadGeometry, SceneError> {
        let positions = self.vectors(positions.value(), &format!("{place}, POSITION"))?;
        let corners = match primitive.indices {
            Some(accessor) => {
                accessors::indices(self.document, accessor.value(), &format!("{place}, indices"))?
            }
            None => (0..positions.len() as u32).collect(),
        };
        let mut vertices = Vertices { positions, normals: Vec::new() };
        if let Some(accessor) = primitive.attributes.get(&Checked::Valid(Semantic::Normals)) {
            let at = format!("{place}, NORMAL");
            let claimed = accessors::count(self.document, accessor.value());
            check_normals(claimed, vertices.positions.len(), &at)?;
            let normals = self.vectors(accessor.value(), &at)?;
            vertices.normals = normals.into_iter().map(Vec3::normalize_or_zero).collect();
        }
        if let Some(pose) = pose {
            pose.apply(self.document, primitive, &mut vertices, place)?;
        }
        let mut triangles = triangles(primitive.mode, &corners, place)?;
        if pose.is_some_and(Pose::mirrors) {
            triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        let Vertices { positions, normals } = vertices;
        let mut geometry = Geometry { normals, ..Geometry::new(positions, triangles) };
        self.read_paint(&mut geometry, primitive, place)?;
        if pose.is_some() {
            // They are those at rest; what follows from coordinates moves with the triangles.
            geometry.tangents.clear();
        }
        let (geometry, dropped) =
            self.world.cleaned(geometry).map_err(|fault| match fault.field.as_str() {
                "positions" => SceneError::at(place, fault.of("POSITION")),
                "triangles" => SceneError::at(place, fault.of("indices")),
                "normals" => SceneError::at(place, fault.of("NORMAL")),
                "texture_coordinates" => SceneError::at(place, fault.of("TEXCOORD_0")),
                "texture_coordinates_1" => SceneError::at(place, fault.of("TEXCOORD_1")),
                "colors" => SceneError::at(place, fault.of("COLOR_0")),
                "tangents" => SceneError::at(place, fault.of("TANGENT")),
                _ => SceneError::at(place, fault),
            })?;
        let behind = geometry.corners_behind();
        Ok(ReadGeometry { geometry, dropped, behind })
    }

    /// What textures and stretched facets go by, if the file has any, and the colors of vertices.
    fn read_paint(
        &self,
        geometry: &mut Geometry,
        primitive: &Primitive,
        place: &str,
    ) -> Result<(), SceneError> {
        let document = self.document;
        let of = |semantic: Semantic, name: &str| {
            let accessor = primitive.attributes.get(&Checked::Valid(semantic))?;
            Some((accessor.value(), format!("{place}, {name}")))
        };
        if let Some((accessor, at)) = of(Semantic::Colors(0), "COLOR_0") {
            let colors = accessors::colors(document, accessor, &at)?.into_iter();
            let not_negative =
                |color: Vec4| if color.is_finite() { color.max(Vec4::ZERO) } else { color };
            geometry.colors = colors.map(not_negative).collect();
        }
        if !self.has_coordinates {
            return Ok(());
        }
        if let Some((accessor, at)) = of(Semantic::TexCoords(0), "TEXCOORD_0") {
            geometry.texture_coordinates = accessors::coordinates(document, accessor, &at)?;
        }
        if let Some((accessor, at)) = of(Semantic::TexCoords(1), "TEXCOORD_1") {
            geometry.texture_coordinates_1 = accessors::coordinates(document, accessor, &at)?;
        }
        if let Some((accessor, at)) = of(Semantic::Tangents, "TANGENT") {
            geometry.tangents = accessors::tangents(document, accessor, &at)?;
        }
        Ok(())
    }

    fn vectors(&self, accessor: usize, place: &str) -> Result<Vec<Vec3>, SceneError> {
        let vectors = accessors::vectors(self.document, accessor, place)?;
        Ok(vectors.into_iter().map(Vec3::from_array).collect())
    }

    /// Says what is not rendered as it stands in the file.
    fn warn_about(&mut self, primitive: &Primitive, read: &ReadGeometry, at: &str) {
        const TRIANGLES: [&str; 2] = ["triangle without area", "triangles without area"];
        const CORNERS: [&str; 2] = ["corner", "corners"];
        let &ReadGeometry { ref geometry, dropped, behind } = read;
        if geometry.triangles.is_empty() {
            self.warnings.add(at, "has no triangle with an area and is skipped");
        } else if primitive.mode == Checked::Valid(Mode::Triangles) {
            self.warnings.add_counted(at, dropped, TRIANGLES, "dropped");
        }
        if behind > 0 && behind == 3 * geometry.triangles.len() {
            let text = "all normals are on the backs of the triangles (or missing), and are \
                        mirrored to the fronts: the mesh may be inside out, and a material of one \
                        side is black from behind";
            self.warnings.add(at, text);
        } else {
            let text = "with a normal on the back of the triangle (or none): mirrored to the front";
            self.warnings.add_counted(at, behind, CORNERS, text);
        }
    }
}

/// Refuses, before they are read, normals that are not as many as the vertices.
fn check_normals(normals: u64, vertices: usize, place: &str) -> Result<(), SceneError> {
    if normals == vertices as u64 {
        return Ok(());
    }
    let problem = format!("{normals} normals for {vertices} vertices");
    Err(SceneError::new(place, problem, "export the mesh again"))
}

/// Whether a primitive is made of triangles, and not of points or lines.
fn is_of_triangles(mode: Checked<Mode>, place: &str) -> Result<bool, SceneError> {
    match mode {
        Checked::Valid(Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) => Ok(true),
        Checked::Valid(Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) => Ok(false),
        Checked::Invalid => {
            let place = format!("{place}, mode");
            Err(SceneError::new(place, "is not known", "export the mesh as triangles"))
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
        _ => return refuse("is not made of triangles".to_owned()),
    };
    Ok(rows)
}
