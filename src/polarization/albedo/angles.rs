//! At which angles light meets the facets that reflect it: by that, what facets reflect in all
//! follows for any reflectance, as that under a film, without an integral of its own.

use std::sync::OnceLock;

use super::{ALPHAS, Draw, POWERS, for_each_drawn, nodes, vandermonde_inverse};
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

/// What makes coefficients of powers of a reflectance, as [`super::CoatAlbedo`] has them: a row for
/// each.
type Matrix = [[f32; ANGLES]; POWERS];

/// Those of all roughnesses of the grid.
static OF_GGX: [OnceLock<Box<Matrix>>; ALPHAS + 1] = [const { OnceLock::new() }; ALPHAS + 1];
static OF_BECKMANN: [OnceLock<Box<Matrix>>; ALPHAS + 1] = [const { OnceLock::new() }; ALPHAS + 1];

/// Coefficients of powers of the root of the cosine of what facets of a roughness reflect, over
/// what mirrors would.
pub fn powers(distribution: Distribution, reflectance: &Angles, alpha: f32) -> [f32; POWERS] {
    let rows = match distribution {
        Distribution::Ggx => &OF_GGX,
        Distribution::Beckmann => &OF_BECKMANN,
    };
    let place = alpha.clamp(0.0, 1.0).sqrt() * ALPHAS as f32;
    let row = (place as usize).min(ALPHAS - 1);
    let part = place - row as f32;
    let [less, more] = [row, row + 1].map(|row| {
        let matrix = rows[row].get_or_init(|| matrix(distribution, row));
        matrix.each_ref().map(|weights| {
            let terms = weights.iter().zip(&reflectance.0).map(|(weight, value)| weight * value);
            terms.sum::<f32>()
        })
    });
    std::array::from_fn(|term| less[term] + part * (more[term] - less[term]))
}

/// That of a roughness of the grid.
fn matrix(distribution: Distribution, row: usize) -> Box<Matrix> {
    let root = row as f32 / ALPHAS as f32;
    let met = nodes().map(|node| met(distribution, root * root, node * node));
    let term = |row: [f64; POWERS], angle: usize| {
        let sum: f64 = row.iter().zip(&met).map(|(factor, met)| factor * met[angle]).sum();
        sum as f32
    };
    Box::new(vandermonde_inverse().map(|row| std::array::from_fn(|angle| term(row, angle))))
}

/// Which share of light of the cosine `cos` that mirrors reflect meets them at each of the angles;
/// what is between two counts for both.
fn met(distribution: Distribution, alpha: f32, cos: f64) -> [f64; ANGLES] {
    let mut sums = [0.0; ANGLES];
    for_each_drawn(distribution, alpha, cos, |Draw { facets, normal, given, u, weight }| {
        let drawn = facets.draw(normal, given, u);
        let pdf = facets.pdf(normal, given, drawn);
        let reflection = facets.reflect(normal, given, drawn);
        let share = weight * (reflection.value * drawn.dot(normal) / pdf);
        let share = (pdf.simd_gt(F32s::ZERO) & share).to_array();
        for (share, cos) in share.into_iter().zip(reflection.cos_half.to_array()) {
            let place = cos.sqrt() * (ANGLES - 1) as f32;
            let less = (place as usize).min(ANGLES - 2);
            let part = place * place - (less * less) as f32;
            let part = f64::from(part / (2 * less + 1) as f32);
            sums[less] += f64::from(share) * (1.0 - part);
            sums[less + 1] += f64::from(share) * part;
        }
    });
    let all: f64 = sums.iter().sum();
    sums.map(|sum| sum / all)
}

#[cfg(test)]
mod tests {
    use super::super::{Albedo, CoatAlbedo, Of, integrate};
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
            }
        }
    }

    /// Fringes are, too, and the shares are of all light.
    #[test]
    fn fringes_count_as_integrated() {
        let fringes = |cos: F32s| F32s::splat(0.5) + F32s::splat(0.3) * (cos * 12.0).cos();
        let sampled = Angles::sampled(fringes);
        for (alpha, cos) in [(0.05, 0.9), (0.3, 0.5), (0.8, 0.2)] {
            let met = met(Distribution::Ggx, alpha, cos);
            let pairs = met.iter().zip(&sampled.0);
            let found: f64 = pairs.map(|(share, value)| share * f64::from(*value)).sum();
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
            let own = sums[1] / (super::super::HEIGHTS * super::super::TURNS) as f64;
            assert!((all - own).abs() < 1e-6, "{all} {own}");
        }
    }
}
