//! What a camera of polarization records: raw images of a sensor with an analyzer before every
//! pixel (division of focal plane).
//!
//! Pixels come in squares of four, behind linear analyzers at 90 and 45, 135 and 0 degrees, as on
//! Sony's IMX250MZR; on color sensors (IMX250MYR) the squares in turn are the red, green, green and
//! blue cells of a Bayer mosaic:
//!
//! ```text
//!     90  45                 R R G G
//!    135   0                 R R G G
//!                            G G B B
//!                            G G B B
//! ```
//!
//! The value of a pixel, from light to number: what passes its analyzer, times two to the power of
//! the exposure, is a share of the full well; electrons are drawn (Poisson) and cut off at the full
//! well; the noise of reading them out is added (normal); a gain makes them numbers, a black level
//! is added, and the sum is rounded and cut off at 0 and at the largest number.

use std::fmt;
use std::path::Path;

use rand_distr::{Distribution, Poisson, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

use super::analyzed::check_stokes;
use super::error::OutputError;
use super::png;
use super::visualize::stokes_at;
use crate::image::StokesImage;
use crate::math::elementary::exp2;
use crate::math::{Fault, Range};
use crate::polarization::Analyzer;
use crate::spectrum::Color;

/// Axes of the analyzers before a square of pixels: `[line][column]`, in degrees counterclockwise
/// from the right of the image.
pub const AXES_DEG: [[f64; 2]; 2] = [[90.0, 45.0], [135.0, 0.0]];
/// Channels of a Bayer cell: `[line][column]`.
const BAYER: [[usize; 2]; 2] = [[0, 1], [1, 2]];

/// What a pixel may hold, in electrons.
const FULL_WELL: Range = Range::new("from 1 to 1e12", |x| (1.0..=1e12).contains(&x));

/// What lies before the pixels besides analyzers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filters {
    /// Nothing; of an RGB image they see the luminance, of bands and responses their mean.
    Mono,
    /// Red, green and blue filters, which let the image's channels pass.
    Bayer,
}

impl Filters {
    /// Those that show an image of these channels whole.
    pub fn of(color: &Color) -> Self {
        match color {
            Color::Rgb => Self::Bayer,
            Color::Mono { .. } | Color::Bands(_) | Color::Responses(_) => Self::Mono,
        }
    }

    /// Pixels along an edge of the pattern that repeats.
    pub fn period(self) -> usize {
        match self {
            Self::Mono => 2,
            Self::Bayer => 4,
        }
    }
}

/// A sensor with analyzers, and how it is read out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolarizationSensor {
    /// What lies before its pixels.
    pub filters: Filters,
    /// Bits of its numbers: 8, 12 or 16.
    pub bits: u32,
    /// What passes an analyzer is multiplied by two to this power; then 1 fills the well.
    pub exposure_ev: f32,
    /// Added to every number; less than the largest.
    pub black_level: u32,
    /// What its electrons are, if it is not without noise.
    pub electrons: Option<Electrons>,
    /// Of the noise: the same for the same sensor and image.
    pub seed: u32,
}

impl PolarizationSensor {
    /// One without noise, whose full well is the largest of its numbers.
    pub fn ideal(filters: Filters, bits: u32) -> Self {
        Self { filters, bits, exposure_ev: 0.0, black_level: 0, electrons: None, seed: 0 }
    }
}

/// What makes noise: that light comes in photons, each an electron, and that reading them is not
/// exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Electrons {
    /// The most that a pixel holds, from 1 to 1e12.
    pub full_well: f64,
    /// Numbers for an electron, greater than 0; if not given, such that the full well is the
    /// largest number.
    pub gain: Option<f64>,
    /// Standard deviation of the electrons that are read, in electrons; not negative.
    pub read_noise: f64,
}

impl Electrons {
    /// Noise of light alone.
    pub fn of_full_well(full_well: f64) -> Self {
        Self { full_well, gain: None, read_noise: 0.0 }
    }
}

/// What a sensor has recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RawImage {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Bits of the numbers: 8, 12 or 16.
    pub bits: u32,
    /// A number for every pixel, from 0 to two to the power of the bits, less one; rows from the
    /// top, pixels from the left.
    pub values: Vec<u16>,
    /// The sensor in words.
    pub description: String,
}

impl RawImage {
    /// Writes a gray PNG of 8 bits, or of 16, in which numbers of 12 bits are the lower ones.
    ///
    /// # Errors
    /// When the file cannot be written; nothing is left half-way.
    pub fn save(&self, path: &Path) -> Result<(), OutputError> {
        png::write_raw(self, path)
    }
}

impl PolarizationSensor {
    /// Refuses what no sensor is.
    pub fn check(&self) -> Result<(), Fault> {
        if !matches!(self.bits, 8 | 12 | 16) {
            let problem = format!("{} must be 8, 12 or 16", self.bits);
            return Err(Fault::new("bits", problem, ""));
        }
        Range::ANY.check("exposure", self.exposure_ev)?;
        if self.black_level >= self.largest() {
            let problem = format!("{} must be less than {}", self.black_level, self.largest());
            return Err(Fault::new("black_level", problem, "the largest number of so many bits"));
        }
        let Some(Electrons { full_well, gain, read_noise }) = self.electrons else { return Ok(()) };
        FULL_WELL.check("full_well", full_well)?;
        gain.map_or(Ok(()), |gain| Range::POSITIVE.check("gain", gain))?;
        Range::NOT_NEGATIVE.check("read_noise", read_noise)
    }

    /// What it records of an image, pixel by pixel.
    ///
    /// # Errors
    /// When something of it is out of range; the image holds intensity alone, has no colors for its
    /// filters, or sides that are no multiples of [`Filters::period`].
    pub fn record(&self, image: &StokesImage) -> Result<RawImage, OutputError> {
        self.check().map_err(OutputError::Sensor)?;
        check_stokes(image)?;
        self.check_fit(image)?;
        let (width, height, bits) = (image.width, image.height, self.bits);
        let values = (0..width * height).map(|pixel| {
            let (x, y) = (pixel % width, pixel / width);
            let analyzer = Analyzer::Linear { axis_deg: AXES_DEG[y % 2][x % 2] };
            let stokes = match self.filters {
                Filters::Mono => stokes_at(image, pixel),
                Filters::Bayer => {
                    let channel = BAYER[y / 2 % 2][x / 2 % 2];
                    [0, 1, 2, 3].map(|component| image.plane(component, channel)[pixel])
                }
            };
            let light = f64::from(analyzer.passed(stokes)) * exp2(f64::from(self.exposure_ev));
            self.number(light, pixel)
        });
        let description = self.to_string();
        Ok(RawImage { width, height, bits, values: values.collect(), description })
    }

    fn check_fit(&self, image: &StokesImage) -> Result<(), OutputError> {
        let period = self.filters.period();
        let fits = image.width.is_multiple_of(period) && image.height.is_multiple_of(period);
        let reason = match (self.filters, &image.color) {
            (Filters::Bayer, Color::Mono { .. }) => {
                "it has one wavelength, and a color mosaic needs RGB; take a mono sensor"
            }
            (Filters::Bayer, Color::Bands(_)) => {
                "it has bands, and a color mosaic needs RGB; take a mono sensor"
            }
            (Filters::Bayer, Color::Responses(_)) => {
                "it has responses of its own, and a color mosaic needs RGB; take a mono sensor"
            }
            (Filters::Bayer, Color::Rgb) if !fits => {
                "a color mosaic has sides that are multiples of 4 pixels; render it in such a size"
            }
            (Filters::Mono, _) if !fits => {
                "a mosaic has sides that are multiples of 2 pixels; render it in such a size"
            }
            (Filters::Bayer, Color::Rgb) | (Filters::Mono, _) => return Ok(()),
        };
        Err(OutputError::Image { reason })
    }

    /// The largest number.
    fn largest(&self) -> u32 {
        (1 << self.bits) - 1
    }

    /// What a pixel says of light that is so much of its full well.
    fn number(&self, light: f64, pixel: usize) -> u16 {
        // What is not a number is dark, too.
        let light = light.max(0.0);
        let room = f64::from(self.largest() - self.black_level);
        let signal = match self.electrons {
            None => room * light.min(1.0),
            Some(electrons) => {
                let gain = electrons.gain.unwrap_or(room / electrons.full_well);
                gain * electrons.read(light, noise(self.seed, pixel))
            }
        };
        let number = (f64::from(self.black_level) + signal).round();
        number.clamp(0.0, f64::from(self.largest())) as u16
    }
}

/// Random numbers of a pixel alone, so that no other pixel's light changes its noise.
fn noise(seed: u32, pixel: usize) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64((u64::from(seed) << 32) ^ pixel as u64)
}

impl Electrons {
    /// Electrons that are read where light would fill so much of the well.
    fn read(&self, light: f64, mut noise: Pcg64Mcg) -> f64 {
        let mean = light * self.full_well;
        let held = match Poisson::new(mean) {
            Ok(arriving) => arriving.sample(&mut noise).min(self.full_well),
            // No light, or more than can be counted.
            Err(_) if mean > 0.0 => self.full_well,
            Err(_) => 0.0,
        };
        let deviation: f64 = StandardNormal.sample(&mut noise);
        held + self.read_noise * deviation
    }
}

/// The sensor in words, of one line.
impl fmt::Display for PolarizationSensor {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [[a, b], [c, d]] = AXES_DEG;
        let filters = match self.filters {
            Filters::Mono => "",
            Filters::Bayer => ", RGGB of such squares",
        };
        write!(
            f,
            "linear analyzers [[{a}, {b}], [{c}, {d}]] degrees{filters}; {} bits",
            self.bits
        )?;
        write!(f, ", black level {}, exposure {} EV", self.black_level, self.exposure_ev)?;
        let Some(Electrons { full_well, gain, read_noise }) = self.electrons else {
            return write!(f, ", no noise");
        };
        write!(f, ", full well {full_well} electrons, read noise {read_noise} electrons")?;
        if let Some(gain) = gain {
            write!(f, ", gain {gain} per electron")?;
        }
        write!(f, ", seed {}", self.seed)
    }
}
