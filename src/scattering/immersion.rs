//! Which medium a point is in: what a path that starts there starts in.

use std::iter::from_fn;

use glam::Vec3;

use crate::geometry::{Accelerator, Hit, offset_distance, reach_of_triangle};
use crate::math::elementary::{cos, sin, sin_cos};
use crate::math::hash;
use crate::scene::baked::{Body, KEEP, NONE, SOUGHT, Shapes};

/// Directions in which to look for the nearest boundary at first; the majority rules, as one of
/// them may run along an edge.
pub const DIRECTIONS: [Vec3; 7] = [
    Vec3::new(0.267, 0.535, 0.802),
    Vec3::new(-0.802, 0.267, 0.535),
    Vec3::new(0.535, -0.802, 0.267),
    Vec3::new(-0.267, -0.535, -0.802),
    Vec3::new(0.913, 0.365, -0.183),
    Vec3::new(-0.183, 0.913, -0.365),
    Vec3::new(-0.365, -0.183, 0.913),
];

/// Directions in which to look then, if walls hid all boundaries, and walls from which to look on
/// in each: what is bounded by them and the boundaries together is one medium.
const MORE_DIRECTIONS: usize = 128;
const WALLS: usize = 8;

/// The majority of looks is certain when it leads by so many.
const LEAD: usize = 3;

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

/// Where a ray crosses a surface.
#[derive(Clone, Copy, Debug)]
pub struct Crossed {
    /// Its row.
    pub surface: u32,
    /// From the ray's origin, in lengths of its direction.
    pub distance: f32,
    /// Where.
    pub position: Vec3,
    /// The geometric normal, to the front.
    pub normal: Vec3,
    /// Of the direction to that.
    pub cosine: f32,
}

impl Crossed {
    /// 1 where the ray goes to the front, else -1.
    pub fn outwards(&self) -> i32 {
        if self.cosine > 0.0 { 1 } else { -1 }
    }
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

    /// What finds them.
    pub fn accelerator(&self) -> &'a Accelerator {
        self.accelerator
    }

    /// The medium around a point: a row in `media`, or [`NONE`].
    ///
    /// What the boundaries say that can be seen from there, or from the walls seen from there.
    /// Opaque walls say nothing; where there is nothing else to be seen, it is what fills the
    /// smallest body around them all, or the medium of the scene. Where boundaries contradict each
    /// other, it is what fills the smallest body around the point.
    pub fn at(&self, point: Vec3) -> u32 {
        if !self.has_media {
            return NONE;
        }
        let near = self.in_sight(point).or_else(|| self.round_corners(point));
        near.unwrap_or_else(|| self.behind_walls(point))
    }

    /// What fills the smallest body around a point, or the scene, whatever walls there are.
    pub fn behind_walls(&self, point: Vec3) -> u32 {
        self.filling(point).unwrap_or(self.shapes.scene_medium)
    }

    /// The medium about points that are close together; none are looked for where there are no
    /// media.
    pub fn about(&self, points: impl IntoIterator<Item = Vec3>) -> Around<u32> {
        if !self.has_media {
            return Around::Same(NONE);
        }
        // Where walls are all around, they are around the others too.
        let mut is_walled_in = false;
        let at = |point: Vec3| {
            let near = self.in_sight(point).or_else(|| {
                let far = if is_walled_in { None } else { self.round_corners(point) };
                is_walled_in = far.is_none();
                far
            });
            near.unwrap_or_else(|| self.behind_walls(point))
        };
        Around::of(points.into_iter().map(at)).unwrap_or(Around::Same(self.shapes.scene_medium))
    }

    /// The media before and behind the points of an emitter, with the normals there; those of the
    /// scene if it has no place. Behind an emitter that shines to its front alone nobody asks for
    /// it: it is taken to be the same.
    pub fn about_emitter(
        &self,
        places: impl FnOnce(&Shapes) -> Vec<(Vec3, Vec3)>,
        primitive: u32,
        is_two_sided: bool,
    ) -> Around<[u32; 2]> {
        if !self.has_media {
            return Around::Same([NONE; 2]);
        }
        let places = places(self.shapes);
        let about = |side: f32| {
            let stated = self.stated(primitive, usize::from(side < 0.0));
            stated.map(Around::Same).unwrap_or_else(|| {
                let step = side * self.step_off(primitive);
                self.about(places.iter().map(|&(point, normal)| point + step * normal))
            })
        };
        let front = about(1.0);
        let back = if is_two_sided { about(-1.0) } else { front };
        let (Around::Same(front), Around::Same(back)) = (front, back) else {
            return Around::Varies;
        };
        Around::Same([front, back])
    }

    /// The medium before or behind a primitive, whose normal at `point` is `normal`; about the
    /// point itself where there is no primitive ([`NONE`]).
    pub fn of_side(&self, primitive: u32, side: usize, point: Vec3, normal: Vec3) -> u32 {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let off = || point + sign * self.step_off(primitive) * normal;
        self.stated(primitive, side).unwrap_or_else(|| self.at(off()))
    }

    /// What the surface of a primitive says about its front (0) or back (1).
    fn stated(&self, primitive: u32, side: usize) -> Option<u32> {
        if primitive == NONE {
            return None;
        }
        let surface = &self.shapes.surfaces[self.shapes.surface_of(primitive) as usize];
        let stated = [surface.exterior, surface.interior][side];
        (stated != KEEP && stated != SOUGHT).then_some(stated)
    }

    /// How far off a primitive one is on a side of it.
    fn step_off(&self, primitive: u32) -> f32 {
        if primitive == NONE { 0.0 } else { STEPS * offset_distance(self.reach(primitive)) }
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

    /// What fills the smallest body around a point, or else what most of a few looks find.
    fn in_sight(&self, point: Vec3) -> Option<u32> {
        if self.shapes.are_bodies_all {
            return Some(self.behind_walls(point));
        }
        let look = |direction: Vec3| self.see(point, direction.normalize());
        let filling = if self.shapes.overlaps { self.filling(point) } else { None };
        filling.or_else(|| self.majority(DIRECTIONS.into_iter().map(look)))
    }

    /// What most of many looks find that go on from the walls they meet.
    fn round_corners(&self, point: Vec3) -> Option<u32> {
        let looks = (0..).zip(spread(MORE_DIRECTIONS));
        self.majority(looks.map(|(index, direction)| self.see_around(point, direction, index)))
    }

    /// What most looks have found, of those that have found anything.
    fn majority(&self, looks: impl Iterator<Item = Seen>) -> Option<u32> {
        let mut votes: Vec<(u32, usize)> = Vec::new();
        let mut count = 0;
        for medium in looks.filter_map(|seen| self.said_by(seen)) {
            count += 1;
            match votes.iter_mut().find(|(voted, _)| *voted == medium) {
                Some((_, votes)) if 2 * (*votes + 1) >= count + LEAD => return Some(medium),
                Some((_, votes)) => *votes += 1,
                None => votes.push((medium, 1)),
            }
        }
        votes.into_iter().max_by_key(|&(_, votes)| votes).map(|(medium, _)| medium)
    }

    /// The medium that is where one sees this from, unless a wall hides it.
    fn said_by(&self, seen: Seen) -> Option<u32> {
        let medium = match seen {
            Seen::Nothing => return None,
            Seen::Outside => self.shapes.scene_medium,
            Seen::Side(surface, side) => self.sides(surface)[side],
        };
        (medium != SOUGHT).then_some(medium)
    }

    /// [`Immersion::see`], and on from the walls that are met; `index` tells looks apart.
    pub fn see_around(&self, mut origin: Vec3, mut direction: Vec3, index: usize) -> Seen {
        for wall in 0..=WALLS {
            let (seen, place) = self.cast(origin, direction);
            let (Seen::Nothing, Some((position, normal))) = (seen, place) else { return seen };
            let reach = position.abs().max_element().max(position.distance(origin));
            let aside = hash::combine(hash::combine(0, index as u32), wall as u32);
            let number = |salt: u32| (hash::combine(aside, salt) >> 8) as f32 / (1 << 24) as f32;
            let (z, angle) = (2.0 * number(0) - 1.0, std::f32::consts::TAU * number(1));
            let radius = (1.0 - z * z).sqrt();
            let aside = Vec3::new(radius * cos(angle), radius * sin(angle), z);
            origin = position + STEPS * offset_distance(reach) * normal;
            direction = (normal + 0.99 * aside).normalize();
        }
        Seen::Nothing
    }

    /// The first side of a boundary in a direction; of several in one place, one that is stated.
    pub fn see(&self, origin: Vec3, direction: Vec3) -> Seen {
        self.cast(origin, direction).0
    }

    /// [`Immersion::see`], and where a wall hid everything, with the normal to this side.
    fn cast(&self, origin: Vec3, direction: Vec3) -> (Seen, Option<(Vec3, Vec3)>) {
        let mut first: Option<(f32, Seen)> = None;
        let mut crossed = self.crossed(origin, direction);
        for _ in 0..SURFACES_MAX {
            let next = crossed.next();
            if let Some((end, seen)) = first
                && next.as_ref().is_none_or(|next| next.distance > end)
            {
                return (seen, None);
            }
            let Some(next) = next else { return (Seen::Outside, None) };
            let Crossed { surface: row, position, normal, .. } = next;
            let surface = &self.shapes.surfaces[row as usize];
            let side = usize::from(next.cosine < 0.0);
            if surface.is_opaque {
                let normal = if side == 1 { normal } else { -normal };
                let wall = (Seen::Nothing, Some((position, normal)));
                return first.map_or(wall, |(_, seen)| (seen, None));
            }
            if self.sides(row)[side] != KEEP {
                if !surface.unstated[side] {
                    return (Seen::Side(row, side), None);
                }
                let reach = position.abs().max_element().max(next.distance);
                let end = next.distance + STEPS * offset_distance(reach);
                first = first.or(Some((end, Seen::Side(row, side))));
            }
        }
        (Seen::Nothing, None)
    }

    fn sides(&self, surface: u32) -> [u32; 2] {
        let surface = &self.shapes.surfaces[surface as usize];
        [surface.interior, surface.exterior]
    }

    /// What fills the body that counts around a point, as most of a few directions have it.
    fn filling(&self, point: Vec3) -> Option<u32> {
        if self.shapes.bodies.is_empty() {
            return None;
        }
        let innermost = |which: usize| self.innermost(point, DIRECTIONS[which].normalize());
        let (first, second) = (innermost(0), innermost(1));
        if first == second || innermost(2) != second { first } else { second }
    }

    fn innermost(&self, point: Vec3, direction: Vec3) -> Option<u32> {
        let bodies = &self.shapes.bodies;
        let around = self.leaves(point, direction).into_iter().filter_map(|surface| {
            let row = bodies.binary_search_by_key(&surface, |body| body.surface).ok()?;
            Some(&bodies[row])
        });
        let rank = |a: &&Body, b: &&Body| {
            let by_priority = a.priority.cmp(&b.priority);
            by_priority.then(b.size.total_cmp(&a.size)).then(b.surface.cmp(&a.surface))
        };
        around.max_by(rank).map(|body| body.filling)
    }

    /// Whether a point is inside of a surface that is closed, or of several that are so together,
    /// of which this is the first.
    pub fn is_within(&self, surface: u32, point: Vec3) -> bool {
        let votes = DIRECTIONS[..3].iter().map(|it| self.leaves(point, it.normalize()));
        votes.filter(|around| around.contains(&surface)).count() >= 2
    }

    /// All that a ray crosses, in order.
    pub fn crossed(&self, origin: Vec3, direction: Vec3) -> impl Iterator<Item = Crossed> {
        let Self { shapes, accelerator, .. } = *self;
        let mut last: Option<Hit> = None;
        let hits = from_fn(move || {
            let hit = match last {
                None => accelerator.closest(origin, direction, f32::INFINITY),
                Some(last) => accelerator.next(origin, direction, last),
            };
            last = Some(hit);
            (hit.primitive != NONE).then_some(hit)
        });
        hits.fuse().map(move |hit| {
            let position = origin + direction * hit.t;
            let normal = shapes.geometric_normal(hit.primitive, position);
            let (surface, cosine) = (shapes.surface_of(hit.primitive), direction.dot(normal));
            Crossed { surface, distance: hit.t, position, normal, cosine }
        })
    }

    /// The surfaces that a ray leaves more often than it enters them.
    fn leaves(&self, origin: Vec3, direction: Vec3) -> Vec<u32> {
        let mut counts: Vec<(u32, i32)> = Vec::new();
        for crossed in self.crossed(origin, direction) {
            let whole = self.shapes.surfaces[crossed.surface as usize].whole;
            match counts.iter_mut().find(|(surface, _)| *surface == whole) {
                Some((_, count)) => *count += crossed.outwards(),
                None => counts.push((whole, crossed.outwards())),
            }
        }
        counts.into_iter().filter(|(_, count)| *count > 0).map(|(surface, _)| surface).collect()
    }
}

/// Directions all over the sphere, on a spiral of the golden angle.
pub fn spread(count: usize) -> impl Iterator<Item = Vec3> {
    let golden = std::f32::consts::PI * (3.0 - 5.0_f32.sqrt());
    (0..count).map(move |index| {
        let z = 1.0 - (2 * index + 1) as f32 / count as f32;
        let (sin, cos) = sin_cos(golden * index as f32);
        let radius = (1.0 - z * z).sqrt();
        Vec3::new(cos * radius, sin * radius, z)
    })
}
