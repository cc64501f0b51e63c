//! Turns the partial weights from the last vertex's measure to the new one's.

use std::ops::Range;

use crate::geometry::{HitColumns, SurfaceColumns};
use crate::math::{F32s, LANES, Vector, lanes};
use crate::scattering::{Met, Scene};
use crate::transport::tables::partition::Partition;
use crate::transport::tables::paths::AnyPaths;

/// Brings the partial weights to the vertices just reached: by the length of the segment, unless
/// that comes from infinity, and the cosine of arrival, or the density of the medium of the vertex.
///
/// From: resolve_surfaces, paint_surfaces. To: depolarize_sensor, depolarize_light, weigh_choice.
/// Writes: paths (mis). Reads: paths (rays), hits, surfaces, scene, partition.
pub fn weigh_arrival<const N: usize>(
    paths: &mut AnyPaths<N>,
    hits: &HitColumns,
    surfaces: &SurfaceColumns,
    (scene, partition): (&Scene<N>, &Partition),
    from_infinity: bool,
) {
    for part in &partition.parts {
        let density = match part.event.met {
            Met::Medium(medium) => Some(F32s::splat(scene.medium(medium).density)),
            Met::Surface(_) => None,
        };
        weigh_part(paths, hits, surfaces, (part.rows.clone(), density), from_infinity);
    }
}

fn weigh_part<const N: usize>(
    paths: &mut AnyPaths<N>,
    hits: &HitColumns,
    surfaces: &SurfaceColumns,
    (rows, density): (Range<usize>, Option<F32s>),
    from_infinity: bool,
) {
    for row in rows.clone().step_by(LANES) {
        let normal = Vector::load(&surfaces.geometric_normal, row);
        let cosine = Vector::load(&paths.rays.direction, row).dot(normal).abs();
        let measure = density.unwrap_or(cosine);
        let distance = lanes::load(&hits.t, row);
        // A segment without an end (or from one) has no distance to convert by.
        let infinite = lanes::load(&paths.mis.pdf_w, row).simd_gt(F32s::splat(f32::MAX));
        let distance2 = if from_infinity {
            infinite.bitselect(F32s::splat(1.0), distance * distance)
        } else {
            distance * distance
        };
        let weights = paths.mis.load(row).arrive(distance2, measure);
        paths.mis.store(row, rows.end, weights);
    }
}
