//! The smooth metal: a mirror whose Fresnel reflection polarizes, differently at each wavelength.

use super::model::{Choice, Incidence, OneOfTwo, Scattered, Specular, Surface, reflect, strongest};
use crate::math::F32s;
use crate::polarization::{Block, fresnel, s_axis};
use crate::scattering::side::Side;

/// The index of refraction n - i k relative to vacuum.
#[derive(Clone, Copy, Debug)]
pub struct Conductor<const N: usize> {
    /// Real part n > 0.
    eta: [f32; N],
    /// Extinction coefficient k >= 0.
    k: [f32; N],
}

impl<const N: usize> Conductor<N> {
    /// With the real part `eta` of the index of refraction, and its extinction coefficient.
    pub fn of(eta: [f32; N], k: [f32; N]) -> Self {
        Self { eta, k }
    }
}

impl<const N: usize> Surface for Conductor<N> {
    fn scattered(&self) -> f32 {
        let reflectance = |n: usize| fresnel::conductor_reflectance(1.0, self.eta[n], self.k[n]);
        strongest::<N>(std::array::from_fn(reflectance))
    }
}

impl<const N: usize> Specular<N> for Conductor<N> {
    type Kernel = Block<F32s>;
    const ACHROMATIC: bool = false;

    #[inline(always)]
    fn scatter<const POLARIZED: bool>(
        at: &Incidence<Self>,
        _choose: impl FnOnce(OneOfTwo) -> Choice,
        _side: Side,
    ) -> Scattered<N, Self::Kernel> {
        let direction = reflect(at.direction, at.normal);
        let faces = at.front | at.two_sided;
        let stays = at.stays(direction);
        let mut weight = [F32s::splat(0.0); N];
        let mut kernels = [Block::identity(); N];
        for (n, weight) in weight.iter_mut().enumerate() {
            let eta = at.models.field(|model| model.eta[n]);
            let k = at.models.field(|model| model.k[n]);
            let reflectance = if POLARIZED {
                let (reflectance, block) = fresnel::conductor(at.cos_i, eta, k);
                kernels[n] = block;
                reflectance
            } else {
                fresnel::conductor_reflectance(at.cos_i, eta, k)
            };
            *weight = faces & stays & reflectance;
        }
        let axis = if POLARIZED { s_axis(at.normal, at.direction) } else { direction };
        Scattered { direction, weight, kernels, axis, alone: F32s::splat(0.0) }
    }
}
