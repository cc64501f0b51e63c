//! What absorbs everything. Paths end there.

use super::model::Surface;

/// It has no parameters.
#[derive(Clone, Copy, Debug)]
pub struct Absorber;

impl Absorber {
    /// The only one.
    pub fn of() -> Self {
        Self
    }
}

impl Surface for Absorber {
    fn scattered(&self) -> f32 {
        0.0
    }
}
