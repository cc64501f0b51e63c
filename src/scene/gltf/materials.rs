//! Materials: the extension's models, and what glTF's own parameters mean here.
//!
//! Without the extension, a metallic-roughness material becomes the model of ours that it names
//! exactly, or the nearest with a warning, or is refused:
//! - metallic 1, roughness 0: a conductor with eta = 1 and k = 2 sqrt(F0 / (1 - F0)), which has
//!   the reflectance F0 = baseColor at normal incidence (F0 is capped at 0.999);
//! - metallic 0, transmission 1, roughness 0: a dielectric of KHR_materials_ior, 1.5 if not given;
//! - metallic 0, no transmission: Lambertian of baseColor, without glTF's dielectric coat;
//! - no material: Lambertian of reflectance 0.8.

use gltf::json::Material;
use hecs::Entity;
use serde_json::Value;

use super::Import;
use super::extension::{Body, MATERIAL, Range};
use crate::scene::error::SceneError;
use crate::scene::world::{Bsdf, Emission, Sides};
use crate::spectrum::{Spectrum, metal, metal_names};

/// Index of refraction that glTF gives to dielectrics.
const DEFAULT_IOR: f32 = 1.5;
/// Reflectance of what has no material.
const DEFAULT_REFLECTANCE: f32 = 0.8;
/// Greatest F0 of a metal that has no eta and k: they would be infinite at 1.
const F0_MAX: f32 = 0.999;

/// Values of `bsdf`, with the keys that they take.
const MODELS: [(&str, &[&str]); 7] = [
    ("absorber", &[]),
    ("conductor", &["eta", "k", "metal"]),
    ("dielectric", &["exterior_ior", "ior"]),
    ("diffuse", &["reflectance"]),
    ("null", &[]),
    ("polarizer", &["axis_deg", "extinction_ratio"]),
    ("retarder", &["axis_deg", "retardance_deg"]),
];
/// Values of `bsdf` that later versions will know.
const PLANNED_MODELS: [&str; 3] = ["plastic", "rough_conductor", "rough_dielectric"];

impl Import<'_> {
    /// The entity of a material, which is added when it is first used.
    pub fn material(&mut self, index: Option<usize>, user: &str) -> Result<Entity, SceneError> {
        if let Some(&entity) = self.materials.get(&index) {
            return Ok(entity);
        }
        let (label, bsdf, emission, two_sided) = match index {
            Some(index) => {
                let label = self.document.label("materials", index);
                let bsdf = self.bsdf(index, &label)?;
                let material = &self.document.root.materials[index];
                let emission = emission(material, &label)?;
                if bsdf == Bsdf::Null && emission.is_some() {
                    let remedy = "remove emissiveFactor, or use the bsdf absorber";
                    let problem = "a null surface is not there, so it cannot emit";
                    return Err(SceneError::new(label, problem, remedy));
                }
                (label, bsdf, emission, material.double_sided)
            }
            None => {
                let remark = "has no material and is taken as a diffuse surface of reflectance";
                self.warn(format!("{user} {remark} {DEFAULT_REFLECTANCE}"));
                let reflectance = Spectrum::Constant(DEFAULT_REFLECTANCE);
                ("default material".to_owned(), Bsdf::Diffuse { reflectance }, None, true)
            }
        };
        let (order, name) = self.identity(label);
        let entity = self.entities.spawn((order, name, bsdf, Sides { two_sided }));
        if let Some(emission) = emission {
            // The entity has just been spawned, so this cannot fail.
            let _ = self.entities.insert_one(entity, emission);
        }
        self.materials.insert(index, entity);
        Ok(entity)
    }

    fn bsdf(&mut self, index: usize, label: &str) -> Result<Bsdf, SceneError> {
        let document = self.document;
        let value = &document.value["materials"][index];
        let material = &document.root.materials[index];
        refuse_textures(value, label)?;
        let body = Body::of(value, label, &MATERIAL)?;
        if let Some(model) = body.word("bsdf")? {
            return extension_model(model, &body, material);
        }
        if !body.is_empty() {
            let keys: Vec<&str> = body.keys().collect();
            let problem = format!("has {} but no `bsdf`", keys.join(", "));
            return Err(SceneError::new(label, problem, "add `bsdf`, the name of the model"));
        }
        self.metallic_roughness(material, label)
    }

    fn metallic_roughness(&mut self, material: &Material, label: &str) -> Result<Bsdf, SceneError> {
        const ADVICE: &str = "use factors of 0 or 1, or SUNSTONE_polarization with a `bsdf`";
        let pbr = &material.pbr_metallic_roughness;
        let (metallic, roughness) = (pbr.metallic_factor.0, pbr.roughness_factor.0);
        let transmission = material.extensions.as_ref().and_then(|e| e.transmission.as_ref());
        let transmission = transmission.map_or(0.0, |t| t.transmission_factor.0);
        let [red, green, blue, alpha] = pbr.base_color_factor.0;
        for factor in [red, green, blue, metallic, roughness, transmission] {
            Range::UNIT.check(f64::from(factor), &format!("{label}, pbrMetallicRoughness"))?;
        }
        if alpha < 1.0 {
            self.warn(format!("{label}: alpha is ignored, surfaces are opaque"));
        }
        let refuse = |problem: &str| Err(SceneError::new(label, problem, ADVICE));
        match (metallic, transmission) {
            (1.0, _) if roughness == 0.0 => {
                let k = |f0: f32| {
                    let f0 = f0.min(F0_MAX);
                    2.0 * (f0 / (1.0 - f0)).sqrt()
                };
                let eta = Spectrum::Constant(1.0);
                Ok(Bsdf::Conductor { eta, k: Spectrum::Rgb([red, green, blue].map(k)) })
            }
            (1.0, _) => refuse("is a rough metal, which is not supported yet"),
            (0.0, 1.0) if roughness == 0.0 => {
                if [red, green, blue] != [1.0; 3] {
                    self.warn(format!("{label}: the color of the glass is ignored"));
                }
                Ok(Bsdf::Dielectric { ior: khr_ior(material, label)?, exterior_ior: 1.0 })
            }
            (0.0, 1.0) => refuse("is rough glass, which is not supported yet"),
            (0.0, 0.0) => {
                if roughness < 1.0 {
                    self.warn(format!(
                        "{label}: rendered as Lambertian of its base color, without glTF's coat"
                    ));
                }
                Ok(Bsdf::Diffuse { reflectance: Spectrum::Rgb([red, green, blue]) })
            }
            (0.0, _) => refuse("mixes transmission and reflection by a partial factor"),
            _ => refuse("mixes metal and dielectric by a partial metallicFactor"),
        }
    }
}

/// The model that `bsdf` names.
fn extension_model(model: &str, body: &Body, material: &Material) -> Result<Bsdf, SceneError> {
    let names: Vec<&str> = MODELS.iter().map(|(name, _)| *name).collect();
    let remedy = format!("use one of {}", names.join(", "));
    if PLANNED_MODELS.contains(&model) {
        let problem = format!("`{model}` is not supported yet");
        return Err(SceneError::new(body.field("bsdf"), problem, remedy));
    }
    let Some((_, keys)) = MODELS.iter().find(|(name, _)| *name == model) else {
        let problem = format!("`{model}` is not a model");
        return Err(SceneError::new(body.field("bsdf"), problem, remedy));
    };
    if let Some(key) = body.keys().find(|key| *key != "bsdf" && !keys.contains(key)) {
        let remedy = format!("a {model} takes: {}", keys.join(", "));
        let problem = format!("means nothing for a {model}");
        return Err(SceneError::new(body.field(key), problem, remedy));
    }
    let axis_deg = body.number("axis_deg", Range::ANY)?.unwrap_or(0.0);
    match model {
        "diffuse" => {
            let [red, green, blue, _] = material.pbr_metallic_roughness.base_color_factor.0;
            let base_color = Spectrum::Rgb([red, green, blue]);
            let reflectance = body.spectrum("reflectance", Range::UNIT)?.unwrap_or(base_color);
            for value in reflectance.values() {
                Range::UNIT.check(f64::from(*value), &body.field("reflectance"))?;
            }
            Ok(Bsdf::Diffuse { reflectance })
        }
        "conductor" => conductor(body),
        "dielectric" => {
            let ior = body.number("ior", Range::POSITIVE)?.map(|ior| ior as f32);
            let ior = ior.map_or_else(|| khr_ior(material, body.label()), Ok)?;
            let exterior_ior = body.number("exterior_ior", Range::POSITIVE)?.unwrap_or(1.0);
            Range::POSITIVE.check(
                f64::from(ior) / exterior_ior,
                &format!("{}, ior over exterior_ior", body.label()),
            )?;
            Ok(Bsdf::Dielectric { ior, exterior_ior: exterior_ior as f32 })
        }
        "null" => Ok(Bsdf::Null),
        "polarizer" => {
            let ratio = body.number("extinction_ratio", Range::AT_LEAST_ONE)?;
            Ok(Bsdf::Polarizer { axis_deg, extinction_ratio: ratio.unwrap_or(f64::INFINITY) })
        }
        "retarder" => match body.number("retardance_deg", Range::ANY)? {
            Some(retardance_deg) => Ok(Bsdf::Retarder { axis_deg, retardance_deg }),
            None => {
                let remedy = "90 for a quarter-wave plate, 180 for a half-wave plate";
                Err(SceneError::new(body.field("retardance_deg"), "is missing", remedy))
            }
        },
        _ => Ok(Bsdf::Absorber),
    }
}

fn conductor(body: &Body) -> Result<Bsdf, SceneError> {
    let names = || metal_names().collect::<Vec<_>>().join(", ");
    let eta = body.spectrum("eta", Range::POSITIVE)?;
    let k = body.spectrum("k", Range::NOT_NEGATIVE)?;
    match (body.word("metal")?, eta, k) {
        (Some(name), None, None) => {
            let Some((eta, k)) = metal(name) else {
                let problem = format!("`{name}` is not tabulated");
                let remedy = format!("use one of {}, or give `eta` and `k`", names());
                return Err(SceneError::new(body.field("metal"), problem, remedy));
            };
            Ok(Bsdf::Conductor { eta, k })
        }
        (None, Some(eta), Some(k)) => Ok(Bsdf::Conductor { eta, k }),
        _ => {
            let remedy = format!("with `metal` one of {}", names());
            let problem = "a conductor takes either `metal` or both `eta` and `k`";
            Err(SceneError::new(body.label(), problem, remedy))
        }
    }
}

fn khr_ior(material: &Material, label: &str) -> Result<f32, SceneError> {
    let ior = material.extensions.as_ref().and_then(|extensions| extensions.ior.as_ref());
    let ior = ior.map_or(DEFAULT_IOR, |ior| ior.ior.0);
    Range::POSITIVE.check(f64::from(ior), &format!("{label}, KHR_materials_ior.ior"))?;
    Ok(ior)
}

/// emissiveFactor times emissiveStrength is the radiance.
fn emission(material: &Material, label: &str) -> Result<Option<Emission>, SceneError> {
    let factor = material.emissive_factor.0;
    let strength = material.extensions.as_ref().and_then(|e| e.emissive_strength.as_ref());
    let strength = strength.map_or(1.0, |strength| strength.emissive_strength.0);
    let field = format!("{label}, emissiveFactor times emissiveStrength");
    for channel in factor {
        Range::NOT_NEGATIVE.check(f64::from(channel) * f64::from(strength), &field)?;
    }
    let radiance = Spectrum::Rgb(factor).scaled(strength);
    let emits = radiance.values().iter().any(|value| *value > 0.0);
    Ok(emits.then_some(Emission { radiance }))
}

/// Refuses a material that has a texture anywhere.
fn refuse_textures(material: &Value, label: &str) -> Result<(), SceneError> {
    let mut open = vec![material];
    while let Some(next) = open.pop() {
        for (key, inner) in next.as_object().into_iter().flatten() {
            if key.ends_with("Texture") {
                let problem = "textures are not supported yet";
                let remedy = "replace it by a factor, for instance its mean color";
                return Err(SceneError::new(format!("{label}, {key}"), problem, remedy));
            }
            if key != "extras" {
                open.push(inner);
            }
        }
    }
    Ok(())
}
