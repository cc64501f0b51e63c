//! The color of glass and metal: glTF's base color, which is that of the light that goes through
//! glass, and the extension's own words for it.

use serde_json::Value;

use super::Import;
use super::extension::Body;
use crate::image::texels::Coding;
use crate::math::Range;
use crate::scene::error::SceneError;
use crate::scene::world::{Bsdf, Paint, Reads, Stain, Texture};

/// Shares that are left of light that is reflected and that goes through, and what they are
/// multiplied by.
pub const REFLECTED: [&str; 2] = ["reflected", "reflected_texture"];
pub const TRANSMITTED: [&str; 2] = ["transmitted", "transmitted_texture"];

/// Keys of smooth metal.
pub const CONDUCTOR: [&str; 6] = ["eta", "film", "k", "metal", REFLECTED[0], REFLECTED[1]];
/// Keys of smooth glass.
pub const DIELECTRIC: [&str; 7] =
    ["exterior_ior", "film", "ior", REFLECTED[0], REFLECTED[1], TRANSMITTED[0], TRANSMITTED[1]];
/// Keys of panes.
pub const THIN_DIELECTRIC: [&str; 6] =
    ["exterior_ior", "ior", REFLECTED[0], REFLECTED[1], TRANSMITTED[0], TRANSMITTED[1]];
/// Keys of rough metal.
pub const ROUGH_CONDUCTOR: [&str; 14] = [
    "alpha",
    "alpha_texture",
    "alpha_u",
    "alpha_v",
    "axis_deg",
    "distribution",
    "eta",
    "film",
    "k",
    "metal",
    "multiple_scattering",
    REFLECTED[0],
    REFLECTED[1],
    "roughness",
];
/// Keys of rough glass.
pub const ROUGH_DIELECTRIC: [&str; 15] = [
    "alpha",
    "alpha_texture",
    "alpha_u",
    "alpha_v",
    "axis_deg",
    "distribution",
    "exterior_ior",
    "film",
    "ior",
    "multiple_scattering",
    REFLECTED[0],
    REFLECTED[1],
    "roughness",
    TRANSMITTED[0],
    TRANSMITTED[1],
];
/// What plain glTF says of the color of a material.
pub struct BaseColor {
    pub factor: [f32; 3],
    pub texture: Option<Texture>,
    pub by_vertices: bool,
}

impl BaseColor {
    /// Whether it is the same everywhere.
    fn is_even(&self) -> bool {
        self.texture.is_none() && !self.by_vertices
    }

    /// The paint of a factor; none where all light is left.
    fn paint(self, factor: [f32; 3]) -> Option<Paint> {
        let Self { texture, by_vertices, .. } = self;
        let says = texture.is_some() || by_vertices || factor != [1.0; 3];
        says.then_some(Paint { factor, texture, reads: Reads::Color, by_vertices })
    }
}

impl Import<'_> {
    /// The stain of a material that has this color.
    pub fn stain(
        &mut self,
        body: &Body,
        base: BaseColor,
        (bsdf, label): (&Bsdf, &str),
    ) -> Result<Stain, SceneError> {
        let is_own = body.has("bsdf");
        let [reflects, transmits] = Stain::goes_with(bsdf);
        if !is_own {
            // Solid glass of an even color absorbs it on the way.
            let is_absorbed = base.is_even() && !matches!(bsdf, Bsdf::ThinDielectric { .. });
            let factor = base.factor;
            let transmitted =
                base.paint(factor).filter(|_| Stain::is_of_glass(bsdf) && !is_absorbed);
            if transmitted.is_some() && !transmits {
                self.warnings.add_like("color of clear glass", label, uncolored(bsdf));
                return Ok(Stain::default());
            }
            return Ok(Stain { reflected: None, transmitted });
        }
        if !reflects {
            if [REFLECTED, TRANSMITTED].concat().iter().any(|key| body.has(key)) {
                self.warnings.add_like("color of clear glass", label, uncolored(bsdf));
            }
            return Ok(Stain::default());
        }
        let reflected = self.own_stain(body, REFLECTED)?;
        if !transmits {
            return Ok(Stain { reflected, transmitted: None });
        }
        let transmitted = match self.own_stain(body, TRANSMITTED)? {
            Some(own) if own.texture.is_some() => Some(own),
            own => base.paint(own.map_or([1.0; 3], |own| own.factor)),
        };
        Ok(Stain { reflected, transmitted })
    }

    /// A share by a color and a texture of the extension's.
    fn own_stain(
        &mut self,
        body: &Body,
        [key, texture_key]: [&str; 2],
    ) -> Result<Option<Paint>, SceneError> {
        let factor = match body.spectrum(key)? {
            None => [1.0; 3],
            Some(share) => {
                share.check(key, Range::UNIT).map_err(|fault| body.place(fault))?;
                share.rgb().ok_or_else(|| {
                    let problem = "is given by wavelength, which colors of glass and metal are not";
                    SceneError::new(body.field(key), problem, "give a number or [r, g, b]")
                })?
            }
        };
        let texture = self.own_color((body, texture_key))?;
        let (texture, reads) = match texture {
            Some((texture, reads)) => (Some(texture), reads),
            None => (None, Reads::Color),
        };
        let says = texture.is_some() || factor != [1.0; 3];
        Ok(says.then_some(Paint { factor, texture, reads, by_vertices: false }))
    }
}

/// How integers of these textures are encoded, and what of a texel counts, unless they say it.
pub const MEANT: (Coding, Reads) = (Coding::Srgb, Reads::Color);

/// Why a surface has no color of its own.
fn uncolored(bsdf: &Bsdf) -> &'static str {
    match bsdf {
        Bsdf::Filmed { .. } => "colors of rough surfaces under a film are ignored",
        _ if bsdf.clone().simplified() == Bsdf::Null => {
            "the color of glass of the index around it is ignored, as it is not there: give it \
             another index, if by a thousandth"
        }
        _ => "its model has no colors of what it reflects and lets through: they are ignored",
    }
}

/// The color of a material of plain glTF.
pub fn color_of(material: &Value) -> [f32; 3] {
    let factor = &material["pbrMetallicRoughness"]["baseColorFactor"];
    [0, 1, 2].map(|channel| factor[channel].as_f64().map_or(1.0, |it| it as f32))
}
