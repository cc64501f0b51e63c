//! The eight-wide tree and how one ray goes through it.

use glam::Vec3;

use crate::math::{F32s, LANES};
use crate::scene::baked::{NONE, Sphere, Triangle};

use super::block::{LEAF, Leaf, Node, SphereBlock, TriangleBlock};
use super::builder::largest_coordinate;
use super::collapse::Tree;
use super::kernel::{Nearest, Rays, main_axis, renamed};

/// Scenes of at most so many primitives are traced eight rays at a time through all of them.
pub const SHORT_SCENE: usize = 48;

/// How far node bounds are pushed out, relative to the coordinates: 8 ulp, against 4 that the
/// rounding of the slab test and of the shear in the triangle test can add up to.
const PADDING: f32 = 8.0 * f32::EPSILON;

/// Components of a direction are at least this, relative to the largest, in the slab test: what
/// that moves a ray by within the scene is far below [`PADDING`].
const SMALLEST_COMPONENT: f32 = 1e-8;

/// All primitives of a scene, ready to be traced.
#[derive(Clone, Debug, PartialEq)]
pub struct Accelerator {
    tree: Tree,
    pub(super) short: Option<ShortScene>,
    triangle_count: usize,
    sphere_count: usize,
    reach: f32,
}

/// The primitives of a short scene in order.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ShortScene {
    pub triangles: Vec<[[f32; 3]; 3]>,
    /// Centers and squared radii.
    pub spheres: Vec<([f32; 3], f32)>,
}

/// The nearest hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in lengths of the direction; infinite when nothing is hit.
    pub t: f32,
    /// Barycentric weight of corner b, within [0, 1]; 0 for spheres.
    pub u: f32,
    /// Barycentric weight of corner c, within [0, 1]; 0 for spheres.
    pub v: f32,
    /// The primitive as [`crate::scene::baked::BakedScene`] numbers them, or [`NONE`].
    pub primitive: u32,
}

impl Hit {
    /// Nothing is hit.
    pub const MISS: Self = Self { t: f32::INFINITY, u: 0.0, v: 0.0, primitive: NONE };
}

/// What an accelerator is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Statistics {
    /// Triangles of the scene.
    pub triangles: usize,
    /// Spheres of the scene.
    pub spheres: usize,
    /// Nodes with up to eight children.
    pub nodes: usize,
    /// Leaves.
    pub leaves: usize,
    /// Blocks of up to eight triangles.
    pub triangle_blocks: usize,
    /// Blocks of up to eight spheres.
    pub sphere_blocks: usize,
    /// Nodes on the longest way to a leaf.
    pub depth: usize,
    /// Memory in bytes.
    pub bytes: usize,
}

/// What is still to be visited, nearest on top. Kept between rays, as clearing it costs time.
pub(super) struct Stack {
    entries: Vec<(f32, u32)>,
}

impl Stack {
    /// Room for the way through `accelerator`.
    pub fn new(accelerator: &Accelerator) -> Self {
        // A node takes its own entry and leaves at most eight; without nodes nothing is pushed.
        Self { entries: vec![(0.0, 0); accelerator.tree.depth as usize * LANES] }
    }
}

/// The ray in the form of the slab test: padded bounds are entered and left at
/// `bound * inverse + offset`.
struct Slabs {
    inverse: [F32s; 3],
    near: [F32s; 3],
    far: [F32s; 3],
    /// Per axis, which of the two bounds is nearer.
    sign: [usize; 3],
}

impl Slabs {
    #[inline(always)]
    fn new(origin: Vec3, direction: Vec3, reach: f32) -> Self {
        let smallest = SMALLEST_COMPONENT * direction.abs().max_element();
        let padding = PADDING * (origin.abs().max_element() + reach);
        let mut slabs = Self {
            inverse: [F32s::ZERO; 3],
            near: [F32s::ZERO; 3],
            far: [F32s::ZERO; 3],
            sign: [0; 3],
        };
        for axis in 0..3 {
            let inverse = 1.0 / direction[axis].abs().max(smallest).copysign(direction[axis]);
            let (offset, pad) = (-origin[axis] * inverse, padding * inverse.abs());
            slabs.inverse[axis] = F32s::splat(inverse);
            slabs.near[axis] = F32s::splat(offset - pad);
            slabs.far[axis] = F32s::splat(offset + pad);
            slabs.sign[axis] = usize::from(inverse < 0.0);
        }
        slabs
    }

    /// Where the ray enters each child, and the lanes of those it passes before `t_max`.
    #[inline(always)]
    fn enter(&self, node: &Node, t_max: F32s) -> (F32s, u32) {
        let near = |axis: usize| {
            let bound = node.bounds[axis][self.sign[axis] & 1];
            bound.mul_add(self.inverse[axis], self.near[axis])
        };
        let far = |axis: usize| {
            let bound = node.bounds[axis][(self.sign[axis] & 1) ^ 1];
            bound.mul_add(self.inverse[axis], self.far[axis])
        };
        let enter = near(0).fast_max(near(1)).fast_max(near(2).fast_max(F32s::ZERO));
        let leave = far(0).fast_min(far(1)).fast_min(far(2).fast_min(t_max));
        (enter, enter.simd_le(leave).to_bitmask())
    }
}

impl Accelerator {
    /// Builds the tree, in one thread; the same input gives the same tree, bit for bit.
    pub fn build(triangles: &[Triangle], spheres: &[Sphere]) -> Self {
        let is_short = triangles.len() + spheres.len() <= SHORT_SCENE;
        let of_sphere = |s: &Sphere| (s.center.to_array(), s.radius * s.radius);
        let short = is_short.then(|| ShortScene {
            triangles: triangles.iter().map(|t| t.corners.map(|c| c.to_array())).collect(),
            spheres: spheres.iter().map(of_sphere).collect(),
        });
        Self {
            tree: Tree::build(triangles, spheres),
            short,
            triangle_count: triangles.len(),
            sphere_count: spheres.len(),
            reach: largest_coordinate(triangles, spheres),
        }
    }

    /// The nearest hit with `0 < t < t_max`; of several at exactly the same distance, that of the
    /// smallest primitive. `direction` may have any length but zero.
    pub fn closest(&self, origin: Vec3, direction: Vec3, t_max: f32) -> Hit {
        self.closest_with(&mut Stack::new(self), origin, direction, t_max)
    }

    /// Whether anything is hit with `0 < t < t_max`.
    pub fn occluded(&self, origin: Vec3, direction: Vec3, t_max: f32) -> bool {
        self.occluded_with(&mut Stack::new(self), origin, direction, t_max)
    }

    /// Counts and memory.
    pub fn statistics(&self) -> Statistics {
        let tree = &self.tree;
        let bytes = size_of_val(tree.nodes.as_slice())
            + size_of_val(tree.leaves.as_slice())
            + size_of_val(tree.triangle_blocks.as_slice())
            + size_of_val(tree.sphere_blocks.as_slice());
        Statistics {
            triangles: self.triangle_count,
            spheres: self.sphere_count,
            nodes: tree.nodes.len(),
            leaves: tree.leaves.len(),
            triangle_blocks: tree.triangle_blocks.len(),
            sphere_blocks: tree.sphere_blocks.len(),
            depth: tree.depth as usize,
            bytes,
        }
    }

    /// [`Accelerator::closest`] with a stack to reuse.
    #[inline(always)]
    pub(super) fn closest_with(
        &self,
        stack: &mut Stack,
        origin: Vec3,
        direction: Vec3,
        t_max: f32,
    ) -> Hit {
        let axes = renamed(main_axis(direction));
        let rays = Rays::one(origin, direction, axes);
        let mut nearest = Nearest::none(F32s::splat(t_max));
        if self.tree.root & LEAF != 0 {
            self.visit_leaf(&mut nearest, self.leaf(self.tree.root), &rays, axes);
            return single_hit(&nearest);
        }
        let slabs = Slabs::new(origin, direction, self.reach);
        let stack = &mut stack.entries[..];
        let mut t_best = t_max;
        let mut top = 0;
        let mut reference = self.tree.root;
        loop {
            if reference & LEAF != 0 {
                if self.visit_leaf(&mut nearest, self.leaf(reference), &rays, axes) {
                    t_best = nearest.smallest_t();
                }
            } else {
                let node = &self.tree.nodes[reference as usize];
                let (enter, lanes) = slabs.enter(node, F32s::splat(t_best));
                if lanes != 0 {
                    // The nearest child is next, without a detour over the stack.
                    top = push_sorted(stack, top, enter.as_array(), node, lanes) - 1;
                    reference = stack[top].1;
                    continue;
                }
            }
            loop {
                if top == 0 {
                    return single_hit(&nearest);
                }
                top -= 1;
                if stack[top].0 <= t_best {
                    break;
                }
            }
            reference = stack[top].1;
        }
    }

    /// [`Accelerator::occluded`] with a stack to reuse.
    #[inline(always)]
    pub(super) fn occluded_with(
        &self,
        stack: &mut Stack,
        origin: Vec3,
        direction: Vec3,
        t_max: f32,
    ) -> bool {
        let axes = renamed(main_axis(direction));
        let rays = Rays::one(origin, direction, axes);
        let limit = F32s::splat(t_max);
        if self.tree.root & LEAF != 0 {
            return self.leaf_blocks(self.leaf(self.tree.root), &rays, axes, limit);
        }
        let slabs = Slabs::new(origin, direction, self.reach);
        let stack = &mut stack.entries[..];
        let mut top = 1;
        stack[0].1 = self.tree.root;
        while top > 0 {
            top -= 1;
            let reference = stack[top].1;
            if reference & LEAF != 0 {
                if self.leaf_blocks(self.leaf(reference), &rays, axes, limit) {
                    return true;
                }
                continue;
            }
            let node = &self.tree.nodes[reference as usize];
            let (_, mut lanes) = slabs.enter(node, limit);
            while lanes != 0 {
                let lane = (lanes.trailing_zeros() & 7) as usize;
                lanes &= lanes - 1;
                stack[top].1 = node.children[lane];
                top += 1;
            }
        }
        false
    }

    #[inline(always)]
    fn leaf(&self, reference: u32) -> &Leaf {
        &self.tree.leaves[(reference & !LEAF) as usize]
    }

    #[inline(always)]
    fn blocks(&self, leaf: &Leaf) -> (&[TriangleBlock], &[SphereBlock]) {
        let [first, end] = leaf.triangles.map(|row| row as usize);
        let triangles = &self.tree.triangle_blocks[first..end];
        let [first, end] = leaf.spheres.map(|row| row as usize);
        (triangles, &self.tree.sphere_blocks[first..end])
    }

    /// Takes over what the leaf has to offer; whether there was anything.
    #[inline(always)]
    fn visit_leaf(
        &self,
        nearest: &mut Nearest,
        leaf: &Leaf,
        rays: &Rays,
        axes: [usize; 3],
    ) -> bool {
        let (triangles, spheres) = self.blocks(leaf);
        let mut any = false;
        for block in triangles {
            any |= nearest.offer(&block.meet(rays, axes), block.primitives);
        }
        for block in spheres {
            any |= nearest.offer(&block.meet(rays), block.primitives);
        }
        any
    }

    /// Whether anything in the leaf is nearer than `t_max`.
    #[inline(always)]
    fn leaf_blocks(&self, leaf: &Leaf, rays: &Rays, axes: [usize; 3], t_max: F32s) -> bool {
        let (triangles, spheres) = self.blocks(leaf);
        for block in triangles {
            let found = block.meet(rays, axes);
            if (found.mask & found.t.simd_lt(t_max)).any() {
                return true;
            }
        }
        for block in spheres {
            let found = block.meet(rays);
            if (found.mask & found.t.simd_lt(t_max)).any() {
                return true;
            }
        }
        false
    }
}

/// Pushes the children in `lanes` with the nearest on top; returns the new top.
#[inline(always)]
fn push_sorted(
    stack: &mut [(f32, u32)],
    base: usize,
    enter: &[f32; LANES],
    node: &Node,
    mut lanes: u32,
) -> usize {
    let mut top = base;
    while lanes != 0 {
        let lane = (lanes.trailing_zeros() & 7) as usize;
        lanes &= lanes - 1;
        let entry = (enter[lane], node.children[lane]);
        let mut slot = top;
        while slot > base && stack[slot - 1].0 < entry.0 {
            stack[slot] = stack[slot - 1];
            slot -= 1;
        }
        stack[slot] = entry;
        top += 1;
    }
    top
}

/// The nearest hit of one ray, of those that the lanes found.
#[inline(always)]
fn single_hit(nearest: &Nearest) -> Hit {
    let t = nearest.smallest_t();
    let mut lanes = nearest.t.simd_eq(F32s::splat(t)).to_bitmask();
    let primitives = nearest.primitive.as_array();
    let mut best = (lanes.trailing_zeros() & 7) as usize;
    lanes &= lanes.wrapping_sub(1);
    while lanes != 0 {
        let lane = (lanes.trailing_zeros() & 7) as usize;
        lanes &= lanes - 1;
        if primitives[lane] < primitives[best] {
            best = lane;
        }
    }
    if primitives[best] == NONE {
        return Hit::MISS;
    }
    Hit {
        t,
        u: nearest.u.as_array()[best],
        v: nearest.v.as_array()[best],
        primitive: primitives[best],
    }
}
