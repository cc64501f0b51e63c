//! All primitives of a scene, ready to be traced.

use std::cell::RefCell;

use glam::Vec3;

use crate::math::Vector;
use crate::scene::baked::{Shapes, Sphere, Triangle};
use crate::scene::instanced::Instanced;

use super::next::next_hit;
use super::rays::Hit;
use super::tree::Tree;
use super::walk::{TraceScratch, walk};

/// Scenes of at most so many primitives are traced eight rays at a time through all of them.
pub const SHORT_SCENE: usize = 48;

/// All primitives of a scene, ready to be traced.
#[derive(Clone, Debug, PartialEq)]
pub struct Accelerator {
    pub(super) tree: Tree,
    pub(super) short: Option<ShortScene>,
    triangle_count: usize,
    sphere_count: usize,
}

/// The primitives of a short scene in order.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ShortScene {
    /// Corners of triangles, each once.
    pub corners: Vec<[f32; 3]>,
    /// Rows in `corners`.
    pub triangles: Vec<[usize; 3]>,
    /// Centers and squared radii.
    pub spheres: Vec<([f32; 3], f32)>,
}

thread_local! {
    /// What rays that are traced one by one need: to make it anew for each takes longer than to
    /// trace it.
    static SCRATCH: RefCell<TraceScratch> = RefCell::default();
}

impl ShortScene {
    fn new(triangles: &[Triangle], spheres: &[Sphere]) -> Self {
        let mut corners: Vec<[f32; 3]> = Vec::new();
        let mut row_of = |corner: Vec3| {
            let corner = corner.to_array();
            let known = corners.iter().position(|known| *known == corner);
            known.unwrap_or_else(|| {
                corners.push(corner);
                corners.len() - 1
            })
        };
        let triangles = triangles.iter().map(|triangle| triangle.corners.map(&mut row_of));
        let triangles = triangles.collect();
        let of_sphere = |s: &Sphere| (s.center.to_array(), s.radius * s.radius);
        Self { corners, triangles, spheres: spheres.iter().map(of_sphere).collect() }
    }
}

/// What an accelerator is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Statistics {
    /// Triangles of the scene, without those of instances.
    pub triangles: usize,
    /// Spheres of the scene.
    pub spheres: usize,
    /// Meshes that are instanced.
    pub objects: usize,
    /// Their instances.
    pub instances: usize,
    /// Nodes with up to eight children; like the next three, without those of objects.
    pub nodes: usize,
    /// Blocks of up to eight triangles.
    pub triangle_blocks: usize,
    /// Blocks of up to eight spheres.
    pub sphere_blocks: usize,
    /// Nodes on the longest way to a leaf.
    pub depth: usize,
    /// Memory in bytes, with that of objects.
    pub bytes: usize,
}

impl Accelerator {
    /// Builds the tree, with all threads; the same input gives the same tree, bit for bit.
    pub fn build(triangles: &[Triangle], spheres: &[Sphere]) -> Self {
        Self::with_instances(triangles, spheres, &Instanced::default())
    }

    /// The tree over all primitives of a scene.
    pub fn of_shapes(shapes: &Shapes) -> Self {
        Self::with_instances(&shapes.triangles, &shapes.spheres, &shapes.instanced)
    }

    /// [`Accelerator::build`] for a scene that holds instances too. Their primitives have numbers
    /// behind those of the triangles and spheres.
    pub fn with_instances(
        triangles: &[Triangle],
        spheres: &[Sphere],
        instanced: &Instanced,
    ) -> Self {
        let is_short = triangles.len() + spheres.len() <= SHORT_SCENE;
        let is_short = is_short && instanced.instances().is_empty();
        Self {
            tree: Tree::build(triangles, spheres, instanced),
            short: is_short.then(|| ShortScene::new(triangles, spheres)),
            triangle_count: triangles.len(),
            sphere_count: spheres.len(),
        }
    }

    /// The nearest hit with `0 < t < t_max`; of several at exactly the same distance, that of the
    /// smallest primitive. `direction` may have any length but zero.
    pub fn closest(&self, origin: Vec3, direction: Vec3, t_max: f32) -> Hit {
        let mut nearest = Hit::MISS;
        self.trace_one::<false>(origin, direction, t_max, |hit| nearest = hit);
        nearest
    }

    /// The nearest hit of a ray beyond another of the same ray; of several at one distance, the
    /// next primitive.
    pub fn next(&self, origin: Vec3, direction: Vec3, hit: Hit) -> Hit {
        let rays = [origin, direction];
        SCRATCH.with_borrow_mut(|scratch| next_hit(&self.tree.view(), rays, hit, scratch))
    }

    /// Whether anything is hit with `0 < t < t_max`.
    pub fn occluded(&self, origin: Vec3, direction: Vec3, t_max: f32) -> bool {
        let mut is_hit = false;
        self.trace_one::<true>(origin, direction, t_max, |_| is_hit = true);
        is_hit
    }

    fn trace_one<const ANY: bool>(
        &self,
        origin: Vec3,
        direction: Vec3,
        t_max: f32,
        mut better: impl FnMut(Hit),
    ) {
        let load = |_| (Vector::splat(origin), Vector::splat(direction));
        let better = |_, hit| {
            better(hit);
            true
        };
        SCRATCH.with_borrow_mut(|scratch| {
            walk::<1, ANY>(&self.tree, 0..1, load, |_| t_max, scratch, better);
        });
    }

    /// Counts and memory.
    pub fn statistics(&self) -> Statistics {
        let tree = &self.tree;
        Statistics {
            triangles: self.triangle_count,
            spheres: self.sphere_count,
            objects: tree.objects.len(),
            instances: tree.instances.len(),
            nodes: tree.nodes.len(),
            triangle_blocks: tree.triangle_blocks.len(),
            sphere_blocks: tree.sphere_blocks.len(),
            depth: tree.depth as usize,
            bytes: tree.bytes(),
        }
    }
}
