//! Photon density estimation: merges vertices of sensor paths with the photons about them (paper,
//! equation 13). One scattering kernel acts at the merge, that of the sensor's vertex, on light
//! that arrives along the photon's direction.

use glam::Vec3A;

use crate::geometry::SurfaceColumns;
use crate::math::{F32s, LANES, Vector, lanes};
use crate::polarization::{Arrival, LightCarrier, Stokes};
use crate::scattering::painting::SceneAt;
use crate::scattering::phase::half_sine2;
use crate::scattering::surface::model::reflect;
use crate::scattering::vertex::{KeptLanes, LightLanes, Same, Scatterer, Vertices, for_scatterer};
use crate::scattering::{Met, Scene};
use crate::transport::clearing::{Clearing, Nearby};
use crate::transport::collapse::{has_collapsed, met_by_collapsed};
use crate::transport::measure::{measure_polarized, measure_unpolarized};
use crate::transport::sides::SensorSide;
use crate::transport::tables::measured::Measured;
use crate::transport::tables::paths::PathTable;
use crate::transport::tables::photon_grid::{PhotonGrid, PhotonVisitor};
use crate::transport::tables::photon_maps::PhotonMap;
use crate::transport::tables::photon_queries::{PhotonQueries, QueryOrder};
use crate::transport::tables::photons::{PATH_LENGTH_MAX, PhotonClass, PhotonTable};
use crate::transport::tables::states::LightState;
use crate::transport::{Arrived, LightModel};

/// Photons that a vertex merges with at most; where more are in reach, the kernel ends at the first
/// after so many, or nearer where they lie aside. Over what that encloses their sum is a density,
/// as it is over a kernel whose size they do not choose, where they lie evenly (a Poisson process).
/// Caustics are as sharp as their light is dense.
const CROWD: usize = 100;
/// Largest radius at the boundary of a medium, relative to its mean free path.
const BOUNDARY_OF_FREE_PATH: f32 = 0.25;

/// Merges rows that have arrived with the photons of their map whose paths have `length_max`
/// segments at most.
///
/// From: the photon maps, depolarize_sensor. To: the film.
/// Writes: measured, queries. Reads: arrived (paths, surfaces), map, scene.
pub fn merge_photons<const N: usize, M: LightModel<N>>(
    measured: &mut Measured<N>,
    queries: &mut PhotonQueries,
    arrived: &Arrived<N, M::Sensor>,
    (map, length_max): (&PhotonMap<N>, u32),
    scene: SceneAt<N>,
) {
    let &Arrived { paths, surfaces, event, ref rows, .. } = arrived;
    if map.grid.photons().len == 0 {
        return;
    }
    let PhotonQueries { order, around } = queries;
    order.sort(&surfaces.position, rows.clone(), map.grid.cells());
    let (per_volume, radius) = (map.per_volume(), map.radius);
    let (kernel, met) = (Kernel { per_volume, radius, around }, event.met);
    // What the gathering asks of the scene is the same wherever surfaces are painted.
    let whole = scene.scene;
    let gather = Gather { measured, paths, surfaces, scene: whole, kernel, met, length_max };
    let grid = &map.grid;
    let points = &surfaces.position;
    for_scatterer!(scene, event.met, all => merge::<N, M, _>(gather, grid, all, (order, points)));
}

fn merge<const N: usize, M: LightModel<N>, S: Scatterer<N>>(
    gather: Gather<N, M::Sensor>,
    grid: &PhotonGrid<N>,
    all: S,
    (order, points): (&QueryOrder, &[Vec<f32>; 3]),
) {
    let photons = grid.photons();
    if M::POLARIZED && S::POLARIZES {
        // Without states in common there is one per wavelength.
        if photons.class == PhotonClass::Stokes {
            let mut visitor = Polarizing::<N, true, S, _> { gather, all, photons };
            grid.gather(&mut visitor, order, points);
        } else {
            let mut visitor = Polarizing::<N, false, S, _> { gather, all, photons };
            grid.gather(&mut visitor, order, points);
        }
    } else if S::Vertices::IS_EVEN {
        grid.gather(&mut Even { gather, all }, order, points);
    } else {
        grid.gather(&mut Uneven { gather, all, photons }, order, points);
    }
}

/// The kernel of the density estimate.
struct Kernel<'a> {
    /// Reciprocal of the disk or ball, over the light paths.
    per_volume: f32,
    radius: f32,
    around: &'a mut Nearby,
}

/// What all merges read and write.
struct Gather<'a, const N: usize, C> {
    measured: &'a mut Measured<N>,
    paths: &'a PathTable<N, C>,
    surfaces: &'a SurfaceColumns,
    scene: &'a Scene<N>,
    kernel: Kernel<'a>,
    met: Met,
    /// Most segments of a photon's path.
    length_max: u32,
}

/// Photons whose directions are within `end` of `k_in`, as `half_sine2`, do not count: paths go on
/// there.
#[derive(Clone, Copy)]
struct Peak {
    k_in: Vector<F32s>,
    end: F32s,
}

impl Peak {
    /// The mask of the photons along `k_in` that count.
    #[inline(always)]
    fn leaves(&self, k_in: Vector<F32s>) -> F32s {
        half_sine2(k_in, self.k_in).simd_ge(self.end)
    }
}

impl<const N: usize, C: SensorSide<N>> Gather<'_, N, C> {
    /// Where photons within `radius`, which may be less than the kernel's, count about the vertex
    /// in row `query`.
    fn clearing(&mut self, query: usize, radius: f32) -> Clearing {
        let (center, accelerator) =
            (lanes::row_of(&self.surfaces.position, query), &self.scene.accelerator);
        let whole = self.kernel.radius / radius;
        let around = &mut self.kernel.around;
        if let Met::Medium(medium) = self.met {
            let at_boundary = BOUNDARY_OF_FREE_PATH / self.scene.medium(medium).reduced;
            let mut of = Clearing::in_medium(center, [radius, at_boundary], accelerator, around);
            of.gain *= whole.powi(3);
            return of;
        }
        let normal = Vec3A::from(lanes::row_of(&self.surfaces.geometric_normal, query));
        let direction = Vec3A::from(lanes::row_of(&self.paths.rays.direction, query));
        let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
        let shapes = (&**accelerator, self.scene.rims());
        let reach = (radius, self.surfaces.offset[query]);
        let mut of = Clearing::on_surface(center, normal, reach, shapes, around);
        of.gain *= whole.powi(2);
        of
    }

    /// The photons of the packet at `row` that count.
    #[inline(always)]
    fn counting(
        &self,
        clearing: &Option<Clearing>,
        photons: &PhotonTable<N>,
        row: usize,
        within: F32s,
    ) -> F32s {
        let Some(clearing) = clearing else { return F32s::splat(0.0) };
        let within = within & clearing.holds(Vector::load(&photons.position, row));
        if self.length_max >= PATH_LENGTH_MAX {
            return within;
        }
        within & photons.no_longer_than(row, self.length_max)
    }

    #[inline(always)]
    fn direction(&self, row: usize) -> Vector<F32s> {
        Vector::splat(lanes::row_of(&self.paths.rays.direction, row))
    }

    /// The peak of the vertex in row `query`.
    #[inline(always)]
    fn peak(&self, query: usize) -> Peak {
        let k_out = -self.direction(query);
        let k_in = match self.met {
            Met::Medium(_) => k_out,
            Met::Surface(_) => {
                let normal = lanes::row_of(&self.surfaces.shading_normal, query);
                reflect(k_out, Vector::splat(normal))
            }
        };
        let end = self.scene.peak_at(self.met, self.surfaces.primitive[query]);
        Peak { k_in, end: F32s::splat(end) }
    }

    /// What a row makes of a sum over photons that is to gain so much; `factor` is the same in all
    /// lanes.
    #[inline(always)]
    fn per_sum(&self, (row, gain): (usize, f32), factor: &[F32s; N]) -> [f32; N] {
        let mut values = [0.0; N];
        for (n, value) in values.iter_mut().enumerate() {
            let beta = self.paths.beta[n][row] * self.kernel.per_volume * gain;
            *value = beta * factor[n].to_array()[0];
        }
        values
    }

    /// Adds intensity that scatters towards the sensor, per `factor` of every wavelength.
    #[inline(always)]
    fn add(&mut self, (row, gain): (usize, f32), sums: &[F32s; N], factor: &[F32s; N]) {
        let mut value = self.per_sum((row, gain), factor);
        for (value, sum) in value.iter_mut().zip(sums) {
            *value *= sum.reduce_add();
        }
        let slot = self.paths.identity.slot[row] as usize;
        measure_unpolarized(self.measured, &self.paths.carriers, (row, slot), value);
    }
}

/// The powers of photons, by wavelength, as a path counts them that has `collapsed` or not.
#[inline(always)]
fn powers_met<const N: usize>(collapsed: bool, power: impl Fn(usize) -> F32s) -> [F32s; N] {
    let mut powers = [F32s::splat(0.0); N];
    for (n, value) in powers.iter_mut().enumerate() {
        *value = power(n);
    }
    if collapsed {
        powers[0] = met_by_collapsed::<N>(powers[0], powers[1 % N]);
    }
    powers
}

/// Surfaces that scatter alike whatever comes from the right side.
struct Even<'a, const N: usize, S, C> {
    gather: Gather<'a, N, C>,
    all: S,
}

/// The vertex at which photons are gathered.
struct SurfaceState<const N: usize> {
    /// None if no photons may be in reach.
    clearing: Option<Clearing>,
    sums: [F32s; N],
    /// Whether the path goes on at one wavelength.
    collapsed: bool,
    /// Normals, turned to the side from which the sensor looks.
    geometric: Vector<F32s>,
    shading: Vector<F32s>,
}

impl<const N: usize, S: Scatterer<N>, C: SensorSide<N>> PhotonVisitor<N> for Even<'_, N, S, C> {
    type State = SurfaceState<N>;

    const CROWD: usize = CROWD;

    fn enclose(&mut self, state: &mut Self::State, query: usize, radius: f32) {
        state.clearing = Some(self.gather.clearing(query, radius));
    }

    #[inline(always)]
    fn begin(&mut self, query: usize) -> SurfaceState<N> {
        let Gather { surfaces, .. } = &self.gather;
        let given = -self.gather.direction(query);
        let turned = |normal: Vector<F32s>| {
            let away = given.dot(normal).simd_lt(F32s::splat(0.0));
            Vector::select(away, -normal, normal)
        };
        SurfaceState {
            clearing: None,
            sums: [F32s::splat(0.0); N],
            collapsed: has_collapsed(&self.gather.paths.beta, query),
            geometric: turned(Vector::splat(lanes::row_of(&surfaces.geometric_normal, query))),
            shading: turned(Vector::splat(lanes::row_of(&surfaces.shading_normal, query))),
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
        let within = self.gather.counting(&state.clearing, photons, row, within);
        let direction = photons.directions_of_any_length(row);
        let zero = F32s::splat(0.0);
        let geometric = direction.dot(state.geometric);
        let arrives = within & geometric.simd_lt(zero);
        let powers = powers_met(state.collapsed, |n| lanes::load(&photons.power[n], row));
        if !self.gather.scene.has_shading_normals {
            for (sum, &power) in state.sums.iter_mut().zip::<&[F32s; N]>(&powers) {
                *sum += arrives & power;
            }
            return;
        }
        // Photons count by the geometric normal, and the integral asks for the shading normal.
        let shading = direction.dot(state.shading);
        let arrives = arrives & shading.simd_lt(zero);
        let ratio = shading / geometric;
        for (sum, &power) in state.sums.iter_mut().zip::<&[F32s; N]>(&powers) {
            *sum += arrives & (power * ratio);
        }
    }

    #[inline(always)]
    fn finish(&mut self, row: usize, state: SurfaceState<N>) {
        let Some(Clearing { gain, .. }) = state.clearing else { return };
        let gather = &self.gather;
        let vertex = self.all.at(gather.surfaces, Same(row));
        let KeptLanes { facing, .. } = vertex.keep();
        let given = -gather.direction(row);
        // The normals themselves stand for a direction that passes wherever any does.
        let towards = Vector::select(
            given.dot(facing.geometric).simd_lt(F32s::splat(0.0)),
            -(facing.geometric + facing.shading),
            facing.geometric + facing.shading,
        );
        let reflects = facing.reflects(given, towards);
        let factor = vertex.per_photon().map(|factor| reflects & factor);
        self.gather.add((row, gain), &state.sums, &factor);
    }
}

/// What scatters differently by directions: depolarizing, or in scalar renders.
struct Uneven<'a, const N: usize, S, C> {
    gather: Gather<'a, N, C>,
    all: S,
    photons: &'a PhotonTable<N>,
}

/// A vertex that waits for photons.
struct UnevenState<V, S> {
    /// None if no photons may be in reach.
    clearing: Option<Clearing>,
    vertex: V,
    /// Whether the path goes on at one wavelength.
    collapsed: bool,
    sums: S,
    pending: Pending,
    peak: Peak,
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

/// Adds what the photons `rows` in the mask scatter along `k_out`, but for those in the `peak`.
#[inline(always)]
fn add_scattered<const N: usize>(
    sums: &mut [F32s; N],
    (vertex, collapsed): (&impl Vertices<N>, bool),
    photons: &PhotonTable<N>,
    (k_out, peak): (Vector<F32s>, Peak),
    (rows, within): (&[u32; LANES], F32s),
) {
    let k_in = photons.directions_of(rows);
    let within = within & peak.leaves(k_in);
    let scattered = vertex.merge(k_in, k_out);
    let powers: [F32s; N] = powers_met(collapsed, |n| photons.power_of(rows, n));
    for (n, sum) in sums.iter_mut().enumerate() {
        *sum += within & (powers[n] * scattered[n]);
    }
}

impl<const N: usize, S: Scatterer<N>, C: SensorSide<N>> PhotonVisitor<N> for Uneven<'_, N, S, C> {
    type State = UnevenState<S::Vertices, [F32s; N]>;

    const CROWD: usize = CROWD;

    fn enclose(&mut self, state: &mut Self::State, query: usize, radius: f32) {
        state.clearing = Some(self.gather.clearing(query, radius));
    }

    #[inline(always)]
    fn begin(&mut self, query: usize) -> Self::State {
        let k_out = -self.gather.direction(query);
        UnevenState {
            clearing: None,
            vertex: self.all.at(self.gather.surfaces, Same(query)),
            collapsed: has_collapsed(&self.gather.paths.beta, query),
            sums: [F32s::splat(0.0); N],
            pending: Pending::default(),
            peak: self.gather.peak(query),
            k_out,
            axis: k_out,
        }
    }

    #[inline(always)]
    fn visit(
        &mut self,
        state: &mut Self::State,
        row: usize,
        within: F32s,
        photons: &PhotonTable<N>,
    ) {
        let UnevenState { clearing, vertex, collapsed, sums, pending, peak, k_out, .. } = state;
        let within = self.gather.counting(clearing, photons, row, within);
        pending.add(row, within, |rows, within| {
            let at = (&*vertex, *collapsed);
            add_scattered(sums, at, photons, (*k_out, *peak), (rows, within));
        });
    }

    #[inline(always)]
    fn finish(&mut self, row: usize, state: Self::State) {
        let UnevenState { clearing, vertex, collapsed, mut sums, pending, peak, k_out, .. } = state;
        let Some(Clearing { gain, .. }) = clearing else { return };
        pending.finish(|rows, within| {
            let at = (&vertex, collapsed);
            add_scattered(&mut sums, at, self.photons, (k_out, peak), (rows, within));
        });
        self.gather.add((row, gain), &sums, &vertex.per_photon());
    }
}

/// What polarizes, in polarized renders; with `COMMON`, photons have one state for all
/// wavelengths.
struct Polarizing<'a, const N: usize, const COMMON: bool, S, C> {
    gather: Gather<'a, N, C>,
    all: S,
    photons: &'a PhotonTable<N>,
}

/// Adds the Stokes vectors that the photons `rows` in the mask scatter along `k_out`, in the frame
/// of `axis_out`, but for those in the `peak`.
#[inline(always)]
fn add_polarized<const N: usize, const COMMON: bool>(
    sums: &mut [Stokes<F32s>; N],
    (vertex, collapsed): (&impl Vertices<N>, bool),
    photons: &PhotonTable<N>,
    (k_out, axis_out, peak): (Vector<F32s>, Vector<F32s>, Peak),
    (rows, within): (&[u32; LANES], F32s),
) {
    let k_in = photons.directions_of(rows);
    let within = within & peak.leaves(k_in);
    if vertex.is_dense() {
        let out = [k_in, k_out, axis_out];
        return add_densely::<N, COMMON>(sums, (vertex, collapsed), photons, out, (rows, within));
    }
    let (shares, (kernels, axis)) = vertex.merge_polarized(k_in, k_out);
    let x = k_in.any_perpendicular();
    let arrival = Arrival::between(x, axis, k_in);
    let to_sums = Arrival::between(axis, axis_out, k_out);
    let arrived = |n: usize| {
        let [s1, s2, s3] = photons.states_of(rows, n);
        LightCarrier { stokes: Stokes([F32s::splat(1.0), s1, s2, s3]), x }.turned(&arrival)
    };
    let common = arrived(0);
    let powers: [F32s; N] = powers_met(collapsed, |n| photons.power_of(rows, n));
    for (n, Stokes(sums)) in sums.iter_mut().enumerate() {
        let light = if COMMON || n == 0 { common } else { arrived(n) };
        let Stokes(scattered) = light.pass(kernels[n]).turned(&to_sums).stokes;
        let power = within & (powers[n] * shares[n]);
        for (sum, &component) in sums.iter_mut().zip(&scattered) {
            *sum = power.mul_add(component, *sum);
        }
    }
}

/// [`add_polarized`] at vertices with dense kernels.
#[inline(never)]
fn add_densely<const N: usize, const COMMON: bool>(
    sums: &mut [Stokes<F32s>; N],
    (vertex, collapsed): (&impl Vertices<N>, bool),
    photons: &PhotonTable<N>,
    [k_in, k_out, axis_out]: [Vector<F32s>; 3],
    (rows, within): (&[u32; LANES], F32s),
) {
    let arrived = |n: usize| {
        let [s1, s2, s3] = photons.states_of(rows, if COMMON { 0 } else { n });
        Stokes([F32s::splat(1.0), s1, s2, s3])
    };
    let stokes = std::array::from_fn(arrived);
    let mut light = LightLanes { stokes, x: k_in.any_perpendicular() };
    vertex.scatter(k_in, k_out, &mut light);
    let to_sums = Arrival::between(light.x, axis_out, k_out);
    let shares = vertex.merge(k_in, k_out);
    let powers: [F32s; N] = powers_met(collapsed, |n| photons.power_of(rows, n));
    for (n, Stokes(sums)) in sums.iter_mut().enumerate() {
        let leaving = LightCarrier { stokes: light.stokes[n], x: light.x };
        let Stokes(scattered) = leaving.turned(&to_sums).stokes;
        let power = within & (powers[n] * shares[n]);
        for (sum, &component) in sums.iter_mut().zip(&scattered) {
            *sum = power.mul_add(component, *sum);
        }
    }
}

impl<const N: usize, const COMMON: bool, S: Scatterer<N>, C: SensorSide<N>> PhotonVisitor<N>
    for Polarizing<'_, N, COMMON, S, C>
{
    type State = UnevenState<S::Vertices, [Stokes<F32s>; N]>;

    const CROWD: usize = CROWD;

    fn enclose(&mut self, state: &mut Self::State, query: usize, radius: f32) {
        state.clearing = Some(self.gather.clearing(query, radius));
    }

    #[inline(always)]
    fn begin(&mut self, query: usize) -> Self::State {
        let k_out = -self.gather.direction(query);
        UnevenState {
            clearing: None,
            vertex: self.all.at(self.gather.surfaces, Same(query)),
            collapsed: has_collapsed(&self.gather.paths.beta, query),
            sums: [Stokes([F32s::splat(0.0); 4]); N],
            pending: Pending::default(),
            peak: self.gather.peak(query),
            k_out,
            axis: k_out.any_perpendicular(),
        }
    }

    #[inline(always)]
    fn visit(
        &mut self,
        state: &mut Self::State,
        row: usize,
        within: F32s,
        photons: &PhotonTable<N>,
    ) {
        let UnevenState { clearing, vertex, collapsed, sums, pending, peak, k_out, axis } = state;
        let within = self.gather.counting(clearing, photons, row, within);
        pending.add(row, within, |rows, within| {
            let (at, out) = ((&*vertex, *collapsed), (*k_out, *axis, *peak));
            add_polarized::<N, COMMON>(sums, at, photons, out, (rows, within));
        });
    }

    #[inline(always)]
    fn finish(&mut self, row: usize, state: Self::State) {
        let UnevenState { clearing, vertex, collapsed, mut sums, pending, peak, k_out, axis } =
            state;
        let Some(Clearing { gain, .. }) = clearing else { return };
        pending.finish(|rows, within| {
            let (at, out) = ((&vertex, collapsed), (k_out, axis, peak));
            add_polarized::<N, COMMON>(&mut sums, at, self.photons, out, (rows, within));
        });
        let gather = &mut self.gather;
        let value = gather.per_sum((row, gain), &vertex.per_photon());
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
