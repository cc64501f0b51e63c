//! Tracing whole columns of rays, one row a ray.

use std::ops::Range;

use crate::math::columns::Rows;
use crate::math::{F32s, LANES, Vector, lanes};
use crate::scene::baked::NONE;

use super::accelerator::{Accelerator, SHORT_CORNERS, ShortScene};
use super::kernel::{Nearest, Rays, Renaming};
use super::rays::{Hit, HitColumns, RayColumns};
use super::walk::{TraceScratch, walk};

/// Rays that are on their way through a large tree at a time: of 4, 6, 8, 12, 16 and 24 the least
/// that is as fast as any among 4.4 million triangles. Rays sorted beforehand by direction or
/// place, even all of a film, were no more than 5 % faster than these: less than sorting costs.
const FLIGHT: usize = 16;

/// Finds the nearest hit of each ray in `rows`.
pub fn trace_closest(
    hits: &mut HitColumns,
    scratch: &mut TraceScratch,
    rays: &RayColumns,
    rows: Range<usize>,
    accelerator: &Accelerator,
) {
    if let Some(scene) = &accelerator.short {
        return closest_in_short(hits, rays, rows, (scene, accelerator.tree.reach));
    }
    hits.t[rows.clone()].fill(f32::INFINITY);
    hits.u[rows.clone()].fill(0.0);
    hits.v[rows.clone()].fill(0.0);
    hits.primitive[rows.clone()].fill(NONE);
    let better = |row: usize, hit: Hit| hits.set(row, hit);
    let load = |row: usize| rays.eight(row);
    let (tree, t_max) = (&accelerator.tree, |_| f32::INFINITY);
    match tree.is_large() {
        false => walk::<1, false>(tree, rows, load, t_max, scratch, better),
        true => walk::<FLIGHT, false>(tree, rows, load, t_max, scratch, better),
    }
}

/// Finds which rays in `rows` meet anything with `0 < t < t_max`: their `blocked` becomes
/// `u32::MAX`, that of the others 0. `t_max` is padded by [`LANES`] like the rays.
pub fn trace_visibility(
    blocked: &mut [u32],
    scratch: &mut TraceScratch,
    rays: &RayColumns,
    t_max: &[f32],
    rows: Range<usize>,
    accelerator: &Accelerator,
) {
    if let Some(scene) = &accelerator.short {
        return visibility_in_short(blocked, rays, t_max, rows, (scene, accelerator.tree.reach));
    }
    blocked[rows.clone()].fill(0);
    let better = |row: usize, _: Hit| blocked[row] = u32::MAX;
    let load = |row: usize| rays.eight(row);
    let (tree, t_max) = (&accelerator.tree, |row: usize| t_max[row]);
    match tree.is_large() {
        false => walk::<1, true>(tree, rows, load, t_max, scratch, better),
        true => walk::<FLIGHT, true>(tree, rows, load, t_max, scratch, better),
    }
}

fn closest_in_short(
    hits: &mut HitColumns,
    columns: &RayColumns,
    rows: Range<usize>,
    (scene, reach): (&ShortScene, f32),
) {
    let mut corners = [Vector::splat([0.0; 3]); SHORT_CORNERS];
    for row in rows.clone().step_by(LANES) {
        let (origin, direction) = columns.eight(row);
        let nearest = if Rays::are_alike(origin, direction, reach) {
            nearest_in_short::<false>(&mut corners, origin, direction, scene)
        } else {
            nearest_in_short::<true>(&mut corners, origin, direction, scene)
        };
        lanes::store(&mut hits.t, row, rows.end, nearest.t);
        lanes::store(&mut hits.u, row, rows.end, nearest.u);
        lanes::store(&mut hits.v, row, rows.end, nearest.v);
        lanes::store_u32(&mut hits.primitive, row, rows.end, nearest.primitive);
    }
}

#[inline(always)]
fn nearest_in_short<const HOPEFUL: bool>(
    corners: &mut [Vector<F32s>; SHORT_CORNERS],
    origin: Vector<F32s>,
    direction: Vector<F32s>,
    scene: &ShortScene,
) -> Nearest {
    let (rays, renaming) = Rays::eight(origin, direction);
    shear_corners(corners, &rays, renaming, scene);
    let mut nearest = Nearest::none(F32s::splat(f32::INFINITY));
    let mut primitive = 0;
    for &[a, b, c] in &scene.triangles {
        if let Some(found) = rays.meet_sheared::<HOPEFUL>(corners[a], corners[b], corners[c]) {
            nearest.offer_in_order(&found, primitive);
        }
        primitive += 1;
    }
    for &(center, radius_squared) in &scene.spheres {
        if let Some(found) = rays.meet_spheres(Vector::splat(center), F32s::splat(radius_squared)) {
            nearest.offer_in_order(&found, primitive);
        }
        primitive += 1;
    }
    nearest
}

fn visibility_in_short(
    blocked: &mut [u32],
    columns: &RayColumns,
    t_max: &[f32],
    rows: Range<usize>,
    (scene, reach): (&ShortScene, f32),
) {
    let mut corners = [Vector::splat([0.0; 3]); SHORT_CORNERS];
    for row in rows.clone().step_by(LANES) {
        let (origin, direction) = columns.eight(row);
        let t_max = lanes::load(t_max, row);
        let mask = if Rays::are_alike(origin, direction, reach) {
            blocked_in_short::<false>(&mut corners, (origin, direction), t_max, scene)
        } else {
            blocked_in_short::<true>(&mut corners, (origin, direction), t_max, scene)
        };
        lanes::store_u32(blocked, row, rows.end, mask.to_bits());
    }
}

#[inline(always)]
fn blocked_in_short<const HOPEFUL: bool>(
    corners: &mut [Vector<F32s>; SHORT_CORNERS],
    (origin, direction): (Vector<F32s>, Vector<F32s>),
    t_max: F32s,
    scene: &ShortScene,
) -> F32s {
    let (rays, renaming) = Rays::eight(origin, direction);
    shear_corners(corners, &rays, renaming, scene);
    let mut mask = F32s::ZERO;
    for &[a, b, c] in &scene.triangles {
        if let Some(found) = rays.meet_sheared::<HOPEFUL>(corners[a], corners[b], corners[c]) {
            mask |= found.mask & found.t.simd_lt(t_max);
        }
    }
    for &(center, radius_squared) in &scene.spheres {
        if let Some(found) = rays.meet_spheres(Vector::splat(center), F32s::splat(radius_squared)) {
            mask |= found.mask & found.t.simd_lt(t_max);
        }
    }
    mask
}

/// The corners of all triangles as eight rays see them.
#[inline(always)]
fn shear_corners(
    sheared: &mut [Vector<F32s>; SHORT_CORNERS],
    rays: &Rays,
    renaming: Renaming,
    scene: &ShortScene,
) {
    for (to, corner) in sheared.iter_mut().zip(&scene.corners) {
        *to = rays.sheared(renaming.apply(Vector::splat(*corner)));
    }
}
