//! Which medium a point is in: what a path that starts there starts in.

use glam::Vec3;

use crate::geometry::Accelerator;
use crate::scene::baked::{KEEP, NONE, Shapes};

/// Directions in which to look for the nearest boundary; the majority rules, as one of them may
/// run along an edge.
const DIRECTIONS: [Vec3; 7] = [
    Vec3::new(0.267, 0.535, 0.802),
    Vec3::new(-0.802, 0.267, 0.535),
    Vec3::new(0.535, -0.802, 0.267),
    Vec3::new(-0.267, -0.535, -0.802),
    Vec3::new(0.913, 0.365, -0.183),
    Vec3::new(-0.183, 0.913, -0.365),
    Vec3::new(-0.365, -0.183, 0.913),
];

/// Surfaces that a look goes through before it gives up.
const SURFACES_MAX: usize = 256;

/// How far a look steps off a surface, relative to the scene.
const STEP: f32 = 1e-5;

/// Finds media of points in a scene.
pub struct Immersion<'a> {
    shapes: &'a Shapes,
    accelerator: &'a Accelerator,
    /// Without media there is nothing to look for.
    has_media: bool,
}

impl<'a> Immersion<'a> {
    /// Looks at the surfaces of `shapes`, found by `accelerator`.
    pub fn new(shapes: &'a Shapes, accelerator: &'a Accelerator, has_media: bool) -> Self {
        Self { shapes, accelerator, has_media }
    }

    /// The medium around a point: a row in `media`, or [`NONE`].
    pub fn at(&self, point: Vec3) -> u32 {
        if !self.has_media {
            return NONE;
        }
        let found = DIRECTIONS.map(|direction| self.look(point, direction.normalize()));
        let votes = |medium: u32| found.iter().filter(|&&other| other == medium).count();
        found.into_iter().max_by_key(|&medium| votes(medium)).unwrap_or(NONE)
    }

    /// The shapes that are looked at.
    pub fn shapes(&self) -> &'a Shapes {
        self.shapes
    }

    /// The media before and behind a primitive, whose normal at `point` is `normal`.
    pub fn of_sides(&self, primitive: u32, point: Vec3, normal: Vec3) -> [u32; 2] {
        let surface = &self.shapes.surfaces[self.shapes.surface_of(primitive) as usize];
        let step = normal * (STEP * self.shapes.bounds.radius);
        let side = |stated: u32, point: Vec3| if stated == KEEP { self.at(point) } else { stated };
        [side(surface.exterior, point + step), side(surface.interior, point - step)]
    }

    /// The medium on the near side of the first boundary in a direction; that of the scene if
    /// there is none.
    fn look(&self, mut origin: Vec3, direction: Vec3) -> u32 {
        for _ in 0..SURFACES_MAX {
            let hit = self.accelerator.closest(origin, direction, f32::INFINITY);
            if hit.primitive == NONE {
                break;
            }
            let surface = &self.shapes.surfaces[self.shapes.surface_of(hit.primitive) as usize];
            let position = origin + direction * hit.t;
            let normal = self.shapes.geometric_normal(hit.primitive, position);
            let near =
                if direction.dot(normal) < 0.0 { surface.exterior } else { surface.interior };
            if near != KEEP {
                return near;
            }
            origin = position + direction * (STEP * self.shapes.bounds.radius);
        }
        self.shapes.scene_medium
    }
}
