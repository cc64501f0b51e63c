//! Colors of diffuse light and of gloss, as glTF once stated them
//! (KHR_materials_pbrSpecularGlossiness), as a base color and a share of metal.
//!
//! A texel has a diffuse color d and reflects s towards the normal, so that (1 - max s) d is
//! diffuse. Metallic-roughness of base color c and share m of metal has 0.96 (1 - m) c that is
//! diffuse, and reflects 0.04 (1 - m) + m c. That they look the same is a quadratic equation for m,
//! of brightnesses; c is then what one of the two asks for, and more of the second where there is
//! more metal.

use std::sync::Arc;

use serde_json::Value;

use super::Import;
use super::materials::KHR_GLOSSY;
use super::textures::Slot;
use crate::image::palette::encode_srgb;
use crate::image::texels::{Coding, Texels};
use crate::math::Range;
use crate::scene::error::SceneError;
use crate::scene::world::{Bsdf, Picture, Texture, half_hash};
use crate::spectrum::Spectrum;

/// What glTF's dielectrics reflect towards the normal.
const F0: f32 = 0.04;
/// Its index of refraction.
const IOR: f32 = 1.5;
/// Least share that something is divided by.
const SHARE_MIN: f32 = 1e-4;

/// What a material says, times what its textures have.
#[derive(Clone, Copy)]
struct Gloss {
    /// The diffuse color, and alpha.
    diffuse: [f32; 4],
    /// What is reflected towards the normal, and 1 less the roughness.
    specular: [f32; 4],
}

impl Gloss {
    fn of(glossy: &Value, label: &str) -> Result<Self, SceneError> {
        let numbers = |key: &str, count: usize| {
            let place = format!("{label}, {KHR_GLOSSY}.{key}");
            let stated = match &glossy[key] {
                Value::Null => return Ok([1.0; 4]),
                Value::Array(stated) => stated.as_slice(),
                stated => std::slice::from_ref(stated),
            };
            if stated.len() != count {
                let problem = format!("is not {count} numbers");
                return Err(SceneError::new(place, problem, "export the scene again"));
            }
            let mut read = [1.0; 4];
            for (to, from) in read.iter_mut().zip(stated) {
                *to = from.as_f64().map_or(f32::NAN, |number| number as f32);
                Range::UNIT.check("", *to).map_err(|fault| SceneError::at(&place, fault))?;
            }
            Ok(read)
        };
        let [glossiness, ..] = numbers("glossinessFactor", 1)?;
        let [red, green, blue, _] = numbers("specularFactor", 3)?;
        let specular = [red, green, blue, glossiness];
        Ok(Self { diffuse: numbers("diffuseFactor", 4)?, specular })
    }

    fn times(self, [diffuse, specular]: [[f32; 4]; 2]) -> Self {
        let product = |a: [f32; 4], b: [f32; 4]| std::array::from_fn(|i| a[i] * b[i]);
        Self { diffuse: product(self.diffuse, diffuse), specular: product(self.specular, specular) }
    }

    /// What is reflected towards the normal.
    fn gloss(&self) -> [f32; 3] {
        let [red, green, blue, _] = self.specular;
        [red, green, blue]
    }

    /// The base color, the share of metal and the roughness.
    fn as_metal(self) -> ([f32; 3], f32, f32) {
        let (specular, glossiness) = (self.gloss(), self.specular[3]);
        let left = 1.0 - specular.into_iter().fold(0.0, f32::max);
        let [red, green, blue, _] = self.diffuse;
        let matte = [red, green, blue].map(|it| it * left / (1.0 - F0));
        let share = share_of_metal(brightness(matte), brightness(specular));
        let color = std::array::from_fn(|i| {
            let by_matte = matte[i] / (1.0 - share).max(SHARE_MIN);
            let by_gloss = (specular[i] - F0 * (1.0 - share)) / share.max(SHARE_MIN);
            let weight = share * share;
            (by_matte + weight * (by_gloss - by_matte)).clamp(0.0, 1.0)
        });
        (color, share, 1.0 - glossiness)
    }
}

/// How bright a color looks, about.
fn brightness([red, green, blue]: [f32; 3]) -> f32 {
    (0.299 * red * red + 0.587 * green * green + 0.114 * blue * blue).sqrt()
}

/// The share m of metal of which F0 m^2 + (matte + gloss - 2 F0) m + F0 - gloss = 0.
fn share_of_metal(matte: f32, gloss: f32) -> f32 {
    if gloss <= F0 {
        return 0.0;
    }
    let half = 0.5 * (matte + gloss - 2.0 * F0);
    let root = (half * half + F0 * (gloss - F0)).sqrt();
    // The one that is positive, without a difference of like numbers.
    let share = match half > 0.0 {
        true => (gloss - F0) / (half + root),
        false => (root - half) / F0,
    };
    share.clamp(0.0, 1.0)
}

/// What a material of colors of gloss is without its pictures; with them, their factors are 1.
pub fn model(glossy: &Value, label: &str) -> Result<Bsdf, SceneError> {
    let gloss = Gloss::of(glossy, label)?;
    let (color, metallic, roughness) = match has_pictures(glossy) {
        true => ([1.0; 3], 1.0, 1.0),
        false => gloss.as_metal(),
    };
    // What reflects less than dielectrics do has no metal, and more of it is diffuse.
    let is_dull = !has_pictures(glossy) && metallic == 0.0;
    let specular = if is_dull { (brightness(gloss.gloss()) / F0).min(1.0) } else { 1.0 };
    let more = (1.0 - F0) / (1.0 - F0 * specular);
    let color = color.map(|it| more * it);
    Ok(Bsdf::MetallicRoughness {
        base_color: Spectrum::Rgb(color),
        metallic,
        alpha: roughness * roughness,
        ior: IOR,
        specular,
    })
}

/// The alpha of a material of colors of gloss.
pub fn alpha(glossy: &Value) -> f32 {
    glossy["diffuseFactor"][3].as_f64().unwrap_or(1.0) as f32
}

fn has_pictures(glossy: &Value) -> bool {
    ["diffuseTexture", "specularGlossinessTexture"].iter().any(|key| glossy[*key].is_object())
}

impl Import<'_> {
    /// The textures of base color and of roughness and metal that those of diffuse color and of
    /// gloss stand for.
    pub fn glossy_textures(
        &mut self,
        glossy: &Value,
        label: &str,
    ) -> Result<[Option<Texture>; 2], SceneError> {
        let gloss = Gloss::of(glossy, label)?;
        let mut read = |key: &str| {
            let label = format!("{label}, {key}");
            self.texture(&Slot { info: &glossy[key], label, coding: Coding::Srgb, more: &[] })
        };
        let (diffuse, specular) = (read("diffuseTexture")?, read("specularGlossinessTexture")?);
        let Some(place) = diffuse.as_ref().or(specular.as_ref()) else { return Ok([None, None]) };
        let is_apart = diffuse.is_some()
            && specular.as_ref().is_some_and(|it| {
                (it.set, it.transform, it.wrap) != (place.set, place.transform, place.wrap)
            });
        if is_apart {
            let text = "its textures of diffuse color and gloss are placed differently: of gloss \
                        the mean is taken";
            self.warnings.add_like("places of gloss", label, text);
        }
        let source = (diffuse.as_ref(), specular.as_ref(), is_apart);
        let [color, metal] = converted(gloss, source);
        let of = |(picture, coding)| Some(Texture { picture, coding, ..place.clone() });
        Ok([of((color, Coding::Srgb)), of((metal, Coding::Linear))])
    }
}

/// The pictures of base color, and of roughness (green) and metal (blue).
fn converted(
    gloss: Gloss,
    (diffuse, specular, is_apart): (Option<&Texture>, Option<&Texture>, bool),
) -> [Arc<Picture>; 2] {
    let sources = [diffuse, specular];
    let size = sources
        .into_iter()
        .flatten()
        .map(|it| it.picture.texels().size())
        .fold([1, 1], |[a, b], [width, height]| [a.max(width), b.max(height)]);
    let mean = specular.map(Texture::mean).filter(|_| is_apart);
    let texel = |of: Option<&Texture>, x: u32, y: u32| match of {
        None => [1.0; 4],
        Some(of) => {
            let texels = of.picture.texels();
            let [width, height] = texels.size();
            // Whole numbers, as pictures of other sizes are mostly halves.
            let at = |at: u32, of: u32, whole: u32| {
                (u64::from(at) * u64::from(of) / u64::from(whole)) as u32
            };
            texels.at(at(x, width, size[0]), at(y, height, size[1]), of.coding)
        }
    };
    let mut colors = Vec::with_capacity(size[0] as usize * size[1] as usize);
    let mut metals = Vec::with_capacity(colors.capacity());
    let byte = |value: f32| (255.0 * value).round() as u8;
    for y in 0..size[1] {
        for x in 0..size[0] {
            let shine = mean.unwrap_or_else(|| texel(specular, x, y));
            let matte = texel(diffuse, x, y);
            let (color, metal, roughness) = gloss.times([matte, shine]).as_metal();
            let [red, green, blue] = color.map(encode_srgb);
            colors.push([red, green, blue, byte(matte[3].clamp(0.0, 1.0))]);
            metals.push([0, byte(roughness), byte(metal), 255]);
        }
    }
    let numbers = gloss.diffuse.into_iter().chain(gloss.specular).flat_map(f32::to_le_bytes);
    let checksums = sources.map(|of| of.map_or(0, |it| it.picture.checksum).to_le_bytes());
    let named: Vec<u8> = numbers.chain(checksums.into_iter().flatten()).collect();
    let picture = |bytes: Vec<[u8; 4]>, name: &[u8]| {
        let checksum = half_hash(&[named.as_slice(), name].concat());
        Arc::new(Picture::new(Texels::of_bytes(size[0], bytes), checksum))
    };
    [picture(colors, b"color"), picture(metals, b"metal")]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is diffuse and what is reflected towards the normal.
    fn parts((color, metal, _): ([f32; 3], f32, f32)) -> [[f32; 3]; 2] {
        let plain = 1.0 - metal;
        [color.map(|it| (1.0 - F0) * plain * it), color.map(|it| F0 * plain + metal * it)]
    }

    #[test]
    fn what_metal_or_plastic_is_comes_back() {
        let colors = [[0.8, 0.5, 0.2], [0.1, 0.1, 0.1], [1.0, 1.0, 1.0], [0.02, 0.9, 0.3]];
        for color in colors {
            for metal in [0.0, 1.0] {
                // As gloss: of metal the color is what it reflects, and nothing is diffuse.
                let [matte, gloss] = parts((color, metal, 0.0));
                let left = 1.0 - gloss.into_iter().fold(0.0, f32::max);
                let diffuse = matte.map(|it| it / left.max(1e-3));
                let gloss = Gloss {
                    diffuse: [diffuse[0], diffuse[1], diffuse[2], 1.0],
                    specular: [gloss[0], gloss[1], gloss[2], 0.75],
                };
                let found = gloss.as_metal();
                let wanted = [matte, parts((color, metal, 0.0))[1]];
                for (found, wanted) in parts(found).as_flattened().iter().zip(wanted.as_flattened())
                {
                    assert!((found - wanted).abs() < 2e-3, "{color:?} {metal}: {found} {wanted}");
                }
                assert_eq!(found.2, 0.25);
            }
        }
    }

    #[test]
    fn what_reflects_nothing_is_diffuse() {
        let glossy = serde_json::json!({"diffuseFactor": [0.5, 0.25, 0.75, 1.0],
            "specularFactor": [0.0, 0.0, 0.0], "glossinessFactor": 0.0});
        let model = model(&glossy, "material 0").expect("it is sound");
        let Bsdf::MetallicRoughness { base_color: Spectrum::Rgb(color), specular, .. } = model
        else {
            panic!("{model:?}");
        };
        assert_eq!(specular, 0.0);
        for (found, wanted) in color.into_iter().zip([0.5, 0.25, 0.75]) {
            assert!((found - wanted).abs() < 1e-6, "{color:?}");
        }
    }

    #[test]
    fn shares_of_metal_solve_the_equation() {
        for gloss in [0.05_f32, 0.1, 0.3, 0.9, 1.0] {
            for matte in [0.0_f32, 1e-4, 0.02, 0.3, 0.9] {
                let m = f64::from(share_of_metal(matte, gloss));
                let (matte, gloss, f0) = (f64::from(matte), f64::from(gloss), f64::from(F0));
                let left = f0 * m * m + (matte + gloss - 2.0 * f0) * m + f0 - gloss;
                assert!(left.abs() < 1e-6 || m == 1.0 && left < 0.0, "{matte} {gloss}: {m}");
            }
        }
    }
}
