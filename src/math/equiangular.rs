//! Distances on a segment that see a point under equal angles (Kulla and Fajardo 2012, "Importance
//! sampling techniques for path tracing in participating media", section 4): the more often the
//! nearer they are to it, as its light falls off.

use super::{F32s, Vector};

/// Longer segments end here, so that squares stay within the range of numbers.
const LENGTH_MAX: f32 = 1e15;
/// Least distance of the point from the line, over that from the segment's start and from the
/// line's origin: where less is rounding.
const LEAST_WIDTH: f32 = 1e-6;

/// Eight segments, each with its point.
///
/// Angles are counted from the segment's start, by their tangents: differences of angles on the
/// line would be rounding where it leads nearly through the point.
#[derive(Clone, Copy)]
pub struct Equiangular {
    /// Where the segment begins on its line.
    from: F32s,
    /// That, as seen from the place closest to the point.
    ahead: F32s,
    /// Distance of the point from the line.
    width: F32s,
    /// Under which the point sees the segment; above zero.
    angle: F32s,
}

impl Equiangular {
    /// For the point at `offset` from the origin of a line along `direction` (unit length), and the
    /// distances between `from` and `to` on it. The point counts as no closer to the line than
    /// `radius`.
    #[inline(always)]
    pub fn new(
        offset: Vector<F32s>,
        direction: Vector<F32s>,
        [from, to]: [F32s; 2],
        radius: F32s,
    ) -> Self {
        let along = offset.dot(direction);
        let across = offset - direction * along;
        let ahead = from - along;
        let least = (offset.length() + from + ahead.abs()) * F32s::splat(LEAST_WIDTH);
        let least = least.max(radius).max(F32s::splat(f32::MIN_POSITIVE.sqrt()));
        let width = across.length().max(least);
        let length = (to - from).max(F32s::ZERO).min(F32s::splat(LENGTH_MAX));
        let angle = (width * length).atan2(width.mul_add(width, ahead * (ahead + length)));
        Self { from, ahead, width, angle: angle.max(F32s::splat(f32::MIN_POSITIVE)) }
    }

    /// The distance for a random number in [0, 1).
    #[inline(always)]
    pub fn sample(&self, u: F32s) -> F32s {
        let &Self { from, ahead, width, angle } = self;
        let (sine, cosine) = (u * angle).sin_cos();
        let start2 = width.mul_add(width, ahead * ahead);
        from + sine * start2 / (width * cosine - ahead * sine)
    }

    /// The density per unit of length with which a distance on the segment is drawn.
    #[inline(always)]
    pub fn density(&self, distance: F32s) -> F32s {
        let &Self { from, ahead, width, angle } = self;
        let behind = distance - from + ahead;
        width / (angle * width.mul_add(width, behind * behind))
    }

    /// What an even light at the point brings to the segment, over its intensity: the integral of
    /// the inverse square of the distance.
    #[inline(always)]
    pub fn brought(&self) -> F32s {
        self.angle / self.width
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::LANES;

    /// What a segment along x, whose line begins at zero, is seen by from a point.
    fn seen(offset: [f32; 3], range: [f32; 2]) -> Equiangular {
        let [offset, x] = [offset, [1.0, 0.0, 0.0]].map(Vector::splat);
        Equiangular::new(offset, x, range.map(F32s::splat), F32s::ZERO)
    }

    const CASES: [([f32; 3], [f32; 2]); 7] = [
        ([2.0, 1.0, 0.0], [0.0, 5.0]),
        ([2.0, 1e-3, 0.0], [0.5, 9.0]),
        ([-3.0, 1e-2, 0.0], [1.0, 1.5]),
        ([50.0, 0.0, 2e-4], [1.0, 2.0]),
        ([7.0, 0.0, 3.0], [7.0, 7.001]),
        ([1.0, 2.0, 2.0], [0.0, 1e6]),
        ([1e4, 30.0, 40.0], [9e3, 2e4]),
    ];

    /// The distance that sees a share of the angle, in double precision.
    fn exact([x, y, z]: [f32; 3], [from, to]: [f32; 2], u: f64) -> f64 {
        let width = f64::from(y).hypot(f64::from(z));
        let [from, to] = [from, to].map(|end| (f64::from(end) - f64::from(x)).atan2(width));
        f64::from(x) + width * (from + u * (to - from)).tan()
    }

    #[test]
    fn angles_are_equal() {
        for (offset, range) in CASES.into_iter().filter(|(it, _)| it[1].hypot(it[2]) > 1e-3) {
            let u = F32s::from(std::array::from_fn(|lane| lane as f32 / LANES as f32));
            let drawn = seen(offset, range).sample(u).to_array();
            for (u, drawn) in u.to_array().into_iter().zip(drawn) {
                let exact = exact(offset, range, f64::from(u));
                let error = (f64::from(drawn) - exact).abs() / (1e-5 * exact + 1e-6);
                assert!(error < 1.0, "{offset:?} {range:?} {u}: {drawn} for {exact}");
            }
        }
    }

    /// Density: of the derivative of the angle, in double precision.
    #[test]
    fn the_density_is_that_of_what_is_drawn() {
        for ([x, y, z], [from, to]) in CASES {
            let [x, y, z, from, to] = [x, y, z, from, to].map(f64::from);
            let width = y.hypot(z);
            let angle = ((to - x) / width).atan() - ((from - x) / width).atan();
            let seen = seen([x, y, z].map(|it| it as f32), [from, to].map(|it| it as f32));
            for step in 0..=16 {
                let distance = from + (to - from) * f64::from(step) / 16.0;
                let exact = width / (angle * (width * width + (distance - x).powi(2)));
                let density = seen.density(F32s::splat(distance as f32)).to_array()[0];
                let error = (f64::from(density) / exact - 1.0).abs();
                assert!(error < 2e-4, "{x} {width} {distance}: {density} for {exact}");
            }
        }
    }

    /// Where the line leads through the point, distances are drawn about it all the same.
    #[test]
    fn lines_through_the_point_have_densities() {
        let seen = seen([3.0, 0.0, 0.0], [1.0, 4.0]);
        for step in 0..64 {
            let drawn = seen.sample(F32s::splat(step as f32 / 64.0));
            let (drawn, density) = (drawn.to_array()[0], seen.density(drawn).to_array()[0]);
            assert!((1.0..=4.0).contains(&drawn), "{drawn}");
            assert!(density > 0.0 && density.is_finite(), "{drawn}: {density}");
        }
    }

    #[test]
    fn nothing_is_lost_at_infinity() {
        let seen = seen([1.0, 2.0, 0.0], [0.0, f32::INFINITY]);
        let [near, far] = [0.0, 0.999_999].map(|u| seen.sample(F32s::splat(u)).to_array()[0]);
        assert!(near == 0.0 && far > 1e4 && far.is_finite(), "{near} {far}");
        assert!(seen.density(F32s::splat(far)).to_array()[0] > 0.0);
    }
}
