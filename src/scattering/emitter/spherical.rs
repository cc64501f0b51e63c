//! Triangles as they are seen from a point: their solid angle (van Oosterom and Strackee 1983), and
//! directions to them that are uniform in it (Arvo 1995, "Stratified sampling of spherical
//! triangles"). Points that are uniform on the area crowd where a near triangle is far and aslant.

use std::f64::consts::FRAC_1_PI;

use crate::math::{F32s, Real, Vector, warp};

/// Tangent of half the solid angle, 0.3 sr, from which on directions are chosen in it. Below it
/// the distances and cosines of all points are nearly the same.
const LARGE: f64 = 0.151;

/// The square of the longest edge over that of the distance to the nearest corner below which no
/// triangle is so large: its nearest point is at most 1/sqrt(3) of the edge nearer than that
/// corner, and its area at most sqrt(3)/4 of the square, so that it covers less than 0.22 sr.
const SMALL: f64 = 0.25;

/// Squared chord, of 0.1 rad, that every side has to have: along shorter ones directions are not
/// told apart in single precision.
const LONG: f64 = 0.01;

/// The corners of a triangle as seen from a point.
#[derive(Clone, Copy)]
pub struct SphericalTriangle<F> {
    /// Unit vectors to them.
    corners: [Vector<F>; 3],
    /// The tangent of half the solid angle, as a fraction; neither number is below zero at once.
    half: [F; 2],
}

impl<F: Real> SphericalTriangle<F> {
    /// Where it may be large, by the vectors to its corners.
    #[inline(always)]
    pub fn may_be_large([a, b, c]: [Vector<F>; 3]) -> F::Mask {
        let longest = [b - a, c - b, a - c].map(Vector::length_squared);
        let nearest = [a, b, c].map(Vector::length_squared);
        let longest = longest[0].max(longest[1]).max(longest[2]);
        longest.gt(nearest[0].min(nearest[1]).min(nearest[2]) * F::splat(SMALL))
    }

    /// From the vectors to its corners.
    #[inline(always)]
    pub fn new([a, b, c]: [Vector<F>; 3]) -> Self {
        let [to_a, to_b, to_c] = [a, b, c].map(Vector::length);
        // By the edges, so that nothing cancels where they are short.
        let volume = a.dot((b - a).cross(c - a)).abs();
        let products = [(a.dot(b), to_c), (b.dot(c), to_a), (c.dot(a), to_b)];
        let sum = products
            .iter()
            .fold(to_a * to_b * to_c, |sum, &(cosine, length)| cosine.mul_add(length, sum));
        let unit = |vector: Vector<F>, length: F| vector * (F::one() / length);
        Self { corners: [unit(a, to_a), unit(b, to_b), unit(c, to_c)], half: [volume, sum] }
    }

    /// Where it is so large that directions are to be chosen in its solid angle.
    #[inline(always)]
    pub fn is_large(&self) -> F::Mask {
        let [volume, sum] = self.half;
        let [a, b, c] = self.corners;
        let chord = |one: Vector<F>, other: Vector<F>| (one - other).length_squared();
        let shortest = chord(a, b).min(chord(b, c)).min(chord(c, a));
        let share = F::select(shortest.gt(F::splat(LONG)), volume, F::zero());
        share.gt((sum * F::splat(LARGE)).max(F::zero()))
    }

    /// The solid angle, in sr.
    #[inline(always)]
    pub fn solid_angle(&self) -> F {
        let [volume, sum] = self.half;
        F::splat(2.0) * volume.atan2(sum)
    }
}

impl SphericalTriangle<F32s> {
    /// A direction to it.
    #[inline(always)]
    pub fn direction(&self, u: [F32s; 2]) -> Vector<F32s> {
        let one = F32s::splat(1.0);
        let [a, b, c] = self.corners;
        let cos_ab = a.dot(b);
        let to_b = a.mul_add(-cos_ab, b);
        let to_c = a.mul_add(-a.dot(c), c);
        let inverse = one / (to_b.length_squared() * to_c.length_squared()).sqrt();
        let cos_at_a = to_b.dot(to_c) * inverse;
        let sin_at_a = a.dot(b.cross(c)).abs() * inverse;
        // The corner c' on the edge from a to c with which a, b bound the share u of the area.
        let turns = u[0] * self.solid_angle() * F32s::splat(0.5 * FRAC_1_PI as f32);
        let (sine, cosine) = warp::sin_cos_turns(turns);
        let sin_phi = cosine * sin_at_a - sine * cos_at_a;
        let cos_phi = -(cosine * cos_at_a + sine * sin_at_a);
        let (p, q) = (cos_phi + cos_at_a, sin_phi - sin_at_a * cos_ab);
        let above = (q * cos_phi - p * sin_phi).mul_add(cos_at_a, q);
        let below = (q * sin_phi + p * cos_phi) * sin_at_a;
        let cos_edge = (above / below).fast_max(-one).fast_min(one);
        let corner = along(a, to_c, cos_edge);
        // And a point on the arc between b and that.
        let cos_between = corner.dot(b);
        let aside = b.mul_add(-cos_between, corner);
        along(b, aside, one - u[1] * (one - cos_between))
    }
}

/// The unit vector that has a cosine to the unit vector `axis`, towards `aside`, which is
/// perpendicular to that.
#[inline(always)]
fn along(axis: Vector<F32s>, aside: Vector<F32s>, cosine: F32s) -> Vector<F32s> {
    let sine = (F32s::splat(1.0) - cosine * cosine).fast_max(F32s::splat(0.0)).sqrt();
    let length = aside.length().fast_max(F32s::splat(f32::MIN_POSITIVE));
    aside.mul_add(sine / length, axis * cosine)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::LANES;

    /// Of a thousand sets of moments, one is off by more with a chance of 1e-3.
    const LIMIT: f64 = 5.0;
    const PACKETS: usize = 20_000;

    const TRIANGLES: [[[f32; 3]; 3]; 5] = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [[0.3, 0.1, 1.0], [-0.2, 0.5, 1.0], [-0.1, -0.4, 0.2]],
        // Right before the eyes, and turned round.
        [[5.0, -3.0, 0.05], [-4.0, -3.0, 0.05], [0.0, 6.0, 0.05]],
        [[0.0, 6.0, 0.05], [-4.0, -3.0, 0.05], [5.0, -3.0, 0.05]],
        // Long, and seen along.
        [[30.0, 0.1, 0.2], [0.2, 0.1, 0.2], [30.0, -0.1, 0.2]],
    ];

    fn seen<F: Real>(corners: [[f32; 3]; 3]) -> SphericalTriangle<F> {
        SphericalTriangle::new(
            corners.map(|corner| Vector::from(corner.map(|it| F::splat(f64::from(it))))),
        )
    }

    #[test]
    fn the_solid_angle_is_that_of_girard() {
        for corners in TRIANGLES {
            let [a, b, c] = corners.map(|it| glam::Vec3::from(it).as_dvec3());
            let angle = |at: glam::DVec3, one: glam::DVec3, other: glam::DVec3| {
                at.cross(one).angle_between(at.cross(other))
            };
            let expected = angle(a, b, c) + angle(b, c, a) + angle(c, a, b) - std::f64::consts::PI;
            let found = seen::<f64>(corners).solid_angle();
            assert!((found - expected).abs() < 1e-7, "{corners:?}: {found}, not {expected}");
            let in_lanes = f64::from(seen::<F32s>(corners).solid_angle().as_array()[0]);
            assert!((in_lanes / expected - 1.0).abs() < 1e-5, "{in_lanes}, not {expected}");
        }
    }

    /// First and second moments of the directions, against those of points on the area that are
    /// weighed by the solid angle that they stand for.
    #[test]
    fn directions_are_uniform() {
        let golden = |index: usize, step: f64| ((index as f64 + 0.5) * step).fract() as f32;
        for corners in TRIANGLES {
            let triangle = seen::<F32s>(corners);
            let [a, b, c] = corners.map(|it| glam::Vec3::from(it).as_dvec3());
            let moments = |w: glam::DVec3| [w.x, w.y, w.z, w.x * w.y, w.y * w.z, w.z * w.x];
            let (mut by_angle, mut by_area) = ([[0.0; 2]; 6], [[0.0; 2]; 6]);
            let solid_angle = seen::<f64>(corners).solid_angle();
            for packet in 0..PACKETS {
                let u = [0.754_877_666_246_693, 0.569_840_290_998_053].map(|step| {
                    F32s::from(crate::math::lanes::each(|lane| golden(packet * LANES + lane, step)))
                });
                let directions = triangle.direction(u).to_rows();
                for (lane, direction) in directions.into_iter().enumerate() {
                    let direction = glam::Vec3::from(direction).as_dvec3();
                    assert!((direction.length() - 1.0).abs() < 1e-4, "{direction}");
                    let (r, v) =
                        (f64::from(u[0].as_array()[lane]).sqrt(), f64::from(u[1].as_array()[lane]));
                    let point = a + (b - a) * (r * (1.0 - v)) + (c - a) * (r * v);
                    let towards = point.normalize();
                    let area = (b - a).cross(c - a);
                    let weight =
                        0.5 * area.dot(towards).abs() / point.length_squared() / solid_angle;
                    let pairs = moments(direction).into_iter().zip(moments(towards));
                    for (index, (one, other)) in pairs.enumerate() {
                        let other = other * weight;
                        by_angle[index][0] += one;
                        by_angle[index][1] += one * one;
                        by_area[index][0] += other;
                        by_area[index][1] += other * other;
                    }
                }
            }
            let count = (PACKETS * LANES) as f64;
            for (one, other) in by_angle.into_iter().zip(by_area) {
                let [(m, v), (n, w)] = [one, other].map(|[sum, squares]| {
                    let mean = sum / count;
                    (mean, (squares / count - mean * mean) / count)
                });
                let error = (v + w).sqrt();
                assert!((m - n).abs() < LIMIT * error, "{corners:?}: {m}, not {n} +- {error}");
            }
        }
    }
}
