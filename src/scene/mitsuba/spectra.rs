//! Spectra and colors: as properties, and as objects with types.

use super::fields::{Fields, Given};
use super::text;
use super::tree::{Curve, NAME, Tag, Value};
use crate::math::Range;
use crate::math::elementary::exp_m1;
use crate::math::text::excerpt;
use crate::scene::error::SceneError;
use crate::spectrum::color_space::RgbResponse;
use crate::spectrum::{Spectrum, SpectrumTable, White};

/// What a spectrum is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Light: colors are of what shines like the white, and nothing shines outside of a table.
    Emission,
    /// A share, or a coefficient: zero outside of a table.
    Share,
    /// An index of refraction, of which nothing is known outside of a table.
    Index,
}

impl Fields<'_> {
    /// A spectrum: a property, or an object of that name. None if neither is there.
    pub fn spectrum(&self, name: &str, kind: Kind) -> Result<Option<Spectrum>, SceneError> {
        match self.given(name) {
            None => Ok(None),
            Some(Given::Property(property)) => {
                let value = spectrum(&property.value, kind);
                value.map(Some).ok_or_else(|| self.of_kind(name, &property.value, "a spectrum"))
            }
            Some(Given::Object(object)) => texture(&Fields::of(self.tree, object), kind).map(Some),
        }
    }

    /// A spectrum, or the number that holds if nothing is said.
    pub fn spectrum_or(&self, name: &str, kind: Kind, or: f64) -> Result<Spectrum, SceneError> {
        Ok(self.spectrum(name, kind)?.unwrap_or_else(|| of_number(or, kind)))
    }

    /// Refuses a factor that is not one: nothing in nature scales what these surfaces do.
    pub fn factor_of_one(&self, name: &str) -> Result<(), SceneError> {
        let factor = self.spectrum_or(name, Kind::Share, 1.0)?;
        if factor.values().iter().all(|value| *value == 1.0) {
            return Ok(());
        }
        Err(self.wrong(name, "only 1 is supported", "remove it"))
    }
}

/// A number: of light, that of the white.
fn of_number(value: f64, kind: Kind) -> Spectrum {
    match kind {
        Kind::Emission => Spectrum::Rgb([value as f32; 3]),
        Kind::Share | Kind::Index => Spectrum::Constant(value as f32),
    }
}

fn spectrum(value: &Value, kind: Kind) -> Option<Spectrum> {
    match value {
        Value::Float(value) => Some(of_number(*value, kind)),
        Value::Integer(value) => Some(of_number(*value as f64, kind)),
        Value::Rgb([red, green, blue]) if red == green && green == blue => {
            Some(of_number(*red, kind))
        }
        Value::Rgb(rgb) => Some(Spectrum::Rgb(rgb.map(|value| value as f32))),
        Value::Spectrum(curve) => of_curve(curve, kind),
        Value::Boolean(_) | Value::Text(_) | Value::Vector(_) | Value::Transform(_) => None,
    }
}

fn of_curve(curve: &Curve, kind: Kind) -> Option<Spectrum> {
    /// Where tables end that are zero outside, and those that are not.
    const OUTSIDE_NM: [f32; 2] = [1.0, 1e5];
    let pairs = match curve {
        // Light that is the same at all wavelengths is not white.
        Curve::Uniform(value) if kind == Kind::Emission => {
            let values = vec![*value as f32; 2];
            let table = SpectrumTable::new(OUTSIDE_NM.to_vec(), values).ok()?;
            return Some(seen(table, kind));
        }
        Curve::Uniform(value) => return Some(Spectrum::Constant(*value as f32)),
        Curve::Table(pairs) => pairs,
    };
    let mut nm: Vec<f32> = pairs.iter().map(|pair| pair[0] as f32).collect();
    let mut values: Vec<f32> = pairs.iter().map(|pair| pair[1] as f32).collect();
    let (first, last) = (*nm.first()?, *nm.last()?);
    let [before, behind] = OUTSIDE_NM;
    if kind != Kind::Index && first.next_down() > before && last.next_up() < behind {
        nm.splice(0..0, [before, first.next_down()]);
        nm.extend([last.next_up(), behind]);
        values.splice(0..0, [0.0; 2]);
        values.extend([0.0; 2]);
    }
    let table = SpectrumTable::new(nm, values).ok()?;
    Some(seen(table, kind))
}

/// The same, which in RGB has the color that is seen: of light, or of what daylight leaves of it.
fn seen(table: SpectrumTable, kind: Kind) -> Spectrum {
    let white = match kind {
        Kind::Emission => White::E,
        Kind::Share | Kind::Index => White::D65,
    };
    let whole = Spectrum::Table(table.clone());
    let rgb = color_of(&whole, white);
    // What is outside of the colors of a screen is taken as what is next to it. Of a share no
    // channel has more than there is at any wavelength, up to all of it.
    let greatest = whole.values().iter().fold(1.0_f32, |a, b| a.max(*b)).into();
    let [least, most] = match kind {
        Kind::Emission => [0.0, f64::INFINITY],
        Kind::Share => [0.0, greatest],
        Kind::Index => [INDEX_MIN, f64::INFINITY],
    };
    Spectrum::Table(table.seen_as(rgb.map(|value| value.clamp(least, most) as f32)))
}

/// An index of refraction out of tables by name, which in RGB has the color of its curve.
pub fn index_of_name(spectrum: Spectrum) -> Spectrum {
    let rgb = color_of(&spectrum, White::E);
    match spectrum {
        Spectrum::Table(table) => {
            Spectrum::Table(table.seen_as(rgb.map(|value| value.max(INDEX_MIN) as f32)))
        }
        other @ (Spectrum::Constant(_) | Spectrum::Rgb(_) | Spectrum::Formula(_)) => other,
    }
}

/// Least index of refraction in a channel, where the color of a curve would be outside of those of
/// a screen.
const INDEX_MIN: f64 = 1e-3;

/// The color of a spectrum under a white, linear sRGB; nothing is where it says nothing.
fn color_of(spectrum: &Spectrum, white: White) -> [f64; 3] {
    let value = |nm: f64| f64::from(spectrum.at(nm as f32).unwrap_or(0.0));
    RgbResponse::new().rgb(|nm| value(nm) * white.at(nm))
}

/// What reads an object.
type Read = fn(&Fields, Kind) -> Result<Spectrum, SceneError>;

/// The objects that are spectra, by type.
const TYPES: [(&str, Read); 7] = [
    ("uniform", flat),
    ("rawconstant", flat),
    ("srgb", |fields, _| color(fields, 1.0)),
    ("d65", |fields, _| daylight(fields)),
    ("blackbody", |fields, _| blackbody(fields)),
    ("irregular", irregular),
    ("regular", regular),
];

fn texture(fields: &Fields, kind: Kind) -> Result<Spectrum, SceneError> {
    let object = fields.object;
    if object.tag != Tag::Texture {
        let problem = format!("is a {}, and not a spectrum", object.tag.name());
        return Err(fields.refuse(problem, ""));
    }
    let Some((_, read)) = TYPES.iter().find(|(name, _)| *name == object.plugin) else {
        let problem = format!("`{}` is not supported", excerpt(&object.plugin, NAME));
        let names: Vec<&str> = TYPES.iter().map(|(name, _)| *name).collect();
        let remedy = format!("what does not vary over a surface is: {}", names.join(", "));
        return Err(fields.refuse(problem, remedy));
    };
    let spectrum = read(fields, kind)?;
    fields.finish()?;
    Ok(spectrum)
}

fn flat(fields: &Fields, kind: Kind) -> Result<Spectrum, SceneError> {
    let curve = Curve::Uniform(fields.number("value")?.unwrap_or(1.0));
    of_curve(&curve, kind).ok_or_else(|| fields.refuse("has a value that is not finite", ""))
}

fn color(fields: &Fields, scale: f64) -> Result<Spectrum, SceneError> {
    match fields.property("color").map(|property| &property.value) {
        Some(Value::Rgb(rgb)) => Ok(Spectrum::Rgb(rgb.map(|value| (value * scale) as f32))),
        Some(other) => Err(fields.of_kind("color", other, "an rgb")),
        None => Ok(Spectrum::Rgb([scale as f32; 3])),
    }
}

/// Daylight, which colors of light shine like.
fn daylight(fields: &Fields) -> Result<Spectrum, SceneError> {
    let scale = fields.number("scale")?.unwrap_or(1.0);
    color(fields, scale)
}

/// W/(m^2 sr nm) by Planck's law.
fn blackbody(fields: &Fields) -> Result<Spectrum, SceneError> {
    /// Planck's constant times twice the square of the speed of light, in W nm^5 / (m^2 sr nm), and
    /// the second radiation constant in nm K, of the SI of 2019.
    const FIRST: f64 = 1.191_042_972e20;
    const SECOND_NM_K: f64 = 1.438_776_877e7;
    const NM: f32 = 555.0;
    let Some(kelvin) = fields.number("temperature")? else {
        return Err(fields.wrong("temperature", "is missing", "give it in kelvin"));
    };
    fields.ignore(&["wavelength_min", "wavelength_max"]);
    let relative =
        Spectrum::blackbody(kelvin).map_err(|fault| fields.fault(fault.of("temperature"), &[]))?;
    let nm = f64::from(NM);
    let absolute = FIRST / nm.powi(5) / exp_m1(SECOND_NM_K / (nm * kelvin));
    let own = relative.at(NM).map_err(|error| fields.refuse(error.to_string(), ""))?;
    Ok(relative.scaled((absolute / f64::from(own)) as f32))
}

fn irregular(fields: &Fields, kind: Kind) -> Result<Spectrum, SceneError> {
    if let Some(property) = fields.property("value") {
        let found = spectrum(&property.value, kind);
        return found.ok_or_else(|| fields.of_kind("value", &property.value, "a spectrum"));
    }
    let nm = list(fields, "wavelengths")?;
    let values = list(fields, "values")?;
    if nm.len() != values.len() {
        let problem = format!("has {} values for {} wavelengths", values.len(), nm.len());
        return Err(fields.refuse(problem, ""));
    }
    of_pairs(fields, nm.into_iter().zip(values).map(|(nm, value)| [nm, value]).collect(), kind)
}

fn regular(fields: &Fields, kind: Kind) -> Result<Spectrum, SceneError> {
    let mut ends = [0.0; 2];
    for (end, name) in ends.iter_mut().zip(["wavelength_min", "wavelength_max"]) {
        let value = fields.number(name)?;
        *end = value.ok_or_else(|| fields.wrong(name, "is missing", "give it in nanometers"))?;
    }
    let values = list(fields, "values")?;
    let last = values.len().saturating_sub(1).max(1) as f64;
    let nm = |index: usize| ends[0] + (ends[1] - ends[0]) * index as f64 / last;
    of_pairs(fields, values.iter().enumerate().map(|(i, value)| [nm(i), *value]).collect(), kind)
}

fn list(fields: &Fields, name: &str) -> Result<Vec<f64>, SceneError> {
    let text = fields.text(name)?;
    let text = text.ok_or_else(|| fields.wrong(name, "is missing", "give a list of numbers"))?;
    text::numbers(text).map_err(|problem| fields.wrong(name, problem, ""))
}

fn of_pairs(fields: &Fields, pairs: Vec<[f64; 2]>, kind: Kind) -> Result<Spectrum, SceneError> {
    let curve = text::table(pairs).map_err(|problem| fields.refuse(problem, ""))?;
    let spectrum = of_curve(&curve, kind);
    spectrum.ok_or_else(|| fields.refuse("has values that are not finite", ""))
}

/// What is made of two spectra, number by number; of tables at the wavelengths of both. None if one
/// is a color and the other a table.
pub fn product(a: &Spectrum, b: &Spectrum, f: impl Fn(f32, f32) -> f32) -> Option<Spectrum> {
    if let (Spectrum::Constant(a), Spectrum::Constant(b)) = (a, b) {
        return Some(Spectrum::Constant(f(*a, *b)));
    }
    let is_table = |of: &Spectrum| of.ends_nm().is_some();
    if !is_table(a) && !is_table(b) {
        let channel = |of: &Spectrum, index: usize| {
            let values = of.values();
            values.get(index).copied().unwrap_or(values[0])
        };
        let rgb = std::array::from_fn(|index| f(channel(a, index), channel(b, index)));
        return Some(Spectrum::Rgb(rgb));
    }
    if [a, b].into_iter().any(|of| matches!(of, Spectrum::Rgb(_))) {
        return None;
    }
    let mut nm = [a.knots_nm(), b.knots_nm()].concat();
    nm.sort_by(f32::total_cmp);
    nm.dedup();
    let is_within = |of: &Spectrum, nm: f32| {
        of.ends_nm().is_none_or(|[first, last]| (first..=last).contains(&nm))
    };
    nm.retain(|nm| is_within(a, *nm) && is_within(b, *nm));
    let at = |nm: &f32| Some(f(a.at(*nm).ok()?, b.at(*nm).ok()?));
    let values: Option<Vec<f32>> = nm.iter().map(at).collect();
    Spectrum::table(&nm, &values?).ok()
}

/// Refuses a spectrum with values outside of a range.
pub fn check(
    fields: &Fields,
    name: &str,
    spectrum: &Spectrum,
    range: Range,
) -> Result<(), SceneError> {
    spectrum.check("", range).map_err(|fault| fields.wrong(name, fault.problem, fault.remedy))
}
