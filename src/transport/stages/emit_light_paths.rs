//! Starts one light path a slot.

use crate::math::LANES;
use crate::scattering::Scene;
use crate::scattering::emitter::EmissionSample;
use crate::transport::Chunk;
use crate::transport::emission::{sample_emissions, state_sent};
use crate::transport::mis::PartialWeights;
use crate::transport::sampler::{Stream, path_seed};
use crate::transport::sides::LightSide;
use crate::transport::tables::paths::PathTable;

/// Starts the light paths of a chunk, as many as its slots.
///
/// Emitters at a finite distance and others meet their first surface with different measures,
/// which `weigh_arrival` learns from the infinite `pdf_w` of the latter.
///
/// From: nothing. To: trace_closest, connect_emission.
/// Writes: paths. Reads: chunk, scene.
pub fn emit_light_paths<const N: usize, C: LightSide<N>>(
    paths: &mut PathTable<N, C>,
    chunk: &Chunk,
    scene: &Scene<N>,
) {
    let slots = chunk.slots();
    paths.len = slots;
    if let Some(carriers) = paths.carriers.columns_mut() {
        carriers.start_at_emitters(slots);
    }
    for row in (0..slots).step_by(LANES) {
        let end = slots.min(row + LANES);
        for slot in row..end {
            let (path, index) = chunk.sequence_of(slot, &scene.sensor);
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

fn start_row<const N: usize, C: LightSide<N>>(
    paths: &mut PathTable<N, C>,
    row: usize,
    sample: &EmissionSample<N>,
    scene: &Scene<N>,
) {
    let origin = scene.off_emitter(sample, sample.direction);
    if paths.media.present() {
        paths.media.inside[row] = scene.medium_at_emitter(sample, sample.direction);
    }
    for axis in 0..3 {
        paths.rays.origin[axis][row] = origin[axis];
        paths.rays.direction[axis][row] = sample.direction[axis];
    }
    for channel in 0..N {
        paths.beta[channel][row] = sample.beta[channel];
    }
    paths.mis.pdf_w[row] = if sample.finite { 0.0 } else { f32::INFINITY };
    let &EmissionSample { emission_pdf, cos_at_light, delta, .. } = sample;
    paths.mis.set_row(row, PartialWeights::from_emitter(emission_pdf, cos_at_light, delta));
    let from = (sample.position, sample.direction);
    if let Some(carriers) = paths.carriers.columns_mut()
        && let Some(light) = state_sent(scene, sample.emitter, from)
    {
        carriers.start_polarized(row, &light);
    }
}
