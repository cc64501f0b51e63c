//! Rays on their way through the tree.
//!
//! What the tests need to know of a ray is computed for eight rays at a time and read from there
//! in every step. Each step, into a node or a leaf, starts with memory that may be far away; so in
//! large trees several rays are on their way at once: a step ends with asking for what the ray
//! visits next, and the others take theirs before it goes on.

use std::array;
use std::ops::Range;

use glam::Vec3A;

use crate::math::{F32s, LANES, Vector};
use crate::scene::baked::NONE;

use super::block::{Node, Reference};
use super::kernel::{Candidates, renamed};
use super::packet::walk_alike;
use super::prepared::{BATCH, Prepared};
use super::rays::Hit;
use super::tree::{Tree, View};

/// The place of a ray among those prepared and how far it has come.
#[derive(Clone, Copy)]
pub(super) struct Walk {
    pub ray: usize,
    /// Where the search ends: at the nearest hit so far.
    pub t_max: f32,
    nearest: u32,
    /// What is added to the primitives of the tree.
    first_primitive: u32,
    /// What is visited next.
    pub next: Reference,
    /// First and first free entry of this ray's stack.
    base: usize,
    top: usize,
}

/// What rays under way need beside the tree. It can be used again and again, for any tree, so that
/// tracing allocates nothing.
#[derive(Clone, Debug, Default)]
pub struct TraceScratch {
    pub(super) prepared: Prepared,
    pub(super) stacks: Stacks,
    /// Of a short scene, as eight rays see them.
    pub(super) corners: Vec<Vector<F32s>>,
}

/// What is still to be visited by the rays under way, nearest on top.
#[derive(Clone, Debug, Default)]
pub(super) struct Stacks {
    pub entries: Vec<(f32, Reference)>,
    /// Those of eight rays that go together.
    pub alike: Vec<(F32s, Reference)>,
    pub inside: Inside,
}

/// What a ray needs inside an instance; the one around it waits meanwhile.
#[derive(Clone, Debug, Default)]
pub(super) struct Inside(Option<Box<TraceScratch>>);

impl Inside {
    /// Made when it is first needed.
    pub fn scratch(&mut self) -> &mut TraceScratch {
        self.0.get_or_insert_default()
    }
}

impl Stacks {
    /// Makes room for the way of `rays` rays through `tree`; how much each has.
    pub fn make_room(&mut self, tree: &View, rays: usize) -> usize {
        // A node takes its own entry and leaves at most eight; a root alone takes one.
        let each = (tree.depth as usize * LANES).max(1);
        if self.alike.len() < each {
            self.alike.resize(each, (F32s::ZERO, Reference::NONE));
        }
        if self.entries.len() < each * rays {
            self.entries.resize(each * rays, (0.0, Reference::NONE));
        }
        each
    }
}

impl Walk {
    /// Whether anything is hit.
    #[inline(always)]
    pub fn has_hit(&self) -> bool {
        self.nearest != NONE
    }

    /// Goes on to the next node or leaf; false when there is none. With `ANY` the first hit is
    /// the last, and need not be the nearest.
    #[inline(always)]
    pub fn step<const ANY: bool>(
        &mut self,
        tree: &View,
        prepared: &Prepared,
        stack: &mut [(f32, Reference)],
        inside: &mut Inside,
        better: &mut impl FnMut(usize, Hit) -> bool,
    ) -> bool {
        let ray = self.ray & (BATCH - 1);
        if self.next.is_leaf() {
            self.meet_leaf::<ANY>(tree, prepared, inside, better);
            if ANY && self.has_hit() {
                return false;
            }
        } else {
            let node = &tree.nodes[self.next.row()];
            let (enter, is_in) = prepared.enter(ray, node, [0.0, self.t_max]);
            if is_in.any() {
                // The nearest child is next, without a detour over the stack.
                self.top = if ANY {
                    push(stack, self.top, node, is_in.to_bitmask()) - 1
                } else {
                    push_sorted(stack, self.top, enter, node, is_in) - 1
                };
                self.next = stack[self.top].1;
                return true;
            }
        }
        while self.top > self.base {
            self.top -= 1;
            let (enter, reference) = stack[self.top];
            if ANY || enter <= self.t_max {
                self.next = reference;
                return true;
            }
        }
        false
    }

    #[inline(always)]
    pub fn meet_leaf<const ANY: bool>(
        &mut self,
        tree: &View,
        prepared: &Prepared,
        inside: &mut Inside,
        better: &mut impl FnMut(usize, Hit) -> bool,
    ) {
        let ray = self.ray & (BATCH - 1);
        let rays = prepared.rays(ray);
        if !self.next.is_of_triangles() {
            if let Some(row) = self.next.as_instance() {
                *self = enter_instance::<ANY>(*self, (tree, row), prepared, inside, better);
                return;
            }
            for block in &tree.sphere_blocks[self.next.blocks()] {
                if let Some(found) = block.meet(&rays) {
                    self.offer(&found, block.primitives.as_array(), better);
                }
            }
            return;
        }
        let axes = renamed(prepared.main_axis[ray] as usize);
        for block in &tree.triangle_blocks[self.next.blocks()] {
            if let Some(found) = block.meet(&rays, axes) {
                self.offer(&found, block.primitives.as_array(), better);
            }
        }
    }

    /// Takes over what is nearer, or as near with a smaller primitive.
    #[inline(always)]
    fn offer(
        &mut self,
        found: &Candidates,
        primitives: &[u32; LANES],
        better: &mut impl FnMut(usize, Hit) -> bool,
    ) {
        let mut lanes = (found.mask & found.t.simd_le(F32s::splat(self.t_max))).to_bitmask();
        while lanes != 0 {
            let lane = (lanes.trailing_zeros() & 7) as usize;
            lanes &= lanes - 1;
            let t = found.t.as_array()[lane];
            let primitive = primitives[lane] + self.first_primitive;
            let is_first_of_equals = self.nearest != NONE && primitive < self.nearest;
            if t < self.t_max || t == self.t_max && is_first_of_equals {
                let (u, v) = (found.u.as_array()[lane], found.v.as_array()[lane]);
                if better(self.ray, Hit { t, u, v, primitive }) {
                    (self.t_max, self.nearest) = (t, primitive);
                }
            }
        }
    }
}

/// Takes a walk through the tree of an instance, in the space of its object; distances are the same
/// there, as the direction keeps its length in the world. The walk goes by value: one that
/// functions point to is not kept in registers, which made all rays 5 % slower.
#[inline(never)]
fn enter_instance<const ANY: bool>(
    outside: Walk,
    (tree, row): (&View, usize),
    prepared: &Prepared,
    inside: &mut Inside,
    better: &mut impl FnMut(usize, Hit) -> bool,
) -> Walk {
    let instance = &tree.instances[row];
    let object = &tree.objects[instance.object as usize].view();
    let ray = outside.ray & (BATCH - 1);
    let [origin, direction] = instance.ray_inside(prepared.world_ray(ray).map(Vec3A::from));
    let TraceScratch { prepared, stacks, .. } = inside.scratch();
    stacks.make_room(object, 1);
    let [origin, direction] = [origin, direction].map(Vector::splat);
    prepared.prepare(ray & !(LANES - 1), origin, direction, F32s::splat(object.reach));
    let first_primitive = instance.first_primitive;
    let mut walk = Walk { next: object.root, first_primitive, base: 0, top: 0, ..outside };
    let Stacks { entries, inside, .. } = stacks;
    while walk.step::<ANY>(object, prepared, entries, inside, better) {}
    Walk { t_max: walk.t_max, nearest: walk.nearest, ..outside }
}

/// Takes rays to their ends, up to `FLIGHT` of them at a time. `load` gives origins and directions
/// of the eight rays from a row on, `t_max` where a row's search ends; `better` is told of each
/// hit of a row that is nearer than all before, and says whether it counts.
#[inline(always)]
pub(super) fn walk<const FLIGHT: usize, const ANY: bool>(
    tree: &Tree,
    rows: Range<usize>,
    load: impl Fn(usize) -> (Vector<F32s>, Vector<F32s>),
    t_max: impl Fn(usize) -> f32,
    scratch: &mut TraceScratch,
    mut better: impl FnMut(usize, Hit) -> bool,
) {
    let TraceScratch { prepared, stacks, .. } = scratch;
    let tree = &tree.view();
    let room = stacks.make_room(tree, FLIGHT);
    // Slices by value: pointers behind a pointer would be read again in every step.
    let (entries, alike) = (stacks.entries.as_mut_slice(), stacks.alike.as_mut_slice());
    let inside = &mut stacks.inside;
    for first in rows.clone().step_by(BATCH) {
        let batch = first..rows.end.min(first + BATCH);
        for row in batch.clone().step_by(LANES) {
            let (origin, direction) = load(row);
            prepared.prepare(row - first, origin, direction, F32s::splat(tree.reach));
        }
        let start = |ray: usize| Walk {
            ray,
            t_max: t_max(first + ray),
            nearest: NONE,
            first_primitive: 0,
            next: tree.root,
            base: 0,
            top: 0,
        };
        let mut better = |ray: usize, hit: Hit| better(first + ray, hit);
        let (mut alone, mut count) = ([0; BATCH], 0);
        for ray in (0..batch.len()).step_by(LANES) {
            if ray + LANES <= batch.len() && prepared.are_alike(ray, tree.reach) {
                let walks = array::from_fn(|lane| start(ray + lane));
                walk_alike::<FLIGHT, ANY>(
                    tree,
                    prepared,
                    walks,
                    alike,
                    (entries, inside),
                    &mut better,
                );
                continue;
            }
            for ray in ray..batch.len().min(ray + LANES) {
                alone[count] = ray;
                count += 1;
            }
        }
        let mut walks = alone[..count].iter().map(|ray| start(*ray));
        if FLIGHT == 1 {
            for mut walk in walks {
                while walk.step::<ANY>(tree, prepared, entries, inside, &mut better) {}
            }
            continue;
        }
        let mut next = |base: usize| walks.next().map(|walk| Walk { base, top: base, ..walk });
        let mut flight = array::from_fn(|slot| next(slot * room));
        fly::<FLIGHT, ANY>(
            tree,
            prepared,
            (&mut flight, &mut next),
            (entries, inside),
            &mut better,
        );
    }
}

/// Takes rays to their ends, `FLIGHT` of them at a time: those in flight and all that `next` finds
/// for the part of the stack that one leaves.
#[inline(always)]
fn fly<const FLIGHT: usize, const ANY: bool>(
    tree: &View,
    prepared: &Prepared,
    (flight, next): (&mut [Option<Walk>; FLIGHT], &mut impl FnMut(usize) -> Option<Walk>),
    (stack, inside): (&mut [(f32, Reference)], &mut Inside),
    better: &mut impl FnMut(usize, Hit) -> bool,
) {
    let mut flying = flight.iter().flatten().count();
    while flying > 0 {
        for slot in &mut *flight {
            let Some(walk) = slot else { continue };
            if walk.step::<ANY>(tree, prepared, stack, inside, better) {
                tree.prefetch(walk.next);
            } else {
                *slot = next(walk.base);
                flying -= usize::from(slot.is_none());
            }
        }
    }
}

/// Pushes the children that are in, with the nearest on top; returns the new top.
#[inline(always)]
fn push_sorted(
    stack: &mut [(f32, Reference)],
    base: usize,
    enter: F32s,
    node: &Node,
    is_in: F32s,
) -> usize {
    let (mut lanes, mut top) = (is_in.to_bitmask(), base);
    while lanes != 0 {
        let lane = (lanes.trailing_zeros() & 7) as usize;
        lanes &= lanes - 1;
        let entry = (enter.as_array()[lane], node.children[lane]);
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

/// Pushes the children in `lanes` in any order; returns the new top.
#[inline(always)]
fn push(stack: &mut [(f32, Reference)], base: usize, node: &Node, lanes: u32) -> usize {
    let (mut lanes, mut top) = (lanes, base);
    while lanes != 0 {
        let lane = (lanes.trailing_zeros() & 7) as usize;
        lanes &= lanes - 1;
        stack[top].1 = node.children[lane];
        top += 1;
    }
    top
}
