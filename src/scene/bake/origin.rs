//! Where world space is centered, so that single precision suffices wherever the scene stands.
//!
//! A coordinate in `f32` is good to a ten-millionth of itself. About a point as near to the camera
//! as the nearest thing that it sees, that is as good as the ten-millionth of any distance from
//! the camera, or little worse.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::check_range;
use crate::math::elementary::{exp2, log2, tan};
use crate::scene::error::SceneError;
use crate::scene::world::{
    Ball, Bsdf, Geometry, Lens, MadeOf, Mesh, Name, Passage, Punctual, Transform, World,
};

/// How much further than what the camera sees the origin may be: up to there it stays where the
/// scene has it.
const SLACK: f64 = 8.0;

/// The same relative to half of the height that the camera sees there, for those that look at
/// little from far off.
const SLACK_OF_VIEW: f64 = 64.0;

/// Where on the film the camera looks for the nearest thing that it sees, from -1 to 1.
const LOOKS: [[f64; 2]; 5] = [[0.0, 0.0], [-0.6, -0.6], [0.6, -0.6], [-0.6, 0.6], [0.6, 0.6]];

/// Most triangles that a look tries, about; of more it tries some.
const TRIED_MAX: usize = 1 << 20;

/// What world space is centered on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Center {
    /// The new origin.
    pub origin: DVec3,
    /// Coordinates that count as near: what the camera sees first is hardly farther from there.
    pub near: f32,
}

impl Center {
    /// Where the scene has it, with nothing to say what is far.
    const UNKNOWN: Self = Self { origin: DVec3::ZERO, near: f32::INFINITY };
}

/// A point that world space is centered on, for the precision of what the camera sees: the origin
/// of the scene where that is near.
///
/// # Errors
/// When it would be out of range.
pub fn center(world: &World) -> Result<Center, SceneError> {
    let cameras = world
        .in_order::<(&Name, &Transform, &Lens), _>(|(name, at, lens)| (name.clone(), *at, *lens));
    let Some((name, place, lens)) = cameras.into_iter().next() else { return Ok(Center::UNKNOWN) };
    let eye = place.0.translation;
    let (focus, distance) = match nearest_seen(world, &place, &lens) {
        Some(focus) => (focus, eye.distance(focus)),
        None => (eye, nearest_place(world, eye)),
    };
    check_range(focus, focus, &name.0)?;
    // In steps of a power of two, so that round coordinates stay round.
    let step = (SLACK * distance).min(SLACK_OF_VIEW * half_view(&lens, distance));
    let step = exp2(log2(step).ceil());
    let origin = (focus / step).round() * step;
    let is_known = origin.is_finite() && step > 0.0;
    Ok(if is_known { Center { origin, near: step as f32 } } else { Center::UNKNOWN })
}

/// Half the height of what the camera sees at a distance.
fn half_view(lens: &Lens, distance: f64) -> f64 {
    match *lens {
        Lens::Perspective { yfov, .. } => distance * tan(0.5 * yfov),
        Lens::Orthographic { half_height, .. } => f64::from(half_height),
    }
}

/// A ray in double precision; the direction has any length.
#[derive(Clone, Copy)]
struct Ray {
    origin: DVec3,
    direction: DVec3,
}

impl Ray {
    fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }

    /// The same in the space of a shape; distances along it stay the same.
    fn inside(&self, to_world: &DAffine3) -> Self {
        let to_shape = to_world.inverse();
        let origin = to_shape.transform_point3(self.origin);
        Self { origin, direction: to_shape.transform_vector3(self.direction) }
    }
}

/// The nearest point that the camera sees of anything but what light passes straight on.
fn nearest_seen(world: &World, place: &Transform, lens: &Lens) -> Option<DVec3> {
    let is_seen = |of: &MadeOf| {
        let bsdf = world.entities().get::<&Bsdf>(of.0);
        bsdf.is_ok_and(|bsdf| matches!(bsdf.passage(), Passage::Closed | Passage::Body))
    };
    let meshes = world.in_order::<(&Transform, &Mesh, &MadeOf), _>(|(at, mesh, of)| {
        is_seen(of).then(|| (at.0, Arc::clone(&mesh.0)))
    });
    let meshes: Vec<_> = meshes.into_iter().flatten().collect();
    let balls = world.in_order::<(&Transform, &Ball, &MadeOf), _>(|(at, ball, of)| {
        is_seen(of).then_some((at.0, ball.radius))
    });
    let mut boxes: HashMap<*const Geometry, [DVec3; 2]> = HashMap::new();
    for (_, mesh) in &meshes {
        boxes.entry(Arc::as_ptr(mesh)).or_insert_with(|| mesh.bounds());
    }
    let triangles: usize = meshes.iter().map(|(_, mesh)| mesh.triangles.len()).sum();
    let every = triangles.div_ceil(TRIED_MAX).max(1);
    let look = |film: [f64; 2]| {
        let ray = ray_of(place, lens, film);
        let of_meshes = meshes.iter().filter_map(|(to_world, mesh)| {
            let ray = ray.inside(to_world);
            let meets = meets_box(&ray, boxes[&Arc::as_ptr(mesh)]);
            meets.then(|| meet_mesh(&ray, mesh, every)).flatten()
        });
        let of_balls = balls
            .iter()
            .flatten()
            .filter_map(|(to_world, radius)| meet_ball(&ray.inside(to_world), *radius));
        let t = of_meshes.chain(of_balls).min_by(f64::total_cmp)?;
        Some(ray.at(t))
    };
    let seen = LOOKS.into_iter().filter_map(look);
    let eye = place.0.translation;
    seen.min_by(|a, b| eye.distance_squared(*a).total_cmp(&eye.distance_squared(*b)))
}

fn ray_of(Transform(place): &Transform, lens: &Lens, [x, y]: [f64; 2]) -> Ray {
    let [right, up, back] = [place.matrix3.x_axis, place.matrix3.y_axis, place.matrix3.z_axis]
        .map(|axis| axis.normalize_or_zero());
    match *lens {
        Lens::Perspective { yfov, aspect, .. } => {
            let half = tan(0.5 * yfov);
            let half_width = half * f64::from(aspect.unwrap_or(1.0));
            let direction = x * half_width * right + y * half * up - back;
            Ray { origin: place.translation, direction }
        }
        Lens::Orthographic { half_width, half_height } => {
            let aside = x * f64::from(half_width) * right + y * f64::from(half_height) * up;
            Ray { origin: place.translation + aside, direction: -back }
        }
    }
}

fn meets_box(ray: &Ray, [low, high]: [DVec3; 2]) -> bool {
    let [a, b] = [low, high].map(|corner| (corner - ray.origin) / ray.direction);
    // A ray within a face is not a number; the other axes decide then.
    let enters = a.min(b).to_array().into_iter().fold(0.0, f64::max);
    let leaves = a.max(b).to_array().into_iter().fold(f64::INFINITY, f64::min);
    enters <= leaves
}

/// Where a ray meets every so manieth triangle of a mesh (Moeller and Trumbore 1997).
fn meet_mesh(ray: &Ray, mesh: &Geometry, every: usize) -> Option<f64> {
    let meet = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|row| mesh.positions[row as usize].as_dvec3());
        let (ab, ac, from_a) = (b - a, c - a, ray.origin - a);
        let across = ray.direction.cross(ac);
        let scale = ab.dot(across).recip();
        let u = from_a.dot(across) * scale;
        let along = from_a.cross(ab);
        let v = ray.direction.dot(along) * scale;
        let t = ac.dot(along) * scale;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t.is_finite()).then_some(t)
    };
    mesh.triangles.iter().step_by(every).filter_map(meet).min_by(f64::total_cmp)
}

fn meet_ball(ray: &Ray, radius: f64) -> Option<f64> {
    let a = ray.direction.length_squared();
    let half_b = ray.origin.dot(ray.direction);
    let root = (half_b * half_b - a * (ray.origin.length_squared() - radius * radius)).sqrt();
    [-half_b - root, -half_b + root].into_iter().map(|t| t / a).find(|t| *t > 0.0)
}

/// The distance to the nearest of the centers of all shapes and lights, or one that is finite.
fn nearest_place(world: &World, eye: DVec3) -> f64 {
    let meshes = world.in_order::<(&Transform, &Mesh), _>(|(at, mesh)| {
        let [low, high] = mesh.0.bounds();
        at.0.transform_point3(0.5 * (low + high))
    });
    let others =
        world.in_order::<(&Transform, hecs::Or<&Ball, &Punctual>), _>(|(at, _)| at.0.translation);
    let distances = meshes.into_iter().chain(others).map(|center| center.distance(eye));
    distances.filter(|distance| *distance > 0.0).min_by(f64::total_cmp).unwrap_or(1.0)
}
