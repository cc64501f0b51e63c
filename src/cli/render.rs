//! The verb `render`: load, check, render, write.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::image::StokesImage;
use crate::integrators::profile::STAGES;
use crate::render::statistics::{RenderStatistics, peak_memory_bytes};
use crate::render::threads::Threads;
use crate::render::{self, Integrator, Mode, Outcome, Progress, Settings};
use crate::scattering::Scene;
use crate::scene::baked::{BakedScene, MaterialKind};
use crate::scene::{self, World};
use crate::spectrum::Color;

use super::CliError;
use super::args::{RenderArguments, StatsFormat};
use super::files::{print, refuse_overwriting, say};
use super::{job, system};

/// Renders a scene to a file.
pub(super) fn render(arguments: &RenderArguments) -> Result<(), CliError> {
    let settings = job::settings(arguments)?;
    refuse_overwriting(&arguments.output, &[&arguments.scene])?;
    crate::image::check_savable(&arguments.output)?;
    let world = scene::load_with(&arguments.scene, arguments.camera.as_deref())?;
    for warning in world.warnings() {
        say(format_args!("warning: {warning}"));
    }
    match settings.color {
        Color::Rgb => render_with::<3>(arguments, &settings, &world),
        Color::Mono { .. } => render_with::<1>(arguments, &settings, &world),
    }
}

fn render_with<const N: usize>(
    arguments: &RenderArguments,
    settings: &Settings,
    world: &World,
) -> Result<(), CliError> {
    let tables = scene::bake::<N>(world, settings.color)?;
    let size = job::film_size(arguments, &tables.shapes.camera)?;
    job::check_memory(settings, size, system::available_memory())?;
    if settings.integrator == Integrator::Light && !arguments.quiet && has_specular(&tables) {
        say(LIGHT_NOTE);
    }
    let scene = Scene::new(tables, size.0, size.1);
    let threads = Threads::start(arguments.threads)?;
    let progress = progress_bar(arguments, settings);
    let updates = Updates::new(arguments)?;
    let (start, cpu_start) = (Instant::now(), system::cpu_seconds());
    let outcome = threads.run(|| {
        render::render(&scene, settings, &|so_far| {
            progress.set_position(u64::from(so_far.iterations));
            updates.write(arguments, so_far);
        })
    });
    let seconds = start.elapsed().as_secs_f64();
    let cpu_seconds = system::cpu_seconds().zip(cpu_start).map(|(end, start)| end - start);
    progress.finish_and_clear();

    let times = Times { seconds, cpu_seconds, threads: threads.count() };
    let statistics = statistics(arguments, settings, size, &outcome, times);
    let mut image = outcome.film.develop();
    // It takes more memory than the image, whose file does too while it is written.
    drop(outcome.film);
    if !arguments.variance {
        image.variance = None;
    }
    image.metadata = metadata(arguments, settings, &statistics);
    crate::image::save(&image, &arguments.output)?;
    report(arguments, &statistics, &image)
}

/// Images on the way.
struct Updates {
    interval: Option<Duration>,
    last: Mutex<Instant>,
}

impl Updates {
    fn new(arguments: &RenderArguments) -> Result<Self, CliError> {
        let interval = job::seconds("--update", arguments.update)?;
        Ok(Self { interval, last: Mutex::new(Instant::now()) })
    }

    /// Writes the image if it is time. A render does not end for a failure to do so.
    fn write(&self, arguments: &RenderArguments, so_far: &Progress) {
        let Some(interval) = self.interval else { return };
        let mut last = self.last.lock().expect("no thread panics while it holds the lock");
        if last.elapsed() < interval {
            return;
        }
        let mut image = so_far.image();
        let iterations = so_far.iterations.to_string();
        image.metadata = vec![
            ("scene".to_owned(), arguments.scene.display().to_string()),
            ("iterations".to_owned(), iterations),
        ];
        if let Err(error) = crate::image::save(&image, &arguments.output) {
            say(format_args!("warning: no update was written: {error}"));
        }
        *last = Instant::now();
    }
}

/// Which images particle tracing can make.
const LIGHT_NOTE: &str = "\
note: the integrator `light` cannot see through glass and polarizers or into mirrors, so these \
      are black in its image; `bdpt`, `path` and `ppm` show them";

/// Whether there are surfaces that light paths cannot connect to the sensor from.
fn has_specular<const N: usize>(tables: &BakedScene<N>) -> bool {
    let kind = |material: u32| tables.optics.materials[material as usize].kind;
    tables.shapes.surfaces.iter().any(|surface| {
        let kind = kind(surface.material);
        !matches!(kind, MaterialKind::Absorber | MaterialKind::Diffuse | MaterialKind::Null)
    })
}

fn progress_bar(arguments: &RenderArguments, settings: &Settings) -> ProgressBar {
    if arguments.quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(u64::from(settings.iterations));
    let template = "{wide_bar} {pos}/{len} iterations, {per_sec}, {eta} left";
    bar.set_style(ProgressStyle::with_template(template).unwrap_or(ProgressStyle::default_bar()));
    bar
}

/// The name of an integrator.
pub(super) fn name_of(integrator: Integrator) -> &'static str {
    match integrator {
        Integrator::Path => "path",
        Integrator::Light => "light",
        Integrator::Bdpt => "bdpt",
        Integrator::Ppm => "ppm",
    }
}

/// The name of a mode.
pub(super) fn mode_of(mode: Mode) -> &'static str {
    match mode {
        Mode::Scalar => "scalar",
        Mode::Intensity => "intensity",
        Mode::Polarized => "polarized",
    }
}

/// What the channels stand for, in words.
pub(super) fn color_of(color: Color) -> String {
    match color {
        Color::Rgb => "RGB".into(),
        Color::Mono { wavelength_nm } => format!("{wavelength_nm} nm"),
    }
}

/// What a render took.
struct Times {
    seconds: f64,
    cpu_seconds: Option<f64>,
    threads: usize,
}

fn statistics(
    arguments: &RenderArguments,
    settings: &Settings,
    (width, height): (u32, u32),
    outcome: &Outcome,
    taken: Times,
) -> RenderStatistics {
    let times = outcome.profile.times.map(|time| time.as_secs_f64());
    let mut statistics = RenderStatistics {
        scene: arguments.scene.display().to_string(),
        integrator: name_of(settings.integrator).into(),
        mode: mode_of(settings.mode).into(),
        color: color_of(settings.color),
        width: width as usize,
        height: height as usize,
        iterations: u64::from(outcome.iterations),
        threads: taken.threads,
        seconds: taken.seconds,
        cpu_seconds: taken.cpu_seconds,
        samples_per_second: 0.0,
        rays_closest: outcome.profile.rays_closest,
        rays_visibility: outcome.profile.rays_visibility,
        stages: STAGES.map(String::from).into_iter().zip(times).collect(),
        peak_memory_bytes: peak_memory_bytes(),
    };
    statistics.count_samples();
    statistics
}

fn metadata(
    arguments: &RenderArguments,
    settings: &Settings,
    statistics: &RenderStatistics,
) -> Vec<(String, String)> {
    let words = std::env::args_os();
    let command: Vec<String> = words.map(|word| word.to_string_lossy().into_owned()).collect();
    let replicates = settings.replicates.to_string();
    [
        ("scene", statistics.scene.clone()),
        ("command", command.join(" ")),
        ("integrator", statistics.integrator.clone()),
        ("mode", statistics.mode.clone()),
        ("color", statistics.color.clone()),
        ("iterations", statistics.iterations.to_string()),
        ("replicates", replicates),
        ("max path length", arguments.max_path_length.to_string()),
        ("roulette after", arguments.roulette_after.to_string()),
        ("seed", settings.seed.to_string()),
        ("seconds", format!("{:.3}", statistics.seconds)),
        ("version", env!("CARGO_PKG_VERSION").into()),
    ]
    .map(|(key, value)| (key.to_owned(), value))
    .to_vec()
}

/// Says what was done: statistics on standard output if asked for, a line on standard error.
fn report(
    arguments: &RenderArguments,
    statistics: &RenderStatistics,
    image: &StokesImage,
) -> Result<(), CliError> {
    match arguments.stats {
        Some(StatsFormat::Json) => {
            let text = serde_json::to_string_pretty(statistics)
                .map_err(|error| CliError::System(format!("cannot write JSON: {error}")))?;
            print(text)?;
        }
        Some(StatsFormat::Text) => print(statistics)?,
        None => {}
    }
    if !arguments.quiet {
        say(format_args!(
            "{}: {} x {}, {} iterations of {} ({}) in {:.2} s",
            arguments.output.display(),
            image.width,
            image.height,
            statistics.iterations,
            statistics.integrator,
            statistics.mode,
            statistics.seconds
        ));
    }
    Ok(())
}
