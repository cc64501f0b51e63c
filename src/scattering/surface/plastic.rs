//! Plastic: a base that depolarizes, under a dielectric interface that light goes through polarized
//! on its way in and out (Baek et al. 2018, "Simultaneous acquisition of polarimetric SVBRDF and
//! normals").
//!
//! The interface has facets that reflect by Fresnel's Mueller matrix about their own plane of
//! incidence, once: several reflections of a dielectric are some thousandths ([`super::rough`]).
//! What goes into the base and comes out of it is refracted at the mean plane, of Mueller matrices
//! T. With a depolarizer D between them the base is
//!
//! ```text
//! M = g T(o) D T(i) / pi        of M00 = g t(i) t(o) / pi
//! ```
//!
//! that is a column (1, a(o), 0, 0) times a row (1, a(i), 0, 0), with the diattenuation a of
//! refraction, in the frames of the two planes of incidence: dense in any frame that both share.
//!
//! Of the light within the base, the interface sends some back to it, which is scattered again. All
//! of that light has been depolarized, so that it changes nothing but the gain g, by what the base
//! of reflectance r is said to do with it ([`InternalReflection`]):
//!
//! | | g | t |
//! |---|---|---|
//! | lost | r | 1 - F, as Baek et al. have it |
//! | linear | r / m | 1 - E |
//! | nonlinear | r / (n^2 (1 - r (1 - m / n^2))) | 1 - E |
//!
//! Here F is Fresnel's reflectance, E what the facets reflect of light from a direction
//! ([`CoatAlbedo`]), m the mean of t over the hemisphere, and 1 - m / n^2 what is reflected within,
//! by reciprocity. With E and r = 1, all light that the facets do not reflect comes out of the
//! base.

use std::f32::consts::FRAC_1_PI;

use super::glossy::Glossy;
use super::model::{ModelLanes, Surface, strongest};
use super::rough::{FacetPlane, Rough, is_above, peak};
use crate::math::{F32s, Real, Vector};
use crate::polarization::albedo::{POWERS, TERMS, mean_over_cosines};
use crate::polarization::{
    Albedo, Block, CoatAlbedo, Dense, Distribution, Even, FacetReflection, Facets, Rotation,
    Stokes, fresnel, s_axis,
};
use crate::scattering::event::Form;
use crate::scattering::vertex::mean;
use crate::scene::world::{Coat, InternalReflection};

/// Keeps denominators off zero.
const TINY: f32 = 1e-30;

/// One material.
#[derive(Clone, Copy, Debug)]
pub struct Plastic<const N: usize> {
    /// The base, over the product of what the interface lets through.
    base: [f32; N],
    /// What the base reflects of what gets to it, by wavelength.
    share: [f32; N],
    /// Index of refraction within, over that outside.
    ior: f32,
    /// The roughness of the facets.
    alpha: f32,
    /// 1 for Beckmann's distribution, else 0.
    beckmann: f32,
    /// The share of what facets would reflect that is there.
    specular: f32,
    /// 1 where Fresnel's equations say what gets through, 0 where the albedo of facets does.
    smooth: f32,
    /// What the whole facets reflect.
    albedo: CoatAlbedo,
}

impl<const N: usize> Plastic<N> {
    /// With the reflectance of the base, and its interface.
    pub fn of(reflectance: [f32; N], coat: Coat) -> Self {
        let Coat { exterior_ior, alpha, distribution, specular, internal_reflection, .. } = coat;
        let ior = coat.ior / exterior_ior;
        let albedo = CoatAlbedo::of(distribution, ior, alpha);
        let by_fresnel = |cos| F32s::ONE - fresnel::dielectric_reflectance(cos, F32s::splat(ior)).0;
        let (is_smooth, through) = match internal_reflection {
            InternalReflection::Lost => (true, mean_over_cosines(by_fresnel)),
            InternalReflection::Linear | InternalReflection::Nonlinear => {
                (false, 1.0 - albedo.mean)
            }
        };
        let gain = |r: f32| match internal_reflection {
            InternalReflection::Lost => r,
            InternalReflection::Linear => r / through,
            InternalReflection::Nonlinear => r / (ior * ior * (1.0 - r) + r * through),
        };
        let gains = reflectance.map(gain);
        Self {
            base: gains.map(|gain| FRAC_1_PI * gain),
            share: gains.map(|gain| gain * through),
            ior,
            alpha,
            beckmann: if distribution == Distribution::Beckmann { 1.0 } else { 0.0 },
            specular,
            smooth: if is_smooth { 1.0 } else { 0.0 },
            albedo,
        }
    }
}

impl<const N: usize> Surface for Plastic<N> {
    fn scattered(&self) -> f32 {
        let of_facets = self.specular * self.albedo.mean;
        (of_facets + strongest(self.share) * (1.0 - self.albedo.mean)).min(1.0)
    }

    fn peak(&self) -> f32 {
        peak(self.alpha)
    }
}

/// Eight of them.
#[derive(Clone, Copy)]
pub struct Plastics<const N: usize> {
    facets: Facets,
    base: [F32s; N],
    ior: F32s,
    specular: F32s,
    /// Mask of those through which light gets as Fresnel's equations say.
    smooth: F32s,
    /// Of [`CoatAlbedo`].
    facets_terms: [F32s; TERMS],
    reflected: [F32s; POWERS],
    /// Mean over the wavelengths of what the base reflects.
    share: F32s,
}

impl<const N: usize> Plastics<N> {
    /// What the facets do not reflect of light of the cosine.
    #[inline(always)]
    fn missing(&self, cos: F32s) -> F32s {
        let of_facets = Albedo::missing(&self.facets_terms, cos);
        F32s::ONE - CoatAlbedo::at(of_facets, &self.reflected, cos)
    }

    /// The share of light of the cosine that gets through the interface.
    #[inline(always)]
    fn through(&self, cos: F32s) -> F32s {
        let mut through = self.missing(cos);
        if self.smooth.any() {
            let cos = cos.fast_max(F32s::ZERO);
            let (reflectance, _) = fresnel::dielectric_reflectance(cos, self.ior);
            through = Real::select(self.smooth, F32s::ONE - reflectance, through);
        }
        through
    }

    /// What the base scatters, per [`Plastic::base`].
    #[inline(always)]
    fn of_base(&self, reflection: &FacetReflection) -> F32s {
        let [given, drawn] = reflection.cosines.map(|cos| self.through(cos));
        is_above(reflection) & (given * drawn)
    }

    /// The matrix of the base over its M00, about the axis of the facets' plane.
    #[inline(always)]
    fn base_matrix(&self, reflection: &FacetReflection, plane: &FacetPlane) -> [[F32s; 4]; 4] {
        let &FacetPlane { normal, axis, k_in, k_out } = plane;
        let [leans_in, leans_out] = reflection.cosines.map(|cos| {
            let cos = cos.fast_max(F32s::ZERO).fast_min(F32s::ONE);
            fresnel::dielectric(cos, self.ior).transmission.a
        });
        let of_plane = |a: F32s| [F32s::ONE, a, F32s::ZERO, F32s::ZERO];
        let across = |k: Vector<F32s>| s_axis(normal, k);
        let arriving = Rotation::between(axis, across(k_in), k_in);
        let leaving = Rotation::between(across(k_out), axis, k_out);
        let row = arriving.collect_row(of_plane(leans_in));
        let Stokes(column) = leaving.apply(Stokes(of_plane(leans_out)));
        column.map(|of_column| row.map(|of_row| of_column * of_row))
    }
}

impl<const N: usize> Rough<N> for Plastics<N> {
    type Kernel = Dense<F32s>;
    type Slopes = Even;

    #[inline(always)]
    fn facets(&self) -> &Facets {
        &self.facets
    }

    #[inline(always)]
    fn chances(&self, cos: F32s) -> [F32s; 2] {
        let missing = self.missing(cos);
        let once = self.specular * (F32s::ONE - missing);
        let base = self.share * missing;
        [once / (once + base).fast_max(F32s::splat(f32::MIN_POSITIVE)), F32s::ZERO]
    }

    #[inline(always)]
    fn values(&self, reflection: &FacetReflection) -> [F32s; N] {
        let (reflectance, _) = fresnel::dielectric_reflectance(reflection.cos_half, self.ior);
        let once = reflection.value * (self.specular * reflectance);
        let through = self.of_base(reflection);
        let mut values = self.base;
        values.iter_mut().for_each(|value| *value = value.mul_add(through, once));
        values
    }

    #[inline(always)]
    fn kernels(&self, reflection: &FacetReflection, plane: &FacetPlane) -> [Self::Kernel; N] {
        let fresnel::Interface { reflectance, reflection: block, .. } =
            fresnel::dielectric(reflection.cos_half, self.ior);
        let once = reflection.value * (self.specular * reflectance);
        let through = self.of_base(reflection);
        let of_base = self.base_matrix(reflection, plane);
        let Block { a, c, s } = block;
        let (zero, one) = (F32s::ZERO, F32s::ONE);
        let of_facets =
            [[one, a, zero, zero], [a, one, zero, zero], [zero, zero, c, s], [zero, zero, -s, c]];
        let mut kernels = [Dense([[one; 4]; 4]); N];
        for (Dense(kernel), &base) in kernels.iter_mut().zip(&self.base) {
            let below = base * through;
            let scale = one / (once + below).fast_max(F32s::splat(TINY));
            let [once, below] = [once * scale, below * scale];
            let elements = kernel.as_flattened_mut().iter_mut();
            let parts = of_facets.as_flattened().iter().zip(of_base.as_flattened());
            // The first is one.
            for (element, (&facets, &base)) in elements.zip(parts).skip(1) {
                *element = once.mul_add(facets, below * base);
            }
        }
        kernels
    }
}

impl<const N: usize> Glossy<N> for Plastic<N> {
    type Lanes<'a> = Plastics<N>;
    const FORM: Form = Form::Dense;

    #[inline(always)]
    fn lanes<'a>(models: &ModelLanes<'a, Self>) -> Plastics<N> {
        let alpha = models.field(|model| model.alpha);
        let half = F32s::splat(0.5);
        Plastics {
            facets: Facets::new(alpha, models.field(|model| model.beckmann).simd_gt(half)),
            base: models.spectrum(|model| &model.base),
            ior: models.field(|model| model.ior),
            specular: models.field(|model| model.specular),
            smooth: models.field(|model| model.smooth).simd_gt(half),
            facets_terms: models.spectrum(|model| &model.albedo.facets),
            reflected: models.spectrum(|model| &model.albedo.reflected),
            share: mean(&models.spectrum(|model| &model.share)),
        }
    }
}

#[cfg(test)]
mod tests;
