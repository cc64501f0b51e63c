//! The Mueller kernels of this bounce's polarizing events.

use super::{Channels, Column, channels, vectors};

/// One sparse block per row, relative to the scalar value M00 that already is in `beta`.
pub struct KernelColumns<const N: usize> {
    /// Diattenuation; only channel 0 for kernels that do not depend on wavelength.
    pub a: Channels<N>,
    /// Cosine-like element of the lower block.
    pub c: Channels<N>,
    /// Sine-like element of the lower block.
    pub s: Channels<N>,
    /// The x axis of the block's frames: perpendicular to the light before and after.
    pub axis: [Column; 3],
}

impl<const N: usize> KernelColumns<N> {
    /// An empty table for `capacity` rows.
    pub fn new(capacity: usize) -> Self {
        Self {
            a: channels(capacity),
            c: channels(capacity),
            s: channels(capacity),
            axis: vectors(capacity),
        }
    }
}
