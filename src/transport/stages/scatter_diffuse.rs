//! Scatters rows that have hit diffuse surfaces: both sides alike, but for the shading normals.

use std::ops::Range;

use crate::geometry::SurfaceColumns;
use crate::math::columns::Column;
use crate::math::{F32s, LANES, Vector, lanes, warp};
use crate::scattering::Scene;
use crate::transport::bounce::{Bounce, Side};
use crate::transport::mis::TurnDensities;
use crate::transport::sampler::{Purpose, draw};
use crate::transport::tables::paths::PathTable;
use crate::transport::vertex::{MaterialLanes, facing_of};

/// Draws a new direction for the rows `rows`, cosine-weighted about the shading normal.
///
/// From: depolarize_sensor, depolarize_light. To: advance_paths.
/// Writes: drawn, paths (beta, mis). Reads: paths, surfaces, scene.
pub fn scatter_diffuse<const N: usize, C>(
    drawn: &mut [Column; 3],
    paths: &mut PathTable<N, C>,
    surfaces: &SurfaceColumns,
    scene: &Scene<N>,
    rows: Range<usize>,
    Bounce { path_length, side }: Bounce,
) {
    for row in rows.clone().step_by(LANES) {
        let seed = lanes::load_u32(&paths.identity.seed, row);
        let iteration = lanes::load_u32(&paths.identity.iteration, row);
        let u = draw(seed, iteration, path_length, Purpose::Direction);
        let live = LANES.min(rows.end - row);
        let material = MaterialLanes::gather(scene, surfaces, row, live);
        let facing = facing_of(surfaces, &material, row);
        let given = -Vector::load(&paths.rays.direction, row);
        let below = given.dot(facing.shading).simd_lt(F32s::splat(0.0));
        let axis = Vector::select(below, -facing.shading, facing.shading);
        let (direction, cosine) = warp::cosine_hemisphere(axis, u);
        let mut weight = facing.reflects(given, direction) & F32s::splat(1.0);
        if side == Side::Light {
            weight = weight.simd_gt(F32s::splat(0.5)) & facing.adjoint(given, direction);
        }
        for n in 0..N {
            let beta = lanes::load(&paths.beta[n], row) * material.reflectance[n] * weight;
            lanes::store(&mut paths.beta[n], row, rows.end, beta);
        }
        direction.store(drawn, row, rows.end);
        let pdf = warp::cosine_pdf(cosine);
        let pdf_reverse = warp::cosine_pdf(given.dot(facing.shading).abs());
        let measure = direction.dot(facing.geometric).abs();
        paths.mis.depart(row, rows.end, TurnDensities { pdf, pdf_reverse, measure });
    }
}
