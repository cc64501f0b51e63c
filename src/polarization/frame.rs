//! Reference frames of Stokes vectors and the rotations between them.

use super::stokes::Stokes;
use crate::math::{Real, Vector};

/// Squared sine below which two directions count as parallel (about 1e-4 rad).
///
/// Above it a cross product in `f32` is off the perpendicular by less than 6e-4 rad, below it an
/// arbitrary axis is off the plane of incidence by less than that; either enters squared.
const PARALLEL_SIN2: f64 = 1e-8;

/// Squared length below which a reference axis counts as missing.
const MISSING_AXIS: f64 = 1e-12;

/// The change of reference axis `R(a)`, with `a` the signed angle about `+k` from the old `x` to
/// the new one: `[1 0 0 0; 0 cos2 sin2 0; 0 -sin2 cos2 0; 0 0 0 1]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation<F> {
    /// `cos 2a`.
    pub cos2: F,
    /// `sin 2a`.
    pub sin2: F,
}

impl<F: Real> Rotation<F> {
    /// No rotation.
    #[inline(always)]
    pub fn identity() -> Self {
        Self { cos2: F::one(), sin2: F::zero() }
    }

    /// From the axis `x_old` to the axis `x_new`, both perpendicular to the unit vector `k`, by dot
    /// products only.
    ///
    /// Neither axis need be of unit length or exactly perpendicular: the pair is normalized, so
    /// what is returned is always a rotation. It is the identity where an axis vanishes.
    #[inline(always)]
    pub fn between(x_old: Vector<F>, x_new: Vector<F>, k: Vector<F>) -> Self {
        let cos = x_old.dot(x_new);
        let sin = k.dot(x_old.cross(x_new));
        let cos_squared = cos * cos;
        let norm = sin.mul_add(sin, cos_squared);
        let scale = F::one() / norm;
        let sound = norm.gt(F::splat(MISSING_AXIS));
        Self {
            cos2: F::select(sound, (-sin).mul_add(sin, cos_squared) * scale, F::one()),
            sin2: F::select(sound, (sin + sin) * cos * scale, F::zero()),
        }
    }

    /// `R S`: the same light seen from the new axis.
    #[inline(always)]
    pub fn apply(self, stokes: Stokes<F>) -> Stokes<F> {
        let [s0, s1, s2, s3] = stokes.0;
        let new_s1 = self.cos2.mul_add(s1, self.sin2 * s2);
        let new_s2 = self.cos2.mul_add(s2, -(self.sin2 * s1));
        Stokes([s0, new_s1, new_s2, s3])
    }

    /// `r R`: the sensor's row `r`, given for the new axis, made to accept light given for the old.
    #[inline(always)]
    pub fn collect_row(self, row: [F; 4]) -> [F; 4] {
        let [r0, r1, r2, r3] = row;
        let new_r1 = self.cos2.mul_add(r1, -(self.sin2 * r2));
        let new_r2 = self.cos2.mul_add(r2, self.sin2 * r1);
        [r0, new_r1, new_r2, r3]
    }

    /// `T R`, row by row as [`Rotation::collect_row`].
    #[inline(always)]
    pub fn collect_matrix(self, matrix: [[F; 4]; 4]) -> [[F; 4]; 4] {
        // Not `map`, which is not always inlined.
        let [first, second, third, fourth] = matrix;
        [
            self.collect_row(first),
            self.collect_row(second),
            self.collect_row(third),
            self.collect_row(fourth),
        ]
    }

    /// The rotation back: `R(-a)`.
    #[inline(always)]
    pub fn inverse(self) -> Self {
        Self { cos2: self.cos2, sin2: -self.sin2 }
    }
}

/// The s axis of an event, `unit(normal x k)`, for unit vectors in the same space.
///
/// Where the two are parallel to about 1e-4 rad there is no plane of incidence: any axis
/// perpendicular to `k` serves and [`Vector::any_perpendicular`] is returned. Never not a number.
#[inline(always)]
pub fn s_axis<F: Real>(normal: Vector<F>, k: Vector<F>) -> Vector<F> {
    unit_or_perpendicular(normal.cross(k), k)
}

/// The x axis of the film's frame, `unit(ray_direction x up)`: to the right in the image. The
/// light's own direction of travel is `-ray_direction`. Falls back like [`s_axis`].
#[inline(always)]
pub fn film_axis<F: Real>(ray_direction: Vector<F>, up: Vector<F>) -> Vector<F> {
    unit_or_perpendicular(ray_direction.cross(up), ray_direction)
}

/// `axis` at unit length, or any perpendicular of the unit vector `k` where `axis` vanishes.
#[inline(always)]
pub(super) fn unit_or_perpendicular<F: Real>(axis: Vector<F>, k: Vector<F>) -> Vector<F> {
    let length_squared = axis.length_squared();
    let unit = axis * (F::one() / length_squared.sqrt());
    let sound = length_squared.gt(F::splat(PARALLEL_SIN2));
    Vector::select(sound, unit, k.any_perpendicular())
}
