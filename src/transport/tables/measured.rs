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

/// All that reached the film by connections to the sensor.
#[derive(Default)]
pub struct Splats<const N: usize> {
    /// After a depolarizer or from an emitter.
    pub unpolarized: Vec<Splat<N>>,
    /// After a polarizing event.
    pub polarized: Vec<PolarizedSplat<N>>,
}

impl<const N: usize> Splats<N> {
    /// Removes all.
    pub fn clear(&mut self) {
        self.unpolarized.clear();
        self.polarized.clear();
    }

    /// Appends unpolarized light.
    #[inline(always)]
    pub fn push(&mut self, pixel: u32, value: [f32; N]) {
        self.unpolarized.push(Splat { pixel, value });
    }

    /// Takes all of another.
    pub fn append(&mut self, other: &mut Self) {
        self.unpolarized.append(&mut other.unpolarized);
        self.polarized.append(&mut other.polarized);
    }
}

/// Stokes vectors on the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolarizedSplat<const N: usize> {
    /// Index of the pixel.
    pub pixel: u32,
    /// S0..S3 in the film's frame.
    pub stokes: [[f32; N]; 4],
}

/// Unpolarized light on the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splat<const N: usize> {
    /// Index of the pixel.
    pub pixel: u32,
    /// Intensity.
    pub value: [f32; N],
}
