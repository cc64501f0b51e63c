//! Thin films: the extension's, and what glTF calls iridescence.

use serde_json::{Value, json};

use super::extension::{Body, THIN_FILM};
use super::spectra::Part;
use crate::math::Range;
use crate::scene::error::SceneError;
use crate::scene::warnings::Warnings;
use crate::scene::world::{Bsdf, ThinFilm};
use crate::spectrum::Spectrum;

/// How glTF states a film.
const KHR_IRIDESCENCE: &str = "KHR_materials_iridescence";
/// Its index, and its thickness in nanometers, unless they are stated.
const DEFAULTS: [(&str, f64); 2] =
    [("iridescenceIor", 1.3), ("iridescenceThicknessMaximum", 400.0)];

/// The film of a material, if it has one.
pub fn stated(body: &Body) -> Result<Option<ThinFilm<Spectrum>>, SceneError> {
    let Some(film) = body.object("film", &THIN_FILM)? else { return Ok(None) };
    let Some(eta) = film.refraction("eta", Part::Real)? else {
        return Err(film.missing("eta", "the real part of the film's index of refraction"));
    };
    let k = film.refraction("k", Part::Extinction)?.unwrap_or(Spectrum::Constant(0.0));
    let Some(thickness_nm) = film.number("thickness_nm")? else {
        return Err(film.missing("thickness_nm", "in nanometers, as 300"));
    };
    Ok(Some(ThinFilm::new(eta, k, thickness_nm as f32)))
}

/// What [`stated`] reads.
pub fn written(film: &ThinFilm<Spectrum>, of: &mut impl FnMut(&Spectrum) -> Value) -> Value {
    json!({"eta": of(&film.eta), "k": of(&film.k), "thickness_nm": of(&film.thickness)})
}

/// Metal or glass with the film that glTF states.
pub fn iridescent(
    bsdf: Bsdf,
    value: &Value,
    label: &str,
    warnings: &mut Warnings,
) -> Result<Bsdf, SceneError> {
    let iridescence = &value["extensions"][KHR_IRIDESCENCE];
    let field = |key: &str| format!("{label}, {KHR_IRIDESCENCE}.{key}");
    let number = |key: &str, or: f64| match &iridescence[key] {
        Value::Null => Ok(or),
        stated => stated.as_f64().ok_or_else(|| {
            SceneError::new(field(key), "must be a number", "export the scene again")
        }),
    };
    let factor = number("iridescenceFactor", 0.0)?;
    Range::UNIT
        .check("", factor)
        .map_err(|fault| SceneError::at(&field("iridescenceFactor"), fault))?;
    if factor == 0.0 {
        return Ok(bsdf);
    }
    let [ior, thickness_nm] = DEFAULTS.map(|(key, or)| number(key, or).map(|value| value as f32));
    let (ior, thickness_nm) = (ior?, thickness_nm?);
    let film = ThinFilm::new(ior, 0.0, thickness_nm);
    let filmed = match bsdf {
        Bsdf::Conductor { eta, k } => Bsdf::FilmedConductor { eta, k, film },
        Bsdf::Dielectric { ior, exterior_ior } => {
            Bsdf::FilmedDielectric { ior, exterior_ior, film }
        }
        bsdf @ (Bsdf::Absorber
        | Bsdf::Diffuse { .. }
        | Bsdf::RoughConductor { .. }
        | Bsdf::RoughDielectric { .. }
        | Bsdf::Plastic { .. }
        | Bsdf::Measured { .. }
        | Bsdf::Blend { .. }
        | Bsdf::Brushed { .. }
        | Bsdf::MetallicRoughness { .. }
        | Bsdf::Layered { .. }
        | Bsdf::DispersiveDielectric { .. }
        | Bsdf::FilmedConductor { .. }
        | Bsdf::FilmedDielectric { .. }
        | Bsdf::ThinDielectric { .. }
        | Bsdf::Polarizer { .. }
        | Bsdf::Retarder { .. }
        | Bsdf::Sheet { .. }
        | Bsdf::Null) => {
            let text = "its iridescence is ignored: only smooth metal and solid glass without \
                        dispersion have films";
            warnings.add(label, text);
            return Ok(bsdf);
        }
    };
    let is_painted = ["iridescenceTexture", "iridescenceThicknessTexture"]
        .into_iter()
        .any(|key| iridescence[key].is_object());
    if factor < 1.0 || is_painted {
        let text = "its film covers it whole, at iridescenceThicknessMaximum: factors and textures \
                    of iridescence are ignored";
        warnings.add(label, text);
    }
    filmed.check().map_err(|fault| {
        let key = match fault.field.as_str() {
            "film.eta" => DEFAULTS[0].0,
            _ => DEFAULTS[1].0,
        };
        SceneError::at(&field(key), fault.of(""))
    })?;
    Ok(filmed)
}
