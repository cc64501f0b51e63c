//! Three-component vectors over any [`Real`]: one vector in `f64`, or eight in lanes.

use std::ops::{Add, Mul, Neg, Sub};

use super::{F32s, LANES, Real, lanes};

/// A vector in world space unless its name says otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vector<F> {
    /// First component.
    pub x: F,
    /// Second component.
    pub y: F,
    /// Third component.
    pub z: F,
}

impl<F: Real> Vector<F> {
    /// The vector (x, y, z).
    #[inline(always)]
    pub fn new(x: F, y: F, z: F) -> Self {
        Self { x, y, z }
    }

    /// Inner product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> F {
        self.x.mul_add(other.x, self.y.mul_add(other.y, self.z * other.z))
    }

    /// Right-handed cross product.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    /// Squared length.
    #[inline(always)]
    pub fn length_squared(self) -> F {
        self.dot(self)
    }

    /// Length.
    #[inline(always)]
    pub fn length(self) -> F {
        self.length_squared().sqrt()
    }

    /// The vector of length one along `self`; not a number for the zero vector.
    #[inline(always)]
    pub fn normalize(self) -> Self {
        self * (F::one() / self.length())
    }

    /// `self * factor + addend`, component by component.
    #[inline(always)]
    pub fn mul_add(self, factor: F, addend: Self) -> Self {
        Self {
            x: self.x.mul_add(factor, addend.x),
            y: self.y.mul_add(factor, addend.y),
            z: self.z.mul_add(factor, addend.z),
        }
    }

    /// `if_true` where the mask holds, `if_false` elsewhere.
    #[inline(always)]
    pub fn select(mask: F::Mask, if_true: Self, if_false: Self) -> Self {
        Self {
            x: F::select(mask, if_true.x, if_false.x),
            y: F::select(mask, if_true.y, if_false.y),
            z: F::select(mask, if_true.z, if_false.z),
        }
    }

    /// A unit vector perpendicular to the unit vector `self`, continuous except across z = 0
    /// (Duff et al. 2017, "Building an orthonormal basis, revisited", first basis vector).
    #[inline(always)]
    pub fn any_perpendicular(self) -> Self {
        let sign = F::select(self.z.lt(F::zero()), F::splat(-1.0), F::one());
        let a = -F::one() / (sign + self.z);
        let xa = self.x * a;
        Self { x: F::one() + sign * self.x * xa, y: sign * self.y * xa, z: -(sign * self.x) }
    }
}

impl Vector<F32s> {
    /// One vector in all lanes.
    #[inline(always)]
    pub fn splat(vector: impl Into<[f32; 3]>) -> Self {
        let [x, y, z] = vector.into();
        Self { x: F32s::splat(x), y: F32s::splat(y), z: F32s::splat(z) }
    }

    /// Reads eight rows from three columns.
    #[inline(always)]
    pub fn load(columns: &[Vec<f32>; 3], row: usize) -> Self {
        Self {
            x: lanes::load(&columns[0], row),
            y: lanes::load(&columns[1], row),
            z: lanes::load(&columns[2], row),
        }
    }

    /// Writes the rows from `row` to `end`, at most eight, to three columns.
    #[inline(always)]
    pub fn store(self, columns: &mut [Vec<f32>; 3], row: usize, end: usize) {
        lanes::store(&mut columns[0], row, end, self.x);
        lanes::store(&mut columns[1], row, end, self.y);
        lanes::store(&mut columns[2], row, end, self.z);
    }

    /// Gathers one vector per lane.
    #[inline(always)]
    pub fn gather(vector_of_lane: impl Fn(usize) -> [f32; 3]) -> Self {
        let rows = lanes::each(vector_of_lane);
        let column = |axis: usize| F32s::from(lanes::each(|lane| rows[lane][axis]));
        Self { x: column(0), y: column(1), z: column(2) }
    }

    /// The vector of one lane.
    #[inline(always)]
    pub fn lane(self, lane: usize) -> Vector<f32> {
        let Self { x, y, z } = self;
        Vector { x: x.to_array()[lane], y: y.to_array()[lane], z: z.to_array()[lane] }
    }

    /// The vectors of all lanes.
    #[inline(always)]
    pub fn to_rows(self) -> [[f32; 3]; LANES] {
        let [x, y, z] = [self.x, self.y, self.z].map(F32s::to_array);
        std::array::from_fn(|lane| [x[lane], y[lane], z[lane]])
    }
}

impl<F> From<[F; 3]> for Vector<F> {
    #[inline(always)]
    fn from([x, y, z]: [F; 3]) -> Self {
        Self { x, y, z }
    }
}

impl<F> From<Vector<F>> for [F; 3] {
    #[inline(always)]
    fn from(Vector { x, y, z }: Vector<F>) -> Self {
        [x, y, z]
    }
}

impl<F: Real> Add for Vector<F> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<F: Real> Sub for Vector<F> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<F: Real> Mul<F> for Vector<F> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: F) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

impl<F: Real> Neg for Vector<F> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}
