//! Photon density estimation: merges vertices of sensor paths with the photons about them (paper,
//! equation 13). One scattering kernel acts at the merge, that of the sensor's vertex, on light
//! that arrives along the photon's direction.

use std::ops::Range;

use crate::geometry::SurfaceColumns;
use crate::math::{F32s, LANES, Vector, lanes};
use crate::polarization::{Arrival, LightCarrier, Stokes};
use crate::scattering::event::Event;
use crate::scattering::medium::{Medium, PhaseFunction, PhaseLookup, half_sine2};
use crate::scattering::phase::Scatters;
use crate::scattering::vertex::VertexLanes;
use crate::scattering::{Met, Scene};
use crate::transport::LightModel;
use crate::transport::measure::{measure_polarized, measure_unpolarized};
use crate::transport::sides::SensorSide;
use crate::transport::tables::measured::Measured;
use crate::transport::tables::paths::PathTable;
use crate::transport::tables::photon_grid::{PhotonGrid, PhotonVisitor};
use crate::transport::tables::photon_maps::PhotonMap;
use crate::transport::tables::photon_queries::QueryOrder;
use crate::transport::tables::photons::{PATH_LENGTH_MAX, PhotonClass, PhotonTable};
use crate::transport::tables::states::LightState;
use crate::transport::vertex::on_surface;

/// Merges the rows `rows`, which have met `event`, with the photons of their map whose paths have
/// `length_max` segments at most.
///
/// From: the photon maps, depolarize_sensor. To: the film.
/// Writes: measured, order. Reads: paths, surfaces, map, scene.
pub fn merge_photons<const N: usize, M: LightModel<N>>(
    measured: &mut Measured<N>,
    order: &mut QueryOrder,
    paths: &PathTable<N, M::Sensor>,
    surfaces: &SurfaceColumns,
    (map, length_max): (&PhotonMap<N>, u32),
    scene: &Scene<N>,
    (event, rows): (Event, Range<usize>),
) {
    if map.grid.photons().len == 0 {
        return;
    }
    order.sort(&surfaces.position, rows, map.grid.cells());
    let per_volume = map.per_volume();
    let gather = Gather { measured, paths, surfaces, scene, per_volume, length_max };
    let grid = &map.grid;
    let points = &surfaces.position;
    match event.met {
        Met::Surface(_) => grid.gather(&mut OnSurface(gather), order, points),
        Met::Medium(row) => {
            let medium = scene.medium(row);
            match &medium.phase {
                PhaseFunction::Table(table) if M::POLARIZED => {
                    merge_polarized(gather, grid, medium, table, (order, points));
                }
                PhaseFunction::Table(_) | PhaseFunction::HenyeyGreenstein(_) => {
                    let photons = grid.photons();
                    grid.gather(&mut InVolume { gather, medium, photons }, order, points);
                }
            }
        }
    }
}

fn merge_polarized<const N: usize, C: SensorSide<N>>(
    gather: Gather<N, C>,
    grid: &PhotonGrid<N>,
    medium: &Medium<N>,
    table: &PhaseLookup<N>,
    (order, points): (&QueryOrder, &[Vec<f32>; 3]),
) {
    let photons = grid.photons();
    // Without states in common there is one per wavelength.
    if grid.photons().class == PhotonClass::Stokes {
        let mut visitor = Polarizing::<N, true, C> { gather, medium, table, photons };
        grid.gather(&mut visitor, order, points);
    } else {
        let mut visitor = Polarizing::<N, false, C> { gather, medium, table, photons };
        grid.gather(&mut visitor, order, points);
    }
}

/// What all merges read and write.
struct Gather<'a, const N: usize, C> {
    measured: &'a mut Measured<N>,
    paths: &'a PathTable<N, C>,
    surfaces: &'a SurfaceColumns,
    scene: &'a Scene<N>,
    /// The kernel of the density estimate: reciprocal of the disk or ball, over the light paths.
    per_volume: f32,
    /// Most segments of a photon's path.
    length_max: u32,
}

impl<const N: usize, C: SensorSide<N>> Gather<'_, N, C> {
    /// The photons of the packet at `row` that count.
    #[inline(always)]
    fn counting(&self, photons: &PhotonTable<N>, row: usize, within: F32s) -> F32s {
        if self.length_max >= PATH_LENGTH_MAX {
            return within;
        }
        within & photons.no_longer_than(row, self.length_max)
    }

    #[inline(always)]
    fn direction(&self, row: usize) -> Vector<F32s> {
        Vector::splat(lanes::row_of(&self.paths.rays.direction, row))
    }

    /// Adds intensity that scatters towards the sensor, per `factor` of every wavelength.
    #[inline(always)]
    fn add(&mut self, row: usize, sums: &[F32s; N], factor: impl Fn(usize) -> f32) {
        let mut value = [0.0; N];
        for (n, value) in value.iter_mut().enumerate() {
            let beta = self.paths.beta[n][row] * self.per_volume;
            *value = beta * factor(n) * sums[n].reduce_add();
        }
        let slot = self.paths.identity.slot[row] as usize;
        measure_unpolarized(self.measured, &self.paths.carriers, (row, slot), value);
    }
}

/// Adds the powers of the packet at `row` to `sums`, for photons in the mask.
#[inline(always)]
fn add_powers<const N: usize>(
    sums: &mut [F32s; N],
    photons: &PhotonTable<N>,
    row: usize,
    within: F32s,
) {
    for (sum, power) in sums.iter_mut().zip(&photons.power) {
        *sum += within & lanes::load(power, row);
    }
}

/// Diffuse surfaces: whatever comes from the right side counts alike.
struct OnSurface<'a, const N: usize, C>(Gather<'a, N, C>);

/// The vertex at which photons are gathered.
struct SurfaceState<const N: usize> {
    query: usize,
    sums: [F32s; N],
    /// Normals, turned to the side from which the sensor looks.
    geometric: Vector<F32s>,
    shading: Vector<F32s>,
}

impl<const N: usize, C: SensorSide<N>> PhotonVisitor<N> for OnSurface<'_, N, C> {
    type State = SurfaceState<N>;

    #[inline(always)]
    fn begin(&mut self, query: usize) -> SurfaceState<N> {
        let given = -self.0.direction(query);
        let turned = |normal: Vector<F32s>| {
            let away = given.dot(normal).simd_lt(F32s::splat(0.0));
            Vector::select(away, -normal, normal)
        };
        SurfaceState {
            query,
            sums: [F32s::splat(0.0); N],
            geometric: turned(Vector::splat(lanes::row_of(
                &self.0.surfaces.geometric_normal,
                query,
            ))),
            shading: turned(Vector::splat(lanes::row_of(&self.0.surfaces.shading_normal, query))),
        }
    }

    #[inline(always)]
    fn visit(
        &mut self,
        state: &mut SurfaceState<N>,
        row: usize,
        within: F32s,
        photons: &PhotonTable<N>,
    ) {
        let within = self.0.counting(photons, row, within);
        let direction = photons.directions_of_any_length(row);
        let zero = F32s::splat(0.0);
        let geometric = direction.dot(state.geometric);
        let arrives = within & geometric.simd_lt(zero);
        if !self.0.scene.has_shading_normals {
            return add_powers(&mut state.sums, photons, row, arrives);
        }
        // Photons count by the geometric normal, and the integral asks for the shading normal.
        let shading = direction.dot(state.shading);
        let arrives = arrives & shading.simd_lt(zero);
        let ratio = shading / geometric;
        for (sum, power) in state.sums.iter_mut().zip(&photons.power) {
            *sum += arrives & (lanes::load(power, row) * ratio);
        }
    }

    #[inline(always)]
    fn finish(&mut self, row: usize, state: SurfaceState<N>) {
        let gather = &self.0;
        let normal = lanes::row_of(&gather.surfaces.geometric_normal, state.query);
        let vertex = on_surface(gather.surfaces, gather.scene, normal, row);
        let VertexLanes::Surface { facing, brdf } = vertex else {
            return;
        };
        let given = -gather.direction(row);
        // The normals themselves stand for a direction that passes wherever any does.
        let towards = Vector::select(
            given.dot(facing.geometric).simd_lt(F32s::splat(0.0)),
            -(facing.geometric + facing.shading),
            facing.geometric + facing.shading,
        );
        let reflects = facing.reflects(given, towards);
        let brdf = brdf.map(|brdf| (reflects & brdf).to_array()[0]);
        self.0.add(row, &state.sums, |n| brdf[n]);
    }
}

/// Media that depolarize, or scalar renders of others.
struct InVolume<'a, const N: usize, C> {
    gather: Gather<'a, N, C>,
    medium: &'a Medium<N>,
    photons: &'a PhotonTable<N>,
}

/// A vertex in a medium.
struct VolumeState<S> {
    sums: S,
    pending: Pending,
    /// Where light leaves towards the sensor.
    k_out: Vector<F32s>,
    /// The x axis of the frame in which Stokes vectors are summed.
    axis: Vector<F32s>,
}

/// Rows of photons in reach that wait until there are eight. A ball holds a fifteenth of what the
/// cells about it do, so that packets as they are found hardly have more than one.
#[derive(Default)]
struct Pending {
    rows: [u32; LANES],
    len: usize,
}

impl Pending {
    /// Adds the rows in the mask, and calls `work` whenever there are eight.
    #[inline(always)]
    fn add(&mut self, first_row: usize, within: F32s, mut work: impl FnMut(&[u32; LANES], F32s)) {
        let mut bits = within.to_bitmask();
        while bits != 0 {
            self.rows[self.len] = first_row as u32 + bits.trailing_zeros();
            self.len += 1;
            bits &= bits - 1;
            if self.len == LANES {
                self.len = 0;
                work(&self.rows, lanes::first(LANES));
            }
        }
    }

    /// Calls `work` for what is left.
    #[inline(always)]
    fn finish(mut self, mut work: impl FnMut(&[u32; LANES], F32s)) {
        if self.len > 0 {
            let any = self.rows[0];
            self.rows[self.len..].fill(any);
            work(&self.rows, lanes::first(self.len));
        }
    }
}

/// What turns the power of photons, which counts scatterings, into fluence.
#[inline(always)]
fn per_scattering<const N: usize>(medium: &Medium<N>, n: usize) -> f32 {
    let sigma_s = medium.sigma_s[n];
    if sigma_s > 0.0 { 1.0 / sigma_s } else { 0.0 }
}

/// Adds what the photons `rows` in the mask scatter along `k_out`.
#[inline(always)]
fn add_scattered<const N: usize>(
    sums: &mut [F32s; N],
    medium: &Medium<N>,
    photons: &PhotonTable<N>,
    k_out: Vector<F32s>,
    (rows, within): (&[u32; LANES], F32s),
) {
    let angle = half_sine2(photons.directions_of(rows), k_out);
    let phase = medium.phase.values(angle);
    for (n, (sum, &phase)) in sums.iter_mut().zip(&phase).enumerate() {
        *sum += within & (photons.power_of(rows, n) * phase);
    }
}

impl<const N: usize, C: SensorSide<N>> PhotonVisitor<N> for InVolume<'_, N, C> {
    type State = VolumeState<[F32s; N]>;

    #[inline(always)]
    fn begin(&mut self, query: usize) -> Self::State {
        let k_out = -self.gather.direction(query);
        let sums = [F32s::splat(0.0); N];
        VolumeState { sums, pending: Pending::default(), k_out, axis: k_out }
    }

    #[inline(always)]
    fn visit(
        &mut self,
        state: &mut Self::State,
        row: usize,
        within: F32s,
        photons: &PhotonTable<N>,
    ) {
        let VolumeState { sums, pending, k_out, .. } = state;
        let within = self.gather.counting(photons, row, within);
        pending.add(row, within, |rows, within| {
            add_scattered(sums, self.medium, photons, *k_out, (rows, within));
        });
    }

    #[inline(always)]
    fn finish(&mut self, row: usize, state: Self::State) {
        let VolumeState { mut sums, pending, k_out, .. } = state;
        let (medium, photons) = (self.medium, self.photons);
        pending.finish(|rows, within| {
            add_scattered(&mut sums, medium, photons, k_out, (rows, within));
        });
        self.gather.add(row, &sums, |n| per_scattering(medium, n));
    }
}

/// Polarizing media in polarized renders; with `COMMON`, photons have one state for all
/// wavelengths.
struct Polarizing<'a, const N: usize, const COMMON: bool, C> {
    gather: Gather<'a, N, C>,
    medium: &'a Medium<N>,
    table: &'a PhaseLookup<N>,
    photons: &'a PhotonTable<N>,
}

/// Adds the Stokes vectors that the photons `rows` in the mask scatter along `k_out`, in the frame
/// of `axis_out`.
#[inline(always)]
fn add_polarized<const N: usize, const COMMON: bool>(
    sums: &mut [Stokes<F32s>; N],
    table: &PhaseLookup<N>,
    photons: &PhotonTable<N>,
    (k_out, axis_out): (Vector<F32s>, Vector<F32s>),
    (rows, within): (&[u32; LANES], F32s),
) {
    let k_in = photons.directions_of(rows);
    let (phase, kernels) = table.values_and_kernels(half_sine2(k_in, k_out));
    // Its length does not matter, and where it vanishes, forwards, no turn is needed.
    let axis = k_in.cross(k_out);
    let x = k_in.any_perpendicular();
    let arrival = Arrival::between(x, axis, k_in);
    let to_sums = Arrival::between(axis, axis_out, k_out);
    let arrived = |n: usize| {
        let [s1, s2, s3] = photons.states_of(rows, n);
        LightCarrier { stokes: Stokes([F32s::splat(1.0), s1, s2, s3]), x }.turned(&arrival)
    };
    let common = arrived(0);
    for (n, Stokes(sums)) in sums.iter_mut().enumerate() {
        let light = if COMMON || n == 0 { common } else { arrived(n) };
        let Stokes(scattered) = light.pass(kernels[n]).turned(&to_sums).stokes;
        let power = within & (photons.power_of(rows, n) * phase[n]);
        for (sum, &component) in sums.iter_mut().zip(&scattered) {
            *sum = power.mul_add(component, *sum);
        }
    }
}

impl<const N: usize, const COMMON: bool, C: SensorSide<N>> PhotonVisitor<N>
    for Polarizing<'_, N, COMMON, C>
{
    type State = VolumeState<[Stokes<F32s>; N]>;

    #[inline(always)]
    fn begin(&mut self, query: usize) -> Self::State {
        let k_out = -self.gather.direction(query);
        let sums = [Stokes([F32s::splat(0.0); 4]); N];
        let axis = k_out.any_perpendicular();
        VolumeState { sums, pending: Pending::default(), k_out, axis }
    }

    #[inline(always)]
    fn visit(
        &mut self,
        state: &mut Self::State,
        row: usize,
        within: F32s,
        photons: &PhotonTable<N>,
    ) {
        let VolumeState { sums, pending, k_out, axis } = state;
        let within = self.gather.counting(photons, row, within);
        pending.add(row, within, |rows, within| {
            let out = (*k_out, *axis);
            add_polarized::<N, COMMON>(sums, self.table, photons, out, (rows, within));
        });
    }

    #[inline(always)]
    fn finish(&mut self, row: usize, state: Self::State) {
        let VolumeState { mut sums, pending, k_out, axis } = state;
        pending.finish(|rows, within| {
            let out = (k_out, axis);
            add_polarized::<N, COMMON>(&mut sums, self.table, self.photons, out, (rows, within));
        });
        let gather = &mut self.gather;
        let mut value = [0.0; N];
        for (n, value) in value.iter_mut().enumerate() {
            let beta = gather.paths.beta[n][row] * gather.per_volume;
            *value = beta * per_scattering(self.medium, n);
        }
        let light = LightState { stokes: sums.map(total), x: axis.lane(0) };
        let place = (row, gather.paths.identity.slot[row] as usize);
        let along = (k_out.lane(0), gather.scene.sensor.up());
        let carriers = &gather.paths.carriers;
        measure_polarized(gather.measured, carriers, place, value, &light, along);
    }
}

/// The sum over the lanes.
#[inline(always)]
fn total(Stokes([s0, s1, s2, s3]): Stokes<F32s>) -> Stokes<f32> {
    Stokes([s0.reduce_add(), s1.reduce_add(), s2.reduce_add(), s3.reduce_add()])
}
