//! Thin films on metal and glass: what a camera sees of them, against tabulated ones.

use glam::Vec3;
use serde_json::{Value, json};
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::Mode;
use sunstone::internals::spectrum::Color;

use crate::support::gltf::Document;
use crate::support::rendering::{MONO, image, scene, settings};

/// Rows of the table of films by its Python script: before, eta, k, behind, k behind, waves, angle,
/// R00, R01, R22, R32 and the same of what is refracted.
fn table() -> Vec<Vec<f64>> {
    let text = include_str!("../data/film/films.csv");
    let row = |line: &str| line.split(',').map(|cell| cell.parse().expect("a number")).collect();
    text.lines().skip(1).map(row).collect()
}

/// A plane seen along its plane of incidence under a sky of 1, before what is black; what S0 and S1
/// are.
fn seen(body: Value, deg: f64) -> [f64; 2] {
    let mut plane = Document::default();
    let material = plane.material(body);
    plane.quad(Vec3::ZERO, Vec3::X * 20.0, Vec3::Y * 20.0, material);
    let black = plane.material(json!({"bsdf": "absorber"}));
    plane.quad(Vec3::Z * -0.5, Vec3::X * 90.0, Vec3::Y * 90.0, black);
    plane.environment(1.0);
    let (sine, cosine) = (deg as f32).to_radians().sin_cos();
    // Up is in the plane of incidence, and right is across it.
    plane.up(Vec3::new(0.0, cosine, sine));
    plane.orthographic(Vec3::new(0.0, -sine, cosine) * 4.0, Vec3::ZERO, 0.05);
    let world = plane.load("plane");
    let samples = if body_is_glass(&world.describe()) { 1024 } else { 4 };
    let options = settings(Integrator::Path, Mode::Polarized, MONO, samples, 2);
    let image = image(&scene::<1>(&world, MONO, [2, 2]), &options);
    [0, 1].map(|of| image.planes[of].iter().map(|value| f64::from(*value)).sum::<f64>() / 4.0)
}

fn body_is_glass(described: &str) -> bool {
    described.contains("smooth dielectric")
}

/// At 550 nm, of the rows that are seen from vacuum, no more aslant than a far plane allows. What
/// glass refracts is lost: reflection is drawn, and 4,096 samples are within 5 standard errors.
#[test]
fn films_are_seen_as_tabulated() {
    let mut count = 0;
    for row in table().iter().step_by(3) {
        let [before, eta, k, behind, behind_k, waves, deg, r00, r01] = row[..9] else {
            panic!("a short row")
        };
        if before != 1.0 || deg > 85.0 {
            continue;
        }
        let film = json!({"eta": eta, "k": k, "thickness_nm": 550.0 * waves});
        let is_metal = behind_k > 0.0;
        let body = match is_metal {
            true => json!({"bsdf": "conductor", "eta": behind, "k": behind_k, "film": film}),
            false => json!({"bsdf": "dielectric", "ior": behind, "film": film}),
        };
        let found = seen(body, deg);
        let error = match is_metal {
            true => 1e-4,
            false => 1e-4 + 5.0 * (r00 * (1.0 - r00) / 4096.0).sqrt(),
        };
        for (found, expected) in found.into_iter().zip([r00, r01]) {
            assert!((found - expected).abs() < error, "{found} {expected}: {row:?}");
        }
        count += 1;
    }
    assert!(count > 20, "{count} rows");
}

/// A ball of glass under a film, in a sky of 1, is not there: nothing is absorbed, and all that is
/// polarized is taken back. In all colors and modes.
#[test]
fn films_on_glass_lose_no_light() {
    let mut ball = Document::default();
    let film = json!({"eta": 1.9, "thickness_nm": 430});
    let glass = ball.material(json!({"bsdf": "dielectric", "ior": 1.5, "film": film}));
    ball.sphere(Vec3::ZERO, 0.5, glass);
    ball.environment(1.0);
    ball.orthographic(Vec3::Z * 3.0, Vec3::ZERO, 0.4);
    let world = ball.load("ball");
    for mode in [Mode::Scalar, Mode::Polarized] {
        let options = settings(Integrator::Path, mode, Color::Rgb, 256, 64);
        let image = image(&scene::<3>(&world, Color::Rgb, [4, 4]), &options);
        let size = image.planes[0].len() as f32;
        for (index, plane) in image.planes.iter().enumerate() {
            let mean = plane.iter().sum::<f32>() / size;
            let expected = if index < 3 { 1.0 } else { 0.0 };
            // Wavelengths share a choice that is drawn for their mean: 4,096 paths of a spread of a
            // tenth or so.
            assert!((mean - expected).abs() < 0.01, "{mode:?}, plane {index}: {mean}");
        }
    }
}
