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

use super::Settings;
use super::tiles::Pool;

/// Light paths that are shot and stored together.
const BATCH: u32 = 16 * ROWS as u32;

/// Photons within the first radius (the paper, section 5).
const NEAREST: usize = 25;
/// Points of a map that the first radius is found at.
const PROBES: usize = 1024;
/// Tiles of the film that they are taken from.
const PROBED_TILES: usize = 64;
/// First radius relative to that of the scene where there are too few photons to tell.
const RADIUS_OF_SCENE: f32 = 0.01;

/// The maps of all places, and the photons on their way there.
pub struct PhotonPass<const N: usize> {
    /// Where photons are merged.
    pub maps: PhotonMaps<N>,
    /// First radii.
    first_radii: Vec<f32>,
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
    pub fn new(scene: &Scene<N>, photons: u32, polarized: bool) -> Self {
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
        let tables = || classes.iter().map(|&class| PhotonTable::of_class(class, 0)).collect();
        Self {
            maps: PhotonMaps::new(&classes),
            first_radii: Vec::new(),
            batches: (0..photons.div_ceil(BATCH)).map(|_| tables()).collect(),
        }
    }

    /// Photons in all maps.
    pub fn stored(&self) -> u64 {
        self.maps.0.iter().map(|map| map.stored.len as u64).sum()
    }

    /// Radii of the kernels, by map.
    pub fn radii(&self) -> Vec<f32> {
        self.maps.0.iter().map(|map| map.radius).collect()
    }

    /// Shoots the photons of an iteration and sorts them.
    pub fn shoot<M: LightModel<N>>(
        &mut self,
        pool: &Pool<N, M>,
        scene: &Scene<N>,
        settings: &Settings,
        shot: Shot,
        profile: &mut Profile,
    ) {
        let light_paths = settings.photons.per_iteration;
        self.batches.par_iter_mut().enumerate().for_each(|(index, batch)| {
            let index = index as u32;
            batch.iter_mut().for_each(PhotonTable::clear);
            let end = light_paths.min((index + 1) * BATCH);
            for first in (index * BATCH..end).step_by(ROWS) {
                let chunk = chunk(settings, shot, first, end.min(first + ROWS as u32) - first);
                pool.with(|workspace| photons::photons(batch, workspace, scene, &chunk));
            }
        });
        profile.time_of_threads(Stage::Store, rayon::current_num_threads(), || {
            for (index, map) in self.maps.0.iter_mut().enumerate() {
                map.stored.clear();
                for batch in &self.batches {
                    map.stored.append_table(&batch[index]);
                }
                map.light_paths = light_paths as f32;
            }
        });
        if self.first_radii.is_empty() {
            self.first_radii = self.find_radii(pool, scene, settings, shot);
        }
        let shrinking = shrinking(settings.photons.alpha, shot.earlier);
        profile.time_of_threads(Stage::Store, rayon::current_num_threads(), || {
            for (map, first) in self.maps.0.iter_mut().zip(&self.first_radii) {
                map.radius = first * shrinking.powf(1.0 / f64::from(map.dimensions)) as f32;
                map.grid.rebuild(&map.stored, map.radius);
            }
        });
        profile.photons += self.stored();
    }

    /// The radii to begin with: what is asked for, or the median distance from points that the
    /// sensor sees to their 25th nearest photon.
    fn find_radii<M: LightModel<N>>(
        &self,
        pool: &Pool<N, M>,
        scene: &Scene<N>,
        settings: &Settings,
        shot: Shot,
    ) -> Vec<f32> {
        if let Some(radius) = settings.photons.radius {
            return vec![radius; self.maps.0.len()];
        }
        let fallback = RADIUS_OF_SCENE * scene.shapes.bounds.radius;
        let points = self.probe(pool, scene, settings, shot);
        self.maps
            .0
            .iter()
            .zip(points)
            .map(|(map, points)| {
                let step = points.len().div_ceil(PROBES).max(1);
                let some: Vec<[f32; 3]> = points.into_iter().step_by(step).collect();
                let mut distances = nearest_distances(&map.stored, &some, NEAREST);
                distances.retain(|distance| distance.is_finite() && *distance > 0.0);
                distances.sort_by(f32::total_cmp);
                distances.get(distances.len() / 2).copied().unwrap_or(fallback)
            })
            .collect()
    }

    /// Vertices at which photons will be merged, by map, from tiles all over the film.
    fn probe<M: LightModel<N>>(
        &self,
        pool: &Pool<N, M>,
        scene: &Scene<N>,
        settings: &Settings,
        shot: Shot,
    ) -> Vec<Vec<[f32; 3]>> {
        let tiles = tiles(scene.sensor.width, scene.sensor.height);
        let step = tiles.len().div_ceil(PROBED_TILES);
        let mut points = vec![Vec::new(); self.maps.0.len()];
        for &[x, y, width, height] in tiles.iter().step_by(step) {
            let of_pixels = Chunk { sequence: Sequence::PerPath, ..chunk(settings, shot, 0, 0) };
            let chunk = Chunk { x, y, width, height, ..of_pixels };
            pool.with(|workspace| {
                walk_to_merging(workspace, scene, &chunk, |w, _| {
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
fn chunk(settings: &Settings, shot: Shot, first_path: u32, paths: u32) -> Chunk {
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
