//! Mueller matrices that no surface has, made ones that some has: of measurements, which noise has
//! polarized more than there is light.
//!
//! A Mueller matrix is a sum of Jones matrices' if and only if its coherency matrix
//! `H = sum over i, j of M_ij (sigma_i x sigma_j*) / 2` has no negative eigenvalue (Cloude 1986,
//! "Group theory and polarisation algebra"). Where it has, as much of the ideal depolarizer of the
//! same M00 is mixed in as takes: its H is M00 / 2 times the identity.

/// Steps of bisection for the share of the depolarizer.
const STEPS: usize = 14;
/// What rounding may make of an eigenvalue of zero, over M00.
const ROUNDING: f64 = 1e-6;

/// A complex number.
type Complex = [f64; 2];

/// A matrix `[row][column]` with as little less polarization as makes it physical; zero if M00 is
/// not above zero.
pub fn physical(matrix: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
    let m00 = matrix[0][0];
    if m00 <= 0.0 || !m00.is_finite() {
        return [[0.0; 4]; 4];
    }
    let coherency = coherency(&matrix);
    if is_positive(&coherency, m00, 0.0) {
        return matrix;
    }
    let (mut least, mut most) = (0.0, 1.0);
    for _ in 0..STEPS {
        let share = 0.5 * (least + most);
        if is_positive(&coherency, m00, share) {
            most = share;
        } else {
            least = share;
        }
    }
    let mut mixed = matrix.map(|row| row.map(|element| (1.0 - most) * element));
    mixed[0][0] = m00;
    mixed
}

/// H, of which the lower triangle counts.
fn coherency(m: &[[f64; 4]; 4]) -> [[Complex; 4]; 4] {
    // sigma_i: diagonal for 0 and 1, else off it; of S1, S2 and S3 in this order.
    const SIGMA: [[[Complex; 2]; 2]; 4] = [
        [[[1.0, 0.0], [0.0, 0.0]], [[0.0, 0.0], [1.0, 0.0]]],
        [[[1.0, 0.0], [0.0, 0.0]], [[0.0, 0.0], [-1.0, 0.0]]],
        [[[0.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [0.0, 0.0]]],
        [[[0.0, 0.0], [0.0, -1.0]], [[0.0, 1.0], [0.0, 0.0]]],
    ];
    let mut h = [[[0.0; 2]; 4]; 4];
    for (row, column) in (0..4).flat_map(|row| (0..4).map(move |column| (row, column))) {
        let mut sum = [0.0; 2];
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
            let [a, b] = SIGMA[i][row / 2][column / 2];
            let [c, d] = SIGMA[j][row % 2][column % 2];
            // Times the conjugate.
            let product = [a * c + b * d, b * c - a * d];
            sum = [sum[0] + 0.5 * m[i][j] * product[0], sum[1] + 0.5 * m[i][j] * product[1]];
        }
        h[row][column] = sum;
    }
    h
}

/// Whether H, mixed with a share of the depolarizer, is positive: Cholesky's decomposition.
fn is_positive(h: &[[Complex; 4]; 4], m00: f64, share: f64) -> bool {
    let mut l = [[[0.0; 2]; 4]; 4];
    for row in 0..4 {
        for column in 0..=row {
            let mut sum = h[row][column].map(|part| (1.0 - share) * part);
            if row == column {
                sum[0] += 0.5 * m00 * share + ROUNDING * m00;
            }
            for ([a, b], [c, d]) in l[row].iter().zip(&l[column]).take(column) {
                sum = [sum[0] - (a * c + b * d), sum[1] - (b * c - a * d)];
            }
            if row == column {
                if sum[0] <= 0.0 {
                    return false;
                }
                l[row][row] = [sum[0].sqrt(), 0.0];
            } else {
                let pivot = l[column][column][0];
                l[row][column] = sum.map(|part| part / pivot);
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polarization::{Block, Kernel, SpheroidBlock, Stokes};

    /// The most that light may be polarized behind a matrix, over its intensity, of many states.
    fn most(matrix: [[f64; 4]; 4]) -> f64 {
        let mut most: f64 = 0.0;
        for step in 0..2000 {
            let z = 1.0 - f64::from(2 * step + 1) / 2000.0;
            let (r, turn) = ((1.0 - z * z).sqrt(), f64::from(step) * 2.399_963);
            let light = [1.0, r * turn.cos(), r * turn.sin(), z];
            let s = matrix.map(|row| row.iter().zip(light).map(|(a, b)| a * b).sum::<f64>());
            let polarized = (s[1] * s[1] + s[2] * s[2] + s[3] * s[3]).sqrt();
            most = most.max(polarized - s[0]);
        }
        most
    }

    #[test]
    fn what_is_physical_stays() {
        let metal = crate::polarization::conductor(0.4_f64, 0.2, 3.0).1;
        let polarizer = Block { a: 1.0, c: 0.0, s: 0.0 };
        let spheroid = SpheroidBlock { a: -0.3, b: 0.8, c: 0.4, d: 0.3, s: 0.1 };
        for block in [metal, polarizer, Block::identity()] {
            let Block { a, c, s } = block;
            let matrix = SpheroidBlock { a, b: 1.0, c, d: c, s }.dense().0;
            assert_eq!(physical(matrix), matrix, "{block:?}");
        }
        let matrix = spheroid.dense().0;
        assert_eq!(physical(matrix), matrix);
        let light = crate::polarization::Dense(matrix).scatter(Stokes([1.0, 0.6, 0.0, 0.8]));
        assert!(light.0[0] > 0.0);
    }

    #[test]
    fn what_is_not_is_depolarized_no_more_than_it_takes() {
        let mirror = SpheroidBlock { a: 0.0, b: 1.0, c: -1.0, d: -1.0, s: 0.0 }.dense().0;
        for factor in [1.01, 1.2, 2.0] {
            let mut matrix = mirror.map(|row| row.map(|element| factor * element));
            matrix[0][0] = 1.0;
            let found = physical(matrix);
            assert!(most(found) < 1e-5);
            // It is the mirror again.
            for (found, mirror) in found.as_flattened().iter().zip(mirror.as_flattened()) {
                assert!((found - mirror).abs() < 2e-4 * factor, "{found} {mirror}");
            }
        }
        // It turns no Stokes vector into one that is none, but a share of each that is paired with
        // another ray would be one.
        let transposed = SpheroidBlock { a: 0.0, b: 1.0, c: 1.0, d: -1.0, s: 0.0 }.dense().0;
        let found = physical(transposed);
        assert!((found[1][1] - 1.0 / 3.0).abs() < 1e-3, "{found:?}");
        for nothing in [0.0, -1.0, f64::NAN] {
            let mut matrix = mirror;
            matrix[0][0] = nothing;
            assert_eq!(physical(matrix), [[0.0; 4]; 4]);
        }
    }
}
