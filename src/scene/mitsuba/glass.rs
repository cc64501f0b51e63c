//! Glass and metal, smooth and of facets.

use super::bsdfs::{Surface, number};
use super::fields::Fields;
use super::spectra::{Kind, index_of_name};
use super::textures::{Use, Wanted};
use super::tree::{NAME, Value};
use crate::math::Range;
use crate::math::text::excerpt;
use crate::polarization::Distribution;
use crate::scene::error::SceneError;
use crate::scene::world::{Along, Bsdf, Grain, Parameter};
use crate::spectrum::{Spectrum, metal, metal_names};

/// Indices of refraction by name, at the line d (E. Hecht, "Optics").
const INDICES: [(&str, f64); 23] = [
    ("vacuum", 1.0),
    ("helium", 1.000_036),
    ("hydrogen", 1.000_132),
    ("air", 1.000_277),
    ("carbon dioxide", 1.000_45),
    ("water", 1.333),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.52045),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.47),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.5046),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.575),
    ("diamond", 2.419),
];

/// An index of refraction: a number, or that of a substance.
pub fn index(fields: &Fields, name: &str, default: &str) -> Result<f32, SceneError> {
    let of_name = |wanted: &str| {
        let found = INDICES.iter().find(|(known, _)| known.eq_ignore_ascii_case(wanted));
        found.map(|(_, index)| *index as f32).ok_or_else(|| {
            let problem = format!("`{}` is not known", excerpt(wanted, NAME));
            let names: Vec<&str> = INDICES.iter().map(|(name, _)| *name).collect();
            fields.wrong(name, problem, format!("give a number, or one of {}", names.join(", ")))
        })
    };
    match fields.property(name).map(|property| &property.value) {
        None => of_name(default),
        Some(Value::Text(text)) => of_name(text),
        Some(Value::Float(value)) => Ok(*value as f32),
        Some(Value::Integer(value)) => Ok(*value as f32),
        Some(other) => Err(fields.of_kind(name, other, "a float or the name of a substance")),
    }
}

pub fn dielectric(fields: &Fields) -> Result<Surface, SceneError> {
    let ior = index(fields, "int_ior", "bk7")?;
    let exterior_ior = index(fields, "ext_ior", "air")?;
    stained(fields, Bsdf::Dielectric { ior, exterior_ior }.into())
}

pub fn thin_dielectric(fields: &Fields) -> Result<Surface, SceneError> {
    let ior = Spectrum::Constant(index(fields, "int_ior", "bk7")?);
    let exterior_ior = Spectrum::Constant(index(fields, "ext_ior", "air")?);
    stained(fields, Bsdf::ThinDielectric { ior, exterior_ior }.into())
}

pub fn conductor(fields: &Fields) -> Result<Surface, SceneError> {
    let [eta, k] = metal_index(fields)?;
    stained(fields, Bsdf::Conductor { eta, k }.into())
}

/// A surface with what is left of light that it reflects and, of glass, that goes through.
fn stained(fields: &Fields, mut surface: Surface) -> Result<Surface, SceneError> {
    let of =
        [("specular_reflectance", Use::Reflected), ("specular_transmittance", Use::Transmitted)];
    let ways = if surface.bsdf.transmits() { 2 } else { 1 };
    for (way, (name, used)) in of.into_iter().enumerate().take(ways) {
        if let Some(wanted) = fields.wanted(name, used) {
            surface.wanted.push(wanted);
            continue;
        }
        let share = fields.spectrum_or(name, Kind::Share, 1.0)?;
        super::spectra::check(fields, name, &share, Range::UNIT)?;
        let Some(share) = share.rgb() else {
            let problem = "is given by wavelength, which colors of glass and metal are not";
            return Err(fields.wrong(name, problem, "give an rgb or one number"));
        };
        surface.stain[way] = Some(share).filter(|share| *share != [1.0; 3]);
    }
    Ok(surface)
}

/// Facets reflect once, as Mitsuba has it.
pub fn rough_conductor(fields: &Fields) -> Result<Surface, SceneError> {
    let [eta, k] = metal_index(fields)?;
    let ([along, alpha], wanted) = roughness(fields)?;
    let distribution = distribution(fields)?;
    let bsdf = Bsdf::RoughConductor { eta, k, alpha, distribution, multiple_scattering: false };
    stained(fields, Surface { wanted, ..brushed(bsdf, [along, alpha]).into() })
}

/// Facets scatter once, as Mitsuba has it.
pub fn rough_dielectric(fields: &Fields) -> Result<Surface, SceneError> {
    let ior = Spectrum::Constant(index(fields, "int_ior", "bk7")?);
    let exterior_ior = Spectrum::Constant(index(fields, "ext_ior", "air")?);
    let ([along, alpha], wanted) = roughness(fields)?;
    let distribution = distribution(fields)?;
    let multiple_scattering = false;
    let bsdf =
        Bsdf::RoughDielectric { ior, exterior_ior, alpha, distribution, multiple_scattering };
    stained(fields, Surface { wanted, ..brushed(bsdf, [along, alpha]).into() })
}

/// A model whose facets have these roughnesses along u and v: the second is the model's.
fn brushed(bsdf: Bsdf, [along, across]: [f32; 2]) -> Bsdf {
    match along == across {
        true => bsdf,
        false => Bsdf::brushed(bsdf, Grain::new(Along::Alpha(along))),
    }
}

/// The roughness of facets along u and v, or a picture of it.
fn roughness(fields: &Fields) -> Result<([f32; 2], Vec<Wanted>), SceneError> {
    for name in ["alpha_u", "alpha_v"] {
        if fields.picture(name).is_some() {
            let problem = "pictures of facets that differ along u and v are not supported";
            return Err(fields.wrong(name, problem, "use one, of `alpha`"));
        }
    }
    match fields.wanted("alpha", Use::Parameter(Parameter::Alpha)) {
        Some(wanted) => Ok(([1.0; 2], vec![wanted])),
        None => Ok((alphas(fields)?, Vec::new())),
    }
}

/// The roughness of facets, and how their normals are distributed.
pub fn facets(fields: &Fields) -> Result<(f32, Distribution), SceneError> {
    Ok((alpha(fields)?, distribution(fields)?))
}

fn distribution(fields: &Fields) -> Result<Distribution, SceneError> {
    match fields.text("distribution")? {
        None => Ok(Distribution::Beckmann),
        Some(name) => Distribution::named(name).ok_or_else(|| {
            let problem = format!("`{}` is not a distribution of facets", excerpt(name, NAME));
            let remedy = format!("use {}", Distribution::ALL.map(Distribution::name).join(" or "));
            fields.wrong("distribution", problem, remedy)
        }),
    }
}

/// The same along u and v.
fn alpha(fields: &Fields) -> Result<f32, SceneError> {
    let [along, across] = alphas(fields)?;
    if along == across {
        return Ok(along);
    }
    let problem = "facets of plastic that differ along u and v are not supported";
    Err(fields.wrong("alpha_u", problem, "use `alpha`"))
}

fn alphas(fields: &Fields) -> Result<[f32; 2], SceneError> {
    // How facets are drawn changes no image.
    fields.boolean("sample_visible")?;
    let alphas = match (stated_alpha(fields, "alpha_u")?, stated_alpha(fields, "alpha_v")?) {
        (None, None) => [stated_alpha(fields, "alpha")?.unwrap_or(0.1); 2],
        (Some(along), Some(across)) => [along, across],
        (Some(_), None) => return Err(fields.wrong("alpha_v", "is missing", "state both")),
        (None, Some(_)) => return Err(fields.wrong("alpha_u", "is missing", "state both")),
    };
    Ok(alphas.map(|alpha| alpha as f32))
}

/// A roughness of facets, if there is one.
fn stated_alpha(fields: &Fields, name: &str) -> Result<Option<f64>, SceneError> {
    const REMEDY: &str =
        "give one number from 0, smooth, to 1; rough surfaces are the same all over";
    let alpha =
        number(fields, name).map_err(|error| fields.wrong(name, error.problem(), REMEDY))?;
    match alpha {
        Some(alpha) if !(0.0..=1.0).contains(&alpha) => {
            Err(fields.wrong(name, format!("{alpha} must be within [0, 1]"), REMEDY))
        }
        alpha => Ok(alpha),
    }
}

/// The index of refraction of a metal, and its extinction coefficient.
fn metal_index(fields: &Fields) -> Result<[Spectrum; 2], SceneError> {
    /// An index whose reflectance differs from 1 by 4e-9, where that of 0 does not.
    const NOTHING: f64 = 1e-9;
    let material = fields.text("material")?.unwrap_or("none");
    if fields.has("eta") || material == "none" {
        // Nothing said is a perfect mirror.
        let mut eta = fields.spectrum_or("eta", Kind::Index, 0.0)?;
        if eta == Spectrum::Constant(0.0) {
            eta = Spectrum::Constant(NOTHING as f32);
        }
        let k = fields.spectrum_or("k", Kind::Index, 1.0)?;
        return Ok([eta, k]);
    }
    let symbol = material.strip_suffix("_palik").unwrap_or(material);
    let (eta, k) = metal(symbol).ok_or_else(|| {
        let problem = format!("`{}` is not tabulated", excerpt(material, NAME));
        let remedy = format!("use one of {}, or give `eta` and `k`", metal_names().join(", "));
        fields.wrong("material", problem, remedy)
    })?;
    Ok([eta, k].map(index_of_name))
}
