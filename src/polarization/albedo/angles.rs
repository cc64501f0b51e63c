//! At which angles light meets the facets that reflect it: by that, what facets reflect in all
//! follows for any reflectance, as that under a film, without an integral of its own.

use super::{
    ALPHAS, Draw, HEIGHTS, Of, POWERS, TURNS, Table, between_rows, for_each_drawn, nodes, passed,
    vandermonde_inverse,
};
use crate::math::{F32s, LANES, lanes};
use crate::polarization::Distribution;

/// Cosines of incidence between which a reflectance is linear: even in the root, as reflectances
/// are steep at grazing.
const ANGLES: usize = 32;

/// A reflectance by the cosine of incidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Angles([f32; ANGLES]);

impl Angles {
    /// One that is asked at all cosines that count.
    pub fn sampled(of: impl Fn(F32s) -> F32s) -> Self {
        let mut all = [0.0; ANGLES];
        for (packet, all) in all.chunks_exact_mut(LANES).enumerate() {
            let root = F32s::from(lanes::each(|lane| (packet * LANES + lane) as f32));
            let root = root * F32s::splat(1.0 / (ANGLES - 1) as f32);
            all.copy_from_slice(&of(root * root).to_array());
        }
        Self(all)
    }
}

/// What makes coefficients of powers of a reflectance: a row for each, of which the last number is
/// what there is without.
pub type Matrix = [[f32; ANGLES + 1]; POWERS];

impl Table {
    /// Coefficients at a roughness, as of [`Table::at`], with this reflectance: of mirrors, those
    /// of a coat, of which what is reflected counts.
    pub fn by_angles(&self, reflectance: &Angles, alpha: f32) -> [f32; POWERS] {
        between_rows(alpha, |row| {
            let matrix = self.by_angles[row].get_or_init(|| self.matrix(row));
            matrix.each_ref().map(|[weights @ .., without]| {
                let terms = weights.iter().zip(&reflectance.0);
                without + terms.map(|(weight, value)| weight * value).sum::<f32>()
            })
        })
    }

    /// That of a roughness of the grid.
    fn matrix(&self, row: usize) -> Box<Matrix> {
        let root = row as f32 / ALPHAS as f32;
        let values = nodes().map(|node| self.values(root * root, node));
        let term = |row: [f64; POWERS], angle: usize| {
            let sum: f64 = row.iter().zip(&values).map(|(factor, of)| factor * of[angle]).sum();
            sum as f32
        };
        Box::new(vandermonde_inverse().map(|row| std::array::from_fn(|angle| term(row, angle))))
    }

    /// What the polynomial of a roughness is of, from 0 to 1, for each of the angles and without.
    fn values(&self, alpha: f32, x: f64) -> [f64; ANGLES + 1] {
        match self.of {
            Of::Glass { ior } => {
                let met = met(self.distribution, (alpha, Some(ior)), self.cosine(alpha, x));
                let mut missing = met.map(|share| -share / (HEIGHTS * TURNS) as f64);
                missing[ANGLES] += 1.0;
                missing
            }
            Of::Mirrors | Of::Coat { .. } | Of::Cloth => {
                let met = met(self.distribution, (alpha, None), x * x);
                let all: f64 = met.iter().sum();
                met.map(|share| share / all)
            }
        }
    }
}

/// How much of light of the cosine `cos` that facets would reflect meets them at each of the
/// angles, less what goes through glass of an index there, where angles are those on the side of
/// the lower index; and what is reflected totally, and goes through.
fn met(
    distribution: Distribution,
    (alpha, ior): (f32, Option<f32>),
    cos: f64,
) -> [f64; ANGLES + 1] {
    let mut sums = [0.0; ANGLES + 1];
    for_each_drawn(distribution, alpha, cos, |Draw { facets, normal, given, u, weight }| {
        let drawn = facets.draw(normal, given, u);
        let pdf = facets.pdf(normal, given, drawn);
        let reflection = facets.reflect(normal, given, drawn);
        let share = weight * (reflection.value * drawn.dot(normal) / pdf);
        let share = pdf.simd_gt(F32s::ZERO) & share;
        let Some(ior) = ior else { return add(&mut sums, reflection.cos_half, share) };
        let (outside, total) = outside(reflection.cos_half, ior);
        add(&mut sums, outside, !total & share);
        let (passed, cos_half) = passed(&facets, normal, (given, u), F32s::splat(ior));
        let passed = weight * passed;
        add(&mut sums, self::outside(cos_half, ior).0, -passed);
        sums[ANGLES] += f64::from((passed + (total & share)).reduce_add());
    });
    sums
}

/// The cosine on the side of the lower index of refraction, which is `ior` relative to that of the
/// side of the cosine `cos` if it is less than one, and the mask of total reflection.
fn outside(cos: F32s, ior: f32) -> (F32s, F32s) {
    if ior >= 1.0 {
        return (cos, F32s::ZERO);
    }
    let sin2 = (F32s::ONE - cos * cos) * F32s::splat(1.0 / (ior * ior));
    ((F32s::ONE - sin2).fast_max(F32s::ZERO).sqrt(), sin2.simd_ge(F32s::ONE))
}

/// Adds shares at cosines; what is between two counts for both.
fn add(sums: &mut [f64; ANGLES + 1], cos: F32s, share: F32s) {
    for (share, cos) in share.to_array().into_iter().zip(cos.to_array()) {
        let place = cos.clamp(0.0, 1.0).sqrt() * (ANGLES - 1) as f32;
        let less = (place as usize).min(ANGLES - 2);
        let part = place * place - (less * less) as f32;
        let part = f64::from(part / (2 * less + 1) as f32);
        sums[less] += f64::from(share) * (1.0 - part);
        sums[less + 1] += f64::from(share) * part;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Albedo, CoatAlbedo, integrate};
    use super::*;
    use crate::polarization::fresnel;

    /// Coats of dielectrics, of which there are tables.
    #[test]
    fn any_reflectance_may_be_that_of_a_dielectric() {
        for distribution in Distribution::ALL {
            for (ior, alpha) in [(1.5, 0.0), (1.5, 0.035), (1.5, 0.6), (2.4, 0.2), (1.2, 1.0)] {
                let of = |cos| fresnel::dielectric_reflectance(cos, F32s::splat(ior)).0;
                let any = CoatAlbedo::of_any(distribution, &Angles::sampled(of), alpha);
                let coat = CoatAlbedo::of(distribution, ior, alpha);
                for cos in [0.02, 0.1, 0.3, 0.7, 1.0] {
                    let at = |coat: &CoatAlbedo| {
                        let terms = coat.facets.map(F32s::splat);
                        let missing = Albedo::missing(&terms, F32s::splat(cos));
                        let powers = coat.reflected.map(F32s::splat);
                        CoatAlbedo::at(missing, &powers, F32s::splat(cos)).to_array()[0]
                    };
                    let (found, expected) = (at(&any), at(&coat));
                    let text = format!("{distribution:?} {ior} {alpha} {cos}");
                    assert!((found - expected).abs() < 3e-3, "{text}: {found} {expected}");
                }
                assert!((any.mean - coat.mean).abs() < 1e-3, "{} {}", any.mean, coat.mean);
                let reflectance = Angles::sampled(of);
                for ior in [ior, 1.0 / ior] {
                    let any = Albedo::of_any_glass(distribution, (ior, &reflectance), alpha);
                    let glass = Albedo::of_glass(distribution, ior, alpha);
                    let off = (any.mean - glass.mean).abs();
                    assert!(off < 2e-3, "{ior} {alpha}: {} {}", any.mean, glass.mean);
                }
            }
        }
    }

    /// Fringes are, too, and the shares are of all light.
    #[test]
    fn fringes_count_as_integrated() {
        let fringes = |cos: F32s| F32s::splat(0.5) + F32s::splat(0.3) * (cos * 12.0).cos();
        let sampled = Angles::sampled(fringes);
        for (alpha, cos) in [(0.05, 0.9), (0.3, 0.5), (0.8, 0.2)] {
            let met = met(Distribution::Ggx, (alpha, None), cos);
            let pairs = met.iter().zip(&sampled.0);
            let found: f64 = pairs.map(|(share, value)| share * f64::from(*value)).sum();
            let found = found / met.iter().sum::<f64>();
            let mut sums = [0.0; 2];
            for_each_drawn(Distribution::Ggx, alpha, cos, |it| {
                let Draw { facets, normal, given, u, weight } = it;
                let drawn = facets.draw(normal, given, u);
                let pdf = facets.pdf(normal, given, drawn);
                let reflection = facets.reflect(normal, given, drawn);
                let share = weight * (reflection.value * drawn.dot(normal) / pdf);
                let share = pdf.simd_gt(F32s::ZERO) & share;
                sums[0] += f64::from((share * fringes(reflection.cos_half)).reduce_add());
                sums[1] += f64::from(share.reduce_add());
            });
            let expected = sums[0] / sums[1];
            assert!((found - expected).abs() < 6e-3, "{alpha} {cos}: {found} {expected}");
            let all = integrate(Distribution::Ggx, Of::Mirrors, alpha, cos);
            let own = sums[1] / (HEIGHTS * TURNS) as f64;
            assert!((all - own).abs() < 1e-6, "{all} {own}");
        }
    }
}
