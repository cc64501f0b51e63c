//! Luminaires that are measured: files of IES LM-63, by a key of point lights, or as EXT_lights_ies
//! has them.

use std::sync::Arc;

use serde_json::Value;

use super::Import;
use super::document::Document;
use super::extension::Body;
use super::lights::LUMENS_PER_WATT;
use crate::math::Fault;
use crate::scene::error::SceneError;
use crate::scene::world::{Luminaire, Name, Photometry, Punctual, Transform};
use crate::spectrum::Spectrum;

/// How glTF states them.
pub const EXT_LIGHTS: &str = "EXT_lights_ies";

/// What a light emits by direction, of the file that it names.
pub fn luminaire_of(body: &Body, document: &Document) -> Result<Option<Luminaire>, SceneError> {
    let Some(uri) = body.word("ies")? else { return Ok(None) };
    let field = body.field("ies");
    let bytes = document.read_bytes(uri, &field)?;
    read(&bytes, &field).map(Some)
}

/// What is not ASCII is in the words of a file, which do not count.
fn read(bytes: &[u8], field: &str) -> Result<Luminaire, SceneError> {
    let read = Photometry::from_ies(&String::from_utf8_lossy(bytes));
    let read = read.map_err(|Fault { field: part, problem, remedy }| {
        let separator = if part.is_empty() { "" } else { ", " };
        SceneError::new(format!("{field}{separator}{part}"), problem, remedy)
    })?;
    Ok(Luminaire(Arc::new(read)))
}

impl Import<'_> {
    /// Says what is doubtful about the file of a luminaire.
    pub fn doubt(&mut self, Luminaire(photometry): &Luminaire, place: &str) {
        photometry.doubts().iter().for_each(|doubt| self.warnings.add(place, doubt));
    }

    /// Adds the luminaire of a node, if the extension has one there.
    pub fn add_luminaire(
        &mut self,
        node: &Value,
        label: &str,
        place: Transform,
    ) -> Result<(), SceneError> {
        let own = &node["extensions"][EXT_LIGHTS];
        if !own.is_object() {
            return Ok(());
        }
        let label = format!("{label}, {EXT_LIGHTS}");
        let profiles = &self.document.value["extensions"][EXT_LIGHTS]["lights"];
        let profile = own["light"].as_u64().and_then(|index| profiles.get(index as usize));
        let Some(profile) = profile else {
            let count = profiles.as_array().map_or(0, Vec::len);
            let problem = format!("is not an index into the file's {count} profiles");
            return Err(SceneError::new(format!("{label}, light"), problem, "export it again"));
        };
        let luminaire = read(&self.document.image_bytes(profile, &label)?, &label)?;
        self.doubt(&luminaire, &label);
        let number = |value: &Value, by_default: f64| {
            if value.is_null() { Some(by_default) } else { value.as_f64() }
        };
        let of_color = |index: usize| number(&own["color"][index], 1.0);
        let numbers = [number(&own["multiplier"], 1.0), of_color(0), of_color(1), of_color(2)];
        let [Some(multiplier), Some(red), Some(green), Some(blue)] = numbers else {
            let remedy = "write a multiplier and [red, green, blue]";
            return Err(SceneError::new(label, "has no sound multiplier or color", remedy));
        };
        let color = Spectrum::Rgb([red, green, blue].map(|it| it as f32));
        let light = Punctual::point(color.scaled(multiplier as f32 / LUMENS_PER_WATT));
        if light.intensity.values().iter().all(|value| *value == 0.0) {
            return Ok(());
        }
        let put = self.world.put_light(Name(label.clone()), light, place);
        let put = put.and_then(|light| self.world.put_luminaire(light, luminaire));
        put.map_err(|fault| SceneError::at(&label, fault.of("multiplier times color")))
    }
}
