//! Time over sizes of the work.

use std::hint::black_box;
use std::ops::ControlFlow;

use super::clock::{Taken, machine, timed};
use super::wavelengths::{Carried, carried};
use super::{MeasureError, Subject, Watch, color_in_words};
use crate::bench::scaling::{Conditions, Sample, Scaling, Series, Time};
use crate::integrators::Integrator;
use crate::render::threads::Threads;
use crate::render::{Options, Photons, PlacedWorld, RenderError, Renderer, Settings};

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

/// What can grow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeriesKind {
    /// Threads, from 1 to all processors.
    Threads,
    /// Samples per pixel.
    Samples,
    /// Light paths an iteration, with ppm.
    Photons,
    /// Pixels of the film.
    Pixels,
    /// Wavelengths that light is carried at.
    Wavelengths,
}

impl SeriesKind {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Threads, Self::Samples, Self::Photons, Self::Pixels, Self::Wavelengths];

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Threads => "threads",
            Self::Samples => "samples",
            Self::Photons => "photons",
            Self::Pixels => "pixels",
            Self::Wavelengths => "wavelengths",
        }
    }
}

/// What is measured where a series says nothing else.
pub struct Base {
    /// Of every render; the size of the film is known.
    pub options: Options,
    /// Threads of every render.
    pub threads: usize,
    /// Samples per pixel of every render; each series has its own, else.
    pub samples: Option<u32>,
    /// The film on which photons are merged: small, else, for their time to be that of photons.
    pub film: [Option<u32>; 2],
    /// Most points of a series, the smallest first.
    pub points_max: usize,
    /// Rounds that are measured.
    pub rounds: u32,
}

/// A series that is to be measured.
pub struct Plan {
    kind: SeriesKind,
    /// Its sizes of the work.
    pub points: Vec<Point>,
}

/// A size of the work that is to be measured.
pub struct Point {
    size: f64,
    /// Of the render.
    pub options: Options,
    threads: usize,
}

impl Plan {
    /// The points of a series.
    pub fn of(kind: SeriesKind, base: &Base) -> Self {
        let mut points = points(kind, base);
        points.truncate(base.points_max);
        Self { kind, points }
    }
}

/// Measures series; the report's machine has the threads of the `base`.
pub fn scaling(
    subject: &Subject,
    plans: &[Plan],
    base: &Base,
    watch: &impl Watch,
) -> Result<Scaling, MeasureError> {
    let series = |Plan { kind, points }: &Plan| {
        watch.at(kind.name());
        let samples = measure(subject, points, base.rounds, watch)?;
        Ok(Series::new(kind.name(), in_words(*kind, &points[0]), samples))
    };
    let series = plans.iter().map(series).collect::<Result<_, MeasureError>>()?;
    let options = &base.options;
    let conditions = Conditions {
        machine: machine(&Threads::start(Some(base.threads))?),
        scene: subject.label.clone(),
        integrator: options.integrator_name().into(),
        mode: options.mode.name().into(),
        color: color_in_words(options),
        rounds: base.rounds,
        path_length_max: options.path_length_max,
        roulette_after: options.roulette_after,
        seed: options.seed,
    };
    Ok(Scaling { conditions, series })
}

fn points(name: SeriesKind, base: &Base) -> Vec<Point> {
    let Base { threads, options, samples, film, .. } = base;
    let threads = *threads;
    let samples = |default| samples.unwrap_or(default);
    let at = |size: f64, samples| {
        let options = Options { samples, ..options.clone() };
        Point { size, options, threads }
    };
    match name {
        SeriesKind::Threads => numbers_of_threads(threads)
            .map(|threads| Point { threads, ..at(threads as f64, samples(16)) })
            .collect(),
        SeriesKind::Samples => SAMPLES.map(|samples| at(f64::from(samples), samples)).into(),
        SeriesKind::Photons => PHOTONS
            .map(|per_iteration| {
                let mut point = at(f64::from(per_iteration), samples(4));
                point.options.integrator = Some(Integrator::Ppm);
                let per_iteration = Some(per_iteration);
                point.options.photons = Photons { per_iteration, ..options.photons };
                let edge = |typed: Option<u32>| Some(typed.unwrap_or(EDGE_OF_PHOTONS));
                point.options.width = edge(film[0]);
                point.options.height = edge(film[1]);
                point
            })
            .into(),
        SeriesKind::Pixels => EDGES
            .map(|edge| {
                let mut point = at(f64::from(edge * edge), samples(4));
                (point.options.width, point.options.height) = (Some(edge), Some(edge));
                point
            })
            .into(),
        SeriesKind::Wavelengths => carried(options)
            .into_iter()
            .map(|Carried { wavelengths, options, .. }| {
                let options = Options { samples: samples(16), ..options };
                Point { size: wavelengths as f64, options, threads }
            })
            .collect(),
    }
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
    points: &[Point],
    rounds: u32,
    watch: &impl Watch,
) -> Result<Vec<Sample>, MeasureError> {
    let settings: Vec<Settings> = points
        .iter()
        .map(|point| Settings::new(point.options.clone()))
        .collect::<Result<_, _>>()?;
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
            watch.round();
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
) -> Result<Taken, MeasureError> {
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
pub fn film_of(options: &Options) -> [u32; 2] {
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

/// What stays as it is in a series, of which this is the first point.
fn in_words(name: SeriesKind, point: &Point) -> String {
    let Point { options, threads, .. } = point;
    let [width, height] = film_of(options);
    let mut words = vec![options.integrator_name().to_owned()];
    if name != SeriesKind::Wavelengths {
        words.push(color_in_words(options));
    }
    if name != SeriesKind::Pixels {
        words.push(format!("{width} x {height} pixels"));
    }
    if name != SeriesKind::Samples {
        words.push(format!("{} samples a pixel", options.samples));
    }
    if options.shoots_photons() && name != SeriesKind::Photons {
        let light_paths = options.photons.light_paths([width, height]);
        words.push(format!("{light_paths} light paths an iteration"));
    }
    if name != SeriesKind::Threads {
        words.push(format!("{threads} threads"));
    }
    words.join(", ")
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
