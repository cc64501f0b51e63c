//! A render that is stepped: what `render` does in one go, and a measurement piece by piece.

use crate::film::Film;
use crate::image::StokesImage;
use crate::integrators::profile::Profile;
use crate::math::hash::combine;
use crate::scattering::Scene;
use crate::transport::{LightModel, Polarized, Scalar};

use super::photon_pass::{PhotonPass, Shot};
use super::{Integrator, Mode, Outcome, Pool, Settings, WAVE, wave};

/// A render of one replicate that goes on for as long as it is asked to. Its film is that of
/// [`super::render`] with as many iterations; `Settings::iterations`, `replicates` and
/// `time_limit` do not count here.
pub struct Session<'a>(Box<dyn Steps + Send + 'a>);

impl<'a> Session<'a> {
    /// A render in which nothing has been done yet.
    pub fn new<const N: usize>(scene: &'a Scene<N>, settings: &'a Settings) -> Self {
        match settings.mode {
            Mode::Scalar => Self(Box::new(Run::<N, Scalar>::new(scene, settings))),
            Mode::Intensity | Mode::Polarized => {
                Self(Box::new(Run::<N, Polarized>::new(scene, settings)))
            }
        }
    }

    /// Does the next iteration of photons with its samples, or a wave of samples where there are
    /// no photons. The first also finds the radius that photons are merged within.
    pub fn step(&mut self) {
        self.0.step();
    }

    /// Renders `samples` more samples per pixel, in the same waves or iterations; with photons, a
    /// multiple of the samples of an iteration.
    pub fn advance(&mut self, samples: u32) {
        self.0.advance_by(samples);
    }

    /// The image so far, without variances.
    pub fn image(&self) -> StokesImage {
        self.0.image()
    }

    /// What all steps so far took.
    pub fn profile(&self) -> Profile {
        self.0.profile()
    }

    /// Radii of the latest iteration: that on surfaces, then those in the media. Empty without
    /// photons.
    pub fn radii(&self) -> Vec<f32> {
        self.0.radii()
    }

    /// What came out.
    pub fn finish(self) -> Outcome {
        self.0.finish()
    }
}

/// A run whose mode is known to itself alone.
trait Steps {
    fn step(&mut self);
    fn advance_by(&mut self, samples: u32);
    fn image(&self) -> StokesImage;
    fn profile(&self) -> Profile;
    fn radii(&self) -> Vec<f32>;
    fn finish(self: Box<Self>) -> Outcome;
}

impl<const N: usize, M: LightModel<N>> Steps for Run<'_, N, M> {
    fn step(&mut self) {
        self.advance_by(self.wave_of());
    }

    fn advance_by(&mut self, samples: u32) {
        let end = self.done + samples;
        while self.done < end {
            let count = self.wave_of().min(end - self.done);
            self.advance(self.done, count, combine(self.settings.seed, 0));
        }
    }

    fn image(&self) -> StokesImage {
        self.film.preview(self.done)
    }

    fn profile(&self) -> Profile {
        let mut profile = self.profile.clone();
        self.pool.add_profiles(&mut profile);
        profile
    }

    fn radii(&self) -> Vec<f32> {
        self.photons.as_ref().map_or(Vec::new(), PhotonPass::radii)
    }

    fn finish(mut self: Box<Self>) -> Outcome {
        if self.done > 0 {
            self.film.finish_replicate(self.done);
        }
        (*self).into_outcome()
    }
}

/// All that a render keeps from one wave to the next.
pub(super) struct Run<'a, const N: usize, M: LightModel<N>> {
    scene: &'a Scene<N>,
    settings: &'a Settings,
    /// The sums.
    pub film: Film,
    pool: Pool<N, M>,
    photons: Option<PhotonPass<N>>,
    profile: Profile,
    /// Samples per pixel so far.
    pub done: u32,
}

impl<'a, const N: usize, M: LightModel<N>> Run<'a, N, M> {
    /// Black film, no photons.
    pub fn new(scene: &'a Scene<N>, settings: &'a Settings) -> Self {
        let (width, height) = (scene.sensor.width, scene.sensor.height);
        let with_variance = settings.replicates > 1;
        let components = settings.mode.components();
        let photons = (settings.integrator == Integrator::Ppm)
            .then(|| PhotonPass::new(scene, settings.photons.per_iteration, M::POLARIZED));
        Self {
            scene,
            settings,
            film: Film::new(width, height, settings.color, components, with_variance),
            pool: Pool::new(components, scene.has_media()),
            photons,
            profile: Profile::default(),
            done: 0,
        }
    }

    /// Samples per pixel of a wave: those of an iteration of photons, if there are photons.
    pub fn wave_of(&self) -> u32 {
        if self.photons.is_some() { self.settings.photons.samples } else { WAVE }
    }

    /// Renders one wave: `count` samples per pixel from `first` on in the sequences of `seed`.
    pub fn advance(&mut self, first: u32, count: u32, seed: u32) {
        let wave_of = self.wave_of();
        let Self { scene, settings, film, pool, photons, profile, done } = self;
        if let Some(photons) = photons {
            let shot = Shot { iteration: first / wave_of, seed, earlier: *done / wave_of };
            photons.shoot(pool, scene, settings, shot, profile);
        }
        let maps = photons.as_ref().map(|photons| &photons.maps);
        wave(film, profile, pool, scene, settings, (first, count, seed), maps);
        *done += count;
    }

    /// What came out, with the profiles of all threads.
    pub fn into_outcome(mut self) -> Outcome {
        self.pool.add_profiles(&mut self.profile);
        Outcome { film: self.film, profile: self.profile, iterations: self.done }
    }
}
