//! The smooth boundary of glass or water: reflects or refracts, by Fresnel's equations.

use super::model::{Incidence, Scattered, Specular, Surface, reflect, refract};
use crate::math::{F32s, Real, Vector};
use crate::polarization::{Block, fresnel, s_axis};
use crate::scattering::side::Side;

/// Without dispersion.
#[derive(Clone, Copy, Debug)]
pub struct Dielectric {
    /// Index of refraction behind the front relative to before it, greater than 0.
    ior: f32,
}

impl Dielectric {
    /// With the indices of refraction behind and before the front.
    pub fn of(ior: f32, exterior_ior: f32) -> Self {
        Self { ior: ior / exterior_ior }
    }
}

impl Surface for Dielectric {
    const NESTS: bool = true;

    fn scattered(&self) -> f32 {
        1.0
    }
}

impl<const N: usize> Specular<N> for Dielectric {
    type Kernel = Block<F32s>;
    const ACHROMATIC: bool = true;

    #[inline(always)]
    fn scatter<const POLARIZED: bool>(
        at: &Incidence<Self>,
        choice: impl FnOnce() -> F32s,
        side: Side,
    ) -> Scattered<N, Self::Kernel> {
        let u = choice();
        let ior = at.models.field(|model| model.ior);
        let one = F32s::splat(1.0);
        let eta = Real::select(at.front, ior, one / ior);
        let (reflectance, cos_t) = fresnel::dielectric_reflectance(at.cos_i, eta);
        let reflects = u.simd_lt(reflectance);
        let reflected = reflect(at.direction, at.normal);
        let refracted = refract(at.direction, at.normal, at.cos_i, cos_t, eta);
        let direction = Vector::select(reflects, reflected, refracted);
        let (block, axis) = if POLARIZED {
            let interface = fresnel::dielectric(at.cos_i, eta);
            let block = Block::select(reflects, interface.reflection, interface.transmission);
            (block, s_axis(at.normal, at.direction))
        } else {
            (Block::identity(), direction)
        };
        // Radiance grows with the square of the index; importance, and power, do not.
        let squeeze = match side {
            Side::Sensor => Real::select(reflects, one, one / (eta * eta)),
            Side::Light => one,
        };
        let consistent = !(at.stays(direction) ^ reflects);
        Scattered { direction, weight: [consistent & squeeze; N], kernels: [block; N], axis }
    }
}
