//! Sends the rows on along the directions drawn.

use crate::geometry::{SurfaceColumns, offset_origin};
use crate::math::columns::Column;
use crate::math::{LANES, Vector, lanes};
use crate::scattering::Scene;
use crate::transport::tables::paths::AnyPaths;
use crate::transport::vantage::towards;

/// Starts the next segment of every row off its surface, of which it keeps what the choice of
/// emitters there is to know.
///
/// From: scatter_surfaces, collect_sensor, scatter_light. To: trace_closest.
/// Writes: paths (rays, last). Reads: directions, surfaces, scene.
pub fn advance_paths<const N: usize>(
    paths: &mut AnyPaths<N>,
    directions: &[Column; 3],
    surfaces: &SurfaceColumns,
    scene: &Scene<N>,
) {
    for row in (0..paths.len).step_by(LANES) {
        let direction = Vector::load(directions, row);
        let position = Vector::load(&surfaces.position, row);
        let normal = Vector::load(&surfaces.geometric_normal, row);
        let offset = lanes::load(&surfaces.offset, row);
        if paths.last.present() {
            let before = Vector::load(&paths.rays.direction, row);
            towards(surfaces, before, scene, row).store(&mut paths.last.normal, row, paths.len);
        }
        let origin = offset_origin(position, normal, direction, offset);
        origin.store(&mut paths.rays.origin, row, paths.len);
        direction.store(&mut paths.rays.direction, row, paths.len);
    }
}
