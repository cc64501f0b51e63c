//! How time grows with threads, samples, photons, pixels and wavelengths.

use std::fmt;

use serde::Serialize;

use super::costs::COVERAGE;
use super::figures::{Figures, part};
use super::plot::{Axis, Curve, Panel, Point};
use super::{Machine, Report, interval_in_words};
use crate::math::statistics::{Fit, Interval, log_log_fit, median, median_interval};

/// Seconds by one clock.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Time {
    /// The median over the rounds.
    pub seconds: f64,
    /// Where that lies.
    pub interval: Option<Interval>,
}

impl Time {
    /// What some rounds took.
    pub fn new(seconds: &[f64]) -> Self {
        Self { seconds: median(seconds), interval: median_interval(seconds, COVERAGE) }
    }
}

/// One size of the work.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sample {
    /// The size, in the unit of the series.
    pub size: f64,
    /// Renders that were timed together in a round.
    pub repeats: u32,
    /// A render's seconds of all cores together, where the system tells.
    pub cpu: Option<Time>,
    /// A render's seconds by the clock on the wall.
    pub wall: Time,
}

impl Sample {
    /// The best clock there is: that of the cores, else that on the wall.
    fn time(&self) -> &Time {
        self.cpu.as_ref().unwrap_or(&self.wall)
    }
}

/// Work of growing size.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Series {
    /// What grows: `threads`, `samples`, `photons`, `pixels`, `wavelengths`.
    pub name: &'static str,
    /// What stays as it is, in words.
    pub work: String,
    /// From small to large.
    pub points: Vec<Sample>,
    /// The slope of the logarithm of CPU time (else of wall clock time) over that of the size.
    pub slope: Option<Fit>,
    /// The same of wall clock time.
    pub wall_slope: Option<Fit>,
    /// Wall clock time of the first point over that of each, where threads grow.
    pub speedups: Option<Vec<f64>>,
}

impl Series {
    /// Fits lines to points.
    pub fn new(name: &'static str, work: String, points: Vec<Sample>) -> Self {
        let fit = |seconds: &dyn Fn(&Sample) -> f64| {
            let points: Vec<(f64, f64)> =
                points.iter().map(|point| (point.size, seconds(point))).collect();
            log_log_fit(&points)
        };
        let slope = fit(&|point| point.time().seconds);
        let wall_slope = fit(&|point| point.wall.seconds);
        let speedup = |point: &Sample| points[0].wall.seconds / point.wall.seconds;
        let speedups = (name == "threads").then(|| points.iter().map(speedup).collect());
        Self { name, work, points, slope, wall_slope, speedups }
    }
}

/// What was measured on what.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Conditions {
    /// On what.
    #[serde(flatten)]
    pub machine: Machine,
    /// The scene as it was named.
    pub scene: String,
    /// The integrator of all series but that of photons.
    pub integrator: String,
    /// `scalar` or `polarized`.
    pub mode: String,
    /// What the channels stand for, but in the series of wavelengths.
    pub color: String,
    /// Rounds that were measured, the one that warms up not counted.
    pub rounds: u32,
    /// Most segments of a path.
    pub path_length_max: u32,
    /// Path length after which roulette may end a path, where a number is given.
    pub roulette_after: Option<u32>,
    /// Seed of all randomness.
    pub seed: u32,
}

/// The whole report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scaling {
    /// What was measured on what.
    pub conditions: Conditions,
    /// In the order in which they were measured.
    pub series: Vec<Series>,
}

impl Report for Scaling {
    fn panels(&self) -> Vec<Panel> {
        let curve = |name: &str, series: &Series, time: &dyn Fn(&Sample) -> Time| Curve {
            name: name.into(),
            points: (series.points.iter())
                .map(|point| (point.size, time(point)))
                .map(|(size, time)| Point::new(size, time.seconds).within(time.interval))
                .collect(),
        };
        let panel = |series: &Series| Panel {
            title: format!("{}: {}", series.name, series.work),
            x: Axis::logarithmic(series.name),
            y: Axis::logarithmic("seconds"),
            curves: vec![
                curve("CPU", series, &|point| *point.time()),
                curve("wall clock", series, &|point| point.wall),
            ],
        };
        self.series.iter().map(panel).collect()
    }

    fn figures(&self) -> Figures {
        let mut figures = Figures::default();
        let Conditions { scene, integrator, color, .. } = &self.conditions;
        for series in &self.series {
            let integrator = if series.name == "photons" { "ppm" } else { integrator };
            let parts = ["scaling", &part(scene), integrator, &part(&color.to_lowercase())];
            let name = [&parts[..], &[series.name]].concat().join(".");
            if let Some(fit) = series.slope {
                figures.add(&[&name, "slope"], fit.slope);
            }
            if let Some(last) = series.points.last() {
                figures.add(&[&name, "seconds"], last.time().seconds);
            }
            if let Some(speedup) = series.speedups.iter().flatten().last() {
                figures.add(&[&name, "speedup"], *speedup);
            }
        }
        figures
    }
}

impl fmt::Display for Scaling {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Conditions { machine, scene, mode, color, rounds, .. } = &self.conditions;
        writeln!(f, "Scaling: seconds a render of {scene}, {mode}, {color}\n")?;
        write!(
            f,
            "{machine};\nmedians of {rounds} rounds, which go through all points of a series up \
             and down; one more is not\ncounted. A render is all that happens once the scene is \
             baked, its image included."
        )?;
        self.series.iter().try_for_each(|series| write!(f, "\n\n{series}"))
    }
}

impl fmt::Display for Series {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let last = if self.speedups.is_some() { "speedup" } else { "CPU us each" };
        write!(
            f,
            "{}: {}\n{:>12} {:>10} {:>17} {:>10} {:>17} {last:>12}",
            self.name, self.work, self.name, "CPU", "interval", "wall clock", "interval"
        )?;
        for (index, point) in self.points.iter().enumerate() {
            let Sample { size, wall, .. } = point;
            let time = point.time();
            write!(
                f,
                "\n{size:>12} {:>10.4} {:>17} {:>10.4} {:>17} ",
                time.seconds,
                interval_in_words(&time.interval, 4),
                wall.seconds,
                interval_in_words(&wall.interval, 4),
            )?;
            match &self.speedups {
                Some(speedups) => write!(f, "{:>12.3}", speedups[index])?,
                None => write!(f, "{:>12.3}", 1e6 * time.seconds / size)?,
            }
        }
        match (self.slope, self.wall_slope) {
            (Some(slope), Some(wall)) => write!(
                f,
                "\nlog-log slope: {} (CPU), {} (wall clock)",
                fit_in_words(slope),
                fit_in_words(wall)
            ),
            _ => write!(f, "\nno slope: one point tells none"),
        }
    }
}

/// A slope with its standard error.
pub(super) fn fit_in_words(fit: Fit) -> String {
    match fit.standard_error {
        Some(error) => format!("{:.3} +- {error:.3}", fit.slope),
        None => format!("{:.3}", fit.slope),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(size: f64, cpu: f64, wall: f64) -> Sample {
        let [cpu, wall] = [cpu, wall].map(|seconds| Time::new(&[seconds; 3]));
        Sample { size, repeats: 1, cpu: Some(cpu), wall }
    }

    #[test]
    fn slopes_and_speedups_follow_from_the_points() {
        let threads = [1.0, 2.0, 4.0].map(|n| sample(n, 8.0, 8.0 / n));
        let series = Series::new("threads", String::new(), threads.to_vec());
        assert_eq!(series.speedups, Some(vec![1.0, 2.0, 4.0]));
        let [slope, wall] = [series.slope, series.wall_slope].map(|fit| fit.expect("points").slope);
        assert!(slope.abs() < 1e-12 && (wall + 1.0).abs() < 1e-12, "{slope} {wall}");
        let pixels = [10.0, 100.0].map(|n: f64| sample(n, 2.0 * n * n, 1.0));
        let series = Series::new("pixels", String::new(), pixels.to_vec());
        assert_eq!(series.speedups, None);
        assert!((series.slope.expect("points").slope - 2.0).abs() < 1e-12);
        assert!(series.to_string().contains("slope: 2.000 (CPU), 0.000 (wall"), "{series}");
        let alone = Series::new("pixels", String::new(), pixels[..1].to_vec());
        assert!(alone.to_string().contains("one point tells none"), "{alone}");
    }
}
