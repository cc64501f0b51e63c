//! How errors fall with time: integrators against each other.

use crate::math::elementary::{ln, pow};

use std::fmt;

use serde::Serialize;

use super::figures::{Figures, part};
use super::plot::{Axis, Curve, Panel, Point};
use super::{Machine, Report, column_width};

/// The reference's own variance relative to the least error, above which the text says so.
const REFERENCE_NOISE_MAX: f64 = 0.1;

/// The error of one Stokes component.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComponentError {
    /// `S0` to `S3`.
    pub name: String,
    /// Root of the mean squared difference from the reference.
    pub rmse: f64,
    /// Mean squared difference relative to the reference's S0.
    pub relative_mse: f64,
}

/// The image after some iterations.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Step {
    /// Iterations so far.
    pub iterations: u32,
    /// Seconds of all cores together so far, where the system tells; else of the wall clock.
    pub seconds: f64,
    /// Wall clock seconds so far.
    pub wall_seconds: f64,
    /// One entry per Stokes component.
    pub errors: Vec<ComponentError>,
}

impl Step {
    /// The mean of the same step of several renders.
    fn mean(steps: &[&Step]) -> Self {
        let mean = |of: &dyn Fn(&Step) -> f64| {
            steps.iter().map(|step| of(step)).sum::<f64>() / steps.len() as f64
        };
        let error = |(component, error): (usize, &ComponentError)| ComponentError {
            name: error.name.clone(),
            rmse: mean(&|step| step.errors[component].rmse.powi(2)).sqrt(),
            relative_mse: mean(&|step| step.errors[component].relative_mse),
        };
        Self {
            iterations: steps[0].iterations,
            seconds: mean(&|step| step.seconds),
            wall_seconds: mean(&|step| step.wall_seconds),
            errors: steps[0].errors.iter().enumerate().map(error).collect(),
        }
    }
}

/// How the image of an integrator comes about.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Convergence {
    /// The integrator's name.
    pub integrator: String,
    /// At powers of two of iterations.
    pub steps: Vec<Step>,
}

impl Convergence {
    /// The mean of renders with different seeds, as far as all of them have come.
    pub fn mean(integrator: &str, runs: &[Vec<Step>]) -> Self {
        let length = runs.iter().map(Vec::len).min().unwrap_or(0);
        let step = |index| Step::mean(&runs.iter().map(|run| &run[index]).collect::<Vec<_>>());
        Self { integrator: integrator.into(), steps: (0..length).map(step).collect() }
    }

    /// Relative mean squared errors of a component over seconds.
    fn curve(&self, component: usize) -> Vec<(f64, f64)> {
        let point = |step: &Step| (step.seconds, step.errors[component].relative_mse);
        self.steps.iter().map(point).collect()
    }

    /// Components that all images have.
    fn components(&self) -> usize {
        self.steps.first().map_or(0, |step| step.errors.len())
    }
}

/// Two integrators at the same place of their curves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Equal {
    /// The seconds, or the relative mean squared error, that are the same.
    pub at: f64,
    /// The other integrator's error, or time, over that of the first.
    pub ratio: f64,
}

/// An integrator against the first, in one Stokes component.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Duel {
    /// The integrator's name.
    pub integrator: String,
    /// The first integrator's name.
    pub against: String,
    /// `S0` to `S3`.
    pub component: String,
    /// Ratios of relative mean squared errors at equal times, from early to late.
    pub equal_time: Vec<Equal>,
    /// Ratios of times to equal errors, from large to small errors.
    pub equal_error: Vec<Equal>,
}

impl Duel {
    fn new(other: &Convergence, first: &Convergence, component: usize) -> Self {
        let (ours, theirs) = (first.curve(component), other.curve(component));
        let name = &first.steps[0].errors[component].name;
        Self {
            integrator: other.integrator.clone(),
            against: first.integrator.clone(),
            component: name.clone(),
            equal_time: equal_times(&ours, &theirs),
            equal_error: equal_errors(&ours, &theirs),
        }
    }
}

/// Ratios of errors at the times of the first curve that the second covers, and at the end of what
/// both cover.
fn equal_times(first: &[(f64, f64)], second: &[(f64, f64)]) -> Vec<Equal> {
    let end = |curve: &[(f64, f64)]| curve.last().map_or(0.0, |point| point.0);
    let mut times: Vec<f64> = first.iter().map(|point| point.0).collect();
    times.push(end(first).min(end(second)));
    times.sort_by(f64::total_cmp);
    times.dedup();
    let equal = |at: f64| Some(Equal { at, ratio: error_at(second, at)? / error_at(first, at)? });
    times.into_iter().filter_map(equal).collect()
}

/// Ratios of times to the errors of the first curve that the second reaches, and to the error at
/// the end of one that both reach.
fn equal_errors(first: &[(f64, f64)], second: &[(f64, f64)]) -> Vec<Equal> {
    let end = |curve: &[(f64, f64)]| curve.last().map_or(f64::INFINITY, |point| point.1);
    let mut errors: Vec<f64> = first.iter().map(|point| point.1).collect();
    errors.push(end(first).max(end(second)));
    errors.sort_by(|a, b| b.total_cmp(a));
    errors.dedup();
    let equal = |at: f64| Some(Equal { at, ratio: time_to(second, at)? / time_to(first, at)? });
    errors.into_iter().filter_map(equal).collect()
}

/// The error of a curve at a time, between its points along straight lines of logarithms; nothing
/// outside of what was measured.
pub fn error_at(curve: &[(f64, f64)], time: f64) -> Option<f64> {
    let mut segments = curve.windows(2);
    let segment = segments.find(|pair| pair[0].0 <= time && time <= pair[1].0)?;
    between(segment[0], segment[1], time)
}

/// The time from which on the error of a curve is no more than this, in the same way; nothing if
/// it ends above. Small errors before do not count: a few samples may not yet have seen what is
/// rare and bright.
pub fn time_to(curve: &[(f64, f64)], error: f64) -> Option<f64> {
    let flip = |(time, error): (f64, f64)| (error, time);
    match curve.iter().rposition(|point| point.1 > error) {
        Some(above) => between(flip(curve[above]), flip(*curve.get(above + 1)?), error),
        None => curve.first().filter(|point| point.1 == error).map(|point| point.0),
    }
}

/// Where the straight line of logarithms through two points is at `x`.
fn between((x0, y0): (f64, f64), (x1, y1): (f64, f64), x: f64) -> Option<f64> {
    if [x0, x1, y0, y1, x].into_iter().any(|value| !(value > 0.0 && value.is_finite())) {
        return None;
    }
    let share = if x0 == x1 { 0.0 } else { ln(x / x0) / ln(x1 / x0) };
    Some(y0 * pow(y1 / y0, share))
}

/// What the errors are measured against.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reference {
    /// Its file, or how it was rendered.
    pub name: String,
    /// The relative mean squared error that it owes to its own noise, per component, if known.
    pub relative_variance: Option<Vec<f64>>,
}

/// What was measured on what.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Conditions {
    /// On what.
    #[serde(flatten)]
    pub machine: Machine,
    /// The scene as it was named.
    pub scene: String,
    /// `scalar` or `polarized`.
    pub mode: String,
    /// What the channels stand for.
    pub color: String,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Light paths an iteration, with photons.
    pub photons_shot: u32,
    /// Most segments of a path.
    pub path_length_max: u32,
    /// Path length after which roulette may end a path, where a number is given.
    pub roulette_after: Option<u32>,
    /// Renders of each integrator, whose errors are averaged.
    pub seeds: u32,
    /// Seed of the first of them.
    pub seed: u32,
}

/// The whole report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErrorReport {
    /// What was measured on what.
    pub conditions: Conditions,
    /// What against.
    pub reference: Reference,
    /// One entry an integrator.
    pub integrators: Vec<Convergence>,
    /// The others against the first, each in every component.
    pub duels: Vec<Duel>,
}

impl ErrorReport {
    /// Draws the conclusions.
    pub fn new(
        conditions: Conditions,
        reference: Reference,
        integrators: Vec<Convergence>,
    ) -> Self {
        let duels = match &integrators[..] {
            [first, others @ ..] if first.components() > 0 => others
                .iter()
                .flat_map(|other| {
                    (0..first.components()).map(move |component| Duel::new(other, first, component))
                })
                .collect(),
            _ => Vec::new(),
        };
        Self { conditions, reference, integrators, duels }
    }

    /// Components whose least error is not much more than what the reference's noise makes.
    fn noisy_components(&self) -> Vec<String> {
        let Some(variances) = &self.reference.relative_variance else { return Vec::new() };
        let is_noisy = |(component, variance): &(usize, &f64)| {
            let steps = self.integrators.iter().flat_map(|integrator| &integrator.steps);
            let errors = steps.filter_map(|step| step.errors.get(*component));
            let least = errors.map(|error| error.relative_mse).fold(f64::INFINITY, f64::min);
            **variance > REFERENCE_NOISE_MAX * least
        };
        let noisy = variances.iter().enumerate().filter(is_noisy);
        noisy.map(|(component, _)| format!("S{component}")).collect()
    }

    fn write_steps(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for Convergence { integrator, steps } in &self.integrators {
            let Some(first) = steps.first() else { continue };
            write!(f, "\n\n{integrator}:\n{:>10} {:>9}", "iterations", "seconds")?;
            for error in &first.errors {
                write!(f, " {:>9} {:>9}", format!("{} rmse", error.name), "rel. mse")?;
            }
            for Step { iterations, seconds, errors, .. } in steps {
                write!(f, "\n{iterations:>10} {seconds:>9.4}")?;
                for ComponentError { rmse, relative_mse, .. } in errors {
                    write!(f, " {rmse:>9.3e} {relative_mse:>9.3e}")?;
                }
            }
        }
        Ok(())
    }

    fn write_duels(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(duel) = self.duels.first() else { return Ok(()) };
        let width = column_width(self.duels.iter().map(|duel| duel.integrator.as_str()), 10);
        write!(
            f,
            "\n\nAgainst {}: ratios of the relative mse at equal time, and of the time to equal \
             relative mse,\nat the end of what both have measured\n\
             {:<width$}    {:>10} {:>12}   {:>12} {:>12}",
            duel.against, "", "error", "at seconds", "time", "to rel. mse"
        )?;
        for Duel { integrator, component, equal_time, equal_error, .. } in &self.duels {
            write!(f, "\n{integrator:<width$} {component}")?;
            match equal_time.last() {
                Some(Equal { at, ratio }) => write!(f, " {ratio:>10.4} {at:>12.4}")?,
                None => write!(f, " {:>10} {:>12}", "-", "-")?,
            }
            match equal_error.last() {
                Some(Equal { at, ratio }) => write!(f, "   {ratio:>12.4} {at:>12.3e}")?,
                None => write!(f, "   {:>12} {:>12}", "-", "-")?,
            }
        }
        Ok(())
    }

    fn write_caveat(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.reference.relative_variance.is_none() {
            return write!(
                f,
                "\n\nThe reference holds no variances: how much of these errors is its own noise \
                 is open."
            );
        }
        match &self.noisy_components()[..] {
            [] => Ok(()),
            noisy => write!(
                f,
                "\n\nCaution: more than {} % of the least error in {} is the noise of the \
                 reference itself.\nA reference of more samples would tell more.",
                100.0 * REFERENCE_NOISE_MAX,
                noisy.join(", ")
            ),
        }
    }
}

impl Report for ErrorReport {
    fn panels(&self) -> Vec<Panel> {
        let count = self.integrators.iter().map(Convergence::components).min().unwrap_or(0);
        let curve = |convergence: &Convergence, component: usize| Curve {
            name: convergence.integrator.clone(),
            points: (convergence.curve(component).into_iter())
                .map(|(seconds, error)| Point::new(seconds, error))
                .collect(),
        };
        let panel = |component: usize| Panel {
            title: format!("{}, S{component}", self.conditions.scene),
            x: Axis::logarithmic("seconds"),
            y: Axis::logarithmic("relative mean squared error"),
            curves: self.integrators.iter().map(|found| curve(found, component)).collect(),
        };
        (0..count).map(panel).collect()
    }

    fn figures(&self) -> Figures {
        let mut figures = Figures::default();
        let Conditions { scene, color, .. } = &self.conditions;
        let (scene, color) = (part(scene), part(&color.to_lowercase()));
        for Convergence { integrator, steps } in &self.integrators {
            let Some(last) = steps.last() else { continue };
            for ComponentError { name, relative_mse, .. } in &last.errors {
                let name = ["error", &scene, integrator, &color, name, "relative_mse_seconds"];
                figures.add(&name, relative_mse * last.seconds);
            }
        }
        for Duel { integrator, component, equal_time, equal_error, .. } in &self.duels {
            let name = ["error", &scene, integrator, &color, component].join(".");
            if let Some(Equal { ratio, .. }) = equal_time.last() {
                figures.add(&[&name, "equal_time_ratio"], *ratio);
            }
            if let Some(Equal { ratio, .. }) = equal_error.last() {
                figures.add(&[&name, "equal_error_ratio"], *ratio);
            }
        }
        figures
    }
}

impl fmt::Display for ErrorReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Conditions { machine, scene, mode, color, width, height, seeds, .. } = &self.conditions;
        write!(
            f,
            "Error over time: {scene}, {mode}, {color}, {width} x {height} pixels\n\n\
             {machine};\nmeans of {seeds} renders with different seeds; seconds are those of all \
             cores together.\nThe reference is {}.",
            self.reference.name
        )?;
        self.write_steps(f)?;
        self.write_duels(f)?;
        self.write_caveat(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative errors `scale / time` at these times.
    fn curve(scale: f64, times: &[f64]) -> Vec<(f64, f64)> {
        times.iter().map(|&time| (time, scale / time)).collect()
    }

    fn is_near(a: f64, b: f64) -> bool {
        (a / b - 1.0).abs() < 1e-12
    }

    #[test]
    fn powers_are_followed_between_the_points_and_not_beyond() {
        let curve = curve(3.0, &[1.0, 10.0, 30.0]);
        assert!(is_near(error_at(&curve, 5.0).unwrap(), 0.6));
        assert!(is_near(time_to(&curve, 0.2).unwrap(), 15.0));
        for outside in [0.9, 31.0] {
            assert_eq!(error_at(&curve, outside), None);
        }
        for outside in [3.1, 0.09] {
            assert_eq!(time_to(&curve, outside), None);
        }
        // The last time counts where errors have risen in between, and none where they end above
        // or were zero.
        let rising = [(1.0, 1.0), (2.0, 0.1), (3.0, 0.8), (4.0, 0.1)];
        assert!(time_to(&rising, 0.5).unwrap() > 3.0);
        assert_eq!(time_to(&rising[..3], 0.5), None);
        assert_eq!(error_at(&[(1.0, 0.0), (2.0, 0.0)], 1.5), None);
    }

    /// Twice the error at equal time is half the speed where errors fall as one over time.
    #[test]
    fn ratios_at_equal_time_and_error() {
        let (first, second) = (curve(1.0, &[1.0, 2.0, 4.0, 8.0]), curve(2.0, &[0.5, 3.0, 5.0]));
        let times = equal_times(&first, &second);
        assert_eq!(times.iter().map(|e| e.at).collect::<Vec<_>>(), [1.0, 2.0, 4.0, 5.0]);
        assert!(times.iter().all(|equal| is_near(equal.ratio, 2.0)), "{times:?}");
        let errors = equal_errors(&first, &second);
        assert_eq!(errors.iter().map(|e| e.at).collect::<Vec<_>>(), [1.0, 0.5, 0.4]);
        assert!(errors.iter().all(|equal| is_near(equal.ratio, 2.0)), "{errors:?}");
        assert!(equal_times(&first, &curve(1.0, &[9.0, 10.0])).is_empty());
    }

    fn report(variance: Option<f64>) -> ErrorReport {
        let step = |seconds: f64, relative_mse: f64| Step {
            iterations: 1,
            seconds,
            wall_seconds: seconds,
            errors: vec![ComponentError { name: "S0".into(), rmse: 1.0, relative_mse }],
        };
        // Two seeds whose mean is the scale; one has come further.
        let convergence = |name: &str, scale: f64| {
            let run = |times: &[f64], scale: f64| {
                times.iter().map(|&time| step(time, scale / time)).collect::<Vec<Step>>()
            };
            let runs =
                [run(&[1.0, 2.0, 4.0, 8.0], 0.5 * scale), run(&[1.0, 2.0, 4.0], 1.5 * scale)];
            Convergence::mean(name, &runs)
        };
        let machine =
            Machine { version: String::new(), processor: None, processors: 1, threads: 1 };
        let conditions = Conditions {
            machine,
            scene: "a".into(),
            mode: "scalar".into(),
            color: "RGB".into(),
            width: 1,
            height: 1,
            photons_shot: 1,
            path_length_max: 1,
            roulette_after: Some(1),
            seeds: 1,
            seed: 0,
        };
        let reference = Reference {
            name: "r".into(),
            relative_variance: variance.map(|variance| vec![variance]),
        };
        ErrorReport::new(
            conditions,
            reference,
            vec![convergence("path", 1.0), convergence("bdpt", 0.5)],
        )
    }

    #[test]
    fn noise_of_the_reference_is_said() {
        let [quiet, loud, unknown] = [Some(0.01), Some(0.02), None].map(|v| report(v).to_string());
        assert!(!quiet.contains("Caution") && !quiet.contains("no variances"), "{quiet}");
        assert!(loud.contains("Caution: more than 10 % of the least error in S0"), "{loud}");
        assert!(unknown.contains("holds no variances"), "{unknown}");
    }

    #[test]
    fn figures_are_those_of_the_ends() {
        let figures = report(None).figures().0;
        assert!(is_near(figures["error.a.path.rgb.S0.relative_mse_seconds"], 1.0));
        assert!(is_near(figures["error.a.bdpt.rgb.S0.equal_time_ratio"], 0.5));
        assert!(is_near(figures["error.a.bdpt.rgb.S0.equal_error_ratio"], 0.5));
        assert_eq!(figures.len(), 4);
    }
}
