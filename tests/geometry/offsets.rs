//! Rays that leave a surface do not meet it again, and rays that arrive do not pass it.

use glam::Vec3;
use sunstone::internals::geometry::{Accelerator, SurfaceColumns, offset_origin, resolve_surfaces};
use sunstone::internals::geometry::{TraceScratch, trace_closest};
use sunstone::internals::math::Vector;
use sunstone::internals::scene::baked::{NONE, Sphere, Triangle};

use super::fixtures::{Random, closed_box, columns, cornell, no_hits, triangle};
use super::surfaces::scene_of;

fn vector(columns: &[Vec<f32>; 3], row: usize) -> Vec3 {
    Vec3::new(columns[0][row], columns[1][row], columns[2][row])
}

fn leave(position: Vec3, normal: Vec3, direction: Vec3, offset: f32) -> Vec3 {
    let [position, normal, direction] =
        [position, normal, direction].map(|v| Vector { x: v.x, y: v.y, z: v.z });
    let origin = offset_origin(position, normal, direction, offset);
    Vec3::new(origin.x, origin.y, origin.z)
}

/// Hits the one primitive from everywhere and leaves it in all directions.
fn no_self_intersection(triangles: &[Triangle], spheres: &[Sphere], random: &mut Random) {
    let scene = scene_of(triangles, spheres);
    let accelerator = Accelerator::build(triangles, spheres);
    let count = 64;
    let bounds = &scene.bounds;
    let ray = |_| {
        let target = match triangles.first() {
            Some(t) => {
                let (u, v) = (random.uniform(), random.uniform());
                t.corners[0]
                    + (t.corners[1] - t.corners[0]) * u * (1.0 - v)
                    + (t.corners[2] - t.corners[0]) * v
            }
            None => spheres[0].center + random.direction() * spheres[0].radius * 0.999,
        };
        let origin = target + random.direction() * bounds.radius * random.between(0.1, 3.0);
        (origin, (target - origin).normalize())
    };
    let rays: Vec<_> = (0..count).map(ray).collect();
    let (columns, mut hits) = (columns(&rays), no_hits(count));
    trace_closest(&mut hits, &mut TraceScratch::default(), &columns, 0..count, &accelerator);
    let mut surfaces = SurfaceColumns::new(count);
    resolve_surfaces(&mut surfaces, &hits, &columns, 0..count, &scene);
    for row in (0..count).filter(|&row| hits.primitive[row] != NONE) {
        let position = vector(&surfaces.position, row);
        let normal = vector(&surfaces.geometric_normal, row);
        let mut direction = random.direction();
        if row % 4 == 0 {
            // Nearly tangential.
            let lift = 10.0_f32.powf(random.between(-6.0, -1.0));
            direction = (direction.cross(normal).normalize() + normal * lift).normalize();
        }
        let outwards = triangles.is_empty() && normal.dot(direction) < 0.0;
        let direction = if outwards { -direction } else { direction };
        let origin = leave(position, normal, direction, surfaces.offset[row]);
        let hit = accelerator.closest(origin, direction, f32::INFINITY);
        assert_eq!(hit.primitive, NONE, "{triangles:?} {spheres:?} {origin} {direction} {hit:?}");
    }
}

#[test]
fn triangles_do_not_meet_themselves() {
    let mut random = Random(31);
    for _ in 0..3000 {
        let size = 10.0_f32.powf(random.between(-3.0, 4.0));
        let at = random.in_cube() * 10.0_f32.powf(random.between(-3.0, 4.0));
        let mut corner = || at + random.in_cube() * size;
        let triangle = triangle(corner(), corner(), corner());
        no_self_intersection(&[triangle], &[], &mut random);
    }
}

#[test]
fn spheres_do_not_meet_themselves() {
    let mut random = Random(32);
    for _ in 0..3000 {
        let radius = 10.0_f32.powf(random.between(-3.0, 4.0));
        // A sphere that its own coordinates cannot resolve is not tested.
        let far = random.between(-3.0, 4.0).min(radius.log10() + 3.0);
        let center = random.in_cube() * 10.0_f32.powf(far);
        no_self_intersection(&[], &[Sphere { center, radius }], &mut random);
    }
}

/// Walks of many bounces inside a closed room never get out.
fn walks_stay_inside(triangles: &[Triangle], spheres: &[Sphere], start: Vec3, scale: f32) -> usize {
    let scene = scene_of(triangles, spheres);
    let accelerator = Accelerator::build(triangles, spheres);
    let mut random = Random(33);
    let count = 20_000;
    let mut rays: Vec<_> = (0..count).map(|_| (start, random.direction())).collect();
    let mut escaped = 0;
    for _ in 0..10 {
        let (columns, mut hits) = (columns(&rays), no_hits(rays.len()));
        trace_closest(
            &mut hits,
            &mut TraceScratch::default(),
            &columns,
            0..rays.len(),
            &accelerator,
        );
        let mut surfaces = SurfaceColumns::new(rays.len());
        resolve_surfaces(&mut surfaces, &hits, &columns, 0..rays.len(), &scene);
        let mut next = Vec::new();
        for (row, &(_, arriving)) in rays.iter().enumerate() {
            let position = vector(&surfaces.position, row);
            if hits.primitive[row] == NONE || position.abs().max_element() > scale * 1.001 {
                escaped += 1;
                continue;
            }
            let normal = vector(&surfaces.geometric_normal, row);
            let facing = if normal.dot(arriving) > 0.0 { -normal } else { normal };
            let direction = random.direction();
            let direction = direction * direction.dot(facing).signum();
            next.push((leave(position, facing, direction, surfaces.offset[row]), direction));
        }
        rays = next;
    }
    escaped
}

#[test]
fn walks_do_not_leak() {
    for scale in [1e-3, 1.0, 1e4] {
        let mut room = closed_box(Vec3::splat(-scale), Vec3::splat(scale));
        room.extend(closed_box(Vec3::splat(-0.9 * scale), Vec3::splat(-0.3 * scale)));
        let (_, spheres) = cornell();
        let scaled = |s: &Sphere| Sphere { center: s.center * scale, radius: s.radius * scale };
        let spheres: Vec<_> = spheres.iter().map(scaled).collect();
        let escaped = walks_stay_inside(&room, &spheres, Vec3::Y * 0.5 * scale, scale);
        assert!(escaped <= 1, "{escaped} of 200,000 escaped at scale {scale}");
    }
}
