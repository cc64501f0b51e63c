//! What the sensor has measured in this chunk.

use wide::f32x4;

use crate::math::{F32s, LANES};
use crate::polarization::Stokes;

/// What sensor paths have measured, slot by slot. What belongs to a slot lies together, as slots
/// are added to one at a time and in any order.
///
/// A path's first depolarizer fixes the state of all light that it measures behind: `T D` is
/// `(T e0)(d e0^T)`, whose column `T e0` is the same for whatever comes. So behind it light is
/// added as intensity, as in scalar mode, and the column is applied once, when the slot is read.
#[derive(Clone, Debug)]
pub struct Measured<const N: usize> {
    components: usize,
    /// Intensity: on films of intensities all that is measured, else what is behind the first
    /// depolarizer.
    intensity: Vec<[f32; N]>,
    /// What of the other parts of a slot is in use.
    parts: Vec<Parts>,
    /// Stokes vectors measured before the first depolarizer, by wavelength; none on films of
    /// intensities.
    stokes: Vec<[[f32; 4]; N]>,
    /// The Stokes vectors on the film, by wavelength, of light behind the first depolarizer, over
    /// S0; likewise.
    column: Vec<[[f32; 4]; N]>,
    /// See [`Measured::brought`].
    brought: Vec<f32>,
}

/// What of a slot holds anything but its intensity; where it does not, it was never written.
#[derive(Clone, Copy, Debug, Default)]
struct Parts {
    stokes: bool,
    column: bool,
}

/// What a slot has measured on a Stokes film.
pub enum Reading<'a, const N: usize> {
    /// Unpolarized light.
    Intensity(&'a [f32; N]),
    /// S0..S3 by wavelength.
    Stokes([f32x4; N]),
}

impl<const N: usize> Measured<N> {
    /// A table for `capacity` slots.
    pub fn new(capacity: usize, components: usize) -> Self {
        let polarized = if components == 1 { 0 } else { capacity };
        Self {
            components,
            intensity: vec![[0.0; N]; capacity],
            parts: vec![Parts::default(); polarized],
            stokes: vec![[[0.0; 4]; N]; polarized],
            column: vec![[[0.0; 4]; N]; polarized],
            brought: vec![0.0; capacity],
        }
    }

    /// Stokes components of a slot: 1 or 4.
    pub fn components(&self) -> usize {
        self.components
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.intensity.fill([0.0; N]);
        self.parts.fill(Parts::default());
        self.brought.fill(0.0);
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

    /// Adds intensity to a slot: of a film of intensities, or behind the first depolarizer.
    #[inline(always)]
    pub fn add_intensity(&mut self, slot: usize, value: [f32; N]) {
        for (sum, value) in self.intensity[slot].iter_mut().zip(&value) {
            *sum += value;
        }
    }

    /// Adds the Stokes vectors of the wavelengths to a slot of a Stokes film, before the first
    /// depolarizer.
    #[inline(always)]
    pub fn add_stokes(&mut self, slot: usize, stokes: impl Fn(usize) -> Stokes<f32>) {
        let parts = &mut self.parts[slot];
        let sums = &mut self.stokes[slot];
        if !parts.stokes {
            parts.stokes = true;
            *sums = [[0.0; 4]; N];
        }
        for (n, sums) in sums.iter_mut().enumerate() {
            sums.iter_mut().zip(stokes(n).0).for_each(|(sum, value)| *sum += value);
        }
    }

    /// Multiplies all that a slot has measured.
    pub fn weigh(&mut self, slot: usize, weight: f32) {
        self.intensity[slot].iter_mut().for_each(|value| *value *= weight);
        if self.parts.get(slot).is_some_and(|parts| parts.stokes) {
            let values = self.stokes[slot].as_flattened_mut();
            values.iter_mut().for_each(|value| *value *= weight);
        }
    }

    /// Says in what states the light behind their first depolarizers reaches the film, at one
    /// wavelength of up to eight slots: S0..S3 over S0.
    #[inline(always)]
    pub fn set_columns(&mut self, slots: &[u32], wavelength: usize, Stokes(state): Stokes<F32s>) {
        let state = state.map(F32s::to_array);
        let of_four = |first: usize| {
            let [s0, s1, s2, s3] = &state;
            let lanes = |of: &[f32; LANES]| {
                f32x4::new([of[first], of[first + 1], of[first + 2], of[first + 3]])
            };
            f32x4::transpose([lanes(s0), lanes(s1), lanes(s2), lanes(s3)])
        };
        let [[a, b, c, d], [e, f, g, h]] = [of_four(0), of_four(4)];
        for (slot, column) in slots.iter().zip([a, b, c, d, e, f, g, h]) {
            let slot = *slot as usize;
            self.column[slot][wavelength] = column.to_array();
            self.parts[slot].column = true;
        }
    }

    /// The intensities of the first `slots` slots: all that a film of intensities has measured.
    pub fn intensities_mut(&mut self, slots: usize) -> &mut [f32] {
        self.intensity[..slots].as_flattened_mut()
    }

    /// The intensities of a slot, all that a film of intensities has measured there.
    #[inline(always)]
    pub fn intensity(&self, slot: usize) -> &[f32; N] {
        &self.intensity[slot]
    }

    /// What a slot of a Stokes film has measured.
    #[inline(always)]
    pub fn reading(&self, slot: usize) -> Reading<'_, N> {
        let (parts, intensity) = (self.parts[slot], &self.intensity[slot]);
        if !(parts.stokes | parts.column) {
            return Reading::Intensity(intensity);
        }
        let mut states = [f32x4::ZERO; N];
        for (n, (state, &value)) in states.iter_mut().zip(intensity).enumerate() {
            *state = match parts.column {
                true => f32x4::new(self.column[slot][n]) * f32x4::splat(value),
                false => f32x4::new([value, 0.0, 0.0, 0.0]),
            };
        }
        if parts.stokes {
            for (state, more) in states.iter_mut().zip(&self.stokes[slot]) {
                *state += f32x4::new(*more);
            }
        }
        Reading::Stokes(states)
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
    /// S0..S3 by wavelength, in the film's frame.
    pub stokes: [[f32; 4]; N],
}

/// Unpolarized light on the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splat<const N: usize> {
    /// Index of the pixel.
    pub pixel: u32,
    /// Intensity.
    pub value: [f32; N],
}
