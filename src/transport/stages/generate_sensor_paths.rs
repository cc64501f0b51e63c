//! Starts one sensor path a slot, through a random point of its pixel's filter, or through that of
//! its pixel where neighbors share samples.

use crate::math::{F32s, LANES, Vector, lanes};
use crate::polarization::film_axis;
use crate::scattering::Scene;
use crate::transport::Chunk;
use crate::transport::mis::PartialWeights;
use crate::transport::sampler::{Purpose, Stream, draw, path_seed};
use crate::transport::shift::shift;
use crate::transport::sides::SensorSide;
use crate::transport::tables::paths::PathTable;

/// Starts the sensor paths of a chunk. `light_paths` is the number of light paths an iteration,
/// what connections to the sensor are weighed by (0: there are none), `components` how many Stokes
/// components the film has, which behind an analyzer is one.
///
/// From: nothing. To: trace_closest.
/// Writes: paths. Reads: chunk, scene.
pub fn generate_sensor_paths<const N: usize, C: SensorSide<N>>(
    paths: &mut PathTable<N, C>,
    chunk: &Chunk,
    scene: &Scene<N>,
    light_paths: f32,
    components: usize,
) {
    let slots = chunk.slots();
    let sensor = &scene.sensor;
    paths.len = slots;
    if let Some(carriers) = paths.carriers.columns_mut() {
        match sensor.analyzer() {
            None => carriers.start_at_film(slots, components),
            Some(analyzer) => carriers.start_at_analyzer(slots, analyzer.state()),
        }
    }
    for channel in &mut paths.beta {
        channel[..slots].fill(1.0);
    }
    paths.mis.pdf_w[..slots].fill(f32::INFINITY);
    if paths.media.present() {
        paths.media.start(slots);
    }
    let shifts: Option<Vec<[f32; 2]>> = (0..chunk.iterations)
        .map(|iteration| Some(shift(sensor, chunk, chunk.first_iteration + iteration)?.place))
        .collect();
    let reach = sensor.layout.reach() as f32;
    let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
    for row in (0..slots).step_by(LANES) {
        let end = slots.min(row + LANES);
        for slot in row..end {
            let (column, line, iteration) = chunk.place(slot);
            (x[slot - row], y[slot - row]) = (column as f32 - reach, line as f32 - reach);
            if let Some(shifts) = &shifts {
                let [right, down] = shifts[(iteration - chunk.first_iteration) as usize];
                (x[slot - row], y[slot - row]) = (x[slot - row] + right, y[slot - row] + down);
            }
            paths.identity.slot[slot] = slot as u32;
            paths.identity.iteration[slot] = iteration;
            paths.identity.seed[slot] =
                path_seed(chunk.seed, Stream::Sensor, sensor.path_of([column, line]));
        }
        let seed = lanes::load_u32(&paths.identity.seed, row);
        let iteration = lanes::load_u32(&paths.identity.iteration, row);
        let film = [lanes::load(&x, 0), lanes::load(&y, 0)];
        let film = match shifts {
            Some(_) => film,
            None => sensor.points(film, draw(seed, iteration, 0, Purpose::Pixel)),
        };
        let (origin, direction, pdf) =
            sensor.rays(film, || draw(seed, iteration, 0, Purpose::Lens));
        origin.store(&mut paths.rays.origin, row, slots);
        direction.store(&mut paths.rays.direction, row, slots);
        if let (Some(_), Some(carriers)) = (sensor.analyzer(), paths.carriers.columns_mut()) {
            let axis = film_axis(direction, Vector::splat(sensor.up()));
            axis.store(&mut carriers.axis, row, slots);
        }
        if paths.media.present() {
            let origins = origin.to_rows();
            for (inside, origin) in paths.media.inside[row..end].iter_mut().zip(origins) {
                *inside = scene.medium_at_sensor(origin.into());
            }
        }
        let weights = PartialWeights::from_sensor(pdf, F32s::splat(light_paths));
        paths.mis.store(row, slots, weights);
    }
}
