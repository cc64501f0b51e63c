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
            Crossed::Model(kind) => {
                for_straight_on!(scene.surfaces, kind, models => {
                    pass::<N, POLARIZED, _>(crossings, (scene, models), rows.clone());
                });
                if scene.has_stains {
                    pass_in_part(crossings, scene, rows, POLARIZED);
                }
            }
            Crossed::Holes => pass_holes(crossings, scene, rows),
        }
    }
}

/// What rows of panes let through that have a stain, or holes: light through these is as it was.
#[inline(never)]
fn pass_in_part<const N: usize>(
    crossings: &mut CrossingTable<N>,
    scene: &Scene<N>,
    rows: Range<usize>,
    polarized: bool,
) {
    for row in rows {
        let HitColumns { primitive, u, v, .. } = &crossings.hits;
        let at = ([u[row], v[row]], lanes::row_of(&crossings.surfaces.position, row).into());
        let primitive = primitive[row];
        if let Some([_, stain]) = scene.stain_at(primitive, at) {
            for (value, left) in crossings.transmittance[row].iter_mut().zip(stain) {
                *value *= left;
            }
        }
        let covered = scene.coverage_at(primitive, at);
        if covered == 1.0 {
            continue;
        }
        let open = 1.0 - covered;
        for n in 0..N {
            let value = &mut crossings.transmittance[row][n];
            let through = covered * *value;
            *value = through + open;
            if polarized {
                let share = if *value > 0.0 { through / *value } else { 0.0 };
                let [a, c, s] = crossings.kernels[row][n];
                crossings.kernels[row][n] = [a * share, (c - 1.0).mul_add(share, 1.0), s * share];
            }
        }
        crossings.chance[row] = covered.mul_add(crossings.chance[row] - 1.0, 1.0);
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
        let at = ([u[row], v[row]], lanes::row_of(&crossings.surfaces.position, row).into());
        let open = 1.0 - scene.coverage_at(primitive[row], at);
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
