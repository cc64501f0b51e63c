//! Turns the partial weights from the last vertex's measure to the new one's.

use std::ops::Range;

use crate::geometry::{HitColumns, SurfaceColumns};
use crate::math::{F32s, LANES, Vector, lanes};
use crate::scattering::{Met, Scene};
use crate::transport::tables::partition::Partition;
use crate::transport::tables::paths::{MisColumns, PathTable};

/// Second half of equations 31 to 36 of Georgiev's technical report: `d_vcm` takes the squared
/// distance (unless the segment comes from infinity), both take the cosine of arrival, or the
/// density of the medium in which the vertex is.
///
/// From: resolve_surfaces. To: connect_to_emitters, connect_to_vertices, store_light_vertices.
/// Writes: mis. Reads: rays, hits, surfaces, scene, partition.
pub fn weigh_arrival<const N: usize, C>(
    paths: &mut PathTable<N, C>,
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

fn weigh_part<const N: usize, C>(
    paths: &mut PathTable<N, C>,
    hits: &HitColumns,
    surfaces: &SurfaceColumns,
    (rows, density): (Range<usize>, Option<F32s>),
    from_infinity: bool,
) {
    let MisColumns { d_vcm, d_vc, pdf_w } = &mut paths.mis;
    for row in rows.clone().step_by(LANES) {
        let normal = Vector::load(&surfaces.geometric_normal, row);
        let cosine = Vector::load(&paths.rays.direction, row).dot(normal).abs();
        let cosine = density.unwrap_or(cosine);
        let distance = lanes::load(&hits.t, row);
        // A segment without an end (or from one) has no distance to convert by.
        let infinite = lanes::load(pdf_w, row).simd_gt(F32s::splat(f32::MAX));
        let one = F32s::splat(1.0);
        let square = if from_infinity {
            infinite.bitselect(one, distance * distance)
        } else {
            distance * distance
        };
        let inverse = one / cosine;
        let vcm = lanes::load(d_vcm, row) * square * inverse;
        let vc = lanes::load(d_vc, row) * inverse;
        lanes::store(d_vcm, row, rows.end, vcm);
        lanes::store(d_vc, row, rows.end, vc);
    }
}
