//! Nothing but a boundary between media: light goes on as if it were not there, and it counts for
//! no segment of a path.

use super::model::Surface;

/// It has no parameters.
#[derive(Clone, Copy, Debug)]
pub struct Null;

impl Null {
    /// The only one.
    pub fn of() -> Self {
        Self
    }
}

impl Surface for Null {
    fn scattered(&self) -> f32 {
        1.0
    }
}
