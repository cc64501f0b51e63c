//! What the sensor has measured in this chunk.

/// Stokes values per slot: `components` (1 or 4) by wavelength. What belongs to a slot lies
/// together, as slots are added to one at a time and in any order.
pub struct Measured<const N: usize> {
    components: usize,
    values: Vec<[f32; N]>,
}

impl<const N: usize> Measured<N> {
    /// A table for `capacity` slots.
    pub fn new(capacity: usize, components: usize) -> Self {
        Self { components, values: vec![[0.0; N]; capacity * components] }
    }

    /// Stokes components of a slot: 1 or 4.
    pub fn components(&self) -> usize {
        self.components
    }

    /// Sets everything to zero.
    pub fn clear(&mut self) {
        self.values.fill([0.0; N]);
    }

    /// The values of a slot, component by component.
    #[inline(always)]
    pub fn at(&mut self, slot: usize) -> &mut [[f32; N]] {
        &mut self.values[slot * self.components..][..self.components]
    }

    /// The intensity of a slot, by wavelength.
    #[inline(always)]
    pub fn intensity(&self, slot: usize) -> &[f32; N] {
        &self.values[slot * self.components]
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
