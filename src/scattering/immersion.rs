//! Which medium a point is in: what a path that starts there starts in.

use glam::Vec3;

use crate::geometry::{Accelerator, offset_distance, reach_of_triangle};
use crate::scene::baked::{KEEP, NONE, Shapes};

/// Directions in which to look for the nearest boundary at first; the majority rules, as one of
/// them may run along an edge.
const DIRECTIONS: [Vec3; 7] = [
    Vec3::new(0.267, 0.535, 0.802),
    Vec3::new(-0.802, 0.267, 0.535),
    Vec3::new(0.535, -0.802, 0.267),
    Vec3::new(-0.267, -0.535, -0.802),
    Vec3::new(0.913, 0.365, -0.183),
    Vec3::new(-0.183, 0.913, -0.365),
    Vec3::new(-0.365, -0.183, 0.913),
];

/// Directions in which to look then, if walls hid all boundaries.
const MORE_DIRECTIONS: usize = 128;

/// Surfaces that a look goes through before it gives up.
const SURFACES_MAX: usize = 256;

/// How far before and behind its surface an emitter's media are looked for, in offsets of rays.
const STEPS: f32 = 4.0;

/// Media about something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Around<M> {
    /// The same about all of its points.
    Same(M),
    /// Not the same about all: it crosses a boundary.
    Varies,
}

impl<M: Copy + PartialEq> Around<M> {
    /// What some of its points have about them.
    fn of(media: impl IntoIterator<Item = M>) -> Option<Self> {
        let mut media = media.into_iter();
        let first = media.next()?;
        let is_same = media.all(|other| other == first);
        Some(if is_same { Self::Same(first) } else { Self::Varies })
    }
}

/// Finds media of points in a scene.
#[derive(Clone, Copy)]
pub struct Immersion<'a> {
    shapes: &'a Shapes,
    accelerator: &'a Accelerator,
    /// Of every material, whether nothing passes.
    is_opaque: &'a [bool],
    /// Without media there is nothing to look for.
    has_media: bool,
}

impl<'a> Immersion<'a> {
    /// Looks at the surfaces of `shapes`, found by `accelerator`. `is_opaque` says of every
    /// material whether nothing passes.
    pub fn new(
        shapes: &'a Shapes,
        accelerator: &'a Accelerator,
        is_opaque: &'a [bool],
        has_media: bool,
    ) -> Self {
        Self { shapes, accelerator, is_opaque, has_media }
    }

    /// The medium around a point: a row in `media`, or [`NONE`].
    ///
    /// What the boundaries say that can be seen from there. Opaque walls say nothing; where there
    /// is nothing else to be seen, it is the medium of the scene.
    pub fn at(&self, point: Vec3) -> u32 {
        if !self.has_media {
            return NONE;
        }
        let first = self.majority(point, DIRECTIONS.into_iter());
        let more = || self.majority(point, spread(MORE_DIRECTIONS));
        first.or_else(more).unwrap_or(self.shapes.scene_medium)
    }

    /// The medium about points; none are looked for where there are no media.
    pub fn about(&self, points: impl IntoIterator<Item = Vec3>) -> Around<u32> {
        if !self.has_media {
            return Around::Same(NONE);
        }
        let media = points.into_iter().map(|point| self.at(point));
        Around::of(media).unwrap_or(Around::Same(self.shapes.scene_medium))
    }

    /// The media before and behind the points of an emitter, with the normals there; those of the
    /// scene if it has no place.
    pub fn about_emitter(
        &self,
        places: impl FnOnce(&Shapes) -> Vec<(Vec3, Vec3)>,
        primitive: u32,
    ) -> Around<[u32; 2]> {
        if !self.has_media {
            return Around::Same([NONE; 2]);
        }
        let places = places(self.shapes);
        let sides = places.iter().map(|&(point, normal)| self.of_sides(primitive, point, normal));
        Around::of(sides).unwrap_or(Around::Same([self.shapes.scene_medium; 2]))
    }

    /// The media before and behind a primitive, whose normal at `point` is `normal`; about the
    /// point itself where there is no primitive ([`NONE`]).
    pub fn of_sides(&self, primitive: u32, point: Vec3, normal: Vec3) -> [u32; 2] {
        if primitive == NONE {
            return [self.at(point); 2];
        }
        let surface = &self.shapes.surfaces[self.shapes.surface_of(primitive) as usize];
        let step = normal * (STEPS * offset_distance(self.reach(primitive)));
        let side = |stated: u32, point: Vec3| if stated == KEEP { self.at(point) } else { stated };
        [side(surface.exterior, point + step), side(surface.interior, point - step)]
    }

    /// The largest coordinate of a primitive that is not instanced.
    fn reach(&self, primitive: u32) -> f32 {
        let row = primitive as usize;
        match self.shapes.triangles.get(row) {
            Some(triangle) => reach_of_triangle(triangle),
            None => {
                let sphere = &self.shapes.spheres[row - self.shapes.triangles.len()];
                sphere.center.abs().max_element() + sphere.radius
            }
        }
    }

    /// What most looks have found, of those that have found anything.
    fn majority(&self, point: Vec3, directions: impl Iterator<Item = Vec3>) -> Option<u32> {
        let found: Vec<u32> =
            directions.filter_map(|it| self.look(point, it.normalize())).collect();
        let votes = |medium: u32| found.iter().filter(|&&other| other == medium).count();
        found.iter().copied().max_by_key(|&medium| votes(medium))
    }

    /// The medium on the near side of the first boundary in a direction; that of the scene if
    /// there is none, nothing if a wall hides what there is.
    fn look(&self, origin: Vec3, direction: Vec3) -> Option<u32> {
        let mut hit = self.accelerator.closest(origin, direction, f32::INFINITY);
        for _ in 0..SURFACES_MAX {
            if hit.primitive == NONE {
                return Some(self.shapes.scene_medium);
            }
            let surface = &self.shapes.surfaces[self.shapes.surface_of(hit.primitive) as usize];
            if self.is_opaque[surface.material as usize] {
                return None;
            }
            let position = origin + direction * hit.t;
            let normal = self.shapes.geometric_normal(hit.primitive, position);
            let near =
                if direction.dot(normal) < 0.0 { surface.exterior } else { surface.interior };
            if near != KEEP {
                return Some(near);
            }
            hit = self.accelerator.next(origin, direction, hit);
        }
        None
    }
}

/// Directions all over the sphere, on a spiral of the golden angle.
pub fn spread(count: usize) -> impl Iterator<Item = Vec3> {
    let golden = std::f32::consts::PI * (3.0 - 5.0_f32.sqrt());
    (0..count).map(move |index| {
        let z = 1.0 - (2 * index + 1) as f32 / count as f32;
        let (sin, cos) = (golden * index as f32).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        Vec3::new(cos * radius, sin * radius, z)
    })
}
