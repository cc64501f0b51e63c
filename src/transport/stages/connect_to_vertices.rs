//! Connects depolarizing vertices of sensor paths to those of the light path they are paired
//! with (paper, equation 12).

use std::ops::Range;

use crate::geometry::{SurfaceColumns, offset_origin};
use crate::math::{F32s, LANES, Vector, lanes, warp};
use crate::scattering::Scene;
use crate::scattering::diffuse::{BRDF, Facing};
use crate::transport::tables::connections::ConnectionTable;
use crate::transport::tables::paths::PathTable;
use crate::transport::tables::vertices::{SlotOrder, VertexTable};

use super::connect_to_emitters::{segment, to_rows};
use super::connect_to_sensor::facing_of_vertices;
use super::{row_of, splat};

/// Connects each of the rows `rows`, which have hit diffuse surfaces, to all vertices of its
/// slot's light path that keep the whole within `path_length_max` segments.
///
/// Both ends are depolarizers, so the Mueller kernels reduce to their first elements: only
/// intensity crosses the connection.
///
/// From: weigh_arrival, depolarize_sensor. To: trace_visibility, gather_connections.
/// Writes: connections. Reads: paths, surfaces, vertices, scene.
pub fn connect_to_vertices<const N: usize, C>(
    connections: &mut ConnectionTable<N>,
    paths: &PathTable<N, C>,
    surfaces: &SurfaceColumns,
    (vertices, order): (&VertexTable<N>, &SlotOrder),
    scene: &Scene<N>,
    (rows, vertex_length_max): (Range<usize>, u32),
) {
    connections.clear();
    for row in rows {
        let of_path = order.rows_of(paths.identity.slot[row] as usize);
        if of_path.is_empty() {
            continue;
        }
        let sensor = SensorVertex::load(paths, surfaces, scene, row);
        for vertex in of_path.clone().step_by(LANES) {
            let live = LANES.min(of_path.end - vertex);
            connect(connections, &sensor, vertices, vertex, live, vertex_length_max, scene.reach);
        }
    }
}

/// One sensor vertex in all lanes.
struct SensorVertex<const N: usize> {
    row: u32,
    position: Vector<F32s>,
    facing: Facing,
    given: Vector<F32s>,
    /// Throughput times BRDF.
    power: [F32s; N],
    d_vcm: F32s,
    d_vc: F32s,
}

impl<const N: usize> SensorVertex<N> {
    #[inline(always)]
    fn load<C>(
        paths: &PathTable<N, C>,
        surfaces: &SurfaceColumns,
        scene: &Scene<N>,
        row: usize,
    ) -> Self {
        let primitive = surfaces.primitive[row] as usize;
        let material = &scene.tables.materials[scene.material_of_primitive[primitive] as usize];
        let two_sided = F32s::splat(if material.two_sided { 1.0 } else { 0.0 });
        Self {
            row: row as u32,
            position: splat(row_of(&surfaces.position, row)),
            facing: Facing {
                geometric: splat(row_of(&surfaces.geometric_normal, row)),
                shading: splat(row_of(&surfaces.shading_normal, row)),
                two_sided: two_sided.simd_gt(F32s::splat(0.5)),
            },
            given: -splat(row_of(&paths.rays.direction, row)),
            power: std::array::from_fn(|n| {
                F32s::splat(paths.beta[n][row] * material.reflectance[n] * BRDF)
            }),
            d_vcm: F32s::splat(paths.mis.d_vcm[row]),
            d_vc: F32s::splat(paths.mis.d_vc[row]),
        }
    }
}

#[inline(always)]
fn connect<const N: usize>(
    connections: &mut ConnectionTable<N>,
    sensor: &SensorVertex<N>,
    vertices: &VertexTable<N>,
    vertex: usize,
    live: usize,
    vertex_length_max: u32,
    reach: f32,
) {
    let position = Vector::load(&vertices.position, vertex);
    let offset = position - sensor.position;
    let distance2 = offset.length_squared();
    let direction = offset * (F32s::splat(1.0) / distance2.sqrt());
    let factor = factor(sensor, vertices, vertex, direction, distance2);
    let lengths = lanes::load_u32(&vertices.path_length, vertex).to_array();
    let values: [[f32; LANES]; N] = std::array::from_fn(|n| {
        (sensor.power[n] * lanes::load(&vertices.power[n], vertex) * factor).to_array()
    });
    let normal = Vector::load(&vertices.geometric_normal, vertex);
    let reach = F32s::splat(reach);
    let from = to_rows(offset_origin(sensor.position, sensor.facing.geometric, direction, reach));
    let to = to_rows(offset_origin(position, normal, -direction, reach));
    for lane in 0..live {
        let value = values.map(|value| value[lane]);
        if lengths[lane] <= vertex_length_max && value.iter().any(|&value| value > 0.0) {
            let (towards, t_max) = segment(from[lane], to[lane]);
            connections.push(from[lane], towards, t_max, value, sensor.row);
        }
    }
}

/// Geometry term, cosines and weight (Georgiev's technical report, equations 40 and 41).
#[inline(always)]
fn factor<const N: usize>(
    sensor: &SensorVertex<N>,
    vertices: &VertexTable<N>,
    vertex: usize,
    direction: Vector<F32s>,
    distance2: F32s,
) -> F32s {
    let light_facing = facing_of_vertices(vertices, vertex);
    let light_given = Vector::load(&vertices.given, vertex);
    let inverse2 = F32s::splat(1.0) / distance2;
    let sensor_cos = direction.dot(sensor.facing.shading).abs();
    let sensor_geometric = direction.dot(sensor.facing.geometric).abs();
    let light_cos = direction.dot(light_facing.shading).abs();
    let light_geometric = direction.dot(light_facing.geometric).abs();

    let sensor_to_light = warp::cosine_pdf(sensor_cos) * light_geometric * inverse2;
    let light_to_sensor = warp::cosine_pdf(light_cos) * sensor_geometric * inverse2;
    let sensor_reverse = warp::cosine_pdf(sensor.given.dot(sensor.facing.shading).abs());
    let light_reverse = warp::cosine_pdf(light_given.dot(light_facing.shading).abs());
    let light_d_vcm = lanes::load(&vertices.d_vcm, vertex);
    let light_d_vc = lanes::load(&vertices.d_vc, vertex);
    let light = sensor_to_light * light_d_vc.mul_add(light_reverse, light_d_vcm);
    let rest = light_to_sensor * sensor.d_vc.mul_add(sensor_reverse, sensor.d_vcm);
    let weight = F32s::splat(1.0) / (light + F32s::splat(1.0) + rest);

    let adjoint = light_facing.adjoint(light_given, -direction);
    let visible = sensor.facing.reflects(sensor.given, direction)
        & light_facing.reflects(light_given, -direction);
    visible & (sensor_cos * light_cos * adjoint * inverse2 * weight)
}
