//! What rough surfaces have in common: facets that are mirrors, and light that is scattered in all
//! directions beside.
//!
//! Facets have Fresnel's Mueller matrix about the plane of their normal and the light. What has
//! been reflected by several of them is given back by the lobe of Kulla and Conty (see
//! [`crate::polarization::albedo`]) with the color of light that has been reflected more than
//! once, `F_mean^2 E_mean / (1 - F_mean (1 - E_mean))` of what is missing. It is depolarized: such
//! light has come by planes of incidence of all directions, over which polarization averages out
//! but for a share that no model of single reflections tells.

use std::f32::consts::FRAC_1_PI;

use super::facing::Facing;
use super::glossy::Lobes;
use super::model::{Drawn, ModelLanes};
use crate::math::{F32s, Real, Vector, lanes, warp};
use crate::polarization::albedo::mean_over_cosines;
use crate::polarization::{
    ALPHA_MIN, Albedo, Block, Even, FacetReflection, Facets, Slopes, SpheroidBlock, fresnel, s_axis,
};
use crate::scattering::event::Elements;
use crate::scattering::side::Side;

/// Least share of what is missing, on the average, for which there is a lobe.
pub const MISSING_MIN: f32 = 1e-5;
/// Keeps denominators off zero.
pub const TINY: f32 = 1e-30;
/// Least density that is said of a drawn direction: of those below the surface, which carry
/// nothing, it would be zero.
pub const PDF_MIN: f32 = 1e-12;

/// Roughness from which on photons merge whatever their directions.
pub const NARROW: f32 = 0.2;
/// Slopes of facets in the peak, over the roughness: beyond it GGX has a hundredth of its most.
const PEAK: f32 = 3.0;

/// The end of the peak of facets of this roughness; see [`Surface::peak`]. A mirror that is turned
/// by an angle turns light by twice that.
///
/// [`Surface::peak`]: super::model::Surface::peak
pub fn peak(alpha: f32) -> f32 {
    if alpha >= NARROW {
        return 0.0;
    }
    let slope = PEAK * alpha.max(ALPHA_MIN);
    slope * slope / (1.0 + slope * slope)
}

/// The Mueller matrix of what facets of one normal reflect: a sum of blocks about the same axis.
#[derive(Clone, Copy)]
pub struct FacetLobe {
    m00: F32s,
    m01: F32s,
    m22: F32s,
    m23: F32s,
}

impl FacetLobe {
    /// Nothing.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = F32s::splat(0.0);
        Self { m00: zero, m01: zero, m22: zero, m23: zero }
    }

    /// With a reflection of this M00 and the block over it.
    #[inline(always)]
    pub fn and(self, m00: F32s, block: Block<F32s>) -> Self {
        Self {
            m00: self.m00 + m00,
            m01: m00.mul_add(block.a, self.m01),
            m22: m00.mul_add(block.c, self.m22),
            m23: m00.mul_add(block.s, self.m23),
        }
    }

    /// What of unpolarized light it reflects, per steradian.
    #[inline(always)]
    pub fn m00(&self) -> F32s {
        self.m00
    }

    /// The kernel where something else that depolarizes has the M00 `beside`.
    #[inline(always)]
    pub fn beside(self, beside: F32s) -> SpheroidBlock<F32s> {
        let scale = F32s::splat(1.0) / (self.m00 + beside).fast_max(F32s::splat(TINY));
        let c = self.m22 * scale;
        SpheroidBlock { a: self.m01 * scale, b: self.m00 * scale, c, d: c, s: self.m23 * scale }
    }
}

/// What metal facets reflect, once and several times, of light from everywhere.
#[derive(Clone, Copy, Debug)]
pub struct Reflected<const N: usize> {
    /// The lobe of several reflections, over the product of what single ones leave out of both
    /// directions.
    pub gain: [f32; N],
    /// Mean reflectance of the facets.
    pub single: [f32; N],
    /// What is reflected in the end of that which meets a second facet, over what lossless ones
    /// would reflect; zero where it is not given back.
    pub multiple: [f32; N],
}

impl<const N: usize> Reflected<N> {
    /// By facets of the index n - i k with the `albedo` of lossless ones.
    pub fn of(eta: [f32; N], k: [f32; N], albedo: &Albedo, is_given_back: bool) -> Self {
        let single = std::array::from_fn(|n| {
            let [eta, k] = [eta[n], k[n]].map(F32s::splat);
            mean_over_cosines(|cos| fresnel::conductor_reflectance(cos, eta, k))
        });
        Self::of_means(single, albedo, is_given_back)
    }

    /// By facets of these mean reflectances.
    pub fn of_means(single: [f32; N], albedo: &Albedo, is_given_back: bool) -> Self {
        let missing = 1.0 - albedo.mean;
        if !is_given_back || missing < MISSING_MIN {
            return Self { gain: [0.0; N], single, multiple: [0.0; N] };
        }
        let multiple = single.map(|f: f32| f * f * albedo.mean / (1.0 - f * missing));
        let gain = multiple.map(|share| share * FRAC_1_PI / missing);
        Self { gain, single, multiple }
    }
}

/// How light goes by the facets that reflect it.
pub struct FacetPlane {
    /// The surface's normal, on the side of the light.
    pub normal: Vector<F32s>,
    /// Across the facets' plane of incidence.
    pub axis: Vector<F32s>,
    /// Along the light that arrives.
    pub k_in: Vector<F32s>,
    /// Along the light that leaves.
    pub k_out: Vector<F32s>,
}

/// Eight rough surfaces, from which directions are drawn by facets, or else by the cosine.
pub trait Rough<const N: usize> {
    /// How rough their facets are by direction.
    type Slopes: Slopes;

    /// The facets.
    fn facets(&self) -> &Facets<Self::Slopes>;

    /// The probability of drawing by facets for a path that comes from a direction of the cosine
    /// `cos`, and the share of the rest that is like what they leave out: see [`Mixture`].
    fn chances(&self, cos: F32s) -> [F32s; 2];

    /// The scattering function per steradian, where facets reflect so much; zero where directions
    /// are not both above the surface.
    fn values(&self, reflection: &FacetReflection) -> [F32s; N];

    /// What the kernels are made of.
    type Kernel: Elements;

    /// The kernels, over the axis of the facets' plane of incidence.
    fn kernels(&self, reflection: &FacetReflection, plane: &FacetPlane) -> [Self::Kernel; N];

    /// What facets reflect between two directions.
    #[inline(always)]
    fn reflect(
        &self,
        facing: &Facing,
        given: Vector<F32s>,
        drawn: Vector<F32s>,
    ) -> FacetReflection {
        self.facets().reflect(facing.shading_towards(given), given, drawn)
    }
}

/// Directions that are drawn by facets, with some chance, or else by the cosine, or towards the
/// cosines that facets leave out most of.
#[derive(Clone, Copy)]
pub struct Mixture<S = Even> {
    /// The facets.
    pub facets: Facets<S>,
    /// The probability of drawing by them.
    pub chance: F32s,
    /// The share of the rest that is drawn by [`Grazing`].
    pub grazing: F32s,
}

impl<S: Slopes> Mixture<S> {
    /// That of rough surfaces for paths that come from directions of the cosine `cos`.
    #[inline(always)]
    fn of<const N: usize>(rough: &impl Rough<N, Slopes = S>, cos: F32s) -> Self {
        let [chance, grazing] = rough.chances(cos);
        Self { facets: *rough.facets(), chance, grazing }
    }

    /// Density per steradian of [`Mixture::draw`]; see [`Lobes::pdf`].
    #[inline(always)]
    pub fn pdf(&self, normal: Vector<F32s>, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
        let of_facets = self.facets.pdf(normal, given, drawn);
        let cos = drawn.dot(normal).fast_max(F32s::splat(0.0));
        let mut others = warp::cosine_pdf(cos);
        if self.grazes() {
            let of_lobe = Grazing::of(&self.facets).pdf(cos);
            others = self.grazing.mul_add(of_lobe - others, others);
        }
        self.chance.mul_add(of_facets - others, others)
    }

    /// Draws a direction, for a path that comes from `given` above the surface of the `normal`,
    /// with its density. The first number chooses between facets and the others, too.
    #[inline(always)]
    pub fn draw(
        &self,
        normal: Vector<F32s>,
        given: Vector<F32s>,
        u: [F32s; 2],
    ) -> (Vector<F32s>, F32s) {
        let (by_facets, first) = choose(u[0], self.chance);
        let of_facets = self.facets.draw(normal, given, [first, u[1]]);
        let mut height = first;
        if self.grazes() {
            let (by_lobe, again) = choose(first, self.grazing);
            let low = Grazing::of(&self.facets).cosine_number(again);
            height = Real::select(by_lobe, low, again);
        }
        let (of_cosine, _) = warp::cosine_hemisphere(normal, [height, u[1]]);
        let direction = Vector::select(by_facets, of_facets, of_cosine);
        (direction, self.pdf(normal, given, direction).fast_max(F32s::splat(PDF_MIN)))
    }

    #[inline(always)]
    fn grazes(&self) -> bool {
        let one = F32s::splat(1.0);
        (self.grazing.simd_gt(F32s::splat(0.0)) & self.chance.simd_lt(one)).any()
    }
}

/// Whether a number in [0, 1) is below a chance, and the number that it is within its part.
#[inline(always)]
pub fn choose(number: F32s, chance: F32s) -> (F32s, F32s) {
    let one = F32s::splat(1.0);
    let below_one = F32s::splat(1.0 - f32::EPSILON / 2.0);
    let is_below = number.simd_lt(chance);
    let less = number / chance.fast_max(F32s::splat(TINY));
    let more = (number - chance) / (one - chance).fast_max(F32s::splat(TINY));
    (is_below, Real::select(is_below, less, more).fast_min(below_one))
}

/// Directions of the density `mu / (mu^2 + s^2)` over its integral, of cosines mu about a scale s:
/// as what facets leave out, which goes with the square of the roughness over the cosine.
pub struct Grazing {
    scale2: F32s,
    /// Twice the integral of the density.
    integral: F32s,
}

impl Grazing {
    /// About cosines like the roughness of these facets.
    #[inline(always)]
    pub fn of(facets: &Facets<impl Slopes>) -> Self {
        let (one, scale) = (F32s::splat(1.0), facets.alpha() * F32s::splat(2.0));
        let scale2 = scale * scale;
        Self { scale2, integral: (one + one / scale2).ln() }
    }

    /// The density per steradian.
    #[inline(always)]
    pub fn pdf(&self, cos: F32s) -> F32s {
        F32s::splat(FRAC_1_PI) * cos / (self.integral * cos.mul_add(cos, self.scale2))
    }

    /// The number by which [`warp::cosine_hemisphere`] draws what is drawn here by `u`.
    #[inline(always)]
    pub fn cosine_number(&self, u: F32s) -> F32s {
        let one = F32s::splat(1.0);
        let cos2 = self.scale2 * ((u * self.integral).exp() - one);
        (one - cos2).fast_max(F32s::splat(0.0)).fast_min(F32s::splat(1.0 - f32::EPSILON / 2.0))
    }
}

impl<R: Rough<N> + Copy, const N: usize> Lobes<N> for R {
    type Kernel = R::Kernel;

    #[inline(always)]
    fn values(
        &self,
        facing: &Facing,
        given: Vector<F32s>,
        drawn: Vector<F32s>,
        _side: Side,
    ) -> [F32s; N] {
        Rough::values(self, &self.reflect(facing, given, drawn))
    }

    #[inline(always)]
    fn pdf(&self, facing: &Facing, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
        let normal = facing.shading_towards(given);
        Mixture::of(self, given.dot(normal)).pdf(normal, given, drawn)
    }

    #[inline(always)]
    fn draw(&self, facing: &Facing, given: Vector<F32s>, u: [F32s; 3], side: Side) -> Drawn<N> {
        let normal = facing.shading_towards(given);
        let u = [u[0], u[1]];
        let (direction, pdf) = Mixture::of(self, given.dot(normal)).draw(normal, given, u);
        let mut weight = Lobes::values(self, facing, given, direction, side);
        let cos = direction.dot(normal);
        let scale = cos.fast_max(F32s::splat(0.0)) / pdf;
        weight.iter_mut().for_each(|weight| *weight *= scale);
        Drawn { direction, pdf, weight, lost: cos.simd_le(F32s::ZERO) }
    }

    #[inline(always)]
    fn kernels(
        &self,
        facing: &Facing,
        k_in: Vector<F32s>,
        k_out: Vector<F32s>,
    ) -> ([Self::Kernel; N], Vector<F32s>) {
        let reflection = self.reflect(facing, -k_in, k_out);
        let axis = s_axis(reflection.half, k_in);
        let plane = FacetPlane { normal: facing.shading_towards(k_out), axis, k_in, k_out };
        (Rough::kernels(self, &reflection, &plane), axis)
    }
}

/// What is left of light at eight rows, in `WAYS` ways that it goes, if it is not all of it.
#[inline(never)]
pub fn stains<M, const N: usize, const WAYS: usize>(
    models: &ModelLanes<M>,
    of: impl Fn(&M) -> Option<&[[f32; N]; WAYS]>,
) -> Option<[[F32s; N]; WAYS]> {
    let all = models.each();
    if !all.iter().any(|model| of(model).is_some()) {
        return None;
    }
    let left = |way: usize, n: usize| {
        F32s::from(lanes::each(|lane| of(all[lane]).map_or(1.0, |stain| stain[way][n])))
    };
    Some(std::array::from_fn(|way| std::array::from_fn(|n| left(way, n))))
}

/// Mask of the reflections between directions that are both above the surface.
#[inline(always)]
pub fn is_above(reflection: &FacetReflection) -> F32s {
    let [cos_given, cos_drawn] = reflection.cosines;
    cos_given.fast_min(cos_drawn).simd_gt(F32s::splat(0.0))
}

#[cfg(test)]
pub mod tests;
