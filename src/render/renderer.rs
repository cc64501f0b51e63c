//! The renderer: stepped, watched, stopped, finished.

use std::any::Any;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::film::Developed;
use crate::film::layout::Layout;
use crate::image::StokesImage;
use crate::image::cut::{CROP, FILTER, PIXEL_ASPECT};
use crate::image::rows::Rows;
use crate::integrators::profile::Profile;
use crate::scattering::{Scene, Side};
use crate::scene::SceneError;
use crate::transport::{Polarized, Scalar};

use super::layers::SeenFirst;
use super::memory::{MemoryError, check_memory_of_cut};
use super::placed::WithScene;
use super::recorded::{self, Origin, PartError};
use super::resolved::Resolved;
use super::run::{Run, Steps};
use super::sets::Sets;
use super::spectral;
use super::threads::Threads;
use super::{Mode, Options, PlacedWorld, Settings, SettingsError};

/// A render of a world. It keeps what it needs of it and goes on for as long as it is asked to.
///
/// The image is a function of world, settings and samples: neither the number of threads nor how
/// the samples are asked for, one [`Renderer::step`] after the other or all at once, in one go or
/// [saved](Renderer::save) and [taken up](Renderer::resume) elsewhere, together or in parts
/// ([`crate::merge`]), changes a bit of it.
pub struct Renderer {
    steps: Box<dyn Steps>,
    settings: Resolved,
    film: Layout,
    origin: Origin,
    seen_first: SeenFirst,
    threads: Option<Arc<Threads>>,
    stop: Stop,
}

/// A world cannot be placed, or a render cannot begin.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The world is wrong, or not to be seen in the color.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The settings do not go with the world.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The film, the photons or the shapes are too large for the memory.
    #[error(transparent)]
    Memory(#[from] MemoryError),
}

/// Stops a render from elsewhere: from another thread, say. All clones are one.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<Asked>);

/// What has been asked for.
#[derive(Debug, Default)]
struct Asked {
    stop: AtomicBool,
    give_up: AtomicBool,
}

impl Stop {
    /// Asks the render to stop when the current wave of samples is done: [`Renderer::run`] and
    /// [`Renderer::advance`] end then, for good; [`Renderer::step`] does what it is told. Photons
    /// are no longer waited for: the first iteration takes those that are there, and any other is
    /// given up.
    pub fn stop(&self) {
        self.0.stop.store(true, Ordering::Relaxed);
    }

    /// Asks the render to stop as soon as it can, within the wave in hand: what is left of its
    /// pixels is missing from the image, which is of no use then.
    pub fn give_up(&self) {
        self.0.give_up.store(true, Ordering::Relaxed);
        self.stop();
    }

    /// Whether either has been asked for.
    pub fn is_set(&self) -> bool {
        self.0.stop.load(Ordering::Relaxed)
    }

    /// Whether the wave in hand is given up.
    fn is_given_up(&self) -> bool {
        self.0.give_up.load(Ordering::Relaxed)
    }
}

/// What a wave is not to go on for.
#[derive(Clone, Default)]
pub struct Limit {
    /// When the time is over.
    pub end: Option<Instant>,
    /// What asks to stop, if anybody may.
    pub stop: Option<Stop>,
}

impl Limit {
    /// Whether it has been reached.
    pub fn is_over(&self) -> bool {
        self.is_stopped() || self.end.is_some_and(|end| Instant::now() > end)
    }

    /// Whether that is because somebody asks to stop.
    pub fn is_stopped(&self) -> bool {
        self.stop.as_ref().is_some_and(Stop::is_set)
    }

    /// Whether nobody wants the image any more.
    pub fn is_given_up(&self) -> bool {
        self.stop.as_ref().is_some_and(Stop::is_given_up)
    }
}

/// How far a render has come.
pub struct Progress<'a> {
    /// Samples per pixel so far.
    pub samples: u32,
    /// Samples per pixel that were asked for.
    pub total: u32,
    settings: &'a Resolved,
    origin: &'a Origin,
    steps: &'a dyn Steps,
}

impl Progress<'_> {
    /// Writes what is needed to go on from here to a file: see [`Renderer::save`].
    ///
    /// # Errors
    /// As that.
    pub fn save(&self, path: &Path) -> Result<(), PartError> {
        recorded::save(path, self.origin, self.settings, self.steps)
    }

    /// The image so far, without variances, and with what is known of its making as metadata.
    pub fn preview(&self) -> StokesImage {
        self.rows().whole().into_owned()
    }

    /// The same image, of which no plane is in memory.
    pub(crate) fn rows(&self) -> Developed<'_> {
        let mut image = self.steps.preview();
        image.metadata = metadata(self.settings, self.samples);
        image
    }
}

impl Renderer {
    /// A render in which nothing has been done yet, on the threads of the caller's rayon pool.
    ///
    /// # Errors
    /// When a spectrum of the world does not cover the color, nothing emits, or the film is too
    /// large to be counted or for the memory.
    pub fn new(world: &PlacedWorld, settings: &Settings) -> Result<Self, RenderError> {
        let film = world.film(settings)?;
        let mut renderer = world.with_scene(settings, film, InMemory { settings })??;
        renderer.origin = Origin::of(world.clone(), film);
        renderer.seen_first = world.seen_first(settings)?;
        let put_in = world.world().put_in().iter();
        renderer.settings.put_in = put_in.map(|it| (it.what, it.text.clone())).collect();
        Ok(renderer)
    }

    /// A render of a scene that has been baked, for tests that look into its tables; the film is
    /// the scene's, which has the wavelengths of a color. None of four or eight: these are others
    /// in every iteration, for which the renderer bakes the scene itself ([`Renderer::new`]).
    #[doc(hidden)]
    pub fn of<const N: usize>(scene: Arc<Scene<N>>, settings: &Settings) -> Self {
        Self::of_any(scene, settings)
    }

    /// The same in a function of this crate alone: generic ones are compiled with all that they
    /// call wherever they are used, in each of the tests.
    fn of_any(scene: Arc<dyn Any + Send + Sync>, settings: &Settings) -> Self {
        match scene.downcast::<Scene<1>>() {
            Ok(scene) => Self::whole(scene, settings),
            Err(scene) => match scene.downcast::<Scene<3>>() {
                Ok(scene) => Self::whole(scene, settings),
                Err(_) => panic!("no channels stand for so many wavelengths"),
            },
        }
    }

    fn whole<const N: usize>(scene: Arc<Scene<N>>, settings: &Settings) -> Self {
        let resolved = Resolved::new(settings, &scene);
        Self::with(Sets::fixed(scene), resolved)
    }

    fn with<const N: usize>(sets: Sets<N>, settings: Resolved) -> Self {
        let film = sets.scene.sensor.layout;
        let steps: Box<dyn Steps> = match settings.mode {
            Mode::Scalar => Box::new(Run::<N, Scalar>::new(sets, &settings)),
            Mode::Intensity | Mode::Polarized => {
                Box::new(Run::<N, Polarized>::new(sets, &settings))
            }
        };
        let origin = Origin::unknown(film);
        let (seen_first, stop) = (SeenFirst::default(), Stop::default());
        Self { steps, settings, film, origin, seen_first, threads: None, stop }
    }

    /// The same render on threads of its own, which several renders may share.
    #[must_use]
    pub fn on(mut self, threads: &Arc<Threads>) -> Self {
        self.threads = Some(Arc::clone(threads));
        self
    }

    /// The same render, which listens to something that there is already, and so can be stopped
    /// before it has begun.
    #[must_use]
    pub fn stopped_by(mut self, stop: &Stop) -> Self {
        self.stop = stop.clone();
        self
    }

    /// Renders the next wave: 16 samples per pixel, or an iteration of photons with its samples,
    /// and less where what was asked for or a replicate ends. With one replicate, steps go on
    /// behind [`Renderer::is_done`], as long as anybody asks for them, unless a part was.
    pub fn step(&mut self) {
        let left = self.total().saturating_sub(self.samples());
        if left > 0 || self.settings.part.is_none() {
            self.step_at_most(if left == 0 { u32::MAX } else { left }, &Limit::default());
        }
    }

    /// Renders `samples` more samples per pixel, in the same waves, whatever was asked for; with
    /// photons, so many that iterations are whole. Ends early if it is stopped.
    pub fn advance(&mut self, samples: u32) {
        let samples = samples.div_ceil(self.settings.samples_per_iteration());
        let samples = samples.saturating_mul(self.settings.samples_per_iteration());
        let end = self.samples().saturating_add(samples);
        let end = if self.settings.part.is_some() { end.min(self.total()) } else { end };
        let limit = Limit { end: None, stop: Some(self.stop.clone()) };
        while self.samples() < end && !self.stop.is_set() {
            let before = self.samples();
            self.step_at_most(end - before, &limit);
            if self.samples() == before {
                break;
            }
        }
    }

    /// Renders until all samples that were asked for are done, the time is over, `progress` breaks
    /// or [`Stop`] is set; once it has begun, there is an image. `progress` hears after every wave.
    pub fn run(&mut self, mut progress: impl FnMut(&Progress) -> ControlFlow<()>) {
        let start = Instant::now();
        let time_limit = self.settings.time_limit;
        let end = time_limit.and_then(|limit| start.checked_add(limit));
        let limit = Limit { end, stop: Some(self.stop.clone()) };
        let is_over = |samples: u32| limit.is_given_up() || samples > 0 && limit.is_over();
        let is_stopped = limit.is_stopped();
        while !(is_stopped || self.is_done() || is_over(self.samples())) {
            let most = match time_limit {
                Some(limit) => self.samples_in(limit.saturating_sub(start.elapsed()), start),
                None => u32::MAX,
            };
            let left = self.total() - self.samples();
            self.step_at_most(most.min(left), &limit);
            let (samples, total) = (self.samples(), self.total());
            let Self { settings, origin, steps, .. } = self;
            let so_far = Progress { samples, total, settings, origin, steps: &**steps };
            if progress(&so_far).is_break() {
                break;
            }
        }
    }

    /// Samples per pixel that a wave may have of the `left` time, if it goes on as since `start`:
    /// half of it, so that waves grow from one sample on, and shrink in the end. Photons come in
    /// whole iterations.
    fn samples_in(&self, left: Duration, start: Instant) -> u32 {
        if self.settings.integrator.shoots_photons() {
            return u32::MAX;
        }
        let rate = f64::from(self.samples()) / start.elapsed().as_secs_f64().max(1e-9);
        ((0.5 * rate * left.as_secs_f64()) as u32).clamp(1, self.samples().max(1))
    }

    /// Samples per pixel so far, of the part that was asked for.
    pub fn samples(&self) -> u32 {
        self.steps.done() - self.settings.first_sample
    }

    /// Samples per pixel that were asked for: of a part, if one was.
    pub fn total(&self) -> u32 {
        self.settings.end_sample - self.settings.first_sample
    }

    /// Whether all samples that were asked for are done.
    pub fn is_done(&self) -> bool {
        self.samples() >= self.total()
    }

    /// Writes what has been summed so far to a file, which appears when it is complete and on the
    /// disk: a render that [goes on](Renderer::resume) from it gives the bits of one that was never
    /// stopped, and parts that are done give those of the whole image ([`crate::merge`]).
    ///
    /// # Errors
    /// When the file cannot be written; when the render was [stopped](Stop) as it shot its first
    /// photons, as nothing goes on from an iteration of some of them.
    pub fn save(&mut self, path: &Path) -> Result<(), PartError> {
        if self.settings.part.is_some() && self.is_done() {
            self.steps.end_block();
        }
        recorded::save(path, &self.origin, &self.settings, &*self.steps)
    }

    /// Goes on from what [`Renderer::save`] has written, in a render in which nothing has been done
    /// yet.
    ///
    /// # Errors
    /// When the file cannot be read or is damaged, or is of another scene, settings or build: with
    /// what differs.
    pub fn resume(&mut self, path: &Path) -> Result<(), PartError> {
        recorded::resume(path, &self.origin, &self.settings, &mut *self.steps)
    }

    /// What was asked for, and what the scene has decided of it.
    pub fn settings(&self) -> &Resolved {
        &self.settings
    }

    /// Width and height of the image in pixels: of the part of the film that is rendered.
    pub fn film_size(&self) -> [u32; 2] {
        self.film.cut.size
    }

    /// What stops the render from another thread.
    pub fn stop_handle(&self) -> Stop {
        self.stop.clone()
    }

    /// The image so far, without variances.
    pub fn preview(&self) -> StokesImage {
        let steps = &self.steps;
        on(self.threads.as_deref(), || steps.preview().whole().into_owned())
    }

    /// The same image, of which no plane is in memory.
    pub(crate) fn rows(&self) -> Developed<'_> {
        self.steps.preview()
    }

    /// The time that every stage has taken so far, and the rays and photons.
    pub fn profile(&self) -> Profile {
        self.steps.profile()
    }

    /// Radii of the latest iteration of photons, in scene units: that on surfaces, then those in
    /// the media, none where paths go on instead. Empty without photons.
    pub fn radii(&self) -> Vec<Option<f32>> {
        self.steps.radii()
    }

    /// The channels for which no iteration has had a wavelength so far, so that they are black; and
    /// those for which none has had one that light goes on at which disperses, so that they lack
    /// that light.
    pub fn unmeasured(&self) -> [Vec<usize>; 2] {
        self.steps.unmeasured()
    }

    /// The image of all samples so far, with variances if there are replicates, and with what is
    /// known of its making as metadata.
    pub fn finish(self) -> StokesImage {
        let threads = self.threads.clone();
        let rows = self.finish_rows();
        on(threads.as_deref(), || rows.whole().into_owned())
    }

    /// The same image, of which no plane is in memory.
    pub(crate) fn finish_rows(self) -> Developed<'static> {
        let metadata = metadata(&self.settings, self.samples());
        let steps = self.steps;
        let mut image = on(self.threads.as_deref(), || steps.finish());
        image.metadata = metadata;
        image.layers = self.seen_first.layers;
        image.metadata.extend(self.seen_first.names);
        image
    }

    fn step_at_most(&mut self, samples: u32, limit: &Limit) {
        let steps = &mut self.steps;
        on(self.threads.as_deref(), || steps.step(samples, limit));
    }
}

/// Makes a render of a scene for which there is memory.
struct InMemory<'a> {
    settings: &'a Settings,
}

impl WithScene for InMemory<'_> {
    type Output = Result<Renderer, RenderError>;

    fn with<const N: usize>(self, sets: Sets<N>) -> Self::Output {
        let resolved = Resolved::new(self.settings, &sets.scene).of_part()?;
        let options = Options { integrator: Some(resolved.integrator), ..self.settings.options() };
        check_memory_of_cut(&options, sets.scene.sensor.layout.cut)?;
        Ok(Renderer::with(sets, resolved))
    }
}

/// Does work on some threads, or on those of the caller.
fn on<R: Send>(threads: Option<&Threads>, work: impl FnOnce() -> R + Send) -> R {
    match threads {
        Some(threads) => threads.run(work),
        None => work(),
    }
}

/// For sensor paths, and for light paths where that is another number.
fn roulette_after(settings: &Resolved) -> String {
    match settings.roulette_after {
        Some(after) => after.to_string(),
        None => {
            let of_sides = settings.roulette_of_sides();
            let [sensor, light] = [Side::Sensor, Side::Light].map(|side| of_sides[side as usize]);
            format!("{sensor}, light paths {light}")
        }
    }
}

/// Where the variances of an image come from.
fn variance_in_words(settings: &Resolved) -> &'static str {
    match (settings.replicates, settings.variance) {
        (2.., _) => "between replicates",
        (_, true) => "between blocks of one sequence: may be overestimated",
        (_, false) => "none",
    }
}

pub(super) fn metadata(settings: &Resolved, samples: u32) -> Vec<(String, String)> {
    let integrator = [
        Some(("integrator", settings.integrator.name().to_owned())),
        Some(("integrator asked for", settings.integrator_name().to_owned())),
        settings.rule.map(|rule| ("integrator rule", rule.text().to_owned())),
        settings.passes.map(|it| ("photons an iteration", it.light_paths.to_string())),
        settings.passes.map(|it| ("samples an iteration", it.samples.to_string())),
    ];
    let analyzer = settings.analyzer.map(|it| ("analyzer", it.to_string()));
    let Layout { cut, filter, pixel_aspect, .. } = settings.film;
    let crop = (!cut.is_whole()).then(|| (CROP, cut.to_string()));
    let is_wide = filter.radius > 0.5 && settings.integrator.measures();
    let kind = || ("filter samples", settings.film.samples().name().to_owned());
    let of_filter = is_wide.then(kind);
    let pixels = (pixel_aspect != 1.0).then(|| (PIXEL_ASPECT, pixel_aspect.to_string()));
    let is_plain = settings.spectral.is_none() && settings.color == crate::spectrum::Color::Rgb;
    let white = (!is_plain).then(|| ("rgb white", settings.white().name().to_owned()));
    let spectral = settings.spectral.map(|it| ("spectral", spectral::in_words(it)));
    let balance = spectral::balance_in_words(settings).map(|it| ("white balance", it));
    let others = [
        ("mode", settings.mode.name().to_owned()),
        ("color", settings.color.to_string()),
        ("iterations", samples.to_string()),
        ("replicates", settings.replicates.to_string()),
        ("variance", variance_in_words(settings).to_owned()),
        ("max path length", settings.path_length_max.to_string()),
        ("roulette after", roulette_after(settings)),
        ("sampling", settings.sampling.name().to_owned()),
        (FILTER, filter.to_string()),
        ("seed", settings.seed.to_string()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
    ];
    let held = (!settings.held.is_empty()).then(|| ("held spectra", settings.held.join("; ")));
    let put_in = settings.put_in.iter().cloned();
    let facts = integrator.into_iter().flatten().chain(analyzer).chain(put_in).chain(spectral);
    let facts =
        facts.chain(others).chain(of_filter).chain(crop).chain(pixels).chain(white).chain(balance);
    let facts = facts.chain(held);
    facts.map(|(key, value)| (key.to_owned(), value)).collect()
}
