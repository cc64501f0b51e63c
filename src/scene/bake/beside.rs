//! Sets lamps and cameras before what they lie on and light goes through: on which side of it their
//! light starts would be left to rounding.

use std::time::Duration;

use glam::{DVec3, Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};

use super::apart::{CLEARANCE, bounds};
use crate::scene::baked::{Shapes, Sphere, Triangle};

/// Most points whose neighborhoods are looked through one by one: a tree over all that light goes
/// through takes longer than a render of few samples.
const POINTS: usize = 16;

/// Triangles and spheres that light goes through, but for those of instances.
pub struct Passable<'a> {
    shapes: &'a Shapes,
    rows: Vec<usize>,
    /// None where there are none.
    tree: Option<Bvh2>,
}

impl<'a> Passable<'a> {
    /// Those of a scene that some points may lie on.
    pub fn at(points: &[Vec3], shapes: &'a Shapes) -> Self {
        let places: Vec<Aabb> = points.iter().map(|point| around(*point)).collect();
        let count = shapes.triangles.len() + shapes.spheres.len();
        let passes = |row: &usize| {
            let surface = shapes.surface_of_primitive[*row];
            !shapes.surfaces[surface as usize].is_opaque
        };
        let box_of = |row: usize| bounds((&shapes.triangles, &shapes.spheres), row);
        let may_touch = |row: &usize| match points.len() {
            0..=POINTS => {
                let own = box_of(*row);
                places.iter().any(|place| own.intersect_aabb(place))
            }
            _ => true,
        };
        let rows: Vec<usize> = (0..count).filter(passes).filter(may_touch).collect();
        let boxes: Vec<Aabb> = rows.iter().map(|&row| box_of(row)).collect();
        let params = BvhBuildParams::fast_build();
        let tree = || build_bvh2(&boxes, params, &mut Duration::default());
        let tree = (!rows.is_empty()).then(tree);
        Self { shapes, rows, tree }
    }

    /// One of these points, or the nearest before all that it lies on.
    pub fn before(&self, point: Vec3) -> Vec3 {
        let Some(tree) = &self.tree else { return point };
        let mut moved = point.as_dvec3();
        tree.aabb_traverse(around(point), |tree, node| {
            let node = &tree.nodes[node as usize];
            let first = node.first_index as usize;
            for &index in &tree.primitive_indices[first..first + node.prim_count as usize] {
                if let Some(step) = self.step_off(self.rows[index as usize], moved) {
                    moved += step;
                }
            }
            true
        });
        moved.as_vec3()
    }

    /// How a point has to be moved that lies on a primitive.
    fn step_off(&self, row: usize, point: DVec3) -> Option<DVec3> {
        let (height, normal, clearance) = match self.shapes.triangles.get(row) {
            Some(triangle) => height_over(triangle, point)?,
            None => {
                let Sphere { center, radius } =
                    self.shapes.spheres[row - self.shapes.triangles.len()];
                let from_center = point - center.as_dvec3();
                let reach = point.abs().max_element() + f64::from(radius);
                let height = from_center.length() - f64::from(radius);
                (height, from_center.normalize_or(DVec3::X), CLEARANCE * reach)
            }
        };
        (height.abs() < clearance).then(|| normal * (clearance - height))
    }
}

/// What lies within reach of a point.
fn around(point: Vec3) -> Aabb {
    let room = 2.0 * CLEARANCE as f32 * point.abs().max_element();
    Aabb::new(Vec3A::from(point) - room, Vec3A::from(point) + room)
}

/// The height of a point over the front of a triangle, the normal there, and what height is no
/// contact; none if the point is beside it.
fn height_over(Triangle { corners }: &Triangle, point: DVec3) -> Option<(f64, DVec3, f64)> {
    let corners = corners.map(|corner| corner.as_dvec3());
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a).normalize();
    let reach = corners
        .iter()
        .fold(point.abs().max_element(), |reach, corner| reach.max(corner.abs().max_element()));
    let clearance = CLEARANCE * reach;
    let is_inside = [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| {
        let inwards = normal.cross(to - from).normalize();
        (point - from).dot(inwards) > -clearance
    });
    is_inside.then(|| ((point - a).dot(normal), normal, clearance))
}
