//! Which ways to one and the same path share its light.

/// How what a path brings shares the light with other ways to the same path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strategy {
    /// Emission met by chance and next-event estimation (power heuristic).
    Unidirectional,
    /// All bidirectional strategies (balance heuristic).
    Bidirectional,
    /// Photons merged: of more than one segment, which nothing competes with, and beside them
    /// emission met by chance and next-event estimation as in [`Strategy::Unidirectional`].
    Merging,
}

impl Strategy {
    /// Whether paths connect to lamps between their vertices, too.
    pub fn connects_flights(self) -> bool {
        match self {
            Self::Unidirectional | Self::Merging => true,
            // Light paths start where these lead.
            Self::Bidirectional => false,
        }
    }
}
