//! Connects points of emitters straight to the sensor: what is seen directly, where no sensor
//! path is traced.

use crate::math::{LANES, lanes};
use crate::scattering::emitter::EmissionSample;
use crate::scattering::{Scene, Side};
use crate::transport::emission::{sample_emissions, state_sent};
use crate::transport::mis;
use crate::transport::sampler::{Purpose, draw};
use crate::transport::sides::LightSide;
use crate::transport::splat::pixel_of;
use crate::transport::tables::connections::{Cargo, ConnectionTable, Segment};
use crate::transport::tables::paths::PathTable;
use crate::transport::{Chunk, Strategy};

/// Connects the start of every light path to the pixel that sees it; emitters without area are
/// not seen. `light_paths` is the number of light paths an iteration. With
/// [`Strategy::Bidirectional`], sensor paths meet the emitters as well, and only those whose images
/// are small are connected.
///
/// From: emit_light_paths. To: trace_connections.
/// Writes: connections. Reads: paths (identity), chunk, scene.
pub fn connect_emission<const N: usize, C: LightSide<N>>(
    connections: &mut ConnectionTable<N>,
    paths: &PathTable<N, C>,
    chunk: &Chunk,
    scene: &Scene<N>,
    light_paths: f32,
    strategy: Strategy,
) {
    connections.clear();
    for row in (0..chunk.slots()).step_by(LANES) {
        let live = LANES.min(chunk.slots() - row);
        let seed = lanes::load_u32(&paths.identity.seed, row);
        let iteration = lanes::load_u32(&paths.identity.iteration, row);
        let lens = draw(seed, iteration, 0, Purpose::LensConnection).map(|u| u.to_array());
        let samples = sample_emissions(&paths.identity, scene, row);
        for (lane, sample) in samples.iter().enumerate().take(live) {
            let competes = strategy == Strategy::Bidirectional;
            let is_left_to_others = competes && scene.glimpses.start_pdf(sample.emitter) == 0.0;
            if !(sample.delta || is_left_to_others) {
                let lens = lens.map(|u| u[lane]);
                let is_polarized = paths.carriers.columns().is_some();
                let of_path = (chunk, row + lane, lens);
                connect(
                    connections,
                    sample,
                    (scene, is_polarized),
                    of_path,
                    (light_paths, competes),
                );
            }
        }
    }
}

/// Connects one point of an emitter, or one direction of the environment; in modes that are
/// polarized, in the state in which it emits.
fn connect<const N: usize>(
    connections: &mut ConnectionTable<N>,
    sample: &EmissionSample<N>,
    (scene, is_polarized): (&Scene<N>, bool),
    (chunk, slot, lens): (&Chunk, usize, [f32; 2]),
    (light_paths, competes): (f32, bool),
) {
    let found = if sample.finite {
        scene.sensor.connect(sample.position, lens)
    } else {
        scene.sensor.connect_infinite(-sample.direction, lens)
    };
    let Some(found) = found else { return };
    let cosine = sample.cosine_seen(found.direction);
    if cosine <= 0.0 {
        return;
    }
    let Some((pixel, share)) = pixel_of(&found, &scene.sensor, chunk, slot, 0) else { return };
    let importance = found.pdf_area / light_paths;
    let weight = match competes {
        true => mis::weight_of_start_connected(sample.start_pdf, cosine, importance),
        false => 1.0,
    };
    let factor = weight * cosine * importance / sample.start_pdf * share;
    let mut value = sample.radiance.map(|radiance| radiance * factor);
    if scene.has_incandescent_lamps() {
        let shares = scene.emissivity(sample.emitter, sample.normal, found.direction);
        value.iter_mut().zip(shares).for_each(|(value, share)| *value *= share);
    }
    let lens = found.lens.to_array();
    let segment = if sample.finite {
        let origin = scene.off_emitter(sample, found.direction);
        let inside = scene.medium_at_emitter(sample, found.direction);
        Segment::between(Side::Light, origin.to_array(), lens, inside)
    } else {
        let direction = (-found.direction).to_array();
        let inside = scene.medium_at_sensor(found.lens);
        Segment { origin: lens, direction, t_max: f32::INFINITY, inside, from: Side::Sensor }
    };
    let cargo = Cargo { value, weight };
    let sent = || state_sent(scene, sample.emitter, (sample.position, found.direction));
    match is_polarized.then(sent).flatten() {
        Some(state) => connections.push_polarized(segment, cargo, pixel, state),
        None => connections.push(segment, cargo, pixel),
    }
}
