//! Participating media as the stages read them: coefficients, and what is derived from them.

use crate::scene::baked;

use super::phase::{HenyeyGreenstein, PhaseFunction, Scatters, for_phase};

/// Mean square of a phase function ([`Scatters::moments`]) from which on it is nearly a delta: that
/// of Henyey and Greenstein's at a mean cosine of 0.93.
const PEAKED: f32 = 100.0;

/// A homogeneous medium with what is derived from its coefficients.
#[derive(Clone, Debug)]
pub struct Medium<const N: usize> {
    /// Extinction coefficient per scene unit.
    pub sigma_t: [f32; N],
    /// Scattering coefficient per scene unit.
    pub sigma_s: [f32; N],
    /// Mean extinction coefficient over the wavelengths: what takes the place of a surface's
    /// cosine where strategies are weighed against each other.
    pub density: f32,
    /// The probability with which roulette lets a path go on.
    pub survival: f32,
    /// The largest reduced extinction coefficient over the wavelengths, of which scattering that
    /// leads forwards is left out by its mean cosine: one over the transport mean free path.
    pub reduced: f32,
    /// Whether its phase function is nearly a delta.
    pub is_peaked: bool,
    /// How it scatters.
    pub phase: PhaseFunction<N>,
}

impl<const N: usize> Medium<N> {
    /// Derives the row of a baked medium.
    pub fn new(medium: &baked::Medium<N>) -> Self {
        let mut sigma_t = medium.sigma_a;
        let mut albedo = 0.0_f32;
        for (sigma_t, &sigma_s) in sigma_t.iter_mut().zip(&medium.sigma_s) {
            *sigma_t += sigma_s;
            albedo = albedo.max(if sigma_s > 0.0 { sigma_s / *sigma_t } else { 0.0 });
        }
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
            density: sigma_t.iter().sum::<f32>() / N as f32,
            survival: albedo.clamp(0.05, 1.0),
            reduced,
            is_peaked,
            phase,
        }
    }

    /// A medium that is not there.
    pub fn clear() -> Self {
        let phase = PhaseFunction::HenyeyGreenstein(HenyeyGreenstein { g: [0.0; N] });
        let (sigma_t, sigma_s) = ([0.0; N], [0.0; N]);
        let (density, survival, reduced, is_peaked) = (0.0, 1.0, 0.0, false);
        Self { sigma_t, sigma_s, density, survival, reduced, is_peaked, phase }
    }
}
