//! A render in the making, for one number of wavelengths and one mode.

use crate::film::record::{Column, Fact, Record};
use crate::film::{Developed, Film, Gauge, Variances};
use crate::image::OutputError;
use crate::integrators::profile::Profile;
use crate::math::hash::combine;
use crate::scattering::Scene;
use crate::transport::LightModel;

use super::Resolved;
use super::photon_pass::{PhotonPass, Shot};
use super::place::{Groups, Place};
use super::renderer::Limit;
use super::sets::{Iteration, Sets};
use super::tiles::{Pool, wave};

/// Samples per pixel between two looks at the clock.
const WAVE: u32 = 16;

/// What a render does whose wavelengths and mode are known to itself alone.
pub trait Steps: Send + Sync {
    /// Renders the next wave, `most` samples per pixel at most, and less where a replicate or block
    /// ends; none if photons are not ready within the limit.
    fn step(&mut self, most: u32, limit: &Limit);
    /// Samples per pixel of the whole image that come before the next.
    fn done(&self) -> u32;
    /// The image so far, without variances.
    fn preview(&self) -> Developed<'_>;
    /// What all steps so far took.
    fn profile(&self) -> Profile;
    /// Radii of the latest iteration of photons: that on surfaces, then those in the media.
    fn radii(&self) -> Vec<Option<f32>>;
    /// Channels for which there has been no wavelength so far; and those for which there has been
    /// none that light goes on at which disperses, if any does.
    fn unmeasured(&self) -> [Vec<usize>; 2];
    /// What is needed to go on from here, but for `done`: to the same bits, unless an iteration was
    /// left unfinished, when there is none.
    fn state(&self) -> Option<State<'_>>;
    /// Ends the current block, as whoever has the samples behind it begins a new one.
    fn end_block(&mut self);
    /// Goes on from a state after `done` samples.
    fn restore(&mut self, record: &mut Record, done: u32) -> Result<(), OutputError>;
    /// The image of all that has been done, with variances where two replicates or blocks, or more,
    /// have begun.
    fn finish(self: Box<Self>) -> Developed<'static>;
}

/// Facts and columns of a state.
pub type State<'a> = (Vec<Fact>, Vec<(String, Column<'a>)>);

/// All that a render keeps from one wave to the next.
pub struct Run<const N: usize, M: LightModel<N>> {
    sets: Sets<N>,
    settings: Resolved,
    film: Film,
    pool: Pool<N, M>,
    photons: Option<PhotonPass<N>>,
    profile: Profile,
    groups: Groups,
    place: Place,
    /// An iteration was begun with fewer photons than it should have: nothing else has its bits.
    is_unfinished: bool,
}

impl<const N: usize, M: LightModel<N>> Run<N, M> {
    /// Black film, no photons.
    pub fn new(sets: Sets<N>, settings: &Resolved) -> Self {
        let scene = &sets.scene;
        let photons = settings.passes.map(|passes| PhotonPass::new(scene, passes, M::POLARIZED));
        let groups = settings.groups();
        let place = Place::after(&groups, settings.first_sample, settings.first_sample);
        let with = (scene.has_media(), settings.integrator.weighs_strategies());
        Self {
            film: black_film(scene, settings, sets.differ()),
            pool: Pool::new(settings.components(), with, settings.stage_times),
            sets,
            settings: settings.clone(),
            photons,
            profile: Profile { is_timed: settings.stage_times, ..Profile::default() },
            groups,
            place,
            is_unfinished: false,
        }
    }

    /// Samples per pixel of a wave: those of an iteration of photons, if there are photons.
    fn wave_of(&self) -> u32 {
        self.settings.passes.map_or(WAVE, |passes| passes.samples)
    }

    /// Goes on to the next replicate or block where one has ended.
    fn begin_block(&mut self) {
        if self.place.is_end_of_block(&self.groups) {
            self.film.finish_block(self.place.of_block);
            self.place.begin_block(&self.groups);
        }
    }

    /// What the next samples are rendered with: iterations of so many samples each.
    fn iterations(&self, count: u32) -> (Vec<Iteration<N>>, u32) {
        let seed = combine(self.settings.seed, self.place.replicate);
        let first = self.place.of_replicate;
        match self.settings.passes {
            // Photons and the samples that they are for have the same wavelengths.
            Some(passes) => (self.sets.iterations(first / passes.samples, 1, seed), count),
            None if self.sets.differ() => (self.sets.iterations(first, count, seed), 1),
            None => (self.sets.iterations(first, 1, seed), count),
        }
    }

    /// Shoots the photons of the iteration at hand: false if they are not ready within the limit.
    fn shoot(&mut self, scene: &Scene<N>, limit: &Limit) -> bool {
        let (wave_of, place) = (self.wave_of(), self.place);
        let Self { sets, settings, pool, photons, profile, .. } = self;
        let Some(photons) = photons else { return true };
        let seed = combine(settings.seed, place.replicate);
        let iteration = place.of_replicate / wave_of;
        let shot = Shot { iteration, seed, earlier: place.done / wave_of };
        // An image of some photons is better than none.
        let some_will_do = place.done == settings.first_sample;
        let scenes = (scene, &*sets);
        let is_shot = photons.shoot(pool, scenes, settings, (shot, limit, some_will_do), profile);
        self.is_unfinished |= is_shot && !photons.is_complete();
        is_shot
    }
}

impl<const N: usize, M: LightModel<N>> Steps for Run<N, M> {
    fn step(&mut self, most: u32, limit: &Limit) {
        self.begin_block();
        let count = self.wave_of().min(most).min(self.place.left_of_block);
        if count == 0 {
            return;
        }
        let (iterations, samples_of_each) = self.iterations(count);
        if !self.shoot(&iterations[0].scene, limit) {
            return;
        }
        let Self { settings, film, pool, photons, profile, place, .. } = self;
        let seed = combine(settings.seed, place.replicate);
        let maps = photons.as_ref().map(|photons| &photons.maps);
        let is_wanted = || !limit.is_given_up();
        let samples = (place.of_replicate, count, seed);
        let lit = (&*iterations, samples_of_each);
        wave((film, profile), pool, (lit, settings), samples, maps, &is_wanted);
        self.place.advance(count);
        self.is_unfinished |= limit.is_given_up();
    }

    fn done(&self) -> u32 {
        self.place.done
    }

    fn preview(&self) -> Developed<'_> {
        let Resolved { analyzer, .. } = self.settings;
        self.film.so_far(self.place.of_block).behind(analyzer, self.settings.mode.components())
    }

    fn profile(&self) -> Profile {
        let mut profile = self.profile.clone();
        self.pool.add_profiles(&mut profile);
        profile
    }

    fn radii(&self) -> Vec<Option<f32>> {
        self.photons.as_ref().map_or(Vec::new(), PhotonPass::radii)
    }

    fn unmeasured(&self) -> [Vec<usize>; 2] {
        let Place { replicate, of_replicate, .. } = self.place;
        let samples = self.settings.passes.map_or(1, |passes| passes.samples);
        let seeds = (0..=replicate).map(|replicate| combine(self.settings.seed, replicate));
        let count = of_replicate.div_ceil(samples);
        [self.film.unmeasured(), self.sets.unmeasured_if_dispersed(count, seeds)]
    }

    fn state(&self) -> Option<State<'_>> {
        (!self.is_unfinished).then(|| self.film.state())
    }

    fn restore(&mut self, record: &mut Record, done: u32) -> Result<(), OutputError> {
        self.film.restore(record)?;
        self.place = Place::after(&self.groups, self.settings.first_sample, done);
        Ok(())
    }

    fn end_block(&mut self) {
        if self.place.of_block > 0 {
            self.film.finish_block(self.place.of_block);
            self.place.of_block = 0;
        }
    }

    fn finish(mut self: Box<Self>) -> Developed<'static> {
        self.end_block();
        // Photons and working tables take memory that the image may need.
        let (film, settings) = {
            let run = *self;
            (run.film, run.settings)
        };
        film.into_developed().behind(settings.analyzer, settings.mode.components())
    }
}

fn black_film<const N: usize>(scene: &Scene<N>, settings: &Resolved, sets_differ: bool) -> Film {
    let size = scene.sensor.layout.cut.size;
    let variances = match (settings.replicates, settings.variance) {
        (2.., _) => Variances::Replicates,
        (_, true) => Variances::Blocks,
        (_, false) => Variances::None,
    };
    let kinds = (variances, if sets_differ { Gauge::Kept } else { Gauge::None });
    let begins_later = settings.first_sample > 0;
    Film::new(size, settings.color.clone(), settings.components(), kinds, begins_later)
}
