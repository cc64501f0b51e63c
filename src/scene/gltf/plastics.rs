//! Plastics: the extension's keys of them.

use serde_json::{Value, json};

use super::extension::Body;
use super::facets::{alpha, distribution};
use super::materials::{Of, khr_ior};
use crate::scene::error::SceneError;
use crate::scene::world::{Bsdf, Coat, InternalReflection};
use crate::spectrum::Spectrum;

/// Keys of plastic.
pub const KEYS: [&str; 8] = [
    "alpha",
    "distribution",
    "exterior_ior",
    "internal_reflection",
    "ior",
    "reflectance",
    "roughness",
    "specular",
];

/// The plastic of a material.
pub fn plastic(body: &Body, (material, _): Of) -> Result<Bsdf, SceneError> {
    let [red, green, blue, _] = material.pbr_metallic_roughness.base_color_factor.0;
    let base_color = Spectrum::Rgb([red, green, blue]);
    let number = |key| body.number(key).map(|value| value.map(|value| value as f32));
    let internal_reflection = match body.word("internal_reflection")? {
        None => InternalReflection::default(),
        Some(name) => InternalReflection::named(name).ok_or_else(|| {
            let names = InternalReflection::ALL.map(InternalReflection::name);
            let problem = format!("`{name}` is not what becomes of light reflected within");
            let remedy = format!("use one of {}", names.join(", "));
            SceneError::new(body.field("internal_reflection"), problem, remedy)
        })?,
    };
    Ok(Bsdf::Plastic {
        reflectance: body.spectrum("reflectance")?.unwrap_or(base_color),
        coat: Coat {
            ior: number("ior")?.unwrap_or_else(|| khr_ior(material)),
            exterior_ior: number("exterior_ior")?.unwrap_or(1.0),
            alpha: alpha(body)?,
            distribution: distribution(body)?,
            specular: number("specular")?.unwrap_or(1.0),
            internal_reflection,
        },
    })
}

/// What [`plastic`] reads.
pub fn written(reflectance: Value, coat: &Coat) -> Value {
    let Coat { ior, exterior_ior, alpha, distribution, specular, internal_reflection } = coat;
    json!({"bsdf": "plastic", "reflectance": reflectance, "ior": ior,
        "exterior_ior": exterior_ior, "alpha": alpha, "distribution": distribution.name(),
        "specular": specular, "internal_reflection": internal_reflection.name()})
}
