//! Weighs what the slots of a chunk have measured by the filter of their pixels.

use crate::math::{LANES, U32s, lanes};
use crate::scattering::Sensor;
use crate::transport::Chunk;
use crate::transport::sampler::{Purpose, Stream, draw, path_seed};
use crate::transport::tables::measured::Measured;

/// Multiplies each slot by what its sample counts, which is drawn by a filter with negative lobes:
/// by the numbers that put the sample where it is. Other filters leave all as it is.
///
/// From: gather_connections. To: the film.
/// Writes: measured. Reads: chunk, sensor.
pub fn weigh_samples<const N: usize>(measured: &mut Measured<N>, chunk: &Chunk, sensor: &Sensor) {
    let Some(weight) = sensor.weights() else { return };
    for first in (0..chunk.slots()).step_by(LANES) {
        let live = LANES.min(chunk.slots() - first);
        let (mut seeds, mut iterations) = ([0; LANES], [0; LANES]);
        for lane in 0..live {
            let (column, line, iteration) = chunk.place(first + lane);
            let path = sensor.path_of([column, line]);
            seeds[lane] = path_seed(chunk.seed, Stream::Sensor, path);
            iterations[lane] = iteration;
        }
        let numbers = draw(U32s::from(seeds), U32s::from(iterations), 0, Purpose::Pixel);
        let numbers = numbers.map(|numbers| numbers.to_array());
        for lane in 0..live {
            measured.weigh(first + lane, weight(lanes::row_of_lanes(&numbers, lane)));
        }
    }
}
