//! Textures: pictures out of files, data URIs and buffer views, and what of a material they feed.
//!
//! Base color and emission are sRGB, all else is linear, and so is OpenEXR; colors of vertices
//! multiply base color. `alphaMode` MASK and BLEND make holes. Occlusion maps darken what light
//! leaves dark by itself, and are not used.

use std::collections::{BTreeSet, HashMap};
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;
use serde_json::Value;

use super::Import;
use super::document::Document;
use super::extension::{Body, COVERAGE, EXTENSION, MATERIAL, TEXTURE};
use super::films;
use super::gloss;
use super::layers;
use super::materials::{KHR_GLOSSY, KHR_UNLIT};
use super::own_textures::{BUMP_TEXTURE, own_words};
use super::stains::{self, BaseColor};
use crate::image::texels::Coding;
use crate::math::elementary::sin_cos;
use crate::math::text::listed;
use crate::scene::error::{Findings, SceneError};
use crate::scene::world::{
    Bsdf, Coverage, Emission, Filter, Layers, Paint, Parameter, Picture, Reads, Relief,
    ReliefFrame, ReliefOf, Stain, Texture, Textures, Wrap, half_hash,
};

/// The key of shares of metal and roughness.
const METAL: &str = "metallicRoughnessTexture";
/// `alphaCutoff` of materials that do not say.
const CUTOFF: f32 = 0.5;

/// What has been decoded for the worlds of a file, by what its JSON says of each image.
#[derive(Default)]
pub struct Pictures(Mutex<HashMap<u128, Result<Arc<Picture>, SceneError>>>);

impl Document {
    /// The picture of an image, decoded once.
    fn picture(&self, image: usize) -> Result<Arc<Picture>, SceneError> {
        let key = half_hash(self.value["images"][image].to_string().as_bytes());
        let lock = || self.pictures.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = lock().get(&key) {
            return known.clone();
        }
        let decoded = self.decoded(image).map(Arc::new);
        lock().entry(key).or_insert(decoded).clone()
    }

    /// The picture of what is around the scene, decoded once.
    pub fn picture_around(&self, uri: &str, field: &str) -> Result<Arc<Picture>, SceneError> {
        let bytes = self.bytes_of(uri, field)?;
        let key = half_hash(&bytes);
        let lock = || self.pictures.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(Ok(known)) = lock().get(&key) {
            return Ok(Arc::clone(known));
        }
        let picture = Arc::new(Picture::around(&bytes, field)?);
        lock().insert(key, Ok(Arc::clone(&picture)));
        Ok(picture)
    }

    fn decoded(&self, image: usize) -> Result<Picture, SceneError> {
        let label = self.label("images", image);
        let bytes = self.image_bytes(&self.value["images"][image], &label)?;
        Picture::decoded(&bytes, &label)
    }
}

/// A texture of a material, as the file has it.
pub struct Slot<'a> {
    /// What the material says of it.
    pub info: &'a Value,
    /// What errors call it.
    pub label: String,
    /// What its numbers mean, unless it says so itself.
    pub coding: Coding,
    /// What else it may say, by keys of the extension.
    pub more: &'static [&'static str],
}

impl Import<'_> {
    /// What of a material differs from place to place; `bsdf` and `emission` are what it is without
    /// that.
    pub fn textures(
        &mut self,
        index: Option<usize>,
        label: &str,
        of: (&Bsdf, Option<&Emission>),
    ) -> Result<Textures, SceneError> {
        let mut textures = self.own_textures(index, label, of)?;
        if let Some(index) = index {
            self.paint_blend(&mut textures, (index, label), of.0)?;
            self.paint_grain(&mut textures, (index, label), of.0)?;
            self.paint_film(&mut textures, (index, label), of.0)?;
        }
        Ok(textures)
    }

    /// The same without those of parts.
    fn own_textures(
        &mut self,
        index: Option<usize>,
        label: &str,
        (bsdf, emission): (&Bsdf, Option<&Emission>),
    ) -> Result<Textures, SceneError> {
        let document = self.document;
        let material = index.map_or(&Value::Null, |index| &document.value["materials"][index]);
        self.warn_of_unread(material, label);
        let mut textures = Textures::default();
        let mut findings = Findings::default();
        let slot = |info, key: &str, coding| Slot {
            info,
            label: format!("{label}, {key}"),
            coding,
            more: &[],
        };
        let glossy = &material["extensions"][KHR_GLOSSY];
        let [base, metal] = match glossy.is_object() {
            true => findings.note(self.glossy_textures(glossy, label)).unwrap_or_default(),
            false => {
                let mut of = |key, coding| {
                    let info = &material["pbrMetallicRoughness"][key];
                    findings.note(self.texture(&slot(info, key, coding))).flatten()
                };
                [of("baseColorTexture", Coding::Srgb), of(METAL, Coding::Linear)]
            }
        };
        let by_vertices = self.colors_of(index);
        let is_unlit = material["extensions"][KHR_UNLIT].is_object();
        self.paint_color(&mut textures, (&base, by_vertices), (is_unlit, bsdf, emission), label);
        let body = Body::of(material, label, &MATERIAL)?;
        let color = BaseColor {
            factor: stains::color_of(material),
            texture: base.clone(),
            by_vertices: by_vertices.is_some(),
        };
        textures.stain = findings.note(self.stain(&body, color, (bsdf, label))).unwrap_or_default();
        textures.coverage = match body.object("coverage", &COVERAGE)? {
            Some(own) => findings.note(self.own_coverage(&own)),
            None => self.coverage(material, (label, bsdf), base, by_vertices),
        };
        if let Some(texture) = metal {
            let paints = metal_and_roughness(bsdf, texture);
            if paints.is_empty() {
                let text = "metallicRoughnessTexture is ignored: the model has no roughness";
                self.warnings.add(label, text);
            }
            textures.parameters.extend(paints);
        }
        if body.has("alpha_texture") {
            let paint = findings.note(self.alpha(&body, bsdf));
            textures.parameters.extend(paint.map(|paint| (Parameter::Alpha, paint)));
        }
        let layers = findings.note(self.paint_layers(bsdf, material, label));
        textures.parameters.extend(layers.into_iter().flatten());
        let glow = &material["emissiveTexture"];
        let glow = self.texture(&slot(glow, "emissiveTexture", Coding::Srgb));
        let glow = findings.note(glow).flatten();
        if let (false, Some(texture), Some(emission)) = (is_unlit, glow, emission) {
            textures.emission = findings.note(painted_emission(texture, emission, label));
        }
        let relief = self.relief(&material["normalTexture"], &body, (bsdf, label));
        textures.relief = findings.note(relief).flatten();
        findings.result()?;
        Ok(textures)
    }

    /// The color by a picture and by vertices, if either is there: that of a model, or of what
    /// emits it.
    fn paint_color(
        &mut self,
        textures: &mut Textures,
        (base, by_vertices): (&Option<Texture>, Option<bool>),
        (is_unlit, bsdf, emission): (bool, &Bsdf, Option<&Emission>),
        label: &str,
    ) {
        if let (true, Bsdf::Absorber, Some(factor)) =
            (is_unlit, bsdf, emission.and_then(|emission| emission.radiance.rgb()))
        {
            let (texture, by_vertices) = (base.clone(), by_vertices.is_some());
            if texture.is_some() || by_vertices {
                let paint = Paint { factor, texture, reads: Reads::Color, by_vertices };
                textures.emission = Some(paint);
            }
        } else if base.is_some() || by_vertices.is_some() {
            match color_of(bsdf) {
                Some((parameter, factor)) => {
                    let (texture, by_vertices) = (base.clone(), by_vertices.is_some());
                    let paint = Paint { factor, texture, reads: Reads::Color, by_vertices };
                    textures.parameters.push((parameter, paint));
                }
                None if Stain::goes_with(bsdf)[1] => {}
                None => {
                    let text = "color by textures and vertices is ignored: the model has none";
                    self.warnings.add_like("color by textures", label, text);
                }
            }
        }
    }

    /// A picture of normals, or of heights, if there is one. Any exporter may write normals; who
    /// states heights means them.
    fn relief(
        &mut self,
        info: &Value,
        body: &Body,
        (bsdf, label): (&Bsdf, &str),
    ) -> Result<Option<Relief>, SceneError> {
        let normals = self.normals(info, label)?;
        let heights = self.heights(body)?;
        if !Textures::may_bend(bsdf) {
            if heights.is_some() {
                let model = body.word("bsdf")?.unwrap_or("sheet");
                let problem = format!("means nothing for a {model}, which has no normals to bend");
                return Err(SceneError::new(body.field(BUMP_TEXTURE), problem, "take it away"));
            }
            if normals.is_some() {
                let text = "normalTexture is ignored: sheets and null have no normals to bend";
                self.warnings.add_like("normals of sheets", label, text);
            }
            return Ok(None);
        }
        if normals.is_some() && heights.is_some() {
            let problem = "and normalTexture exclude each other";
            let field = body.field(BUMP_TEXTURE);
            return Err(SceneError::new(field, problem, "take one of them away"));
        }
        Ok(normals.or(heights))
    }

    fn normals(&mut self, info: &Value, label: &str) -> Result<Option<Relief>, SceneError> {
        let slot = Slot {
            info,
            label: format!("{label}, normalTexture"),
            coding: Coding::Linear,
            more: &["frame"],
        };
        let Some(texture) = self.texture(&slot)? else { return Ok(None) };
        self.doubt_normals(&texture, label);
        let scale = slot.info["scale"].as_f64().unwrap_or(1.0) as f32;
        let own = Body::of(slot.info, &slot.label, &TEXTURE)?;
        let frame = match own.word("frame")? {
            None | Some("picture") => ReliefFrame::Picture,
            Some("mesh") => ReliefFrame::Mesh,
            Some(_) => {
                let remedy = "use \"picture\" or \"mesh\"";
                return Err(SceneError::new(own.field("frame"), "is no frame", remedy));
            }
        };
        Ok(Some(Relief { texture, scale, of: ReliefOf::Normals(frame) }))
    }

    /// Says that a normal map is none, where it is so.
    fn doubt_normals(&mut self, texture: &Texture, label: &str) {
        let astray = texture.picture.normals_astray();
        if astray == 0 {
            return;
        }
        let [width, height] = texture.picture.texels().size().map(u64::from);
        let text = format!(
            "has texels without a normal, or with one that points into the surface ({astray} of \
             {}): what they show is bent to the front; is it a normal map?",
            width * height
        );
        let place = format!("{label}, normalTexture");
        self.warnings.add_like("normals astray", &place, &text);
    }

    /// The holes of a material, if it has any.
    fn coverage(
        &mut self,
        material: &Value,
        (label, bsdf): (&str, &Bsdf),
        base: Option<Texture>,
        by_vertices: Option<bool>,
    ) -> Option<Coverage> {
        let cutoff = match material["alphaMode"].as_str() {
            Some("MASK") => Some(material["alphaCutoff"].as_f64().map_or(CUTOFF, |it| it as f32)),
            Some("BLEND") => None,
            // Alpha counts for nothing.
            Some(_) | None => return None,
        };
        let glossy = &material["extensions"][KHR_GLOSSY];
        let alpha = &material["pbrMetallicRoughness"]["baseColorFactor"][3];
        let factor = match glossy.is_object() {
            true => gloss::alpha(glossy),
            false => alpha.as_f64().unwrap_or(1.0) as f32,
        };
        let texture = base.filter(|texture| texture.picture.least_alpha() < 1.0);
        let by_vertices = by_vertices == Some(true);
        let is_even = texture.is_none() && !by_vertices;
        let paint = Paint { factor: [factor; 3], texture, reads: Reads::Alpha, by_vertices };
        let coverage = Coverage { paint, cutoff };
        if is_even && coverage.of(factor) == 1.0 {
            return None;
        }
        if !Textures::may_have_holes(bsdf) {
            // Models of our own have an alpha that is even for viewers which know none of them.
            let has_own =
                || Body::of(material, label, &MATERIAL).is_ok_and(|body| body.has("bsdf"));
            if is_even && has_own() {
                return None;
            }
            let text = "alpha is ignored: light goes through the glass anyway";
            self.warnings.add_like("alpha", label, text);
            return None;
        }
        Some(coverage)
    }

    /// A texture with its picture.
    pub fn texture(&mut self, slot: &Slot) -> Result<Option<Texture>, SceneError> {
        if slot.info.is_null() {
            return Ok(None);
        }
        self.decode_all();
        let document = self.document;
        let refuse = |problem: &str, remedy: &str| SceneError::new(&slot.label, problem, remedy);
        let textures = &document.value["textures"];
        let texture = slot.info["index"].as_u64().and_then(|index| textures.get(index as usize));
        let Some(texture) = texture else {
            return Err(refuse("has no `index` of a texture of the file", "export it again"));
        };
        let image = match image_of(texture) {
            Some(image) if document.value["images"].get(image).is_some() => image,
            Some(_) | None => {
                let compressed = &texture["extensions"]["KHR_texture_basisu"];
                return Err(match compressed.is_null() {
                    true => refuse("has no picture that is read", "export it with one"),
                    false => refuse(
                        "is compressed by KHR_texture_basisu (Basis Universal), which is not read",
                        "convert its picture to PNG, for instance with gltf-transform",
                    ),
                });
            }
        };
        let picture = document.picture(image)?;
        let transform = &slot.info["extensions"]["KHR_texture_transform"];
        let set = transform["texCoord"].as_u64().or(slot.info["texCoord"].as_u64()).unwrap_or(0);
        if set > 1 {
            let problem = format!("goes by TEXCOORD_{set}, and only the sets 0 and 1 are read");
            return Err(refuse(&problem, "use one of these"));
        }
        let sampler = texture["sampler"].as_u64().map_or(&Value::Null, |sampler| {
            document.value["samplers"].get(sampler as usize).unwrap_or(&Value::Null)
        });
        let wrap = |key: &str| match sampler[key].as_u64() {
            Some(33071) => Wrap::Clamp,
            Some(33648) => Wrap::Mirror,
            Some(_) | None => Wrap::Repeat,
        };
        let (coding, own_transform) = own_words(slot)?;
        let transform = match own_transform {
            Some(own) => own,
            None => transform_of(transform, &slot.label)?,
        };
        Ok(Some(Texture {
            picture,
            coding,
            wrap: ["wrapS", "wrapT"].map(wrap),
            filter: match sampler["magFilter"].as_u64() {
                Some(9728) => Filter::Nearest,
                Some(_) | None => Filter::Linear,
            },
            set: set as usize,
            transform,
        }))
    }

    /// Decodes the pictures of all materials, by all threads.
    fn decode_all(&mut self) {
        if std::mem::replace(&mut self.has_pictures, true) {
            return;
        }
        let document = self.document;
        let mut wanted = Vec::new();
        for material in document.value["materials"].as_array().into_iter().flatten() {
            let pbr = &material["pbrMetallicRoughness"];
            let [base, metal] = ["baseColorTexture", METAL].map(|it| &pbr[it]);
            let own = [base, metal, &material["emissiveTexture"], &material["normalTexture"]];
            let body = &material["extensions"][EXTENSION];
            let (film, khr) = (&body["film"], &material["extensions"][films::KHR_IRIDESCENCE]);
            let of_films = films::PICTURES.map(|(key, ..)| &khr[key]);
            let own_films = films::OWN_PICTURES.map(|(key, _)| &film[key]);
            let keys =
                ["alpha_texture", BUMP_TEXTURE, stains::REFLECTED[1], stains::TRANSMITTED[1]];
            let more = keys.map(|key| &body[key]).into_iter().chain([&body["coverage"]["texture"]]);
            let glossy = &material["extensions"][KHR_GLOSSY];
            let glossy = ["diffuseTexture", "specularGlossinessTexture"].map(|key| &glossy[key]);
            let more = more.chain(of_films).chain(own_films).chain(glossy);
            for info in own.into_iter().chain(more).chain(layers::infos(material)) {
                let texture = info["index"].as_u64();
                let texture = texture.and_then(|it| document.value["textures"].get(it as usize));
                wanted.extend(texture.and_then(image_of));
            }
        }
        wanted.sort_unstable();
        wanted.dedup();
        // What goes wrong is told to who asks for it.
        wanted.into_par_iter().for_each(|image| drop(document.picture(image)));
    }

    /// Whether meshes of a material have colors at their vertices, and whether with alpha. Those of
    /// a mesh are not of a part of its blend.
    pub(super) fn colors_of(&self, material: Option<usize>) -> Option<bool> {
        if !self.blending.is_empty() {
            return None;
        }
        let value = &self.document.value;
        let meshes = value["meshes"].as_array().into_iter().flatten();
        let primitives = meshes.flat_map(|it| it["primitives"].as_array().into_iter().flatten());
        let own = primitives.filter(|it| it["material"].as_u64() == material.map(|it| it as u64));
        let colors = own.filter_map(|it| it["attributes"]["COLOR_0"].as_u64());
        colors.fold(None, |found, accessor| {
            let has_alpha = value["accessors"][accessor as usize]["type"] == "VEC4";
            Some(found == Some(true) || has_alpha)
        })
    }

    /// Says which textures are not read, once a kind.
    fn warn_of_unread(&mut self, material: &Value, label: &str) {
        const READ: [&str; 11] = [
            "anisotropyTexture",
            "baseColorTexture",
            "clearcoatNormalTexture",
            "diffuseTexture",
            "emissiveTexture",
            films::PICTURES[0].0,
            films::PICTURES[1].0,
            METAL,
            "normalTexture",
            "occlusionTexture",
            "specularGlossinessTexture",
        ];
        let mut open = vec![material];
        let mut unread = BTreeSet::new();
        while let Some(next) = open.pop() {
            for (key, inner) in next.as_object().into_iter().flatten() {
                match key.as_str() {
                    "extras" => {}
                    read if READ.contains(&read) || layers::TEXTURES.contains(&read) => {}
                    other if other.ends_with("Texture") => drop(unread.insert(other)),
                    _ => open.push(inner),
                }
            }
        }
        if !unread.is_empty() {
            let text = format!("{}: not read yet, factors hold throughout", listed(unread));
            self.warnings.add_like("textures", label, &text);
        }
    }
}

/// What emits by a picture.
fn painted_emission(
    texture: Texture,
    emission: &Emission,
    label: &str,
) -> Result<Paint, SceneError> {
    let Some(factor) = emission.radiance.rgb() else {
        let problem = "the picture and a spectrum of the emission exclude each other";
        let place = format!("{label}, emissiveTexture");
        return Err(SceneError::new(place, problem, "take one of them away"));
    };
    Ok(Paint { factor, texture: Some(texture), reads: Reads::Color, by_vertices: false })
}

/// The image of a texture.
fn image_of(texture: &Value) -> Option<usize> {
    let webp = texture["extensions"]["EXT_texture_webp"]["source"].as_u64();
    webp.or(texture["source"].as_u64()).map(|image| image as usize)
}

/// The color of a model that has one as red, green and blue.
fn color_of(bsdf: &Bsdf) -> Option<(Parameter, [f32; 3])> {
    let (parameter, spectrum) = match bsdf {
        Bsdf::Diffuse { reflectance } | Bsdf::Plastic { reflectance, .. } => {
            (Parameter::Reflectance, reflectance)
        }
        Bsdf::MetallicRoughness { base_color, .. }
        | Bsdf::Layered { layers: Layers { base_color, .. } } => (Parameter::BaseColor, base_color),
        Bsdf::Brushed { of, .. } | Bsdf::Filmed { of, .. } => return color_of(of),
        Bsdf::Absorber
        | Bsdf::Conductor { .. }
        | Bsdf::RoughConductor { .. }
        | Bsdf::Measured { .. }
        | Bsdf::Blend { .. }
        | Bsdf::RoughDielectric { .. }
        | Bsdf::Dielectric { .. }
        | Bsdf::DispersiveDielectric { .. }
        | Bsdf::FilmedConductor { .. }
        | Bsdf::FilmedDielectric { .. }
        | Bsdf::ThinDielectric { .. }
        | Bsdf::Polarizer { .. }
        | Bsdf::Retarder { .. }
        | Bsdf::Sheet { .. }
        | Bsdf::Null => return None,
    };
    Some((parameter, spectrum.rgb()?))
}

/// Shares of metal in the blue of a picture, and roughness in its green, as far as a model has
/// them.
fn metal_and_roughness(bsdf: &Bsdf, texture: Texture) -> Vec<(Parameter, Paint)> {
    let (metallic, roughness) = match bsdf {
        Bsdf::MetallicRoughness { metallic, alpha, .. }
        | Bsdf::Layered { layers: Layers { metallic, alpha, .. } } => {
            (Some(*metallic), alpha.sqrt())
        }
        Bsdf::RoughConductor { alpha, .. } | Bsdf::RoughDielectric { alpha, .. } => {
            (None, alpha.sqrt())
        }
        Bsdf::Brushed { of, .. } | Bsdf::Filmed { of, .. } => {
            return metal_and_roughness(of, texture);
        }
        Bsdf::Absorber
        | Bsdf::Diffuse { .. }
        | Bsdf::Conductor { .. }
        | Bsdf::Measured { .. }
        | Bsdf::Blend { .. }
        | Bsdf::Plastic { .. }
        | Bsdf::Dielectric { .. }
        | Bsdf::DispersiveDielectric { .. }
        | Bsdf::FilmedConductor { .. }
        | Bsdf::FilmedDielectric { .. }
        | Bsdf::ThinDielectric { .. }
        | Bsdf::Polarizer { .. }
        | Bsdf::Retarder { .. }
        | Bsdf::Sheet { .. }
        | Bsdf::Null => return Vec::new(),
    };
    let paint = |factor: f32, reads| {
        let texture = Some(texture.clone());
        Paint { factor: [factor; 3], texture, reads, by_vertices: false }
    };
    let metallic = metallic.map(|metallic| (Parameter::Metallic, paint(metallic, Reads::Blue)));
    let roughness = (Parameter::Roughness, paint(roughness, Reads::Green));
    metallic.into_iter().chain([roughness]).collect()
}

/// The rows of KHR_texture_transform: coordinates are scaled, turned so that the picture turns
/// clockwise, and moved.
pub fn transform_of(transform: &Value, label: &str) -> Result<[[f32; 3]; 2], SceneError> {
    let number = |value: &Value, default: f64| match value.as_f64() {
        Some(number) if (number as f32).is_finite() => Ok(number),
        None if value.is_null() => Ok(default),
        Some(_) | None => {
            let place = format!("{label}, KHR_texture_transform");
            Err(SceneError::new(place, format!("{value} is no number"), "export it again"))
        }
    };
    let pair = |key: &str, default: f64| -> Result<[f64; 2], SceneError> {
        let pair = &transform[key];
        Ok([number(&pair[0], default)?, number(&pair[1], default)?])
    };
    let ([across, down], [wide, high]) = (pair("offset", 0.0)?, pair("scale", 1.0)?);
    let (sine, cosine) = sin_cos(number(&transform["rotation"], 0.0)?);
    let rows = [[cosine * wide, sine * high, across], [-sine * wide, cosine * high, down]];
    Ok(rows.map(|row| row.map(|value| value as f32)))
}
