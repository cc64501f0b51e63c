//! What paths meet, and what that does to polarization: all that tells the loops of the stages
//! apart.

use super::medium::Medium;
use super::phase::{Scatters, for_phase};
use super::surface::SurfaceKind;
use crate::math::F32s;
use crate::polarization::{Block, SpheroidBlock};

/// What a path has met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Met {
    /// A surface of some kind.
    Surface(SurfaceKind),
    /// A particle of the medium in this row of the scene's media.
    Medium(u32),
}

impl Met {
    /// Its place among the scene's events.
    #[inline(always)]
    pub fn event(self) -> usize {
        match self {
            Self::Surface(kind) => kind.event(),
            Self::Medium(row) => SurfaceKind::EVENTS + row as usize,
        }
    }
}

/// How many elements a Mueller kernel has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// One: what leaves is unpolarized whatever arrives.
    Depolarizer,
    /// a, c and s.
    Block,
    /// a, b, c, d and s.
    Spheroid,
    /// Sixteen.
    Dense,
}

/// A kernel's elements over M00, eight rows at a time.
pub trait Elements: Copy {
    /// How many there are.
    const FORM: Form;

    /// All that there may be.
    fn spheroid(self) -> SpheroidBlock<F32s>;
}

/// All elements of kernels at every wavelength.
#[inline(always)]
pub fn spheroids<K: Elements, const N: usize>(kernels: &[K; N]) -> [SpheroidBlock<F32s>; N] {
    let mut spheroids = [Depolarizer.spheroid(); N];
    for (spheroid, kernel) in spheroids.iter_mut().zip(kernels) {
        *spheroid = kernel.spheroid();
    }
    spheroids
}

/// The kernel without elements: what leaves is unpolarized.
#[derive(Clone, Copy, Debug)]
pub struct Depolarizer;

impl Elements for Depolarizer {
    const FORM: Form = Form::Depolarizer;

    #[inline(always)]
    fn spheroid(self) -> SpheroidBlock<F32s> {
        let zero = F32s::splat(0.0);
        SpheroidBlock { a: zero, b: zero, c: zero, d: zero, s: zero }
    }
}

impl Elements for Block<F32s> {
    const FORM: Form = Form::Block;

    #[inline(always)]
    fn spheroid(self) -> SpheroidBlock<F32s> {
        let Self { a, c, s } = self;
        SpheroidBlock { a, b: F32s::splat(1.0), c, d: c, s }
    }
}

impl Elements for SpheroidBlock<F32s> {
    const FORM: Form = Form::Spheroid;

    #[inline(always)]
    fn spheroid(self) -> Self {
        self
    }
}

/// A kind of event: the rows that meet it go through the same loops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event {
    /// What is met.
    pub met: Met,
    /// Its kernel.
    pub form: Form,
    /// Whether the kernel is the same at all wavelengths, and stored once.
    pub achromatic: bool,
}

/// The place of the event at which paths end among the scene's events.
pub const END: usize = 0;

impl Event {
    /// The channel of the kernel columns that holds a wavelength's coefficients.
    #[inline(always)]
    pub fn channel(&self, wavelength: usize) -> usize {
        if self.achromatic { 0 } else { wavelength }
    }

    /// Whether light that vertices keep, as photons or to be connected to, leaves them polarized.
    #[inline(always)]
    pub fn keeps_polarized(&self) -> bool {
        self.connects() && self.form != Form::Depolarizer
    }

    /// Whether vertices of this kind can be connected to: all but those that leave light a
    /// single way.
    #[inline(always)]
    pub fn connects(&self) -> bool {
        match self.met {
            Met::Surface(kind) => kind.connects(),
            Met::Medium(_) => true,
        }
    }
}

/// All events of a scene with these media: [`END`], those at surfaces, and one for every medium.
pub fn events<const N: usize>(media: &[Medium<N>]) -> Vec<Event> {
    let in_media = media.iter().zip(0..).map(|(medium, row)| {
        let (form, achromatic) = for_phase!(&medium.phase, phase => phase.kernel());
        Event { met: Met::Medium(row), form, achromatic }
    });
    SurfaceKind::events().chain(in_media).collect()
}
