//! glTF's metallic-roughness: a rough metal, or a Lambertian base under a rough dielectric coat,
//! or a mixture of the two by the metallic factor.
//!
//! Both have the same facets (GGX). Those of the metal have eta = 1 and the k with which the base
//! color is its reflectance at normal incidence, and what several of them reflect is given back as
//! at any rough metal ([`super::rough`]). Those of the coat have glTF's index of refraction, and
//! both polarize by Fresnel's equations. The base depolarizes.
//!
//! What the coat lets through lights the base: of light that arrives at a cosine mu, `1 - E(mu)`
//! with the albedo E of the coat, and as much of what leaves it gets out, so that the base is
//!
//! ```text
//! color (1 - E(i)) (1 - E(o)) / (pi (1 - E_mean))
//! ```
//!
//! It is reciprocal, and a white base reflects all that the coat does not (Kelemen and
//! Szirmay-Kalos 2001, "A microfacet based coupled specular-matte BRDF model"). glTF's own text
//! weighs the base by `1 - F(i h)`, by which it would reflect more than it gets at grazing.

use std::f32::consts::FRAC_1_PI;

use super::glossy::Glossy;
use super::model::{ModelLanes, Surface, strongest};
use super::rough::{FacetLobe, FacetPlane, Reflected, Rough, is_above, peak};
use crate::math::F32s;
use crate::polarization::albedo::{POWERS, TERMS};
use crate::polarization::{
    Albedo, CoatAlbedo, Distribution, Even, FacetReflection, Facets, Slopes, SpheroidBlock, fresnel,
};
use crate::scattering::event::Form;
use crate::scattering::vertex::mean;

/// Least share of light that gets through a coat, on the average.
pub const THROUGH_MIN: f32 = 1e-3;

/// One material.
#[derive(Clone, Copy, Debug)]
pub struct MetallicRoughness<const N: usize> {
    /// The share of metal, within [0, 1].
    metallic: f32,
    /// The share of what the coat would reflect that there is, over all of the material.
    coat: f32,
    /// The coat's index of refraction relative to vacuum, at least 1.
    ior: f32,
    /// The roughness of the facets.
    alpha: f32,
    /// Extinction coefficient of the metal.
    k: [f32; N],
    /// The base, over the product of what the coat lets through.
    base: [f32; N],
    /// Reflectance of the base, over all of the material.
    color: [f32; N],
    /// What the coat reflects where there is no metal.
    of_coat: CoatAlbedo,
    /// What lossless facets reflect once.
    of_facets: Albedo,
    /// What the metal reflects, over all of the material.
    metal: Reflected<N>,
}

impl<const N: usize> MetallicRoughness<N> {
    /// With the base color, the share of metal, the roughness of the facets (the square of
    /// glTF's), the coat's index of refraction, and the share of what it reflects that is there.
    pub fn of(base_color: [f32; N], metallic: f32, alpha: f32, ior: f32, specular: f32) -> Self {
        let of_facets = Albedo::of_facets(Distribution::Ggx, alpha);
        let of_coat = CoatAlbedo::of(Distribution::Ggx, ior, alpha).scaled(specular);
        let k = base_color.map(fresnel::k_of_reflectance);
        let mut metal = Reflected::of([1.0; N], k, &of_facets, true);
        for values in [&mut metal.gain, &mut metal.single, &mut metal.multiple] {
            values.iter_mut().for_each(|value| *value *= metallic);
        }
        let plain = 1.0 - metallic;
        let color = base_color.map(|color| plain * color);
        let per_color = FRAC_1_PI / (1.0 - of_coat.mean).max(THROUGH_MIN);
        Self {
            metallic,
            coat: plain * specular,
            ior,
            alpha,
            k,
            base: color.map(|color| color * per_color),
            color,
            of_coat,
            of_facets,
            metal,
        }
    }
}

impl<const N: usize> Surface for MetallicRoughness<N> {
    fn scattered(&self) -> f32 {
        let Self { metallic, color, of_coat, of_facets, metal, .. } = self;
        let all = |n: usize| {
            let of_metal =
                metal.single[n] * of_facets.mean + metal.multiple[n] * (1.0 - of_facets.mean);
            of_metal + (1.0 - metallic) * of_coat.mean + color[n] * (1.0 - of_coat.mean)
        };
        strongest::<N>(std::array::from_fn(all)).min(1.0)
    }

    fn peak(&self) -> f32 {
        peak(self.alpha)
    }
}

/// Eight of them.
#[derive(Clone, Copy)]
pub struct MetallicRoughnesses<const N: usize, S = Even> {
    facets: Facets<S>,
    metallic: F32s,
    coat: F32s,
    ior: F32s,
    k: [F32s; N],
    base: [F32s; N],
    gain: [F32s; N],
    /// Of [`CoatAlbedo`].
    of_coat: [F32s; POWERS],
    /// Of [`Albedo`].
    of_facets: [F32s; TERMS],
    /// Means over the wavelengths of what the base reflects, and the metal once and several times.
    color: F32s,
    single: F32s,
    multiple: F32s,
}

impl<const N: usize, S> MetallicRoughnesses<N, S> {
    /// Those of some rows, with these facets.
    #[inline(always)]
    pub fn new(models: &ModelLanes<MetallicRoughness<N>>, facets: Facets<S>) -> Self {
        Self {
            facets,
            metallic: models.field(|model| model.metallic),
            coat: models.field(|model| model.coat),
            ior: models.field(|model| model.ior),
            k: models.spectrum(|model| &model.k),
            base: models.spectrum(|model| &model.base),
            gain: models.spectrum(|model| &model.metal.gain),
            of_coat: models.spectrum(|model| &model.of_coat.reflected),
            of_facets: models.spectrum(|model| &model.of_facets.terms),
            color: mean(&models.spectrum(|model| &model.color)),
            single: mean(&models.spectrum(|model| &model.metal.single)),
            multiple: mean(&models.spectrum(|model| &model.metal.multiple)),
        }
    }

    /// What the coat lets through of light of the cosine, and what facets that reflect all leave
    /// out, with the cosine to even ones.
    #[inline(always)]
    fn missing(&self, cos: F32s, even: F32s) -> [F32s; 2] {
        let of_facets = Albedo::missing(&self.of_facets, even);
        [F32s::splat(1.0) - CoatAlbedo::at(of_facets, &self.of_coat, cos), of_facets]
    }

    /// What is reflected otherwise than once by facets.
    #[inline(always)]
    fn depolarized(&self, reflection: &FacetReflection) -> [F32s; N] {
        let above = is_above(reflection);
        let FacetReflection { cosines, even, .. } = reflection;
        let [given, drawn] = [0, 1].map(|of| self.missing(cosines[of], even[of]));
        let [through, several] = [0, 1].map(|of| above & (given[of] * drawn[of]));
        let mut values = [F32s::splat(0.0); N];
        for (n, value) in values.iter_mut().enumerate() {
            *value = self.base[n].mul_add(through, self.gain[n] * several);
        }
        values
    }

    /// Whether any of them has metal, and a coat.
    #[inline(always)]
    fn kinds(&self) -> [bool; 2] {
        [self.metallic, self.coat].map(|share| share.simd_gt(F32s::splat(0.0)).any())
    }
}

impl<const N: usize, S: Slopes> Rough<N> for MetallicRoughnesses<N, S> {
    type Kernel = SpheroidBlock<F32s>;
    type Slopes = S;

    #[inline(always)]
    fn facets(&self) -> &Facets<S> {
        &self.facets
    }

    #[inline(always)]
    fn chances(&self, cos: F32s) -> [F32s; 2] {
        let one = F32s::splat(1.0);
        let [through, missing] = self.missing(cos, cos);
        let once = self.single * (one - missing);
        let facets = (one - self.metallic).mul_add(one - through, once);
        let several = self.multiple * missing;
        let others = self.color.mul_add(through, several);
        let least = F32s::splat(f32::MIN_POSITIVE);
        [facets / (facets + others).fast_max(least), several / others.fast_max(least)]
    }

    #[inline(always)]
    fn values(&self, reflection: &FacetReflection) -> [F32s; N] {
        let mut values = self.depolarized(reflection);
        let [has_metal, has_coat] = self.kinds();
        let cos = reflection.cos_half;
        if has_coat {
            let (reflectance, _) = fresnel::dielectric_reflectance(cos, self.ior);
            let of_coat = reflection.value * (self.coat * reflectance);
            values.iter_mut().for_each(|value| *value += of_coat);
        }
        if has_metal {
            let of_metal = reflection.value * self.metallic;
            for (value, &k) in values.iter_mut().zip(&self.k) {
                let reflectance = fresnel::conductor_reflectance(cos, F32s::splat(1.0), k);
                *value = of_metal.mul_add(reflectance, *value);
            }
        }
        values
    }

    #[inline(always)]
    fn kernels(&self, reflection: &FacetReflection, _: &FacetPlane) -> [Self::Kernel; N] {
        let (cos, depolarized) = (reflection.cos_half, self.depolarized(reflection));
        let [has_metal, has_coat] = self.kinds();
        let mut of_coat = FacetLobe::none();
        if has_coat {
            let fresnel::Interface { reflectance, reflection: block, .. } =
                fresnel::dielectric(cos, self.ior);
            of_coat = of_coat.and(reflection.value * (self.coat * reflectance), block);
        }
        let mut kernels = [of_coat.beside(depolarized[0]); N];
        for (n, kernel) in kernels.iter_mut().enumerate() {
            let mut once = of_coat;
            if has_metal {
                let (reflectance, block) = fresnel::conductor(cos, F32s::splat(1.0), self.k[n]);
                once = once.and(reflection.value * self.metallic * reflectance, block);
            }
            *kernel = once.beside(depolarized[n]);
        }
        kernels
    }
}

impl<const N: usize> Glossy<N> for MetallicRoughness<N> {
    type Lanes<'a> = MetallicRoughnesses<N>;
    const FORM: Form = Form::Spheroid;

    #[inline(always)]
    fn lanes<'a>(models: &ModelLanes<'a, Self>) -> MetallicRoughnesses<N> {
        let alpha = models.field(|model| model.alpha);
        MetallicRoughnesses::new(models, Facets::new(alpha, F32s::splat(0.0)))
    }
}
