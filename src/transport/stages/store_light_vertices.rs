//! Keeps the light vertices that others can connect to.

use std::ops::Range;

use crate::geometry::SurfaceColumns;
use crate::math::{F32s, LANES, Vector, lanes};
use crate::scattering::Scene;
use crate::scattering::diffuse::BRDF;
use crate::transport::tables::paths::PathTable;
use crate::transport::tables::vertices::VertexTable;

use super::scatter_diffuse::MaterialLanes;

/// Appends the rows `rows`, which have hit diffuse surfaces.
///
/// From: weigh_arrival, depolarize_light. To: connect_to_sensor, connect_to_vertices.
/// Writes: vertices. Reads: paths, surfaces, scene.
pub fn store_light_vertices<const N: usize, C>(
    vertices: &mut VertexTable<N>,
    paths: &PathTable<N, C>,
    surfaces: &SurfaceColumns,
    scene: &Scene<N>,
    rows: Range<usize>,
    path_length: u32,
) {
    vertices.reserve(rows.len());
    let start = vertices.len;
    let end = start + rows.len();
    for row in rows.clone().step_by(LANES) {
        let to = start + row - rows.start;
        let live = LANES.min(rows.end - row);
        let material = MaterialLanes::gather(scene, surfaces, row, live);
        Vector::load(&surfaces.position, row).store(&mut vertices.position, to, end);
        Vector::load(&surfaces.geometric_normal, row).store(
            &mut vertices.geometric_normal,
            to,
            end,
        );
        Vector::load(&surfaces.shading_normal, row).store(&mut vertices.shading_normal, to, end);
        (-Vector::load(&paths.rays.direction, row)).store(&mut vertices.given, to, end);
        for n in 0..N {
            let power = lanes::load(&paths.beta[n], row) * material.reflectance[n];
            lanes::store(&mut vertices.power[n], to, end, power * F32s::splat(BRDF));
        }
        let two_sided = material.two_sided & F32s::splat(1.0);
        lanes::store(&mut vertices.two_sided, to, end, two_sided);
        lanes::store(&mut vertices.d_vcm, to, end, lanes::load(&paths.mis.d_vcm, row));
        lanes::store(&mut vertices.d_vc, to, end, lanes::load(&paths.mis.d_vc, row));
    }
    vertices.slot[start..end].copy_from_slice(&paths.identity.slot[rows]);
    vertices.path_length[start..end].fill(path_length);
    vertices.len = end;
}
