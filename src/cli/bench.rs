//! The verb `bench`: measurements of this program on this machine.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};

use crate::integrators::session::Session;
use crate::integrators::threads::Threads;
use crate::integrators::{Mode, Settings};
use crate::output::atomic;
use crate::output::table1::{Conditions, Measured, PAPER, PaperRow, Round, SceneReport, Table1};
use crate::scattering::Scene;
use crate::scene;

use super::CliError;
use super::args::{Bench, BenchArguments, StatsFormat, Table1Arguments};
use super::files::{print, refuse_overwriting, say};
use super::{job, system};

/// Measures what is asked for.
pub(super) fn bench(arguments: &BenchArguments) -> Result<(), CliError> {
    match &arguments.what {
        Bench::Table1(arguments) => table1(arguments),
    }
}

/// A scene of the paper's table that the program carries with it.
struct Shipped {
    file: &'static str,
    bytes: &'static [u8],
    paper: &'static PaperRow,
}

const SHIPPED: [Shipped; 2] = [
    Shipped {
        file: "scenes/mirror.gltf",
        bytes: include_bytes!("../../scenes/mirror.gltf"),
        paper: &PAPER.rows[0],
    },
    Shipped {
        file: "scenes/tank.gltf",
        bytes: include_bytes!("../../scenes/tank.gltf"),
        paper: &PAPER.rows[1],
    },
];

/// A scene that is ready to be measured.
struct Subject {
    name: String,
    paper: Option<&'static PaperRow>,
    scene: Scene<3>,
}

/// The paper's Table 1.
fn table1(arguments: &Table1Arguments) -> Result<(), CliError> {
    let polarized = job::table1_settings(arguments)?;
    let scalar = Settings { mode: Mode::Scalar, ..polarized };
    if let Some(path) = &arguments.json {
        let inputs: Vec<&Path> = arguments.scenes.iter().map(PathBuf::as_path).collect();
        refuse_overwriting(path, &inputs)?;
        atomic::probe_writable(path)?;
    }
    let size = (arguments.width, arguments.height);
    job::check_memory(&polarized, size, system::available_memory())?;
    let subjects = subjects(arguments, &polarized)?;
    let threads = Threads::start(arguments.threads)?;
    let progress = progress_bar(subjects.len(), arguments.iterations);
    let measured = subjects.iter().map(|subject| {
        progress.set_message(subject.name.clone());
        let rounds =
            measure(&subject.scene, [&scalar, &polarized], arguments.iterations, &threads, || {
                progress.inc(1);
            });
        SceneReport::new(subject.name.clone(), subject.paper, rounds)
    });
    let scenes: Vec<SceneReport> = measured.collect();
    progress.finish_and_clear();
    let report = Table1::new(conditions(arguments, &polarized, threads.count()), scenes);
    let json = serde_json::to_string_pretty(&report)
        .map_err(|error| CliError::System(format!("cannot write JSON: {error}")))?;
    match arguments.format {
        StatsFormat::Text => print(&report)?,
        StatsFormat::Json => print(&json)?,
    }
    match &arguments.json {
        Some(path) => Ok(atomic::write(path, (json + "\n").as_bytes())?),
        None => Ok(()),
    }
}

/// Loads all scenes, before the first is measured.
fn subjects(arguments: &Table1Arguments, settings: &Settings) -> Result<Vec<Subject>, CliError> {
    let subject = |name: String, paper, world: &scene::World| -> Result<Subject, CliError> {
        for warning in world.warnings() {
            say(format_args!("warning: {name}: {warning}"));
        }
        let tables = scene::bake::<3>(world, settings.color)?;
        let scene = Scene::new(tables, arguments.width, arguments.height);
        Ok(Subject { name, paper, scene })
    };
    if arguments.scenes.is_empty() {
        let shipped = SHIPPED.iter().map(|Shipped { file, bytes, paper }| {
            let world = scene::load_from_memory(Path::new(file), bytes)?;
            subject(world.name().to_owned(), Some(*paper), &world)
        });
        return shipped.collect();
    }
    let named = arguments.scenes.iter().map(|path| {
        let world = scene::load(path)?;
        // A copy of a shipped scene is that scene.
        let bytes = std::fs::read(path).unwrap_or_default();
        let shipped = SHIPPED.iter().find(|shipped| shipped.bytes == bytes);
        subject(path.display().to_string(), shipped.map(|shipped| shipped.paper), &world)
    });
    named.collect()
}

fn progress_bar(scenes: usize, iterations: u32) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(scenes as u64 * (u64::from(iterations) + 1));
    let template = "{msg} {wide_bar} {pos}/{len} rounds, {eta} left";
    bar.set_style(ProgressStyle::with_template(template).unwrap_or(ProgressStyle::default_bar()));
    bar
}

fn conditions(arguments: &Table1Arguments, settings: &Settings, threads: usize) -> Conditions {
    Conditions {
        version: env!("CARGO_PKG_VERSION").into(),
        processor: system::processor_model(),
        processors: std::thread::available_parallelism().map_or(threads, usize::from),
        threads,
        integrator: "ppm".into(),
        color: "RGB".into(),
        width: arguments.width,
        height: arguments.height,
        iterations: arguments.iterations,
        photons_shot: settings.photons.per_iteration,
        samples_per_iteration: settings.photons.samples,
        alpha: settings.photons.alpha,
        path_length_max: settings.path_length_max,
        roulette_after: settings.roulette_after,
        seed: settings.seed,
    }
}

/// Renders in both modes (scalar first in `settings`), an iteration of one and an iteration of
/// the other; every other round begins with the other mode. The first round warms up: it fills
/// tables that grow, and finds the radius of the kernels.
fn measure(
    scene: &Scene<3>,
    settings: [&Settings; 2],
    iterations: u32,
    threads: &Threads,
    progress: impl Fn(),
) -> Vec<Round> {
    let mut sessions = settings.map(|settings| Session::new(scene, settings));
    let mut rounds = Vec::with_capacity(iterations as usize);
    for round in 0..=iterations {
        let first = (round % 2) as usize;
        let mut measured = [Measured::default(), Measured::default()];
        for mode in [first, 1 - first] {
            measured[mode] = step(&mut sessions[mode], threads);
        }
        if round > 0 {
            let [scalar, polarized] = measured;
            rounds.push(Round { polarized_first: first == 1, scalar, polarized });
        }
        progress();
    }
    rounds
}

/// One iteration and what it took.
fn step(session: &mut Session<3>, threads: &Threads) -> Measured {
    let before = session.profile();
    let (start, cpu_start) = (Instant::now(), system::cpu_seconds());
    threads.run(|| session.step());
    let seconds = start.elapsed().as_secs_f64();
    let cpu_seconds = system::cpu_seconds().zip(cpu_start).map(|(end, start)| end - start);
    Measured::new(seconds, cpu_seconds, [&before, &session.profile()], session.radii())
}
