//! What a ray meets beyond a hit: rays that go on straight are never restarted, so that whatever
//! lies close behind a surface, or in the same place, is met all the same.

use std::ops::Range;

use glam::{Vec3, Vec3A};

use crate::math::columns::Rows;
use crate::math::{F32s, LANES, U32s, Vector};

use super::accelerator::Accelerator;
use super::block::Reference;
use super::columns::next_in_short;
use super::kernel::{Candidates, Rays, renamed};
use super::rays::{Hit, HitColumns, RayColumns};
use super::tree::View;
use super::walk::TraceScratch;

/// Moves every hit in `rows` on to the next one of its ray with `t < t_max`, and to
/// [`Hit::MISS`] where there is none. Hits are in order of distance, and of primitive where that is
/// the same; `t_max` is one for each of the rows.
pub fn trace_next(
    hits: &mut HitColumns,
    scratch: &mut TraceScratch,
    rays: &RayColumns,
    t_max: &[f32],
    rows: Range<usize>,
    accelerator: &Accelerator,
) {
    if let Some(scene) = &accelerator.short {
        return next_in_short(hits, &mut scratch.corners, (rays, t_max), rows, scene);
    }
    let tree = &accelerator.tree.view();
    for row in rows {
        let ray = rays.get(row);
        let ray = [ray.origin, ray.direction].map(Vec3A::from);
        let mut search = Search::beyond(hits.get(row), t_max[row]);
        search.look(tree, ray, 0, scratch);
        hits.set(row, search.next);
    }
}

/// The hit of a ray beyond `last`, or [`Hit::MISS`].
pub(super) fn next_hit(tree: &View, ray: [Vec3; 2], last: Hit, scratch: &mut TraceScratch) -> Hit {
    let mut search = Search::beyond(last, f32::INFINITY);
    search.look(tree, ray.map(Vec3A::from), 0, scratch);
    search.next
}

/// The next hit so far.
struct Search {
    /// Distance and primitive of the hit from which on it is searched.
    after: (f32, u32),
    /// The nearest beyond that, and where the search ends.
    next: Hit,
    t_max: f32,
}

impl Search {
    fn beyond(last: Hit, t_max: f32) -> Self {
        Self { after: (last.t, last.primitive), next: Hit::MISS, t_max }
    }

    /// Looks through a tree whose primitives are numbered from `first_primitive` on; the ray is in
    /// the tree's space.
    fn look(
        &mut self,
        tree: &View,
        [origin, direction]: [Vec3A; 2],
        first_primitive: u32,
        TraceScratch { prepared, stacks, .. }: &mut TraceScratch,
    ) {
        stacks.make_room(tree, 1);
        let lanes = |v: Vec3A| Vector::splat(v.to_array());
        prepared.prepare(0, lanes(origin), lanes(direction), F32s::splat(tree.reach));
        let axes = renamed(prepared.main_axis[0] as usize);
        let rays = prepared.rays(0);
        let (mut top, mut next) = (0, tree.root);
        loop {
            if !next.is_leaf() {
                let node = &tree.nodes[next.row()];
                let (_, is_in) = prepared.enter(0, node, [self.after.0, self.t_max]);
                let mut lanes = is_in.to_bitmask();
                while lanes != 0 {
                    stacks.entries[top].1 = node.children[lanes.trailing_zeros() as usize & 7];
                    lanes &= lanes - 1;
                    top += 1;
                }
            } else if next.is_of_triangles() {
                for block in &tree.triangle_blocks[next.blocks()] {
                    if let Some(found) = block.meet(&rays, axes) {
                        self.offer(&found, block.primitives, first_primitive);
                    }
                }
            } else if let Some(row) = next.as_instance() {
                let instance = &tree.instances[row];
                let object = &tree.objects[instance.object as usize].view();
                let ray = instance.ray_inside([origin, direction]);
                self.look(object, ray, instance.first_primitive, stacks.inside.scratch());
            } else {
                self.meet_spheres(tree, next, &rays, first_primitive);
            }
            let Some(below) = top.checked_sub(1) else { return };
            top = below;
            next = stacks.entries[top].1;
        }
    }

    /// A sphere is met twice.
    fn meet_spheres(&mut self, tree: &View, leaf: Reference, rays: &Rays, first_primitive: u32) {
        for block in &tree.sphere_blocks[leaf.blocks()] {
            for found in block.meet_twice(rays).iter().flatten() {
                self.offer(found, block.primitives, first_primitive);
            }
        }
    }

    fn offer(&mut self, found: &Candidates, primitives: U32s, first_primitive: u32) {
        let mut lanes = found.mask.to_bitmask();
        while lanes != 0 {
            let lane = (lanes.trailing_zeros() & 7) as usize;
            lanes &= lanes - 1;
            debug_assert!(lane < LANES);
            let primitive = primitives.as_array()[lane] + first_primitive;
            let of = |values: F32s| values.as_array()[lane];
            let place = (of(found.t), primitive);
            let is_nearer = place < (self.next.t, self.next.primitive);
            if place > self.after && is_nearer && place.0 < self.t_max {
                let (u, v) = (of(found.u), of(found.v));
                self.next = Hit { t: place.0, u, v, primitive };
                self.t_max = self.t_max.min(place.0.next_up());
            }
        }
    }
}
