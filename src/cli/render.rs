//! The verb `render`: load, check, render, write.

use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::image::StokesImage;
use crate::integrators::Integrator;
use crate::integrators::profile::STAGES;
use crate::render::statistics::{RenderStatistics, peak_memory_bytes};
use crate::render::threads::Threads;
use crate::render::{PlacedWorld, Progress, Renderer, Settings, system};
use crate::scene;

use super::CliError;
use super::args::{RenderArguments, StatsFormat};
use super::files::{print, refuse_overwriting, say};
use super::job;

/// Renders a scene to a file.
pub(super) fn render(arguments: &RenderArguments) -> Result<(), CliError> {
    let settings = job::settings(arguments)?;
    refuse_overwriting(&arguments.output, &[&arguments.scene])?;
    crate::image::check_savable(&arguments.output)?;
    let world = scene::load_with(&arguments.scene, arguments.camera.as_deref())?;
    for warning in world.warnings() {
        say(format_args!("warning: {warning}"));
    }
    let world = PlacedWorld::new(world)?;
    let threads = Arc::new(Threads::start(arguments.threads)?);
    let mut renderer = Renderer::new(&world, &settings)?.on(&threads);
    let is_blind = settings.integrator == Integrator::Light && renderer.has_specular_surfaces();
    if is_blind && !arguments.quiet {
        say(LIGHT_NOTE);
    }
    let progress = progress_bar(arguments, &settings);
    let mut updates = Updates::new(arguments)?;
    let (start, cpu_start) = (Instant::now(), system::cpu_seconds());
    renderer.run(|so_far| {
        progress.set_position(u64::from(so_far.samples));
        updates.write(arguments, so_far);
        ControlFlow::Continue(())
    });
    let seconds = start.elapsed().as_secs_f64();
    let cpu_seconds = system::cpu_seconds().zip(cpu_start).map(|(end, start)| end - start);
    progress.finish_and_clear();

    let times = Times { seconds, cpu_seconds, threads: threads.count() };
    let statistics = statistics(arguments, &renderer, times);
    let mut image = renderer.finish();
    if !arguments.variance {
        image.variance = None;
    }
    add_metadata(&mut image, &statistics);
    crate::image::save(&image, &arguments.output)?;
    report(arguments, &statistics, &image)
}

/// Images on the way.
struct Updates {
    interval: Option<Duration>,
    last: Instant,
}

impl Updates {
    fn new(arguments: &RenderArguments) -> Result<Self, CliError> {
        let interval = job::seconds("--update", arguments.update)?;
        Ok(Self { interval, last: Instant::now() })
    }

    /// Writes the image if it is time. A render does not end for a failure to do so.
    fn write(&mut self, arguments: &RenderArguments, so_far: &Progress) {
        let Some(interval) = self.interval else { return };
        if self.last.elapsed() < interval {
            return;
        }
        let mut image = so_far.preview();
        let iterations = so_far.samples.to_string();
        image.metadata = vec![
            ("scene".to_owned(), arguments.scene.display().to_string()),
            ("iterations".to_owned(), iterations),
        ];
        if let Err(error) = crate::image::save(&image, &arguments.output) {
            say(format_args!("warning: no update was written: {error}"));
        }
        self.last = Instant::now();
    }
}

/// Which images particle tracing can make.
const LIGHT_NOTE: &str = "\
note: the integrator `light` cannot see through glass and polarizers or into mirrors, so these \
      are black in its image; `bdpt`, `path` and `ppm` show them";

fn progress_bar(arguments: &RenderArguments, settings: &Settings) -> ProgressBar {
    if arguments.quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(u64::from(settings.samples));
    let template = "{wide_bar} {pos}/{len} iterations, {per_sec}, {eta} left";
    bar.set_style(ProgressStyle::with_template(template).unwrap_or(ProgressStyle::default_bar()));
    bar
}

/// What a render took.
struct Times {
    seconds: f64,
    cpu_seconds: Option<f64>,
    threads: usize,
}

fn statistics(arguments: &RenderArguments, renderer: &Renderer, taken: Times) -> RenderStatistics {
    let (settings, profile) = (renderer.settings(), renderer.profile());
    let times = profile.times.map(|time| time.as_secs_f64());
    let [width, height] = renderer.film_size();
    let mut statistics = RenderStatistics {
        scene: arguments.scene.display().to_string(),
        integrator: settings.integrator.name().into(),
        mode: settings.mode.name().into(),
        color: settings.color.to_string(),
        width: width as usize,
        height: height as usize,
        iterations: u64::from(renderer.samples()),
        threads: taken.threads,
        seconds: taken.seconds,
        cpu_seconds: taken.cpu_seconds,
        samples_per_second: 0.0,
        rays_closest: profile.rays_closest,
        rays_visibility: profile.rays_visibility,
        stages: STAGES.map(String::from).into_iter().zip(times).collect(),
        peak_memory_bytes: peak_memory_bytes(),
    };
    statistics.count_samples();
    statistics
}

/// Adds what the renderer does not know: where the scene came from, the command and the time.
fn add_metadata(image: &mut StokesImage, statistics: &RenderStatistics) {
    let words = std::env::args_os();
    let command: Vec<String> = words.map(|word| word.to_string_lossy().into_owned()).collect();
    let facts = [
        ("scene", statistics.scene.clone()),
        ("command", command.join(" ")),
        ("seconds", format!("{:.3}", statistics.seconds)),
    ];
    image.metadata.splice(0..0, facts.map(|(key, value)| (key.to_owned(), value)));
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
