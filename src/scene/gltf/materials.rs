//! Materials: the extension's models, and what glTF's own parameters mean here.
//!
//! Without the extension, a metallic-roughness material becomes the model of ours that it names
//! exactly, or the nearest with a warning, or is refused. Facets have alpha = roughness^2, and are
//! smooth below 0.001:
//! - metallic 1, smooth: a conductor with eta = 1 and k = 2 sqrt(F0 / (1 - F0)), which has
//!   the reflectance F0 = baseColor at normal incidence (F0 is capped at 0.999);
//! - no transmission, or metallic 1: rough metal of that index, and a Lambertian base of baseColor
//!   under a rough coat of KHR_materials_ior (1.5 if not given), of which KHR_materials_specular
//!   may leave a share; mixed by the metallic factor;
//! - metallic 0, transmission 1: a dielectric of KHR_materials_ior, 1.5 if not given; thin-walled
//!   and smooth, unless KHR_materials_volume gives it a thickness: then a solid, smooth or rough,
//!   whose attenuation is absorption;
//! - other transmission, rough panes, KHR_materials_clearcoat, KHR_materials_sheen,
//!   KHR_materials_diffuse_transmission, and colors and textures of KHR_materials_specular: layers,
//!   see [`super::layers`];
//! - no material: Lambertian of reflectance 0.8.

use gltf::json;
use hecs::Entity;
use serde_json::Value;

use super::Import;
use super::blends::{self, BLEND};
use super::document::decode_data_uri;
use super::extension::{Body, MATERIAL};
use super::facets::{self, alpha, distribution_and_several};
use super::files::Files;
use super::films;
use super::gloss;
use super::layers::{has_painted_wall, says_more};
use super::own_textures::{BUMP_SCALE, BUMP_TEXTURE};
use super::plastics;
use super::sheets;
use super::sides::ONE_SIDED;
use super::spectra::Part;
use super::stains::{CONDUCTOR, DIELECTRIC, ROUGH_CONDUCTOR, ROUGH_DIELECTRIC, THIN_DIELECTRIC};
use super::volume::Volume;
use crate::math::Range;
use crate::polarization::fresnel::k_of_reflectance;
use crate::polarization::{ALPHA_MIN, Distribution};
use crate::scene::error::SceneError;
use crate::scene::world::{
    Boundary, Bsdf, Emission, EmittedStokes, Incandescent, Layers, Material, MeasuredTable, Name,
    Skin, Transform, tabulated,
};
use crate::spectrum::{Spectrum, metal, metal_names};

/// Index of refraction that glTF gives to dielectrics.
const DEFAULT_IOR: f32 = 1.5;
/// Reflectance of what has no material.
const DEFAULT_REFLECTANCE: f32 = 0.8;
/// The color of what has none.
const WHITE: Spectrum = Spectrum::Rgb([1.0; 3]);
/// Where glTF states an index of refraction.
const KHR_IOR: &str = "KHR_materials_ior.ior";
/// How glTF states dispersion.
const KHR_DISPERSION: &str = "KHR_materials_dispersion";
/// How glTF states that something emits more than white.
const KHR_EMISSIVE_STRENGTH: &str = "KHR_materials_emissive_strength";
/// How glTF states what looks the same in any light.
pub const KHR_UNLIT: &str = "KHR_materials_unlit";
/// How glTF once stated colors of gloss.
pub const KHR_GLOSSY: &str = "KHR_materials_pbrSpecularGlossiness";
/// What a material emits.
const EMISSION: &str = "emission";
/// Whether that is by heat.
const INCANDESCENT: &str = "incandescent";
/// How that is polarized.
const STOKES: &str = "stokes";

/// What a model is read of besides its keys: glTF's own, and the scene's files.
pub(super) type Of<'a> = (&'a json::Material, &'a Files);

/// A value of `bsdf`.
struct Model {
    name: &'static str,
    /// The keys that it takes.
    keys: &'static [&'static str],
    /// Reads them.
    read: fn(&Body, Of) -> Result<Bsdf, SceneError>,
}

/// All of them.
const MODELS: [Model; 14] = [
    Model { name: "absorber", keys: &[], read: |_, _| Ok(Bsdf::Absorber) },
    Model {
        name: "circular_polarizer",
        keys: &sheets::CIRCULAR,
        read: |body, _| sheets::circular_polarizer(body),
    },
    Model { name: "conductor", keys: &CONDUCTOR, read: conductor },
    Model { name: "dielectric", keys: &DIELECTRIC, read: dielectric },
    Model { name: "diffuse", keys: &["reflectance"], read: diffuse },
    Model { name: "measured", keys: &["file"], read: measured },
    Model { name: "mueller", keys: &sheets::MUELLER, read: |body, _| sheets::mueller(body) },
    Model { name: "null", keys: &[], read: |_, _| Ok(Bsdf::Null) },
    Model { name: "plastic", keys: &plastics::KEYS, read: plastics::plastic },
    Model { name: "polarizer", keys: &sheets::POLARIZER, read: |body, _| sheets::polarizer(body) },
    Model { name: "retarder", keys: &sheets::RETARDER, read: |body, _| sheets::retarder(body) },
    Model { name: "rough_conductor", keys: &ROUGH_CONDUCTOR, read: rough_conductor },
    Model { name: "rough_dielectric", keys: &ROUGH_DIELECTRIC, read: rough_dielectric },
    Model { name: "thin_dielectric", keys: &THIN_DIELECTRIC, read: thin_dielectric },
];
/// Keys that go with any model.
const OF_ALL: [&str; 8] =
    ["bsdf", BUMP_SCALE, BUMP_TEXTURE, "coverage", EMISSION, INCANDESCENT, ONE_SIDED, STOKES];

impl<'a> Import<'a> {
    /// The entity of a material, which is added when it is first used.
    pub fn material(&mut self, index: Option<usize>, user: &str) -> Result<Entity, SceneError> {
        if let Some(known) = self.materials.get(&index) {
            return known.clone();
        }
        let material = self.read_material(index, user);
        let value = index.map_or(&Value::Null, |index| &self.document.value["materials"][index]);
        if value["extensions"][KHR_UNLIT].is_object() {
            self.unlit.extend(&material);
        }
        if value["emissiveTexture"].is_object() {
            let strength = &value["extensions"][KHR_EMISSIVE_STRENGTH]["emissiveStrength"];
            let is_bright = strength.as_f64().is_some_and(|strength| strength > 1.0);
            let has_own = Body::of(value, user, &MATERIAL).is_ok_and(|body| body.has(EMISSION));
            self.glowing.extend(material.iter().map(|&entity| (entity, is_bright || has_own)));
        }
        self.materials.insert(index, material.clone());
        material
    }

    fn read_material(&mut self, index: Option<usize>, user: &str) -> Result<Entity, SceneError> {
        let (label, material) = match index {
            Some(index) => {
                let label = self.document.label("materials", index);
                let bsdf = self.bsdf(index, &label)?;
                let emission = self.emission(index, &label)?;
                let sides = self.sides(index, &label, (&bsdf, &emission))?;
                (label, Material { bsdf, sides, emission })
            }
            None => {
                let text = format!(
                    "has no material and is taken as a diffuse surface of reflectance \
                     {DEFAULT_REFLECTANCE}"
                );
                self.warnings.add_like("no material", user, &text);
                let material = Material::from(Bsdf::diffuse(DEFAULT_REFLECTANCE)).two_sided();
                ("default material".to_owned(), material)
            }
        };
        let stokes = index.map_or(Ok(None), |index| self.stokes(index, &label))?;
        let by_heat = index.map_or(Ok(None), |index| self.is_incandescent(index, &label))?;
        let emits = material.emission.is_some();
        let of = (&material.bsdf, material.emission.as_ref());
        let textures = self.textures(index, &label, of)?;
        let put = self.world.put_material(Name(label.clone()), material);
        let entity = put.map_err(|fault| SceneError::at(&label, fault))?;
        if !textures.is_empty() {
            self.world.set_textures(entity, textures)?;
        }
        if let Some(stokes) = stokes.filter(|_| emits) {
            let put = self.world.put_stokes(entity, stokes);
            put.map_err(|fault| SceneError::at(&label, fault))?;
        }
        if let (Some(body), true) = (by_heat, emits) {
            self.world.put_incandescent(entity).map_err(|fault| body.place(fault))?;
        }
        Ok(entity)
    }

    /// The keys of a material that emits by its heat. That may be switched off, but has to be
    /// stated.
    fn is_incandescent(&self, index: usize, label: &str) -> Result<Option<Body<'a>>, SceneError> {
        let document = self.document;
        let value = &document.value["materials"][index];
        let body = Body::of(value, label, &MATERIAL)?;
        match body.flag(INCANDESCENT)?.unwrap_or(false) {
            true if !states_emission(value, &body) => {
                Err(body.place(Incandescent::without_emission()))
            }
            true => Ok(Some(body)),
            false => Ok(None),
        }
    }

    /// How what a material emits is polarized. That may be switched off, but has to be stated.
    fn stokes(&self, index: usize, label: &str) -> Result<Option<EmittedStokes>, SceneError> {
        let value = &self.document.value["materials"][index];
        let body = Body::of(value, label, &MATERIAL)?;
        match body.stokes(STOKES)? {
            Some(_) if !states_emission(value, &body) => {
                Err(body.place(EmittedStokes::without_emission()))
            }
            stokes => Ok(stokes),
        }
    }

    /// A material with what is on the two sides; the node's word counts before the material's.
    pub fn skin(
        &mut self,
        material: Option<usize>,
        mut boundary: Boundary,
        (user, place): (&str, &Transform),
    ) -> Result<Skin, SceneError> {
        let entity = self.material(material, user)?;
        if let (Some(index), None) = (material, boundary.interior) {
            boundary.interior = self.filling(index, place)?;
        }
        Ok(Skin { material: entity, boundary })
    }

    pub fn bsdf(&mut self, index: usize, label: &str) -> Result<Bsdf, SceneError> {
        let document = self.document;
        let value = &document.value["materials"][index];
        let material = &document.root.materials[index];
        if value.get("occlusionTexture").is_some() {
            self.warnings
                .add(label, "the occlusion map is ignored: light finds the shadows itself");
        }
        let body = Body::of(value, label, &MATERIAL)?;
        if let Some(model) = body.word("bsdf")? {
            if model == BLEND {
                check_keys((model, &blends::KEYS), &body)?;
                return self.blend(index, &body);
            }
            return dispersed(
                extension_model(model, &body, (material, &document.files))?,
                value,
                label,
            );
        }
        let keys: Vec<&str> = body.keys().filter(|key| !OF_ALL.contains(key)).collect();
        if !keys.is_empty() {
            let problem = format!("has {} but no `bsdf`", keys.join(", "));
            return Err(SceneError::new(label, problem, "add `bsdf`, the name of the model"));
        }
        if value["extensions"][KHR_UNLIT].is_object() {
            self.warnings.add(label, "is unlit: emits its color, which shines on other things too");
            return Ok(Bsdf::Absorber);
        }
        let glossy = &value["extensions"][KHR_GLOSSY];
        if glossy.is_object() {
            let text = "is of KHR_materials_pbrSpecularGlossiness: its colors are taken for those \
                        of shares of metal";
            self.warnings.add(label, text);
            return gloss::model(glossy, label);
        }
        let volume = Volume::of(value, label)?;
        let bsdf = self.metallic_roughness((index, volume.is_solid), label)?;
        let bsdf = dispersed(bsdf, value, label)?;
        let bsdf = self.grained(bsdf, value, label)?;
        let bsdf = films::iridescent(bsdf, value, label, &mut self.warnings)?;
        if bsdf.transmits() {
            // Walls have a color of their own.
            let is_wall = matches!(bsdf, Bsdf::Layered { .. });
            let [red, green, blue, _] = material.pbr_metallic_roughness.base_color_factor.0;
            let volume = match self.has_even_color(index) && !is_wall {
                true => volume.tinted([red, green, blue]),
                false => volume,
            };
            self.volumes.insert(index, volume);
        }
        Ok(bsdf)
    }

    /// The radiance: a color, which is emissiveFactor if the extension has no spectrum in its
    /// place, times emissiveStrength.
    pub fn emission(&self, index: usize, label: &str) -> Result<Option<Emission>, SceneError> {
        let document = self.document;
        let material = &document.root.materials[index];
        let body = Body::of(&document.value["materials"][index], label, &MATERIAL)?;
        let strength = material.extensions.as_ref().and_then(|e| e.emissive_strength.as_ref());
        let strength = strength.map_or(1.0, |strength| strength.emissive_strength.0);
        let stated = body.emission(EMISSION, document)?;
        let color = if stated.is_some() { EMISSION } else { "emissiveFactor" };
        let extensions = &document.value["materials"][index]["extensions"];
        let own = match extensions[KHR_UNLIT].is_object() && body.word("bsdf")?.is_none() {
            true => {
                let [red, green, blue, _] = material.pbr_metallic_roughness.base_color_factor.0;
                Spectrum::Rgb([red, green, blue])
            }
            false => Spectrum::Rgb(material.emissive_factor.0).scaled(strength),
        };
        let radiance = stated.map_or(own, |stated| stated.scaled(strength));
        let emission = Emission { radiance };
        let field = format!("{color} times emissiveStrength");
        emission.check().map_err(|fault| SceneError::at(label, fault.of(field)))?;
        Ok(Some(emission).filter(Emission::emits))
    }

    /// Whether neither a picture nor vertices change the color of a material of plain glTF.
    fn has_even_color(&self, index: usize) -> bool {
        let pbr = &self.document.value["materials"][index]["pbrMetallicRoughness"];
        pbr["baseColorTexture"].is_null() && self.colors_of(Some(index)).is_none()
    }

    fn metallic_roughness(
        &mut self,
        (index, is_solid): (usize, bool),
        label: &str,
    ) -> Result<Bsdf, SceneError> {
        let document = self.document;
        let value = &document.value["materials"][index];
        let material = &document.root.materials[index];
        let pbr = &material.pbr_metallic_roughness;
        let (metallic, roughness) = (pbr.metallic_factor.0, pbr.roughness_factor.0);
        let [red, green, blue, _] = pbr.base_color_factor.0;
        let color = [red, green, blue];
        for factor in [red, green, blue, metallic, roughness] {
            Range::UNIT
                .check("pbrMetallicRoughness", factor)
                .map_err(|fault| SceneError::at(label, fault))?;
        }
        let is_smooth = roughness * roughness < ALPHA_MIN;
        let of = |key: &str| !value["pbrMetallicRoughness"][key].is_null();
        let is_painted = of("baseColorTexture") || of("metallicRoughnessTexture");
        let mut layers = Layers {
            ior: khr_ior(material),
            ..Layers::plain(Spectrum::Rgb(color), metallic, roughness * roughness)
        };
        self.read_layers(&mut layers, value, label)?;
        let is_metal = metallic == 1.0 && !of("metallicRoughnessTexture");
        if is_metal {
            (layers.transmission, layers.diffuse_transmission) = (0.0, 0.0);
        }
        let is_wall = layers.transmission > 0.0;
        let is_pane = is_smooth && !of("metallicRoughnessTexture");
        let is_glass = metallic == 0.0
            && layers.transmission == 1.0
            && !has_painted_wall(value)
            && (is_solid || is_pane);
        let bsdf = if is_glass {
            if says_more(value, &layers) {
                let text = "coats, cloth and colors of facets are ignored on glass";
                self.warnings.add_like("layers of glass", label, text);
            }
            let may_be_rough =
                of("metallicRoughnessTexture") || is_solid && facets::is_stated(value);
            if layers.base_color != WHITE && is_solid && self.has_even_color(index) {
                let text = "the color of the glass is what it absorbs over its thicknessFactor";
                self.warnings.add(label, text);
            }
            // Not that of brighter facets.
            let layers = Layers { ior: khr_ior(material), ..layers };
            glass(&layers, (is_solid, may_be_rough))
        } else if is_wall || says_more(value, &layers) {
            if is_wall && is_solid {
                let text = "is glass by a share: light goes through it without being refracted";
                self.warnings.add_like("glass by a share", label, text);
            }
            Bsdf::Layered { layers }
        } else if metallic == 1.0 && is_smooth && !is_painted && !facets::is_stated(value) {
            let k = Spectrum::Rgb(color.map(k_of_reflectance));
            Bsdf::Conductor { eta: Spectrum::Constant(1.0), k }
        } else {
            let Layers { base_color, metallic, alpha, ior, specular, .. } = layers;
            Bsdf::MetallicRoughness { base_color, metallic, alpha, ior, specular }
        };
        bsdf.check().map_err(|fault| match fault.field.as_str() {
            "ior" => SceneError::at(label, fault.of(KHR_IOR)),
            _ => SceneError::at(label, fault),
        })?;
        Ok(bsdf)
    }
}

/// Whether a material says what it emits, and be it nothing.
fn states_emission(value: &Value, body: &Body) -> bool {
    body.has(EMISSION)
        || value.get("emissiveFactor").is_some()
        || value["extensions"][KHR_UNLIT].is_object()
}

/// All glass: a pane, or the boundary of a solid, with facets if it is rough, or may be.
fn glass(layers: &Layers<Spectrum>, (is_solid, is_painted): (bool, bool)) -> Bsdf {
    match *layers {
        Layers { ior, alpha, .. } if alpha >= ALPHA_MIN || is_painted => Bsdf::RoughDielectric {
            ior: Spectrum::Constant(ior),
            exterior_ior: Spectrum::Constant(1.0),
            alpha,
            distribution: Distribution::Ggx,
            multiple_scattering: true,
        },
        Layers { ior, .. } if is_solid => Bsdf::dielectric(ior),
        Layers { ior, .. } => Bsdf::thin_dielectric(ior),
    }
}

/// Glass with what KHR_materials_dispersion says of it.
fn dispersed(bsdf: Bsdf, value: &Value, label: &str) -> Result<Bsdf, SceneError> {
    let dispersion = &value["extensions"][KHR_DISPERSION]["dispersion"];
    if dispersion.is_null() {
        return Ok(bsdf);
    }
    let field = || format!("{label}, {KHR_DISPERSION}.dispersion");
    let Some(number) = dispersion.as_f64() else {
        return Err(SceneError::new(field(), "must be a number", "20 over the Abbe number"));
    };
    if number == 0.0 {
        return Ok(bsdf);
    }
    let of = |ior: f32| {
        Spectrum::of_dispersion(ior, number as f32)
            .map_err(|problem| SceneError::new(field(), problem, "20 over the Abbe number"))
    };
    let bsdf = match bsdf {
        Bsdf::Dielectric { ior, exterior_ior } => {
            let exterior_ior = Spectrum::Constant(exterior_ior);
            Bsdf::DispersiveDielectric { ior: of(ior)?, exterior_ior }
        }
        Bsdf::RoughDielectric {
            ior: Spectrum::Constant(ior),
            exterior_ior,
            alpha,
            distribution,
            multiple_scattering,
        } => {
            let ior = of(ior)?;
            Bsdf::RoughDielectric { ior, exterior_ior, alpha, distribution, multiple_scattering }
        }
        // It states that of every wavelength.
        Bsdf::RoughDielectric { .. } => return Ok(bsdf),
        Bsdf::ThinDielectric { ior, exterior_ior } => match ior {
            Spectrum::Constant(ior) => Bsdf::ThinDielectric { ior: of(ior)?, exterior_ior },
            // It states that of every wavelength.
            ior @ (Spectrum::Rgb(_) | Spectrum::Table(_) | Spectrum::Formula(_)) => {
                return Ok(Bsdf::ThinDielectric { ior, exterior_ior });
            }
        },
        Bsdf::Brushed { of, grain } => Bsdf::brushed(dispersed(*of, value, label)?, grain),
        Bsdf::Absorber
        | Bsdf::Diffuse { .. }
        | Bsdf::Conductor { .. }
        | Bsdf::MetallicRoughness { .. }
        | Bsdf::Layered { .. }
        | Bsdf::Plastic { .. }
        | Bsdf::Measured { .. }
        | Bsdf::Blend { .. }
        | Bsdf::Filmed { .. }
        | Bsdf::FilmedConductor { .. }
        | Bsdf::FilmedDielectric { .. }
        | Bsdf::RoughConductor { .. }
        | Bsdf::DispersiveDielectric { .. }
        | Bsdf::Polarizer { .. }
        | Bsdf::Retarder { .. }
        | Bsdf::Sheet { .. }
        | Bsdf::Null => return Ok(bsdf),
    };
    bsdf.check().map_err(|fault| SceneError::at(label, fault.of(KHR_DISPERSION)))?;
    Ok(bsdf)
}

/// The model that `bsdf` names.
fn extension_model(model: &str, body: &Body, of: Of) -> Result<Bsdf, SceneError> {
    let mut names = MODELS.map(|model| model.name).to_vec();
    names.insert(1, BLEND);
    let remedy = format!("use one of {}", names.join(", "));
    let Some(Model { keys, read, .. }) = MODELS.iter().find(|known| known.name == model) else {
        let problem = format!("`{model}` is not a model");
        return Err(SceneError::new(body.field("bsdf"), problem, remedy));
    };
    check_keys((model, keys), body)?;
    let bsdf = read(body, of)?;
    bsdf.check().map_err(|fault| match fault.field.as_str() {
        "ior" if !body.has("ior") => SceneError::at(body.label(), fault.of(KHR_IOR)),
        "ior over exterior_ior" => SceneError::at(body.label(), fault),
        _ => body.place(fault),
    })?;
    Ok(bsdf)
}

/// Refuses keys that a model does not take.
fn check_keys((model, keys): (&str, &[&str]), body: &Body) -> Result<(), SceneError> {
    match body.keys().find(|key| !keys.contains(key) && !OF_ALL.contains(key)) {
        None => Ok(()),
        Some(key) => {
            let remedy = match keys {
                [] => format!("{model} takes no keys: take it away"),
                keys => format!("a {model} takes: {}", keys.join(", ")),
            };
            let problem = format!("means nothing for a {model}");
            Err(SceneError::new(body.field(key), problem, remedy))
        }
    }
}

fn diffuse(body: &Body, (material, _): Of) -> Result<Bsdf, SceneError> {
    let [red, green, blue, _] = material.pbr_metallic_roughness.base_color_factor.0;
    let base_color = Spectrum::Rgb([red, green, blue]);
    Ok(Bsdf::diffuse(body.spectrum("reflectance")?.unwrap_or(base_color)))
}

fn dielectric(body: &Body, (material, _): Of) -> Result<Bsdf, SceneError> {
    let ior = refraction(body, "ior")?.unwrap_or_else(|| khr_ior(material).into());
    let exterior_ior = refraction(body, "exterior_ior")?.unwrap_or(1.0.into());
    filmed(Bsdf::boundary(ior, exterior_ior), body)
}

/// A model with the film that is stated, if one is.
fn filmed(bsdf: Bsdf, body: &Body) -> Result<Bsdf, SceneError> {
    Ok(match films::stated(body)? {
        Some(film) => bsdf.filmed(film),
        None => bsdf,
    })
}

fn thin_dielectric(body: &Body, (material, _): Of) -> Result<Bsdf, SceneError> {
    let ior = refraction(body, "ior")?.unwrap_or_else(|| Spectrum::Constant(khr_ior(material)));
    let exterior_ior = refraction(body, "exterior_ior")?.unwrap_or(Spectrum::Constant(1.0));
    Ok(Bsdf::ThinDielectric { ior, exterior_ior })
}

/// The index of refraction of a dielectric.
fn refraction(body: &Body, key: &str) -> Result<Option<Spectrum>, SceneError> {
    let name = body.value(key).and_then(|(value, _)| value.as_str());
    if let Some(name) = name.filter(|name| metal(name).is_some()) {
        let problem = format!("`{name}` is a metal");
        return Err(SceneError::new(body.field(key), problem, "make it a conductor"));
    }
    body.refraction(key, Part::Real)
}

fn conductor(body: &Body, _: Of) -> Result<Bsdf, SceneError> {
    let (eta, k) = metal_index(body, "conductor")?;
    filmed(Bsdf::Conductor { eta, k }, body)
}

fn rough_conductor(body: &Body, _: Of) -> Result<Bsdf, SceneError> {
    let (eta, k) = metal_index(body, "rough_conductor")?;
    let (distribution, multiple_scattering) = distribution_and_several(body)?;
    let bsdf = facets::stated(
        body,
        || alpha(body),
        |alpha| Bsdf::RoughConductor { eta, k, alpha, distribution, multiple_scattering },
    )?;
    filmed(bsdf, body)
}

fn rough_dielectric(body: &Body, (material, _): Of) -> Result<Bsdf, SceneError> {
    let ior = refraction(body, "ior")?.unwrap_or_else(|| khr_ior(material).into());
    let exterior_ior = refraction(body, "exterior_ior")?.unwrap_or(1.0.into());
    let (distribution, multiple_scattering) = distribution_and_several(body)?;
    let bsdf = facets::stated(
        body,
        || alpha(body),
        |alpha| Bsdf::RoughDielectric {
            ior,
            exterior_ior,
            alpha,
            distribution,
            multiple_scattering,
        },
    )?;
    filmed(bsdf, body)
}

/// A table in a file, read once.
fn measured(body: &Body, (_, files): Of) -> Result<Bsdf, SceneError> {
    let Some(uri) = body.word("file")? else {
        return Err(body.missing("file", "a file of measured reflectance, `.pbsdf`"));
    };
    let place = body.field("file");
    let (name, bytes) = match uri.strip_prefix("data:") {
        Some(data) => ("data", decode_data_uri(data, place.clone())?),
        None => (uri, files.bytes(uri, &place, u64::MAX)?),
    };
    let table = MeasuredTable::new(name, bytes).map_err(|fault| SceneError::at(&place, fault))?;
    Ok(Bsdf::Measured { places: table.places(), table })
}

/// The index of refraction of a metal of the model `name`.
fn metal_index(body: &Body, name: &str) -> Result<(Spectrum, Spectrum), SceneError> {
    let index = |key, part| body.refraction(key, part);
    match (body.word("metal")?, index("eta", Part::Real)?, index("k", Part::Extinction)?) {
        (Some(symbol), None, None) => tabulated(symbol).map_err(|fault| body.place(fault)),
        (None, Some(eta), Some(k)) => Ok((eta, k)),
        _ => {
            let remedy = format!("with `metal` one of {}", metal_names().join(", "));
            let problem = format!("a {name} takes either `metal` or both `eta` and `k`");
            Err(SceneError::new(body.label(), problem, remedy))
        }
    }
}

pub(super) fn khr_ior(material: &json::Material) -> f32 {
    let ior = material.extensions.as_ref().and_then(|extensions| extensions.ior.as_ref());
    ior.map_or(DEFAULT_IOR, |ior| ior.ior.0)
}
