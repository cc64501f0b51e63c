//! The eight-wide tree.

use bytemuck::must_cast_slice;
use prefetch_index::prefetch_index;

use crate::math::LANES;
use crate::scene::baked::{Sphere, Triangle};
use crate::scene::instanced::{Instance, Instanced};

use super::block::{Node, Reference, SphereBlock, TriangleBlock};
use super::builder::{build_binary, largest_coordinate};
use super::collapse::{Growth, Shapes, collapse};
use super::table::Table;

/// Trees beyond this are large.
const LARGE_BYTES: usize = 64 << 20;

/// The eight-wide tree.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tree {
    pub nodes: Table<Node>,
    pub triangle_blocks: Table<TriangleBlock>,
    pub sphere_blocks: Vec<SphereBlock>,
    /// Trees of their own for what is instanced.
    pub objects: Vec<Tree>,
    /// Where these stand.
    pub instances: Vec<Instance>,
    /// Where every ray starts.
    pub root: Reference,
    /// Nodes on the longest way from the root to a leaf, at most.
    pub depth: u32,
    /// Largest coordinate of any shape.
    pub reach: f32,
}

/// The tree as rays see it.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub nodes: &'a [Node],
    pub triangle_blocks: &'a [TriangleBlock],
    pub sphere_blocks: &'a [SphereBlock],
    pub objects: &'a [Tree],
    pub instances: &'a [Instance],
    pub root: Reference,
    pub depth: u32,
    pub reach: f32,
}

impl Tree {
    /// Builds the tree, with all threads; the same input gives the same tree, bit for bit.
    pub fn build(triangles: &[Triangle], spheres: &[Sphere], instanced: &Instanced) -> Self {
        let instances = instanced.instances();
        let shapes = Shapes { triangles, spheres, instances };
        let none = Instanced::default();
        let objects = instanced.objects().iter();
        Self {
            reach: largest_coordinate(&shapes),
            objects: objects.map(|object| Self::build(&object.triangles, &[], &none)).collect(),
            instances: instances.to_vec(),
            ..Self::over(shapes)
        }
    }

    fn over(shapes: Shapes) -> Self {
        let counts = [shapes.triangles.len(), shapes.spheres.len(), shapes.instances.len()];
        let count = counts.iter().sum();
        let is_of_one_kind = counts.contains(&count);
        if count > 1 && !(is_of_one_kind && shapes.instances.is_empty() && count <= LANES) {
            return collapse(&build_binary(&shapes), shapes);
        }
        let all: Vec<u32> = (0..count as u32).collect();
        Growth::leaf(&all, shapes).into()
    }

    /// Whether the tree is much larger than the caches, so that most steps wait for memory.
    pub fn is_large(&self) -> bool {
        self.bytes() > LARGE_BYTES
    }

    /// Memory in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.nodes)
            + size_of_val(&*self.triangle_blocks)
            + size_of_val(self.sphere_blocks.as_slice())
            + size_of_val(self.instances.as_slice())
            + self.objects.iter().map(Self::bytes).sum::<usize>()
    }

    /// The tree as rays see it.
    #[inline(always)]
    pub fn view(&self) -> View<'_> {
        View {
            nodes: &self.nodes,
            triangle_blocks: &self.triangle_blocks,
            sphere_blocks: &self.sphere_blocks,
            objects: &self.objects,
            instances: &self.instances,
            root: self.root,
            depth: self.depth,
            reach: self.reach,
        }
    }
}

impl From<Growth> for Tree {
    fn from(grown: Growth) -> Self {
        Self {
            nodes: grown.nodes.into(),
            triangle_blocks: grown.triangle_blocks.into(),
            sphere_blocks: grown.sphere_blocks,
            objects: Vec::new(),
            instances: Vec::new(),
            root: grown.root,
            depth: grown.depth,
            reach: 0.0,
        }
    }
}

impl View<'_> {
    /// Asks for the memory of what is visited next.
    #[inline(always)]
    pub fn prefetch(&self, next: Reference) {
        if !next.is_leaf() {
            let lines: &[[u8; 64]] = must_cast_slice(self.nodes);
            (0..4).for_each(|line| prefetch_index(lines, next.row() * 4 + line));
        } else if next.is_of_triangles() {
            let lines: &[[u8; 64]] = must_cast_slice(self.triangle_blocks);
            (0..5).for_each(|line| prefetch_index(lines, next.blocks().start * 5 + line));
        }
    }
}
