//! Scatters rows that have hit conductors, dielectrics, polarizers and retarders, and writes the
//! Mueller kernels of those events where they are wanted.

use crate::geometry::SurfaceColumns;
use crate::math::columns::Column;
use crate::math::{F32s, LANES, Real, Vector, lanes};
use crate::polarization::elements::transmission_axis;
use crate::polarization::kernel::Block;
use crate::polarization::{fresnel, s_axis};
use crate::scattering::specular::{against, reflect, refract};
use crate::scattering::{Met, Scene};
use crate::scene::baked::{Material, MaterialKind};
use crate::transport::sampler::{Purpose, draw};
use crate::transport::tables::kernels::{KernelColumns, StoredKernel};
use crate::transport::tables::partition::{Part, Partition};
use crate::transport::tables::paths::PathTable;

use crate::transport::bounce::{Bounce, Side};
use crate::transport::flight::beyond;

/// Sends the rows of all but the diffuse parts on.
///
/// With `POLARIZED`, also writes one kernel a row: achromatic ones to channel 0 only.
///
/// From: depolarize_sensor, depolarize_light. To: collect_sensor, scatter_light.
/// Writes: drawn, kernels, paths (beta, mis, media). Reads: paths, surfaces, scene, partition.
pub fn scatter_specular<const N: usize, const POLARIZED: bool, C>(
    drawn: &mut [Column; 3],
    kernels: &mut KernelColumns<N>,
    paths: &mut PathTable<N, C>,
    surfaces: &SurfaceColumns,
    scene: &Scene<N>,
    partition: &Partition,
    bounce: Bounce,
) {
    for part in partition.parts.iter().filter(|part| !part.event.connects()) {
        let end = part.rows.end;
        for row in part.rows.clone().step_by(LANES) {
            let live = LANES.min(end - row);
            let lanes = RowLanes::load(paths, surfaces, scene, row, live);
            let scattered = match part.event.met {
                Met::Surface(MaterialKind::Conductor) => {
                    conduct::<N, POLARIZED>(kernels, &lanes, part, row)
                }
                Met::Surface(MaterialKind::Dielectric) => {
                    dielectric::<N, POLARIZED, C>(kernels, paths, &lanes, part, row, bounce)
                }
                Met::Surface(MaterialKind::Polarizer | MaterialKind::Retarder) => {
                    pass::<N, POLARIZED>(kernels, surfaces, scene, &lanes, part, row)
                }
                Met::Surface(_) | Met::Medium(_) => continue,
            };
            if paths.media.present() {
                cross(paths, surfaces, scene, &scattered.direction, row, end);
            }
            depart(drawn, paths, &lanes, scattered, row, end, bounce.side);
        }
    }
}

/// Where a row has gone through its surface, it is in the medium on the other side from now on:
/// the one that the surface names.
#[inline(always)]
fn cross<const N: usize, C>(
    paths: &mut PathTable<N, C>,
    surfaces: &SurfaceColumns,
    scene: &Scene<N>,
    drawn: &Vector<F32s>,
    row: usize,
    end: usize,
) {
    let normal = Vector::load(&surfaces.geometric_normal, row);
    let before = Vector::load(&paths.rays.direction, row).dot(normal).to_array();
    let after = drawn.dot(normal).to_array();
    for lane in 0..LANES.min(end - row) {
        if before[lane] * after[lane] > 0.0 {
            let inside = &mut paths.media.inside[row + lane];
            *inside = beyond(scene, surfaces.primitive[row + lane], after[lane] > 0.0, *inside);
        }
    }
}

/// Eight rows at a specular surface.
struct RowLanes<'a, const N: usize> {
    direction: Vector<F32s>,
    geometric: Vector<F32s>,
    /// Shading normal, against the ray.
    normal: Vector<F32s>,
    cos_i: F32s,
    /// Mask of the rows that come from the front.
    front: F32s,
    scene: &'a Scene<N>,
    material: [usize; LANES],
}

impl<'a, const N: usize> RowLanes<'a, N> {
    #[inline(always)]
    fn load<C>(
        paths: &PathTable<N, C>,
        surfaces: &SurfaceColumns,
        scene: &'a Scene<N>,
        row: usize,
        live: usize,
    ) -> Self {
        let direction = Vector::load(&paths.rays.direction, row);
        let geometric = Vector::load(&surfaces.geometric_normal, row);
        let normal = against(Vector::load(&surfaces.shading_normal, row), direction);
        let material =
            lanes::each(|lane| scene.material_row(surfaces.primitive[row + lane.min(live - 1)]));
        Self {
            direction,
            geometric,
            normal,
            cos_i: (-direction.dot(normal)).min(F32s::splat(1.0)),
            front: direction.dot(geometric).simd_lt(F32s::splat(0.0)),
            scene,
            material,
        }
    }

    #[inline(always)]
    fn field(&self, of: impl Fn(&Material<N>) -> f32) -> F32s {
        let materials = &self.scene.optics.materials;
        F32s::from(lanes::each(|lane| of(&materials[self.material[lane]])))
    }
}

/// A new direction and what it costs.
struct Scattered<const N: usize> {
    direction: Vector<F32s>,
    weight: [F32s; N],
}

#[inline(always)]
fn conduct<const N: usize, const POLARIZED: bool>(
    kernels: &mut KernelColumns<N>,
    lanes: &RowLanes<N>,
    part: &Part,
    row: usize,
) -> Scattered<N> {
    let direction = reflect(lanes.direction, lanes.normal);
    let two_sided = lanes.field(|material| if material.two_sided { 1.0 } else { 0.0 });
    let faces = lanes.front | two_sided.simd_gt(F32s::splat(0.5));
    let stays = (direction.dot(lanes.geometric) * lanes.direction.dot(lanes.geometric))
        .simd_lt(F32s::splat(0.0));
    let mut weight = [F32s::splat(0.0); N];
    for (n, weight) in weight.iter_mut().enumerate() {
        let eta = lanes.field(|material| material.eta[n]);
        let k = lanes.field(|material| material.k[n]);
        let reflectance = if POLARIZED {
            let (reflectance, block) = fresnel::conductor(lanes.cos_i, eta, k);
            block.store(kernels, n, row, part.rows.end);
            reflectance
        } else {
            fresnel::conductor_reflectance(lanes.cos_i, eta, k)
        };
        *weight = faces & stays & reflectance;
    }
    if POLARIZED {
        let axis = s_axis(lanes.normal, lanes.direction);
        axis.store(&mut kernels.axis, row, part.rows.end);
    }
    Scattered { direction, weight }
}

#[inline(always)]
fn dielectric<const N: usize, const POLARIZED: bool, C>(
    kernels: &mut KernelColumns<N>,
    paths: &PathTable<N, C>,
    lanes: &RowLanes<N>,
    part: &Part,
    row: usize,
    bounce: Bounce,
) -> Scattered<N> {
    let seed = lanes::load_u32(&paths.identity.seed, row);
    let iteration = lanes::load_u32(&paths.identity.iteration, row);
    let [u, _] = draw(seed, iteration, bounce.path_length, Purpose::Decision);
    let ior = lanes.field(|material| material.ior);
    let one = F32s::splat(1.0);
    let eta = Real::select(lanes.front, ior, one / ior);
    let (reflectance, cos_t) = fresnel::dielectric_reflectance(lanes.cos_i, eta);
    let reflects = u.simd_lt(reflectance);
    if POLARIZED {
        let interface = fresnel::dielectric(lanes.cos_i, eta);
        let block = Block::select(reflects, interface.reflection, interface.transmission);
        block.store(kernels, 0, row, part.rows.end);
        let axis = s_axis(lanes.normal, lanes.direction);
        axis.store(&mut kernels.axis, row, part.rows.end);
    }
    let reflected = reflect(lanes.direction, lanes.normal);
    let refracted = refract(lanes.direction, lanes.normal, lanes.cos_i, cos_t, eta);
    let direction = Vector::select(reflects, reflected, refracted);
    // Radiance grows with the square of the index; importance, and power, do not.
    let squeeze = match bounce.side {
        Side::Sensor => Real::select(reflects, one, one / (eta * eta)),
        Side::Light => one,
    };
    let same_side = (direction.dot(lanes.geometric) * lanes.direction.dot(lanes.geometric))
        .simd_lt(F32s::splat(0.0));
    let consistent = !(same_side ^ reflects);
    Scattered { direction, weight: [consistent & squeeze; N] }
}

/// Straight on through a polarizer or retarder.
#[inline(always)]
fn pass<const N: usize, const POLARIZED: bool>(
    kernels: &mut KernelColumns<N>,
    surfaces: &SurfaceColumns,
    scene: &Scene<N>,
    lanes: &RowLanes<N>,
    part: &Part,
    row: usize,
) -> Scattered<N> {
    if POLARIZED {
        let block = Block {
            a: lanes.field(|material| material.a),
            c: lanes.field(|material| material.c),
            s: lanes.field(|material| material.s),
        };
        block.store(kernels, 0, row, part.rows.end);
        let axis = element_axis(surfaces, scene, lanes, row, part.rows.end);
        axis.store(&mut kernels.axis, row, part.rows.end);
    }
    Scattered { direction: lanes.direction, weight: [lanes.field(|material| material.m00); N] }
}

/// The axis of an element, turned within its surface and then laid across the light.
#[inline(always)]
fn element_axis<const N: usize>(
    surfaces: &SurfaceColumns,
    scene: &Scene<N>,
    lanes: &RowLanes<N>,
    row: usize,
    end: usize,
) -> Vector<F32s> {
    let surface = |lane: usize| {
        let surface = surfaces.surface[(row + lane).min(end - 1)];
        &scene.shapes.surfaces[surface as usize]
    };
    let node_x = Vector::gather(|lane| surface(lane).axis_x.to_array());
    let node_y = Vector::gather(|lane| surface(lane).axis_y.to_array());
    let normal = lanes.geometric;
    let project = |axis: Vector<F32s>| normal.mul_add(-axis.dot(normal), axis);
    let in_surface = project(node_x);
    let upright = in_surface.length_squared().simd_lt(F32s::splat(1e-4));
    let x = Vector::select(upright, project(node_y), in_surface).normalize();
    let y = normal.cross(x);
    let cosine = lanes.field(|material| material.axis[0]);
    let sine = lanes.field(|material| material.axis[1]);
    transmission_axis(x.mul_add(cosine, y * sine), normal, lanes.direction)
}

#[inline(always)]
fn depart<const N: usize, C>(
    drawn: &mut [Column; 3],
    paths: &mut PathTable<N, C>,
    lanes: &RowLanes<N>,
    scattered: Scattered<N>,
    row: usize,
    end: usize,
    side: Side,
) {
    let Scattered { direction, weight } = scattered;
    let cos_out = direction.dot(lanes.geometric).abs();
    // Veach 1997, equation 5.19, for a direction that has the cosine of arrival (or Snell's
    // partner of it) to the shading normal on both sides; one without shading normals.
    let adjoint = match side {
        Side::Sensor => F32s::splat(1.0),
        Side::Light => {
            let cos_in = lanes.direction.dot(lanes.geometric).abs();
            let shading_out = direction.dot(lanes.normal).abs();
            let flat = (cos_in - lanes.cos_i).abs().simd_lt(F32s::splat(1e-6));
            let ratio = lanes.cos_i * cos_out / (cos_in * shading_out);
            Real::select(flat, F32s::splat(1.0), ratio)
        }
    };
    for (n, &weight) in weight.iter().enumerate() {
        let beta = lanes::load(&paths.beta[n], row) * weight * adjoint;
        lanes::store(&mut paths.beta[n], row, end, beta);
    }
    direction.store(drawn, row, end);
    paths.mis.depart_specular(row, end, cos_out);
}
