//! Next-event estimation: connects depolarizing vertices of sensor paths to emitters.

use std::ops::Range;

use crate::geometry::{SurfaceColumns, offset_origin};
use crate::math::{F32s, LANES, Real, Vector, lanes, warp};
use crate::scattering::Scene;
use crate::scattering::diffuse::{BRDF, Facing};
use crate::scattering::direct::DirectLanes;
use crate::transport::sampler::{Purpose, draw};
use crate::transport::tables::connections::ConnectionTable;
use crate::transport::tables::paths::PathTable;

use super::collect_emission::Strategy;
use super::scatter_diffuse::{MaterialLanes, facing_of};

/// Connects the rows `rows`, which have hit diffuse surfaces, to one emitter each.
///
/// From: depolarize_sensor (`Bidirectional`: weigh_arrival). To: trace_visibility.
/// Writes: connections. Reads: paths, surfaces, scene.
pub fn connect_to_emitters<const N: usize, C>(
    connections: &mut ConnectionTable<N>,
    paths: &PathTable<N, C>,
    surfaces: &SurfaceColumns,
    scene: &Scene<N>,
    rows: Range<usize>,
    path_length: u32,
    strategy: Strategy,
) {
    connections.clear();
    for row in rows.clone().step_by(LANES) {
        let live = LANES.min(rows.end - row);
        let chosen = choose(paths, surfaces, scene, row, path_length);
        let material = MaterialLanes::gather(scene, surfaces, row, live);
        let facing = facing_of(surfaces, &material, row);
        let given = -Vector::load(&paths.rays.direction, row);
        let cosine = chosen.direction.dot(facing.shading).abs();
        let bsdf_pdf = warp::cosine_pdf(cosine) * chosen.reachable;
        let weight = match strategy {
            Strategy::Unidirectional => {
                let ratio = bsdf_pdf / chosen.pdf_w;
                F32s::splat(1.0) / ratio.mul_add(ratio, F32s::splat(1.0))
            }
            Strategy::Bidirectional => {
                bidirectional_weight(paths, &chosen, &facing, given, bsdf_pdf, row)
            }
        };
        let reflects = facing.reflects(given, chosen.direction);
        let factor = reflects & (weight * cosine * F32s::splat(BRDF) / chosen.pdf_w);
        let values: [[f32; LANES]; N] = std::array::from_fn(|n| {
            let beta = lanes::load(&paths.beta[n], row) * material.reflectance[n];
            (beta * chosen.radiance[n] * factor).to_array()
        });
        let segments = segments(surfaces, scene.reach, &chosen, row);
        for lane in 0..live {
            let value = values.map(|value| value[lane]);
            if value.iter().any(|&value| value > 0.0) {
                let (origin, towards) = (segments.origin[lane], segments.towards[lane]);
                connections.push(origin, towards, segments.t_max[lane], value, (row + lane) as u32);
            }
        }
    }
}

/// Georgiev's technical report, equations 44 and 45.
#[inline(always)]
fn bidirectional_weight<const N: usize, C>(
    paths: &PathTable<N, C>,
    chosen: &DirectLanes<N>,
    facing: &Facing,
    given: Vector<F32s>,
    bsdf_pdf: F32s,
    row: usize,
) -> F32s {
    let cos_to_light = chosen.direction.dot(facing.geometric).abs();
    let reverse_pdf = warp::cosine_pdf(given.dot(facing.shading).abs());
    let light = bsdf_pdf / chosen.pdf_w;
    let to_vertex = chosen.emission_pdf * cos_to_light / (chosen.pdf_w * chosen.cos_at_light);
    let sensor = to_vertex
        * lanes::load(&paths.mis.d_vc, row)
            .mul_add(reverse_pdf, lanes::load(&paths.mis.d_vcm, row));
    F32s::splat(1.0) / (light + F32s::splat(1.0) + sensor)
}

/// One emitter a row, and a point or direction on it.
#[inline(always)]
fn choose<const N: usize, C>(
    paths: &PathTable<N, C>,
    surfaces: &SurfaceColumns,
    scene: &Scene<N>,
    row: usize,
    path_length: u32,
) -> DirectLanes<N> {
    let seed = lanes::load_u32(&paths.identity.seed, row);
    let iteration = lanes::load_u32(&paths.identity.iteration, row);
    let [choice, _] = draw(seed, iteration, path_length, Purpose::Emitter);
    let chosen = choice.to_array().map(|u| scene.choose_emitter(u));
    let u = draw(seed, iteration, path_length, Purpose::EmitterPosition);
    scene.direct.sample(chosen, Vector::load(&surfaces.position, row), u)
}

/// Eight segments to be tested, off the surfaces at both ends.
struct Segments {
    origin: [[f32; 3]; LANES],
    towards: [[f32; 3]; LANES],
    t_max: [f32; LANES],
}

#[inline(always)]
fn segments<const N: usize>(
    surfaces: &SurfaceColumns,
    reach: f32,
    chosen: &DirectLanes<N>,
    row: usize,
) -> Segments {
    let reach = F32s::splat(reach);
    let position = Vector::load(&surfaces.position, row);
    let normal = Vector::load(&surfaces.geometric_normal, row);
    let origin = offset_origin(position, normal, chosen.direction, reach);
    let end = offset_origin(chosen.point, chosen.normal, -chosen.direction, reach);
    let offset = end - origin;
    let length = offset.length();
    let towards = offset * (F32s::splat(1.0) / length);
    Segments {
        origin: to_rows(origin),
        towards: to_rows(Vector::select(chosen.finite, towards, chosen.direction)),
        t_max: Real::select(chosen.finite, length, F32s::splat(f32::INFINITY)).to_array(),
    }
}

/// Direction and length of the segment between two points that are off their surfaces.
#[inline(always)]
pub(super) fn segment(from: [f32; 3], to: [f32; 3]) -> ([f32; 3], f32) {
    let offset: [f32; 3] = std::array::from_fn(|axis| to[axis] - from[axis]);
    let length = offset.iter().map(|x| x * x).sum::<f32>().sqrt();
    (offset.map(|x| x / length), length)
}

/// The lanes of a vector as rows.
#[inline(always)]
pub(super) fn to_rows(vector: Vector<F32s>) -> [[f32; 3]; LANES] {
    let [x, y, z] = [vector.x, vector.y, vector.z].map(F32s::to_array);
    std::array::from_fn(|lane| [x[lane], y[lane], z[lane]])
}
