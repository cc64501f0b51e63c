//! Keeps what light paths bring to surfaces and media as photons.

use crate::geometry::HitColumns;
use crate::math::{F32s, LANES, Real, Vector, lanes};
use crate::polarization::{Arrival, LightCarrier, Stokes};
use crate::scattering::{Met, Scene};
use crate::transport::Arrived;
use crate::transport::sides::LightSide;
use crate::transport::tables::carriers::LightCarriers;
use crate::transport::tables::photons::{PhotonClass, PhotonTable, round_directions};

/// Least share of a surface that photons are divided by: the few that meet what is hardly there
/// would shine far over its edge. What such a surface is short of is less than this share of it.
const SHARE_MIN: f32 = 0.25;

/// Appends rows that have arrived. At depolarizers the power is all there is; elsewhere the state
/// of polarization is kept relative to it.
///
/// From: depolarize_light. To: the photon maps.
/// Writes: photons. Reads: arrived (paths, surfaces), hits, scene.
pub fn store_photons<const N: usize, C: LightSide<N>>(
    photons: &mut PhotonTable<N>,
    arrived: &Arrived<N, C>,
    (hits, scene): (&HitColumns, &Scene<N>),
) {
    let &Arrived { paths, surfaces, ref rows, path_length, event } = arrived;
    let has_holes = matches!(event.met, Met::Surface(_)) && scene.has_holes();
    let first = photons.len;
    for row in rows.clone().step_by(LANES) {
        let live = LANES.min(rows.end - row);
        let direction = Vector::load(&paths.rays.direction, row);
        let position = Vector::load(&surfaces.position, row);
        let mut power = [F32s::splat(0.0); N];
        for (power, beta) in power.iter_mut().zip(&paths.beta) {
            *power = lanes::load(beta, row);
        }
        if has_holes {
            // Where light and sensor meet a surface that is there by a share, they meet the same
            // part of it: that it is there counts once, and has counted for the sensor.
            let there = lanes::each(|lane| match lane < live {
                true => scene.coverage_of(surfaces, hits, row + lane),
                false => 1.0,
            });
            let there = F32s::from(there).fast_max(F32s::splat(SHARE_MIN));
            power.iter_mut().for_each(|power| *power /= there);
        }
        let start = photons.len;
        if photons.class == PhotonClass::Power {
            photons.append_lanes(position, direction, &power, live);
            continue;
        }
        let rounded = round_directions(direction);
        let states = states_about(paths.carriers.columns(), row, live, rounded);
        for (power, state) in power.iter_mut().zip(&states) {
            *power *= state[0];
        }
        photons.append_lanes(position, direction, &power, live);
        for (channel, state) in states.iter().enumerate().take(photons.class.channels(N)) {
            let polarization = [state[1], state[2], state[3]];
            photons.store_stokes(start, photons.len, channel, polarization);
        }
    }
    photons.note_path_length(first, path_length);
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
