//! The linear retarder: straight transmission that delays one polarization against the other.

use super::element::Element;
use super::model::{Incidence, Passage, StraightOn, Surface};
use crate::math::F32s;
use crate::polarization::elements::retarder_block;

/// A sheet; it loses no light.
#[derive(Clone, Copy, Debug)]
pub struct Retarder {
    /// The kernel in the frame of the fast axis.
    element: Element,
}

impl Retarder {
    /// With the fast axis `axis_deg` from the surface's `axis_x`.
    pub fn of(axis_deg: f64, retardance_deg: f64) -> Self {
        Self { element: Element::new(retarder_block(retardance_deg), axis_deg) }
    }
}

impl Surface for Retarder {
    fn scattered(&self) -> f32 {
        1.0
    }
}

impl<const N: usize> StraightOn<N> for Retarder {
    const ACTS: bool = true;

    #[inline(always)]
    fn pass<const POLARIZED: bool>(at: &Incidence<Self>) -> Passage<N> {
        Element::pass::<_, N, POLARIZED>(at, |model| &model.element, F32s::splat(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polarization::Block;

    #[test]
    fn a_quarter_wave_is_exact() {
        let Retarder { element } = Retarder::of(45.0, 90.0);
        assert_eq!(element.block, Block { a: 0.0, c: 0.0, s: 1.0 });
        assert!((element.axis.0[0] - element.axis.0[1]).abs() < 1e-7);
    }
}
