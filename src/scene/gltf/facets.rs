//! Facets: how rough they are, and along which direction they are stretched, by the extension's
//! keys and by what glTF calls anisotropy.

use serde_json::{Value, json};

use super::Import;
use super::extension::{Body, MATERIAL};
use super::textures::Slot;
use crate::image::texels::Coding;
use crate::math::Range;
use crate::math::elementary::atan2;
use crate::polarization::Distribution;
use crate::scene::error::SceneError;
use crate::scene::world::{Along, Bsdf, Grain, Paint, Parameter, Reads, Textures};

/// How glTF states it.
pub const KHR_ANISOTROPY: &str = "KHR_materials_anisotropy";
/// The key of its picture.
const TEXTURE: &str = "anisotropyTexture";

/// How facets are distributed, and whether what several of them scatter is given back.
pub fn distribution_and_several(body: &Body) -> Result<(Distribution, bool), SceneError> {
    let multiple_scattering = body.flag("multiple_scattering")?.unwrap_or(true);
    Ok((distribution(body)?, multiple_scattering))
}

/// What [`distribution_and_several`] and [`alpha`] reads, beside other keys.
pub fn with_facets(mut body: Value, of: (f32, Distribution, bool)) -> Value {
    let (alpha, distribution, multiple_scattering) = of;
    body["alpha"] = alpha.into();
    body["distribution"] = distribution.name().into();
    body["multiple_scattering"] = multiple_scattering.into();
    body
}

/// How the normals of facets are distributed.
pub fn distribution(body: &Body) -> Result<Distribution, SceneError> {
    match body.word("distribution")? {
        None => Ok(Distribution::default()),
        Some(name) => Distribution::named(name).ok_or_else(|| {
            let remedy = format!("use {}", Distribution::ALL.map(Distribution::name).join(" or "));
            let problem = format!("`{name}` is not a distribution of facets");
            SceneError::new(body.field("distribution"), problem, remedy)
        }),
    }
}

/// The roughness of facets: itself, or its root.
pub fn alpha(body: &Body) -> Result<f32, SceneError> {
    match (body.number("alpha")?, body.number("roughness")?) {
        (Some(alpha), None) => Ok(alpha as f32),
        (None, Some(roughness)) => {
            let fault = Range::UNIT.check("roughness", roughness).err();
            fault.map_or(Ok(()), |fault| Err(body.place(fault)))?;
            Ok((roughness * roughness) as f32)
        }
        (None, None) => Err(body.missing("alpha", "within [0, 1]; or `roughness`, its root")),
        (Some(_), Some(_)) => {
            let problem = "takes either `alpha` or `roughness`, its root";
            Err(SceneError::new(body.label(), problem, "remove one of them"))
        }
    }
}

/// A model with the facets that the keys `alpha_u`, `alpha_v` and `axis_deg` state; `of` makes it,
/// of facets of a roughness, which is that across if there is another one.
pub fn stated(
    body: &Body,
    alpha: impl FnOnce() -> Result<f32, SceneError>,
    of: impl FnOnce(f32) -> Bsdf,
) -> Result<Bsdf, SceneError> {
    let number = |key| body.number(key).map(|value| value.map(|value| value as f32));
    let (along, across) = match (number("alpha_u")?, number("alpha_v")?) {
        (Some(along), Some(across)) => (along, across),
        (None, None) if body.has("axis_deg") => {
            let remedy = "it says where alpha_u is: state that, and alpha_v";
            return Err(SceneError::new(body.field("axis_deg"), "means nothing", remedy));
        }
        (None, None) => return alpha().map(of),
        (Some(_), None) => return Err(body.missing("alpha_v", "that across alpha_u")),
        (None, Some(_)) => return Err(body.missing("alpha_u", "that across alpha_v")),
    };
    if let Some(key) = ["alpha", "roughness"].into_iter().find(|key| body.has(key)) {
        let remedy = "state alpha_u and alpha_v alone";
        return Err(SceneError::new(body.field(key), "contradicts alpha_u", remedy));
    }
    let unit = |key, alpha| Range::UNIT.check(key, alpha).map_err(|fault| body.place(fault));
    unit("alpha_u", along)?;
    unit("alpha_v", across)?;
    let turn = number("axis_deg")?.unwrap_or(0.0).to_radians();
    let grain = Grain { turn, ..Grain::new(Along::Alpha(along)) };
    Ok(Bsdf::brushed(of(across), grain))
}

/// What [`stated`] reads, in the keys of a model with the roughness across.
pub fn written(mut body: Value, grain: &Grain) -> Value {
    let across = body["alpha"].take();
    if let Some(keys) = body.as_object_mut() {
        keys.remove("alpha");
    }
    let [x, y] = grain.direction;
    let turn = grain.turn.to_degrees() + atan2(y, x).to_degrees();
    let [along, across] = grain.alphas(across.as_f64().unwrap_or(1.0) as f32);
    body["alpha_u"] = json!(along);
    body["alpha_v"] = json!(across);
    body["axis_deg"] = json!(turn);
    body
}

/// What [`Import::grained`] reads, of metallic-roughness.
pub fn write_anisotropy(grain: &Grain, across: f32, material: &mut Value) {
    let [along, _] = grain.alphas(across);
    let strength = match grain.along {
        Along::Strength(strength) => strength,
        Along::Alpha(_) => {
            ((along - across) / (1.0 - across).max(f32::MIN_POSITIVE)).max(0.0).sqrt()
        }
    };
    let [x, y] = grain.direction;
    material["extensions"][KHR_ANISOTROPY] = json!({"anisotropyStrength": strength.min(1.0),
        "anisotropyRotation": grain.turn + atan2(y, x)});
}

/// Whether a material states facets that are stretched.
pub fn is_stated(material: &Value) -> bool {
    let of = &material["extensions"][KHR_ANISOTROPY];
    of["anisotropyStrength"].as_f64().is_some_and(|strength| strength != 0.0)
}

/// Whether any material has facets that are stretched, whose direction goes by the coordinates and
/// tangents of meshes.
pub fn any_is_stretched(materials: &Value) -> bool {
    let keys = |material| Body::of(material, "", &MATERIAL).is_ok_and(|body| body.has("alpha_u"));
    materials.as_array().into_iter().flatten().any(|it| is_stated(it) || keys(it))
}

impl Import<'_> {
    /// A model with the grain that glTF states.
    pub fn grained(
        &mut self,
        bsdf: Bsdf,
        material: &Value,
        label: &str,
    ) -> Result<Bsdf, SceneError> {
        let of = &material["extensions"][KHR_ANISOTROPY];
        let field = |key: &str| format!("{label}, {KHR_ANISOTROPY}.{key}");
        let number = |key: &str| match &of[key] {
            Value::Null => Ok(0.0),
            stated => stated.as_f64().map(|number| number as f32).ok_or_else(|| {
                SceneError::new(field(key), "must be a number", "export the scene again")
            }),
        };
        let [strength, turn] = ["anisotropyStrength", "anisotropyRotation"].map(number);
        let (strength, turn) = (strength?, turn?);
        let key = field("anisotropyStrength");
        Range::UNIT.check("", strength).map_err(|fault| SceneError::at(&key, fault))?;
        if strength == 0.0 {
            return Ok(bsdf);
        }
        if bsdf.facets_alpha().is_none() {
            let text =
                "its anisotropy is ignored: rough metal, coats and solid glass alone have it";
            self.warnings.add_like("anisotropy", label, text);
            return Ok(bsdf);
        }
        let bsdf = Bsdf::brushed(bsdf, Grain { turn, ..Grain::new(Along::Strength(strength)) });
        let key = field("anisotropyRotation");
        bsdf.check().map_err(|fault| SceneError::at(&key, fault.of("")))?;
        Ok(bsdf)
    }

    /// The picture of glTF's grain.
    pub fn paint_grain(
        &mut self,
        textures: &mut Textures,
        (index, label): (usize, &str),
        bsdf: &Bsdf,
    ) -> Result<(), SceneError> {
        let Bsdf::Brushed { grain: Grain { along: Along::Strength(strength), .. }, .. } =
            bsdf.without_film()
        else {
            return Ok(());
        };
        let document = self.document;
        let info = &document.value["materials"][index]["extensions"][KHR_ANISOTROPY][TEXTURE];
        let label = format!("{label}, {TEXTURE}");
        let slot = Slot { info, label, coding: Coding::Linear, more: &[] };
        let Some(texture) = self.texture(&slot)? else { return Ok(()) };
        for (parameter, factor, reads) in [
            (Parameter::GrainRight, 1.0, Reads::Red),
            (Parameter::GrainUp, 1.0, Reads::Green),
            (Parameter::Strength, *strength, Reads::Blue),
        ] {
            let texture = Some(texture.clone());
            let paint = Paint { factor: [factor; 3], texture, reads, by_vertices: false };
            textures.parameters.push((parameter, paint));
        }
        Ok(())
    }
}
