//! Nothing but a boundary between media: light goes on as if it were not there, and it counts for
//! no segment of a path.

use super::model::{Incidence, Passage, StraightOn, Surface};
use crate::math::F32s;
use crate::polarization::Block;

/// It has no parameters.
#[derive(Clone, Copy, Debug)]
pub struct Null;

impl Null {
    /// The only one.
    pub fn of() -> Self {
        Self
    }
}

impl Surface for Null {
    fn scattered(&self) -> f32 {
        1.0
    }
}

impl<const N: usize> StraightOn<N> for Null {
    const ACTS: bool = false;

    #[inline(always)]
    fn pass<const POLARIZED: bool>(at: &Incidence<Self>) -> Passage<N> {
        let one = F32s::splat(1.0);
        let (kernel, axis) = (Block::identity(), at.direction);
        Passage { transmittance: [one; N], chance: one, kernels: [kernel; N], axis }
    }
}
