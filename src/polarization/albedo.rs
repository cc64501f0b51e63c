//! What surfaces of microfacets reflect in all, by the angle of the light, of what arrives: the
//! rest has met other facets, which the model of single reflections leaves out.
//!
//! It is integrated for a grid of roughnesses, where that is asked for. What is missing of it lies
//! about cosines like the roughness, so it is kept as a polynomial in `x = (1 + s) mu / (mu + s)`
//! where the scale s goes with the roughness. It is off by 0.0025 at most of GGX' mirrors, mostly
//! by 0.0005; by 0.0035 of Beckmann's, whose facets are not hidden at all from some angle on; and
//! by 0.005 of glass from within. Coats reflect what facets leave of a polynomial in the root of
//! the cosine, off by 0.009 at most, within a degree of the surface. What is built on it
//! reflects as much less or more, and is as reciprocal as ever: the mean over the hemisphere is
//! that of the very polynomial.
//!
//! Kulla and Conty 2017 ("Revisiting physically based shading at Imageworks") make of such an
//! albedo E(mu) the lobe `(1 - E(i)) (1 - E(o)) / (pi (1 - E_mean))`, which is reciprocal and
//! reflects just what is missing.

mod angles;

pub use angles::Angles;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock};

use crate::math::elementary::{exp, ln};
use crate::math::{F32s, LANES, Vector, lanes, warp};

use super::cloth::cloth;
use super::fresnel;
use super::microfacet::{ALPHA_MIN, Distribution, Facets};

/// Coefficients of the polynomials.
pub const POWERS: usize = 8;
/// Coefficients of what is missing, and their scale.
pub const TERMS: usize = POWERS + 1;
/// Intervals of the grid of roughnesses: even in the root.
const ALPHAS: usize = 32;
/// Points of the quadrature: turns over a half circle (the other mirrors it), and heights.
const TURNS: usize = 16;
const HEIGHTS: usize = 64;
/// Most tables that are kept of dielectrics.
const TABLES_MAX: usize = 1000;
/// Steps of the logarithm of indices of refraction: those of paths differ from iteration to
/// iteration.
const STEP_OF_IOR: f32 = 1e-3;

/// The albedo of facets of one roughness, by the cosine of the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Albedo {
    /// Coefficients of what is missing, from the lowest power on, and the scale: see
    /// [`Albedo::missing`].
    pub terms: [f32; TERMS],
    /// The mean over the hemisphere, by the cosine.
    pub mean: f32,
}

impl Albedo {
    /// Of facets that reflect all light.
    pub fn of_facets(distribution: Distribution, alpha: f32) -> Self {
        Self::of_terms(facets(distribution).terms(alpha))
    }

    /// Of facets of a dielectric of this index of refraction, relative to what is on the side that
    /// light comes from: what they reflect and let through. The index counts to a thousandth.
    pub fn of_glass(distribution: Distribution, ior: f32, alpha: f32) -> Self {
        Self::of_terms(Table::shared(distribution, Of::Glass { ior: stepped(ior) }).terms(alpha))
    }

    /// The same of glass with this reflectance by the angle on the side of the lower index, and
    /// with total reflection on the other.
    pub fn of_any_glass(
        distribution: Distribution,
        (ior, reflectance): (f32, &Angles),
        alpha: f32,
    ) -> Self {
        let table = Table::shared(distribution, Of::Glass { ior: stepped(ior) });
        Self::of_terms(table.with_scale(table.by_angles(reflectance, alpha), alpha))
    }

    /// What is missing at eight cosines, 0 to 1, by the terms there; within [0, 1].
    #[inline(always)]
    pub fn missing(terms: &[F32s; TERMS], cos: F32s) -> F32s {
        let (one, scale) = (F32s::splat(1.0), terms[POWERS]);
        let cos = cos.fast_max(F32s::splat(0.0));
        polynomial(&terms[..POWERS], cos * (one + scale) / (cos + scale))
    }

    fn of_terms(terms: [f32; TERMS]) -> Self {
        let lanes = terms.map(F32s::splat);
        let missing = mean_in_decades(terms[POWERS], |cos| Self::missing(&lanes, cos));
        Self { terms, mean: 1.0 - missing }
    }
}

/// The albedo of facets of a dielectric of which what is reflected counts, by the cosine of the
/// light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoatAlbedo {
    /// What facets that reflect all light leave out: see [`Albedo::terms`].
    pub facets: [f32; TERMS],
    /// Coefficients of the powers of the root of the cosine of what the others reflect, from the
    /// lowest on.
    pub reflected: [f32; POWERS],
    /// The mean over the hemisphere, by the cosine.
    pub mean: f32,
}

impl CoatAlbedo {
    /// Of this index of refraction, relative to what is outside.
    pub fn of(distribution: Distribution, ior: f32, alpha: f32) -> Self {
        let facets = facets(distribution).terms(alpha);
        Self::of_terms(facets, Table::shared(distribution, Of::Coat { ior }).at(alpha))
    }

    /// Of facets with this reflectance by the angle of the light, as [`Angles::sampled`] has it.
    pub fn of_any(distribution: Distribution, reflectance: &Angles, alpha: f32) -> Self {
        let mirrors = facets(distribution);
        Self::of_terms(mirrors.terms(alpha), mirrors.by_angles(reflectance, alpha))
    }

    fn of_terms(facets: [f32; TERMS], reflected: [f32; POWERS]) -> Self {
        let (terms, powers) = (facets.map(F32s::splat), reflected.map(F32s::splat));
        let at = |cos| Self::at(Albedo::missing(&terms, cos), &powers, cos);
        Self { facets, reflected, mean: mean_in_decades(facets[POWERS], at) }
    }

    /// The same with a share of the reflectance.
    #[must_use]
    pub fn scaled(self, share: f32) -> Self {
        let reflected = self.reflected.map(|term| share * term);
        Self { reflected, mean: share * self.mean, ..self }
    }

    /// At eight cosines, 0 to 1, where so much is missing of what facets that reflect all light
    /// reflect; within [0, 1].
    #[inline(always)]
    pub fn at(missing: F32s, reflected: &[F32s; POWERS], cos: F32s) -> F32s {
        let root = cos.fast_max(F32s::splat(0.0)).sqrt();
        (F32s::splat(1.0) - missing) * polynomial(reflected, root)
    }
}

/// The albedo of cloth of white threads ([`super::cloth`]), by the cosine of the light. It may be
/// more than one towards grazing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClothAlbedo {
    /// Coefficients of the powers of the root of the cosine, from the lowest on.
    pub powers: [f32; POWERS],
    /// The mean over the hemisphere, by the cosine.
    pub mean: f32,
}

impl ClothAlbedo {
    /// Of threads of this roughness.
    pub fn of(alpha: f32) -> Self {
        static OF_CLOTH: Table = Table::new(Distribution::Ggx, Of::Cloth);
        let powers = OF_CLOTH.at(alpha.max(super::cloth::ALPHA_MIN));
        let lanes = powers.map(F32s::splat);
        Self { powers, mean: mean_in_decades(1.0, |cos| Self::at(&lanes, cos)) }
    }

    /// At eight cosines, 0 to 1, by the coefficients there; not less than 0.
    #[inline(always)]
    pub fn at(powers: &[F32s; POWERS], cos: F32s) -> F32s {
        let root = cos.fast_max(F32s::splat(0.0)).sqrt();
        unbounded(powers, root).fast_max(F32s::splat(0.0))
    }
}

/// With these coefficients, from the lowest power on, within [0, 1].
#[inline(always)]
fn polynomial(terms: &[F32s], x: F32s) -> F32s {
    unbounded(terms, x).fast_max(F32s::splat(0.0)).fast_min(F32s::splat(1.0))
}

#[inline(always)]
fn unbounded(terms: &[F32s], x: F32s) -> F32s {
    let mut sum = terms[POWERS - 1];
    for &term in terms[..POWERS - 1].iter().rev() {
        sum = sum.mul_add(x, term);
    }
    sum
}

/// Those that reflect all light.
fn facets(distribution: Distribution) -> &'static Table {
    static OF_GGX: Table = Table::new(Distribution::Ggx, Of::Mirrors);
    static OF_BECKMANN: Table = Table::new(Distribution::Beckmann, Of::Mirrors);
    match distribution {
        Distribution::Ggx => &OF_GGX,
        Distribution::Beckmann => &OF_BECKMANN,
    }
}

/// The mean over the hemisphere, by the cosine, of what changes about cosines of this scale: by
/// midpoints in the logarithm of the cosine.
fn mean_in_decades(scale: f32, of: impl Fn(F32s) -> F32s) -> f32 {
    const PACKETS: usize = 4;
    /// Cosines of less than the scale over this count for nothing.
    const BELOW: f32 = 32.0;
    /// Nor do those whose logarithm is less.
    const LEAST: f32 = -4.0;
    let step = ln(scale / BELOW).min(LEAST) / (PACKETS * LANES) as f32;
    let mut sums = [F32s::splat(0.0); 2];
    for packet in 0..PACKETS {
        let places = lanes::each(|lane| (packet * LANES + lane) as f32 + 0.5);
        let cos = (F32s::from(places) * F32s::splat(step)).exp();
        let weight = cos * cos;
        sums = [weight.mul_add(of(cos), sums[0]), sums[1] + weight];
    }
    let [sum, weights] = sums.map(|sum| sum.reduce_add());
    sum / weights
}

/// The mean over the hemisphere, by the cosine, of a reflectance, which is smooth in the cosine:
/// by midpoints.
pub fn mean_over_cosines(of: impl Fn(F32s) -> F32s) -> f32 {
    const PACKETS: usize = 2;
    const ALL: f32 = (PACKETS * LANES) as f32;
    let sum = (0..PACKETS).map(|packet| {
        let cos = lanes::each(|lane| ((packet * LANES + lane) as f32 + 0.5) / ALL);
        let cos = F32s::from(cos);
        (F32s::splat(2.0 / ALL) * cos * of(cos)).reduce_add()
    });
    sum.sum()
}

/// What facets are of.
#[derive(Clone, Copy, Debug)]
enum Of {
    /// What reflects all light.
    Mirrors,
    /// A dielectric of this index of refraction, of which what is reflected counts.
    Coat { ior: f32 },
    /// A dielectric of this index of refraction, of which what is let through counts, too.
    Glass { ior: f32 },
    /// Cloth of white threads, of any distribution.
    Cloth,
}

/// An index of refraction in steps, and never 1: facets between equal indices are not to be seen.
fn stepped(ior: f32) -> f32 {
    let steps = (ln(ior) / STEP_OF_IOR).round();
    exp(if steps == 0.0 { 1.0 } else { steps } * STEP_OF_IOR)
}

/// Tells tables apart.
type Key = (bool, bool, u32);

/// The albedo of facets of any roughness, integrated where it is asked for.
struct Table {
    distribution: Distribution,
    of: Of,
    /// Coefficients at the roughnesses of the grid.
    rows: [OnceLock<[f32; POWERS]>; ALPHAS + 1],
    /// The same of any reflectance.
    by_angles: [OnceLock<Box<angles::Matrix>>; ALPHAS + 1],
}

impl Table {
    const fn new(distribution: Distribution, of: Of) -> Self {
        Self {
            distribution,
            of,
            rows: [const { OnceLock::new() }; ALPHAS + 1],
            by_angles: [const { OnceLock::new() }; ALPHAS + 1],
        }
    }

    /// The one that all ask.
    fn shared(distribution: Distribution, of: Of) -> Arc<Self> {
        static TABLES: Mutex<BTreeMap<Key, Arc<Table>>> = Mutex::new(BTreeMap::new());
        thread_local! {
            /// What this thread has asked for last: it asks again at every hit of a picture.
            static LAST: RefCell<Option<(Key, Arc<Table>)>> = const { RefCell::new(None) };
        }
        let (passes, ior) = match of {
            Of::Mirrors => (false, 0.0),
            // Of no index of refraction.
            Of::Cloth => (false, -1.0),
            Of::Coat { ior } => (false, ior),
            Of::Glass { ior } => (true, ior),
        };
        let key = (distribution == Distribution::Beckmann, passes, ior.to_bits());
        let last = LAST.with_borrow(|last| last.clone().filter(|(of, _)| *of == key));
        let found = || {
            let mut tables = TABLES.lock().expect("no thread panics while it holds the lock");
            if tables.len() >= TABLES_MAX {
                tables.clear();
            }
            Arc::clone(tables.entry(key).or_insert_with(|| Arc::new(Self::new(distribution, of))))
        };
        let table = last.map_or_else(found, |(_, table)| table);
        LAST.set(Some((key, Arc::clone(&table))));
        // No lock is held while it is computed.
        table
    }

    fn row(&self, row: usize) -> &[f32; POWERS] {
        self.rows[row].get_or_init(|| {
            let root = row as f32 / ALPHAS as f32;
            let values = nodes().map(|node| self.value(root * root, node));
            let term = |row: [f64; POWERS]| row.iter().zip(&values).map(|(a, b)| a * b).sum();
            vandermonde_inverse().map(|row| {
                let term: f64 = term(row);
                term as f32
            })
        })
    }

    /// What the polynomial of a roughness is of, from 0 to 1.
    fn value(&self, alpha: f32, x: f64) -> f64 {
        match self.of {
            Of::Mirrors | Of::Glass { .. } => {
                1.0 - integrate(self.distribution, self.of, alpha, self.cosine(alpha, x))
            }
            Of::Cloth => integrate(self.distribution, self.of, alpha, x * x),
            Of::Coat { .. } => {
                let of = |of: Of| integrate(self.distribution, of, alpha, x * x);
                of(self.of) / of(Of::Mirrors)
            }
        }
    }

    /// The cosine of a node of what is missing.
    fn cosine(&self, alpha: f32, x: f64) -> f64 {
        let scale = f64::from(self.scale(alpha));
        scale * x / (1.0 + scale - x)
    }

    /// Of the cosines about which light goes missing.
    fn scale(&self, alpha: f32) -> f32 {
        let alpha = alpha.max(ALPHA_MIN);
        match (self.of, self.distribution) {
            // By trial: their edge is sharper than the roughness says where that is large.
            (Of::Mirrors | Of::Coat { .. } | Of::Cloth, Distribution::Ggx) => {
                let smooth = 1.0 - alpha;
                alpha * (2.0 * smooth * smooth + 0.1)
            }
            (Of::Mirrors | Of::Coat { .. } | Of::Cloth, Distribution::Beckmann)
            | (Of::Glass { .. }, _) => 2.5 * alpha,
        }
    }

    /// The coefficients: linear in the root of the roughness.
    fn at(&self, alpha: f32) -> [f32; POWERS] {
        between_rows(alpha, |row| *self.row(row))
    }

    /// The coefficients, and their scale.
    fn terms(&self, alpha: f32) -> [f32; TERMS] {
        self.with_scale(self.at(alpha), alpha)
    }

    fn with_scale(&self, powers: [f32; POWERS], alpha: f32) -> [f32; TERMS] {
        let scale = self.scale(alpha.min(1.0));
        std::array::from_fn(|term| powers.get(term).copied().unwrap_or(scale))
    }
}

/// Coefficients at a roughness, of those at the roughnesses of the grid.
fn between_rows(alpha: f32, of: impl Fn(usize) -> [f32; POWERS]) -> [f32; POWERS] {
    let place = alpha.clamp(0.0, 1.0).sqrt() * ALPHAS as f32;
    let row = (place as usize).min(ALPHAS - 1);
    let part = place - row as f32;
    let [less, more] = [row, row + 1].map(of);
    std::array::from_fn(|term| less[term] + part * (more[term] - less[term]))
}

/// Where polynomials are computed: at the nodes of Chebyshev.
fn nodes() -> [f64; POWERS] {
    std::array::from_fn(|node| {
        let turn = std::f64::consts::PI * (node as f64 + 0.5) / POWERS as f64;
        0.5 - 0.5 * crate::math::elementary::cos(turn)
    })
}

/// The matrix that makes coefficients of the values at [`nodes`]: row k holds those of the power k
/// in Lagrange's polynomials.
fn vandermonde_inverse() -> [[f64; POWERS]; POWERS] {
    let nodes = nodes();
    let mut inverse = [[0.0; POWERS]; POWERS];
    for (node, &root) in nodes.iter().enumerate() {
        let mut coefficients = [0.0; POWERS];
        coefficients[0] = 1.0;
        for &other in nodes.iter().filter(|&&other| other != root) {
            for power in (0..POWERS).rev() {
                let lower = if power > 0 { coefficients[power - 1] } else { 0.0 };
                coefficients[power] = (lower - other * coefficients[power]) / (root - other);
            }
        }
        for (row, coefficient) in inverse.iter_mut().zip(coefficients) {
            row[node] = coefficient;
        }
    }
    inverse
}

/// The share of light of the cosine `cos` that facets reflect, or let through: its mean over the
/// directions that are drawn.
fn integrate(distribution: Distribution, of: Of, alpha: f32, cos: f64) -> f64 {
    if let Of::Cloth = of {
        return of_cloth(alpha, cos);
    }
    let mut sum = 0.0;
    for_each_drawn(distribution, alpha, cos, |Draw { facets, normal, given, u, weight }| {
        let drawn = facets.draw(normal, given, u);
        let pdf = facets.pdf(normal, given, drawn);
        let reflection = facets.reflect(normal, given, drawn);
        let reflectance = match of {
            Of::Mirrors | Of::Cloth => F32s::splat(1.0),
            Of::Coat { ior } | Of::Glass { ior } => {
                fresnel::dielectric_reflectance(reflection.cos_half, F32s::splat(ior)).0
            }
        };
        let share = reflection.value * drawn.dot(normal) / pdf * reflectance;
        sum += f64::from((pdf.simd_gt(F32s::ZERO) & (weight * share)).reduce_add());
        if let Of::Glass { ior } = of {
            let (share, cos_half) = passed(&facets, normal, (given, u), F32s::splat(ior));
            let reflectance = fresnel::dielectric_reflectance(cos_half, F32s::splat(ior)).0;
            let passed = share * (F32s::ONE - reflectance);
            sum += f64::from((weight * passed).reduce_add());
        }
    });
    sum / (HEIGHTS * TURNS) as f64
}

/// Eight numbers to draw facets by that are seen from a direction.
struct Draw {
    facets: Facets,
    normal: Vector<F32s>,
    given: Vector<F32s>,
    u: [F32s; 2],
    /// How much they count for, over the mean of all.
    weight: F32s,
}

/// Calls `each` with all numbers that facets are drawn by which are seen at a cosine: of
/// `HEIGHTS * TURNS` the mean is that of what is seen.
fn for_each_drawn(distribution: Distribution, alpha: f32, cos: f64, mut each: impl FnMut(Draw)) {
    let is_beckmann = distribution == Distribution::Beckmann;
    let facets = Facets::new(F32s::splat(alpha), lanes::mask_of([is_beckmann; LANES]));
    let normal = Vector::splat([0.0, 0.0, 1.0]);
    let sin = (1.0 - cos * cos).sqrt();
    let given = Vector::splat([sin as f32, 0.0, cos as f32]);
    for height in 0..HEIGHTS {
        // More of them where facets of the long tail are drawn.
        let left = 1.0 - (height as f32 + 0.5) / HEIGHTS as f32;
        let (height, weight) = (F32s::splat(1.0 - left * left), F32s::splat(2.0 * left));
        for turn in (0..TURNS).step_by(LANES) {
            let turns = lanes::each(|lane| ((turn + lane) as f32 + 0.5) * 0.5 / TURNS as f32);
            let u = [F32s::from(turns), height];
            each(Draw { facets, normal, given, u, weight });
        }
    }
}

/// The share of light of the cosine `cos` that cloth of white threads reflects: its mean over the
/// directions, more of them towards grazing.
fn of_cloth(alpha: f32, cos: f64) -> f64 {
    const STEPS: usize = 64;
    let normal = Vector::splat([0.0, 0.0, 1.0]);
    let sin = (1.0 - cos * cos).sqrt();
    let given = Vector::splat([sin as f32, 0.0, cos as f32]);
    let alpha = F32s::splat(alpha);
    let mut sum = 0.0;
    for height in 0..STEPS {
        let root = (height as f32 + 0.5) / STEPS as f32;
        let (height, weight) = (F32s::splat(root * root), F32s::splat(2.0 * root));
        let across = (F32s::splat(1.0) - height * height).sqrt();
        for turn in (0..STEPS).step_by(LANES) {
            let turns = lanes::each(|lane| ((turn + lane) as f32 + 0.5) * 0.5 / STEPS as f32);
            let (sine, cosine) = warp::sin_cos_turns(F32s::from(turns));
            let drawn = Vector::new(across * cosine, across * sine, height);
            let value = cloth(alpha, normal, given, drawn);
            sum += f64::from((weight * height * value).reduce_add());
        }
    }
    2.0 * std::f64::consts::PI * sum / (STEPS * STEPS) as f64
}

/// The share of light that goes through facets that are drawn by `u` and reflect nothing, and the
/// cosine of incidence on them.
fn passed(
    facets: &Facets,
    normal: Vector<F32s>,
    (given, u): (Vector<F32s>, [F32s; 2]),
    ior: F32s,
) -> (F32s, F32s) {
    let half = facets.draw_half(normal, given, u);
    let cos = given.dot(half);
    let (reflectance, cos_t) = fresnel::dielectric_reflectance(cos, ior);
    let drawn = half * (cos / ior - cos_t) - given * (F32s::splat(1.0) / ior);
    let refraction = facets.refract(normal, given, drawn, ior);
    let share = refraction.value * ior * ior * -drawn.dot(normal) / refraction.pdf;
    let is_refracted = refraction.pdf.simd_gt(F32s::ZERO) & reflectance.simd_lt(F32s::ONE);
    (is_refracted & share, cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn facets_at(albedo: &Albedo, cos: f32) -> f64 {
        let missing = Albedo::missing(&albedo.terms.map(F32s::splat), F32s::splat(cos));
        f64::from(1.0 - missing.to_array()[0])
    }

    fn coat_at(coat: &CoatAlbedo, cos: f32) -> f64 {
        let (cos, powers) = (F32s::splat(cos), coat.reflected.map(F32s::splat));
        let missing = Albedo::missing(&coat.facets.map(F32s::splat), cos);
        f64::from(CoatAlbedo::at(missing, &powers, cos).to_array()[0])
    }

    /// From the smoothest on, and within half a degree of the surface.
    #[test]
    fn albedos_between_those_of_the_grid_are_as_integrated() {
        use Distribution::{Beckmann, Ggx};
        for alpha in [0.0015, 0.0065, 0.035, 0.213, 0.83, 0.97] {
            for cos in [0.008, 0.0175, 0.07, 0.35, 1.0] {
                let of = |distribution| facets_at(&Albedo::of_facets(distribution, alpha), cos);
                let glass = |d, ior| facets_at(&Albedo::of_glass(d, ior, alpha), cos);
                let ior = 1.5;
                let cases = [
                    (of(Ggx), Ggx, Of::Mirrors, 2.5e-3),
                    (of(Beckmann), Beckmann, Of::Mirrors, 3.5e-3),
                    (glass(Ggx, 1.5), Ggx, Of::Glass { ior }, 1.5e-3),
                    (glass(Ggx, 1.0 / 1.5), Ggx, Of::Glass { ior: 1.0 / 1.5 }, 5e-3),
                    (glass(Beckmann, 1.5), Beckmann, Of::Glass { ior }, 3e-3),
                    (coat_at(&CoatAlbedo::of(Ggx, ior, alpha), cos), Ggx, Of::Coat { ior }, 9e-3),
                ];
                for (found, distribution, of, limit) in cases {
                    let expected = integrate(distribution, of, alpha, f64::from(cos));
                    let text = format!("{distribution:?} {of:?} {alpha} {cos}");
                    assert!((found - expected).abs() < limit, "{text}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn glass_that_hardly_bends_light_loses_what_facets_hide() {
        for ior in [1.003, 1.001, 1.0003, 1.0001, 1.00001] {
            for (ior, cos) in [ior, 1.0 / ior].into_iter().flat_map(|it| [(it, 1.0), (it, 0.4)]) {
                let found = facets_at(&Albedo::of_glass(Distribution::Ggx, ior, 0.2), cos);
                let expected = integrate(Distribution::Ggx, Of::Glass { ior }, 0.2, f64::from(cos));
                assert!((found - expected).abs() < 3e-3, "{ior}, {cos}: {found}, {expected}");
            }
        }
    }

    #[test]
    fn smooth_coats_reflect_as_fresnel_says() {
        let albedo = CoatAlbedo::of(Distribution::Ggx, 1.5, 0.0);
        for cos in [0.1, 0.3, 0.6, 1.0] {
            let (expected, _) = fresnel::dielectric_reflectance(f64::from(cos), 1.5);
            assert!((coat_at(&albedo, cos) - expected).abs() < 6e-3, "{cos}");
        }
        // Of all directions: Walsh 1926, as given by Duntley 1942.
        assert!((albedo.mean - 0.0918).abs() < 1e-3, "{}", albedo.mean);
        assert_eq!(CoatAlbedo::of(Distribution::Ggx, 1.0, 0.5).mean, 0.0);
    }

    /// By a sum that is fine where the cosine is small.
    #[test]
    fn means_are_those_over_the_hemisphere() {
        const STEPS: u16 = 4000;
        for alpha in [0.001, 0.0065, 0.05, 0.7] {
            let albedo = Albedo::of_facets(Distribution::Ggx, alpha);
            let of_step = |step: u16| {
                let root = (f64::from(step) + 0.5) / f64::from(STEPS);
                let cos = root * root * root;
                let width = 3.0 * root * root / f64::from(STEPS);
                2.0 * cos * width * (1.0 - facets_at(&albedo, cos as f32))
            };
            let missing: f64 = (0..STEPS).map(of_step).sum();
            let found = 1.0 - f64::from(albedo.mean);
            assert!((found / missing - 1.0).abs() < 0.02, "{alpha}: {found}, {missing}");
        }
        // Of a reflectance: k = 2 and eta = 1, by a finer sum.
        let of_metal = |cos: f32| fresnel::conductor_reflectance(cos, 1.0, 2.0);
        let of_step = |step: u16| {
            let cos = (f32::from(step) + 0.5) / f32::from(STEPS);
            2.0 * cos * of_metal(cos) / f32::from(STEPS)
        };
        let expected: f32 = (0..STEPS).map(of_step).sum();
        let [one, two] = [1.0, 2.0].map(F32s::splat);
        let found = mean_over_cosines(|cos| fresnel::conductor_reflectance(cos, one, two));
        assert!((found - expected).abs() < 1e-3, "{found}, {expected}");
    }
}
