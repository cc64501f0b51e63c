//! Scatters rows that have met particles of media, and writes the Mueller kernels of those events
//! where they are wanted.

use crate::math::{F32s, LANES, Vector, lanes};
use crate::polarization::{SpheroidBlock, s_axis};
use crate::scattering::event::Form;
use crate::scattering::medium::Medium;
use crate::scattering::phase::{Scatters, deflect, for_phase, half_sine2};
use crate::scattering::vertex::mean;
use crate::scattering::{Met, Scene, Side};
use crate::transport::mis::TurnDensities;
use crate::transport::sampler::Purpose;
use crate::transport::tables::carriers::{CarrierTable, ratio};
use crate::transport::tables::kernels::DepartureColumns;
use crate::transport::tables::partition::{Part, Partition};
use crate::transport::tables::paths::PathTable;
use crate::transport::{Bounce, Sampling};

/// Draws a new direction for the rows in media, by the phase function of the path's wavelength;
/// the weight counts that it could have been drawn for any of them.
///
/// With [`Sampling::Stokes`] the plane of scattering is drawn from what polarized light does: at
/// one angle, light (1, s1, ...) about the axis of the plane leaves with 1 + a s1 of the intensity
/// of unpolarized light, where a is the diattenuation M01 / M00. So the intensity that a light
/// path carries, and what a sensor path accepts, stay as they are, and no product of such factors
/// grows with every event. The weights of strategies keep densities of unpolarized light.
///
/// From: depolarize_sensor, depolarize_light, pay_out. To: collect_sensor, scatter_light.
/// Writes: departures, paths (beta, mis, media). Reads: paths, scene, partition.
pub fn scatter_medium<const N: usize, const POLARIZED: bool, C: CarrierTable>(
    departures: &mut DepartureColumns<N>,
    paths: &mut PathTable<N, C>,
    scene: &Scene<N>,
    partition: &Partition,
    bounce: Bounce,
) {
    for part in &partition.parts {
        let Met::Medium(medium) = part.event.met else { continue };
        let medium = scene.medium(medium);
        let polarizes = POLARIZED && part.event.form != Form::Depolarizer;
        let leans = polarizes && bounce.sampling == Sampling::Stokes && C::leans(part);
        for_phase!(&medium.phase, phase => {
            for row in part.rows.clone().step_by(LANES) {
                let end = part.rows.end;
                let before = Vector::load(&paths.rays.direction, row);
                let mut after = draw_direction(paths, phase, before, row, bounce.path_length);
                let angle = half_sine2(before, after);
                let mut gains = [F32s::splat(1.0); N];
                if polarizes {
                    let kernels = phase.kernels(angle);
                    if leans {
                        let at = (part, row, bounce);
                        (after, gains) = choose_plane(paths, &kernels, [before, after], at);
                    }
                    let (k_in, k_out) = bounce.side.along_light(before, after);
                    let kind = (part.event.form, part.event.achromatic);
                    let found = (&kernels, s_axis(k_in, k_out));
                    departures.kernels.store_events(kind, found, (row, end));
                }
                weigh(paths, medium, (&phase.values(angle), &gains), row, end);
                after.store(&mut departures.direction, row, end);
            }
        });
    }
}

/// Keeps the plane of scattering that was drawn evenly, or turns it by a right angle, so that
/// either is as frequent as its light, at the path's wavelength, is bright: of the two, one gains
/// what the other loses. Returns the direction, and what that gains at every wavelength.
#[inline(always)]
fn choose_plane<const N: usize, C: CarrierTable>(
    paths: &PathTable<N, C>,
    kernels: &[SpheroidBlock<F32s>; N],
    [before, after]: [Vector<F32s>; 2],
    (part, row, bounce): (&Part, usize, Bounce),
) -> (Vector<F32s>, [F32s; N]) {
    let (k_in, k_out) = bounce.side.along_light(before, after);
    let k = match bounce.side {
        Side::Light => k_in,
        Side::Sensor => k_out,
    };
    let (axis, two) = (s_axis(k_in, k_out), F32s::splat(2.0));
    let mut gains = [F32s::splat(1.0); N];
    for (n, gain) in gains.iter_mut().enumerate() {
        let s1 = ratio(paths.carriers.lean(part, n, row, (axis, k)));
        *gain = kernels[n].a.mul_add(s1, *gain).fast_max(F32s::ZERO).fast_min(two);
    }
    let wavelength = paths.identity.wavelength::<N>(row);
    let chosen: [f32; LANES] =
        lanes::each(|lane| gains[wavelength[lane] as usize].as_array()[lane]);
    let [u, _] = paths.identity.draw(row, bounce.path_length, Purpose::Decision);
    let turns = !(u * two).simd_lt(F32s::from(chosen));
    let turned = before.cross(after) + before * before.dot(after);
    let gains = gains.map(|gain| turns.select(two - gain, gain));
    (Vector::select(turns, turned.normalize(), after), gains)
}

#[inline(always)]
fn draw_direction<const N: usize, C>(
    paths: &PathTable<N, C>,
    phase: &impl Scatters<N>,
    before: Vector<F32s>,
    row: usize,
    path_length: u32,
) -> Vector<F32s> {
    let [u, turns] = paths.identity.draw(row, path_length, Purpose::Direction);
    let wavelength = paths.identity.wavelength::<N>(row);
    deflect(before, phase.sample(wavelength, u), turns)
}

/// Throughput, shares of the wavelengths, and partial weights. `gains` are what the densities are
/// of those of unpolarized light.
#[inline(always)]
fn weigh<const N: usize, C>(
    paths: &mut PathTable<N, C>,
    medium: &Medium<N>,
    (values, gains): (&[F32s; N], &[F32s; N]),
    row: usize,
    end: usize,
) {
    if !paths.media.has_shares() {
        // The density is that of any wavelength.
        for beta in &mut paths.beta {
            let weighed = lanes::load(beta, row) / gains[0];
            lanes::store(beta, row, end, weighed);
        }
    } else {
        let mut densities = *values;
        let mut sum = F32s::splat(0.0);
        for (n, share) in paths.media.share.iter().enumerate() {
            densities[n] *= gains[n] * lanes::load(share, row);
            sum += densities[n];
        }
        let inverse = F32s::splat(1.0) / sum;
        for n in 0..N {
            let beta = lanes::load(&paths.beta[n], row) * values[n] * inverse;
            lanes::store(&mut paths.beta[n], row, end, beta);
            lanes::store(&mut paths.media.share[n], row, end, densities[n] * inverse);
        }
    }
    let pdf = mean(values);
    let measure = F32s::splat(medium.density);
    paths.mis.depart(row, end, TurnDensities { pdf, pdf_reverse: pdf, measure });
}
