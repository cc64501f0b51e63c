//! How what lamps emit is polarized, and hangs on its direction, at the wavelengths of a render.

use glam::Vec3;

/// The states of what lamps emit, in the order of these (`Optics::lamps`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EmittedStates<const N: usize> {
    /// None of a lamp that is unpolarized; empty where all are.
    pub of_lamps: Vec<Option<LampState<N>>>,
    /// Whether any is another at other wavelengths.
    pub is_chromatic: bool,
    /// Whether a picture says how the environment's light is polarized.
    pub by_picture: bool,
    /// Whether any is incandescent.
    pub has_incandescent: bool,
}

/// The state of what a lamp emits.
#[derive(Clone, Debug, PartialEq)]
pub enum LampState<const N: usize> {
    /// The same in all directions.
    Same {
        /// S1, S2 and S3 over S0 at every wavelength: of light along the unit vector k, in the
        /// frame (x, k cross x, k).
        stokes: [[f32; 3]; N],
        /// What x is along, less what of it is along k, and what takes its place where the two
        /// are parallel; unit vectors. Of lamps that are surfaces those of the surface.
        axes: Option<[Vec3; 2]>,
    },
    /// Light from within comes out of a smooth surface by what that does not reflect, as much and
    /// in such a state: the lamp says how much a black body would emit.
    Incandescent,
}

impl<const N: usize> EmittedStates<N> {
    /// Whether any lamp is polarized.
    pub fn any(&self) -> bool {
        self.by_picture || !self.of_lamps.is_empty()
    }

    /// That of a lamp, if it is polarized.
    #[inline(always)]
    pub fn of(&self, lamp: u32) -> Option<&LampState<N>> {
        self.of_lamps.get(lamp as usize)?.as_ref()
    }
}
