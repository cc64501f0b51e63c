//! Lights without a surface: punctual ones and the environment.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use glam::Vec3;

use super::Photometry;

use crate::math::{Fault, Range};
use crate::spectrum::Spectrum;

/// A light without extent, along the -z axis of its transform.
#[derive(Clone, Debug, PartialEq)]
pub struct Punctual {
    /// Its shape.
    pub kind: PunctualKind,
    /// Radiant intensity in W/sr, or irradiance in W/m^2 if directional; not negative. Zero
    /// throughout emits nothing.
    pub intensity: Spectrum,
}

/// What a point emits by direction: that of the measurement times its own intensity. The axis from
/// which vertical angles are measured is the -z axis of its transform; horizontal ones turn
/// counter-clockwise about z from its x axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Luminaire(pub Arc<Photometry>);

/// Shapes of punctual lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PunctualKind {
    /// The same in all directions.
    Point,
    /// A cone.
    Spot {
        /// Half angle of full intensity in radians, at least 0.
        inner: f64,
        /// Half angle of the whole cone in radians, greater than 0, at most pi/2, not less than
        /// `inner`.
        outer: f64,
    },
    /// Infinitely far away.
    Directional,
}

impl Punctual {
    /// The same radiant intensity in W/sr in all directions.
    pub fn point(intensity: impl Into<Spectrum>) -> Self {
        Self { kind: PunctualKind::Point, intensity: intensity.into() }
    }

    /// A cone: radiant intensity on its axis in W/sr, half angles of full intensity and of the
    /// whole in radians.
    pub fn spot(intensity: impl Into<Spectrum>, inner: f64, outer: f64) -> Self {
        Self { kind: PunctualKind::Spot { inner, outer }, intensity: intensity.into() }
    }

    /// Parallel light: irradiance in W/m^2 on a plane that faces it.
    pub fn directional(irradiance: impl Into<Spectrum>) -> Self {
        Self { kind: PunctualKind::Directional, intensity: irradiance.into() }
    }

    /// Refuses what cannot shine.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        self.kind.check()?;
        self.intensity.check("intensity", Range::NOT_NEGATIVE)
    }
}

impl Luminaire {
    /// Refuses lights of another kind than points.
    pub(super) fn check(kind: Option<PunctualKind>) -> Result<(), Fault> {
        match kind {
            Some(PunctualKind::Point) => Ok(()),
            Some(PunctualKind::Spot { .. } | PunctualKind::Directional) | None => {
                let problem = "is what points emit, and this is none";
                Err(Fault::new("ies", problem, "make the light a point"))
            }
        }
    }
}

impl PunctualKind {
    fn check(&self) -> Result<(), Fault> {
        match *self {
            Self::Point | Self::Directional => Ok(()),
            // Blender writes equal angles for a spot without soft edge, so that is fine.
            Self::Spot { inner, outer }
                if inner >= 0.0 && inner <= outer && outer > 0.0 && outer <= FRAC_PI_2 =>
            {
                Ok(())
            }
            Self::Spot { inner, outer } => {
                let problem = format!("the inner angle {inner} and the outer {outer} do not fit");
                Err(Fault::new("spot", problem, "radians, 0 <= inner <= outer <= pi/2"))
            }
        }
    }
}

/// Radiance from all directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Its mean in W/(m^2 sr); not negative. Zero throughout emits nothing.
    pub radiance: Spectrum,
    /// A vector in world space, of length 1 at most: from the direction d comes the mean times
    /// 1 + d . gradient.
    pub gradient: Vec3,
}

impl Environment {
    /// Refuses what cannot shine.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        self.radiance.check("radiance", Range::NOT_NEGATIVE)?;
        let length = self.gradient.length();
        if length <= 1.0 + GRADIENT_TOLERANCE {
            return Ok(());
        }
        let problem = format!("its length must be at most 1, not {length}");
        Err(Fault::new("gradient", problem, "no sky is darker than black"))
    }
}

/// How much longer than 1 a gradient may come out of rounding.
const GRADIENT_TOLERANCE: f32 = 1e-5;
