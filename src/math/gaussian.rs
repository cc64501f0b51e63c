//! The error function and its inverse: how much of a Gaussian is up to a place, and where so much
//! of it is.

use super::{F32s, Real};

/// The error function, off by 4e-7 at most (Abramowitz and Stegun 1964, "Handbook of mathematical
/// functions", equation 7.1.26).
#[inline(always)]
pub fn erf(x: F32s) -> F32s {
    let one = F32s::splat(1.0);
    let size = x.abs();
    let t = one / F32s::splat(0.327_591_1).mul_add(size, one);
    let terms = [1.061_405_4, -1.453_152, 1.421_413_7, -0.284_496_74, 0.254_829_6];
    let rest = polynomial(&terms, t) * t * (-(size * size)).exp();
    let value = one - rest;
    Real::select(x.simd_lt(F32s::splat(0.0)), -value, value)
}

/// The inverse of [`erf`] within (-1, 1), off by 1e-6 of itself at most (Giles 2010,
/// "Approximating the erfinv function").
#[inline(always)]
pub fn erf_inverse(x: F32s) -> F32s {
    const MIDDLE: [f32; 9] = [
        2.810_226_4e-8,
        3.432_739_4e-7,
        -3.523_387_7e-6,
        -4.391_506_5e-6,
        2.185_808_7e-4,
        -1.253_725e-3,
        -4.177_681_6e-3,
        0.246_640_73,
        1.501_409_4,
    ];
    const TAIL: [f32; 9] = [
        -2.002_142_6e-4,
        1.009_505_6e-4,
        1.349_343_2e-3,
        -3.673_428_4e-3,
        5.739_507_7e-3,
        -7.622_461e-3,
        9.438_870_5e-3,
        1.001_674,
        2.832_976_8,
    ];
    let one = F32s::splat(1.0);
    let left = ((one - x) * (one + x)).fast_max(F32s::splat(f32::MIN_POSITIVE));
    let depth = -left.ln();
    let middle = polynomial(&MIDDLE, depth - F32s::splat(2.5));
    let tail = polynomial(&TAIL, depth.fast_max(F32s::splat(0.0)).sqrt() - F32s::splat(3.0));
    x * Real::select(depth.simd_lt(F32s::splat(5.0)), middle, tail)
}

/// The coefficients from the highest power on.
#[inline(always)]
fn polynomial(terms: &[f32], x: F32s) -> F32s {
    let mut sum = F32s::splat(0.0);
    for term in terms {
        sum = sum.mul_add(x, F32s::splat(*term));
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Abramowitz and Stegun 1964, table 7.1.
    const TABLE: [(f32, f64); 7] = [
        (0.0, 0.0),
        (0.1, 0.112_462_916_0),
        (0.5, 0.520_499_877_8),
        (1.0, 0.842_700_792_9),
        (1.5, 0.966_105_146_5),
        (2.0, 0.995_322_265_0),
        (3.0, 0.999_977_909_5),
    ];

    fn of(function: fn(F32s) -> F32s, x: f32) -> f64 {
        f64::from(function(F32s::splat(x)).to_array()[3])
    }

    #[test]
    fn values_are_those_of_the_table() {
        for (x, expected) in TABLE {
            for sign in [1.0, -1.0] {
                let found = of(erf, sign * x);
                assert!((found - f64::from(sign) * expected).abs() < 4e-7, "{x}: {found}");
            }
        }
    }

    #[test]
    fn the_inverse_leads_back() {
        for (x, value) in TABLE.into_iter().filter(|(x, _)| *x < 2.5) {
            let found = of(erf_inverse, value as f32);
            // The slope there takes away digits of the value.
            let slope =
                std::f64::consts::FRAC_2_SQRT_PI * crate::math::elementary::exp(-f64::from(x * x));
            let allowed = 1e-6 * f64::from(x) + 6e-8 / slope;
            assert!((found - f64::from(x)).abs() <= allowed, "{x}: {found}");
        }
        for end in [1.0, -1.0] {
            assert!(of(erf_inverse, end).is_finite());
        }
    }
}
