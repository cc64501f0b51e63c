//! Participating media: their coefficients and how they scatter.

use super::particles::Spheres;
use super::phase_matrix::{TabulatedMatrix, check_matrices};
use crate::math::{Fault, Range};
use crate::polarization::milk::Milk;
use crate::spectrum::Spectrum;

/// Most media that a scene may have.
pub(crate) const MEDIA_MAX: usize = 4096;

const MEAN_COSINE: Range = Range::new("within (-1, 1)", |x| (x as f32).abs() < 1.0);
const HALF: Range = Range::new("within [0, 0.5]", |x| (0.0..=0.5).contains(&x));

/// Marks the medium that fills the scene outside all boundaries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FillsScene;

/// A homogeneous participating medium.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium {
    /// Absorption coefficient in 1/m, not negative; none if it follows from the particles.
    pub sigma_a: Option<Spectrum>,
    /// Scattering coefficient in 1/m, not negative; none if it follows from the particles.
    pub sigma_s: Option<Spectrum>,
    /// How it scatters.
    pub phase: Phase,
}

impl Medium {
    /// A medium of given coefficients in 1/m: absorption, scattering.
    pub fn new(sigma_a: impl Into<Spectrum>, sigma_s: impl Into<Spectrum>, phase: Phase) -> Self {
        Self { sigma_a: Some(sigma_a.into()), sigma_s: Some(sigma_s.into()), phase }
    }

    /// Refuses what no medium does.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        self.phase.check()?;
        for (field, sigma) in [("sigma_a", &self.sigma_a), ("sigma_s", &self.sigma_s)] {
            match sigma {
                Some(sigma) => sigma.check(field, Range::NOT_NEGATIVE)?,
                None if self.phase.brings_coefficients() => {}
                None => {
                    let remedy = "give sigma_a and sigma_s, in 1/m";
                    return Err(Fault::new(field, "is missing", remedy));
                }
            }
        }
        Ok(())
    }
}

/// The coefficients follow from the particles; only spheres and milk have these.
impl From<Phase> for Medium {
    fn from(phase: Phase) -> Self {
        Self { sigma_a: None, sigma_s: None, phase }
    }
}

/// A phase function, or what it follows from.
#[derive(Clone, Debug, PartialEq)]
pub enum Phase {
    /// Henyey and Greenstein 1941, an ideal depolarizer.
    HenyeyGreenstein {
        /// Mean cosine of the scattering angle, within (-1, 1); 0 is isotropic.
        g: Spectrum,
    },
    /// Particles much smaller than the wavelength.
    Rayleigh {
        /// Ratio of the two intensities scattered at 90 degrees from unpolarized light, 0 to 1/2.
        depolarization: f64,
    },
    /// Spheres in a host, by the theory of Lorenz and Mie.
    Spheres(Spheres),
    /// Fat and casein in water, likewise.
    Milk(Milk),
    /// Phase matrices at increasing wavelengths; one alone holds for all wavelengths.
    Table(Vec<TabulatedMatrix>),
}

impl Phase {
    /// The same in all directions; an ideal depolarizer.
    pub fn isotropic() -> Self {
        Self::HenyeyGreenstein { g: Spectrum::Constant(0.0) }
    }

    /// Whether absorption and scattering coefficients follow from it.
    fn brings_coefficients(&self) -> bool {
        match self {
            Self::HenyeyGreenstein { .. } | Self::Rayleigh { .. } | Self::Table(_) => false,
            Self::Spheres(_) | Self::Milk(_) => true,
        }
    }

    /// Refuses what is no phase function.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        match self {
            Self::HenyeyGreenstein { g } => g.check("g", MEAN_COSINE),
            Self::Rayleigh { depolarization } => HALF.check("depolarization", *depolarization),
            Self::Spheres(spheres) => spheres.check(),
            Self::Milk(milk) => milk.check(),
            Self::Table(matrices) => check_matrices(matrices),
        }
    }
}
