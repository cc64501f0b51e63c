//! A vertex of a path, as tests of the algebra write it down.

use sunstone::internals::math::{Real, Vector};
use sunstone::internals::polarization::{Arrival, Block, Departure};

/// A kernel and its frames. Directions are unit vectors along the light's travel, whichever side
/// samples them.
#[derive(Clone, Copy)]
pub struct Vertex<F, K = Block<F>> {
    /// The kernel relative to its `M00`.
    pub kernel: K,
    /// Its reference axis before and after, perpendicular to both directions.
    pub x: Vector<F>,
    /// Direction of the light before.
    pub k_in: Vector<F>,
    /// Direction of the light after.
    pub k_out: Vector<F>,
}

impl<F: Real, K> Vertex<F, K> {
    /// How light whose axis is `x_light` comes here.
    pub fn arrival(&self, x_light: Vector<F>) -> Arrival<F> {
        Arrival::between(x_light, self.x, self.k_in)
    }

    /// How light leaves into a sensor subpath whose axis is `x_sensor`.
    pub fn departure(&self, x_sensor: Vector<F>) -> Departure<F> {
        Departure::between(self.x, x_sensor, self.k_out)
    }
}
