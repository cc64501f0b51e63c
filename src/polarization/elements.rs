//! Optical elements that act on polarization only: polarizers and retarders.

use super::frame::unit_or_perpendicular;
use super::kernel::Block;
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

/// A retarder whose fast axis is the frame's x axis and whose slow axis lags it by `retardance`
/// radians; it loses no light. A quarter wave (pi / 2) turns `S2 = 1` into `S3 = -1`.
pub fn retarder_block(retardance: f64) -> Block<f64> {
    Block { a: 0.0, c: retardance.cos(), s: retardance.sin() }
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
