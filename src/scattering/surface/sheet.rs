//! Sheets that let light straight on and do anything to its polarization: real polarizers,
//! dispersive retarders, circular polarizers, and what has a given Mueller matrix. The class of
//! dense kernels: no other model pays for it.

use super::element::Axis;
use super::model::{Incidence, Passage, StraightOn, Surface, strongest};
use crate::math::F32s;
use crate::polarization::{Block, Dense};
use crate::scattering::event::Form;
use crate::scene::world::Action;

/// A sheet at every wavelength.
#[derive(Clone, Copy, Debug)]
pub struct Sheet<const N: usize> {
    /// Transmittance of unpolarized light.
    m00: [f32; N],
    /// The Mueller matrices over it, from front to back in the frame of the axis.
    matrices: [Dense<f32>; N],
    /// How the axis lies in the sheet.
    axis: Axis,
}

impl<const N: usize> Sheet<N> {
    /// With the axis `axis_deg` from the surface's `axis_x`.
    pub fn of(axis_deg: f64, action: Action<[f32; N]>) -> Self {
        let mut sheet = Self {
            m00: [0.0; N],
            matrices: [Dense(Block::identity().matrix().map(|row| row.map(|of| of as f32))); N],
            axis: Axis::turned(axis_deg),
        };
        for n in 0..N {
            let matrix = action.matrix(n);
            let m00 = matrix[0][0];
            // What lets nothing through may do anything to it.
            if m00 as f32 > 0.0 {
                sheet.m00[n] = m00 as f32;
                sheet.matrices[n] = Dense(matrix.map(|row| row.map(|of| (of / m00) as f32)));
            }
        }
        sheet
    }
}

impl<const N: usize> Surface for Sheet<N> {
    fn scattered(&self) -> f32 {
        strongest(self.m00)
    }
}

impl<const N: usize> StraightOn<N> for Sheet<N> {
    const ACTS: bool = true;
    const ACHROMATIC: bool = false;
    const FORM: Form = Form::Dense;

    fn matrices(&self) -> [Dense<f32>; N] {
        self.matrices
    }

    #[inline(always)]
    fn pass<const POLARIZED: bool>(at: &Incidence<Self>) -> Passage<N> {
        let axis = match POLARIZED {
            true => Axis::across(at, |model| &model.axis),
            false => at.direction,
        };
        let transmittance = at.models.spectrum(|model| &model.m00);
        let kernels = [Block::identity(); N];
        Passage { transmittance, chance: F32s::splat(1.0), kernels, axis }
    }
}
