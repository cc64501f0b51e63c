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

/// How rough facets are along directions of the surface: what the distributions are stretched by.
///
/// Heitz 2014, section 5: all of them are those of an even surface whose slopes are stretched.
pub trait Slopes: Copy {
    /// The roughness; of what differs by direction, the root of the product of both.
    fn alpha(&self) -> F32s;

    /// The root of `alpha^2 / (pi D)` of GGX, for a half vector of this cosine and squared sine to
    /// the normal.
    fn spread(&self, normal: Vector<F32s>, half: Vector<F32s>, of: [F32s; 2]) -> F32s;

    /// The squared slope of a half vector, over the squared roughness along it, with the squares
    /// of its cosine and sine.
    fn steepness(&self, normal: Vector<F32s>, half: Vector<F32s>, of: [F32s; 2]) -> F32s;

    /// `sqrt(cos^2 + alpha^2 sin^2)` of a direction: twice it over the cosine is `1 + 2 L` with `L`
    /// of GGX.
    fn slope_length(&self, normal: Vector<F32s>, v: Vector<F32s>, cos: F32s) -> F32s;

    /// `alpha sin` of a direction.
    fn width(&self, normal: Vector<F32s>, v: Vector<F32s>, cos: F32s) -> F32s;

    /// The cosine at which even facets, of the root mean square of the roughness, hide each other
    /// as much as these do from a direction of the cosine: what several of them scatter goes by it.
    fn even(&self, normal: Vector<F32s>, v: Vector<F32s>, cos: F32s) -> F32s;

    /// A direction in a space in which the facets are those of a hemisphere.
    fn stretch(&self, normal: Vector<F32s>, v: Vector<F32s>) -> Vector<F32s>;
}

/// The same in all directions.
#[derive(Clone, Copy, Debug)]
pub struct Even {
    /// The root mean square of Beckmann's slopes; of the others, the slope that a half of all
    /// facets exceeds. From [`ALPHA_MIN`] to 1.
    alpha: F32s,
}

impl Slopes for Even {
    #[inline(always)]
    fn alpha(&self) -> F32s {
        self.alpha
    }

    #[inline(always)]
    fn spread(&self, _: Vector<F32s>, _: Vector<F32s>, [cos, sin2]: [F32s; 2]) -> F32s {
        (cos * cos).mul_add(self.alpha * self.alpha, sin2)
    }

    #[inline(always)]
    fn steepness(&self, _: Vector<F32s>, _: Vector<F32s>, [cos2, sin2]: [F32s; 2]) -> F32s {
        sin2 / (cos2 * (self.alpha * self.alpha))
    }

    #[inline(always)]
    fn slope_length(&self, _: Vector<F32s>, _: Vector<F32s>, cos: F32s) -> F32s {
        let one = F32s::splat(1.0);
        let alpha2 = self.alpha * self.alpha;
        ((one - alpha2) * cos).mul_add(cos, alpha2).fast_max(F32s::splat(0.0)).sqrt()
    }

    #[inline(always)]
    fn width(&self, _: Vector<F32s>, _: Vector<F32s>, cos: F32s) -> F32s {
        let one = F32s::splat(1.0);
        let sin = (one - cos * cos).fast_max(F32s::splat(TINY)).sqrt();
        self.alpha * sin
    }

    #[inline(always)]
    fn even(&self, _: Vector<F32s>, _: Vector<F32s>, cos: F32s) -> F32s {
        cos
    }

    #[inline(always)]
    fn stretch(&self, normal: Vector<F32s>, v: Vector<F32s>) -> Vector<F32s> {
        let along = normal * v.dot(normal);
        ((v - along) * self.alpha + along).normalize()
    }
}

/// Along a direction of the surface, and across it: as brushed metal.
#[derive(Clone, Copy, Debug)]
pub struct Stretched {
    /// A unit vector along the surface.
    along: Vector<F32s>,
    /// As [`Even`]'s, along it and across.
    alpha: [F32s; 2],
}

impl Stretched {
    /// The parts of a vector along the direction, and across, times the roughness there.
    #[inline(always)]
    fn parts(&self, normal: Vector<F32s>, v: Vector<F32s>) -> [F32s; 2] {
        let [along, across] = self.plain(normal, v);
        [along * self.alpha[0], across * self.alpha[1]]
    }

    #[inline(always)]
    fn plain(&self, normal: Vector<F32s>, v: Vector<F32s>) -> [F32s; 2] {
        [v.dot(self.along), v.dot(normal.cross(self.along))]
    }
}

impl Slopes for Stretched {
    #[inline(always)]
    fn alpha(&self) -> F32s {
        (self.alpha[0] * self.alpha[1]).sqrt()
    }

    #[inline(always)]
    fn spread(&self, normal: Vector<F32s>, half: Vector<F32s>, [cos, _]: [F32s; 2]) -> F32s {
        let [along, across] = self.plain(normal, half);
        let ratio = self.alpha[1] / self.alpha[0];
        let sides = (along * along).mul_add(ratio, across * across / ratio);
        (cos * cos).mul_add(self.alpha[0] * self.alpha[1], sides)
    }

    #[inline(always)]
    fn steepness(&self, normal: Vector<F32s>, half: Vector<F32s>, [cos2, _]: [F32s; 2]) -> F32s {
        let [along, across] = self.plain(normal, half);
        let [along, across] = [along / self.alpha[0], across / self.alpha[1]];
        along.mul_add(along, across * across) / cos2
    }

    #[inline(always)]
    fn slope_length(&self, normal: Vector<F32s>, v: Vector<F32s>, cos: F32s) -> F32s {
        let [along, across] = self.parts(normal, v);
        cos.mul_add(cos, along.mul_add(along, across * across)).sqrt()
    }

    #[inline(always)]
    fn width(&self, normal: Vector<F32s>, v: Vector<F32s>, _: F32s) -> F32s {
        let [along, across] = self.parts(normal, v);
        along.mul_add(along, across * across).fast_max(F32s::splat(TINY * TINY)).sqrt()
    }

    #[inline(always)]
    fn even(&self, normal: Vector<F32s>, v: Vector<F32s>, cos: F32s) -> F32s {
        let [along, across] = self.alpha;
        let mean2 = along.mul_add(along, across * across) * F32s::splat(0.5);
        let slope = self.width(normal, v, cos) / mean2.sqrt();
        cos / slope.mul_add(slope, cos * cos).fast_max(F32s::splat(TINY)).sqrt()
    }

    #[inline(always)]
    fn stretch(&self, normal: Vector<F32s>, v: Vector<F32s>) -> Vector<F32s> {
        let [along, across] = self.parts(normal, v);
        let side = normal.cross(self.along);
        (normal * v.dot(normal) + self.along * along + side * across).normalize()
    }
}

/// The facets about eight vertices.
#[derive(Clone, Copy, Debug)]
pub struct Facets<S = Even> {
    slopes: S,
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
    /// What these are to even facets: [`Slopes::even`].
    pub even: [F32s; 2],
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

impl Facets<Even> {
    /// Those of roughness `alpha`, of Beckmann's distribution where the mask holds.
    #[inline(always)]
    pub fn new(alpha: F32s, beckmann: F32s) -> Self {
        Self { slopes: Even { alpha: within(alpha) }, beckmann }
    }
}

/// A roughness that is computed with.
#[inline(always)]
fn within(alpha: F32s) -> F32s {
    alpha.fast_max(F32s::splat(ALPHA_MIN)).fast_min(F32s::splat(1.0))
}

impl Facets<Stretched> {
    /// Those of these roughnesses along a unit vector of the surface, and across it, of Beckmann's
    /// distribution where the mask holds.
    #[inline(always)]
    pub fn stretched(along: Vector<F32s>, alpha: [F32s; 2], beckmann: F32s) -> Self {
        Self { slopes: Stretched { along, alpha: alpha.map(within) }, beckmann }
    }
}

impl<S: Slopes> Facets<S> {
    /// Their roughness, from [`ALPHA_MIN`] to 1.
    #[inline(always)]
    pub fn alpha(&self) -> F32s {
        self.slopes.alpha()
    }

    /// See [`Slopes::even`].
    #[inline(always)]
    pub fn even(&self, normal: Vector<F32s>, v: Vector<F32s>, cos: F32s) -> F32s {
        self.slopes.even(normal, v, cos)
    }

    /// Light between the directions `given` and `drawn`, both away from the surface of the unit
    /// `normal`; the same for both orders of the two.
    #[inline(never)]
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
        let [length_given, length_drawn] = [(given, cos_given), (drawn, cos_drawn)]
            .map(|(v, cos)| self.slopes.slope_length(normal, v, cos));
        let sum = cos_given.mul_add(length_drawn, cos_drawn * length_given);
        // G2 / (4 cos i cos o) of GGX.
        let seen = F32s::splat(0.5) / sum.fast_max(F32s::splat(TINY));
        let mut value = self.ggx(normal, half, [cos, sin2]) * seen;
        if self.beckmann.any() {
            let shadowed = F32s::splat(1.0)
                + self.beckmann_lambda(normal, given, cos_given)
                + self.beckmann_lambda(normal, drawn, cos_drawn);
            let seen = F32s::splat(1.0)
                / (F32s::splat(4.0) * cos_given * cos_drawn * shadowed).fast_max(F32s::splat(TINY));
            let beckmann = self.beckmann(normal, half, [cos, sin2]) * seen;
            value = Real::select(self.beckmann, beckmann, value);
        }
        let cos_half = given.dot(half).fast_max(zero).fast_min(F32s::splat(1.0));
        let even = [
            self.slopes.even(normal, given, cos_given),
            self.slopes.even(normal, drawn, cos_drawn),
        ];
        FacetReflection { half, cos_half, value: above & value, cosines, even }
    }

    /// Density per steradian of [`Facets::draw`] for `drawn`; zero where the directions are not
    /// both above the surface. Over the density of facets that are seen from `given`, it is a
    /// fourth of the reciprocal of the cosine of incidence on them, which cancels.
    #[inline(never)]
    pub fn pdf(&self, normal: Vector<F32s>, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
        let zero = F32s::splat(0.0);
        let (cos_given, cos_drawn) = (given.dot(normal), drawn.dot(normal));
        let half = half_vector(given, drawn);
        let (cos, sin2) = cos_and_sin2(normal, half);
        let above = cos_given.simd_gt(zero) & cos_drawn.simd_gt(zero);
        let length = self.slopes.slope_length(normal, given, cos_given);
        let seen = F32s::splat(2.0) * (cos_given + length);
        let mut pdf = self.ggx(normal, half, [cos, sin2]) / seen;
        if self.beckmann.any() {
            let beckmann =
                self.beckmann_per_cosine(normal, (given, cos_given), (half, [cos, sin2]));
            pdf = Real::select(self.beckmann, F32s::splat(0.25) * beckmann, pdf);
        }
        above & pdf
    }

    /// Draws a direction for a path that comes from `given`, by two numbers in [0, 1). It may lie
    /// below the surface, where nothing is reflected.
    #[inline(never)]
    pub fn draw(&self, normal: Vector<F32s>, given: Vector<F32s>, u: [F32s; 2]) -> Vector<F32s> {
        let half = self.draw_half(normal, given, u);
        let twice = F32s::splat(2.0) * given.dot(half);
        half.mul_add(twice, -given).normalize()
    }

    /// Light between the direction `given` above the surface of the unit `normal` and `drawn` below
    /// it, with the index of refraction `eta` below over that above.
    #[inline(never)]
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
        let ggx = self.ggx(normal, half, [cos, sin2]);
        // G1 of GGX.
        let seen = |v: Vector<F32s>, cos: F32s| {
            let length = self.slopes.slope_length(normal, v, cos);
            (cos + cos) / (cos + length).fast_max(F32s::splat(TINY))
        };
        let of_given = seen(given, cos_given);
        let mut spread = ggx * of_given * seen(drawn, below);
        if self.beckmann.any() {
            let one = F32s::splat(1.0);
            let seen = |v, cos| one / (one + self.beckmann_lambda(normal, v, cos));
            let of_both = seen(given, cos_given) * seen(drawn, below);
            let beckmann = self.beckmann(normal, half, [cos, sin2]) * of_both;
            spread = Real::select(self.beckmann, beckmann, spread);
        }
        // The sum's length is that of its part along the normal of the facets.
        let turned = given_half * -drawn_half / length2;
        let value = turned * spread / (cos_given * below).fast_max(F32s::splat(TINY));
        // Facets that are seen have the density D G1(i) (i h) / cos i, and o the n^2 |o h| / (..)^2
        // of theirs.
        let mut pdf = turned * (eta * eta) * ggx * of_given / cos_given.fast_max(F32s::splat(TINY));
        if self.beckmann.any() {
            let seen = self.beckmann_per_cosine(normal, (given, cos_given), (half, [cos, sin2]));
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
        let seen = self.slopes.stretch(normal, given);
        let stretched = |half| self.slopes.stretch(normal, half);
        if self.beckmann.all() {
            return stretched(beckmann_half(normal, seen, u));
        }
        let half = stretched(ggx_half(normal, seen, u));
        if self.beckmann.none() {
            return half;
        }
        Vector::select(self.beckmann, stretched(beckmann_half(normal, seen, u)), half)
    }

    /// `D G1(i) / cos i` of Beckmann: the density of facets that are seen from i over the cosine of
    /// incidence on them, which are given by the cosine to the surface's normal and the squared
    /// sine.
    #[inline(never)]
    fn beckmann_per_cosine(
        &self,
        normal: Vector<F32s>,
        (given, cos_given): (Vector<F32s>, F32s),
        (half, of): (Vector<F32s>, [F32s; 2]),
    ) -> F32s {
        let width = self.slopes.width(normal, given, cos_given);
        let area = beckmann_area(width, cos_given).fast_max(F32s::splat(TINY));
        F32s::splat(2.0) * self.beckmann(normal, half, of) / area
    }

    /// D of GGX.
    #[inline(always)]
    fn ggx(&self, normal: Vector<F32s>, half: Vector<F32s>, of: [F32s; 2]) -> F32s {
        let alpha2 = self.alpha() * self.alpha();
        let spread = self.slopes.spread(normal, half, of);
        alpha2 * F32s::splat(FRAC_1_PI) / (spread * spread).fast_max(F32s::splat(TINY * TINY))
    }

    /// D of Beckmann.
    #[inline(always)]
    fn beckmann(&self, normal: Vector<F32s>, half: Vector<F32s>, of: [F32s; 2]) -> F32s {
        let [cos, sin2] = of;
        let cos2 = (cos * cos).fast_max(F32s::splat(TINY));
        let alpha2 = self.alpha() * self.alpha();
        let steepness = self.slopes.steepness(normal, half, [cos2, sin2]);
        let exponent = steepness.fast_min(F32s::splat(80.0));
        (-exponent).exp() / (F32s::splat(PI) * alpha2 * cos2 * cos2)
    }

    /// L of Beckmann's distribution, in the rational form of Walter et al. 2007 (equation 27),
    /// which is off by 0.35 % at most.
    #[inline(always)]
    fn beckmann_lambda(&self, normal: Vector<F32s>, v: Vector<F32s>, cos: F32s) -> F32s {
        let one = F32s::splat(1.0);
        let a = cos.fast_max(F32s::splat(0.0)) / self.slopes.width(normal, v, cos);
        let above = F32s::splat(0.396).mul_add(a, F32s::splat(-1.259)).mul_add(a, one);
        let below = F32s::splat(2.181).mul_add(a, F32s::splat(3.535)) * a;
        let shadowed = above / below.fast_max(F32s::splat(TINY));
        a.simd_lt(F32s::splat(1.6)) & shadowed
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
    let width = (one - cos * cos).fast_max(tiny).sqrt();
    let target = u[1] * beckmann_area(width, cos);
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

/// Twice the area of Beckmann's facets that is seen from a direction of this [`Slopes::width`] and
/// cosine, over that of the surface: `2 cos (1 + L)`.
#[inline(always)]
fn beckmann_area(width: F32s, cos: F32s) -> F32s {
    let one = F32s::splat(1.0);
    let slope = (cos / width).fast_min(F32s::splat(MOST_SLOPE));
    let beyond = (-(slope * slope)).exp() * width * F32s::splat(ROOT_OF_PI_INVERSE);
    cos.mul_add(one + erf(slope), beyond)
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
