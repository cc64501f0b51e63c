//! What paths meet, and what that does to polarization: all that tells the loops of the stages
//! apart.

use crate::scene::baked::{MaterialKind, Optics, Phase};

/// What a path has met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Met {
    /// A surface of some kind.
    Surface(MaterialKind),
    /// A particle of the medium in this row of the scene's media.
    Medium(u32),
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

/// Events at surfaces, in the order of the rows that meet them, specular ones first; media follow.
const SURFACES: [Event; 6] = [
    at_surface(MaterialKind::Absorber, Form::Depolarizer),
    at_surface(MaterialKind::Conductor, Form::Block),
    at_surface(MaterialKind::Dielectric, Form::Block),
    at_surface(MaterialKind::Polarizer, Form::Block),
    at_surface(MaterialKind::Retarder, Form::Block),
    at_surface(MaterialKind::Diffuse, Form::Depolarizer),
];

const fn at_surface(kind: MaterialKind, form: Form) -> Event {
    let achromatic = !matches!(kind, MaterialKind::Conductor);
    Event { met: Met::Surface(kind), form, achromatic }
}

impl Event {
    /// The channel of the kernel columns that holds a wavelength's coefficients.
    #[inline(always)]
    pub fn channel(&self, wavelength: usize) -> usize {
        if self.achromatic { 0 } else { wavelength }
    }

    /// Whether vertices of this kind can be connected to: all but those that leave light a
    /// single way.
    #[inline(always)]
    pub fn connects(&self) -> bool {
        matches!(self.met, Met::Surface(MaterialKind::Diffuse) | Met::Medium(_))
    }
}

/// All events of a scene: [`END`], those at surfaces, and one for every medium.
pub fn events<const N: usize>(optics: &Optics<N>) -> Vec<Event> {
    let in_media = optics.media.iter().zip(0..).map(|(medium, row)| {
        let (form, achromatic) = match &medium.phase {
            Phase::HenyeyGreenstein { .. } => (Form::Depolarizer, true),
            Phase::Table(table) if table.spheres => (Form::Block, table.achromatic),
            Phase::Table(table) => (Form::Spheroid, table.achromatic),
        };
        Event { met: Met::Medium(row), form, achromatic }
    });
    SURFACES.into_iter().chain(in_media).collect()
}

/// The place of a kind of material among the events; boundaries of media are never met.
pub fn event_of_kind(kind: MaterialKind) -> usize {
    SURFACES.iter().position(|event| event.met == Met::Surface(kind)).unwrap_or(END)
}

/// The place of a medium among the events.
#[inline(always)]
pub fn event_of_medium(medium: u32) -> usize {
    SURFACES.len() + medium as usize
}
