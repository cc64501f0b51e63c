//! The number type of the leaf mathematics: written once, run in `f64` by the tests that compare
//! with published tables and in eight `f32` lanes by the stages.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::elementary;
use super::lanes::F32s;
use super::warp;

/// A real number, or eight of them side by side.
///
/// Comparison yields a [`Real::Mask`], and [`Real::select`] chooses without branching; both
/// branches are evaluated, so neither may trap.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The outcome of a comparison, one truth value per lane.
    type Mask: Copy;

    /// The constant `value` in every lane, rounded to the precision at hand.
    fn splat(value: f64) -> Self;
    /// `self * factor + addend`; fused where the processor has it.
    fn mul_add(self, factor: Self, addend: Self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Magnitude.
    fn abs(self) -> Self;
    /// The smaller of the two.
    fn min(self, other: Self) -> Self;
    /// The larger of the two.
    fn max(self, other: Self) -> Self;
    /// e to the power of it.
    fn exp(self) -> Self;
    /// Sine and cosine of an angle in turns: of many, no digits are lost but those that are not
    /// there.
    fn sin_cos_turns(self) -> (Self, Self);
    /// The angle of the point that has `x` to the right and `self` upwards, from -pi to pi.
    fn atan2(self, x: Self) -> Self;
    /// Where `self < other`.
    fn lt(self, other: Self) -> Self::Mask;
    /// Where `self > other`.
    fn gt(self, other: Self) -> Self::Mask;
    /// `if_true` where the mask holds, `if_false` elsewhere.
    fn select(mask: Self::Mask, if_true: Self, if_false: Self) -> Self;

    /// Zero.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }
    /// One.
    #[inline(always)]
    fn one() -> Self {
        Self::splat(1.0)
    }
}

macro_rules! scalar_real {
    ($float:ty) => {
        impl Real for $float {
            type Mask = bool;
            #[inline(always)]
            fn splat(value: f64) -> Self {
                value as $float
            }
            #[inline(always)]
            fn mul_add(self, factor: Self, addend: Self) -> Self {
                <$float>::mul_add(self, factor, addend)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                <$float>::sqrt(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                <$float>::abs(self)
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                <$float>::min(self, other)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                <$float>::max(self, other)
            }
            #[inline(always)]
            fn exp(self) -> Self {
                elementary::exp(self)
            }
            #[inline(always)]
            fn sin_cos_turns(self) -> (Self, Self) {
                elementary::sin_cos((self - self.round()) * (std::f64::consts::TAU as $float))
            }
            #[inline(always)]
            fn atan2(self, x: Self) -> Self {
                elementary::atan2(self, x)
            }
            #[inline(always)]
            fn lt(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn gt(self, other: Self) -> bool {
                self > other
            }
            #[inline(always)]
            fn select(mask: bool, if_true: Self, if_false: Self) -> Self {
                if mask { if_true } else { if_false }
            }
        }
    };
}

scalar_real!(f32);
scalar_real!(f64);

impl Real for F32s {
    type Mask = F32s;
    #[inline(always)]
    fn splat(value: f64) -> Self {
        F32s::splat(value as f32)
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        F32s::mul_add(self, factor, addend)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        F32s::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        F32s::abs(self)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        F32s::fast_min(self, other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        F32s::fast_max(self, other)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        F32s::exp(self)
    }
    #[inline(always)]
    fn sin_cos_turns(self) -> (Self, Self) {
        warp::sin_cos_turns(self - self.floor())
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        F32s::atan2(self, x)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Self {
        self.simd_lt(other)
    }
    #[inline(always)]
    fn gt(self, other: Self) -> Self {
        self.simd_gt(other)
    }
    #[inline(always)]
    fn select(mask: Self, if_true: Self, if_false: Self) -> Self {
        mask.select(if_true, if_false)
    }
}
