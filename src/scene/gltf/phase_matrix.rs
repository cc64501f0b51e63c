//! Tabulated phase matrices: from a CSV beside the scene, or from an object in it.

use std::collections::BTreeMap;

use super::Import;
use super::extension::{Body, MATRIX};
use crate::math::text::{excerpt, listed};
use crate::scene::error::SceneError;
use crate::scene::world::{COLUMNS, TabulatedMatrix, check_wavelengths};

/// Columns of the elements, in the order of `TabulatedMatrix`.
const ELEMENTS: [&str; 6] = ["m00", "m01", "m11", "m22", "m23", "m33"];
/// Other names of the column `lambda_nm`.
const WAVELENGTH_NAMES: [&str; 3] = ["lambda", "nm", "wavelength_nm"];
/// Most characters of a cell that an error shows: enough for a number, and too few to tell what is
/// in a file that is no table.
const CELL: usize = 20;
type Columns = BTreeMap<String, Vec<f64>>;

impl Import<'_> {
    /// The phase matrices of a medium's `table`, by increasing wavelength.
    pub fn phase_matrices(&mut self, body: &Body) -> Result<Vec<TabulatedMatrix>, SceneError> {
        let field = body.field("table");
        const REMEDY: &str = "give the path of a CSV, or an object with the columns";
        let columns = if !body.has("table") {
            return Err(body.missing("table", REMEDY));
        } else if body.is_object("table") {
            match body.object("table", &MATRIX)? {
                Some(object) => columns_of(&object)?,
                None => Columns::new(),
            }
        } else {
            let Some(uri) = body.value("table").and_then(|(value, _)| value.as_str()) else {
                return Err(SceneError::new(field, "is neither a path nor an object", REMEDY));
            };
            let (columns, ignored) = parse_csv(&self.document.read_text(uri, &field)?, &field)?;
            if let Some(text) = unread(&ignored) {
                self.warnings.add_like("columns", &field, &text);
            }
            columns
        };
        let mut matrices = matrices(columns, &field)?;
        check_wavelengths(&matrices).map_err(|fault| body.place(fault))?;
        for matrix in &mut matrices {
            let place = match matrix.wavelength_nm {
                Some(nm) => format!("{field}, {nm} nm"),
                None => field.clone(),
            };
            let integral = matrix.normalize().map_err(|fault| SceneError::at(&place, fault))?;
            if !TabulatedMatrix::is_unit(integral) {
                let text = format!("M00 integrates to {integral:.4} and is normalized");
                self.warnings.add_like("M00", &place, &text);
            }
        }
        Ok(matrices)
    }
}

/// A cell as an error shows it: itself, or if that might say what it should not, its column.
fn shown(cell: &str, column: &str) -> String {
    match excerpt(cell, CELL) == cell {
        true => format!("`{cell}`"),
        false => format!("the cell of {column}"),
    }
}

/// What is said about columns that mean nothing.
fn unread(columns: &[String]) -> Option<String> {
    let names = listed(columns.iter().map(|name| excerpt(name, CELL)));
    match columns.len() {
        0 => None,
        1 => Some(format!("the column {names} is ignored")),
        _ => Some(format!("the columns {names} are ignored")),
    }
}

fn columns_of(object: &Body) -> Result<Columns, SceneError> {
    let mut columns = Columns::new();
    for key in object.keys() {
        if let Some(column) = object.numbers(key)? {
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
            Err(SceneError::new(format!("{field}, line {number}"), problem, COLUMNS))
        };
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        if cells.len() != names.len() {
            return refuse(format!("has {} columns, not {}", cells.len(), names.len()));
        }
        for ((column, cell), name) in columns.iter_mut().zip(cells).zip(&names) {
            match cell.parse() {
                Ok(value) => column.push(value),
                Err(_) if !MATRIX.known.contains(&&**name) => {}
                Err(_) => return refuse(format!("{} is not a number", shown(cell, name))),
            }
        }
    }
    let mut known = Columns::new();
    let mut ignored = Vec::new();
    for (name, column) in names.into_iter().zip(columns) {
        if !MATRIX.known.contains(&&*name) {
            ignored.push(name);
        } else if known.insert(name.clone(), column).is_some() {
            let name = excerpt(&name, CELL);
            return Err(SceneError::new(field, format!("has two columns {name}"), COLUMNS));
        }
    }
    Ok((known, ignored))
}

/// Rows of equal wavelength become a matrix, in the order of wavelengths.
fn matrices(mut columns: Columns, field: &str) -> Result<Vec<TabulatedMatrix>, SceneError> {
    let refuse = |problem: String| Err(SceneError::new(field, problem, COLUMNS));
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
    Ok(matrices)
}
