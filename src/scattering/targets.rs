//! What matters to light paths in a scene: what the camera sees, by some of its rays, and the
//! surfaces that leave light a single way, as balls. A function of the scene, the camera and the
//! film's size alone.

use glam::Vec3;

use super::emitter::aim::{GAIN_MIN, Target, Targets};
use super::immersion::{STEPS, spread};
use super::look::first_met;
use super::{Scene, Sensor};
use crate::geometry::offset_distance;
use crate::math::F32s;
use crate::scene::baked::{Bounds, NONE};

/// Camera rays along an edge of the film.
const RAYS: usize = 16;
/// Mirrors and panes on the way of a camera ray, and all that it passes.
const PASSED_MAX: usize = 16;
const STEPS_MAX: usize = 4096;
/// Parts of what the camera sees, the nearest to its middle first, that have a ball each, so that
/// what is seen from close by, and far away things on few pixels, get as many paths for a pixel.
const PARTS: [f32; 3] = [0.5, 0.9, 1.0];
/// How much larger those balls are than what the rays have found of them: what lies between two
/// rays belongs to it too.
const BETWEEN: f32 = 1.0 + 2.0 / RAYS as f32;
/// Most balls about surfaces that leave light a single way.
const BODIES_MAX: usize = 12;
/// The least radius of a ball, relative to the scene: positions have to be more exact than it.
const RADIUS_MIN: f32 = 1e-5;
/// The weights of what the camera sees, of what leaves light a single way, which only light paths
/// find light by, and of what is around.
const WEIGHT_OF_VIEW: f32 = 1.0;
const WEIGHT_OF_BODIES: f32 = 2.0;
const WEIGHT_OF_SURROUNDINGS: f32 = 0.5;
/// Balls about what the camera sees, each so many times as large as the one before.
const STEP_AROUND: f32 = 4.0;
const AROUND_MAX: usize = 8;

/// What light paths are to be aimed at; nothing where what matters is all of the scene.
pub fn targets<const N: usize>(scene: &Scene<N>) -> Targets {
    let whole = scene.shapes.bounds;
    let is_small = |ball: &Bounds| GAIN_MIN * ball.radius.powi(2) < whole.radius.powi(2);
    let least = RADIUS_MIN * whole.radius;
    // From the start: the camera may see a single point, and what is beside a ball without an
    // extent is neither near nor far.
    let extended = |balls: Vec<Bounds>| -> Vec<Bounds> {
        let balls = balls.into_iter();
        balls.map(|ball| Bounds { radius: ball.radius.max(least), ..ball }).collect()
    };
    let seen = points_seen(scene);
    let view = extended(balls_of_parts(seen.iter().map(|(point, _)| *point).collect()));
    let near: Vec<Bounds> = view.iter().copied().filter(is_small).collect();
    let mut bodies = clusters(&extended(specular_bodies(scene)), view.first());
    bodies.retain(|ball| is_small(ball) && !near.iter().any(|of_view| holds(ball, of_view)));
    let mut by_way_of = extended(balls_of_parts(points_by_way_of(scene, &seen)));
    by_way_of.retain(|ball| is_small(ball) && !bodies.iter().any(|body| holds(body, ball)));
    bodies.extend(by_way_of);
    let around = around(near.last(), is_small);
    let shared = |balls: Vec<Bounds>, weight: f32| {
        let worths: Vec<f32> = balls.iter().map(|ball| worth(ball, view.first())).collect();
        let share = weight / worths.iter().sum::<f32>();
        let targets = balls.into_iter().zip(worths);
        targets.map(move |(ball, worth)| Target { ball, weight: share * worth })
    };
    let sees_little = !near.is_empty();
    let all = shared(near, WEIGHT_OF_VIEW)
        .chain(shared(bodies, WEIGHT_OF_BODIES))
        .chain(shared(around, WEIGHT_OF_SURROUNDINGS))
        .collect();
    Targets { all, sees_little }
}

/// Larger and larger balls about what the camera sees: light that is scattered towards it from
/// afar falls off with the square of the distance, and so may the density of paths, but no faster.
fn around(view: Option<&Bounds>, is_small: impl Fn(&Bounds) -> bool) -> Vec<Bounds> {
    let larger = |ball: &Bounds| Bounds { radius: STEP_AROUND * ball.radius, ..*ball };
    let all = std::iter::successors(view.map(larger), |ball| Some(larger(ball)));
    all.take_while(is_small).take(AROUND_MAX).collect()
}

/// Balls about parts of some points, the smallest first.
fn balls_of_parts(mut points: Vec<Vec3>) -> Vec<Bounds> {
    let Some(middle) = middle(&points) else { return Vec::new() };
    points.sort_by(|a, b| a.distance_squared(middle).total_cmp(&b.distance_squared(middle)));
    let mut balls: Vec<Bounds> = Vec::new();
    for part in PARTS {
        let count = (part * points.len() as f32).ceil() as usize;
        let ball = ball_about(points[..count].iter().map(|&center| Bounds { center, radius: 0.0 }));
        let ball = Bounds { radius: BETWEEN * ball.radius, ..ball };
        // Of two that are about the same, the larger one.
        if balls.last().is_some_and(|last| ball.radius.powi(2) < 2.0 * last.radius.powi(2)) {
            balls.pop();
        }
        balls.push(ball);
    }
    balls
}

/// The median of each coordinate.
fn middle(points: &[Vec3]) -> Option<Vec3> {
    let median = |axis: usize| {
        let mut all: Vec<f32> = points.iter().map(|point| point[axis]).collect();
        all.sort_by(f32::total_cmp);
        all[all.len() / 2]
    };
    (!points.is_empty()).then(|| Vec3::new(median(0), median(1), median(2)))
}

/// Points on what scatters light that the camera's rays end at, straight or by way of mirrors and
/// glass, with the normals there, to the side they come from.
fn points_seen<const N: usize>(scene: &Scene<N>) -> Vec<(Vec3, Vec3)> {
    let sensor: &Sensor = &scene.sensor;
    let at =
        |index: usize, edge: u32| F32s::splat((index as f32 + 0.5) / RAYS as f32 * edge as f32);
    let seen = |pixel: usize| {
        let film = [at(pixel % RAYS, sensor.width), at(pixel / RAYS, sensor.height)];
        let (origin, direction, _) = sensor.rays(film, || [F32s::splat(0.5); 2]);
        let [origin, direction] = [origin, direction].map(|it| Vec3::from(it.to_rows()[0]));
        end_of_ray(scene, origin, direction)
    };
    (0..RAYS * RAYS).filter_map(seen).collect()
}

/// Where a ray ends that mirrors reflect, and that goes straight on through glass, as if that were
/// thin.
fn end_of_ray<const N: usize>(
    scene: &Scene<N>,
    mut origin: Vec3,
    mut direction: Vec3,
) -> Option<(Vec3, Vec3)> {
    let mut hit = scene.accelerator.closest(origin, direction, f32::INFINITY);
    let mut passed = 0;
    for _ in 0..STEPS_MAX {
        if hit.primitive == NONE || passed == PASSED_MAX {
            return None;
        }
        let kind = scene.material_at(hit.primitive).kind;
        let point = origin + hit.t * direction;
        let normal = scene.shapes.geometric_normal(hit.primitive, point);
        let normal = -direction.dot(normal).signum() * normal;
        if !kind.is_specular() && !kind.is_straight_on() {
            return Some((point, normal));
        }
        passed += usize::from(kind.is_specular());
        let surface = scene.shapes.surface_of(hit.primitive);
        if scene.shapes.surfaces[surface as usize].is_opaque {
            direction -= 2.0 * direction.dot(normal) * normal;
            origin = off(point, normal);
            hit = scene.accelerator.closest(origin, direction, f32::INFINITY);
        } else {
            hit = scene.accelerator.next(origin, direction, hit);
        }
    }
    None
}

/// Points of mirrors and glass that others see first, by rays in all directions by their cosine:
/// light comes that way to what a large one is before.
fn points_by_way_of<const N: usize>(scene: &Scene<N>, seen: &[(Vec3, Vec3)]) -> Vec<Vec3> {
    if !scene.has_specular_surfaces() {
        return Vec::new();
    }
    let kind_of = |primitive: u32| scene.material_at(primitive).kind;
    let passes =
        |primitive: u32| kind_of(primitive).is_straight_on() && !kind_of(primitive).is_specular();
    let directions: Vec<Vec3> = spread(RAYS * RAYS).collect();
    let point = |(index, (point, normal)): (usize, &(Vec3, Vec3))| {
        // In another order than that of the points.
        let about = directions[index * 197 % directions.len()];
        let (origin, direction) = (off(*point, *normal), (about + *normal).try_normalize()?);
        let met = first_met(scene, origin, direction, passes);
        let is_it = met.primitive != NONE && kind_of(met.primitive).is_specular();
        is_it.then(|| origin + met.t * direction)
    };
    seen.iter().enumerate().filter_map(point).collect()
}

/// Just before a surface.
fn off(point: Vec3, normal: Vec3) -> Vec3 {
    point + STEPS * offset_distance(point.abs().max_element()) * normal
}

/// Balls about the surfaces that leave light a single way, a ball each.
fn specular_bodies<const N: usize>(scene: &Scene<N>) -> Vec<Bounds> {
    let (shapes, materials) = (&scene.shapes, scene.surfaces.materials());
    let is_specular = |surface: u32| {
        let material = shapes.surfaces[surface as usize].material;
        materials[material as usize].kind.is_specular()
    };
    let own = shapes.triangles.len();
    let mut balls: Vec<Bounds> = Vec::new();
    let mut boxes: Vec<Option<[Vec3; 2]>> = vec![None; shapes.surfaces.len()];
    for (primitive, &surface) in shapes.surface_of_primitive.iter().enumerate() {
        if !is_specular(surface) {
            continue;
        }
        match primitive.checked_sub(own) {
            Some(row) => {
                let sphere = shapes.spheres[row];
                balls.push(Bounds { center: sphere.center, radius: sphere.radius });
            }
            None => grow(&mut boxes[surface as usize], &shapes.triangles[primitive].corners),
        }
    }
    for instance in shapes.instanced.instances() {
        if is_specular(instance.surface) {
            grow(&mut boxes[instance.surface as usize], &instance.bounds);
        }
    }
    let about = |[low, high]: [Vec3; 2]| Bounds {
        center: 0.5 * (low + high),
        radius: 0.5 * (high - low).length(),
    };
    balls.extend(boxes.into_iter().flatten().map(about));
    balls
}

fn grow(around: &mut Option<[Vec3; 2]>, points: &[Vec3]) {
    for &point in points {
        let [low, high] = around.unwrap_or([point; 2]);
        *around = Some([low.min(point), high.max(point)]);
    }
}

/// Few balls about many: as long as some are far apart in one, the one that is worth most for its
/// size is parted.
fn clusters(balls: &[Bounds], seen: Option<&Bounds>) -> Vec<Bounds> {
    if balls.is_empty() {
        return Vec::new();
    }
    let mut groups: Vec<(Bounds, Vec<Bounds>)> =
        vec![(ball_about(balls.iter().copied()), balls.to_vec())];
    let cost = |(about, members): &(Bounds, Vec<Bounds>)| {
        let largest = members.iter().fold(0.0, |largest: f32, of| largest.max(of.radius));
        let is_apart = about.radius > 2.0 * largest;
        if is_apart { worth(about, seen) * about.radius.powi(2) } else { 0.0 }
    };
    while groups.len() < BODIES_MAX {
        let costs = groups.iter().map(cost).enumerate();
        let (index, most) = costs.fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
        if most == 0.0 {
            break;
        }
        let (about, members) = groups.swap_remove(index);
        for part in parted(about, members) {
            groups.push((ball_about(part.iter().copied()), part));
        }
    }
    groups.into_iter().map(|(about, _)| about).collect()
}

/// The members on both sides of the middle of a ball, across their longest extent.
fn parted(about: Bounds, members: Vec<Bounds>) -> [Vec<Bounds>; 2] {
    let mut extent = None;
    members.iter().for_each(|member| grow(&mut extent, &[member.center]));
    let [low, high] = extent.unwrap_or([about.center; 2]);
    let axis = (high - low).max_position();
    let middle = 0.5 * (low + high)[axis];
    let (a, b) = members.into_iter().partition(|member| member.center[axis] < middle);
    [a, b]
}

/// A ball about others.
fn ball_about(balls: impl Iterator<Item = Bounds> + Clone) -> Bounds {
    let mut extent = None;
    balls.clone().for_each(|it| grow(&mut extent, &[it.center - it.radius, it.center + it.radius]));
    let [low, high] = extent.unwrap_or([Vec3::ZERO; 2]);
    let center = 0.5 * (low + high);
    let radius =
        balls.fold(0.0, |radius: f32, it| radius.max(it.center.distance(center) + it.radius));
    Bounds { center, radius }
}

/// What light from a body is worth to the camera: falls off with the square of its distance from
/// what is seen.
fn worth(body: &Bounds, seen: Option<&Bounds>) -> f32 {
    let Some(seen) = seen else { return 1.0 };
    let gap = body.center.distance(seen.center) - body.radius - seen.radius;
    let distance = gap.max(0.0) / (seen.radius + body.radius);
    1.0 / (1.0 + distance * distance)
}

/// Whether a ball is all in another.
fn holds(outer: &Bounds, inner: &Bounds) -> bool {
    outer.center.distance(inner.center) + inner.radius <= outer.radius
}
