//! `bench scaling`.

use std::hint::black_box;

use indicatif::ProgressBar;

use super::args::{ScalingArguments, SeriesName};
use super::measure::{Taken, machine, processors, progress_bar, timed};
use super::report::{check_outputs, deliver};
use super::subject::{Renderable, Subject, load, load_all};
use super::work;
use crate::bench::Machine;
use crate::bench::scaling::{Conditions, Sample, Scaling, Series, Time};
use crate::cli::args::ColorName;
use crate::cli::render::{color_of, mode_of, name_of};
use crate::cli::{CliError, job, system};
use crate::render::threads::Threads;
use crate::render::{Integrator, Photons, Settings};
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
    settings: Settings,
    film: (u32, u32),
    threads: usize,
}

/// Times over sizes.
pub fn scaling(arguments: &ScalingArguments) -> Result<(), CliError> {
    let base = base(arguments)?;
    let plans = plans(arguments, &base)?;
    let output = &arguments.output;
    check_outputs(&output.report, output.record.as_deref(), arguments.scene.as_slice())?;
    for point in plans.iter().flat_map(|(_, points)| points) {
        job::check_memory(&point.settings, point.film, system::available_memory())?;
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
    let conditions = conditions(arguments, &base.settings, subject.short_name(), machine);
    let report = Scaling { conditions, series };
    let machine = &report.conditions.machine;
    deliver(&report, output, ("scaling", machine))
}

/// What is measured where a series says nothing else.
fn base(arguments: &ScalingArguments) -> Result<Planned, CliError> {
    let ScalingArguments { work, series, integrator, rounds, .. } = arguments;
    let typed = [("--photons", work.photons.is_some())];
    work::check_photons(std::slice::from_ref(integrator), &typed)?;
    job::within("--rounds", *rounds, 1000, "")?;
    job::within("--spp", arguments.spp.unwrap_or(1), job::SPP_MAX, "")?;
    job::within("--points", arguments.points.unwrap_or(1), 1000, "")?;
    if (1..series.len()).any(|index| series[..index].contains(&series[index])) {
        return Err(CliError::Usage("--series names a series twice".into()));
    }
    let settings = work::settings(work, job::integrator(*integrator), 1)?;
    Ok(Planned {
        size: 1.0,
        settings: Settings { mode: job::mode(arguments.mode), ..settings },
        film: work::size(work, None)?,
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
    let &Planned { film, threads, settings, .. } = base;
    let samples = |default| arguments.spp.unwrap_or(default);
    let at = |size: f64, iterations| {
        let settings = Settings { iterations, ..settings };
        Planned { size, settings, film, threads }
    };
    Ok(match name {
        SeriesName::Threads => numbers_of_threads(threads)
            .map(|threads| Planned { threads, ..at(threads as f64, samples(16)) })
            .collect(),
        SeriesName::Samples => SAMPLES.map(|samples| at(f64::from(samples), samples)).into(),
        SeriesName::Photons => PHOTONS
            .map(|per_iteration| {
                let mut point = at(f64::from(per_iteration), samples(4));
                point.settings.integrator = Integrator::Ppm;
                point.settings.photons = Photons { per_iteration, ..settings.photons };
                let edge = |typed: Option<u32>| typed.unwrap_or(EDGE_OF_PHOTONS);
                point.film = (edge(arguments.work.width), edge(arguments.work.height));
                point
            })
            .into(),
        SeriesName::Pixels => EDGES
            .map(|edge| Planned { film: (edge, edge), ..at(f64::from(edge * edge), samples(4)) })
            .into(),
        SeriesName::Wavelengths => {
            let mono = job::color(ColorName::Mono, arguments.work.wavelength)?;
            [mono, Color::Rgb]
                .map(|color| {
                    let mut point = at(color.channels() as f64, samples(16));
                    point.settings.color = color;
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
    let bake = |point: &Planned| subject.bake(point.settings.color, point.film);
    let scenes: Vec<Box<dyn Renderable>> = points.iter().map(bake).collect::<Result<_, _>>()?;
    let threads: Vec<Threads> =
        points.iter().map(|point| Threads::start(Some(point.threads))).collect::<Result<_, _>>()?;
    let mut repeats = vec![1; points.len()];
    let mut taken: Vec<Vec<Taken>> = points.iter().map(|_| Vec::new()).collect();
    for round in 0..=rounds {
        let up = 0..points.len();
        let order: Vec<usize> = if round % 2 == 0 { up.collect() } else { up.rev().collect() };
        for point in order {
            let settings = &points[point].settings;
            let took = time(scenes[point].as_ref(), settings, &threads[point], repeats[point]);
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
fn time(scene: &dyn Renderable, settings: &Settings, threads: &Threads, repeats: u32) -> Taken {
    let render = || scene.render(settings).film.develop();
    let (_, taken) = timed(|| {
        threads.run(|| (0..repeats).for_each(|_| drop(black_box(render()))));
    });
    let mean = |seconds: f64| seconds / f64::from(repeats);
    Taken { seconds: mean(taken.seconds), cpu_seconds: taken.cpu_seconds.map(mean) }
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
    let Planned { settings, film: (width, height), threads, .. } = point;
    let mut words = vec![name_of(settings.integrator).to_owned()];
    if name != SeriesName::Wavelengths {
        words.push(color_of(settings.color));
    }
    if name != SeriesName::Pixels {
        words.push(format!("{width} x {height} pixels"));
    }
    if name != SeriesName::Samples {
        words.push(format!("{} samples a pixel", settings.iterations));
    }
    if settings.integrator == Integrator::Ppm && name != SeriesName::Photons {
        words.push(format!("{} light paths an iteration", settings.photons.per_iteration));
    }
    if name != SeriesName::Threads {
        words.push(format!("{threads} threads"));
    }
    words.join(", ")
}

fn conditions(
    arguments: &ScalingArguments,
    settings: &Settings,
    scene: String,
    machine: Machine,
) -> Conditions {
    Conditions {
        machine,
        scene,
        integrator: name_of(settings.integrator).into(),
        mode: mode_of(settings.mode).into(),
        color: color_of(settings.color),
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
