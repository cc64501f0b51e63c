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
