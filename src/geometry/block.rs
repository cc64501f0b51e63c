//! What the eight-wide tree is made of.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::Vec3A;

use crate::math::{F32s, LANES, U32s, Vector};
use crate::scene::baked::{NONE, Sphere, Triangle};

use super::kernel::{Candidates, Rays};

/// Says of a reference that it is a leaf.
const LEAF: u32 = 1 << 31;
/// Says of a leaf that it is not of triangles.
const OTHER: u32 = 1 << 30;
/// Where the number of blocks of a leaf, less one, begins.
const COUNT_SHIFT: u32 = 28;
/// Says of such a leaf that it is an instance, and not of spheres.
const INSTANCE: u32 = 1 << 27;
/// Most blocks of a leaf.
pub(super) const LEAF_BLOCKS: u32 = 4;

/// What a child of a node is: a row of the nodes, a few blocks of one kind, or an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub(super) struct Reference(u32);

/// Lengths of the tables that references refer to.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rows {
    pub nodes: usize,
    pub triangle_blocks: usize,
    pub sphere_blocks: usize,
}

impl Default for Reference {
    fn default() -> Self {
        Self::NONE
    }
}

impl Reference {
    /// No child.
    pub const NONE: Self = Self(u32::MAX);

    /// The node in row `row`.
    pub fn node(row: usize) -> Self {
        debug_assert!(row < LEAF as usize, "fewer than 2^31 nodes");
        Self(row as u32)
    }

    /// The leaf of `count` blocks from row `first`.
    pub fn leaf(first: usize, count: u32, of_spheres: bool) -> Self {
        let rows = if of_spheres { INSTANCE } else { 1 << COUNT_SHIFT };
        debug_assert!(first < rows as usize && (1..=LEAF_BLOCKS).contains(&count));
        let kind = if of_spheres { OTHER } else { 0 };
        Self(LEAF | kind | ((count - 1) << COUNT_SHIFT) | first as u32)
    }

    /// The instance in row `row`.
    pub fn instance(row: usize) -> Self {
        debug_assert!(row < INSTANCE as usize);
        Self(LEAF | OTHER | INSTANCE | row as u32)
    }

    /// The same when the tables that it refers to are appended to others of `base` rows.
    pub fn moved(self, base: Rows) -> Self {
        let rows = match self.is_leaf() {
            false => base.nodes,
            true if self.is_of_triangles() => base.triangle_blocks,
            true if self.as_instance().is_none() => base.sphere_blocks,
            // Instances have a table for all, and no child has none.
            true => 0,
        };
        Self(self.0 + rows as u32)
    }

    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.0 & LEAF != 0
    }

    /// Of a leaf: whether its blocks are of triangles.
    #[inline(always)]
    pub fn is_of_triangles(self) -> bool {
        self.0 & OTHER == 0
    }

    /// Of a leaf not of triangles: the row of an instance.
    #[inline(always)]
    pub fn as_instance(self) -> Option<usize> {
        (self.0 & INSTANCE != 0).then_some((self.0 & (INSTANCE - 1)) as usize)
    }

    /// Of a node: its row.
    #[inline(always)]
    pub fn row(self) -> usize {
        self.0 as usize
    }

    /// Of a leaf but an instance: the rows of its blocks.
    #[inline(always)]
    pub fn blocks(self) -> Range<usize> {
        let first = (self.0 & ((1 << COUNT_SHIFT) - 1)) as usize;
        first..first + ((self.0 >> COUNT_SHIFT) & (LEAF_BLOCKS - 1)) as usize + 1
    }
}

/// Up to eight children. Vacant ones have bounds that no ray enters.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Per axis, the lower and the upper bounds of the children.
    pub bounds: [[F32s; 2]; 3],
    pub children: [Reference; LANES],
    /// Fills the last of four cache lines.
    _padding: [u32; LANES],
}

impl Node {
    /// A node without children.
    pub fn vacant() -> Self {
        let none = [F32s::splat(f32::INFINITY), F32s::splat(f32::NEG_INFINITY)];
        Self { bounds: [none; 3], children: [Reference::NONE; LANES], _padding: [0; LANES] }
    }
}

/// Up to eight triangles. Vacant lanes have no area, so nothing hits them.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct TriangleBlock {
    /// Per corner and axis, the coordinates.
    corners: [[F32s; 3]; 3],
    pub primitives: U32s,
}

impl TriangleBlock {
    /// The triangles of at most eight `primitives`.
    pub fn new(primitives: &[u32], triangles: &[Triangle]) -> Self {
        let mut corners = [[[0.0; LANES]; 3]; 3];
        let mut ids = [NONE; LANES];
        for (lane, &primitive) in primitives.iter().enumerate() {
            ids[lane] = primitive;
            for (corner, position) in triangles[primitive as usize].corners.iter().enumerate() {
                for axis in 0..3 {
                    corners[corner][axis][lane] = position[axis];
                }
            }
        }
        Self { corners: corners.map(|axes| axes.map(F32s::from)), primitives: U32s::from(ids) }
    }

    /// Corners with their axes renamed.
    #[inline(always)]
    pub fn corners(&self, [x, y, z]: [usize; 3]) -> [Vector<F32s>; 3] {
        let corner = |of: &[F32s; 3]| Vector::new(of[x], of[y], of[z]);
        let [a, b, c] = &self.corners;
        [corner(a), corner(b), corner(c)]
    }

    /// One ray against the block, if it meets anything; `axes` are those of the ray.
    #[inline(always)]
    pub fn meet(&self, rays: &Rays, axes: [usize; 3]) -> Option<Candidates> {
        rays.meet_triangles(self.corners(axes))
    }
}

/// Up to eight spheres. Vacant lanes have a negative squared radius, so nothing hits them.
#[derive(Clone, Debug, PartialEq)]
#[repr(align(64))]
pub(super) struct SphereBlock {
    center: Vector<F32s>,
    radius_squared: F32s,
    pub primitives: U32s,
}

impl SphereBlock {
    /// The spheres of at most eight `primitives`, of which the first `triangle_count` of the
    /// scene are none.
    pub fn new(primitives: &[u32], spheres: &[Sphere], triangle_count: u32) -> Self {
        let mut center = [[0.0; 3]; LANES];
        let mut radius_squared = [-1.0; LANES];
        let mut ids = [NONE; LANES];
        for (lane, &primitive) in primitives.iter().enumerate() {
            let sphere = &spheres[(primitive - triangle_count) as usize];
            ids[lane] = primitive;
            center[lane] = sphere.center.to_array();
            radius_squared[lane] = sphere.radius * sphere.radius;
        }
        Self {
            center: Vector::gather(|lane| center[lane]),
            radius_squared: F32s::from(radius_squared),
            primitives: U32s::from(ids),
        }
    }

    /// One ray against the block, if it meets anything.
    #[inline(always)]
    pub fn meet(&self, rays: &Rays) -> Option<Candidates> {
        rays.meet_spheres(self.center, self.radius_squared)
    }

    /// Centers and radii.
    pub fn spheres(&self) -> impl Iterator<Item = (Vec3A, f32)> + '_ {
        let radii = self.radius_squared.to_array().into_iter().enumerate();
        let in_use = radii.filter(|(_, squared)| *squared >= 0.0);
        in_use.map(|(lane, squared)| {
            (Vec3A::from(<[f32; 3]>::from(self.center.lane(lane))), squared.sqrt())
        })
    }

    /// [`SphereBlock::meet`], where the ray enters and where it leaves.
    #[inline(always)]
    pub fn meet_twice(&self, rays: &Rays) -> Option<[Candidates; 2]> {
        rays.meet_spheres_twice(self.center, self.radius_squared)
    }
}
