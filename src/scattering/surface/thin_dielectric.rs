//! A pane too thin to tell its two faces apart: all reflections within it are summed, without
//! interference.

use super::model::{
    Choice, Incidence, OneOfTwo, Passage, Scattered, Specular, StraightOn, Surface, reflect,
};
use crate::math::F32s;
use crate::polarization::{Block, Pane, pane, s_axis};
use crate::scattering::side::Side;

/// Without dispersion.
#[derive(Clone, Copy, Debug)]
pub struct ThinDielectric {
    /// Index of refraction relative to that of what is on both sides, greater than 0.
    ior: f32,
}

impl ThinDielectric {
    /// With the indices of refraction of the pane, and on both its sides.
    pub fn of(ior: f32, exterior_ior: f32) -> Self {
        Self { ior: ior / exterior_ior }
    }

    #[inline(always)]
    fn pane(at: &Incidence<Self>) -> Pane<F32s> {
        pane(at.cos_i, at.models.field(|model| model.ior))
    }
}

impl Surface for ThinDielectric {
    fn scattered(&self) -> f32 {
        1.0
    }
}

/// Its vertices are where light is reflected, which is drawn by the share of unpolarized light
/// that is: nothing is left to weigh.
impl<const N: usize> Specular<N> for ThinDielectric {
    type Kernel = Block<F32s>;
    const ACHROMATIC: bool = true;

    #[inline(always)]
    fn scatter<const POLARIZED: bool>(
        at: &Incidence<Self>,
        _choose: impl FnOnce(OneOfTwo) -> Choice,
        _side: Side,
    ) -> Scattered<N, Self::Kernel> {
        let direction = reflect(at.direction, at.normal);
        let (block, axis) = if POLARIZED {
            (Self::pane(at).reflection, s_axis(at.normal, at.direction))
        } else {
            (Block::identity(), direction)
        };
        let weight = [at.stays(direction) & F32s::splat(1.0); N];
        Scattered { direction, weight, kernels: [block; N], axis, alone: F32s::splat(0.0) }
    }
}

impl<const N: usize> StraightOn<N> for ThinDielectric {
    const ACTS: bool = true;

    #[inline(always)]
    fn pass<const POLARIZED: bool>(at: &Incidence<Self>) -> Passage<N> {
        let pane = Self::pane(at);
        let axis = if POLARIZED { s_axis(at.normal, at.direction) } else { at.direction };
        Passage {
            transmittance: [pane.transmittance; N],
            chance: pane.transmittance,
            kernel: pane.transmission,
            axis,
        }
    }
}
