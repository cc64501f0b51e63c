//! The sheet polarizer: straight transmission through a (partial) linear polarizer.

use super::element::Element;
use super::model::{Incidence, Passage, StraightOn, Surface};
use crate::polarization::elements::polarizer_block;

/// A sheet.
#[derive(Clone, Copy, Debug)]
pub struct Polarizer {
    /// Transmittance for unpolarized light.
    m00: f32,
    /// The kernel in the frame of the transmission axis.
    element: Element,
}

impl Polarizer {
    /// With the transmission axis `axis_deg` from the surface's `axis_x`, and the greatest over
    /// the least transmittance; the greatest is 1.
    pub fn of(axis_deg: f64, extinction_ratio: f64) -> Self {
        let (m00, block) = polarizer_block(1.0, extinction_ratio.recip());
        Self { m00: m00 as f32, element: Element::new(block, axis_deg) }
    }
}

impl Surface for Polarizer {
    fn scattered(&self) -> f32 {
        self.m00
    }
}

impl<const N: usize> StraightOn<N> for Polarizer {
    const ACTS: bool = true;

    #[inline(always)]
    fn pass<const POLARIZED: bool>(at: &Incidence<Self>) -> Passage<N> {
        Element::pass::<_, N, POLARIZED>(
            at,
            |model| &model.element,
            at.models.field(|model| model.m00),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polarization::Block;

    #[test]
    fn an_ideal_polarizer_passes_half_the_light() {
        let Polarizer { m00, element } = Polarizer::of(0.0, f64::INFINITY);
        let block = Block { a: 1.0, c: 0.0, s: 0.0 };
        assert_eq!((m00, element.block, element.axis.0), (0.5, block, [1.0, 0.0]));
        let [cos, sin] = Polarizer::of(-30.0, f64::INFINITY).element.axis.0;
        assert!((cos - 0.866_025_4).abs() < 1e-6 && (sin + 0.5).abs() < 1e-6);
    }
}
