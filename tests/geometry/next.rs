//! All that a ray meets, one after the other, and visibility past some of it.

use glam::Vec3;
use sunstone::internals::geometry::{
    Accelerator, CROSSES, Hit, HitColumns, TraceScratch, trace_next, trace_visibility_past,
};
use sunstone::internals::scene::baked::{NONE, Sphere, Triangle};

use super::fixtures::{Random, columns, limits, quad, soup};

/// Where a ray meets one primitive alone, which is in the scene by the number `primitive`.
fn alone(accelerator: &Accelerator, [o, d]: [Vec3; 2], primitive: u32) -> Vec<(f32, u32)> {
    let mut hit = accelerator.closest(o, d, f32::INFINITY);
    let mut found = Vec::new();
    while hit.primitive != NONE {
        found.push((hit.t, primitive));
        hit = accelerator.next(o, d, hit);
    }
    found
}

/// Primitive by primitive, sorted.
fn brute_force(triangles: &[Triangle], spheres: &[Sphere], ray: [Vec3; 2]) -> Vec<(f32, u32)> {
    let of_triangles = triangles.iter().map(|it| Accelerator::build(&[*it], &[]));
    let of_spheres = spheres.iter().map(|it| Accelerator::build(&[], &[*it]));
    let each = of_triangles.chain(of_spheres).zip(0..);
    let mut found: Vec<(f32, u32)> =
        each.flat_map(|(accelerator, primitive)| alone(&accelerator, ray, primitive)).collect();
    found.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
    found
}

fn one_after_the_other(accelerator: &Accelerator, [o, d]: [Vec3; 2]) -> Vec<(f32, u32)> {
    let start = Hit { t: 0.0, ..Hit::MISS };
    let hits = std::iter::successors(Some(start), |hit| Some(accelerator.next(o, d, *hit)));
    let hits = hits.skip(1).take_while(|hit| hit.primitive != NONE);
    hits.map(|hit| (hit.t, hit.primitive)).collect()
}

/// All rays at once, as columns, each until it meets nothing more.
fn side_by_side(accelerator: &Accelerator, rays: &[[Vec3; 2]]) -> Vec<Vec<(f32, u32)>> {
    let pairs: Vec<(Vec3, Vec3)> = rays.iter().map(|&[o, d]| (o, d)).collect();
    let (columns, t_max) = (columns(&pairs), limits(rays.len(), f32::INFINITY));
    let mut hits = HitColumns::new(rays.len());
    hits.t.fill(0.0);
    let mut found = vec![Vec::new(); rays.len()];
    loop {
        let scratch = &mut TraceScratch::default();
        trace_next(&mut hits, scratch, &columns, &t_max, 0..rays.len(), accelerator);
        let mut is_over = true;
        for (row, found) in found.iter_mut().enumerate() {
            if hits.primitive[row] != NONE {
                found.push((hits.t[row], hits.primitive[row]));
                is_over = false;
            }
        }
        if is_over {
            return found;
        }
    }
}

fn rays(random: &mut Random, count: usize) -> Vec<[Vec3; 2]> {
    let ray = |_| {
        let origin = random.in_cube() * 2.0;
        [origin, (random.in_cube() * 0.7 - origin).normalize()]
    };
    (0..count).map(ray).collect()
}

/// With duplicates: what lies in one place is met one after the other, too.
#[test]
fn hits_come_in_order_and_none_is_left_out() {
    let mut random = Random(51);
    for (count_of_triangles, count_of_spheres) in [(3, 0), (0, 5), (20, 10), (300, 60)] {
        let (mut triangles, mut spheres) = soup(7, count_of_triangles, count_of_spheres);
        triangles.extend_from_within(..count_of_triangles / 3);
        spheres.extend_from_within(..count_of_spheres / 3);
        triangles.extend(quad(Vec3::new(-1.0, 0.1, -1.0), Vec3::X * 2.0, Vec3::Z * 2.0));
        let accelerator = Accelerator::build(&triangles, &spheres);
        let mut met = 0;
        let rays = rays(&mut random, 101);
        for (ray, found) in rays.iter().zip(side_by_side(&accelerator, &rays)) {
            let expected = brute_force(&triangles, &spheres, *ray);
            assert_eq!(one_after_the_other(&accelerator, *ray), expected, "{ray:?}");
            assert_eq!(found, expected, "{ray:?}");
            met += expected.len();
        }
        assert!(met > 20, "only {met} hits");
    }
}

/// Of every three primitives, one lets rays pass.
#[test]
fn visibility_past_some_is_what_all_hits_say() {
    let passes = |primitive: u32| primitive.is_multiple_of(3);
    let mut random = Random(52);
    for (count_of_triangles, count_of_spheres) in [(12, 6), (200, 40)] {
        let (triangles, spheres) = soup(8, count_of_triangles, count_of_spheres);
        let accelerator = Accelerator::build(&triangles, &spheres);
        let rays = rays(&mut random, 4000);
        let pairs: Vec<(Vec3, Vec3)> = rays.iter().map(|&[o, d]| (o, d)).collect();
        let t_max = limits(rays.len(), 0.7);
        let mut blocked = vec![7; rays.len() + 8];
        let (columns, scratch) = (columns(&pairs), &mut TraceScratch::default());
        let rows = 0..rays.len();
        trace_visibility_past(
            &mut blocked,
            scratch,
            (&columns, &t_max),
            rows,
            &accelerator,
            &passes,
        );
        let mut counts = [0; 3];
        for (&ray, &found) in rays.iter().zip(&blocked) {
            let mut met = one_after_the_other(&accelerator, ray);
            met.retain(|(t, _)| *t < 0.7);
            let expected = match met.iter().all(|&(_, primitive)| passes(primitive)) {
                true if met.is_empty() => 0,
                true => CROSSES,
                false => u32::MAX,
            };
            assert_eq!(found, expected, "{ray:?}: {met:?}");
            counts[expected.min(2) as usize] += 1;
        }
        assert!(counts.iter().all(|count| *count > 5), "{counts:?}");
    }
}
