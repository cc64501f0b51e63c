//! Scatters rows that have met particles of media, and writes the Mueller kernels of those events
//! where they are wanted.

use crate::geometry::RayColumns;
use crate::math::columns::Channels;
use crate::math::{F32s, LANES, Vector, lanes};
use crate::polarization::{SpheroidBlock, s_axis};
use crate::scattering::event::Form;
use crate::scattering::medium::Medium;
use crate::scattering::phase::{Scatters, deflect, for_phase, half_sine2};
use crate::scattering::vertex::mean;
use crate::scattering::{Met, Scene, Side};
use crate::transport::mis::TurnDensities;
use crate::transport::sampler::Purpose;
use crate::transport::tables::carriers::{CarrierTable, Lean, lean_of, ratio};
use crate::transport::tables::kernels::DepartureColumns;
use crate::transport::tables::media::MediaColumns;
use crate::transport::tables::partition::{Part, Partition};
use crate::transport::tables::paths::{IdentityColumns, MisColumns, PathTable};
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
        let PathTable { rays, identity, beta, mis, media, carriers, .. } = &mut *paths;
        let leans = POLARIZED && bounce.sampling == Sampling::Stokes && C::leans(part);
        let lean = |row: usize, frame| lean_of(carriers, part, row, frame);
        let lean: Option<&Lean<N>> = if leans { Some(&lean) } else { None };
        let mut to = Scattering { departures, rays, identity, beta, mis, media, lean };
        scatter_part::<N, POLARIZED>(&mut to, scene.medium(medium), part, bounce);
    }
}

/// What is written of rows, and read.
struct Scattering<'a, const N: usize> {
    departures: &'a mut DepartureColumns<N>,
    rays: &'a RayColumns,
    identity: &'a IdentityColumns,
    beta: &'a mut Channels<N>,
    mis: &'a mut MisColumns,
    media: &'a mut MediaColumns<N>,
    /// Where it steers the plane of scattering.
    lean: Option<&'a Lean<'a, N>>,
}

/// Rows in one medium.
#[inline(never)]
fn scatter_part<const N: usize, const POLARIZED: bool>(
    to: &mut Scattering<N>,
    medium: &Medium<N>,
    part: &Part,
    bounce: Bounce,
) {
    let polarizes = POLARIZED && part.event.form != Form::Depolarizer;
    let end = part.rows.end;
    for_phase!(&medium.phase, phase => {
        for row in part.rows.clone().step_by(LANES) {
            let before = Vector::load(&to.rays.direction, row);
            let mut after = to.draw_direction(phase, before, row, bounce.path_length);
            let angle = half_sine2(before, after);
            let mut gains = [F32s::splat(1.0); N];
            if polarizes {
                let kernels = phase.kernels(angle);
                if let Some(lean) = to.lean {
                    let at = (lean, row, bounce);
                    (after, gains) = choose_plane(to.identity, &kernels, [before, after], at);
                }
                let (k_in, k_out) = bounce.side.along_light(before, after);
                let kind = (part.event.form, part.event.achromatic);
                let found = (&kernels, s_axis(k_in, k_out));
                to.departures.kernels.store_events(kind, found, (row, end));
            }
            to.weigh(medium, (&phase.values(angle), &gains), row, end);
            after.store(&mut to.departures.direction, row, end);
        }
    });
}

/// Keeps the plane of scattering that was drawn evenly, or turns it by a right angle, so that
/// either is as frequent as its light, at the path's wavelength, is bright: of the two, one gains
/// what the other loses. Returns the direction, and what that gains at every wavelength.
#[inline(always)]
fn choose_plane<const N: usize>(
    identity: &IdentityColumns,
    kernels: &[SpheroidBlock<F32s>; N],
    [before, after]: [Vector<F32s>; 2],
    (lean, row, bounce): (&Lean<N>, usize, Bounce),
) -> (Vector<F32s>, [F32s; N]) {
    let (k_in, k_out) = bounce.side.along_light(before, after);
    let k = match bounce.side {
        Side::Light => k_in,
        Side::Sensor => k_out,
    };
    let (axis, two) = (s_axis(k_in, k_out), F32s::splat(2.0));
    let mut gains = [F32s::splat(1.0); N];
    for ((gain, kernel), light) in gains.iter_mut().zip(kernels).zip(lean(row, (axis, k))) {
        *gain = kernel.a.mul_add(ratio(light), *gain).fast_max(F32s::ZERO).fast_min(two);
    }
    let wavelength = identity.wavelength::<N>(row);
    let chosen: [f32; LANES] =
        lanes::each(|lane| gains[wavelength[lane] as usize].as_array()[lane]);
    let u = identity.draw_first(row, bounce.path_length, Purpose::Decision);
    let turns = !(u * two).simd_lt(F32s::from(chosen));
    let turned = before.cross(after) + before * before.dot(after);
    let gains = gains.map(|gain| turns.select(two - gain, gain));
    (Vector::select(turns, turned.normalize(), after), gains)
}

impl<const N: usize> Scattering<'_, N> {
    #[inline(always)]
    fn draw_direction(
        &self,
        phase: &impl Scatters<N>,
        before: Vector<F32s>,
        row: usize,
        path_length: u32,
    ) -> Vector<F32s> {
        let [u, turns] = self.identity.draw(row, path_length, Purpose::Direction);
        let wavelength = self.identity.wavelength::<N>(row);
        deflect(before, phase.sample(wavelength, u), turns)
    }

    /// Throughput, shares of the wavelengths, and partial weights. `gains` are what the densities
    /// are of those of unpolarized light.
    #[inline(always)]
    fn weigh(
        &mut self,
        medium: &Medium<N>,
        (values, gains): (&[F32s; N], &[F32s; N]),
        row: usize,
        end: usize,
    ) {
        if !self.media.has_shares() {
            // The density is that of any wavelength.
            for beta in self.beta.iter_mut() {
                let weighed = lanes::load(beta, row) / gains[0];
                lanes::store(beta, row, end, weighed);
            }
        } else {
            let mut densities = *values;
            let mut sum = F32s::splat(0.0);
            for (n, share) in self.media.share.iter().enumerate() {
                densities[n] *= gains[n] * lanes::load(share, row);
                sum += densities[n];
            }
            let inverse = F32s::splat(1.0) / sum;
            for n in 0..N {
                let beta = lanes::load(&self.beta[n], row) * values[n] * inverse;
                lanes::store(&mut self.beta[n], row, end, beta);
                lanes::store(&mut self.media.share[n], row, end, densities[n] * inverse);
            }
        }
        let pdf = mean(values);
        let measure = F32s::splat(medium.density);
        self.mis.depart(row, end, TurnDensities { pdf, pdf_reverse: pdf, measure });
    }
}
