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
use super::model::Drawn;
use crate::math::{F32s, Real, Vector, warp};
use crate::polarization::albedo::{TERMS, mean_over_cosines};
use crate::polarization::{
    ALPHA_MIN, Albedo, Block, FacetReflection, Facets, SpheroidBlock, fresnel, s_axis,
};
use crate::scattering::event::Elements;
use crate::scattering::side::Side;

/// Least share of what is missing, on the average, for which there is a lobe.
pub const MISSING_MIN: f32 = 1e-4;
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
    /// The facets.
    fn facets(&self) -> &Facets;

    /// The probability of drawing by facets for a path that comes from a direction of the cosine
    /// `cos`.
    fn chance_of_facets(&self, cos: F32s) -> F32s;

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
        let chance = self.chance_of_facets(given.dot(normal));
        let of_facets = self.facets().pdf(normal, given, drawn);
        let of_cosine = warp::cosine_pdf(drawn.dot(normal).fast_max(F32s::splat(0.0)));
        chance.mul_add(of_facets - of_cosine, of_cosine)
    }

    /// The first number chooses between facets and the cosine, too.
    #[inline(always)]
    fn draw(&self, facing: &Facing, given: Vector<F32s>, u: [F32s; 3], side: Side) -> Drawn<N> {
        let one = F32s::splat(1.0);
        let normal = facing.shading_towards(given);
        let chance = self.chance_of_facets(given.dot(normal));
        let by_facets = u[0].simd_lt(chance);
        let less = u[0] / chance.fast_max(F32s::splat(TINY));
        let more = (u[0] - chance) / (one - chance).fast_max(F32s::splat(TINY));
        let below_one = F32s::splat(1.0 - f32::EPSILON / 2.0);
        let again = [Real::select(by_facets, less, more).fast_min(below_one), u[1]];
        let (of_cosine, _) = warp::cosine_hemisphere(normal, again);
        let of_facets = self.facets().draw(normal, given, again);
        let direction = Vector::select(by_facets, of_facets, of_cosine);
        let pdf = self.pdf(facing, given, direction).fast_max(F32s::splat(PDF_MIN));
        let mut weight = Lobes::values(self, facing, given, direction, side);
        let scale = direction.dot(normal).fast_max(F32s::splat(0.0)) / pdf;
        weight.iter_mut().for_each(|weight| *weight *= scale);
        Drawn { direction, pdf, weight }
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

/// Mask of the reflections between directions that are both above the surface.
#[inline(always)]
pub fn is_above(reflection: &FacetReflection) -> F32s {
    let [cos_given, cos_drawn] = reflection.cosines;
    cos_given.fast_min(cos_drawn).simd_gt(F32s::splat(0.0))
}

/// What facets of the albedo with these terms leave out of light of the cosine `cos`.
#[inline(always)]
pub fn missing(terms: &[F32s; TERMS], cos: F32s) -> F32s {
    F32s::splat(1.0) - Albedo::at(terms, cos)
}

#[cfg(test)]
pub mod tests;
