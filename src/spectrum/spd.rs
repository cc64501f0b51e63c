//! Files of measured spectra: two columns, wavelength in nanometers and value.

use super::SpectrumTable;
use super::rows::finite;
use crate::math::Fault;

const REMEDY: &str =
    "write a wavelength in nanometers and a value in every line; # starts comments";

impl SpectrumTable {
    /// Reads a `.spd` file: a vacuum wavelength in nanometers and a value in every line, apart by
    /// spaces, tabs, commas or semicolons; wavelengths increase. What follows after # in a line,
    /// and empty lines, do not count.
    ///
    /// # Errors
    /// With the line, as the field of the fault, that has something else, and when there is none.
    pub fn from_spd(text: &str) -> Result<Self, Fault> {
        let (mut wavelengths_nm, mut values) = (Vec::new(), Vec::new());
        for (number, line) in (1..).zip(text.lines()) {
            let line = line.split('#').next().unwrap_or_default();
            let separators = |letter: char| letter.is_whitespace() || ",;".contains(letter);
            let cells: Vec<&str> = line.split(separators).filter(|cell| !cell.is_empty()).collect();
            let refuse = |problem: String| Fault::new(format!("line {number}"), problem, REMEDY);
            let [nm, value] = match cells[..] {
                [] => continue,
                [nm, value] => [nm, value],
                _ => return Err(refuse(format!("has {} columns, not 2", cells.len()))),
            };
            let [nm, value] = [finite(nm), finite(value)].map(|read| read.map_err(refuse));
            let (nm, value) = (nm?, value?);
            if nm <= wavelengths_nm.last().copied().unwrap_or(0.0) {
                return Err(refuse(format!("{nm} nm is not greater than what is before it")));
            }
            wavelengths_nm.push(nm);
            values.push(value);
        }
        Self::new(wavelengths_nm, values)
            .map_err(|problem| Fault::new("", format!("the file {problem}"), REMEDY))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Spectrum;

    #[test]
    fn files_are_read_with_comments_and_any_separator() {
        let text = "# a lamp\r\n\n380 0.5\r\n 400,\t1e0 # peak\n420;2\n430.5  0";
        let spectrum = Spectrum::from(SpectrumTable::from_spd(text).unwrap());
        assert_eq!(spectrum.values(), [0.5, 1.0, 2.0, 0.0]);
        assert_eq!(spectrum.at(410.0), Ok(1.5));
        assert_eq!(spectrum.at(379.0).unwrap_err().first_nm, 380.0);
        let one = Spectrum::from(SpectrumTable::from_spd("550 1").unwrap());
        assert_eq!(one.at(550.0), Ok(1.0));
    }

    #[test]
    fn errors_name_the_line() {
        for (text, field, problem) in [
            ("", "", "at least one"),
            ("# nothing\n\n", "", "at least one"),
            ("380 1\n400", "line 2", "has 1 columns"),
            ("380 1 2", "line 1", "has 3 columns"),
            ("nm value\n380 1", "line 1", "`nm` is not"),
            ("\n380 x", "line 2", "`x` is not"),
            ("380 1\n390 nan", "line 2", "`nan` is not"),
            ("380 1\n390 1e50", "line 2", "`1e50` is not"),
            ("380 1\n380 2", "line 2", "380 nm is not greater"),
            ("400 1\n390 2", "line 2", "390 nm is not greater"),
            ("-5 1", "line 1", "-5 nm is not greater"),
            ("0 1", "line 1", "0 nm is not greater"),
            ("380 correct-horse-battery-staple-secret", "line 1", "`correct-horse-batter...` is"),
        ] {
            let fault = SpectrumTable::from_spd(text).unwrap_err();
            assert_eq!(fault.field, field, "{text:?}");
            assert!(fault.problem.contains(problem), "{text:?}: {}", fault.problem);
            assert!(!fault.remedy.is_empty());
        }
    }
}
