//! Floor 9: schedules over a film. This file runs integrators over its tiles, the one place where
//! scalar or polarized, and how many wavelengths, is chosen.

mod photon_pass;
pub mod session;
pub mod statistics;
pub mod threads;

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use crate::film::Film;
use crate::image::StokesImage;
use crate::integrators::profile::{Profile, Stage};
use crate::integrators::workspace::Workspace;
use crate::integrators::{bdpt, light, path, ppm};
use crate::math::hash::combine;
use crate::scattering::Scene;
use crate::spectrum::Color;
use crate::transport::chunk::{ITERATIONS, Sequence, tiles};
use crate::transport::tables::measured::Splats;
use crate::transport::tables::photon_maps::PhotonMaps;
use crate::transport::{Chunk, LightModel, Polarized, Scalar};

use session::Run;

/// Iterations between two looks at the clock.
const WAVE: u32 = 16;

/// How light is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Integrator {
    /// From the sensor, with next-event estimation.
    Path,
    /// From the emitters, connected to the sensor.
    Light,
    /// From both, with all connections.
    Bdpt,
    /// From both, merged: progressive photon mapping.
    Ppm,
}

/// How photons are shot and gathered; for [`Integrator::Ppm`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photons {
    /// Light paths an iteration of photons, at least one.
    pub per_iteration: u32,
    /// Samples per pixel for every iteration of photons, at least one.
    pub samples: u32,
    /// How much the kernel keeps of what an iteration could take: from 0 (exclusive) to 1, where
    /// it does not shrink at all.
    pub alpha: f32,
    /// First radius of the kernel in scene units, greater than zero; by default what holds 25
    /// photons.
    pub radius: Option<f32>,
}

impl Default for Photons {
    fn default() -> Self {
        Self { per_iteration: 1_000_000, samples: 1, alpha: 2.0 / 3.0, radius: None }
    }
}

/// What light is made of, and what the film measures of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Light without polarization, its intensity.
    Scalar,
    /// Polarized light, its intensity: S0 of [`Mode::Polarized`], for which sensor paths carry one
    /// row of their matrix instead of four.
    Intensity,
    /// Polarized light, its Stokes vector.
    Polarized,
}

impl Mode {
    /// Stokes components on the film.
    pub fn components(self) -> usize {
        match self {
            Self::Scalar | Self::Intensity => 1,
            Self::Polarized => 4,
        }
    }
}

/// What to render, validated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// How light is found.
    pub integrator: Integrator,
    /// Intensity or Stokes vectors.
    pub mode: Mode,
    /// What the channels stand for.
    pub color: Color,
    /// Samples per pixel, at least one; with photons, a multiple of the samples of an iteration.
    pub iterations: u32,
    /// Independent randomizations that the iterations are split into, from 1 to `iterations`;
    /// variances need two or more.
    pub replicates: u32,
    /// Most segments of a path, at least one.
    pub path_length_max: u32,
    /// Path length after which roulette may end a path.
    pub roulette_after: u32,
    /// Seed of all randomness.
    pub seed: u32,
    /// Photons, where they are used.
    pub photons: Photons,
    /// Stop after the first wave of iterations that ends later than this.
    pub time_limit: Option<Duration>,
}

/// What came out.
pub struct Outcome {
    /// The sums.
    pub film: Film,
    /// Where the time went, summed over threads.
    pub profile: Profile,
    /// Iterations done: fewer than asked for if time ran out.
    pub iterations: u32,
}

/// How far a render has come.
pub struct Progress<'a> {
    /// Samples per pixel so far.
    pub iterations: u32,
    film: &'a Film,
    /// Samples per pixel of the current replicate so far.
    of_replicate: u32,
}

impl Progress<'_> {
    /// The image so far, without variances.
    pub fn image(&self) -> StokesImage {
        self.film.preview(self.of_replicate)
    }
}

/// Renders. `progress` hears after every wave.
///
/// Within a thread pool of any size the result has the same bits, unless time runs out.
pub fn render<const N: usize>(
    scene: &Scene<N>,
    settings: &Settings,
    progress: &(dyn Fn(&Progress) + Sync),
) -> Outcome {
    match settings.mode {
        Mode::Scalar => render_as::<N, Scalar>(scene, settings, progress),
        Mode::Intensity | Mode::Polarized => render_as::<N, Polarized>(scene, settings, progress),
    }
}

fn render_as<const N: usize, M: LightModel<N>>(
    scene: &Scene<N>,
    settings: &Settings,
    progress: &(dyn Fn(&Progress) + Sync),
) -> Outcome {
    let start = Instant::now();
    let mut run = Run::<N, M>::new(scene, settings);
    let late = || settings.time_limit.is_some_and(|limit| start.elapsed() > limit);
    for replicate in 0..settings.replicates {
        let iterations = share(settings, replicate + 1) - share(settings, replicate);
        let seed = combine(settings.seed, replicate);
        let mut first = 0;
        while first < iterations && !(run.done > 0 && late()) {
            let count = run.wave_of().min(iterations - first);
            run.advance(first, count, seed);
            first += count;
            progress(&Progress { iterations: run.done, film: &run.film, of_replicate: first });
        }
        if first > 0 {
            run.film.finish_replicate(first);
        }
    }
    run.into_outcome()
}

/// Iterations of the first `replicates` replicates: whole numbers of photon passes, if any.
fn share(settings: &Settings, replicates: u32) -> u32 {
    let unit = if settings.integrator == Integrator::Ppm { settings.photons.samples } else { 1 };
    let units = u64::from(settings.iterations / unit) * u64::from(replicates);
    (units / u64::from(settings.replicates)) as u32 * unit
}

/// Workspaces at rest.
struct Pool<const N: usize, M: LightModel<N>> {
    resting: Mutex<Vec<Box<Workspace<N, M>>>>,
    components: usize,
    with_media: bool,
}

impl<const N: usize, M: LightModel<N>> Pool<N, M> {
    fn new(components: usize, with_media: bool) -> Self {
        Self { resting: Mutex::new(Vec::new()), components, with_media }
    }

    fn with<R>(&self, work: impl FnOnce(&mut Workspace<N, M>) -> R) -> R {
        let resting = self.resting.lock().expect("no thread panics while it holds the lock").pop();
        let create = || Box::new(Workspace::new(self.components, self.with_media));
        let mut workspace = resting.unwrap_or_else(create);
        let result = work(&mut workspace);
        self.resting.lock().expect("no thread panics while it holds the lock").push(workspace);
        result
    }

    /// Adds what the workspaces have counted so far; none may be in use.
    fn add_profiles(&self, profile: &mut Profile) {
        let resting = self.resting.lock().expect("no thread panics while it holds the lock");
        resting.iter().for_each(|workspace| profile.add(&workspace.profile));
    }
}

/// What one tile adds to the film.
struct TileResult<const N: usize> {
    /// Values per pixel, summed over the iterations of the wave.
    sums: Vec<f32>,
    splats: Splats<N>,
}

/// Renders `count` iterations from `first` on over all tiles and adds them to the film, tile by
/// tile in a fixed order.
fn wave<const N: usize, M: LightModel<N>>(
    film: &mut Film,
    profile: &mut Profile,
    pool: &Pool<N, M>,
    scene: &Scene<N>,
    settings: &Settings,
    (first, count, seed): (u32, u32, u32),
    maps: Option<&PhotonMaps<N>>,
) {
    let render = |[x, y, width, height]: [u32; 4]| {
        let chunk = |first_iteration: u32, iterations: u32| Chunk {
            x,
            y,
            width,
            height,
            first_iteration,
            iterations,
            seed,
            path_length_max: settings.path_length_max,
            roulette_after: settings.roulette_after,
            sequence: Sequence::PerPath,
        };
        pool.with(|workspace| tile(workspace, scene, settings, (first, count), maps, chunk))
    };
    let tiles = tiles(scene.sensor.width, scene.sensor.height);
    let next = AtomicUsize::new(0);
    let line = Mutex::new(Line { film, profile, added: 0, waiting: BTreeMap::new() });
    // Every thread takes the next tile when it is done with one, so that none waits for others
    // before the end, and few results for those before them.
    let work = || {
        while let Some((index, tile)) = take(&next, &tiles) {
            let result = render(tile);
            let mut line = line.lock().expect("no thread panics while it holds the lock");
            line.add(index, result, &tiles);
        }
    };
    rayon::scope(|scope| {
        (0..rayon::current_num_threads()).for_each(|_| scope.spawn(|_| work()));
    });
}

/// The next tile and its place among all.
fn take(next: &AtomicUsize, tiles: &[[u32; 4]]) -> Option<(usize, [u32; 4])> {
    let index = next.fetch_add(1, Ordering::Relaxed);
    tiles.get(index).map(|tile| (index, *tile))
}

/// Results on their way into the film, which takes them in the order of the tiles: sums have one.
struct Line<'a, const N: usize> {
    film: &'a mut Film,
    profile: &'a mut Profile,
    /// Tiles that are in the film.
    added: usize,
    /// Results of later tiles.
    waiting: BTreeMap<usize, TileResult<N>>,
}

impl<const N: usize> Line<'_, N> {
    fn add(&mut self, index: usize, result: TileResult<N>, tiles: &[[u32; 4]]) {
        let Self { film, profile, added, waiting } = self;
        waiting.insert(index, result);
        profile.time(Stage::Film, || {
            while let Some(result) = waiting.remove(added) {
                add_result(film, tiles[*added], &result);
                *added += 1;
            }
        });
    }
}

fn add_result<const N: usize>(film: &mut Film, tile: [u32; 4], result: &TileResult<N>) {
    add_sums(film, &result.sums, tile);
    for splat in &result.splats.unpolarized {
        film.add(splat.pixel as usize, &splat.value);
    }
    for splat in &result.splats.polarized {
        let values = &splat.stokes.as_flattened()[..film.values_per_pixel()];
        film.add(splat.pixel as usize, values);
    }
}

/// All chunks of one tile and wave.
fn tile<const N: usize, M: LightModel<N>>(
    workspace: &mut Workspace<N, M>,
    scene: &Scene<N>,
    settings: &Settings,
    (first, count): (u32, u32),
    maps: Option<&PhotonMaps<N>>,
    chunk: impl Fn(u32, u32) -> Chunk,
) -> TileResult<N> {
    let mut result = TileResult { sums: Vec::new(), splats: Splats::default() };
    for start in (first..first + count).step_by(ITERATIONS as usize) {
        let chunk = chunk(start, ITERATIONS.min(first + count - start));
        match settings.integrator {
            Integrator::Path => path::path(workspace, scene, &chunk),
            Integrator::Light => light::light(workspace, scene, &chunk),
            Integrator::Bdpt => bdpt::bdpt(workspace, scene, &chunk),
            Integrator::Ppm => {
                let maps = maps.expect("photons are shot before they are gathered");
                ppm::ppm(workspace, scene, &chunk, maps);
            }
        }
        if settings.integrator != Integrator::Light {
            sum_measured(&mut result.sums, workspace, &chunk);
        }
        if matches!(settings.integrator, Integrator::Light | Integrator::Bdpt) {
            result.splats.append(&mut workspace.splats);
        }
    }
    result
}

/// Adds the slots of a chunk to the values of its pixels.
fn sum_measured<const N: usize, M: LightModel<N>>(
    sums: &mut Vec<f32>,
    workspace: &mut Workspace<N, M>,
    chunk: &Chunk,
) {
    let Workspace { measured, profile, .. } = workspace;
    let stride = measured.components() * N;
    profile.time(Stage::Film, || {
        sums.resize(chunk.pixels() * stride, 0.0);
        let iterations = measured.values(chunk.slots()).chunks_exact(chunk.pixels() * stride);
        for values in iterations {
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += value;
            }
        }
    });
}

fn add_sums(film: &mut Film, sums: &[f32], [x, y, width, height]: [u32; 4]) {
    if sums.is_empty() {
        return;
    }
    let (stride, film_width) = (film.values_per_pixel(), film.width() as u32);
    for (line, values) in (y..y + height).zip(sums.chunks_exact(width as usize * stride)) {
        for (column, values) in (x..x + width).zip(values.chunks_exact(stride)) {
            film.add((line * film_width + column) as usize, values);
        }
    }
}
