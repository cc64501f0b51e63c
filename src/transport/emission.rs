//! How light paths leave their emitters, whichever stage asks.

use crate::math::{LANES, lanes};
use crate::scattering::Scene;
use crate::scattering::emitter::{EmissionSample, sample_emission};

use super::sampler::{Purpose, draw};
use super::tables::paths::IdentityColumns;

/// How the paths of eight rows leave their emitters.
pub fn sample_emissions<const N: usize>(
    identity: &IdentityColumns,
    scene: &Scene<N>,
    row: usize,
) -> [EmissionSample<N>; LANES] {
    let seed = lanes::load_u32(&identity.seed, row);
    let iteration = lanes::load_u32(&identity.iteration, row);
    let numbers = |purpose| draw(seed, iteration, 0, purpose).map(|u| u.to_array());
    let [choice, _] = numbers(Purpose::EmitterOfPath);
    let position = numbers(Purpose::EmissionPosition);
    let direction = numbers(Purpose::EmissionDirection);
    std::array::from_fn(|lane| {
        let (u_position, u_direction) = (position.map(|u| u[lane]), direction.map(|u| u[lane]));
        sample_emission(scene, choice[lane], u_position, u_direction)
    })
}
