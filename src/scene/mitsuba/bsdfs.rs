//! What surfaces do to light: the types of `<bsdf>`.

use super::fields::{Fields, Given};
use super::spectra::{Kind, index_of_name};
use super::textures::{Use, Wanted};
use super::tree::{Curve, NAME, Tag, Value};
use crate::math::Range;
use crate::math::text::excerpt;
use crate::polarization::Distribution;
use crate::scene::error::SceneError;
use crate::scene::world::{
    Action, Along, BLEND_DEPTH, Bsdf, Coat, Grain, Grid, InternalReflection, Parameter,
};
use crate::spectrum::{Spectrum, metal, metal_names};

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
    /// The parts of a blend.
    pub parts: Vec<Self>,
    /// Whether some part was smooth, and has the least rough facets now.
    pub has_smooth_parts: bool,
    /// The object that names a measured table, which is the model in place of `bsdf`.
    pub measured: Option<usize>,
}

impl Surface {
    /// Whether it asks for a texture of a use.
    fn wants(&self, used: Use) -> bool {
        self.wanted.iter().any(|wanted| wanted.used == used)
    }
}

impl From<Bsdf> for Surface {
    fn from(bsdf: Bsdf) -> Self {
        Self {
            bsdf,
            two_sided: false,
            wanted: Vec::new(),
            even: 1.0,
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
const TYPES: [(&str, Read); 18] = [
    (BLEND, blend),
    ("circular", |fields| circular(fields).map(one_sided)),
    ("conductor", |fields| conductor(fields).map(one_sided)),
    ("dielectric", |fields| dielectric(fields).map(one_sided)),
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
    ("thindielectric", |fields| thin_dielectric(fields).map(one_sided)),
    ("twosided", two_sided),
];

/// Indices of refraction by name, at the line d (E. Hecht, "Optics").
const INDICES: [(&str, f64); 23] = [
    ("vacuum", 1.0),
    ("helium", 1.000_036),
    ("hydrogen", 1.000_132),
    ("air", 1.000_277),
    ("carbon dioxide", 1.000_45),
    ("water", 1.333),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.52045),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.47),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.5046),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.575),
    ("diamond", 2.419),
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

/// An index of refraction: a number, or that of a substance.
fn index(fields: &Fields, name: &str, default: &str) -> Result<f32, SceneError> {
    let of_name = |wanted: &str| {
        let found = INDICES.iter().find(|(known, _)| known.eq_ignore_ascii_case(wanted));
        found.map(|(_, index)| *index as f32).ok_or_else(|| {
            let problem = format!("`{}` is not known", excerpt(wanted, NAME));
            let names: Vec<&str> = INDICES.iter().map(|(name, _)| *name).collect();
            fields.wrong(name, problem, format!("give a number, or one of {}", names.join(", ")))
        })
    };
    match fields.property(name).map(|property| &property.value) {
        None => of_name(default),
        Some(Value::Text(text)) => of_name(text),
        Some(Value::Float(value)) => Ok(*value as f32),
        Some(Value::Integer(value)) => Ok(*value as f32),
        Some(other) => Err(fields.of_kind(name, other, "a float or the name of a substance")),
    }
}

fn dielectric(fields: &Fields) -> Result<Bsdf, SceneError> {
    let ior = index(fields, "int_ior", "bk7")?;
    let exterior_ior = index(fields, "ext_ior", "air")?;
    fields.factor_of_one("specular_reflectance")?;
    fields.factor_of_one("specular_transmittance")?;
    Ok(Bsdf::Dielectric { ior, exterior_ior })
}

fn thin_dielectric(fields: &Fields) -> Result<Bsdf, SceneError> {
    let ior = Spectrum::Constant(index(fields, "int_ior", "bk7")?);
    let exterior_ior = Spectrum::Constant(index(fields, "ext_ior", "air")?);
    fields.factor_of_one("specular_reflectance")?;
    fields.factor_of_one("specular_transmittance")?;
    Ok(Bsdf::ThinDielectric { ior, exterior_ior })
}

fn conductor(fields: &Fields) -> Result<Bsdf, SceneError> {
    metal_index(fields).map(|[eta, k]| Bsdf::Conductor { eta, k })
}

/// Facets reflect once, as Mitsuba has it.
fn rough_conductor(fields: &Fields) -> Result<Surface, SceneError> {
    let [eta, k] = metal_index(fields)?;
    let ([along, alpha], wanted) = roughness(fields)?;
    let distribution = distribution(fields)?;
    let bsdf = Bsdf::RoughConductor { eta, k, alpha, distribution, multiple_scattering: false };
    Ok(Surface { wanted, ..brushed(bsdf, [along, alpha]).into() })
}

/// Facets scatter once, as Mitsuba has it.
fn rough_dielectric(fields: &Fields) -> Result<Surface, SceneError> {
    let ior = Spectrum::Constant(index(fields, "int_ior", "bk7")?);
    let exterior_ior = Spectrum::Constant(index(fields, "ext_ior", "air")?);
    fields.factor_of_one("specular_reflectance")?;
    fields.factor_of_one("specular_transmittance")?;
    let ([along, alpha], wanted) = roughness(fields)?;
    let distribution = distribution(fields)?;
    let multiple_scattering = false;
    let bsdf =
        Bsdf::RoughDielectric { ior, exterior_ior, alpha, distribution, multiple_scattering };
    Ok(Surface { wanted, ..brushed(bsdf, [along, alpha]).into() })
}

/// A model whose facets have these roughnesses along u and v: the second is the model's.
fn brushed(bsdf: Bsdf, [along, across]: [f32; 2]) -> Bsdf {
    match along == across {
        true => bsdf,
        false => Bsdf::brushed(bsdf, Grain::new(Along::Alpha(along))),
    }
}

/// The roughness of facets along u and v, or a picture of it.
fn roughness(fields: &Fields) -> Result<([f32; 2], Vec<Wanted>), SceneError> {
    for name in ["alpha_u", "alpha_v"] {
        if fields.picture(name).is_some() {
            let problem = "pictures of facets that differ along u and v are not supported";
            return Err(fields.wrong(name, problem, "use one, of `alpha`"));
        }
    }
    match fields.wanted("alpha", Use::Parameter(Parameter::Alpha)) {
        Some(wanted) => Ok(([1.0; 2], vec![wanted])),
        None => Ok((alphas(fields)?, Vec::new())),
    }
}

/// The roughness of facets, and how their normals are distributed.
fn facets(fields: &Fields) -> Result<(f32, Distribution), SceneError> {
    Ok((alpha(fields)?, distribution(fields)?))
}

fn distribution(fields: &Fields) -> Result<Distribution, SceneError> {
    match fields.text("distribution")? {
        None => Ok(Distribution::Beckmann),
        Some(name) => Distribution::named(name).ok_or_else(|| {
            let problem = format!("`{}` is not a distribution of facets", excerpt(name, NAME));
            let remedy = format!("use {}", Distribution::ALL.map(Distribution::name).join(" or "));
            fields.wrong("distribution", problem, remedy)
        }),
    }
}

/// The same along u and v.
fn alpha(fields: &Fields) -> Result<f32, SceneError> {
    let [along, across] = alphas(fields)?;
    if along == across {
        return Ok(along);
    }
    let problem = "facets of plastic that differ along u and v are not supported";
    Err(fields.wrong("alpha_u", problem, "use `alpha`"))
}

fn alphas(fields: &Fields) -> Result<[f32; 2], SceneError> {
    // How facets are drawn changes no image.
    fields.boolean("sample_visible")?;
    let alphas = match (stated_alpha(fields, "alpha_u")?, stated_alpha(fields, "alpha_v")?) {
        (None, None) => [stated_alpha(fields, "alpha")?.unwrap_or(0.1); 2],
        (Some(along), Some(across)) => [along, across],
        (Some(_), None) => return Err(fields.wrong("alpha_v", "is missing", "state both")),
        (None, Some(_)) => return Err(fields.wrong("alpha_u", "is missing", "state both")),
    };
    Ok(alphas.map(|alpha| alpha as f32))
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

/// A roughness of facets, if there is one.
fn stated_alpha(fields: &Fields, name: &str) -> Result<Option<f64>, SceneError> {
    const REMEDY: &str =
        "give one number from 0, smooth, to 1; rough surfaces are the same all over";
    let alpha =
        number(fields, name).map_err(|error| fields.wrong(name, error.problem(), REMEDY))?;
    match alpha {
        Some(alpha) if !(0.0..=1.0).contains(&alpha) => {
            Err(fields.wrong(name, format!("{alpha} must be within [0, 1]"), REMEDY))
        }
        alpha => Ok(alpha),
    }
}

/// A number, if there is one.
fn number(fields: &Fields, name: &str) -> Result<Option<f64>, SceneError> {
    fields.has(name).then(|| angle_deg(fields, name, 0.0)).transpose()
}

/// The index of refraction of a metal, and its extinction coefficient.
fn metal_index(fields: &Fields) -> Result<[Spectrum; 2], SceneError> {
    /// An index whose reflectance differs from 1 by 4e-9, where that of 0 does not.
    const NOTHING: f64 = 1e-9;
    fields.factor_of_one("specular_reflectance")?;
    let material = fields.text("material")?.unwrap_or("none");
    if fields.has("eta") || material == "none" {
        // Nothing said is a perfect mirror.
        let mut eta = fields.spectrum_or("eta", Kind::Index, 0.0)?;
        if eta == Spectrum::Constant(0.0) {
            eta = Spectrum::Constant(NOTHING as f32);
        }
        let k = fields.spectrum_or("k", Kind::Index, 1.0)?;
        return Ok([eta, k]);
    }
    let symbol = material.strip_suffix("_palik").unwrap_or(material);
    let (eta, k) = metal(symbol).ok_or_else(|| {
        let problem = format!("`{}` is not tabulated", excerpt(material, NAME));
        let remedy = format!("use one of {}, or give `eta` and `k`", metal_names().join(", "));
        fields.wrong("material", problem, remedy)
    })?;
    Ok([eta, k].map(index_of_name))
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
    if surface.even < 1.0 || surface.wants(Use::Opacity) || surface.wants(Use::Relief) {
        let problem = "a part of a blendbsdf has holes or a normalmap of its own";
        return Err(own.refuse(problem, "put the whole blendbsdf into them"));
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
    let has_holes = surface.even < 1.0 || surface.wants(Use::Opacity);
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
    if surface.bsdf.transmits() {
        let problem = "what light goes through has no holes";
        return Err(fields.refuse(problem, "use an opacity of 1"));
    }
    surface.wanted.extend(wanted);
    surface.even = share;
    Ok(surface)
}

/// A surface with normals by a picture.
fn normal_map(fields: &Fields) -> Result<Surface, SceneError> {
    let mut surface = inner(fields)?;
    if surface.wants(Use::Relief) {
        return Err(fields.refuse("has a normalmap within a normalmap", "keep one"));
    }
    let Some(wanted) = fields.wanted("normalmap", Use::Relief) else {
        return Err(fields.wrong("normalmap", "is no picture", "give a texture of type bitmap"));
    };
    // What is turned back over, and how it is shadowed, is the same for all here.
    surface.wanted.push(wanted);
    Ok(surface)
}
