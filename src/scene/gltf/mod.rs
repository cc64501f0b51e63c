//! glTF 2.0 in: from a file to a [`World`].
//!
//! `document` reads and validates; `hierarchy` walks the nodes; `media`, `meshes`, `materials`,
//! `lights` and `cameras` turn what hangs on them into entities; `extension` reads the vendor keys.
//! `edit` changes the JSON by name before that, in the `places` that names mean; `edited` keeps
//! what was edited, and `unused` checks what is edited and not seen.

mod accessors;
mod cameras;
mod document;
mod edit;
mod edited;
mod extension;
pub(super) mod files;
mod hierarchy;
mod lights;
mod materials;
mod media;
mod meshes;
mod particles;
mod phase_matrix;
mod places;
mod spectra;
mod unused;
mod validate;
mod volume;
mod write;

use std::collections::BTreeMap;
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use hecs::Entity;

use self::document::Document;
pub use self::edit::{Edit, Editable};
pub use self::edited::{EditedFile, keys_of_kind};
use self::extension::{Body, ENVIRONMENT, NODE, SCENE};
use self::files::Files;
use self::hierarchy::PlacedNode;
use self::meshes::ReadGeometries;
pub use self::write::Written;
use super::error::{Findings, SceneError};
use super::warnings::Warnings;
use super::world::{Ball, Boundary, Environment, Filling, Geometry, Name, World};
use crate::math::text::listed;

/// A .gltf or .glb file that has been read, with its buffers: worlds are made of it, as it stands
/// and after edits. They share the meshes.
pub struct GltfFile {
    pub(in crate::scene) path: PathBuf,
    document: Document,
    geometries: ReadGeometries,
}

impl GltfFile {
    /// Reads a .gltf or .glb file with its buffers, if need be (`allow_outside`) from outside its
    /// folder.
    ///
    /// # Errors
    /// When a file cannot be read, or is not glTF 2.0.
    pub fn read(path: &Path, allow_outside: bool) -> Result<Self, SceneError> {
        Self::of(path, Document::read(path, allow_outside))
    }

    /// The same from the contents of the file, which refers to nothing outside its folder.
    ///
    /// # Errors
    /// As [`GltfFile::read`].
    pub fn from_memory(path: &Path, bytes: &[u8]) -> Result<Self, SceneError> {
        Self::of(path, Document::parse(bytes, Files::of_scene(path, false)))
    }

    fn of(path: &Path, document: Result<Document, SceneError>) -> Result<Self, SceneError> {
        let document = document.map_err(|error| error.in_file(path))?;
        Ok(Self { path: path.to_owned(), document, geometries: ReadGeometries::default() })
    }

    /// The default scene after some edits, seen by the camera of this name or number, or by the
    /// first.
    ///
    /// # Errors
    /// As `load`, when there is no such camera, and when an edit is about nothing that is there.
    pub fn world(&self, camera: Option<&str>, edits: &[Edit]) -> Result<World, SceneError> {
        let import = || match edits {
            [] => self.import(&self.document, camera, edits),
            _ => self.import(&self.document.edited(edits)?, camera, edits),
        };
        import().map_err(|error| error.in_file(&self.path))
    }

    fn import(
        &self,
        document: &Document,
        camera: Option<&str>,
        edits: &[Edit],
    ) -> Result<World, SceneError> {
        let mut import = Import::new(document, &self.geometries);
        let scene = import.scene()?;
        import.add_scene(scene, camera)?;
        let stem = || self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let name = document.root.scenes[scene].name.clone();
        let mut world = mem::replace(&mut import.world, World::new(""));
        world.name = name.unwrap_or_else(stem);
        world.file = self.path.clone();
        let read = document.files.read().into_iter();
        (world.files, world.checksums) = read.map(|file| (file.path, file.checksum)).unzip();
        world.warnings = mem::take(&mut import.warnings).sentences();
        import.check_edited(edits)?;
        Ok(world)
    }
}

/// Keys of the vendor extension, by the name of their definition in `sunstone.schema.json`.
pub fn extension_keys() -> impl Iterator<Item = (&'static str, &'static [&'static str])> {
    extension::ALL.iter().map(|keys| (keys.definition, keys.known))
}

/// The triangles of a primitive, if it has any that can be rendered.
type Part = Option<Arc<Geometry>>;

/// A scene on its way from the document to the world.
struct Import<'a> {
    document: &'a Document,
    world: World,
    warnings: Warnings,
    /// Medium entities, by index in the file.
    media: Vec<Entity>,
    /// Material entities or what is wrong with them, by index in the file; `None` is the material
    /// of what has none.
    materials: BTreeMap<Option<usize>, Result<Entity, SceneError>>,
    /// What bodies absorb whose materials say so, by index in the file.
    volumes: BTreeMap<usize, Filling>,
    /// What has been read for other worlds of the same file.
    shared: &'a ReadGeometries,
    /// Triangles or what is wrong with them, by mesh and primitive.
    geometries: BTreeMap<(usize, usize), Result<Part, SceneError>>,
    /// Vertices and corners that the meshes read so far have, and some for each of their instances.
    elements: u64,
}

impl<'a> Import<'a> {
    fn new(document: &'a Document, shared: &'a ReadGeometries) -> Self {
        let mut warnings = Warnings::default();
        let unknown = validate::unknown_extensions(&document.value);
        if !unknown.is_empty() {
            let text = format!("extensions that are not known are ignored: {}", listed(unknown));
            warnings.add_like("extensions", "", &text);
        }
        if document.value["animations"].as_array().is_some_and(|all| !all.is_empty()) {
            warnings.add("", "animations are ignored");
        }
        Self {
            document,
            world: World::new(""),
            warnings,
            media: Vec::new(),
            materials: BTreeMap::new(),
            volumes: BTreeMap::new(),
            shared,
            geometries: BTreeMap::new(),
            elements: 0,
        }
    }

    /// The scene to load: the default one, else the first.
    fn scene(&self) -> Result<usize, SceneError> {
        let root = &self.document.root;
        let scene = root.scene.map_or(0, |scene| scene.value());
        if scene < root.scenes.len() {
            return Ok(scene);
        }
        Err(SceneError::new("scenes", "the file has no scene", "export the scene again"))
    }

    fn add_scene(&mut self, scene: usize, camera: Option<&str>) -> Result<(), SceneError> {
        let nodes = hierarchy::placed_nodes(self.document, scene, &mut self.warnings)?;
        self.add_media(scene)?;
        let mut findings = Findings::default();
        for node in &nodes {
            findings.note(self.add_node(node));
            if self.is_full() {
                break;
            }
        }
        findings.note(self.add_camera(&nodes, camera));
        findings.note(self.add_environment(scene));
        findings.result()
    }

    fn add_node(&mut self, placed: &PlacedNode) -> Result<(), SceneError> {
        let node = &self.document.root.nodes[placed.node];
        let label = self.document.label("nodes", placed.node);
        let body = Body::of(&self.document.value["nodes"][placed.node], &label, &NODE)?;
        if node.skin.is_some() {
            self.warnings.add(&label, "the skin is ignored, the mesh stays in its bind pose");
        }
        let boundary = self.boundary(&body)?;
        if body.has("shape") || body.has("sphere_radius") {
            self.add_sphere(placed, &body, boundary)?;
        } else if body.has("material") {
            let remedy = "add `shape` or `sphere_radius`; meshes have materials of their own";
            return Err(SceneError::new(body.field("material"), "belongs to a sphere", remedy));
        } else if let Some(mesh) = node.mesh {
            self.add_mesh(mesh.value(), &body, boundary, placed.to_world)?;
        } else if let Some(key) =
            ["interior", "exterior", "priority"].into_iter().find(|key| body.has(key))
        {
            let remedy = "move it to the node of the mesh";
            return Err(SceneError::new(body.field(key), "belongs to a mesh or sphere", remedy));
        }
        let extensions = node.extensions.as_ref();
        if let Some(light) = extensions.and_then(|all| all.khr_lights_punctual.as_ref()) {
            self.add_light(light.light.value(), &label, placed.to_world)?;
        }
        Ok(())
    }

    /// Adds an analytic sphere. A mesh on the same node is a stand-in for viewers that know none:
    /// its first material is the sphere's, and its triangles are not used.
    fn add_sphere(
        &mut self,
        placed: &PlacedNode,
        body: &Body,
        boundary: Boundary,
    ) -> Result<(), SceneError> {
        let ball = self.ball(body)?;
        let materials = self.document.root.materials.len();
        let own = body.index("material", "materials", materials)?;
        let mesh = self.document.root.nodes[placed.node].mesh;
        let stand_in = mesh.and_then(|mesh| {
            let primitive = self.document.root.meshes[mesh.value()].primitives.first()?;
            primitive.material.map(|material| material.value())
        });
        let material = match (own, stand_in) {
            (Some(own), Some(other)) if own != other => {
                let problem = format!("{own} contradicts the mesh, which has material {other}");
                let remedy = "state the material once";
                return Err(SceneError::new(body.field("material"), problem, remedy));
            }
            (None, None) => {
                let remedy = "add `material`, or a mesh that has one";
                return Err(SceneError::new(body.label(), "the sphere has no material", remedy));
            }
            _ => own.or(stand_in),
        };
        let skin = self.skin(material, boundary, body.label())?;
        let name = Name(format!("{}, sphere", body.label()));
        let put = self.world.put_ball(name, ball, skin, placed.to_world);
        put.map(|_| ()).map_err(|fault| body.place(fault))
    }

    fn ball(&self, body: &Body) -> Result<Ball, SceneError> {
        const DEFAULT_RADIUS: f64 = 0.5;
        if body.has("shape") && body.has("sphere_radius") {
            let problem = "a node has either `shape` or `sphere_radius`";
            return Err(SceneError::new(body.label(), problem, "remove one of them"));
        }
        let checked = |radius: f64, field: String| {
            let ball = Ball { radius };
            ball.check().map_err(|fault| SceneError::at(&field, fault.of("")))?;
            Ok(ball)
        };
        if let Some(radius) = body.number("sphere_radius")? {
            return checked(radius, body.field("sphere_radius"));
        }
        let shapes = &self.document.value["extensions"]["KHR_implicit_shapes"]["shapes"];
        let len = shapes.as_array().map_or(0, Vec::len);
        let index = body.index("shape", "KHR_implicit_shapes", len)?.unwrap_or(0);
        let field = format!("KHR_implicit_shapes, shape {index}");
        let kind = shapes[index]["type"].as_str().unwrap_or("without type");
        if kind != "sphere" {
            let problem = format!("is a `{kind}`, and only spheres are supported");
            return Err(SceneError::new(field, problem, "use a mesh"));
        }
        let radius = &shapes[index]["sphere"]["radius"];
        match radius.as_f64() {
            Some(radius) => checked(radius, format!("{field}, sphere.radius")),
            None if radius.is_null() => Ok(Ball { radius: DEFAULT_RADIUS }),
            None => Err(SceneError::new(format!("{field}, sphere.radius"), "is not a number", "")),
        }
    }

    /// Adds the environment that the scene, or the root of the file, describes.
    fn add_environment(&mut self, scene: usize) -> Result<(), SceneError> {
        let value = &self.document.value;
        let label = self.document.label("scenes", scene);
        let mut found: Option<String> = None;
        for (object, label) in [(&value["scenes"][scene], label.as_str()), (value, "root")] {
            let body = Body::of(object, label, &SCENE)?;
            let Some(environment) = body.object("environment", &ENVIRONMENT)? else { continue };
            let field = body.field("environment");
            let Some(radiance) = environment.emission("radiance", self.document)? else {
                return Err(SceneError::new(field, "has no `radiance`", "add it"));
            };
            if let Some(other) = &found {
                let problem = format!("is described twice, by {other} too");
                return Err(SceneError::new(field, problem, "keep one of them"));
            }
            let sky = Environment { radiance };
            let put = match sky.radiance.values().iter().all(|value| *value == 0.0) {
                true => sky.check(),
                false => self.world.put_environment(Name("environment".into()), sky).map(|_| ()),
            };
            put.map_err(|fault| environment.place(fault))?;
            found = Some(field);
        }
        Ok(())
    }
}
