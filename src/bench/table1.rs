//! What polarization costs, as Table 1 of Jarabo and Gutierrez 2016 reports it, and which stages
//! it costs that in.

use std::fmt;

use serde::Serialize;

use super::costs::{Costs, Round};
use super::figures::{Figures, part};
use super::overhead::ratios;
use super::plot::Panel;
use super::{Machine, Report, column_width, interval_in_words, thousands};
use crate::math::statistics::Interval;

/// Table 1 of the paper and how it came about.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Paper {
    /// Where it was published.
    pub reference: &'static str,
    /// Iterations that its costs are averages over.
    pub iterations: u32,
    /// Samples per pixel an iteration.
    pub samples_per_iteration: u32,
    /// Light paths an iteration.
    pub photons_shot: u32,
    /// What it ran on.
    pub machine: &'static str,
    /// One row a scene.
    pub rows: [PaperRow; 2],
}

/// A row of the paper's table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PaperRow {
    /// Number of the figure.
    pub figure: u32,
    /// The scene as the table names it.
    pub scene: &'static str,
    /// Photons stored in an iteration, on average.
    pub photons: f64,
    /// Seconds per iteration without polarization.
    pub scalar_seconds: f64,
    /// Seconds per iteration with polarization.
    pub polarized_seconds: f64,
}

impl PaperRow {
    /// Polarized over scalar.
    fn ratio(&self) -> f64 {
        self.polarized_seconds / self.scalar_seconds
    }
}

/// The paper's table, with the settings of its section 5.
pub const PAPER: Paper = Paper {
    reference: "Jarabo and Gutierrez 2016, Bidirectional Rendering of Polarized Light Transport",
    iterations: 500,
    samples_per_iteration: 16,
    photons_shot: 1_000_000,
    machine: "unknown",
    rows: [
        PaperRow {
            figure: 3,
            scene: "mirror",
            photons: 527e3,
            scalar_seconds: 8.0,
            polarized_seconds: 14.0,
        },
        PaperRow {
            figure: 4,
            scene: "bunny",
            photons: 300e3,
            scalar_seconds: 17.0,
            polarized_seconds: 33.0,
        },
    ],
};

/// What was measured on what.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Conditions {
    /// On what.
    #[serde(flatten)]
    pub machine: Machine,
    /// The integrator's name.
    pub integrator: String,
    /// What the channels stand for.
    pub color: String,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Iterations that were measured in each mode, the one that warms up not counted.
    pub iterations: u32,
    /// Light paths an iteration.
    pub photons_shot: u32,
    /// Samples per pixel an iteration.
    pub samples_per_iteration: u32,
    /// How the kernel shrinks.
    pub alpha: f32,
    /// Most segments of a path.
    pub path_length_max: u32,
    /// Path length after which roulette may end a path, where a number is given.
    pub roulette_after: Option<u32>,
    /// Seed of all randomness.
    pub seed: u32,
}

/// The account of one scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneReport {
    /// The scene as it was named.
    pub scene: String,
    /// Its row in the paper's table.
    pub paper: Option<PaperRow>,
    /// Photons stored in an iteration, on average.
    pub photons: f64,
    /// What the iterations tell; each is a round.
    #[serde(flatten)]
    pub costs: Costs,
}

impl SceneReport {
    /// Draws the conclusions from the rounds.
    pub fn new(scene: String, paper: Option<&PaperRow>, rounds: Vec<Round>) -> Self {
        let costs = Costs::new(rounds);
        Self { scene, paper: paper.copied(), photons: costs.photons(), costs }
    }
}

/// The whole report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Table1 {
    /// What was measured on what.
    pub conditions: Conditions,
    /// What it is compared with.
    pub paper: Paper,
    /// One row a scene.
    pub scenes: Vec<SceneReport>,
}

impl Table1 {
    /// A report on some scenes.
    pub fn new(conditions: Conditions, scenes: Vec<SceneReport>) -> Self {
        Self { conditions, paper: PAPER, scenes }
    }
}

impl Report for Table1 {
    fn panels(&self) -> Vec<Panel> {
        let names = self.scenes.iter().map(|scene| scene.scene.clone()).collect();
        vec![ratios(names, self.scenes.iter().map(|scene| &scene.costs))]
    }

    fn figures(&self) -> Figures {
        let mut figures = Figures::default();
        for SceneReport { scene, costs, .. } in &self.scenes {
            costs.add_figures(&mut figures, &["table1", &part(scene)].join("."));
        }
        figures
    }
}

impl fmt::Display for Table1 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "Table 1: seconds per iteration without and with polarization\n")?;
        self.write_rows(f)?;
        self.write_notes(f)?;
        for scene in &self.scenes {
            write!(f, "\n\n{}, stage by stage: ", scene.scene)?;
            write!(f, "mean seconds per iteration, summed over threads")?;
            scene.costs.write_stages(f)?;
        }
        Ok(())
    }
}

impl Table1 {
    fn write_rows(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = column_width(self.scenes.iter().map(|scene| scene.scene.as_str()), 6);
        writeln!(
            f,
            "{:width$}{:>51}   | the paper\n\
             fig. {:<width$} {:>8} {:>9} {:>9} {:>6} {:>6} {:>13}   | {:>7} {:>6} {:>6} {:>5}",
            "",
            "",
            "scene",
            "photons",
            "unpol. s",
            "pol. s",
            "ratio",
            "median",
            "interval",
            "photons",
            "unpol.",
            "pol.",
            "ratio"
        )?;
        for scene in &self.scenes {
            let figure = scene.paper.map_or("-".into(), |paper| paper.figure.to_string());
            let wall = &scene.costs.wall;
            let interval = interval_in_words(&wall.ratio_interval, 3);
            write!(
                f,
                "{figure:>4} {:<width$} {:>8} {:>9.4} {:>9.4} {:>6.3} {:>6.3} {interval:>13}   |",
                scene.scene,
                thousands(scene.photons),
                wall.scalar_seconds,
                wall.polarized_seconds,
                wall.ratio_of_medians,
                wall.median_of_ratios,
            )?;
            match &scene.paper {
                Some(paper) => writeln!(
                    f,
                    " {:>7} {:>6.0} {:>6.0} {:>5.2}",
                    thousands(paper.photons),
                    paper.scalar_seconds,
                    paper.polarized_seconds,
                    paper.ratio()
                )?,
                None => writeln!(f)?,
            }
        }
        Ok(())
    }

    fn write_notes(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Conditions { machine, color, integrator, .. } = &self.conditions;
        let Conditions { width, height, iterations, photons_shot, .. } = self.conditions;
        let samples = self.conditions.samples_per_iteration;
        write!(
            f,
            "\nHere: {machine};\n\
             {integrator}, {color}, {width} x {height} pixels, {iterations} iterations a mode, \
             each of {photons_shot} light paths\nand {samples} samples a pixel; the modes \
             alternate, after one iteration each that is not counted.\n\
             Seconds are medians of the wall clock; ratio is that of these medians, median that \
             of the\nratios of the rounds, and interval holds the latter",
        )?;
        match self.scenes.iter().find_map(|scene| scene.costs.wall.ratio_interval) {
            Some(Interval { coverage, .. }) => write!(
                f,
                " with a chance of {:.1} %: order statistics,\nwhatever the distribution.",
                100.0 * coverage
            )?,
            None => write!(f, ": one round tells none.")?,
        }
        let paths = match self.scenes.iter().all(|scene| scene.costs.same_paths) {
            true => "Both modes had the same photons, rays and radii.",
            false => "The modes did NOT have the same photons, rays and radii: see the JSON.",
        };
        let Paper { iterations, samples_per_iteration, photons_shot, machine, .. } = self.paper;
        write!(
            f,
            "\n{paths}\nThe paper: averages over {iterations} iterations, each of {photons_shot} \
             light paths and\n{samples_per_iteration} samples a pixel, RGB; its machine is \
             {machine}, and so is the size of its images.",
        )
    }
}
