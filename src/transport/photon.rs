//! How light is left as photons, whichever stage leaves it.

use crate::math::{F32s, Real, Vector, lanes};
use crate::polarization::{Arrival, LightCarrier, Stokes};
use crate::transport::sides::LightSide;
use crate::transport::tables::carriers::LightCarriers;
use crate::transport::tables::photons::{PhotonClass, PhotonTable, round_directions};

/// Light as it arrives somewhere.
#[derive(Clone, Copy)]
pub struct Arriving<const N: usize> {
    /// Where.
    pub position: Vector<F32s>,
    /// Along which unit vector it travels.
    pub direction: Vector<F32s>,
    /// What a scalar renderer takes for its power.
    pub power: [F32s; N],
}

/// Appends the first `live` lanes of what arrives, whose carriers are in the rows from `row` on.
#[inline(always)]
pub fn leave<const N: usize, C: LightSide<N>>(
    photons: &mut PhotonTable<N>,
    arriving: Arriving<N>,
    carriers: &C,
    (row, live): (usize, usize),
) {
    let Arriving { position, direction, mut power } = arriving;
    let start = photons.len;
    let rounded = round_directions(direction);
    let states = states_about(carriers.columns(), row, live, rounded);
    for (power, state) in power.iter_mut().zip(&states) {
        *power *= state[0];
    }
    photons.append_lanes(position, direction, &power, live);
    if photons.class == PhotonClass::Power {
        return;
    }
    for (channel, state) in states.iter().enumerate().take(photons.class.channels(N)) {
        let polarization = [state[1], state[2], state[3]];
        photons.store_stokes(start, photons.len, channel, polarization);
    }
}

/// The states of eight rows from `row` on, `live` of them in use, in the canonical frame of their
/// `direction`: per wavelength, the factor of the intensity, and s1..s3 over it.
fn states_about<const N: usize>(
    carriers: Option<&LightCarriers<N>>,
    row: usize,
    live: usize,
    direction: Vector<F32s>,
) -> [[F32s; 4]; N] {
    let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
    let canonical = direction.any_perpendicular();
    let Stokes(unpolarized) = LightCarrier::unpolarized(canonical).stokes;
    let mut states = [unpolarized; N];
    let Some(carriers) = carriers else { return states };
    let class = &carriers.class[row..row + live];
    if !class.iter().any(|class| class.has_stokes()) {
        return states;
    }
    let polarized =
        lanes::mask_of(lanes::each(|lane| class.get(lane).is_some_and(|class| class.has_stokes())));
    let x = Vector::load(&carriers.axis, row);
    let arrival = Arrival::between(x, canonical, direction);
    for (n, state) in states.iter_mut().enumerate() {
        let Stokes([s0, s1, s2, s3]) = carriers.load(n, row, x).turned(&arrival).stokes;
        // Where no light is left, no polarization is either.
        let lit = polarized & s0.simd_gt(zero);
        let inverse = lit & (one / s0);
        let factor = Real::select(polarized, s0, one);
        *state = [factor, s1, s2, s3];
        for value in &mut state[1..] {
            *value = lit & (*value * inverse);
        }
    }
    states
}
