//! Where surfaces end or bend sharply: what photons of one surface must not be counted across.

use std::cmp::Ordering;

use glam::{Vec3, Vec3A};
use rayon::prelude::*;

use crate::scene::baked::{Shapes, Triangle};

use super::accelerator::Accelerator;

/// The cosine of the angle by which a surface that goes on behind an edge turns there at most.
const SMOOTH: f32 = 0.7;
/// The most rims of instances: beyond, their copies would take more memory than they are worth.
const OF_INSTANCES_MAX: usize = 1 << 20;

/// The edges of triangles behind which no other goes on nearly as they do, as a tree of triangles
/// without width. Edges meet where their ends have equal coordinates.
#[derive(Default)]
pub struct Rims(Option<Accelerator>);

impl Rims {
    /// Those of all triangles of a scene.
    pub fn of_shapes(shapes: &Shapes) -> Self {
        let mut rims = rims_of(&shapes.triangles);
        let instanced = &shapes.instanced;
        let of_objects: Vec<_> =
            instanced.objects().iter().map(|object| rims_of(&object.triangles)).collect();
        let of = |object: u32| &of_objects[object as usize];
        let count: usize = instanced.instances().iter().map(|it| of(it.object).len()).sum();
        if count <= OF_INSTANCES_MAX {
            for instance in instanced.instances() {
                let to_world = |corner: Vec3| instance.to_world.transform_point3(corner);
                let in_world = |rim: &Triangle| Triangle { corners: rim.corners.map(to_world) };
                rims.extend(of(instance.object).iter().map(in_world));
            }
        }
        Self::from_edges(&rims)
    }

    fn from_edges(rims: &[Triangle]) -> Self {
        Self((!rims.is_empty()).then(|| Accelerator::build(rims, &[])))
    }

    /// Those of some triangles.
    #[cfg(test)]
    pub fn of_triangles(triangles: &[Triangle]) -> Self {
        Self::from_edges(&rims_of(triangles))
    }

    /// The tree, if there are any.
    pub fn tree(&self) -> Option<&Accelerator> {
        self.0.as_ref()
    }
}

/// An edge as a triangle has it.
#[derive(Clone, Copy)]
struct Side {
    /// The ends, the lesser first, exactly.
    ends: [[u32; 3]; 2],
    row: u32,
    /// Which edge of the triangle.
    edge: u32,
}

impl Side {
    fn of(triangle: &Triangle, row: usize, edge: usize) -> Self {
        // Zero has two signs.
        let place = |corner: Vec3| corner.to_array().map(|it| (it + 0.0).to_bits());
        let ends = [edge, (edge + 1) % 3].map(|corner| place(triangle.corners[corner]));
        let [one, other] = ends;
        let ends = if one.cmp(&other) == Ordering::Greater { [other, one] } else { ends };
        Self { ends, row: row as u32, edge: edge as u32 }
    }

    /// The corners of the edge, and the unit vector in the triangle across and away from it.
    fn across(&self, triangles: &[Triangle]) -> ([Vec3; 2], Vec3A) {
        let corners = triangles[self.row as usize].corners;
        let at = |step: u32| corners[((self.edge + step) % 3) as usize];
        let [from, to, opposite] = [at(0), at(1), at(2)];
        let along = Vec3A::from(to - from).normalize_or_zero();
        let over = Vec3A::from(opposite - from);
        ([from, to], (over - along * along.dot(over)).normalize_or_zero())
    }
}

/// The rims of triangles, each once, in an order that hangs on where they are alone.
fn rims_of(triangles: &[Triangle]) -> Vec<Triangle> {
    let sides_of = |(row, triangle)| [0, 1, 2].map(|edge| Side::of(triangle, row, edge));
    let mut sides: Vec<Side> = triangles.par_iter().enumerate().flat_map_iter(sides_of).collect();
    sides.par_sort_unstable_by_key(|side| (side.ends, side.row, side.edge));
    let edges = sides.chunk_by(|one, other| one.ends == other.ends);
    let rim = |sides: &[Side]| {
        let ([from, to], _) = sides[0].across(triangles);
        let ways: Vec<Vec3A> = sides.iter().map(|side| side.across(triangles).1).collect();
        let goes_on = |way: &Vec3A| ways.iter().any(|other| -way.dot(*other) > SMOOTH);
        (!ways.iter().all(goes_on)).then_some(Triangle { corners: [from, to, to] })
    };
    edges.filter_map(rim).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quad(corners: [[f32; 3]; 4]) -> [Triangle; 2] {
        let [a, b, c, d] = corners.map(Vec3::from);
        [[a, b, c], [a, c, d]].map(|corners| Triangle { corners })
    }

    fn count(quads: &[[[f32; 3]; 4]]) -> usize {
        let triangles: Vec<Triangle> = quads.iter().flat_map(|corners| quad(*corners)).collect();
        rims_of(&triangles).len()
    }

    #[test]
    fn surfaces_end_at_open_edges_and_turn_at_sharp_ones() {
        let floor = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let beside =
            |rise: f32| [[1.0, 0.0, 0.0], [2.0, 0.0, rise], [2.0, 1.0, rise], [1.0, 1.0, 0.0]];
        let wall = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]];
        assert_eq!(count(&[floor]), 4);
        assert_eq!(count(&[floor, beside(0.0)]), 6);
        assert_eq!(count(&[floor, beside(0.5)]), 6);
        assert_eq!(count(&[floor, beside(3.0)]), 7);
        // What goes on is one surface; the wall on it ends there.
        assert_eq!(count(&[floor, wall]), 7);
        assert_eq!(count(&[floor, beside(0.0), wall]), 10);
    }
}
