//! How long a ray takes:
//! `cargo test --profile checks --test geometry -- --ignored --nocapture profile`.

use std::hint::black_box;
use std::time::Instant;

use glam::Vec3;
use sunstone::internals::geometry::{Accelerator, SurfaceColumns, resolve_surfaces};
use sunstone::internals::geometry::{RayColumns, TraceScratch, trace_closest, trace_visibility};
use sunstone::internals::math::LANES;
use sunstone::internals::scene::baked::{NONE, Sphere, Triangle};

use super::fixtures::{Random, closed_box, columns, cornell, icosphere, no_hits, quad};
use super::surfaces::scene_of;

const SIDE: usize = 256;
const CHUNK: usize = 1024;
const REPETITIONS: usize = 9;

/// Median of several repetitions in ns a row; chunks as the stages use them.
fn time(count: usize, mut stage: impl FnMut(std::ops::Range<usize>)) -> f64 {
    let mut times: Vec<_> = (0..REPETITIONS)
        .map(|_| {
            let start = Instant::now();
            for first in (0..count).step_by(CHUNK) {
                stage(first..(first + CHUNK).min(count));
            }
            start.elapsed().as_nanos() as f64 / count as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[REPETITIONS / 2]
}

fn camera_rays(eye: Vec3) -> Vec<(Vec3, Vec3)> {
    let ray = |index: usize| {
        let (x, y) = ((index % SIDE) as f32 + 0.5, (index / SIDE) as f32 + 0.5);
        let half = SIDE as f32 / 2.0;
        (eye, Vec3::new(x / half - 1.0, 1.0 - y / half, -2.6).normalize())
    };
    (0..SIDE * SIDE).map(ray).collect()
}

/// Rays scattered by diffuse surfaces where `rays` hit.
fn bounce(accelerator: &Accelerator, rays: &[(Vec3, Vec3)], seed: u64) -> Vec<(Vec3, Vec3)> {
    let mut random = Random(seed);
    let mut scattered = Vec::new();
    for &(origin, direction) in rays {
        let hit = accelerator.closest(origin, direction, f32::INFINITY);
        if hit.primitive != NONE {
            let position = origin + direction * (hit.t * 0.9999);
            let out = random.direction();
            scattered.push((position, out * -out.dot(direction).signum()));
        }
    }
    scattered
}

fn report(name: &str, accelerator: &Accelerator, rays: &[(Vec3, Vec3)], t_max: f32) {
    let count = rays.len();
    let columns: RayColumns = columns(rays);
    let mut hits = no_hits(count);
    let closest = time(count, |rows| {
        trace_closest(&mut hits, &mut TraceScratch::default(), &columns, rows, accelerator)
    });
    let mut blocked = vec![0; count];
    let limits = vec![t_max; count + LANES];
    let occluded = time(count, |rows| {
        trace_visibility(
            &mut blocked,
            &mut TraceScratch::default(),
            &columns,
            &limits,
            rows,
            accelerator,
        )
    });
    let mut sum = 0.0;
    let single = time(count, |rows| {
        for row in rows {
            sum += accelerator.closest(rays[row].0, rays[row].1, f32::INFINITY).u;
        }
    });
    black_box(sum);
    let share = blocked.iter().filter(|&&b| b != 0).count() as f64 / count as f64;
    println!(
        "{name:24} closest {closest:6.1}  occluded {occluded:6.1} ({:2.0} % blocked)  \
         closest() {single:6.1} ns",
        100.0 * share
    );
}

fn profile(name: &str, triangles: &[Triangle], spheres: &[Sphere], eye: Vec3) {
    let start = Instant::now();
    let accelerator = Accelerator::build(triangles, spheres);
    println!("{name}: built in {:.1?}, {:?}", start.elapsed(), accelerator.statistics());
    let camera = camera_rays(eye);
    let first = bounce(&accelerator, &camera, 1);
    let second = bounce(&accelerator, &first, 2);
    report("  camera", &accelerator, &camera, 2.0);
    report("  diffuse, first bounce", &accelerator, &first, 0.8);
    report("  diffuse, second bounce", &accelerator, &second, 0.8);
    let scene = scene_of(triangles, spheres);
    let (columns, mut hits) = (columns(&second), no_hits(second.len()));
    trace_closest(&mut hits, &mut TraceScratch::default(), &columns, 0..second.len(), &accelerator);
    let mut surfaces = SurfaceColumns::new(second.len());
    let resolve = time(second.len(), |rows| {
        resolve_surfaces(&mut surfaces, &hits, &columns, rows, &scene);
    });
    println!("  resolve_surfaces {resolve:.1} ns");
}

#[test]
#[ignore = "a measurement; run alone and in release"]
fn profile_rays() {
    let (triangles, spheres) = cornell();
    profile("cornell", &triangles, &spheres, Vec3::new(0.0, 0.0, 3.4));
    let (mut boxes, _) = cornell();
    boxes.extend(closed_box(Vec3::new(-0.7, -0.999, -0.6), Vec3::new(-0.1, 0.2, 0.0)));
    boxes.extend(closed_box(Vec3::new(0.1, -0.999, 0.0), Vec3::new(0.7, -0.4, 0.6)));
    profile("cornell with two boxes", &boxes, &[], Vec3::new(0.0, 0.0, 3.4));
    for levels in [1, 2, 6] {
        let (mut room, _) = cornell();
        room.truncate(10);
        let mut mesh: Vec<_> = icosphere(levels)
            .iter()
            .map(|t| Triangle { corners: t.corners.map(|c| c * 0.6) })
            .collect();
        mesh.extend(room);
        mesh.extend(quad(Vec3::new(-0.5, 0.995, -0.5), Vec3::X, Vec3::Z));
        profile(&format!("icosphere {levels} in a room"), &mesh, &[], Vec3::Z * 3.4);
    }
}
