//! What light goes straight on through: models that let it, and holes.

use super::{Material, SurfaceKind};

/// What light goes straight on through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crossed {
    /// A model that lets it.
    Model(SurfaceKind),
    /// Holes in what is of any other model.
    Holes,
}

impl Crossed {
    /// Whether it changes light at all.
    #[inline(always)]
    pub const fn acts(self) -> bool {
        match self {
            Self::Model(kind) => kind.acts(),
            Self::Holes => true,
        }
    }

    /// Whether paths may be scattered there instead.
    #[inline(always)]
    pub const fn scatters(self) -> bool {
        match self {
            Self::Model(kind) => kind.scatters(),
            Self::Holes => true,
        }
    }
}

impl Material {
    /// What light goes straight on through, if it does.
    #[inline(always)]
    pub const fn crossed(&self) -> Option<Crossed> {
        match (self.kind.is_straight_on(), self.has_holes) {
            (true, _) => Some(Crossed::Model(self.kind)),
            (false, true) => Some(Crossed::Holes),
            (false, false) => None,
        }
    }

    /// Whether paths and connections go straight on through it, if only by chance.
    #[inline(always)]
    pub const fn is_straight_on(&self) -> bool {
        self.has_holes || self.kind.is_straight_on()
    }
}
