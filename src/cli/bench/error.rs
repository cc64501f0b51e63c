//! `bench error`.

use std::path::PathBuf;

use super::args::ErrorArguments;
use super::report::{check_outputs, deliver};
use super::{progress_of, work};
use crate::bench::measure::error::{self as measure, REPLICATES, Task, Truth, rounds_in_all};
use crate::cli::files::say;
use crate::cli::{CliError, job};
use crate::image::StokesImage;
use crate::image::compare::in_words;
use crate::image::load as load_image;
use crate::integrators::Integrator;
use crate::render::Options;
use crate::render::memory::check_memory;
use crate::render::settings::SAMPLES_MAX;
use crate::render::threads::Threads;
use crate::spectrum::Color;

/// Errors over time.
pub fn error(arguments: &ErrorArguments) -> Result<(), CliError> {
    let options = options(arguments)?;
    let output = &arguments.output;
    check_outputs(&output.report, output.record.as_deref(), &inputs(arguments))?;
    let given = arguments.reference.as_ref().map(|path| load_image(path)).transpose()?;
    let size_of = |image: &StokesImage| [image.width as u32, image.height as u32];
    let size = work::size(&arguments.work, given.as_ref().map(size_of))?;
    let [width, height] = size.map(Some);
    let options = Options { width, height, ..options.clone() };
    if let Some(image) = &given {
        check_fit(arguments, image, &options, size)?;
    }
    check_memory(&options, size)?;
    let subject = work::load(&arguments.scene, &arguments.work.files)?;
    let threads = Threads::start(arguments.work.threads)?;
    let truth = match given {
        Some(image) => Truth::Image(Box::new(image), name_of_file(arguments)),
        None => Truth::Render {
            integrator: arguments.reference_integrator.0,
            samples: arguments.reference_spp,
        },
    };
    let integrators: Vec<Integrator> = arguments.integrator.iter().map(|name| name.0).collect();
    let task = Task {
        subject: &subject,
        options,
        integrators: &integrators,
        seeds: arguments.seeds,
        iterations: arguments.iterations,
        seconds: arguments.seconds,
    };
    let progress = progress_of(rounds_in_all(integrators.len(), arguments.seeds));
    let report = measure::error(&task, truth, &threads, &progress)?;
    progress.finish();
    deliver(&report, output, ("error", &report.conditions.machine))
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
    Ok(Options { mode: arguments.mode.0, ..options.clone() })
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
    let render = StokesImage::new(width, height, settings.color.clone(), components);
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
    match (&reference.color, &settings.color) {
        (Color::Mono { wavelength_nm: first }, Color::Mono { wavelength_nm: second })
            if first != second =>
        {
            let file = name_of_file(arguments);
            say(format_args!(
                "warning: {file}: the reference is of {first} nm and the render of {second} nm"
            ));
        }
        (
            Color::Mono { .. } | Color::Rgb | Color::Bands(_) | Color::Responses(_),
            Color::Mono { .. } | Color::Rgb | Color::Bands(_) | Color::Responses(_),
        ) => {}
    }
}
