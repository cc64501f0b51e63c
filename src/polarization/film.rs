//! One thin film on a smooth interface: all reflections within it interfere (Airy's sums; Born and
//! Wolf, 7th ed., 1.6.4), as complex amplitudes of both polarizations.
//!
//! With the amplitudes `r01` and `r12` of the film's two faces, `x = exp(-4 pi i w g1)` of a way
//! there and back, `w` the thickness in wavelengths and `g1 = n1 cos t1`:
//!
//! ```text
//! r = r01 + b x / (1 - q x),    b = (1 - r01^2) r12,    q = -r01 r12
//! ```
//!
//! Films are measured by light of more than one wavelength where a channel stands for a range of
//! them, and the products `r_p conj(r_s)` that Mueller matrices are made of then are means. They
//! are series in `exp(-i k phi)`, and over a line of Lorentz's shape the harmonic `k` loses
//! `exp(-k s phi)`, where `s` is the half-width over the wavelength: the mean is a sum in closed
//! form again, whatever the thickness, and a mixture of physical matrices. (Belcour and Barla 2017,
//! "A practical extension to microfacet theory for the modeling of varying iridescence", say why
//! three wavelengths alone are not enough.)

use super::kernel::Block;
use crate::math::Real;

/// Keeps denominators off zero that only grazing light reaches; its square is a normal number in
/// `f32`.
const TINY: f64 = 1e-18;

/// A film of index `eta - i k`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Film<F> {
    /// Real part of the index of refraction, greater than 0.
    pub eta: F,
    /// Extinction coefficient, 0 or above.
    pub k: F,
    /// Thickness in vacuum wavelengths, 0 or above.
    pub waves: F,
    /// Half of the width of what the wavelength stands for, over the wavelength; 0 for itself.
    pub spread: F,
}

/// What an interface with a film does to light that arrives on one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filmed<F> {
    /// Reflected fraction of unpolarized power; 0 to 1.
    pub reflectance: F,
    /// Reflection relative to `reflectance`.
    pub reflection: Block<F>,
    /// Refracted fraction of unpolarized power: what is not reflected, if the film does not absorb.
    pub transmittance: F,
    /// Refraction relative to `transmittance`; the identity where nothing is refracted.
    pub transmission: Block<F>,
    /// Cosine of the angle of refraction, 0 to 1; 0 in total reflection.
    pub cos_t: F,
}

#[derive(Clone, Copy)]
struct Complex<F> {
    re: F,
    im: F,
}

impl<F: Real> Complex<F> {
    #[inline(always)]
    fn real(re: F) -> Self {
        Self { re, im: F::zero() }
    }

    #[inline(always)]
    fn select(mask: F::Mask, if_true: Self, if_false: Self) -> Self {
        Self {
            re: F::select(mask, if_true.re, if_false.re),
            im: F::select(mask, if_true.im, if_false.im),
        }
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self { re: self.re + other.re, im: self.im + other.im }
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self { re: self.re - other.re, im: self.im - other.im }
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        Self {
            re: self.re * other.re - self.im * other.im,
            im: self.re * other.im + self.im * other.re,
        }
    }

    #[inline(always)]
    fn scaled(self, factor: F) -> Self {
        Self { re: self.re * factor, im: self.im * factor }
    }

    #[inline(always)]
    fn conjugate(self) -> Self {
        Self { re: self.re, im: -self.im }
    }

    #[inline(always)]
    fn norm(self) -> F {
        self.re.mul_add(self.re, self.im * self.im)
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        let scale = F::one() / other.norm().max(F::splat(TINY * TINY));
        self.times(other.conjugate()).scaled(scale)
    }
}

/// What light meets on one side of a face: the square of the index, and `g = n cos t`, whose square
/// is that less `u`; of it `Im g <= 0`.
#[derive(Clone, Copy)]
struct Layer<F> {
    squared: Complex<F>,
    g: Complex<F>,
}

impl<F: Real> Layer<F> {
    /// Of index `eta - i k`, for the square `u` of index times sine, which all layers share.
    #[inline(always)]
    fn of(eta: F, k: F, u: F) -> Self {
        let half = F::splat(0.5);
        let product = eta * k;
        let squared = Complex { re: (eta - k) * (eta + k), im: -(product + product) };
        let difference = squared.re - u;
        let modulus = difference.mul_add(difference, squared.im * squared.im).sqrt();
        // The larger part first, for the other cancels.
        let larger = (half * (modulus + difference.abs())).sqrt();
        let smaller = product / larger.max(F::splat(TINY));
        let decays = difference.lt(F::zero());
        let re = F::select(decays, smaller, larger);
        let im = -F::select(decays, larger, smaller);
        Self { squared, g: Complex { re, im } }
    }
}

/// Amplitudes of s and p at a face, p with the sign of Verdet.
#[derive(Clone, Copy)]
struct Face<F> {
    reflected: [Complex<F>; 2],
    /// Of the fields along the face.
    refracted: [Complex<F>; 2],
}

impl<F: Real> Face<F> {
    #[inline(always)]
    fn between(before: &Layer<F>, behind: &Layer<F>) -> Self {
        let [p, q] = [behind.squared.times(before.g), before.squared.times(behind.g)];
        let (s_sum, p_sum) = (before.g.plus(behind.g), p.plus(q));
        Self {
            reflected: [before.g.minus(behind.g).over(s_sum), p.minus(q).over(p_sum)],
            refracted: [before.g.plus(before.g).over(s_sum), q.plus(q).over(p_sum)],
        }
    }
}

/// A series `a + b x / (1 - q x)` of amplitudes.
#[derive(Clone, Copy)]
struct Series<F> {
    a: Complex<F>,
    b: Complex<F>,
    q: Complex<F>,
}

/// What a film does to the phase: `x`, which is `damped` for means, and `|x|^2`.
#[derive(Clone, Copy)]
struct Delay<F: Real> {
    damped: Complex<F>,
    norm: F,
    /// Where nothing is damped, and products are no means.
    is_sharp: F::Mask,
}

/// Means have series that converge where the square of `q x` is less than 1: that of an evanescent
/// wave, or in a metal, may not be, but there are no fringes either. From here on less is damped,
/// and at 0.2 more nothing.
const DAMPED: f64 = 0.75;

impl<F: Real> Delay<F> {
    /// Of a film, its `g`, and the squares of the `q` of both polarizations.
    #[inline(always)]
    fn of(film: &Film<F>, g: Complex<F>, q_squared: [F; 2]) -> Self {
        let (twice, radians) = (film.waves + film.waves, F::splat(std::f64::consts::TAU));
        let (turns, decay) = (twice * g.re, -(radians * twice * g.im));
        let norm = (-(decay + decay)).exp();
        let ratio = q_squared[0].max(q_squared[1]) * norm;
        let share = (F::splat(5.0 * (DAMPED + 0.2)) - F::splat(5.0) * ratio).min(F::one());
        let damping = (radians * turns * film.spread * share).max(F::zero());
        let (sin, cos) = turns.sin_cos_turns();
        let x = Complex { re: cos, im: -sin };
        let damped = x.scaled((-(decay + damping)).exp());
        Self { damped, norm, is_sharp: F::lt(damping, F::splat(f64::from(f32::MIN_POSITIVE))) }
    }
}

impl<F: Real> Series<F> {
    /// `b x / (1 - q x)` of the mean.
    #[inline(always)]
    fn tail(&self, delay: &Delay<F>) -> Complex<F> {
        let bx = self.b.times(delay.damped);
        bx.over(Complex::real(F::one()).minus(self.q.times(delay.damped)))
    }

    /// The mean of the product of one with the conjugate of another.
    #[inline(always)]
    fn product(&self, other: &Self, delay: &Delay<F>) -> Complex<F> {
        let [left, right] = [self.tail(delay), other.tail(delay).conjugate()];
        let [a, a2] = [self.a, other.a.conjugate()];
        let one = Complex::real(F::one());
        let qq = self.q.times(other.q.conjugate()).scaled(delay.norm);
        let inverse = Complex::real(delay.norm).over(one.minus(qq));
        let later = other.b.conjugate().times(self.q).times(inverse);
        let earlier = self.b.times(other.q.conjugate()).times(inverse);
        let bb = self.b.times(other.b.conjugate()).times(inverse);
        let even = a.times(a2).plus(bb);
        let mean = even.plus(left.times(a2.plus(later))).plus(right.times(a.plus(earlier)));
        Complex::select(delay.is_sharp, a.plus(left).times(a2.plus(right)), mean)
    }
}

/// `M00` and the block of a field whose s and p have these powers, and `product` is that of p with
/// the conjugate of s.
#[inline(always)]
fn block_of<F: Real>([s, p]: [F; 2], product: Complex<F>) -> (F, Block<F>) {
    let half = F::splat(0.5);
    let m00 = (s + p) * half;
    let over = F::select(m00.gt(F::zero()), F::one() / m00, F::zero());
    let block = Block { a: (s - p) * half * over, c: product.re * over, s: -(product.im * over) };
    (m00, Block::select(m00.gt(F::zero()), block, Block::identity()))
}

/// The layers about a film, with its faces and its delay.
struct Stack<F: Real> {
    layers: [Layer<F>; 3],
    faces: [Face<F>; 2],
    delay: Delay<F>,
}

impl<F: Real> Stack<F> {
    #[inline(always)]
    fn of(cos_i: F, before: F, film: &Film<F>, [eta, k]: [F; 2]) -> Self {
        let sin2 = (-cos_i).mul_add(cos_i, F::one()).max(F::zero());
        let u = before * before * sin2;
        let g0 = Complex::real(before * cos_i);
        let first = Layer { squared: Complex::real(before * before), g: g0 };
        let layers = [first, Layer::of(film.eta, film.k, u), Layer::of(eta, k, u)];
        let faces = [Face::between(&layers[0], &layers[1]), Face::between(&layers[1], &layers[2])];
        let q_squared = |of: usize| faces[0].reflected[of].times(faces[1].reflected[of]).norm();
        Self { layers, faces, delay: Delay::of(film, layers[1].g, [q_squared(0), q_squared(1)]) }
    }

    /// Amplitudes of reflection, of s and of p.
    #[inline(always)]
    fn reflected(&self, of: usize) -> Series<F> {
        let [first, second] = [self.faces[0].reflected[of], self.faces[1].reflected[of]];
        let both = first.times(second);
        let b = second.minus(first.times(both));
        Series { a: first, b, q: both.scaled(-F::one()) }
    }

    #[inline(always)]
    fn reflection(&self) -> (F, Block<F>) {
        let [s, p] = [self.reflected(0), self.reflected(1)];
        let of = |series: &Series<F>| series.product(series, &self.delay).re.max(F::zero());
        let (m00, block) = block_of([of(&s), of(&p)], p.product(&s, &self.delay));
        (m00.min(F::one()), block)
    }

    /// Powers of s and p that are refracted, and the product of p with the conjugate of s, where
    /// both indices are real. Amplitudes are `t y / (1 - q x)`, where `y^2 = x`.
    #[inline(always)]
    fn transmission(&self) -> ([F; 2], Complex<F>) {
        let [n0, n2] = [&self.layers[0], &self.layers[2]];
        let one = Complex::real(F::one());
        let amplitude = |of: usize| {
            let t = self.faces[0].refracted[of].times(self.faces[1].refracted[of]);
            (t, self.reflected(of).q)
        };
        let [s, p] = [amplitude(0), amplitude(1)];
        let decay = self.delay.norm.sqrt();
        let later = |q: Complex<F>| {
            let qx = q.times(self.delay.damped);
            qx.over(one.minus(qx))
        };
        let product = |(t, q): (Complex<F>, Complex<F>), (t2, q2): (Complex<F>, Complex<F>)| {
            let qq = q.times(q2.conjugate()).scaled(self.delay.norm);
            let [left, right] = [later(q), later(q2).conjugate()];
            let mean = one.plus(left).plus(right).over(one.minus(qq));
            let sharp = one.plus(left).times(one.plus(right));
            let sum = Complex::select(self.delay.is_sharp, sharp, mean);
            t.times(t2.conjugate()).scaled(decay).times(sum)
        };
        let index = (n2.squared.re / n0.squared.re).sqrt();
        let cosines = n2.g.re / n0.g.re.max(F::splat(TINY));
        let powers = [
            product(s, s).re * cosines,
            // The admittances of p are squares of indices over g.
            product(p, p).re * index * index / cosines.max(F::splat(TINY)),
        ];
        (powers, product(p, s).scaled(index))
    }
}

/// Reflection at a smooth conductor of index `eta - i k` under a film, both relative to what is
/// outside: `M00`, and the kernel relative to it. `cos_i` in 0 to 1.
#[inline(always)]
pub fn filmed_conductor<F: Real>(cos_i: F, film: &Film<F>, index: [F; 2]) -> (F, Block<F>) {
    Stack::of(cos_i, F::one(), film, index).reflection()
}

/// A smooth interface of two dielectrics with a film between them. `cos_i` in 0 to 1 is measured on
/// the side where the light arrives; the indices of refraction are before and behind.
#[inline(always)]
pub fn filmed_dielectric<F: Real>(cos_i: F, film: &Film<F>, [before, behind]: [F; 2]) -> Filmed<F> {
    let stack = Stack::of(cos_i, before, film, [behind, F::zero()]);
    let (reflected, reflection) = stack.reflection();
    let refracts = stack.layers[2].g.re.gt(F::zero());
    let (powers, product) = stack.transmission();
    let (refracted, transmission) = block_of(powers, product);
    let absorbs = film.k.gt(F::zero());
    let one = F::one();
    // Without absorption, what is not reflected is refracted, and all of it in total reflection.
    let reflectance = F::select(refracts, reflected, F::select(absorbs, reflected, one));
    let rest = one - reflectance;
    let transmittance = F::select(absorbs, refracted.min(rest), rest);
    Filmed {
        reflectance,
        reflection,
        transmittance: F::select(refracts, transmittance, F::zero()),
        transmission: Block::select(refracts, transmission, Block::identity()),
        cos_t: stack.layers[2].g.re / behind,
    }
}
