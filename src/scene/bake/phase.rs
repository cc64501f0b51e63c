//! Tables of phase matrices: from elements at equally spaced angles to what rendering samples and
//! looks up.

use std::f64::consts::PI;

use crate::math::elementary::{cos, sin};
use crate::polarization::rayleigh::rayleigh_depolarized;
use crate::scene::baked::PhaseTable;
use crate::scene::world::TabulatedMatrix;

/// Number of intervals from 0 to pi that resolve the dipole's phase function.
const RAYLEIGH_INTERVALS: usize = 1024;
/// Fewest and most intervals of other tables.
const INTERVALS_MIN: usize = 512;
const INTERVALS_MAX: usize = 8192;
/// Intervals per size parameter: the lobes of a sphere are about pi over it wide.
const INTERVALS_PER_SIZE: f64 = 8.0;

/// A phase matrix at one angle, in any unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elements {
    pub m00: f64,
    pub m01: f64,
    pub m11: f64,
    pub m22: f64,
    pub m23: f64,
    pub m33: f64,
}

impl Elements {
    /// These, or for a share of 1 the others, or what lies between.
    pub fn mixed(&self, other: &Self, share: f64) -> Self {
        let mix = |from: f64, to: f64| from * (1.0 - share) + to * share;
        Self {
            m00: mix(self.m00, other.m00),
            m01: mix(self.m01, other.m01),
            m11: mix(self.m11, other.m11),
            m22: mix(self.m22, other.m22),
            m23: mix(self.m23, other.m23),
            m33: mix(self.m33, other.m33),
        }
    }
}

/// The phase matrix of small particles, the same at all wavelengths.
pub fn rayleigh<const N: usize>(depolarization: f64) -> PhaseTable<N> {
    let at = |index: usize| {
        let cos_theta = cos(PI * index as f64 / RAYLEIGH_INTERVALS as f64);
        let (m00, block) = rayleigh_depolarized(cos_theta, depolarization);
        let spheres = depolarization == 0.0;
        Elements {
            m00,
            m01: m00 * block.a,
            m11: if spheres { m00 } else { m00 * block.b },
            m22: m00 * block.c,
            m23: 0.0,
            m33: if spheres { m00 * block.c } else { m00 * block.d },
        }
    };
    let matrix: Vec<Elements> = (0..=RAYLEIGH_INTERVALS).map(at).collect();
    table(&[(); N].map(|()| matrix.clone()))
}

/// Number of intervals from 0 to pi, even, that resolve spheres of a size parameter.
pub fn intervals(size_parameter: f64) -> usize {
    let wanted = (INTERVALS_PER_SIZE * size_parameter).ceil() as usize;
    wanted.clamp(INTERVALS_MIN, INTERVALS_MAX).next_multiple_of(2)
}

/// The first and the last wavelength in nanometers of tabulated matrices, if they have any.
pub fn ends_nm(matrices: &[TabulatedMatrix]) -> Option<[f64; 2]> {
    let [first, last] = [matrices.first(), matrices.last()];
    Some([first?.wavelength_nm?, last?.wavelength_nm?])
}

/// Tabulated matrices at wavelengths in nanometers that they cover, linear between the table's
/// wavelengths and angles. Angles that are equally spaced in the table are nodes again.
pub fn tabulated<const N: usize>(
    matrices: &[TabulatedMatrix],
    wavelengths_nm: [f64; N],
) -> PhaseTable<N> {
    let steps = matrices.iter().flat_map(|matrix| matrix.theta_deg.windows(2));
    let finest = steps.map(|pair| pair[1] - pair[0]).fold(180.0, f64::min);
    let own = ((180.0 / finest).round() as usize).clamp(1, INTERVALS_MAX);
    let intervals = own * INTERVALS_MIN.div_ceil(own);
    let mut found = [const { Vec::new() }; N];
    for (found, wavelength_nm) in found.iter_mut().zip(wavelengths_nm) {
        let (low, high, share) = neighbors(matrices, wavelength_nm);
        let at = |index: usize| {
            let theta_deg = 180.0 * index as f64 / intervals as f64;
            let (low, high) = (elements_at(low, theta_deg), elements_at(high, theta_deg));
            let mixed: [f64; 6] = std::array::from_fn(|e| low[e] * (1.0 - share) + high[e] * share);
            let [m00, m01, m11, m22, m23, m33] = mixed;
            Elements { m00, m01, m11, m22, m23, m33 }
        };
        *found = (0..=intervals).map(at).collect();
    }
    table(&found)
}

/// Whether all matrices are as those of spheres.
pub fn are_of_spheres(matrices: &[TabulatedMatrix]) -> bool {
    let mut all = matrices.iter().flat_map(|matrix| &matrix.elements);
    all.all(|[m00, _, m11, m22, _, m33]| m00 == m11 && m22 == m33)
}

/// The matrices on both sides of a wavelength, and the share of the second.
fn neighbors(
    matrices: &[TabulatedMatrix],
    wavelength_nm: f64,
) -> (&TabulatedMatrix, &TabulatedMatrix, f64) {
    let Some([first_nm, last_nm]) = ends_nm(matrices) else {
        return (&matrices[0], &matrices[0], 0.0);
    };
    // Rounding to single precision may have led outside.
    let wavelength_nm = wavelength_nm.clamp(first_nm, last_nm);
    let nm = |matrix: &TabulatedMatrix| matrix.wavelength_nm.unwrap_or(first_nm);
    let upper = matrices.partition_point(|matrix| nm(matrix) < wavelength_nm);
    let (low, high) = (&matrices[upper.saturating_sub(1)], &matrices[upper]);
    let width = nm(high) - nm(low);
    let share = if width > 0.0 { (wavelength_nm - nm(low)) / width } else { 1.0 };
    (low, high, share)
}

/// A tabulated matrix at an angle, linear between the angles of the table.
fn elements_at(matrix: &TabulatedMatrix, theta_deg: f64) -> [f64; 6] {
    let angles = &matrix.theta_deg;
    let upper = angles.partition_point(|&at| at < theta_deg).clamp(1, angles.len() - 1);
    let (low, high) = (matrix.elements[upper - 1], matrix.elements[upper]);
    let share = (theta_deg - angles[upper - 1]) / (angles[upper] - angles[upper - 1]);
    let share = share.clamp(0.0, 1.0);
    std::array::from_fn(|element| low[element] * (1.0 - share) + high[element] * share)
}

/// The table of one matrix per wavelength, all at the same equally spaced angles, two at least,
/// with `m00` not negative and greater than zero somewhere.
pub fn table<const N: usize>(matrices: &[Vec<Elements>; N]) -> PhaseTable<N> {
    let angles = matrices[0].len();
    let half_sine2: Vec<f32> = (0..angles).map(|index| half_sine2(index, angles - 1)).collect();
    let mut table = PhaseTable {
        half_sine2,
        m00: vec![[0.0; N]; angles],
        cdf: vec![[0.0; N]; angles],
        elements: vec![[[0.0; N]; 5]; angles],
        spheres: false,
        achromatic: false,
    };
    for (channel, matrix) in matrices.iter().enumerate() {
        fill_channel(&mut table, channel, matrix);
    }
    let equal = |a: &[f32; N], b: &[f32; N]| a == b;
    table.spheres = table.elements.iter().all(|[_, b, c, d, _]| *b == [1.0; N] && equal(c, d));
    let same = |element: &[f32; N]| element.iter().all(|value| *value == element[0]);
    table.achromatic = table.elements.iter().flatten().all(same);
    table
}

/// `sin^2(theta / 2)` of an angle, exact at both ends.
fn half_sine2(index: usize, intervals: usize) -> f32 {
    let half = 0.5 * PI * index as f64 / intervals as f64;
    // The form that is accurate for small angles, from either end.
    let value = if 2 * index <= intervals {
        sin(half).powi(2)
    } else {
        1.0 - sin(0.5 * PI * (intervals - index) as f64 / intervals as f64).powi(2)
    };
    value as f32
}

/// Integral of `m00` over the sphere of directions up to each angle, read as linear in
/// `half_sine2`, for which `dOmega = 4 pi d(half_sine2)`.
fn integrals(half_sine2: &[f32], matrix: &[Elements]) -> Vec<f64> {
    let mut sum = 0.0;
    let mut integrals = vec![0.0];
    for (ends, m) in half_sine2.windows(2).zip(matrix.windows(2)) {
        let width = f64::from(ends[1]) - f64::from(ends[0]);
        sum += 2.0 * PI * width * (m[0].m00 + m[1].m00);
        integrals.push(sum);
    }
    integrals
}

/// Writes one wavelength: a phase function that integrates to one, its cumulative distribution
/// and the elements relative to it.
fn fill_channel<const N: usize>(table: &mut PhaseTable<N>, channel: usize, matrix: &[Elements]) {
    let integrals = integrals(&table.half_sine2, matrix);
    let total = integrals[integrals.len() - 1];
    for (index, m) in matrix.iter().enumerate() {
        table.m00[index][channel] = (m.m00 / total) as f32;
        table.cdf[index][channel] = (integrals[index] / total) as f32;
        // Where nothing is scattered, the matrix is a depolarizer.
        let scale = if m.m00 > 0.0 { 1.0 / m.m00 } else { 0.0 };
        let relative = |element: f64| ((element * scale) as f32).clamp(-1.0, 1.0);
        let m11 = if m.m11 == m.m00 { 1.0 } else { relative(m.m11) };
        let elements = [relative(m.m01), m11, relative(m.m22), relative(m.m33), relative(m.m23)];
        for (row, element) in table.elements[index].iter_mut().zip(elements) {
            row[channel] = element;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The integral of a table's phase function as rendering reads it.
    fn integral<const N: usize>(table: &PhaseTable<N>, channel: usize) -> f64 {
        let rows = table.half_sine2.windows(2).zip(table.m00.windows(2));
        rows.map(|(x, m)| {
            let mean = 0.5 * (f64::from(m[0][channel]) + f64::from(m[1][channel]));
            4.0 * PI * (f64::from(x[1]) - f64::from(x[0])) * mean
        })
        .sum()
    }

    fn check<const N: usize>(table: &PhaseTable<N>) {
        let last = table.m00.len() - 1;
        assert!(table.half_sine2.is_sorted_by(|a, b| a < b));
        assert_eq!((table.half_sine2[0], table.half_sine2[last]), (0.0, 1.0));
        for channel in 0..N {
            assert!((integral(table, channel) - 1.0).abs() < 1e-6);
            assert!(table.cdf.is_sorted_by(|a, b| a[channel] <= b[channel]));
            assert_eq!((table.cdf[0][channel], table.cdf[last][channel]), (0.0, 1.0));
        }
    }

    #[test]
    fn dipoles() {
        for depolarization in [0.0, 0.03, 0.5] {
            let table = rayleigh::<3>(depolarization);
            check(&table);
            assert!(table.achromatic);
            assert_eq!(table.spheres, depolarization == 0.0);
            let (m00, block) = rayleigh_depolarized(0.0, depolarization);
            let [a, b, c, d, s] = table.elements[RAYLEIGH_INTERVALS / 2].map(|row| row[1]);
            let expected = [block.a, block.b, block.c, block.d, 0.0];
            for (found, expected) in [a, b, c, d, s].into_iter().zip(expected) {
                assert!((f64::from(found) - expected).abs() < 1e-6, "{found} {expected}");
            }
            assert!((f64::from(table.m00[RAYLEIGH_INTERVALS / 2][2]) / m00 - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn peaks_keep_the_integral_at_the_finest_spacing() {
        let peak = |index: usize| {
            let m00 = (1e-9 + (index as f64 / 8192.0).powi(2)).powi(-2);
            Elements { m00, m01: -0.5 * m00, m11: m00, m22: 0.0, m23: 0.0, m33: 0.0 }
        };
        let flat = Elements { m00: 2.0, m01: 0.0, m11: 1.0, m22: 0.5, m23: 0.25, m33: -0.5 };
        let table = table(&[(0..=8192).map(peak).collect(), vec![flat; 8193]]);
        check(&table);
        assert!(!table.spheres && !table.achromatic);
        assert_eq!(table.elements[100].map(|row| row[1]), [0.0, 0.5, 0.25, -0.25, 0.125]);
    }

    #[test]
    fn where_nothing_is_scattered_nothing_is_divided_by_zero() {
        let none = Elements { m00: 0.0, m01: 0.0, m11: 0.0, m22: 0.0, m23: 0.0, m33: 0.0 };
        let mut matrix = vec![none; 513];
        matrix[256].m00 = 1.0;
        let table = table(&[matrix]);
        check(&table);
        assert!(table.elements.iter().flatten().all(|row| row[0].is_finite()));
    }
}
