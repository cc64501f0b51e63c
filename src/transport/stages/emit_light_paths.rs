//! Starts one light path a slot.

use glam::Vec3;

use crate::geometry::offset_origin;
use crate::math::{LANES, Vector, lanes};
use crate::scattering::Scene;
use crate::scattering::emission::{EmissionSample, sample_emission};
use crate::transport::Chunk;
use crate::transport::mis::{EmitterDensities, PartialWeights};
use crate::transport::sampler::{Purpose, Stream, draw, path_seed};
use crate::transport::tables::paths::{IdentityColumns, PathTable};

use super::scatter_light::LightSide;

/// Starts the light paths of a chunk, as many as its slots.
///
/// Emitters at a finite distance and others meet their first surface with different measures,
/// which `weigh_arrival` learns from the infinite `pdf_w` of the latter.
///
/// To: trace_closest.
/// Writes: paths. Reads: chunk, scene.
pub fn emit_light_paths<const N: usize, C: LightSide<N>>(
    paths: &mut PathTable<N, C>,
    chunk: &Chunk,
    scene: &Scene<N>,
) {
    let slots = chunk.slots();
    paths.len = slots;
    paths.carriers.emit_unpolarized(slots);
    for row in (0..slots).step_by(LANES) {
        let end = slots.min(row + LANES);
        for slot in row..end {
            let (path, index) = chunk.sequence_of(slot, scene.sensor.width);
            paths.identity.slot[slot] = slot as u32;
            paths.identity.iteration[slot] = index;
            paths.identity.seed[slot] = path_seed(chunk.seed, Stream::Light, path);
        }
        let samples = sample_emissions(&paths.identity, scene, row);
        for (slot, sample) in (row..end).zip(&samples) {
            start_row(paths, slot, sample, scene);
        }
    }
    paths.media.start(slots);
}

/// How the paths of eight rows leave their emitters.
pub(super) fn sample_emissions<const N: usize>(
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

fn start_row<const N: usize, C>(
    paths: &mut PathTable<N, C>,
    row: usize,
    sample: &EmissionSample<N>,
    scene: &Scene<N>,
) {
    let origin = leave(sample.position, sample.normal, sample.direction, scene.reach);
    if paths.media.present() {
        let front = sample.direction.dot(sample.normal) >= 0.0;
        paths.media.inside[row] = scene.medium_at_emitter(sample.emitter, front);
    }
    for axis in 0..3 {
        paths.rays.origin[axis][row] = origin[axis];
        paths.rays.direction[axis][row] = sample.direction[axis];
    }
    for channel in 0..N {
        paths.beta[channel][row] = sample.beta[channel];
    }
    paths.mis.pdf_w[row] = if sample.finite { 0.0 } else { f32::INFINITY };
    let &EmissionSample { direct_pdf, emission_pdf, cos_at_light, delta, .. } = sample;
    let emitter = EmitterDensities { direct_pdf, emission_pdf, cos_at_light };
    paths.mis.set_row(row, PartialWeights::from_emitter(emitter, delta));
}

/// [`offset_origin`] for one point.
pub(super) fn leave(position: Vec3, normal: Vec3, direction: Vec3, reach: f32) -> Vec3 {
    let [position, normal, direction] =
        [position, normal, direction].map(|vector| Vector::from(vector.to_array()));
    Vec3::from_array(offset_origin(position, normal, direction, reach).into())
}
