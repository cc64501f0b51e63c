//! What differs over a surface: the types of `<texture>` that are pictures, and which parameters
//! they feed.

use std::sync::Arc;

use super::Import;
use super::bsdfs::Surface;
use super::fields::{Fields, Given};
use super::spectra::Kind;
use super::tree::{NAME, Tag};
use crate::image::texels::{Coding, Texels};
use crate::math::text::excerpt;
use crate::scene::error::SceneError;
use crate::scene::world::{
    Coverage, Filter, Paint, Parameter, Picture, Reads, Relief, ReliefFrame, ReliefOf, Stain,
    Texture, Textures, Wrap, half_hash,
};

/// The types that are pictures.
const BITMAP: &str = "bitmap";
const CHECKERBOARD: &str = "checkerboard";

/// What of a surface a texture is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Use {
    /// A parameter of its model.
    Parameter(Parameter),
    /// What it emits.
    Radiance,
    /// How much of it is there.
    Opacity,
    /// The share that is left of what it reflects, and of what goes through.
    Reflected,
    Transmitted,
    /// Its normals, by a picture of these.
    Normals,
    /// Its normals, by a picture of heights, which are so much where that is 1.
    Heights(f32),
}

/// A texture that a surface asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    pub used: Use,
    /// The number of its object.
    pub object: usize,
}

impl Fields<'_> {
    /// The object of this name, if it is a picture.
    pub fn picture(&self, name: &str) -> Option<usize> {
        let mut children = self.object.children.iter();
        let object = super::fields::object_of(children.find(|child| child.name == name)?)?;
        let plugin = self.tree.objects[object].plugin.as_str();
        let is_picture = self.tree.objects[object].tag == Tag::Texture
            && [BITMAP, CHECKERBOARD].contains(&plugin);
        // It is asked for as all others.
        match self.given(name) {
            Some(Given::Object(object)) if is_picture => Some(object),
            Some(Given::Object(_) | Given::Property(_)) | None => None,
        }
    }

    /// The same for a use.
    pub fn wanted(&self, name: &str, used: Use) -> Option<Wanted> {
        self.picture(name).map(|object| Wanted { used, object })
    }
}

impl Import<'_> {
    /// What a surface, whose blend may have `parts`, has asked for; `even` is how much of it is
    /// there all over, and `stain` the shares that are left of light all over.
    pub fn textures(
        &mut self,
        (wanted, parts): (&[Wanted], &[Surface]),
        (even, stain): (f32, [Option<[f32; 3]>; 2]),
    ) -> Result<Textures, SceneError> {
        let mut textures = Textures::default();
        for part in parts {
            let of = self.textures((&part.wanted, &part.parts), (1.0, [None; 2]))?;
            textures.parts.push(of);
        }
        if textures.parts.iter().all(Textures::is_empty) {
            textures.parts.clear();
        }
        for Wanted { used, object } in wanted {
            let texture = self.texture(*object, *used)?;
            let paint = |reads| Paint {
                factor: [1.0; 3],
                texture: Some(texture.clone()),
                reads,
                by_vertices: false,
            };
            match used {
                Use::Parameter(parameter) => {
                    let is_color = parameter.role().is_some();
                    let reads = if is_color { Reads::Color } else { Reads::Luminance };
                    textures.parameters.push((*parameter, paint(reads)));
                }
                Use::Radiance => textures.emission = Some(paint(Reads::Color)),
                Use::Reflected => textures.stain.reflected = Some(paint(Reads::Color)),
                Use::Transmitted => textures.stain.transmitted = Some(paint(Reads::Color)),
                Use::Opacity => {
                    let paint = paint(Reads::Luminance);
                    textures.coverage = Some(Coverage { paint, cutoff: None });
                }
                Use::Normals => {
                    let of = ReliefOf::Normals(ReliefFrame::Mesh);
                    textures.relief = Some(Relief { texture, scale: 1.0, of });
                }
                Use::Heights(scale) => {
                    let of = ReliefOf::Heights(Reads::Luminance);
                    textures.relief = Some(Relief { texture, scale: *scale, of });
                }
            }
        }
        let plain =
            |factor| Paint { factor, texture: None, reads: Reads::Color, by_vertices: false };
        if even < 1.0 {
            let paint = plain([even; 3]);
            textures.coverage = Some(Coverage { paint, cutoff: None });
        }
        let Stain { reflected, transmitted } = &mut textures.stain;
        for (share, paint) in stain.iter().zip([reflected, transmitted]) {
            if let Some(share) = share {
                *paint = Some(plain(*share));
            }
        }
        Ok(textures)
    }

    /// The texture that an object is, for a use.
    pub fn texture(&mut self, object: usize, used: Use) -> Result<Texture, SceneError> {
        let fields = Fields::of(self.tree, object);
        let transform = fields.transform("to_uv")?;
        let columns = [transform.x_axis, transform.y_axis, transform.translation];
        let row = |axis: usize| columns.map(|column| column[axis] as f32);
        let rows = [row(0), row(1)];
        if !rows.as_flattened().iter().all(|value| value.is_finite()) {
            return Err(fields.wrong("to_uv", "is not finite", ""));
        }
        let texture = match fields.object.plugin.as_str() {
            CHECKERBOARD => checkerboard(&fields, used)?,
            // The only other one that is a picture.
            _ => self.bitmap(&fields)?,
        };
        fields.finish()?;
        Ok(Texture { transform: rows, ..texture })
    }

    fn bitmap(&mut self, fields: &Fields) -> Result<Texture, SceneError> {
        // How it is kept in memory, and by what it is looked up.
        fields.ignore(&["format", "accel"]);
        let is_raw = fields.boolean("raw")?.unwrap_or(false);
        let Some(name) = fields.text("filename")? else {
            return Err(fields.wrong("filename", "is missing", "add it"));
        };
        let choice = |field: &str, names: &[&str]| match fields.text(field)? {
            None => Ok(0),
            Some(text) => names.iter().position(|name| *name == text).ok_or_else(|| {
                let problem = format!("`{}` is not supported", excerpt(text, NAME));
                fields.wrong(field, problem, format!("use {}", names.join(" or ")))
            }),
        };
        let filter = match choice("filter_type", &["bilinear", "nearest"])? {
            0 => Filter::Linear,
            _ => Filter::Nearest,
        };
        let wrap = match choice("wrap_mode", &["repeat", "mirror", "clamp"])? {
            0 => Wrap::Repeat,
            1 => Wrap::Mirror,
            _ => Wrap::Clamp,
        };
        let path = self.paths.of(name, self.files);
        let picture = match self.pictures.get(&path) {
            Some(known) => Arc::clone(known),
            None => {
                let place = format!("{}, filename", fields.label());
                let bytes = self.files.named(&path, &place, u64::MAX)?;
                let picture = Arc::new(Picture::decoded(&bytes, &place)?);
                self.pictures.insert(path, Arc::clone(&picture));
                picture
            }
        };
        let coding = if is_raw { Coding::Linear } else { Coding::Srgb };
        let transform = Default::default();
        Ok(Texture { picture, coding, wrap: [wrap; 2], filter, set: 0, transform })
    }
}

/// Four squares, which are repeated.
fn checkerboard(fields: &Fields, used: Use) -> Result<Texture, SceneError> {
    let kind = match used {
        Use::Radiance => Kind::Emission,
        Use::Heights(_) => {
            let problem = "is of steps, which have no slopes";
            return Err(fields.refuse(problem, "use a texture of type bitmap"));
        }
        Use::Parameter(_) | Use::Opacity | Use::Reflected | Use::Transmitted | Use::Normals => {
            Kind::Share
        }
    };
    let color = |name: &str, or: f64| {
        let spectrum = fields.spectrum_or(name, kind, or)?;
        spectrum.rgb().ok_or_else(|| {
            let problem = "is given by wavelength, which squares cannot be";
            fields.wrong(name, problem, "give an rgb or one number")
        })
    };
    let [dark, light] = [color("color0", 0.4)?, color("color1", 0.2)?];
    // Mitsuba has its two colors the other way round where it wants numbers.
    let is_number = match used {
        Use::Parameter(parameter) => parameter.role().is_none(),
        Use::Opacity => true,
        Use::Radiance | Use::Reflected | Use::Transmitted | Use::Normals | Use::Heights(_) => false,
    };
    let [dark, light] = if is_number { [light, dark] } else { [dark, light] };
    let colors = vec![dark, light, light, dark];
    let is_usable = |value: &f32| value.is_finite() && *value >= 0.0;
    if !colors.as_flattened().iter().all(is_usable) {
        return Err(fields.refuse("has a color that is negative or infinite", ""));
    }
    let bytes: Vec<u8> = colors.as_flattened().iter().flat_map(|it| it.to_le_bytes()).collect();
    let picture = Arc::new(Picture::new(Texels::of_colors(2, colors), half_hash(&bytes)));
    let (coding, filter, transform) = (Coding::Linear, Filter::Nearest, Default::default());
    Ok(Texture { picture, coding, wrap: [Wrap::Repeat; 2], filter, set: 0, transform })
}
