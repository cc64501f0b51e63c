//! The smooth boundary of glass or water whose index of refraction depends on the wavelength.

use super::model::{Choice, Incidence, OneOfTwo, Scattered, Specular, Surface, reflect, refract};
use crate::math::{F32s, Real, Vector};
use crate::polarization::{Block, fresnel, s_axis};
use crate::scattering::side::Side;

/// With dispersion: what is refracted goes on at the first wavelength alone, as the others go other
/// ways; what is reflected keeps all.
#[derive(Clone, Copy, Debug)]
pub struct DispersiveDielectric<const N: usize> {
    /// Index of refraction behind the front relative to before it, greater than 0.
    ior: [f32; N],
    /// Whether it depends on the wavelength: interfaces between others stand in the same table.
    disperses: bool,
}

impl<const N: usize> DispersiveDielectric<N> {
    /// With the indices of refraction behind and before the front.
    pub fn of(ior: [f32; N], exterior_ior: [f32; N]) -> Self {
        let ior: [f32; N] = std::array::from_fn(|n| ior[n] / exterior_ior[n]);
        Self { ior, disperses: ior.iter().any(|of| *of != ior[0]) }
    }
}

impl<const N: usize> DispersiveDielectric<N> {
    /// The index of refraction behind the front relative to before it.
    pub fn relative_ior(&self) -> [f32; N] {
        self.ior
    }
}

impl<const N: usize> Surface for DispersiveDielectric<N> {
    const NESTS: bool = true;

    fn scattered(&self) -> f32 {
        1.0
    }
}

/// Fresnel's equations at every wavelength.
struct Faces<const N: usize> {
    reflectance: [F32s; N],
    reflection: [Block<F32s>; N],
    /// Of the first wavelength.
    transmission: Block<F32s>,
    cos_t: F32s,
}

impl<const N: usize> Faces<N> {
    #[inline(always)]
    fn at<const POLARIZED: bool>(cos_i: F32s, eta: &[F32s; N]) -> Self {
        let mut faces = Self {
            reflectance: [F32s::splat(0.0); N],
            reflection: [Block::identity(); N],
            transmission: Block::identity(),
            cos_t: F32s::splat(0.0),
        };
        for (n, &eta) in eta.iter().enumerate() {
            let (reflectance, cos_t) = fresnel::dielectric_reflectance(cos_i, eta);
            faces.reflectance[n] = reflectance;
            if POLARIZED {
                let all = fresnel::dielectric(cos_i, eta);
                faces.reflection[n] = all.reflection;
                faces.transmission = if n == 0 { all.transmission } else { faces.transmission };
            }
            faces.cos_t = if n == 0 { cos_t } else { faces.cos_t };
        }
        faces
    }

    /// Reflection as it is drawn: for paths that have collapsed by the first wavelength, else by
    /// the mean of all, as the first may be refracted without loss where others are not. Its share,
    /// and its diattenuation.
    #[inline(always)]
    fn drawn(&self, collapsed: F32s) -> [F32s; 2] {
        let mut sums = [F32s::splat(0.0); 2];
        for (reflectance, block) in self.reflectance.iter().zip(&self.reflection) {
            sums = [sums[0] + *reflectance, reflectance.mul_add(block.a, sums[1])];
        }
        let share = sums[0] * F32s::splat(1.0 / N as f32);
        let a =
            Real::select(sums[0].simd_gt(F32s::splat(0.0)), sums[1] / sums[0], F32s::splat(0.0));
        let first = [self.reflectance[0], self.reflection[0].a];
        [Real::select(collapsed, first[0], share), Real::select(collapsed, first[1], a)]
    }
}

impl<const N: usize> Specular<N> for DispersiveDielectric<N> {
    type Kernel = Block<F32s>;
    const ACHROMATIC: bool = false;
    const DISPERSES: bool = true;

    #[inline(always)]
    fn scatter<const POLARIZED: bool>(
        at: &Incidence<Self>,
        choose: impl FnOnce(OneOfTwo) -> Choice,
        side: Side,
    ) -> Scattered<N, Self::Kernel> {
        let one = F32s::splat(1.0);
        let ior = at.models.spectrum(|model| &model.ior);
        let eta = ior.map(|ior| Real::select(at.front, ior, one / ior));
        let faces = Faces::at::<POLARIZED>(at.cos_i, &eta);
        let [share, diattenuation] = faces.drawn(at.collapsed);
        let axis = if POLARIZED { s_axis(at.normal, at.direction) } else { at.direction };
        let Choice { first: reflects, gain } = choose(OneOfTwo { share, diattenuation, axis });
        let reflected = reflect(at.direction, at.normal);
        let refracted = refract(at.direction, at.normal, at.cos_i, faces.cos_t, eta[0]);
        let direction = Vector::select(reflects, reflected, refracted);
        // Radiance grows with the square of the index; importance, and power, do not.
        let squeeze = match side {
            Side::Sensor => one / (eta[0] * eta[0]),
            Side::Light => one,
        };
        let consistent = !(at.stays(direction) ^ reflects);
        let mut weight = [one; N];
        let mut kernels = [faces.transmission; N];
        for (n, (weight, kernel)) in weight.iter_mut().zip(&mut kernels).enumerate() {
            let reflectance = faces.reflectance[n];
            let of_reflected = reflectance / share;
            let of_refracted = squeeze * ((one - reflectance) / (one - share));
            let of_way = Real::select(reflects, of_reflected, of_refracted);
            *weight = consistent & (of_way / gain);
            *kernel = Block::select(reflects, faces.reflection[n], faces.transmission);
        }
        let disperses = at.models.field(|model| if model.disperses { 1.0 } else { 0.0 });
        let alone = !reflects & disperses.simd_gt(F32s::splat(0.5));
        Scattered { direction, weight, kernels, axis, alone }
    }
}
