//! Formulas of what shines: blackbodies and emission lines.

use std::f64::consts::{LN_2, PI};
use std::fmt;

use super::cie::{VISIBLE_NM, luminous_mean};
use super::formula::{Formula, Law};
use super::{RELATIVE_WIDTH_MIN, Spectrum};
use crate::math::elementary::{exp, exp_m1};
use crate::math::{Fault, Range};

/// Second radiation constant h c / k in nm K, exact in the SI of 2019.
pub const RADIATION_NM_K: f64 = 1.438_776_877e7;
/// Wien's displacement constant in nm K.
const WIEN_NM_K: f64 = 2.897_771_955e6;
/// Where blackbodies are defined, in nanometers.
const BLACKBODY_NM: [f32; 2] = [100.0, 10_000.0];
/// Where lines are defined: everywhere.
const LINES_NM: [f32; 2] = [f32::MIN_POSITIVE, f32::MAX];
/// Most lines of a spectrum.
const LINES_MAX: usize = 10_000;

const KELVIN: Range = Range::new("within [500, 1000000]", |x| (500.0..=1_000_000.0).contains(&x));

/// A line of emission, of which a list makes a spectrum: see [`Spectrum::lines`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Vacuum wavelength of its center in nanometers.
    pub center_nm: f64,
    /// What it integrates to over wavelength, in the unit of the spectrum times nanometers.
    pub power: f64,
    /// Full width in nanometers: of a Gaussian at half its maximum.
    pub width_nm: f64,
}

/// What lines look like.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LineShape {
    /// A normal distribution.
    #[default]
    Gaussian,
    /// The same in all of its width.
    Box,
}

impl Spectrum {
    /// The radiation of a blackbody at a temperature in kelvin, by Planck's law: as bright as a
    /// flat spectrum of 1, that is, with a mean of 1 under the luminous efficiency y of the CIE
    /// 1931 observer. From 100 to 10,000 nm.
    ///
    /// # Errors
    /// When the temperature is not within 500 and 1,000,000 K.
    pub fn blackbody(kelvin: f64) -> Result<Self, Fault> {
        KELVIN.check("blackbody_k", kelvin)?;
        let mut blackbody = Blackbody { kelvin, factor: 1.0 };
        blackbody.factor = 1.0 / luminous_mean(VISIBLE_NM, |nm| blackbody.at(nm));
        Ok(Self::Formula(Formula::new(Law::Blackbody(blackbody), BLACKBODY_NM)))
    }

    /// Lines of emission, and nothing between them. A line integrates to its power over wavelength
    /// in nanometers.
    ///
    /// # Errors
    /// With the number of the first line that has no wavelength, or a width below a 50,000th of
    /// that, or a power that is negative, or that is not finite; and when there are none, or more
    /// than 10,000.
    pub fn lines(lines: &[Line], shape: LineShape) -> Result<Self, Fault> {
        if !(1..=LINES_MAX).contains(&lines.len()) {
            let problem = format!("needs one to {LINES_MAX} lines, not {}", lines.len());
            return Err(Fault::new("lines", problem, "give [[nm, power, width_nm], ...]"));
        }
        for (index, line) in lines.iter().enumerate() {
            line.check(shape).map_err(|fault| fault.within(&format!("lines[{index}]")))?;
        }
        let law = Lines { lines: lines.to_vec(), shape };
        Ok(Self::Formula(Formula::new(Law::Lines(law), LINES_NM)))
    }
}

impl Line {
    fn check(&self, shape: LineShape) -> Result<(), Fault> {
        Range::POSITIVE.check("center_nm", self.center_nm)?;
        Range::NOT_NEGATIVE.check("power", self.power)?;
        Range::POSITIVE.check("width_nm", self.width_nm)?;
        let least = (self.center_nm * RELATIVE_WIDTH_MIN) as f32;
        if (self.width_nm as f32) < least {
            let problem = format!(
                "is {}, and wavelengths, which are numbers of single precision, tell apart no \
                 line at {} nm that is narrower than {least} nm",
                self.width_nm, self.center_nm
            );
            let remedy = "give it that width: over so little, light does nothing else";
            return Err(Fault::new("width_nm", problem, remedy));
        }
        Range::NOT_NEGATIVE.check("power over width_nm", self.peak(shape))
    }

    /// The value at its center.
    fn peak(&self, shape: LineShape) -> f64 {
        match shape {
            LineShape::Gaussian => 2.0 * (LN_2 / PI).sqrt() * self.power / self.width_nm,
            LineShape::Box => self.power / self.width_nm,
        }
    }

    /// Where a box is whole, and where nothing of it is left, in widths from its middle: on either
    /// side of its edge, also in single precision. What is chosen in proportion of a line between
    /// these is then never less likely by more than a half, and never zero where there is light.
    fn beside_edge(&self) -> [f64; 2] {
        const WIDTHS: f64 = 1e-3;
        let rounding = f64::from(f32::EPSILON) * self.center_nm / self.width_nm;
        let off = WIDTHS.max(rounding).min(0.25);
        [0.5 - off, 0.5 + off]
    }

    fn at(&self, wavelength_nm: f64, shape: LineShape) -> f64 {
        let off = (wavelength_nm - self.center_nm) / self.width_nm;
        let profile = match shape {
            LineShape::Gaussian => exp(-4.0 * LN_2 * off * off),
            LineShape::Box => f64::from(u8::from((-0.5..0.5).contains(&off))),
        };
        self.peak(shape) * profile
    }
}

/// Planck's law, times a number.
#[derive(Clone, Debug, PartialEq)]
pub struct Blackbody {
    kelvin: f64,
    factor: f64,
}

impl Blackbody {
    /// The value at a wavelength in nanometers.
    pub(super) fn at(&self, wavelength_nm: f64) -> f64 {
        let um = wavelength_nm * 1e-3;
        let exponent = RADIATION_NM_K / (wavelength_nm * self.kelvin);
        self.factor / (um * um * um * um * um * exp_m1(exponent))
    }

    /// The least and the greatest value in a range: the latter at its peak, by Wien's law.
    pub(super) fn bounds(&self, [from, to]: [f64; 2]) -> [f64; 2] {
        let peak = (WIEN_NM_K / self.kelvin).clamp(from, to);
        // The constant is rounded, and the maximum is flat.
        [self.at(from).min(self.at(to)), self.at(peak) * (1.0 + 1e-7)]
    }
}

impl fmt::Display for Blackbody {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "blackbody of {} K", self.kelvin as f32)
    }
}

/// Lines of emission.
#[derive(Clone, Debug, PartialEq)]
pub struct Lines {
    lines: Vec<Line>,
    shape: LineShape,
}

impl Lines {
    /// The value at a wavelength in nanometers.
    pub(super) fn at(&self, wavelength_nm: f64) -> f64 {
        self.lines.iter().map(|line| line.at(wavelength_nm, self.shape)).sum()
    }

    /// Wavelengths in nanometers between which they are nearly linear.
    pub(super) fn knots_nm(&self) -> impl Iterator<Item = f64> {
        self.lines.iter().flat_map(|line| {
            let steps = match self.shape {
                LineShape::Gaussian => (-16..=16).map(|step| f64::from(step) / 8.0).collect(),
                LineShape::Box => {
                    let [inner, outer] = line.beside_edge();
                    vec![-outer, -inner, inner, outer]
                }
            };
            steps.into_iter().map(|widths| line.center_nm + widths * line.width_nm)
        })
    }

    /// Zero, and what no value exceeds: all lines in one place.
    pub(super) fn bounds(&self) -> [f64; 2] {
        [0.0, self.lines.iter().map(|line| line.peak(self.shape)).sum()]
    }
}

impl fmt::Display for Lines {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match &self.lines[..] {
            [line] => write!(f, "a line at {} nm", line.center_nm as f32),
            lines => write!(f, "{} lines", lines.len()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::cie::integrals;

    /// What wavelengths are chosen by is linear between the values at the knots. Where a line has
    /// light, that must not be far below it, least of all zero, or rare paths weigh without bounds.
    #[test]
    fn between_knots_no_line_is_underrated() {
        for center_nm in [436.0, 589.3, 650.05, 1000.123] {
            for width_nm in [0.03, 0.1, 0.5, 20.0] {
                for shape in [LineShape::Box, LineShape::Gaussian] {
                    let line = Line { center_nm, power: 1.0, width_nm };
                    let spectrum = Spectrum::lines(&[line], shape).unwrap();
                    let at = |nm: f64| f64::from(spectrum.at(nm as f32).unwrap());
                    let knots: Vec<f64> = spectrum.knots_nm().into_iter().map(f64::from).collect();
                    assert!(knots.is_sorted());
                    for step in 0..=1000 {
                        let share = f64::from(step) / 1000.0 - 0.5;
                        let nm = f64::from((center_nm + share * width_nm) as f32);
                        let upper = knots.partition_point(|knot| *knot <= nm);
                        let [from, to] = [upper - 1, upper].map(|index| knots[index]);
                        let part = (nm - from) / (to - from);
                        let linear = at(from) * (1.0 - part) + at(to) * part;
                        assert!(linear >= 0.4 * at(nm), "{line:?}, {shape:?}, {nm}: {linear}");
                    }
                }
            }
        }
    }

    #[test]
    fn lines_integrate_to_their_power() {
        let sodium = [(588.995, 2.0, 0.3), (589.592, 1.0, 0.3)];
        let lines = sodium.map(|(center_nm, power, width_nm)| Line { center_nm, power, width_nm });
        for shape in [LineShape::Gaussian, LineShape::Box] {
            let spectrum = Spectrum::lines(&lines, shape).unwrap();
            let step = 1.0 / 1024.0;
            let values =
                (0..20 * 1024).map(|i| f64::from(spectrum.at(580.0 + i as f32 * step).unwrap()));
            let sum: f64 = values.sum::<f64>() * f64::from(step);
            assert!((sum - 3.0).abs() < 0.02, "{shape:?}: {sum}");
            assert_eq!(spectrum.at(550.0), Ok(0.0));
            assert!(spectrum.at(588.995).unwrap() <= spectrum.values()[1]);
        }
        // Half of the maximum at half of the width.
        let line = Line { center_nm: 550.0, power: 1.0, width_nm: 2.0 };
        let spectrum = Spectrum::lines(&[line], LineShape::Gaussian).unwrap();
        let [center, side] = [550.0, 551.0].map(|nm| spectrum.at(nm).unwrap());
        assert!((side / center - 0.5).abs() < 1e-6);
    }

    #[test]
    fn lamps_refuse_what_does_not_shine() {
        let line = Line { center_nm: 550.0, power: 1.0, width_nm: 2.0 };
        for (wrong, field) in [
            (Line { center_nm: 0.0, ..line }, "lines[1].center_nm"),
            (Line { center_nm: f64::NAN, ..line }, "lines[1].center_nm"),
            (Line { power: -1.0, ..line }, "lines[1].power"),
            (Line { power: f64::INFINITY, ..line }, "lines[1].power"),
            (Line { width_nm: 0.0, ..line }, "lines[1].width_nm"),
            (Line { width_nm: 0.01, ..line }, "lines[1].width_nm"),
            (Line { power: 1e38, width_nm: 0.02, ..line }, "lines[1].power over width_nm"),
        ] {
            let fault = Spectrum::lines(&[line, wrong], LineShape::Box).unwrap_err();
            assert_eq!(fault.field, field);
        }
        // What an error names as the least width is one.
        for center_nm in [20.0, 436.0, 589.3, 700.1] {
            let of = |width_nm| {
                let line = Line { center_nm, power: 1.0, width_nm };
                Spectrum::lines(&[line], LineShape::Gaussian)
            };
            let problem = of(1e-6).unwrap_err().problem;
            let least = problem.rsplit(' ').nth(1).and_then(|number| number.parse().ok()).unwrap();
            assert!(of(least).is_ok() && of(least * 0.999).is_err(), "{problem}");
        }
        assert!(Spectrum::lines(&[], LineShape::Box).is_err());
        assert!(Spectrum::lines(&vec![line; LINES_MAX + 1], LineShape::Box).is_err());
        for kelvin in [0.0, -3000.0, 499.0, 1e7, f64::NAN, f64::INFINITY] {
            assert_eq!(Spectrum::blackbody(kelvin).unwrap_err().field, "blackbody_k");
        }
    }

    /// Chromaticities x, y by PyPI's `colour-science` 0.4.7, `sd_blackbody` and `sd_to_XYZ`, whose
    /// radiation constant has five digits.
    #[test]
    fn blackbodies_have_the_colors_of_others() {
        for (kelvin, x, y) in [
            (1000.0, 0.652_725, 0.344_486),
            (3000.0, 0.436_933, 0.404_076),
            (6500.0, 0.313_527, 0.323_630),
            (10_000.0, 0.280_634, 0.288_289),
        ] {
            let spectrum = Spectrum::blackbody(kelvin).unwrap();
            let seen = integrals(VISIBLE_NM, |nm| f64::from(spectrum.at(nm as f32).unwrap()));
            let sum: f64 = seen.iter().sum();
            let error = (seen[0] / sum - x).abs().max((seen[1] / sum - y).abs());
            assert!(error < 3e-5, "{kelvin}: {error:e}");
        }
    }

    #[test]
    fn blackbodies_are_as_bright_as_a_flat_spectrum() {
        for kelvin in [500.0, 2856.0, 6504.0, 1e6] {
            let spectrum = Spectrum::blackbody(kelvin).unwrap();
            let at = |nm: f64| f64::from(spectrum.at(nm as f32).unwrap());
            let mean = luminous_mean(VISIBLE_NM, at);
            assert!((mean - 1.0).abs() < 1e-6, "{kelvin}: {mean}");
            let [least, most] = spectrum.values().try_into().unwrap();
            for nm in (100..=10_000).step_by(20) {
                let value = spectrum.at(nm as f32).unwrap();
                assert!(least <= value && value <= most && value.is_finite(), "{kelvin}, {nm}");
            }
        }
    }
}
