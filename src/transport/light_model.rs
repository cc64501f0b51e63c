//! Scalar or polarized: the one choice that decides which carriers exist, made once at the top
//! and compiled into every stage.

use super::sides::{LightSide, SensorSide};
use super::tables::carriers::{LightCarriers, SensorCarriers};

/// What light is made of.
pub trait LightModel<const N: usize>: Send + Sync + 'static {
    /// Whether Mueller kernels are evaluated.
    const POLARIZED: bool;
    /// Carriers of light paths.
    type Light: LightSide<N> + Send;
    /// Carriers of sensor paths.
    type Sensor: SensorSide<N> + Send;
}

/// Light without polarization.
pub struct Scalar;

/// Stokes vectors, and Mueller matrices between them.
pub struct Polarized;

impl<const N: usize> LightModel<N> for Scalar {
    const POLARIZED: bool = false;
    type Light = ();
    type Sensor = ();
}

impl<const N: usize> LightModel<N> for Polarized {
    const POLARIZED: bool = true;
    type Light = LightCarriers<N>;
    type Sensor = SensorCarriers<N>;
}
