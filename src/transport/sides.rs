//! The two sides of the transport as stages see them: columns of carriers in polarized mode, and
//! nothing in scalar mode. Which it is, the compiler knows.

use super::tables::carriers::{CarrierTable, LightCarriers, SensorCarriers};

/// The carriers of light paths.
pub trait LightSide<const N: usize>: CarrierTable {
    /// The columns, if the mode has any.
    fn columns(&self) -> Option<&LightCarriers<N>>;

    /// The columns, if the mode has any.
    fn columns_mut(&mut self) -> Option<&mut LightCarriers<N>>;
}

/// The carriers of sensor paths.
pub trait SensorSide<const N: usize>: CarrierTable {
    /// The columns, if the mode has any.
    fn columns(&self) -> Option<&SensorCarriers<N>>;

    /// The columns, if the mode has any.
    fn columns_mut(&mut self) -> Option<&mut SensorCarriers<N>>;
}

impl<const N: usize> LightSide<N> for () {
    #[inline(always)]
    fn columns(&self) -> Option<&LightCarriers<N>> {
        None
    }
    #[inline(always)]
    fn columns_mut(&mut self) -> Option<&mut LightCarriers<N>> {
        None
    }
}

impl<const N: usize> SensorSide<N> for () {
    #[inline(always)]
    fn columns(&self) -> Option<&SensorCarriers<N>> {
        None
    }
    #[inline(always)]
    fn columns_mut(&mut self) -> Option<&mut SensorCarriers<N>> {
        None
    }
}

impl<const N: usize> LightSide<N> for LightCarriers<N> {
    #[inline(always)]
    fn columns(&self) -> Option<&LightCarriers<N>> {
        Some(self)
    }
    #[inline(always)]
    fn columns_mut(&mut self) -> Option<&mut LightCarriers<N>> {
        Some(self)
    }
}

impl<const N: usize> SensorSide<N> for SensorCarriers<N> {
    #[inline(always)]
    fn columns(&self) -> Option<&SensorCarriers<N>> {
        Some(self)
    }
    #[inline(always)]
    fn columns_mut(&mut self) -> Option<&mut SensorCarriers<N>> {
        Some(self)
    }
}
