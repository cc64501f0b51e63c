//! Participating media as the stages read them: coefficients, and what is derived from them.

use crate::scene::baked;

use super::phase::{HenyeyGreenstein, PhaseFunction};

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
        Self {
            sigma_t,
            sigma_s: medium.sigma_s,
            density: sigma_t.iter().sum::<f32>() / N as f32,
            survival: albedo.clamp(0.05, 1.0),
            phase: PhaseFunction::from(&medium.phase),
        }
    }

    /// A medium that is not there.
    pub fn clear() -> Self {
        let phase = PhaseFunction::HenyeyGreenstein(HenyeyGreenstein { g: [0.0; N] });
        Self { sigma_t: [0.0; N], sigma_s: [0.0; N], density: 0.0, survival: 1.0, phase }
    }
}
