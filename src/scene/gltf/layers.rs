//! What plain glTF says of materials beyond metallic-roughness: each a number or a color, times a
//! texture.

use serde_json::{Value, json};

use super::Import;
use super::textures::Slot;
use crate::image::texels::Coding;
use crate::math::Range;
use crate::scene::error::{Findings, SceneError};
use crate::scene::world::{Bsdf, Layers, Paint, Parameter, Reads};
use crate::spectrum::Spectrum;

const CLEARCOAT: &str = "KHR_materials_clearcoat";
const DIFFUSE_TRANSMISSION: &str = "KHR_materials_diffuse_transmission";
const SHEEN: &str = "KHR_materials_sheen";
const SPECULAR: &str = "KHR_materials_specular";
const TRANSMISSION: &str = "KHR_materials_transmission";
/// Greatest index of refraction of facets.
const IOR_MAX: f32 = 10.0;

/// One of the numbers or colors.
struct Layer {
    extension: &'static str,
    factor: &'static str,
    texture: &'static str,
    /// Where there is no factor.
    default: f32,
    parameter: Parameter,
    /// What of the texture counts.
    reads: Reads,
    coding: Coding,
    /// Where it is kept.
    at: At,
}

/// The place of a factor in layers.
enum At {
    Number(fn(&mut Layers<Spectrum>) -> &mut f32),
    /// Of the root of it.
    Root(fn(&mut Layers<Spectrum>) -> &mut f32),
    Color(fn(&mut Layers<Spectrum>) -> &mut Spectrum),
}

/// All of them.
const LAYERS: [Layer; 9] = [
    Layer {
        extension: TRANSMISSION,
        factor: "transmissionFactor",
        texture: "transmissionTexture",
        default: 0.0,
        parameter: Parameter::Transmission,
        reads: Reads::Red,
        coding: Coding::Linear,
        at: At::Number(|layers| &mut layers.transmission),
    },
    Layer {
        extension: DIFFUSE_TRANSMISSION,
        factor: "diffuseTransmissionFactor",
        texture: "diffuseTransmissionTexture",
        default: 0.0,
        parameter: Parameter::DiffuseTransmission,
        reads: Reads::Alpha,
        coding: Coding::Linear,
        at: At::Number(|layers| &mut layers.diffuse_transmission),
    },
    Layer {
        extension: DIFFUSE_TRANSMISSION,
        factor: "diffuseTransmissionColorFactor",
        texture: "diffuseTransmissionColorTexture",
        default: 1.0,
        parameter: Parameter::DiffuseTransmissionColor,
        reads: Reads::Color,
        coding: Coding::Srgb,
        at: At::Color(|layers| &mut layers.diffuse_transmission_color),
    },
    Layer {
        extension: CLEARCOAT,
        factor: "clearcoatFactor",
        texture: "clearcoatTexture",
        default: 0.0,
        parameter: Parameter::Coat,
        reads: Reads::Red,
        coding: Coding::Linear,
        at: At::Number(|layers| &mut layers.coat),
    },
    Layer {
        extension: CLEARCOAT,
        factor: "clearcoatRoughnessFactor",
        texture: "clearcoatRoughnessTexture",
        default: 0.0,
        parameter: Parameter::CoatRoughness,
        reads: Reads::Green,
        coding: Coding::Linear,
        at: At::Root(|layers| &mut layers.coat_alpha),
    },
    Layer {
        extension: SHEEN,
        factor: "sheenColorFactor",
        texture: "sheenColorTexture",
        default: 0.0,
        parameter: Parameter::ClothColor,
        reads: Reads::Color,
        coding: Coding::Srgb,
        at: At::Color(|layers| &mut layers.cloth_color),
    },
    Layer {
        extension: SHEEN,
        factor: "sheenRoughnessFactor",
        texture: "sheenRoughnessTexture",
        default: 0.0,
        parameter: Parameter::ClothRoughness,
        reads: Reads::Alpha,
        coding: Coding::Linear,
        at: At::Root(|layers| &mut layers.cloth_alpha),
    },
    Layer {
        extension: SPECULAR,
        factor: "specularFactor",
        texture: "specularTexture",
        default: 1.0,
        parameter: Parameter::Specular,
        reads: Reads::Alpha,
        coding: Coding::Linear,
        at: At::Number(|layers| &mut layers.specular),
    },
    Layer {
        extension: SPECULAR,
        factor: "specularColorFactor",
        texture: "specularColorTexture",
        default: 1.0,
        parameter: Parameter::SpecularColor,
        reads: Reads::Color,
        coding: Coding::Srgb,
        at: At::Color(|layers| &mut layers.specular_color),
    },
];

/// The names of the textures.
pub const TEXTURES: [&str; LAYERS.len()] = {
    let mut names = [""; LAYERS.len()];
    let mut row = 0;
    while row < names.len() {
        names[row] = LAYERS[row].texture;
        row += 1;
    }
    names
};

/// Where glTF has a parameter of layers and its texture.
pub struct Place {
    pub extension: &'static str,
    pub factor: &'static str,
    pub texture: &'static str,
    /// What of the texture counts.
    pub reads: Reads,
    pub coding: Coding,
}

/// The place of a parameter, if it is one of layers that metallic-roughness has not.
pub fn place_of(parameter: Parameter) -> Option<Place> {
    let of = LAYERS.iter().find(|of| of.parameter == parameter)?;
    let &Layer { extension, factor, texture, reads, coding, .. } = of;
    Some(Place { extension, factor, texture, reads, coding })
}

/// What a material says of the textures of layers.
pub fn infos(material: &Value) -> impl Iterator<Item = &Value> {
    LAYERS.iter().map(|of| &material["extensions"][of.extension][of.texture])
}

/// Whether a material says more than metallic-roughness, glass and a share of what facets reflect.
pub fn says_more(material: &Value, layers: &Layers<Spectrum>) -> bool {
    let is_lit = layers.diffuse_transmission > 0.0 || layers.coat > 0.0;
    let has = |color: &Spectrum, none: f32| color.values().iter().any(|value| *value != none);
    let of_specular = LAYERS.iter().filter(|of| of.extension == SPECULAR);
    let is_painted = of_specular
        .map(|of| &material["extensions"][of.extension][of.texture])
        .any(|texture| !texture.is_null());
    is_lit || has(&layers.cloth_color, 0.0) || has(&layers.specular_color, 1.0) || is_painted
}

/// Whether the share of a wall differs from place to place.
pub fn has_painted_wall(material: &Value) -> bool {
    !material["extensions"][TRANSMISSION]["transmissionTexture"].is_null()
}

impl Import<'_> {
    /// Adds what a material says beyond metallic-roughness.
    pub fn read_layers(
        &mut self,
        layers: &mut Layers<Spectrum>,
        material: &Value,
        label: &str,
    ) -> Result<(), SceneError> {
        let mut findings = Findings::default();
        for of in &LAYERS {
            let body = &material["extensions"][of.extension];
            if body.is_null() {
                continue;
            }
            let place = format!("{label}, {}.{}", of.extension, of.factor);
            let value = &body[of.factor];
            let unit = |number: f32| {
                let checked = Range::UNIT.check("", number);
                checked.map(|()| number).map_err(|fault| SceneError::at(&place, fault))
            };
            match of.at {
                At::Number(field) => {
                    let read = number(value, of.default, &place).and_then(unit);
                    findings.note(read.map(|number| *field(layers) = number));
                }
                At::Root(field) => {
                    let read = number(value, of.default, &place).and_then(unit);
                    findings.note(read.map(|number| *field(layers) = number * number));
                }
                At::Color(field) => {
                    let read = color(value, of.default, &place);
                    let Some(mut color) = findings.note(read) else { continue };
                    if of.parameter == Parameter::SpecularColor {
                        color = self.brightened(layers, color, label);
                    }
                    for channel in color {
                        findings.note(unit(channel));
                    }
                    *field(layers) = Spectrum::Rgb(color);
                }
            }
        }
        let normal = &material["extensions"][CLEARCOAT]["clearcoatNormalTexture"];
        if layers.coat > 0.0 && !normal.is_null() {
            let text = "clearcoatNormalTexture is ignored: the coat follows the base";
            self.warnings.add_like("coat normals", label, text);
        }
        findings.result()
    }

    /// The share of what facets reflect that is there, of a color which may be more than 1: then
    /// they are of a greater index of refraction, of which all is there.
    fn brightened(
        &mut self,
        layers: &mut Layers<Spectrum>,
        color: [f32; 3],
        label: &str,
    ) -> [f32; 3] {
        let most = color.into_iter().fold(1.0, f32::max);
        if !(most > 1.0 && most.is_finite()) {
            return color;
        }
        // The root of what is reflected at normal incidence.
        let root = most.sqrt() * (layers.ior - 1.0) / (layers.ior + 1.0);
        let root_max = (IOR_MAX - 1.0) / (IOR_MAX + 1.0);
        if root > root_max {
            let text = format!(
                "specularColorFactor asks for more than facets of index {IOR_MAX} reflect, and \
                 gets that"
            );
            self.warnings.add_like("specular color", label, &text);
        }
        let root = root.min(root_max);
        layers.ior = (1.0 + root) / (1.0 - root);
        color.map(|channel| channel / most)
    }

    /// The textures of layers; none of other models.
    pub fn paint_layers(
        &mut self,
        bsdf: &Bsdf,
        material: &Value,
        label: &str,
    ) -> Result<Vec<(Parameter, Paint)>, SceneError> {
        let Bsdf::Layered { layers } = bsdf else { return Ok(Vec::new()) };
        let mut findings = Findings::default();
        let mut painted = Vec::new();
        let mut layers = layers.clone();
        for of in &LAYERS {
            let slot = Slot {
                info: &material["extensions"][of.extension][of.texture],
                label: format!("{label}, {}", of.texture),
                coding: of.coding,
                more: &[],
            };
            let Some(texture) = findings.note(self.texture(&slot)).flatten() else { continue };
            let factor = match of.at {
                At::Number(field) => [*field(&mut layers); 3],
                At::Root(field) => [field(&mut layers).sqrt(); 3],
                // Those of glTF are.
                At::Color(field) => field(&mut layers).rgb().unwrap_or([1.0; 3]),
            };
            let texture = Some(texture);
            let paint = Paint { factor, texture, reads: of.reads, by_vertices: false };
            painted.push((of.parameter, paint));
        }
        findings.result().map(|()| painted)
    }
}

/// Writes layers as glTF's own extensions into a material; `color` says what is red, green and blue
/// of a spectrum.
pub fn write_layers(
    layers: &Layers<Spectrum>,
    material: &mut Value,
    mut color: impl FnMut(&Spectrum) -> [f32; 3],
) {
    let [red, green, blue] = color(&layers.base_color);
    material["pbrMetallicRoughness"] = json!({"baseColorFactor": [red, green, blue, 1.0],
        "metallicFactor": layers.metallic, "roughnessFactor": layers.alpha.sqrt()});
    let mut layers = layers.clone();
    let mut extensions = json!({"KHR_materials_ior": {"ior": layers.ior}});
    for of in &LAYERS {
        extensions[of.extension][of.factor] = match of.at {
            At::Number(field) => json!(*field(&mut layers)),
            At::Root(field) => json!(field(&mut layers).sqrt()),
            At::Color(field) => json!(color(field(&mut layers))),
        };
    }
    material["extensions"] = extensions;
}

/// A number, or what stands for it.
fn number(value: &Value, default: f32, place: &str) -> Result<f32, SceneError> {
    match value {
        Value::Null => Ok(default),
        value => value
            .as_f64()
            .map(|number| number as f32)
            .ok_or_else(|| SceneError::new(place, "must be a number", "within [0, 1]")),
    }
}

/// Red, green and blue, or what stands for each.
fn color(value: &Value, default: f32, place: &str) -> Result<[f32; 3], SceneError> {
    if value.is_null() {
        return Ok([default; 3]);
    }
    let channels = value.as_array().into_iter().flatten();
    let channels: Vec<f32> =
        channels.filter_map(|it| it.as_f64().map(|number| number as f32)).collect();
    <[f32; 3]>::try_from(channels)
        .map_err(|_| SceneError::new(place, "is not three numbers", "give red, green and blue"))
}
