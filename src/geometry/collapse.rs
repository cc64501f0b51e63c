//! From the binary tree to one with eight children a node and blocks of eight primitives.
//!
//! Which nodes of the binary tree survive is the optimum under the surface area heuristic, by the
//! dynamic program of Ylitie, Karras and Laine 2017, "Efficient Incoherent Ray Traversal on GPUs
//! Through Compressed Wide BVHs", section 3: `cost[i]` is the least cost of the subtree when its
//! parent has `i + 1` slots for it.

use obvhs::bvh2::{Bvh2, node::Bvh2Node};

use crate::math::LANES;
use crate::scene::baked::{Sphere, Triangle};

use super::block::{LEAF, Leaf, Node, SphereBlock, TriangleBlock};
use super::builder::build_binary;

/// Cost of testing and sorting the eight children of a node, relative to a block of triangles.
/// Of 1, 1.5 and 2.2 the fastest by a few per cent on 82k triangles; no difference on small scenes.
const NODE_COST: f32 = 1.5;
/// Cost of a block of triangles.
const TRIANGLE_BLOCK_COST: f32 = 1.0;
/// Cost of a block of spheres.
const SPHERE_BLOCK_COST: f32 = 1.0;
/// Most blocks of a leaf, both kinds together.
const LEAF_BLOCKS: u32 = 4;

/// The eight-wide tree.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tree {
    pub nodes: Vec<Node>,
    pub leaves: Vec<Leaf>,
    pub triangle_blocks: Vec<TriangleBlock>,
    pub sphere_blocks: Vec<SphereBlock>,
    /// Where every ray starts: a node, or a leaf with [`LEAF`] set.
    pub root: u32,
    /// Nodes on the longest way from the root to a leaf.
    pub depth: u32,
}

/// The plan for one node of the binary tree.
#[derive(Clone, Copy, Default)]
struct Plan {
    triangles: u32,
    spheres: u32,
    /// Least cost given 1 to 7 slots, times area.
    cost: [f32; LANES - 1],
    /// Given 2 to 8 slots: how many the left child gets, or 0 to make do with one slot less.
    left: [u8; LANES - 1],
    is_leaf: bool,
}

struct Collapse<'a> {
    binary: &'a Bvh2,
    plans: Vec<Plan>,
    triangles: &'a [Triangle],
    spheres: &'a [Sphere],
    tree: Tree,
}

impl Tree {
    /// Builds the tree; without primitives it is an empty leaf.
    pub fn build(triangles: &[Triangle], spheres: &[Sphere]) -> Self {
        let empty = Tree {
            nodes: Vec::new(),
            leaves: Vec::new(),
            triangle_blocks: Vec::new(),
            sphere_blocks: Vec::new(),
            root: LEAF,
            depth: 0,
        };
        let binary = if triangles.len() <= LANES && spheres.len() <= LANES {
            Bvh2::default()
        } else {
            build_binary(triangles, spheres)
        };
        let plans = Vec::new();
        let mut collapse = Collapse { binary: &binary, plans, triangles, spheres, tree: empty };
        if binary.nodes.is_empty() {
            let all = (0..(triangles.len() + spheres.len()) as u32).collect();
            collapse.push_leaf(all);
        } else {
            collapse.plan();
            collapse.emit();
        }
        collapse.tree
    }
}

fn children(node: &Bvh2Node) -> [usize; 2] {
    [node.first_index as usize, node.first_index as usize + 1]
}

impl Collapse<'_> {
    /// Makes the plans, children first.
    fn plan(&mut self) {
        let nodes = &self.binary.nodes;
        let mut order = Vec::with_capacity(nodes.len());
        let mut stack = vec![0];
        while let Some(index) = stack.pop() {
            order.push(index);
            if !nodes[index].is_leaf() {
                stack.extend(children(&nodes[index]));
            }
        }
        self.plans = vec![Plan::default(); nodes.len()];
        for &index in order.iter().rev() {
            self.plans[index] = if nodes[index].is_leaf() {
                self.plan_primitives(&nodes[index])
            } else {
                self.plan_inner(&nodes[index])
            };
        }
    }

    fn plan_primitives(&self, node: &Bvh2Node) -> Plan {
        let mut plan = Plan { is_leaf: true, ..Plan::default() };
        for primitive in self.primitives(node) {
            let is_triangle = (primitive as usize) < self.triangles.len();
            plan.triangles += u32::from(is_triangle);
            plan.spheres += u32::from(!is_triangle);
        }
        plan.cost = [leaf_cost(&plan) * node.aabb().half_area(); LANES - 1];
        plan
    }

    fn plan_inner(&self, node: &Bvh2Node) -> Plan {
        let [left, right] = children(node).map(|child| &self.plans[child]);
        let mut plan = Plan {
            triangles: left.triangles + right.triangles,
            spheres: left.spheres + right.spheres,
            ..Plan::default()
        };
        // The cheapest way to divide `slots` among the two children.
        let divide = |slots: usize| {
            let cost = |share: usize| left.cost[share - 1] + right.cost[slots - share - 1];
            let shares = (1..slots).map(|share| (share, cost(share)));
            let cheaper = |a: (usize, f32), b: (usize, f32)| if b.1 < a.1 { b } else { a };
            shares.fold((0, f32::INFINITY), cheaper)
        };
        let area = node.aabb().half_area();
        let (share, cost) = divide(LANES);
        let as_node = cost + area * NODE_COST;
        let as_leaf = area * leaf_cost(&plan);
        plan.left[LANES - 2] = share as u8;
        plan.is_leaf = as_leaf <= as_node;
        plan.cost[0] = as_leaf.min(as_node);
        for slots in 2..LANES {
            let (share, cost) = divide(slots);
            let divided = cost < plan.cost[slots - 2];
            plan.left[slots - 2] = if divided { share as u8 } else { 0 };
            plan.cost[slots - 1] = if divided { cost } else { plan.cost[slots - 2] };
        }
        plan
    }

    /// The primitives directly in a leaf of the binary tree.
    fn primitives(&self, node: &Bvh2Node) -> impl Iterator<Item = u32> + '_ {
        let first = node.first_index as usize;
        let indices = &self.binary.primitive_indices[first..first + node.prim_count as usize];
        indices.iter().copied()
    }

    /// Carries out the plan, depth first.
    fn emit(&mut self) {
        if self.plans[0].is_leaf {
            self.push_leaf(self.primitives_below(0));
            return;
        }
        self.tree.root = 0;
        self.tree.nodes.push(Node::vacant());
        let mut work = vec![(0, 0, 1)];
        while let Some((index, row, depth)) = work.pop() {
            self.tree.depth = self.tree.depth.max(depth);
            let mut node = Node::vacant();
            for (lane, child) in self.chosen_children(index).into_iter().enumerate() {
                let bounds = self.binary.nodes[child].aabb();
                for axis in 0..3 {
                    node.bounds[axis][0].as_mut_array()[lane] = bounds.min[axis];
                    node.bounds[axis][1].as_mut_array()[lane] = bounds.max[axis];
                }
                node.children[lane] = if self.plans[child].is_leaf {
                    self.push_leaf(self.primitives_below(child))
                } else {
                    let row = self.tree.nodes.len();
                    self.tree.nodes.push(Node::vacant());
                    work.push((child, row, depth + 1));
                    row as u32
                };
            }
            self.tree.nodes[row] = node;
        }
    }

    /// The nodes of the binary tree that become the children of the wide node at `index`.
    fn chosen_children(&self, index: usize) -> Vec<usize> {
        let mut chosen = Vec::with_capacity(LANES);
        let mut pending = vec![(index, LANES)];
        while let Some((index, slots)) = pending.pop() {
            let mut slots = slots;
            while slots > 1 && self.plans[index].left[slots - 2] == 0 {
                slots -= 1;
            }
            if slots == 1 {
                chosen.push(index);
            } else {
                let share = self.plans[index].left[slots - 2] as usize;
                let [left, right] = children(&self.binary.nodes[index]);
                pending.push((right, slots - share));
                pending.push((left, share));
            }
        }
        chosen
    }

    /// All primitives in a subtree of the binary tree.
    fn primitives_below(&self, index: usize) -> Vec<u32> {
        let mut primitives = Vec::new();
        let mut stack = vec![index];
        while let Some(index) = stack.pop() {
            let node = &self.binary.nodes[index];
            if node.is_leaf() {
                primitives.extend(self.primitives(node));
            } else {
                stack.extend(children(node));
            }
        }
        primitives
    }

    /// Appends a leaf and returns the reference to it.
    fn push_leaf(&mut self, mut primitives: Vec<u32>) -> u32 {
        primitives.sort_unstable();
        let triangle_count = self.triangles.len() as u32;
        let middle = primitives.partition_point(|&primitive| primitive < triangle_count);
        let (of_triangles, of_spheres) = primitives.split_at(middle);
        let first_triangle = self.tree.triangle_blocks.len() as u32;
        let first_sphere = self.tree.sphere_blocks.len() as u32;
        for eight in of_triangles.chunks(LANES) {
            self.tree.triangle_blocks.push(TriangleBlock::new(eight, self.triangles));
        }
        for eight in of_spheres.chunks(LANES) {
            let block = SphereBlock::new(eight, self.spheres, triangle_count);
            self.tree.sphere_blocks.push(block);
        }
        self.tree.leaves.push(Leaf {
            triangles: [first_triangle, self.tree.triangle_blocks.len() as u32],
            spheres: [first_sphere, self.tree.sphere_blocks.len() as u32],
        });
        LEAF | (self.tree.leaves.len() as u32 - 1)
    }
}

/// Cost of all primitives of a subtree as one leaf, infinite if they are too many.
fn leaf_cost(plan: &Plan) -> f32 {
    let triangle_blocks = plan.triangles.div_ceil(LANES as u32);
    let sphere_blocks = plan.spheres.div_ceil(LANES as u32);
    if triangle_blocks + sphere_blocks > LEAF_BLOCKS {
        return f32::INFINITY;
    }
    triangle_blocks as f32 * TRIANGLE_BLOCK_COST + sphere_blocks as f32 * SPHERE_BLOCK_COST
}
