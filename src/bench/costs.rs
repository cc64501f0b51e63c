//! What polarization costs: the same work in both modes, in rounds that alternate, and the stages
//! that the difference goes into.

use std::fmt;

use serde::Serialize;

use super::figures::Figures;
use super::interval_in_words;
use crate::integrators::profile::{Profile, STAGES, Stage};
use crate::math::statistics::{Interval, median, median_interval};

/// Least coverage of the intervals, where there are enough rounds.
pub const COVERAGE: f64 = 0.95;

/// Time of all stages relative to CPU time, above which the text says that threads waited.
const WAITING: f64 = 1.1;

/// What the stages may miss of the difference of the modes and still add up to it.
const GAP_MAX: f64 = 0.1;

/// One connection in so many, of those that are played for, may fall out otherwise where modes
/// round otherwise; what is not the same work differs by far more.
const ROUNDED_OTHERWISE: u64 = 1000;

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

/// The work of one round in one mode.
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
    pub radii: Vec<Option<f32>>,
}

impl Measured {
    /// What was done between two looks at the profile of a render.
    pub fn new(
        seconds: f64,
        cpu_seconds: Option<f64>,
        [before, after]: [&Profile; 2],
        radii: Vec<Option<f32>>,
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

    fn of_stages(&self) -> f64 {
        self.stages.iter().map(|stage| stage.1).sum()
    }

    fn is_as(&self, other: &Self) -> bool {
        self.photons == other.photons
            && self.rays_closest == other.rays_closest
            && self.rays_visibility.abs_diff(other.rays_visibility)
                <= self.rays_visibility / ROUNDED_OTHERWISE
            && self.radii == other.radii
    }
}

/// The same work in both modes, one right after the other.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Round {
    /// Which of them came first.
    pub polarized_first: bool,
    /// Without polarization.
    pub scalar: Measured,
    /// With polarization.
    pub polarized: Measured,
}

impl Round {
    /// What `seconds` finds with polarization less what it finds without.
    fn difference(&self, seconds: impl Fn(&Measured) -> f64) -> f64 {
        seconds(&self.polarized) - seconds(&self.scalar)
    }
}

/// Seconds a round in both modes, means over the rounds.
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
    /// A cost in both modes.
    pub fn new(scalar: f64, polarized: f64) -> Self {
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

/// Polarized over scalar by one clock.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ratio {
    /// Seconds a round without polarization: the median over the rounds.
    pub scalar_seconds: f64,
    /// The same with polarization.
    pub polarized_seconds: f64,
    /// Polarized over scalar of these two.
    pub ratio_of_medians: f64,
    /// The median over the rounds of polarized over scalar.
    pub median_of_ratios: f64,
    /// Where the median of the ratios lies.
    pub ratio_interval: Option<Interval>,
}

impl Ratio {
    fn new(rounds: &[Round], seconds: impl Fn(&Measured) -> f64) -> Self {
        let scalar_seconds = median_of(rounds, |round| seconds(&round.scalar));
        let polarized_seconds = median_of(rounds, |round| seconds(&round.polarized));
        let ratio = |round: &Round| seconds(&round.polarized) / seconds(&round.scalar);
        let ratios: Vec<f64> = rounds.iter().map(ratio).collect();
        Self {
            scalar_seconds,
            polarized_seconds,
            ratio_of_medians: polarized_seconds / scalar_seconds,
            median_of_ratios: median(&ratios),
            ratio_interval: median_interval(&ratios, COVERAGE),
        }
    }
}

/// Whether the stages account for the difference of the modes: medians over the rounds, in
/// seconds of all cores together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Account {
    /// Polarized less scalar as the system counts.
    pub measured: f64,
    /// Polarized less scalar by the clocks of the stages, over `waiting`.
    pub of_stages: f64,
    /// What the clocks of the stages count over what the system counts, in both modes together;
    /// 1 if it is less. Their clocks run on while a busy machine lets threads wait.
    pub waiting: f64,
    /// `of_stages` less `measured`.
    pub gap: f64,
    /// Where the median of the gap lies.
    pub gap_interval: Option<Interval>,
    /// Whether the gap is less than a tenth of the difference, or the interval holds zero.
    pub adds_up: bool,
}

impl Account {
    fn new(rounds: &[Round], cpu: impl Fn(&Measured) -> f64) -> Self {
        let waiting = |round: &Round| {
            let counted = cpu(&round.scalar) + cpu(&round.polarized);
            ((round.scalar.of_stages() + round.polarized.of_stages()) / counted).max(1.0)
        };
        let of_stages = |round: &Round| round.difference(Measured::of_stages) / waiting(round);
        let gap = |round: &Round| of_stages(round) - round.difference(&cpu);
        let gap_interval = median_interval(&rounds.iter().map(gap).collect::<Vec<f64>>(), COVERAGE);
        let is_noise = gap_interval.is_some_and(|found| found.low <= 0.0 && found.high >= 0.0);
        let (measured, gap) =
            (median_of(rounds, |round| round.difference(&cpu)), median_of(rounds, gap));
        Self {
            measured,
            of_stages: median_of(rounds, of_stages),
            waiting: median_of(rounds, waiting),
            gap,
            gap_interval,
            adds_up: is_noise || is_small(gap, measured),
        }
    }
}

/// Whether a gap is a small part of a difference.
fn is_small(gap: f64, difference: f64) -> bool {
    gap.abs() <= GAP_MAX * difference.abs()
}

/// All that rounds in both modes tell.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Costs {
    /// By the clock on the wall.
    #[serde(flatten)]
    pub wall: Ratio,
    /// By the seconds of all cores together, where the system tells.
    pub cpu_ratio: Option<Ratio>,
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
    /// Whether the stages add up to the difference, where the system counts.
    pub account: Option<Account>,
    /// Every round.
    pub rounds: Vec<Round>,
}

impl Costs {
    /// Draws the conclusions from the rounds.
    pub fn new(rounds: Vec<Round>) -> Self {
        let all_stages = Cost::mean(&rounds, Measured::of_stages);
        let has_cpu = |m: &Measured| m.cpu_seconds.is_some();
        let is_known =
            rounds.iter().all(|round| has_cpu(&round.scalar) && has_cpu(&round.polarized));
        let cpu = |m: &Measured| m.cpu_seconds.unwrap_or(0.0);
        Self {
            wall: Ratio::new(&rounds, |m| m.seconds),
            cpu_ratio: is_known.then(|| Ratio::new(&rounds, cpu)),
            same_paths: rounds.iter().all(|round| round.scalar.is_as(&round.polarized)),
            groups: groups(&rounds, all_stages.difference),
            all_stages,
            cpu: is_known.then(|| Cost::mean(&rounds, cpu)),
            account: is_known.then(|| Account::new(&rounds, cpu)),
            rounds,
        }
    }

    /// Photons stored in a round, on average.
    pub fn photons(&self) -> f64 {
        Cost::mean(&self.rounds, |m| m.photons as f64).scalar
    }

    /// The ratio by the best clock there is: that of the cores, else that on the wall.
    pub fn ratio(&self) -> &Ratio {
        self.cpu_ratio.as_ref().unwrap_or(&self.wall)
    }

    /// The figures under a name.
    pub fn add_figures(&self, figures: &mut Figures, name: &str) {
        let ratio = self.ratio();
        figures.add(&[name, "ratio"], ratio.median_of_ratios);
        figures.add(&[name, "wall_ratio"], self.wall.median_of_ratios);
        figures.add(&[name, "scalar_seconds"], ratio.scalar_seconds);
        figures.add(&[name, "polarized_seconds"], ratio.polarized_seconds);
    }

    /// Writes the stages in groups, both modes side by side, and whether they add up.
    pub fn write_stages(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
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
        write_cost(f, "all stages", self.all_stages)?;
        write_ratio(f, self.all_stages)?;
        self.write_cpu(f)
    }

    fn write_cpu(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let stages = self.all_stages;
        let (Some(cpu), Some(account)) = (self.cpu, self.account) else { return Ok(()) };
        write_cost(f, "CPU time, measured", cpu)?;
        write_ratio(f, cpu)?;
        let rest = Cost::new(cpu.scalar - stages.scalar, cpu.polarized - stages.polarized);
        write_cost(f, "CPU time less all stages", rest)?;
        write!(f, "\n{account}")
    }
}

impl fmt::Display for Account {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { measured, of_stages, waiting, gap, gap_interval, adds_up } = self;
        let verdict = match (adds_up, is_small(*gap, *measured)) {
            (true, true) => "add up to",
            (true, false) => "add up, within noise, to",
            (false, _) => "do NOT add up to",
        };
        write!(
            f,
            "The stages {verdict} the measured difference: medians {of_stages:+.4} and \
             {measured:+.4} s,\n{gap:+.4} s apart in a round, which is {:+.1} %; interval {}.",
            100.0 * gap / measured,
            interval_in_words(gap_interval, 4)
        )?;
        if *waiting > WAITING {
            write!(
                f,
                "\nThreads waited while stages were timed: was the machine busy? The clocks of \
                 the stages\nran {waiting:.2} times too long, by which their sum is divided here."
            )?;
        }
        Ok(())
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

fn write_ratio(f: &mut fmt::Formatter<'_>, cost: Cost) -> fmt::Result {
    write!(f, " {:>12}", format!("x {:.3}", cost.polarized / cost.scalar))
}

fn write_cost(f: &mut fmt::Formatter<'_>, name: &str, cost: Cost) -> fmt::Result {
    let Cost { scalar, polarized, difference } = cost;
    write!(f, "\n{name:<45} {scalar:>10.4} {polarized:>10.4} {difference:>+10.4}")
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

    /// `seconds` on the wall, on two cores; the stages find 1.5 seconds and those of Mueller.
    fn measured(seconds: f64, mueller: f64) -> Measured {
        let (mut before, mut after) = (Profile::default(), Profile::default());
        before.photons = 5;
        after.photons = 12;
        after.times[Stage::Trace as usize] = std::time::Duration::from_millis(1500);
        after.times[Stage::Mueller as usize] = std::time::Duration::from_secs_f64(mueller);
        Measured::new(seconds, Some(2.0 * seconds), [&before, &after], vec![Some(0.5)])
    }

    fn rounds(polarized: &[f64], mueller: f64) -> Vec<Round> {
        let round = |&polarized: &f64| Round {
            polarized_first: false,
            scalar: measured(1.0, 0.0),
            polarized: measured(polarized, mueller),
        };
        polarized.iter().map(round).collect()
    }

    #[test]
    fn conclusions_follow_from_the_rounds() {
        let costs = Costs::new(rounds(&[1.2, 9.0, 1.1], 0.25));
        assert_eq!((costs.wall.scalar_seconds, costs.wall.polarized_seconds), (1.0, 1.2));
        assert_eq!((costs.wall.ratio_of_medians, costs.wall.median_of_ratios), (1.2, 1.2));
        assert_eq!(costs.ratio().polarized_seconds, 2.4);
        assert_eq!((costs.photons(), costs.same_paths), (7.0, true));
        assert_eq!(costs.all_stages, Cost::new(1.5, 1.75));
        assert_eq!(costs.groups[3].share_of_overhead, Some(1.0));
        assert_eq!(costs.cpu.expect("all rounds have it").scalar, 2.0);
    }

    /// The system finds 0.4 seconds of difference (twice 0.2), with and without noise.
    #[test]
    fn stages_add_up_to_a_tenth_or_to_the_noise() {
        let steady = [1.2; 9];
        let noisy = [1.2, 1.1, 1.3, 1.0, 1.4, 1.2, 1.2, 1.1, 1.3];
        for (polarized, mueller, adds_up) in [
            (&steady, 0.4, true),
            (&steady, 0.43, true),
            (&steady, 0.45, false),
            (&steady, 0.35, false),
            (&noisy, 0.45, true),
            (&noisy, 0.9, false),
        ] {
            let costs = Costs::new(rounds(polarized, mueller));
            let account = costs.account.expect("all rounds have it");
            assert_eq!((account.adds_up, account.waiting), (adds_up, 1.0), "{account:?}");
            assert!((account.gap - (mueller - 0.4)).abs() < 1e-9, "{account:?}");
            assert_eq!(format!("{account}").contains("NOT"), !adds_up, "{account}");
        }
    }

    /// Clocks of stages that ran twice as long as the system counts are read at half.
    #[test]
    fn threads_that_waited_do_not_spoil_the_account() {
        let waited = |mut round: Round| {
            for measured in [&mut round.scalar, &mut round.polarized] {
                let cpu = measured.of_stages();
                measured.stages.iter_mut().for_each(|stage| stage.1 *= 2.0);
                measured.cpu_seconds = Some(cpu);
            }
            round
        };
        let rounds: Vec<Round> = rounds(&[1.2; 3], 0.4).into_iter().map(waited).collect();
        let account = Costs::new(rounds).account.expect("all rounds have it");
        assert_eq!((account.waiting, account.adds_up), (2.0, true), "{account:?}");
        assert!(account.gap.abs() < 1e-9, "{account:?}");
        assert!(format!("{account}").contains("2.00 times too long"), "{account}");
    }
}
