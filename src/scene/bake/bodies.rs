//! Which triangles hold together when a surface gives way.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::{DVec3, Vec3};

use super::apart::Yields;
use super::primitives::Primitives;
use crate::math::elementary::atan2;
use crate::scene::baked::{Surface, Triangle};

/// A place, exactly.
type Place = [u32; 3];

/// Where a corner is, exactly.
pub fn place(corner: Vec3) -> Place {
    // Zero has two signs.
    corner.to_array().map(|it| (it + 0.0).to_bits())
}

/// Finds the body of every triangle that gives way, by one of its triangles. Triangles of one
/// surface that share a corner are of one body, and those that share an edge and are alike, where
/// what one bounds goes on behind the other: of boxes that are stacked, every one is a body.
pub fn bodies(tables: &Primitives, yields: &[Yields]) -> Vec<u32> {
    let mut groups = Groups((0..tables.triangles.len() as u32).collect());
    let mut at_corner: HashMap<(u32, Place), u32> = HashMap::new();
    let mut at_edge: HashMap<(Alike, [Place; 2]), Vec<HalfEdge>> = HashMap::new();
    for (row, (triangle, &surface)) in
        (0..).zip(tables.triangles.iter().zip(&tables.surface_of_primitive))
    {
        let yields = yields[surface as usize];
        if let Yields::Never { .. } = yields {
            continue;
        }
        for corner in triangle.corners {
            let first = *at_corner.entry((surface, place(corner))).or_insert(row);
            groups.unite(first, row);
        }
        if let Yields::AsSheet = yields {
            continue;
        }
        let alike = alike(&tables.surfaces[surface as usize]);
        for half in half_edges(triangle, row) {
            let [from, to] = half.0;
            at_edge.entry((alike, [from.min(to), from.max(to)])).or_default().push(half);
        }
    }
    for halves in at_edge.values() {
        halves.iter().for_each(|half| unite_around(&mut groups, half, halves));
    }
    (0..tables.triangles.len() as u32).map(|row| groups.root(row)).collect()
}

/// What surfaces have in common that bound a body together.
pub type Alike = (u32, [u32; 2], i32);

/// See [`Alike`].
pub fn alike(&Surface { material, interior, exterior, priority, .. }: &Surface) -> Alike {
    (material, [interior, exterior], priority)
}

/// An edge as it runs about a triangle: its ends, the triangle, the direction from the edge to the
/// third corner, and the normal.
struct HalfEdge([Place; 2], u32, DVec3, DVec3);

fn half_edges(triangle: &Triangle, row: u32) -> [HalfEdge; 3] {
    let corners = triangle.corners.map(|corner| corner.as_dvec3());
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
    [0, 1, 2].map(|index| {
        let [from, to] = [index, (index + 1) % 3];
        let across = normal.cross(corners[to] - corners[from]).normalize();
        let ends = [triangle.corners[from], triangle.corners[to]].map(place);
        HalfEdge(ends, row, across, normal)
    })
}

/// Unites a triangle with the first that one comes to around an edge through what it bounds.
fn unite_around(groups: &mut Groups, half: &HalfEdge, halves: &[HalfEdge]) {
    let HalfEdge([from, to], row, across, normal) = half;
    let angle = |other: &&HalfEdge| {
        let behind = atan2(other.2.dot(-*normal), other.2.dot(*across));
        behind.rem_euclid(TAU)
    };
    let runs_back = |other: &&HalfEdge| other.0 == [*to, *from];
    let next =
        halves.iter().filter(runs_back).min_by(|one, other| angle(one).total_cmp(&angle(other)));
    if let Some(next) = next {
        groups.unite(*row, next.1);
    }
}

/// Disjoint sets, by one member of each.
struct Groups(Vec<u32>);

impl Groups {
    fn root(&mut self, mut row: u32) -> u32 {
        while self.0[row as usize] != row {
            let above = self.0[self.0[row as usize] as usize];
            self.0[row as usize] = above;
            row = above;
        }
        row
    }

    fn unite(&mut self, one: u32, other: u32) {
        let [one, other] = [self.root(one), self.root(other)];
        self.0[one.max(other) as usize] = one.min(other);
    }
}
