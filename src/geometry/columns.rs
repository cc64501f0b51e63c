//! Tracing whole columns of rays, one row a ray.

use std::ops::Range;

use crate::math::columns::Rows;
use crate::math::{F32s, LANES, U32s, Vector, lanes};
use crate::scene::baked::NONE;

use super::accelerator::{Accelerator, SHORT_SCENE, ShortScene};
use super::kernel::{Nearest, Rays, Renaming};
use super::rays::{Hit, HitColumns, RayColumns};
use super::tree::Tree;
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
        let scene = (scene, accelerator.tree.reach);
        return closest_in_short(hits, &mut scratch.corners, rays, rows, scene);
    }
    hits.t[rows.clone()].fill(f32::INFINITY);
    hits.u[rows.clone()].fill(0.0);
    hits.v[rows.clone()].fill(0.0);
    hits.primitive[rows.clone()].fill(NONE);
    let better = |row: usize, hit: Hit| {
        hits.set(row, hit);
        true
    };
    let load = |row: usize| rays.eight(row);
    let (tree, t_max) = (&accelerator.tree, |_| f32::INFINITY);
    match tree.is_large() {
        false => walk::<1, false>(tree, rows, load, t_max, scratch, better),
        true => walk::<FLIGHT, false>(tree, rows, load, t_max, scratch, better),
    }
}

/// What becomes of a ray that meets only what lets it pass; see [`trace_visibility_past`].
pub const CROSSES: u32 = 1;

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
        let scene = (scene, accelerator.tree.reach);
        return visibility_in_short(blocked, &mut scratch.corners, (rays, t_max), rows, scene);
    }
    any_in_tree(blocked, scratch, (rays, t_max), rows, &accelerator.tree, |_| false);
}

/// [`trace_visibility`] past the primitives that `passes` names: where a ray meets nothing but
/// those, its `blocked` becomes [`CROSSES`].
// By way of a pointer: walks are large, and what a hit is asked is no loop.
pub fn trace_visibility_past(
    blocked: &mut [u32],
    scratch: &mut TraceScratch,
    (rays, t_max): (&RayColumns, &[f32]),
    rows: Range<usize>,
    accelerator: &Accelerator,
    passes: &dyn Fn(u32) -> bool,
) {
    if let Some(scene) = &accelerator.short {
        let scene = (scene, accelerator.tree.reach, Past::new(scene, passes));
        let corners = &mut scratch.corners;
        return visibility_past_in_short(blocked, corners, (rays, t_max), rows, scene);
    }
    any_in_tree(blocked, scratch, (rays, t_max), rows, &accelerator.tree, passes);
}

#[inline(always)]
fn any_in_tree(
    blocked: &mut [u32],
    scratch: &mut TraceScratch,
    (rays, t_max): (&RayColumns, &[f32]),
    rows: Range<usize>,
    tree: &Tree,
    passes: impl Fn(u32) -> bool,
) {
    blocked[rows.clone()].fill(0);
    let better = |row: usize, hit: Hit| {
        let ends = !passes(hit.primitive);
        // Not instead of what it was: more may be met in the leaf where a ray has ended.
        blocked[row] |= if ends { u32::MAX } else { CROSSES };
        ends
    };
    let load = |row: usize| rays.eight(row);
    let t_max = |row: usize| t_max[row];
    match tree.is_large() {
        false => walk::<1, true>(tree, rows, load, t_max, scratch, better),
        true => walk::<FLIGHT, true>(tree, rows, load, t_max, scratch, better),
    }
}

fn closest_in_short(
    hits: &mut HitColumns,
    corners: &mut Vec<Vector<F32s>>,
    columns: &RayColumns,
    rows: Range<usize>,
    (scene, reach): (&ShortScene, f32),
) {
    let corners = room_for_corners(corners, scene);
    for row in rows.clone().step_by(LANES) {
        let (origin, direction) = columns.eight(row);
        let nearest = if Rays::are_alike(origin, direction, reach) {
            nearest_in_short::<false>(corners, origin, direction, scene)
        } else {
            nearest_in_short::<true>(corners, origin, direction, scene)
        };
        lanes::store(&mut hits.t, row, rows.end, nearest.t);
        lanes::store(&mut hits.u, row, rows.end, nearest.u);
        lanes::store(&mut hits.v, row, rows.end, nearest.v);
        lanes::store_u32(&mut hits.primitive, row, rows.end, nearest.primitive);
    }
}

#[inline(always)]
fn nearest_in_short<const HOPEFUL: bool>(
    corners: &mut [Vector<F32s>],
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

/// Moves hits on to the next ones; see [`super::trace_next`].
pub(super) fn next_in_short(
    hits: &mut HitColumns,
    corners: &mut Vec<Vector<F32s>>,
    (columns, t_max): (&RayColumns, &[f32]),
    rows: Range<usize>,
    scene: &ShortScene,
) {
    let corners = room_for_corners(corners, scene);
    for row in rows.clone().step_by(LANES) {
        let (origin, direction) = columns.eight(row);
        let (rays, renaming) = Rays::eight(origin, direction);
        shear_corners(corners, &rays, renaming, scene);
        let after = (lanes::load(&hits.t, row), lanes::load_u32(&hits.primitive, row));
        let mut next = Nearest::none(lanes::load(t_max, row));
        for (&[a, b, c], primitive) in scene.triangles.iter().zip(0..) {
            if let Some(found) = rays.meet_sheared::<false>(corners[a], corners[b], corners[c]) {
                next.offer_beyond(after, &found, primitive);
            }
        }
        let spheres = scene.spheres.iter().zip(scene.triangles.len() as u32..);
        for (&(center, radius_squared), primitive) in spheres {
            let (center, radius_squared) = (Vector::splat(center), F32s::splat(radius_squared));
            for found in rays.meet_spheres_twice(center, radius_squared).iter().flatten() {
                next.offer_beyond(after, found, primitive);
            }
        }
        let Nearest { t, u, v, primitive } = next;
        let missed: F32s = bytemuck::cast(primitive.simd_eq(U32s::splat(NONE)));
        lanes::store(&mut hits.t, row, rows.end, missed.select(F32s::splat(f32::INFINITY), t));
        lanes::store(&mut hits.u, row, rows.end, u);
        lanes::store(&mut hits.v, row, rows.end, v);
        lanes::store_u32(&mut hits.primitive, row, rows.end, primitive);
    }
}

fn visibility_in_short(
    blocked: &mut [u32],
    corners: &mut Vec<Vector<F32s>>,
    (columns, t_max): (&RayColumns, &[f32]),
    rows: Range<usize>,
    (scene, reach): (&ShortScene, f32),
) {
    let corners = room_for_corners(corners, scene);
    for row in rows.clone().step_by(LANES) {
        let rays = columns.eight(row);
        let t_max = lanes::load(t_max, row);
        let mut mask = F32s::ZERO;
        let meets = |met: F32s, _| mask |= met;
        if Rays::are_alike(rays.0, rays.1, reach) {
            any_in_short::<false>(corners, rays, t_max, scene, meets);
        } else {
            any_in_short::<true>(corners, rays, t_max, scene, meets);
        }
        lanes::store_u32(blocked, row, rows.end, mask.to_bits());
    }
}

/// Which primitives of a short scene let rays pass: all bits of what ends them are set.
struct Past([u32; SHORT_SCENE]);

impl Past {
    fn new(scene: &ShortScene, passes: &dyn Fn(u32) -> bool) -> Self {
        let mut ends = [u32::MAX; SHORT_SCENE];
        let count = scene.triangles.len() + scene.spheres.len();
        for (ends, primitive) in ends[..count].iter_mut().zip(0..) {
            *ends = u32::from(passes(primitive)).wrapping_sub(1);
        }
        Self(ends)
    }
}

fn visibility_past_in_short(
    blocked: &mut [u32],
    corners: &mut Vec<Vector<F32s>>,
    (columns, t_max): (&RayColumns, &[f32]),
    rows: Range<usize>,
    (scene, reach, Past(ends)): (&ShortScene, f32, Past),
) {
    let corners = room_for_corners(corners, scene);
    for row in rows.clone().step_by(LANES) {
        let rays = columns.eight(row);
        let t_max = lanes::load(t_max, row);
        let (mut ended, mut met) = (U32s::splat(0), U32s::splat(0));
        let meets = |these: F32s, primitive: u32| {
            let these = these.to_bits();
            ended |= these & U32s::splat(ends[primitive as usize]);
            met |= these;
        };
        if Rays::are_alike(rays.0, rays.1, reach) {
            any_in_short::<false>(corners, rays, t_max, scene, meets);
        } else {
            any_in_short::<true>(corners, rays, t_max, scene, meets);
        }
        lanes::store_u32(blocked, row, rows.end, ended | met & U32s::splat(CROSSES));
    }
}

/// Where the corners of a short scene are kept as rays see them: memory that is there already.
fn room_for_corners<'a>(
    corners: &'a mut Vec<Vector<F32s>>,
    scene: &ShortScene,
) -> &'a mut [Vector<F32s>] {
    if corners.len() < scene.corners.len() {
        corners.resize(scene.corners.len(), Vector::splat([0.0; 3]));
    }
    corners
}

/// Tells `meets` of each primitive which rays meet it.
#[inline(always)]
fn any_in_short<const HOPEFUL: bool>(
    corners: &mut [Vector<F32s>],
    (origin, direction): (Vector<F32s>, Vector<F32s>),
    t_max: F32s,
    scene: &ShortScene,
    mut meets: impl FnMut(F32s, u32),
) {
    let (rays, renaming) = Rays::eight(origin, direction);
    shear_corners(corners, &rays, renaming, scene);
    for (&[a, b, c], primitive) in scene.triangles.iter().zip(0..) {
        if let Some(found) = rays.meet_sheared::<HOPEFUL>(corners[a], corners[b], corners[c]) {
            meets(found.mask & found.t.simd_lt(t_max), primitive);
        }
    }
    for (&(center, radius_squared), primitive) in
        scene.spheres.iter().zip(scene.triangles.len() as u32..)
    {
        if let Some(found) = rays.meet_spheres(Vector::splat(center), F32s::splat(radius_squared)) {
            meets(found.mask & found.t.simd_lt(t_max), primitive);
        }
    }
}

/// The corners of all triangles as eight rays see them.
#[inline(always)]
fn shear_corners(
    sheared: &mut [Vector<F32s>],
    rays: &Rays,
    renaming: Renaming,
    scene: &ShortScene,
) {
    for (to, corner) in sheared.iter_mut().zip(&scene.corners) {
        *to = rays.sheared(renaming.apply(Vector::splat(*corner)));
    }
}
