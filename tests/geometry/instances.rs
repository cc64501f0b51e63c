//! Instances against the same triangles one by one.

use glam::{Affine3A, Mat3, Quat, Vec3};
use sunstone::internals::geometry::{
    Accelerator, RayColumns, SurfaceColumns, TraceScratch, offset_origin, resolve_surfaces,
    trace_closest, trace_visibility,
};
use sunstone::internals::math::{LANES, Vector};
use sunstone::internals::scene::baked::{NONE, Shapes, Sphere, Triangle};
use sunstone::internals::scene::corners::Corners;
use sunstone::internals::scene::instanced::{Instance, Instanced, Object};

use super::fixtures::{Random, closed_box, columns, icosphere, limits, no_hits, soup};
use super::surfaces::scene_of;

/// A place that stretches by up to 4 and may mirror; `spread` is the size of the scene.
fn place(random: &mut Random, spread: f32) -> Affine3A {
    let size = spread * random.between(0.05, 0.2);
    let mut scale = Vec3::splat(size);
    if random.bits() & 1 == 0 {
        scale *= Vec3::new(random.between(1.0, 4.0), random.between(1.0, 4.0), 1.0);
    }
    if random.bits() & 1 == 0 {
        scale.x = -scale.x;
    }
    let turn = Quat::from_axis_angle(random.direction(), random.between(0.0, 6.0));
    let linear = Mat3::from_quat(turn) * Mat3::from_diagonal(scale);
    Affine3A::from_mat3_translation(linear, random.in_cube() * spread)
}

fn add(to: &mut Instanced, object: u32, to_world: Affine3A) {
    let corners = to.objects()[object as usize].triangles.iter().flat_map(|t| t.corners);
    let corners = corners.map(|corner| to_world.transform_point3(corner));
    let bounds = corners.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], corner| {
        [low.min(corner), high.max(corner)]
    });
    let to_object = to_world.matrix3.inverse();
    let instance = Instance { object, surface: 0, first_primitive: 0, to_world, to_object, bounds };
    assert!(to.add_instance(instance));
}

fn object(triangles: Vec<Triangle>, is_smooth: bool) -> Object {
    // Those of a sphere: the corners themselves.
    let normals = |t: &Triangle| t.corners.map(Vec3::normalize);
    let shading_normals = if is_smooth { triangles.iter().map(normals).collect() } else { vec![] };
    Object { triangles, shading_normals, corners: Corners::default() }
}

/// Two kinds of objects in forty places, among triangles and spheres, and the same scene with
/// copies in the instances' place. Copies of instances come in order, behind the triangles.
struct Pair {
    instanced: Shapes,
    copied: Shapes,
    /// Of every copied triangle, its name in the instanced scene.
    name_of_copy: Vec<u32>,
}

fn pair(seed: u64, spread: f32, is_smooth: bool) -> Pair {
    let mut random = Random(seed);
    let (triangles, spheres) = soup(seed, 30, 10);
    let triangles: Vec<_> =
        triangles.iter().map(|t| Triangle { corners: t.corners.map(|c| c * spread) }).collect();
    let scaled = |s: &Sphere| Sphere { center: s.center * spread, radius: s.radius * spread };
    let spheres: Vec<_> = spheres.iter().map(scaled).collect();
    let mut instanced = Instanced::behind(triangles.len() + spheres.len());
    let few = instanced.add_object(object(icosphere(0), is_smooth));
    let many = instanced.add_object(object(icosphere(3), is_smooth));
    for index in 0..40 {
        add(&mut instanced, if index % 3 == 0 { few } else { many }, place(&mut random, spread));
    }
    let mut copies = triangles.clone();
    let mut normals = vec![[Vec3::ZERO; 3]; triangles.len()];
    let mut name_of_copy: Vec<u32> = (0..triangles.len() as u32).collect();
    for instance in instanced.instances() {
        let object = &instanced.objects()[instance.object as usize];
        let is_mirrored = instance.to_world.matrix3.determinant() < 0.0;
        let ordered = |[a, b, c]: [Vec3; 3]| if is_mirrored { [a, c, b] } else { [a, b, c] };
        let turned = Mat3::from(instance.to_object).transpose();
        for (row, triangle) in object.triangles.iter().enumerate() {
            let corners = triangle.corners.map(|c| instance.to_world.transform_point3(c));
            copies.push(Triangle { corners: ordered(corners) });
            let own = object.shading_normals.get(row).copied().unwrap_or_default();
            // Of any length, so that they are interpolated as in the object's space.
            normals.push(ordered(own).map(|n| turned * n));
            name_of_copy.push(instance.first_primitive + row as u32);
        }
    }
    let first_sphere = triangles.len() as u32;
    name_of_copy.extend(first_sphere..first_sphere + spheres.len() as u32);
    let mut copied = scene_of(&copies, &spheres);
    let mut scene = scene_of(&triangles, &spheres);
    (scene.instanced, scene.bounds) = (instanced, copied.bounds);
    if is_smooth {
        copied.shading_normals = normals;
    }
    Pair { instanced: scene, copied, name_of_copy }
}

fn accelerator(scene: &Shapes) -> Accelerator {
    Accelerator::with_instances(&scene.triangles, &scene.spheres, &scene.instanced)
}

fn at(columns: &[Vec<f32>; 3], row: usize) -> Vec3 {
    Vec3::new(columns[0][row], columns[1][row], columns[2][row])
}

fn resolved(scene: &Shapes, rays: &RayColumns, count: usize) -> (Vec<(f32, u32)>, SurfaceColumns) {
    let (mut hits, mut surfaces) = (no_hits(count), SurfaceColumns::new(count));
    let scratch = &mut TraceScratch::default();
    trace_closest(&mut hits, scratch, rays, 0..count, &accelerator(scene));
    resolve_surfaces(&mut surfaces, &hits, rays, 0..count, scene);
    (hits.t.into_iter().zip(hits.primitive).collect(), surfaces)
}

#[test]
fn instances_are_seen_as_their_copies_are() {
    for (seed, spread, is_smooth) in [(1, 1.0, true), (2, 300.0, false), (3, 1e-2, true)] {
        let Pair { instanced, copied, name_of_copy } = pair(seed, spread, is_smooth);
        let mut random = Random(seed);
        // Runs of eight that start and run alike, and others.
        let count = 40_000;
        let mut start = (Vec3::ZERO, Vec3::ZERO);
        let rays: Vec<_> = (0..count)
            .map(|row| {
                if row % LANES == 0 || row > count / 2 {
                    start = (random.in_cube() * 1.5 * spread, random.direction());
                }
                (start.0, (start.1 + random.in_cube() * 1e-2).normalize())
            })
            .collect();
        let rays = columns(&rays);
        let (found, surfaces) = resolved(&instanced, &rays, count);
        let (expected, reference) = resolved(&copied, &rays, count);
        let (mut on_instances, mut different) = (0, 0);
        for row in 0..count {
            let name = match expected[row].1 {
                NONE => NONE,
                primitive => name_of_copy[primitive as usize],
            };
            if found[row].1 != name {
                // Through the edge between two, or past the silhouette.
                different += 1;
                continue;
            }
            if name == NONE {
                continue;
            }
            on_instances += usize::from(instanced.instanced.instance_of(name).is_some());
            let close = |a: Vec3, b: Vec3, to: f32| (a - b).length() <= to;
            assert!((found[row].0 - expected[row].0).abs() <= 2e-4 * spread, "{row}");
            let [position, geometric, shading] =
                [&surfaces.position, &surfaces.geometric_normal, &surfaces.shading_normal]
                    .map(|columns| at(columns, row));
            // Positions across the ray are as uncertain as along it, if that grazes.
            assert!(close(position, at(&reference.position, row), 2e-4 * spread), "{row}");
            assert!(close(geometric, at(&reference.geometric_normal, row), 1e-4), "{row}");
            let expected = at(&reference.shading_normal, row);
            if expected.dot(geometric) > 0.01 {
                assert!(close(shading, expected, 1e-3), "{row}: {shading} {expected}");
            }
            assert!(shading.dot(geometric) > 0.0);
            assert_eq!(surfaces.surface[row], instanced.surface_of(name));
            let normal = instanced.geometric_normal(name, position);
            assert!(close(normal, geometric, 1e-5));
        }
        assert!(
            on_instances > count / 10 && different < count / 2000,
            "{on_instances} {different}"
        );
        let t_max = limits(count, spread);
        let blocked = |scene: &Shapes| {
            let mut blocked = vec![0; count];
            let scratch = &mut TraceScratch::default();
            trace_visibility(&mut blocked, scratch, &rays, &t_max, 0..count, &accelerator(scene));
            blocked
        };
        let (ours, theirs) = (blocked(&instanced), blocked(&copied));
        let different = ours.iter().zip(&theirs).filter(|(a, b)| a != b).count();
        assert!(different < count / 2000, "{different}");
    }
}

#[test]
fn instances_are_tight() {
    let mut random = Random(5);
    for (spread, mesh) in [(1.0, icosphere(4)), (100.0, closed_box(-Vec3::ONE, Vec3::ONE))] {
        let mut instanced = Instanced::behind(0);
        instanced.add_object(object(mesh.clone(), false));
        let to_world = place(&mut random, spread);
        add(&mut instanced, 0, to_world);
        let accelerator = Accelerator::with_instances(&[], &[], &instanced);
        let count = 500_000;
        let ray = |_| {
            let corners = mesh[random.below(mesh.len())].corners;
            let on_edge = corners[0].lerp(corners[1], random.uniform());
            let target = if random.bits() & 1 == 0 { corners[0] } else { on_edge };
            let origin = to_world.transform_point3(random.in_cube() * 0.5);
            (origin, (to_world.transform_point3(target) - origin).normalize())
        };
        let rays = columns(&(0..count).map(ray).collect::<Vec<_>>());
        let (mut hits, mut blocked) = (no_hits(count), vec![0; count]);
        let scratch = &mut TraceScratch::default();
        trace_closest(&mut hits, scratch, &rays, 0..count, &accelerator);
        let t_max = limits(count, f32::INFINITY);
        trace_visibility(&mut blocked, scratch, &rays, &t_max, 0..count, &accelerator);
        assert_eq!(hits.primitive[..count].iter().filter(|it| **it == NONE).count(), 0);
        assert_eq!(blocked.iter().filter(|it| **it == 0).count(), 0);
    }
}

/// Rays that leave a convex object outwards do not meet it again, whatever its place.
#[test]
fn instances_do_not_meet_themselves() {
    let mut random = Random(6);
    for round in 0..300 {
        let spread = 10.0_f32.powf(random.between(-3.0, 4.0));
        let mut instanced = Instanced::behind(0);
        let mesh = if round % 2 == 0 { icosphere(0) } else { closed_box(-Vec3::ONE, Vec3::ONE) };
        instanced.add_object(object(mesh, false));
        add(&mut instanced, 0, place(&mut random, spread));
        let [low, high] = instanced.instances()[0].bounds;
        let corner = |point: Vec3| Triangle { corners: [point; 3] };
        let mut scene = scene_of(&[corner(low), corner(high)], &[]);
        scene.triangles.clear();
        scene.surface_of_primitive.clear();
        scene.instanced = instanced;
        let accelerator = accelerator(&scene);
        let (middle, radius) = (scene.bounds.center, scene.bounds.radius);
        let count = 2_000;
        let ray = |_| {
            let origin = middle + random.direction() * radius * random.between(1.1, 4.0);
            (origin, (middle + random.in_cube() * 0.5 * radius - origin).normalize())
        };
        let rays = columns(&(0..count).map(ray).collect::<Vec<_>>());
        let (found, surfaces) = resolved(&scene, &rays, count);
        for row in (0..count).filter(|row| found[*row].1 != NONE) {
            let normal = at(&surfaces.geometric_normal, row);
            let tangent = random.direction().cross(normal).normalize();
            let lift = 10.0_f32.powf(random.between(-6.0, 0.0));
            let direction = (tangent + normal * lift).normalize();
            let vector = |v: Vec3| Vector { x: v.x, y: v.y, z: v.z };
            let position = vector(at(&surfaces.position, row));
            let origin =
                offset_origin(position, vector(normal), vector(direction), surfaces.offset[row]);
            let origin = Vec3::new(origin.x, origin.y, origin.z);
            let hit = accelerator.closest(origin, direction, f32::INFINITY);
            assert_eq!(hit.primitive, NONE, "{:?} {origin} {direction}", scene.instanced);
        }
    }
}

#[test]
fn instances_share_memory() {
    let mut random = Random(7);
    let mut instanced = Instanced::behind(0);
    instanced.add_object(object(icosphere(5), false));
    for _ in 0..100 {
        add(&mut instanced, 0, place(&mut random, 10.0));
    }
    let statistics = Accelerator::with_instances(&[], &[], &instanced).statistics();
    assert_eq!((statistics.objects, statistics.instances), (1, 100));
    let one = Accelerator::build(&icosphere(5), &[]).statistics().bytes;
    assert!(statistics.bytes < one + 100 * 512, "{} {one}", statistics.bytes);
    // Neighboring names belong to instances in order, without overlap.
    for pair in instanced.instances().windows(2) {
        let next = pair[0].first_primitive + 20 * 4_u32.pow(5);
        assert!(pair[1].first_primitive >= next && pair[1].first_primitive < next + 256);
    }
}
