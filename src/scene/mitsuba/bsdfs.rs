//! What surfaces do to light: the types of `<bsdf>`.

use super::fields::{Fields, Given};
use super::glass::{
    conductor, dielectric, facets, index, rough_conductor, rough_dielectric, thin_dielectric,
};
use super::spectra::Kind;
use super::textures::{Use, Wanted};
use super::tree::{Curve, NAME, Tag, Value};
use crate::math::Range;
use crate::math::text::excerpt;
use crate::polarization::Distribution;
use crate::scene::error::SceneError;
use crate::scene::world::{
    Action, BLEND_DEPTH, Bsdf, Coat, Grid, InternalReflection, Parameter, Textures,
};
use crate::spectrum::Spectrum;

/// A surface as read.
#[derive(Clone, Debug)]
pub struct Surface {
    /// How it scatters.
    pub bsdf: Bsdf,
    /// Whether both sides do.
    pub two_sided: bool,
    /// The textures that it asks for.
    pub wanted: Vec<Wanted>,
    /// How much of it is there all over, from 0 to 1.
    pub even: f32,
    /// The shares that are left of light that it reflects and that goes through, where that is not
    /// all of it.
    pub stain: [Option<[f32; 3]>; 2],
    /// The parts of a blend.
    pub parts: Vec<Self>,
    /// Whether some part was smooth, and has the least rough facets now.
    pub has_smooth_parts: bool,
    /// The object that names a measured table, which is the model in place of `bsdf`.
    pub measured: Option<usize>,
}

impl Surface {
    /// Whether it has holes by a texture.
    fn wants_holes(&self) -> bool {
        self.wanted.iter().any(|wanted| wanted.used == Use::Opacity)
    }

    /// Whether its normals are by a texture.
    fn wants_relief(&self) -> bool {
        let is_relief = |used| matches!(used, Use::Normals | Use::Heights(_));
        self.wanted.iter().any(|wanted| is_relief(wanted.used))
    }

    /// Gives it normals by a texture, unless nothing is there: a mask may leave none of it.
    fn bend(&mut self, wanted: Wanted) {
        if self.bsdf != Bsdf::Null {
            self.wanted.push(wanted);
        }
    }
}

impl From<Bsdf> for Surface {
    fn from(bsdf: Bsdf) -> Self {
        Self {
            bsdf,
            two_sided: false,
            wanted: Vec::new(),
            even: 1.0,
            stain: [None; 2],
            parts: Vec::new(),
            has_smooth_parts: false,
            measured: None,
        }
    }
}

/// The type of blends.
pub const BLEND: &str = "blendbsdf";

/// What reads a type.
type Read = fn(&Fields) -> Result<Surface, SceneError>;

/// The types that are known.
const TYPES: [(&str, Read); 19] = [
    (BLEND, blend),
    ("bumpmap", bump_map),
    ("circular", |fields| circular(fields).map(one_sided)),
    ("conductor", conductor),
    ("dielectric", dielectric),
    ("diffuse", diffuse),
    ("mask", mask),
    ("measured_polarized", measured),
    ("normalmap", normal_map),
    ("null", |_| Ok(one_sided(Bsdf::Null))),
    ("plastic", plastic),
    ("polarizer", |fields| polarizer(fields).map(one_sided)),
    ("pplastic", polarized_plastic),
    ("retarder", |fields| retarder(fields).map(one_sided)),
    ("roughconductor", rough_conductor),
    ("roughdielectric", rough_dielectric),
    ("roughplastic", rough_plastic),
    ("thindielectric", thin_dielectric),
    ("twosided", two_sided),
];

/// Reads a surface.
pub fn read(fields: &Fields) -> Result<Surface, SceneError> {
    let plugin = fields.object.plugin.as_str();
    let Some((_, read)) = TYPES.iter().find(|(name, _)| *name == plugin) else {
        let problem = format!("`{}` is not supported", excerpt(plugin, NAME));
        let names: Vec<&str> = TYPES.iter().map(|(name, _)| *name).collect();
        return Err(fields.refuse(problem, format!("the types are {}", names.join(", "))));
    };
    let surface = read(fields)?;
    let is_plastic = matches!(surface.bsdf, Bsdf::Plastic { .. });
    let named = |(of, _): &(&str, &str)| is_plastic || *of != "reflectance";
    let names: Vec<_> = NAMES.into_iter().filter(named).collect();
    surface.bsdf.check().map_err(|fault| fields.fault(fault, &names))?;
    fields.finish()?;
    Ok(surface)
}

/// What fields of models are called here.
const NAMES: [(&str, &str); 6] = [
    ("ior", "int_ior"),
    ("exterior_ior", "ext_ior"),
    ("ior over exterior_ior", "int_ior"),
    ("specular", "specular_reflectance"),
    ("axis_deg", "theta"),
    ("retardance_deg", "delta"),
];

fn one_sided(bsdf: Bsdf) -> Surface {
    bsdf.into()
}

fn diffuse(fields: &Fields) -> Result<Surface, SceneError> {
    let (reflectance, wanted) = reflectance(fields, "reflectance")?;
    Ok(Surface { wanted, ..diffuse_or_black(reflectance).into() })
}

/// A share of light by color, or a picture of it.
fn reflectance(fields: &Fields, name: &str) -> Result<(Spectrum, Vec<Wanted>), SceneError> {
    match fields.wanted(name, Use::Parameter(Parameter::Reflectance)) {
        Some(wanted) => Ok((Spectrum::Rgb([1.0; 3]), vec![wanted])),
        None => {
            let reflectance = fields.spectrum_or(name, Kind::Share, 0.5)?;
            super::spectra::check(fields, name, &reflectance, Range::UNIT)?;
            Ok((reflectance, Vec::new()))
        }
    }
}

/// A table in a file, which is read where files are.
fn measured(fields: &Fields) -> Result<Surface, SceneError> {
    // It is of how Mitsuba draws directions.
    fields.ignore(&["alpha_sample"]);
    if fields.text("filename")?.is_none() {
        return Err(fields.wrong("filename", "is missing", "add it"));
    }
    fields.number("wavelength")?;
    let here = std::ptr::from_ref(fields.object);
    let measured = fields.tree.objects.iter().position(|it| std::ptr::from_ref(it) == here);
    Ok(Surface { measured, ..Bsdf::Absorber.into() })
}

/// What reflects nothing absorbs everything.
pub fn diffuse_or_black(reflectance: Spectrum) -> Bsdf {
    match reflectance.values().iter().all(|value| *value == 0.0) {
        true => Bsdf::Absorber,
        false => Bsdf::Diffuse { reflectance },
    }
}

/// What Mitsuba has is the model of Baek et al.: light that is reflected within is lost.
fn polarized_plastic(fields: &Fields) -> Result<Surface, SceneError> {
    let of_facets = facets(fields)?;
    plastic_of(fields, of_facets, InternalReflection::Lost)
}

fn rough_plastic(fields: &Fields) -> Result<Surface, SceneError> {
    let of_facets = facets(fields)?;
    plastic_of(fields, of_facets, internal_reflection(fields)?)
}

/// Its mirrors are the least rough facets.
fn plastic(fields: &Fields) -> Result<Surface, SceneError> {
    plastic_of(fields, (0.0, Distribution::Ggx), internal_reflection(fields)?)
}

fn internal_reflection(fields: &Fields) -> Result<InternalReflection, SceneError> {
    let is_nonlinear = fields.boolean("nonlinear")?.unwrap_or(false);
    Ok(if is_nonlinear { InternalReflection::Nonlinear } else { InternalReflection::Linear })
}

fn plastic_of(
    fields: &Fields,
    (alpha, distribution): (f32, Distribution),
    internal_reflection: InternalReflection,
) -> Result<Surface, SceneError> {
    let (reflectance, wanted) = reflectance(fields, "diffuse_reflectance")?;
    let Spectrum::Constant(specular) =
        fields.spectrum_or("specular_reflectance", Kind::Share, 1.0)?
    else {
        let problem = "must be one number: facets of a dielectric have no color";
        return Err(fields.wrong("specular_reflectance", problem, "remove it"));
    };
    let bsdf = Bsdf::Plastic {
        reflectance,
        coat: Coat {
            ior: index(fields, "int_ior", "polypropylene")?,
            exterior_ior: index(fields, "ext_ior", "air")?,
            alpha,
            distribution,
            specular,
            internal_reflection,
        },
    };
    Ok(Surface { wanted, ..bsdf.into() })
}

/// A number, if there is one.
pub fn number(fields: &Fields, name: &str) -> Result<Option<f64>, SceneError> {
    fields.has(name).then(|| angle_deg(fields, name, 0.0)).transpose()
}

/// An angle in degrees, the same at all wavelengths.
fn angle_deg(fields: &Fields, name: &str, default: f64) -> Result<f64, SceneError> {
    match fields.given(name) {
        // As they stand: spectra have half of the digits.
        Some(Given::Property(property)) => match &property.value {
            Value::Float(value) | Value::Spectrum(Curve::Uniform(value)) => Ok(*value),
            Value::Integer(value) => Ok(*value as f64),
            other @ (Value::Boolean(_)
            | Value::Text(_)
            | Value::Vector(_)
            | Value::Rgb(_)
            | Value::Spectrum(Curve::Table(_))
            | Value::Transform(_)) => Err(fields.of_kind(name, other, "one number")),
        },
        Some(Given::Object(_)) => Err(fields.wrong(name, "must be one number", "")),
        None => Ok(default),
    }
}

fn polarizer(fields: &Fields) -> Result<Bsdf, SceneError> {
    let transmittance = fields.spectrum_or("transmittance", Kind::Share, 1.0)?;
    if fields.boolean("polarizing")? == Some(false) {
        let problem = "a sheet that takes half of the light and polarizes nothing is not supported";
        return Err(fields.wrong("polarizing", problem, "remove it"));
    }
    // It turns clockwise, seen from the front.
    let axis_deg = 0.0 - angle_deg(fields, "theta", 0.0)?;
    if transmittance == Spectrum::Constant(1.0) {
        return Ok(Bsdf::polarizer(axis_deg));
    }
    let grid = Grid { transmittance, blocked: Spectrum::Constant(0.0) };
    Ok(Bsdf::Sheet { axis_deg, action: Action::Polarizer(grid) })
}

/// An ideal filter of circular light, which leaves it circular: alike from both sides, and at any
/// angle.
fn circular(fields: &Fields) -> Result<Bsdf, SceneError> {
    let transmittance = fields.spectrum_or("transmittance", Kind::Share, 1.0)?;
    angle_deg(fields, "theta", 0.0)?;
    let sense = if fields.boolean("left_handed")? == Some(true) { -0.5 } else { 0.5 };
    let nothing = || Spectrum::Constant(0.0);
    let mut matrix: [Spectrum; 16] = std::array::from_fn(|_| nothing());
    for (corner, of) in [(0, 0.5), (3, sense), (12, sense), (15, 0.5)] {
        matrix[corner] = transmittance.clone().scaled(of);
    }
    Ok(Bsdf::Sheet { axis_deg: 0.0, action: Action::Matrix(matrix) })
}

fn retarder(fields: &Fields) -> Result<Bsdf, SceneError> {
    fields.factor_of_one("transmittance")?;
    let axis_deg = angle_deg(fields, "theta", 0.0)?;
    let retardance_deg = angle_deg(fields, "delta", 90.0)?;
    Ok(Bsdf::Retarder { axis_deg, retardance_deg })
}

/// The surface within another.
fn inner(fields: &Fields) -> Result<Surface, SceneError> {
    match fields.objects(Tag::Bsdf)[..] {
        [(_, only)] => read(&fields.within(only)),
        [] => Err(fields.refuse("has no bsdf in it", "add one")),
        [_, ..] => {
            let problem = "has several in it, and only one is supported";
            Err(fields.refuse(problem, "keep one: both sides are like it"))
        }
    }
}

/// Of two surfaces; the weight is that of the second.
fn blend(fields: &Fields) -> Result<Surface, SceneError> {
    if fields.blends >= BLEND_DEPTH {
        let problem = format!("there are more than {BLEND_DEPTH} blends within each other");
        return Err(fields.refuse(problem, "blend fewer"));
    }
    let [(_, first), (_, second)] = fields.objects(Tag::Bsdf)[..] else {
        return Err(fields.refuse("must have two bsdfs in it", "add or remove some"));
    };
    let [first, second] = [part(fields, first)?, part(fields, second)?];
    if first.two_sided != second.two_sided {
        let problem = "one of its bsdfs is twosided and the other is not";
        return Err(fields.refuse(problem, "put the whole blendbsdf into a twosided"));
    }
    let wanted = fields.wanted("weight", Use::Parameter(Parameter::Weight));
    let weight = match wanted {
        Some(_) => 1.0,
        None => number(fields, "weight")?.ok_or_else(|| {
            let remedy = "add it: a float from 0, the first bsdf, to 1, the second; or a texture";
            fields.wrong("weight", "is missing", remedy)
        })?,
    };
    let weight = weight.clamp(0.0, 1.0) as f32;
    let parts = [&first, &second].map(|part| part.bsdf.clone());
    Ok(Surface {
        two_sided: first.two_sided,
        wanted: wanted.into_iter().collect(),
        has_smooth_parts: first.has_smooth_parts || second.has_smooth_parts,
        parts: vec![first, second],
        ..Bsdf::Blend { parts: Box::new(parts), weight }.into()
    })
}

/// A surface as a part of a blend.
fn part(fields: &Fields, object: usize) -> Result<Surface, SceneError> {
    let own = fields.within(object);
    let mut surface = read(&own)?;
    if surface.even < 1.0 || surface.wants_holes() || surface.wants_relief() {
        let problem = "a part of a blendbsdf has holes, a normalmap or a bumpmap of its own";
        return Err(own.refuse(problem, "put the whole blendbsdf into them"));
    }
    let is_stain = |used| matches!(used, Use::Reflected | Use::Transmitted);
    if surface.stain != [None; 2] || surface.wanted.iter().any(|it| is_stain(it.used)) {
        let problem = "a part of a blendbsdf has a color beside its index of refraction";
        return Err(own.refuse(problem, "remove specular_reflectance"));
    }
    if surface.measured.is_some() {
        let problem = "measured reflectance in a blendbsdf is not supported";
        return Err(own.refuse(problem, "use it alone"));
    }
    let is_smooth;
    (surface.bsdf, is_smooth) = surface.bsdf.into_part();
    surface.has_smooth_parts |= is_smooth;
    surface.bsdf.check_part().map_err(|fault| own.fault(fault, &[]))?;
    Ok(surface)
}

fn two_sided(fields: &Fields) -> Result<Surface, SceneError> {
    let surface = inner(fields)?;
    let may_transmit = fields.boolean("allow_transmission")?.unwrap_or(false);
    if surface.bsdf.transmits() {
        let remedy = "what transmits has two sides of its own: use it alone";
        let problem = match may_transmit {
            true => "`allow_transmission` is not supported",
            false => "its bsdf transmits",
        };
        return Err(fields.refuse(problem, remedy));
    }
    Ok(Surface { two_sided: true, ..surface })
}

/// A surface of which a share is there.
fn mask(fields: &Fields) -> Result<Surface, SceneError> {
    let mut surface = inner(fields)?;
    let has_holes = surface.even < 1.0 || surface.wants_holes();
    let wanted = fields.wanted("opacity", Use::Opacity);
    let opacity = match &wanted {
        Some(_) => Spectrum::Constant(1.0),
        None => fields.spectrum_or("opacity", Kind::Share, 0.5)?,
    };
    super::spectra::check(fields, "opacity", &opacity, Range::UNIT)?;
    if opacity.values().iter().all(|value| *value == 0.0) {
        return Ok(one_sided(Bsdf::Null));
    }
    let Spectrum::Constant(share) = opacity else {
        return Err(fields.wrong("opacity", "has a color, which holes have not", "give a float"));
    };
    if share == 1.0 && wanted.is_none() {
        return Ok(surface);
    }
    if has_holes {
        return Err(fields.refuse("has a mask within a mask", "multiply their opacities"));
    }
    if !Textures::may_have_holes(&surface.bsdf) {
        let problem = "glass that refracts, and sheets, have no holes";
        return Err(fields.refuse(problem, "use an opacity of 1"));
    }
    surface.wanted.extend(wanted);
    surface.even = share;
    Ok(surface)
}

/// A surface with normals by a picture.
fn normal_map(fields: &Fields) -> Result<Surface, SceneError> {
    let mut surface = flat(fields)?;
    let Some(wanted) = fields.wanted("normalmap", Use::Normals) else {
        return Err(fields.wrong("normalmap", "is no picture", "give a texture of type bitmap"));
    };
    surface.bend(wanted);
    Ok(surface)
}

/// A surface with normals by a picture of heights.
fn bump_map(fields: &Fields) -> Result<Surface, SceneError> {
    let mut surface = flat(fields)?;
    let scale = fields.number("scale")?.unwrap_or(1.0) as f32;
    if !scale.is_finite() {
        return Err(fields.wrong(
            "scale",
            "is out of range",
            "give a height in units of the scene",
        ));
    }
    let [(name, _)] = fields.objects(Tag::Texture)[..] else {
        return Err(fields.refuse("must have one texture in it", "give it one of type bitmap"));
    };
    let Some(wanted) = fields.wanted(name, Use::Heights(scale)) else {
        return Err(fields.refuse("has a texture that is no picture", "give one of type bitmap"));
    };
    surface.bend(wanted);
    Ok(surface)
}

/// The surface within one that gives it normals.
fn flat(fields: &Fields) -> Result<Surface, SceneError> {
    // What is turned back over, and how it is shadowed, is the same for all here.
    fields.ignore(&["flip_invalid_normals", "use_shadowing_function"]);
    let surface = inner(fields)?;
    if surface.wants_relief() {
        let problem = "has a normalmap or a bumpmap within it";
        return Err(fields.refuse(problem, "keep one of them"));
    }
    if surface.bsdf != Bsdf::Null && !Textures::may_bend(&surface.bsdf) {
        let problem = "has a sheet within it, which has no normals to bend";
        return Err(fields.refuse(problem, "use that bsdf without it"));
    }
    Ok(surface)
}
