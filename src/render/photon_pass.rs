//! The photons of an iteration: shot, stored and sorted.

use rayon::prelude::*;

use crate::integrators::photons;
use crate::integrators::ppm::walk_to_merging;
use crate::integrators::profile::{Profile, Stage};
use crate::scattering::Scene;
use crate::transport::chunk::{ROWS, Sequence, tiles};
use crate::transport::tables::nearest_photons::nearest_distances;
use crate::transport::tables::photon_maps::{PhotonMaps, map_of};
use crate::transport::tables::photons::{PhotonClass, PhotonTable};
use crate::transport::{Chunk, LightModel};

use super::renderer::Limit;
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
/// Photons within the kernel of a medium below which paths go on instead.
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
        let is_chromatic = scene.events_present().any(|event| !event.achromatic);
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
        }
    }

    /// Photons in all maps.
    pub fn stored(&self) -> u64 {
        self.maps.0.iter().map(|map| map.grid.photons().len as u64).sum()
    }

    /// Radii of the kernels, by map.
    pub fn radii(&self) -> Vec<f32> {
        self.maps.0.iter().map(|map| map.radius).collect()
    }

    /// Shoots the photons of an iteration and sorts them, but not beyond a limit: false if not all
    /// were shot then, unless some will do.
    pub fn shoot<M: LightModel<N>>(
        &mut self,
        pool: &Pool<N, M>,
        scene: &Scene<N>,
        settings: &Resolved,
        (shot, limit, some_will_do): (Shot, &Limit, bool),
        profile: &mut Profile,
    ) -> bool {
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
        self.maps.0.iter_mut().for_each(|map| map.light_paths = light_paths as f32);
        if self.first_radii.is_empty() {
            self.first_radii = self.find_radii(pool, scene, settings, shot);
            self.give_up_sparse_maps(scene, settings);
        }
        let shrinking = shrinking(settings.photons.alpha, shot.earlier);
        profile.time_of_threads(Stage::Store, rayon::current_num_threads(), || {
            for (map, first) in self.maps.0.iter_mut().zip(&self.first_radii) {
                map.radius = first * shrinking.powf(1.0 / f64::from(map.dimensions)) as f32;
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

    /// The radii to begin with: what is asked for, or the median distance from points that the
    /// sensor sees to their 25th nearest photon.
    fn find_radii<M: LightModel<N>>(
        &self,
        pool: &Pool<N, M>,
        scene: &Scene<N>,
        settings: &Resolved,
        shot: Shot,
    ) -> Vec<f32> {
        if let Some(radius) = settings.photons.radius {
            return vec![radius; self.maps.0.len()];
        }
        let fallback = RADIUS_OF_SCENE * scene.shapes.bounds.radius;
        // Where light hardly comes, the nearest photons are those of other places.
        let evenly = (4.0 * NEAREST as f32 / self.light_paths as f32).sqrt();
        let radius_max = RADIUS_OF_EVEN * evenly * scene.shapes.bounds.radius;
        let points = self.probe(pool, scene, settings, shot);
        self.maps
            .0
            .iter()
            .zip(points)
            .map(|(map, mut points)| {
                // Modes come to them in other orders.
                points.sort_by_key(|point| point.map(f32::to_bits));
                let step = points.len().div_ceil(PROBES).max(1);
                let some: Vec<[f32; 3]> = points.into_iter().step_by(step).collect();
                let mut distances = nearest_distances(map.grid.photons(), &some, NEAREST);
                distances.retain(|distance| distance.is_finite() && *distance > 0.0);
                distances.sort_by(f32::total_cmp);
                let median = distances.get(distances.len() / 2).copied();
                median.unwrap_or(fallback).min(radius_max)
            })
            .collect()
    }

    /// Bounds the kernels in media by their mean free paths, beyond which the light of different
    /// places is mixed up. Where such kernels hold hardly any photons, paths that go on find more,
    /// unless lamps are hidden from them.
    fn give_up_sparse_maps(&mut self, scene: &Scene<N>, settings: &Resolved) {
        if settings.photons.radius.is_some() {
            return;
        }
        let media = self.maps.0[1..].iter_mut().zip(&mut self.first_radii[1..]).zip(0..);
        for ((map, radius), medium) in media {
            let radius_max = PART_OF_FREE_PATH / scene.medium(medium).reduced;
            let photons = NEAREST as f32 * (radius_max / *radius).powi(3);
            if photons < PHOTONS_MIN && !scene.hides_lamps() {
                map.merges = false;
                map.grid.unsorted().clear();
            }
            *radius = radius.min(radius_max);
        }
    }

    /// Vertices at which photons will be merged, by map, from tiles all over the film.
    fn probe<M: LightModel<N>>(
        &self,
        pool: &Pool<N, M>,
        scene: &Scene<N>,
        settings: &Resolved,
        shot: Shot,
    ) -> Vec<Vec<[f32; 3]>> {
        let tiles = tiles(scene.sensor.width, scene.sensor.height);
        let step = tiles.len().div_ceil(PROBED_TILES);
        let mut points = vec![Vec::new(); self.maps.0.len()];
        for &[x, y, width, height] in tiles.iter().step_by(step) {
            let of_pixels = Chunk { sequence: Sequence::PerPath, ..chunk(settings, shot, 0, 0) };
            let chunk = Chunk { x, y, width, height, ..of_pixels };
            pool.with(|workspace| {
                walk_to_merging(workspace, scene, &chunk, &self.maps, |w, _| {
                    for (event, rows) in w.walk.partition.connectable() {
                        let map = map_of(event.met);
                        let [x, y, z] = &w.walk.surfaces.position;
                        points[map].extend(rows.map(|row| [x[row], y[row], z[row]]));
                    }
                });
            });
        }
        points
    }
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
    }
}
