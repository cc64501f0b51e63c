//! Luminaires as they are measured: files of IES LM-63, which manufacturers give away.

use crate::math::elementary::{cos, sin};
use crate::math::{Fault, Range};

const REMEDY: &str = "is it a file of IES LM-63, type C?";
/// Most angles of either kind.
const ANGLES_MAX: f64 = 10_000.0;
/// Most intensities.
const VALUES_MAX: usize = 10_000_000;

/// Luminous intensities of a luminaire by direction: those between angles are linear in them, those
/// beyond are zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Photometry {
    /// From the axis, in degrees: increasing, within 0 to 180.
    vertical_deg: Vec<f64>,
    /// About it, in degrees: increasing, from 0 to 0 (the same all around), 90 (the same in all
    /// quadrants), 180 (the same on both sides of its plane) or 360, or from 90 to 270 (on both
    /// sides of the plane across).
    horizontal_deg: Vec<f64>,
    /// In candela, for all vertical angles of the first horizontal one, and so on.
    candela: Vec<f64>,
    /// What of the file is not as it says.
    doubts: Vec<&'static str>,
}

/// Most that the intensities in one plane may differ, relative to the largest of the file.
const SEAM_MAX: f64 = 1e-3;

/// The numbers of a file, one after the other.
struct Numbers<'a> {
    left: Box<dyn Iterator<Item = &'a str> + 'a>,
}

impl Numbers<'_> {
    fn next(&mut self, what: &str) -> Result<f64, Fault> {
        let Some(word) = self.left.next() else {
            return Err(Fault::new(what, "is missing: the file ends before", REMEDY));
        };
        let number = word.parse::<f64>().map_err(|_| {
            let word: String = word.chars().take(40).collect();
            Fault::new(what, format!("`{word}` is not a number"), REMEDY)
        })?;
        Range::ANY.check(what, number)?;
        Ok(number)
    }

    fn count(&mut self, what: &str) -> Result<usize, Fault> {
        let number = self.next(what)?;
        if number.fract() == 0.0 && (1.0..=ANGLES_MAX).contains(&number) {
            return Ok(number as usize);
        }
        Err(Fault::new(what, format!("{number} is not a count of at most {ANGLES_MAX}"), REMEDY))
    }

    fn list(&mut self, count: usize, what: &str) -> Result<Vec<f64>, Fault> {
        (0..count).map(|_| self.next(what)).collect()
    }

    /// Reads what stands for TILT; what of it does not count is said.
    fn tilt(&mut self, tilt: &str) -> Result<Option<&'static str>, Fault> {
        match tilt {
            "NONE" => return Ok(None),
            "INCLUDE" => {}
            _ => {
                let doubt = "names a file for TILT, which is not read: its lamps emit as they were \
                             measured, however they hang";
                return Ok(Some(doubt));
            }
        }
        self.next("TILT")?;
        let count = self.count("TILT")?;
        self.list(count, "TILT")?;
        let factors = self.list(count, "TILT")?;
        let doubt = "has factors of TILT, which are not read: its lamps emit as they were \
                     measured, however they hang";
        Ok(factors.iter().any(|factor| *factor != 1.0).then_some(doubt))
    }
}

impl Photometry {
    /// Reads a file of IES LM-63 (1986 to 2019) of type C: intensities times its multiplier and the
    /// factor of its ballast. What a lamp does when it is tilted does not count; that, and what
    /// else is doubtful, is in [`Photometry::doubts`].
    ///
    /// # Errors
    /// With the part of the file that is not so, as the field of the fault.
    pub fn from_ies(text: &str) -> Result<Self, Fault> {
        let mut lines = text.lines();
        let tilt = lines.by_ref().map(str::trim).find_map(|line| line.strip_prefix("TILT="));
        let Some(tilt) = tilt else {
            return Err(Fault::new("TILT", "is missing", REMEDY));
        };
        let separators = |letter: char| letter.is_whitespace() || letter == ',';
        let words = lines.flat_map(move |line| line.split(separators));
        let mut numbers = Numbers { left: Box::new(words.filter(|word| !word.is_empty())) };
        let mut doubts: Vec<&str> = numbers.tilt(tilt.trim())?.into_iter().collect();
        numbers.list(2, "lamps")?;
        let multiplier = numbers.next("multiplier")?;
        let vertical = numbers.count("number of vertical angles")?;
        let horizontal = numbers.count("number of horizontal angles")?;
        if vertical * horizontal > VALUES_MAX {
            return Err(Fault::new("", "has too many angles", "thin them out"));
        }
        let kind = numbers.next("photometric type")?;
        if kind != 1.0 {
            let problem = format!("is {kind}, and only 1, type C, is read");
            return Err(Fault::new("photometric type", problem, "convert it to type C"));
        }
        // Units and sizes of the opening.
        numbers.list(4, "sizes")?;
        let ballast = numbers.next("ballast factor")?;
        numbers.list(2, "watts")?;
        let vertical_deg = numbers.list(vertical, "vertical angles")?;
        let horizontal_deg = numbers.list(horizontal, "horizontal angles")?;
        let factor = multiplier * ballast;
        let candela = numbers.list(vertical * horizontal, "candela values")?;
        let candela = candela.into_iter().map(|value| value * factor).collect();
        if numbers.left.next().is_some() {
            doubts.push("goes on behind its last candela value: what follows is not read");
        }
        let mut read = Self { vertical_deg, horizontal_deg, candela, doubts };
        read.check()?;
        if read.has_seam() {
            let doubt = "has other intensities at a horizontal angle of 360 degrees than at 0, \
                         which is the same plane: they jump there";
            read.doubts.push(doubt);
        }
        Ok(read)
    }

    /// A file of it, which is read as the same.
    pub fn to_ies(&self) -> String {
        let [vertical, horizontal] = [&self.vertical_deg, &self.horizontal_deg].map(Vec::len);
        let mut text = format!(
            "IESNA:LM-63-2002\n[MANUFAC] written by sunstone\nTILT=NONE\n1 -1 1 {vertical} \
             {horizontal} 1 2 0 0 0\n1 1 0\n"
        );
        let planes = self.candela.chunks(vertical);
        for row in [&self.vertical_deg[..], &self.horizontal_deg].into_iter().chain(planes) {
            let numbers: Vec<String> = row.iter().map(f64::to_string).collect();
            text.push_str(&numbers.join(" "));
            text.push('\n');
        }
        text
    }

    /// What of the file counts for nothing, or contradicts itself, as sentences about the file.
    pub fn doubts(&self) -> &[&'static str] {
        &self.doubts
    }

    /// Whether the first plane and the last are one, and differ.
    fn has_seam(&self) -> bool {
        let rows = self.vertical_deg.len();
        let last = self.candela.len() - rows;
        let pairs = self.candela[..rows].iter().zip(&self.candela[last..]);
        let largest = self.candela.iter().copied().fold(0.0, f64::max);
        self.horizontal_deg.ends_with(&[360.0])
            && pairs.into_iter().any(|(a, b)| (a - b).abs() > SEAM_MAX * largest)
    }

    fn check(&self) -> Result<(), Fault> {
        let increase = |angles: &[f64]| angles.is_sorted_by(|a, b| a < b);
        let ends = |angles: &[f64]| [angles[0], angles[angles.len() - 1]];
        let [first, last] = ends(&self.vertical_deg);
        if let [only] = self.vertical_deg[..] {
            let problem = format!("are {only} alone, between which and nothing lies no direction");
            let remedy = "give two at least: 0 and 180 emit everywhere";
            return Err(Fault::new("vertical angles", problem, remedy));
        }
        if !increase(&self.vertical_deg) || first < 0.0 || last > 180.0 {
            let problem = "do not increase within 0 to 180 degrees";
            return Err(Fault::new("vertical angles", problem, REMEDY));
        }
        let known = [[0.0, 0.0], [0.0, 90.0], [0.0, 180.0], [0.0, 360.0], [90.0, 270.0]];
        let all_around = ends(&self.horizontal_deg);
        if !increase(&self.horizontal_deg) || !known.contains(&all_around) {
            let problem = format!("go from {} to {} degrees", all_around[0], all_around[1]);
            let remedy = "they increase from 0 to 0, 90, 180 or 360, or from 90 to 270";
            return Err(Fault::new("horizontal angles", problem, remedy));
        }
        self.candela.iter().try_for_each(|it| Range::NOT_NEGATIVE.check("candela values", *it))?;
        if self.mean() > 0.0 {
            return Ok(());
        }
        Err(Fault::new("candela values", "are zero throughout: it emits nothing", "remove it"))
    }

    /// The intensity in candela at angles in degrees: from the axis, and about it.
    pub fn at(&self, vertical_deg: f64, horizontal_deg: f64) -> f64 {
        let Some((row, share)) = place(&self.vertical_deg, vertical_deg) else { return 0.0 };
        let (column, beside) =
            place(&self.horizontal_deg, self.folded(horizontal_deg)).unwrap_or((0, 0.0));
        let of_column = |column: usize| {
            let of = |row: usize| self.candela[column * self.vertical_deg.len() + row];
            let next = (row + 1).min(self.vertical_deg.len() - 1);
            of(row) * (1.0 - share) + of(next) * share
        };
        let next = (column + 1).min(self.horizontal_deg.len() - 1);
        of_column(column) * (1.0 - beside) + of_column(next) * beside
    }

    /// The angle among those that are given which stands for another.
    fn folded(&self, horizontal_deg: f64) -> f64 {
        let turned = horizontal_deg.rem_euclid(360.0);
        let on_one_side = if turned > 180.0 { 360.0 - turned } else { turned };
        let (first, last) =
            (self.horizontal_deg[0], self.horizontal_deg[self.horizontal_deg.len() - 1]);
        if first == 90.0 {
            return if (90.0..=270.0).contains(&turned) {
                turned
            } else {
                (540.0 - turned).rem_euclid(360.0)
            };
        }
        if last == 0.0 {
            0.0
        } else if last == 90.0 && on_one_side > 90.0 {
            180.0 - on_one_side
        } else if last <= 180.0 {
            on_one_side
        } else {
            turned
        }
    }

    /// The mean over all directions in candela: the integrals of what is linear in angles.
    pub fn mean(&self) -> f64 {
        let all_around = |row: usize| {
            let at = |column: usize| self.candela[column * self.vertical_deg.len() + row];
            let steps = self.horizontal_deg.windows(2).enumerate();
            let sum: f64 = steps
                .map(|(index, ends)| 0.5 * (at(index) + at(index + 1)) * (ends[1] - ends[0]))
                .sum();
            match self.horizontal_deg[..] {
                [first, .., last] => sum / (last - first),
                _ => at(0),
            }
        };
        let steps = self.vertical_deg.windows(2).enumerate();
        let over = |(row, ends): (usize, &[f64])| {
            let [a, b] = [ends[0], ends[1]].map(f64::to_radians);
            let [at_a, at_b] = [all_around(row), all_around(row + 1)];
            let slope = (at_b - at_a) / (b - a);
            at_a * cos(a) - at_b * cos(b) + slope * (sin(b) - sin(a))
        };
        0.5 * steps.map(over).sum::<f64>()
    }
}

/// The step of increasing angles in which one is, and how far in it; none beyond their ends.
fn place(angles: &[f64], angle: f64) -> Option<(usize, f64)> {
    if angle < angles[0] || angles[angles.len() - 1] < angle {
        return None;
    }
    let upper = angles.partition_point(|&at| at < angle);
    if upper == 0 {
        return Some((0, 0.0));
    }
    Some((upper - 1, (angle - angles[upper - 1]) / (angles[upper] - angles[upper - 1])))
}
