//! A pane too thin to tell its two faces apart: all reflections within it are summed, without
//! interference.

use super::model::{
    Choice, Incidence, OneOfTwo, Passage, Scattered, Specular, StraightOn, Surface, reflect,
};
use crate::math::{F32s, Real};
use crate::polarization::{Block, Pane, pane, s_axis};
use crate::scattering::side::Side;

/// With the index of every wavelength: all of them go the same ways, so that paths keep them.
#[derive(Clone, Copy, Debug)]
pub struct ThinDielectric<const N: usize> {
    /// Index of refraction relative to that of what is on both sides, greater than 0.
    ior: [f32; N],
}

impl<const N: usize> ThinDielectric<N> {
    /// With the indices of refraction of the pane, and on both its sides.
    pub fn of(ior: [f32; N], exterior_ior: [f32; N]) -> Self {
        Self { ior: std::array::from_fn(|n| ior[n] / exterior_ior[n]) }
    }

    /// The pane at every wavelength, and the mean of what it transmits: the probability with which
    /// paths pass, whichever wavelengths they have.
    #[inline(always)]
    fn panes(at: &Incidence<Self>) -> ([Pane<F32s>; N], F32s) {
        let ior = at.models.spectrum(|model| &model.ior);
        let first = pane(at.cos_i, ior[0]);
        let mut panes = [first; N];
        let mut excess = F32s::splat(0.0);
        for (other, &ior_n) in panes.iter_mut().zip(&ior).skip(1) {
            // Mostly they are all the same.
            if !ior_n.simd_eq(ior[0]).all() {
                *other = pane(at.cos_i, ior_n);
                excess += other.transmittance - first.transmittance;
            }
        }
        (panes, first.transmittance + excess * F32s::splat(1.0 / N as f32))
    }
}

impl<const N: usize> Surface for ThinDielectric<N> {
    fn scattered(&self) -> f32 {
        1.0
    }
}

/// Its vertices are where light is reflected, which is drawn by the share of unpolarized light
/// that is, on the average over the wavelengths: what is left to weigh is how these differ.
impl<const N: usize> Specular<N> for ThinDielectric<N> {
    type Kernel = Block<F32s>;
    const ACHROMATIC: bool = false;

    #[inline(always)]
    fn scatter<const POLARIZED: bool>(
        at: &Incidence<Self>,
        _choose: impl FnOnce(OneOfTwo) -> Choice,
        _side: Side,
    ) -> Scattered<N, Self::Kernel> {
        let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
        let direction = reflect(at.direction, at.normal);
        let (panes, chance) = Self::panes(at);
        let axis = if POLARIZED { s_axis(at.normal, at.direction) } else { direction };
        let stays = at.stays(direction);
        let reflects = one - chance;
        let mut weight = [zero; N];
        for (weight, pane) in weight.iter_mut().zip(&panes) {
            let ratio = (one - pane.transmittance) / reflects;
            *weight = stays & Real::select(reflects.simd_gt(zero), ratio, one);
        }
        let kernels = panes.map(|pane| pane.reflection);
        Scattered { direction, weight, kernels, axis, alone: zero }
    }
}

impl<const N: usize> StraightOn<N> for ThinDielectric<N> {
    const ACTS: bool = true;
    const ACHROMATIC: bool = false;

    #[inline(always)]
    fn pass<const POLARIZED: bool>(at: &Incidence<Self>) -> Passage<N> {
        let (panes, chance) = Self::panes(at);
        Passage {
            transmittance: panes.map(|pane| pane.transmittance),
            chance,
            kernels: panes.map(|pane| pane.transmission),
            axis: if POLARIZED { s_axis(at.normal, at.direction) } else { at.direction },
        }
    }
}
