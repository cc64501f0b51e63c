//! What surfaces of microfacets reflect in all, by the angle of the light, of what arrives: the
//! rest has met other facets, which the model of single reflections leaves out.
//!
//! It is integrated for a grid of roughnesses, where that is asked for, and kept as a polynomial in
//! the root of the cosine. With roughnesses from 0.2 on, it is off by 0.006 at most, mostly by
//! 0.001; with less, by 0.014 towards grazing, and by up to 0.09 within two degrees of it. What is
//! built on it reflects as much less or more, and is as reciprocal as ever.
//!
//! Kulla and Conty 2017 ("Revisiting physically based shading at Imageworks") make of such an
//! albedo E(mu) the lobe `(1 - E(i)) (1 - E(o)) / (pi (1 - E_mean))`, which is reciprocal and
//! reflects just what is missing.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock};

use crate::math::elementary::{exp, ln};
use crate::math::{F32s, LANES, Vector, lanes, warp};

use super::cloth::cloth;
use super::fresnel;
use super::microfacet::{Distribution, Facets};

/// Coefficients of the polynomial.
pub const TERMS: usize = 8;
/// Intervals of the grid of roughnesses: even in the root.
const ALPHAS: usize = 32;
/// Points of the quadrature: turns over a half circle (the other mirrors it), and heights.
const TURNS: usize = 16;
const HEIGHTS: usize = 32;
/// Most tables that are kept of dielectrics.
const TABLES_MAX: usize = 1000;
/// Steps of the logarithm of indices of refraction: those of paths differ from iteration to
/// iteration.
const STEP_OF_IOR: f32 = 1e-3;

/// The albedo of facets of one roughness, by the cosine of the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Albedo {
    /// Coefficients of the powers of the root of the cosine, from the lowest on.
    pub terms: [f32; TERMS],
    /// The mean over the hemisphere, by the cosine.
    pub mean: f32,
}

impl Albedo {
    /// Of facets that reflect all light.
    pub fn of_facets(distribution: Distribution, alpha: f32) -> Self {
        static OF_GGX: Table = Table::new(Distribution::Ggx, Of::Mirrors);
        static OF_BECKMANN: Table = Table::new(Distribution::Beckmann, Of::Mirrors);
        match distribution {
            Distribution::Ggx => OF_GGX.at(alpha),
            Distribution::Beckmann => OF_BECKMANN.at(alpha),
        }
    }

    /// Of facets (GGX) of a dielectric of this index of refraction, relative to what is outside.
    pub fn of_coat(ior: f32, alpha: f32) -> Self {
        Self::of_dielectric(Distribution::Ggx, ior, alpha)
    }

    /// The same of any distribution.
    pub fn of_dielectric(distribution: Distribution, ior: f32, alpha: f32) -> Self {
        Table::shared(distribution, Of::Coat { ior }).at(alpha)
    }

    /// Of facets of a dielectric of this index of refraction, relative to what is on the side that
    /// light comes from: what they reflect and let through. The index counts to a thousandth.
    pub fn of_glass(distribution: Distribution, ior: f32, alpha: f32) -> Self {
        let steps = (ln(ior) / STEP_OF_IOR).round();
        let ior = exp(steps * STEP_OF_IOR);
        Table::shared(distribution, Of::Glass { ior }).at(alpha)
    }

    /// The same with a share of the reflectance.
    #[must_use]
    pub fn scaled(self, share: f32) -> Self {
        Self { terms: self.terms.map(|term| share * term), mean: share * self.mean }
    }

    /// Of cloth of white threads ([`super::cloth`]). It may be more than one towards grazing.
    pub fn of_cloth(alpha: f32) -> Self {
        static OF_CLOTH: Table = Table::new(Distribution::Ggx, Of::Cloth);
        OF_CLOTH.at(alpha.max(super::cloth::ALPHA_MIN))
    }

    /// At eight cosines, 0 to 1, by the terms there; within [0, 1].
    #[inline(always)]
    pub fn at(terms: &[F32s; TERMS], cos: F32s) -> F32s {
        Self::unbounded(terms, cos).fast_min(F32s::splat(1.0))
    }

    /// The same of what may be more than one.
    #[inline(always)]
    pub fn unbounded(terms: &[F32s; TERMS], cos: F32s) -> F32s {
        let root = cos.fast_max(F32s::splat(0.0)).sqrt();
        let mut sum = terms[TERMS - 1];
        for &term in terms[..TERMS - 1].iter().rev() {
            sum = sum.mul_add(root, term);
        }
        sum.fast_max(F32s::splat(0.0))
    }

    fn of_terms(terms: [f32; TERMS]) -> Self {
        // The integral of 2 mu dmu = 4 r^3 dr over the powers of the root r.
        let integral = |(power, term): (usize, &f32)| 4.0 * term / (power + 4) as f32;
        Self { terms, mean: terms.iter().enumerate().map(integral).sum() }
    }
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

/// Tells tables apart.
type Key = (bool, bool, u32);

/// The albedo of facets of any roughness, integrated where it is asked for.
struct Table {
    distribution: Distribution,
    of: Of,
    /// Terms at the roughnesses of the grid.
    rows: [OnceLock<[f32; TERMS]>; ALPHAS + 1],
}

impl Table {
    const fn new(distribution: Distribution, of: Of) -> Self {
        Self { distribution, of, rows: [const { OnceLock::new() }; ALPHAS + 1] }
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

    fn row(&self, row: usize) -> &[f32; TERMS] {
        self.rows[row].get_or_init(|| {
            let root = row as f32 / ALPHAS as f32;
            let (alpha, of) = (root * root, self.distribution);
            let values = roots().map(|root| integrate(of, self.of, alpha, root * root));
            let term = |row: [f64; TERMS]| row.iter().zip(&values).map(|(a, b)| a * b).sum::<f64>();
            vandermonde_inverse().map(|row| term(row) as f32)
        })
    }

    /// Linear in the root of the roughness.
    fn at(&self, alpha: f32) -> Albedo {
        let place = alpha.clamp(0.0, 1.0).sqrt() * ALPHAS as f32;
        let row = (place as usize).min(ALPHAS - 1);
        let part = place - row as f32;
        let [less, more] = [row, row + 1].map(|row| self.row(row));
        let between = |term: usize| less[term] + part * (more[term] - less[term]);
        Albedo::of_terms(std::array::from_fn(between))
    }
}

/// The roots of cosines at which it is computed: those of Chebyshev.
fn roots() -> [f64; TERMS] {
    std::array::from_fn(|node| {
        let turn = std::f64::consts::PI * (node as f64 + 0.5) / TERMS as f64;
        0.5 - 0.5 * crate::math::elementary::cos(turn)
    })
}

/// The matrix that makes coefficients of the values at [`roots`]: row k holds those of the power k
/// in Lagrange's polynomials.
fn vandermonde_inverse() -> [[f64; TERMS]; TERMS] {
    let roots = roots();
    let mut inverse = [[0.0; TERMS]; TERMS];
    for (node, &root) in roots.iter().enumerate() {
        let mut coefficients = [0.0; TERMS];
        coefficients[0] = 1.0;
        for &other in roots.iter().filter(|&&other| other != root) {
            for power in (0..TERMS).rev() {
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
    let none = F32s::splat(0.0);
    let is_beckmann = distribution == Distribution::Beckmann;
    let facets = Facets::new(F32s::splat(alpha), lanes::mask_of([is_beckmann; LANES]));
    let normal = Vector::splat([0.0, 0.0, 1.0]);
    let sin = (1.0 - cos * cos).sqrt();
    let given = Vector::splat([sin as f32, 0.0, cos as f32]);
    let mut sum = 0.0;
    for height in 0..HEIGHTS {
        // More of them where facets of the long tail are drawn.
        let left = 1.0 - (height as f32 + 0.5) / HEIGHTS as f32;
        let (height, weight) = (F32s::splat(1.0 - left * left), F32s::splat(2.0 * left));
        for turn in (0..TURNS).step_by(LANES) {
            let turns = lanes::each(|lane| ((turn + lane) as f32 + 0.5) * 0.5 / TURNS as f32);
            let u = [F32s::from(turns), height];
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
            sum += f64::from((pdf.simd_gt(none) & (weight * share)).reduce_add());
            if let Of::Glass { ior } = of {
                let passed = passed(&facets, normal, (given, u), F32s::splat(ior));
                sum += f64::from((weight * passed).reduce_add());
            }
        }
    }
    sum / (HEIGHTS * TURNS) as f64
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

/// The share of light that goes through facets that are drawn by `u`.
fn passed(
    facets: &Facets,
    normal: Vector<F32s>,
    (given, u): (Vector<F32s>, [F32s; 2]),
    ior: F32s,
) -> F32s {
    let half = facets.draw_half(normal, given, u);
    let cos = given.dot(half);
    let (reflectance, cos_t) = fresnel::dielectric_reflectance(cos, ior);
    let drawn = half * (cos / ior - cos_t) - given * (F32s::splat(1.0) / ior);
    let refraction = facets.refract(normal, given, drawn, ior);
    let share = refraction.value * ior * ior * -drawn.dot(normal) / refraction.pdf;
    refraction.pdf.simd_gt(F32s::splat(0.0)) & (share * (F32s::splat(1.0) - reflectance))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(albedo: &Albedo, cos: f32) -> f32 {
        Albedo::at(&albedo.terms.map(F32s::splat), F32s::splat(cos)).to_array()[0]
    }

    #[test]
    fn albedos_between_those_of_the_grid_are_as_integrated() {
        for alpha in [0.213, 0.47, 0.83] {
            for cos in [0.1, 0.35, 0.7, 1.0] {
                let pairs = [
                    (Albedo::of_facets(Distribution::Ggx, alpha), Distribution::Ggx, Of::Mirrors),
                    (
                        Albedo::of_facets(Distribution::Beckmann, alpha),
                        Distribution::Beckmann,
                        Of::Mirrors,
                    ),
                    (Albedo::of_coat(1.5, alpha), Distribution::Ggx, Of::Coat { ior: 1.5 }),
                ];
                for (albedo, distribution, of) in pairs {
                    let expected = integrate(distribution, of, alpha, f64::from(cos));
                    let found = f64::from(at(&albedo, cos));
                    assert!((found - expected).abs() < 4e-3, "{alpha} {cos}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn smooth_coats_reflect_as_fresnel_says() {
        let albedo = Albedo::of_coat(1.5, 0.0);
        for cos in [0.1, 0.3, 0.6, 1.0] {
            let (expected, _) = fresnel::dielectric_reflectance(f64::from(cos), 1.5);
            assert!((f64::from(at(&albedo, cos)) - expected).abs() < 6e-3, "{cos}");
        }
        // Of all directions: Walsh 1926, as given by Duntley 1942.
        assert!((albedo.mean - 0.0918).abs() < 1e-3, "{}", albedo.mean);
        assert_eq!(Albedo::of_coat(1.0, 0.5).mean, 0.0);
    }

    #[test]
    fn means_are_those_over_the_hemisphere() {
        const STEPS: u16 = 2000;
        let albedo = Albedo::of_facets(Distribution::Ggx, 0.7);
        let of_step = |step: u16| {
            let cos = (f32::from(step) + 0.5) / f32::from(STEPS);
            2.0 * cos * at(&albedo, cos) / f32::from(STEPS)
        };
        let mean: f32 = (0..STEPS).map(of_step).sum();
        assert!((mean - albedo.mean).abs() < 1e-4, "{mean}, {}", albedo.mean);
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
