//! What wavelengths cost: light carried at one, three, four and eight of them, in both modes.

use std::fmt;

use serde::Serialize;

use super::costs::COVERAGE;
use super::figures::{Figures, part};
use super::plot::{Axis, Curve, Panel, Point};
use super::scaling::fit_in_words;
use super::{Machine, Report, interval_in_words};
use crate::math::statistics::{Fit, Interval, log_log_fit, median, median_interval};

/// The number of wavelengths that others are compared with: red, green and blue.
const OF_RGB: usize = 3;

/// What was measured on what.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Conditions {
    /// On what.
    #[serde(flatten)]
    pub machine: Machine,
    /// Whether seconds are those of all cores together, or else of the clock on the wall.
    pub cpu: bool,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Rounds that were measured, the one that warms up not counted.
    pub rounds: u32,
    /// Most segments of a path.
    pub path_length_max: u32,
    /// Path length after which roulette may end a path, where a number is given.
    pub roulette_after: Option<u32>,
    /// Seed of all randomness.
    pub seed: u32,
}

/// A median over rounds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Median {
    /// The median.
    pub median: f64,
    /// Where it lies.
    pub interval: Option<Interval>,
}

/// What a number of wavelengths costs in one mode.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Price {
    /// Seconds a round: the median over the rounds.
    pub seconds: f64,
    /// Over those of RGB in the same mode and round.
    pub ratio: Median,
    /// Seconds of every round.
    pub rounds: Vec<f64>,
}

/// One number of wavelengths.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// What light is carried at, in words.
    pub name: String,
    /// How many.
    pub wavelengths: usize,
    /// Without polarization.
    pub scalar: Price,
    /// With polarization.
    pub polarized: Price,
    /// Polarized over scalar of a round.
    pub modes: Median,
}

/// What the rounds took: seconds of each without and with polarization.
#[derive(Clone, Debug, PartialEq)]
pub struct Taken {
    /// What light is carried at, in words.
    pub name: String,
    /// How many wavelengths.
    pub wavelengths: usize,
    /// Seconds of every round, without polarization and with it.
    pub rounds: [Vec<f64>; 2],
}

/// One scene by one integrator.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Case {
    /// The scene as it was named.
    pub scene: String,
    /// The integrator's name.
    pub integrator: String,
    /// Samples per pixel of a round.
    pub samples: u32,
    /// One row for each number of wavelengths.
    pub rows: Vec<Row>,
    /// The slopes of the logarithm of the seconds over that of the number, without and with
    /// polarization.
    pub slopes: Option<[Fit; 2]>,
}

/// The whole report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Wavelengths {
    /// What was measured on what.
    pub conditions: Conditions,
    /// One for each scene and integrator.
    pub cases: Vec<Case>,
}

impl Median {
    fn of(values: &[f64]) -> Self {
        Self { median: median(values), interval: median_interval(values, COVERAGE) }
    }

    /// That of the quotients of two lists.
    fn of_ratios(over: &[f64], under: &[f64]) -> Self {
        Self::of(&over.iter().zip(under).map(|(over, under)| over / under).collect::<Vec<f64>>())
    }
}

impl Case {
    /// Draws the conclusions from the rounds, of which some are of RGB.
    pub fn new(scene: String, integrator: String, samples: u32, taken: &[Taken]) -> Self {
        let rgb = taken.iter().find(|taken| taken.wavelengths == OF_RGB);
        let row = |Taken { name, wavelengths, rounds }: &Taken| {
            let price = |mode: usize| Price {
                seconds: median(&rounds[mode]),
                ratio: Median::of_ratios(&rounds[mode], rgb.map_or(&[], |rgb| &rgb.rounds[mode])),
                rounds: rounds[mode].clone(),
            };
            Row {
                name: name.clone(),
                wavelengths: *wavelengths,
                scalar: price(0),
                polarized: price(1),
                modes: Median::of_ratios(&rounds[1], &rounds[0]),
            }
        };
        let rows: Vec<Row> = taken.iter().map(row).collect();
        let slope = |seconds: &dyn Fn(&Row) -> f64| {
            let points: Vec<(f64, f64)> =
                rows.iter().map(|row| (row.wavelengths as f64, seconds(row))).collect();
            log_log_fit(&points)
        };
        let slopes = slope(&|row| row.scalar.seconds).zip(slope(&|row| row.polarized.seconds));
        Self { scene, integrator, samples, rows, slopes: slopes.map(<[Fit; 2]>::from) }
    }
}

impl Report for Wavelengths {
    fn panels(&self) -> Vec<Panel> {
        let point = |row: &Row, ratio: &Median| {
            Point::new(row.wavelengths as f64, ratio.median).within(ratio.interval)
        };
        let panel = |Case { scene, integrator, rows, .. }: &Case| Panel {
            title: format!("{scene} {integrator}: time over that of RGB"),
            x: Axis::linear("wavelengths"),
            y: Axis::linear("ratio"),
            curves: vec![
                Curve {
                    name: "scalar".into(),
                    points: rows.iter().map(|row| point(row, &row.scalar.ratio)).collect(),
                },
                Curve {
                    name: "polarized".into(),
                    points: rows.iter().map(|row| point(row, &row.polarized.ratio)).collect(),
                },
            ],
        };
        self.cases.iter().map(panel).collect()
    }

    fn figures(&self) -> Figures {
        let mut figures = Figures::default();
        for Case { scene, integrator, rows, slopes, .. } in &self.cases {
            let name = ["wavelengths", &part(scene), integrator].join(".");
            for Row { wavelengths, scalar, polarized, modes, .. } in rows {
                let of = wavelengths.to_string();
                for (mode, price) in [("scalar", scalar), ("polarized", polarized)] {
                    figures.add(&[&name, mode, &of, "seconds"], price.seconds);
                    figures.add(&[&name, mode, &of, "ratio"], price.ratio.median);
                }
                figures.add(&[&name, &of, "ratio"], modes.median);
            }
            for (mode, fit) in ["scalar", "polarized"].into_iter().zip(slopes.iter().flatten()) {
                figures.add(&[&name, mode, "slope"], fit.slope);
            }
        }
        figures
    }
}

impl fmt::Display for Wavelengths {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Conditions { machine, cpu, width, height, rounds, .. } = &self.conditions;
        let clock = if *cpu { "CPU seconds" } else { "seconds by the clock on the wall" };
        writeln!(f, "Wavelengths: {clock} a round, and ratios to those of RGB in the same mode\n")?;
        write!(
            f,
            "{machine};\n{width} x {height} pixels, {rounds} rounds, which go through all numbers \
             of wavelengths in both modes up and down;\none more is not counted. Ratios are \
             medians of those of the rounds",
        )?;
        let interval =
            self.cases.iter().flat_map(|case| &case.rows).find_map(|it| it.modes.interval);
        match interval {
            Some(Interval { coverage, .. }) => {
                write!(f, ", in intervals\nwith a chance of {:.1} %.", 100.0 * coverage)?;
            }
            None => write!(f, "; one round tells no interval.")?,
        }
        self.cases.iter().try_for_each(|case| write!(f, "\n\n{case}"))
    }
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { scene, integrator, samples, rows, slopes } = self;
        write!(
            f,
            "{scene}, {integrator}: {samples} samples a pixel in a round\n\
             {:13} | {:>8} {:>7} {:>11} | {:>9} {:>7} {:>11} | {:>7} {:>11}",
            "",
            "scalar",
            "ratio",
            "interval",
            "polarized",
            "ratio",
            "interval",
            "modes",
            "interval"
        )?;
        for Row { name, scalar, polarized, modes, .. } in rows {
            write!(
                f,
                "\n{name:13} | {:>8.4} {:>7.3} {:>11} | {:>9.4} {:>7.3} {:>11} | {:>7.3} {:>11}",
                scalar.seconds,
                scalar.ratio.median,
                interval_in_words(&scalar.ratio.interval, 3),
                polarized.seconds,
                polarized.ratio.median,
                interval_in_words(&polarized.ratio.interval, 3),
                modes.median,
                interval_in_words(&modes.interval, 3),
            )?;
        }
        match slopes {
            Some([scalar, polarized]) => {
                let [scalar, polarized] = [*scalar, *polarized].map(fit_in_words);
                write!(f, "\nlog-log slope: {scalar} (scalar), {polarized} (polarized)")
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prices_follow_from_the_rounds() {
        let taken = |wavelengths: usize, scalar: [f64; 3], polarized: [f64; 3]| Taken {
            name: wavelengths.to_string(),
            wavelengths,
            rounds: [scalar.to_vec(), polarized.to_vec()],
        };
        let taken = [
            taken(1, [1.0, 1.0, 4.0], [2.0, 2.0, 8.0]),
            taken(3, [2.0, 2.0, 8.0], [3.0, 3.0, 12.0]),
            taken(4, [2.0, 2.2, 8.0], [6.0, 3.0, 12.0]),
        ];
        let case = Case::new("a".into(), "path".into(), 4, &taken);
        let [one, rgb, four] = &case.rows[..] else { panic!("three") };
        assert_eq!((one.scalar.ratio.median, one.polarized.ratio.median), (0.5, 2.0 / 3.0));
        assert_eq!((rgb.scalar.ratio.median, rgb.modes.median), (1.0, 1.5));
        assert_eq!((four.scalar.seconds, four.scalar.ratio.median), (2.2, 1.0));
        let interval = four.polarized.ratio.interval.expect("of three rounds");
        assert_eq!((interval.low, interval.high), (1.0, 2.0));
    }

    #[test]
    fn slopes_are_those_of_the_medians() {
        let taken = [1, 3, 4, 8].map(|wavelengths: usize| {
            let number = wavelengths as f64;
            let rounds = [vec![number.sqrt(), 0.0, 100.0], vec![number; 3]];
            Taken { name: String::new(), wavelengths, rounds }
        });
        let case = Case::new(String::new(), String::new(), 1, &taken);
        let [scalar, polarized] = case.slopes.expect("of four points").map(|fit| fit.slope);
        assert!((scalar - 0.5).abs() < 1e-12 && (polarized - 1.0).abs() < 1e-12);
    }
}
