//! Things of a meter on grounds of up to a thousand kilometers: the light is the same on all of
//! them, by every integrator, and what was closed stays closed when it is divided.

use std::collections::HashMap;

use glam::{Quat, Vec3};
use serde_json::json;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::Mode;
use sunstone::internals::scene::World;

use crate::support::gltf::Document;
use crate::support::rendering::{MONO, replicates, scene, settings};
use crate::support::statistics::{Estimate, mean_s0};

const SIZE: [u32; 2] = [16, 16];
const REPLICATES: u32 = 16;
const ITERATIONS: u32 = 64;
const PATH_LENGTH_MAX: u32 = 6;
/// What no score exceeds: noise does with a chance of 1e-5 in all comparisons together.
const LIMIT: f64 = 5.0;

/// A lamp of 0.2 m and a white wall over a ground that reaches so far, all turned about the origin
/// and so many times as large, seen from above at so many times the usual distance.
fn lamp_and_wall(reach: f32, turned: Quat, size: f32, away: f32) -> World {
    let mut scene = Document::default();
    let floor = scene.diffuse(0.5);
    let lamp = scene.material(json!({"bsdf": "absorber"}));
    let lamp = scene.emits(lamp, 100.0);
    let wall = scene.diffuse(0.8);
    let wall = scene.two_sided(wall);
    let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| turned * axis * size);
    scene.quad(Vec3::ZERO, reach * z, reach * x, floor);
    scene.quad(y, 0.1 * x, 0.1 * z, lamp);
    scene.quad(0.5 * y + 0.3 * x, 0.5 * y, 0.5 * z, wall);
    scene.up(-z);
    scene.perspective(3.0 * away * y, Vec3::ZERO, 2.0 * (0.15_f32 / away).atan(), None);
    scene.load("lamp and wall")
}

fn mean(world: &World, integrator: Integrator, seed: u32, replicate_count: u32) -> Estimate {
    let scene = scene::<1>(world, MONO, SIZE);
    let mut options = settings(integrator, Mode::Scalar, MONO, ITERATIONS, PATH_LENGTH_MAX);
    options.seed += seed;
    let images = replicates(&scene, &options, replicate_count);
    Estimate::of(&images.iter().map(mean_s0).collect::<Vec<f64>>())
}

#[test]
fn the_size_of_the_ground_changes_nothing() {
    let tilted = Quat::from_xyzw(0.2, 0.3, 0.1, 0.927).normalize();
    let small = lamp_and_wall(20.0, Quat::IDENTITY, 1.0, 1.0);
    let reference = mean(&small, Integrator::Path, 0, 8 * REPLICATES);
    let cases = [
        ("20 km", lamp_and_wall(2e4, Quat::IDENTITY, 1.0, 1.0)),
        ("1,000 km", lamp_and_wall(1e6, Quat::IDENTITY, 1.0, 1.0)),
        ("100 km, tilted", lamp_and_wall(1e5, tilted, 1.0, 1.0)),
        ("20 m times 1e-5", lamp_and_wall(20.0, Quat::IDENTITY, 1e-5, 1.0)),
    ];
    let mut worst = 0.0_f64;
    for (seed, (name, world)) in (1..).zip(&cases) {
        for integrator in [Integrator::Path, Integrator::Bdpt, Integrator::Light] {
            let found = mean(world, integrator, 1000 * seed, REPLICATES);
            let score = found.score(&reference, reference.mean).unwrap_or(0.0);
            println!("{name}, {integrator:?}: {:.5} z {score:.1}", found.mean);
            worst = worst.max(score.abs());
        }
    }
    assert!(worst < LIMIT, "{worst}");
}

/// From a camera ten kilometers off, what it sees has a meter.
#[test]
fn a_camera_may_look_from_far_off() {
    let world = lamp_and_wall(1e5, Quat::IDENTITY, 1.0, 1e4);
    let path = mean(&world, Integrator::Path, 0, REPLICATES);
    for integrator in [Integrator::Bdpt, Integrator::Light] {
        let found = mean(&world, integrator, 1000, REPLICATES);
        let score = found.score(&path, path.mean).unwrap_or(0.0);
        println!("{integrator:?}: {:.5} for {:.5} z {score:.1}", found.mean, path.mean);
        assert!(score.abs() < LIMIT, "{integrator:?}: {score}");
    }
}

/// A box that reaches so far, standing on the ground, and a room.
fn boxes(reach: f32) -> World {
    let mut scene = Document::default();
    let white = scene.diffuse(0.5);
    let edge = Vec3::new(reach, 0.5 * reach, 2.0 * reach);
    scene.cuboid(0.5 * reach * Vec3::Y, edge, white);
    scene.environment(1.0);
    scene.up(Vec3::X);
    scene.perspective(Vec3::new(0.0, 3.0, 0.0), Vec3::ZERO, 0.6, None);
    scene.load("boxes")
}

#[test]
fn what_is_divided_stays_closed() {
    for (reach, divided) in [(5.0, false), (1e3, true), (1e6, true)] {
        let triangles = &scene::<1>(&boxes(reach), MONO, SIZE).shapes.triangles;
        assert_eq!(triangles.len() > 12, divided, "{reach}: {} triangles", triangles.len());
        assert!(triangles.len() < 4000, "{reach}: {} triangles", triangles.len());
        let place = |corner: Vec3| corner.to_array().map(|it| (it + 0.0).to_bits());
        let mut edges: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
        for triangle in triangles {
            for corner in 0..3 {
                let [from, to] = [0, 1].map(|next| place(triangle.corners[(corner + next) % 3]));
                // Every edge is passed once each way.
                let way = if from < to { 1 } else { -1 };
                *edges.entry([from.min(to), from.max(to)]).or_default() += way;
            }
        }
        assert!(edges.values().all(|passed| *passed == 0), "{reach}");
        let reach_of = |corner: Vec3| corner.abs().max_element();
        // Near is what counts 32 m at most, eight times the distance of the floor, rounded up.
        let is_small = |corner: &Vec3| reach_of(*corner) < 32.0 * 32.0 + 1.0;
        let at_hand = triangles.iter().filter(|it| it.corners.iter().all(is_small));
        assert!(at_hand.count() > 0, "{reach}: nothing small is near");
    }
}
