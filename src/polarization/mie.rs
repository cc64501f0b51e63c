//! Scattering by one homogeneous sphere of any size (Lorenz and Mie; Bohren and Huffman 1983,
//! "Absorption and Scattering of Light by Small Particles", chapter 4), in `f64` only: phase
//! functions are tabulated from it once.
//!
//! The book's fields go as `exp(-i w t)` and its `m` is `n + i k`; inside, so do these. What comes
//! out follows the module's convention: `M00 = S11, M01 = -S12, M22 = S33, M23 = S34`.

use crate::math::elementary::{cbrt, cos, sin};

use std::f64::consts::PI;
use std::ops::{Add, Div, Mul, Sub};

use super::kernel::Block;

/// A complex number, `re + i im`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Complex {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
}

impl Complex {
    const ZERO: Self = Self { re: 0.0, im: 0.0 };

    fn new(re: f64, im: f64) -> Self {
        Self { re, im }
    }

    fn real(re: f64) -> Self {
        Self { re, im: 0.0 }
    }

    fn conjugate(self) -> Self {
        Self { re: self.re, im: -self.im }
    }

    /// Squared modulus.
    pub fn norm(self) -> f64 {
        self.re * self.re + self.im * self.im
    }

    fn scaled(self, factor: f64) -> Self {
        Self { re: self.re * factor, im: self.im * factor }
    }
}

impl Add for Complex {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { re: self.re + other.re, im: self.im + other.im }
    }
}

impl Sub for Complex {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { re: self.re - other.re, im: self.im - other.im }
    }
}

impl Mul for Complex {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self {
            re: self.re * other.re - self.im * other.im,
            im: self.re * other.im + self.im * other.re,
        }
    }
}

impl Div for Complex {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        (self * other.conjugate()).scaled(1.0 / other.norm())
    }
}

/// The phase matrix of spheres at one angle, in 1/sr: `M11 = M00` and `M33 = M22`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseElements {
    /// Phase function; integrates to one over the sphere of directions.
    pub m00: f64,
    /// Positive where unpolarized light becomes polarized across the scattering plane.
    pub m01: f64,
    /// Linear polarization at 45 degrees, and circular, kept.
    pub m22: f64,
    /// Circular made linear at 45 degrees.
    pub m23: f64,
}

impl PhaseElements {
    /// `M00` and the kernel relative to it.
    pub fn block(self) -> (f64, Block<f64>) {
        let scale = 1.0 / self.m00;
        (self.m00, Block { a: self.m01 * scale, c: self.m22 * scale, s: self.m23 * scale })
    }
}

/// A sphere with its expansion coefficients, ready to be asked for any angle.
#[derive(Clone, Debug)]
pub struct MieSphere {
    size_parameter: f64,
    /// `(a_n, b_n)` from n = 1 on.
    coefficients: Vec<(Complex, Complex)>,
    /// Extinction cross-section over the geometric one.
    pub q_ext: f64,
    /// Scattering cross-section over the geometric one.
    pub q_sca: f64,
    /// Mean cosine of the scattering angle.
    pub g: f64,
}

impl MieSphere {
    /// A sphere of index `n - i k` relative to its host (`n > 0`, `k >= 0`, not `1 - 0 i`) and
    /// `size_parameter = 2 pi radius / wavelength in the host`, 1e-6 or above.
    pub fn new(n: f64, k: f64, size_parameter: f64) -> Self {
        let x = size_parameter;
        let coefficients = expand(Complex::new(n, k), x);
        let mut sphere = Self { size_parameter, coefficients, q_ext: 0.0, q_sca: 0.0, g: 0.0 };
        let mut backward = 0.0;
        for (index, &(a, b)) in sphere.coefficients.iter().enumerate() {
            let order = (index + 1) as f64;
            let weight = 2.0 * order + 1.0;
            sphere.q_ext += weight * (a.re + b.re);
            sphere.q_sca += weight * (a.norm() + b.norm());
            backward += weight / (order * (order + 1.0)) * (a * b.conjugate()).re;
            if let Some(&(a_next, b_next)) = sphere.coefficients.get(index + 1) {
                let neighbors = a * a_next.conjugate() + b * b_next.conjugate();
                backward += order * (order + 2.0) / (order + 1.0) * neighbors.re;
            }
        }
        sphere.g = 2.0 * backward / sphere.q_sca;
        sphere.q_ext *= 2.0 / (x * x);
        sphere.q_sca *= 2.0 / (x * x);
        sphere
    }

    /// The amplitudes `(S1, S2)`, perpendicular and parallel to the scattering plane, as phasors
    /// `exp(+i w t)` (the complex conjugates of the book's, equation 4.74).
    pub fn amplitudes(&self, cos_theta: f64) -> (Complex, Complex) {
        let (mut s1, mut s2) = (Complex::ZERO, Complex::ZERO);
        let (mut pi_previous, mut pi) = (0.0, 1.0);
        for (index, &(a, b)) in self.coefficients.iter().enumerate() {
            let order = (index + 1) as f64;
            let tau = order * cos_theta * pi - (order + 1.0) * pi_previous;
            let weight = (2.0 * order + 1.0) / (order * (order + 1.0));
            s1 = s1 + (a.scaled(pi) + b.scaled(tau)).scaled(weight);
            s2 = s2 + (a.scaled(tau) + b.scaled(pi)).scaled(weight);
            let climb = (2.0 * order + 1.0) * cos_theta * pi - (order + 1.0) * pi_previous;
            (pi_previous, pi) = (pi, climb / order);
        }
        (s1.conjugate(), s2.conjugate())
    }

    /// `(2n + 1) / (n (n + 1))` times `a_n + b_n` and `a_n - b_n`, as `[re, im, re, im]` from
    /// n = 1 on: what sums over many angles need.
    pub(super) fn series(&self) -> Vec<[f64; 4]> {
        let terms = self.coefficients.iter().zip(1u32..);
        terms
            .map(|(&(a, b), n)| {
                let order = f64::from(n);
                let weight = (2.0 * order + 1.0) / (order * (order + 1.0));
                let (sum, difference) = ((a + b).scaled(weight), (a - b).scaled(weight));
                [sum.re, sum.im, difference.re, difference.im]
            })
            .collect()
    }

    /// The phase matrix (equation 4.77 over `pi x^2 q_sca`); the x axis of both frames is the
    /// normal of the scattering plane.
    pub fn phase(&self, cos_theta: f64) -> PhaseElements {
        let (s1, s2) = self.amplitudes(cos_theta);
        let scale = 1.0 / (PI * self.size_parameter * self.size_parameter * self.q_sca);
        let cross = s2 * s1.conjugate();
        PhaseElements {
            m00: 0.5 * scale * (s1.norm() + s2.norm()),
            m01: 0.5 * scale * (s1.norm() - s2.norm()),
            m22: scale * cross.re,
            m23: -scale * cross.im,
        }
    }
}

/// The coefficients `(a_n, b_n)` (equation 4.88): eight more than Wiscombe 1980 found enough, which
/// takes the error of backscattered light from 1e-9 to 1e-12.
fn expand(m: Complex, x: f64) -> Vec<(Complex, Complex)> {
    let orders = (x + 4.05 * cbrt(x) + 10.0).ceil() as usize;
    let inside = logarithmic_derivatives(m.scaled(x), orders);
    let outside = logarithmic_derivatives(Complex::real(x), orders);
    // Riccati-Bessel functions: psi_n, and chi_n with xi_n = psi_n - i chi_n.
    let (mut psi_before, mut psi) = (cos(x), sin(x));
    let (mut chi_before, mut chi) = (-sin(x), cos(x));
    let mut coefficients = Vec::with_capacity(orders);
    for n in 1..=orders {
        let order = n as f64;
        // Upward recurrence of psi is unstable once n passes x; the ratio is not.
        let psi_next = if order < x {
            (2.0 * order - 1.0) / x * psi - psi_before
        } else {
            psi / (outside[n].re + order / x)
        };
        let chi_next = (2.0 * order - 1.0) / x * chi - chi_before;
        (psi_before, psi) = (psi, psi_next);
        (chi_before, chi) = (chi, chi_next);
        let (xi_before, xi) = (Complex::new(psi_before, -chi_before), Complex::new(psi, -chi));
        let coefficient = |derivative: Complex| {
            let factor = derivative + Complex::real(order / x);
            (factor.scaled(psi) - Complex::real(psi_before)) / (factor * xi - xi_before)
        };
        coefficients.push((coefficient(inside[n] / m), coefficient(inside[n] * m)));
    }
    coefficients
}

/// `D_n(z)`, the logarithmic derivatives of psi_n, for n = 0 to `orders` by downward recurrence
/// (equation 4.89).
///
/// It forgets its start only while n exceeds |z|, by a distance that grows as the cube root; the
/// customary |z| + 15 leaves errors of 1e-5 at |z| = 100 where nothing absorbs.
fn logarithmic_derivatives(z: Complex, orders: usize) -> Vec<Complex> {
    let modulus = z.norm().sqrt();
    let turning = orders.max(modulus.ceil() as usize);
    let start = turning + (8.0 * cbrt(modulus)).ceil() as usize + 16;
    let mut derivatives = vec![Complex::ZERO; start + 1];
    derivatives[start] = Complex::real((start + 1) as f64) / z;
    for n in (1..=start).rev() {
        let ratio = Complex::real(n as f64) / z;
        derivatives[n - 1] = ratio - Complex::real(1.0) / (derivatives[n] + ratio);
    }
    derivatives.truncate(orders + 1);
    derivatives
}
