//! Plastics: what is said of their bases.

use crate::math::{Fault, Range};
use crate::polarization::Distribution;
use crate::spectrum::Spectrum;

use super::layers::COAT_IOR;
use super::material::{Bsdf, check_indices};

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

/// The interface over the base of [`Bsdf::Plastic`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    /// Index of refraction within, at least that outside and at most ten times it.
    pub ior: f32,
    /// Index of refraction outside, greater than zero; 1 in vacuum.
    pub exterior_ior: f32,
    /// Roughness of the facets, within [0, 1]; see [`Bsdf::RoughConductor`]. At least 0.001 is
    /// computed with.
    pub alpha: f32,
    /// How the normals of facets are distributed.
    pub distribution: Distribution,
    /// Share of what the facets would reflect that is there, within [0, 1].
    pub specular: f32,
    /// What becomes of light that the interface reflects within.
    pub internal_reflection: InternalReflection,
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

impl Coat {
    /// Refuses what is out of range.
    pub(super) fn check(&self) -> Result<(), Fault> {
        let Self { ior, exterior_ior, alpha, specular, .. } = self;
        let [within, outside] = [*ior, *exterior_ior].map(Spectrum::Constant);
        check_indices(&within, &outside)?;
        COAT_IOR.check("ior over exterior_ior", ior / exterior_ior)?;
        Range::UNIT.check("alpha", *alpha)?;
        Range::UNIT.check("specular", *specular)
    }
}

impl Bsdf {
    /// A plastic of a reflectance of the base (a number, or red, green and blue, within [0, 1]),
    /// with facets (GGX) of some roughness and the index of refraction 1.5, in vacuum; see
    /// [`Bsdf::Plastic`].
    pub fn plastic(reflectance: impl Into<Spectrum>, alpha: f32) -> Self {
        Self::Plastic {
            reflectance: reflectance.into(),
            coat: Coat {
                ior: 1.5,
                exterior_ior: 1.0,
                alpha,
                distribution: Distribution::default(),
                specular: 1.0,
                internal_reflection: InternalReflection::default(),
            },
        }
    }
}
