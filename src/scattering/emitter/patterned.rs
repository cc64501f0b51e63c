//! Points of intensities by direction: luminaires and projectors. Light paths are drawn by these,
//! and aimed at nothing else.

use glam::Vec3;

use crate::math::{F32s, LANES, Vector, lanes};
use crate::scattering::Scene;
use crate::scene::baked::Shapes;
use crate::scene::emitter::{EmitterModel, Patterned};

use super::direct::{DirectLanes, Own, OwnLanes, Tables, own};
use super::point;
use super::tree::Outline;
use super::{EmissionSample, Emits, Source};

impl Emits for Patterned {
    const DELTA: bool = true;

    fn record(&self, _: &Shapes, probability: f32) -> Own {
        let [x, y, z] = self.position.to_array();
        own([x, y, z, probability])
    }

    /// As if the mean were everywhere: see [`Scene::weigh_patterns`].
    #[inline(always)]
    fn choose<const N: usize>(
        (&[x, y, z, probability, ..], _): (&OwnLanes, &Tables),
        reference: Vector<F32s>,
        radiance: [F32s; N],
        chance: F32s,
        _: [F32s; 2],
    ) -> DirectLanes<N> {
        let place = Vector::new(x, y, z);
        point::choose::<Self, N>(place, reference, radiance, [chance, probability])
    }

    fn density(&self, _: &Shapes, _: Vec3, _: Vec3, _: Vec3) -> f32 {
        1.0
    }

    fn outline(&self, _: &Shapes) -> Outline {
        let (axis, edge) = self.cone;
        match edge > -1.0 {
            // As if the cone were full of it.
            true => {
                Outline { axis: axis * (2.0 / (1.0 - edge)), edge, ..Outline::at(self.position) }
            }
            false => Outline { even: 1.0, ..Outline::at(self.position) },
        }
    }

    fn emit<const N: usize>(
        &self,
        source: &Source<N>,
        _: [f32; 2],
        u_direction: [f32; 2],
    ) -> EmissionSample<N> {
        let pattern = &source.patterns[self.row as usize];
        let direction = pattern.direction(u_direction);
        let share = pattern.share(direction, source.carried);
        let intensity = std::array::from_fn(|n| source.radiance[n] * share[n]);
        // Where it is zero, which is rounding, nothing is emitted.
        let density = pattern.density(direction).max(f32::MIN_POSITIVE);
        point::emit::<Self, N>(source, self.position, direction, intensity, density)
    }

    fn places(&self, _: &Shapes) -> Vec<(Vec3, Vec3)> {
        vec![(self.position, Vec3::ZERO)]
    }
}

impl<const N: usize> Scene<N> {
    /// Multiplies what arrives from eight emitters, if these have patterns, by what they emit that
    /// way, and the densities of light paths by theirs.
    #[inline(never)]
    pub fn weigh_patterns(&self, chosen: &mut DirectLanes<N>, emitters: [usize; LANES]) {
        let towards = chosen.direction.to_rows();
        let (mut shares, mut densities) = ([[1.0; N]; LANES], [1.0; LANES]);
        for (lane, &emitter) in emitters.iter().enumerate() {
            if let EmitterModel::Patterned(Patterned { row, .. }) =
                self.optics.emitters[emitter].model
            {
                let pattern = &self.optics.patterns[row as usize];
                let direction = -Vec3::from(towards[lane]);
                shares[lane] = pattern.share(direction, &self.optics.carried);
                densities[lane] = pattern.density(direction);
            }
        }
        for (n, radiance) in chosen.radiance.iter_mut().enumerate() {
            *radiance *= F32s::from(lanes::each(|lane| shares[lane][n]));
        }
        chosen.emission_pdf *= F32s::from(densities);
    }
}
