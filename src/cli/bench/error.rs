//! `bench error`.

use std::ops::ControlFlow;
use std::path::PathBuf;

use super::args::ErrorArguments;
use super::measure::{Taken, machine, progress_bar, timed};
use super::report::{check_outputs, deliver};
use super::subject::load;
use super::work;
use crate::bench::Machine;
use crate::bench::convergence::{
    ComponentError, Conditions, Convergence, ErrorReport, Reference, Step,
};
use crate::cli::args::IntegratorName;
use crate::cli::files::say;
use crate::cli::{CliError, job};
use crate::image::StokesImage;
use crate::image::compare::{ComponentComparison, compare, in_words, relative_variance};
use crate::image::load as load_image;
use crate::render::memory::check_memory;
use crate::render::settings::SAMPLES_MAX;
use crate::render::threads::Threads;
use crate::render::{Options, PlacedWorld, Renderer, Settings};
use crate::spectrum::Color;

/// Replicates of a reference that is rendered, for its variances.
const REPLICATES: u32 = 16;

/// Errors over time.
pub fn error(arguments: &ErrorArguments) -> Result<(), CliError> {
    let options = options(arguments)?;
    let output = &arguments.output;
    check_outputs(&output.report, output.record.as_deref(), &inputs(arguments))?;
    let given = arguments.reference.as_ref().map(|path| load_image(path)).transpose()?;
    let size_of = |image: &StokesImage| [image.width as u32, image.height as u32];
    let size = work::size(&arguments.work, given.as_ref().map(size_of))?;
    let [width, height] = size.map(Some);
    let options = Options { width, height, ..options };
    if let Some(image) = &given {
        check_fit(arguments, image, &options, size)?;
    }
    check_memory(&options, size)?;
    let subject = load(&arguments.scene)?;
    let threads = Threads::start(arguments.work.threads)?;
    let renders = arguments.integrator.len() as u64 * u64::from(arguments.seeds);
    let progress = progress_bar(renders + 1);
    progress.set_message("reference");
    let (image, name) = match given {
        Some(image) => (image, name_of_file(arguments)),
        None => reference(arguments, &subject.world, &options, &threads)?,
    };
    let reference = Reference { name, relative_variance: relative_variance(&image) };
    progress.inc(1);
    let mut integrators = Vec::with_capacity(arguments.integrator.len());
    for &IntegratorName(integrator) in &arguments.integrator {
        progress.set_message(integrator.name());
        let run = |index: u32| {
            let seed = options.seed.wrapping_add(index);
            let options = Options { integrator, seed, ..options };
            let steps = converge(arguments, &subject.world, options, &threads, &image);
            progress.inc(1);
            steps
        };
        let runs: Vec<Vec<Step>> = (0..arguments.seeds).map(run).collect::<Result<_, _>>()?;
        integrators.push(Convergence::mean(integrator.name(), &runs));
    }
    progress.finish_and_clear();
    let conditions = conditions(arguments, &options, subject.short_name(), size, machine(&threads));
    let report = ErrorReport::new(conditions, reference, integrators);
    let machine = &report.conditions.machine;
    deliver(&report, output, ("error", machine))
}

/// Checks what was typed.
fn options(arguments: &ErrorArguments) -> Result<Options, CliError> {
    let ErrorArguments { integrator, work, iterations, reference_spp, .. } = arguments;
    let mut shooting = integrator.clone();
    if arguments.reference.is_none() {
        shooting.push(arguments.reference_integrator);
    }
    work::refuse_photons(&shooting, &[("--photons", work.photons.is_some())])?;
    work::check_names(&[], integrator)?;
    job::within("--iterations", *iterations, SAMPLES_MAX, "")?;
    job::within("--seeds", arguments.seeds, 1000, "")?;
    job::within("--reference-spp", *reference_spp, SAMPLES_MAX, "")?;
    if *reference_spp < REPLICATES {
        return Err(CliError::Usage(format!(
            "--reference-spp must be {REPLICATES} or more, not {reference_spp}: its variances are \
             taken from so many replicates"
        )));
    }
    job::seconds("--seconds", Some(arguments.seconds))?;
    // The size may follow from the reference.
    let options = work::options(work, integrator[0].0, 1, work::size(work, None)?)?;
    Ok(Options { mode: arguments.mode.0, ..options })
}

fn inputs(arguments: &ErrorArguments) -> Vec<PathBuf> {
    std::iter::once(&arguments.scene).chain(&arguments.reference).cloned().collect()
}

fn name_of_file(arguments: &ErrorArguments) -> String {
    arguments.reference.as_ref().map_or(String::new(), |path| path.display().to_string())
}

/// Refuses a reference that is another kind of image than the render will be.
fn check_fit(
    arguments: &ErrorArguments,
    reference: &StokesImage,
    settings: &Options,
    [width, height]: [u32; 2],
) -> Result<(), CliError> {
    let components = settings.mode.components();
    let (width, height) = (width as usize, height as usize);
    let render = StokesImage::new(width, height, settings.color, components);
    let remedy = if (reference.width, reference.height) != (width, height) {
        "leave out --width and --height"
    } else if reference.color.channels() != settings.color.channels() {
        "choose another --color"
    } else if reference.components < components {
        "it holds the intensity alone, which goes with --mode scalar and intensity"
    } else {
        warn_of_wavelength(arguments, reference, settings);
        return Ok(());
    };
    Err(CliError::Usage(format!(
        "the reference {} is {} and the render of {} would be {}: {remedy}",
        name_of_file(arguments),
        in_words(reference),
        arguments.scene.display(),
        in_words(&render),
    )))
}

/// Other formats than EXR do not say which wavelength theirs is, so this is no error.
fn warn_of_wavelength(arguments: &ErrorArguments, reference: &StokesImage, settings: &Options) {
    match (reference.color, settings.color) {
        (Color::Mono { wavelength_nm: first }, Color::Mono { wavelength_nm: second })
            if first != second =>
        {
            let file = name_of_file(arguments);
            say(format_args!(
                "warning: {file}: the reference is of {first} nm and the render of {second} nm"
            ));
        }
        (Color::Mono { .. } | Color::Rgb, Color::Mono { .. } | Color::Rgb) => {}
    }
}

/// Renders a reference with a seed of its own; and says how.
fn reference(
    arguments: &ErrorArguments,
    world: &PlacedWorld,
    options: &Options,
    threads: &Threads,
) -> Result<(StokesImage, String), CliError> {
    let integrator = arguments.reference_integrator.0;
    let settings = Settings::new(Options {
        integrator,
        samples: arguments.reference_spp,
        replicates: REPLICATES,
        seed: options.seed.wrapping_sub(1),
        ..*options
    })?;
    let mut renderer = Renderer::new(world, &settings)?;
    threads.run(|| renderer.run(|_| ControlFlow::Continue(())));
    let samples = arguments.reference_spp;
    let name = format!("{} with {samples} samples a pixel, rendered here", integrator.name());
    Ok((renderer.finish(), name))
}

/// Renders until time or iterations run out, and compares at every power of two.
fn converge(
    arguments: &ErrorArguments,
    world: &PlacedWorld,
    options: Options,
    threads: &Threads,
    reference: &StokesImage,
) -> Result<Vec<Step>, CliError> {
    let mut renderer = Renderer::new(world, &Settings::new(options)?)?;
    let mut steps: Vec<Step> = Vec::new();
    let (mut done, mut seconds, mut wall_seconds) = (0, 0.0, 0.0);
    let mut next = 1;
    // The next step takes as long as all before it.
    while next <= arguments.iterations && (done == 0 || 2.0 * seconds <= arguments.seconds) {
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

fn conditions(
    arguments: &ErrorArguments,
    settings: &Options,
    scene: String,
    [width, height]: [u32; 2],
    machine: Machine,
) -> Conditions {
    Conditions {
        machine,
        scene,
        mode: settings.mode.name().into(),
        color: settings.color.to_string(),
        width,
        height,
        photons_shot: settings.photons.per_iteration,
        path_length_max: settings.path_length_max,
        roulette_after: settings.roulette_after,
        seeds: arguments.seeds,
        seed: settings.seed,
    }
}
