//! Emitters whose light cannot get out of what is around them to where the camera looks.
//!
//! From the camera and from each emitter, rays wander about: through all that is not opaque, and
//! from what is opaque back in any direction. An emitter is shut in if none of the places they come
//! to is in sight of one that the camera's come to. So gaps may be overlooked, but only small ones;
//! and what is in sight is never shut in.

use glam::Vec3;

use super::immersion::{STEPS, spread};
use super::look::first_met;
use super::{Scene, emitter};
use crate::geometry::offset_distance;
use crate::math::F32s;
use crate::math::hash::{combine, mix};
use crate::scene::baked::NONE;

/// Walks of the camera, along an edge of the film, and of an emitter; places of each.
const VIEWS: usize = 8;
const WALKS: usize = 64;
const PLACES: usize = 12;
/// Places of the camera that are looked for from each of an emitter's.
const LOOKS: usize = 4;
/// Directions to choose from.
const DIRECTIONS: usize = 4096;

/// Where walks have come to.
#[derive(Default)]
struct Reached {
    places: Vec<Vec3>,
    /// Whether some have left the scene.
    outside: bool,
}

/// What wanders about.
pub struct Wanderer<'a, const N: usize> {
    scene: &'a Scene<N>,
    directions: Vec<Vec3>,
    /// What the camera's walks have come to.
    of_camera: Reached,
}

impl<'a, const N: usize> Wanderer<'a, N> {
    /// Starts at the camera.
    pub fn new(scene: &'a Scene<N>) -> Self {
        let directions = spread(DIRECTIONS).collect();
        let mut wanderer = Self { scene, directions, of_camera: Reached::default() };
        let mut reached = Reached::default();
        let sensor = &scene.sensor;
        for view in 0..VIEWS * VIEWS {
            let at = |index: usize, edge: u32| {
                F32s::splat((index as f32 + 0.5) / VIEWS as f32 * edge as f32)
            };
            let film = [at(view % VIEWS, sensor.width), at(view / VIEWS, sensor.height)];
            let (origin, direction, _) = sensor.rays(film, || [F32s::splat(0.0); 2]);
            let [origin, direction] = [origin, direction].map(|it| Vec3::from(it.to_rows()[0]));
            reached.places.push(origin);
            wanderer.walk(&mut reached, origin, direction, view as u32);
        }
        wanderer.of_camera = reached;
        wanderer
    }

    /// Whether no light of an emitter gets to the camera. What is infinitely far away is never
    /// shut in.
    pub fn is_shut_in(&self, row: usize) -> bool {
        let scene = self.scene;
        let model = &scene.optics.emitters[row].model;
        let starts = emitter::places(model, &scene.shapes);
        if starts.is_empty() {
            return false;
        }
        let two_sided = emitter::is_two_sided(model);
        (0..WALKS).all(|walk| {
            let (place, normal) = starts[walk % starts.len()];
            let seed = combine(mix(row as u32), walk as u32);
            let front = if two_sided && seed & 1 == 0 { -normal } else { normal };
            let place = place + STEPS * scene.emitter_offset(row) * front;
            let mut reached = Reached { places: vec![place], outside: false };
            self.walk(&mut reached, place, self.off(front, seed), seed);
            let mut places = reached.places.iter().zip(0..);
            let is_seen = (reached.outside && self.of_camera.outside)
                || places
                    .any(|(&place, index)| self.is_seen_by_camera(place, combine(seed, index)));
            !is_seen
        })
    }

    fn is_seen_by_camera(&self, place: Vec3, seed: u32) -> bool {
        let places = &self.of_camera.places;
        (0..LOOKS as u32).any(|look| {
            let to = places[combine(seed, look) as usize % places.len()] - place;
            to == Vec3::ZERO || self.met(place, to).0 >= 1.0
        })
    }

    /// Goes on from a place until the scene is left.
    fn walk(&self, reached: &mut Reached, mut place: Vec3, mut direction: Vec3, seed: u32) {
        for step in 0..PLACES as u32 {
            let (t, primitive) = self.met(place, direction);
            if primitive == NONE {
                reached.outside = true;
                return;
            }
            let hit = place + t * direction;
            let normal = self.scene.shapes.geometric_normal(primitive, hit);
            let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
            place = hit + STEPS * offset_distance(hit.abs().max_element()) * normal;
            reached.places.push(place);
            direction = self.off(normal, combine(seed, step));
        }
    }

    /// A direction by the cosine about a normal; any direction if that is zero.
    fn off(&self, normal: Vec3, seed: u32) -> Vec3 {
        0.99 * self.directions[mix(seed) as usize % DIRECTIONS] + normal
    }

    /// What opaque a ray meets, and where.
    fn met(&self, origin: Vec3, direction: Vec3) -> (f32, u32) {
        let shapes = &self.scene.shapes;
        let passes =
            |primitive: u32| !shapes.surfaces[shapes.surface_of(primitive) as usize].is_opaque;
        let hit = first_met(self.scene, origin, direction, passes);
        (hit.t, hit.primitive)
    }
}
