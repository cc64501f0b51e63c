//! Lamps in view whose own images are far smaller than a pixel: `bdpt` and `light` find them, by
//! their closed form where there is one, and of the others a note says that they do not.

use std::f64::consts::PI;

use glam::Vec3;
use serde_json::json;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::Mode;
use sunstone::internals::scene::World;
use sunstone::{Options, PlacedWorld, Settings};

use crate::support::gltf::Document;
use crate::support::rendering::{MONO, replicates, scene, settings};
use crate::support::statistics::{Estimate, mean_s0};

const SIZE: [u32; 2] = [8, 8];
const REPLICATES: u32 = 16;
/// What no score exceeds: noise does with a chance of 1e-5 in all comparisons together.
const LIMIT: f64 = 5.0;
const RADIANCE: f64 = 1e8;
const DISTANCE: f64 = 2.0;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Lens {
    Pinhole,
    Thin,
    Parallel,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Lamp {
    Ball,
    /// Facing the camera.
    Quad,
}

/// A lamp of so large a radius, or half edge, before the camera, and what is between.
fn lamp_in_view(lens: Lens, lamp: Lamp, size: f32, before: Option<serde_json::Value>) -> World {
    let mut scene = Document::default();
    let glow = scene.material(json!({"bsdf": "absorber"}));
    let glow = scene.emits(glow, RADIANCE as f32);
    match lamp {
        Lamp::Ball => scene.sphere(Vec3::ZERO, size, glow),
        Lamp::Quad => scene.quad(Vec3::ZERO, size * Vec3::X, size * Vec3::Y, glow),
    }
    if let Some(body) = before {
        let sheet = scene.material(body);
        scene.quad(Vec3::Z, Vec3::new(0.9, 0.0, 0.4), Vec3::Y, sheet);
    }
    let eye = Vec3::Z * DISTANCE as f32;
    match lens {
        Lens::Pinhole => scene.perspective(eye, Vec3::ZERO, 0.5, None),
        Lens::Thin => scene.perspective(eye, Vec3::ZERO, 0.5, Some([0.05, DISTANCE as f32])),
        Lens::Parallel => scene.orthographic(eye, Vec3::ZERO, 0.5),
    }
    scene.load("lamp in view")
}

fn mean(world: &World, integrator: Integrator) -> Estimate {
    let scene = scene::<1>(world, MONO, SIZE);
    let images =
        replicates(&scene, &settings(integrator, Mode::Polarized, MONO, 64, 4), REPLICATES);
    Estimate::of(&images.iter().map(mean_s0).collect::<Vec<f64>>())
}

/// The radiance times the share of the film that the lamp's image takes up.
#[test]
fn lamps_smaller_than_pixels_are_seen_as_bright_as_they_are() {
    for (lens, size) in [
        (Lens::Pinhole, 1e-7),
        (Lens::Pinhole, 1e-4),
        (Lens::Pinhole, 0.05),
        (Lens::Parallel, 1e-4),
    ] {
        for lamp in [Lamp::Ball, Lamp::Quad] {
            let area = match lamp {
                Lamp::Ball => PI * f64::from(size).powi(2),
                Lamp::Quad => 4.0 * f64::from(size).powi(2),
            };
            let seen = match (lens, lamp) {
                (Lens::Parallel, _) => area,
                // A cone touches the ball, nearer than its middle.
                (_, Lamp::Ball) => area / (DISTANCE.powi(2) - f64::from(size).powi(2)),
                (_, Lamp::Quad) => area / DISTANCE.powi(2),
            };
            let film = match lens {
                Lens::Parallel => 1.0,
                Lens::Pinhole | Lens::Thin => 4.0 * 0.25_f64.tan().powi(2),
            };
            let seen = seen / film;
            let expected = RADIANCE * seen;
            let found = mean(&lamp_in_view(lens, lamp, size, None), Integrator::Bdpt);
            let score = found.score(&Estimate::exact(expected), expected).unwrap_or(0.0);
            println!("{lens:?}, {lamp:?} of {size}: {:.4e} for {expected:.4e}", found.mean);
            assert!(score.abs() < LIMIT, "{lens:?}, {lamp:?} of {size}: {score}");
            assert!((found.mean / expected - 1.0).abs() < 0.1, "{found:?} for {expected}");
        }
    }
}

#[test]
fn light_and_bdpt_agree_on_them_through_lenses_and_sheets() {
    let sheets = [
        None,
        Some(json!({"bsdf": "polarizer", "axis_deg": 30})),
        Some(json!({"bsdf": "thin_dielectric", "ior": 1.5})),
    ];
    for sheet in sheets {
        for (lens, size) in
            [(Lens::Pinhole, 0.03), (Lens::Thin, 1e-4), (Lens::Thin, 0.03), (Lens::Parallel, 0.03)]
        {
            let world = lamp_in_view(lens, Lamp::Quad, size, sheet.clone());
            let [bdpt, light] = [Integrator::Bdpt, Integrator::Light].map(|it| mean(&world, it));
            let score = bdpt.score(&light, light.mean).unwrap_or(0.0);
            println!("{lens:?} {size} {sheet:?}: {:.4e} and {:.4e}", bdpt.mean, light.mean);
            assert!(light.mean > 0.0 && score.abs() < LIMIT, "{lens:?} {size} {sheet:?}: {score}");
        }
    }
}

#[test]
fn who_hits_a_lamp_by_chance_says_so() {
    let said = |world: World, integrator: Integrator, samples: u32| {
        let options = Options { integrator: Some(integrator), samples, ..Options::default() };
        let world = PlacedWorld::new(world).expect("a sound world");
        let notes = world.notes(&Settings::new(options).expect("sound options")).expect("notes");
        notes.iter().any(|note| note.contains("its own image"))
    };
    let lamp = |size| lamp_in_view(Lens::Pinhole, Lamp::Ball, size, None);
    for integrator in [Integrator::Path, Integrator::Ppm] {
        assert!(said(lamp(1e-5), integrator, 64), "{integrator:?}");
        // As large as some pixels of 512 x 512.
        assert!(!said(lamp(5e-3), integrator, 64), "{integrator:?}");
        // A third of a pixel, by few samples or many.
        assert!(said(lamp(6e-4), integrator, 4), "{integrator:?}");
        assert!(!said(lamp(6e-4), integrator, 256), "{integrator:?}");
        let wall = json!({"bsdf": "diffuse", "reflectance": 0.5});
        let hidden = lamp_in_view(Lens::Pinhole, Lamp::Ball, 1e-5, Some(wall));
        assert!(!said(hidden, integrator, 64), "{integrator:?}");
    }
    for integrator in [Integrator::Bdpt, Integrator::Light] {
        assert!(!said(lamp(1e-5), integrator, 64), "{integrator:?}");
    }
}
