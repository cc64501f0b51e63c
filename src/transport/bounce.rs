//! Where on which path events happen.

use std::ops::Range;

use crate::geometry::SurfaceColumns;
use crate::scattering::{Event, Side};

use super::tables::paths::PathTable;

/// A vertex of a walk: what the stages that go on from there are told.
#[derive(Clone, Copy, Debug)]
pub struct Bounce {
    /// Segments up to this vertex.
    pub path_length: u32,
    /// Which way the path is traced.
    pub side: Side,
    /// What directions are drawn by.
    pub sampling: Sampling,
}

/// What the directions of polarized paths are drawn by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sampling {
    /// Where polarization piles up, in media and at smooth interfaces: what the light that paths
    /// carry, or accept, does.
    #[default]
    Stokes,
    /// What unpolarized light would do: all modes trace the same paths.
    Intensity,
}

impl Sampling {
    /// All, the default first.
    pub const ALL: [Self; 2] = [Self::Stokes, Self::Intensity];

    /// What the command line calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stokes => "stokes",
            Self::Intensity => "intensity",
        }
    }
}

/// Rows of a walk's paths that have met the same: what the stages that look for light there, or
/// leave some, are told.
pub struct Arrived<'a, const N: usize, C> {
    /// All paths.
    pub paths: &'a PathTable<N, C>,
    /// The surfaces at which they are.
    pub surfaces: &'a SurfaceColumns,
    /// What the rows have met.
    pub event: Event,
    /// The rows.
    pub rows: Range<usize>,
    /// Their segments so far.
    pub path_length: u32,
}
