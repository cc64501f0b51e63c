//! Where the samples of an iteration lie that neighbors share.

use crate::film::lattice::Shift;
use crate::math::U32s;
use crate::scattering::Sensor;

use super::Chunk;
use super::sampler::{Purpose, Stream, draw, path_seed};

/// The lattice of an iteration of a chunk, the same in all its chunks; none if samples are each
/// pixel's own.
pub fn shift(sensor: &Sensor, chunk: &Chunk, iteration: u32) -> Option<Shift> {
    sensor.shift(|| {
        let [seed, iteration] = [path_seed(chunk.seed, Stream::Film, 0), iteration];
        let [seed, iteration] = [seed, iteration].map(U32s::splat);
        draw(seed, iteration, 0, Purpose::Pixel).map(|numbers| numbers.to_array()[0])
    })
}
