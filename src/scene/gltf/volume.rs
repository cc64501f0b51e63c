//! What plain glTF says about the inside of transmitting surfaces (KHR_materials_volume): whether
//! there is any, and what it absorbs.

use serde_json::Value;

use super::Import;
use crate::math::Range;
use crate::math::elementary::ln;
use crate::scene::error::SceneError;
use crate::scene::world::{Filling, Medium, Name, Phase};
use crate::spectrum::Spectrum;

/// The extension.
const VOLUME: &str = "KHR_materials_volume";
/// Least transmittance of a channel: that of black would need infinite absorption.
const TRANSMITTANCE_MIN: f64 = 1e-6;

/// What the extension says of a material.
pub struct Volume {
    /// Whether surfaces bound a body; else they are walls of their own, too thin to refract.
    pub is_solid: bool,
    /// What the body absorbs.
    pub absorbs: Option<Medium>,
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
        let is_solid = number("thicknessFactor", Range::NOT_NEGATIVE, 0.0)? > 0.0;
        let distance = match body["attenuationDistance"] {
            Value::Null => f64::INFINITY,
            _ => number("attenuationDistance", Range::POSITIVE, f64::INFINITY)?,
        };
        let color = color(&body["attenuationColor"], &format!("{label}, {VOLUME}"))?;
        let absorbs = is_solid && distance.is_finite() && color.iter().any(|&it| it < 1.0);
        let sigma_a = color.map(|it| (-ln(it.max(TRANSMITTANCE_MIN)) / distance) as f32);
        let medium = || Medium {
            sigma_a: Some(Spectrum::Rgb(sigma_a)),
            sigma_s: Some(Spectrum::Constant(0.0)),
            phase: Phase::isotropic(),
        };
        Ok(Self { is_solid, absorbs: absorbs.then(medium) })
    }
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
    /// Makes a medium of what the body behind a material's surfaces absorbs.
    pub fn add_volume(
        &mut self,
        material: usize,
        volume: Volume,
        label: &str,
    ) -> Result<(), SceneError> {
        let Some(medium) = volume.absorbs else { return Ok(()) };
        let name = Name(format!("{label}, {VOLUME}"));
        let put = self.world.put_medium(name, medium);
        let medium = put.map_err(|fault| SceneError::at(label, fault))?;
        self.volumes.insert(material, Filling::Medium(medium));
        Ok(())
    }
}
