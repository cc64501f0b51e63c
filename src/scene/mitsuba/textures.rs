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
    Coverage, Filter, Paint, Parameter, Picture, Reads, Relief, ReliefFrame, Texture, Textures,
    Wrap, half_hash,
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
    /// Its normals.
    Relief,
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
    /// there all over.
    pub fn textures(
        &mut self,
        (wanted, parts): (&[Wanted], &[Surface]),
        even: f32,
    ) -> Result<Textures, SceneError> {
        let mut textures = Textures::default();
        for part in parts {
            let of = self.textures((&part.wanted, &part.parts), 1.0)?;
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
                Use::Opacity => {
                    let paint = paint(Reads::Luminance);
                    textures.coverage = Some(Coverage { paint, cutoff: None });
                }
                Use::Relief => {
                    let frame = ReliefFrame::Mesh;
                    textures.relief = Some(Relief { texture, scale: 1.0, frame });
                }
            }
        }
        if even < 1.0 {
            let factor = [even; 3];
            let paint = Paint { factor, texture: None, reads: Reads::Color, by_vertices: false };
            textures.coverage = Some(Coverage { paint, cutoff: None });
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
        Use::Parameter(_) | Use::Opacity | Use::Relief => Kind::Share,
    };
    let color = |name: &str, or: f64| {
        let spectrum = fields.spectrum_or(name, kind, or)?;
        spectrum.rgb().ok_or_else(|| {
            let problem = "is given by wavelength, which squares cannot be";
            fields.wrong(name, problem, "give an rgb or one number")
        })
    };
    let [dark, light] = [color("color0", 0.4)?, color("color1", 0.2)?];
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
