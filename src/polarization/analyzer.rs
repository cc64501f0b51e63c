//! Ideal analyzers: what lets one state of polarization pass and stops the opposite one.

use std::fmt;

use super::elements::exact_sin_cos_deg;
use super::stokes::Stokes;
use crate::math::{Fault, Range};

/// An ideal analyzer, in the frame `(x, y, k)` of the light that it is held into.
///
/// With `p` the Stokes vector of intensity one that passes whole, its Mueller matrix is
/// `p p^T / 2`: of rank one. What lies behind it measures one number, `p^T S / 2`, and all four
/// Stokes components are that number times those of `p`.
///
/// ```
/// use sunstone::Analyzer;
///
/// // Malus: of light polarized along x, a quarter is left at 60 degrees.
/// let passed = Analyzer::Linear { axis_deg: 60.0 }.passed([1.0, 1.0, 0.0, 0.0]);
/// assert!((passed - 0.25).abs() < 1e-7);
/// assert_eq!(Analyzer::LeftCircular.passed([1.0, 0.0, 0.0, 1.0]), 0.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Analyzer {
    /// Passes light that is polarized linearly.
    Linear {
        /// Along this axis: degrees from x towards y, any finite number. On a film that is
        /// counterclockwise from the right of the image.
        axis_deg: f64,
    },
    /// Passes right circular light (S3 > 0).
    RightCircular,
    /// Passes left circular light.
    LeftCircular,
}

impl Analyzer {
    /// The light of intensity one that passes whole.
    pub fn state(self) -> Stokes<f64> {
        match self {
            Self::Linear { axis_deg } => {
                let (sin, cos) = exact_sin_cos_deg(2.0 * axis_deg);
                Stokes([1.0, cos, sin, 0.0])
            }
            Self::RightCircular => Stokes([1.0, 0.0, 0.0, 1.0]),
            Self::LeftCircular => Stokes([1.0, 0.0, 0.0, -1.0]),
        }
    }

    /// What passes of light, given and returned in the same units: at least 0 where that is
    /// physical, but for rounding.
    pub fn passed(self, stokes: [f32; 4]) -> f32 {
        let Stokes(state) = self.state();
        let product: f64 = state.iter().zip(stokes).map(|(p, s)| p * f64::from(s)).sum();
        (0.5 * product) as f32
    }

    /// Refuses an axis that is none.
    pub(crate) fn check(self) -> Result<(), Fault> {
        match self {
            Self::Linear { axis_deg } => Range::ANY.check("axis_deg", axis_deg),
            Self::RightCircular | Self::LeftCircular => Ok(()),
        }
    }
}

/// As in "linear at 45 degrees", "right circular".
impl fmt::Display for Analyzer {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Linear { axis_deg } => write!(f, "linear at {axis_deg} degrees"),
            Self::RightCircular => f.write_str("right circular"),
            Self::LeftCircular => f.write_str("left circular"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The opposite states pass nothing of each other, and together all.
    #[test]
    fn opposite_analyzers_share_the_light() {
        let light = [1.0, 0.3, -0.4, 0.5];
        let linear = |axis_deg| Analyzer::Linear { axis_deg };
        let circular = [Analyzer::RightCircular, Analyzer::LeftCircular];
        for [one, other] in [[linear(0.0), linear(90.0)], [linear(45.0), linear(-45.0)], circular] {
            assert_eq!(one.passed(other.state().0.map(|s| s as f32)), 0.0);
            assert_eq!(one.passed(one.state().0.map(|s| s as f32)), 1.0);
            assert!((one.passed(light) + other.passed(light) - 1.0).abs() < 1e-6);
        }
        // From x towards y: S2 > 0 is polarized along x + y.
        assert_eq!(linear(45.0).passed(light), 0.5 * (1.0 - 0.4));
        assert_eq!(circular[0].passed(light), 0.75);
        assert!(linear(f64::NAN).check().is_err() && linear(1e39).check().is_err());
        assert!(linear(-720.0).check().is_ok());
    }
}
