//! Closest hits and visibility against brute force.

use glam::Vec3;
use sunstone::internals::geometry::{
    Accelerator, Hit, RayColumns, SHORT_SCENE, TraceScratch, trace_closest, trace_visibility,
};
use sunstone::internals::scene::baked::{NONE, Sphere, Triangle};

use super::fixtures::{Random, columns, cornell, icosphere, limits, no_hits, quad, soup, triangle};

fn trace(accelerator: &Accelerator, rays: &RayColumns, count: usize) -> Vec<Hit> {
    let mut hits = no_hits(count);
    trace_closest(&mut hits, &mut TraceScratch::default(), rays, 0..count, accelerator);
    let hit = |row: usize| Hit {
        t: hits.t[row],
        u: hits.u[row],
        v: hits.v[row],
        primitive: hits.primitive[row],
    };
    (0..count).map(hit).collect()
}

/// Every ray against every primitive: short scenes one after the other, without any tree.
fn brute_force(
    triangles: &[Triangle],
    spheres: &[Sphere],
    rays: &RayColumns,
    count: usize,
) -> Vec<Hit> {
    let mut best = vec![Hit::MISS; count];
    let mut merge = |accelerator: &Accelerator, first: u32| {
        for (best, hit) in best.iter_mut().zip(trace(accelerator, rays, count)) {
            if hit.t < best.t {
                *best = Hit { primitive: hit.primitive + first, ..hit };
            }
        }
    };
    let mut first = 0;
    for some in triangles.chunks(SHORT_SCENE) {
        merge(&Accelerator::build(some, &[]), first);
        first += some.len() as u32;
    }
    for some in spheres.chunks(SHORT_SCENE) {
        merge(&Accelerator::build(&[], some), first);
        first += some.len() as u32;
    }
    best
}

/// All distances in double precision, by a different method, smallest first.
fn reference(triangles: &[Triangle], spheres: &[Sphere], o: Vec3, d: Vec3) -> Vec<(f64, u32)> {
    let (o, d) = (o.as_dvec3(), d.as_dvec3());
    let mut found = Vec::new();
    for (index, triangle) in triangles.iter().enumerate() {
        let [a, b, c] = triangle.corners.map(|corner| corner.as_dvec3());
        let (e1, e2, s) = (b - a, c - a, o - a);
        let p = d.cross(e2);
        let determinant = e1.dot(p);
        let (u, q) = (s.dot(p) / determinant, s.cross(e1));
        let (v, t) = (d.dot(q) / determinant, e2.dot(q) / determinant);
        if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 {
            found.push((t, index as u32));
        }
    }
    for (index, sphere) in spheres.iter().enumerate() {
        let f = o - sphere.center.as_dvec3();
        let (a, b) = (d.dot(d), f.dot(d));
        let discriminant = b * b - a * (f.dot(f) - f64::from(sphere.radius).powi(2));
        if discriminant >= 0.0 {
            let roots = [-b - discriminant.sqrt(), -b + discriminant.sqrt()];
            let positive = roots.into_iter().map(|root| root / a).find(|&t| t > 0.0);
            found.extend(positive.map(|t| (t, (triangles.len() + index) as u32)));
        }
    }
    found.sort_by(|a, b| a.partial_cmp(b).unwrap());
    found
}

/// Coherent rays (a pinhole), incoherent ones, some along the axes, some from far away.
fn mixed_rays(seed: u64, count: usize) -> Vec<(Vec3, Vec3)> {
    let mut random = Random(seed);
    let ray = |index: usize| match index % 5 {
        0 => {
            let (x, y) = (index as f32 / count as f32 - 0.5, random.between(-0.5, 0.5));
            (Vec3::new(0.1, 0.2, 3.0), Vec3::new(x, y, -1.0).normalize())
        }
        1 => {
            let mut direction = Vec3::ZERO;
            direction[random.below(3)] = if random.uniform() < 0.5 { -1.0 } else { 1.0 };
            (random.in_cube(), direction)
        }
        2 => (random.in_cube() * 2.0, random.direction() * random.between(0.1, 10.0)),
        3 => {
            // From far away, where the coordinates of the origin are coarse.
            let origin = random.direction() * 10.0_f32.powf(random.between(0.5, 4.0));
            (origin, (random.in_cube() - origin).normalize())
        }
        _ => (random.in_cube(), random.direction()),
    };
    (0..count).map(ray).collect()
}

#[test]
fn tree_equals_brute_force_bit_for_bit() {
    let mut scenes: Vec<_> = [(1, 1000, 100), (2, 300, 0), (3, 0, 300), (4, 40, 30)]
        .map(|(seed, triangles, spheres)| soup(seed, triangles, spheres))
        .into();
    // Bounds without thickness.
    let flat = |at: usize| {
        let (x, y) = ((at % 20) as f32 * 0.1 - 1.0, (at / 20) as f32 * 0.1 - 1.0);
        quad(Vec3::new(x, y, 0.3), Vec3::X * 0.1, Vec3::Y * 0.1)
    };
    scenes.push(((0..400).flat_map(flat).collect(), Vec::new()));
    scenes.push((icosphere(3), Vec::new()));
    for (seed, (triangles, spheres)) in scenes.into_iter().enumerate() {
        let seed = seed as u64;
        let accelerator = Accelerator::build(&triangles, &spheres);
        let rays = mixed_rays(seed, 10_000);
        let columns = columns(&rays);
        let hits = trace(&accelerator, &columns, rays.len());
        let expected = brute_force(&triangles, &spheres, &columns, rays.len());
        assert!(hits.iter().filter(|hit| hit.primitive != NONE).count() > 1000);
        for (row, (hit, expected)) in hits.iter().zip(&expected).enumerate() {
            assert_eq!(hit, expected, "seed {seed}, ray {row}: {:?}", rays[row]);
        }
    }
}

#[test]
fn short_scenes_equal_one_ray_at_a_time() {
    for (seed, triangles, spheres) in [(5, 0, 0), (6, 1, 0), (7, 0, 1), (8, 8, 8), (9, 31, 17)] {
        let (triangles, spheres) = soup(seed, triangles, spheres);
        let accelerator = Accelerator::build(&triangles, &spheres);
        let rays = mixed_rays(seed, 10_003);
        let hits = trace(&accelerator, &columns(&rays), rays.len());
        for (row, &(origin, direction)) in rays.iter().enumerate() {
            let expected = accelerator.closest(origin, direction, f32::INFINITY);
            assert_eq!(hits[row], expected, "seed {seed}, ray {row}");
        }
    }
}

#[test]
fn hits_agree_with_double_precision() {
    let (triangles, spheres) = soup(10, 200, 60);
    let accelerator = Accelerator::build(&triangles, &spheres);
    let rays = mixed_rays(10, 10_000);
    let mut differing = 0;
    for &(origin, direction) in &rays {
        let hit = accelerator.closest(origin, direction, f32::INFINITY);
        let expected = reference(&triangles, &spheres, origin, direction);
        let (t, primitive) = expected.first().copied().unwrap_or((f64::INFINITY, NONE));
        let close = hit.t == t as f32 || (f64::from(hit.t) - t).abs() < 2e-5 * t;
        differing += usize::from(!close || hit.primitive != primitive);
    }
    // Rays that graze an edge or a sphere may differ.
    assert!(differing <= 5, "{differing} of {} differ", rays.len());
}

#[test]
fn occluded_is_closest_below_t_max() {
    for (seed, triangles, spheres) in [(11, 500, 80), (12, 12, 2)] {
        let (triangles, spheres) = soup(seed, triangles, spheres);
        let accelerator = Accelerator::build(&triangles, &spheres);
        let rays = mixed_rays(seed, 10_001);
        let mut random = Random(seed);
        let mut t_max = limits(rays.len(), f32::INFINITY);
        for (row, &(origin, direction)) in rays.iter().enumerate() {
            let t = accelerator.closest(origin, direction, f32::INFINITY).t;
            // A third exactly at the hit, which does not count.
            let factor = [1.0, 1.0 + 1e-6, random.between(0.0, 2.0)][row % 3];
            t_max[row] = if t.is_finite() { t * factor } else { random.between(0.0, 5.0) };
        }
        let mut blocked = vec![7; rays.len()];
        let columns = columns(&rays);
        trace_visibility(
            &mut blocked,
            &mut TraceScratch::default(),
            &columns,
            &t_max,
            0..rays.len(),
            &accelerator,
        );
        for (row, &(origin, direction)) in rays.iter().enumerate() {
            let limit = t_max[row];
            let expected = accelerator.closest(origin, direction, f32::INFINITY).t < limit;
            assert_eq!(accelerator.occluded(origin, direction, limit), expected, "ray {row}");
            assert_eq!(blocked[row], if expected { u32::MAX } else { 0 }, "ray {row}");
            let limited = accelerator.closest(origin, direction, limit);
            assert_eq!(limited.primitive != NONE, expected, "ray {row}");
        }
    }
}

#[test]
fn a_range_leaves_the_other_rows_alone() {
    for (triangles, spheres) in [cornell(), (icosphere(2), Vec::new())] {
        let accelerator = Accelerator::build(&triangles, &spheres);
        let rays = mixed_rays(13, 50);
        let mut hits = no_hits(50);
        hits.t.fill(-1.0);
        let mut blocked = vec![7; 50];
        trace_closest(
            &mut hits,
            &mut TraceScratch::default(),
            &columns(&rays),
            11..30,
            &accelerator,
        );
        let t_max = limits(50, 9.0);
        trace_visibility(
            &mut blocked,
            &mut TraceScratch::default(),
            &columns(&rays),
            &t_max,
            11..30,
            &accelerator,
        );
        for (row, &blocked) in blocked.iter().enumerate() {
            assert_eq!(hits.t[row] == -1.0, !(11..30).contains(&row));
            assert_eq!(blocked == 7, !(11..30).contains(&row));
        }
    }
}

#[test]
fn ties_go_to_the_smaller_primitive() {
    // Twenty times the same square, among others that make a tree necessary.
    let square = quad(Vec3::new(-1.0, -1.0, 0.0), Vec3::X * 2.0, Vec3::Y * 2.0);
    let (soup, _) = soup(14, 200, 0);
    let away = |t: &Triangle| Triangle { corners: t.corners.map(|c| c + Vec3::Z * 9.0) };
    let mut triangles: Vec<_> = soup.iter().map(away).collect();
    for _ in 0..20 {
        triangles.extend(square);
    }
    let accelerator = Accelerator::build(&triangles, &[]);
    let mut random = Random(14);
    for _ in 0..1000 {
        let target = Vec3::new(random.between(-0.9, 0.9), random.between(-0.9, 0.9), 0.0);
        let origin = Vec3::new(0.1, 0.2, -3.0);
        let hit = accelerator.closest(origin, target - origin, 1e9);
        assert!(hit.primitive == 200 || hit.primitive == 201, "{hit:?}");
    }
}

#[test]
fn nothing_is_hit_in_an_empty_scene() {
    let accelerator = Accelerator::build(&[], &[]);
    assert_eq!(accelerator.closest(Vec3::ZERO, Vec3::X, f32::INFINITY), Hit::MISS);
    assert!(!accelerator.occluded(Vec3::ZERO, Vec3::X, f32::INFINITY));
    assert_eq!(trace(&accelerator, &columns(&[(Vec3::ZERO, Vec3::X)]), 1), [Hit::MISS]);
}

#[test]
fn degenerate_triangles_are_never_hit() {
    let point = triangle(Vec3::ONE, Vec3::ONE, Vec3::ONE);
    let line = triangle(Vec3::ZERO, Vec3::X, Vec3::X * 2.0);
    let triangles: Vec<_> = (0..60).flat_map(|_| [point, line]).collect();
    let accelerator = Accelerator::build(&triangles, &[]);
    for (origin, direction) in mixed_rays(15, 1000) {
        assert_eq!(accelerator.closest(origin, direction, f32::INFINITY), Hit::MISS);
    }
    assert_eq!(accelerator.closest(Vec3::ZERO, Vec3::ONE, f32::INFINITY), Hit::MISS);
}

#[test]
fn zero_components_and_faces_of_bounds_do_no_harm() {
    // A grid of squares in z = 0 and rays within the planes of their bounds.
    let mut triangles = Vec::new();
    for x in 0..16 {
        for y in 0..16 {
            triangles.extend(quad(Vec3::new(x as f32, y as f32, 0.0), Vec3::X, Vec3::Y));
        }
    }
    let accelerator = Accelerator::build(&triangles, &[]);
    for zero in [0.0, -0.0_f32] {
        for step in 0..=64 {
            for other in [0.0, 1.0, 5.25, 16.0] {
                let origin = Vec3::new(step as f32 * 0.25, other, 2.0);
                let hit = accelerator.closest(origin, Vec3::new(zero, zero, -1.0), 9.0);
                assert_eq!(hit.t, 2.0, "{origin}");
                let hit = accelerator.closest(origin * Vec3::new(1., 1., -1.), Vec3::Z, 9.0);
                assert_eq!(hit.t, 2.0, "{origin}");
            }
        }
    }
    // In the plane itself there is nothing to hit, and nothing to trip over.
    let within = accelerator.closest(Vec3::new(-1.0, 3.0, 0.0), Vec3::X, f32::INFINITY);
    assert!(within.primitive == NONE || within.t.is_finite());
    assert!(!accelerator.occluded(Vec3::new(0.0, 0.0, 1.0), Vec3::new(1.0, 0.0, -0.0), 1e9));
}

#[test]
fn scale_does_not_matter() {
    let (triangles, spheres) = soup(16, 200, 50);
    let rays = mixed_rays(16, 2000);
    let accelerator = Accelerator::build(&triangles, &spheres);
    for scale in [2.0_f32.powi(-20), 2.0_f32.powi(10), 2.0_f32.powi(28)] {
        let large = |t: &Triangle| Triangle { corners: t.corners.map(|c| c * scale) };
        let triangles: Vec<_> = triangles.iter().map(large).collect();
        let larger = |s: &Sphere| Sphere { center: s.center * scale, radius: s.radius * scale };
        let spheres: Vec<_> = spheres.iter().map(larger).collect();
        let scaled = Accelerator::build(&triangles, &spheres);
        for &(origin, direction) in &rays {
            let expected = accelerator.closest(origin, direction, f32::INFINITY);
            let hit = scaled.closest(origin * scale, direction, f32::INFINITY);
            assert_eq!(hit, Hit { t: expected.t * scale, ..expected }, "scale {scale}");
        }
    }
}

#[test]
fn spheres_from_inside_and_from_their_surface() {
    let mut random = Random(17);
    for _ in 0..20_000 {
        let radius = 10.0_f32.powf(random.between(-3.0, 3.0));
        let center = random.in_cube() * radius * random.between(0.0, 50.0);
        let accelerator = Accelerator::build(&[], &[Sphere { center, radius }]);
        let (normal, direction) = (random.direction(), random.direction());
        let inside = center + normal * radius * random.between(0.0, 0.9);
        let hit = accelerator.closest(inside, direction, f32::INFINITY);
        let distance = (inside + direction * hit.t - center).length();
        assert!((distance - radius).abs() < 2e-4 * radius, "{distance} {radius}");
        let off = 1e-5 * (radius + center.length());
        let outside = center + normal * (radius + off);
        if normal.dot(direction) > 1e-2 {
            assert!(!accelerator.occluded(outside, direction, f32::INFINITY));
        }
    }
}

#[test]
fn eight_of_a_kind_have_no_nodes() {
    for (triangles, spheres) in [(8, 0), (1, 0), (0, 8)] {
        let (triangles, spheres) = soup(18, triangles, spheres);
        let statistics = Accelerator::build(&triangles, &spheres).statistics();
        let blocks = statistics.triangle_blocks + statistics.sphere_blocks;
        assert_eq!((statistics.nodes, blocks, statistics.depth), (0, 1, 0));
    }
}

/// Bundles of rays from about one point in about one direction, narrow and wide ones.
fn bundles(seed: u64, count: usize) -> Vec<(Vec3, Vec3)> {
    let mut random = Random(seed);
    let mut rays = Vec::new();
    while rays.len() < count {
        let (origin, direction) = (random.in_cube() * 1.5, random.direction());
        let (apart, wide) = (random.between(0.0, 0.03), random.between(0.0, 0.15));
        for _ in 0..8 + random.below(30) {
            let direction = (direction + random.in_cube() * wide).normalize();
            rays.push((origin + random.in_cube() * apart, direction));
        }
    }
    rays
}

#[test]
fn rays_that_run_alike_find_what_each_would_alone() {
    let scenes = [soup(20, 3_000, 200), soup(21, 60, 30), (icosphere(5), Vec::new())];
    for (seed, (triangles, spheres)) in scenes.into_iter().enumerate() {
        equals_one_at_a_time(&triangles, &spheres, &bundles(seed as u64, 10_003));
    }
}

/// So large that several rays are on their way at once.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn rays_through_a_large_tree_find_what_each_would_alone() {
    let mesh = icosphere(8);
    let bytes = Accelerator::build(&mesh, &[]).statistics().bytes;
    assert!(bytes > 64 << 20, "{bytes}");
    let rays: Vec<_> = [bundles(3, 1_000), mixed_rays(22, 4_003)].concat();
    equals_one_at_a_time(&mesh, &[], &rays);
}

fn equals_one_at_a_time(triangles: &[Triangle], spheres: &[Sphere], rays: &[(Vec3, Vec3)]) {
    let accelerator = Accelerator::build(triangles, spheres);
    let columns = columns(rays);
    let hits = trace(&accelerator, &columns, rays.len());
    let mut random = Random(rays.len() as u64);
    let t_max: Vec<f32> =
        limits(rays.len(), 1.0).iter().map(|_| random.between(0.0, 3.0)).collect();
    let mut blocked = vec![7; rays.len()];
    trace_visibility(
        &mut blocked,
        &mut TraceScratch::default(),
        &columns,
        &t_max,
        0..rays.len(),
        &accelerator,
    );
    assert!(hits.iter().any(|hit| hit.primitive != NONE));
    for (row, &(origin, direction)) in rays.iter().enumerate() {
        let alone = accelerator.closest(origin, direction, f32::INFINITY);
        assert_eq!(hits[row], alone, "ray {row}: {:?}", rays[row]);
        let is_blocked = accelerator.occluded(origin, direction, t_max[row]);
        assert_eq!(blocked[row], if is_blocked { u32::MAX } else { 0 }, "ray {row}");
    }
}

#[test]
fn building_twice_gives_the_same_bits() {
    let (triangles, spheres) = soup(19, 20_000, 500);
    let accelerator = Accelerator::build(&triangles, &spheres);
    assert!(accelerator == Accelerator::build(&triangles, &spheres));
    let statistics = accelerator.statistics();
    assert_eq!((statistics.triangles, statistics.spheres), (20_000, 500));
    assert!(statistics.triangle_blocks < 20_000 / 3, "{statistics:?}");
}

#[test]
fn threads_do_not_change_the_tree() {
    let (triangles, spheres) = soup(23, 60_000, 500);
    let build = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Accelerator::build(&triangles, &spheres))
    };
    let alone = build(1);
    for threads in [2, 3, 8] {
        assert!(alone == build(threads), "{threads} threads");
    }
}
