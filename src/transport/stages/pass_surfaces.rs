//! What surfaces do to light that goes straight on.

use std::ops::Range;

use crate::geometry::{HitColumns, resolve_surfaces};
use crate::math::{F32s, LANES, lanes};
use crate::scattering::Scene;
use crate::scattering::painting::paint_normals;
use crate::scattering::surface::model::{Incidence, Passage};
use crate::scattering::surface::{Crossed, StraightOn, for_straight_on};
use crate::transport::tables::crossings::CrossingTable;

/// Finds the surfaces of all crossings, and their transmittance. With `POLARIZED`, also their
/// kernels.
///
/// From: follow_paths, follow_connections. To: choose_passage, cross_surfaces, cross_connections.
/// Writes: crossings. Reads: scene.
pub fn pass_surfaces<const N: usize, const POLARIZED: bool>(
    crossings: &mut CrossingTable<N>,
    scene: &Scene<N>,
) {
    let CrossingTable { surfaces, hits, rays, len, .. } = &mut *crossings;
    resolve_surfaces(surfaces, hits, rays, 0..*len, &scene.shapes);
    if scene.is_painted() {
        paint_normals(surfaces, hits, 0..*len, scene);
    }
    for part in 0..crossings.parts.len() {
        let (kind, rows) = (crossings.parts[part].kind, crossings.parts[part].rows.clone());
        match kind {
            Crossed::Model(kind) => for_straight_on!(scene.surfaces, kind, models => {
                pass::<N, POLARIZED, _>(crossings, (scene, models), rows);
            }),
            Crossed::Holes => pass_holes(crossings, scene, rows),
        }
    }
}

/// Rows of surfaces with holes.
fn pass_holes<const N: usize>(
    crossings: &mut CrossingTable<N>,
    scene: &Scene<N>,
    rows: Range<usize>,
) {
    for row in rows {
        let HitColumns { primitive, u, v, .. } = &crossings.hits;
        let open = 1.0 - scene.coverage_at(primitive[row], [u[row], v[row]]);
        crossings.transmittance[row] = [open; N];
        crossings.chance[row] = open;
    }
}

/// Rows of one model.
fn pass<const N: usize, const POLARIZED: bool, M: StraightOn<N>>(
    crossings: &mut CrossingTable<N>,
    (scene, models): (&Scene<N>, &[M]),
    rows: Range<usize>,
) {
    if !M::ACTS {
        return;
    }
    for row in rows.clone().step_by(LANES) {
        let live = LANES.min(rows.end - row);
        let CrossingTable { surfaces, rays, .. } = &*crossings;
        let at = Incidence::load(scene, models, surfaces, rays, (row, live));
        let Passage { transmittance, chance, kernels, axis } = M::pass::<POLARIZED>(&at);
        let transmittance = transmittance.map(F32s::to_array);
        for (lane, to) in crossings.transmittance[row..row + live].iter_mut().enumerate() {
            *to = lanes::row_of_lanes(&transmittance, lane);
        }
        lanes::store(&mut crossings.chance, row, rows.end, chance);
        if POLARIZED {
            for (n, kernel) in kernels.iter().enumerate().take(if M::ACHROMATIC { 1 } else { N }) {
                let [a, c, s] = [kernel.a, kernel.c, kernel.s].map(F32s::to_array);
                for (lane, to) in crossings.kernels[row..row + live].iter_mut().enumerate() {
                    to[n] = [a[lane], c[lane], s[lane]];
                }
            }
            axis.store(&mut crossings.axis, row, rows.end);
        }
    }
}
