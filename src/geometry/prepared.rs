//! Rays in the forms of the tests, computed for eight at a time.

use crate::math::{F32s, LANES, Vector, lanes};

use super::block::Node;
use super::kernel::Rays;

/// Rays that are prepared together.
pub(super) const BATCH: usize = 128;

/// How far node bounds are pushed out, relative to the coordinates: 8 ulp, against 4 that the
/// rounding of the slab test and of the shear in the triangle test can add up to.
const PADDING: f32 = 8.0 * f32::EPSILON;

/// Components of a direction are at least this, relative to the largest, in the slab test: what
/// that moves a ray by within the scene is far below [`PADDING`].
const SMALLEST_COMPONENT: f32 = 1e-8;

pub(super) type Column = [f32; BATCH];

/// Rays in the forms of the tests.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Prepared {
    origin: [Column; 3],
    direction: [Column; 3],
    /// The slab test: padded bounds are entered at `bound * inverse + near` and left at
    /// `bound * inverse + far`.
    inverse: [Column; 3],
    near: [Column; 3],
    far: [Column; 3],
    /// The triangle test, see [`Rays`].
    local: [Column; 3],
    shear: [Column; 2],
    scale: Column,
    /// Per axis, all bits where the nearer bound is the upper one.
    is_backward: [[u32; BATCH]; 3],
    /// The axis that becomes the last.
    pub main_axis: [u32; BATCH],
}

impl Default for Prepared {
    fn default() -> Self {
        let none = [0.0; BATCH];
        Self {
            origin: [none; 3],
            direction: [none; 3],
            inverse: [none; 3],
            near: [none; 3],
            far: [none; 3],
            local: [none; 3],
            shear: [none; 2],
            scale: none,
            is_backward: [[0; BATCH]; 3],
            main_axis: [0; BATCH],
        }
    }
}

impl Prepared {
    /// Prepares eight rays in the places from `first` on. Directions have any length but zero.
    #[inline(always)]
    pub fn prepare(
        &mut self,
        first: usize,
        origin: Vector<F32s>,
        direction: Vector<F32s>,
        reach: F32s,
    ) {
        let (o, d) = ([origin.x, origin.y, origin.z], [direction.x, direction.y, direction.z]);
        let largest = |v: &[F32s; 3]| v[0].abs().fast_max(v[1].abs()).fast_max(v[2].abs());
        let smallest = largest(&d) * F32s::splat(SMALLEST_COMPONENT);
        let padding = (largest(&o) + reach) * F32s::splat(PADDING);
        for axis in 0..3 {
            let magnitude = F32s::ONE / d[axis].abs().fast_max(smallest);
            let inverse = magnitude.copysign(d[axis]);
            let (offset, pad) = (-(o[axis] * inverse), padding * magnitude);
            set(&mut self.origin[axis], first, o[axis]);
            set(&mut self.direction[axis], first, d[axis]);
            set(&mut self.inverse[axis], first, inverse);
            set(&mut self.near[axis], first, offset - pad);
            set(&mut self.far[axis], first, offset + pad);
            let is_backward = inverse.simd_lt(F32s::ZERO).to_bits();
            self.is_backward[axis][first..first + LANES].copy_from_slice(is_backward.as_array());
        }
        let (rays, renaming) = Rays::eight(origin, direction);
        set(&mut self.local[0], first, rays.local.x);
        set(&mut self.local[1], first, rays.local.y);
        set(&mut self.local[2], first, rays.local.z);
        set(&mut self.shear[0], first, rays.shear[0]);
        set(&mut self.shear[1], first, rays.shear[1]);
        set(&mut self.scale, first, rays.scale);
        let main_axis = renaming.main_axis();
        self.main_axis[first..first + LANES].copy_from_slice(main_axis.as_array());
    }

    /// [`Rays::are_alike`] of the eight rays from `first` on.
    #[inline(always)]
    pub fn are_alike(&self, first: usize, reach: f32) -> bool {
        let vector = |[x, y, z]: &[Column; 3]| Vector {
            x: get(x, first),
            y: get(y, first),
            z: get(z, first),
        };
        Rays::are_alike(vector(&self.origin), vector(&self.direction), reach)
    }

    /// Where each of the eight rays from `first` on enters the child in `lane`, and which of them
    /// pass it before `t_max`.
    #[inline(always)]
    pub fn enter_one(&self, first: usize, node: &Node, lane: usize, t_max: F32s) -> (F32s, F32s) {
        let at = |axis: usize| {
            let [lower, upper] = &node.bounds[axis];
            let inverse = get(&self.inverse[axis], first);
            let [lower, upper] = [lower, upper].map(|b| F32s::splat(b.as_array()[lane]) * inverse);
            let (near, far) = (lower.fast_min(upper), lower.fast_max(upper));
            (near + get(&self.near[axis], first), far + get(&self.far[axis], first))
        };
        let [x, y, z] = [at(0), at(1), at(2)];
        let enter = x.0.fast_max(y.0).fast_max(z.0.fast_max(F32s::ZERO));
        let leave = x.1.fast_min(y.1).fast_min(z.1.fast_min(t_max));
        (enter, enter.simd_le(leave))
    }

    /// Where a ray enters each child, and the lanes of those it passes between two distances.
    #[inline(always)]
    pub fn enter(&self, ray: usize, node: &Node, [t_min, t_max]: [f32; 2]) -> (F32s, F32s) {
        let at = |axis: usize, side: usize, offset: &Column| {
            let backward = (self.is_backward[axis][ray] & 1) as usize;
            let bound = node.bounds[axis][backward ^ side];
            bound.mul_add(F32s::splat(self.inverse[axis][ray]), F32s::splat(offset[ray]))
        };
        let near = |axis: usize| at(axis, 0, &self.near[axis]);
        let far = |axis: usize| at(axis, 1, &self.far[axis]);
        let enter = near(0).fast_max(near(1)).fast_max(near(2).fast_max(F32s::splat(t_min)));
        let leave = far(0).fast_min(far(1)).fast_min(far(2).fast_min(F32s::splat(t_max)));
        (enter, enter.simd_le(leave))
    }

    /// Origin and direction of a ray.
    #[inline(always)]
    pub fn world_ray(&self, ray: usize) -> [[f32; 3]; 2] {
        let at = |columns: &[Column; 3]| [columns[0][ray], columns[1][ray], columns[2][ray]];
        [at(&self.origin), at(&self.direction)]
    }

    /// One ray in all lanes.
    #[inline(always)]
    pub fn rays(&self, ray: usize) -> Rays {
        let vector = |columns: &[Column; 3]| Vector {
            x: F32s::splat(columns[0][ray]),
            y: F32s::splat(columns[1][ray]),
            z: F32s::splat(columns[2][ray]),
        };
        Rays {
            origin: vector(&self.origin),
            direction: vector(&self.direction),
            local: vector(&self.local),
            shear: [F32s::splat(self.shear[0][ray]), F32s::splat(self.shear[1][ray])],
            scale: F32s::splat(self.scale[ray]),
        }
    }
}

#[inline(always)]
fn get(column: &Column, first: usize) -> F32s {
    lanes::load(column, first)
}

#[inline(always)]
fn set(column: &mut Column, first: usize, value: F32s) {
    column[first..first + LANES].copy_from_slice(value.as_array());
}
