//! Progressive photon mapping converges as its radius schedule says (Knaus and Zwicker 2011).
//!
//! A kernel whose size (area or volume) is p(i) times the first in iteration i makes noise whose
//! variance goes as the sum of 1 / p(i) over n^2, n^-alpha in the limit, and on surfaces a bias
//! that goes as the mean of p(i), n^(alpha - 1) in the limit. A spot light in the center of a
//! ball of glass makes light that connections cannot find, and whose intensity on the floor has a
//! closed form. Slopes are fitted to the logarithms of error over iterations, those that are
//! measured and those of theory. The quick test fits over fewer iterations and seeds; each leaves
//! a plot in the scratch folder.

use std::cmp::Ordering;
use std::fmt::Write;
use std::fs;
use std::ops::ControlFlow;
use std::sync::Arc;

use glam::Vec3;
use serde_json::json;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::math::F32s;
use sunstone::internals::render::{Mode, Options, Photons, Renderer, Settings};
use sunstone::internals::scattering::Scene;
use sunstone::internals::scene::World;

use crate::support::gltf::Document;
use crate::support::rendering::{MONO, scene, settings};

const EDGE: u32 = 8;
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
    // Wide enough for all photons within reach of the picture.
    let cone = json!({"innerConeAngle": 0.85, "outerConeAngle": 0.87});
    let spot = json!({"type": "spot", "intensity": INTENSITY, "spot": cone});
    document.light(spot, LIGHT, MIDDLE - LIGHT);
    if in_fog {
        let fog = document.medium(json!({"sigma_a": 0.0, "sigma_s": 0.5, "phase": "isotropic"}));
        document.fill(fog);
    }
    document.up(Vec3::Z);
    document.orthographic(MIDDLE + Vec3::Y, MIDDLE, HALF);
    document.load("lamp")
}

/// How long a comparison is: seeds, and the numbers of iterations, doubled from the first on.
#[derive(Clone, Copy)]
struct Effort {
    seeds: u32,
    first: u32,
    doublings: u32,
}

impl Effort {
    fn iterations(self) -> Vec<u32> {
        (0..=self.doublings).map(|doubling| self.first << doubling).collect()
    }
}

/// What each of the numbers of iterations makes of every pixel, from one render.
fn render(scene: &Arc<Scene<1>>, photons: Photons, seed: u32, iterations: &[u32]) -> Vec<Vec<f64>> {
    let last = iterations[iterations.len() - 1];
    // Four segments: the light leaves the ball at once, or on the other side after a reflection.
    let settings = settings(Integrator::Ppm, Mode::Polarized, MONO, last, 4);
    let seed = settings.seed + 7919 * seed;
    let settings =
        Settings::new(Options { photons, seed, ..settings.clone() }).expect("sound options");
    let mut images = Vec::new();
    Renderer::of(Arc::clone(scene), &settings).run(|so_far| {
        if iterations.contains(&so_far.samples) {
            let image = so_far.preview();
            images.push(image.planes[0].iter().map(|&value| f64::from(value)).collect());
        }
        ControlFlow::Continue(())
    });
    images
}

/// Mean radiance of the floor in every pixel. A share of 0.04 of the light is reflected inside the
/// glass and does not come this way within the path length.
fn radiance(scene: &Scene<1>) -> Vec<f64> {
    const POINTS: u32 = 8;
    let mut means = vec![0.0; (EDGE * EDGE) as usize];
    for point in 0..EDGE * EDGE * POINTS * POINTS {
        let [column, line] = [point % (EDGE * POINTS), point / (EDGE * POINTS)];
        let film = [column, line].map(|x| F32s::splat((x as f32 + 0.5) / POINTS as f32));
        let (origin, _, _) = scene.sensor.rays(film, || film);
        let [x, z] = [origin.x, origin.z].map(|lanes| f64::from(lanes.to_array()[0]));
        let height = f64::from(LIGHT.y);
        let distance2 = x * x + z * z + height * height;
        let irradiance = 0.96 * f64::from(INTENSITY) * height / distance2.powf(1.5);
        let radiance = f64::from(REFLECTANCE) * std::f64::consts::FRAC_1_PI * irradiance;
        let pixel = line / POINTS * EDGE + column / POINTS;
        means[pixel as usize] += radiance / f64::from(POINTS * POINTS);
    }
    means
}

/// Root mean square over the pixels, relative to the light, of the noise or, where the truth is
/// known, of the bias.
fn error(images: &[&Vec<f64>], truth: Option<&[f64]>) -> f64 {
    let seeds = images.len() as f64;
    let (mut noise, mut bias, mut light) = (0.0, 0.0, 0.0);
    for pixel in 0..images[0].len() {
        let mean = images.iter().map(|image| image[pixel]).sum::<f64>() / seeds;
        let square = |image: &&Vec<f64>| (image[pixel] - mean).powi(2);
        let variance = images.iter().map(square).sum::<f64>() / (seeds - 1.0);
        noise += variance;
        light += mean * mean;
        // The mean over the seeds has noise of its own.
        let off = truth.map_or(0.0, |truth| mean - truth[pixel]);
        bias += off * off - variance / seeds;
    }
    (if truth.is_some() { bias.max(0.0) } else { noise } / light).sqrt()
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

/// A curve of the plot: name, measured points, and the slope of theory between them.
struct Curve {
    name: String,
    points: Vec<(f64, f64)>,
    theory: f64,
}

/// Sizes of the kernel relative to the first (Knaus and Zwicker, equation 15).
fn sizes(alpha: f32, iterations: u32) -> impl Iterator<Item = f64> {
    let alpha = f64::from(alpha);
    (0..iterations).scan(1.0, move |size, i| {
        if i > 0 {
            *size *= (f64::from(i) + alpha) / (f64::from(i) + 1.0);
        }
        Some(*size)
    })
}

/// Noise after some iterations, up to a factor.
fn noise_in_theory(alpha: f32, n: u32) -> f64 {
    sizes(alpha, n).map(f64::recip).sum::<f64>().sqrt() / f64::from(n)
}

/// Bias on surfaces after some iterations, up to a factor.
fn bias_in_theory(alpha: f32, n: u32) -> f64 {
    sizes(alpha, n).sum::<f64>() / f64::from(n)
}

/// Errors over iterations on logarithmic axes, as SVG, with lines of the slopes of theory.
fn plot(curves: &[Curve]) -> String {
    let x = |n: f64| 70.0 + 60.0 * (n / 8.0).log2();
    let y = |error: f64| 40.0 - 90.0 * error.log10();
    let mut svg = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"760\" height=\"420\" \
         font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"760\" height=\"420\" fill=\"white\"/>\n\
         <text x=\"250\" y=\"412\">iterations</text>\n\
         <text x=\"12\" y=\"20\">relative error</text>\n",
    );
    for n in [8.0, 16.0, 32.0, 64.0, 128.0, 256.0, 512.0, 1024.0] {
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
            "<path d=\"M70 {at}H490\" stroke=\"#ddd\"/>\n\
             <text x=\"12\" y=\"{at}\">1e-{exponent}</text>"
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
    Photons { per_iteration: Some(per_iteration), samples: Some(1), alpha, radius: Some(radius) }
}

/// Measures noise or, if the truth is given, bias.
fn measure(
    name: &str,
    scene: &Arc<Scene<1>>,
    photons: Photons,
    truth: Option<&[f64]>,
    effort: Effort,
) -> Curve {
    let iterations = effort.iterations();
    let renders: Vec<Vec<Vec<f64>>> =
        (0..effort.seeds).map(|seed| render(scene, photons, seed, &iterations)).collect();
    let theory = if truth.is_some() { bias_in_theory } else { noise_in_theory };
    let (mut points, mut expected) = (Vec::new(), Vec::new());
    for (index, &n) in iterations.iter().enumerate() {
        let images: Vec<&Vec<f64>> = renders.iter().map(|images| &images[index]).collect();
        points.push((f64::from(n), error(&images, truth)));
        expected.push((f64::from(n), theory(photons.alpha, n)));
    }
    let name = format!("{name}, alpha {}", photons.alpha);
    Curve { name, points, theory: slope(&expected) }
}

fn check(file: &str, curves: &[Curve]) {
    let file = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(file);
    fs::write(&file, plot(curves)).expect("the scratch folder can be written to");
    let mut wrong = Vec::new();
    for curve in curves {
        let found = slope(&curve.points);
        let line = format!("{}: {found:.3}, theory {:.3}", curve.name, curve.theory);
        println!("{line}, {:?}", curve.points);
        // Not a number where there was nothing to measure.
        if (found - curve.theory).abs().partial_cmp(&LIMIT) != Some(Ordering::Less) {
            wrong.push(line);
        }
    }
    assert!(wrong.is_empty(), "{}\nsee {}", wrong.join("\n"), file.display());
}

/// A kernel so small that the noise of the photons is that of the image.
fn noisy(alpha: f32) -> Photons {
    photons(3_000, 0.05, alpha)
}

fn lamps() -> [Arc<Scene<1>>; 2] {
    [false, true].map(|in_fog| scene::<1>(&lamp(in_fog), MONO, [EDGE; 2]))
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn noise_falls_as_the_schedule_says() {
    let [floor, fog] = lamps();
    let effort = Effort { seeds: 24, first: 8, doublings: 3 };
    let curves = [
        measure("noise", &floor, noisy(0.5), None, effort),
        measure("noise in fog", &fog, noisy(0.8), None, effort),
    ];
    check("convergence.svg", &curves);
}

#[test]
#[ignore = "minutes: 1,024 iterations, to be run before a release"]
fn errors_fall_as_the_schedule_says_at_full_length() {
    let [floor, fog] = lamps();
    let truth = radiance(&floor);
    let effort = Effort { seeds: 24, first: 32, doublings: 5 };
    // A large kernel over a floor that grows dark with distance.
    let biased = photons(12_000, 0.3, 0.6);
    let curves = [
        measure("noise", &floor, noisy(0.5), None, effort),
        measure("noise", &floor, noisy(0.8), None, effort),
        measure("noise in fog", &fog, noisy(0.5), None, effort),
        measure("bias", &floor, biased, Some(&truth), effort),
    ];
    check("convergence-full.svg", &curves);
}
