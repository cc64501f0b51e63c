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

/// A Mueller matrix, `[row][column]`.
pub type Matrix = [[f64; 4]; 4];

/// `left right`: what light does that meets `right` first.
fn product(left: &Matrix, right: &Matrix) -> Matrix {
    let element = |i: usize, j: usize| (0..4).map(|k| left[i][k] * right[k][j]).sum();
    std::array::from_fn(|i| std::array::from_fn(|j| element(i, j)))
}

/// Leads Stokes vectors to a frame that is turned by an angle about the light, of which these are
/// the cosine and sine of the double.
fn rotator([cos2, sin2]: [f64; 2]) -> Matrix {
    [[1.0, 0.0, 0.0, 0.0], [0.0, cos2, sin2, 0.0], [0.0, -sin2, cos2, 0.0], [0.0, 0.0, 0.0, 1.0]]
}

/// A polarizer, and behind it a retarder whose fast axis is turned from the polarizer's axis about
/// the light, by an angle of which `turned` are the cosine and sine of the double.
pub fn circular(polarizer: &Matrix, retarder: &Matrix, turned: [f64; 2]) -> Matrix {
    let [cos2, sin2] = turned;
    let behind = product(&rotator([cos2, -sin2]), &product(retarder, &rotator(turned)));
    product(&behind, polarizer)
}

/// How much more than physical a matrix may be, by rounding.
const UNPHYSICAL: f64 = 1e-5;

/// What a matrix that no sheet or mirror has does wrong.
///
/// It must let no more light leave than arrives, whatever the polarization and from either side,
/// and be a mixture of Jones matrices: its coherency matrix has no negative eigenvalue (Cloude
/// 1986, "Group theory and polarisation algebra"), by which nothing leaves with a degree of
/// polarization over 1.
///
/// # Errors
/// What that is.
pub fn is_physical(matrix: &Matrix) -> Result<(), &'static str> {
    let length = |of: [f64; 3]| of.into_iter().map(|x| x * x).sum::<f64>().sqrt();
    let along = length([matrix[0][1], matrix[0][2], matrix[0][3]]);
    let back = length([matrix[1][0], matrix[2][0], matrix[3][0]]);
    if matrix[0][0] + along.max(back) > 1.0 + UNPHYSICAL {
        return Err("it lets more light leave than arrives");
    }
    let shift = UNPHYSICAL * matrix[0][0].abs();
    // What passes nothing has no polarization either.
    let passes_nothing = matrix.iter().flatten().all(|element| *element == 0.0);
    if passes_nothing || is_positive(coherency(matrix), shift) {
        return Ok(());
    }
    Err("it lets light leave with a degree of polarization over 1: it is no mixture of Jones \
         matrices")
}

/// For every element (i, j) above the diagonal of a coherency matrix, of which elements (k, l) and
/// (l, k) of the Mueller matrix its imaginary part is the difference.
const PAULI_PAIRS: [[usize; 4]; 6] =
    [[0, 1, 3, 2], [0, 2, 1, 3], [0, 3, 2, 1], [1, 2, 0, 3], [1, 3, 2, 0], [2, 3, 0, 1]];

/// Cloude's coherency matrix over 4, Hermitian, as a real symmetric one of its real and imaginary
/// parts `[[A, -B], [B, A]]`; its trace over 2 is M00.
fn coherency(m: &Matrix) -> [[f64; 8]; 8] {
    let mut real = [[0.0; 4]; 4];
    let mut imaginary = [[0.0; 4]; 4];
    let signs = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    for (i, [of1, of2, of3]) in signs.into_iter().enumerate() {
        real[i][i] = (m[0][0] + of1 * m[1][1] + of2 * m[2][2] + of3 * m[3][3]) / 4.0;
    }
    for [i, j, k, l] in PAULI_PAIRS {
        real[i][j] = (m[i][j] + m[j][i]) / 4.0;
        imaginary[i][j] = (m[k][l] - m[l][k]) / 4.0;
        real[j][i] = real[i][j];
        imaginary[j][i] = -imaginary[i][j];
    }
    std::array::from_fn(|row| {
        std::array::from_fn(|column| {
            let (i, j) = (row % 4, column % 4);
            match (row < 4, column < 4) {
                (true, true) | (false, false) => real[i][j],
                (true, false) => -imaginary[i][j],
                (false, true) => imaginary[i][j],
            }
        })
    })
}

/// Whether a symmetric matrix plus `shift` times unity has no negative eigenvalue: its Cholesky
/// factors exist.
fn is_positive(mut matrix: [[f64; 8]; 8], shift: f64) -> bool {
    for (k, row) in matrix.iter_mut().enumerate() {
        row[k] += shift;
    }
    for k in 0..8 {
        let pivot = matrix[k];
        if pivot[k] <= 0.0 {
            return false;
        }
        for row in &mut matrix[k + 1..] {
            let factor = row[k] / pivot[k];
            for (element, pivot) in row.iter_mut().zip(&pivot).skip(k + 1) {
                *element -= factor * pivot;
            }
        }
    }
    true
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

    /// The Mueller matrix of a Jones matrix by its definition on the six states of light.
    fn of_jones(j: [[[f64; 2]; 2]; 2]) -> Matrix {
        let times =
            |a: [f64; 2], b: [f64; 2]| [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
        let stokes = |ex: [f64; 2], ey: [f64; 2]| {
            let [xx, yy] = [ex, ey].map(|e| e[0] * e[0] + e[1] * e[1]);
            let cross = times(ex, [ey[0], -ey[1]]);
            [xx + yy, xx - yy, 2.0 * cross[0], -2.0 * cross[1]]
        };
        let out = |ex: [f64; 2], ey: [f64; 2]| {
            let row = |r: [[f64; 2]; 2]| {
                let (a, b) = (times(r[0], ex), times(r[1], ey));
                [a[0] + b[0], a[1] + b[1]]
            };
            stokes(row(j[0]), row(j[1]))
        };
        let h = 0.5_f64.sqrt();
        let states = [
            ([1.0, 0.0], [0.0, 0.0]),
            ([0.0, 0.0], [1.0, 0.0]),
            ([h, 0.0], [h, 0.0]),
            ([h, 0.0], [-h, 0.0]),
            ([h, 0.0], [0.0, h]),
            ([h, 0.0], [0.0, -h]),
        ];
        let mut matrix = Matrix::default();
        for (i, row) in matrix.iter_mut().enumerate() {
            let of = |state: usize| out(states[state].0, states[state].1)[i];
            let pair = |a, b, sign: f64| 0.5 * (of(a) + sign * of(b));
            *row = [pair(0, 1, 1.0), pair(0, 1, -1.0), pair(2, 3, -1.0), pair(4, 5, -1.0)];
        }
        matrix
    }

    fn scaled(matrix: &Matrix, factor: f64) -> Matrix {
        matrix.map(|row| row.map(|element| element * factor))
    }

    /// Jones matrices and their mixtures are physical, and where the coherency matrix of one has an
    /// eigenvalue of zero, as that of a single Jones matrix does, a little less of M00 is not.
    #[test]
    fn mixtures_of_jones_matrices_are_physical_and_no_more() {
        let mut seed = 1_u64;
        let mut next = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        for _ in 0..200 {
            let mut one =
                || of_jones(std::array::from_fn(|_| std::array::from_fn(|_| [next(), next()])));
            let (a, b) = (one(), one());
            let greatest = |m: &Matrix| m[0][0] + m.iter().flatten().map(|x| x.abs()).sum::<f64>();
            let a = scaled(&a, 0.9 / greatest(&a));
            let b = scaled(&b, 0.9 / greatest(&b));
            assert_eq!(is_physical(&a), Ok(()));
            let mixed: Matrix =
                std::array::from_fn(|i| std::array::from_fn(|j| 0.3 * a[i][j] + 0.7 * b[i][j]));
            assert_eq!(is_physical(&mixed), Ok(()));
            let mut less = a;
            less[0][0] *= 0.99;
            assert!(is_physical(&less).is_err(), "{less:?}");
            // Transposition of the lower part alone is what no event does.
            let mut mirrored = a;
            for (i, j) in [(1, 2), (1, 3), (2, 3)] {
                (mirrored[i][j], mirrored[j][i]) = (-a[i][j], -a[j][i]);
            }
            (1..4).for_each(|i| mirrored[i][i] = -a[i][i]);
            assert!(is_physical(&mirrored).is_err(), "{mirrored:?}");
        }
    }

    #[test]
    fn matrices_that_make_light_are_refused() {
        let ideal = polarizer_block(1.0, 0.0).1.matrix();
        assert!(is_physical(&ideal).is_err(), "twice what an ideal polarizer passes");
        assert_eq!(is_physical(&scaled(&ideal, 0.5)), Ok(()));
        assert_eq!(is_physical(&Matrix::default()), Ok(()));
        let mut from_nothing = Matrix::default();
        from_nothing[1][1] = 0.1;
        assert!(is_physical(&from_nothing).is_err());
    }

    /// The textbook matrix (Chipman, Lam and Young 2018, table 6.4), for the retarder's axis
    /// turned to the left by 45 degrees: right circular light, S3 = +1.
    #[test]
    fn polarizer_and_quarter_wave_make_circular_light() {
        let (m00, block) = polarizer_block(1.0, 0.0);
        let polarizer = scaled(&block.matrix(), m00);
        let made = circular(&polarizer, &retarder_block(90.0).matrix(), [0.0, 1.0]);
        let row = [0.5, 0.5, 0.0, 0.0];
        assert_eq!(made, [row, [0.0; 4], [0.0; 4], row]);
    }

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
