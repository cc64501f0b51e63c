//! glTF out: a [`World`] as a .gltf file with all that is in it, the extension's keys where glTF
//! has no words. What cannot be written is refused; what is written a little otherwise is said.

mod container;
mod meshes;
mod painted;
mod parts;
mod stored;

use std::collections::{BTreeSet, HashMap};

use glam::{DAffine3, DMat4, Vec3};
use hecs::Entity;
use serde_json::{Map, Value, json};

pub use self::container::Written;
use self::meshes::{Meshes, Tint};
use self::painted::{Lists, tint_of};
use self::stored::{Stored, data_uri, open};
use super::cameras::written_film;
use super::extension::EXTENSION;
use super::facets::{self, with_facets};
use super::layers::write_layers;
use super::sides::{ONE_SIDED, has_backs};
use super::{blends, films, plastics, sheets};
use crate::polarization::Analyzer;
use crate::scene::error::{Findings, SceneError};
use crate::scene::warnings::Warnings;
use crate::scene::world::{
    Backdrop, BackdropSource, Ball, Boundary, Bsdf, ClearSky, Emission, EmittedStokes, Environment,
    Falloff, Filling, FillsScene, Incandescent, Lens, Luminaire, MadeOf, Medium, Mesh, Name, Phase,
    Picture, Projection, Punctual, PunctualKind, Raster, Resolution, Sides, Textures, Transform,
    Window, World,
};
use crate::spectrum::{RGB_WAVELENGTHS_NM, Spectrum};

/// Where formulas are written as tables, in nanometers, and the step.
const FORMULA_NM: [f32; 2] = [300.0, 1000.0];
const STEP_NM: f32 = 1.0;

impl Written {
    /// A scene with its meshes and all that it refers to.
    ///
    /// # Errors
    /// When something in it has no words there.
    pub fn of(world: &World) -> Result<Self, SceneError> {
        let mut writer = Writer::of(world);
        let document = writer.document().map_err(|error| error.in_file(&world.file))?;
        let Writer { mut warnings, stored, meshes, lists, .. } = writer;
        if lists.images.iter().any(|image| !stored.is_of_gltf(*image)) {
            let text = "some are of formats that viewers of glTF need not know, as OpenEXR";
            warnings.add("pictures", text);
        }
        let (bytes, images, warnings) = (meshes.bytes, lists.images, warnings.sentences());
        Ok(Self { document, bytes, stored, images, warnings })
    }
}

struct Writer<'a> {
    world: &'a World,
    meshes: Meshes,
    stored: Stored,
    lists: Lists,
    nodes: Vec<Value>,
    mesh_list: Vec<Value>,
    materials: Vec<Value>,
    cameras: Vec<Value>,
    lights: Vec<Value>,
    media: Vec<Value>,
    /// Numbers in the file of materials and media.
    numbers: HashMap<Entity, usize>,
    /// Which colors of vertices count for materials, if any do.
    tints: HashMap<Entity, Tint>,
    warnings: Warnings,
}

impl<'a> Writer<'a> {
    fn of(world: &'a World) -> Self {
        Self {
            world,
            meshes: Meshes::default(),
            stored: Stored::default(),
            lists: Lists::default(),
            nodes: Vec::new(),
            mesh_list: Vec::new(),
            materials: Vec::new(),
            cameras: Vec::new(),
            lights: Vec::new(),
            media: Vec::new(),
            numbers: HashMap::new(),
            tints: HashMap::new(),
            warnings: Warnings::default(),
        }
    }

    fn document(&mut self) -> Result<Value, SceneError> {
        let world = self.world;
        let mut findings = Findings::default();
        let mut scene = Map::new();
        type OfMedium<'a> = (Entity, &'a Name, &'a Medium, Option<&'a FillsScene>);
        let media = world.in_order::<OfMedium, _>(|(entity, name, medium, fills)| {
            (entity, name.clone(), medium.clone(), fills.is_some())
        });
        for (entity, name, medium, fills) in media {
            if fills {
                scene.insert("medium".into(), json!(self.media.len()));
            }
            self.numbers.insert(entity, self.media.len());
            let medium = self.medium(&name, &medium);
            self.media.extend(findings.note(medium));
        }
        self.add_materials(&mut findings);
        self.shapes(world);
        findings.note(self.add_lights());
        findings.note(self.add_sky(&mut scene));
        self.camera(world);
        findings.result()?;
        if !self.media.is_empty() {
            scene.insert("media".into(), Value::Array(std::mem::take(&mut self.media)));
        }
        Ok(self.whole(world, scene))
    }

    fn add_materials(&mut self, findings: &mut Findings) {
        type Light<'a> =
            (Option<&'a Emission>, Option<&'a EmittedStokes>, Option<&'a Incandescent>);
        type OfMaterial<'a> = (Entity, &'a Name, &'a Bsdf, &'a Sides, Light<'a>);
        let materials =
            self.world.in_order::<OfMaterial, _>(|(entity, name, bsdf, sides, light)| {
                (
                    entity,
                    name.clone(),
                    bsdf.clone(),
                    *sides,
                    (light.0.cloned(), light.1.cloned(), light.2.copied()),
                )
            });
        for (entity, name, bsdf, sides, (emission, stokes, by_heat)) in materials {
            let mut material = self.material(&name, &bsdf, sides, emission.as_ref());
            let body = &mut material["extensions"][EXTENSION];
            if by_heat.is_some() {
                body["incandescent"] = json!(true);
            }
            let is_lamp = emission.as_ref().is_some_and(Emission::emits);
            if !sides.two_sided && has_backs(&bsdf, (body["bsdf"].is_string(), is_lamp)) {
                body[ONE_SIDED] = json!(true);
            }
            self.stokes(&name, stokes.as_ref(), &mut material["extensions"][EXTENSION]);
            if let Ok(textures) = self.world.entities().get::<&Textures>(entity) {
                self.tints.insert(entity, tint_of(&textures));
                findings.note(self.paint(&name, (&bsdf, &textures), &mut material));
            }
            findings.note(self.store_tables(&name, &bsdf, &mut material));
            self.numbers.insert(entity, self.materials.len());
            self.materials.push(material);
        }
    }

    fn whole(&mut self, world: &World, scene: Map<String, Value>) -> Value {
        let mut whole = json!({
            "asset": {"version": "2.0", "generator": "sunstone"},
            "scene": 0,
            "scenes": [{
                "name": world.name(),
                "nodes": (0..self.nodes.len()).collect::<Vec<_>>(),
                "extensions": {EXTENSION: scene},
            }],
        });
        let lists = [
            ("nodes", &mut self.nodes),
            ("cameras", &mut self.cameras),
            ("materials", &mut self.materials),
            ("meshes", &mut self.mesh_list),
            ("accessors", &mut self.meshes.accessors),
            ("bufferViews", &mut self.meshes.views),
            ("textures", &mut self.lists.textures),
            ("samplers", &mut self.lists.samplers),
        ];
        // glTF knows no empty lists.
        for (name, list) in lists.into_iter().filter(|(_, list)| !list.is_empty()) {
            whole[name] = Value::Array(std::mem::take(list));
        }
        if !self.lights.is_empty() {
            whole["extensions"] = json!({"KHR_lights_punctual": {"lights": self.lights}});
        }
        let mut used = BTreeSet::new();
        note_extensions(&whole, &mut used);
        whole["extensionsUsed"] = json!(used);
        whole
    }

    fn shapes(&mut self, world: &World) {
        type OfMesh<'a> = (&'a Name, &'a Mesh, &'a Transform, &'a MadeOf, &'a Boundary);
        let meshes = world.in_order::<OfMesh, _>(|(name, mesh, place, of, boundary)| {
            (called(name), mesh.clone(), place.0, *of, *boundary)
        });
        for (name, Mesh(geometry), place, MadeOf(material), boundary) in meshes {
            let tint = self.tints.get(&material).copied().unwrap_or(Tint::None);
            let primitive = self.meshes.primitive(&geometry, (self.numbers[&material], tint));
            let node = json!({
                "name": name,
                "mesh": self.mesh_list.len(),
                "matrix": matrix(place),
                "extensions": {EXTENSION: self.boundary(&boundary)},
            });
            self.mesh_list.push(json!({"name": name, "primitives": [primitive]}));
            self.nodes.push(node);
        }
        type OfBall<'a> = (&'a Name, &'a Ball, &'a Transform, &'a MadeOf, &'a Boundary);
        let balls = world.in_order::<OfBall, _>(|(name, ball, place, of, boundary)| {
            (called(name), *ball, place.0, *of, *boundary)
        });
        for (name, ball, place, MadeOf(material), boundary) in balls {
            let mut body = self.boundary(&boundary);
            body["sphere_radius"] = json!(ball.radius);
            body["material"] = json!(self.numbers[&material]);
            let extensions = json!({EXTENSION: body});
            let node = json!({"name": name, "matrix": matrix(place), "extensions": extensions});
            self.nodes.push(node);
        }
    }

    fn boundary(&self, boundary: &Boundary) -> Value {
        let mut body = json!({});
        for (field, filling) in [("interior", boundary.interior), ("exterior", boundary.exterior)] {
            match filling {
                Some(Filling::Medium(medium)) => body[field] = json!(self.numbers[&medium]),
                Some(Filling::Clear) => body[field] = Value::Null,
                None => {}
            }
        }
        if boundary.priority != 0 {
            body["priority"] = json!(boundary.priority);
        }
        body
    }

    fn material(
        &mut self,
        name: &Name,
        bsdf: &Bsdf,
        sides: Sides,
        emission: Option<&Emission>,
    ) -> Value {
        let mut body = self.bsdf(name, bsdf);
        let mut material = json!({"name": called(name), "doubleSided": sides.two_sided});
        let under = bsdf.without_film();
        if let Bsdf::MetallicRoughness { metallic, alpha, ior, specular, .. } =
            under.without_grain()
        {
            // glTF's own: the body has the color until here, and no name of a model.
            let color = body["base_color"].take();
            body = json!({});
            material["pbrMetallicRoughness"] = json!({"baseColorFactor": color,
                "metallicFactor": metallic, "roughnessFactor": alpha.sqrt()});
            material["extensions"] = json!({"KHR_materials_ior": {"ior": ior},
                "KHR_materials_specular": {"specularFactor": specular}});
            if let Bsdf::Brushed { grain, .. } = under {
                facets::write_anisotropy(grain, *alpha, &mut material);
            }
            if let Bsdf::Filmed { film, .. } = bsdf
                && !films::write_iridescence(film, &mut material)
            {
                let text = "has a film by wavelength, which glTF has not: it is not written";
                self.warnings.add(&name.0, text);
            }
        }
        if let Bsdf::Layered { layers } = bsdf {
            body = json!({});
            write_layers(layers, &mut material, |of| self.base_color(name, of));
        }
        if let Some(Emission { radiance }) = emission {
            body["emission"] = self.spectrum(name, radiance);
            // For viewers that do not know the extension.
            material["emissiveFactor"] = json!([1.0, 1.0, 1.0]);
        }
        material["extensions"][EXTENSION] = body;
        material
    }

    fn bsdf(&mut self, name: &Name, bsdf: &Bsdf) -> Value {
        let mut of = |spectrum: &Spectrum| self.spectrum(name, spectrum);
        match bsdf {
            Bsdf::Absorber => json!({"bsdf": "absorber"}),
            Bsdf::Diffuse { reflectance } => {
                json!({"bsdf": "diffuse", "reflectance": of(reflectance)})
            }
            Bsdf::Conductor { eta, k } => json!({"bsdf": "conductor", "eta": of(eta), "k": of(k)}),
            &Bsdf::RoughConductor { ref eta, ref k, alpha, distribution, multiple_scattering } => {
                let body = json!({"bsdf": "rough_conductor", "eta": of(eta), "k": of(k)});
                with_facets(body, (alpha, distribution, multiple_scattering))
            }
            Bsdf::RoughDielectric {
                ior,
                exterior_ior: before,
                alpha,
                distribution,
                multiple_scattering,
            } => {
                let body = json!({"bsdf": "rough_dielectric", "ior": of(ior),
                    "exterior_ior": of(before)});
                with_facets(body, (*alpha, *distribution, *multiple_scattering))
            }
            Bsdf::Plastic { reflectance, coat } => plastics::written(of(reflectance), coat),
            // The file is known where all that is stored is.
            Bsdf::Measured { .. } => json!({"bsdf": "measured"}),
            Bsdf::MetallicRoughness { base_color, .. } => {
                let [red, green, blue] = self.base_color(name, base_color);
                json!({"base_color": [red, green, blue, 1.0]})
            }
            // All of them are glTF's own.
            Bsdf::Layered { .. } => json!({}),
            Bsdf::Dielectric { ior, exterior_ior } => {
                json!({"bsdf": "dielectric", "ior": ior, "exterior_ior": exterior_ior})
            }
            Bsdf::DispersiveDielectric { ior, exterior_ior } => {
                json!({"bsdf": "dielectric", "ior": of(ior), "exterior_ior": of(exterior_ior)})
            }
            Bsdf::ThinDielectric { ior, exterior_ior } => {
                json!({"bsdf": "thin_dielectric", "ior": of(ior), "exterior_ior": of(exterior_ior)})
            }
            Bsdf::Polarizer { axis_deg, extinction_ratio } => {
                let mut body = json!({"bsdf": "polarizer", "axis_deg": axis_deg});
                if extinction_ratio.is_finite() {
                    body["extinction_ratio"] = json!(extinction_ratio);
                }
                body
            }
            Bsdf::Retarder { axis_deg, retardance_deg } => {
                json!({"bsdf": "retarder", "axis_deg": axis_deg, "retardance_deg": retardance_deg})
            }
            Bsdf::Sheet { axis_deg, action } => sheets::written(*axis_deg, action, of),
            Bsdf::FilmedConductor { eta, k, film } => json!({"bsdf": "conductor", "eta": of(eta),
                "k": of(k), "film": films::written(film, &mut of)}),
            Bsdf::FilmedDielectric { ior, exterior_ior, film } => json!({"bsdf": "dielectric",
                "ior": ior, "exterior_ior": exterior_ior,
                "film": films::written(film, &mut of)}),
            Bsdf::Null => json!({"bsdf": "null"}),
            Bsdf::Brushed { of, grain } => facets::written(self.bsdf(name, of), grain),
            Bsdf::Filmed { of: inner, film } => {
                let film = films::written(film, &mut of);
                let mut body = self.bsdf(name, inner);
                body["film"] = film;
                body
            }
            Bsdf::Blend { parts, weight } => {
                blends::written(parts, *weight, |part, which| self.part(name, part, which))
            }
        }
    }

    /// A color that glTF knows as red, green and blue alone.
    fn base_color(&mut self, name: &Name, color: &Spectrum) -> [f32; 3] {
        match color {
            Spectrum::Constant(value) => [*value; 3],
            Spectrum::Rgb(rgb) => *rgb,
            Spectrum::Table(_) | Spectrum::Formula(_) => {
                let text =
                    "has a base color by wavelength, of which red, green and blue are written";
                self.warnings.add(&name.0, text);
                RGB_WAVELENGTHS_NM.map(|nm| color.at(nm).unwrap_or(0.0))
            }
        }
    }

    fn medium(&mut self, name: &Name, medium: &Medium) -> Result<Value, SceneError> {
        let mut body = match &medium.phase {
            Phase::HenyeyGreenstein { g } => json!({"phase": "hg", "g": self.spectrum(name, g)}),
            Phase::Rayleigh { depolarization } => {
                json!({"phase": "rayleigh", "depolarization": depolarization})
            }
            Phase::Spheres(_) | Phase::Milk(_) | Phase::Table(_) => {
                let problem = "particles and tables of phase matrices are not written";
                return Err(SceneError::new(&name.0, problem, "keep the scene's own file"));
            }
        };
        body["name"] = json!(called(name));
        for (key, sigma) in [("sigma_a", &medium.sigma_a), ("sigma_s", &medium.sigma_s)] {
            if let Some(sigma) = sigma {
                body[key] = self.spectrum(name, sigma);
            }
        }
        Ok(body)
    }

    fn spectrum(&mut self, name: &Name, spectrum: &Spectrum) -> Value {
        match spectrum {
            Spectrum::Constant(value) => json!(value),
            Spectrum::Rgb(rgb) => json!(rgb),
            Spectrum::Table(table) => {
                if table.color().is_some() {
                    let text =
                        "has spectra that are seen in RGB at 650, 550 and 450 nm from now on";
                    self.warnings.add(&name.0, text);
                }
                let nm = spectrum.knots_nm();
                json!({"nm": nm, "value": &spectrum.values()[..nm.len()]})
            }
            Spectrum::Formula(_) => {
                let text = "has formulas, which become tables from 300 to 1000 nm at most";
                self.warnings.add(&name.0, text);
                let ends = spectrum.ends_nm().unwrap_or(FORMULA_NM);
                let [from, to] = [ends[0].max(FORMULA_NM[0]), ends[1].min(FORMULA_NM[1])];
                let steps = ((to - from).max(0.0) / STEP_NM) as usize;
                let nm = (0..=steps).map(|step| from + STEP_NM * step as f32);
                let rows = nm.filter_map(|nm| Some((nm, spectrum.at(nm).ok()?)));
                let (nm, values): (Vec<f32>, Vec<f32>) = rows.unzip();
                json!({"nm": nm, "value": values})
            }
        }
    }

    /// How what is emitted is polarized, if it is.
    fn stokes(&mut self, name: &Name, stokes: Option<&EmittedStokes>, body: &mut Value) {
        if let Some(EmittedStokes { stokes }) = stokes {
            body["stokes"] = json!(stokes.each_ref().map(|it| self.spectrum(name, it)));
        }
    }

    fn add_lights(&mut self) -> Result<(), SceneError> {
        type Shown<'a> = (Option<&'a Luminaire>, Option<&'a Projection>);
        type Light<'a> =
            (&'a Name, &'a Punctual, Option<&'a EmittedStokes>, &'a Transform, Shown<'a>);
        let lights = self.world.in_order::<Light, _>(|(name, light, stokes, place, shown)| {
            let shown = (shown.0.cloned(), shown.1.cloned());
            (name.clone(), light.clone(), stokes.cloned(), place.0, shown)
        });
        for (name, Punctual { kind, intensity }, stokes, place, (measured, thrown)) in lights {
            let mut light = match kind {
                PunctualKind::Point => json!({"type": "point"}),
                PunctualKind::Directional | PunctualKind::Sun { .. } => {
                    json!({"type": "directional"})
                }
                PunctualKind::Spot { inner, outer, .. } => json!({
                    "type": "spot",
                    "spot": {"innerConeAngle": inner, "outerConeAngle": outer},
                }),
            };
            let emission = self.spectrum(&name, &intensity);
            light["name"] = json!(called(&name));
            let mut body = json!({"units": "radiometric", "emission": emission});
            if let PunctualKind::Sun { diameter } = kind {
                body["angular_diameter_deg"] = json!(diameter.to_degrees());
            }
            if let PunctualKind::Spot { falloff: falloff @ Falloff::Angle, .. } = kind {
                body["falloff"] = json!(falloff.name());
            }
            self.stokes(&name, stokes.as_ref(), &mut body);
            if let Some(Luminaire(photometry)) = measured {
                body["ies"] = json!(data_uri("text/plain", photometry.to_ies().as_bytes()));
            }
            if let Some(Projection(picture)) = thrown {
                body["picture"] = open(self.picture(&name, &picture)?);
            }
            light["extensions"] = json!({EXTENSION: body});
            let reference = json!({"KHR_lights_punctual": {"light": self.lights.len()}});
            let node = json!({"name": called(&name), "matrix": matrix(place),
                "extensions": reference});
            self.nodes.push(node);
            self.lights.push(light);
        }
        Ok(())
    }

    /// The number of a picture among what is stored.
    fn picture(&mut self, name: &Name, picture: &Picture) -> Result<usize, SceneError> {
        let stored = self.stored.picture(picture, self.world);
        stored.map_err(|error| SceneError::new(&name.0, error, "keep the scene's own file"))
    }

    fn add_sky(&mut self, scene: &mut Map<String, Value>) -> Result<(), SceneError> {
        type Sky<'a> = (&'a Name, &'a Environment, Option<&'a EmittedStokes>);
        let skies = self
            .world
            .in_order::<Sky, _>(|(name, sky, stokes)| (name.clone(), sky.clone(), stokes.cloned()));
        for (name, Environment { radiance, gradient, backdrop }, stokes) in skies {
            let mut sky = json!({"radiance": self.spectrum(&name, &radiance)});
            if gradient != Vec3::ZERO {
                sky["gradient"] = json!(gradient.to_array());
            }
            if let Some(Backdrop { picture, rotation, source }) = backdrop {
                match source {
                    BackdropSource::ClearSky(ClearSky { sun, turbidity, max_degree }) => {
                        sky["sky"] = json!({"sun_direction": sun.to_array(),
                            "turbidity": turbidity, "max_degree": max_degree});
                    }
                    BackdropSource::File(_) | BackdropSource::Memory => {
                        sky["uri"] = open(self.picture(&name, &picture)?);
                        sky["rotation"] = json!(rotation.to_array());
                    }
                }
            }
            self.stokes(&name, stokes.as_ref(), &mut sky);
            scene.insert("environment".into(), sky);
        }
        Ok(())
    }

    fn camera(&mut self, world: &World) {
        type Seen<'a> = (Option<&'a Analyzer>, Option<&'a Window>);
        type Film<'a> = (Option<&'a Resolution>, Option<&'a Raster>, Seen<'a>);
        let cameras = world.in_order::<(&Name, &Lens, &Transform, Film), _>(
            |(name, lens, place, (resolution, raster, (analyzer, window)))| {
                let film = (resolution.copied(), raster.copied(), analyzer.copied());
                // Whoever reads the file puts the same one in.
                window.is_none().then(|| (called(name), *lens, place.0, film))
            },
        );
        for (name, lens, place, (resolution, raster, analyzer)) in cameras.into_iter().flatten() {
            let mut body = json!({});
            let mut camera = match lens {
                Lens::Perspective { yfov, aspect, aperture_radius, focus_distance } => {
                    if aperture_radius > 0.0 {
                        body["aperture_radius"] = json!(aperture_radius);
                        body["focus_distance"] = json!(focus_distance);
                    }
                    let mut lens = json!({"yfov": yfov, "znear": 0.01});
                    if let Some(aspect) = aspect {
                        lens["aspectRatio"] = json!(aspect);
                    }
                    json!({"type": "perspective", "perspective": lens})
                }
                Lens::Orthographic { half_width, half_height } => json!({
                    "type": "orthographic",
                    "orthographic": {"xmag": half_width, "ymag": half_height, "znear": 0.0,
                        "zfar": 1000.0},
                }),
            };
            let mut film = written_film(raster.unwrap_or_default());
            if let Some(Resolution(size)) = resolution {
                film["resolution"] = json!(size);
            }
            match analyzer {
                Some(Analyzer::Linear { axis_deg }) => {
                    film["analyzer"] = json!({"kind": "linear", "axis_deg": axis_deg});
                }
                Some(Analyzer::RightCircular) => {
                    film["analyzer"] = json!({"kind": "right_circular"});
                }
                Some(Analyzer::LeftCircular) => {
                    film["analyzer"] = json!({"kind": "left_circular"});
                }
                None => {}
            }
            body["film"] = film;
            camera["name"] = json!(name);
            camera["extensions"] = json!({EXTENSION: body});
            let node = json!({"name": name, "matrix": matrix(place), "camera": self.cameras.len()});
            self.nodes.push(node);
            self.cameras.push(camera);
        }
    }
}

/// Adds the names of all extensions that a value uses.
fn note_extensions(value: &Value, used: &mut BTreeSet<String>) {
    for item in value.as_array().into_iter().flatten() {
        note_extensions(item, used);
    }
    for (key, item) in value.as_object().into_iter().flatten() {
        if key == "extensions" {
            used.extend(item.as_object().into_iter().flatten().map(|(name, _)| name.clone()));
        }
        note_extensions(item, used);
    }
}

fn called(name: &Name) -> String {
    name.own().to_owned()
}

/// Sixteen numbers, by column.
fn matrix(place: DAffine3) -> [f64; 16] {
    DMat4::from(place).to_cols_array()
}
