//! Luminaires: points of intensities by direction, as they were measured. Light paths are drawn by
//! these, and aimed at nothing else.

use glam::Vec3;

use crate::math::{F32s, LANES, Vector, lanes};
use crate::scattering::Scene;
use crate::scene::baked::Shapes;
use crate::scene::emitter::{EmitterModel, Luminaire};

use super::direct::{DirectLanes, Own, OwnLanes, Tables, own};
use super::point;
use super::tree::Outline;
use super::{EmissionSample, Emits, MetEmission, Source};

impl Emits for Luminaire {
    const DELTA: bool = true;

    fn record(&self, _: &Shapes, probability: f32) -> Own {
        let [x, y, z] = self.position.to_array();
        own([x, y, z, probability])
    }

    /// As if the mean were everywhere: see [`Scene::weigh_luminaires`].
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
        Outline { even: 1.0, ..Outline::at(self.position) }
    }

    fn emit<const N: usize>(
        &self,
        source: &Source<N>,
        _: [f32; 2],
        u_direction: [f32; 2],
    ) -> EmissionSample<N> {
        let measured = &source.luminaires[self.row as usize];
        let direction = measured.direction(u_direction);
        let share = measured.share(direction);
        let intensity = source.radiance.map(|mean| mean * share);
        let density = measured.density(direction);
        point::emit::<Self, N>(source, self.position, direction, intensity, density)
    }

    fn met<const N: usize>(&self, _: &Source<N>, _: Vec3, _: Vec3) -> Option<MetEmission<N>> {
        None
    }

    fn places(&self, _: &Shapes) -> Vec<(Vec3, Vec3)> {
        vec![(self.position, Vec3::ZERO)]
    }
}

impl<const N: usize> Scene<N> {
    /// Multiplies what arrives from eight emitters, if they are luminaires, by what these emit that
    /// way, and the densities of light paths by theirs.
    #[inline(never)]
    pub fn weigh_luminaires(&self, chosen: &mut DirectLanes<N>, emitters: [usize; LANES]) {
        let towards = chosen.direction.to_rows();
        let (mut shares, mut densities) = ([1.0; LANES], [1.0; LANES]);
        for (lane, &emitter) in emitters.iter().enumerate() {
            if let EmitterModel::Luminaire(Luminaire { row, .. }) =
                self.optics.emitters[emitter].model
            {
                let measured = &self.optics.luminaires[row as usize];
                let direction = -Vec3::from(towards[lane]);
                shares[lane] = measured.share(direction);
                densities[lane] = measured.density(direction);
            }
        }
        let shares = F32s::from(lanes::each(|lane| shares[lane]));
        chosen.radiance.iter_mut().for_each(|radiance| *radiance *= shares);
        chosen.emission_pdf *= F32s::from(densities);
    }
}
