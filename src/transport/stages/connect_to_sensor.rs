//! Connects light vertices to the sensor.

use crate::geometry::offset_origin;
use crate::math::{F32s, LANES, Vector, lanes, warp};
use crate::scattering::Scene;
use crate::scattering::diffuse::Facing;
use crate::scattering::sensor::SensorConnection;
use crate::transport::Chunk;
use crate::transport::sampler::{Purpose, Stream, draw, path_seed};
use crate::transport::tables::connections::ConnectionTable;
use crate::transport::tables::vertices::VertexTable;

use super::collect_emission::Strategy;
use super::connect_to_emitters::{segment, to_rows};
use super::row_of;

/// The normals of eight light vertices.
#[inline(always)]
pub(super) fn facing_of_vertices<const N: usize>(vertices: &VertexTable<N>, row: usize) -> Facing {
    Facing {
        geometric: Vector::load(&vertices.geometric_normal, row),
        shading: Vector::load(&vertices.shading_normal, row),
        two_sided: lanes::load(&vertices.two_sided, row).simd_gt(F32s::splat(0.5)),
    }
}

/// Connects all vertices, each to the pixel that sees it. `light_paths` is the number of light
/// paths an iteration. With [`Strategy::Unidirectional`] nothing else finds these paths.
///
/// From: store_light_vertices, ordered by slot, so that splats come in an order that no mode
/// changes. To: trace_visibility, splat_connections.
/// Writes: connections. Reads: vertices, chunk, scene.
pub fn connect_to_sensor<const N: usize>(
    connections: &mut ConnectionTable<N>,
    vertices: &VertexTable<N>,
    chunk: &Chunk,
    scene: &Scene<N>,
    light_paths: f32,
    strategy: Strategy,
) {
    connections.clear();
    for row in (0..vertices.len).step_by(LANES) {
        let live = LANES.min(vertices.len - row);
        let found: [Option<SensorConnection>; LANES] = std::array::from_fn(|lane| {
            if lane >= live {
                return None;
            }
            let lens = lens_of(vertices, chunk, scene, row + lane);
            scene.sensor.connect(row_of(&vertices.position, row + lane), lens)
        });
        if found.iter().all(Option::is_none) {
            continue;
        }
        let field = |of: fn(&SensorConnection) -> f32| {
            F32s::from(std::array::from_fn(|lane| found[lane].as_ref().map_or(0.0, of)))
        };
        let direction = Vector::gather(|lane| {
            found[lane].as_ref().map_or([0.0, 0.0, 1.0], |found| found.direction.to_array())
        });
        let factor = connection_factor(
            vertices,
            direction,
            field(|found| found.pdf_area),
            light_paths,
            strategy,
            row,
        );
        let origin = to_rows(offset_origin(
            Vector::load(&vertices.position, row),
            Vector::load(&vertices.geometric_normal, row),
            direction,
            F32s::splat(scene.reach),
        ));
        let values: [[f32; LANES]; N] =
            std::array::from_fn(|n| (lanes::load(&vertices.power[n], row) * factor).to_array());
        for (lane, found) in found.iter().enumerate() {
            let value = values.map(|value| value[lane]);
            let Some(found) = found.as_ref().filter(|_| value.iter().any(|&v| v > 0.0)) else {
                continue;
            };
            let (towards, t_max) = segment(origin[lane], found.lens.to_array());
            connections.push(origin[lane], towards, t_max, value, found.pixel);
        }
    }
}

/// The point of the lens that a vertex connects to.
#[inline(always)]
fn lens_of<const N: usize>(
    vertices: &VertexTable<N>,
    chunk: &Chunk,
    scene: &Scene<N>,
    row: usize,
) -> [f32; 2] {
    if !scene.sensor.has_lens() {
        return [0.0; 2];
    }
    let (column, line, iteration) = chunk.place(vertices.slot[row] as usize);
    let path = line * scene.sensor.width + column;
    let seed = path_seed(chunk.seed, Stream::Light, path);
    let splat = crate::math::U32s::splat;
    draw(splat(seed), splat(iteration), vertices.path_length[row], Purpose::LensConnection)
        .map(|u| u.to_array()[0])
}

/// Importance over the number of light paths, cosines, and weight (Georgiev's technical report,
/// equations 46 and 47).
#[inline(always)]
fn connection_factor<const N: usize>(
    vertices: &VertexTable<N>,
    direction: Vector<F32s>,
    pdf_area: F32s,
    light_paths: f32,
    strategy: Strategy,
    row: usize,
) -> F32s {
    let facing = facing_of_vertices(vertices, row);
    let given = Vector::load(&vertices.given, row);
    let cos_shading = direction.dot(facing.shading).abs();
    let cos_geometric = direction.dot(facing.geometric).abs();
    let per_path = F32s::splat(1.0 / light_paths);
    let weight = match strategy {
        Strategy::Unidirectional => F32s::splat(1.0),
        Strategy::Bidirectional => {
            let reverse_pdf = warp::cosine_pdf(given.dot(facing.shading).abs());
            let d_vcm = lanes::load(&vertices.d_vcm, row);
            let d_vc = lanes::load(&vertices.d_vc, row);
            let light = pdf_area * cos_geometric * per_path * d_vc.mul_add(reverse_pdf, d_vcm);
            F32s::splat(1.0) / (light + F32s::splat(1.0))
        }
    };
    let adjoint = facing.adjoint(given, direction);
    facing.reflects(given, direction) & (adjoint * cos_shading * pdf_area * per_path * weight)
}
