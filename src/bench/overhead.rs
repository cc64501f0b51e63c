//! What polarization costs in any scenes, by any integrators.

use std::fmt;

use serde::Serialize;

use super::costs::{Cost, Costs};
use super::figures::{Figures, part};
use super::plot::{Axis, Curve, Panel, Point};
use super::{Machine, Report, column_width, interval_in_words};
use crate::math::statistics::Interval;

/// What was measured on what.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Conditions {
    /// On what.
    #[serde(flatten)]
    pub machine: Machine,
    /// What the channels stand for.
    pub color: String,
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

/// One scene by one integrator.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Case {
    /// The scene as it was named.
    pub scene: String,
    /// The integrator's name.
    pub integrator: String,
    /// Samples per pixel of a round.
    pub samples: u32,
    /// Light paths of a round, with photons.
    pub photons_shot: Option<u64>,
    /// What the rounds tell.
    #[serde(flatten)]
    pub costs: Costs,
    /// Seconds in which the film becomes an image, once a render and not part of a round.
    pub develop: Cost,
}

/// The whole report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Overhead {
    /// What was measured on what.
    pub conditions: Conditions,
    /// One row for each scene and integrator.
    pub cases: Vec<Case>,
}

impl Report for Overhead {
    fn panels(&self) -> Vec<Panel> {
        let names = self.cases.iter().map(|case| format!("{} {}", case.scene, case.integrator));
        let costs = self.cases.iter().map(|case| &case.costs);
        vec![ratios(names.collect(), costs)]
    }

    fn figures(&self) -> Figures {
        let mut figures = Figures::default();
        let color = part(&self.conditions.color.to_lowercase());
        for Case { scene, integrator, costs, .. } in &self.cases {
            let name = ["overhead", &part(scene), integrator, &color].join(".");
            costs.add_figures(&mut figures, &name);
        }
        figures
    }
}

/// Ratios side by side, each under its name.
pub fn ratios<'a>(names: Vec<String>, costs: impl Iterator<Item = &'a Costs>) -> Panel {
    let point = |(index, costs): (u32, &Costs)| {
        let ratio = costs.ratio();
        let point = Point::new(f64::from(index), ratio.median_of_ratios);
        point.within(ratio.ratio_interval)
    };
    let points = (0..).zip(costs).map(point).collect();
    Panel {
        title: "Polarized over scalar time".into(),
        x: Axis::names(names),
        y: Axis::linear("ratio"),
        curves: vec![Curve { name: String::new(), points }],
    }
}

impl fmt::Display for Overhead {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "Overhead: seconds a round without and with polarization\n")?;
        self.write_rows(f)?;
        self.write_notes(f)?;
        for case in &self.cases {
            let Case { scene, integrator, costs, develop, .. } = case;
            write!(f, "\n\n{scene}, {integrator}, stage by stage: ")?;
            write!(f, "mean seconds a round, summed over threads")?;
            costs.write_stages(f)?;
            let Cost { scalar, polarized, .. } = develop;
            write!(f, "\nOnce a render, not counted above: the film becomes an image in ")?;
            write!(f, "{scalar:.4} and {polarized:.4} s.")?;
        }
        Ok(())
    }
}

impl Overhead {
    fn write_rows(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = column_width(self.cases.iter().map(|case| case.scene.as_str()), 5);
        let clock = match self.cases.iter().all(|case| case.costs.cpu_ratio.is_some()) {
            true => "CPU time",
            false => "wall clock",
        };
        writeln!(
            f,
            "{:width$} {:10} | {clock:^44} | {:^20}\n\
             {:<width$} {:10} | {:>9} {:>9} {:>8} {:>15} | {:>8} {:>11}",
            "",
            "",
            "wall clock",
            "scene",
            "integrator",
            "scalar",
            "polarized",
            "ratio",
            "interval",
            "ratio",
            "interval"
        )?;
        for Case { scene, integrator, costs, .. } in &self.cases {
            let ratio = costs.ratio();
            writeln!(
                f,
                "{scene:<width$} {integrator:10} | {:>9.4} {:>9.4} {:>8.3} {:>15} | {:>8.3} {:>11}",
                ratio.scalar_seconds,
                ratio.polarized_seconds,
                ratio.median_of_ratios,
                interval_in_words(&ratio.ratio_interval, 3),
                costs.wall.median_of_ratios,
                interval_in_words(&costs.wall.ratio_interval, 3),
            )?;
        }
        Ok(())
    }

    fn write_notes(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Conditions { machine, color, width, height, rounds, .. } = &self.conditions;
        write!(
            f,
            "\n{machine};\n{color}, {width} x {height} pixels, {rounds} rounds a mode; the modes \
             alternate,\nafter one round each that is not counted.",
        )?;
        for Case { scene, integrator, samples, photons_shot, .. } in &self.cases {
            write!(f, "\n{scene}, {integrator}: {samples} samples a pixel in a round")?;
            if let Some(photons) = photons_shot {
                write!(f, ", {photons} light paths")?;
            }
        }
        write!(f, "\nSeconds are medians, ratio is the median of the ratios of the rounds")?;
        let interval = |case: &Case| case.costs.wall.ratio_interval;
        match self.cases.iter().find_map(interval) {
            Some(Interval { coverage, .. }) => write!(
                f,
                ", and interval holds it\nwith a chance of {:.1} %: order statistics, whatever \
                 the distribution.",
                100.0 * coverage
            ),
            None => write!(f, "; one round tells no interval."),
        }?;
        match self.cases.iter().all(|case| case.costs.same_paths) {
            true => write!(f, "\nBoth modes had the same photons, rays and radii."),
            false => write!(f, "\nThe modes did NOT have the same photons, rays and radii."),
        }
    }
}
