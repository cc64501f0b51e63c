//! Scatters rows that have met particles of media, and writes the Mueller kernels of those events
//! where they are wanted.

use crate::math::{F32s, LANES, Vector, lanes};
use crate::polarization::s_axis;
use crate::scattering::event::Form;
use crate::scattering::medium::Medium;
use crate::scattering::phase::{Scatters, deflect, for_phase, half_sine2};
use crate::scattering::vertex::mean;
use crate::scattering::{Met, Scene};
use crate::transport::Bounce;
use crate::transport::mis::TurnDensities;
use crate::transport::sampler::Purpose;
use crate::transport::tables::kernels::DepartureColumns;
use crate::transport::tables::partition::Partition;
use crate::transport::tables::paths::PathTable;

/// Draws a new direction for the rows in media, by the phase function of the path's wavelength;
/// the weight counts that it could have been drawn for any of them.
///
/// From: depolarize_sensor, depolarize_light. To: collect_sensor, scatter_light.
/// Writes: departures, paths (beta, mis, media). Reads: paths, scene, partition.
pub fn scatter_medium<const N: usize, const POLARIZED: bool, C>(
    departures: &mut DepartureColumns<N>,
    paths: &mut PathTable<N, C>,
    scene: &Scene<N>,
    partition: &Partition,
    Bounce { path_length, side }: Bounce,
) {
    for (event, rows) in partition.events() {
        let Met::Medium(medium) = event.met else { continue };
        let medium = scene.medium(medium);
        for_phase!(&medium.phase, phase => {
            for row in rows.clone().step_by(LANES) {
                let end = rows.end;
                let before = Vector::load(&paths.rays.direction, row);
                let after = draw_direction(paths, phase, before, row, path_length);
                let angle = half_sine2(before, after);
                weigh(paths, medium, &phase.values(angle), row, end);
                after.store(&mut departures.direction, row, end);
                if POLARIZED && event.form != Form::Depolarizer {
                    let (k_in, k_out) = side.along_light(before, after);
                    let found = (phase.kernels(angle), s_axis(k_in, k_out));
                    let kind = (event.form, event.achromatic);
                    departures.kernels.store_events(kind, &found, (row, end));
                }
            }
        });
    }
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

/// Throughput, shares of the wavelengths, and partial weights.
#[inline(always)]
fn weigh<const N: usize, C>(
    paths: &mut PathTable<N, C>,
    medium: &Medium<N>,
    values: &[F32s; N],
    row: usize,
    end: usize,
) {
    if N > 1 {
        let mut densities = *values;
        let mut sum = F32s::splat(0.0);
        for (density, share) in densities.iter_mut().zip(&paths.media.share) {
            *density *= lanes::load(share, row);
            sum += *density;
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
