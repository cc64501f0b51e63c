//! The verb `render`: load, check, render, write.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::film::Developed;
use crate::image::StokesImage;
use crate::image::atomic::probe_writable;
use crate::image::format::extension;
use crate::image::png;
use crate::image::rows::Rows;
use crate::integrators::profile::STAGES;
use crate::math::text::counted;
use crate::render::doubts::doubts;
use crate::render::statistics::{RenderStatistics, SAMPLES, peak_memory_bytes};
use crate::render::threads::Threads;
use crate::render::{PartError, PlacedWorld, Progress as SoFar, Renderer, system};
use crate::scene;

use super::CliError;
use super::args::{RenderArguments, StatsFormat};
use super::checkpoint::{Checkpoints, say_how_to_go_on};
use super::files::{json, print, refuse_overwriting, say};
use super::interrupt::{Interrupt, Signal};
use super::progress::Progress;
use super::tev::{Tev, Viewer};
use super::{job, rescue, view};

/// Renders a scene to a file.
pub(super) fn render(arguments: &RenderArguments) -> Result<(), CliError> {
    // What is wrong on the command line is told before the scene is read.
    job::settings(arguments)?;
    let outputs = outputs_of(arguments)?;
    for output in &outputs {
        refuse_overwriting(output, &[&arguments.scene])?;
        probe_writable(output)?;
    }
    let checkpoints = Checkpoints::new(arguments)?;
    let updates = Updates::new(arguments)?;
    let tev = arguments.tev.as_deref().map(Tev::connect).transpose()?;
    let threads = Arc::new(Threads::start(arguments.threads)?);
    let world = threads.run(|| placed_world(arguments, &outputs))?;
    let (arguments, asked) = job::with_asked(arguments, world.asked());
    let (arguments, settings) = (&arguments, job::settings(&arguments)?);
    if let Some(asked) = asked.filter(|_| !arguments.quiet) {
        say(format_args!("note: as the scene asks: {asked}"));
    }
    let mut renderer = threads.run(|| Renderer::new(&world, &settings))?.on(&threads);
    checkpoints.resume(&mut renderer)?;
    let foreseen = world.foreseen(&settings)?;
    if !arguments.quiet {
        foreseen.notes.iter().for_each(|note| say(format_args!("note: {note}")));
    }
    foreseen.lacks.iter().for_each(|lack| say(format_args!("warning: {lack}")));
    let show = |tev: Tev| tev.show(&arguments.output, &renderer.rows(), updates.interval);
    let viewer = tev.map(show).transpose()?;
    let mut followers = Followers { checkpoints, updates, viewer, threads };
    let (start, cpu_start) = (Instant::now(), system::cpu_seconds());
    let signal = run(arguments, &mut renderer, &mut followers, start)?;
    let seconds = start.elapsed().as_secs_f64();
    let cpu_seconds = system::cpu_seconds().zip(cpu_start).map(|(end, start)| end - start);

    let Followers { mut checkpoints, viewer, threads, .. } = followers;
    let times = Times { seconds, cpu_seconds, threads: threads.count() };
    let statistics = statistics(arguments, &renderer, times);
    let interrupted = signal.filter(|_| !renderer.is_done());
    if interrupted.is_some() {
        checkpoints.write_last(&mut renderer, &arguments.output);
    }
    match arguments.part {
        Some(_) => {
            if interrupted.is_none() {
                save_part(&mut renderer, &arguments.output)?;
            }
            show_last(viewer, &renderer.rows(), &threads);
        }
        None => {
            let image = finish(arguments, renderer, (&world, &threads), (interrupted, seconds))?;
            show_last(viewer, &image, &threads);
        }
    }
    report(arguments, &statistics)?;
    match interrupted {
        Some(signal) => {
            checkpoints.say();
            Err(interrupted_after(signal, statistics.iterations as u32, arguments))
        }
        None => {
            checkpoints.remove();
            Ok(())
        }
    }
}

/// What follows a render on its way.
struct Followers {
    checkpoints: Checkpoints,
    updates: Updates,
    viewer: Option<Viewer>,
    threads: Arc<Threads>,
}

impl Followers {
    fn hear(&mut self, arguments: &RenderArguments, so_far: &SoFar) {
        if so_far.samples < so_far.total {
            self.checkpoints.write(so_far);
        }
        self.updates.write(arguments, so_far, &self.threads);
        if let Some(viewer) = &mut self.viewer {
            viewer.update(&so_far.rows(), &self.threads);
        }
    }
}

fn show_last(viewer: Option<Viewer>, image: &dyn Rows, threads: &Threads) {
    if let Some(viewer) = viewer {
        viewer.finish(image, threads);
    }
}

/// The files that will be written.
fn outputs_of(arguments: &RenderArguments) -> Result<Vec<PathBuf>, CliError> {
    match arguments.part {
        Some(_) => Ok(vec![arguments.output.clone()]),
        None => Ok(crate::image::files_of(&arguments.output)?),
    }
}

/// Renders until it is done or a signal comes, which is returned.
fn run(
    arguments: &RenderArguments,
    renderer: &mut Renderer,
    followers: &mut Followers,
    start: Instant,
) -> Result<Option<Signal>, CliError> {
    let progress = progress_of(arguments, renderer);
    let at_once = Unfinished::new(arguments);
    let interrupt = Interrupt::listen(renderer.stop_handle(), move |image, samples, signal| {
        let error = at_once.write(image, samples, signal, start.elapsed());
        error.say();
        error.exit_code()
    })?;
    renderer.run(|so_far| {
        progress.set(so_far.samples.into());
        interrupt.keep(so_far, &followers.threads);
        followers.hear(arguments, so_far);
        match interrupt.signal() {
            Some(_) => ControlFlow::Break(()),
            None => ControlFlow::Continue(()),
        }
    });
    if renderer.samples() == 0 {
        // The signal was there first.
        renderer.step();
    }
    interrupt.end();
    progress.finish();
    Ok(interrupt.signal())
}

/// Writes a part that is done.
fn save_part(renderer: &mut Renderer, path: &Path) -> Result<(), CliError> {
    let mut other = None;
    let write = |path: &Path| match renderer.save(path) {
        Err(PartError::File(error)) => Err(error),
        Err(error) => {
            other = Some(error);
            Ok(())
        }
        Ok(()) => Ok(()),
    };
    rescue::save_by(write, path)?;
    other.map_or(Ok(()), |error| Err(error.into()))
}

/// Writes the image, says what may be wrong with it and returns it.
fn finish(
    arguments: &RenderArguments,
    renderer: Renderer,
    (world, threads): (&PlacedWorld, &Threads),
    (interrupted, seconds): (Option<Signal>, f64),
) -> Result<Developed<'static>, CliError> {
    let settings = renderer.settings().clone();
    let doubts = doubts(&renderer, world);
    let mut image = renderer.finish_rows();
    if !arguments.variance {
        image.drop_variance();
    }
    add_metadata(&mut image.metadata, &arguments.scene, seconds, interrupted);
    threads.run(|| rescue::save(&image, &arguments.output))?;
    if let Some(stops) = exposure(&image, &arguments.output).filter(|_| !arguments.quiet) {
        let verb = if stops > 0.0 { "brightened" } else { "darkened" };
        let stops = stops.abs();
        say(format_args!("note: {} is {verb} by {stops} stops", arguments.output.display()));
    }
    if arguments.variance && !image.frame().has_variance {
        say(why_no_variances(settings.replicates));
    }
    if !arguments.quiet {
        doubts.note().iter().for_each(|note| say(format_args!("note: {note}")));
    }
    doubts.about(&image).iter().for_each(|doubt| say(format_args!("warning: {doubt}")));
    Ok(image)
}

/// The stops by which a preview is not as bright as the image.
fn exposure(image: &dyn Rows, output: &Path) -> Option<f32> {
    let is_preview = extension(output) == "png";
    is_preview.then(|| png::exposure(&image.whole())).filter(|stops| *stops != 0.0)
}

/// What keeps a render from variances, and how to have them.
fn why_no_variances(replicates: u32) -> &'static str {
    match replicates {
        2.. => {
            "warning: no variances are stored: replicates come one after the other, and the first \
             had not ended; leave out --replicates, or set --spp to what there is time for"
        }
        _ => {
            "warning: no variances are stored: the render ended before there was anything to \
             compare; give it more time"
        }
    }
}

/// The world of the scene, of which there are warnings to be said, in its place; none of these
/// outputs is among its files.
fn placed_world(arguments: &RenderArguments, outputs: &[PathBuf]) -> Result<PlacedWorld, CliError> {
    let reading = arguments.files.reading(view::view(arguments)?);
    let world = scene::load_with(&arguments.scene, &reading)?;
    outputs.iter().try_for_each(|output| refuse_overwriting(output, world.files()))?;
    let said = world.warnings().len();
    let warn = |warning: &str| say(format_args!("warning: {warning}"));
    world.warnings().iter().for_each(|warning| warn(warning));
    let world = PlacedWorld::new(world)?;
    world.warnings().skip(said).for_each(warn);
    Ok(world)
}

/// What is needed to write the image of a render that is not waited for.
struct Unfinished {
    scene: PathBuf,
    output: PathBuf,
    checkpoint: Option<PathBuf>,
    is_part: bool,
}

impl Unfinished {
    fn new(arguments: &RenderArguments) -> Self {
        let RenderArguments { scene, output, part, .. } = arguments;
        let checkpoint = arguments.checkpoints.checkpoint.clone();
        let (scene, output) = (scene.clone(), output.clone());
        Self { scene, output, checkpoint, is_part: part.is_some() }
    }

    /// Writes it, if it is one; what there is to say and to end with.
    fn write(
        &self,
        mut image: StokesImage,
        samples: u32,
        signal: Signal,
        time: Duration,
    ) -> CliError {
        let interrupted = CliError::Interrupted {
            signal,
            samples,
            output: self.output.clone(),
            is_part: self.is_part,
        };
        say_how_to_go_on(self.checkpoint.as_deref());
        if self.is_part {
            return interrupted;
        }
        add_metadata(&mut image.metadata, &self.scene, time.as_secs_f64(), Some(signal));
        match rescue::save(&image, &self.output) {
            Ok(()) => interrupted,
            Err(error) => error,
        }
    }
}

fn interrupted_after(signal: Signal, samples: u32, arguments: &RenderArguments) -> CliError {
    let (output, is_part) = (arguments.output.clone(), arguments.part.is_some());
    CliError::Interrupted { signal, samples, output, is_part }
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
    fn write(&mut self, arguments: &RenderArguments, so_far: &SoFar, threads: &Threads) {
        // A part is no image before it is merged.
        let Some(interval) = self.interval.filter(|_| arguments.part.is_none()) else { return };
        if self.last.elapsed() < interval {
            return;
        }
        let mut image = so_far.rows();
        image.metadata.insert(0, ("scene".to_owned(), arguments.scene.display().to_string()));
        if let Err(error) = threads.run(|| crate::image::save(&image, &arguments.output)) {
            say(format_args!("warning: no update was written: {error}"));
        }
        self.last = Instant::now();
    }
}

fn progress_of(arguments: &RenderArguments, renderer: &Renderer) -> Progress {
    let template = "{wide_bar} {pos}/{len} samples a pixel, {per_sec}, {eta} left";
    match arguments.quiet {
        true => Progress::none(),
        false => Progress::of(renderer.total().into(), SAMPLES[1], template),
    }
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
        radii: renderer.radii(),
        stages: STAGES.map(String::from).into_iter().zip(times).collect(),
        peak_memory_bytes: peak_memory_bytes(),
    };
    statistics.count_samples();
    statistics
}

/// Adds what the renderer does not know: where the scene came from, the command, the time, and
/// whether a signal ended it.
fn add_metadata(
    to: &mut Vec<(String, String)>,
    scene: &Path,
    seconds: f64,
    signal: Option<Signal>,
) {
    let facts = [
        ("scene", scene.display().to_string()),
        ("command", command()),
        ("seconds", format!("{seconds:.3}")),
    ];
    let interrupted = signal.map(|signal| ("interrupted", signal.name().to_owned()));
    let facts = facts.into_iter().chain(interrupted);
    to.splice(0..0, facts.map(|(key, value)| (key.to_owned(), value)));
}

/// The command line as a shell takes it.
pub(super) fn command() -> String {
    let words = std::env::args_os().map(|word| word.to_string_lossy().into_owned());
    let quoted = |word: String| match shlex::try_quote(&word) {
        Ok(quoted) => quoted.into_owned(),
        // It holds a zero byte, which no system passes on.
        Err(_) => word,
    };
    words.map(quoted).collect::<Vec<_>>().join(" ")
}

/// Says what was done: statistics on standard output if asked for, a line on standard error.
fn report(arguments: &RenderArguments, statistics: &RenderStatistics) -> Result<(), CliError> {
    match arguments.stats {
        Some(StatsFormat::Json) => {
            print(json(statistics)?)?;
        }
        Some(StatsFormat::Text) => print(statistics)?,
        None => {}
    }
    if !arguments.quiet {
        say(format_args!(
            "{}: {} x {}, {} of {} ({}) in {:.2} s",
            arguments.output.display(),
            statistics.width,
            statistics.height,
            counted(statistics.iterations as usize, SAMPLES),
            statistics.integrator,
            statistics.mode,
            statistics.seconds
        ));
    }
    Ok(())
}
