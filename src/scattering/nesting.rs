//! Nested dielectrics: what is refracted where closed bodies of glass or water overlap or touch.
//!
//! Of the bodies around a point the one of the highest priority counts, and of several the smallest
//! (in the manner of Schmidt and Budge 2002, "Simple nested dielectrics in ray traced images").
//! Which that is does not hang on what a path went through: it is looked for on both sides of what
//! is hit, just as far off it as rays start. So paths of either side know the same, whatever is
//! inside or around, and faces in one place are one interface: what is hit first tells what is
//! before it and behind it, and the ray that goes on starts beyond both. Where a path comes from
//! counts in gaps alone that are narrower than that, and there a ray may still start beyond a face
//! that it should meet. Bodies that are apart from all others are not looked for.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use glam::Vec3;

use super::immersion::{DIRECTIONS, Immersion, STEPS};
use super::patches::{Patches, wholes};
use super::surface::Surfaces;
use crate::geometry::offset_distance;
use crate::scene::baked::{NONE, Optics, Shapes, Solid};
use crate::scene::world::SurfaceModel;

/// Finds the solids whose boxes reach into those of others.
pub fn nest(shapes: &mut Shapes, primitives: &[Vec<u32>]) {
    let mut found: Vec<(u32, Solid, f32)> = Vec::new();
    for (whole, all) in wholes(shapes, primitives) {
        let surface = &shapes.surfaces[whole as usize];
        if !surface.is_body {
            continue;
        }
        let patches = Patches::new(shapes, &all);
        if patches.is_closed() {
            let (bounds, size) = (patches.bounds(), patches.size());
            let (material, priority) = (surface.material, surface.priority);
            let solid = Solid { material, priority, size, bounds, others: Vec::new() };
            found.push((whole, solid, patches.step()));
        }
    }
    meet(&mut found);
    let mut new_row = BTreeMap::new();
    let mut solid_of = BTreeMap::new();
    for (row, (whole, solid, _)) in (0_u32..).zip(&found) {
        if !solid.others.is_empty() {
            let kept = new_row.len() as u32;
            new_row.insert(row, kept);
            solid_of.insert(*whole, kept);
        }
    }
    for surface in &mut shapes.surfaces {
        if let Some(solid) = solid_of.get(&surface.whole) {
            (surface.solid, surface.material) = (*solid, surface.nested_material);
        }
    }
    let kept = found.into_iter().map(|(_, solid, _)| solid).filter(|it| !it.others.is_empty());
    let renumbered = |mut solid: Solid| {
        solid.others.iter_mut().for_each(|other| *other = new_row[other]);
        solid
    };
    shapes.solids = kept.map(renumbered).collect();
}

/// Tells solids of the others whose boxes reach into theirs, or up to them.
fn meet(found: &mut [(u32, Solid, f32)]) {
    let wide = |(_, solid, step): &(u32, Solid, f32)| {
        let [low, high] = solid.bounds;
        [low - *step, high + *step]
    };
    let boxes: Vec<[Vec3; 2]> = found.iter().map(wide).collect();
    let mut order: Vec<usize> = (0..found.len()).collect();
    order.sort_by(|&a, &b| boxes[a][0].x.total_cmp(&boxes[b][0].x));
    for (place, &a) in order.iter().enumerate() {
        let [low, high] = boxes[a];
        let reached = order[place + 1..].iter().take_while(|&&b| boxes[b][0].x <= high.x);
        for &b in reached {
            if low.cmple(boxes[b][1]).all() && boxes[b][0].cmple(high).all() {
                found[a].1.others.push(b as u32);
                found[b].1.others.push(a as u32);
            }
        }
    }
}

impl Immersion<'_> {
    /// The solids that count before and behind a surface of `solid`, at a point on it from which
    /// `off` leads to the front, for a path that comes from `origin`; [`NONE`] where there is none.
    pub fn solids_at(&self, solid: u32, point: Vec3, off: Vec3, origin: Vec3) -> [u32; 2] {
        let others = &self.shapes().solids[solid as usize].others;
        let winner = |off: Vec3, own: Option<u32>| {
            let around = others.iter().copied().filter(|&other| self.is_in(other, point, off));
            let rank = |a: &u32, b: &u32| self.rank(*a, *b);
            around.chain(own).max_by(rank).unwrap_or(NONE)
        };
        // Between faces that are nearer than rays start off them, rays may have started.
        let height = (origin - point).dot(off) / off.length_squared();
        let near = (0.5 * height.abs()).min(1.0);
        let [front, back] = if height > 0.0 { [near, 1.0] } else { [1.0, near] };
        [winner(front * off, None), winner(-back * off, Some(solid))]
    }

    /// Which of two solids counts where both are.
    fn rank(&self, a: u32, b: u32) -> Ordering {
        let [first, second] = [a, b].map(|row| &self.shapes().solids[row as usize]);
        let by_priority = first.priority.cmp(&second.priority);
        by_priority.then(second.size.total_cmp(&first.size)).then(b.cmp(&a))
    }

    /// Whether what is `off` a point of a surface is in a solid, as most of three looks away from
    /// that surface have it.
    fn is_in(&self, solid: u32, point: Vec3, off: Vec3) -> bool {
        let point = point + off;
        let [low, high] = self.shapes().solids[solid as usize].bounds;
        if !(low.cmple(point).all() && point.cmple(high).all()) {
            return false;
        }
        let gets_out = |direction: Vec3| {
            let away = direction * 1.0_f32.copysign(direction.dot(off));
            self.gets_out(solid, point, away.normalize())
        };
        let [a, b, c, ..] = DIRECTIONS;
        let (first, second) = (gets_out(a), gets_out(b));
        if first == second { first } else { gets_out(c) }
    }

    /// Whether a ray leaves a solid more often than it enters it.
    fn gets_out(&self, solid: u32, origin: Vec3, direction: Vec3) -> bool {
        let (shapes, accelerator) = (self.shapes(), self.accelerator());
        let [low, high] = shapes.solids[solid as usize].bounds;
        let far = Vec3::select(direction.cmpgt(Vec3::ZERO), high, low);
        let slack = STEPS * offset_distance(low.abs().max(high.abs()).max_element());
        let end = ((far - origin) / direction + slack / direction.abs()).min_element();
        let mut count = 0;
        let mut hit = accelerator.closest(origin, direction, f32::INFINITY);
        while hit.primitive != NONE && hit.t <= end {
            if shapes.surfaces[shapes.surface_of(hit.primitive) as usize].solid == solid {
                let position = origin + direction * hit.t;
                let normal = shapes.geometric_normal(hit.primitive, position);
                count += if direction.dot(normal) > 0.0 { 1 } else { -1 };
            }
            hit = accelerator.next(origin, direction, hit);
        }
        count > 0
    }
}

/// The interfaces between all that solids are made of, and what is around them.
pub struct Interfaces {
    /// Which of the indices of refraction every solid has; the first is that around all.
    index_of: Vec<usize>,
    count: usize,
    /// Row in the table of dielectrics of the first; they follow by what is before, then by what
    /// is behind.
    first_row: usize,
}

impl Interfaces {
    /// Adds them to the table of dielectrics; nothing where there are no solids.
    pub fn new<const N: usize>(
        shapes: &Shapes,
        optics: &Optics<N>,
        surfaces: &mut Surfaces<N>,
    ) -> Option<Self> {
        if shapes.solids.is_empty() {
            return None;
        }
        let mut indices = vec![1.0_f32];
        let index = |solid: &Solid| {
            let ior = match optics.materials[solid.material as usize].model {
                SurfaceModel::Dielectric { ior, .. } => ior,
                SurfaceModel::Absorber
                | SurfaceModel::Conductor { .. }
                | SurfaceModel::Diffuse { .. }
                | SurfaceModel::Null
                | SurfaceModel::Polarizer { .. }
                | SurfaceModel::Retarder { .. }
                | SurfaceModel::ThinDielectric { .. } => 1.0,
            };
            indices.iter().position(|known| *known == ior).unwrap_or_else(|| {
                indices.push(ior);
                indices.len() - 1
            })
        };
        let index_of = shapes.solids.iter().map(index).collect();
        let mut rows = Vec::new();
        for &before in &indices {
            rows.extend(indices.iter().map(|&behind| surfaces.add_interface(behind, before)));
        }
        Some(Self { index_of, count: indices.len(), first_row: rows[0] as usize })
    }

    /// The row in the table of dielectrics of the interface between two solids, before and behind.
    pub fn row(&self, sides: [u32; 2]) -> usize {
        let [before, behind] =
            sides.map(|solid| self.index_of.get(solid as usize).copied().unwrap_or(0));
        self.first_row + before * self.count + behind
    }
}
