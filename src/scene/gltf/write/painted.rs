//! Textures of written materials: in the places that glTF has for them, or in those of the
//! extension. What has neither is refused.

use std::collections::HashMap;
use std::sync::Arc;

use serde_json::{Value, json};

use super::super::extension::EXTENSION;
use super::super::facets::KHR_ANISOTROPY;
use super::super::films;
use super::super::layers::{Place, place_of};
use super::super::materials::KHR_UNLIT;
use super::super::own_textures::{BUMP_SCALE, BUMP_TEXTURE, channel_name, coding_name};
use super::super::stains::{self, REFLECTED, TRANSMITTED};
use super::super::textures::transform_of;
use super::meshes::Tint;
use super::stored::Stored;
use crate::image::texels::Coding;
use crate::math::elementary::{atan2, sin_cos};
use crate::scene::error::SceneError;
use crate::scene::world::{
    Bsdf, Coverage, Filter, Paint, Parameter, Reads, Relief, ReliefFrame, ReliefOf, Stain, Texture,
    Textures, World, Wrap,
};

/// Rows of a texture that lies as the coordinates do.
const PLAIN: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
const REMEDY: &str = "keep the scene's own file";

/// The lists that textures stand in.
#[derive(Default)]
pub struct Lists {
    pub textures: Vec<Value>,
    pub samplers: Vec<Value>,
    /// Pictures by their numbers among what is stored.
    pub images: Vec<usize>,
    /// Textures by what they are made of.
    known: HashMap<(usize, [Wrap; 2], Filter), usize>,
}

/// A material that is written, and what its textures are written to.
pub struct Painter<'a> {
    pub world: &'a World,
    pub stored: &'a mut Stored,
    pub lists: &'a mut Lists,
    /// What errors call the material.
    pub name: &'a str,
    pub material: &'a mut Value,
}

/// Which colors of vertices count. Alpha is kept where it changes nothing.
pub fn tint_of(textures: &Textures) -> Tint {
    match &textures.coverage {
        _ if !textures.read_vertices() => Tint::None,
        Some(coverage) if !coverage.paint.by_vertices => Tint::Color,
        Some(_) | None => Tint::ColorAndAlpha,
    }
}

/// What a place for a texture takes without being told: how integers are encoded, and what of a
/// texel counts.
type Meant = (Coding, Reads);

impl Painter<'_> {
    /// Adds textures to the material, which has all else of it.
    pub fn paint(&mut self, bsdf: &Bsdf, textures: &Textures) -> Result<(), SceneError> {
        let Textures { parameters, parts: _, emission, relief, coverage, stain } = textures;
        let under = bsdf.without_film();
        let has_grain = matches!(under, Bsdf::Brushed { .. });
        let (whole, bsdf) = (bsdf, under.without_grain());
        let of = |wanted: &[Parameter]| {
            let mut found = parameters.iter().filter(|(parameter, _)| wanted.contains(parameter));
            found.next().map(|(_, paint)| paint)
        };
        // Light of its own by the colors of vertices is that of glTF's unlit materials.
        let is_unlit =
            *bsdf == Bsdf::Absorber && emission.as_ref().is_some_and(|it| it.by_vertices);
        let color = of(&[Parameter::Reflectance, Parameter::BaseColor]);
        let base = if is_unlit { emission.as_ref() } else { color };
        if let Some(paint) = base {
            self.base(
                paint,
                color.is_some()
                    && !matches!(bsdf, Bsdf::Layered { .. } | Bsdf::MetallicRoughness { .. }),
            )?;
        }
        self.facets(bsdf, [Parameter::Metallic, Parameter::Roughness].map(|it| of(&[it])))?;
        for (parameter, paint) in parameters {
            if let Some(place) = place_of(*parameter) {
                self.layer(place, paint)?;
            }
        }
        self.grain(
            bsdf,
            [Parameter::Strength, Parameter::GrainRight, Parameter::GrainUp].map(|it| of(&[it])),
        )?;
        self.film(whole, [Parameter::FilmShare, Parameter::FilmThickness].map(|it| of(&[it])))?;
        if let Some(paint) = of(&[Parameter::Weight]) {
            self.check(paint)?;
            self.body()["weight"] = json!(paint.factor[0]);
            if paint.texture.is_some() {
                let info = self.info_of(paint, (Coding::Linear, Reads::Luminance))?;
                self.body()["weight_texture"] = info;
            }
        }
        if let Some(paint) = of(&[Parameter::Alpha]) {
            if has_grain {
                return self.refuse("has stretched facets by a picture, which are not written");
            }
            self.check(paint)?;
            let meant = (Coding::Linear, Reads::Luminance);
            self.body()["alpha"] = json!(paint.factor[0]);
            let info = self.info_of(paint, meant)?;
            self.body()["alpha_texture"] = info;
        }
        match emission {
            Some(_) if is_unlit => self.make_unlit(),
            Some(paint) => self.emission(paint)?,
            None => {}
        }
        if let Some(coverage) = coverage {
            self.coverage(coverage, base)?;
        }
        let Stain { reflected, transmitted } = stain;
        for (keys, paint) in [(REFLECTED, reflected), (TRANSMITTED, transmitted)] {
            paint.iter().try_for_each(|paint| self.stain(keys, paint))?;
        }
        relief.as_ref().map_or(Ok(()), |relief| self.relief(relief))
    }

    fn stain(&mut self, [key, of]: [&str; 2], paint: &Paint) -> Result<(), SceneError> {
        self.body()[key] = json!(paint.factor);
        // That of glTF's own color goes by the colors of vertices, too.
        if paint.by_vertices && key == TRANSMITTED[0] && paint.reads == Reads::Color {
            if let Some(texture) = &paint.texture {
                let info = self.info(texture, Coding::Srgb)?;
                self.material["pbrMetallicRoughness"]["baseColorTexture"] = info;
            }
            return Ok(());
        }
        self.check(paint)?;
        if paint.texture.is_some() {
            self.body()[of] = self.info_of(paint, stains::MEANT)?;
        }
        Ok(())
    }

    fn relief(&mut self, relief: &Relief) -> Result<(), SceneError> {
        let mut info = self.info(&relief.texture, Coding::Linear)?;
        match relief.of {
            ReliefOf::Normals(frame) => {
                info["scale"] = json!(relief.scale);
                if frame == ReliefFrame::Mesh {
                    info["extensions"][EXTENSION]["frame"] = json!("mesh");
                }
                self.material["normalTexture"] = info;
            }
            ReliefOf::Heights(reads) => {
                if reads != Reads::Luminance {
                    let Some(channel) = channel_name(reads) else {
                        return self.refuse("reads a number out of a color, which glTF has not");
                    };
                    info["extensions"][EXTENSION]["channel"] = json!(channel);
                }
                self.body()[BUMP_TEXTURE] = info;
                self.body()[BUMP_SCALE] = json!(relief.scale);
            }
        }
        Ok(())
    }

    fn refuse<T>(&self, problem: &str) -> Result<T, SceneError> {
        Err(SceneError::new(self.name, problem, REMEDY))
    }

    fn body(&mut self) -> &mut Value {
        &mut self.material["extensions"][EXTENSION]
    }

    /// Refuses colors of vertices where glTF knows none.
    fn check(&self, paint: &Paint) -> Result<(), SceneError> {
        match paint.by_vertices {
            true => {
                self.refuse("has colors of vertices for more than its color, which glTF has not")
            }
            false => Ok(()),
        }
    }

    /// The color, which may be a key of the extension as well.
    fn base(&mut self, paint: &Paint, is_of_extension: bool) -> Result<(), SceneError> {
        let [red, green, blue] = paint.factor;
        if paint.reads != Reads::Color {
            return self.refuse("has a color by one channel of a picture, which glTF has not");
        }
        if paint.factor.iter().any(|factor| *factor > 1.0) {
            return self.refuse("has a color of more than its picture, which glTF has not");
        }
        if is_of_extension {
            self.body()["reflectance"] = json!(paint.factor);
            self.material["pbrMetallicRoughness"]["metallicFactor"] = json!(0.0);
        }
        self.material["pbrMetallicRoughness"]["baseColorFactor"] = json!([red, green, blue, 1.0]);
        if let Some(texture) = &paint.texture {
            let info = self.info(texture, Coding::Srgb)?;
            self.material["pbrMetallicRoughness"]["baseColorTexture"] = info;
        }
        Ok(())
    }

    /// Shares of metal and roughness, which are of one picture.
    fn facets(&mut self, bsdf: &Bsdf, paints: [Option<&Paint>; 2]) -> Result<(), SceneError> {
        let texture = match paints {
            [None, None] => return Ok(()),
            [Some(metal), Some(rough)] => {
                self.check(metal)?;
                let is_one = metal.texture == rough.texture && metal.reads == Reads::Blue;
                metal.texture.as_ref().filter(|_| is_one)
            }
            [None, Some(rough)] => {
                let is_alone =
                    matches!(bsdf, Bsdf::RoughConductor { .. } | Bsdf::RoughDielectric { .. });
                rough.texture.as_ref().filter(|_| is_alone)
            }
            [Some(_), None] => None,
        };
        let rough = paints[1].filter(|rough| rough.reads == Reads::Green);
        let (Some(texture), Some(rough)) = (texture, rough) else {
            let problem = "has metal and roughness that are not the blue and the green of one \
                           picture, which glTF has not";
            return self.refuse(problem);
        };
        self.check(rough)?;
        let info = self.info(texture, Coding::Linear)?;
        match paints[0] {
            Some(metal) => {
                let pbr = &mut self.material["pbrMetallicRoughness"];
                pbr["metallicFactor"] = json!(metal.factor[0]);
                pbr["roughnessFactor"] = json!(rough.factor[0]);
            }
            None => {
                self.body()["roughness"] = json!(rough.factor[0]);
                self.body().as_object_mut().map(|body| body.remove("alpha"));
            }
        }
        self.material["pbrMetallicRoughness"]["metallicRoughnessTexture"] = info;
        Ok(())
    }

    /// Direction and strength of facets that are stretched, which are of one picture.
    fn grain(&mut self, bsdf: &Bsdf, paints: [Option<&Paint>; 3]) -> Result<(), SceneError> {
        const NUMBERS: [Reads; 3] = [Reads::Blue, Reads::Red, Reads::Green];
        let (strength, texture) = match paints {
            [None, None, None] => return Ok(()),
            [Some(strength), Some(right), Some(up)] => {
                let all = [strength, right, up];
                let is_one = all.iter().all(|it| it.texture == strength.texture)
                    && all.map(|it| it.reads) == NUMBERS
                    && matches!(bsdf, Bsdf::MetallicRoughness { .. });
                (Some(strength), strength.texture.as_ref().filter(|_| is_one))
            }
            [..] => (None, None),
        };
        let (Some(strength), Some(texture)) = (strength, texture) else {
            return self.refuse("has a grain by pictures that glTF has not");
        };
        let info = self.info(texture, Coding::Linear)?;
        let of = &mut self.material["extensions"][KHR_ANISOTROPY];
        of["anisotropyStrength"] = json!(strength.factor[0]);
        of["anisotropyTexture"] = info;
        Ok(())
    }

    /// How much a film covers, and how thick it is: in the extension's words, or in glTF's where
    /// the model is one of glTF's own.
    fn film(&mut self, bsdf: &Bsdf, paints: [Option<&Paint>; 2]) -> Result<(), SceneError> {
        let (Bsdf::Filmed { film, .. }
        | Bsdf::FilmedConductor { film, .. }
        | Bsdf::FilmedDielectric { film, .. }) = bsdf
        else {
            return Ok(());
        };
        let under = bsdf.without_film().without_grain();
        let is_of_gltf = matches!(under, Bsdf::MetallicRoughness { .. });
        for ((paint, own), (key, _, reads)) in
            paints.into_iter().zip(films::OWN_PICTURES).zip(films::PICTURES)
        {
            let Some(paint) = paint else { continue };
            self.check(paint)?;
            let meant = if is_of_gltf { reads } else { Reads::Luminance };
            if is_of_gltf && paint.reads != meant {
                return self.refuse("has a film by another channel of a picture than glTF has");
            }
            let info = match &paint.texture {
                Some(_) => Some(self.info_of(paint, (Coding::Linear, meant))?),
                None => None,
            };
            let Some(numbers) = films::numbers(film, own.1, paint.factor[0], info.is_some()) else {
                return self.refuse("has a film whose thickness depends on the wavelength");
            };
            let extensions = &mut self.material["extensions"];
            let of = match is_of_gltf {
                true => &mut extensions[films::KHR_IRIDESCENCE],
                false => &mut extensions[EXTENSION]["film"],
            };
            for (own_key, khr_key, number) in numbers {
                of[if is_of_gltf { khr_key } else { own_key }] = json!(number);
            }
            if let Some(info) = info {
                of[if is_of_gltf { key } else { own.0 }] = info;
            }
        }
        Ok(())
    }

    fn layer(&mut self, place: Place, paint: &Paint) -> Result<(), SceneError> {
        let Place { extension, factor, texture, reads, coding } = place;
        self.check(paint)?;
        if paint.reads != reads {
            return self.refuse("has a layer by another channel of a picture than glTF has");
        }
        let of = &mut self.material["extensions"][extension];
        of[factor] = match reads {
            Reads::Color => json!(paint.factor),
            Reads::Red | Reads::Green | Reads::Blue | Reads::Alpha | Reads::Luminance => {
                json!(paint.factor[0])
            }
        };
        if let Some(picture) = &paint.texture {
            let info = self.info(picture, coding)?;
            self.material["extensions"][extension][texture] = info;
        }
        Ok(())
    }

    /// What lit itself alone has nothing of the extension but how its light is polarized.
    fn make_unlit(&mut self) {
        if let Some(body) = self.body().as_object_mut() {
            ["bsdf", "emission"].iter().for_each(|key| drop(body.remove(*key)));
        }
        if let Some(material) = self.material.as_object_mut() {
            material.remove("emissiveFactor");
        }
        self.material["extensions"][KHR_UNLIT] = json!({});
    }

    fn emission(&mut self, paint: &Paint) -> Result<(), SceneError> {
        self.check(paint)?;
        if paint.reads != Reads::Color {
            return self.refuse("emits by one channel of a picture, which glTF has not");
        }
        self.body()["emission"] = json!(paint.factor);
        if let Some(texture) = &paint.texture {
            let info = self.info(texture, Coding::Srgb)?;
            self.material["emissiveTexture"] = info;
        }
        Ok(())
    }

    /// Holes: glTF's, by the alpha of the picture of the color, or those of the extension.
    fn coverage(&mut self, coverage: &Coverage, base: Option<&Paint>) -> Result<(), SceneError> {
        let Coverage { paint, cutoff } = coverage;
        let of_color = base.and_then(|base| base.texture.as_ref());
        let has_alpha = |texture: &Texture| texture.picture.least_alpha() < 1.0;
        // Without anything to be read from, it does not matter what is.
        let is_even = paint.texture.is_none() && !paint.by_vertices;
        let is_plain = (is_even || paint.reads == Reads::Alpha)
            && match (&paint.texture, of_color) {
                (None, of_color) => !of_color.is_some_and(has_alpha),
                (Some(own), Some(of_color)) => own == of_color && has_alpha(own),
                (Some(_), None) => false,
            };
        if is_plain {
            if paint.by_vertices && base.is_some_and(|base| !base.by_vertices) {
                return self.refuse("has colors of vertices for alpha alone, which glTF has not");
            }
            let pbr = &mut self.material["pbrMetallicRoughness"];
            if pbr["baseColorFactor"].is_null() {
                pbr["baseColorFactor"] = json!([1.0, 1.0, 1.0, 1.0]);
            }
            pbr["baseColorFactor"][3] = json!(paint.factor[0]);
            match cutoff {
                Some(least) => {
                    self.material["alphaMode"] = json!("MASK");
                    self.material["alphaCutoff"] = json!(least);
                }
                None => self.material["alphaMode"] = json!("BLEND"),
            }
            return Ok(());
        }
        self.check(paint)?;
        let mut body = json!({"share": paint.factor[0]});
        if let Some(least) = cutoff {
            body["cutoff"] = json!(least);
        }
        if paint.texture.is_some() {
            body["texture"] = self.info_of(paint, (Coding::Linear, Reads::Luminance))?;
        }
        self.body()["coverage"] = body;
        Ok(())
    }

    /// What a place says of the texture of a paint.
    fn info_of(&mut self, paint: &Paint, (coding, reads): Meant) -> Result<Value, SceneError> {
        let Some(texture) = &paint.texture else {
            return self.refuse("is painted with nothing, which glTF has not");
        };
        let mut info = self.info(texture, coding)?;
        if paint.reads != reads {
            let Some(channel) = channel_name(paint.reads) else {
                return self.refuse("reads a number out of a color, which glTF has not");
            };
            info["extensions"][EXTENSION]["channel"] = json!(channel);
        }
        Ok(info)
    }

    fn info(&mut self, texture: &Texture, coding: Coding) -> Result<Value, SceneError> {
        let mut info = json!({"index": self.index_of(texture)?});
        if texture.set != 0 {
            info["texCoord"] = json!(texture.set);
        }
        if texture.transform != PLAIN {
            let (transform, is_near, is_exact) = of_khr(texture.transform);
            if is_near {
                info["extensions"]["KHR_texture_transform"] = transform;
            }
            if !is_exact {
                info["extensions"][EXTENSION]["transform"] = json!(texture.transform);
            }
        }
        if texture.coding != coding {
            info["extensions"][EXTENSION]["coding"] = json!(coding_name(texture.coding));
        }
        Ok(info)
    }

    /// The index of a texture with this picture, and these edges.
    fn index_of(&mut self, texture: &Texture) -> Result<usize, SceneError> {
        let picture: &Arc<_> = &texture.picture;
        let stored = self.stored.picture(picture, self.world);
        let stored = stored.map_err(|error| SceneError::new(self.name, error, REMEDY))?;
        let Lists { textures, samplers, images, known } = &mut *self.lists;
        let key = (stored, texture.wrap, texture.filter);
        if let Some(index) = known.get(&key) {
            return Ok(*index);
        }
        let image = images.iter().position(|image| *image == stored).unwrap_or_else(|| {
            images.push(stored);
            images.len() - 1
        });
        let [across, down] = texture.wrap.map(|wrap| match wrap {
            Wrap::Repeat => 10497,
            Wrap::Mirror => 33648,
            Wrap::Clamp => 33071,
        });
        let filter = match texture.filter {
            Filter::Nearest => 9728,
            Filter::Linear => 9729,
        };
        let sampler =
            json!({"wrapS": across, "wrapT": down, "magFilter": filter, "minFilter": filter});
        let sampler = samplers.iter().position(|it| *it == sampler).unwrap_or_else(|| {
            samplers.push(sampler);
            samplers.len() - 1
        });
        textures.push(match self.stored.is_webp(stored) {
            true => json!({"sampler": sampler,
                "extensions": {"EXT_texture_webp": {"source": image}}}),
            false => json!({"sampler": sampler, "source": image}),
        });
        known.insert(key, textures.len() - 1);
        Ok(textures.len() - 1)
    }
}

/// What KHR_texture_transform can say of the rows, and whether it is near to them, and all of it:
/// there is no shear in it, and the rows of what is turned have been rounded.
fn of_khr(rows: [[f32; 3]; 2]) -> (Value, bool, bool) {
    const NEAR: f32 = 1e-5;
    let [[a, b, across], [c, d, down]] = rows.map(|row| row.map(f64::from));
    let rotation = match ([b, c] == [0.0; 2], [a, c] == [0.0; 2]) {
        // No half turn, but a mirror.
        (true, _) => 0.0,
        (false, true) => atan2(b, d),
        (false, false) => atan2(-c, a),
    };
    let (sine, cosine) = sin_cos(rotation);
    let mut transform = json!({"offset": [across, down],
        "scale": [a * cosine - c * sine, b * sine + d * cosine]});
    if rotation != 0.0 {
        transform["rotation"] = json!(rotation);
    }
    let Ok(read) = transform_of(&transform, "") else { return (transform, false, false) };
    let largest = rows.as_flattened().iter().fold(0.0_f32, |most, it| most.max(it.abs()));
    let pairs = read.as_flattened().iter().zip(rows.as_flattened());
    let error = pairs.fold(0.0_f32, |most, (own, wanted)| most.max((own - wanted).abs()));
    (transform, error <= NEAR * largest, read == rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_gltf_can_say_of_a_place_is_said_in_its_words() {
        for (transform, is_exact) in [
            (json!({"offset": [0.5, -3.0], "scale": [2.0, 0.25]}), true),
            (json!({"scale": [-1.0, 1.0]}), true),
            (json!({"scale": [0.1, -0.3], "rotation": 0.4}), false),
            (json!({"rotation": 1.1, "offset": [1e-3, 7.0]}), false),
        ] {
            let rows = transform_of(&transform, "").unwrap();
            let (_, is_near, exact) = of_khr(rows);
            assert!(is_near && (exact || !is_exact), "{transform}");
        }
        // It is sheared, as no such place is.
        let (_, is_near, is_exact) = of_khr([[1.0, 0.5, 0.0], [0.0, 1.0, 0.0]]);
        assert!(!is_near && !is_exact);
    }
}
