//! Rough plates under films: what a camera sees of them under an even sky, against sums over
//! facets of Airy's matrices in double precision.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use sunstone::internals::integrators::Integrator;
use sunstone::internals::polarization::{Film, filmed_conductor};
use sunstone::internals::render::Mode;

use crate::support::gltf::Document;
use crate::support::rendering::{MONO, replicates, scene, settings};

const ALPHA: f64 = 0.3;
/// Independent images.
const REPLICATES: u32 = 16;
/// Titanium at 550 nm, about, under its oxide.
const INDEX: [f64; 2] = [1.87, 2.6];
const FILM: Film<f64> = Film { eta: 2.4, k: 0.0, waves: 40.0 / 550.0, spread: 0.0 };

/// S0 and S1 of a plate seen at an angle along its plane of incidence, means of images and their
/// standard errors. Right is across the plane.
fn seen(body: Value, deg: f64) -> [[f64; 2]; 2] {
    let mut plate = Document::default();
    let material = plate.material(body);
    plate.quad(Vec3::ZERO, Vec3::X * 20.0, Vec3::Y * 20.0, material);
    plate.environment(1.0);
    let (sine, cosine) = (deg as f32).to_radians().sin_cos();
    plate.up(Vec3::new(0.0, cosine, sine));
    plate.orthographic(Vec3::new(0.0, -sine, cosine) * 4.0, Vec3::ZERO, 0.05);
    let world = plate.load("plate");
    let options = settings(Integrator::Path, Mode::Polarized, MONO, 16, 2);
    let images = replicates(&scene::<1>(&world, MONO, [4, 4]), &options, REPLICATES);
    [0, 1].map(|of| {
        let mean = |values: &[f32]| values.iter().map(|it| f64::from(*it)).sum::<f64>() / 16.0;
        let means: Vec<f64> = images.iter().map(|image| mean(&image.planes[of])).collect();
        let all = f64::from(REPLICATES);
        let mean = means.iter().sum::<f64>() / all;
        let squares = means.iter().map(|it| (it - mean).powi(2)).sum::<f64>();
        [mean, (squares / (all * (all - 1.0))).sqrt()]
    })
}

/// The same of light from everywhere by GGX's facets of the reflectance that `face` says with the
/// diattenuation, by the cosine.
fn expected(deg: f64, face: impl Fn(f64) -> [f64; 2]) -> [f64; 2] {
    const EDGE: usize = 150;
    let (sine, cosine) = deg.to_radians().sin_cos();
    let v = DVec3::new(0.0, -sine, cosine);
    let lambda = |w: DVec3| {
        let tan2 = (1.0 - w.z * w.z) / (w.z * w.z);
        0.5 * ((1.0 + ALPHA * ALPHA * tan2).sqrt() - 1.0)
    };
    let mut sums = [0.0; 2];
    for (row, turn) in (0..EDGE).flat_map(|row| (0..2 * EDGE).map(move |turn| (row, turn))) {
        let z = (row as f64 + 0.5) / EDGE as f64;
        let phi = (turn as f64 + 0.5) * PI / EDGE as f64;
        let r = (1.0 - z * z).sqrt();
        let l = DVec3::new(r * phi.cos(), r * phi.sin(), z);
        let h = (l + v).normalize();
        let tan2 = (1.0 - h.z * h.z) / (h.z * h.z);
        let density = ALPHA * ALPHA / (PI * h.z.powi(4) * (ALPHA * ALPHA + tan2).powi(2));
        let facets = density / (1.0 + lambda(l) + lambda(v)) / (4.0 * l.z * v.z) * l.z;
        let [reflectance, diattenuation] = face(v.dot(h));
        // The axis across the facets' plane, about the light to the camera, from the right.
        let s = h.cross(v).normalize();
        let cos_twice = 2.0 * s.dot(DVec3::X).powi(2) - 1.0;
        let part = facets * reflectance * 2.0 * PI / (2 * EDGE * EDGE) as f64;
        sums[0] += part;
        sums[1] += part * diattenuation * cos_twice;
    }
    sums
}

fn film() -> Value {
    json!({"eta": FILM.eta, "k": FILM.k, "thickness_nm": 40.0})
}

/// Of four numbers each, four standard errors: by chance in one of 4,000 cases.
fn check(name: &str, found: [[f64; 2]; 2], expected: [f64; 2]) {
    for ([mean, error], expected) in found.into_iter().zip(expected) {
        println!("{name}: {mean:.5} +- {error:.5}, {expected:.5}");
        assert!((mean - expected).abs() < 4.0 * error + 2e-4, "{name}: {mean} {expected}");
    }
}

#[test]
fn rough_metal_under_a_film_is_seen_as_summed() {
    let [eta, k] = INDEX;
    let body = |film| {
        let mut body = json!({"bsdf": "rough_conductor", "eta": eta, "k": k, "alpha": ALPHA,
            "multiple_scattering": false});
        if film {
            body["film"] = self::film();
        }
        body
    };
    let face = |waves: f64| {
        move |cos: f64| {
            let (m00, block) = filmed_conductor(cos, &Film { waves, ..FILM }, INDEX);
            [m00, block.a]
        }
    };
    let [bare, filmed] = [expected(45.0, face(0.0)), expected(45.0, face(FILM.waves))];
    assert!((bare[0] - filmed[0]).abs() > 0.05, "the test cannot fail: {bare:?} {filmed:?}");
    check("bare", seen(body(false), 45.0), bare);
    check("filmed", seen(body(true), 45.0), filmed);
}
