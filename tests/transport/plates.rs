//! Piles of plates at Brewster's angle, which polarize the light that comes through: its Stokes
//! vector against Fresnel's equations, and its noise against that of scalar transport.
//!
//! Some 50 numbers are scored. A normal number exceeds the limit of 5 with a chance of 6e-7, so
//! that noise fails the tests in 1 of 30,000 cases.

use glam::{Quat, Vec3};
use serde_json::json;
use sunstone::internals::image::StokesImage;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Mode, Options};
use sunstone::internals::scene::World;
use sunstone::internals::spectrum::Color;
use sunstone::internals::transport::Sampling;

use crate::support::gltf::Document;
use crate::support::rendering::{MONO, replicates, scene, settings};
use crate::support::statistics::{Estimate, estimate, worst};

const EDGE: u32 = 8;
const PIXELS: usize = (EDGE * EDGE) as usize;
const SAMPLES: u32 = 16;
const REPLICATES: u32 = 16;
const LIMIT: f64 = 5.0;
const IOR: f32 = 1.5;

/// Half the thickness of a plate.
const HALF: f32 = 0.01;

/// A plate across the z axis, if that were not turned.
fn add_plate(document: &mut Document, center: Vec3, turn: Quat, glass: usize) {
    let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| turn * axis);
    for (face, u, v) in [(z, x, y), (-z, y, x)] {
        document.quad(center + face * HALF, u * 12.0, v * 12.0, glass);
    }
    for (face, u, v) in [(x, y, z), (-x, z, y), (y, z, x), (-y, x, z)] {
        let [u, v] = [u, v].map(|edge| if edge == z { edge * HALF } else { edge * 12.0 });
        document.quad(center + face * 12.0, u, v, glass);
    }
}

/// Plates with so much air between them.
fn stack(plates: usize, gap: f32) -> World {
    let mut document = Document::default();
    let glass = document.material(json!({"bsdf": "dielectric", "ior": IOR}));
    let turn = Quat::from_rotation_x(IOR.atan());
    for plate in 0..plates {
        let center = turn * Vec3::NEG_Z * (2.0 * HALF + gap) * plate as f32;
        add_plate(&mut document, center, turn, glass);
    }
    before_wall(document, "stack")
}

/// Two balls of glass, of which the other is so far aside and of that radius; spheres, or meshes.
fn balls(aside: f32, radius: f32, meshed: bool) -> World {
    let mut document = Document::default();
    let glass = document.material(json!({"bsdf": "dielectric", "ior": IOR}));
    for (center, radius) in [(Vec3::ZERO, 0.8), (Vec3::new(aside, aside, 0.0), radius)] {
        match meshed {
            true => document.ball(center, radius, 16, glass),
            false => document.sphere(center, radius, glass),
        }
    }
    before_wall(document, "balls")
}

/// How many others each solid may reach into, of those that may at all.
fn others(world: &World) -> Vec<usize> {
    let scene = scene::<1>(world, MONO, [EDGE; 2]);
    scene.shapes.solids.iter().map(|solid| solid.others.len()).collect()
}

/// Boxes about plates that lean, and about balls, overlap where they are apart: only bodies that
/// touch, or are in each other, are to cost anything.
#[test]
fn bodies_that_are_apart_are_not_looked_for() {
    assert!(others(&pile("ten plates", 10, 10)).is_empty());
    assert!(others(&stack(10, 1e-3)).is_empty());
    for meshed in [false, true] {
        assert!(others(&balls(1.2, 0.8, meshed)).is_empty(), "{meshed}");
        assert_eq!(others(&balls(1.1, 0.8, meshed)), [1, 1], "{meshed}");
        assert_eq!(others(&balls(0.1, 0.3, meshed)), [1, 1], "{meshed}");
    }
    for gap in [1e-6, -1e-3] {
        assert_eq!(others(&stack(4, gap)), [1, 2, 2, 1], "{gap}");
    }
}

/// Plates that touch, or overlap, are one.
#[test]
fn plates_without_air_between_are_one() {
    let everywhere: Vec<usize> = (0..PIXELS).collect();
    let [s, p] = transmitted(1);
    let mut scores = Vec::new();
    for gap in [0.0, 1e-6, -1e-3] {
        for integrator in [Integrator::Path, Integrator::Bdpt] {
            let of = options(integrator, Mode::Polarized, MONO, Sampling::Stokes);
            let images = images::<1>(&stack(4, gap), MONO, of);
            for (stokes, exact) in [0.5 * (s + p), 0.5 * (s - p)].into_iter().enumerate() {
                let found = estimate(&images, stokes, &everywhere);
                scores.extend(found.score(&Estimate::exact(exact), 1.0));
            }
        }
    }
    assert!(scores.len() >= 6 && worst(&scores) < LIMIT, "{scores:?}");
}

/// Plates before a wall of radiance 1, in the dark otherwise; seen by parallel rays against z that
/// meet them at Brewster's angle. Those from `turned` on lean another way by a right angle.
fn pile(name: &str, plates: usize, turned: usize) -> World {
    let mut document = Document::default();
    let glass = document.material(json!({"bsdf": "dielectric", "ior": IOR}));
    for plate in 0..plates {
        let lean = Quat::from_rotation_x(IOR.atan());
        let turn = if plate < turned { lean } else { Quat::from_rotation_z(1.5707964) * lean };
        let mut center = Vec3::Z * (-0.1 * plate as f32);
        if plate >= turned {
            // So far behind that they do not reach into the others.
            center -= Vec3::Z * 40.0;
        }
        add_plate(&mut document, center, turn, glass);
    }
    before_wall(document, name)
}

fn before_wall(mut document: Document, name: &str) -> World {
    let wall = document.material(json!({"bsdf": "absorber"}));
    let wall = document.emits(wall, 1.0);
    document.quad(Vec3::Z * -80.0, Vec3::X * 9.0, Vec3::Y * 9.0, wall);
    document.orthographic(Vec3::Z * 20.0, Vec3::ZERO, 0.5);
    document.load(name)
}

fn images<const N: usize>(world: &World, color: Color, of: Options) -> Vec<StokesImage> {
    let scene = scene::<N>(world, color, [EDGE; 2]);
    replicates(&scene, &of, REPLICATES)
}

fn options(integrator: Integrator, mode: Mode, color: Color, sampling: Sampling) -> Options {
    Options { sampling, ..settings(integrator, mode, color, SAMPLES, 400) }
}

/// The mean over pixels of the variance of one sample's S0.
fn noise(images: &[StokesImage]) -> f64 {
    let variance = |pixel: usize| estimate(images, 0, &[pixel]).variance;
    let of_mean = (0..PIXELS).map(variance).sum::<f64>() / PIXELS as f64;
    of_mean * f64::from(REPLICATES * SAMPLES)
}

/// Of 2m faces of reflectance R, without interference: (1 - R) / (1 + (2m - 1) R). At Brewster's
/// angle only light across the plane of incidence is reflected.
fn transmitted(plates: usize) -> [f64; 2] {
    let n2 = f64::from(IOR).powi(2);
    let reflectance = ((1.0 - n2) / (1.0 + n2)).powi(2);
    let faces = 2.0 * plates as f64;
    let across = (1.0 - reflectance) / (1.0 + (faces - 1.0) * reflectance);
    [across, 1.0]
}

#[test]
fn piles_of_plates_polarize_as_fresnel_has_it() {
    let everywhere: Vec<usize> = (0..PIXELS).collect();
    for plates in [1, 4] {
        let world = pile(&format!("{plates} plates"), plates, plates);
        let [s, p] = transmitted(plates);
        let exact = [0.5 * (s + p), 0.5 * (s - p), 0.0, 0.0];
        for integrator in [Integrator::Path, Integrator::Bdpt, Integrator::Ppm] {
            let images = images::<3>(
                &world,
                Color::Rgb,
                options(integrator, Mode::Polarized, Color::Rgb, Sampling::Stokes),
            );
            let mut scores = Vec::new();
            for (stokes, exact) in exact.into_iter().enumerate() {
                for channel in 0..3 {
                    let found = estimate(&images, 3 * stokes + channel, &everywhere);
                    scores.extend(found.score(&Estimate::exact(exact), 1.0));
                }
            }
            println!("{plates} plates, {integrator:?}: {scores:.2?}");
            assert!(scores.len() >= 6);
            assert!(worst(&scores) < LIMIT, "{plates} plates, {integrator:?}: {scores:?}");
        }
    }
}

/// Reflection and transmission are drawn by what the light of the path does, so that all paths
/// weigh the same: the variance is that of passing or not.
#[test]
fn polarized_light_is_no_noisier_than_unpolarized() {
    let world = pile("six plates", 6, 6);
    let found = |mode, sampling| {
        noise(&images::<1>(&world, MONO, options(Integrator::Path, mode, MONO, sampling)))
    };
    let scalar = found(Mode::Scalar, Sampling::Stokes);
    let polarized = found(Mode::Polarized, Sampling::Stokes);
    let even = found(Mode::Polarized, Sampling::Intensity);
    println!("scalar {scalar:.4}, polarized {polarized:.4}, by intensity {even:.4}");
    assert!(polarized < 1.3 * scalar, "{polarized} for {scalar}");
    assert!(even > 2.0 * scalar, "{even} for {scalar}");
}

/// Piles that cross: what the first lets through the second reflects.
#[test]
fn crossed_piles_are_seen_alike_by_all() {
    let everywhere: Vec<usize> = (0..PIXELS).collect();
    let world = pile("crossed plates", 4, 2);
    let by = |integrator, sampling| {
        let of = options(integrator, Mode::Polarized, MONO, sampling);
        let images = images::<1>(&world, MONO, of);
        [0, 1, 2, 3].map(|stokes| estimate(&images, stokes, &everywhere))
    };
    let all = [
        by(Integrator::Path, Sampling::Intensity),
        by(Integrator::Path, Sampling::Stokes),
        by(Integrator::Bdpt, Sampling::Stokes),
        by(Integrator::Ppm, Sampling::Stokes),
    ];
    let mut scores = Vec::new();
    for other in &all[1..] {
        for (a, b) in all[0].iter().zip(other) {
            scores.extend(a.score(b, all[0][0].mean));
        }
    }
    println!("{:?}: {scores:.2?}", all[0].map(|estimate| estimate.mean));
    assert!(scores.len() >= 6 && worst(&scores) < LIMIT, "{scores:?}");
}
