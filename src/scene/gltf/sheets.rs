//! Sheets that let light straight on: polarizers, retarders, both on each other, and what has a
//! given Mueller matrix.

use serde_json::{Value, json};

use super::extension::{Body, SPECTRUM};
use super::spectra::{plain, table};
use crate::math::Range;
use crate::math::text::excerpt;
use crate::scene::error::SceneError;
use crate::scene::world::{Action, Bsdf, Delay, Grid, Hand};
use crate::spectrum::Spectrum;

/// Keys of polarizers.
pub const POLARIZER: [&str; 4] = ["axis_deg", "blocked", "extinction_ratio", "transmittance"];
/// Keys of retarders.
pub const RETARDER: [&str; 4] = ["axis_deg", "birefringence", "retardance_deg", "thickness_um"];
/// Keys of polarizers with a retarder behind.
pub const CIRCULAR: [&str; 8] = [
    "axis_deg",
    "birefringence",
    "blocked",
    "extinction_ratio",
    "handedness",
    "retardance_deg",
    "thickness_um",
    "transmittance",
];
/// Keys of Mueller matrices.
pub const MUELLER: [&str; 2] = ["axis_deg", "matrix"];

/// Most characters of a name that an error quotes.
const NAME: usize = 60;
/// Nanometers in a micrometer.
const NM_PER_UM: f32 = 1000.0;
/// How matrices are written.
const ROWS: &str = "write four rows of four elements, each a number or a spectrum";

fn axis_deg(body: &Body) -> Result<f64, SceneError> {
    Ok(body.number("axis_deg")?.unwrap_or(0.0))
}

/// An ideal polarizer with an extinction ratio, or one by its transmittances.
pub fn polarizer(body: &Body) -> Result<Bsdf, SceneError> {
    let axis_deg = axis_deg(body)?;
    if body.has("transmittance") || body.has("blocked") {
        return Ok(Bsdf::Sheet { axis_deg, action: Action::Polarizer(grid(body)?) });
    }
    let extinction_ratio = body.number("extinction_ratio")?.unwrap_or(f64::INFINITY);
    Ok(Bsdf::Polarizer { axis_deg, extinction_ratio })
}

/// Transmittances of both axes, of which that across may follow from a ratio.
fn grid(body: &Body) -> Result<Grid<Spectrum>, SceneError> {
    let transmittance = body.spectrum("transmittance")?.unwrap_or(Spectrum::Constant(1.0));
    let blocked = match (body.spectrum("blocked")?, body.number("extinction_ratio")?) {
        (Some(_), Some(_)) => {
            let problem = "takes either `blocked` or `extinction_ratio`";
            return Err(SceneError::new(body.label(), problem, "remove one of them"));
        }
        (Some(blocked), None) => blocked,
        (None, Some(ratio)) => {
            Range::AT_LEAST_ONE
                .check("extinction_ratio", ratio)
                .map_err(|fault| body.place(fault))?;
            transmittance.clone().scaled(ratio.recip() as f32)
        }
        (None, None) => Spectrum::Constant(0.0),
    };
    Ok(Grid { transmittance, blocked })
}

/// A retarder of one retardance, or by its spectrum.
pub fn retarder(body: &Body) -> Result<Bsdf, SceneError> {
    let axis_deg = axis_deg(body)?;
    match delay(body)? {
        Some(Delay::Degrees(Spectrum::Constant(_))) => {
            // As it stands: spectra have half of the digits.
            let retardance_deg = body.number("retardance_deg")?.unwrap_or_default();
            Ok(Bsdf::retarder(axis_deg, retardance_deg))
        }
        Some(delay) => Ok(Bsdf::Sheet { axis_deg, action: Action::Retarder(delay) }),
        None => {
            let remedy = "90 for a quarter-wave plate, 180 for a half-wave plate; or give \
                          `birefringence` and `thickness_um`";
            Err(SceneError::new(body.field("retardance_deg"), "is missing", remedy))
        }
    }
}

/// By which light lags, if it is stated.
fn delay(body: &Body) -> Result<Option<Delay<Spectrum>>, SceneError> {
    let degrees = body.spectrum("retardance_deg")?;
    let of_crystal = (body.spectrum("birefringence")?, body.number("thickness_um")?);
    match (degrees, of_crystal) {
        (None, (None, None)) => Ok(None),
        (Some(degrees), (None, None)) => Ok(Some(Delay::Degrees(degrees))),
        (None, (Some(birefringence), Some(um))) => {
            let thickness = Spectrum::Constant(um as f32 * NM_PER_UM);
            Ok(Some(Delay::Crystal { birefringence, thickness }))
        }
        (_, _) => {
            let problem = "takes either `retardance_deg` or both `birefringence` and \
                           `thickness_um`";
            Err(SceneError::new(body.label(), problem, "state the retardance once"))
        }
    }
}

/// A polarizer with a retarder behind.
pub fn circular_polarizer(body: &Body) -> Result<Bsdf, SceneError> {
    let hand = match body.word("handedness")? {
        None => Hand::default(),
        Some(name) => Hand::named(name).ok_or_else(|| {
            let problem = format!("`{}` is no sense of rotation", excerpt(name, NAME));
            let remedy = format!("use {}", Hand::ALL.map(Hand::name).join(" or "));
            SceneError::new(body.field("handedness"), problem, remedy)
        })?,
    };
    let retarder = delay(body)?.unwrap_or(Delay::Degrees(Spectrum::Constant(90.0)));
    let action = Action::Circular { polarizer: grid(body)?, retarder, hand };
    Ok(Bsdf::Sheet { axis_deg: axis_deg(body)?, action })
}

/// What has a given Mueller matrix.
pub fn mueller(body: &Body) -> Result<Bsdf, SceneError> {
    Ok(Bsdf::Sheet { axis_deg: axis_deg(body)?, action: Action::Matrix(matrix(body)?) })
}

/// Four rows of four spectra.
fn matrix(body: &Body) -> Result<[Spectrum; 16], SceneError> {
    let Some((value, field)) = body.value("matrix") else {
        return Err(body.missing("matrix", ROWS));
    };
    let wrong = || SceneError::new(field, "is not a matrix", ROWS);
    let mut elements = Vec::with_capacity(16);
    for (row, values) in value.as_array().ok_or_else(wrong)?.iter().enumerate() {
        let values = values.as_array().filter(|values| values.len() == 4).ok_or_else(wrong)?;
        for (column, value) in values.iter().enumerate() {
            elements.push(element(value, format!("{field}[{row}][{column}]"))?);
        }
    }
    <[Spectrum; 16]>::try_from(elements).map_err(|_| wrong())
}

fn element(value: &Value, field: String) -> Result<Spectrum, SceneError> {
    match value.is_object() {
        true => table(&Body::nested(value, field, &SPECTRUM)?),
        false => plain(value, &field, "a table"),
    }
}

/// The keys of a sheet, with what writes spectra.
pub fn written(
    axis_deg: f64,
    action: &Action<Spectrum>,
    mut of: impl FnMut(&Spectrum) -> Value,
) -> Value {
    let mut body = json!({"axis_deg": axis_deg});
    let mut put_grid = |body: &mut Value, grid: &Grid<Spectrum>| {
        body["transmittance"] = of(&grid.transmittance);
        body["blocked"] = of(&grid.blocked);
    };
    match action {
        Action::Polarizer(grid) => {
            body["bsdf"] = json!("polarizer");
            put_grid(&mut body, grid);
        }
        Action::Retarder(delay) => {
            body["bsdf"] = json!("retarder");
            put_delay(&mut body, delay, &mut of);
        }
        Action::Circular { polarizer, retarder, hand } => {
            body["bsdf"] = json!("circular_polarizer");
            body["handedness"] = json!(hand.name());
            put_grid(&mut body, polarizer);
            put_delay(&mut body, retarder, &mut of);
        }
        Action::Matrix(elements) => {
            body["bsdf"] = json!("mueller");
            let rows = elements.chunks(4).map(|row| row.iter().map(&mut of).collect::<Value>());
            body["matrix"] = rows.collect();
        }
    }
    body
}

fn put_delay(body: &mut Value, delay: &Delay<Spectrum>, of: &mut impl FnMut(&Spectrum) -> Value) {
    match delay {
        Delay::Degrees(degrees) => body["retardance_deg"] = of(degrees),
        Delay::Crystal { birefringence, thickness } => {
            body["birefringence"] = of(birefringence);
            body["thickness_um"] = of(&thickness.clone().scaled(NM_PER_UM.recip()));
        }
    }
}
