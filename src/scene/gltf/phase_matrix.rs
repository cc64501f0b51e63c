//! Tabulated phase matrices: from a CSV beside the scene, or from an object in it.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use super::Import;
use super::extension::{Body, MATRIX, Range};
use crate::scene::error::SceneError;
use crate::scene::world::TabulatedMatrix;

/// Columns of the elements, in the order of `TabulatedMatrix`.
const ELEMENTS: [&str; 6] = ["m00", "m01", "m11", "m22", "m23", "m33"];
/// Other names of the column `lambda_nm`.
const WAVELENGTH_NAMES: [&str; 3] = ["lambda", "nm", "wavelength_nm"];
/// Most rows of a table.
const ROWS_MAX: usize = 1 << 20;
/// How far an integral may be from one without a warning.
const INTEGRAL_TOLERANCE: f64 = 0.01;
/// How far an element may exceed M00, which rounding to a few digits can do.
const ELEMENT_TOLERANCE: f64 = 1e-3;
const REMEDY: &str = "columns are theta_deg, M00, M01, M11, M22, M23, M33 and perhaps lambda_nm; \
                      without M11 and M33 they are M00 and M22, as for spheres";

type Columns = BTreeMap<String, Vec<f64>>;

impl Import<'_> {
    /// The phase matrices of a medium's `table`, by increasing wavelength.
    pub fn phase_matrices(&mut self, body: &Body) -> Result<Vec<TabulatedMatrix>, SceneError> {
        let field = body.field("table");
        let columns = if !body.has("table") {
            return Err(body.missing("table", "give the path of a CSV, or an object"));
        } else if body.is_object("table") {
            match body.object("table", &MATRIX)? {
                Some(object) => columns_of(&object)?,
                None => Columns::new(),
            }
        } else {
            let uri = body.word("table")?.unwrap_or_default();
            let (columns, ignored) = parse_csv(&self.document.read_text(uri, &field)?, &field)?;
            for name in ignored {
                self.warn(format!("{field}: the column {name} is ignored"));
            }
            columns
        };
        let mut matrices = matrices(columns, &field)?;
        for matrix in &mut matrices {
            let place = match matrix.wavelength_nm {
                Some(nm) => format!("{field}, {nm} nm"),
                None => field.clone(),
            };
            let integral = checked_integral(matrix, &place)?;
            if (integral - 1.0).abs() > INTEGRAL_TOLERANCE {
                self.warn(format!("{place}: M00 integrates to {integral:.4} and is normalized"));
            }
            matrix.elements.as_flattened_mut().iter_mut().for_each(|m| *m /= integral);
        }
        Ok(matrices)
    }
}

fn columns_of(object: &Body) -> Result<Columns, SceneError> {
    let mut columns = Columns::new();
    for key in object.keys() {
        if let Some(column) = object.numbers(key, Range::ANY)? {
            columns.insert(key.to_owned(), column);
        }
    }
    Ok(columns)
}

/// Columns by their name in the first line, and the names of those that mean nothing. Empty lines
/// and lines that start with # do not count.
fn parse_csv(text: &str, field: &str) -> Result<(Columns, Vec<String>), SceneError> {
    let mut lines = (1..).zip(text.lines().map(str::trim));
    let mut lines = lines.by_ref().filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let heads = lines.next().map_or("", |(_, line)| line);
    let names: Vec<String> = heads
        .split(',')
        .map(|name| match name.trim().to_lowercase() {
            name if WAVELENGTH_NAMES.contains(&&*name) => "lambda_nm".to_owned(),
            name => name,
        })
        .collect();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
    for (number, line) in lines {
        let refuse = |problem: String| {
            Err(SceneError::new(format!("{field}, line {number}"), problem, REMEDY))
        };
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        if cells.len() != names.len() {
            return refuse(format!("has {} columns, not {}", cells.len(), names.len()));
        }
        for ((column, cell), name) in columns.iter_mut().zip(cells).zip(&names) {
            match cell.parse() {
                Ok(value) => column.push(value),
                Err(_) if !MATRIX.known.contains(&&**name) => {}
                Err(_) => return refuse(format!("`{cell}` is not a number")),
            }
        }
    }
    let mut known = Columns::new();
    let mut ignored = Vec::new();
    for (name, column) in names.into_iter().zip(columns) {
        if !MATRIX.known.contains(&&*name) {
            ignored.push(name);
        } else if known.insert(name.clone(), column).is_some() {
            return Err(SceneError::new(field, format!("has two columns {name}"), REMEDY));
        }
    }
    Ok((known, ignored))
}

/// Rows of equal wavelength become a matrix, in the order of wavelengths.
fn matrices(mut columns: Columns, field: &str) -> Result<Vec<TabulatedMatrix>, SceneError> {
    let refuse = |problem: String| Err(SceneError::new(field, problem, REMEDY));
    match (columns.contains_key("m11"), columns.contains_key("m33")) {
        (false, false) => {
            for (name, source) in [("m11", "m00"), ("m33", "m22")] {
                let column = columns.get(source).cloned().unwrap_or_default();
                columns.insert(name.to_owned(), column);
            }
        }
        (true, true) => {}
        _ => return refuse("has one of M11 and M33, and not the other".to_owned()),
    }
    let wavelengths = columns.remove("lambda_nm");
    let Some(theta) = columns.remove("theta_deg") else {
        return refuse("has no column theta_deg".to_owned());
    };
    let mut elements = [const { Vec::new() }; 6];
    for (column, name) in elements.iter_mut().zip(ELEMENTS) {
        match columns.remove(name) {
            Some(values) => *column = values,
            None => return refuse(format!("has no column {}", name.to_uppercase())),
        }
    }
    let rows = theta.len();
    let lengths = elements.iter().chain(&wavelengths).map(Vec::len);
    if lengths.into_iter().any(|length| length != rows) {
        return refuse("has columns of different lengths".to_owned());
    }
    if rows > ROWS_MAX {
        return refuse(format!("has {rows} rows, more than {ROWS_MAX}"));
    }
    let mut matrices: Vec<TabulatedMatrix> = Vec::new();
    for row in 0..rows {
        let wavelength_nm = wavelengths.as_ref().map(|column| column[row]);
        if matrices.last().is_none_or(|last| last.wavelength_nm != wavelength_nm) {
            let (theta_deg, elements) = (Vec::new(), Vec::new());
            matrices.push(TabulatedMatrix { wavelength_nm, theta_deg, elements });
        }
        if let Some(matrix) = matrices.last_mut() {
            matrix.theta_deg.push(theta[row]);
            matrix.elements.push(std::array::from_fn(|element| elements[element][row]));
        }
    }
    let nm = |matrix: &TabulatedMatrix| matrix.wavelength_nm.unwrap_or(1.0);
    let increasing = matrices.is_sorted_by(|a, b| nm(a) < nm(b));
    let positive = matrices.iter().all(|matrix| nm(matrix).is_normal() && nm(matrix) > 0.0);
    if matrices.is_empty() || !increasing || !positive {
        return refuse("needs rows, sorted by increasing wavelength in nanometers".to_owned());
    }
    Ok(matrices)
}

/// Refuses what is no phase matrix; the integral of M00 over the sphere of directions.
fn checked_integral(matrix: &TabulatedMatrix, place: &str) -> Result<f64, SceneError> {
    let refuse = |problem: String| Err(SceneError::new(place, problem, REMEDY));
    let theta = &matrix.theta_deg;
    let finite = theta.iter().chain(matrix.elements.as_flattened()).all(|x| x.is_finite());
    if !finite {
        return refuse("has values that are not finite".to_owned());
    }
    let covers = |at: Option<&f64>, end: f64| at.is_some_and(|at| (at - end).abs() < 1e-6);
    if !theta.is_sorted_by(|a, b| a < b) || theta.len() < 2 {
        return refuse("needs increasing angles, each once".to_owned());
    }
    if !covers(theta.first(), 0.0) || !covers(theta.last(), 180.0) {
        let (first, last) = (theta[0], theta[theta.len() - 1]);
        return refuse(format!("covers {first} to {last} degrees, not 0 to 180"));
    }
    for (at, [m00, others @ ..]) in theta.iter().zip(&matrix.elements) {
        if *m00 < 0.0 {
            return refuse(format!("M00 is negative at {at} degrees"));
        }
        if others.iter().any(|m| m.abs() > m00 * (1.0 + ELEMENT_TOLERANCE)) {
            return refuse(format!("an element exceeds M00 at {at} degrees"));
        }
    }
    let half_sine2 = |at: f64| (0.5 * at.to_radians()).sin().powi(2);
    let rings = theta.windows(2).zip(matrix.elements.windows(2));
    let integral: f64 = rings
        .map(|(at, m)| 2.0 * PI * (half_sine2(at[1]) - half_sine2(at[0])) * (m[0][0] + m[1][0]))
        .sum();
    if integral < f64::from(f32::MIN_POSITIVE) || !integral.is_finite() {
        return refuse(format!("M00 integrates to {integral}"));
    }
    Ok(integral)
}
