//! Tracing whole columns of rays, one row a ray.

use std::ops::Range;

use glam::Vec3;

use crate::math::{F32s, LANES, U32s, Vector, lanes};
use crate::scene::baked::NONE;

use super::accelerator::{Accelerator, ShortScene, Stack};
use super::kernel::{Candidates, Nearest, Rays, Renaming, splat};

/// Marks, in the place of a primitive, that a ray ended in a medium before it met one; the row of
/// the medium is added. Smaller than [`NONE`].
pub const IN_MEDIUM: u32 = 1 << 31;

/// The medium of a primitive that is marked by [`IN_MEDIUM`].
#[inline(always)]
pub fn medium_met(primitive: u32) -> Option<u32> {
    (primitive >= IN_MEDIUM && primitive != NONE).then_some(primitive - IN_MEDIUM)
}

/// Rays. Columns are padded by [`LANES`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RayColumns {
    /// Origins, already off the surface they leave (see [`super::offset_origin`]).
    pub origin: [Vec<f32>; 3],
    /// Directions, unit length.
    pub direction: [Vec<f32>; 3],
}

impl RayColumns {
    /// Room for `capacity` rays.
    pub fn new(capacity: usize) -> Self {
        let column = || vec![0.0; capacity + LANES];
        Self {
            origin: std::array::from_fn(|_| column()),
            direction: std::array::from_fn(|_| column()),
        }
    }

    #[inline(always)]
    fn row(&self, row: usize) -> (Vec3, Vec3) {
        let vector =
            |columns: &[Vec<f32>; 3]| Vec3::new(columns[0][row], columns[1][row], columns[2][row]);
        (vector(&self.origin), vector(&self.direction))
    }
}

/// Nearest hits. Columns are padded by [`LANES`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HitColumns {
    /// Distance; infinite when nothing is hit.
    pub t: Vec<f32>,
    /// Barycentric weight of corner b; 0 for spheres.
    pub u: Vec<f32>,
    /// Barycentric weight of corner c; 0 for spheres.
    pub v: Vec<f32>,
    /// The primitive, [`NONE`], or a medium ([`IN_MEDIUM`]).
    pub primitive: Vec<u32>,
}

impl HitColumns {
    /// Room for the hits of `capacity` rays.
    pub fn new(capacity: usize) -> Self {
        let column = || vec![0.0; capacity + LANES];
        let primitive = vec![NONE; capacity + LANES];
        Self { t: column(), u: column(), v: column(), primitive }
    }
}

/// Finds the nearest hit of each ray in `rows`.
pub fn trace_closest(
    hits: &mut HitColumns,
    rays: &RayColumns,
    rows: Range<usize>,
    accelerator: &Accelerator,
) {
    if let Some(scene) = &accelerator.short {
        return closest_in_short(hits, rays, rows, scene);
    }
    let stack = &mut Stack::new(accelerator);
    for row in rows {
        let (origin, direction) = rays.row(row);
        let hit = accelerator.closest_with(stack, origin, direction, f32::INFINITY);
        hits.t[row] = hit.t;
        hits.u[row] = hit.u;
        hits.v[row] = hit.v;
        hits.primitive[row] = hit.primitive;
    }
}

/// Finds which rays in `rows` meet anything with `0 < t < t_max`: their `blocked` becomes
/// `u32::MAX`, that of the others 0. `t_max` is padded by [`LANES`] like the rays.
pub fn trace_visibility(
    blocked: &mut [u32],
    rays: &RayColumns,
    t_max: &[f32],
    rows: Range<usize>,
    accelerator: &Accelerator,
) {
    if let Some(scene) = &accelerator.short {
        return visibility_in_short(blocked, rays, t_max, rows, scene);
    }
    let stack = &mut Stack::new(accelerator);
    for row in rows {
        let (origin, direction) = rays.row(row);
        let is_blocked = accelerator.occluded_with(stack, origin, direction, t_max[row]);
        blocked[row] = if is_blocked { u32::MAX } else { 0 };
    }
}

#[inline(always)]
fn load_rays(rays: &RayColumns, row: usize) -> (Rays, Renaming) {
    Rays::eight(Vector::load(&rays.origin, row), Vector::load(&rays.direction, row))
}

#[inline(always)]
fn meet_triangle(rays: &Rays, renaming: Renaming, corners: &[[f32; 3]; 3]) -> Candidates {
    rays.meet_triangles(corners.map(|corner| renaming.apply(splat(corner))))
}

fn closest_in_short(
    hits: &mut HitColumns,
    columns: &RayColumns,
    rows: Range<usize>,
    scene: &ShortScene,
) {
    for row in rows.clone().step_by(LANES) {
        let (rays, renaming) = load_rays(columns, row);
        let mut nearest = Nearest::none(F32s::splat(f32::INFINITY));
        let mut primitive = 0;
        for corners in &scene.triangles {
            nearest.offer_in_order(&meet_triangle(&rays, renaming, corners), primitive);
            primitive += 1;
        }
        for &(center, radius_squared) in &scene.spheres {
            let found = rays.meet_spheres(splat(center), F32s::splat(radius_squared));
            nearest.offer_in_order(&found, primitive);
            primitive += 1;
        }
        lanes::store(&mut hits.t, row, rows.end, nearest.t);
        lanes::store(&mut hits.u, row, rows.end, nearest.u);
        lanes::store(&mut hits.v, row, rows.end, nearest.v);
        store_u32(&mut hits.primitive, row, rows.end, nearest.primitive);
    }
}

fn visibility_in_short(
    blocked: &mut [u32],
    columns: &RayColumns,
    t_max: &[f32],
    rows: Range<usize>,
    scene: &ShortScene,
) {
    for row in rows.clone().step_by(LANES) {
        let (rays, renaming) = load_rays(columns, row);
        let t_max = lanes::load(t_max, row);
        let mut mask = F32s::ZERO;
        for corners in &scene.triangles {
            let found = meet_triangle(&rays, renaming, corners);
            mask |= found.mask & found.t.simd_lt(t_max);
        }
        for &(center, radius_squared) in &scene.spheres {
            let found = rays.meet_spheres(splat(center), F32s::splat(radius_squared));
            mask |= found.mask & found.t.simd_lt(t_max);
        }
        store_u32(blocked, row, rows.end, mask.to_bits());
    }
}

/// [`lanes::store`] for identifiers.
#[inline(always)]
pub(super) fn store_u32(column: &mut [u32], row: usize, end: usize, value: U32s) {
    let lanes = value.to_array();
    let count = LANES.min(end - row);
    column[row..row + count].copy_from_slice(&lanes[..count]);
}
