//! Optical elements that act on polarization only: polarizers and retarders.

use super::frame::unit_or_perpendicular;
use super::kernel::Block;
use crate::math::elementary::sin_cos;
use crate::math::{Real, Vector};

/// A partial polarizer with power transmittances `t_max` along its axis and `t_min` across it
/// (`1 >= t_max >= t_min >= 0`); the x axis of the frame is the transmission axis.
///
/// Returns `M00 = (t_max + t_min) / 2` and the kernel relative to it (Chipman, Lam and Young 2018,
/// "Polarized Light and Optical Systems", 6.27 with no retardance). An opaque one is the identity.
pub fn polarizer_block(t_max: f64, t_min: f64) -> (f64, Block<f64>) {
    let sum = t_max + t_min;
    if sum <= 0.0 {
        return (0.0, Block::identity());
    }
    let c = 2.0 * (t_max * t_min).sqrt() / sum;
    (0.5 * sum, Block { a: (t_max - t_min) / sum, c, s: 0.0 })
}

/// A retarder whose fast axis is the frame's x axis and whose slow axis lags it by `retardance_deg`
/// degrees; it loses no light. A quarter wave (90 degrees) turns `S2 = 1` into `S3 = -1`.
pub fn retarder_block(retardance_deg: f64) -> Block<f64> {
    let (sin, cos) = exact_sin_cos_deg(retardance_deg);
    Block { a: 0.0, c: cos, s: sin }
}

/// Sine and cosine of an angle in degrees, exact at multiples of 90 degrees: crossed polarizers
/// and quarter-wave plates are the commonest of all.
pub fn exact_sin_cos_deg(degrees: f64) -> (f64, f64) {
    let turned = degrees.rem_euclid(360.0);
    let quarter = (turned / 90.0).round();
    let (sin, cos) = sin_cos((turned - 90.0 * quarter).to_radians());
    match quarter as u32 % 4 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// The effective transmission axis, perpendicular to the light's direction `k`, of a polarizer
/// whose transmission axis lies in a surface with this `normal` (all unit vectors).
///
/// The absorbing axis `normal x axis_in_surface` is what is projected across `k` (Korger et al.
/// 2013, "The polarization properties of a tilted polarizer"), and light passes perpendicular to
/// it. Any perpendicular of `k` where `k` runs along the absorbing axis.
#[inline(always)]
pub fn transmission_axis<F: Real>(
    axis_in_surface: Vector<F>,
    normal: Vector<F>,
    k: Vector<F>,
) -> Vector<F> {
    let absorbing = normal.cross(axis_in_surface);
    unit_or_perpendicular(absorbing.cross(k), k)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_turns_are_exact() {
        for (degrees, sin, cos) in [(0.0, 0.0, 1.0), (90.0, 1.0, 0.0), (-90.0, -1.0, 0.0)] {
            let found = exact_sin_cos_deg(degrees);
            assert_eq!((found.0.abs(), found.1.abs()), (f64::abs(sin), f64::abs(cos)));
            assert!(found.0 * sin >= 0.0 && found.1 * cos >= 0.0);
        }
        assert_eq!(exact_sin_cos_deg(180.0).1, -1.0);
        let (sin, cos) = exact_sin_cos_deg(200.0);
        assert!((sin - 200f64.to_radians().sin()).abs() < 1e-15);
        assert!((cos - 200f64.to_radians().cos()).abs() < 1e-15);
    }
}
