//! Mitsuba 3's XML in: from a file to a [`World`].
//!
//! `xml` reads elements into the `tree` of objects, with parameters (`text`), includes and
//! references; `fields` are what objects are asked for, and refuse what nobody asks for. `shapes`
//! (with `mesh`), `bsdfs`, `media`, `emitters`, `sensors` and `integrators` know the types of what
//! their names say, and `spectra` what all of these have.
//!
//! Signs and frames are Mitsuba's where it says how things stand: its polarizers turn clockwise,
//! its cameras look along z. What the objects then do to light is ours.

mod bsdfs;
mod definitions;
mod emitters;
mod fields;
mod glass;
mod integrators;
mod media;
mod mesh;
mod sensors;
mod shapes;
mod spectra;
mod text;
mod textures;
mod transforms;
mod tree;
mod xml;

use std::collections::BTreeMap;
use std::mem;
use std::path::Path;
use std::sync::Arc;

use hecs::Entity;

use self::bsdfs::{Surface, diffuse_or_black};
use self::fields::{Fields, object_of};
use self::shapes::{Body, Form};
use self::tree::{Object, Tag, Tree};
use self::xml::Paths;
use super::error::{Findings, SceneError};
use super::gltf::Edit;
use super::gltf::files::Files;
use super::view::{LightChoice, View};
use super::warnings::Warnings;
use super::world::{
    Asked, Boundary, Bsdf, Filling, Geometry, Material, MeasuredTable, Mesh, Name, Picture, Sides,
    Skin, Transform, World,
};
use crate::image::read_bytes;
use crate::spectrum::Spectrum;

/// Most bytes of a scene.
const BYTES_MAX: u64 = 1 << 28;

/// How a camera and light are stated.
const STATE_CAMERA: &str = "add a <sensor>, and choose it with --camera ID if there are several";
const STATE_LIGHT: &str = "add an <emitter>, as <emitter type=\"constant\"/>";

/// A scene that has been read, of which worlds are made.
pub struct MitsubaFile {
    tree: Tree,
    paths: Paths,
    files: Files,
    /// The file, and how it was read.
    bytes: Vec<u8>,
    allow_outside: bool,
    definitions: Vec<(String, String)>,
}

impl MitsubaFile {
    /// Reads a scene and what it includes, if need be (`allow_outside`) from outside its folder;
    /// with values of its parameters.
    ///
    /// # Errors
    /// When a file cannot be read, or is none of Mitsuba 3.
    pub fn read(
        path: &Path,
        allow_outside: bool,
        definitions: &[(String, String)],
    ) -> Result<Self, SceneError> {
        let bytes = read_bytes(path, BYTES_MAX).map_err(|error| {
            let refused = SceneError::new("", format!("cannot be read: {error}"), "");
            refused.of_system(error.kind()).in_file(path)
        })?;
        Self::from_memory(path, &bytes, allow_outside, definitions)
    }

    /// The same from the contents of the file.
    ///
    /// # Errors
    /// As [`MitsubaFile::read`].
    pub fn from_memory(
        path: &Path,
        bytes: &[u8],
        allow_outside: bool,
        definitions: &[(String, String)],
    ) -> Result<Self, SceneError> {
        let files = Files::of_scene(path, allow_outside);
        files.note_scene(bytes);
        let read = xml::read(bytes, &files, definitions);
        let (tree, paths) = read.map_err(|error| error.in_file(path))?;
        let (bytes, definitions) = (bytes.to_vec(), definitions.to_vec());
        Ok(Self { tree, paths, files, bytes, allow_outside, definitions })
    }

    /// The same file with other values of its parameters, `define/NAME` each.
    ///
    /// # Errors
    /// When an edit is of anything else, or the scene has no such parameter, or is none with it.
    pub fn redefined(&self, path: &Path, edits: &[Edit]) -> Result<Self, SceneError> {
        let definitions = definitions::with_edits(&self.definitions, edits);
        let definitions = definitions.map_err(|error| error.in_file(path))?;
        Self::from_memory(path, &self.bytes, self.allow_outside, &definitions)
    }

    /// Says if the scene has not all parameters of these edits. Nothing that it refers to outside
    /// of its folder is looked at, and what else is wrong with it is told by who reads it.
    ///
    /// # Errors
    /// When an edit is of anything but a parameter that is there.
    pub fn check_edits(path: &Path, bytes: &[u8], edits: &[Edit]) -> Result<(), SceneError> {
        let definitions = definitions::with_edits(&[], edits)?;
        let files = Files::of_scene(path, false);
        xml::check_parameters(bytes, &files, &definitions)
    }

    /// How it asks to be rendered by a camera.
    ///
    /// # Errors
    /// When something in that is not supported, or wrong.
    pub fn asked(&self, view: &View) -> Result<Asked, SceneError> {
        let mut import = self.import(&self.files, String::new());
        let sensors = import.look_around(|import, object, tag| match tag {
            Tag::Integrator => import.add_integrator(object),
            Tag::Shape
            | Tag::Emitter
            | Tag::Bsdf
            | Tag::Medium
            | Tag::Phase
            | Tag::Texture
            | Tag::Volume
            | Tag::Film
            | Tag::Filter
            | Tag::Sampler
            | Tag::Scene
            | Tag::Sensor => Ok(()),
        });
        let (sensors, mut findings) = sensors;
        findings.note(import.add_camera(&sensors, view));
        findings.result()?;
        Ok(import.world.asked)
    }

    /// A world in the making, of this name.
    fn import<'a>(&'a self, files: &'a Files, name: String) -> Import<'a> {
        Import {
            tree: &self.tree,
            paths: &self.paths,
            files,
            world: World::new(name),
            warnings: Warnings::default(),
            materials: BTreeMap::new(),
            media: BTreeMap::new(),
            geometries: BTreeMap::new(),
            pictures: BTreeMap::new(),
            tables: BTreeMap::new(),
            shapes: 0,
            has_environment: false,
        }
    }

    /// The scene as it is seen.
    ///
    /// # Errors
    /// When something in it is not supported, wrong, or not physical, or there is no such camera,
    /// or a time is wanted.
    pub fn world(&self, path: &Path, view: &View) -> Result<World, SceneError> {
        if view.time.is_some() {
            let problem = "scenes of Mitsuba have none";
            let error = SceneError::new("animations", problem, "leave out --time");
            return Err(error.in_file(path));
        }
        let files = self.files.again();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut import = self.import(&files, stem);
        import.scene(view).map_err(|error| error.in_file(path))?;
        let Import { mut world, mut warnings, .. } = import;
        world.file = path.to_owned();
        let read = files.read().into_iter();
        (world.files, world.checksums) = read.map(|file| (file.path, file.checksum)).unzip();
        let mut sentences = mem::take(&mut warnings).sentences();
        sentences.append(&mut world.warnings);
        world.warnings = sentences;
        Ok(world)
    }
}

/// A scene on its way from objects to the world.
struct Import<'a> {
    tree: &'a Tree,
    paths: &'a Paths,
    files: &'a Files,
    world: World,
    warnings: Warnings,
    /// Material entities or what is wrong with them, by the objects that they are made of.
    materials: BTreeMap<MaterialKey, Result<Entity, SceneError>>,
    media: BTreeMap<usize, Result<Entity, SceneError>>,
    /// Meshes by file, index, and whether they are flat, inside out, and with mirrored texture
    /// coordinates.
    geometries: BTreeMap<(String, u32, [bool; 3]), Arc<Geometry>>,
    /// Pictures of textures by file.
    pictures: BTreeMap<String, Arc<Picture>>,
    /// Measured tables by file.
    tables: BTreeMap<String, MeasuredTable>,
    /// How many shapes instances have made.
    shapes: usize,
    has_environment: bool,
}

/// The BSDF and the emitter of a material, and whether it emits where its back is never seen, or
/// the front has become the back.
type MaterialKey = (Option<usize>, Option<usize>, bool, bool);

impl Import<'_> {
    fn scene(&mut self, view: &View) -> Result<(), SceneError> {
        let (sensors, mut findings) = self.look_around(|import, object, tag| match tag {
            Tag::Shape => import.add_shape(object),
            Tag::Emitter => import.add_emitter(object),
            Tag::Integrator => import.add_integrator(object),
            // Sensors are looked at when it is known which is wanted, and the others where
            // something refers to them.
            Tag::Sensor | Tag::Bsdf | Tag::Medium | Tag::Phase | Tag::Texture | Tag::Volume => {
                Ok(())
            }
            Tag::Film | Tag::Filter | Tag::Sampler | Tag::Scene => {
                let label = import.tree.objects[object].label();
                Err(SceneError::new(label, "has no place in a scene", "move it to a sensor"))
            }
        });
        let camera = findings.note(self.add_camera(&sensors, view));
        findings.result()?;
        if camera == Some(None) {
            self.world.frame_or(STATE_CAMERA)?;
        }
        // One of no power is stated.
        let has_emitter = self.tree.objects.iter().any(|object| object.tag == Tag::Emitter);
        if view.light == LightChoice::Auto && !has_emitter {
            self.world.light_up(STATE_LIGHT)?;
        }
        Ok(())
    }

    /// Looks at what stands in the scene itself; which of it are sensors, and what is wrong.
    fn look_around(
        &mut self,
        mut look: impl FnMut(&mut Self, usize, Tag) -> Result<(), SceneError>,
    ) -> (Vec<usize>, Findings) {
        const ROOT: usize = 0;
        let (mut sensors, mut findings) = (Vec::new(), Findings::default());
        for child in &self.tree.objects[ROOT].children {
            let Some(object) = object_of(child) else { continue };
            let tag = self.tree.objects[object].tag;
            if tag == Tag::Sensor {
                sensors.push(object);
            }
            findings.note(look(self, object, tag));
        }
        (sensors, findings)
    }

    /// Adds what has the form of a shape, with its material and media.
    fn add_surface(&mut self, fields: &Fields, form: Form) -> Result<(), SceneError> {
        let bsdf = fields.only(Tag::Bsdf)?;
        let emitter = fields.only(Tag::Emitter)?;
        if let Some(sensor) = fields.only(Tag::Sensor)? {
            let label = self.tree.objects[sensor].label();
            return Err(SceneError::new(label, "a shape cannot be a sensor", "move it out"));
        }
        let mut boundary = self.boundary(fields)?;
        fields.finish()?;
        let is_inside_out = matches!(form.body, Body::Ball(_, true));
        let key = (bsdf, emitter, form.is_closed && emitter.is_some(), is_inside_out);
        let material = self.material(fields, key)?;
        let bsdf = self.world.entities().get::<&Bsdf>(material).map(|bsdf| (*bsdf).clone());
        if let Ok(bsdf) = bsdf {
            self.check_sheet(fields, &bsdf, &form)?;
            if !bsdf.transmits() && (boundary.interior, boundary.exterior) != (None, None) {
                let text = "the media of opaque surfaces are ignored: boundaries that light \
                            passes say where it is";
                self.warnings.add(&fields.label(), text);
                boundary = Boundary::default();
            }
            if bsdf == Bsdf::Null && boundary.interior.is_none() {
                if boundary.exterior.is_none() {
                    // It is not there at all.
                    return Ok(());
                }
                boundary.interior = Some(Filling::Clear);
            }
        }
        if is_inside_out {
            boundary =
                Boundary { interior: boundary.exterior, exterior: boundary.interior, ..boundary };
        }
        let skin = Skin { material, boundary };
        let (name, place) = (Name(fields.label()), Transform(form.to_world));
        let put = match form.body {
            Body::Mesh(geometry) if geometry.triangles.is_empty() => {
                self.warnings.add(&name.0, "has no triangle with an area and is skipped");
                return Ok(());
            }
            Body::Mesh(geometry) => self.world.put_mesh(name, Mesh(geometry), skin, place),
            Body::Ball(ball, _) => self.world.put_ball(name, ball, skin, place),
        };
        put.map(|_| ()).map_err(|fault| fields.fault(fault, &[]))
    }

    /// Refuses a sheet with an axis on a shape that has none.
    fn check_sheet(&self, fields: &Fields, bsdf: &Bsdf, form: &Form) -> Result<(), SceneError> {
        let has_axis = match bsdf {
            Bsdf::Polarizer { .. } | Bsdf::Retarder { .. } | Bsdf::Sheet { .. } => true,
            Bsdf::Absorber
            | Bsdf::Diffuse { .. }
            | Bsdf::Conductor { .. }
            | Bsdf::RoughConductor { .. }
            | Bsdf::RoughDielectric { .. }
            | Bsdf::MetallicRoughness { .. }
            | Bsdf::Layered { .. }
            | Bsdf::Plastic { .. }
            | Bsdf::Measured { .. }
            | Bsdf::Blend { .. }
            | Bsdf::Brushed { .. }
            | Bsdf::Filmed { .. }
            | Bsdf::FilmedConductor { .. }
            | Bsdf::FilmedDielectric { .. }
            | Bsdf::Dielectric { .. }
            | Bsdf::DispersiveDielectric { .. }
            | Bsdf::ThinDielectric { .. }
            | Bsdf::Null => false,
        };
        if !has_axis || form.has_axis {
            return Ok(());
        }
        let problem = "a sheet with an axis needs a shape that says where x is";
        Err(fields.refuse(problem, "use a rectangle that is not flipped"))
    }

    /// The media on both sides of a shape.
    fn boundary(&mut self, fields: &Fields) -> Result<Boundary, SceneError> {
        let mut boundary = Boundary::default();
        for (name, object) in fields.objects(Tag::Medium) {
            let medium = Filling::Medium(self.medium(object)?);
            let side = match name {
                "interior" => &mut boundary.interior,
                "exterior" => &mut boundary.exterior,
                _ => {
                    let remedy = "name it `interior` or `exterior`";
                    return Err(fields.refuse("does not say where its medium is", remedy));
                }
            };
            if side.replace(medium).is_some() {
                return Err(fields.wrong(name, "is stated twice", "keep one"));
            }
        }
        Ok(boundary)
    }

    /// The entity of a medium, made once.
    fn medium(&mut self, object: usize) -> Result<Entity, SceneError> {
        if let Some(known) = self.media.get(&object) {
            return known.clone();
        }
        let fields = Fields::of(self.tree, object);
        let made = media::read(&fields).and_then(|medium| {
            let put = self.world.put_medium(Name(fields.label()), medium);
            put.map_err(|fault| fields.fault(fault, &[]))
        });
        self.media.insert(object, made.clone());
        made
    }

    /// The entity of the material of a shape, made once.
    fn material(&mut self, shape: &Fields, key: MaterialKey) -> Result<Entity, SceneError> {
        if let Some(known) = self.materials.get(&key) {
            return known.clone();
        }
        let made = self.new_material(shape, key);
        self.materials.insert(key, made.clone());
        made
    }

    fn new_material(
        &mut self,
        shape: &Fields,
        (bsdf, emitter, is_closed, is_inside_out): MaterialKey,
    ) -> Result<Entity, SceneError> {
        let (emission, glow) = match emitter {
            Some(emitter) => {
                let (emission, glow) = emitters::area(&Fields::of(self.tree, emitter))?;
                (Some(emission), glow)
            }
            None => (None, None),
        };
        let own = bsdf.map(|bsdf| &self.tree.objects[bsdf]);
        let surface = match bsdf {
            Some(bsdf) => bsdfs::read(&Fields::of(self.tree, bsdf))?,
            None => {
                let reflectance = if emission.is_some() { 0.0 } else { 0.5 };
                diffuse_or_black(Spectrum::Constant(reflectance)).into()
            }
        };
        let Surface { mut bsdf, two_sided, mut wanted, even, stain, parts, .. } = surface;
        let Surface { has_smooth_parts, measured, .. } = surface;
        if let Some(object) = measured {
            bsdf = self.measured(object)?;
        }
        wanted.extend(glow);
        let label = own.map_or_else(|| shape.label(), Object::label);
        if has_smooth_parts {
            let text = "blends smooth metal, which is of facets of alpha 0.001 there";
            self.warnings.add(&label, text);
        }
        let refuse = |problem: &str, remedy: &str| Err(SceneError::new(&label, problem, remedy));
        let mut material = Material { bsdf, sides: Sides { two_sided }, emission };
        if is_inside_out {
            material = match turned(material) {
                Some(material) => material,
                None => {
                    let problem = "is on a sphere that is inside out and one-sided";
                    return refuse(problem, "use twosided, or a mesh");
                }
            };
        }
        if two_sided && material.emission.is_some() {
            // Only the front emits here, and both sides would.
            if is_closed || material.bsdf == Bsdf::Absorber {
                material.sides.two_sided = false;
            } else {
                let problem = "is two-sided, and emits from the front alone";
                return refuse(problem, "use a bsdf that is not twosided");
            }
        }
        let textures = self.textures((&wanted, &parts), (even, stain))?;
        if is_inside_out && textures.relief.is_some() {
            return refuse("has a relief on a sphere that is inside out", "use a mesh");
        }
        let put = self.world.put_material(Name(label.clone()), material);
        let entity = put.map_err(|fault| SceneError::at(&label, fault))?;
        if !textures.is_empty() {
            self.world.set_textures(entity, textures)?;
        }
        Ok(entity)
    }

    /// The model of a measured table: at the wavelengths of the render, or at one for all.
    fn measured(&mut self, object: usize) -> Result<Bsdf, SceneError> {
        let fields = Fields::of(self.tree, object);
        let name = fields.text("filename")?.unwrap_or_default();
        let path = self.paths.of(name, self.files);
        let table = match self.tables.get(&path) {
            Some(known) => known.clone(),
            None => {
                let place = format!("{}, filename", fields.label());
                let bytes = self.files.named(&path, &place, u64::MAX)?;
                let read = MeasuredTable::new(&path, bytes);
                let table = read.map_err(|fault| SceneError::at(&place, fault))?;
                self.tables.insert(path, table.clone());
                table
            }
        };
        let places = match fields.number("wavelength")? {
            None | Some(-1.0) => table.places(),
            Some(nm) => {
                let at = table.places().at(nm as f32);
                let [first, last] = table.ends_nm();
                let problem = format!("{nm} nm is not among those of the table");
                let remedy = format!("give one from {first} to {last} nm");
                Spectrum::Constant(at.map_err(|_| fields.wrong("wavelength", problem, remedy))?)
            }
        };
        Ok(Bsdf::Measured { table, places })
    }

    /// A mesh without what no ray ever meets.
    fn cleaned(&mut self, fields: &Fields, mesh: Geometry) -> Result<Arc<Geometry>, SceneError> {
        const TRIANGLES: [&str; 2] = ["triangle without area", "triangles without area"];
        let (geometry, dropped) =
            self.world.cleaned(mesh).map_err(|fault| fields.fault(fault.of("filename"), &[]))?;
        self.warnings.add_counted(&fields.label(), dropped, TRIANGLES, "dropped");
        Ok(geometry)
    }
}

/// What a material is to the other side of a surface; none if the world has no such one.
fn turned(material: Material) -> Option<Material> {
    let is_same = material.sides.two_sided && material.emission.is_none();
    let bsdf = match material.bsdf.clone() {
        Bsdf::Dielectric { ior, exterior_ior } => {
            Bsdf::Dielectric { ior: exterior_ior, exterior_ior: ior }
        }
        Bsdf::DispersiveDielectric { ior, exterior_ior } => {
            Bsdf::DispersiveDielectric { ior: exterior_ior, exterior_ior: ior }
        }
        Bsdf::RoughDielectric { ior, exterior_ior, alpha, distribution, multiple_scattering } => {
            let (ior, exterior_ior) = (exterior_ior, ior);
            Bsdf::RoughDielectric { ior, exterior_ior, alpha, distribution, multiple_scattering }
        }
        Bsdf::Brushed { of, grain } if of.transmits() => {
            let inner = turned(Material { bsdf: *of, ..material.clone() })?;
            Bsdf::brushed(inner.bsdf, grain)
        }
        bsdf @ (Bsdf::ThinDielectric { .. } | Bsdf::Null) => bsdf,
        bsdf @ (Bsdf::Absorber
        | Bsdf::Diffuse { .. }
        | Bsdf::Conductor { .. }
        | Bsdf::RoughConductor { .. }
        | Bsdf::MetallicRoughness { .. }
        | Bsdf::Layered { .. }
        | Bsdf::Plastic { .. }
        | Bsdf::Measured { .. }
        | Bsdf::Blend { .. }
        | Bsdf::Brushed { .. })
            if is_same =>
        {
            bsdf
        }
        Bsdf::Absorber
        | Bsdf::Diffuse { .. }
        | Bsdf::Conductor { .. }
        | Bsdf::RoughConductor { .. }
        | Bsdf::MetallicRoughness { .. }
        | Bsdf::Layered { .. }
        | Bsdf::Plastic { .. }
        | Bsdf::Measured { .. }
        | Bsdf::Blend { .. }
        | Bsdf::Brushed { .. }
        | Bsdf::Filmed { .. }
        | Bsdf::FilmedConductor { .. }
        | Bsdf::FilmedDielectric { .. }
        | Bsdf::Polarizer { .. }
        | Bsdf::Retarder { .. }
        | Bsdf::Sheet { .. } => return None,
    };
    let emits = material.emission.is_some();
    (!emits).then_some(Material { bsdf, ..material })
}
