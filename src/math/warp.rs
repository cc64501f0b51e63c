//! From the unit square to directions and points: area-preserving maps with known densities.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, PI};

use super::{F32s, Real, Vector};

/// Sine and cosine of `2 pi turns` for `turns` in [0, 1), absolute error below 4e-7.
///
/// Folds the circle into [-pi/4, pi/4] and uses the Taylor polynomials there, which costs a
/// quarter of a general routine.
#[inline(always)]
pub fn sin_cos_turns(turns: F32s) -> (F32s, F32s) {
    let quarter = (turns * F32s::splat(4.0)).round();
    let x = (turns - quarter * F32s::splat(0.25)) * F32s::splat(2.0 * PI);
    let x2 = x * x;
    let sine = x * x2.mul_add(
        x2.mul_add(
            x2.mul_add(F32s::splat(-1.0 / 5040.0), F32s::splat(1.0 / 120.0)),
            F32s::splat(-1.0 / 6.0),
        ),
        F32s::splat(1.0),
    );
    let cosine = x2.mul_add(
        x2.mul_add(
            x2.mul_add(
                x2.mul_add(F32s::splat(1.0 / 40320.0), F32s::splat(-1.0 / 720.0)),
                F32s::splat(1.0 / 24.0),
            ),
            F32s::splat(-0.5),
        ),
        F32s::splat(1.0),
    );
    let half = F32s::splat(0.5);
    // quarter is 0..4; odd quarters swap, quarters 2 and 3 (and 1, 2) flip signs.
    let odd = (quarter * half - (quarter * half).floor()).gt(F32s::splat(0.25));
    let (s, c) = (odd.bitselect(cosine, sine), odd.bitselect(sine, cosine));
    let second = quarter.gt(F32s::splat(1.5)) & quarter.lt(F32s::splat(3.5));
    let middle = quarter.gt(half) & quarter.lt(F32s::splat(2.5));
    (second.bitselect(-s, s), middle.bitselect(-c, c))
}

/// The angle theta over pi, from 0 to 1, whose `sin^2(theta / 2)` is given; absolute error below
/// 1e-6.
///
/// Polynomial of the arc sine: Abramowitz and Stegun 1964, 4.4.46, on the half of its range where
/// nothing cancels.
#[inline(always)]
pub fn angle_of_half_sine2(half_sine2: F32s) -> F32s {
    const COEFFICIENTS: [f32; 8] = [
        FRAC_PI_2,
        -0.214_598_8,
        0.088_978_99,
        -0.050_174_305,
        0.030_891_88,
        -0.017_088_126,
        0.006_670_09,
        -0.001_262_491_1,
    ];
    let one = F32s::splat(1.0);
    let backward = half_sine2.gt(F32s::splat(0.5));
    let nearer = backward.bitselect(one - half_sine2, half_sine2).max(F32s::splat(0.0));
    let sine = nearer.sqrt();
    let mut sum = F32s::splat(COEFFICIENTS[7]);
    for &coefficient in COEFFICIENTS[..7].iter().rev() {
        sum = sum.mul_add(sine, F32s::splat(coefficient));
    }
    // Half the angle over pi / 2 is the angle over pi.
    let angle = one - (one - sine).sqrt() * sum * F32s::splat(2.0 * FRAC_1_PI);
    backward.bitselect(one - angle, angle)
}

/// A point of the unit disk, uniform by area.
#[inline(always)]
pub fn disk(u: [F32s; 2]) -> [F32s; 2] {
    let radius = u[0].sqrt();
    let (sine, cosine) = sin_cos_turns(u[1]);
    [radius * cosine, radius * sine]
}

/// A direction about the unit vector `axis` with density [`cosine_pdf`]; the second value is the
/// cosine between the two.
#[inline(always)]
pub fn cosine_hemisphere(axis: Vector<F32s>, u: [F32s; 2]) -> (Vector<F32s>, F32s) {
    let [x, y] = disk(u);
    let z = (F32s::splat(1.0) - u[0]).max(F32s::splat(0.0)).sqrt();
    let tangent = axis.any_perpendicular();
    let bitangent = axis.cross(tangent);
    (tangent.mul_add(x, bitangent.mul_add(y, axis * z)), z)
}

/// Density of [`cosine_hemisphere`] per steradian for a cosine not less than zero.
#[inline(always)]
pub fn cosine_pdf(cosine: F32s) -> F32s {
    cosine * F32s::splat(FRAC_1_PI)
}

/// A direction uniform over the cone about `axis` whose edge has the cosine `cos_edge`
/// (-1: the whole sphere). Its density is `1 / (2 pi (1 - cos_edge))` per steradian.
#[inline(always)]
pub fn cone(axis: Vector<F32s>, cos_edge: F32s, u: [F32s; 2]) -> Vector<F32s> {
    let z = F32s::splat(1.0) - u[0] * (F32s::splat(1.0) - cos_edge);
    let radius = (F32s::splat(1.0) - z * z).max(F32s::splat(0.0)).sqrt();
    let (sine, cosine) = sin_cos_turns(u[1]);
    let tangent = axis.any_perpendicular();
    let bitangent = axis.cross(tangent);
    tangent.mul_add(radius * cosine, bitangent.mul_add(radius * sine, axis * z))
}

/// Barycentric coordinates (of corners b and c) uniform over a triangle
/// (Heitz 2019, "A low-distortion map between triangle and square").
#[inline(always)]
pub fn triangle(u: [F32s; 2]) -> [F32s; 2] {
    let half = F32s::splat(0.5);
    let lower = u[0].gt(u[1]);
    let b = lower.bitselect(u[0] - u[1] * half, u[0] * half);
    let c = lower.bitselect(u[1] * half, u[1] - u[0] * half);
    [b, c]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sin_cos_is_exact_to_its_stated_error() {
        for step in 0..4096_u32 {
            let turns = step as f32 / 4096.0;
            let (sine, cosine) = sin_cos_turns(F32s::splat(turns));
            let (s, c) = (f64::from(turns) * std::f64::consts::TAU).sin_cos();
            assert!((f64::from(sine.to_array()[0]) - s).abs() < 4e-7, "sin at {turns}");
            assert!((f64::from(cosine.to_array()[0]) - c).abs() < 4e-7, "cos at {turns}");
        }
    }

    #[test]
    fn angles_are_exact_to_their_stated_error() {
        for step in 0..=4096_u32 {
            let theta = std::f64::consts::PI * f64::from(step) / 4096.0;
            let half_sine2 = (0.5 * theta).sin().powi(2) as f32;
            let found = angle_of_half_sine2(F32s::splat(half_sine2)).to_array()[0];
            let expected = f64::from(half_sine2).sqrt().asin() * std::f64::consts::FRAC_2_PI;
            assert!((f64::from(found) - expected).abs() < 1e-6, "{step}: {found}");
        }
    }

    #[test]
    fn hemisphere_stays_about_its_axis() {
        let axis = Vector::new(0.6, 0.0, -0.8);
        let lanes = Vector::splat(axis);
        let u = F32s::from([0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 0.999]);
        let (direction, cosine) = cosine_hemisphere(lanes, [u, u]);
        for lane in 0..8 {
            let dot = direction.dot(lanes).to_array()[lane];
            assert!((dot - cosine.to_array()[lane]).abs() < 1e-6);
            assert!((direction.length().to_array()[lane] - 1.0).abs() < 1e-6);
        }
    }
}
