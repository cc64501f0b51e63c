//! Materials of keyword arguments, which are those of the scene files.

use pyo3::prelude::*;
use sunstone::spectra::metal_names;
use sunstone::world::{Bsdf, EmittedStokes, InternalReflection, Material, Sides};
use sunstone::{Distribution, Spectrum};

use crate::errors::of_any;
use crate::keys::Keys;
use crate::spectra::Part;

/// Index of refraction that glTF gives to dielectrics.
const IOR: f32 = 1.5;
/// Reflectance of what does not state one.
const REFLECTANCE: f32 = 0.8;

/// Values of `bsdf`.
const MODELS: &str = "use one of absorber, conductor, dielectric, diffuse, null, plastic, \
                      polarizer, retarder, rough_conductor, rough_dielectric, thin_dielectric";

/// A material, and how what it emits is polarized: in a state, or by its heat.
pub fn material(keys: Keys) -> PyResult<(Material, Option<EmittedStokes>, bool)> {
    let model: String = keys.need("bsdf", MODELS)?;
    let two_sided = keys.flag("two_sided")?;
    let emission = keys.lamp("emission")?;
    let stokes = keys.stokes("stokes")?;
    if stokes.is_some() && emission.is_none() {
        let problem = "is the state of what is emitted, and nothing is";
        return Err(keys.refuse("stokes", problem, "add an emission"));
    }
    let incandescent = keys.flag("incandescent")?;
    let bsdf = bsdf(&keys, &model)?;
    keys.finish(&format!("a material of bsdf \"{model}\""))?;
    let material = Material { bsdf, sides: Sides { two_sided }, emission: None };
    let material = match emission {
        Some(radiance) => material.emitting(radiance),
        None => material,
    };
    Ok((material, stokes, incandescent))
}

fn bsdf(keys: &Keys, model: &str) -> PyResult<Bsdf> {
    let axis_deg = || Ok::<f64, PyErr>(keys.take("axis_deg")?.unwrap_or(0.0));
    Ok(match model {
        "absorber" => Bsdf::Absorber,
        "conductor" => conductor(keys)?,
        "dielectric" => {
            let [ior, exterior_ior] = indices(keys)?;
            Bsdf::boundary(ior, exterior_ior)
        }
        "diffuse" => Bsdf::diffuse(keys.spectrum("reflectance")?.unwrap_or(REFLECTANCE.into())),
        "null" => Bsdf::Null,
        "plastic" => plastic(keys)?,
        "polarizer" => Bsdf::Polarizer {
            axis_deg: axis_deg()?,
            extinction_ratio: keys.take("extinction_ratio")?.unwrap_or(f64::INFINITY),
        },
        "retarder" => Bsdf::Retarder {
            axis_deg: axis_deg()?,
            retardance_deg: keys
                .need("retardance_deg", "90 for a quarter-wave plate, 180 for a half-wave plate")?,
        },
        "rough_conductor" => rough_conductor(keys)?,
        "rough_dielectric" => {
            let [ior, exterior_ior] = indices(keys)?;
            let (alpha, distribution, multiple_scattering) = facets(keys)?;
            Bsdf::RoughDielectric { ior, exterior_ior, alpha, distribution, multiple_scattering }
        }
        "thin_dielectric" => {
            let [ior, exterior_ior] = indices(keys)?;
            Bsdf::ThinDielectric { ior, exterior_ior }
        }
        model => return Err(keys.refuse("bsdf", &format!("`{model}` is not a model"), MODELS)),
    })
}

fn indices(keys: &Keys) -> PyResult<[Spectrum; 2]> {
    let [ior, exterior_ior] = [keys.index("ior")?, keys.index("exterior_ior")?];
    Ok([ior.unwrap_or(IOR.into()), exterior_ior.unwrap_or(1.0.into())])
}

fn conductor(keys: &Keys) -> PyResult<Bsdf> {
    let (eta, k) = metal_index(keys, "conductor")?;
    Ok(Bsdf::Conductor { eta, k })
}

fn rough_conductor(keys: &Keys) -> PyResult<Bsdf> {
    let (eta, k) = metal_index(keys, "rough_conductor")?;
    let (alpha, distribution, multiple_scattering) = facets(keys)?;
    Ok(Bsdf::RoughConductor { eta, k, alpha, distribution, multiple_scattering })
}

/// What facets are like, and whether what several of them scatter is given back.
fn facets(keys: &Keys) -> PyResult<(f32, Distribution, bool)> {
    let distribution = distribution(keys)?;
    let multiple_scattering = keys.flag_or("multiple_scattering", true)?;
    Ok((alpha(keys)?, distribution, multiple_scattering))
}

fn plastic(keys: &Keys) -> PyResult<Bsdf> {
    let internal_reflection = match keys.take::<String>("internal_reflection")? {
        None => InternalReflection::default(),
        Some(name) => InternalReflection::named(&name).ok_or_else(|| {
            let problem = format!("`{name}` is not what becomes of light reflected within");
            keys.refuse("internal_reflection", &problem, "use one of lost, linear, nonlinear")
        })?,
    };
    Ok(Bsdf::Plastic {
        reflectance: keys.spectrum("reflectance")?.unwrap_or(REFLECTANCE.into()),
        ior: number(keys, "ior", IOR)?,
        exterior_ior: number(keys, "exterior_ior", 1.0)?,
        alpha: alpha(keys)?,
        distribution: distribution(keys)?,
        specular: keys.take("specular")?.unwrap_or(1.0),
        internal_reflection,
    })
}

/// An index of refraction that is one number.
fn number(keys: &Keys, key: &str, default: f32) -> PyResult<f32> {
    match keys.index(key)? {
        None => Ok(default),
        Some(Spectrum::Constant(value)) => Ok(value),
        Some(Spectrum::Rgb(_) | Spectrum::Table(_) | Spectrum::Formula(_)) => {
            Err(keys.refuse(key, "must be one number", "that of the sodium line, as 1.5"))
        }
    }
}

/// How the normals of facets are distributed.
fn distribution(keys: &Keys) -> PyResult<Distribution> {
    match keys.take::<String>("distribution")? {
        None => Ok(Distribution::default()),
        Some(name) => Distribution::named(&name).ok_or_else(|| {
            let problem = format!("`{name}` is not a distribution of facets");
            keys.refuse("distribution", &problem, "use ggx or beckmann")
        }),
    }
}

/// The roughness of facets: itself, or its root.
fn alpha(keys: &Keys) -> PyResult<f32> {
    match (keys.take::<f32>("alpha")?, keys.take::<f32>("roughness")?) {
        (Some(alpha), None) => Ok(alpha),
        (None, Some(roughness)) if (0.0..=1.0).contains(&roughness) => Ok(roughness * roughness),
        (None, Some(roughness)) => {
            let problem = format!("{roughness} must be within [0, 1]");
            Err(keys.refuse("roughness", &problem, "it is the root of `alpha`"))
        }
        _ => {
            let problem = "facets take either `alpha` or `roughness`, its root";
            Err(keys.refuse("", problem, "both are within [0, 1]"))
        }
    }
}

/// The index of refraction of a metal of the model `name`.
fn metal_index(keys: &Keys, name: &str) -> PyResult<(Spectrum, Spectrum)> {
    let metal: Option<String> = keys.take("metal")?;
    let [eta, k] = [keys.refraction("eta", Part::Real)?, keys.refraction("k", Part::Extinction)?];
    match (metal, eta, k) {
        (Some(symbol), None, None) => match Bsdf::metal(&symbol).map_err(of_any)? {
            Bsdf::Conductor { eta, k } => Ok((eta, k)),
            other => unreachable!("a metal is a conductor, not {other:?}"),
        },
        (None, Some(eta), Some(k)) => Ok((eta, k)),
        _ => {
            let problem = format!("a {name} takes either `metal` or both `eta` and `k`");
            let remedy = format!("with `metal` one of {}", metal_names().join(", "));
            Err(keys.refuse("", &problem, &remedy))
        }
    }
}
