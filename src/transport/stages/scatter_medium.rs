//! Scatters rows that have met particles of media, and writes the Mueller kernels of those events
//! where they are wanted.

use crate::math::columns::Column;
use crate::math::{F32s, LANES, Vector, lanes};
use crate::polarization::kernel::{Block, SpheroidBlock};
use crate::polarization::s_axis;
use crate::scattering::event::{Event, Form};
use crate::scattering::medium::{Medium, PhaseFunction, PhaseLookup, deflect, half_sine2};
use crate::scattering::phase::Scatters;
use crate::scattering::vertex::mean;
use crate::scattering::{Met, Scene};
use crate::transport::mis::TurnDensities;
use crate::transport::sampler::{Purpose, draw};
use crate::transport::tables::kernels::{KernelColumns, StoredKernel};
use crate::transport::tables::partition::{Part, Partition};
use crate::transport::tables::paths::PathTable;

use crate::transport::bounce::{Bounce, Side};
use crate::transport::flight::wavelength_of;

/// Draws a new direction for the rows in media, by the phase function of the path's wavelength;
/// the weight counts that it could have been drawn for any of them.
///
/// From: depolarize_sensor, depolarize_light. To: collect_sensor, scatter_light.
/// Writes: drawn, kernels, paths (beta, mis, media). Reads: paths, scene, partition.
pub fn scatter_medium<const N: usize, const POLARIZED: bool, C>(
    drawn: &mut [Column; 3],
    kernels: &mut KernelColumns<N>,
    paths: &mut PathTable<N, C>,
    scene: &Scene<N>,
    partition: &Partition,
    Bounce { path_length, side }: Bounce,
) {
    for part in &partition.parts {
        let Met::Medium(medium) = part.event.met else { continue };
        let medium = scene.medium(medium);
        for row in part.rows.clone().step_by(LANES) {
            let end = part.rows.end;
            let before = Vector::load(&paths.rays.direction, row);
            let after = draw_direction(paths, medium, before, row, path_length);
            let angle = half_sine2(before, after);
            weigh(paths, medium, angle, row, end);
            after.store(drawn, row, end);
            if let (true, PhaseFunction::Table(table)) = (POLARIZED, &medium.phase) {
                let (k_in, k_out) = match side {
                    Side::Light => (before, after),
                    Side::Sensor => (-after, -before),
                };
                store_kernels(kernels, table, part, angle, row);
                s_axis(k_in, k_out).store(&mut kernels.axis, row, end);
            }
        }
    }
}

#[inline(always)]
fn draw_direction<const N: usize, C>(
    paths: &PathTable<N, C>,
    medium: &Medium<N>,
    before: Vector<F32s>,
    row: usize,
    path_length: u32,
) -> Vector<F32s> {
    let seed = lanes::load_u32(&paths.identity.seed, row);
    let iteration = lanes::load_u32(&paths.identity.iteration, row);
    let [u, turns] = draw(seed, iteration, path_length, Purpose::Direction);
    let wavelength = wavelength_of::<N>(&paths.identity, row);
    deflect(before, medium.phase.sample(wavelength, u), turns)
}

/// Throughput, shares of the wavelengths, and partial weights.
#[inline(always)]
fn weigh<const N: usize, C>(
    paths: &mut PathTable<N, C>,
    medium: &Medium<N>,
    angle: F32s,
    row: usize,
    end: usize,
) {
    let values = medium.phase.values(angle);
    if N > 1 {
        let mut densities = values;
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
    let pdf = mean(&values);
    let measure = F32s::splat(medium.density);
    paths.mis.depart(row, end, TurnDensities { pdf, pdf_reverse: pdf, measure });
}

#[inline(always)]
fn store_kernels<const N: usize>(
    kernels: &mut KernelColumns<N>,
    table: &PhaseLookup<N>,
    part: &Part,
    angle: F32s,
    row: usize,
) {
    let Event { form, achromatic, .. } = part.event;
    let found = table.kernels(angle);
    for (n, kernel) in found.iter().enumerate().take(if achromatic { 1 } else { N }) {
        let &SpheroidBlock { a, c, s, .. } = kernel;
        match form {
            Form::Block => Block { a, c, s }.store(kernels, n, row, part.rows.end),
            Form::Spheroid | Form::Depolarizer => kernel.store(kernels, n, row, part.rows.end),
        }
    }
}
