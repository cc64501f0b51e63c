//! Connects points of emitters straight to the sensor: what is seen directly, where no sensor
//! path is traced.

use crate::math::{LANES, lanes};
use crate::scattering::Scene;
use crate::scattering::emission::sample_emission;
use crate::transport::Chunk;
use crate::transport::sampler::{Purpose, draw};
use crate::transport::tables::connections::ConnectionTable;
use crate::transport::tables::paths::PathTable;

use super::connect_to_emitters::segment;
use super::emit_light_paths::leave;

/// Connects the start of every light path to the pixel that sees it; emitters without area are
/// not seen. `light_paths` is the number of light paths an iteration.
///
/// From: emit_light_paths. To: trace_connections, splat_connections.
/// Writes: connections. Reads: paths.identity, chunk, scene.
pub fn connect_emission<const N: usize, C>(
    connections: &mut ConnectionTable<N>,
    paths: &PathTable<N, C>,
    chunk: &Chunk,
    scene: &Scene<N>,
    light_paths: f32,
) {
    connections.clear();
    for row in (0..chunk.slots()).step_by(LANES) {
        let seed = lanes::load_u32(&paths.identity.seed, row);
        let iteration = lanes::load_u32(&paths.identity.iteration, row);
        let numbers = |purpose| draw(seed, iteration, 0, purpose).map(|u| u.to_array());
        let [choice, _] = numbers(Purpose::EmitterOfPath);
        let position = numbers(Purpose::EmissionPosition);
        let direction = numbers(Purpose::EmissionDirection);
        let lens = numbers(Purpose::LensConnection);
        for lane in 0..LANES.min(chunk.slots() - row) {
            let of_lane = |numbers: [[f32; LANES]; 2]| numbers.map(|u| u[lane]);
            let sample =
                sample_emission(scene, choice[lane], of_lane(position), of_lane(direction));
            if sample.delta {
                continue;
            }
            let lens = of_lane(lens);
            let found = if sample.finite {
                scene.sensor.connect(sample.position, lens)
            } else {
                scene.sensor.connect_infinite(-sample.direction, lens)
            };
            let Some(found) = found else { continue };
            let cosine = if !sample.finite {
                1.0
            } else if sample.two_sided {
                found.direction.dot(sample.normal).abs()
            } else {
                found.direction.dot(sample.normal)
            };
            if cosine <= 0.0 {
                continue;
            }
            let factor = cosine * found.pdf_area / (sample.direct_pdf * light_paths);
            let value = sample.radiance.map(|radiance| radiance * factor);
            let lens = found.lens.to_array();
            let (origin, towards, t_max) = if sample.finite {
                let origin = leave(sample.position, sample.normal, found.direction, scene.reach);
                let (towards, t_max) = segment(origin.to_array(), lens);
                (origin.to_array(), towards, t_max)
            } else {
                (lens, found.direction.to_array().map(|x| -x), f32::INFINITY)
            };
            connections.push(origin, towards, t_max, value, found.pixel);
        }
    }
}
