//! glTF out: a [`World`] as a .gltf file with all that is in it, the extension's keys where glTF
//! has no words. What cannot be written is refused; what is written a little otherwise is said.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{DAffine3, DMat4, Vec3};
use hecs::Entity;
use serde_json::{Map, Value, json};

use super::cameras::written_film;
use super::extension::EXTENSION;
use super::facets::{self, with_facets};
use super::layers::write_layers;
use super::{blends, films, plastics, sheets};
use crate::image::OutputError;
use crate::image::atomic;
use crate::polarization::Analyzer;
use crate::scene::error::{Findings, SceneError};
use crate::scene::warnings::Warnings;
use crate::scene::world::{
    Backdrop, BackdropSource, Ball, Boundary, Bsdf, ClearSky, Emission, EmittedStokes, Environment,
    Filling, FillsScene, Geometry, Incandescent, Lens, Luminaire, MadeOf, Medium, Mesh, Name,
    Phase, Projection, Punctual, PunctualKind, Raster, Resolution, Sides, Textures, Transform,
    Window, World,
};
use crate::spectrum::{RGB_WAVELENGTHS_NM, Spectrum};

/// Where formulas are written as tables, in nanometers, and the step.
const FORMULA_NM: [f32; 2] = [300.0, 1000.0];
const STEP_NM: f32 = 1.0;

/// A scene as glTF.
pub struct Written {
    text: String,
    warnings: Vec<String>,
}

impl Written {
    /// The JSON of a scene, with its meshes in it.
    ///
    /// # Errors
    /// When something in it has no words there.
    pub fn of(world: &World) -> Result<Self, SceneError> {
        let mut writer = Writer::default();
        let document = writer.document(world).map_err(|error| error.in_file(&world.file))?;
        let text = serde_json::to_string_pretty(&document).unwrap_or_default();
        Ok(Self { text, warnings: writer.warnings.sentences() })
    }

    /// What is not written as it is, a sentence each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Writes the file.
    ///
    /// # Errors
    /// When the system refuses that.
    pub fn save(&self, path: &Path) -> Result<(), OutputError> {
        atomic::write(path, self.text.as_bytes())
    }
}

#[derive(Default)]
struct Writer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    nodes: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    cameras: Vec<Value>,
    lights: Vec<Value>,
    media: Vec<Value>,
    /// Numbers in the file of materials and media.
    numbers: HashMap<Entity, usize>,
    /// Accessors of geometries, by address.
    geometries: HashMap<(usize, usize), usize>,
    warnings: Warnings,
}

impl Writer {
    fn document(&mut self, world: &World) -> Result<Value, SceneError> {
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
        type Light<'a> =
            (Option<&'a Emission>, Option<&'a EmittedStokes>, Option<&'a Incandescent>);
        type OfMaterial<'a> = (Entity, &'a Name, &'a Bsdf, &'a Sides, Light<'a>);
        let materials = world.in_order::<OfMaterial, _>(|(entity, name, bsdf, sides, light)| {
            (
                entity,
                name.clone(),
                bsdf.clone(),
                *sides,
                (light.0.cloned(), light.1.cloned(), light.2.copied()),
            )
        });
        for (entity, name, bsdf, sides, (emission, stokes, by_heat)) in materials {
            let is_painted = world.entities().get::<&Textures>(entity);
            if is_painted.is_ok_and(|textures| !textures.is_empty()) {
                let problem = "textures are not written yet";
                let error = SceneError::new(&name.0, problem, "keep the scene's own file");
                findings.note::<()>(Err(error));
            }
            let mut material = self.material(&name, &bsdf, sides, emission.as_ref());
            if by_heat.is_some() {
                material["extensions"][EXTENSION]["incandescent"] = json!(true);
            }
            self.stokes(&name, stokes.as_ref(), &mut material["extensions"][EXTENSION]);
            self.numbers.insert(entity, self.materials.len());
            self.materials.push(material);
        }
        findings.note(check_backdrops(world));
        self.shapes(world);
        type Patterns<'a> = (&'a Name, Option<&'a Luminaire>, Option<&'a Projection>);
        let patterns = world.in_order::<Patterns, _>(|(name, measured, thrown)| {
            (measured.is_some() || thrown.is_some()).then(|| name.clone())
        });
        for name in patterns.into_iter().flatten() {
            let problem = "luminaires and projectors are not written";
            let error = SceneError::new(&name.0, problem, "keep the scene's own file");
            findings.note::<()>(Err(error));
        }
        self.lights(world, &mut scene);
        self.camera(world);
        findings.result()?;
        if !self.media.is_empty() {
            scene.insert("media".into(), Value::Array(std::mem::take(&mut self.media)));
        }
        Ok(self.whole(world, scene))
    }

    fn whole(&mut self, world: &World, scene: Map<String, Value>) -> Value {
        let mut whole = json!({
            "asset": {"version": "2.0", "generator": "sunstone"},
            "extensionsUsed": [EXTENSION],
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
            ("meshes", &mut self.meshes),
            ("accessors", &mut self.accessors),
            ("bufferViews", &mut self.views),
        ];
        // glTF knows no empty lists.
        for (name, list) in lists.into_iter().filter(|(_, list)| !list.is_empty()) {
            whole[name] = Value::Array(std::mem::take(list));
        }
        if !self.bytes.is_empty() {
            let uri =
                format!("data:application/octet-stream;base64,{}", STANDARD.encode(&self.bytes));
            whole["buffers"] = json!([{"byteLength": self.bytes.len(), "uri": uri}]);
        }
        if !self.lights.is_empty() {
            whole["extensionsUsed"] = json!([EXTENSION, "KHR_lights_punctual"]);
            whole["extensions"] = json!({"KHR_lights_punctual": {"lights": self.lights}});
        }
        whole
    }

    fn shapes(&mut self, world: &World) {
        type OfMesh<'a> = (&'a Name, &'a Mesh, &'a Transform, &'a MadeOf, &'a Boundary);
        let meshes = world.in_order::<OfMesh, _>(|(name, mesh, place, of, boundary)| {
            (called(name), mesh.clone(), place.0, *of, *boundary)
        });
        for (name, Mesh(geometry), place, MadeOf(material), boundary) in meshes {
            let primitive = self.primitive(&geometry, self.numbers[&material]);
            let node = json!({
                "name": name,
                "mesh": self.meshes.len(),
                "matrix": matrix(place),
                "extensions": {EXTENSION: self.boundary(&boundary)},
            });
            self.meshes.push(json!({"name": name, "primitives": [primitive]}));
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

    fn primitive(&mut self, geometry: &Arc<Geometry>, material: usize) -> Value {
        let key = Arc::as_ptr(geometry).addr();
        let columns = [&geometry.positions, &geometry.normals];
        let mut attributes = json!({});
        for (part, (name, column)) in ["POSITION", "NORMAL"].into_iter().zip(columns).enumerate() {
            if column.is_empty() {
                continue;
            }
            let known = self.geometries.get(&(key, part)).copied();
            let accessor = known.unwrap_or_else(|| {
                let bytes = column.iter().flat_map(|row| row.to_array()).flat_map(f32::to_le_bytes);
                let view = self.view(bytes.collect());
                let [low, high] = geometry.bounds().map(|bound| bound.as_vec3().to_array());
                let mut accessor = json!({"bufferView": view, "componentType": 5126,
                    "count": column.len(), "type": "VEC3"});
                if part == 0 {
                    accessor["min"] = json!(low);
                    accessor["max"] = json!(high);
                }
                self.accessors.push(accessor);
                self.accessors.len() - 1
            });
            self.geometries.insert((key, part), accessor);
            attributes[name] = json!(accessor);
        }
        const CORNERS: usize = 2;
        let known = self.geometries.get(&(key, CORNERS)).copied();
        let indices = known.unwrap_or_else(|| {
            let corners = geometry.triangles.as_flattened();
            let view = self.view(corners.iter().flat_map(|row| row.to_le_bytes()).collect());
            self.accessors.push(json!({"bufferView": view, "componentType": 5125,
                "count": corners.len(), "type": "SCALAR"}));
            self.accessors.len() - 1
        });
        self.geometries.insert((key, CORNERS), indices);
        json!({"attributes": attributes, "indices": indices, "material": material})
    }

    /// All that is written is made of four bytes.
    fn view(&mut self, bytes: Vec<u8>) -> usize {
        let (at, length) = (self.bytes.len(), bytes.len());
        self.bytes.extend(bytes);
        self.views.push(json!({"buffer": 0, "byteOffset": at, "byteLength": length}));
        self.views.len() - 1
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
        if let Bsdf::MetallicRoughness { metallic, alpha, ior, specular, .. } = bsdf.without_grain()
        {
            // glTF's own: the body has the color until here, and no name of a model.
            let color = body["base_color"].take();
            body = json!({});
            material["pbrMetallicRoughness"] = json!({"baseColorFactor": color,
                "metallicFactor": metallic, "roughnessFactor": alpha.sqrt()});
            material["extensions"] = json!({"KHR_materials_ior": {"ior": ior},
                "KHR_materials_specular": {"specularFactor": specular}});
            if let Bsdf::Brushed { grain, .. } = bsdf {
                facets::write_anisotropy(grain, *alpha, &mut material);
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
            // Beside the scene, as it was.
            Bsdf::Measured { table, places: _ } => {
                json!({"bsdf": "measured", "file": table.name()})
            }
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
            Bsdf::FilmedConductor { eta, k, film } => {
                let film = films::written(film, &mut of);
                json!({"bsdf": "conductor", "eta": of(eta), "k": of(k), "film": film})
            }
            Bsdf::FilmedDielectric { ior, exterior_ior, film } => {
                let film = films::written(film, &mut of);
                json!({"bsdf": "dielectric", "ior": ior, "exterior_ior": exterior_ior,
                    "film": film})
            }
            Bsdf::Null => json!({"bsdf": "null"}),
            Bsdf::Brushed { of, grain } => facets::written(self.bsdf(name, of), grain),
            Bsdf::Blend { parts, weight } => {
                blends::written(parts, *weight, |part, which| self.part(name, part, which))
            }
        }
    }

    /// Writes a part of a blend as a material; its place.
    fn part(&mut self, name: &Name, part: &Bsdf, which: &str) -> usize {
        let mut material = self.material(name, part, Sides::default(), None);
        material["name"] = json!(format!("{}, {which}", called(name)));
        self.materials.push(material);
        self.materials.len() - 1
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

    fn lights(&mut self, world: &World, scene: &mut Map<String, Value>) {
        type Light<'a> = (&'a Name, &'a Punctual, Option<&'a EmittedStokes>, &'a Transform);
        let lights = world.in_order::<Light, _>(|(name, light, stokes, place)| {
            (name.clone(), light.clone(), stokes.cloned(), place.0)
        });
        for (name, Punctual { kind, intensity }, stokes, place) in lights {
            let mut light = match kind {
                PunctualKind::Point => json!({"type": "point"}),
                PunctualKind::Directional | PunctualKind::Sun { .. } => {
                    json!({"type": "directional"})
                }
                PunctualKind::Spot { inner, outer } => json!({
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
            self.stokes(&name, stokes.as_ref(), &mut body);
            light["extensions"] = json!({EXTENSION: body});
            let reference = json!({"KHR_lights_punctual": {"light": self.lights.len()}});
            let node = json!({"name": called(&name), "matrix": matrix(place),
                "extensions": reference});
            self.nodes.push(node);
            self.lights.push(light);
        }
        type Sky<'a> = (&'a Name, &'a Environment, Option<&'a EmittedStokes>);
        let skies = world
            .in_order::<Sky, _>(|(name, sky, stokes)| (name.clone(), sky.clone(), stokes.cloned()));
        for (name, Environment { radiance, gradient, backdrop }, stokes) in skies {
            let mut sky = json!({"radiance": self.spectrum(&name, &radiance)});
            if gradient != Vec3::ZERO {
                sky["gradient"] = json!(gradient.to_array());
            }
            match backdrop {
                None => {}
                Some(Backdrop { rotation, source: BackdropSource::File(uri), .. }) => {
                    let text =
                        "has a picture, which is to lie beside the new file as beside the old";
                    self.warnings.add(&name.0, text);
                    sky["uri"] = json!(uri);
                    sky["rotation"] = json!(rotation.to_array());
                }
                Some(Backdrop { source: BackdropSource::ClearSky(clear), .. }) => {
                    let ClearSky { sun, turbidity, max_degree } = clear;
                    sky["sky"] = json!({"sun_direction": sun.to_array(), "turbidity": turbidity,
                        "max_degree": max_degree});
                }
                // Which has been refused.
                Some(Backdrop { source: BackdropSource::Memory, .. }) => {}
            }
            self.stokes(&name, stokes.as_ref(), &mut sky);
            scene.insert("environment".into(), sky);
        }
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

/// Refuses pictures of what is around that have no file to refer to.
fn check_backdrops(world: &World) -> Result<(), SceneError> {
    let without = world.in_order::<(&Name, &Environment), _>(|(name, sky)| {
        let source = sky.backdrop.as_ref().map(|backdrop| &backdrop.source);
        (source == Some(&BackdropSource::Memory)).then(|| name.0.clone())
    });
    match without.into_iter().flatten().next() {
        None => Ok(()),
        Some(name) => {
            let problem = "has a picture that is no file, which is not written yet";
            Err(SceneError::new(name, problem, "keep the scene's own file"))
        }
    }
}

fn called(name: &Name) -> String {
    name.own().to_owned()
}

/// Sixteen numbers, by column.
fn matrix(place: DAffine3) -> [f64; 16] {
    DMat4::from(place).to_cols_array()
}
