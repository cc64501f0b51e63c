//! What the sensor has measured in this chunk.

/// Stokes values per slot: `components` (1 or 4) by wavelength. What belongs to a slot lies
/// together, as slots are added to one at a time and in any order.
pub struct Measured<const N: usize> {
    components: usize,
    values: Vec<[f32; N]>,
    /// See [`Measured::brought`].
    brought: Vec<f32>,
}

impl<const N: usize> Measured<N> {
    /// A table for `capacity` slots.
    pub fn new(capacity: usize, components: usize) -> Self {
        let values = vec![[0.0; N]; capacity * components];
        Self { components, values, brought: vec![0.0; capacity] }
    }

    /// Stokes components of a slot: 1 or 4.
    pub fn components(&self) -> usize {
        self.components
    }

    /// Sets everything to zero.
    pub fn clear(&mut self) {
        self.values.fill([0.0; N]);
        self.brought.fill(0.0);
    }

    /// The values of a slot, component by component.
    #[inline(always)]
    pub fn at(&mut self, slot: usize) -> &mut [[f32; N]] {
        &mut self.values[slot * self.components..][..self.components]
    }

    /// What connections that nothing was in the way of have brought a slot at least, at the
    /// wavelength of most, by intensities alone: the same in all modes.
    #[inline(always)]
    pub fn brought(&self, slot: usize) -> f32 {
        self.brought[slot]
    }

    /// Adds to [`Measured::brought`].
    #[inline(always)]
    pub fn add_brought(&mut self, slot: usize, value: f32) {
        self.brought[slot] += value;
    }

    /// Adds intensity to a slot.
    #[inline(always)]
    pub fn add_intensity(&mut self, slot: usize, value: [f32; N]) {
        for (sum, value) in self.values[slot * self.components].iter_mut().zip(&value) {
            *sum += value;
        }
    }

    /// The values of the first `slots` slots: all of a slot, component by component, then the
    /// next.
    pub fn values_mut(&mut self, slots: usize) -> &mut [f32] {
        self.values[..slots * self.components].as_flattened_mut()
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
