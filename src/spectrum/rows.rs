//! Lines of the tables that users write.

use crate::math::text::excerpt;

/// Most characters of a cell that an error shows: enough for a number, and too few to tell what is
/// in a file that is no table.
const CELL: usize = 20;

/// The lines of a table that are not empty, by their numbers from 1, each in its cells. Commas,
/// semicolons and tabs separate; what follows after # in a line does not count, nor do spaces and
/// quotes around cells.
pub fn rows(text: &str) -> impl Iterator<Item = (usize, Vec<&str>)> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    (1..).zip(text.lines()).filter_map(|(number, line)| {
        let line = line.split('#').next().unwrap_or_default();
        let cells = line.split([',', ';', '\t']);
        let cells: Vec<&str> = cells.map(|cell| cell.trim().trim_matches('"').trim()).collect();
        (!line.trim().is_empty()).then_some((number, cells))
    })
}

/// A finite number; what is wrong with a cell that is none.
pub fn finite(cell: &str) -> Result<f32, String> {
    match cell.parse::<f32>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) | Err(_) => Err(format!("`{}` is not a finite number", excerpt(cell, CELL))),
    }
}
