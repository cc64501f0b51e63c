//! Elementary functions with the same bits everywhere.
//!
//! Those of the standard library are the system's, and the system chooses among several by the
//! processor, with other last bits: images would depend on where they are rendered. These are the
//! crate `libm`'s, compiled with the program. What IEEE 754 defines to the last bit (square roots,
//! `mul_add`, rounding, remainders) is everywhere the same; lanes have functions of their own.

macro_rules! elementary {
    ($($(#[$doc:meta])* $name:ident($($argument:ident),+): $single:ident, $double:ident;)+) => {
        /// Single or double precision.
        pub trait Float: Copy + functions::Of {}
        impl Float for f32 {}
        impl Float for f64 {}

        mod functions {
            /// The functions of a precision, in the order of the table.
            pub trait Of: Sized {
                $(fn $name($($argument: Self),+) -> Self;)+
            }
            impl Of for f32 {
                $(#[inline(always)] fn $name($($argument: Self),+) -> Self {
                    libm::$single($($argument),+)
                })+
            }
            impl Of for f64 {
                $(#[inline(always)] fn $name($($argument: Self),+) -> Self {
                    libm::$double($($argument),+)
                })+
            }
        }

        $($(#[$doc])* #[inline(always)]
        pub fn $name<F: Float>($($argument: F),+) -> F {
            functions::Of::$name($($argument),+)
        })+
    };
}

elementary! {
    /// Sine of an angle in radians.
    sin(x): sinf, sin;
    /// Cosine of an angle in radians.
    cos(x): cosf, cos;
    /// Tangent of an angle in radians.
    tan(x): tanf, tan;
    /// The angle in [0, pi] that has this cosine.
    acos(x): acosf, acos;
    /// The angle of the point (x, y) from the axis of x, in [-pi, pi].
    atan2(y, x): atan2f, atan2;
    /// e to the power of x.
    exp(x): expf, exp;
    /// 2 to the power of x.
    exp2(x): exp2f, exp2;
    /// e to the power of x, less one.
    exp_m1(x): expm1f, expm1;
    /// Natural logarithm.
    ln(x): logf, log;
    /// Natural logarithm of 1 + x.
    ln_1p(x): log1pf, log1p;
    /// Logarithm to base 2.
    log2(x): log2f, log2;
    /// Logarithm to base 10.
    log10(x): log10f, log10;
    /// x to the power of y.
    pow(x, y): powf, pow;
    /// Cube root.
    cbrt(x): cbrtf, cbrt;
    /// Length of the vector (x, y), without overflow on the way.
    hypot(x, y): hypotf, hypot;
}

/// Sine and cosine of an angle in radians.
#[inline(always)]
pub fn sin_cos<F: Float>(x: F) -> (F, F) {
    (sin(x), cos(x))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A function here, and the system's.
    type Pair = (fn(f64) -> f64, fn(f64) -> f64);

    #[test]
    fn values_are_those_of_the_system_but_for_the_last_bits() {
        let pairs: [Pair; 14] = [
            (sin, f64::sin),
            (cos, f64::cos),
            (tan, f64::tan),
            (|x| acos(x % 1.0), |x| (x % 1.0).acos()),
            (exp, f64::exp),
            (exp2, f64::exp2),
            (exp_m1, f64::exp_m1),
            (|x| ln(x.abs()), |x| x.abs().ln()),
            (|x| ln_1p(x.abs()), |x| x.abs().ln_1p()),
            (|x| log2(x.abs()), |x| x.abs().log2()),
            (|x| log10(x.abs()), |x| x.abs().log10()),
            (cbrt, f64::cbrt),
            (|x| sin_cos(x).0, f64::sin),
            (|x| sin_cos(x).1, f64::cos),
        ];
        for (number, (found, expected)) in pairs.into_iter().enumerate() {
            for step in -3000..3000 {
                let x = f64::from(step) * 0.01 + 1e-5;
                let (found, expected) = (found(x), expected(x));
                let bound = 4.0 * f64::EPSILON * expected.abs().max(f64::MIN_POSITIVE);
                assert!((found - expected).abs() <= bound, "{number} at {x}: {found}, {expected}");
            }
        }
    }

    #[test]
    fn functions_of_two_are_too() {
        for (a, b) in (-40..40).flat_map(|a| (-40..40).map(move |b| (a, b))) {
            let (a, b) = (0.3 * f64::from(a) + 1e-3, 0.7 * f64::from(b) + 1e-3);
            for (found, expected) in [
                (atan2(a, b), a.atan2(b)),
                (hypot(a, b), a.hypot(b)),
                (pow(a.abs(), b), a.abs().powf(b)),
            ] {
                assert!((found - expected).abs() <= 4.0 * f64::EPSILON * expected.abs());
            }
        }
    }

    #[test]
    fn single_precision_is_that_of_the_double() {
        for step in -3000..3000 {
            let x = step as f32 * 0.01 + 1e-5;
            let wide = f64::from(x);
            for (found, expected) in [
                (sin(x), sin(wide)),
                (cos(x), cos(wide)),
                (exp(x), exp(wide)),
                (ln(x.abs()), ln(wide.abs())),
                (pow(x.abs(), 2.4), pow(wide.abs(), f64::from(2.4_f32))),
            ] {
                let error = (f64::from(found) - expected).abs();
                assert!(error <= 2.0 * f64::from(f32::EPSILON) * expected.abs(), "{x}: {found}");
            }
        }
    }
}
