//! Lamps beside the way through a medium: two ways to find the light that a path scatters there.
//!
//! A path meets a particle by a free flight, and connects to a lamp from there. Or it chooses a
//! lamp from its way, a distance by how that looks from the lamp ([`Equiangular`]), and connects
//! from there. The first knows of the medium, the second of the lamp; the balance heuristic (Veach
//! 1997, section 9.2.2) weighs them by their densities on the way, as both go on alike. Light falls
//! off with the square of the distance from a lamp, and so does the second density: what is
//! found has no peak there.
//!
//! As paths come to where a piece begins in either way, densities are of what follows. That of
//! free flights is the mean over the wavelengths, as in all weights.

use crate::math::equiangular::Equiangular;
use crate::math::{F32s, LANES, Vector, lanes};
use crate::scattering::Scene;
use crate::scattering::emitter::lamps::Lamps;
use crate::scattering::emitter::tree::Vantage;
use crate::scattering::medium::Medium;

use super::tables::paths::AnyPaths;
use super::tables::pieces::PieceTable;

/// Of the light that a lamp would bring to a piece, if nothing took away from it, over its
/// intensity and in units of the extinction coefficient: one over what is bright.
const BRIGHT: f32 = 0.5;
/// Of pieces far from a lamp.
const LEAST_SHARE: f32 = 0.05;

/// Eight pieces of segments in one medium.
pub struct PieceLanes<'a, const N: usize> {
    /// The medium.
    pub medium: &'a Medium<N>,
    /// Where the segments start.
    pub origin: Vector<F32s>,
    /// Where they go, unit length.
    pub direction: Vector<F32s>,
    /// Distances from the origin between which the pieces lie.
    pub range: [F32s; 2],
}

impl<'a, const N: usize> PieceLanes<'a, N> {
    /// The rows from `first` on of the pieces in a medium; `rows` are those of their paths.
    #[inline(always)]
    pub fn load(
        pieces: &PieceTable,
        paths: &AnyPaths<N>,
        (medium, first): (&'a Medium<N>, usize),
        rows: &[usize; LANES],
    ) -> Self {
        Self {
            medium,
            origin: Vector::gather(|lane| lanes::row_of(&paths.rays.origin, rows[lane])),
            direction: Vector::gather(|lane| lanes::row_of(&paths.rays.direction, rows[lane])),
            range: [&pieces.from, &pieces.to].map(|column| lanes::load(column, first)),
        }
    }

    /// The places that lamps are chosen from: in the middle of what light comes through.
    pub fn vantages(&self) -> [Vantage; LANES] {
        let [from, to] = self.range;
        let free = F32s::splat(1.0 / self.medium.extinction());
        let middle = from + ((to - from) * F32s::splat(0.5)).min(free);
        let position = (self.origin + self.direction * middle).to_rows();
        std::array::from_fn(|lane| Vantage {
            position: position[lane].into(),
            normal: glam::Vec3::ZERO,
        })
    }

    /// How the lamps see the pieces.
    #[inline(always)]
    pub fn seen_by(&self, lamps: &Lamps, emitters: [usize; LANES]) -> Equiangular {
        let offset = lamps.places(emitters) - self.origin;
        Equiangular::new(offset, self.direction, self.range, F32s::ZERO)
    }

    /// The share of pieces from which lamps that see them so are looked for: all that are bright
    /// beside what free flights find, where these meet particles before the lamp's light changes
    /// much.
    #[inline(always)]
    pub fn share(&self, seen: &Equiangular) -> F32s {
        let bright = seen.brought() * F32s::splat(BRIGHT / self.medium.density);
        bright.max(F32s::splat(LEAST_SHARE)).min(F32s::ONE)
    }

    /// Density per unit of length with which free flights end at distances from the origin, where
    /// the piece is short or nothing is absorbed; elsewhere it stands for that.
    #[inline(always)]
    pub fn density(&self, distance: F32s) -> F32s {
        let length = distance - self.range[0];
        let mut sum = F32s::ZERO;
        for (&sigma_d, &sigma_t) in self.medium.sigma_d.iter().zip(&self.medium.sigma_t) {
            let [sigma_d, sigma_t] = [sigma_d, sigma_t].map(F32s::splat);
            sum += sigma_d * (-(sigma_t * length)).exp();
        }
        sum * F32s::splat(1.0 / N as f32)
    }

    /// The weight of vertices that free flights have found at `distance` and that have chosen
    /// emitters to connect to with the probabilities `chance`.
    pub fn weight_of_flight(
        &self,
        scene: &Scene<N>,
        distance: F32s,
        (emitters, chance): ([usize; LANES], F32s),
    ) -> F32s {
        let Some(lamps) = &scene.lamps else { return F32s::ONE };
        let of_lamps = lamps.chances(|| self.vantages(), emitters);
        let flight = chance * self.density(distance);
        let seen = self.seen_by(lamps, emitters);
        let lamp = of_lamps * self.share(&seen) * seen.density(distance);
        balance(flight, lamp)
    }
}

/// Balance heuristic for what the density `own` has found; zero where nothing would have.
#[inline(always)]
fn balance(own: F32s, other: F32s) -> F32s {
    own / (own + other).max(F32s::splat(f32::MIN_POSITIVE))
}
