//! What the extension says of textures: those that glTF has no place for, and how others are read.

use serde_json::Value;

use super::Import;
use super::extension::{Body, TEXTURE, TEXTURE_INFO};
use super::textures::Slot;
use crate::image::texels::Coding;
use crate::math::Range;
use crate::scene::error::SceneError;
use crate::scene::world::{Bsdf, Coverage, Paint, Reads, Relief, ReliefOf, Texture};

/// Those of [`Texture::transform`].
type Rows = [[f32; 3]; 2];

/// A picture of heights, and how high 1 is in it.
pub const BUMP_TEXTURE: &str = "bump_texture";
pub const BUMP_SCALE: &str = "bump_scale";
/// All codings.
const CODINGS: [Coding; 2] = [Coding::Srgb, Coding::Linear];
/// What of a texel can be a number, by name.
const CHANNELS: [(&str, Reads); 5] = [
    ("red", Reads::Red),
    ("green", Reads::Green),
    ("blue", Reads::Blue),
    ("alpha", Reads::Alpha),
    ("luminance", Reads::Luminance),
];

impl Import<'_> {
    /// A texture of the extension's own, and what of it counts.
    pub fn own_texture(
        &mut self,
        (body, key): (&Body, &str),
    ) -> Result<Option<(Texture, Reads)>, SceneError> {
        self.own_texture_of((body, key), (Coding::Linear, Reads::Luminance))
    }

    /// The same of a color.
    pub fn own_color(
        &mut self,
        (body, key): (&Body, &str),
    ) -> Result<Option<(Texture, Reads)>, SceneError> {
        self.own_texture_of((body, key), super::stains::MEANT)
    }

    fn own_texture_of(
        &mut self,
        (body, key): (&Body, &str),
        (coding, reads): (Coding, Reads),
    ) -> Result<Option<(Texture, Reads)>, SceneError> {
        let Some((info, field)) = body.value(key) else { return Ok(None) };
        Body::nested(info, field.to_owned(), &TEXTURE_INFO)?;
        let label = field.to_owned();
        let slot = Slot { info, label, coding, more: &["channel"] };
        let Some(texture) = self.texture(&slot)? else { return Ok(None) };
        let own = Body::of(info, field, &TEXTURE)?;
        let reads = match own.word("channel")? {
            None => reads,
            Some(name) => channel_of(name).ok_or_else(|| {
                let names = CHANNELS.map(|(name, _)| name).join(", ");
                let remedy = format!("use one of {names}");
                SceneError::new(own.field("channel"), "is no channel", remedy)
            })?,
        };
        Ok(Some((texture, reads)))
    }

    /// The roughness of facets by a picture.
    pub fn alpha(&mut self, body: &Body, bsdf: &Bsdf) -> Result<Paint, SceneError> {
        let alpha = match bsdf {
            Bsdf::RoughConductor { alpha, .. } | Bsdf::RoughDielectric { alpha, .. } => *alpha,
            Bsdf::Filmed { of, .. } => return self.alpha(body, of),
            Bsdf::Absorber
            | Bsdf::Diffuse { .. }
            | Bsdf::Conductor { .. }
            | Bsdf::MetallicRoughness { .. }
            | Bsdf::Layered { .. }
            | Bsdf::Measured { .. }
            | Bsdf::Blend { .. }
            | Bsdf::Brushed { .. }
            | Bsdf::Plastic { .. }
            | Bsdf::Dielectric { .. }
            | Bsdf::DispersiveDielectric { .. }
            | Bsdf::FilmedConductor { .. }
            | Bsdf::FilmedDielectric { .. }
            | Bsdf::ThinDielectric { .. }
            | Bsdf::Polarizer { .. }
            | Bsdf::Retarder { .. }
            | Bsdf::Sheet { .. }
            | Bsdf::Null => {
                let problem = "is of facets, which the model has not";
                let remedy = "use it with rough_conductor or rough_dielectric";
                return Err(SceneError::new(body.field("alpha_texture"), problem, remedy));
            }
        };
        let found = self.own_texture((body, "alpha_texture"))?;
        let Some((texture, reads)) = found else {
            return Err(body.missing("alpha_texture", "give it the index of a texture"));
        };
        Ok(Paint { factor: [alpha; 3], texture: Some(texture), reads, by_vertices: false })
    }

    /// Normals by a picture of heights.
    pub fn heights(&mut self, body: &Body) -> Result<Option<Relief>, SceneError> {
        let scale = body.number(BUMP_SCALE)?;
        let Some((texture, reads)) = self.own_texture((body, BUMP_TEXTURE))? else {
            return match scale {
                Some(_) => Err(body.missing(BUMP_TEXTURE, "the texture that is so high")),
                None => Ok(None),
            };
        };
        let scale = scale.unwrap_or(1.0);
        Range::ANY.check(BUMP_SCALE, scale as f32).map_err(|fault| body.place(fault))?;
        Ok(Some(Relief { texture, scale: scale as f32, of: ReliefOf::Heights(reads) }))
    }

    /// How much of a surface is there, by the extension.
    pub fn own_coverage(&mut self, body: &Body) -> Result<Coverage, SceneError> {
        let number = |key: &str, range: Range| -> Result<Option<f32>, SceneError> {
            let Some(number) = body.number(key)? else { return Ok(None) };
            range.check(key, number).map_err(|fault| body.place(fault))?;
            Ok(Some(number as f32))
        };
        let share = number("share", Range::UNIT)?.unwrap_or(1.0);
        let cutoff = number("cutoff", Range::NOT_NEGATIVE)?;
        let found = self.own_texture((body, "texture"))?;
        let (texture, reads) =
            found.map_or((None, Reads::Luminance), |(it, reads)| (Some(it), reads));
        let paint = Paint { factor: [share; 3], texture, reads, by_vertices: false };
        Ok(Coverage { paint, cutoff })
    }
}

/// What a coding is called.
pub fn coding_name(coding: Coding) -> &'static str {
    match coding {
        Coding::Srgb => "srgb",
        Coding::Linear => "linear",
    }
}

/// What a channel is called, if it is a number.
pub fn channel_name(reads: Reads) -> Option<&'static str> {
    CHANNELS.iter().find(|(_, known)| *known == reads).map(|(name, _)| *name)
}

fn channel_of(name: &str) -> Option<Reads> {
    CHANNELS.iter().find(|(known, _)| *known == name).map(|(_, reads)| *reads)
}

/// What a texture says in words of the extension: its coding, and its rows if it does.
pub fn own_words(slot: &Slot) -> Result<(Coding, Option<Rows>), SceneError> {
    const OF_ALL: [&str; 2] = ["coding", "transform"];
    let own = Body::of(slot.info, &slot.label, &TEXTURE)?;
    if let Some(key) = own.keys().find(|key| !OF_ALL.contains(key) && !slot.more.contains(key)) {
        let problem = "means nothing for a texture in this place";
        return Err(SceneError::new(own.field(key), problem, "remove it"));
    }
    let coding = match own.word("coding")? {
        None => slot.coding,
        Some(name) => {
            let known = CODINGS.into_iter().find(|coding| coding_name(*coding) == name);
            let remedy = "use \"srgb\" or \"linear\"";
            known.ok_or_else(|| SceneError::new(own.field("coding"), "is no coding", remedy))?
        }
    };
    let transform = own.has("transform").then(|| own_transform(&own)).transpose()?;
    Ok((coding, transform))
}

/// The rows of a texture that says them itself.
fn own_transform(own: &Body) -> Result<Rows, SceneError> {
    let row = |value: &Value| {
        let numbers = value.as_array()?.iter().map(|it| Some(it.as_f64()? as f32));
        let numbers: Vec<f32> = numbers.collect::<Option<_>>()?;
        <[f32; 3]>::try_from(numbers).ok().filter(|row| row.iter().all(|it| it.is_finite()))
    };
    let value = own.value("transform").map(|(value, _)| value);
    let rows = value.and_then(|value| match value.as_array()?.as_slice() {
        [first, second] => Some([row(first)?, row(second)?]),
        _ => None,
    });
    rows.ok_or_else(|| {
        let problem = "is not two rows of three numbers";
        let remedy = "times (u, v, 1) of the mesh they are where the picture is read";
        SceneError::new(own.field("transform"), problem, remedy)
    })
}
