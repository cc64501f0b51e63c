//! Materials: how surfaces scatter light, and whether they emit it.

use crate::math::{Fault, Range};
use crate::scene::error::SceneError;
use crate::spectrum::{Spectrum, metal, metal_names};

/// How a material scatters light.
#[derive(Clone, Debug, PartialEq)]
pub enum Bsdf {
    /// Absorbs everything.
    Absorber,
    /// Lambertian.
    Diffuse {
        /// Directional-hemispherical reflectance, within [0, 1].
        reflectance: Spectrum,
    },
    /// Smooth metal of index n - i k.
    Conductor {
        /// Real part n > 0 of the index of refraction.
        eta: Spectrum,
        /// Extinction coefficient k >= 0.
        k: Spectrum,
    },
    /// Smooth boundary between two dielectrics.
    Dielectric {
        /// Index of refraction behind the front, greater than zero.
        ior: f32,
        /// Index of refraction before the front, greater than zero; 1 in vacuum.
        exterior_ior: f32,
    },
    /// Sheet polarizer.
    Polarizer {
        /// Transmission axis from the node's x axis, counter-clockwise about the front's normal.
        axis_deg: f64,
        /// Greatest over least transmittance, at least 1; infinite for an ideal polarizer.
        extinction_ratio: f64,
    },
    /// Linear retarder.
    Retarder {
        /// Fast axis from the node's x axis, counter-clockwise about the front's normal.
        axis_deg: f64,
        /// Retardance in degrees.
        retardance_deg: f64,
    },
    /// Nothing but a boundary between media of the same index of refraction.
    Null,
}

impl Bsdf {
    /// A Lambertian reflector: a number, or red, green and blue, within [0, 1].
    pub fn diffuse(reflectance: impl Into<Spectrum>) -> Self {
        Self::Diffuse { reflectance: reflectance.into() }
    }

    /// A smooth metal, by its chemical symbol.
    ///
    /// # Errors
    /// When it is not tabulated; the error lists those that are.
    pub fn metal(symbol: &str) -> Result<Self, SceneError> {
        Self::tabulated(symbol).map_err(|fault| SceneError::at("material", fault))
    }

    /// A smooth boundary to a dielectric of an index of refraction, in vacuum.
    pub fn dielectric(ior: f32) -> Self {
        Self::Dielectric { ior, exterior_ior: 1.0 }
    }

    /// An ideal sheet polarizer; see [`Bsdf::Polarizer`].
    pub fn polarizer(axis_deg: f64) -> Self {
        Self::Polarizer { axis_deg, extinction_ratio: f64::INFINITY }
    }

    /// A linear retarder; see [`Bsdf::Retarder`].
    pub fn retarder(axis_deg: f64, retardance_deg: f64) -> Self {
        Self::Retarder { axis_deg, retardance_deg }
    }

    /// The metal of a name; the field of the fault is `metal`.
    pub(crate) fn tabulated(symbol: &str) -> Result<Self, Fault> {
        match metal(symbol) {
            Some((eta, k)) => Ok(Self::Conductor { eta, k }),
            None => {
                let names: Vec<&str> = metal_names().collect();
                let problem = format!("`{symbol}` is not tabulated");
                let remedy = format!("use one of {}, or give `eta` and `k`", names.join(", "));
                Err(Fault::new("metal", problem, remedy))
            }
        }
    }

    /// Whether light passes through to the other side.
    pub fn transmits(&self) -> bool {
        match self {
            Self::Absorber | Self::Diffuse { .. } | Self::Conductor { .. } => false,
            Self::Dielectric { .. }
            | Self::Polarizer { .. }
            | Self::Retarder { .. }
            | Self::Null => true,
        }
    }

    /// Refuses what no surface does.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        match self {
            Self::Absorber | Self::Null => Ok(()),
            Self::Diffuse { reflectance } => reflectance.check("reflectance", Range::UNIT),
            Self::Conductor { eta, k } => {
                eta.check("eta", Range::POSITIVE)?;
                k.check("k", Range::NOT_NEGATIVE)
            }
            Self::Dielectric { ior, exterior_ior } => {
                Range::POSITIVE.check("ior", *ior)?;
                Range::POSITIVE.check("exterior_ior", *exterior_ior)?;
                Range::POSITIVE.check("ior over exterior_ior", ior / exterior_ior)
            }
            Self::Polarizer { axis_deg, extinction_ratio } => {
                Range::ANY.check("axis_deg", *axis_deg)?;
                if *extinction_ratio == f64::INFINITY {
                    return Ok(());
                }
                Range::AT_LEAST_ONE.check("extinction_ratio", *extinction_ratio)
            }
            Self::Retarder { axis_deg, retardance_deg } => {
                Range::ANY.check("axis_deg", *axis_deg)?;
                Range::ANY.check("retardance_deg", *retardance_deg)
            }
        }
    }
}

/// Which sides of a material's surfaces reflect and emit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sides {
    /// Back like front; otherwise the back is black and dark.
    pub two_sided: bool,
}

/// Light that leaves a material's surfaces, the same in all directions, unpolarized.
#[derive(Clone, Debug, PartialEq)]
pub struct Emission {
    /// Radiance in W/(m^2 sr); not negative. Zero throughout emits nothing.
    pub radiance: Spectrum,
}

impl Emission {
    /// Refuses what cannot be emitted.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        self.radiance.check("radiance", Range::NOT_NEGATIVE)
    }
}

/// What [`World::add_material`](super::World::add_material) makes a material of: the components
/// of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// How it scatters light.
    pub bsdf: Bsdf,
    /// Which sides do.
    pub sides: Sides,
    /// What it emits.
    pub emission: Option<Emission>,
}

impl Material {
    /// Absorbs everything and emits a radiance in W/(m^2 sr).
    pub fn emitter(radiance: impl Into<Spectrum>) -> Self {
        Self::from(Bsdf::Absorber).emitting(radiance)
    }

    /// The same material, which emits a radiance in W/(m^2 sr) too.
    #[must_use]
    pub fn emitting(self, radiance: impl Into<Spectrum>) -> Self {
        Self { emission: Some(Emission { radiance: radiance.into() }), ..self }
    }

    /// The same material, whose back is like its front.
    #[must_use]
    pub fn two_sided(self) -> Self {
        Self { sides: Sides { two_sided: true }, ..self }
    }
}

/// One-sided, and it does not emit.
impl From<Bsdf> for Material {
    fn from(bsdf: Bsdf) -> Self {
        Self { bsdf, sides: Sides::default(), emission: None }
    }
}

/// Refuses components of a material that are wrong, or do not go together.
pub(super) fn check_material(bsdf: &Bsdf, emission: Option<&Emission>) -> Result<(), Fault> {
    bsdf.check()?;
    let Some(emission) = emission else { return Ok(()) };
    emission.check()?;
    if *bsdf == Bsdf::Null {
        let problem = "a null surface is not there, so it cannot emit";
        return Err(Fault::new("", problem, "remove its emission, or use an absorber"));
    }
    Ok(())
}
