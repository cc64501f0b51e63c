//! glTF 2.0 in: from a file to a [`World`].
//!
//! `document` reads and validates; `hierarchy` walks the nodes; `media`, `meshes`, `materials`,
//! `lights` and `cameras` turn what hangs on them into entities; `extension` reads the vendor keys.
//! `edit` changes the JSON by name before that, in the `places` that names mean; `edited` keeps
//! what was edited, and `unused` checks what is edited and not seen.

mod accessors;
mod animations;
mod blends;
mod cameras;
mod document;
mod edit;
mod edited;
mod extension;
mod facets;
pub(super) mod files;
mod films;
mod gloss;
mod hierarchy;
mod instances;
mod layers;
mod lights;
mod luminaires;
mod materials;
mod media;
mod meshes;
mod own_textures;
mod particles;
mod phase_matrix;
mod places;
mod plastics;
mod poses;
mod sheets;
mod sides;
mod spectra;
mod stains;
mod textures;
mod unused;
mod validate;
mod volume;
mod write;

use std::collections::BTreeMap;
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use glam::{DQuat, DVec3, Vec3};
use hecs::Entity;

use self::document::Document;
pub use self::edit::{Edit, Editable};
pub use self::edited::{EditedFile, keys_of_kind};
use self::extension::{Body, CLEAR_SKY as SKY_KEYS, ENVIRONMENT, NODE, SCENE};
use self::files::Files;
use self::hierarchy::PlacedNode;
use self::meshes::ReadGeometries;
use self::volume::Volume;
pub use self::write::Written;
use super::error::{Findings, SceneError};
use super::view::{LightChoice, View};
use super::warnings::Warnings;
use super::world::{
    Backdrop, BackdropSource, Ball, Boundary, ClearSky, Environment, Filling, Geometry, Name, SKY,
    SKY_GRADIENT, World,
};
use crate::math::text::listed;
use crate::spectrum::Spectrum;

/// Light by cube maps that are blurred by roughness.
const IMAGE_LIGHTS: &str = "EXT_lights_image_based";
/// How a camera is stated.
const STATE_CAMERA: &str =
    "add a node with a camera, and choose it with --camera NAME if there are several";

/// A .gltf or .glb file that has been read, with its buffers: worlds are made of it, as it stands
/// and after edits. They share the meshes.
pub struct GltfFile {
    pub(in crate::scene) path: PathBuf,
    document: Document,
    geometries: ReadGeometries,
    /// Whether the file as it stands, without edits, emits no light.
    is_dark: OnceLock<bool>,
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
        Ok(Self {
            path: path.to_owned(),
            document,
            geometries: ReadGeometries::default(),
            is_dark: OnceLock::new(),
        })
    }

    /// The default scene after some edits, as it is seen.
    ///
    /// # Errors
    /// As `load`, when there is no such camera, and when an edit is about nothing that is there.
    pub fn world(&self, view: &View, edits: &[Edit]) -> Result<World, SceneError> {
        let import = || {
            let mut warnings = Warnings::default();
            let moved = match view.time {
                Some(time) => Some(self.document.moved(time, &mut warnings)?),
                None if animations::has_any(&self.document) => {
                    let text = "nothing moves: nodes and meshes are as the file states them \
                                (--time SECONDS shows a moment)";
                    warnings.add("animations", text);
                    None
                }
                None => None,
            };
            let document = moved.as_ref().unwrap_or(&self.document);
            let (mut world, is_dark) = match edits {
                [] => self.import(document, view, edits)?,
                _ => self.import(&document.edited(edits)?, view, edits)?,
            };
            // A lamp that an edit has turned off is off.
            if view.light == LightChoice::Auto && is_dark && self.is_dark(edits) {
                world.light_up(&how_to_light())?;
            }
            world.warnings.splice(0..0, warnings.sentences());
            Ok(world)
        };
        import().map_err(|error: SceneError| error.in_file(&self.path))
    }

    /// Whether the file emits no light without the edits, or nobody can tell.
    fn is_dark(&self, edits: &[Edit]) -> bool {
        let is_dark = || {
            let imported = self.import(&self.document, &View::default(), &[]);
            imported.map_or(true, |(_, is_dark)| is_dark)
        };
        edits.is_empty() || *self.is_dark.get_or_init(is_dark)
    }

    /// A world, and whether nothing in it sheds light on other things.
    fn import(
        &self,
        document: &Document,
        view: &View,
        edits: &[Edit],
    ) -> Result<(World, bool), SceneError> {
        let mut import = Import::new(document, &self.geometries);
        let scene = import.scene()?;
        import.add_scene(scene, view)?;
        let stem = || self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let name = document.root.scenes[scene].name.clone();
        let mut world = mem::replace(&mut import.world, World::new(""));
        world.name = name.unwrap_or_else(stem);
        world.file = self.path.clone();
        let read = document.files.read().into_iter();
        (world.files, world.checksums) = read.map(|file| (file.path, file.checksum)).unzip();
        world.warnings = mem::take(&mut import.warnings).sentences();
        import.check_edited(edits)?;
        if import.wants_frame {
            let framed = world.frame_or(STATE_CAMERA);
            framed.map_err(|error| import.why_nothing_is_seen().unwrap_or(error))?;
        }
        let mut no_lamps = import.unlit;
        let wants_frame = import.wants_frame;
        let marks = import.glowing.into_iter().filter(|&(_, is_bright)| wants_frame || !is_bright);
        no_lamps.extend(marks.map(|(entity, _)| entity));
        let is_dark = !import.has_sky && !world.emits(&no_lamps);
        Ok((world, is_dark))
    }
}

/// Keys of the vendor extension, by the name of their definition in `sunstone.schema.json`.
pub fn extension_keys() -> impl Iterator<Item = (&'static str, &'static [&'static str])> {
    extension::ALL.iter().map(|keys| (keys.definition, keys.known))
}

/// How the sky that is put in is stated.
fn how_to_light() -> String {
    let gradient = SKY_GRADIENT.to_array();
    format!(
        "give the scene {{\"extensions\": {{\"SUNSTONE_polarization\": {{\"environment\": \
         {{\"radiance\": {SKY}, \"gradient\": {gradient:?}}}}}}}}}, or add lights"
    )
}

/// A clear sky.
fn clear_sky(body: &Body) -> Result<ClearSky, SceneError> {
    let sun = match body.numbers("sun_direction")?.as_deref() {
        Some(&[x, y, z]) => DVec3::new(x, y, z),
        Some(_) => {
            let place = body.field("sun_direction");
            return Err(SceneError::new(place, "must be three numbers", "a vector to the sun"));
        }
        None => return Err(body.missing("sun_direction", "give a vector to the sun, y > 0")),
    };
    let number = |key: &str, default: f64| Ok(body.number(key)?.unwrap_or(default));
    let turbidity = number("turbidity", ClearSky::TURBIDITY)?;
    let max_degree = number("max_degree", ClearSky::MAX_DEGREE)?;
    let sky = ClearSky { sun, turbidity, max_degree };
    sky.check().map_err(|fault| body.place(fault))?;
    Ok(sky)
}

/// What makes a sky brighter on one side.
fn gradient(environment: &Body) -> Result<Vec3, SceneError> {
    let Some(numbers) = environment.numbers("gradient")? else { return Ok(Vec3::ZERO) };
    match numbers[..] {
        [x, y, z] => Ok(DVec3::new(x, y, z).as_vec3()),
        _ => {
            let problem = "must be three numbers";
            let remedy = "a vector of length 1 at most, to where the sky is brighter";
            Err(SceneError::new(environment.field("gradient"), problem, remedy))
        }
    }
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
    /// What materials say of bodies, by index in the file.
    volumes: BTreeMap<usize, Volume>,
    /// What bodies of materials are filled with.
    fillings: BTreeMap<usize, Filling>,
    /// What has been read for other worlds of the same file.
    shared: &'a ReadGeometries,
    /// Triangles or what is wrong with them, by mesh and primitive, and by the node that moves
    /// their vertices, if one does.
    geometries: BTreeMap<(usize, usize, Option<usize>), Result<Part, SceneError>>,
    /// Vertices and corners that the meshes read so far have, and some for each of their instances.
    elements: u64,
    /// Whether anything goes by the coordinates and tangents of meshes.
    has_coordinates: bool,
    /// The blends whose parts are being read, by index in the file.
    blending: Vec<usize>,
    /// Whether pictures have been decoded.
    has_pictures: bool,
    /// Whether a camera is to be put in.
    wants_frame: bool,
    /// Materials that emit because they look the same in any light, and not to shed any.
    unlit: Vec<Entity>,
    /// Materials that emit by pictures, and whether more than white or by a spectrum: all others
    /// are marks on a model, and so are these where nobody says how it is to be seen.
    glowing: Vec<(Entity, bool)>,
    /// Whether the file says what comes from outside, be it nothing.
    has_sky: bool,
    /// Whether points or lines were skipped.
    has_lines: bool,
}

impl<'a> Import<'a> {
    fn new(document: &'a Document, shared: &'a ReadGeometries) -> Self {
        let mut warnings = Warnings::default();
        let mut unknown = validate::unknown_extensions(&document.value);
        if unknown.remove(IMAGE_LIGHTS) {
            let text = "EXT_lights_image_based is ignored, and so is the light of its pictures: \
                        give the scene an environment, its uri an equirectangular picture of them";
            warnings.add("", text);
        }
        if !unknown.is_empty() {
            let text = format!("extensions that are not known are ignored: {}", listed(unknown));
            warnings.add_like("extensions", "", &text);
        }
        let has_textures = document.value["textures"].as_array().is_some_and(|it| !it.is_empty());
        let has_coordinates =
            has_textures || facets::any_is_stretched(&document.value["materials"]);
        Self {
            document,
            world: World::new(""),
            warnings,
            media: Vec::new(),
            materials: BTreeMap::new(),
            volumes: BTreeMap::new(),
            fillings: BTreeMap::new(),
            shared,
            geometries: BTreeMap::new(),
            elements: 0,
            has_coordinates,
            blending: Vec::new(),
            has_pictures: false,
            wants_frame: false,
            unlit: Vec::new(),
            glowing: Vec::new(),
            has_sky: false,
            has_lines: false,
        }
    }

    /// Why there are no shapes to put a camera before, if there is more to say than that.
    fn why_nothing_is_seen(&self) -> Option<SceneError> {
        let problem = "has nothing that could be seen: points and lines have no surface";
        let remedy = "export the mesh with triangles, for instance lines as thin tubes";
        (self.has_lines && self.geometries.values().all(|part| matches!(part, Ok(None))))
            .then(|| SceneError::new("scene", problem, remedy))
    }

    /// The scene to load: the default one, else the first.
    fn scene(&mut self) -> Result<usize, SceneError> {
        let root = &self.document.root;
        if root.scene.is_none() && root.scenes.len() > 1 {
            let text = format!(
                "the file has {} scenes and does not say which to show: the first is shown",
                root.scenes.len()
            );
            self.warnings.add_like("scenes", "scene", &text);
        }
        let scene = root.scene.map_or(0, |scene| scene.value());
        if scene < root.scenes.len() {
            return Ok(scene);
        }
        Err(SceneError::new("scenes", "the file has no scene", "export the scene again"))
    }

    fn add_scene(&mut self, scene: usize, view: &View) -> Result<(), SceneError> {
        let nodes = hierarchy::placed_nodes(self.document, scene, &mut self.warnings)?;
        self.add_media(scene)?;
        let mut findings = Findings::default();
        findings.note(validate::check_required(&self.document.value));
        for node in &nodes {
            findings.note(self.add_node(node));
            if self.is_full() {
                break;
            }
        }
        findings.note(self.add_camera(&nodes, view));
        findings.note(self.add_environment(scene));
        findings.result()
    }

    fn add_node(&mut self, placed: &PlacedNode) -> Result<(), SceneError> {
        let node = &self.document.root.nodes[placed.node];
        let label = self.document.label("nodes", placed.node);
        let body = Body::of(&self.document.value["nodes"][placed.node], &label, &NODE)?;
        let boundary = self.boundary(&body)?;
        if body.has("shape") || body.has("sphere_radius") {
            self.add_sphere(placed, &body, boundary)?;
        } else if body.has("material") {
            let remedy = "add `shape` or `sphere_radius`; meshes have materials of their own";
            return Err(SceneError::new(body.field("material"), "belongs to a sphere", remedy));
        } else if let Some(mesh) = node.mesh {
            self.add_mesh(mesh.value(), &body, boundary, placed)?;
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
        self.add_luminaire(&self.document.value["nodes"][placed.node], &label, placed.to_world)
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
        let skin = self.skin(material, boundary, (body.label(), &placed.to_world))?;
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

    /// The picture of what is around, if an environment has one.
    fn backdrop(&mut self, environment: &Body) -> Result<Option<Backdrop>, SceneError> {
        if let Some(sky) = environment.object("sky", &SKY_KEYS)? {
            let refuse = |key: &str| {
                let problem = "does not go with `sky`";
                Err(SceneError::new(environment.field(key), problem, "keep one of them"))
            };
            if let Some(key) = ["gradient", "rotation", "stokes", "uri"]
                .into_iter()
                .find(|key| environment.has(key))
            {
                return refuse(key);
            }
            return clear_sky(&sky).map(|sky| Some(sky.into()));
        }
        let Some(uri) = environment.word("uri")? else {
            if environment.has("rotation") {
                let problem = "turns the picture of `uri`, and there is none";
                return Err(SceneError::new(environment.field("rotation"), problem, "remove it"));
            }
            return Ok(None);
        };
        let field = environment.field("uri");
        let rotation = match environment.numbers("rotation")?.as_deref() {
            None => DQuat::IDENTITY,
            Some(&[x, y, z, w]) => DQuat::from_xyzw(x, y, z, w),
            Some(_) => {
                let problem = "must be four numbers";
                let remedy = "a quaternion [x, y, z, w] of length 1, as nodes have";
                return Err(SceneError::new(environment.field("rotation"), problem, remedy));
            }
        };
        let picture = self.document.picture_around(uri, &field)?;
        let source = match uri.starts_with("data:") {
            true => BackdropSource::Memory,
            false => BackdropSource::File(uri.to_owned()),
        };
        let backdrop = Backdrop { picture, rotation, source };
        backdrop.doubt().into_iter().for_each(|text| self.warnings.add(&field, text));
        Ok(Some(backdrop))
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
            let backdrop = self.backdrop(&environment)?;
            let radiance = environment.emission("radiance", self.document)?;
            let radiance = match (radiance, &backdrop) {
                (Some(radiance), _) => radiance,
                (None, Some(_)) => Spectrum::Constant(1.0),
                (None, None) => {
                    let problem = "has neither `radiance` nor `uri` nor `sky`";
                    return Err(SceneError::new(field, problem, "add one of them"));
                }
            };
            if let Some(other) = &found {
                let problem = format!("is described twice, by {other} too");
                return Err(SceneError::new(field, problem, "keep one of them"));
            }
            let sky = Environment { radiance, gradient: gradient(&environment)?, backdrop };
            let checked = sky.check().map_err(|fault| environment.place(fault));
            checked?;
            let stokes = environment.stokes("stokes")?;
            let put = match sky.mean().values().iter().all(|value| *value == 0.0) {
                true => Ok(()),
                false => {
                    let put = self.world.put_environment(Name("environment".into()), sky);
                    put.and_then(|sky| match stokes {
                        Some(stokes) => self.world.put_stokes(sky, stokes),
                        None => Ok(()),
                    })
                }
            };
            put.map_err(|fault| environment.place(fault))?;
            found = Some(field);
            self.has_sky = true;
        }
        Ok(())
    }
}
