//! Reflection and refraction at smooth interfaces (Fresnel's equations; Born and Wolf, 7th ed.,
//! 1.5.2 and 14.2), in a form that subtracts nothing nearly equal.
//!
//! With `u = sin^2 t_i`, `g = sqrt(eta^2 - u)` (`Im g <= 0`) and `v = g cos t_i`, the amplitudes
//! obey `r_s = (cos t_i - g) / (cos t_i + g)` and `r_p / r_s = (u - v) / (u + v)`. The kernel
//! depends on that ratio alone, and `C + i S = r_p conj(r_s)` becomes
//!
//! ```text
//! a = 2 u Re v / (u^2 + |v|^2)
//! c = (u^2 - |v|^2) / (u^2 + |v|^2)
//! s = 2 u Im v / (u^2 + |v|^2)
//! ```
//!
//! The `_reflectance` functions return the same bits as the `M00` of the full ones, so that a
//! scalar and a polarized render of the same path agree.

use super::kernel::Block;
use crate::math::Real;

/// Keeps a denominator that only grazing light at an index-matched interface reaches off zero;
/// its square is a normal number in `f32`.
const TINY: f64 = 1e-18;

/// What a smooth dielectric interface does to light that arrives on one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface<F> {
    /// Reflected fraction of unpolarized power, `A = (R_s + R_p) / 2`; 0 to 1.
    pub reflectance: F,
    /// Reflection relative to `reflectance`.
    pub reflection: Block<F>,
    /// Refracted fraction of unpolarized power, `1 - reflectance`; radiance also needs
    /// `(n_t / n_i)^2`.
    pub transmittance: F,
    /// Refraction relative to `transmittance`; the identity in total reflection.
    pub transmission: Block<F>,
    /// Cosine of the angle of refraction, 0 to 1; 0 in total reflection.
    pub cos_t: F,
}

/// The quantities that reflectance and kernels share.
#[derive(Clone, Copy)]
struct Refraction<F: Real> {
    /// `u`.
    sin2_i: F,
    /// `eta^2 - 1`.
    contrast: F,
    /// `Re g = eta cos t_t`.
    g: F,
    /// `-Im g`: decay of the evanescent wave.
    decay: F,
    /// `cos t_i + Re g`, above zero.
    sum: F,
    /// Where reflection is total.
    total: F::Mask,
}

/// Sine squared from a cosine, never negative.
#[inline(always)]
fn sin_squared<F: Real>(cos: F) -> F {
    (-cos).mul_add(cos, F::one()).max(F::zero())
}

#[inline(always)]
fn refract<F: Real>(cos_i: F, eta: F) -> Refraction<F> {
    let contrast = (eta - F::one()) * (eta + F::one());
    let g_squared = cos_i.mul_add(cos_i, contrast);
    let root = g_squared.abs().sqrt();
    let total = g_squared.lt(F::zero());
    let g = F::select(total, F::zero(), root);
    Refraction {
        sin2_i: sin_squared(cos_i),
        contrast,
        g,
        decay: F::select(total, root, F::zero()),
        sum: (cos_i + g).max(F::splat(TINY)),
        total,
    }
}

/// `A`, from `r_s = -contrast / sum^2` and `A = R_s (u^2 + v^2) / (u + v)^2`.
#[inline(always)]
fn reflectance_of<F: Real>(cos_i: F, refraction: &Refraction<F>) -> F {
    let Refraction { sin2_i: u, contrast, g, sum, total, .. } = *refraction;
    let v = cos_i * g;
    let r_s = contrast / (sum * sum);
    let ratio = u.mul_add(u, v * v) / ((u + v) * (u + v));
    F::select(total, F::one(), (r_s * r_s * ratio).min(F::one()))
}

/// Reflected fraction of unpolarized power and cosine of the angle of refraction (0 in total
/// reflection) at a dielectric; arguments as in [`dielectric`], and the same bits.
#[inline(always)]
pub fn dielectric_reflectance<F: Real>(cos_i: F, eta: F) -> (F, F) {
    let refraction = refract(cos_i, eta);
    (reflectance_of(cos_i, &refraction), refraction.g / eta)
}

/// A smooth interface of two dielectrics. `cos_i` in 0 to 1 is measured on the side where the
/// light arrives, `eta > 0` is `n_t / n_i`. `M00` of the two results adds to one exactly.
#[inline(always)]
pub fn dielectric<F: Real>(cos_i: F, eta: F) -> Interface<F> {
    let refraction = refract(cos_i, eta);
    let Refraction { sin2_i, contrast, g, decay, sum, total } = refraction;
    let reflectance = reflectance_of(cos_i, &refraction);
    let across = sin2_i + cos_i * g;
    // eta cos(t_i - t_t) is `across`, so t_p / t_s = eta / across, and the difference
    // eta^2 - across^2 is u (g - cos t_i)^2 with g - cos t_i = contrast / sum.
    let scale = F::one() / across.mul_add(across, eta * eta);
    let step = contrast / sum;
    let refracted =
        Block { a: -(sin2_i * step * step) * scale, c: (eta + eta) * across * scale, s: F::zero() };
    Interface {
        reflectance,
        reflection: reflection_block(sin2_i, cos_i * g, cos_i * decay),
        transmittance: F::one() - reflectance,
        transmission: Block::select(total, Block::identity(), refracted),
        cos_t: g / eta,
    }
}

/// The kernel of a reflection from `u` and `v = across - i decay`, both parts 0 or above.
#[inline(always)]
fn reflection_block<F: Real>(u: F, across: F, decay: F) -> Block<F> {
    let u_squared = u * u;
    let v_squared = across.mul_add(across, decay * decay);
    let scale = F::one() / (u_squared + v_squared);
    let doubled = (u + u) * scale;
    Block { a: doubled * across, c: (u_squared - v_squared) * scale, s: -(doubled * decay) }
}

/// `g = real - i decay` of a conductor, and its `M00`.
#[derive(Clone, Copy)]
struct Absorption<F> {
    sin2_i: F,
    real: F,
    decay: F,
    reflectance: F,
}

#[inline(always)]
fn absorb<F: Real>(cos_i: F, eta: F, k: F) -> Absorption<F> {
    let u = sin_squared(cos_i);
    let half = F::splat(0.5);
    let product = eta * k;
    // g^2 = difference - 2 i product; the larger part of g first, for the other cancels.
    let difference = (eta - k).mul_add(eta + k, -u);
    let modulus = difference.mul_add(difference, F::splat(4.0) * product * product).sqrt();
    let larger = (half * (modulus + difference.abs())).sqrt();
    let smaller = product / larger.max(F::splat(TINY));
    let metallic = difference.lt(F::zero());
    let real = F::select(metallic, smaller, larger);
    let decay = F::select(metallic, larger, smaller);

    let decay_squared = decay * decay;
    let (less, more) = (cos_i - real, cos_i + real);
    let r_s_denominator = more.mul_add(more, decay_squared).max(F::splat(TINY * TINY));
    let across = cos_i.mul_add(real, u);
    let v_squared = cos_i * cos_i * modulus;
    let ratio_denominator = across.mul_add(across, cos_i * cos_i * decay_squared);
    let r_s_squared = less.mul_add(less, decay_squared) / r_s_denominator;
    let ratio = u.mul_add(u, v_squared) / ratio_denominator;
    Absorption { sin2_i: u, real, decay, reflectance: (r_s_squared * ratio).min(F::one()) }
}

/// Reflected fraction of unpolarized power at a conductor; arguments as in [`conductor`], and the
/// same bits.
#[inline(always)]
pub fn conductor_reflectance<F: Real>(cos_i: F, eta: F, k: F) -> F {
    absorb(cos_i, eta, k).reflectance
}

/// Reflection at a smooth conductor: `M00 = (R_s + R_p) / 2` and the kernel relative to it.
/// `cos_i` in 0 to 1; `eta - i k`, both 0 or above, is its index relative to the outside.
#[inline(always)]
pub fn conductor<F: Real>(cos_i: F, eta: F, k: F) -> (F, Block<F>) {
    let Absorption { sin2_i, real, decay, reflectance } = absorb(cos_i, eta, k);
    (reflectance, reflection_block(sin2_i, cos_i * real, cos_i * decay))
}

/// Greatest reflectance for which there is an extinction coefficient: it would be infinite at 1.
const REFLECTANCE_MAX: f32 = 0.999;

/// The extinction coefficient k with which a conductor of eta = 1 has this reflectance at normal
/// incidence: `F = k^2 / (4 + k^2)`. More than 0.999 is taken as that.
pub fn k_of_reflectance(reflectance: f32) -> f32 {
    let reflectance = reflectance.min(REFLECTANCE_MAX);
    2.0 * (reflectance / (1.0 - reflectance)).sqrt()
}

/// What a plane pane does to light, all reflections between its faces summed, without interference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pane<F> {
    /// Transmitted fraction of unpolarized power; 0 to 1. The rest is reflected.
    pub transmittance: F,
    /// Transmission relative to `transmittance`; the identity in total reflection.
    pub transmission: Block<F>,
    /// Reflection relative to the rest.
    pub reflection: Block<F>,
}

/// A pane in a medium on both its sides; arguments as in [`dielectric`], of its first face.
///
/// With the reflectances `R` of a face, the series are `T' = (1 - R) / (1 + R)` and
/// `R' = 2 R / (1 + R)` per polarization. Between the two the lower blocks are the numbers
/// `b = (1 - R_s)(1 - R_p) / (1 - R_s R_p)` and `r_s r_p (1 + b)`: what every order brings is real,
/// as it goes through each face as often one way as the other.
#[inline(always)]
pub fn pane<F: Real>(cos_i: F, eta: F) -> Pane<F> {
    let (zero, one, half) = (F::zero(), F::one(), F::splat(0.5));
    let face = dielectric(cos_i, eta);
    let a = face.reflection.a;
    let [r_s, r_p] = [one + a, one - a].map(|of| (face.reflectance * of).min(one));
    let [t_s, t_p] = [r_s, r_p].map(|r| (one - r) / (one + r));
    let [u_s, u_p] = [r_s, r_p].map(|r| (r + r) / (one + r));
    let both = (one - r_s) * (one - r_p) / (one - r_s * r_p);
    let (transmittance, reflectance) = ((t_s + t_p) * half, (u_s + u_p) * half);
    let over = |m00: F| F::select(m00.gt(zero), one / m00, zero);
    let (over_t, over_r) = (over(transmittance), over(reflectance));
    let transmission = Block { a: (t_s - t_p) * half * over_t, c: both * over_t, s: zero };
    let crossed = face.reflectance * face.reflection.c * (one + both);
    let reflection = Block { a: (u_s - u_p) * half * over_r, c: crossed * over_r, s: zero };
    let passes = face.transmittance.gt(zero);
    Pane {
        transmittance: F::select(passes, transmittance, zero),
        transmission: Block::select(passes, transmission, Block::identity()),
        reflection: Block::select(passes, reflection, face.reflection),
    }
}
