//! The photons of an iteration: shot, stored and sorted.

use glam::Vec3;
use rayon::prelude::*;

use crate::integrators::photons;
use crate::integrators::ppm::walk_to_merging;
use crate::integrators::profile::{Profile, Stage};
use crate::math::elementary::pow;
use crate::math::hash::combine;
use crate::math::lanes;
use crate::scattering::Scene;
use crate::transport::chunk::{ROWS, Sequence, TILE, tiles};
use crate::transport::tables::nearest_photons::nearest_distances;
use crate::transport::tables::photon_maps::{PhotonMap, PhotonMaps, map_of};
use crate::transport::tables::photons::{PhotonClass, PhotonTable};
use crate::transport::{Chunk, LightModel};

use super::renderer::Limit;
use super::sets::Sets;
use super::tiles::Pool;
use super::{Passes, Resolved};

/// Light paths that are shot and stored together.
const BATCH: u32 = 16 * ROWS as u32;

/// Room for photons relative to what the first of them let expect.
const SPARE_ROOM: f64 = 1.02;
/// Batches that are shot before they are brought to the maps.
const BATCHES: u32 = 32;

/// Photons within the first radius (the paper, section 5).
const NEAREST: usize = 25;
/// Points of a map that the first radius is found at.
const PROBES: usize = 256;
/// Tiles of the film that they are taken from.
const PROBED_TILES: usize = 64;
/// Largest first radius in a medium, relative to its mean free path.
const PART_OF_FREE_PATH: f32 = 0.5;
/// Largest first radius on surfaces, in pixels: details as large as that are not blurred together.
const PIXELS: f32 = 8.0;
/// Pixels from where one is looked at to the nearest of such places, samples being strewn within
/// them.
const PIXELS_APART: f32 = 0.5;
/// Photons within a kernel below which paths go on instead.
const PHOTONS_MIN: f32 = 1.0;
/// Largest first radius, relative to what it would be if the photons of all light paths lay evenly
/// on the ball about the scene.
const RADIUS_OF_EVEN: f32 = 3.0;
/// First radius relative to that of the scene where there are too few photons to tell.
const RADIUS_OF_SCENE: f32 = 0.01;

/// The maps of all places, and the photons on their way there.
pub struct PhotonPass<const N: usize> {
    /// Where photons are merged.
    pub maps: PhotonMaps<N>,
    /// First radii.
    first_radii: Vec<f32>,
    /// Light paths of an iteration.
    light_paths: u32,
    /// Photons of one batch each, by map.
    batches: Vec<Vec<PhotonTable<N>>>,
    /// Whether the latest iteration has all of its light paths.
    is_complete: bool,
}

/// Which iteration is being shot.
#[derive(Clone, Copy)]
pub struct Shot {
    /// Index in the random sequences.
    pub iteration: u32,
    /// Seed of these.
    pub seed: u32,
    /// Iterations since the start of the render, this one excluded.
    pub earlier: u32,
}

impl<const N: usize> PhotonPass<N> {
    /// Empty maps for a scene; in `polarized` renders, photons at what polarizes have states.
    pub fn new(scene: &Scene<N>, passes: Passes, polarized: bool) -> Self {
        // In time: threads that merge could not find them together.
        scene.rims();
        let is_chromatic = scene.optics.states.is_chromatic
            || scene.events_present().any(|event| !event.achromatic);
        let class_of = |map: usize| {
            let mut events = scene.events_present().filter(|event| map_of(event.met) == map);
            if !(polarized && events.any(|event| event.keeps_polarized())) {
                PhotonClass::Power
            } else if is_chromatic {
                PhotonClass::SpectralStokes
            } else {
                PhotonClass::Stokes
            }
        };
        let classes: Vec<PhotonClass> = (0..1 + scene.optics.media.len()).map(class_of).collect();
        let mut maps = PhotonMaps::new(&classes);
        // Photons in them would hardly ever come along the right way.
        for (medium, map) in maps.0[1..].iter_mut().enumerate() {
            map.merges = !scene.medium(medium as u32).is_peaked || scene.hides_lamps();
        }
        let tables = || classes.iter().map(|&class| PhotonTable::of_class(class, 0)).collect();
        Self {
            maps,
            first_radii: Vec::new(),
            light_paths: passes.light_paths,
            batches: (0..passes.light_paths.div_ceil(BATCH).min(BATCHES))
                .map(|_| tables())
                .collect(),
            is_complete: true,
        }
    }

    /// Photons in all maps.
    pub fn stored(&self) -> u64 {
        self.maps.0.iter().map(|map| map.grid.photons().len as u64).sum()
    }

    /// Radii of the kernels, by map; none where paths go on instead.
    pub fn radii(&self) -> Vec<Option<f32>> {
        self.maps.0.iter().map(|map| map.merges.then_some(map.radius)).collect()
    }

    /// Whether the photons of the latest iteration are all that were asked for.
    pub fn is_complete(&self) -> bool {
        self.is_complete
    }

    /// Shoots the photons of an iteration and sorts them, but not beyond a limit: false if not all
    /// were shot then, unless some will do. What is learned from photons is learned from those of
    /// the first iteration, which are shot before if this is another.
    pub fn shoot<M: LightModel<N>>(
        &mut self,
        pool: &Pool<N, M>,
        (scene, sets): (&Scene<N>, &Sets<N>),
        settings: &Resolved,
        (shot, limit, some_will_do): (Shot, &Limit, bool),
        profile: &mut Profile,
    ) -> bool {
        if self.first_radii.is_empty() && shot.earlier > 0 {
            let first = Shot { iteration: 0, seed: combine(settings.seed, 0), earlier: 0 };
            let iterations = sets.iterations(first.iteration, 1, first.seed);
            let scene = &iterations[0].scene;
            if !self.shoot_one(pool, scene, settings, (first, limit, false), profile) {
                return false;
            }
        }
        self.shoot_one(pool, scene, settings, (shot, limit, some_will_do), profile)
    }

    fn shoot_one<M: LightModel<N>>(
        &mut self,
        pool: &Pool<N, M>,
        scene: &Scene<N>,
        settings: &Resolved,
        (shot, limit, some_will_do): (Shot, &Limit, bool),
        profile: &mut Profile,
    ) -> bool {
        if self.maps.0.iter().all(|map| !map.merges) {
            return true;
        }
        let asked_for = self.light_paths;
        let is_given_up = || !some_will_do && limit.is_stopped();
        self.maps.0.iter_mut().for_each(|map| map.grid.unsorted().clear());
        let mut light_paths = 0;
        while light_paths < asked_for && !(light_paths > 0 && limit.is_over()) {
            let start = light_paths;
            light_paths = asked_for.min(start + BATCHES * BATCH);
            self.batches.par_iter_mut().enumerate().for_each(|(index, batch)| {
                batch.iter_mut().for_each(PhotonTable::clear);
                let first = (start + index as u32 * BATCH).min(light_paths);
                for first in (first..light_paths.min(first + BATCH)).step_by(ROWS) {
                    if is_given_up() {
                        return;
                    }
                    let last = light_paths.min(first + ROWS as u32);
                    let chunk = chunk(settings, shot, first, last - first);
                    let maps = &self.maps;
                    pool.with(|workspace| photons::photons(batch, workspace, scene, &chunk, maps));
                }
            });
            if is_given_up() {
                return false;
            }
            profile.time_of_threads(Stage::Store, rayon::current_num_threads(), || {
                self.collect_batches(f64::from(asked_for) / f64::from(light_paths));
            });
        }
        if light_paths < asked_for && !some_will_do {
            return false;
        }
        self.is_complete = light_paths == asked_for;
        self.maps.0.iter_mut().for_each(|map| map.light_paths = light_paths as f32);
        if self.first_radii.is_empty() {
            self.first_radii = match settings.photons.radius {
                Some(radius) => vec![radius; self.maps.0.len()],
                None => self.find_radii(scene, self.probe(pool, scene, settings, shot)),
            };
        }
        let shrinking = shrinking(settings.photons.alpha, shot.earlier);
        profile.time_of_threads(Stage::Store, rayon::current_num_threads(), || {
            for (map, first) in self.maps.0.iter_mut().zip(&self.first_radii) {
                map.radius = first * pow(shrinking, 1.0 / f64::from(map.dimensions)) as f32;
                map.grid.sort(map.radius);
            }
        });
        profile.photons += self.stored();
        true
    }

    /// Brings the photons of the batches to their maps, where there will be so many times those
    /// that are there then. Room for them is made at once: what grows has room that is not needed.
    fn collect_batches(&mut self, share: f64) {
        for (index, map) in self.maps.0.iter_mut().enumerate() {
            let photons = map.grid.unsorted();
            let more: usize = self.batches.iter().map(|batch| batch[index].len).sum();
            let all = (photons.len + more) as f64 * share * SPARE_ROOM;
            photons.reserve((all as usize).saturating_sub(photons.len).max(more));
            for batch in &self.batches {
                photons.append_table(&batch[index]);
            }
        }
    }

    /// The radii to begin with: the median distance from points that the sensor sees to their 25th
    /// nearest photon, within the bounds of the place. Maps whose kernels would hold hardly any
    /// photons are given up.
    fn find_radii(&mut self, scene: &Scene<N>, probes: Vec<Vec<Probe>>) -> Vec<f32> {
        let fallback = RADIUS_OF_SCENE * scene.shapes.bounds.radius;
        // Where light hardly comes, the nearest photons are those of other places.
        let evenly = (4.0 * NEAREST as f32 / self.light_paths as f32).sqrt();
        let radius_max = RADIUS_OF_EVEN * evenly * scene.shapes.bounds.radius;
        let maps = self.maps.0.iter_mut().enumerate().zip(probes);
        let radius_of = |((index, map), mut probes): ((usize, &mut PhotonMap<N>), Vec<Probe>)| {
            sort(&mut probes);
            let step = probes.len().div_ceil(PROBES).max(1);
            let some: Vec<[f32; 3]> = probes.iter().step_by(step).map(|it| it.position).collect();
            let distances = nearest_distances(map.grid.photons(), &some, NEAREST);
            let found = median(distances).map(|distance| distance.min(radius_max));
            let largest = match index.checked_sub(1) {
                // Beyond, the light of different places is mixed up.
                Some(medium) => PART_OF_FREE_PATH / scene.medium(medium as u32).reduced,
                None => median(probes.iter().map(|it| it.apart).collect())
                    .map_or(f32::INFINITY, |apart| PIXELS / PIXELS_APART * apart),
            };
            let photons_of =
                |radius: f32| NEAREST as f32 * (largest / radius).powi(map.dimensions as i32);
            // Paths that go on find more, unless lamps are hidden from them.
            if found.map_or(0.0, photons_of) < PHOTONS_MIN && !scene.hides_lamps() {
                map.merges = false;
                map.grid.unsorted().clear();
            }
            found.unwrap_or(fallback.min(radius_max)).min(largest)
        };
        maps.map(radius_of).collect()
    }

    /// Vertices at which photons will be merged, by map, from tiles all over the film.
    fn probe<M: LightModel<N>>(
        &self,
        pool: &Pool<N, M>,
        scene: &Scene<N>,
        settings: &Resolved,
        shot: Shot,
    ) -> Vec<Vec<Probe>> {
        let tiles = tiles(scene.sensor.layout.sampled().film, TILE);
        let step = tiles.len().div_ceil(PROBED_TILES);
        let mut probes: Vec<Vec<Probe>> = vec![Vec::new(); self.maps.0.len()];
        for &[x, y, width, height] in tiles.iter().step_by(step) {
            let of_pixels = Chunk { sequence: Sequence::PerPath, ..chunk(settings, shot, 0, 0) };
            let chunk = Chunk { x, y, width, height, ..of_pixels };
            let mut points = vec![Vec::new(); probes.len()];
            pool.with(|workspace| {
                walk_to_merging(workspace, scene, &chunk, &self.maps, |w, _| {
                    for (event, rows) in w.walk.partition.connectable() {
                        let position = &w.walk.surfaces.position;
                        let of_rows = rows.map(|row| lanes::row_of(position, row));
                        points[map_of(event.met)].extend(of_rows);
                    }
                });
            });
            for (probes, points) in probes.iter_mut().zip(&points) {
                probes.extend((0..points.len()).map(|index| Probe::of(points, index)));
            }
        }
        probes
    }
}

/// A point that the first radius is found at.
#[derive(Clone, Copy)]
struct Probe {
    position: [f32; 3],
    /// Distance to the nearest other point of its tile.
    apart: f32,
}

impl Probe {
    /// One of the points of a tile.
    fn of(points: &[[f32; 3]], index: usize) -> Self {
        let position = points[index];
        let others = points.iter().enumerate().filter(|(other, _)| *other != index);
        let from = Vec3::from(position);
        let squares = others.map(|(_, &point)| from.distance_squared(point.into()));
        Self { position, apart: squares.fold(f32::INFINITY, f32::min).sqrt() }
    }
}

/// Brings them in one order: modes come to them in others.
fn sort(probes: &mut [Probe]) {
    probes.sort_by_key(|probe| probe.position.map(f32::to_bits));
}

/// The middle one of the lengths that are numbers and no zeros.
fn median(mut lengths: Vec<f32>) -> Option<f32> {
    lengths.retain(|length| length.is_finite() && *length > 0.0);
    lengths.sort_by(f32::total_cmp);
    lengths.get(lengths.len() / 2).copied()
}

/// What is left of the area or volume of the kernel after some iterations: Knaus and Zwicker's
/// equation 15, `(i + alpha) / (i + 1)` from each to the next.
fn shrinking(alpha: f32, earlier: u32) -> f64 {
    let step = |i: u32| (f64::from(i) + f64::from(alpha)) / (f64::from(i) + 1.0);
    (1..=earlier).map(step).product()
}

/// A row of light paths in place of a tile of pixels. They share one random sequence, so that
/// they are stratified among each other.
fn chunk(settings: &Resolved, shot: Shot, first_path: u32, paths: u32) -> Chunk {
    Chunk {
        x: first_path,
        y: 0,
        width: paths,
        height: 1,
        first_iteration: shot.iteration,
        iterations: 1,
        seed: shot.seed,
        path_length_max: settings.path_length_max,
        // From the first vertex on, so that photons have about equal powers.
        roulette_after: [1; 2],
        sampling: settings.sampling,
        sequence: Sequence::Shared,
        is_seen: true,
    }
}
