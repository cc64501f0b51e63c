//! What the sensor has measured in this chunk.

use super::{Channels, channels};

/// Stokes values per slot: `components` (1 or 4) by wavelength.
pub struct Measured<const N: usize> {
    /// One group of columns per Stokes component.
    pub stokes: Vec<Channels<N>>,
}

impl<const N: usize> Measured<N> {
    /// A table for `capacity` slots.
    pub fn new(capacity: usize, components: usize) -> Self {
        Self { stokes: (0..components).map(|_| channels(capacity)).collect() }
    }

    /// Sets everything to zero.
    pub fn clear(&mut self) {
        for column in self.stokes.iter_mut().flatten() {
            column.fill(0.0);
        }
    }

    /// Adds intensity to a slot.
    #[inline(always)]
    pub fn add_intensity(&mut self, slot: usize, value: [f32; N]) {
        for (column, value) in self.stokes[0].iter_mut().zip(&value) {
            column[slot] += value;
        }
    }
}

/// Light that reached the film by a connection to the sensor, after a depolarizer or from an
/// emitter: unpolarized.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splat<const N: usize> {
    /// Index of the pixel.
    pub pixel: u32,
    /// Intensity.
    pub value: [f32; N],
}
