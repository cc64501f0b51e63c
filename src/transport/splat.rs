//! Where light that is connected to the sensor counts.

use crate::math::U32s;
use crate::scattering::Sensor;
use crate::scattering::sensor::SensorConnection;

use super::Chunk;
use super::sampler::{Purpose, Stream, draw, path_seed};

/// The pixel that light counts for which the light path of a slot brings to the sensor after
/// `path_length` segments, by its index among those that are rendered, and how much of it
/// ([`Sensor::pixel_of`]); none if no such pixel sees it.
#[inline(always)]
pub fn pixel_of(
    found: &SensorConnection,
    sensor: &Sensor,
    chunk: &Chunk,
    slot: usize,
    path_length: u32,
) -> Option<(u32, f32)> {
    sensor.pixel_of(found.film, || numbers(sensor, chunk, slot, path_length))
}

/// What a pixel is drawn by, of those whose filters reach a point.
#[inline(never)]
fn numbers(sensor: &Sensor, chunk: &Chunk, slot: usize, path_length: u32) -> [f32; 2] {
    let (column, line, iteration) = chunk.place(slot);
    let seed = path_seed(chunk.seed, Stream::Splat, sensor.path_of([column, line]));
    let [seed, iteration] = [seed, iteration].map(U32s::splat);
    draw(seed, iteration, path_length, Purpose::Pixel).map(|numbers| numbers.to_array()[0])
}
