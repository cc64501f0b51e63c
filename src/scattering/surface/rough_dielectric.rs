//! Rough glass: facets that reflect and refract, each as smooth glass does.
//!
//! What has met several facets is given back as at rough metal ([`super::rough`]), depolarized, on
//! both sides of the surface. With the albedo `E` of single scattering on a side (what facets
//! reflect and let through), `M = 1 - E`, and its mean `m` by the cosine, light that arrives on the
//! side i leaves it with
//!
//! ```text
//! (1 - t_i) M_i(in) M_i(out) / (pi m_i)      on the same side,
//! t_i M_i(in) M_o(out) / (pi m_o)            on the other,
//! ```
//!
//! which is all that is missing. Both are reciprocal, but for the square of the index that radiance
//! grows with, where `t_i m_i n_i^2` is the same for both sides: from the side of less, as much
//! gets through as smooth facets let through of light from everywhere.

use std::f32::consts::FRAC_1_PI;

use super::facing::Facing;
use super::glossy::{Glossy, Lobes};
use super::model::{Drawn, ModelLanes, Surface};
use super::rough::{FacetLobe, Grazing, MISSING_MIN, NARROW, PDF_MIN, choose, stains};
use crate::math::{F32s, Real, Vector, warp};
use crate::polarization::albedo::{TERMS, mean_over_cosines};
use crate::polarization::{
    Albedo, Block, Distribution, Even, FacetRefraction, Facets, Slopes, SpheroidBlock, fresnel,
    s_axis,
};
use crate::scattering::event::Form;
use crate::scattering::side::Side;
use crate::scattering::vertex::Kernels;

/// The front, and the back.
pub const SIDES: usize = 2;

/// One material.
#[derive(Clone, Copy, Debug)]
pub struct RoughDielectric<const N: usize> {
    /// Index of refraction behind the front relative to before it, greater than 0.
    ior: [f32; N],
    /// The roughness of the facets.
    alpha: f32,
    /// 1 for Beckmann's distribution, else 0.
    beckmann: f32,
    sides: [OfSide; SIDES],
    /// What is left of light that is reflected, and of what goes through, if that is not all.
    stain: Option<[[f32; N]; 2]>,
}

/// What is given back of light that arrives on one side.
#[derive(Clone, Copy, Debug)]
pub struct OfSide {
    /// Terms of the albedo of what is scattered once.
    pub terms: [f32; TERMS],
    /// The share of the rest that gets through.
    pub through: f32,
    /// The lobe of what stays on the side, over the product of what is missing of both directions.
    pub back: f32,
    /// The same of what gets through.
    pub beyond: f32,
}

impl<const N: usize> RoughDielectric<N> {
    /// With the indices of refraction behind and before the front and the roughness of facets;
    /// light that several of them scatter is there if `multiple_scattering` is.
    pub fn of(
        ior: [f32; N],
        exterior_ior: [f32; N],
        alpha: f32,
        distribution: Distribution,
        multiple_scattering: bool,
    ) -> Self {
        let ior: [f32; N] = std::array::from_fn(|n| ior[n] / exterior_ior[n]);
        let mean = ior.iter().sum::<f32>() / N as f32;
        let albedos = [mean, 1.0 / mean].map(|of| Albedo::of_glass(distribution, of, alpha));
        let reflected = |relative: f32, _: usize| {
            mean_over_cosines(|cos| fresnel::dielectric_reflectance(cos, F32s::splat(relative)).0)
        };
        Self {
            ior,
            alpha,
            beckmann: if distribution == Distribution::Beckmann { 1.0 } else { 0.0 },
            sides: sides(mean, (&albedos, multiple_scattering), reflected),
            stain: None,
        }
    }

    /// Leaves so much of light that is reflected, and of what goes through.
    pub fn stain(&mut self, stain: [[f32; N]; 2]) {
        self.stain = Some(stain);
    }
}

/// What is given back at a boundary of this index of refraction, behind over before; `reflected`
/// says the mean reflectance of smooth facets on a side, where the index is this one.
pub fn sides(
    ior: f32,
    (albedos, is_given_back): (&[Albedo; SIDES], bool),
    reflected: impl FnOnce(f32, usize) -> f32,
) -> [OfSide; SIDES] {
    let missing = albedos.map(|albedo| 1.0 - albedo.mean);
    if !is_given_back || missing.iter().any(|missing| *missing < MISSING_MIN) {
        let of =
            |albedo: &Albedo| OfSide { terms: albedo.terms, through: 0.0, back: 0.0, beyond: 0.0 };
        return std::array::from_fn(|side| of(&albedos[side]));
    }
    let weight = [missing[0], missing[1] * ior * ior];
    let less = usize::from(weight[1] < weight[0]);
    let relative = if less == 0 { ior } else { 1.0 / ior };
    let reflected = reflected(relative, less);
    let of = |side: usize| {
        let through = (1.0 - reflected) * weight[less] / weight[side];
        OfSide {
            terms: albedos[side].terms,
            through,
            back: (1.0 - through) * FRAC_1_PI / missing[side],
            beyond: through * FRAC_1_PI / missing[1 - side],
        }
    };
    std::array::from_fn(of)
}

impl<const N: usize> RoughDielectric<N> {
    /// Mask of rows with Beckmann's distribution.
    #[inline(always)]
    pub fn beckmann(models: &ModelLanes<Self>) -> F32s {
        models.field(|model| model.beckmann).simd_gt(F32s::splat(0.5))
    }
}

impl<const N: usize> Surface for RoughDielectric<N> {
    const NESTS: bool = true;

    fn scattered(&self) -> f32 {
        1.0
    }

    fn peak(&self) -> f32 {
        peak(self.alpha)
    }
}

/// The end of the peak of facets that refract: about the refracted direction, too, paths go on from
/// what is narrow whatever comes. Facets turn what they refract by a third of what they turn
/// reflected light, mostly.
pub fn peak(alpha: f32) -> f32 {
    const OF_REFRACTED: f32 = 3.0;
    if alpha < OF_REFRACTED * NARROW { 2.0 } else { 0.0 }
}

/// Eight of them.
#[derive(Clone, Copy)]
pub struct RoughDielectrics<const N: usize, S = Even> {
    facets: Facets<S>,
    ior: [F32s; N],
    /// Whether all wavelengths have the same index.
    is_gray: bool,
    sides: [LanesOfSide; SIDES],
    stain: Option<[[F32s; N]; 2]>,
}

/// See [`OfSide`].
#[derive(Clone, Copy)]
struct LanesOfSide {
    terms: [F32s; TERMS],
    through: F32s,
    back: F32s,
    beyond: F32s,
}

/// Eight surfaces as they are for light of one side each.
struct Sided<'a, const N: usize, S> {
    of: &'a RoughDielectrics<N, S>,
    /// Mask of those that are looked at from the front.
    front: F32s,
    /// The shading normal there.
    normal: Vector<F32s>,
    cos_given: F32s,
    /// What that is to even facets.
    even_given: F32s,
}

/// What facets do between two directions at one wavelength.
struct Once {
    /// The scattering function, for radiance that arrives along the drawn direction.
    value: F32s,
    /// The density of drawing the direction by facets.
    pdf: F32s,
    /// The Mueller matrix over the value.
    block: Block<F32s>,
    /// The normal of the facets.
    half: Vector<F32s>,
}

impl<'a, const N: usize, S: Slopes> Sided<'a, N, S> {
    #[inline(always)]
    fn new(of: &'a RoughDielectrics<N, S>, facing: &Facing, given: Vector<F32s>) -> Self {
        let normal = facing.shading_towards(given);
        let cos_given = given.dot(normal);
        Self {
            of,
            front: given.dot(facing.shading).simd_gt(F32s::splat(0.0)),
            normal,
            cos_given,
            even_given: of.facets.even(normal, given, cos_given),
        }
    }

    /// The index of refraction on the other side, relative to this one.
    #[inline(always)]
    fn eta(&self, n: usize) -> F32s {
        let ior = self.of.ior[n];
        Real::select(self.front, ior, F32s::splat(1.0) / ior)
    }

    #[inline(always)]
    fn pick(&self, of: impl Fn(&LanesOfSide) -> F32s) -> F32s {
        let [front, back] = &self.of.sides;
        Real::select(self.front, of(front), of(back))
    }

    /// What is missing of light that arrives on this side, and on the other, by the cosine.
    #[inline(always)]
    fn missing(&self, cos: F32s) -> [F32s; SIDES] {
        let [front, back] = self.of.sides.each_ref().map(|side| Albedo::missing(&side.terms, cos));
        [Real::select(self.front, front, back), Real::select(self.front, back, front)]
    }

    /// The probability of drawing by facets.
    #[inline(always)]
    fn chance_of_facets(&self) -> F32s {
        let [missing, _] = self.missing(self.cos_given);
        let gives_back = self.pick(|side| side.back + side.beyond).simd_gt(F32s::splat(0.0));
        F32s::splat(1.0) - (gives_back & missing)
    }

    /// What facets do at a wavelength; with `POLARIZED`, the block is wanted too.
    #[inline(always)]
    fn once<const POLARIZED: bool>(
        &self,
        n: usize,
        given: Vector<F32s>,
        drawn: Vector<F32s>,
    ) -> Once {
        let (zero, one, eta) = (F32s::splat(0.0), F32s::splat(1.0), self.eta(n));
        let mut once = Once { value: zero, pdf: zero, block: Block::identity(), half: self.normal };
        let same = drawn.dot(self.normal).simd_gt(zero);
        if same.any() {
            let reflection = self.of.facets.reflect(self.normal, given, drawn);
            let face = fresnel::dielectric(reflection.cos_half, eta);
            once.value = reflection.value * face.reflectance;
            once.pdf = self.of.facets.pdf(self.normal, given, drawn) * face.reflectance;
            once.half = reflection.half;
            if POLARIZED {
                once.block = face.reflection;
            }
        }
        if !same.all() {
            let FacetRefraction { half, cos_half, value, pdf } =
                self.of.facets.refract(self.normal, given, drawn, eta);
            let face = fresnel::dielectric(cos_half, eta);
            let passes = one - face.reflectance;
            once.value = Real::select(same, once.value, value * passes);
            once.pdf = Real::select(same, once.pdf, pdf * passes);
            once.half = Vector::select(same, once.half, half);
            if POLARIZED {
                once.block = Block::select(same, once.block, face.transmission);
            }
        }
        once
    }

    /// What has met several facets, for radiance that arrives along the drawn direction.
    #[inline(always)]
    fn several(&self, drawn: Vector<F32s>) -> F32s {
        let cos = drawn.dot(self.normal);
        let same = cos.simd_gt(F32s::splat(0.0));
        let [given, _] = self.missing(self.even_given);
        let even = self.of.facets.even(self.normal, drawn, cos);
        let [here, there] = self.missing(even.abs());
        // Radiance that arrives on the other side gets through by what there is there.
        let [front, back] = &self.of.sides;
        let beyond = Real::select(self.front, back.beyond, front.beyond);
        let gain = Real::select(same, self.pick(|side| side.back) * here, beyond * there);
        gain * given
    }
}

impl<const N: usize, S> RoughDielectrics<N, S> {
    /// Those of some rows, with these facets.
    #[inline(always)]
    pub fn new(models: &ModelLanes<RoughDielectric<N>>, facets: Facets<S>) -> Self {
        let ior = models.spectrum(|model| &model.ior);
        let side = |side: usize| LanesOfSide {
            terms: models.spectrum(|model| &model.sides[side].terms),
            through: models.field(|model| model.sides[side].through),
            back: models.field(|model| model.sides[side].back),
            beyond: models.field(|model| model.sides[side].beyond),
        };
        Self {
            facets,
            ior,
            is_gray: ior.iter().all(|of| of.simd_eq(ior[0]).all()),
            sides: [side(0), side(1)],
            stain: stains(models, |model| model.stain.as_ref()),
        }
    }

    /// How many wavelengths differ.
    #[inline(always)]
    fn kinds(&self) -> usize {
        if self.is_gray { 1 } else { N }
    }
}

impl<const N: usize, S: Slopes> Lobes<N> for RoughDielectrics<N, S> {
    type Kernel = SpheroidBlock<F32s>;

    #[inline(always)]
    fn values(
        &self,
        facing: &Facing,
        given: Vector<F32s>,
        drawn: Vector<F32s>,
        side: Side,
    ) -> [F32s; N] {
        let sided = Sided::new(self, facing, given);
        let (one, several) = (F32s::splat(1.0), sided.several(drawn));
        let same = drawn.dot(sided.normal).simd_gt(F32s::splat(0.0));
        let at = |n: usize| {
            let value = sided.once::<false>(n, given, drawn).value + several;
            let eta = sided.eta(n);
            match side {
                Side::Sensor => value,
                Side::Light => value * Real::select(same, one, eta * eta),
            }
        };
        let mut values = [at(0); N];
        for (n, value) in values.iter_mut().enumerate().take(self.kinds()).skip(1) {
            *value = at(n);
        }
        if let Some(stain) = &self.stain {
            color(&mut values, stain, same);
        }
        values
    }

    #[inline(always)]
    fn pdf(&self, facing: &Facing, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
        let sided = Sided::new(self, facing, given);
        let kinds = self.kinds();
        let mut of_facets = F32s::splat(0.0);
        for n in 0..kinds {
            of_facets += sided.once::<false>(n, given, drawn).pdf;
        }
        of_facets *= F32s::splat(1.0 / kinds as f32);
        let cos = drawn.dot(sided.normal);
        let through = sided.pick(|side| side.through);
        let share =
            Real::select(cos.simd_gt(F32s::splat(0.0)), F32s::splat(1.0) - through, through);
        let of_lobe = share * Grazing::of(&self.facets).pdf(cos.abs());
        sided.chance_of_facets().mul_add(of_facets - of_lobe, of_lobe)
    }

    /// The first number chooses between facets and what they leave out, too; the third one a
    /// wavelength, and one of the sides.
    #[inline(always)]
    fn draw(
        &self,
        facing: &Facing,
        given: Vector<F32s>,
        [first, second, third]: [F32s; 3],
        side: Side,
    ) -> Drawn<N> {
        let one = F32s::splat(1.0);
        let sided = Sided::new(self, facing, given);
        let chance = sided.chance_of_facets();
        let (by_facets, again) = choose(first, chance);
        let again = [again, second];
        let (mut eta, mut decision) = (sided.eta(0), third);
        if !self.is_gray {
            let place = third * F32s::splat(N as f32);
            for n in 1..N {
                let reached = place.simd_ge(F32s::splat(n as f32));
                eta = Real::select(reached, sided.eta(n), eta);
            }
            decision = place - place.floor();
        }
        let half = self.facets.draw_half(sided.normal, given, again);
        let cos_half = given.dot(half).fast_max(F32s::splat(0.0)).fast_min(one);
        let (reflectance, cos_t) = fresnel::dielectric_reflectance(cos_half, eta);
        let reflected = half * (cos_half + cos_half) - given;
        let refracted = half * (cos_half / eta - cos_t) - given * (one / eta);
        let reflects = decision.simd_lt(reflectance);
        let of_facets = Vector::select(reflects, reflected, refracted);
        let lobe = [Grazing::of(&self.facets).cosine_number(again[0]), second];
        let (cosine, _) = warp::cosine_hemisphere(sided.normal, lobe);
        let passes = decision.simd_lt(sided.pick(|side| side.through));
        let mirrored = sided.normal * (cosine.dot(sided.normal) * F32s::splat(-2.0)) + cosine;
        let of_cosine = Vector::select(passes, mirrored, cosine);
        let direction = Vector::select(by_facets, of_facets, of_cosine).normalize();
        let pdf = self.pdf(facing, given, direction).fast_max(F32s::splat(PDF_MIN));
        let mut weight = self.values(facing, given, direction, side);
        let cos = direction.dot(sided.normal);
        // What facets send to the other side than they should meets others.
        let is_lost = by_facets & (cos.simd_gt(F32s::splat(0.0)) ^ reflects);
        let scale = !is_lost & (cos.abs() / pdf);
        weight.iter_mut().for_each(|weight| *weight *= scale);
        Drawn { direction, pdf, weight, lost: is_lost }
    }

    #[inline(always)]
    fn kernels(&self, facing: &Facing, k_in: Vector<F32s>, k_out: Vector<F32s>) -> Kernels<N> {
        let given = -k_in;
        let sided = Sided::new(self, facing, given);
        let several = sided.several(k_out);
        let kernel = |once: &Once| FacetLobe::none().and(once.value, once.block).beside(several);
        let first = sided.once::<true>(0, given, k_out);
        let mut kernels: [SpheroidBlock<F32s>; N] = [kernel(&first); N];
        for (n, kernel_n) in kernels.iter_mut().enumerate().take(self.kinds()).skip(1) {
            *kernel_n = kernel(&sided.once::<true>(n, given, k_out));
        }
        (kernels, s_axis(first.half, k_in))
    }
}

/// Leaves what a stain does of values, of which these stay on their side.
#[cold]
fn color<const N: usize>(values: &mut [F32s; N], stain: &[[F32s; N]; 2], same: F32s) {
    let [reflected, transmitted] = stain;
    for (n, value) in values.iter_mut().enumerate() {
        *value *= Real::select(same, reflected[n], transmitted[n]);
    }
}

impl<const N: usize> Glossy<N> for RoughDielectric<N> {
    type Lanes<'a> = RoughDielectrics<N>;
    const FORM: Form = Form::Spheroid;
    const TRANSMITS: bool = true;

    #[inline(always)]
    fn lanes<'a>(models: &ModelLanes<'a, Self>) -> RoughDielectrics<N> {
        let alpha = models.field(|model| model.alpha);
        RoughDielectrics::new(models, Facets::new(alpha, Self::beckmann(models)))
    }
}

#[cfg(test)]
mod tests;
