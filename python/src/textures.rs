//! Pictures on materials, by what of these they feed.

use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use sunstone::world::{
    Bsdf, Coverage, Filter, Material, Paint, Parameter, Picture, Reads, Relief, ReliefFrame,
    ReliefOf, Stain, Texture, Textures, Wrap,
};
use sunstone::{Coding, Spectrum};

use crate::errors::SCENE_ERROR;
use crate::keys::Keys;

/// What pictures may feed.
pub const SLOTS: [&str; 8] =
    ["alpha", "bump", "coverage", "emission", "normal", "reflectance", "reflected", "transmitted"];
/// What of a texel counts, by name.
const CHANNELS: [(&str, Reads); 6] = [
    ("color", Reads::Color),
    ("red", Reads::Red),
    ("green", Reads::Green),
    ("blue", Reads::Blue),
    ("alpha", Reads::Alpha),
    ("luminance", Reads::Luminance),
];

/// How a slot takes a picture that does not say it itself.
#[derive(Clone, Copy)]
struct Meant(Coding, Reads);

const COLOR: Meant = Meant(Coding::Srgb, Reads::Color);
const NUMBER: Meant = Meant(Coding::Linear, Reads::Luminance);

/// The textures of a material, and the shares that are left of what it reflects and transmits.
pub fn textures(keys: &Keys, painted: Option<Keys>, material: &Material) -> PyResult<Textures> {
    let mut textures = Textures::default();
    let mut shares = [None, None];
    for (share, key) in shares.iter_mut().zip(["reflected", "transmitted"]) {
        *share = keys.spectrum(key)?.map(|share| rgb(keys, key, &share)).transpose()?;
    }
    let [reflected, transmitted] = shares;
    let even = |factor| Paint { factor, texture: None, reads: Reads::Color, by_vertices: false };
    textures.stain = Stain { reflected: reflected.map(even), transmitted: transmitted.map(even) };
    let Some(painted) = painted else { return Ok(textures) };
    for slot in SLOTS {
        if let Some(of) = painted.part(slot)? {
            add(&mut textures, (slot, &of), keys, material)?;
            of.finish("a texture in this place")?;
        }
    }
    painted.finish("textures")?;
    Ok(textures)
}

/// Adds one.
fn add(
    textures: &mut Textures,
    (slot, of): (&str, &Keys),
    keys: &Keys,
    material: &Material,
) -> PyResult<()> {
    let lacks = |what: &str| of.refuse("", &format!("the material has no {what}"), "remove it");
    match slot {
        "reflectance" => {
            let factor = reflectance(&material.bsdf).ok_or_else(|| lacks("reflectance"))?;
            let factor = rgb(keys, "reflectance", factor)?;
            textures.parameters.push((Parameter::Reflectance, paint(of, COLOR, factor)?));
        }
        "alpha" => {
            let factor = alpha(&material.bsdf).ok_or_else(|| lacks("facets by a picture"))?;
            textures.parameters.push((Parameter::Alpha, paint(of, NUMBER, [factor; 3])?));
        }
        "emission" => {
            let emission = material.emission.as_ref().ok_or_else(|| lacks("emission"))?;
            let factor = rgb(keys, "emission", &emission.radiance)?;
            textures.emission = Some(paint(of, COLOR, factor)?);
        }
        "reflected" | "transmitted" => {
            let Stain { reflected, transmitted } = &mut textures.stain;
            let stain = if slot == "reflected" { reflected } else { transmitted };
            let factor = stain.as_ref().map_or([1.0; 3], |even| even.factor);
            *stain = Some(paint(of, COLOR, factor)?);
        }
        "coverage" => {
            let cutoff = of.take("cutoff")?;
            textures.coverage = Some(Coverage { paint: paint(of, NUMBER, [1.0; 3])?, cutoff });
        }
        "bump" | "normal" => {
            if textures.relief.is_some() {
                return Err(of.refuse("", "excludes `bump`", "keep one of them"));
            }
            let scale = of.take("scale")?.unwrap_or(1.0);
            let (texture, reads) = texture(of, NUMBER)?;
            let is_bump = slot == "bump";
            let normals = ReliefOf::Normals(ReliefFrame::Picture);
            let of = if is_bump { ReliefOf::Heights(reads) } else { normals };
            textures.relief = Some(Relief { texture, scale, of });
        }
        other => unreachable!("{other} is none of the slots"),
    }
    Ok(())
}

/// The reflectance of a model, if it has one.
fn reflectance(bsdf: &Bsdf) -> Option<&Spectrum> {
    let (Bsdf::Diffuse { reflectance } | Bsdf::Plastic { reflectance, .. }) = bsdf else {
        return None;
    };
    Some(reflectance)
}

/// The roughness of a model of facets.
fn alpha(bsdf: &Bsdf) -> Option<f32> {
    let (Bsdf::RoughConductor { alpha, .. } | Bsdf::RoughDielectric { alpha, .. }) = bsdf else {
        return None;
    };
    Some(*alpha)
}

/// Red, green and blue of what a picture is multiplied by.
fn rgb(keys: &Keys, key: &str, spectrum: &Spectrum) -> PyResult<[f32; 3]> {
    spectrum.rgb().ok_or_else(|| {
        let problem = "is given by wavelength, which pictures and colors of glass exclude";
        keys.refuse(key, problem, "give a number or [red, green, blue]")
    })
}

fn paint(of: &Keys, meant: Meant, factor: [f32; 3]) -> PyResult<Paint> {
    let (texture, reads) = texture(of, meant)?;
    Ok(Paint { factor, texture: Some(texture), reads, by_vertices: false })
}

/// A picture, how it lies on surfaces, and what of it counts.
fn texture(of: &Keys, Meant(coding, reads): Meant) -> PyResult<(Texture, Reads)> {
    let word = |key: &str, words: &[&str], default: usize| -> PyResult<usize> {
        let Some(word) = of.take::<String>(key)? else { return Ok(default) };
        words.iter().position(|known| *known == word).ok_or_else(|| {
            of.refuse(key, &format!("`{word}` is not known"), &format!("use {}", words.join(", ")))
        })
    };
    let wrap = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
    let wrap = wrap[word("wrap", &["repeat", "mirror", "clamp"], 0)?];
    let filter = [Filter::Linear, Filter::Nearest][word("filter", &["linear", "nearest"], 0)?];
    let coding = match word("coding", &["srgb", "linear"], 2)? {
        0 => Coding::Srgb,
        1 => Coding::Linear,
        _unsaid => coding,
    };
    let names = CHANNELS.map(|(name, _)| name);
    let channel = word("channel", &names, names.len())?;
    let reads = CHANNELS.get(channel).map_or(reads, |(_, reads)| *reads);
    let transform: Option<[[f32; 3]; 2]> = of.take("transform")?;
    let transform = transform.unwrap_or([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let picture = Arc::new(picture(of)?);
    let wrap = [wrap; 2];
    Ok((Texture { picture, coding, wrap, filter, set: 0, transform }, reads))
}

/// The bytes of a file, or of floats in rows of a width.
fn picture(of: &Keys) -> PyResult<Picture> {
    let bytes: Bound<PyBytes> = of.need("picture", "the bytes of a file, or an array")?;
    let bytes = bytes.as_bytes();
    let read = match of.take::<usize>("width")? {
        None => Picture::read(bytes),
        Some(width) => {
            let float = |bytes: &[u8; 4]| f32::from_ne_bytes(*bytes);
            let (floats, _) = bytes.as_chunks::<4>();
            let (colors, _) = floats.as_chunks::<3>();
            Picture::of_colors(
                width,
                colors.iter().map(|color| color.each_ref().map(float)).collect(),
            )
        }
    };
    read.map_err(|error| SCENE_ERROR.says(of.place_of(&error.to_string())))
}
