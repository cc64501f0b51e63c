//! Rough surfaces of small mirrors, the microfacets: how their normals are distributed, which of
//! them are seen, and how they are drawn. Eight vertices at a time.
//!
//! Light of direction i that leaves along o has been reflected by the facets whose normal is the
//! half vector h of the two. Of a surface that reflects all light, that is per steradian (Walter
//! et al. 2007, "Microfacet models for refraction through rough surfaces", equation 20)
//!
//! ```text
//! f = D(h) G2(i, o) / (4 cos i cos o)
//! ```
//!
//! with Smith's masking and shadowing of facets of one height, `G2 = 1 / (1 + L(i) + L(o))`
//! (Heitz 2014, "Understanding the masking-shadowing function", equation 99).
//!
//! Light that goes through leaves below, by facets whose normal is `h = -(i + n o)`, made a unit
//! vector and turned to the side of i, where n is the index of refraction below over that above
//! (equation 21 there, but for the square of the index that radiance grows with):
//!
//! ```text
//! f = |i h| |o h| D(h) G1(i) G1(o) / (|cos i| |cos o| (i h + n o h)^2)
//! ```
//!
//! Masking at the two ends is taken for independent there: facets that are high are hidden more
//! often on one side of the surface, and less often on the other.
//!
//! Half vectors are drawn among the facets that are seen from i: of Trowbridge and Reitz (GGX) by
//! Dupuy and Benyoub 2023 ("Sampling visible GGX normals with spherical caps"), of Beckmann by
//! their slopes, that along i from the inverse of its distribution (Heitz and d'Eon 2014,
//! "Importance sampling microfacet-based BSDFs using the distribution of visible normals"; by
//! Newton's method in the error function, as Jakob 2014, "An improved visible normal sampling
//! routine for the Beckmann distribution").

use std::f32::consts::{FRAC_1_PI, PI};

use crate::math::gaussian::{erf, erf_inverse};
use crate::math::{F32s, Real, Vector, warp};

/// The least roughness that is computed with: facets of less are 0.06 degrees and less from their
/// mean, and directions in `f32` hardly tell them apart.
pub const ALPHA_MIN: f32 = 1e-3;

/// How the normals of facets are distributed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Distribution {
    /// Trowbridge and Reitz 1975; Walter et al. 2007, equation 33: as ground glass, with a long
    /// tail.
    #[default]
    Ggx,
    /// Beckmann and Spizzichino 1963; Walter et al. 2007, equation 25: slopes as those of noise.
    Beckmann,
}

impl Distribution {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Ggx, Self::Beckmann];

    /// The one of a name in files.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|distribution| distribution.name() == name)
    }

    /// What it is called in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ggx => "ggx",
            Self::Beckmann => "beckmann",
        }
    }
}

/// The facets about eight vertices.
#[derive(Clone, Copy, Debug)]
pub struct Facets {
    /// The root mean square of Beckmann's slopes; of the others, the slope that a half of all
    /// facets exceeds. From [`ALPHA_MIN`] to 1.
    alpha: F32s,
    /// Mask of those with Beckmann's distribution.
    beckmann: F32s,
}

/// A reflection by facets.
#[derive(Clone, Copy, Debug)]
pub struct FacetReflection {
    /// Their normal.
    pub half: Vector<F32s>,
    /// The cosine of incidence on them, 0 to 1.
    pub cos_half: F32s,
    /// What they reflect of a lossless surface, per steradian; zero where the directions are not
    /// both above it.
    pub value: F32s,
    /// The cosines of the two directions to the normal of the surface, where there is a value.
    pub cosines: [F32s; 2],
}

/// A refraction by facets.
#[derive(Clone, Copy, Debug)]
pub struct FacetRefraction {
    /// Their normal, on the side of the given direction.
    pub half: Vector<F32s>,
    /// The cosine of incidence on them, 0 to 1.
    pub cos_half: F32s,
    /// What they let through of a surface that reflects nothing, per steradian, for radiance that
    /// arrives along the drawn direction; zero where the two are not on two sides of the surface,
    /// or facets do not refract one to the other.
    pub value: F32s,
    /// The density of drawing the direction where all light goes through.
    pub pdf: F32s,
}

const ROOT_OF_PI_INVERSE: f32 = 0.564_189_6;
/// No slopes of Beckmann's of a roughness of one are steeper.
const MOST_SLOPE: f32 = 9.0;

/// Keeps denominators off zero that only directions within the surface would make so.
const TINY: f32 = 1e-12;

impl Facets {
    /// Those of roughness `alpha`, of Beckmann's distribution where the mask holds.
    #[inline(always)]
    pub fn new(alpha: F32s, beckmann: F32s) -> Self {
        let least = F32s::splat(ALPHA_MIN);
        Self { alpha: alpha.fast_max(least).fast_min(F32s::splat(1.0)), beckmann }
    }

    /// Their roughness, from [`ALPHA_MIN`] to 1.
    #[inline(always)]
    pub fn alpha(&self) -> F32s {
        self.alpha
    }

    /// Light between the directions `given` and `drawn`, both away from the surface of the unit
    /// `normal`; the same for both orders of the two.
    #[inline(always)]
    pub fn reflect(
        &self,
        normal: Vector<F32s>,
        given: Vector<F32s>,
        drawn: Vector<F32s>,
    ) -> FacetReflection {
        let zero = F32s::splat(0.0);
        let half = half_vector(given, drawn);
        let cosines = [given.dot(normal), drawn.dot(normal)];
        let above = cosines[0].simd_gt(zero) & cosines[1].simd_gt(zero);
        let [cos_given, cos_drawn] = cosines;
        let (cos, sin2) = cos_and_sin2(normal, half);
        let mut value = self.ggx(cos, sin2) * self.seen_by_both(cos_given, cos_drawn);
        if self.beckmann.any() {
            let shadowed = F32s::splat(1.0)
                + beckmann_lambda(self.alpha, cos_given)
                + beckmann_lambda(self.alpha, cos_drawn);
            let seen = F32s::splat(1.0)
                / (F32s::splat(4.0) * cos_given * cos_drawn * shadowed).fast_max(F32s::splat(TINY));
            let beckmann = self.beckmann(cos, sin2) * seen;
            value = Real::select(self.beckmann, beckmann, value);
        }
        let cos_half = given.dot(half).fast_max(zero).fast_min(F32s::splat(1.0));
        FacetReflection { half, cos_half, value: above & value, cosines }
    }

    /// Density per steradian of [`Facets::draw`] for `drawn`; zero where the directions are not
    /// both above the surface. Over the density of facets that are seen from `given`, it is a
    /// fourth of the reciprocal of the cosine of incidence on them, which cancels.
    #[inline(always)]
    pub fn pdf(&self, normal: Vector<F32s>, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
        let zero = F32s::splat(0.0);
        let (cos_given, cos_drawn) = (given.dot(normal), drawn.dot(normal));
        let (cos, sin2) = cos_and_sin2(normal, half_vector(given, drawn));
        let above = cos_given.simd_gt(zero) & cos_drawn.simd_gt(zero);
        let seen = F32s::splat(2.0) * (cos_given + self.slope_length(cos_given));
        let mut pdf = self.ggx(cos, sin2) / seen;
        if self.beckmann.any() {
            let beckmann = self.beckmann_per_cosine(cos_given, (cos, sin2));
            pdf = Real::select(self.beckmann, F32s::splat(0.25) * beckmann, pdf);
        }
        above & pdf
    }

    /// Draws a direction for a path that comes from `given`, by two numbers in [0, 1). It may lie
    /// below the surface, where nothing is reflected.
    #[inline(always)]
    pub fn draw(&self, normal: Vector<F32s>, given: Vector<F32s>, u: [F32s; 2]) -> Vector<F32s> {
        let half = self.draw_half(normal, given, u);
        let twice = F32s::splat(2.0) * given.dot(half);
        half.mul_add(twice, -given).normalize()
    }

    /// Light between the direction `given` above the surface of the unit `normal` and `drawn` below
    /// it, with the index of refraction `eta` below over that above.
    #[inline(always)]
    pub fn refract(
        &self,
        normal: Vector<F32s>,
        given: Vector<F32s>,
        drawn: Vector<F32s>,
        eta: F32s,
    ) -> FacetRefraction {
        let zero = F32s::splat(0.0);
        let sum = drawn * eta + given;
        let length2 = sum.length_squared().fast_max(F32s::splat(TINY * TINY));
        let half = sum * (F32s::splat(1.0) / length2.sqrt());
        let half = Vector::select(half.dot(normal).simd_lt(zero), -half, half);
        let (cos_given, below) = (given.dot(normal), -drawn.dot(normal));
        let [given_half, drawn_half] = [given, drawn].map(|v| v.dot(half));
        let passes = cos_given.simd_gt(zero)
            & below.simd_gt(zero)
            & given_half.simd_gt(zero)
            & drawn_half.simd_lt(zero);
        let (cos, sin2) = cos_and_sin2(normal, half);
        let ggx = self.ggx(cos, sin2);
        // G1 of GGX.
        let seen =
            |cos: F32s| (cos + cos) / (cos + self.slope_length(cos)).fast_max(F32s::splat(TINY));
        let of_given = seen(cos_given);
        let mut spread = ggx * of_given * seen(below);
        if self.beckmann.any() {
            let one = F32s::splat(1.0);
            let seen = |cos: F32s| one / (one + beckmann_lambda(self.alpha, cos));
            let beckmann = self.beckmann(cos, sin2) * seen(cos_given) * seen(below);
            spread = Real::select(self.beckmann, beckmann, spread);
        }
        // The sum's length is that of its part along the normal of the facets.
        let turned = given_half * -drawn_half / length2;
        let value = turned * spread / (cos_given * below).fast_max(F32s::splat(TINY));
        // Facets that are seen have the density D G1(i) (i h) / cos i, and o the n^2 |o h| / (..)^2
        // of theirs.
        let mut pdf = turned * (eta * eta) * ggx * of_given / cos_given.fast_max(F32s::splat(TINY));
        if self.beckmann.any() {
            let seen = self.beckmann_per_cosine(cos_given, (cos, sin2));
            pdf = Real::select(self.beckmann, turned * (eta * eta) * seen, pdf);
        }
        FacetRefraction {
            half,
            cos_half: given_half.fast_max(zero).fast_min(F32s::splat(1.0)),
            value: passes & value,
            pdf: passes & pdf,
        }
    }

    /// Draws the normal of a facet that is seen from `given`: facets of a surface that is stretched
    /// by the reciprocal of the roughness are those of a hemisphere.
    #[inline(always)]
    pub fn draw_half(
        &self,
        normal: Vector<F32s>,
        given: Vector<F32s>,
        u: [F32s; 2],
    ) -> Vector<F32s> {
        let stretch = |v: Vector<F32s>| {
            let along = normal * v.dot(normal);
            ((v - along) * self.alpha + along).normalize()
        };
        let seen = stretch(given);
        if self.beckmann.all() {
            return stretch(beckmann_half(normal, seen, u));
        }
        let half = stretch(ggx_half(normal, seen, u));
        if self.beckmann.none() {
            return half;
        }
        Vector::select(self.beckmann, stretch(beckmann_half(normal, seen, u)), half)
    }

    /// `sqrt(cos^2 + alpha^2 sin^2)`: twice it over the cosine is `1 + 2 L` with `L` of GGX.
    #[inline(always)]
    fn slope_length(&self, cos: F32s) -> F32s {
        let one = F32s::splat(1.0);
        let alpha2 = self.alpha * self.alpha;
        ((one - alpha2) * cos).mul_add(cos, alpha2).fast_max(F32s::splat(0.0)).sqrt()
    }

    /// `G2 / (4 cos i cos o)` of GGX.
    #[inline(always)]
    fn seen_by_both(&self, cos_given: F32s, cos_drawn: F32s) -> F32s {
        let sum = cos_given
            .mul_add(self.slope_length(cos_drawn), cos_drawn * self.slope_length(cos_given));
        F32s::splat(0.5) / sum.fast_max(F32s::splat(TINY))
    }

    /// `D G1(i) / cos i` of Beckmann: the density of facets that are seen from i over the cosine of
    /// incidence on them, which are given by the cosine to the surface's normal and the squared
    /// sine.
    #[inline(never)]
    fn beckmann_per_cosine(&self, cos_given: F32s, (cos, sin2): (F32s, F32s)) -> F32s {
        let area = beckmann_area(self.alpha, cos_given).fast_max(F32s::splat(TINY));
        F32s::splat(2.0) * self.beckmann(cos, sin2) / area
    }

    /// D of GGX.
    #[inline(always)]
    fn ggx(&self, cos: F32s, sin2: F32s) -> F32s {
        let alpha2 = self.alpha * self.alpha;
        let spread = (cos * cos).mul_add(alpha2, sin2);
        alpha2 * F32s::splat(FRAC_1_PI) / (spread * spread).fast_max(F32s::splat(TINY * TINY))
    }

    /// D of Beckmann.
    #[inline(always)]
    fn beckmann(&self, cos: F32s, sin2: F32s) -> F32s {
        let cos2 = (cos * cos).fast_max(F32s::splat(TINY));
        let alpha2 = self.alpha * self.alpha;
        let exponent = (sin2 / (cos2 * alpha2)).fast_min(F32s::splat(80.0));
        (-exponent).exp() / (F32s::splat(PI) * alpha2 * cos2 * cos2)
    }
}

/// A facet of GGX' hemisphere that is seen from `seen`.
#[inline(always)]
fn ggx_half(normal: Vector<F32s>, seen: Vector<F32s>, u: [F32s; 2]) -> Vector<F32s> {
    let one = F32s::splat(1.0);
    let up = seen.dot(normal);
    // A cap of directions z from the normal that are reflected towards `seen`.
    let z = (one - u[1]).mul_add(one + up, -up);
    let radius = (one - z * z).fast_max(F32s::splat(0.0)).sqrt();
    let (sine, cosine) = warp::sin_cos_turns(u[0]);
    let tangent = normal.any_perpendicular();
    let bitangent = normal.cross(tangent);
    tangent.mul_add(radius * cosine, bitangent.mul_add(radius * sine, normal.mul_add(z, seen)))
}

/// A facet of Beckmann's of a roughness of one that is seen from `seen`, of any length.
///
/// Those of the slope s along it are seen as `(cos - s sin) exp(-s^2)`, up to where that is zero.
/// All up to s are `(cos (1 + b) + sin exp(-s^2) / sqrt(pi)) / 2` where b is the error function of
/// s, and the slope of that in b is their cosine. It bends one way, so that Newton's method
/// converges. It starts between the solutions of light from straight above and, about, from aside.
// Rare, and long.
#[inline(never)]
fn beckmann_half(normal: Vector<F32s>, seen: Vector<F32s>, u: [F32s; 2]) -> Vector<F32s> {
    /// Off by 3e-7 of all facets then.
    const STEPS: usize = 3;
    let [zero, one, tiny] = [0.0, 1.0, TINY].map(F32s::splat);
    let cos = seen.dot(normal).fast_max(zero);
    let across = seen - normal * seen.dot(normal);
    let sin = across.length_squared().sqrt();
    let most = erf((cos / sin.fast_max(tiny)).fast_min(F32s::splat(MOST_SLOPE)));
    let target = u[1] * beckmann_area(one, cos);
    let above = u[1].mul_add(one + most, -one);
    let aside = (one + most) * (one - (one - u[1]).fast_max(zero).sqrt()) - one;
    let mut value = (sin * sin).mul_add(aside - above, above);
    let edge = F32s::splat(1.0 - f32::EPSILON);
    let mut slope = erf_inverse(value.fast_max(-edge).fast_min(edge));
    for _ in 0..STEPS {
        let beyond = (-(slope * slope)).exp() * sin * F32s::splat(ROOT_OF_PI_INVERSE);
        let excess = cos.mul_add(one + value, beyond) - target;
        let per_value = (cos - slope * sin).fast_max(F32s::splat(1e-6));
        value = (value - excess / per_value).fast_max(-edge).fast_min(most.fast_min(edge));
        slope = erf_inverse(value);
    }
    let sideways = u[0].mul_add(F32s::splat(2.0), -one).fast_max(-edge).fast_min(edge);
    let is_aside = sin.simd_gt(F32s::splat(1e-6));
    let along = Vector::select(is_aside, across * (one / sin), normal.any_perpendicular());
    let beside = normal.cross(along);
    along.mul_add(-slope, beside.mul_add(-erf_inverse(sideways), normal))
}

/// Twice the area of Beckmann's facets that is seen from a cosine, over that of the surface:
/// `2 cos (1 + L)`.
#[inline(always)]
fn beckmann_area(alpha: F32s, cos: F32s) -> F32s {
    let one = F32s::splat(1.0);
    let sin = (one - cos * cos).fast_max(F32s::splat(TINY)).sqrt();
    let spread = alpha * sin;
    let slope = (cos / spread).fast_min(F32s::splat(MOST_SLOPE));
    let beyond = (-(slope * slope)).exp() * spread * F32s::splat(ROOT_OF_PI_INVERSE);
    cos.mul_add(one + erf(slope), beyond)
}

/// L of Beckmann's distribution, in the rational form of Walter et al. 2007 (equation 27), which
/// is off by 0.35 % at most.
#[inline(always)]
fn beckmann_lambda(alpha: F32s, cos: F32s) -> F32s {
    let one = F32s::splat(1.0);
    let sin = (one - cos * cos).fast_max(F32s::splat(TINY)).sqrt();
    let a = cos.fast_max(F32s::splat(0.0)) / (alpha * sin);
    let above = F32s::splat(0.396).mul_add(a, F32s::splat(-1.259)).mul_add(a, one);
    let below = F32s::splat(2.181).mul_add(a, F32s::splat(3.535)) * a;
    let shadowed = above / below.fast_max(F32s::splat(TINY));
    a.simd_lt(F32s::splat(1.6)) & shadowed
}

/// The unit vector between two.
#[inline(always)]
fn half_vector(given: Vector<F32s>, drawn: Vector<F32s>) -> Vector<F32s> {
    let sum = given + drawn;
    sum * (F32s::splat(1.0) / sum.length_squared().fast_max(F32s::splat(TINY)).sqrt())
}

/// The cosine between two unit vectors, and the squared sine from their cross product: nothing is
/// lost where it is small.
#[inline(always)]
fn cos_and_sin2(normal: Vector<F32s>, half: Vector<F32s>) -> (F32s, F32s) {
    (normal.dot(half), normal.cross(half).length_squared())
}
