//! Participating media as the stages read them: coefficients, and what is derived from them.

use std::f32::consts::PI;

use crate::math::elementary::exp2;
use crate::math::{F32s, LANES, lanes};
use crate::scene::baked;

use super::phase::{HenyeyGreenstein, PhaseFunction, Scatters, for_phase};
use super::surface::SURVIVAL_MIN;

/// Mean square of a phase function ([`Scatters::moments`]) from which on it is nearly a delta: that
/// of Henyey and Greenstein's at a mean cosine of 0.93.
const PEAKED: f32 = 100.0;
/// Where the forward peak of a phase function ends: what it has fallen to, relative to an even one.
/// That of dipoles has none.
const END_OF_PEAK: f32 = 2.0;
/// Smallest `half_sine2` at which ends of peaks are looked for, and how many are looked at within
/// a factor of two.
const PEAK_MIN: f32 = 1.0 / (1 << 24) as f32;
const STEPS: u16 = 8;
/// Share of extinction that is hardly absorption: flights by extinction are less work then, and
/// nearly as good.
const HARDLY: f32 = 1.0 / 8.0;

/// A homogeneous medium with what is derived from its coefficients.
#[derive(Clone, Debug)]
pub struct Medium<const N: usize> {
    /// Extinction coefficient per scene unit.
    pub sigma_t: [f32; N],
    /// Scattering coefficient per scene unit.
    pub sigma_s: [f32; N],
    /// Coefficient that free flights are drawn by, per scene unit: the geometric mean of the two, 0
    /// where the medium only absorbs; that of extinction where it hardly does.
    pub sigma_d: [f32; N],
    /// The mean of that over the wavelengths: what takes the place of a surface's cosine where
    /// strategies are weighed against each other.
    pub density: f32,
    /// Where that is extinction at all wavelengths, the largest albedo: the probability with which
    /// roulette lets paths go on from the particles that they meet.
    pub by_extinction: Option<f32>,
    /// Whether it is the same at all wavelengths: paths in it tell none apart.
    pub is_gray: bool,
    /// The largest reduced extinction coefficient over the wavelengths, of which scattering that
    /// leads forwards is left out by its mean cosine: one over the transport mean free path.
    pub reduced: f32,
    /// Whether its phase function is nearly a delta.
    pub is_peaked: bool,
    /// `half_sine2` of the angle at which the forward peak of its phase function ends: closer to
    /// forward than this, photons do not merge but paths go on. 0 if it has none.
    pub peak: f32,
    /// How it scatters.
    pub phase: PhaseFunction<N>,
}

impl<const N: usize> Medium<N> {
    /// Derives the row of a baked medium.
    pub fn new(medium: &baked::Medium<N>) -> Self {
        let sigma_t: [f32; N] = std::array::from_fn(|n| medium.sigma_a[n] + medium.sigma_s[n]);
        let sigma_d = std::array::from_fn(|n| of_flights(medium.sigma_s[n], sigma_t[n]));
        let phase = PhaseFunction::from(&medium.phase);
        let (mut reduced, mut is_peaked) = (0.0_f32, false);
        for (n, (sigma_t, sigma_s)) in sigma_t.iter().zip(&medium.sigma_s).enumerate() {
            let [cosine, square] = for_phase!(&phase, phase => phase.moments(n));
            reduced = reduced.max(sigma_t - cosine.max(0.0) * sigma_s);
            is_peaked |= square > PEAKED;
        }
        Self {
            sigma_t,
            sigma_s: medium.sigma_s,
            sigma_d,
            density: mean(&sigma_d),
            is_gray: is_even(&sigma_t) && is_even(&medium.sigma_s) && phase.is_gray(),
            by_extinction: (sigma_d == sigma_t).then(|| survival(&medium.sigma_s, &sigma_t)),
            reduced,
            is_peaked,
            peak: for_phase!(&phase, phase => end_of_peak(phase)),
            phase,
        }
    }

    /// A medium that is not there.
    pub fn clear() -> Self {
        let phase = PhaseFunction::HenyeyGreenstein(HenyeyGreenstein { g: [0.0; N] });
        let [sigma_t, sigma_s, sigma_d] = [[0.0; N]; 3];
        let (density, reduced, is_peaked, peak) = (0.0, 0.0, false, 0.0);
        let by_extinction = Some(SURVIVAL_MIN);
        let is_gray = true;
        Self {
            sigma_t,
            sigma_s,
            sigma_d,
            density,
            is_gray,
            by_extinction,
            reduced,
            is_peaked,
            peak,
            phase,
        }
    }

    /// Mean extinction coefficient over the wavelengths.
    pub fn extinction(&self) -> f32 {
        mean(&self.sigma_t)
    }
}

/// Coefficient of free flights.
fn of_flights(sigma_s: f32, sigma_t: f32) -> f32 {
    if sigma_t - sigma_s < HARDLY * sigma_t {
        return sigma_t;
    }
    (f64::from(sigma_s) * f64::from(sigma_t)).sqrt() as f32
}

fn is_even<const N: usize>(values: &[f32; N]) -> bool {
    values.iter().all(|value| *value == values[0])
}

/// The largest albedo, as roulette takes it.
fn survival<const N: usize>(sigma_s: &[f32; N], sigma_t: &[f32; N]) -> f32 {
    // Where nothing scatters, nor absorbs, the ratio is not a number, and nothing.
    let albedos = sigma_s.iter().zip(sigma_t).map(|(sigma_s, sigma_t)| sigma_s / sigma_t);
    albedos.fold(SURVIVAL_MIN, f32::max).min(1.0)
}

fn mean<const N: usize>(values: &[f32; N]) -> f32 {
    values.iter().sum::<f32>() / N as f32
}

/// `half_sine2` from which on a phase function has fallen to [`END_OF_PEAK`] at all wavelengths.
fn end_of_peak<const N: usize>(phase: &impl Scatters<N>) -> f32 {
    let end = F32s::splat(END_OF_PEAK / (4.0 * PI));
    let at = |step: u16| PEAK_MIN * exp2(f32::from(step) / f32::from(STEPS));
    for first in (0_u16..).step_by(LANES) {
        let half_sine2 = lanes::each(|lane| at(first + lane as u16).min(1.0));
        let has_ended = (phase.values(F32s::from(half_sine2)).iter())
            .fold(lanes::first(LANES), |ended, value| ended & value.simd_le(end))
            .to_bitmask();
        let lane = has_ended.trailing_zeros() as usize;
        if (first, lane) == (0, 0) {
            return 0.0;
        } else if lane < LANES {
            return half_sine2[lane];
        } else if half_sine2[LANES - 1] == 1.0 {
            break;
        }
    }
    1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_end_where_they_have_fallen_to_twice_an_even_one() {
        for g in [0.3_f32, 0.5, 0.9, 0.999] {
            let found = end_of_peak(&HenyeyGreenstein { g: [g, 0.0] });
            let base = ((1.0 - g * g) / END_OF_PEAK).powf(2.0 / 3.0);
            let end = (base - (1.0 - g).powi(2)) / (4.0 * g);
            let steps = (found / end).log2() * f32::from(STEPS);
            assert!((0.0..=1.01).contains(&steps), "{g}: {found} for {end}");
        }
        for g in [0.0, 0.1, -0.8] {
            assert_eq!(end_of_peak(&HenyeyGreenstein { g: [g] }), 0.0);
        }
    }
}
