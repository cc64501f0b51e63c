//! What the slots of a chunk add to the pixels about them, where neighbors share samples.
//!
//! Samples are added up by blocks of the film that no tile divides, each iteration of a block by
//! itself: what a pixel gets from a block has the same bits whatever else of the film is rendered,
//! and in how many tiles.

use wide::f32x4;

use crate::film::lattice::Shift;
use crate::math::exact::ExactSums;
use crate::scattering::Sensor;
use crate::transport::Chunk;
use crate::transport::chunk::{TILE, aligned_tiles};
use crate::transport::shift::shift;
use crate::transport::tables::measured::{Measured, Reading};

use super::sets::Projection;
use super::sums::{are_finite, are_states_finite};

/// A table of pixels, row by row, of so many values each.
#[derive(Default)]
struct Table {
    width: usize,
    height: usize,
    stride: usize,
    values: Vec<f32>,
}

impl Table {
    /// Becomes a table of zeros.
    fn clear(&mut self, [width, height]: [usize; 2], stride: usize) {
        (self.width, self.height, self.stride) = (width, height, stride);
        self.values.clear();
        self.values.resize(width * height * stride, 0.0);
    }

    fn row(&self, y: usize) -> &[f32] {
        let length = self.width * self.stride;
        &self.values[y * length..][..length]
    }

    fn row_mut(&mut self, y: usize) -> &mut [f32] {
        let length = self.width * self.stride;
        &mut self.values[y * length..][..length]
    }

    fn pixel_mut(&mut self, x: usize, y: usize) -> &mut [f32] {
        let first = (y * self.width + x) * self.stride;
        &mut self.values[first..][..self.stride]
    }
}

/// What blocks are added up in.
#[derive(Default)]
pub struct Blocks {
    samples: Table,
    along_rows: Table,
    spread: Table,
}

/// The channels of the film that some wavelengths reach.
struct Reached {
    components: usize,
    /// How many the film has.
    channels: usize,
    /// Those that are reached, in their order, if that is not all.
    some: Option<Vec<usize>>,
}

impl Reached {
    fn new<const N: usize>(projection: &Projection<N>, components: usize) -> Self {
        let (channels, some) = match projection {
            Projection::Columns => (N, None),
            Projection::Shares(shares) => {
                let mut some: Vec<usize> = shares.taken.iter().map(|it| it.channel).collect();
                some.sort_unstable();
                some.dedup();
                (shares.channels, (some.len() < shares.channels).then_some(some))
            }
        };
        Self { components, channels, some }
    }

    /// Values that a pixel gets.
    fn stride(&self) -> usize {
        self.components * self.some.as_ref().map_or(self.channels, Vec::len)
    }

    /// Where a channel is among these.
    fn place(&self, channel: usize) -> usize {
        self.some.as_ref().map_or(channel, |some| some.partition_point(|&it| it < channel))
    }

    /// Adds a row of pixels to the sums from that at `pixel` on.
    fn add(&self, sums: &mut ExactSums, pixel: usize, row: &[f32]) {
        let (components, of_pixel) = (self.components, self.components * self.channels);
        let first = pixel * of_pixel;
        let Some(some) = &self.some else { return sums.add(first, row) };
        if some.is_empty() {
            return;
        }
        for (index, values) in row.chunks_exact(self.stride()).enumerate() {
            for (channel, values) in some.iter().zip(values.chunks_exact(components)) {
                sums.add(first + index * of_pixel + channel * components, values);
            }
        }
    }
}

/// Adds what the slots of a chunk have measured to the pixels of its tile and those about it, as
/// far as samples reach; returns how many slots are left out as not finite. None, and nothing is
/// done, where samples are each pixel's own.
pub fn share_measured<const N: usize>(
    (sums, blocks): (&mut ExactSums, &mut Blocks),
    measured: &Measured<N>,
    projection: &Projection<N>,
    (chunk, sensor): (&Chunk, &Sensor),
) -> Option<u64> {
    let reach = sensor.layout.reach() as usize;
    let reached = Reached::new(projection, measured.components());
    let width = chunk.width as usize + 2 * reach;
    let mut not_finite = 0;
    for iteration in 0..chunk.iterations {
        let shift = shift(sensor, chunk, chunk.first_iteration + iteration)?;
        let pixels = width * (chunk.height as usize + 2 * reach);
        sums.resize(pixels * reached.channels * reached.components);
        let first_slot = iteration as usize * chunk.pixels();
        for block in aligned_tiles(([chunk.x, chunk.y], [chunk.width, chunk.height]), TILE) {
            let [x, y] = [block[0] - chunk.x, block[1] - chunk.y].map(|at| at as usize);
            let slot = |column, row| first_slot + (y + row) * chunk.width as usize + x + column;
            let size = [block[2], block[3]].map(|side| side as usize);
            blocks.samples.clear(size, reached.stride());
            let from = (projection, &reached);
            not_finite += read_block(&mut blocks.samples, measured, from, slot);
            blocks.spread(&shift, reach);
            for row in 0..blocks.spread.height {
                reached.add(sums, (y + row) * width + x, blocks.spread.row(row));
            }
        }
    }
    Some(not_finite)
}

/// Fills a block with what the channels of the film take of its slots.
fn read_block<const N: usize>(
    block: &mut Table,
    measured: &Measured<N>,
    projection: (&Projection<N>, &Reached),
    slot: impl Fn(usize, usize) -> usize,
) -> u64 {
    let mut not_finite = 0;
    for y in 0..block.height {
        for x in 0..block.width {
            let slot = slot(x, y);
            let values = block.pixel_mut(x, y);
            let is_read = match measured.components() {
                1 => read_intensity(values, measured.intensity(slot), projection),
                _ => match measured.reading(slot) {
                    Reading::Intensity(intensity) => read_intensity(values, intensity, projection),
                    Reading::Stokes(states) => read_stokes(values, &states, projection),
                },
            };
            not_finite += u64::from(!is_read);
        }
    }
    not_finite
}

/// Reads a slot of intensities, unless it is not finite: false.
fn read_intensity<const N: usize>(
    values: &mut [f32],
    intensity: &[f32; N],
    (projection, reached): (&Projection<N>, &Reached),
) -> bool {
    let is_finite = are_finite(intensity);
    match projection {
        _ if !is_finite => {}
        Projection::Columns => {
            let firsts = values.iter_mut().step_by(reached.components);
            firsts.zip(intensity).for_each(|(value, intensity)| *value = *intensity);
        }
        Projection::Shares(shares) => {
            for taken in &shares.taken {
                let place = reached.place(taken.channel) * reached.components;
                values[place] += taken.of(intensity);
            }
        }
    }
    is_finite
}

/// Reads a slot of Stokes vectors, unless it is not finite: false.
fn read_stokes<const N: usize>(
    values: &mut [f32],
    states: &[f32x4; N],
    (projection, reached): (&Projection<N>, &Reached),
) -> bool {
    let (channels, _) = values.as_chunks_mut::<4>();
    let is_finite = are_states_finite(states);
    match projection {
        _ if !is_finite => {}
        Projection::Columns => {
            channels.iter_mut().zip(states).for_each(|(value, state)| *value = state.to_array());
        }
        Projection::Shares(shares) => {
            for taken in &shares.taken {
                let channel = &mut channels[reached.place(taken.channel)];
                *channel = (f32x4::new(*channel) + taken.of_each(states)).to_array();
            }
        }
    }
    is_finite
}

impl Blocks {
    /// Spreads the samples over the pixels that they count for: along rows, then along columns.
    fn spread(&mut self, shift: &Shift, reach: usize) {
        let Self { samples, along_rows, spread } = self;
        let [of_x, of_y] = &shift.weights;
        let stride = samples.stride;
        along_rows.clear([samples.width + 2 * reach, samples.height], stride);
        for y in 0..samples.height {
            let from = samples.row(y);
            for (pixel, weight) in of_x.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
                let to = &mut along_rows.row_mut(y)[pixel * stride..][..from.len()];
                add_weighed(to, from, *weight);
            }
        }
        spread.clear([along_rows.width, samples.height + 2 * reach], stride);
        for y in 0..samples.height {
            let from = along_rows.row(y);
            for (pixel, weight) in of_y.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
                add_weighed(spread.row_mut(y + pixel), from, *weight);
            }
        }
    }
}

fn add_weighed(to: &mut [f32], from: &[f32], weight: f32) {
    for (to, from) in to.iter_mut().zip(from) {
        *to += weight * from;
    }
}
