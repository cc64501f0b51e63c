//! Sends the rows at surfaces on, and writes the Mueller kernels of those events where they are
//! wanted: one loop for every model.

use std::ops::Range;

use crate::geometry::SurfaceColumns;
use crate::math::{F32s, LANES, Real, Vector, lanes};
use crate::scattering::event::{Elements, Form};
use crate::scattering::nesting::InterfaceLanes;
use crate::scattering::painting::SceneAt;
use crate::scattering::surface::model::{Choice, Incidence, OneOfTwo, Scattered};
use crate::scattering::surface::{Connecting, Specular, for_scattering};
use crate::scattering::vertex::{Consecutive, OnSurfaces};
use crate::scattering::{Met, Scene, Side};
use crate::transport::collapse::{collapse, have_collapsed};
use crate::transport::mis::TurnDensities;
use crate::transport::sampler::Purpose;
use crate::transport::tables::carriers::{CarrierTable, ratio};
use crate::transport::tables::kernels::DepartureColumns;
use crate::transport::tables::partition::{Part, Partition};
use crate::transport::tables::paths::PathTable;
use crate::transport::{Bounce, Sampling};

/// Draws a new direction for every row that has met a surface.
///
/// With [`Sampling::Stokes`], of two ways that are drawn one is as frequent as it is bright for the
/// light that a path carries, or what it accepts: of light (1, s1, ...) about the axis of the plane
/// of incidence, R (1 + a s1) is reflected, where a is the diattenuation of reflection. Behind many
/// panes paths have all the weight of those of unpolarized light. The rows of a sensor's matrix
/// that measure S1 to S3 are no greater than that of S0 for any light, and go along. Which way the
/// wavelengths go that a path has in common, all of their light decides.
///
/// With `POLARIZED`, also writes one kernel a row of polarizing models: achromatic ones to
/// channel 0 only.
///
/// From: depolarize_sensor, depolarize_light, pay_out. To: collect_sensor, scatter_light,
/// advance_paths.
/// Writes: departures, paths (beta, mis, media, nested). Reads: paths, surfaces, scene, partition.
pub fn scatter_surfaces<const N: usize, const POLARIZED: bool, C: CarrierTable>(
    departures: &mut DepartureColumns<N>,
    paths: &mut PathTable<N, C>,
    surfaces: &SurfaceColumns,
    scene: SceneAt<N>,
    partition: &Partition,
    bounce: Bounce,
) {
    for part in &partition.parts {
        let Met::Surface(kind) = part.event.met else { continue };
        let mut to = Departing { departures, paths, end: part.rows.end };
        for_scattering!(scene.surfaces, kind, models => {
            specular: {
                let all = (&*scene, models);
                send_on::<N, POLARIZED, C, _>(&mut to, all, surfaces, part, bounce);
            },
            connecting: {
                let all = OnSurfaces::new(&scene, models);
                scatter::<N, POLARIZED, C, _>(&mut to, all, surfaces, part.rows.clone(), bounce);
            },
            else: {},
        });
    }
}

/// How much of a choice unpolarized light decides, whatever the path carries: no way is closed by
/// rounding to light that goes it.
const EVEN_SHARE: f32 = 1.0 / 64.0;

/// What is written of the rows up to `end`.
struct Departing<'a, const N: usize, C> {
    departures: &'a mut DepartureColumns<N>,
    paths: &'a mut PathTable<N, C>,
    end: usize,
}

/// One way, or two.
fn send_on<const N: usize, const POLARIZED: bool, C: CarrierTable, M: Specular<N>>(
    to: &mut Departing<N, C>,
    (scene, models): (&Scene<N>, &[M]),
    surfaces: &SurfaceColumns,
    part: &Part,
    bounce: Bounce,
) {
    let leans = POLARIZED && bounce.sampling == Sampling::Stokes && C::leans(part);
    for row in part.rows.clone().step_by(LANES) {
        let some = (row, LANES.min(part.rows.end - row));
        let mut at = Incidence::load(scene, models, surfaces, &to.paths.rays, some);
        let nested = if M::NESTS { to.interfaces(&at, surfaces, scene, some) } else { None };
        if let Some(InterfaceLanes { rows, .. }) = &nested {
            at.models.rows = *rows;
        }
        if M::DISPERSES && N > 1 {
            at.collapsed = have_collapsed(lanes::load(&to.paths.beta[1], row));
        }
        let choose = |way: OneOfTwo| {
            let [u, _] = to.paths.identity.draw(row, bounce.path_length, Purpose::Decision);
            if leans {
                return choose_by_light(to.paths, u, &way, (part, row, bounce.side));
            }
            Choice { first: u.simd_lt(way.share), gain: F32s::ONE }
        };
        let scattered = M::scatter::<POLARIZED>(&at, choose, bounce.side);
        if POLARIZED {
            to.departures.kernels.store_events(
                (M::Kernel::FORM, M::ACHROMATIC),
                (&scattered.kernels, scattered.axis),
                (row, to.end),
            );
        }
        if to.paths.media.present() {
            let behind = nested.as_ref().map_or([None; LANES], |nested| nested.behind);
            to.cross(surfaces, scene, &scattered.direction, (row, behind));
        }
        if let Some(InterfaceLanes { inside, .. }) = nested {
            to.go_through(surfaces, &scattered.direction, &inside, row);
        }
        to.depart_specular(&at, &scattered, bounce.side, row);
    }
}

/// Chooses one of two ways by what goes there of the light that paths carry, or accept.
#[inline(always)]
fn choose_by_light<const N: usize, C: CarrierTable>(
    paths: &PathTable<N, C>,
    u: F32s,
    way: &OneOfTwo,
    (part, row, side): (&Part, usize, Side),
) -> Choice {
    let before = Vector::load(&paths.rays.direction, row);
    let k = match side {
        Side::Light => before,
        Side::Sensor => -before,
    };
    let mut light = [F32s::ZERO; 2];
    for (n, beta) in paths.beta.iter().enumerate() {
        let beta = lanes::load(beta, row);
        let [s0, s1] = paths.carriers.lean(part, n, row, (way.axis, k));
        light = [beta.mul_add(s0, light[0]), beta.mul_add(s1, light[1])];
    }
    let one = F32s::ONE;
    let leans = way.diattenuation * ratio(light) * F32s::splat(1.0 - EVEN_SHARE);
    let share = (way.share * (one + leans)).min(one);
    let first = u.simd_lt(share);
    let gain = Real::select(first, one + leans, (one - share) / (one - way.share));
    Choice { first, gain }
}

/// Any way.
fn scatter<const N: usize, const POLARIZED: bool, C, M: Connecting<N>>(
    to: &mut Departing<N, C>,
    all: OnSurfaces<M, N>,
    surfaces: &SurfaceColumns,
    rows: Range<usize>,
    bounce: Bounce,
) {
    let side = bounce.side;
    for row in rows.clone().step_by(LANES) {
        let u = to.paths.identity.draw(row, bounce.path_length, Purpose::Direction);
        let some = Consecutive(row, LANES.min(rows.end - row));
        let (of_model, facing) = all.load(surfaces, some);
        let of = all.models.lanes(&of_model);
        let before = Vector::load(&to.paths.rays.direction, row);
        let given = -before;
        let drawn = all.models.draw((&of_model, &of), &facing, given, u);
        let direction = drawn.direction;
        let scale = match side {
            Side::Sensor => F32s::splat(1.0),
            Side::Light => facing.adjoint(given, direction),
        };
        let passes = facing.reflects(given, direction);
        for (beta, &weight) in to.paths.beta.iter_mut().zip(&drawn.weight) {
            let value = lanes::load(beta, row) * weight * (passes & scale);
            lanes::store(beta, row, to.end, value);
        }
        direction.store(&mut to.departures.direction, row, to.end);
        if POLARIZED && !matches!(M::Kernel::FORM, Form::Depolarizer) {
            let (k_in, k_out) = side.along_light(before, direction);
            let kernels = &mut to.departures.kernels;
            if M::is_dense(&of) {
                let (dense, axis) = M::dense_kernels(&of, &facing, k_in, k_out);
                kernels.store_events((Form::Dense, false), (&dense, axis), (row, to.end));
            } else {
                let (sparse, axis) = M::kernels(&of, &facing, k_in, k_out);
                let form = (M::Kernel::FORM, M::ACHROMATIC);
                kernels.store_events(form, (&sparse, axis), (row, to.end));
            }
        }
        let pdf_reverse = M::pdf(&of, &facing, direction, given);
        let measure = direction.dot(facing.geometric).abs();
        let turn = TurnDensities { pdf: drawn.pdf, pdf_reverse, measure };
        to.paths.mis.depart(row, to.end, turn);
    }
}

impl<const N: usize, C> Departing<'_, N, C> {
    /// What rows have met that can be nested, in scenes where it is.
    #[inline(always)]
    fn interfaces<M>(
        &self,
        at: &Incidence<M>,
        surfaces: &SurfaceColumns,
        scene: &Scene<N>,
        (row, live): (usize, usize),
    ) -> Option<InterfaceLanes> {
        let interfaces = scene.interfaces.as_ref()?;
        let paths = (&self.paths.rays, self.paths.nested.inside.as_slice());
        let hits = lanes::each(|lane| row + lane.min(live - 1));
        Some(scene.interfaces_at(interfaces, surfaces, paths, hits, &at.models.rows))
    }

    /// Rows are in the dielectric from now on that is on the side of the surface they go on to.
    fn go_through(
        &mut self,
        surfaces: &SurfaceColumns,
        drawn: &Vector<F32s>,
        inside: &[[u32; 2]; LANES],
        row: usize,
    ) {
        let passes = self.pass(surfaces, drawn, row);
        for lane in 0..LANES.min(self.end - row) {
            self.paths.nested.inside[row + lane] = inside[lane][usize::from(passes[lane].0)];
        }
    }

    /// Which rows go through their surfaces, and to the front.
    #[inline(always)]
    fn pass(
        &self,
        surfaces: &SurfaceColumns,
        drawn: &Vector<F32s>,
        row: usize,
    ) -> [(bool, bool); LANES] {
        let normal = Vector::load(&surfaces.geometric_normal, row);
        let before = Vector::load(&self.paths.rays.direction, row).dot(normal).to_array();
        let after = drawn.dot(normal).to_array();
        lanes::each(|lane| (before[lane] * after[lane] > 0.0, after[lane] > 0.0))
    }

    /// Where a row has gone through its surface, it is in the medium on the other side from now
    /// on: the one that the surface names.
    #[inline(always)]
    fn cross(
        &mut self,
        surfaces: &SurfaceColumns,
        scene: &Scene<N>,
        drawn: &Vector<F32s>,
        (row, solids): (usize, [Option<u32>; LANES]),
    ) {
        let passes = self.pass(surfaces, drawn, row);
        for lane in 0..LANES.min(self.end - row) {
            let (passes, to_front) = passes[lane];
            if passes {
                let inside = &mut self.paths.media.inside[row + lane];
                let known = (*inside, solids[lane]);
                *inside = scene.medium_beyond(surfaces, row + lane, to_front, known);
            }
        }
    }

    #[inline(always)]
    fn depart_specular<M: Specular<N>>(
        &mut self,
        at: &Incidence<M>,
        scattered: &Scattered<N, M::Kernel>,
        side: Side,
        row: usize,
    ) {
        let &Scattered { direction, ref weight, .. } = scattered;
        let cos_out = direction.dot(at.geometric).abs();
        // Veach 1997, equation 5.19, for a direction that has the cosine of arrival (or Snell's
        // partner of it) to the shading normal on both sides; one without shading normals.
        let adjoint = match side {
            Side::Sensor => F32s::splat(1.0),
            Side::Light => {
                let cos_in = at.direction.dot(at.geometric).abs();
                let shading_out = direction.dot(at.normal).abs();
                let flat = (cos_in - at.cos_i).abs().simd_lt(F32s::splat(1e-6));
                let ratio = at.cos_i * cos_out / (cos_in * shading_out);
                Real::select(flat, F32s::splat(1.0), ratio)
            }
        };
        let mut beta = [F32s::ZERO; N];
        for (n, beta) in beta.iter_mut().enumerate() {
            *beta = lanes::load(&self.paths.beta[n], row) * weight[n] * adjoint;
        }
        if M::DISPERSES {
            collapse(&mut beta, scattered.alone);
        }
        for (column, &beta) in self.paths.beta.iter_mut().zip(&beta) {
            lanes::store(column, row, self.end, beta);
        }
        direction.store(&mut self.departures.direction, row, self.end);
        self.paths.mis.depart_specular(row, self.end, cos_out);
    }
}
