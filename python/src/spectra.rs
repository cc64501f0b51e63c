//! Spectra in the keyword arguments of worlds: numbers, colors, tables, and by name and formula, as
//! in scene files.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use sunstone::Spectrum;
use sunstone::internals::math::text::sentence;
use sunstone::spectra::{Line, LineShape, illuminant_names, index, index_names, metal};
use sunstone::world::EmittedStokes;

use crate::errors::SCENE_ERROR;
use crate::keys::{Keys, holds_truth};

/// What of a lamp's keys says how it shines: one of them is given.
const LAMPS: [&str; 4] = ["blackbody_k", "illuminant", "lines", "nm"];

/// Part of an index of refraction n - i k.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// n, which has formulas, too.
    Real,
    /// k.
    Extinction,
}

impl Keys<'_> {
    /// Takes a spectrum.
    pub fn spectrum(&self, key: &str) -> PyResult<Option<Spectrum>> {
        let value: Option<Bound<PyAny>> = self.take(key)?;
        value.map(|value| spectrum(&self.place_of(key), &value)).transpose()
    }

    /// Takes a spectrum that must be there.
    pub fn need_spectrum(&self, key: &str, remedy: &str) -> PyResult<Spectrum> {
        self.spectrum(key)?.ok_or_else(|| self.refuse(key, "is missing", remedy))
    }

    /// Takes the spectrum of what shines.
    pub fn lamp(&self, key: &str) -> PyResult<Option<Spectrum>> {
        let value: Option<Bound<PyAny>> = self.take(key)?;
        value.map(|value| lamp(&self.place_of(key), &value)).transpose()
    }

    /// Takes S1, S2 and S3 over S0 of what is emitted.
    pub fn stokes(&self, key: &str) -> PyResult<Option<EmittedStokes>> {
        let value: Option<Bound<PyAny>> = self.take(key)?;
        value.map(|value| stokes(&self.place_of(key), &value)).transpose()
    }

    /// Takes part of an index of refraction: a spectrum, a formula, or that of a substance.
    pub fn refraction(&self, key: &str, part: Part) -> PyResult<Option<Spectrum>> {
        let value: Option<Bound<PyAny>> = self.take(key)?;
        value.map(|value| self.refraction_of(key, &value, part)).transpose()
    }

    /// Takes the index of refraction of a dielectric.
    pub fn index(&self, key: &str) -> PyResult<Option<Spectrum>> {
        let Some(value) = self.take::<Bound<PyAny>>(key)? else { return Ok(None) };
        if let Ok(name) = value.cast::<PyString>()
            && metal(&name.to_cow()?).is_some()
        {
            return Err(self.refuse(key, &format!("`{name}` is a metal"), "make it a conductor"));
        }
        self.refraction_of(key, &value, Part::Real).map(Some)
    }

    fn refraction_of(&self, key: &str, value: &Bound<PyAny>, part: Part) -> PyResult<Spectrum> {
        if let Ok(name) = value.cast::<PyString>() {
            let Some((n, k)) = index(&name.to_cow()?) else {
                let problem = format!("`{name}` is no substance in the tables");
                let remedy = format!("use one of {}", index_names().join(", "));
                return Err(self.refuse(key, &problem, &remedy));
            };
            return Ok(match part {
                Part::Real => n,
                Part::Extinction => k,
            });
        }
        if let (Ok(object), Part::Real) = (value.cast::<PyDict>(), part) {
            let keys = Keys::of(self.place_of(key), object)?;
            if let Some(formula) = formula(&keys)? {
                keys.finish("a formula")?;
                return Ok(formula);
            }
        }
        spectrum(&self.place_of(key), value)
    }
}

/// Sellmeier's or Cauchy's formula, if one is given.
fn formula(keys: &Keys) -> PyResult<Option<Spectrum>> {
    const RANGE: &str = "say where the formula holds, as [300, 2500]";
    let (formula, made) = if let Some(sellmeier) = keys.part("sellmeier")? {
        const REMEDY: &str = "n^2 = 1 + sum of b w^2 / (w^2 - c), w in um";
        let [b, c]: [Vec<f64>; 2] =
            [sellmeier.need("b", REMEDY)?, sellmeier.need("c_um2", REMEDY)?];
        let made = Spectrum::sellmeier(&b, &c, sellmeier.need("range_nm", RANGE)?);
        (sellmeier, made)
    } else if let Some(cauchy) = keys.part("cauchy")? {
        let a = cauchy.need("a", "n = a + b_um2 / w^2 + c_um4 / w^4, w in um")?;
        let number = |key| Ok::<f64, PyErr>(cauchy.take(key)?.unwrap_or(0.0));
        let [b_um2, c_um4] = [number("b_um2")?, number("c_um4")?];
        let made = Spectrum::cauchy(a, b_um2, c_um4, cauchy.need("range_nm", RANGE)?);
        (cauchy, made)
    } else {
        return Ok(None);
    };
    let made = made.map_err(|problem| formula.refuse("", problem, ""))?;
    formula.finish("this formula")?;
    Ok(Some(made))
}

/// The spectrum of what shines.
pub fn lamp(place: &str, value: &Bound<PyAny>) -> PyResult<Spectrum> {
    if let Ok(name) = value.cast::<PyString>()
        && Spectrum::illuminant(&name.to_cow()?).is_some()
    {
        let problem = format!("`{name}` is a name: give {{\"illuminant\": \"{name}\"}}");
        return Err(SCENE_ERROR.says(sentence(place, &problem)));
    }
    let Ok(object) = value.cast::<PyDict>() else { return spectrum(place, value) };
    let keys = Keys::of(place, object)?;
    let scale: f32 = keys.take("scale")?.unwrap_or(1.0);
    if !(scale.is_finite() && scale >= 0.0) {
        return Err(keys.refuse("scale", &format!("{scale} must be finite and not negative"), ""));
    }
    let made = if let Some(name) = keys.take::<String>("illuminant")? {
        Spectrum::illuminant(&name).ok_or_else(|| {
            let remedy = format!("use one of {}", illuminant_names().join(", "));
            keys.refuse("illuminant", &format!("`{name}` is no illuminant in the tables"), &remedy)
        })?
    } else if let Some(kelvin) = keys.take("blackbody_k")? {
        Spectrum::blackbody(kelvin).map_err(|fault| keys.fault(&fault))?
    } else if let Some(rows) = keys.take::<Vec<[f64; 3]>>("lines")? {
        lines(&keys, &rows)?
    } else if object.contains("nm")? {
        table(&keys)?
    } else {
        let problem = format!("takes one of {}", LAMPS.join(", "));
        return Err(keys.refuse("", &problem, "say once how it shines"));
    };
    keys.finish("this lamp")?;
    Ok(made.scaled(scale))
}

fn lines(keys: &Keys, rows: &[[f64; 3]]) -> PyResult<Spectrum> {
    let shape = match keys.take::<String>("shape")?.as_deref() {
        Some("gaussian") | None => LineShape::Gaussian,
        Some("box") => LineShape::Box,
        Some(other) => {
            let problem = format!("`{other}` is not the shape of a line");
            return Err(keys.refuse("shape", &problem, "use \"gaussian\" or \"box\""));
        }
    };
    let line = |&[center_nm, power, width_nm]: &[f64; 3]| Line { center_nm, power, width_nm };
    let lines: Vec<Line> = rows.iter().map(line).collect();
    Spectrum::lines(&lines, shape).map_err(|fault| keys.fault(&fault))
}

/// S1, S2 and S3 over S0, each a spectrum.
pub fn stokes(place: &str, value: &Bound<PyAny>) -> PyResult<EmittedStokes> {
    let components = value.extract::<Vec<Bound<PyAny>>>();
    let Ok([s1, s2, s3]) = components.as_deref() else {
        let problem = "is not three components: give [S1, S2, S3] over S0, each a spectrum";
        return Err(SCENE_ERROR.says(sentence(place, problem)));
    };
    let of = |index: usize, value| spectrum(&format!("{place}[{index}]"), value);
    let stokes = EmittedStokes::new([of(0, s1)?, of(1, s2)?, of(2, s3)?]);
    stokes.map_err(|fault| SCENE_ERROR.says(fault.of(place)))
}

/// A number, red, green and blue, or {"nm": [...], "value": [...]}.
fn spectrum(place: &str, value: &Bound<PyAny>) -> PyResult<Spectrum> {
    const FORMS: &str =
        "a spectrum is a number, [red, green, blue] or {\"nm\": [...], \"value\": [...]}";
    let refuse = |problem: &str| SCENE_ERROR.says(sentence(place, problem));
    if let Ok(name) = value.cast::<PyString>() {
        return Err(refuse(&format!("`{name}` is a name, and none are taken here: {FORMS}")));
    }
    if let Ok(object) = value.cast::<PyDict>() {
        let keys = Keys::of(place, object)?;
        let made = table(&keys);
        keys.finish("a spectrum")?;
        return made;
    }
    if holds_truth(value) {
        return Err(refuse(FORMS));
    }
    if let Ok(constant) = value.extract::<f32>() {
        return Ok(constant.into());
    }
    match value.extract::<Vec<f32>>().as_deref() {
        Ok(&[red, green, blue]) => Ok([red, green, blue].into()),
        _ => Err(refuse(FORMS)),
    }
}

fn table(keys: &Keys) -> PyResult<Spectrum> {
    let nm: Vec<f32> = keys.need("nm", "give the wavelengths in nanometers")?;
    let values: Vec<f32> = keys.need("value", "give as many values as wavelengths")?;
    Spectrum::table(&nm, &values).map_err(|problem| keys.refuse("", problem, ""))
}
