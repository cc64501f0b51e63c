//! A film in tiles, which threads take one by one.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::film::Film;
use crate::integrators::profile::{Profile, Stage};
use crate::integrators::workspace::Workspace;
use crate::math::exact::ExactSums;
use crate::scattering::Scene;
use crate::transport::chunk::{ITERATIONS, Sequence, tiles};
use crate::transport::tables::measured::Splats;
use crate::transport::tables::photon_maps::PhotonMaps;
use crate::transport::{Chunk, LightModel};

use super::Resolved;

/// Workspaces at rest.
pub struct Pool<const N: usize, M: LightModel<N>> {
    resting: Mutex<Vec<Box<Workspace<N, M>>>>,
    components: usize,
    with_media: bool,
}

impl<const N: usize, M: LightModel<N>> Pool<N, M> {
    /// None yet, for films of so many Stokes components, and scenes with or without media.
    pub fn new(components: usize, with_media: bool) -> Self {
        Self { resting: Mutex::new(Vec::new()), components, with_media }
    }

    /// Does `work` with one of them.
    pub fn with<R>(&self, work: impl FnOnce(&mut Workspace<N, M>) -> R) -> R {
        let resting = self.resting.lock().expect("no thread panics while it holds the lock").pop();
        let create = || Box::new(Workspace::new(self.components, self.with_media));
        let mut workspace = resting.unwrap_or_else(create);
        let result = work(&mut workspace);
        self.resting.lock().expect("no thread panics while it holds the lock").push(workspace);
        result
    }

    /// Adds what the workspaces have counted so far; none may be in use.
    pub fn add_profiles(&self, profile: &mut Profile) {
        let resting = self.resting.lock().expect("no thread panics while it holds the lock");
        resting.iter().for_each(|workspace| profile.add(&workspace.profile));
    }
}

/// What one tile adds to the film.
struct TileResult<const N: usize> {
    /// Values per pixel, summed over the iterations of the wave; none if none are measured.
    sums: ExactSums,
    splats: Splats<N>,
}

/// Renders `count` iterations from `first` on over all tiles and adds them to the film, tile by
/// tile in a fixed order; no tile is begun when it is not wanted any more.
pub fn wave<const N: usize, M: LightModel<N>>(
    (film, profile): (&mut Film, &mut Profile),
    pool: &Pool<N, M>,
    (scene, settings): (&Scene<N>, &Resolved),
    (first, count, seed): (u32, u32, u32),
    maps: Option<&PhotonMaps<N>>,
    is_wanted: &(impl Fn() -> bool + Sync),
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
            roulette_after: settings.roulette_of_sides(),
            sampling: settings.sampling,
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
        while let Some((index, tile)) = take(&next, &tiles).filter(|_| is_wanted()) {
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
        let not_finite = profile.time(Stage::Film, || {
            let mut not_finite = 0;
            while let Some(result) = waiting.remove(added) {
                not_finite += add_result(film, tiles[*added], &result);
                *added += 1;
            }
            not_finite
        });
        profile.not_finite += not_finite;
    }
}

/// Adds what a tile has brought; returns how many splats are left out as not finite.
fn add_result<const N: usize>(film: &mut Film, tile: [u32; 4], result: &TileResult<N>) -> u64 {
    add_sums(film, &result.sums, tile);
    let values_per_pixel = film.values_per_pixel();
    let mut not_finite = 0;
    let mut add = |pixel: u32, values: &[f32]| {
        if are_finite(values) {
            film.add(pixel as usize, values);
        } else {
            not_finite += 1;
        }
    };
    for splat in &result.splats.unpolarized {
        add(splat.pixel, &splat.value);
    }
    for splat in &result.splats.polarized {
        add(splat.pixel, &splat.stokes.as_flattened()[..values_per_pixel]);
    }
    not_finite
}

/// Whether all are finite; without a way out before the end, so that many are looked at at once.
fn are_finite(values: &[f32]) -> bool {
    values.iter().fold(true, |all, value| all & value.is_finite())
}

/// All chunks of one tile and wave.
fn tile<const N: usize, M: LightModel<N>>(
    workspace: &mut Workspace<N, M>,
    scene: &Scene<N>,
    settings: &Resolved,
    (first, count): (u32, u32),
    maps: Option<&PhotonMaps<N>>,
    chunk: impl Fn(u32, u32) -> Chunk,
) -> TileResult<N> {
    let mut result = TileResult { sums: ExactSums::default(), splats: Splats::default() };
    for start in (first..first + count).step_by(ITERATIONS as usize) {
        let chunk = chunk(start, ITERATIONS.min(first + count - start));
        let integrator = settings.integrator;
        integrator.chunk(workspace, scene, &chunk, maps);
        if integrator.measures() {
            sum_measured(&mut result.sums, workspace, &chunk);
        }
        if integrator.splats() {
            result.splats.append(&mut workspace.splats);
        }
    }
    result
}

/// Adds the slots of a chunk to the values of its pixels, but for those that are not finite, which
/// are counted.
fn sum_measured<const N: usize, M: LightModel<N>>(
    sums: &mut ExactSums,
    workspace: &mut Workspace<N, M>,
    chunk: &Chunk,
) {
    let Workspace { measured, profile, .. } = workspace;
    let stride = measured.components() * N;
    let not_finite = profile.time(Stage::Film, || {
        sums.resize(chunk.pixels() * stride);
        let mut not_finite = 0;
        for values in measured.values_mut(chunk.slots()).chunks_exact_mut(chunk.pixels() * stride) {
            if !are_finite(values) {
                for slot in values.chunks_exact_mut(stride).filter(|slot| !are_finite(slot)) {
                    slot.fill(0.0);
                    not_finite += 1;
                }
            }
            sums.add(0, values);
        }
        not_finite
    });
    profile.not_finite += not_finite;
}

fn add_sums(film: &mut Film, sums: &ExactSums, [x, y, width, height]: [u32; 4]) {
    if sums.is_empty() {
        return;
    }
    let (film_width, width) = (film.width(), width as usize);
    for line in 0..height as usize {
        let pixel = (y as usize + line) * film_width + x as usize;
        film.add_row(pixel, sums, line * width, width);
    }
}
