//! Progressive photon mapping converges as its radius schedule says (Knaus and Zwicker 2011).
//!
//! With n iterations the variance of the image goes as n^-alpha, on surfaces and in media, and the
//! bias as the mean square of the radius: n^(alpha - 1) on surfaces. A point light in the center
//! of a ball of glass makes light that connections cannot find and whose intensity on the floor
//! has a closed form. Each slope is fitted to the logarithms of error and iterations, both exact
//! in the mean; the errors of the fits over 24 seeds are below 0.01, so that the limit of 0.05 is
//! five of them. The plot is left in the scratch folder.

#[allow(dead_code, reason = "every test binary uses its own part")]
mod support;

use std::fmt::Write;
use std::fs;

use glam::Vec3;
use serde_json::json;
use sunstone::integrators::{Integrator, Mode, Photons, Settings};
use sunstone::scattering::Scene;
use sunstone::scene::World;

use support::gltf::Document;
use support::rendering::{MONO, image, scene, settings};

const EDGE: u32 = 8;
/// Numbers of iterations whose errors are compared.
const ITERATIONS: [u32; 6] = [32, 64, 128, 256, 512, 1024];
const SEEDS: u32 = 24;
/// What slopes may differ from theory.
const LIMIT: f64 = 0.05;

const LIGHT: Vec3 = Vec3::new(0.0, 0.8, 0.0);
const INTENSITY: f32 = 5.0;
const REFLECTANCE: f32 = 0.5;
/// Half the edge of the picture, and where its middle is on the floor.
const HALF: f32 = 0.25;
const MIDDLE: Vec3 = Vec3::new(0.9, 0.0, 0.0);

/// The camera looks down on a square of the floor beside the ball.
fn lamp(in_fog: bool) -> World {
    let mut document = Document::default();
    let floor = document.diffuse(REFLECTANCE);
    document.quad(Vec3::ZERO, Vec3::Z * 8.0, Vec3::X * 8.0, floor);
    let glass = document.material(json!({"bsdf": "dielectric", "ior": 1.5}));
    document.sphere(LIGHT, 0.2, glass);
    let point = json!({"type": "point", "intensity": INTENSITY});
    document.light(point, LIGHT, Vec3::NEG_Z);
    if in_fog {
        let fog = document.medium(json!({"sigma_a": 0.0, "sigma_s": 0.5, "phase": "isotropic"}));
        document.fill(fog);
    }
    document.up(Vec3::Z);
    document.orthographic(MIDDLE + Vec3::Y, MIDDLE, HALF);
    document.load("lamp")
}

/// What `iterations` iterations make of every pixel.
fn render(scene: &Scene<1>, photons: Photons, seed: u32, iterations: u32) -> Vec<f64> {
    // Four segments: the light leaves the ball at once or after one reflection inside.
    let settings = settings(Integrator::Ppm, Mode::Polarized, MONO, iterations, 4);
    let seed = settings.seed + 7919 * seed;
    let image = image(scene, &Settings { photons, seed, ..settings });
    image.planes[0].iter().map(|&value| f64::from(value)).collect()
}

/// Radiance of the floor at the middle of every pixel. A share R = 0.04 of the light is reflected
/// at each pass of the glass; what comes out first and second counts, 1 - R + R (1 - R).
fn radiance(scene: &Scene<1>) -> Vec<f64> {
    let share = 1.0 - 0.04_f64 * 0.04;
    let pixels = (0..EDGE * EDGE).map(|pixel| [pixel % EDGE, pixel / EDGE]);
    pixels
        .map(|[column, line]| {
            let film = [column, line].map(|x| sunstone::math::F32s::splat(x as f32 + 0.5));
            let (origin, _, _) = scene.sensor.rays(film, || film);
            let [x, z] = [origin.x, origin.z].map(|lanes| f64::from(lanes.to_array()[0]));
            let height = f64::from(LIGHT.y);
            let distance2 = x * x + z * z + height * height;
            let irradiance = f64::from(INTENSITY) * height / distance2.powf(1.5);
            f64::from(REFLECTANCE) * std::f64::consts::FRAC_1_PI * irradiance * share
        })
        .collect()
}

/// Root mean squares over the pixels of noise and bias, relative to the light; `truth` may be
/// missing.
struct Errors {
    noise: f64,
    bias: f64,
}

fn errors(scene: &Scene<1>, photons: Photons, iterations: u32, truth: Option<&[f64]>) -> Errors {
    let images: Vec<Vec<f64>> =
        (0..SEEDS).map(|seed| render(scene, photons, seed, iterations)).collect();
    let pixels = images[0].len();
    let (mut noise, mut bias, mut light) = (0.0, 0.0, 0.0);
    for pixel in 0..pixels {
        let mean = images.iter().map(|image| image[pixel]).sum::<f64>() / f64::from(SEEDS);
        let square = |image: &Vec<f64>| (image[pixel] - mean).powi(2);
        let variance = images.iter().map(square).sum::<f64>() / f64::from(SEEDS - 1);
        noise += variance;
        light += mean * mean;
        if let Some(truth) = truth {
            // The mean over the seeds has noise of its own.
            bias += (mean - truth[pixel]).powi(2) - variance / f64::from(SEEDS);
        }
    }
    Errors { noise: (noise / light).sqrt(), bias: (bias.max(0.0) / light).sqrt() }
}

/// Least squares through the logarithms.
fn slope(points: &[(f64, f64)]) -> f64 {
    let logarithms = points.iter().map(|(x, y)| (x.ln(), y.ln()));
    let count = points.len() as f64;
    let mean_x = logarithms.clone().map(|(x, _)| x).sum::<f64>() / count;
    let mean_y = logarithms.clone().map(|(_, y)| y).sum::<f64>() / count;
    let products = logarithms.clone().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum::<f64>();
    products / logarithms.map(|(x, _)| (x - mean_x).powi(2)).sum::<f64>()
}

/// A curve of the plot: name, measured points and the slope that they should have.
struct Curve {
    name: String,
    points: Vec<(f64, f64)>,
    theory: f64,
}

/// Errors over iterations on logarithmic axes, as SVG, with lines of the slopes of theory.
fn plot(curves: &[Curve]) -> String {
    let x = |n: f64| 70.0 + 70.0 * (n / 16.0).log2();
    let y = |error: f64| 40.0 - 90.0 * error.log10();
    let mut svg = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"760\" height=\"420\" \
         font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"760\" height=\"420\" fill=\"white\"/>\n\
         <text x=\"250\" y=\"412\">iterations</text>\n\
         <text x=\"12\" y=\"20\">relative error</text>\n",
    );
    for n in [16.0, 32.0, 64.0, 128.0, 256.0, 512.0, 1024.0] {
        let at = x(n);
        let _ = writeln!(
            svg,
            "<path d=\"M{at} 40V380\" stroke=\"#ddd\"/><text x=\"{at}\" y=\"395\">{n}</text>"
        );
    }
    for exponent in 0..4 {
        let at = y(10_f64.powi(-exponent));
        let _ = writeln!(
            svg,
            "<path d=\"M70 {at}H490\" stroke=\"#ddd\"/><text x=\"12\" y=\"{at}\">1e-{exponent}</text>"
        );
    }
    for (index, curve) in curves.iter().enumerate() {
        let color = ["#1b4f9c", "#c4621a", "#2b8a3e", "#8b2fa0"][index % 4];
        let (first, last) = (curve.points[0], curve.points[curve.points.len() - 1]);
        let end = first.1 * (last.0 / first.0).powf(curve.theory);
        let _ = writeln!(
            svg,
            "<path d=\"M{} {}L{} {}\" stroke=\"{color}\" stroke-dasharray=\"5 4\"/>",
            x(first.0),
            y(first.1),
            x(last.0),
            y(end)
        );
        for (n, error) in &curve.points {
            let (x, y) = (x(*n), y(*error));
            let _ = writeln!(svg, "<circle cx=\"{x}\" cy=\"{y}\" r=\"4\" fill=\"{color}\"/>");
        }
        let found = slope(&curve.points);
        let _ = writeln!(
            svg,
            "<text x=\"500\" y=\"{}\" fill=\"{color}\">{}: {found:.3}, theory {:.3}</text>",
            y(last.1) + 4.0,
            curve.name,
            curve.theory
        );
    }
    svg + "</svg>\n"
}

fn photons(per_iteration: u32, radius: f32, alpha: f32) -> Photons {
    Photons { per_iteration, samples: 1, alpha, radius: Some(radius) }
}

/// The error of every number of iterations.
fn curve(name: &str, theory: f64, error: impl Fn(u32) -> f64) -> Curve {
    let points = ITERATIONS.map(|n| (f64::from(n), error(n))).to_vec();
    Curve { name: name.to_owned(), points, theory }
}

#[test]
fn errors_fall_as_the_schedule_says() {
    let size = [EDGE; 2];
    let (floor, fog) = (scene::<1>(&lamp(false), MONO, size), scene::<1>(&lamp(true), MONO, size));
    let truth = radiance(&floor);
    // Small kernels, so that the noise of the photons is that of the image.
    let noise = |alpha: f32| {
        let photons = photons(3_000, 0.05, alpha);
        move |scene: &Scene<1>, n: u32| errors(scene, photons, n, None).noise
    };
    let [slow, fast] = [0.5_f32, 0.8].map(noise);
    // A large kernel over a floor that grows dark with distance.
    let biased = photons(20_000, 0.35, 0.6);
    let curves = [
        curve("noise, alpha 0.5", -0.25, |n| slow(&floor, n)),
        curve("noise, alpha 0.8", -0.4, |n| fast(&floor, n)),
        curve("noise in fog, alpha 0.5", -0.25, |n| slow(&fog, n)),
        curve("bias, alpha 0.6", -0.4, |n| errors(&floor, biased, n, Some(&truth)).bias),
    ];
    let file = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("convergence.svg");
    fs::write(&file, plot(&curves)).expect("the scratch folder can be written to");
    let mut wrong = Vec::new();
    for curve in &curves {
        let found = slope(&curve.points);
        let line = format!("{}: {found:.3}, theory {:.3}", curve.name, curve.theory);
        println!("{line}, {:?}", curve.points);
        if (found - curve.theory).abs() > LIMIT {
            wrong.push(line);
        }
    }
    assert!(wrong.is_empty(), "{}\nsee {}", wrong.join("\n"), file.display());
}
