//! Which medium a point is in: what a path that starts there starts in.

use glam::Vec3;

use crate::geometry::{Accelerator, offset_distance, reach_of_triangle};
use crate::scene::baked::{Body, KEEP, NONE, SOUGHT, Shapes};

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
pub const STEPS: f32 = 4.0;

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

/// What a look finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// A wall, behind which anything may be.
    Nothing,
    /// The end of the scene.
    Outside,
    /// A side of a surface: 0 its back, 1 its front.
    Side(u32, usize),
}

/// Finds media of points in a scene.
#[derive(Clone, Copy)]
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

    /// What it looks at.
    pub fn shapes(&self) -> &'a Shapes {
        self.shapes
    }

    /// The medium around a point: a row in `media`, or [`NONE`].
    ///
    /// What the boundaries say that can be seen from there. Opaque walls say nothing; where there
    /// is nothing else to be seen, it is the medium of the scene. Where boundaries contradict each
    /// other, it is what fills the smallest body around the point.
    pub fn at(&self, point: Vec3) -> u32 {
        if !self.has_media {
            return NONE;
        }
        if let Some(filling) = self.filling(point) {
            return filling;
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
        let side = |stated: u32, point: Vec3| match stated {
            KEEP | SOUGHT => self.at(point),
            stated => stated,
        };
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
        let medium = match self.see(origin, direction) {
            Seen::Nothing => return None,
            Seen::Outside => self.shapes.scene_medium,
            Seen::Side(surface, side) => self.sides(surface)[side],
        };
        (medium != SOUGHT).then_some(medium)
    }

    /// The first side of a boundary in a direction; of several in one place, one that is stated.
    pub fn see(&self, origin: Vec3, direction: Vec3) -> Seen {
        let mut first: Option<(f32, Seen)> = None;
        let mut hit = self.accelerator.closest(origin, direction, f32::INFINITY);
        for _ in 0..SURFACES_MAX {
            let is_beyond = |(t, _): (f32, _)| hit.primitive == NONE || hit.t > t;
            if let Some(first) = first
                && is_beyond(first)
            {
                return first.1;
            }
            if hit.primitive == NONE {
                return Seen::Outside;
            }
            let row = self.shapes.surface_of(hit.primitive);
            let surface = &self.shapes.surfaces[row as usize];
            if surface.is_opaque {
                return first.map_or(Seen::Nothing, |(_, seen)| seen);
            }
            let position = origin + direction * hit.t;
            let normal = self.shapes.geometric_normal(hit.primitive, position);
            let side = usize::from(direction.dot(normal) < 0.0);
            if self.sides(row)[side] != KEEP {
                if !surface.unstated[side] {
                    return Seen::Side(row, side);
                }
                let reach = position.abs().max_element().max(hit.t);
                let end = hit.t + STEPS * offset_distance(reach);
                first = first.or(Some((end, Seen::Side(row, side))));
            }
            hit = self.accelerator.next(origin, direction, hit);
        }
        Seen::Nothing
    }

    fn sides(&self, surface: u32) -> [u32; 2] {
        let surface = &self.shapes.surfaces[surface as usize];
        [surface.interior, surface.exterior]
    }

    /// What fills the smallest body around a point, as most of a few directions have it.
    fn filling(&self, point: Vec3) -> Option<u32> {
        if self.shapes.bodies.is_empty() {
            return None;
        }
        let [a, b, c, ..] = DIRECTIONS.map(|it| self.innermost(point, it.normalize()));
        if b == c { b } else { a }
    }

    fn innermost(&self, point: Vec3, direction: Vec3) -> Option<u32> {
        let around = self.leaves(point, direction);
        let bodies = self.shapes.bodies.iter().filter(|body| around.contains(&body.surface));
        let smaller = |a: &&Body, b: &&Body| a.size.total_cmp(&b.size);
        bodies.min_by(smaller).map(|body| body.filling)
    }

    /// Whether a point is inside of a surface that is closed.
    pub fn is_within(&self, surface: u32, point: Vec3) -> bool {
        let votes = DIRECTIONS[..3].iter().map(|it| self.leaves(point, it.normalize()));
        votes.filter(|around| around.contains(&surface)).count() >= 2
    }

    /// The surfaces that a ray leaves more often than it enters them.
    fn leaves(&self, origin: Vec3, direction: Vec3) -> Vec<u32> {
        let mut counts: Vec<(u32, i32)> = Vec::new();
        let mut hit = self.accelerator.closest(origin, direction, f32::INFINITY);
        while hit.primitive != NONE {
            let row = self.shapes.surface_of(hit.primitive);
            let position = origin + direction * hit.t;
            let normal = self.shapes.geometric_normal(hit.primitive, position);
            let step = if direction.dot(normal) > 0.0 { 1 } else { -1 };
            match counts.iter_mut().find(|(surface, _)| *surface == row) {
                Some((_, count)) => *count += step,
                None => counts.push((row, step)),
            }
            hit = self.accelerator.next(origin, direction, hit);
        }
        counts.into_iter().filter(|(_, count)| *count > 0).map(|(surface, _)| surface).collect()
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
