//! Where on which path events happen.

/// Which way a path is traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Along the light.
    Light,
    /// Against it.
    Sensor,
}

/// A vertex of a walk: what the stages that go on from there are told.
#[derive(Clone, Copy, Debug)]
pub struct Bounce {
    /// Segments up to this vertex.
    pub path_length: u32,
    /// Which way the path is traced.
    pub side: Side,
}
