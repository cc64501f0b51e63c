//! Plastics: what is said of their bases.

use crate::polarization::Distribution;
use crate::spectrum::Spectrum;

use super::material::Bsdf;

/// What becomes of light that leaves the base of [`Bsdf::Plastic`] and is reflected back to
/// it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InternalReflection {
    /// It is lost, as in the model of Baek et al. 2018.
    Lost,
    /// The base reflects all of it, whatever its color: what gets out is the reflectance's part of
    /// all that got in.
    Linear,
    /// The base reflects it like what came first: strong colors become stronger.
    #[default]
    Nonlinear,
}

impl InternalReflection {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Lost, Self::Linear, Self::Nonlinear];

    /// The one of a name in files.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|of| of.name() == name)
    }

    /// What it is called in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lost => "lost",
            Self::Linear => "linear",
            Self::Nonlinear => "nonlinear",
        }
    }
}

impl Bsdf {
    /// A plastic of a reflectance of the base (a number, or red, green and blue, within [0, 1]),
    /// with facets (GGX) of some roughness and the index of refraction 1.5, in vacuum; see
    /// [`Bsdf::Plastic`].
    pub fn plastic(reflectance: impl Into<Spectrum>, alpha: f32) -> Self {
        Self::Plastic {
            reflectance: reflectance.into(),
            ior: 1.5,
            exterior_ior: 1.0,
            alpha,
            distribution: Distribution::default(),
            specular: 1.0,
            internal_reflection: InternalReflection::default(),
        }
    }
}
