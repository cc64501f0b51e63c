//! Spectra in the extension: numbers, colors, tables, and by what is said: names of substances and
//! illuminants, formulas, temperatures, lines, files.

use serde_json::Value;

use super::document::Document;
use super::extension::{Body, CAUCHY, EMISSION, INDEX, Keys, SELLMEIER, SPECTRUM};
use crate::math::text::excerpt;
use crate::math::{Fault, Range};
use crate::scene::error::SceneError;
use crate::scene::world::EmittedStokes;
use crate::spectrum::{
    Line, LineShape, Spectrum, SpectrumTable, illuminant_names, index, index_names,
};

/// Most characters of a name that an error quotes.
const NAME: usize = 60;
/// How tables are written.
const TABLE: &str = "{\"nm\": [...], \"value\": [...]}";
/// What of a lamp's keys says how it shines: one of them is given.
const LAMPS: [&str; 5] = ["blackbody_k", "illuminant", "lines", "nm", "spd"];

/// Part of an index of refraction n - i k.
#[derive(Clone, Copy)]
pub enum Part {
    /// n, which has formulas, too.
    Real,
    /// k.
    Extinction,
}

impl Part {
    /// The keys of its objects.
    fn keys(self) -> &'static Keys {
        match self {
            Self::Real => &INDEX,
            Self::Extinction => &SPECTRUM,
        }
    }
}

impl Body<'_> {
    /// A spectrum.
    pub fn spectrum(&self, key: &str) -> Result<Option<Spectrum>, SceneError> {
        match self.is_object(key) {
            true => self.object(key, &SPECTRUM)?.map(|body| table(&body)).transpose(),
            false => self.plain(key, TABLE),
        }
    }

    /// Part of an index of refraction: a spectrum, a formula, or that of a substance with a name.
    pub fn refraction(&self, key: &str, part: Part) -> Result<Option<Spectrum>, SceneError> {
        let Some((value, field)) = self.value(key) else { return Ok(None) };
        if let Some(name) = value.as_str() {
            let Some((n, k)) = index(name) else {
                let problem = format!("`{}` is no substance in the tables", excerpt(name, NAME));
                let remedy = format!("use one of {}", index_names().join(", "));
                return Err(SceneError::new(field, problem, remedy));
            };
            return Ok(Some(match part {
                Part::Real => n,
                Part::Extinction => k,
            }));
        }
        match self.is_object(key) {
            true => self.object(key, part.keys())?.map(|body| formula_or_table(&body)).transpose(),
            false => self.plain(key, &format!("the name of a substance, {TABLE}")),
        }
    }

    /// The spectrum of a lamp, with the files that it names.
    pub fn emission(&self, key: &str, document: &Document) -> Result<Option<Spectrum>, SceneError> {
        match self.is_object(key) {
            true => self.object(key, &EMISSION)?.map(|body| lamp(&body, document)).transpose(),
            false => {
                let name = self.value(key).and_then(|(value, _)| value.as_str());
                if let Some(name) = name.filter(|name| Spectrum::illuminant(name).is_some()) {
                    let problem =
                        format!("is not a spectrum: `{name}` is a name, which stands in an object");
                    let remedy = format!("write {{\"illuminant\": \"{name}\"}}");
                    return Err(SceneError::new(self.field(key), problem, remedy));
                }
                self.plain(key, &format!("an object with one of {}", LAMPS.join(", ")))
            }
        }
    }

    /// S1, S2 and S3 over S0 of what is emitted.
    pub fn stokes(&self, key: &str) -> Result<Option<EmittedStokes>, SceneError> {
        let Some((value, field)) = self.value(key) else { return Ok(None) };
        let Some([s1, s2, s3]) = value.as_array().map(Vec::as_slice) else {
            let remedy = "write [S1, S2, S3] over S0, each a number or a spectrum";
            return Err(SceneError::new(field, "is not three components", remedy));
        };
        let of = |index: usize, value: &Value| {
            let field = format!("{field}[{index}]");
            match value.is_object() {
                true => table(&Body::nested(value, field, &SPECTRUM)?),
                false => plain(value, &field, TABLE),
            }
        };
        let stokes = EmittedStokes::new([of(0, s1)?, of(1, s2)?, of(2, s3)?]);
        stokes.map(Some).map_err(|fault| SceneError::at(field, fault.of("")))
    }

    /// A number or a color. `others` is what else might stand there.
    fn plain(&self, key: &str, others: &str) -> Result<Option<Spectrum>, SceneError> {
        self.value(key).map(|(value, field)| plain(value, field, others)).transpose()
    }

    /// Numbers that must be there.
    fn column(&self, key: &str, remedy: &str) -> Result<Vec<f64>, SceneError> {
        self.numbers(key)?.ok_or_else(|| self.missing(key, remedy))
    }

    /// A range of wavelengths in nanometers that must be there.
    fn range_nm(&self) -> Result<[f32; 2], SceneError> {
        const REMEDY: &str = "say where the formula holds, as [300, 2500]";
        match self.column("range_nm", REMEDY)?[..] {
            [from, to] => Ok([from as f32, to as f32]),
            _ => Err(SceneError::new(self.field("range_nm"), "is not two wavelengths", REMEDY)),
        }
    }
}

/// A number or a color, which errors call `field`. `others` is what else might stand there.
pub fn plain(value: &Value, field: &str, others: &str) -> Result<Spectrum, SceneError> {
    let number = |value: &Value| {
        let number = value.as_f64().ok_or_else(|| {
            let remedy = format!("write a number, [red, green, blue] or {others}");
            match value.as_str() {
                Some(name) => {
                    let name = excerpt(name, NAME);
                    let problem =
                        format!("is not a spectrum: `{name}` is a name, and none are taken here");
                    SceneError::new(field, problem, remedy)
                }
                None => SceneError::new(field, "is not a spectrum", remedy),
            }
        })?;
        Range::ANY.check("", number).map_err(|fault| SceneError::at(field, fault))?;
        Ok::<f32, SceneError>(number as f32)
    };
    match value.as_array().map(Vec::as_slice) {
        Some([red, green, blue]) => {
            Ok(Spectrum::Rgb([number(red)?, number(green)?, number(blue)?]))
        }
        // A list of another length is no number.
        Some(_) | None => Ok(Spectrum::Constant(number(value)?)),
    }
}

/// A table of wavelengths and values.
pub fn table(body: &Body) -> Result<Spectrum, SceneError> {
    let column = |key: &str| -> Result<Vec<f32>, SceneError> {
        let column = body.column(key, &format!("write {TABLE}"))?;
        Ok(column.into_iter().map(|number| number as f32).collect())
    };
    let table = SpectrumTable::new(column("nm")?, column("value")?);
    table.map(Spectrum::Table).map_err(|problem| SceneError::new(body.label(), problem, ""))
}

/// An index of refraction by a formula, or a table.
fn formula_or_table(body: &Body) -> Result<Spectrum, SceneError> {
    let refuse = |problem| SceneError::new(body.label(), problem, "");
    let (sellmeier, cauchy) =
        (body.object("sellmeier", &SELLMEIER)?, body.object("cauchy", &CAUCHY)?);
    let is_table = body.has("nm") || body.has("value");
    match (sellmeier, cauchy) {
        (Some(sellmeier), None) if !is_table => {
            const REMEDY: &str = "n^2 = 1 + sum of b w^2 / (w^2 - c), w in um";
            let [b, c] = [sellmeier.column("b", REMEDY)?, sellmeier.column("c_um2", REMEDY)?];
            Spectrum::sellmeier(&b, &c, sellmeier.range_nm()?).map_err(refuse)
        }
        (None, Some(cauchy)) if !is_table => {
            let Some(a) = cauchy.number("a")? else {
                return Err(cauchy.missing("a", "n = a + b_um2 / w^2 + c_um4 / w^4, w in um"));
            };
            let [b_um2, c_um4] = [cauchy.number("b_um2")?, cauchy.number("c_um4")?];
            let (b_um2, c_um4) = (b_um2.unwrap_or(0.0), c_um4.unwrap_or(0.0));
            Spectrum::cauchy(a, b_um2, c_um4, cauchy.range_nm()?).map_err(refuse)
        }
        (None, None) => table(body),
        (_, _) => {
            let problem = "takes one of `sellmeier`, `cauchy` and a table";
            Err(SceneError::new(body.label(), problem, "state the index once"))
        }
    }
}

fn lamp(body: &Body, document: &Document) -> Result<Spectrum, SceneError> {
    let stated: Vec<&str> = LAMPS.into_iter().filter(|key| body.has(key)).collect();
    let spectrum = match stated[..] {
        ["blackbody_k"] => {
            let kelvin = body.number("blackbody_k")?.unwrap_or_default();
            Spectrum::blackbody(kelvin).map_err(|fault| body.place(fault))?
        }
        ["illuminant"] => illuminant(body)?,
        ["lines"] => lines(body)?,
        ["nm"] => table(body)?,
        ["spd"] => spd(body, document)?,
        _ => {
            let problem = format!("takes one of {}", LAMPS.join(", "));
            return Err(SceneError::new(body.label(), problem, "say once how it shines"));
        }
    };
    for (key, of) in [("shape", "lines"), ("value", "nm")] {
        if body.has(key) && !body.has(of) {
            let problem = format!("means nothing without `{of}`");
            return Err(SceneError::new(body.field(key), problem, "remove it"));
        }
    }
    let scale = body.number("scale")?.unwrap_or(1.0);
    Range::NOT_NEGATIVE.check("scale", scale).map_err(|fault| body.place(fault))?;
    Ok(spectrum.scaled(scale as f32))
}

fn illuminant(body: &Body) -> Result<Spectrum, SceneError> {
    let name = body.word("illuminant")?.unwrap_or_default();
    Spectrum::illuminant(name).ok_or_else(|| {
        let problem = format!("`{}` is no illuminant in the tables", excerpt(name, NAME));
        let remedy = format!("use one of {}", illuminant_names().join(", "));
        SceneError::new(body.field("illuminant"), problem, remedy)
    })
}

fn lines(body: &Body) -> Result<Spectrum, SceneError> {
    const REMEDY: &str = "write [[nm, power, width_nm], ...]";
    let refuse = |place: &str| {
        SceneError::new(body.field(place), "is not three numbers for every line", REMEDY)
    };
    let shape = match body.word("shape")? {
        Some("gaussian") | None => LineShape::Gaussian,
        Some("box") => LineShape::Box,
        Some(other) => {
            let problem = format!("`{}` is not the shape of a line", excerpt(other, NAME));
            let remedy = "use \"gaussian\" or \"box\"";
            return Err(SceneError::new(body.field("shape"), problem, remedy));
        }
    };
    let list = body.value("lines").and_then(|(value, _)| value.as_array());
    let line = |value: &Value| match value.as_array().map(Vec::as_slice) {
        Some([nm, power, width]) => Some(Line {
            center_nm: nm.as_f64()?,
            power: power.as_f64()?,
            width_nm: width.as_f64()?,
        }),
        Some(_) | None => None,
    };
    let lines: Option<Vec<Line>> = list.ok_or_else(|| refuse("lines"))?.iter().map(line).collect();
    let lines = lines.ok_or_else(|| refuse("lines"))?;
    Spectrum::lines(&lines, shape).map_err(|fault| body.place(fault))
}

fn spd(body: &Body, document: &Document) -> Result<Spectrum, SceneError> {
    let (uri, field) = (body.word("spd")?.unwrap_or_default(), body.field("spd"));
    let table = SpectrumTable::from_spd(&document.read_text(uri, &field)?);
    table.map(Spectrum::Table).map_err(|Fault { field: line, problem, remedy }| {
        let place = if line.is_empty() { field } else { format!("{field}, {line}") };
        SceneError::new(place, problem, remedy)
    })
}
