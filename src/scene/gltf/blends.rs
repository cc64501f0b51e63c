//! Blends: materials whose models are mixtures of those of two others.

use serde_json::{Value, json};

use super::Import;
use super::extension::{Body, EXTENSION, MATERIAL};
use crate::scene::error::SceneError;
use crate::scene::world::{BLEND_DEPTH, Bsdf, Paint, Parameter, Textures};

/// The value of `bsdf`.
pub const BLEND: &str = "blend";
/// Its keys.
pub const KEYS: [&str; 4] = ["first", "second", "weight", "weight_texture"];
/// Those that name its parts.
const PARTS: [&str; 2] = ["first", "second"];

impl Import<'_> {
    /// The blend of a material.
    pub fn blend(&mut self, index: usize, body: &Body) -> Result<Bsdf, SceneError> {
        if let Some(at) = self.blending.iter().position(|known| *known == index) {
            let label = self.document.label("materials", self.blending[at]);
            return Err(SceneError::new(label, "is a part of itself", "blend other materials"));
        }
        if self.blending.len() == BLEND_DEPTH {
            let problem = format!("there are more than {BLEND_DEPTH} blends within each other");
            return Err(SceneError::new(body.label(), problem, "blend fewer"));
        }
        self.blending.push(index);
        let parts = PARTS.map(|key| self.part(body, key));
        self.blending.pop();
        let [first, second] = parts;
        let weight = body.number("weight")?;
        let weight = match (weight, body.has("weight_texture")) {
            (Some(weight), _) => weight as f32,
            (None, true) => 1.0,
            (None, false) => {
                return Err(body.missing("weight", "the share of the second, within [0, 1]"));
            }
        };
        let bsdf = Bsdf::Blend { parts: Box::new([first?, second?]), weight };
        bsdf.check().map_err(|fault| body.place(fault))?;
        Ok(bsdf)
    }

    /// The model of the material that a key names.
    fn part(&mut self, body: &Body, key: &str) -> Result<Bsdf, SceneError> {
        let index = self.part_index(body, key)?;
        let label = self.document.label("materials", index);
        let bsdf = self.bsdf(index, &label)?;
        if self.emission(index, &label)?.is_some() {
            let text = "emits, and is part of a blend, of which only its own emission counts";
            self.warnings.add_like("parts that emit", &label, text);
        }
        let (bsdf, is_facets) = bsdf.into_part();
        if is_facets {
            let text = "is smooth metal, which is of facets of alpha 0.001 as part of a blend";
            self.warnings.add_like("smooth parts", &label, text);
        }
        let place = format!("{} ({label})", body.field(key));
        bsdf.check_part().map_err(|fault| SceneError::at(&place, fault))?;
        Ok(bsdf)
    }

    /// The index of a material that is named by it, or by its name.
    fn part_index(&self, body: &Body, key: &str) -> Result<usize, SceneError> {
        let materials = self.document.value["materials"].as_array().map_or(&[][..], |all| all);
        let Some((value, field)) = body.value(key) else {
            return Err(body.missing(key, "a material of the file: its index, or its name"));
        };
        let Some(name) = value.as_str() else {
            let index = body.index(key, "materials", materials.len())?;
            return index.ok_or_else(|| body.missing(key, "a material of the file"));
        };
        let mut named = (0..materials.len()).filter(|at| materials[*at]["name"] == name);
        match (named.next(), named.next()) {
            (Some(index), None) => Ok(index),
            (Some(_), Some(_)) => {
                let problem = format!("several materials are called `{name}`");
                Err(SceneError::new(field, problem, "give its index, or each a name"))
            }
            (None, _) => {
                let problem = format!("no material of the file is called `{name}`");
                Err(SceneError::new(field, problem, "give its index, or its name"))
            }
        }
    }

    /// The textures of a blend and of its parts.
    pub fn paint_blend(
        &mut self,
        textures: &mut Textures,
        (index, label): (usize, &str),
        bsdf: &Bsdf,
    ) -> Result<(), SceneError> {
        let Bsdf::Blend { parts, weight } = bsdf else { return Ok(()) };
        let document = self.document;
        let body = Body::of(&document.value["materials"][index], label, &MATERIAL)?;
        if let Some((texture, reads)) = self.own_texture((&body, "weight_texture"))? {
            let (factor, texture) = ([*weight; 3], Some(texture));
            let paint = Paint { factor, texture, reads, by_vertices: false };
            textures.parameters.push((Parameter::Weight, paint));
        }
        let mut found = Vec::new();
        self.blending.push(index);
        for (key, part) in PARTS.into_iter().zip(parts.iter()) {
            let of = self.part_index(&body, key)?;
            let label = document.label("materials", of);
            let textures = self.textures(Some(of), &label, (part, None))?;
            let Textures { relief, coverage, stain, .. } = &textures;
            if relief.is_some() || coverage.is_some() || stain.is_some() {
                let problem = "has a normal map, holes or a color of its metal, and parts of \
                               blends have none of their own";
                let place = format!("{} ({label})", body.field(key));
                return Err(SceneError::new(place, problem, "give them to the blend"));
            }
            found.push(textures);
        }
        self.blending.pop();
        if found.iter().any(|textures| !textures.is_empty()) {
            textures.parts = found;
        }
        Ok(())
    }
}

/// What [`Import::blend`] reads; `place` writes a part, with the key that names it, as a material,
/// and says its index.
pub fn written(
    parts: &[Bsdf; 2],
    weight: f32,
    mut place: impl FnMut(&Bsdf, &str) -> usize,
) -> Value {
    let mut body = json!({"bsdf": BLEND, "weight": weight});
    for (part, key) in parts.iter().zip(PARTS) {
        body[key] = json!(place(part, key));
    }
    body
}

/// The parts of a blend, and the places that [`written`] says in its material; of others, none.
pub fn parts<'a>(
    bsdf: &'a Bsdf,
    material: &Value,
) -> impl Iterator<Item = (&'a Bsdf, usize)> + use<'a> {
    let body = &material["extensions"][EXTENSION];
    let places = PARTS.map(|key| body[key].as_u64().map(|index| index as usize));
    let parts = if let Bsdf::Blend { parts, .. } = bsdf { &parts[..] } else { &[] };
    parts.iter().zip(places).filter_map(|(part, place)| Some((part, place?)))
}
