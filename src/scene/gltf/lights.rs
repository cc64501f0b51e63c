//! Punctual lights (KHR_lights_punctual).

use std::f64::consts::FRAC_PI_2;

use gltf::json::extensions::scene::khr_lights_punctual::{Light, Type};
use gltf::json::validation::Checked;

use super::Import;
use super::document::Document;
use super::extension::{Body, LIGHT};
use super::luminaires::luminaire_of;
use crate::scene::error::SceneError;
use crate::scene::world::{Falloff, Name, Projection, Punctual, PunctualKind, Transform};
use crate::spectrum::Spectrum;

/// Lumens per watt: what divides candela and lux to get W/sr and W/m^2, as Blender multiplies.
pub(super) const LUMENS_PER_WATT: f32 = 683.0;

impl Import<'_> {
    /// Adds the light that a node, or nothing, refers to; one without intensity adds nothing.
    pub fn add_light(
        &mut self,
        index: usize,
        node: &str,
        place: Transform,
    ) -> Result<(), SceneError> {
        let document = self.document;
        let lights = document.root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
        let Some(light) = lights.and_then(|lights| lights.lights.get(index)) else {
            return Ok(());
        };
        let value = &document.value["extensions"]["KHR_lights_punctual"]["lights"][index];
        let separator = if node.is_empty() { "" } else { ", " };
        let label = match &light.name {
            Some(name) => format!("{node}{separator}light {index} \"{name}\""),
            None => format!("{node}{separator}light {index}"),
        };
        if light.range.is_some() {
            self.warnings.add(&label, "range is ignored, light fades with distance alone");
        }
        let body = Body::of(value, &label, &LIGHT)?;
        let kind = falling(wide(kind(light, &label)?, &body)?, &body)?;
        let color = body.emission("emission", document)?;
        let color = color.unwrap_or(Spectrum::Rgb(light.color));
        let stokes = body.stokes("stokes")?;
        let luminaire = luminaire_of(&body, document)?;
        let projection = projection_of(&body, document)?;
        if let Some(luminaire) = &luminaire {
            self.doubt(luminaire, &body.field("ies"));
        }
        let intensity = color.scaled(light.intensity * unit(&body)?);
        let light = Punctual { kind, intensity };
        let put = if light.intensity.values().iter().all(|value| *value == 0.0) {
            light.check()
        } else {
            let put = self.world.put_light(Name(label.clone()), light, place);
            put.and_then(|light| {
                luminaire.map_or(Ok(()), |it| self.world.put_luminaire(light, it))?;
                projection.map_or(Ok(()), |it| self.world.put_projection(light, it))?;
                match stokes {
                    Some(stokes) => self.world.put_stokes(light, stokes),
                    None => Ok(()),
                }
            })
        };
        put.map_err(|fault| match fault.field.as_str() {
            "ies" | "picture" => SceneError::at(&body.field(&fault.field), fault.of("")),
            "intensity" => {
                let color = if body.has("emission") { "emission" } else { "color" };
                SceneError::at(&label, fault.of(format!("intensity times {color}, in watts")))
            }
            _ => SceneError::at(&label, fault),
        })
    }
}

/// The picture that a light throws.
fn projection_of(body: &Body, document: &Document) -> Result<Option<Projection>, SceneError> {
    let Some(uri) = body.word("picture")? else { return Ok(None) };
    Ok(Some(Projection(document.picture_around(uri, &body.field("picture"))?)))
}

fn kind(light: &Light, label: &str) -> Result<PunctualKind, SceneError> {
    match light.type_ {
        Checked::Valid(Type::Point) => Ok(PunctualKind::Point),
        Checked::Valid(Type::Directional) => Ok(PunctualKind::Directional),
        Checked::Valid(Type::Spot) => {
            let spot = light.spot.clone().unwrap_or_default();
            // A right angle is a little larger as an `f32`.
            let angle = |angle: f32| match f64::from(angle) {
                angle if angle <= FRAC_PI_2 + 1e-6 => angle.min(FRAC_PI_2),
                angle => angle,
            };
            let (inner, outer) = (angle(spot.inner_cone_angle), angle(spot.outer_cone_angle));
            Ok(PunctualKind::Spot { inner, outer, falloff: Falloff::default() })
        }
        Checked::Invalid => {
            let remedy = "use point, spot or directional";
            Err(SceneError::new(format!("{label}, type"), "is not known", remedy))
        }
    }
}

/// A direction that takes up an angle, if it says so: a sun.
fn wide(kind: PunctualKind, body: &Body) -> Result<PunctualKind, SceneError> {
    const KEY: &str = "angular_diameter_deg";
    let Some(degrees) = body.number(KEY)? else { return Ok(kind) };
    match kind {
        // Which is what zero says.
        PunctualKind::Directional if degrees == 0.0 => Ok(kind),
        PunctualKind::Directional if PunctualKind::is_diameter(degrees.to_radians()) => {
            Ok(PunctualKind::Sun { diameter: degrees.to_radians() })
        }
        PunctualKind::Directional => {
            let problem = format!("is {degrees} degrees");
            let remedy = "from 0.0006 to less than 180; 0, or without it, is a direction";
            Err(SceneError::new(body.field(KEY), problem, remedy))
        }
        PunctualKind::Point | PunctualKind::Spot { .. } | PunctualKind::Sun { .. } => {
            let problem = "is for directional lights";
            Err(SceneError::new(body.field(KEY), problem, "remove it, or use such a light"))
        }
    }
}

/// A spot that falls off as it says.
fn falling(kind: PunctualKind, body: &Body) -> Result<PunctualKind, SceneError> {
    const KEY: &str = "falloff";
    let Some(name) = body.word(KEY)? else { return Ok(kind) };
    let refuse = |problem: &str, remedy: &str| SceneError::new(body.field(KEY), problem, remedy);
    let found = Falloff::ALL.into_iter().find(|falloff| falloff.name() == name);
    let falloff = found.ok_or_else(|| refuse("is not known", "use \"cosine\" or \"angle\""))?;
    match kind {
        PunctualKind::Spot { inner, outer, .. } => Ok(PunctualKind::Spot { inner, outer, falloff }),
        PunctualKind::Point | PunctualKind::Directional | PunctualKind::Sun { .. } => {
            Err(refuse("is for spots", "remove it, or make the light a spot"))
        }
    }
}

/// What intensities are multiplied with to have them in radiometric units.
fn unit(body: &Body) -> Result<f32, SceneError> {
    match body.word("units")? {
        Some("radiometric") => Ok(1.0),
        Some("photometric") | None => Ok(1.0 / LUMENS_PER_WATT),
        Some(other) => {
            let problem = format!("`{other}` is not a system of units");
            let remedy = "use \"photometric\" (candela, lux) or \"radiometric\" (W/sr, W/m^2)";
            Err(SceneError::new(body.field("units"), problem, remedy))
        }
    }
}
