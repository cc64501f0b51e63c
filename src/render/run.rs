//! A render in the making, for one number of wavelengths and one mode.

use std::sync::Arc;

use crate::film::Film;
use crate::image::StokesImage;
use crate::integrators::profile::Profile;
use crate::math::hash::combine;
use crate::scattering::Scene;
use crate::transport::LightModel;

use super::Resolved;
use super::photon_pass::{PhotonPass, Shot};
use super::renderer::Limit;
use super::tiles::{Pool, wave};

/// Samples per pixel between two looks at the clock.
const WAVE: u32 = 16;

/// What a render does whose wavelengths and mode are known to itself alone.
pub trait Steps: Send + Sync {
    /// Renders the next wave, `most` samples per pixel at most, and less where a replicate or block
    /// ends; none if photons are not ready within the limit.
    fn step(&mut self, most: u32, limit: &Limit);
    /// Samples per pixel so far.
    fn samples(&self) -> u32;
    /// The image so far, without variances.
    fn preview(&self) -> StokesImage;
    /// What all steps so far took.
    fn profile(&self) -> Profile;
    /// Radii of the latest iteration of photons: that on surfaces, then those in the media.
    fn radii(&self) -> Vec<Option<f32>>;
    /// The image of all that has been done, with variances where two replicates or blocks, or more,
    /// have begun.
    fn finish(self: Box<Self>) -> StokesImage;
}

/// All that a render keeps from one wave to the next.
pub struct Run<const N: usize, M: LightModel<N>> {
    scene: Arc<Scene<N>>,
    settings: Resolved,
    film: Film,
    pool: Pool<N, M>,
    photons: Option<PhotonPass<N>>,
    profile: Profile,
    /// Samples per pixel so far.
    done: u32,
    /// The current replicate.
    replicate: u32,
    /// Samples per pixel of it so far.
    of_replicate: u32,
    /// Samples per pixel since a replicate or block has ended, and those until one ends.
    of_block: u32,
    left_of_block: u32,
}

impl<const N: usize, M: LightModel<N>> Run<N, M> {
    /// Black film, no photons.
    pub fn new(scene: Arc<Scene<N>>, settings: &Resolved) -> Self {
        let (width, height) = (scene.sensor.width, scene.sensor.height);
        let components = settings.mode.components();
        let photons = settings.passes.map(|passes| PhotonPass::new(&scene, passes, M::POLARIZED));
        Self {
            film: Film::new(width, height, settings.color, components, settings.has_variance()),
            pool: Pool::new(components, scene.has_media()),
            scene,
            settings: *settings,
            photons,
            profile: Profile::default(),
            done: 0,
            replicate: 0,
            of_replicate: 0,
            of_block: 0,
            left_of_block: block(settings, 0, 0),
        }
    }

    /// Samples per pixel of a wave: those of an iteration of photons, if there are photons.
    fn wave_of(&self) -> u32 {
        self.settings.passes.map_or(WAVE, |passes| passes.samples)
    }

    /// Hands a replicate, or a block of the one there is, to the film.
    fn finish_block(&mut self) {
        match self.settings.replicates {
            2.. => self.film.finish_replicate(self.of_block),
            _ => self.film.finish_block(self.of_block),
        }
    }

    /// Goes on to the next replicate or block where one has ended.
    fn begin_block(&mut self) {
        let is_last = self.replicate + 1 == self.settings.replicates;
        if self.left_of_block > 0 || (self.settings.replicates > 1 && is_last) {
            return;
        }
        self.finish_block();
        self.of_block = 0;
        if !is_last {
            self.replicate += 1;
            self.of_replicate = 0;
        }
        self.left_of_block = block(&self.settings, self.replicate, self.done);
    }
}

impl<const N: usize, M: LightModel<N>> Steps for Run<N, M> {
    fn step(&mut self, most: u32, limit: &Limit) {
        self.begin_block();
        let wave_of = self.wave_of();
        let count = wave_of.min(most).min(self.left_of_block);
        if count == 0 {
            return;
        }
        let (first, seed) = (self.of_replicate, combine(self.settings.seed, self.replicate));
        let Self { scene, settings, film, pool, photons, profile, done, .. } = self;
        if let Some(photons) = photons {
            let shot = Shot { iteration: first / wave_of, seed, earlier: *done / wave_of };
            // An image of some photons is better than none.
            let some_will_do = *done == 0;
            if !photons.shoot(pool, scene, settings, (shot, limit, some_will_do), profile) {
                return;
            }
        }
        let maps = photons.as_ref().map(|photons| &photons.maps);
        let is_wanted = || !limit.is_given_up();
        wave((film, profile), pool, (scene, settings), (first, count, seed), maps, &is_wanted);
        self.done += count;
        self.of_replicate += count;
        self.of_block += count;
        self.left_of_block -= count;
    }

    fn samples(&self) -> u32 {
        self.done
    }

    fn preview(&self) -> StokesImage {
        self.film.preview(self.of_block)
    }

    fn profile(&self) -> Profile {
        let mut profile = self.profile.clone();
        self.pool.add_profiles(&mut profile);
        profile
    }

    fn radii(&self) -> Vec<Option<f32>> {
        self.photons.as_ref().map_or(Vec::new(), PhotonPass::radii)
    }

    fn finish(mut self: Box<Self>) -> StokesImage {
        if self.of_block > 0 {
            self.finish_block();
        }
        // Photons and working tables take memory that the image may need.
        let film = {
            let run = *self;
            run.film
        };
        film.develop()
    }
}

/// Samples per pixel until the film takes a mean for the variances: of the whole replicate, or of a
/// block of the sequence. One replicate alone goes on for as long as it is asked to.
///
/// Blocks are of powers of two, of which low-discrepancy sequences are made, and are about a
/// sixteenth of all. They begin small, as nobody knows how far a render will come.
fn block(settings: &Resolved, replicate: u32, done: u32) -> u32 {
    const BLOCKS: u32 = 16;
    const LEAST: u32 = 4;
    let unit = settings.samples_per_iteration();
    if settings.replicates > 1 {
        let [end, start] = [replicate + 1, replicate].map(|r| share(settings, r));
        return end - start;
    }
    if !settings.variance {
        return u32::MAX;
    }
    let power_of_two = |value: u32| 1 << value.max(1).ilog2();
    let planned: u32 = power_of_two(settings.samples / unit / BLOCKS);
    let least = if settings.time_limit.is_some() { 1 } else { LEAST };
    planned.min(power_of_two(done / unit * 2 / BLOCKS).max(least)) * unit
}

/// Samples per pixel of the first `replicates` replicates: whole numbers of iterations of photons,
/// if any.
fn share(settings: &Resolved, replicates: u32) -> u32 {
    let unit = settings.samples_per_iteration();
    let units = u64::from(settings.samples / unit) * u64::from(replicates);
    (units / u64::from(settings.replicates)) as u32 * unit
}
