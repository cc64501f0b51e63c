//! Lets light paths that have come to their first vertices know how likely those are to choose
//! their emitters.

use glam::Vec3;

use crate::geometry::SurfaceColumns;
use crate::math::{LANES, Vector, lanes};
use crate::scattering::Scene;
use crate::scattering::emitter::direct_pdf;
use crate::transport::emission::emitters_of_paths;
use crate::transport::tables::paths::AnyPaths;
use crate::transport::vantage::vantages;

/// Completes the partial weights of light paths at their first vertices by the densities of
/// choosing the points where they started when connecting from there.
///
/// From: weigh_arrival. To: depolarize_light.
/// Writes: paths (mis). Reads: paths (identity, rays), surfaces, scene.
pub fn weigh_choice<const N: usize>(
    paths: &mut AnyPaths<N>,
    surfaces: &SurfaceColumns,
    scene: &Scene<N>,
) {
    for row in (0..paths.len).step_by(LANES) {
        let emitters = emitters_of_paths(&paths.identity, scene, row);
        let from = vantages(surfaces, Vector::load(&paths.rays.direction, row), scene, row);
        for lane in 0..LANES.min(paths.len - row) {
            let row = row + lane;
            let origin = Vec3::from(lanes::row_of(&paths.rays.origin, row));
            let direction = Vec3::from(lanes::row_of(&paths.rays.direction, row));
            let pdf = direct_pdf(scene, (emitters[lane], None), &from[lane], (origin, -direction));
            paths.mis.set_row(row, paths.mis.row(row).beside_choice(pdf));
        }
    }
}
