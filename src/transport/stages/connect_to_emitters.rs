//! Next-event estimation: connects depolarizing vertices of sensor paths to emitters.

use std::ops::Range;

use crate::geometry::{SurfaceColumns, offset_origin};
use crate::math::{F32s, LANES, Vector, lanes, warp};
use crate::scattering::Scene;
use crate::scattering::diffuse::{BRDF, Facing};
use crate::scattering::emission::{DirectSample, sample_direct};
use crate::transport::sampler::{Purpose, draw};
use crate::transport::tables::connections::ConnectionTable;
use crate::transport::tables::paths::PathTable;

use super::collect_emission::Strategy;
use super::emit_light_paths::leave;
use super::row_of;
use super::scatter_diffuse::{MaterialLanes, facing_of};

/// Eight chosen points or directions, columns of [`DirectSample`]; lanes without one carry no
/// radiance.
struct Chosen<const N: usize> {
    direction: Vector<F32s>,
    origin: [[f32; 3]; LANES],
    towards: [[f32; 3]; LANES],
    t_max: [f32; LANES],
    radiance: [F32s; N],
    pdf_w: F32s,
    emission_pdf: F32s,
    cos_at_light: F32s,
    /// 1 where paths can meet the emitter by chance, else 0.
    reachable: F32s,
}

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
        let chosen = choose(paths, surfaces, scene, row, live, path_length);
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
        for lane in 0..live {
            let value = values.map(|value| value[lane]);
            if value.iter().any(|&value| value > 0.0) {
                let (origin, towards) = (chosen.origin[lane], chosen.towards[lane]);
                connections.push(origin, towards, chosen.t_max[lane], value, (row + lane) as u32);
            }
        }
    }
}

/// Georgiev's technical report, equations 44 and 45.
#[inline(always)]
fn bidirectional_weight<const N: usize, C>(
    paths: &PathTable<N, C>,
    chosen: &Chosen<N>,
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

#[inline(always)]
fn choose<const N: usize, C>(
    paths: &PathTable<N, C>,
    surfaces: &SurfaceColumns,
    scene: &Scene<N>,
    row: usize,
    live: usize,
    path_length: u32,
) -> Chosen<N> {
    let seed = lanes::load_u32(&paths.identity.seed, row);
    let iteration = lanes::load_u32(&paths.identity.iteration, row);
    let [choice, _] = draw(seed, iteration, path_length, Purpose::Emitter).map(|u| u.to_array());
    let place = draw(seed, iteration, path_length, Purpose::EmitterPosition).map(|u| u.to_array());
    let samples: [Option<DirectSample<N>>; LANES] = std::array::from_fn(|lane| {
        if lane >= live {
            return None;
        }
        let reference = row_of(&surfaces.position, row + lane);
        sample_direct(scene, reference, choice[lane], place.map(|u| u[lane]))
    });
    let field = |of: fn(&DirectSample<N>) -> f32, none: f32| {
        F32s::from(std::array::from_fn(|lane| samples[lane].as_ref().map_or(none, of)))
    };
    let direction = Vector::gather(|lane| {
        samples[lane].as_ref().map_or([0.0, 0.0, 1.0], |sample| sample.direction.to_array())
    });
    let (origin, towards, t_max) = segments(surfaces, scene.reach, &samples, direction, row);
    Chosen {
        direction,
        origin,
        towards,
        t_max,
        radiance: std::array::from_fn(|n| {
            F32s::from(std::array::from_fn(|lane| {
                samples[lane].as_ref().map_or(0.0, |sample| sample.radiance[n])
            }))
        }),
        pdf_w: field(|sample| sample.pdf_w, 1.0),
        emission_pdf: field(|sample| sample.emission_pdf, 0.0),
        cos_at_light: field(|sample| sample.cos_at_light, 1.0),
        reachable: field(|sample| if sample.delta { 0.0 } else { 1.0 }, 0.0),
    }
}

/// Origin, direction and length of the test for each lane, off the surfaces at both ends.
#[inline(always)]
fn segments<const N: usize>(
    surfaces: &SurfaceColumns,
    reach: f32,
    samples: &[Option<DirectSample<N>>; LANES],
    direction: Vector<F32s>,
    row: usize,
) -> ([[f32; 3]; LANES], [[f32; 3]; LANES], [f32; LANES]) {
    let position = Vector::load(&surfaces.position, row);
    let normal = Vector::load(&surfaces.geometric_normal, row);
    let origin = offset_origin(position, normal, direction, F32s::splat(reach));
    let origin = to_rows(origin);
    let (mut towards, mut t_max) = (to_rows(direction), [f32::INFINITY; LANES]);
    for (lane, sample) in samples.iter().enumerate() {
        let Some((sample, point)) = sample.as_ref().and_then(|s| Some((s, s.point?))) else {
            continue;
        };
        let end = leave(point, sample.normal, -sample.direction, reach);
        (towards[lane], t_max[lane]) = segment(origin[lane], end.to_array());
    }
    (origin, towards, t_max)
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
