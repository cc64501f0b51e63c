//! The smooth boundary of glass or water: reflects or refracts, by Fresnel's equations.

use super::model::{Choice, Incidence, OneOfTwo, Scattered, Specular, Surface, reflect, refract};
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

impl Dielectric {
    /// The index of refraction behind the front relative to before it.
    pub fn relative_ior(&self) -> f32 {
        self.ior
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
        choose: impl FnOnce(OneOfTwo) -> Choice,
        side: Side,
    ) -> Scattered<N, Self::Kernel> {
        let ior = at.models.field(|model| model.ior);
        let one = F32s::splat(1.0);
        let eta = Real::select(at.front, ior, one / ior);
        let (reflectance, cos_t) = fresnel::dielectric_reflectance(at.cos_i, eta);
        let ([reflection, transmission], axis) = if POLARIZED {
            let fresnel::Interface { reflection, transmission, .. } =
                fresnel::dielectric(at.cos_i, eta);
            ([reflection, transmission], s_axis(at.normal, at.direction))
        } else {
            ([Block::identity(); 2], at.direction)
        };
        let reflecting = OneOfTwo { share: reflectance, diattenuation: reflection.a, axis };
        let Choice { first: reflects, gain } = choose(reflecting);
        let block = Block::select(reflects, reflection, transmission);
        let reflected = reflect(at.direction, at.normal);
        let refracted = refract(at.direction, at.normal, at.cos_i, cos_t, eta);
        let direction = Vector::select(reflects, reflected, refracted);
        // Radiance grows with the square of the index; importance, and power, do not.
        let squeeze = match side {
            Side::Sensor => Real::select(reflects, one, one / (eta * eta)),
            Side::Light => one,
        };
        let consistent = !(at.stays(direction) ^ reflects);
        Scattered {
            direction,
            weight: [consistent & (squeeze / gain); N],
            kernels: [block; N],
            axis,
            alone: F32s::splat(0.0),
        }
    }
}
