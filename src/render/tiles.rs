//! A film in tiles, which threads take one by one.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use wide::f32x4;

use crate::film::Film;
use crate::film::layout::Layout;
use crate::image::cut::Cut;
use crate::integrators::profile::{Profile, Stage};
use crate::integrators::workspace::Workspace;
use crate::math::exact::ExactSums;
use crate::spectrum::Taken;
use crate::transport::chunk::{ITERATIONS, Sequence, TILE, WIDE_TILE, aligned_tiles};
use crate::transport::stages::weigh_samples::weigh_samples;
use crate::transport::tables::measured::{PolarizedSplat, Splat, Splats};
use crate::transport::tables::photon_maps::PhotonMaps;
use crate::transport::{Chunk, LightModel};

use super::Resolved;
use super::sets::{Iteration, Projection};
use super::shared::{Blocks, share_measured};
use super::sums::{are_finite, sum_measured};

/// Workspaces at rest.
pub struct Pool<const N: usize, M: LightModel<N>> {
    resting: Mutex<Vec<Box<Workspace<N, M>>>>,
    components: usize,
    with: (bool, bool),
    is_timed: bool,
}

impl<const N: usize, M: LightModel<N>> Pool<N, M> {
    /// None yet, for films of so many Stokes components, and paths with or without media and
    /// partial weights, whose stages are timed or not.
    pub fn new(components: usize, with: (bool, bool), is_timed: bool) -> Self {
        Self { resting: Mutex::new(Vec::new()), components, with, is_timed }
    }

    /// Does `work` with one of them.
    pub fn with<R>(&self, work: impl FnOnce(&mut Workspace<N, M>) -> R) -> R {
        let resting = self.resting.lock().expect("no thread panics while it holds the lock").pop();
        let create = || Box::new(Workspace::new(self.components, self.with, self.is_timed));
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
    /// Values per pixel, summed over the samples of the wave; none if none are measured.
    sums: ExactSums,
    /// For every iteration in turn, if there are any.
    splats: Vec<Splats<N>>,
}

/// What a wave renders: iterations, and how many samples each has.
type Lit<'a, const N: usize> = (&'a [Iteration<N>], u32);

/// Renders `count` samples from `first` on over all tiles and adds them to the film, tile by tile
/// in a fixed order; no tile is begun when it is not wanted any more.
pub fn wave<const N: usize, M: LightModel<N>>(
    (film, profile): (&mut Film, &mut Profile),
    pool: &Pool<N, M>,
    (lit, settings): (Lit<N>, &Resolved),
    (first, count, seed): (u32, u32, u32),
    maps: Option<&PhotonMaps<N>>,
    is_wanted: &(impl Fn() -> bool + Sync),
) {
    let (iterations, samples_of_each) = lit;
    let render = |Tile { area: [x, y, width, height], is_seen }: Tile| {
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
            is_seen,
        };
        pool.with(|workspace| tile(workspace, lit, settings, (first, count), maps, chunk))
    };
    let sensor = &iterations[0].scene.sensor;
    let sampled = sensor.layout.sampled();
    let tiles = tiles_of(sampled, settings.integrator.splats(), samples_of_each);
    let next = AtomicUsize::new(0);
    let waiting = BTreeMap::new();
    let layout = sensor.layout;
    let line =
        Mutex::new(Line { film: &mut *film, profile, iterations, layout, added: 0, waiting });
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
    add_to_gauge(film, lit, count);
}

/// Adds what the wavelengths of some iterations would have measured of a spectrum that is known,
/// for all of the `count` samples.
fn add_to_gauge<const N: usize>(film: &mut Film, (iterations, of_each): Lit<N>, count: u32) {
    let starts = (0..count).step_by(of_each as usize);
    for (iteration, start) in iterations.iter().zip(starts) {
        match &iteration.film {
            Projection::Columns => {}
            Projection::Shares(shares) => {
                let samples = of_each.min(count - start) as f32;
                let values: Vec<f32> = shares.met.iter().map(|met| met * samples).collect();
                film.add_to_gauge(&values);
            }
        }
    }
}

/// A tile of a film.
#[derive(Clone, Copy)]
struct Tile {
    /// Left, top, width, height in pixels of the whole film.
    area: [u32; 4],
    /// Whether its pixels are rendered, or paths from emitters alone are traced there.
    is_seen: bool,
}

/// The tiles of the rendered part of a film, and, if paths from emitters reach the film, those of
/// the rest of it: such a path of any pixel may reach any other, and a part is to have the bits
/// that it has in the whole. Wide ones where a chunk has a single sample, unless these are so few
/// that threads would wait for each other. No bit hangs on that.
fn tiles_of(cut: Cut, has_splats: bool, samples_of_each: u32) -> Vec<Tile> {
    const TILES_OF_THREAD: usize = 2;
    let areas = [(cut.start, cut.size, true)];
    let around = if has_splats { around(cut) } else { [(cut.start, [0; 2], false); 4] };
    let tiles_of = |edge: u32| -> Vec<Tile> {
        let of_area = |(start, size, is_seen): ([u32; 2], [u32; 2], bool)| {
            let areas = aligned_tiles((start, size), edge).into_iter();
            areas.map(move |area| Tile { area, is_seen })
        };
        areas.into_iter().chain(around).flat_map(of_area).collect()
    };
    let wide = tiles_of(WIDE_TILE);
    let are_few = wide.len() < TILES_OF_THREAD * rayon::current_num_threads();
    if samples_of_each > 1 || are_few { tiles_of(TILE) } else { wide }
}

/// What of a film is above, below, left and right of a cut: its start and size, and that it is not
/// seen.
fn around(cut: Cut) -> [([u32; 2], [u32; 2], bool); 4] {
    let Cut { film: [width, height], start: [x, y], size: [across, down] } = cut;
    let [right, bottom] = [x + across, y + down];
    [
        ([0, 0], [width, y], false),
        ([0, bottom], [width, height - bottom], false),
        ([0, y], [x, down], false),
        ([right, y], [width - right, down], false),
    ]
}

/// The next tile and its place among all.
fn take(next: &AtomicUsize, tiles: &[Tile]) -> Option<(usize, Tile)> {
    let index = next.fetch_add(1, Ordering::Relaxed);
    tiles.get(index).map(|tile| (index, *tile))
}

/// Results on their way into the film, which takes them in the order of the tiles: sums have one.
struct Line<'a, const N: usize> {
    film: &'a mut Film,
    profile: &'a mut Profile,
    iterations: &'a [Iteration<N>],
    layout: Layout,
    /// Tiles that are in the film.
    added: usize,
    /// Results of later tiles.
    waiting: BTreeMap<usize, TileResult<N>>,
}

impl<const N: usize> Line<'_, N> {
    fn add(&mut self, index: usize, result: TileResult<N>, tiles: &[Tile]) {
        let Self { film, profile, iterations, layout, added, waiting } = self;
        waiting.insert(index, result);
        let not_finite = profile.time(Stage::Film, || {
            let mut not_finite = 0;
            while let Some(result) = waiting.remove(added) {
                add_sums(film, &result.sums, tiles[*added].area, layout);
                for (iteration, splats) in iterations.iter().zip(&result.splats) {
                    not_finite += add_splats(film, &iteration.film, splats);
                }
                *added += 1;
            }
            not_finite
        });
        profile.not_finite += not_finite;
    }
}

/// Adds what light paths of one iteration have brought; returns how many splats are left out as
/// not finite.
fn add_splats<const N: usize>(
    film: &mut Film,
    projection: &Projection<N>,
    splats: &Splats<N>,
) -> u64 {
    let mut not_finite = 0;
    for Splat { pixel, value } in &splats.unpolarized {
        if are_finite(value) {
            add_intensity(film, projection, *pixel, value);
        } else {
            not_finite += 1;
        }
    }
    let has_stokes = film.components() > 1;
    for PolarizedSplat { pixel, stokes } in &splats.polarized {
        if !are_finite(stokes.as_flattened()) {
            not_finite += 1;
        } else if has_stokes {
            add_stokes(film, projection, *pixel, stokes);
        } else {
            add_intensity(film, projection, *pixel, &stokes.map(|[s0, ..]| s0));
        }
    }
    not_finite
}

fn add_intensity<const N: usize>(
    film: &mut Film,
    projection: &Projection<N>,
    pixel: u32,
    value: &[f32; N],
) {
    let mut add = |channel: usize, value: f32| film.add(pixel as usize, channel, &[value]);
    match projection {
        Projection::Columns => value.iter().enumerate().for_each(|(n, value)| add(n, *value)),
        Projection::Shares(shares) => {
            shares.taken.iter().for_each(|taken| add(taken.channel, taken.of(value)));
        }
    }
}

fn add_stokes<const N: usize>(
    film: &mut Film,
    projection: &Projection<N>,
    pixel: u32,
    stokes: &[[f32; 4]; N],
) {
    let mut add = |channel: usize, stokes: &[f32; 4]| film.add(pixel as usize, channel, stokes);
    match projection {
        Projection::Columns => stokes.iter().enumerate().for_each(|(n, stokes)| add(n, stokes)),
        Projection::Shares(shares) => {
            let states = stokes.map(f32x4::new);
            let of = |taken: &Taken<N>| taken.of_each(&states).to_array();
            shares.taken.iter().for_each(|taken| add(taken.channel, &of(taken)));
        }
    }
}

/// All chunks of one tile and wave.
fn tile<const N: usize, M: LightModel<N>>(
    workspace: &mut Workspace<N, M>,
    (iterations, samples_of_each): Lit<N>,
    settings: &Resolved,
    (first, count): (u32, u32),
    maps: Option<&PhotonMaps<N>>,
    chunk: impl Fn(u32, u32) -> Chunk,
) -> TileResult<N> {
    let mut result = TileResult { sums: ExactSums::default(), splats: Vec::new() };
    let integrator = settings.integrator;
    let mut blocks = Blocks::default();
    let starts = (first..first + count).step_by(samples_of_each as usize);
    for (iteration, start) in iterations.iter().zip(starts) {
        let end = (start + samples_of_each).min(first + count);
        let mut splats = Splats::default();
        for start in (start..end).step_by(ITERATIONS as usize) {
            let chunk = chunk(start, ITERATIONS.min(end - start));
            integrator.chunk(workspace, &iteration.scene, &chunk, maps);
            if integrator.measures() && chunk.is_seen {
                let Workspace { measured, profile, .. } = &mut *workspace;
                let slots = (chunk.slots(), chunk.pixels());
                profile.not_finite += profile.time(Stage::Film, || {
                    let (sums, sensor) = (&mut result.sums, &iteration.scene.sensor);
                    let (to, from) = ((&mut *sums, &mut blocks), (&chunk, sensor));
                    let shared = share_measured(to, measured, &iteration.film, from);
                    shared.unwrap_or_else(|| {
                        weigh_samples(measured, &chunk, sensor);
                        sum_measured(sums, measured, &iteration.film, slots)
                    })
                });
            }
            if integrator.splats() {
                splats.append(&mut workspace.splats);
            }
        }
        if integrator.splats() {
            result.splats.push(splats);
        }
    }
    result
}

/// Adds the sums of a tile, and of the pixels about it that its samples reach.
fn add_sums(film: &mut Film, sums: &ExactSums, [x, y, width, height]: [u32; 4], layout: &Layout) {
    if sums.is_empty() {
        return;
    }
    let (cut, beyond) = (layout.cut, 2 * layout.reach());
    // Where the sums begin and end among the pixels that are rendered, with what is beyond these.
    let [of_columns, of_rows] = [(0, x, width), (1, y, height)].map(|(axis, at, length)| {
        let first = i64::from(at) - i64::from(beyond) - i64::from(cut.start[axis]);
        let end = first + i64::from(length + beyond);
        (first, first.max(0) as usize, end.clamp(0, i64::from(cut.size[axis])) as usize)
    });
    let (left, from, to) = of_columns;
    let (top, above, below) = of_rows;
    if from >= to {
        return;
    }
    for row in above..below {
        let [skipped, line] = [from as i64 - left, row as i64 - top].map(|it| it as usize);
        let first = line * (width + beyond) as usize + skipped;
        film.add_row(row * film.width() + from, sums, first, to - from);
    }
}
