//! Sends the rows at surfaces on, and writes the Mueller kernels of those events where they are
//! wanted: one loop for every model.

use std::ops::Range;

use glam::Vec3;

use crate::geometry::{RayColumns, SurfaceColumns};
use crate::math::columns::Channels;
use crate::math::{F32s, LANES, Real, Vector, lanes};
use crate::scattering::event::{Elements, Form};
use crate::scattering::nesting::InterfaceLanes;
use crate::scattering::painting::SceneAt;
use crate::scattering::surface::model::{Choice, Incidence, LaneRows, OneOfTwo, Scattered};
use crate::scattering::surface::{Connecting, ModelLanes, Specular, SurfaceKind, for_scattering};
use crate::scattering::vertex::{Consecutive, OnSurfaces};
use crate::scattering::{Met, Scene, Side};
use crate::transport::collapse::{collapse, have_collapsed};
use crate::transport::mis::TurnDensities;
use crate::transport::sampler::Purpose;
use crate::transport::tables::carriers::{CarrierTable, Lean, lean_of, ratio};
use crate::transport::tables::kernels::DepartureColumns;
use crate::transport::tables::media::MediaColumns;
use crate::transport::tables::partition::Partition;
use crate::transport::tables::paths::{IdentityColumns, MisColumns, NestedColumns, PathTable};
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
        let PathTable { rays, identity, beta, mis, media, nested, carriers, .. } = &mut *paths;
        let lean = |row: usize, frame| lean_of(carriers, part, row, frame);
        let leans = POLARIZED && bounce.sampling == Sampling::Stokes && C::leans(part);
        let lean: Option<&Lean<N>> = if leans { Some(&lean) } else { None };
        let end = part.rows.end;
        let mut to = Departing { departures, rays, identity, beta, mis, media, nested, lean, end };
        scatter_part::<N, POLARIZED>(&mut to, surfaces, scene, (kind, &part.rows), bounce);
    }
}

/// What is written of rows, and read.
struct Departing<'a, const N: usize> {
    departures: &'a mut DepartureColumns<N>,
    rays: &'a RayColumns,
    identity: &'a IdentityColumns,
    beta: &'a mut Channels<N>,
    mis: &'a mut MisColumns,
    media: &'a mut MediaColumns<N>,
    nested: &'a mut NestedColumns,
    /// Where it steers which of two ways paths go.
    lean: Option<&'a Lean<'a, N>>,
    /// The end of the rows.
    end: usize,
}

/// Rows that have met surfaces of one kind.
#[inline(never)]
fn scatter_part<const N: usize, const POLARIZED: bool>(
    to: &mut Departing<N>,
    surfaces: &SurfaceColumns,
    scene: SceneAt<N>,
    (kind, rows): (SurfaceKind, &Range<usize>),
    bounce: Bounce,
) {
    for_scattering!(scene.surfaces, kind, models => {
        specular: {
            let all = (&*scene, models);
            send_on::<N, POLARIZED, _>(to, all, surfaces, rows.clone(), bounce);
            if scene.has_stains {
                to.stain(surfaces, &scene, rows.clone());
            }
        },
        connecting: {
            let all = OnSurfaces::new(&scene, models);
            let may_pass = kind.passes_any_way() && scene.passes_any_way;
            let beyond = may_pass.then_some(&*scene);
            scatter::<N, POLARIZED, _>(to, all, (surfaces, beyond), rows.clone(), bounce);
        },
        else: {},
    });
}

/// How much of a choice unpolarized light decides, whatever the path carries: no way is closed by
/// rounding to light that goes it.
const EVEN_SHARE: f32 = 1.0 / 64.0;

/// One way, or two.
fn send_on<const N: usize, const POLARIZED: bool, M: Specular<N>>(
    to: &mut Departing<N>,
    (scene, models): (&Scene<N>, &[M]),
    surfaces: &SurfaceColumns,
    rows: Range<usize>,
    bounce: Bounce,
) {
    for row in rows.clone().step_by(LANES) {
        let some = (row, LANES.min(rows.end - row));
        let mut at = Incidence::load(scene, models, surfaces, to.rays, some);
        let given = at.models.rows;
        let nested = if M::NESTS { to.interfaces(&given, surfaces, scene, some) } else { None };
        if let Some(InterfaceLanes { rows, .. }) = &nested {
            at.models = ModelLanes::new(models, *rows);
        }
        if M::DISPERSES && N > 1 {
            at.collapsed = have_collapsed(lanes::load(&to.beta[1], row));
        }
        let choose = |way: OneOfTwo| {
            let u = to.identity.draw_first(row, bounce.path_length, Purpose::Decision);
            match to.lean {
                Some(lean) if POLARIZED => to.choose_by_light(lean, u, &way, (row, bounce.side)),
                Some(_) | None => Choice { first: u.simd_lt(way.share), gain: F32s::ONE },
            }
        };
        let scattered = M::scatter::<POLARIZED>(&at, choose, bounce.side);
        if POLARIZED {
            to.departures.kernels.store_events(
                (M::Kernel::FORM, M::ACHROMATIC),
                (&scattered.kernels, scattered.axis),
                (row, to.end),
            );
        }
        to.enter(surfaces, scene, &scattered.direction, (row, nested));
        let Scattered { direction, ref weight, alone, .. } = scattered;
        let met = (at.geometric, at.normal, at.cos_i);
        let alone = M::DISPERSES.then_some(alone);
        to.depart_specular([at.direction, direction], met, (weight, alone), (bounce.side, row));
    }
}

/// Any way; if that may be through the surfaces, what is `beyond` is of this scene.
fn scatter<const N: usize, const POLARIZED: bool, M: Connecting<N>>(
    to: &mut Departing<N>,
    all: OnSurfaces<M, N>,
    (surfaces, beyond): (&SurfaceColumns, Option<&Scene<N>>),
    rows: Range<usize>,
    bounce: Bounce,
) {
    let side = bounce.side;
    for row in rows.clone().step_by(LANES) {
        let [first, second] = to.identity.draw(row, bounce.path_length, Purpose::Direction);
        let third = match M::DECIDES {
            true => to.identity.draw_first(row, bounce.path_length, Purpose::Decision),
            false => F32s::ZERO,
        };
        let some = Consecutive(row, LANES.min(rows.end - row));
        let (of_model, facing) = all.load(surfaces, some);
        let of = all.models.lanes(&of_model);
        let before = Vector::load(&to.rays.direction, row);
        let given = -before;
        let drawn = all.models.draw((&of_model, &of), &facing, given, [first, second, third], side);
        let direction = drawn.direction;
        let scale = match side {
            Side::Sensor => F32s::splat(1.0),
            Side::Light => facing.adjoint(given, direction),
        };
        let passes = M::passes(&of, &facing, given, direction);
        for (beta, &weight) in to.beta.iter_mut().zip(&drawn.weight) {
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
        to.mis.depart(row, to.end, turn);
        if let Some(scene) = beyond {
            let Consecutive(row, live) = some;
            let nested = to.interfaces(&LaneRows::Same(0), surfaces, scene, (row, live));
            to.enter(surfaces, scene, &direction, (row, nested));
        }
    }
}

impl<const N: usize> Departing<'_, N> {
    /// Chooses one of two ways by what goes there of the light that paths carry, or accept.
    #[inline(always)]
    fn choose_by_light(
        &self,
        lean: &Lean<N>,
        u: F32s,
        way: &OneOfTwo,
        (row, side): (usize, Side),
    ) -> Choice {
        let before = Vector::load(&self.rays.direction, row);
        let k = match side {
            Side::Light => before,
            Side::Sensor => -before,
        };
        let mut light = [F32s::ZERO; 2];
        for (beta, [s0, s1]) in self.beta.iter().zip(&lean(row, (way.axis, k))) {
            let beta = lanes::load(beta, row);
            light = [beta.mul_add(*s0, light[0]), beta.mul_add(*s1, light[1])];
        }
        let one = F32s::ONE;
        let leans = way.diattenuation * ratio(light) * F32s::splat(1.0 - EVEN_SHARE);
        let share = (way.share * (one + leans)).min(one);
        let first = u.simd_lt(share);
        let gain = Real::select(first, one + leans, (one - share) / (one - way.share));
        Choice { first, gain }
    }

    /// Rows that have been sent on one way have what a stain leaves there.
    #[inline(never)]
    fn stain(&mut self, surfaces: &SurfaceColumns, scene: &Scene<N>, rows: Range<usize>) {
        for row in rows {
            let of = |columns| Vec3::from(lanes::row_of(columns, row));
            // Of triangles, too, it is by the point where they were hit.
            let (primitive, at) = (surfaces.primitive[row], of(&surfaces.position));
            let Some([reflected, transmitted]) = scene.stain_of_point(primitive, at) else {
                continue;
            };
            let normal = of(&surfaces.geometric_normal);
            let [before, after] = [of(&self.rays.direction), of(&self.departures.direction)]
                .map(|direction| direction.dot(normal));
            let left = if before * after > 0.0 { transmitted } else { reflected };
            for (beta, left) in self.beta.iter_mut().zip(left) {
                beta[row] *= left;
            }
        }
    }

    /// Rows that go through their surfaces are in what is there from now on.
    #[inline(never)]
    fn enter(
        &mut self,
        surfaces: &SurfaceColumns,
        scene: &Scene<N>,
        drawn: &Vector<F32s>,
        (row, nested): (usize, Option<InterfaceLanes>),
    ) {
        if self.media.present() {
            let behind = nested.as_ref().map_or([None; LANES], |nested| nested.behind);
            self.cross(surfaces, scene, drawn, (row, behind));
        }
        if let Some(InterfaceLanes { inside, .. }) = nested {
            self.go_through(surfaces, drawn, &inside, row);
        }
    }

    /// What rows have met that can be nested, in scenes where it is.
    #[inline(never)]
    fn interfaces(
        &self,
        given: &LaneRows,
        surfaces: &SurfaceColumns,
        scene: &Scene<N>,
        (row, live): (usize, usize),
    ) -> Option<InterfaceLanes> {
        let interfaces = scene.interfaces.as_ref()?;
        let paths = (self.rays, self.nested.inside.as_slice());
        let hits = lanes::each(|lane| row + lane.min(live - 1));
        Some(scene.interfaces_at(interfaces, surfaces, paths, hits, given))
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
            self.nested.inside[row + lane] = inside[lane][usize::from(passes[lane].0)];
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
        let before = Vector::load(&self.rays.direction, row).dot(normal).to_array();
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
                let inside = &mut self.media.inside[row + lane];
                let known = (*inside, solids[lane]);
                *inside = scene.medium_beyond(surfaces, row + lane, to_front, known);
            }
        }
    }

    /// Rows go on as they were sent by the surfaces that they have met: of these the geometric
    /// normal, the shading normal, and the cosine of arrival to it.
    #[inline(never)]
    fn depart_specular(
        &mut self,
        [before, direction]: [Vector<F32s>; 2],
        (geometric, normal, cos_i): (Vector<F32s>, Vector<F32s>, F32s),
        (weight, alone): (&[F32s; N], Option<F32s>),
        (side, row): (Side, usize),
    ) {
        let cos_out = direction.dot(geometric).abs();
        // Veach 1997, equation 5.19, for a direction that has the cosine of arrival (or Snell's
        // partner of it) to the shading normal on both sides; one without shading normals.
        let adjoint = match side {
            Side::Sensor => F32s::splat(1.0),
            Side::Light => {
                let cos_in = before.dot(geometric).abs();
                let shading_out = direction.dot(normal).abs();
                let flat = (cos_in - cos_i).abs().simd_lt(F32s::splat(1e-6));
                let ratio = cos_i * cos_out / (cos_in * shading_out);
                Real::select(flat, F32s::splat(1.0), ratio)
            }
        };
        let mut beta = [F32s::ZERO; N];
        for (n, beta) in beta.iter_mut().enumerate() {
            *beta = lanes::load(&self.beta[n], row) * weight[n] * adjoint;
        }
        if let Some(alone) = alone {
            collapse(&mut beta, alone);
        }
        for (column, &beta) in self.beta.iter_mut().zip(&beta) {
            lanes::store(column, row, self.end, beta);
        }
        direction.store(&mut self.departures.direction, row, self.end);
        self.mis.depart_specular(row, self.end, cos_out);
    }
}
