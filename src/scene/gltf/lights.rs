//! Punctual lights (KHR_lights_punctual).

use std::f64::consts::FRAC_PI_2;

use glam::DAffine3;
use gltf::json::extensions::scene::khr_lights_punctual::{Light, Type};
use gltf::json::validation::Checked;

use super::Import;
use super::extension::{Body, LIGHT, Range};
use crate::scene::error::SceneError;
use crate::scene::world::{Punctual, PunctualKind, Transform};
use crate::spectrum::Spectrum;

/// Lumens per watt: what divides candela and lux to get W/sr and W/m^2, as Blender multiplies.
const LUMENS_PER_WATT: f32 = 683.0;

impl Import<'_> {
    /// Adds the light that a node refers to; a light without intensity adds nothing.
    pub fn add_light(
        &mut self,
        index: usize,
        node: &str,
        to_world: DAffine3,
    ) -> Result<(), SceneError> {
        let document = self.document;
        let lights = document.root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
        let Some(light) = lights.and_then(|lights| lights.lights.get(index)) else {
            return Ok(());
        };
        let value = &document.value["extensions"]["KHR_lights_punctual"]["lights"][index];
        let label = match &light.name {
            Some(name) => format!("{node}, light {index} \"{name}\""),
            None => format!("{node}, light {index}"),
        };
        if light.range.is_some() {
            self.warn(format!("{label}: range is ignored, light fades with distance alone"));
        }
        let kind = kind(light, &label)?;
        let intensity = intensity(light, &Body::of(value, &label, &LIGHT)?)?;
        if intensity.values().iter().any(|value| *value > 0.0) {
            let (order, name) = self.identity(label);
            let light = Punctual { kind, intensity };
            self.entities.spawn((order, name, Transform(to_world), light));
        }
        Ok(())
    }
}

fn kind(light: &Light, label: &str) -> Result<PunctualKind, SceneError> {
    match light.type_ {
        Checked::Valid(Type::Point) => Ok(PunctualKind::Point),
        Checked::Valid(Type::Directional) => Ok(PunctualKind::Directional),
        Checked::Valid(Type::Spot) => {
            let spot = light.spot.clone().unwrap_or_default();
            let (inner, outer) =
                (f64::from(spot.inner_cone_angle), f64::from(spot.outer_cone_angle));
            // Blender writes equal angles for a spot without soft edge, so that is fine.
            if inner >= 0.0 && inner <= outer && outer > 0.0 && outer <= FRAC_PI_2 + 1e-6 {
                return Ok(PunctualKind::Spot { inner, outer: outer.min(FRAC_PI_2) });
            }
            let problem = format!("innerConeAngle {inner} and outerConeAngle {outer} do not fit");
            let remedy = "radians, 0 <= inner <= outer <= pi/2";
            Err(SceneError::new(format!("{label}, spot"), problem, remedy))
        }
        Checked::Invalid => {
            let remedy = "use point, spot or directional";
            Err(SceneError::new(format!("{label}, type"), "is not known", remedy))
        }
    }
}

/// Color times intensity, in radiometric units.
fn intensity(light: &Light, body: &Body) -> Result<Spectrum, SceneError> {
    let unit = match body.word("units")? {
        Some("radiometric") => 1.0,
        Some("photometric") | None => 1.0 / LUMENS_PER_WATT,
        Some(other) => {
            let problem = format!("`{other}` is not a system of units");
            let remedy = "use \"photometric\" (candela, lux) or \"radiometric\" (W/sr, W/m^2)";
            return Err(SceneError::new(body.field("units"), problem, remedy));
        }
    };
    let field = format!("{}, intensity times color", body.label());
    for channel in light.color {
        Range::NOT_NEGATIVE.check(f64::from(light.intensity * channel), &field)?;
    }
    Ok(Spectrum::Rgb(light.color).scaled(light.intensity * unit))
}
