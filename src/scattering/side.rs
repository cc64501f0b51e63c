//! The two sides of the transport.

use crate::math::{F32s, Vector};

/// Which way a path is traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Along the light.
    Light,
    /// Against it.
    Sensor,
}

impl Side {
    /// The directions of the light before and after a turn of a path from `before` to `after`.
    #[inline(always)]
    pub fn along_light(
        self,
        before: Vector<F32s>,
        after: Vector<F32s>,
    ) -> (Vector<F32s>, Vector<F32s>) {
        match self {
            Self::Light => (before, after),
            Self::Sensor => (-after, -before),
        }
    }
}
