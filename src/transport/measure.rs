//! What sensor paths make of the light that they meet: `T R S` (paper, section 4).

use glam::Vec3;

use crate::math::{Vector, lanes};
use crate::polarization::{Arrival, Stokes, film_axis};

use super::sides::SensorSide;
use super::tables::carriers::SensorCarriers;
use super::tables::classes::SensorClass;
use super::tables::measured::Measured;
use super::tables::states::LightState;

/// A direction of light and the film's up, which between them name the frame of fresh rows.
pub type Along = (Vector<f32>, Vec3);

/// Adds unpolarized light of intensity `value` (throughput included) that a row meets; it belongs
/// to a slot.
#[inline(always)]
pub fn measure_unpolarized<const N: usize, C: SensorSide<N>>(
    measured: &mut Measured<N>,
    carriers: &C,
    (row, slot): (usize, usize),
    value: [f32; N],
) {
    match carriers.columns() {
        None => measured.add_intensity(slot, value),
        Some(carriers) => measure_intensity(measured, carriers, (row, slot), value),
    }
}

/// Adds polarized light that a row meets: `light` is relative to the intensity `value`
/// (throughput included) and travels along the direction of `along` into the subpath's end.
#[inline(always)]
pub fn measure_polarized<const N: usize, C: SensorSide<N>>(
    measured: &mut Measured<N>,
    carriers: &C,
    (row, slot): (usize, usize),
    value: [f32; N],
    light: &LightState<N>,
    along: Along,
) {
    match carriers.columns() {
        None => measured.add_intensity(slot, value),
        Some(carriers) => measure_stokes(measured, carriers, (row, slot), value, light, along),
    }
}

#[inline(always)]
fn measure_intensity<const N: usize>(
    measured: &mut Measured<N>,
    carriers: &SensorCarriers<N>,
    (row, slot): (usize, usize),
    value: [f32; N],
) {
    let class = carriers.class[row];
    let x = || lanes::row_of(&carriers.axis, row).into();
    let accepted = |n: usize| value[n] * carriers.load_row(n, row, x()).depolarized();
    match class {
        SensorClass::Fresh => {
            measured.add_stokes(slot, |n| Stokes([value[n], 0.0, 0.0, 0.0]));
        }
        SensorClass::Plain => measured.add_intensity(slot, value),
        SensorClass::Row => measured.add_intensity(slot, std::array::from_fn(accepted)),
        SensorClass::Once | SensorClass::OnceCommon => measured.add_stokes(slot, |n| {
            let event = carriers.load_event(class.channel_of(n), row, x());
            event.depolarized().spread(value[n])
        }),
        SensorClass::Full | SensorClass::Common => measured.add_stokes(slot, |n| {
            let matrix = carriers.load_matrix(class.channel_of(n), row, x());
            matrix.depolarized().spread(value[n])
        }),
    }
}

#[inline(always)]
fn measure_stokes<const N: usize>(
    measured: &mut Measured<N>,
    carriers: &SensorCarriers<N>,
    (row, slot): (usize, usize),
    value: [f32; N],
    light: &LightState<N>,
    (k, film_up): Along,
) {
    let class = carriers.class[row];
    let framed = || {
        let x = lanes::row_of(&carriers.axis, row).into();
        (x, Arrival::between(light.x, x, k))
    };
    match class {
        SensorClass::Fresh => {
            let film_x = film_axis(-k, film_up.to_array().into());
            let light = light.turned(film_x, k);
            measured.add_stokes(slot, |n| light.stokes[n].scaled(value[n]));
        }
        SensorClass::Plain => {
            let accepted = |n: usize| light.at(n).depolarized() * value[n];
            measured.add_intensity(slot, std::array::from_fn(accepted));
        }
        SensorClass::Row => {
            let (x, arrival) = framed();
            let accepted = |n| carriers.load_row(n, row, x).measure(&light.at(n), &arrival);
            measured.add_intensity(slot, std::array::from_fn(|n| accepted(n) * value[n]));
        }
        SensorClass::Once | SensorClass::OnceCommon => {
            let (x, arrival) = framed();
            let event = |n| carriers.load_event(class.channel_of(n), row, x);
            let scaled = |n| event(n).measure(&light.at(n), &arrival).scaled(value[n]);
            measured.add_stokes(slot, scaled);
        }
        SensorClass::Full | SensorClass::Common => {
            let (x, arrival) = framed();
            let matrix = |n| carriers.load_matrix(class.channel_of(n), row, x);
            let scaled = |n| matrix(n).measure(&light.at(n), &arrival).scaled(value[n]);
            measured.add_stokes(slot, scaled);
        }
    }
}
