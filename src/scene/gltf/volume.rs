//! What plain glTF says about the inside of transmitting surfaces (KHR_materials_volume): whether
//! there is any, and what it absorbs.

use serde_json::Value;

use super::Import;
use crate::math::Range;
use crate::math::elementary::{cbrt, ln};
use crate::scene::error::SceneError;
use crate::scene::world::{Filling, Medium, Name, Phase, Transform};
use crate::spectrum::Spectrum;

/// The extension.
const VOLUME: &str = "KHR_materials_volume";
/// Least transmittance of a channel: that of black would need infinite absorption.
const TRANSMITTANCE_MIN: f64 = 1e-6;
/// Greatest absorption, in 1/m: of it nothing is left over any distance.
const SIGMA_MAX: f64 = 1e30;

/// What the extension says of a material.
pub struct Volume {
    /// Whether surfaces bound a body; else they are walls of their own, too thin to refract.
    pub is_solid: bool,
    /// How thick it is, in the mesh's own space.
    thickness: f64,
    /// What the body absorbs, in the world's.
    sigma_a: [f64; 3],
    /// The color of its surfaces.
    tint: [f64; 3],
}

impl Volume {
    /// Reads it; without it nothing is solid.
    pub fn of(material: &Value, label: &str) -> Result<Self, SceneError> {
        let body = &material["extensions"][VOLUME];
        let number = |key: &str, range: Range, default: f64| {
            let value = match &body[key] {
                Value::Null => return Ok(default),
                value => value.as_f64().unwrap_or(f64::NAN),
            };
            let place = format!("{label}, {VOLUME}.{key}");
            range.check("", value).map_err(|fault| SceneError::at(&place, fault))?;
            Ok::<f64, SceneError>(value)
        };
        let thickness = number("thicknessFactor", Range::NOT_NEGATIVE, 0.0)?;
        let distance = match body["attenuationDistance"] {
            Value::Null => f64::INFINITY,
            _ => number("attenuationDistance", Range::POSITIVE, f64::INFINITY)?,
        };
        let color = color(&body["attenuationColor"], &format!("{label}, {VOLUME}"))?;
        let sigma_a = absorption(color, distance);
        Ok(Self { is_solid: thickness > 0.0, thickness, sigma_a, tint: [1.0; 3] })
    }

    /// The same of glass of a color. Its surfaces are clear, as no real ones color what they
    /// refract: what is inside absorbs that color over the thickness.
    pub fn tinted(self, tint: [f32; 3]) -> Self {
        Self { tint: tint.map(f64::from), ..self }
    }

    /// What the body is filled with where its mesh is so many times as large; nothing, if that is
    /// clear.
    fn medium(&self, scale: f64) -> Option<Medium> {
        let tint = absorption(self.tint, self.thickness * scale);
        let sigma_a: [f32; 3] = std::array::from_fn(|i| (self.sigma_a[i] + tint[i]) as f32);
        let absorbs = self.is_solid && sigma_a.iter().any(|&it| it > 0.0);
        absorbs.then(|| Medium {
            sigma_a: Some(Spectrum::Rgb(sigma_a)),
            sigma_s: Some(Spectrum::Constant(0.0)),
            phase: Phase::isotropic(),
        })
    }
}

/// What leaves a color of white over a distance.
fn absorption(color: [f64; 3], distance: f64) -> [f64; 3] {
    let of = |channel: f64| (-ln(channel.max(TRANSMITTANCE_MIN)) / distance).min(SIGMA_MAX);
    color.map(|channel| if channel < 1.0 { of(channel) } else { 0.0 })
}

/// Three numbers within [0, 1]; white if there are none.
fn color(value: &Value, place: &str) -> Result<[f64; 3], SceneError> {
    if value.is_null() {
        return Ok([1.0; 3]);
    }
    let place = format!("{place}.attenuationColor");
    let channels: Vec<f64> =
        value.as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
    let Ok(color) = <[f64; 3]>::try_from(channels) else {
        let remedy = "give red, green and blue";
        return Err(SceneError::new(place, "is not three numbers", remedy));
    };
    for channel in color {
        let unit = Range::UNIT.check("", channel as f32);
        unit.map_err(|fault| SceneError::at(&place, fault))?;
    }
    Ok(color)
}

impl Import<'_> {
    /// What fills the bodies of a material, if anything does: made for the first of them.
    pub fn filling(
        &mut self,
        material: usize,
        place: &Transform,
    ) -> Result<Option<Filling>, SceneError> {
        if let Some(known) = self.fillings.get(&material) {
            return Ok(Some(*known));
        }
        let size = cbrt(place.0.matrix3.determinant().abs());
        // What is flat has no thickness of its own.
        let scale = if size > 0.0 { size } else { 1.0 };
        let volume = self.volumes.get(&material);
        let Some(medium) = volume.and_then(|volume| volume.medium(scale)) else { return Ok(None) };
        let label = self.document.label("materials", material);
        let put = self.world.put_medium(Name(format!("{label}, {VOLUME}")), medium);
        let medium = put.map_err(|fault| SceneError::at(&label, fault))?;
        let filling = Filling::Medium(medium);
        self.fillings.insert(material, filling);
        Ok(Some(filling))
    }
}
