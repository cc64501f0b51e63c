//! Closed meshes are tight, also for rays aimed at edges and corners.

use glam::Vec3;
use sunstone::internals::geometry::{Accelerator, TraceScratch, trace_closest, trace_visibility};
use sunstone::internals::scene::baked::{NONE, Triangle};

use super::fixtures::{Random, closed_box, columns, icosphere, limits, no_hits};

/// Half of the rays aim at a corner, half at a point on an edge.
fn target(mesh: &[Triangle], random: &mut Random) -> Vec3 {
    let corners = mesh[random.below(mesh.len())].corners;
    let corner = random.below(3);
    if random.bits() & 1 == 0 {
        corners[corner]
    } else {
        corners[corner].lerp(corners[(corner + 1) % 3], random.uniform())
    }
}

/// None of a million rays from points `inside` may get out.
fn nothing_escapes(mesh: &[Triangle], inside: impl Fn(&mut Random) -> Vec3) {
    let mut random = Random(mesh.len() as u64);
    let accelerator = Accelerator::build(mesh, &[]);
    let count = 1_000_000;
    let ray = |_| {
        let origin = inside(&mut random);
        (origin, (target(mesh, &mut random) - origin).normalize())
    };
    let rays: Vec<_> = (0..count).map(ray).collect();
    let columns = columns(&rays);
    let mut hits = no_hits(count);
    trace_closest(&mut hits, &mut TraceScratch::default(), &columns, 0..count, &accelerator);
    let mut blocked = vec![0; count];
    let t_max = limits(count, f32::INFINITY);
    trace_visibility(
        &mut blocked,
        &mut TraceScratch::default(),
        &columns,
        &t_max,
        0..count,
        &accelerator,
    );
    for (row, &(origin, direction)) in rays.iter().enumerate() {
        assert_ne!(hits.primitive[row], NONE, "ray {row} escapes: {:?}", rays[row]);
        assert_ne!(blocked[row], 0, "ray {row} escapes: {:?}", rays[row]);
        if row % 10 == 0 {
            let single = accelerator.closest(origin, direction, f32::INFINITY);
            assert_eq!((single.t, single.primitive), (hits.t[row], hits.primitive[row]));
        }
    }
}

/// From outside, rays aimed at edges and corners meet them or something before them, but for the
/// silhouette, where they may pass by: what `is_inner` says of (target, origin).
fn nothing_is_missed(mesh: &[Triangle], distance: f32, is_inner: fn(Vec3, Vec3) -> bool) {
    let mut random = Random(mesh.len() as u64 + 1);
    let accelerator = Accelerator::build(mesh, &[]);
    let mut hits = 0;
    for _ in 0..100_000 {
        let origin = random.direction() * distance;
        let target = target(mesh, &mut random);
        let direction = (target - origin).normalize();
        let hit = accelerator.closest(origin, direction, f32::INFINITY);
        let to_target = (target - origin).length();
        if is_inner(target, origin) {
            assert!(hit.t <= to_target * 1.0001, "{origin} misses {target}: {hit:?}");
            hits += 1;
        }
    }
    assert!(hits > 10_000);
}

#[test]
fn icosphere_is_tight() {
    for levels in [0, 1, 3, 5] {
        nothing_escapes(&icosphere(levels), |random| random.in_cube() * 0.4);
    }
}

#[test]
fn far_icosphere_is_tight() {
    let moved =
        |t: Triangle| Triangle { corners: t.corners.map(|c| c + Vec3::new(1000.0, -300.0, 70.0)) };
    let mesh: Vec<_> = icosphere(3).into_iter().map(moved).collect();
    nothing_escapes(&mesh, |random| random.in_cube() * 0.4 + Vec3::new(1000.0, -300.0, 70.0));
}

#[test]
fn box_is_tight() {
    let unit = closed_box(Vec3::splat(-1.0), Vec3::splat(1.0));
    nothing_escapes(&unit, |random| random.in_cube() * 0.999);
    let odd = closed_box(Vec3::new(-0.3, -17.1, 2.7), Vec3::new(0.1, 3.3, 911.3));
    nothing_escapes(&odd, |random| Vec3::new(-0.1, -7.0, 400.0) + random.in_cube() * 0.1);
}

#[test]
fn subdivided_box_is_tight() {
    // Many boxes within one, so that the tree is deep.
    let mut mesh = closed_box(Vec3::splat(-1.0), Vec3::splat(1.0));
    for step in 1..40 {
        let low = Vec3::new(1.5 + step as f32 * 0.1, -1.0, -1.0);
        mesh.extend(closed_box(low, low + Vec3::new(0.05, 2.0, 2.0)));
    }
    nothing_escapes(&mesh, |random| random.in_cube() * 0.999);
}

#[test]
fn meshes_are_tight_from_outside() {
    let inner_of_sphere =
        |target: Vec3, origin: Vec3| target.normalize().dot((origin - target).normalize()) > 0.1;
    for distance in [1.5, 30.0] {
        nothing_is_missed(&icosphere(3), distance, inner_of_sphere);
    }
    // Inner where every face of the box that the target lies on is turned to the origin.
    let inner_of_box = |target: Vec3, origin: Vec3| {
        (0..3).all(|k| target[k].abs() < 0.5 || target[k] * origin[k] > 0.25)
    };
    let mesh = closed_box(Vec3::splat(-0.5), Vec3::splat(0.5));
    nothing_is_missed(&mesh, 10.0, inner_of_box);
}
