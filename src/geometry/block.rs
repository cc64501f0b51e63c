//! What the eight-wide tree is made of.

use crate::math::{F32s, LANES, U32s, Vector};
use crate::scene::baked::{NONE, Sphere, Triangle};

use super::kernel::{Candidates, Rays};

/// Marks a child of a node, or the root, as a row of `leaves` instead of `nodes`.
pub(super) const LEAF: u32 = 1 << 31;

/// Up to eight children. Vacant ones have bounds that no ray enters.
#[derive(Clone, Debug, PartialEq)]
#[repr(align(64))]
pub(super) struct Node {
    /// Per axis, the lower and the upper bounds of the children.
    pub bounds: [[F32s; 2]; 3],
    /// A row of the nodes, or of the leaves with [`LEAF`] set.
    pub children: [u32; LANES],
}

impl Node {
    /// A node without children.
    pub fn vacant() -> Self {
        let none = [F32s::splat(f32::INFINITY), F32s::splat(f32::NEG_INFINITY)];
        Self { bounds: [none; 3], children: [NONE; LANES] }
    }
}

/// The blocks of a leaf: rows `first..end` of either table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Leaf {
    pub triangles: [u32; 2],
    pub spheres: [u32; 2],
}

/// Up to eight triangles. Vacant lanes have no area, so nothing hits them.
#[derive(Clone, Debug, PartialEq)]
#[repr(align(64))]
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

    /// One ray against the block.
    #[inline(always)]
    pub fn meet(&self, rays: &Rays, [x, y, z]: [usize; 3]) -> Candidates {
        let corners = &self.corners;
        rays.meet_triangles([
            Vector::new(corners[0][x], corners[0][y], corners[0][z]),
            Vector::new(corners[1][x], corners[1][y], corners[1][z]),
            Vector::new(corners[2][x], corners[2][y], corners[2][z]),
        ])
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

    /// One ray against the block.
    #[inline(always)]
    pub fn meet(&self, rays: &Rays) -> Candidates {
        rays.meet_spheres(self.center, self.radius_squared)
    }
}
