//! Mueller matrices relative to their first element, by how many elements they really have.

use super::frame::Rotation;
use super::stokes::Stokes;
use crate::math::Real;

/// A Mueller matrix `M / M00` between the incoming and outgoing frames of an event.
pub trait Kernel<F: Real>: Copy {
    /// `M S`: light that passes the event.
    fn scatter(self, stokes: Stokes<F>) -> Stokes<F>;

    /// `r M`: one row of the sensor's matrix, extended by the event towards the light.
    fn collect_row(self, row: [F; 4]) -> [F; 4];

    /// `M e0`: unpolarized light that has passed the event.
    #[inline(always)]
    fn first_stokes(self) -> Stokes<F> {
        self.scatter(Stokes::unpolarized())
    }

    /// `e0^T M`: a sensor of intensity in front of the event.
    #[inline(always)]
    fn first_row(self) -> [F; 4] {
        self.collect_row(Stokes::unpolarized().0)
    }

    /// `T M`: the sensor's whole matrix `matrix[row][column]`, extended by the event.
    #[inline(always)]
    fn collect_columns(self, matrix: [[F; 4]; 4]) -> [[F; 4]; 4] {
        // Not `map`, which is not always inlined.
        let [first, second, third, fourth] = matrix;
        [
            self.collect_row(first),
            self.collect_row(second),
            self.collect_row(third),
            self.collect_row(fourth),
        ]
    }

    /// `R M`, the sensor's matrix after its first event. `rotation` leads from the event's
    /// outgoing axis to the film's.
    #[inline(always)]
    fn first_event(self, rotation: Rotation<F>) -> [[F; 4]; 4] {
        let Rotation { cos2, sin2 } = rotation;
        let (zero, one) = (F::zero(), F::one());
        self.collect_columns([
            [one, zero, zero, zero],
            [zero, cos2, sin2, zero],
            [zero, -sin2, cos2, zero],
            [zero, zero, zero, one],
        ])
    }
}

/// `[[1,a,0,0],[a,1,0,0],[0,0,c,s],[0,0,-s,c]]`: interfaces, polarizers, retarders and spheres.
///
/// Physical where `a^2 + c^2 + s^2 <= 1`, with equality for an event that depolarizes nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block<F> {
    /// Diattenuation along the s axis, `(M_s - M_p) / (M_s + M_p)`; -1 to 1.
    pub a: F,
    /// Cosine part of the retardance, -1 to 1.
    pub c: F,
    /// Sine part of the retardance, -1 to 1; positive where the p phase lags the s phase.
    pub s: F,
}

impl<F: Real> Block<F> {
    /// The event that changes nothing.
    #[inline(always)]
    pub fn identity() -> Self {
        Self { a: F::zero(), c: F::one(), s: F::zero() }
    }

    /// `if_true` where the mask holds, `if_false` elsewhere.
    #[inline(always)]
    pub fn select(mask: F::Mask, if_true: Self, if_false: Self) -> Self {
        Self {
            a: F::select(mask, if_true.a, if_false.a),
            c: F::select(mask, if_true.c, if_false.c),
            s: F::select(mask, if_true.s, if_false.s),
        }
    }
}

impl Block<f64> {
    /// All sixteen elements, `[row][column]`.
    pub fn matrix(self) -> [[f64; 4]; 4] {
        let Self { a, c, s } = self;
        [[1.0, a, 0.0, 0.0], [a, 1.0, 0.0, 0.0], [0.0, 0.0, c, s], [0.0, 0.0, -s, c]]
    }
}

impl<F: Real> Kernel<F> for Block<F> {
    #[inline(always)]
    fn scatter(self, stokes: Stokes<F>) -> Stokes<F> {
        let [s0, s1, s2, s3] = stokes.0;
        Stokes([
            self.a.mul_add(s1, s0),
            self.a.mul_add(s0, s1),
            self.c.mul_add(s2, self.s * s3),
            self.c.mul_add(s3, -(self.s * s2)),
        ])
    }

    #[inline(always)]
    fn collect_row(self, row: [F; 4]) -> [F; 4] {
        let [r0, r1, r2, r3] = row;
        [
            self.a.mul_add(r1, r0),
            self.a.mul_add(r0, r1),
            self.c.mul_add(r2, -(self.s * r3)),
            self.c.mul_add(r3, self.s * r2),
        ]
    }

    #[inline(always)]
    fn first_stokes(self) -> Stokes<F> {
        Stokes([F::one(), self.a, F::zero(), F::zero()])
    }

    #[inline(always)]
    fn first_row(self) -> [F; 4] {
        [F::one(), self.a, F::zero(), F::zero()]
    }

    /// Four of the sixteen elements are zero and none needs an addition.
    #[inline(always)]
    fn first_event(self, rotation: Rotation<F>) -> [[F; 4]; 4] {
        let Rotation { cos2, sin2 } = rotation;
        let Self { a, c, s } = self;
        let (zero, one) = (F::zero(), F::one());
        [
            [one, a, zero, zero],
            [cos2 * a, cos2, sin2 * c, sin2 * s],
            [-(sin2 * a), -sin2, cos2 * c, cos2 * s],
            [zero, zero, -s, c],
        ]
    }
}

/// `[[1,a,0,0],[a,b,0,0],[0,0,c,s],[0,0,-s,d]]`: anisotropic molecules, and randomly oriented
/// particles with a plane of symmetry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpheroidBlock<F> {
    /// `M01 / M00`.
    pub a: F,
    /// `M11 / M00`.
    pub b: F,
    /// `M22 / M00`.
    pub c: F,
    /// `M33 / M00`.
    pub d: F,
    /// `M23 / M00`.
    pub s: F,
}

impl<F: Real> SpheroidBlock<F> {
    /// The same with its zeros.
    #[inline(always)]
    pub fn dense(self) -> Dense<F> {
        let Self { a, b, c, d, s } = self;
        let (zero, one) = (F::zero(), F::one());
        Dense([[one, a, zero, zero], [a, b, zero, zero], [zero, zero, c, s], [zero, zero, -s, d]])
    }
}

impl<F: Real> Kernel<F> for SpheroidBlock<F> {
    #[inline(always)]
    fn scatter(self, stokes: Stokes<F>) -> Stokes<F> {
        let [s0, s1, s2, s3] = stokes.0;
        Stokes([
            self.a.mul_add(s1, s0),
            self.a.mul_add(s0, self.b * s1),
            self.c.mul_add(s2, self.s * s3),
            self.d.mul_add(s3, -(self.s * s2)),
        ])
    }

    #[inline(always)]
    fn collect_row(self, row: [F; 4]) -> [F; 4] {
        let [r0, r1, r2, r3] = row;
        [
            self.a.mul_add(r1, r0),
            self.a.mul_add(r0, self.b * r1),
            self.c.mul_add(r2, -(self.s * r3)),
            self.d.mul_add(r3, self.s * r2),
        ]
    }

    #[inline(always)]
    fn first_stokes(self) -> Stokes<F> {
        Stokes([F::one(), self.a, F::zero(), F::zero()])
    }

    #[inline(always)]
    fn first_row(self) -> [F; 4] {
        [F::one(), self.a, F::zero(), F::zero()]
    }

    /// As sparse as that of a [`Block`].
    #[inline(always)]
    fn first_event(self, rotation: Rotation<F>) -> [[F; 4]; 4] {
        let Rotation { cos2, sin2 } = rotation;
        let Self { a, b, c, d, s } = self;
        let (zero, one) = (F::zero(), F::one());
        [
            [one, a, zero, zero],
            [cos2 * a, cos2 * b, sin2 * c, sin2 * s],
            [-(sin2 * a), -(sin2 * b), cos2 * c, cos2 * s],
            [zero, zero, -s, d],
        ]
    }
}

/// Sixteen elements `M / M00`, `[row][column]`: measured materials and models of diffuse
/// polarization.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dense<F>(pub [[F; 4]; 4]);

impl<F: Real> Dense<F> {
    /// The same between other axes: `arriving` leads from the new one to the old before the event,
    /// and `leaving` from the old one to the new behind it.
    #[inline(always)]
    pub fn turned(self, arriving: Rotation<F>, leaving: Rotation<F>) -> Self {
        let [first, second, third, fourth] = self.0;
        let collect = |row| arriving.collect_row(row);
        let [first, second, third, fourth] =
            [collect(first), collect(second), collect(third), collect(fourth)];
        let Rotation { cos2, sin2 } = leaving;
        let along = |a: F, b: F| cos2.mul_add(a, sin2 * b);
        let beside = |a: F, b: F| cos2.mul_add(b, -(sin2 * a));
        Self([
            first,
            std::array::from_fn(|n| along(second[n], third[n])),
            std::array::from_fn(|n| beside(second[n], third[n])),
            fourth,
        ])
    }

    /// Of light that goes the same way in the other direction through something straight on, where
    /// x is the same axis: reciprocity (Sekera 1966, "Scattering matrices and reciprocity
    /// relationships for various representations of the state of polarization") transposes Jones
    /// matrices, and y turns round with the light.
    #[inline(always)]
    pub fn reversed(&self) -> Self {
        let m = &self.0;
        Self([
            [m[0][0], m[1][0], -m[2][0], m[3][0]],
            [m[0][1], m[1][1], -m[2][1], m[3][1]],
            [-m[0][2], -m[1][2], m[2][2], -m[3][2]],
            [m[0][3], m[1][3], -m[2][3], m[3][3]],
        ])
    }
}

impl<F: Real> Kernel<F> for Dense<F> {
    #[inline(always)]
    fn scatter(self, stokes: Stokes<F>) -> Stokes<F> {
        let [first, second, third, fourth] = self.0;
        let of = |row| dot(row, stokes.0);
        Stokes([of(first), of(second), of(third), of(fourth)])
    }

    #[inline(always)]
    fn collect_row(self, row: [F; 4]) -> [F; 4] {
        let [m0, m1, m2, m3] = self.0;
        std::array::from_fn(|j| dot(row, [m0[j], m1[j], m2[j], m3[j]]))
    }
}

/// Inner product of four components, from the first to the last.
#[inline(always)]
pub(super) fn dot<F: Real>(row: [F; 4], column: [F; 4]) -> F {
    row[0] * column[0] + row[1] * column[1] + row[2] * column[2] + row[3] * column[3]
}
