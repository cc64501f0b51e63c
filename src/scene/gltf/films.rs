//! Thin films: the extension's, and what glTF calls iridescence.

use serde_json::{Value, json};

use super::Import;
use super::extension::{Body, MATERIAL, THIN_FILM};
use super::spectra::Part;
use super::textures::Slot;
use crate::image::texels::Coding;
use crate::math::Range;
use crate::scene::error::SceneError;
use crate::scene::warnings::Warnings;
use crate::scene::world::{Bsdf, Paint, Parameter, Reads, Textures, ThinFilm};
use crate::spectrum::Spectrum;

/// How glTF states a film.
pub const KHR_IRIDESCENCE: &str = "KHR_materials_iridescence";
/// Its index, and its thickness in nanometers where its picture is white and black, unless they are
/// stated.
const DEFAULTS: [(&str, f64); 3] = [
    ("iridescenceIor", 1.3),
    ("iridescenceThicknessMaximum", 400.0),
    ("iridescenceThicknessMinimum", 100.0),
];
/// Its pictures: how much of the surface it covers, and how thick it is.
pub const PICTURES: [(&str, Parameter, Reads); 2] = [
    ("iridescenceTexture", Parameter::FilmShare, Reads::Red),
    ("iridescenceThicknessTexture", Parameter::FilmThickness, Reads::Green),
];
/// The same in the extension.
pub const OWN_PICTURES: [(&str, Parameter); 2] =
    [("share_texture", Parameter::FilmShare), ("thickness_texture", Parameter::FilmThickness)];

/// The film of a material, if it has one.
pub fn stated(body: &Body) -> Result<Option<ThinFilm<Spectrum>>, SceneError> {
    let Some(film) = body.object("film", &THIN_FILM)? else { return Ok(None) };
    let Some(eta) = film.refraction("eta", Part::Real)? else {
        return Err(film.missing("eta", "the real part of the film's index of refraction"));
    };
    let k = film.refraction("k", Part::Extinction)?.unwrap_or(Spectrum::Constant(0.0));
    let Some(thickness_nm) = film.number("thickness_nm")? else {
        return Err(film.missing("thickness_nm", "in nanometers, as 300"));
    };
    let black_nm = film.number("thickness_black_nm")?;
    if black_nm.is_some() && !film.has("thickness_texture") {
        let remedy = "it is where thickness_texture is black: give that";
        return Err(SceneError::new(film.field("thickness_black_nm"), "means nothing", remedy));
    }
    let ends_nm = [black_nm.unwrap_or(0.0), thickness_nm].map(|nm| nm as f32);
    for (key, nm) in ["thickness_black_nm", "thickness_nm"].into_iter().zip(ends_nm) {
        Range::NOT_NEGATIVE.check(key, nm).map_err(|fault| film.place(fault))?;
    }
    let share = film.number("share")?.unwrap_or(1.0) as f32;
    Ok(Some(ThinFilm { share, ..ThinFilm::new(eta, k, 0.0).between(ends_nm) }))
}

/// What [`stated`] reads.
pub fn written(film: &ThinFilm<Spectrum>, of: &mut impl FnMut(&Spectrum) -> Value) -> Value {
    let mut body = json!({"eta": of(&film.eta), "k": of(&film.k)});
    body["thickness_nm"] = of(&film.thickness.clone().scaled(film.portion));
    if film.share < 1.0 {
        body["share"] = json!(film.share);
    }
    body
}

/// The numbers that go with a picture of a film (`is_there`), times a factor: the keys of the
/// extension and of glTF, and the values. None can be said of a thickness by wavelength.
pub fn numbers(
    film: &ThinFilm<Spectrum>,
    parameter: Parameter,
    factor: f32,
    is_there: bool,
) -> Option<Vec<(&'static str, &'static str, f32)>> {
    if parameter == Parameter::FilmShare {
        return Some(vec![("share", "iridescenceFactor", factor)]);
    }
    let &Spectrum::Constant(most) = &film.thickness else { return None };
    let [black, white] = film.portions.map(|portion| portion * most);
    let mut numbers =
        vec![("thickness_nm", DEFAULTS[1].0, black + (white - black) * factor.min(1.0))];
    if is_there {
        numbers.push(("thickness_black_nm", DEFAULTS[2].0, black));
    }
    Some(numbers)
}

/// What [`iridescent`] reads, of a film of an index that is one number, and does not absorb.
pub fn write_iridescence(film: &ThinFilm<Spectrum>, material: &mut Value) -> bool {
    let (&Spectrum::Constant(eta), &Spectrum::Constant(thickness)) = (&film.eta, &film.thickness)
    else {
        return false;
    };
    material["extensions"][KHR_IRIDESCENCE] = json!({"iridescenceFactor": film.share,
        "iridescenceIor": eta, "iridescenceThicknessMaximum": thickness * film.portion});
    true
}

/// A material with the film that glTF states.
pub fn iridescent(
    bsdf: Bsdf,
    value: &Value,
    label: &str,
    warnings: &mut Warnings,
) -> Result<Bsdf, SceneError> {
    let iridescence = &value["extensions"][KHR_IRIDESCENCE];
    let field = |key: &str| format!("{label}, {KHR_IRIDESCENCE}.{key}");
    let number = |key: &str, or: f64| match &iridescence[key] {
        Value::Null => Ok(or),
        stated => stated.as_f64().ok_or_else(|| {
            SceneError::new(field(key), "must be a number", "export the scene again")
        }),
    };
    let within = |key: &str, range: Range, number: f64| {
        range.check("", number).map_err(|fault| SceneError::at(&field(key), fault))
    };
    let factor = number("iridescenceFactor", 0.0)?;
    within("iridescenceFactor", Range::UNIT, factor)?;
    if factor == 0.0 {
        return Ok(bsdf);
    }
    let [ior, white_nm, black_nm] = DEFAULTS.map(|(key, or)| number(key, or));
    let (ior, white_nm, black_nm) = (ior?, white_nm?, black_nm?);
    for (key, nm) in [(DEFAULTS[1].0, white_nm), (DEFAULTS[2].0, black_nm)] {
        within(key, Range::NOT_NEGATIVE, nm)?;
    }
    let is_painted = iridescence[PICTURES[1].0].is_object();
    let black_nm = if is_painted { black_nm } else { 0.0 };
    let ends_nm = [black_nm, white_nm].map(|nm| nm as f32);
    let film = ThinFilm { share: factor as f32, ..ThinFilm::new(ior as f32, 0.0, 0.0) };
    let filmed = bsdf.clone().filmed(film.between(ends_nm));
    filmed.check().map_or_else(
        |fault| {
            let key = match fault.field.as_str() {
                "film.eta" => DEFAULTS[0].0,
                "film.thickness_nm" if black_nm > white_nm => DEFAULTS[2].0,
                "film.thickness_nm" => DEFAULTS[1].0,
                _ => {
                    let text = "its iridescence is ignored: clear coats, cloth, walls and glass \
                                with dispersion have none";
                    warnings.add(label, text);
                    return Ok(bsdf);
                }
            };
            Err(SceneError::at(&field(key), fault.of("")))
        },
        |()| Ok(filmed.clone()),
    )
}

impl Import<'_> {
    /// The pictures of a film: glTF's, or the extension's.
    pub fn paint_film(
        &mut self,
        textures: &mut Textures,
        (index, label): (usize, &str),
        bsdf: &Bsdf,
    ) -> Result<(), SceneError> {
        let (Bsdf::Filmed { film, .. }
        | Bsdf::FilmedConductor { film, .. }
        | Bsdf::FilmedDielectric { film, .. }) = bsdf
        else {
            return Ok(());
        };
        let document = self.document;
        let material = &document.value["materials"][index];
        let mut add = |parameter, texture, reads| {
            let factor = if parameter == Parameter::FilmShare { film.share } else { 1.0 };
            let paint =
                Paint { factor: [factor; 3], texture: Some(texture), reads, by_vertices: false };
            textures.parameters.push((parameter, paint));
        };
        let body = Body::of(material, label, &MATERIAL)?;
        if let Some(own) = body.object("film", &THIN_FILM)? {
            for (key, parameter) in OWN_PICTURES {
                if let Some((texture, reads)) = self.own_texture((&own, key))? {
                    add(parameter, texture, reads);
                }
            }
            return Ok(());
        }
        for (key, parameter, reads) in PICTURES {
            let info = &material["extensions"][KHR_IRIDESCENCE][key];
            let label = format!("{label}, {key}");
            let slot = Slot { info, label, coding: Coding::Linear, more: &[] };
            if let Some(texture) = self.texture(&slot)? {
                add(parameter, texture, reads);
            }
        }
        Ok(())
    }
}
