//! Rough metal: see [`super::rough`].

use super::facing::Facing;
use super::model::{Connecting, Drawn, ModelLanes, Surface, strongest};
use super::rough::{FacetLobe, Reflected, Rough, is_above, missing, peak};
use crate::math::{F32s, Vector};
use crate::polarization::albedo::TERMS;
use crate::polarization::{
    Albedo, Distribution, FacetReflection, Facets, SpheroidBlock, fresnel, s_axis,
};
use crate::scattering::vertex::mean;

/// The index of refraction n - i k relative to vacuum, and facets.
#[derive(Clone, Copy, Debug)]
pub struct RoughConductor<const N: usize> {
    /// Real part n > 0.
    eta: [f32; N],
    /// Extinction coefficient k >= 0.
    k: [f32; N],
    /// The roughness of the facets.
    alpha: f32,
    /// 1 for Beckmann's distribution, else 0.
    beckmann: f32,
    /// What lossless facets reflect once.
    albedo: Albedo,
    reflected: Reflected<N>,
}

impl<const N: usize> RoughConductor<N> {
    /// With the index of refraction and the roughness of facets; light that several of them
    /// reflect is there if `multiple_scattering` is.
    pub fn of(
        eta: [f32; N],
        k: [f32; N],
        alpha: f32,
        distribution: Distribution,
        multiple_scattering: bool,
    ) -> Self {
        let albedo = Albedo::of_facets(distribution, alpha);
        let beckmann = if distribution == Distribution::Beckmann { 1.0 } else { 0.0 };
        let reflected = Reflected::of(eta, k, &albedo, multiple_scattering);
        Self { eta, k, alpha, beckmann, albedo, reflected }
    }
}

impl<const N: usize> Surface for RoughConductor<N> {
    fn scattered(&self) -> f32 {
        let Reflected { single, multiple, .. } = self.reflected;
        let missing = 1.0 - self.albedo.mean;
        let all = |n: usize| single[n] * self.albedo.mean + multiple[n] * missing;
        strongest::<N>(std::array::from_fn(all)).min(1.0)
    }

    fn peak(&self) -> f32 {
        peak(self.alpha)
    }
}

/// Eight of them.
#[derive(Clone, Copy)]
pub struct RoughConductors<const N: usize> {
    facets: Facets,
    eta: [F32s; N],
    k: [F32s; N],
    /// Of [`Albedo`].
    terms: [F32s; TERMS],
    gain: [F32s; N],
    /// Means over the wavelengths of what is reflected once, and several times.
    single: F32s,
    multiple: F32s,
}

impl<const N: usize> RoughConductors<N> {
    /// What is reflected several times, per gain.
    #[inline(always)]
    fn several(&self, reflection: &FacetReflection) -> F32s {
        let [given, drawn] = reflection.cosines.map(|cos| missing(&self.terms, cos));
        is_above(reflection) & (given * drawn)
    }
}

impl<const N: usize> Rough<N> for RoughConductors<N> {
    #[inline(always)]
    fn facets(&self) -> &Facets {
        &self.facets
    }

    #[inline(always)]
    fn chance_of_facets(&self, cos: F32s) -> F32s {
        let missing = missing(&self.terms, cos);
        let once = self.single * (F32s::splat(1.0) - missing);
        let several = self.multiple * missing;
        once / (once + several).fast_max(F32s::splat(f32::MIN_POSITIVE))
    }

    #[inline(always)]
    fn values(&self, reflection: &FacetReflection) -> [F32s; N] {
        let several = self.several(reflection);
        let mut values = [F32s::splat(0.0); N];
        for (n, value) in values.iter_mut().enumerate() {
            let reflectance =
                fresnel::conductor_reflectance(reflection.cos_half, self.eta[n], self.k[n]);
            *value = reflection.value.mul_add(reflectance, self.gain[n] * several);
        }
        values
    }
}

impl<const N: usize> Connecting<N> for RoughConductor<N> {
    type Kernel = SpheroidBlock<F32s>;
    const ACHROMATIC: bool = false;
    const IS_EVEN: bool = false;
    type Lanes = RoughConductors<N>;

    #[inline(always)]
    fn factor(_models: &ModelLanes<Self>) -> [F32s; N] {
        [F32s::splat(1.0); N]
    }

    // Of some hundreds of instructions, which many stages want: calls cost nothing beside them, and
    // copies would make a fifth of the program.
    #[inline(never)]
    fn lanes(models: &ModelLanes<Self>) -> RoughConductors<N> {
        let alpha = models.field(|model| model.alpha);
        let beckmann = models.field(|model| model.beckmann).simd_gt(F32s::splat(0.5));
        RoughConductors {
            facets: Facets::new(alpha, beckmann),
            eta: models.spectrum(|model| &model.eta),
            k: models.spectrum(|model| &model.k),
            terms: models.spectrum(|model| &model.albedo.terms),
            gain: models.spectrum(|model| &model.reflected.gain),
            single: mean(&models.spectrum(|model| &model.reflected.single)),
            multiple: mean(&models.spectrum(|model| &model.reflected.multiple)),
        }
    }

    #[inline(never)]
    fn shape(
        of: &RoughConductors<N>,
        facing: &Facing,
        given: Vector<F32s>,
        drawn: Vector<F32s>,
    ) -> [F32s; N] {
        of.values(&of.reflect(facing, given, drawn))
    }

    #[inline(never)]
    fn pdf(
        of: &RoughConductors<N>,
        facing: &Facing,
        given: Vector<F32s>,
        drawn: Vector<F32s>,
    ) -> F32s {
        Rough::pdf(of, facing, given, drawn)
    }

    #[inline(never)]
    fn draw(
        models: &ModelLanes<Self>,
        facing: &Facing,
        given: Vector<F32s>,
        u: [F32s; 2],
    ) -> Drawn<N> {
        Rough::draw(&Self::lanes(models), facing, given, u)
    }

    #[inline(never)]
    fn kernels(
        of: &RoughConductors<N>,
        facing: &Facing,
        k_in: Vector<F32s>,
        k_out: Vector<F32s>,
    ) -> ([SpheroidBlock<F32s>; N], Vector<F32s>) {
        let reflection = of.reflect(facing, -k_in, k_out);
        let several = of.several(&reflection);
        let mut kernels = [FacetLobe::none().beside(several); N];
        for (n, kernel) in kernels.iter_mut().enumerate() {
            let (reflectance, block) = fresnel::conductor(reflection.cos_half, of.eta[n], of.k[n]);
            let once = FacetLobe::none().and(reflection.value * reflectance, block);
            *kernel = once.beside(of.gain[n] * several);
        }
        (kernels, s_axis(reflection.half, k_in))
    }
}
