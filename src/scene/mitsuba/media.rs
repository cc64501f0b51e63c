//! Participating media and their phase functions.

use super::fields::{Fields, Given};
use super::spectra::{Kind, check, product};
use super::tree::{NAME, Tag};
use crate::math::Range;
use crate::math::text::excerpt;
use crate::scene::error::SceneError;
use crate::scene::world::{Medium, Phase};
use crate::spectrum::Spectrum;

/// Reads a medium.
pub fn read(fields: &Fields) -> Result<Medium, SceneError> {
    if fields.object.plugin != "homogeneous" {
        let problem = format!("`{}` is not supported", excerpt(&fields.object.plugin, NAME));
        return Err(fields.refuse(problem, "the only type is homogeneous"));
    }
    let sigma_t = volume(fields, "sigma_t", 1.0)?;
    let albedo = volume(fields, "albedo", 0.75)?;
    let scale = fields.number("scale")?.unwrap_or(1.0) as f32;
    // How media are sampled.
    fields.ignore(&["has_spectral_extinction", "sample_emitters"]);
    check(fields, "albedo", &albedo, Range::UNIT)?;
    check(fields, "sigma_t", &sigma_t, Range::NOT_NEGATIVE)?;
    Range::NOT_NEGATIVE.check("scale", scale).map_err(|fault| fields.fault(fault, &[]))?;
    let phase = match fields.only(Tag::Phase)? {
        Some(object) => phase(&Fields::of(fields.tree, object))?,
        None => Phase::isotropic(),
    };
    let apart = || {
        let problem = "a color and a table cannot be multiplied with each other";
        fields.wrong("albedo", problem, "give both as colors, or both as tables")
    };
    let sigma_s = product(&sigma_t, &albedo, |sigma_t, albedo| scale * sigma_t * albedo);
    let sigma_a = product(&sigma_t, &albedo, |sigma_t, albedo| scale * sigma_t * (1.0 - albedo));
    let (sigma_s, sigma_a) = sigma_s.zip(sigma_a).ok_or_else(apart)?;
    fields.finish()?;
    Ok(Medium::new(sigma_a, sigma_s, phase))
}

/// What a volume holds that is the same everywhere.
fn volume(fields: &Fields, name: &str, default: f64) -> Result<Spectrum, SceneError> {
    if let Some(Given::Object(object)) = fields.given(name)
        && fields.tree.objects[object].tag == Tag::Volume
    {
        let inner = Fields::of(fields.tree, object);
        if inner.object.plugin != "constvolume" {
            let problem = format!("`{}` is not supported", excerpt(&inner.object.plugin, NAME));
            return Err(inner.refuse(problem, "the only type is constvolume"));
        }
        let value = inner.spectrum_or("value", Kind::Share, default)?;
        inner.finish()?;
        return Ok(value);
    }
    fields.spectrum_or(name, Kind::Share, default)
}

/// What reads a type.
type Read = fn(&Fields) -> Result<Phase, SceneError>;

/// The phase functions by type.
const PHASES: [(&str, Read); 3] = [
    ("hg", |fields| {
        let g = fields.number("g")?.unwrap_or(0.8) as f32;
        Ok(Phase::HenyeyGreenstein { g: Spectrum::Constant(g) })
    }),
    ("isotropic", |_| Ok(Phase::isotropic())),
    ("rayleigh", |_| Ok(Phase::Rayleigh { depolarization: 0.0 })),
];

fn phase(fields: &Fields) -> Result<Phase, SceneError> {
    let plugin = fields.object.plugin.as_str();
    let Some((_, read)) = PHASES.iter().find(|(name, _)| *name == plugin) else {
        let problem = format!("`{}` is not supported", excerpt(plugin, NAME));
        let names: Vec<&str> = PHASES.iter().map(|(name, _)| *name).collect();
        return Err(fields.refuse(problem, format!("the types are {}", names.join(", "))));
    };
    let phase = read(fields)?;
    phase.check().map_err(|fault| fields.fault(fault, &[]))?;
    fields.finish()?;
    Ok(phase)
}
