//! What polarization costs, as Table 1 of Jarabo and Gutierrez 2016 reports it, and which stages
//! it costs that in.

use std::fmt;

use serde::Serialize;

use crate::integrators::profile::{Profile, STAGES, Stage};

use super::statistics::{Interval, median, median_interval};

/// Least coverage of the intervals, where there are enough rounds.
const COVERAGE: f64 = 0.95;

/// CPU time relative to the time of all stages, below which the text says that threads waited.
const BUSY: f64 = 0.9;

/// The stages in groups, every stage in one.
pub const GROUPS: [(&str, &[Stage]); 7] = [
    ("sample", &[Stage::Start, Stage::Scatter, Stage::Emission, Stage::Flight]),
    ("trace", &[Stage::Trace, Stage::Visibility]),
    ("sort and store", &[Stage::Sort, Stage::Store, Stage::Advance]),
    ("apply Mueller", &[Stage::Mueller]),
    ("connect", &[Stage::Connect, Stage::Gather]),
    ("merge", &[Stage::Merge]),
    ("film", &[Stage::Film]),
];

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
    /// Version of the program.
    pub version: String,
    /// Model of the processor, where the system tells.
    pub processor: Option<String>,
    /// Processors that the program may use.
    pub processors: usize,
    /// Worker threads.
    pub threads: usize,
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
    /// Path length after which roulette may end a path.
    pub roulette_after: u32,
    /// Seed of all randomness.
    pub seed: u32,
}

/// One iteration in one mode.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Measured {
    /// Wall clock seconds.
    pub seconds: f64,
    /// Seconds of all cores together, where the system tells.
    pub cpu_seconds: Option<f64>,
    /// Seconds per stage, summed over threads, in the order of the schedule.
    pub stages: Vec<(&'static str, f64)>,
    /// Photons stored.
    pub photons: u64,
    /// Rays traced to the closest hit.
    pub rays_closest: u64,
    /// Rays traced for visibility alone.
    pub rays_visibility: u64,
    /// Radii of the kernels: on surfaces, then in the media.
    pub radii: Vec<f32>,
}

impl Measured {
    /// An iteration between two looks at the profile of its render.
    pub fn new(
        seconds: f64,
        cpu_seconds: Option<f64>,
        [before, after]: [&Profile; 2],
        radii: Vec<f32>,
    ) -> Self {
        let times = after.times.iter().zip(&before.times);
        let times = times.map(|(after, before)| after.saturating_sub(*before).as_secs_f64());
        Self {
            seconds,
            cpu_seconds,
            stages: STAGES.into_iter().zip(times).collect(),
            photons: after.photons - before.photons,
            rays_closest: after.rays_closest - before.rays_closest,
            rays_visibility: after.rays_visibility - before.rays_visibility,
            radii,
        }
    }

    fn is_as(&self, other: &Self) -> bool {
        self.photons == other.photons
            && self.rays_closest == other.rays_closest
            && self.rays_visibility == other.rays_visibility
            && self.radii == other.radii
    }
}

/// The same iteration in both modes, one right after the other.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Round {
    /// Which of them came first.
    pub polarized_first: bool,
    /// Without polarization.
    pub scalar: Measured,
    /// With polarization.
    pub polarized: Measured,
}

/// Seconds per iteration in both modes, means over the rounds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Cost {
    /// Without polarization.
    pub scalar: f64,
    /// With polarization.
    pub polarized: f64,
    /// Polarized less scalar.
    pub difference: f64,
}

impl Cost {
    fn new(scalar: f64, polarized: f64) -> Self {
        Self { scalar, polarized, difference: polarized - scalar }
    }

    /// The mean of what `seconds` finds in a round.
    fn mean(rounds: &[Round], seconds: impl Fn(&Measured) -> f64) -> Self {
        let mean = |of: &dyn Fn(&Round) -> f64| {
            rounds.iter().map(of).sum::<f64>() / rounds.len().max(1) as f64
        };
        Self::new(mean(&|round| seconds(&round.scalar)), mean(&|round| seconds(&round.polarized)))
    }
}

/// What a group of stages costs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GroupCost {
    /// Name of the group.
    pub name: &'static str,
    /// Names of its stages.
    pub stages: Vec<&'static str>,
    /// Seconds summed over threads.
    #[serde(flatten)]
    pub cost: Cost,
    /// Its difference in that of all stages, unless that is not positive.
    pub share_of_overhead: Option<f64>,
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
    /// Wall clock seconds per iteration without polarization: the median over the rounds.
    pub scalar_seconds: f64,
    /// The same with polarization.
    pub polarized_seconds: f64,
    /// Polarized over scalar of these two.
    pub ratio_of_medians: f64,
    /// The median over the rounds of polarized over scalar.
    pub median_of_ratios: f64,
    /// Where the median of the ratios lies.
    pub ratio_interval: Option<Interval>,
    /// Whether the modes had the same photons, rays and radii in every round.
    pub same_paths: bool,
    /// What the stages cost, in groups.
    pub groups: Vec<GroupCost>,
    /// What all stages cost together.
    pub all_stages: Cost,
    /// Seconds of all cores together, where the system tells: `all_stages` as the system counts.
    /// It differs where threads wait, which the clocks of the stages do not see, and by what runs
    /// between the stages.
    pub cpu: Option<Cost>,
    /// Every round.
    pub rounds: Vec<Round>,
}

impl SceneReport {
    /// Draws the conclusions from the rounds.
    pub fn new(scene: String, paper: Option<&PaperRow>, rounds: Vec<Round>) -> Self {
        let scalar_seconds = median_of(&rounds, |round| round.scalar.seconds);
        let polarized_seconds = median_of(&rounds, |round| round.polarized.seconds);
        let ratios: Vec<f64> =
            rounds.iter().map(|round| round.polarized.seconds / round.scalar.seconds).collect();
        let all_stages = Cost::mean(&rounds, |m| m.stages.iter().map(|stage| stage.1).sum());
        let has_cpu = |m: &Measured| m.cpu_seconds.is_some();
        let cpu = rounds.iter().all(|round| has_cpu(&round.scalar) && has_cpu(&round.polarized));
        Self {
            scene,
            paper: paper.copied(),
            photons: Cost::mean(&rounds, |m| m.photons as f64).scalar,
            scalar_seconds,
            polarized_seconds,
            ratio_of_medians: polarized_seconds / scalar_seconds,
            median_of_ratios: median(&ratios),
            ratio_interval: median_interval(&ratios, COVERAGE),
            same_paths: rounds.iter().all(|round| round.scalar.is_as(&round.polarized)),
            groups: groups(&rounds, all_stages.difference),
            all_stages,
            cpu: cpu.then(|| Cost::mean(&rounds, |m| m.cpu_seconds.unwrap_or(0.0))),
            rounds,
        }
    }
}

fn median_of(rounds: &[Round], seconds: impl Fn(&Round) -> f64) -> f64 {
    median(&rounds.iter().map(seconds).collect::<Vec<f64>>())
}

fn groups(rounds: &[Round], overhead: f64) -> Vec<GroupCost> {
    let group = |(name, members): (&'static str, &[Stage])| {
        let of_members =
            |m: &Measured| members.iter().map(|&stage| m.stages[stage as usize].1).sum();
        let cost = Cost::mean(rounds, of_members);
        GroupCost {
            name,
            stages: members.iter().map(|&stage| STAGES[stage as usize]).collect(),
            cost,
            share_of_overhead: (overhead > 0.0).then(|| cost.difference / overhead),
        }
    };
    GROUPS.into_iter().map(group).collect()
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

impl fmt::Display for Table1 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "Table 1: seconds per iteration without and with polarization\n")?;
        self.write_rows(f)?;
        self.write_notes(f)?;
        for scene in &self.scenes {
            write!(f, "\n\n{}, stage by stage: ", scene.scene)?;
            write!(f, "mean seconds per iteration, summed over threads")?;
            scene.write_stages(f)?;
        }
        Ok(())
    }
}

impl Table1 {
    fn write_rows(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lengths = self.scenes.iter().map(|scene| scene.scene.chars().count());
        let width = lengths.max().unwrap_or(0).max(6);
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
            let interval = scene
                .ratio_interval
                .map_or("-".into(), |interval| format!("{:.3}-{:.3}", interval.low, interval.high));
            write!(
                f,
                "{figure:>4} {:<width$} {:>8} {:>9.4} {:>9.4} {:>6.3} {:>6.3} {interval:>13}   |",
                scene.scene,
                thousands(scene.photons),
                scene.scalar_seconds,
                scene.polarized_seconds,
                scene.ratio_of_medians,
                scene.median_of_ratios,
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
        let Conditions { version, processors, threads, color, integrator, .. } = &self.conditions;
        let Conditions { width, height, iterations, photons_shot, .. } = self.conditions;
        let samples = self.conditions.samples_per_iteration;
        let processor = self.conditions.processor.as_deref().unwrap_or("unknown processor");
        write!(
            f,
            "\nHere: sunstone {version}, {threads} threads, {processors} of {processor};\n\
             {integrator}, {color}, {width} x {height} pixels, {iterations} iterations a mode, \
             each of {photons_shot} light paths\nand {samples} samples a pixel; the modes \
             alternate, after one iteration each that is not counted.\n\
             Seconds are medians of the wall clock; ratio is that of these medians, median that \
             of the\nratios of the rounds, and interval holds the latter",
        )?;
        match self.scenes.iter().find_map(|scene| scene.ratio_interval) {
            Some(Interval { coverage, .. }) => write!(
                f,
                " with a chance of {:.1} %: order statistics,\nwhatever the distribution.",
                100.0 * coverage
            )?,
            None => write!(f, ": one round tells none.")?,
        }
        let paths = match self.scenes.iter().all(|scene| scene.same_paths) {
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

impl SceneReport {
    fn write_stages(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "\n{:<45} {:>10} {:>10} {:>10} {:>12}",
            "", "scalar", "polarized", "difference", "of overhead"
        )?;
        for group in &self.groups {
            let name = match group.stages[..] {
                [only] if group.name.contains(only) || only == "mueller" => group.name.to_owned(),
                _ => format!("{} ({})", group.name, group.stages.join(", ")),
            };
            write_cost(f, &name, group.cost)?;
            if let Some(share) = group.share_of_overhead {
                write!(f, " {:>10.1} %", 100.0 * share)?;
            }
        }
        let stages = self.all_stages;
        write_cost(f, "all stages", stages)?;
        write_ratio(f, stages)?;
        let Some(cpu) = self.cpu else { return Ok(()) };
        write_cost(f, "CPU time, measured", cpu)?;
        write_ratio(f, cpu)?;
        let rest = Cost::new(cpu.scalar - stages.scalar, cpu.polarized - stages.polarized);
        write_cost(f, "CPU time less all stages", rest)?;
        if cpu.scalar + cpu.polarized < BUSY * (stages.scalar + stages.polarized) {
            write!(f, "\nThreads waited while stages were timed: was the machine busy?")?;
        }
        Ok(())
    }
}

fn write_ratio(f: &mut fmt::Formatter<'_>, cost: Cost) -> fmt::Result {
    write!(f, " {:>12}", format!("x {:.3}", cost.polarized / cost.scalar))
}

fn write_cost(f: &mut fmt::Formatter<'_>, name: &str, cost: Cost) -> fmt::Result {
    let Cost { scalar, polarized, difference } = cost;
    write!(f, "\n{name:<45} {scalar:>10.4} {polarized:>10.4} {difference:>+10.4}")
}

/// A count as the paper writes it.
fn thousands(count: f64) -> String {
    if count < 10_000.0 { format!("{count:.0}") } else { format!("{:.0}K", count / 1000.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stage_is_in_one_group() {
        let mut rows: Vec<usize> = Vec::new();
        for (_, stages) in GROUPS {
            rows.extend(stages.iter().map(|&stage| stage as usize));
        }
        rows.sort_unstable();
        assert_eq!(rows, (0..STAGES.len()).collect::<Vec<_>>());
    }

    fn measured(seconds: f64, mueller: f64) -> Measured {
        let (mut before, mut after) = (Profile::default(), Profile::default());
        before.photons = 5;
        after.photons = 12;
        after.times[Stage::Trace as usize] = std::time::Duration::from_millis(1500);
        after.times[Stage::Mueller as usize] = std::time::Duration::from_secs_f64(mueller);
        Measured::new(seconds, Some(2.0 * seconds), [&before, &after], vec![0.5])
    }

    #[test]
    fn conclusions_follow_from_the_rounds() {
        let round = |polarized: f64| Round {
            polarized_first: false,
            scalar: measured(1.0, 0.0),
            polarized: measured(polarized, 0.25),
        };
        let rounds = vec![round(1.2), round(9.0), round(1.1)];
        let report = SceneReport::new("a".into(), Some(&PAPER.rows[0]), rounds);
        assert_eq!((report.scalar_seconds, report.polarized_seconds), (1.0, 1.2));
        assert_eq!((report.ratio_of_medians, report.median_of_ratios), (1.2, 1.2));
        assert_eq!((report.photons, report.same_paths), (7.0, true));
        assert_eq!(report.all_stages, Cost::new(1.5, 1.75));
        assert_eq!(report.groups[3].share_of_overhead, Some(1.0));
        assert_eq!(report.cpu.expect("all rounds have it").scalar, 2.0);
        assert_eq!(report.paper.expect("it was given").ratio(), 1.75);
    }
}
