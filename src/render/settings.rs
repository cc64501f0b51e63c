//! What a render is asked for: options as typed, and settings in which nothing can be wrong.

use std::fmt::Display;
use std::ops::{Deref, RangeInclusive};
use std::time::Duration;

use crate::film::filter::{Filter, FilterKind, FilterSamples};
use crate::film::layout::{Crop, check_pixel_aspect};
use crate::image::layers::LayerKind;
use crate::integrators::Integrator;
use crate::math::Fault;
use crate::spectrum::{Beyond, Color, Responses, White, WhiteBalance};
use crate::transport::Sampling;

use super::place::Part;
use super::spectral::{Columns, Spectral, columns, measured, responses};

/// What asks for the integrator that suits the scene.
pub const AUTO: &str = "auto";
/// Most samples per pixel: more would not fit the sequences of 32 bits, nor a lifetime.
pub const SAMPLES_MAX: u32 = 1 << 30;
/// Most segments of a path that can be asked for; nothing needs more.
pub const PATH_LENGTH_MAX: u32 = 1_000_000;
/// Most light paths an iteration: their photons are counted in 32 bits.
pub const PHOTONS_MAX: u32 = 1 << 28;
/// Largest film edge in pixels: what a Radiance picture can have.
pub const EDGE_MAX: u32 = 65_535;
/// Most pixels of a film: they are counted in 32 bits.
pub const PIXELS_MAX: u64 = 1 << 31;

/// Wavelength of light of one wavelength where none is named, in nanometers.
pub const WAVELENGTH_NM: f32 = 550.0;
/// Wavelengths in nanometers that optics of rays and spectra can speak of.
pub const WAVELENGTHS_NM: RangeInclusive<f32> = 1.0..=1e6;

/// Light paths an iteration for every pixel, where their number is left open. With the samples of
/// [`SAMPLES_OF_PHOTONS`] both sides take about the same time.
const LIGHT_PATHS_PER_PIXEL: u64 = 4;
/// Bounds of that number: fewer find nothing between them, more take memory and no less error.
const LIGHT_PATHS: [u64; 2] = [10_000, 4_000_000];
/// Samples per pixel for every iteration of photons, where their number is left open, at most.
pub const SAMPLES_OF_PHOTONS: u32 = 4;

/// How photons are shot and gathered; for integrators that do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photons {
    /// Light paths an iteration of photons, from 1 to 2^28; by default four for every pixel, from
    /// ten thousand to four million.
    pub per_iteration: Option<u32>,
    /// Samples per pixel for every iteration of photons, at least one; by default four, or fewer
    /// where that does not divide those of a replicate.
    pub samples: Option<u32>,
    /// How much the kernel keeps of what an iteration could take: from 0 (exclusive) to 1, where
    /// it does not shrink at all.
    pub alpha: f32,
    /// First radius of the kernel in scene units, greater than zero; by default what holds 25
    /// photons.
    pub radius: Option<f32>,
}

impl Default for Photons {
    fn default() -> Self {
        Self { per_iteration: None, samples: None, alpha: 2.0 / 3.0, radius: None }
    }
}

impl Photons {
    /// Light paths an iteration for a film of so many pixels.
    pub fn light_paths(&self, [width, height]: [u32; 2]) -> u32 {
        let [least, most] = LIGHT_PATHS;
        let pixels = u64::from(width) * u64::from(height);
        let balanced = (LIGHT_PATHS_PER_PIXEL * pixels).clamp(least, most);
        self.per_iteration.unwrap_or(balanced as u32)
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
    /// All modes.
    pub const ALL: [Self; 3] = [Self::Scalar, Self::Intensity, Self::Polarized];

    /// Stokes components on the film.
    pub fn components(self) -> usize {
        match self {
            Self::Scalar | Self::Intensity => 1,
            Self::Polarized => 4,
        }
    }

    /// What reports and the command line call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Intensity => "intensity",
            Self::Polarized => "polarized",
        }
    }
}

/// What to render, as it is asked for: [`Settings::new`] checks it.
///
/// ```
/// use sunstone::{Integrator, Options, Settings};
/// let settings = Settings::new(Options {
///     integrator: Some(Integrator::Path),
///     samples: 16,
///     ..Options::default()
/// })?;
/// assert_eq!(settings.samples, 16);
/// let error = Settings::new(Options { samples: 0, ..Options::default() }).unwrap_err();
/// assert!(error.to_string().starts_with("samples must be from 1 to"));
/// # Ok::<(), sunstone::SettingsError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// How light is found; by default what suits the scene ([`crate::Resolved`]).
    pub integrator: Option<Integrator>,
    /// Intensity or Stokes vectors.
    pub mode: Mode,
    /// What the channels stand for. Bands and responses go with [`Options::spectral`].
    pub color: Color,
    /// Light at wavelengths of a whole range instead of those that channels stand for.
    pub spectral: Option<Spectral>,
    /// The white under which red, green and blue of materials and lights have the color that they
    /// say, where channels stand for wavelengths; by default [`White::of`] the color.
    pub rgb_white: Option<White>,
    /// A light that the film shows as white: where spectra are seen in red, green and blue, with
    /// its luminance in all three; where channels have responses, each is 1 for this light and not
    /// for a flat spectrum. By default none.
    pub white_balance: Option<WhiteBalance>,
    /// Responses as they are given: a channel is the integral of radiance times these numbers.
    /// Otherwise each is normalized so that it is 1 for a spectrum of radiance 1 per nanometer.
    pub raw_response: bool,
    /// Whether what tables and formulas say at their ends is held beyond them, instead of the
    /// render being refused that asks for it. The image's metadata says of which, and over which
    /// wavelengths.
    pub hold_spectra: bool,
    /// Width of the film in pixels; by default that of the world's camera, or 512, or what follows
    /// from the height.
    pub width: Option<u32>,
    /// Height of the film in pixels; by default what follows from the width and the camera's
    /// aspect.
    pub height: Option<u32>,
    /// How light about a pixel counts for it; by default as the world's camera says, which is by
    /// the pixel's square if it says nothing.
    pub filter: Option<FilterKind>,
    /// Where that ends, in pixels, from 0.01 to 32; by default [`FilterKind::radius`], or what the
    /// camera says of its filter.
    pub filter_radius: Option<f32>,
    /// Which pixels samples count for, if that is wider than a pixel; by default all that it
    /// reaches, unless its lobes hardly cancel over pixels.
    pub filter_samples: Option<FilterSamples>,
    /// The part of the film that is rendered; by default what the camera says, or all of it. Its
    /// pixels have the bits that they have in the whole.
    pub crop: Option<Crop>,
    /// Width of a pixel over its height, from 0.01 to 100; by default what the camera says, or 1.
    pub pixel_aspect: Option<f32>,
    /// What the image holds of pixels besides their light, as the camera sees it first; nothing by
    /// default. Not of parts.
    pub layers: Vec<LayerKind>,
    /// Samples per pixel, at least one; with photons, a multiple of the samples of an iteration.
    pub samples: u32,
    /// Iterations in place of a number of samples: of one sample per pixel, or, with photons, of a
    /// pass of these with its samples.
    pub iterations: Option<u32>,
    /// Independent randomizations that the samples are split into, from 1 to their number (of
    /// iterations, with photons); variances come with two or more.
    pub replicates: u32,
    /// Variances of the image without replicates, from the spread of blocks of the one sequence
    /// that the samples are. That costs the image nothing. As blocks are stratified among each
    /// other too, which their spread does not show, the variance may be overestimated: by the gain
    /// of a whole sequence over blocks of a sixteenth of it.
    pub variance: bool,
    /// Most segments of a path, at least one: 1 shows emitters only, 2 adds direct light. By
    /// default [`PATH_LENGTH_MAX`], which keeps nothing but a render that would not end.
    pub path_length_max: u32,
    /// Path length from which on roulette may end a path; by default what has measured best: 5
    /// for sensor paths, or 3 by [`Integrator::Bdpt`], and 1 for light paths, of which each has
    /// less to do with its pixels.
    pub roulette_after: Option<u32>,
    /// What directions are drawn by where light is polarized.
    pub sampling: Sampling,
    /// Seed of all randomness.
    pub seed: u32,
    /// Photons, where they are used.
    pub photons: Photons,
    /// Whether the time of every stage is measured, which takes some hundredths more.
    pub stage_times: bool,
    /// Stop when this is over. Waves of samples are short then; photons of a first iteration are as
    /// many as there is time for, and a later one that would be late is left out.
    pub time_limit: Option<Duration>,
    /// Render this part of the image alone, of which each has some of the samples; by default, all.
    /// There are as many parts as iterations, at most, or as blocks where there are variances.
    pub part: Option<Part>,
}

impl Default for Options {
    /// 64 samples of polarized RGB by what suits the scene, of any number of segments.
    fn default() -> Self {
        Self {
            integrator: None,
            mode: Mode::Polarized,
            color: Color::Rgb,
            spectral: None,
            rgb_white: None,
            white_balance: None,
            raw_response: false,
            hold_spectra: false,
            width: None,
            height: None,
            filter: None,
            filter_radius: None,
            filter_samples: None,
            crop: None,
            pixel_aspect: None,
            layers: Vec::new(),
            samples: 64,
            iterations: None,
            replicates: 1,
            variance: false,
            path_length_max: PATH_LENGTH_MAX,
            roulette_after: None,
            sampling: Sampling::Stokes,
            seed: 0,
            photons: Photons::default(),
            stage_times: false,
            time_limit: None,
            part: None,
        }
    }
}

/// [`Options`] that have been checked: none is out of its range, where it would render nothing.
/// What an integrator cannot see in a world is another matter ([`crate::PlacedWorld::notes`]).
#[derive(Clone, Debug, PartialEq)]
pub struct Settings(Options);

impl Settings {
    /// Checks options, and normalizes responses of [`Options::color`] as they say.
    ///
    /// # Errors
    /// Names the first option that is out of its range, and the range.
    pub fn new(options: Options) -> Result<Self, SettingsError> {
        let &Options { width, height, samples, photons, .. } = &options;
        for (setting, edge) in [("width", width), ("height", height)] {
            edge.map_or(Ok(()), |edge| within(setting, edge, 1, EDGE_MAX))?;
        }
        let rule = |fault: Fault| SettingsError { setting: "filter_radius", rule: fault.problem };
        let radius = |radius| Filter { radius, ..Filter::PIXEL }.check();
        options.filter_radius.map_or(Ok(()), radius).map_err(rule)?;
        let rule = |fault: Fault| SettingsError { setting: "pixel_aspect", rule: fault.problem };
        options.pixel_aspect.map_or(Ok(()), check_pixel_aspect).map_err(rule)?;
        within("samples", samples, 1, SAMPLES_MAX)?;
        let of_iteration = if options.may_shoot_photons() {
            check_photons(&photons)?;
            options.samples_of_photons()
        } else {
            1
        };
        within("path_length_max", options.path_length_max, 1, PATH_LENGTH_MAX)?;
        check_color(&options.color)?;
        columns(&options)?;
        check_white(&options)?;
        let options = Options { color: measured(&options)?, ..options };
        responses(&options)?;
        if let Some(count) = options.iterations {
            within("iterations", count, 1, SAMPLES_MAX / of_iteration)?;
        } else if !samples.is_multiple_of(of_iteration) {
            let rule = format!(
                "must be a multiple of the {of_iteration} samples of an iteration of photons, not \
                 {samples}"
            );
            return Err(SettingsError { setting: "samples", rule });
        }
        let iterations = options.iterations.unwrap_or(samples / of_iteration);
        within("replicates", options.replicates, 1, iterations)?;
        if options.part.is_some() && options.time_limit.is_some() {
            let rule = "goes without a time limit, as all samples of a part are needed".to_owned();
            return Err(SettingsError { setting: "part", rule });
        }
        check_layers(&options)?;
        Ok(Self(options))
    }

    /// The options, to be changed and checked again.
    pub fn options(&self) -> Options {
        self.0.clone()
    }

    /// What light is carried at.
    pub(super) fn columns(&self) -> Columns {
        columns(&self.0).expect("settings are checked")
    }

    /// How the channels respond to the wavelengths of a spectral render.
    pub(super) fn responses(&self) -> Option<Responses> {
        responses(&self.0).expect("settings are checked")
    }
}

impl Options {
    /// Whether the image comes with variances.
    pub fn has_variance(&self) -> bool {
        self.variance || self.replicates > 1
    }

    /// The white under which red, green and blue have the color that they say.
    pub fn white(&self) -> White {
        self.rgb_white.unwrap_or(White::of(&self.color))
    }

    /// What tables and formulas say beyond their ends.
    pub fn beyond(&self) -> Beyond {
        if self.hold_spectra { Beyond::Held } else { Beyond::Refused }
    }

    /// What was asked for, by name.
    pub fn integrator_name(&self) -> &'static str {
        self.integrator.map_or(AUTO, Integrator::name)
    }

    /// Whether photons are shot whatever the scene.
    pub fn shoots_photons(&self) -> bool {
        self.integrator.is_some_and(Integrator::shoots_photons)
    }

    /// Whether photons may be shot, in some scene or other.
    fn may_shoot_photons(&self) -> bool {
        self.integrator.is_none_or(Integrator::shoots_photons)
    }

    /// Samples per pixel for every iteration of photons: as given, else the most up to
    /// [`SAMPLES_OF_PHOTONS`] that leave replicates, and blocks of variances, an iteration each.
    pub fn samples_of_photons(&self) -> u32 {
        if let Some(samples) = self.photons.samples {
            return samples;
        }
        let least = if self.variance { self.replicates.max(2) } else { self.replicates };
        let fits = |of_iteration: &u32| {
            self.iterations.is_some()
                || self.samples.is_multiple_of(*of_iteration)
                    && self.samples / of_iteration >= least
        };
        (1..=SAMPLES_OF_PHOTONS).rev().find(fits).unwrap_or(1)
    }

    /// Samples per pixel of an iteration by an integrator: those of a pass of photons, or one.
    pub fn samples_per_iteration(&self, integrator: Integrator) -> u32 {
        if integrator.shoots_photons() { self.samples_of_photons() } else { 1 }
    }

    /// Samples per pixel in all, by an integrator.
    pub fn samples_by(&self, integrator: Integrator) -> u32 {
        let of_iteration = self.samples_per_iteration(integrator);
        self.iterations.map_or(self.samples, |count| count * of_iteration)
    }
}

impl Deref for Settings {
    type Target = Options;
    fn deref(&self) -> &Options {
        &self.0
    }
}

/// A setting that is out of its range.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{setting} {rule}")]
pub struct SettingsError {
    /// What the command line calls the option, with `_` for `-`: mostly the field of [`Options`] or
    /// [`Photons`].
    pub setting: &'static str,
    /// What must hold, and what is the case.
    pub rule: String,
}

/// Checks that a number is within a range.
pub fn within<T: PartialOrd + Display>(
    setting: &'static str,
    value: T,
    least: T,
    most: T,
) -> Result<(), SettingsError> {
    if least <= value && value <= most {
        return Ok(());
    }
    Err(SettingsError { setting, rule: format!("must be from {least} to {most}, not {value}") })
}

/// Refuses layers twice, and those of parts: whoever merges these has no scene.
fn check_layers(options: &Options) -> Result<(), SettingsError> {
    let refuse = |rule: String| Err(SettingsError { setting: "layers", rule });
    if options.part.is_some() && !options.layers.is_empty() {
        let rule = "go without a part: render them apart, with one sample";
        return refuse(rule.to_owned());
    }
    let is_twice = |(index, kind): (usize, &LayerKind)| options.layers[..index].contains(kind);
    match options.layers.iter().enumerate().any(is_twice) {
        true => refuse("must be different ones".to_owned()),
        false => Ok(()),
    }
}

/// Checks that there is light of a color.
pub fn check_color(color: &Color) -> Result<(), SettingsError> {
    match color {
        Color::Mono { wavelength_nm } if !WAVELENGTHS_NM.contains(wavelength_nm) => {
            let (least, most) = (WAVELENGTHS_NM.start(), WAVELENGTHS_NM.end());
            let rule = format!("must be from {least} to {most} nanometers, not {wavelength_nm}");
            Err(SettingsError { setting: "wavelength", rule })
        }
        Color::Mono { .. } | Color::Rgb | Color::Bands(_) | Color::Responses(_) => Ok(()),
    }
}

/// Checks that a white means something for a color, and is known there.
fn check_white(options: &Options) -> Result<(), SettingsError> {
    let Some(white) = options.rgb_white else { return Ok(()) };
    let ends = match (options.spectral, &options.color) {
        (Some(spectral), _) => spectral.range_nm,
        (None, Color::Mono { wavelength_nm }) => [*wavelength_nm; 2],
        (None, Color::Rgb | Color::Bands(_) | Color::Responses(_)) => {
            let rule = "goes with light at wavelengths: in RGB, red, green and blue are what they \
                        are";
            return Err(SettingsError { setting: "rgb_white", rule: rule.to_owned() });
        }
    };
    let [least, most] = white.known_nm();
    let is_outside = |nm: &f32| !(least..=most).contains(&f64::from(*nm));
    let Some(nm) = ends.into_iter().find(is_outside) else { return Ok(()) };
    let name = white.name();
    let rule = format!("{name} is known from {least} to {most} nanometers, not at {nm}");
    Err(SettingsError { setting: "rgb_white", rule })
}

/// Checks how photons are to be shot.
pub fn check_photons(photons: &Photons) -> Result<(), SettingsError> {
    let &Photons { per_iteration, samples, alpha, radius } = photons;
    within("photons", per_iteration.unwrap_or(1), 1, PHOTONS_MAX)?;
    within("samples_per_iteration", samples.unwrap_or(1), 1, SAMPLES_MAX)?;
    if !(alpha > 0.0 && alpha <= 1.0) {
        let rule = format!("must be greater than 0 and at most 1, not {alpha}");
        return Err(SettingsError { setting: "alpha", rule });
    }
    match radius {
        Some(radius) if !(radius > 0.0 && radius.is_finite()) => {
            let rule = format!("must be a length greater than 0, not {radius}");
            Err(SettingsError { setting: "radius", rule })
        }
        _ => Ok(()),
    }
}

/// Refuses a film that could not be counted or stored.
pub fn check_film(width: u32, height: u32) -> Result<(), SettingsError> {
    within("width", width, 1, EDGE_MAX)?;
    within("height", height, 1, EDGE_MAX)?;
    let pixels = u64::from(width) * u64::from(height);
    if pixels > PIXELS_MAX {
        let rule =
            format!("{width} x {height} is too large: a film has {PIXELS_MAX} pixels at most");
        return Err(SettingsError { setting: "width", rule });
    }
    Ok(())
}
