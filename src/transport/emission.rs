//! How light paths leave their emitters, and sensor paths meet them, whichever stage asks, and in
//! what states of polarization.

use glam::Vec3;

use crate::math::{LANES, Vector, lanes};
use crate::scattering::Scene;
use crate::scattering::emitter::state::emitted_state;
use crate::scattering::emitter::{
    EmissionSample, MetEmission, aimed_pdf, direct_pdf, met_emission, sample_emission,
};

use super::Strategy;
use super::measure::{measure_polarized, measure_unpolarized};
use super::mis::{self, EmitterDensities};
use super::sampler::{Purpose, draw};
use super::sides::SensorSide;
use super::tables::measured::Measured;
use super::tables::paths::{IdentityColumns, PathTable};
use super::tables::states::LightState;

/// How the paths of eight rows leave their emitters.
pub fn sample_emissions<const N: usize>(
    identity: &IdentityColumns,
    scene: &Scene<N>,
    row: usize,
) -> [EmissionSample<N>; LANES] {
    let seed = lanes::load_u32(&identity.seed, row);
    let iteration = lanes::load_u32(&identity.iteration, row);
    let numbers = |purpose| draw(seed, iteration, 0, purpose).map(|u| u.to_array());
    let choice = numbers(Purpose::EmitterOfPath);
    let position = numbers(Purpose::EmissionPosition);
    let direction = numbers(Purpose::EmissionDirection);
    let aim = scene.aim.as_ref().map_or([0.0; LANES], |_| numbers(Purpose::Aim)[0]);
    std::array::from_fn(|lane| {
        let [choice, u_position, u_direction] =
            [&choice, &position, &direction].map(|pair| [pair[0][lane], pair[1][lane]]);
        sample_emission(scene, choice, aim[lane], u_position, u_direction)
    })
}

/// The emitters at which eight light paths have started.
pub fn emitters_of_paths<const N: usize>(
    identity: &IdentityColumns,
    scene: &Scene<N>,
    row: usize,
) -> [usize; LANES] {
    let choice = identity.draw(row, 0, Purpose::EmitterOfPath).map(|u| u.to_array());
    lanes::each(|lane| scene.choice.by_power(choice.map(|u| u[lane])))
}

/// The state of the light that an emitter sends from `position` along `direction`, if it is
/// polarized.
#[inline(always)]
pub fn state_sent<const N: usize>(
    scene: &Scene<N>,
    emitter: usize,
    (position, direction): (Vec3, Vec3),
) -> Option<LightState<N>> {
    if !scene.has_polarized_lamps() {
        return None;
    }
    emitted_state(scene, emitter, (position, direction)).map(|state| LightState::emitted(&state))
}

/// An emitter that a sensor path meets.
#[derive(Clone, Copy, Debug)]
pub struct MetEmitter<const N: usize> {
    /// The path.
    pub row: usize,
    /// The distance from its last vertex.
    pub t: f32,
    /// The row of the emitter.
    pub emitter: usize,
    /// What the path's throughput is multiplied by for coming so far.
    pub reaches: [f32; N],
}

/// How a path finds an emitter.
#[derive(Clone, Copy, Debug)]
pub struct Finding {
    /// Segments from the sensor to the emitter.
    pub path_length: u32,
    /// Whether the path may get any longer.
    pub is_last: bool,
    /// What competes.
    pub strategy: Strategy,
}

/// Adds the light of an emitter that a path meets, weighed against the other ways to find it.
pub fn measure_emission<const N: usize, C: SensorSide<N>>(
    measured: &mut Measured<N>,
    paths: &PathTable<N, C>,
    MetEmitter { row, t, emitter, reaches }: MetEmitter<N>,
    scene: &Scene<N>,
    Finding { path_length, strategy, .. }: Finding,
) {
    let direction = Vec3::from(lanes::row_of(&paths.rays.direction, row));
    let origin = Vec3::from(lanes::row_of(&paths.rays.origin, row));
    let position = if t.is_finite() { origin + direction * t } else { origin };
    let Some(met) = met_emission(scene, emitter, position, direction) else { return };
    let MetEmission { cos_at_light, .. } = met;
    // Where the last vertex connects to nothing, nobody asks how.
    let direct_pdf_if = |connects: bool| {
        let from = paths.vantage(row);
        let of_choice = || direct_pdf(scene, (emitter, met.density), &from, (position, direction));
        if connects { of_choice() } else { 0.0 }
    };
    let distance2 = if t.is_finite() { t * t } else { 1.0 };
    let weight = match strategy {
        Strategy::Bidirectional if path_length == 1 => {
            let direct_pdf = scene.glimpses.start_pdf(emitter);
            let densities = EmitterDensities { direct_pdf, emission_pdf: 0.0, cos_at_light };
            let distance2 = if scene.sensor.is_finite() { distance2 } else { 1.0 };
            mis::weight_of_emission_met(paths.mis.row(row), densities, distance2)
        }
        _ if path_length == 1 => 1.0,
        Strategy::Unidirectional | Strategy::Merging => {
            let pdf_w = paths.mis.pdf_w[row];
            // Light paths do not compete.
            let (direct_pdf, emission_pdf) = (direct_pdf_if(pdf_w.is_finite()), 0.0);
            let densities = EmitterDensities { direct_pdf, emission_pdf, cos_at_light };
            mis::power_of_emission_met(pdf_w, densities, distance2)
        }
        Strategy::Bidirectional => {
            let weights = paths.mis.row(row);
            let direct_pdf = direct_pdf_if(weights.d_vcm > 0.0);
            let emission_pdf = aimed_pdf(scene, emitter, &met, (position, direction));
            let densities = EmitterDensities { direct_pdf, emission_pdf, cos_at_light };
            mis::weight_of_emission_met(weights, densities, distance2)
        }
    };
    let value = std::array::from_fn(|n| met.radiance[n] * paths.beta[n][row] * reaches[n] * weight);
    let place = (row, paths.identity.slot[row] as usize);
    if scene.has_polarized_lamps()
        && paths.carriers.columns().is_some()
        && let Some(light) = state_sent(scene, emitter, (position, -direction))
    {
        let carriers = &paths.carriers;
        return measure_state(measured, carriers, place, (value, light), scene, direction);
    }
    measure_unpolarized(measured, &paths.carriers, place, value);
}

/// Adds polarized light that a row meets along its `direction`.
// Rare, and out of the loops of those who measure.
#[inline(never)]
fn measure_state<const N: usize, C: SensorSide<N>>(
    measured: &mut Measured<N>,
    carriers: &C,
    place: (usize, usize),
    (value, light): ([f32; N], LightState<N>),
    scene: &Scene<N>,
    direction: Vec3,
) {
    let along = (Vector::from((-direction).to_array()), scene.sensor.up());
    measure_polarized(measured, carriers, place, value, &light, along);
}
