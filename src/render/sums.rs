//! What the slots of a chunk add to the pixels of its tile.

use wide::f32x4;

use crate::math::exact::ExactSums;
use crate::transport::tables::measured::{Measured, Reading};

use super::sets::{Projection, Shares};

/// Adds the first `slots` slots of a chunk of `pixels` pixels to the values of these, but for those
/// that are not finite; returns how many these are.
pub fn sum_measured<const N: usize>(
    sums: &mut ExactSums,
    measured: &mut Measured<N>,
    projection: &Projection<N>,
    (slots, pixels): (usize, usize),
) -> u64 {
    let slots = (slots, pixels);
    match (projection, measured.components()) {
        (Projection::Columns, 1) => sum_columns(sums, measured, slots),
        (Projection::Columns, 4) => sum_stokes(sums, measured, slots),
        (Projection::Shares(shares), 1) => sum_shares(sums, measured, shares, slots),
        (Projection::Shares(shares), 4) => sum_stokes_shares(sums, measured, shares, slots),
        (_, other) => unreachable!("films have one or four Stokes components, not {other}"),
    }
}

/// Adds intensities whose columns are channels; returns how many slots are left out as not finite.
fn sum_columns<const N: usize>(
    sums: &mut ExactSums,
    measured: &mut Measured<N>,
    (slots, pixels): (usize, usize),
) -> u64 {
    sums.resize(pixels * N);
    let mut not_finite = 0;
    for values in measured.intensities_mut(slots).chunks_exact_mut(pixels * N) {
        if !are_finite(values) {
            for slot in values.chunks_exact_mut(N).filter(|slot| !are_finite(slot)) {
                slot.fill(0.0);
                not_finite += 1;
            }
        }
        sums.add(0, values);
    }
    not_finite
}

/// The same of Stokes vectors.
fn sum_stokes<const N: usize>(
    sums: &mut ExactSums,
    measured: &Measured<N>,
    (slots, pixels): (usize, usize),
) -> u64 {
    sums.resize(pixels * 4 * N);
    sum_readings(measured, (slots, pixels), |pixel, reading| match reading {
        Reading::Intensity(intensity) => {
            for (n, value) in intensity.iter().enumerate() {
                sums.add(4 * (pixel * N + n), &[*value]);
            }
        }
        Reading::Stokes(states) => {
            for (n, state) in states.iter().enumerate() {
                sums.add_four(4 * (pixel * N + n), *state);
            }
        }
    })
}

/// Adds what channels take of intensities.
fn sum_shares<const N: usize>(
    sums: &mut ExactSums,
    measured: &mut Measured<N>,
    shares: &Shares<N>,
    (slots, pixels): (usize, usize),
) -> u64 {
    sums.resize(pixels * shares.channels);
    let mut not_finite = 0;
    let (values, _) = measured.intensities_mut(slots).as_chunks::<N>();
    for (slot, values) in values.iter().enumerate() {
        if !are_finite(values) {
            not_finite += 1;
            continue;
        }
        let first = slot % pixels * shares.channels;
        for taken in &shares.taken {
            sums.add(first + taken.channel, &[taken.of(values)]);
        }
    }
    not_finite
}

/// Adds what channels take of Stokes vectors.
fn sum_stokes_shares<const N: usize>(
    sums: &mut ExactSums,
    measured: &Measured<N>,
    shares: &Shares<N>,
    (slots, pixels): (usize, usize),
) -> u64 {
    let stride = 4 * shares.channels;
    sums.resize(pixels * stride);
    sum_readings(measured, (slots, pixels), |pixel, reading| match reading {
        Reading::Intensity(intensity) => {
            for taken in &shares.taken {
                sums.add(pixel * stride + 4 * taken.channel, &[taken.of(intensity)]);
            }
        }
        Reading::Stokes(states) => {
            for taken in &shares.taken {
                sums.add_four(pixel * stride + 4 * taken.channel, taken.of_each(states));
            }
        }
    })
}

/// Calls `add` with the pixel and the reading of every slot but those that are not finite, and
/// returns how many these are.
#[inline(always)]
fn sum_readings<const N: usize>(
    measured: &Measured<N>,
    (slots, pixels): (usize, usize),
    mut add: impl FnMut(usize, &Reading<N>),
) -> u64 {
    let mut not_finite = 0;
    for first in (0..slots).step_by(pixels) {
        for pixel in 0..pixels {
            let reading = measured.reading(first + pixel);
            let is_finite = match &reading {
                Reading::Intensity(intensity) => are_finite(*intensity),
                Reading::Stokes(states) => are_states_finite(states),
            };
            if is_finite {
                add(pixel, &reading);
            } else {
                not_finite += 1;
            }
        }
    }
    not_finite
}

/// The same of Stokes vectors.
#[inline(always)]
pub fn are_states_finite(states: &[f32x4]) -> bool {
    // Zero times what is not finite is no number.
    let zero = f32x4::ZERO;
    let sum = states.iter().fold(zero, |sum, state| zero.mul_add(*state, sum));
    sum.to_array() == [0.0; 4]
}

/// Whether all are finite; without a way out before the end, so that many are looked at at once.
pub fn are_finite(values: &[f32]) -> bool {
    values.iter().fold(true, |all, value| all & value.is_finite())
}
