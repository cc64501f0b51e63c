//! `bench scaling`.

use std::hint::black_box;
use std::ops::ControlFlow;

use indicatif::ProgressBar;

use super::args::{ScalingArguments, SeriesName};
use super::measure::{Taken, machine, processors, progress_bar, timed};
use super::report::{check_outputs, deliver};
use super::subject::{Subject, load, load_all};
use super::work;
use crate::bench::Machine;
use crate::bench::scaling::{Conditions, Sample, Scaling, Series, Time};
use crate::cli::args::ColorName;
use crate::cli::{CliError, job};
use crate::integrators::Integrator;
use crate::render::memory::check_memory;
use crate::render::settings::SAMPLES_MAX;
use crate::render::threads::Threads;
use crate::render::{Options, Photons, PlacedWorld, RenderError, Renderer, Settings};
use crate::spectrum::Color;

/// Samples per pixel that are rendered one after another.
const SAMPLES: [u32; 6] = [1, 2, 4, 8, 16, 32];
/// Light paths an iteration.
const PHOTONS: [u32; 7] = [10_000, 30_000, 100_000, 300_000, 1_000_000, 2_000_000, 4_000_000];
/// Edges of films in pixels.
const EDGES: [u32; 5] = [64, 128, 256, 512, 1024];
/// Edge of the film on which photons are merged: small, for their time to be that of photons.
const EDGE_OF_PHOTONS: u32 = 16;
/// What renders are repeated to in a round, in seconds of all cores together.
const SECONDS_MIN: f64 = 0.1;
/// Most repetitions in a round.
const REPEATS_MAX: f64 = 1000.0;

/// A size of the work that is to be measured.
struct Planned {
    size: f64,
    options: Options,
    threads: usize,
}

/// Times over sizes.
pub fn scaling(arguments: &ScalingArguments) -> Result<(), CliError> {
    let base = base(arguments)?;
    let plans = plans(arguments, &base)?;
    let output = &arguments.output;
    check_outputs(&output.report, output.record.as_deref(), arguments.scene.as_slice())?;
    for point in plans.iter().flat_map(|(_, points)| points) {
        check_memory(&point.options, film_of(&point.options))?;
    }
    let subject = match &arguments.scene {
        Some(path) => load(path)?,
        None => load_all(&[])?.swap_remove(0),
    };
    let points: u64 = plans.iter().map(|(_, points)| points.len() as u64).sum();
    let progress = progress_bar(points * (u64::from(arguments.rounds) + 1));
    let series = |(name, points): &(SeriesName, Vec<Planned>)| {
        progress.set_message(name_of_series(*name));
        let samples = measure(&subject, points, arguments.rounds, &progress)?;
        Ok(Series::new(name_of_series(*name), in_words(*name, &points[0]), samples))
    };
    let series = plans.iter().map(series).collect::<Result<_, CliError>>()?;
    progress.finish_and_clear();
    let machine = machine(&Threads::start(arguments.work.threads)?);
    let conditions = conditions(arguments, &base.options, subject.short_name(), machine);
    let report = Scaling { conditions, series };
    let machine = &report.conditions.machine;
    deliver(&report, output, ("scaling", machine))
}

/// What is measured where a series says nothing else.
fn base(arguments: &ScalingArguments) -> Result<Planned, CliError> {
    let ScalingArguments { work, series, integrator, rounds, .. } = arguments;
    let typed = [("--photons", work.photons.is_some())];
    work::refuse_photons(std::slice::from_ref(integrator), &typed)?;
    job::within("--rounds", *rounds, 1000, "")?;
    job::within("--spp", arguments.spp.unwrap_or(1), SAMPLES_MAX, "")?;
    job::within("--points", arguments.points.unwrap_or(1), 1000, "")?;
    if (1..series.len()).any(|index| series[..index].contains(&series[index])) {
        return Err(CliError::Usage("--series names a series twice".into()));
    }
    let options = work::options(work, integrator.0, 1, work::size(work, None)?)?;
    Ok(Planned {
        size: 1.0,
        options: Options { mode: arguments.mode.0, ..options },
        threads: work.threads.or_else(processors).unwrap_or(1),
    })
}

/// The points of all series.
fn plans(
    arguments: &ScalingArguments,
    base: &Planned,
) -> Result<Vec<(SeriesName, Vec<Planned>)>, CliError> {
    let most = arguments.points.map_or(usize::MAX, |points| points as usize);
    let plan = |&name| {
        let mut points = points(name, arguments, base)?;
        points.truncate(most);
        Ok((name, points))
    };
    arguments.series.iter().map(plan).collect()
}

fn points(
    name: SeriesName,
    arguments: &ScalingArguments,
    base: &Planned,
) -> Result<Vec<Planned>, CliError> {
    let &Planned { threads, options, .. } = base;
    let samples = |default| arguments.spp.unwrap_or(default);
    let at = |size: f64, samples| {
        let options = Options { samples, ..options };
        Planned { size, options, threads }
    };
    Ok(match name {
        SeriesName::Threads => numbers_of_threads(threads)
            .map(|threads| Planned { threads, ..at(threads as f64, samples(16)) })
            .collect(),
        SeriesName::Samples => SAMPLES.map(|samples| at(f64::from(samples), samples)).into(),
        SeriesName::Photons => PHOTONS
            .map(|per_iteration| {
                let mut point = at(f64::from(per_iteration), samples(4));
                point.options.integrator = Integrator::Ppm;
                point.options.photons = Photons { per_iteration, ..options.photons };
                let edge = |typed: Option<u32>| Some(typed.unwrap_or(EDGE_OF_PHOTONS));
                point.options.width = edge(arguments.work.width);
                point.options.height = edge(arguments.work.height);
                point
            })
            .into(),
        SeriesName::Pixels => EDGES
            .map(|edge| {
                let mut point = at(f64::from(edge * edge), samples(4));
                (point.options.width, point.options.height) = (Some(edge), Some(edge));
                point
            })
            .into(),
        SeriesName::Wavelengths => {
            let mono = job::color(ColorName::Mono, arguments.work.wavelength)?;
            [mono, Color::Rgb]
                .map(|color| {
                    let mut point = at(color.channels() as f64, samples(16));
                    point.options.color = color;
                    point
                })
                .into()
        }
    })
}

/// 1, 2, 3, 4, 6, 8, 12, ... and the most.
fn numbers_of_threads(most: usize) -> impl Iterator<Item = usize> {
    let is_round = |number: usize| {
        let odd = number >> number.trailing_zeros();
        odd == 1 || odd == 3
    };
    (1..=most).filter(move |&number| is_round(number) || number == most)
}

fn measure(
    subject: &Subject,
    points: &[Planned],
    rounds: u32,
    progress: &ProgressBar,
) -> Result<Vec<Sample>, CliError> {
    let settings: Vec<Settings> =
        points.iter().map(|point| Settings::new(point.options)).collect::<Result<_, _>>()?;
    let threads: Vec<Threads> =
        points.iter().map(|point| Threads::start(Some(point.threads))).collect::<Result<_, _>>()?;
    let mut repeats = vec![1; points.len()];
    let mut taken: Vec<Vec<Taken>> = points.iter().map(|_| Vec::new()).collect();
    for round in 0..=rounds {
        let up = 0..points.len();
        let order: Vec<usize> = if round % 2 == 0 { up.collect() } else { up.rev().collect() };
        for point in order {
            let (world, settings) = (&subject.world, &settings[point]);
            let took = time(world, settings, &threads[point], repeats[point])?;
            if round == 0 {
                repeats[point] = repeats_of(took);
            } else {
                taken[point].push(took);
            }
            progress.inc(1);
        }
    }
    let samples = points.iter().zip(repeats).zip(&taken);
    Ok(samples.map(|((point, repeats), taken)| sample(point.size, repeats, taken)).collect())
}

/// A render, with all that it does once the scene is baked: the mean over some repetitions.
fn time(
    world: &PlacedWorld,
    settings: &Settings,
    threads: &Threads,
    repeats: u32,
) -> Result<Taken, CliError> {
    // What the first render bakes, the others find.
    Renderer::new(world, settings)?;
    let render = || -> Result<(), RenderError> {
        let mut renderer = Renderer::new(world, settings)?;
        renderer.run(|_| ControlFlow::Continue(()));
        black_box(renderer.finish());
        Ok(())
    };
    let (rendered, taken) = timed(|| threads.run(|| (0..repeats).try_for_each(|_| render())));
    rendered?;
    let mean = |seconds: f64| seconds / f64::from(repeats);
    Ok(Taken { seconds: mean(taken.seconds), cpu_seconds: taken.cpu_seconds.map(mean) })
}

/// The film of a point, whose size is known.
fn film_of(options: &Options) -> [u32; 2] {
    [options.width, options.height].map(|edge| edge.unwrap_or(1))
}

/// How often a render that took this is repeated in a round.
fn repeats_of(taken: Taken) -> u32 {
    let seconds = taken.cpu_seconds.unwrap_or(taken.seconds);
    (SECONDS_MIN / seconds).ceil().clamp(1.0, REPEATS_MAX) as u32
}

fn sample(size: f64, repeats: u32, taken: &[Taken]) -> Sample {
    let wall: Vec<f64> = taken.iter().map(|taken| taken.seconds).collect();
    let cpu: Option<Vec<f64>> = taken.iter().map(|taken| taken.cpu_seconds).collect();
    Sample { size, repeats, cpu: cpu.map(|cpu| Time::new(&cpu)), wall: Time::new(&wall) }
}

fn name_of_series(name: SeriesName) -> &'static str {
    match name {
        SeriesName::Threads => "threads",
        SeriesName::Samples => "samples",
        SeriesName::Photons => "photons",
        SeriesName::Pixels => "pixels",
        SeriesName::Wavelengths => "wavelengths",
    }
}

/// What stays as it is in a series, of which this is the first point.
fn in_words(name: SeriesName, point: &Planned) -> String {
    let Planned { options, threads, .. } = point;
    let [width, height] = film_of(options);
    let mut words = vec![options.integrator.name().to_owned()];
    if name != SeriesName::Wavelengths {
        words.push(options.color.to_string());
    }
    if name != SeriesName::Pixels {
        words.push(format!("{width} x {height} pixels"));
    }
    if name != SeriesName::Samples {
        words.push(format!("{} samples a pixel", options.samples));
    }
    if options.integrator.shoots_photons() && name != SeriesName::Photons {
        words.push(format!("{} light paths an iteration", options.photons.per_iteration));
    }
    if name != SeriesName::Threads {
        words.push(format!("{threads} threads"));
    }
    words.join(", ")
}

fn conditions(
    arguments: &ScalingArguments,
    settings: &Options,
    scene: String,
    machine: Machine,
) -> Conditions {
    Conditions {
        machine,
        scene,
        integrator: settings.integrator.name().into(),
        mode: settings.mode.name().into(),
        color: settings.color.to_string(),
        rounds: arguments.rounds,
        path_length_max: settings.path_length_max,
        roulette_after: settings.roulette_after,
        seed: settings.seed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_grow_to_the_most() {
        let numbers = |most| numbers_of_threads(most).collect::<Vec<usize>>();
        assert_eq!(numbers(1), [1]);
        assert_eq!(numbers(5), [1, 2, 3, 4, 5]);
        assert_eq!(numbers(28), [1, 2, 3, 4, 6, 8, 12, 16, 24, 28]);
    }

    #[test]
    fn short_renders_are_repeated() {
        let of = |seconds, cpu_seconds| repeats_of(Taken { seconds, cpu_seconds });
        assert_eq!(of(9.0, Some(0.03)), 4);
        assert_eq!((of(0.03, None), of(1.0, Some(2.0))), (4, 1));
        assert_eq!(of(0.0, Some(0.0)), 1000);
    }
}
