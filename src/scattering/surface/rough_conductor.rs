//! Rough metal: see [`super::rough`].

use super::glossy::Glossy;
use super::model::{ModelLanes, Surface, strongest};
use super::rough::{FacetLobe, FacetPlane, Reflected, Rough, is_above, peak, stains};
use crate::math::F32s;
use crate::polarization::albedo::TERMS;
use crate::polarization::{
    Albedo, Distribution, Even, FacetReflection, Facets, Slopes, SpheroidBlock, fresnel,
};
use crate::scattering::event::Form;
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
    /// What is left of light that is reflected, if that is not all.
    stain: Option<[[f32; N]; 1]>,
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
        Self { eta, k, alpha, beckmann, albedo, reflected, stain: None }
    }

    /// Leaves so much of light that is reflected.
    pub fn stain(&mut self, stain: [f32; N]) {
        self.stain = Some([stain]);
    }
}

impl<const N: usize> RoughConductor<N> {
    /// Mask of rows with Beckmann's distribution.
    #[inline(always)]
    pub fn beckmann(models: &ModelLanes<Self>) -> F32s {
        models.field(|model| model.beckmann).simd_gt(F32s::splat(0.5))
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
pub struct RoughConductors<const N: usize, S = Even> {
    facets: Facets<S>,
    eta: [F32s; N],
    k: [F32s; N],
    /// Of [`Albedo`].
    terms: [F32s; TERMS],
    gain: [F32s; N],
    /// Means over the wavelengths of what is reflected once, and several times.
    single: F32s,
    multiple: F32s,
    stain: Option<[[F32s; N]; 1]>,
}

impl<const N: usize, S> RoughConductors<N, S> {
    /// Those of some rows, with these facets.
    #[inline(always)]
    pub fn new(models: &ModelLanes<RoughConductor<N>>, facets: Facets<S>) -> Self {
        Self {
            facets,
            eta: models.spectrum(|model| &model.eta),
            k: models.spectrum(|model| &model.k),
            terms: models.spectrum(|model| &model.albedo.terms),
            gain: models.spectrum(|model| &model.reflected.gain),
            single: mean(&models.spectrum(|model| &model.reflected.single)),
            multiple: mean(&models.spectrum(|model| &model.reflected.multiple)),
            stain: stains(models, |model| model.stain.as_ref()),
        }
    }

    /// What is reflected several times, per gain.
    #[inline(always)]
    fn several(&self, reflection: &FacetReflection) -> F32s {
        let [given, drawn] = reflection.even.map(|cos| Albedo::missing(&self.terms, cos));
        is_above(reflection) & (given * drawn)
    }
}

impl<const N: usize, S: Slopes> Rough<N> for RoughConductors<N, S> {
    type Kernel = SpheroidBlock<F32s>;
    type Slopes = S;

    #[inline(always)]
    fn facets(&self) -> &Facets<S> {
        &self.facets
    }

    #[inline(always)]
    fn chances(&self, cos: F32s) -> [F32s; 2] {
        let missing = Albedo::missing(&self.terms, cos);
        let once = self.single * (F32s::splat(1.0) - missing);
        let several = self.multiple * missing;
        let chance = once / (once + several).fast_max(F32s::splat(f32::MIN_POSITIVE));
        [chance, F32s::splat(1.0)]
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
        if let Some([stain]) = &self.stain {
            values.iter_mut().zip(stain).for_each(|(value, left)| *value *= *left);
        }
        values
    }

    #[inline(always)]
    fn kernels(&self, reflection: &FacetReflection, _: &FacetPlane) -> [Self::Kernel; N] {
        let several = self.several(reflection);
        let mut kernels = [FacetLobe::none().beside(several); N];
        for (n, kernel) in kernels.iter_mut().enumerate() {
            let (reflectance, block) =
                fresnel::conductor(reflection.cos_half, self.eta[n], self.k[n]);
            let once = FacetLobe::none().and(reflection.value * reflectance, block);
            *kernel = once.beside(self.gain[n] * several);
        }
        kernels
    }
}

impl<const N: usize> Glossy<N> for RoughConductor<N> {
    type Lanes<'a> = RoughConductors<N>;
    const FORM: Form = Form::Spheroid;

    #[inline(always)]
    fn lanes<'a>(models: &ModelLanes<'a, Self>) -> RoughConductors<N> {
        let alpha = models.field(|model| model.alpha);
        RoughConductors::new(models, Facets::new(alpha, Self::beckmann(models)))
    }
}
