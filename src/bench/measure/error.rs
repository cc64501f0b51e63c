//! Error over time.

use std::ops::ControlFlow;

use super::clock::{Taken, machine, timed};
use super::{MeasureError, Subject, Watch, color_in_words};
use crate::bench::convergence::{
    ComponentError, Conditions, Convergence, ErrorReport, Reference, Step,
};
use crate::image::StokesImage;
use crate::image::compare::{ComponentComparison, compare, relative_variance};
use crate::integrators::Integrator;
use crate::render::threads::Threads;
use crate::render::{Options, Renderer, Settings};

/// Replicates of a reference that is rendered, for its variances.
pub const REPLICATES: u32 = 16;

/// What is measured.
pub struct Task<'a> {
    /// In which scene.
    pub subject: &'a Subject,
    /// How; with one sample an iteration. The size of the film is known.
    pub options: Options,
    /// By which integrators.
    pub integrators: &'a [Integrator],
    /// Renders of each, with seeds that follow each other; their errors are averaged.
    pub seeds: u32,
    /// Most iterations.
    pub iterations: u32,
    /// Seconds of all cores together after which no longer step is begun.
    pub seconds: f64,
}

/// What is true.
pub enum Truth {
    /// An image, and what it is called.
    Image(Box<StokesImage>, String),
    /// A render that is still to be made.
    Render {
        /// By which integrator.
        integrator: Integrator,
        /// Samples per pixel.
        samples: u32,
    },
}

/// How many rounds a task takes.
pub fn rounds_in_all(integrators: usize, seeds: u32) -> u64 {
    integrators as u64 * u64::from(seeds) + 1
}

/// Measures errors over time.
pub fn error(
    task: &Task,
    truth: Truth,
    threads: &Threads,
    watch: &impl Watch,
) -> Result<ErrorReport, MeasureError> {
    watch.at("reference");
    let (image, name) = match truth {
        Truth::Image(image, name) => (*image, name),
        Truth::Render { integrator, samples } => reference(task, integrator, samples, threads)?,
    };
    let reference = Reference { name, relative_variance: relative_variance(&image) };
    watch.round();
    let mut integrators = Vec::with_capacity(task.integrators.len());
    for &integrator in task.integrators {
        watch.at(integrator.name());
        let run = |index: u32| {
            let seed = task.options.seed.wrapping_add(index);
            let steps = converge(
                task,
                Options { integrator: Some(integrator), seed, ..task.options.clone() },
                threads,
                &image,
            );
            watch.round();
            steps
        };
        let runs: Vec<Vec<Step>> = (0..task.seeds).map(run).collect::<Result<_, _>>()?;
        integrators.push(Convergence::mean(integrator.name(), &runs));
    }
    Ok(ErrorReport::new(conditions(task, threads), reference, integrators))
}

/// Renders a reference with a seed of its own; and says how.
fn reference(
    task: &Task,
    integrator: Integrator,
    samples: u32,
    threads: &Threads,
) -> Result<(StokesImage, String), MeasureError> {
    let settings = Settings::new(Options {
        integrator: Some(integrator),
        samples,
        replicates: REPLICATES,
        seed: task.options.seed.wrapping_sub(1),
        ..task.options.clone()
    })?;
    let mut renderer = Renderer::new(&task.subject.world, &settings)?;
    threads.run(|| renderer.run(|_| ControlFlow::Continue(())));
    let name = format!("{} with {samples} samples a pixel, rendered here", integrator.name());
    Ok((renderer.finish(), name))
}

/// Renders until time or iterations run out, and compares at every power of two.
fn converge(
    task: &Task,
    options: Options,
    threads: &Threads,
    reference: &StokesImage,
) -> Result<Vec<Step>, MeasureError> {
    let mut renderer = Renderer::new(&task.subject.world, &Settings::new(options)?)?;
    let mut steps: Vec<Step> = Vec::new();
    let (mut done, mut seconds, mut wall_seconds) = (0, 0.0, 0.0);
    let mut next = 1;
    // The next step takes as long as all before it.
    while next <= task.iterations && (done == 0 || 2.0 * seconds <= task.seconds) {
        let ((), taken) = timed(|| threads.run(|| renderer.advance(next - done)));
        seconds += cpu_or_wall(taken);
        wall_seconds += taken.seconds;
        // A render develops its film once, at its end.
        let (image, developed) = timed(|| renderer.preview());
        let compared = compare(&image, reference)?;
        let error = |found: ComponentComparison| ComponentError {
            name: found.name,
            rmse: found.rmse,
            relative_mse: found.relative_mse,
        };
        steps.push(Step {
            iterations: next,
            seconds: seconds + cpu_or_wall(developed),
            wall_seconds: wall_seconds + developed.seconds,
            errors: compared.components.into_iter().map(error).collect(),
        });
        done = next;
        next *= 2;
    }
    Ok(steps)
}

fn cpu_or_wall(taken: Taken) -> f64 {
    taken.cpu_seconds.unwrap_or(taken.seconds)
}

fn conditions(task: &Task, threads: &Threads) -> Conditions {
    let options = &task.options;
    let [width, height] = [options.width, options.height].map(|edge| edge.unwrap_or(0));
    Conditions {
        machine: machine(threads),
        scene: task.subject.label.clone(),
        mode: options.mode.name().into(),
        color: color_in_words(options),
        width,
        height,
        photons_shot: options.photons.light_paths([width, height]),
        path_length_max: options.path_length_max,
        roulette_after: options.roulette_after,
        seeds: task.seeds,
        seed: options.seed,
    }
}
