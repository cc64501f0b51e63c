//! From the binary tree to one with eight children a node and blocks of eight primitives.
//!
//! Which nodes of the binary tree survive is the optimum under the surface area heuristic, by the
//! dynamic program of Ylitie, Karras and Laine 2017, "Efficient Incoherent Ray Traversal on GPUs
//! Through Compressed Wide BVHs", section 3: `cost[i]` is the least cost of the subtree when its
//! parent has `i + 1` slots for it.
//!
//! Subtrees of a few thousand primitives are collapsed apart, all threads at a time; only that
//! their roots are nodes is settled beforehand, which the optimum hardly ever disagrees with.

use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use rayon::prelude::*;

use crate::math::LANES;
use crate::scene::baked::{NONE, Sphere, Triangle};
use crate::scene::instanced::Instance;

use super::block::{LEAF_BLOCKS, Node, Reference, Rows, SphereBlock, TriangleBlock};
use super::builder::parts_of;
use super::table::Table;
use super::tree::Tree;

/// Cost of testing and sorting the eight children of a node, relative to a block.
/// Of 1, 1.5 and 2.2 the fastest by a few per cent on 82k triangles; no difference on small scenes.
const NODE_COST: f32 = 1.5;
/// Most primitives of a subtree that is collapsed apart.
const PART_PRIMITIVES: u32 = 4096;

/// An eight-wide tree that grows.
#[derive(Default)]
pub(super) struct Growth {
    pub nodes: Vec<Node>,
    pub triangle_blocks: Vec<TriangleBlock>,
    pub sphere_blocks: Vec<SphereBlock>,
    /// Where every ray starts.
    pub root: Reference,
    /// Nodes on the longest way from the root to a leaf, at most.
    pub depth: u32,
}

/// The plan for one node of the binary tree. Plans lie depth first, left before right.
#[derive(Clone, Copy, Default)]
struct Plan {
    /// The node of the binary tree.
    index: u32,
    /// Plans of the subtree, this one included.
    size: u32,
    /// The part that the subtree is, or [`NONE`].
    part: u32,
    triangles: u32,
    spheres: u32,
    instances: u32,
    /// Least cost given 1 to 7 slots, times area.
    cost: [f32; LANES - 1],
    /// Given 2 to 8 slots: how many the left child gets, or 0 to make do with one slot less.
    left: [u8; LANES - 1],
    is_leaf: bool,
}

/// What a tree is built over. Shapes are counted in this order.
#[derive(Clone, Copy)]
pub(super) struct Shapes<'a> {
    pub triangles: &'a [Triangle],
    pub spheres: &'a [Sphere],
    pub instances: &'a [Instance],
}

/// What is collapsed.
struct Source<'a> {
    binary: &'a Bvh2,
    shapes: Shapes<'a>,
}

/// A subtree of the binary tree on its way into a tree of its own.
struct Collapse<'a> {
    source: &'a Source<'a>,
    /// Subtrees that are collapsed already, depth first.
    parts: &'a [Part],
    plans: Vec<Plan>,
    tree: Growth,
}

/// A subtree that is collapsed.
struct Part {
    /// Its root in the binary tree.
    index: u32,
    cost: f32,
    tree: Growth,
}

impl Growth {
    /// A leaf and nothing else.
    pub fn leaf(primitives: &[u32], shapes: Shapes) -> Self {
        let mut tree = Self::default();
        tree.root = tree.push_leaf(primitives, &shapes);
        tree
    }

    /// Appends a leaf of `primitives`, all of one kind; without any it is a block of no spheres.
    fn push_leaf(&mut self, primitives: &[u32], shapes: &Shapes) -> Reference {
        let Shapes { triangles, spheres, .. } = *shapes;
        let triangle_count = triangles.len() as u32;
        let count = primitives.len().div_ceil(LANES).max(1) as u32;
        if primitives.first().is_some_and(|first| *first < triangle_count) {
            let first = self.triangle_blocks.len();
            let eights = primitives.chunks(LANES);
            let blocks = eights.map(|eight| TriangleBlock::new(eight, triangles));
            self.triangle_blocks.extend(blocks);
            return Reference::leaf(first, count, false);
        }
        let before_instances = triangles.len() + spheres.len();
        if let Some(row) =
            primitives.first().and_then(|it| (*it as usize).checked_sub(before_instances))
        {
            return Reference::instance(row);
        }
        let first = self.sphere_blocks.len();
        for block in 0..count as usize {
            let rows = block * LANES..primitives.len().min((block + 1) * LANES);
            let block = SphereBlock::new(&primitives[rows], spheres, triangle_count);
            self.sphere_blocks.push(block);
        }
        Reference::leaf(first, count, true)
    }
}

/// Collapses the parts of a binary tree over `shapes`, then what is above them, and puts all
/// together.
pub(super) fn collapse(binary: &Bvh2, shapes: Shapes) -> Tree {
    let source = &Source { binary, shapes };
    let parts: Vec<Part> = parts_of(source.binary, PART_PRIMITIVES)
        .into_par_iter()
        .map(|index| {
            let mut part = Collapse::new(source, &[], index);
            part.emit();
            Part { index, cost: part.plans[0].cost[0], tree: part.tree }
        })
        .collect();
    if let [Part { index: 0, .. }] = parts.as_slice() {
        return parts.into_iter().map(|part| part.tree).next().unwrap_or_default().into();
    }
    let mut top = Collapse::new(source, &parts, 0);
    top.emit();
    join(top.tree, &parts)
}

/// The tables of all parts, one after the other, and behind them the nodes of the top.
fn join(top: Growth, parts: &[Part]) -> Tree {
    let tables = || parts.iter().map(|part| &part.tree);
    let count = |of: fn(&Growth) -> usize| tables().map(of).sum::<usize>();
    let node_count = count(|tree| tree.nodes.len()) + top.nodes.len();
    let mut nodes = Table::zeroed(node_count);
    let mut blocks = Table::zeroed(count(|tree| tree.triangle_blocks.len()));
    let (mut nodes_left, mut blocks_left) = (&mut *nodes, &mut *blocks);
    let mut copies = Vec::with_capacity(parts.len());
    for (tree, base) in tables().zip(bases(parts)) {
        let to_nodes = nodes_left.split_off_mut(..tree.nodes.len()).unwrap_or_default();
        let to_blocks = blocks_left.split_off_mut(..tree.triangle_blocks.len()).unwrap_or_default();
        copies.push((tree, base, to_nodes, to_blocks));
    }
    nodes_left.copy_from_slice(&top.nodes);
    copies.into_par_iter().for_each(|(tree, base, to_nodes, to_blocks)| {
        to_blocks.copy_from_slice(&tree.triangle_blocks);
        for (to, node) in to_nodes.iter_mut().zip(&tree.nodes) {
            *to = *node;
            to.children = node.children.map(|child| child.moved(base));
        }
    });
    Tree {
        nodes,
        triangle_blocks: blocks,
        sphere_blocks: tables().flat_map(|tree| tree.sphere_blocks.iter().cloned()).collect(),
        depth: top.depth + tables().map(|tree| tree.depth).max().unwrap_or(0),
        ..Tree::from(top)
    }
}

/// Where the tables of each part begin in those of all.
fn bases(parts: &[Part]) -> impl Iterator<Item = Rows> {
    parts.iter().scan(Rows::default(), |next, part| {
        let base = *next;
        next.nodes += part.tree.nodes.len();
        next.triangle_blocks += part.tree.triangle_blocks.len();
        next.sphere_blocks += part.tree.sphere_blocks.len();
        Some(base)
    })
}

impl<'a> Collapse<'a> {
    /// The plans for the subtree at `root`, down to `parts`, which lie in it depth first.
    fn new(source: &'a Source<'a>, parts: &'a [Part], root: u32) -> Self {
        let mut collapse = Self { source, parts, plans: Vec::new(), tree: Growth::default() };
        collapse.lay_out(root);
        for position in (0..collapse.plans.len()).rev() {
            let plan = &collapse.plans[position];
            if plan.part == NONE && !source.node(plan.index).is_leaf() {
                collapse.plans[position] = collapse.plan_inner(position);
            }
        }
        collapse
    }

    /// Lays out the plans and makes those that depend on no others.
    fn lay_out(&mut self, root: u32) {
        let mut parts = self.parts.iter().zip(0..).peekable();
        let mut stack = vec![root];
        while let Some(index) = stack.pop() {
            let node = self.source.node(index);
            let plan = Plan { index, size: 1, part: NONE, ..Plan::default() };
            self.plans.push(if let Some((part, row)) = parts.next_if(|it| it.0.index == index) {
                // More than a leaf can hold, whatever it is.
                let cost = [part.cost; LANES - 1];
                Plan { part: row, triangles: PART_PRIMITIVES, cost, ..plan }
            } else if node.is_leaf() {
                self.plan_primitives(plan)
            } else {
                stack.extend([node.first_index + 1, node.first_index]);
                plan
            });
        }
    }

    fn plan_primitives(&self, mut plan: Plan) -> Plan {
        let Shapes { triangles, spheres, .. } = self.source.shapes;
        for primitive in self.source.primitives(plan.index) {
            match *primitive as usize {
                it if it < triangles.len() => plan.triangles += 1,
                it if it < triangles.len() + spheres.len() => plan.spheres += 1,
                _ => plan.instances += 1,
            }
        }
        plan.is_leaf = true;
        plan.cost = [leaf_cost(&plan) * self.source.half_area(plan.index); LANES - 1];
        plan
    }

    fn plan_inner(&self, position: usize) -> Plan {
        let children = self.children(position);
        let [left, right] = children.map(|child| &self.plans[child]);
        let mut plan = Plan {
            size: 1 + left.size + right.size,
            triangles: left.triangles.saturating_add(right.triangles),
            spheres: left.spheres.saturating_add(right.spheres),
            instances: left.instances.saturating_add(right.instances),
            ..self.plans[position]
        };
        // The cheapest way to divide `slots` among the two children.
        let divide = |slots: usize| {
            let cost = |share: usize| left.cost[share - 1] + right.cost[slots - share - 1];
            let shares = (1..slots).map(|share| (share, cost(share)));
            let cheaper = |a: (usize, f32), b: (usize, f32)| if b.1 < a.1 { b } else { a };
            shares.fold((0, f32::INFINITY), cheaper)
        };
        let area = self.source.half_area(plan.index);
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

    /// Positions of the two children's plans.
    fn children(&self, position: usize) -> [usize; 2] {
        let left = position + 1;
        [left, left + self.plans[left].size as usize]
    }

    /// Carries out the plan, depth first.
    fn emit(&mut self) {
        let bases: Vec<Rows> = bases(self.parts).collect();
        let first_row = self.parts.iter().map(|part| part.tree.nodes.len()).sum();
        let mut work = Vec::new();
        self.tree.root = self.emit_child(0, 0, first_row, &bases, &mut work);
        while let Some((position, row, depth)) = work.pop() {
            self.tree.depth = self.tree.depth.max(depth);
            let mut node = Node::vacant();
            for (lane, child) in self.chosen_children(position).enumerate() {
                let bounds = self.source.node(self.plans[child].index).aabb();
                for axis in 0..3 {
                    node.bounds[axis][0].as_mut_array()[lane] = bounds.min[axis];
                    node.bounds[axis][1].as_mut_array()[lane] = bounds.max[axis];
                }
                node.children[lane] = self.emit_child(child, depth, first_row, &bases, &mut work);
            }
            self.tree.nodes[row] = node;
        }
    }

    /// A child as a leaf, as the root of a part, or as a node that is left as `work`: the position
    /// of its plan, its row here and its depth. Rows of this tree begin at `first_row`.
    fn emit_child(
        &mut self,
        position: usize,
        depth: u32,
        first_row: usize,
        bases: &[Rows],
        work: &mut Vec<(usize, usize, u32)>,
    ) -> Reference {
        let plan = &self.plans[position];
        if plan.part != NONE {
            let part = plan.part as usize;
            return self.parts[part].tree.root.moved(bases[part]);
        }
        if plan.is_leaf {
            let below = &self.plans[position..][..plan.size as usize];
            let mut primitives: Vec<u32> = below
                .iter()
                .filter(|plan| self.source.node(plan.index).is_leaf())
                .flat_map(|plan| self.source.primitives(plan.index))
                .copied()
                .collect();
            primitives.sort_unstable();
            return self.tree.push_leaf(&primitives, &self.source.shapes);
        }
        let row = self.tree.nodes.len();
        self.tree.nodes.push(Node::vacant());
        work.push((position, row, depth + 1));
        Reference::node(first_row + row)
    }

    /// Plans of the children of the wide node whose plan is at `position`.
    fn chosen_children(&self, position: usize) -> impl Iterator<Item = usize> + use<> {
        let (mut chosen, mut count) = ([0; LANES], 0);
        let mut pending = [(0, 0); LANES];
        pending[0] = (position, LANES);
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let (position, mut slots) = pending[top];
            while slots > 1 && self.plans[position].left[slots - 2] == 0 {
                slots -= 1;
            }
            if slots == 1 {
                chosen[count] = position;
                count += 1;
                continue;
            }
            let share = self.plans[position].left[slots - 2] as usize;
            let [left, right] = self.children(position);
            pending[top] = (right, slots - share);
            pending[top + 1] = (left, share);
            top += 2;
        }
        chosen.into_iter().take(count)
    }
}

impl Source<'_> {
    fn node(&self, index: u32) -> &Bvh2Node {
        &self.binary.nodes[index as usize]
    }

    fn half_area(&self, index: u32) -> f32 {
        self.node(index).aabb().half_area()
    }

    /// The primitives directly in a leaf of the binary tree.
    fn primitives(&self, index: u32) -> &[u32] {
        let node = self.node(index);
        let first = node.first_index as usize;
        &self.binary.primitive_indices[first..first + node.prim_count as usize]
    }
}

/// Cost of all primitives of a subtree as one leaf, infinite if they are too many or of two kinds.
fn leaf_cost(plan: &Plan) -> f32 {
    match [plan.triangles, plan.spheres, plan.instances] {
        [count, 0, 0] | [0, count, 0] if count <= LEAF_BLOCKS * LANES as u32 => {
            count.div_ceil(LANES as u32) as f32
        }
        // Whatever it is: no plan can do without.
        [0, 0, 1] => 1.0,
        _ => f32::INFINITY,
    }
}
