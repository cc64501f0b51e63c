//! What absorbs attenuates paths and does not end them: light through colored glass and ink, its
//! value and its noise, against Bouguer's law.
//!
//! Some 50 means are scored. A normal number exceeds the limit of 5 with a chance of 6e-7, so that
//! noise fails the tests in 1 of 30,000 cases. Variances are compared with those that follow from
//! the probabilities with which paths pass; each is the mean of some 2,000 squares, and its limit
//! at least six standard deviations above.

use glam::Vec3;
use serde_json::json;
use sunstone::internals::image::StokesImage;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::Mode;
use sunstone::internals::scene::World;
use sunstone::internals::spectrum::Color;

use crate::support::gltf::Document;
use crate::support::rendering::{MONO, replicates, scene, settings};
use crate::support::statistics::{Estimate, ROUNDING, estimate, worst};

const EDGE: u32 = 8;
const PIXELS: usize = (EDGE * EDGE) as usize;
const SAMPLES: u32 = 64;
const REPLICATES: u32 = 32;
const LIMIT: f64 = 5.0;

/// Coefficients per channel; blocks are 1 thick.
struct Filling {
    sigma_a: [f64; 3],
    sigma_s: [f64; 3],
}

impl Filling {
    fn sigma_t(&self, channel: usize) -> f64 {
        self.sigma_a[channel] + self.sigma_s[channel]
    }
}

/// Blocks one before the other, seen by parallel rays against z, before a wall of radiance 1 and
/// in the dark otherwise.
fn blocks(name: &str, bsdf: &str, fillings: &[&Filling]) -> World {
    let mut document = Document::default();
    let boundary = document.material(json!({"bsdf": bsdf}));
    for (&Filling { sigma_a, sigma_s }, place) in fillings.iter().zip(0_u8..) {
        let medium = document.medium(json!({"sigma_a": sigma_a, "sigma_s": sigma_s,
            "phase": "isotropic"}));
        let center = Vec3::Z * (-1.5 * f32::from(place));
        document.around(Some(medium), None, |document| {
            document.cuboid(center, Vec3::new(2.0, 2.0, 0.5), boundary);
        });
    }
    let wall = document.material(json!({"bsdf": "absorber"}));
    let wall = document.emits(wall, 1.0);
    document.quad(Vec3::Z * -6.0, Vec3::X * 9.0, Vec3::Y * 9.0, wall);
    document.orthographic(Vec3::Z * 3.0, Vec3::ZERO, 0.5);
    document.load(name)
}

/// Images of the light that comes through within so many segments.
fn images<const N: usize>(world: &World, color: Color, segments: u32) -> Vec<StokesImage> {
    let scene = scene::<N>(world, color.clone(), [EDGE; 2]);
    let options = settings(Integrator::Path, Mode::Scalar, color, SAMPLES, segments);
    replicates(&scene, &options, REPLICATES)
}

/// The mean over pixels of the variance of one sample, over the square of the mean.
fn noise(images: &[StokesImage], channel: usize, mean: f64) -> f64 {
    let variance = |pixel: usize| estimate(images, channel, &[pixel]).variance;
    let of_mean = (0..PIXELS).map(variance).sum::<f64>() / PIXELS as f64;
    of_mean * f64::from(REPLICATES * SAMPLES) / (mean * mean)
}

const EVERYWHERE: [usize; PIXELS] = {
    let mut all = [0; PIXELS];
    let mut pixel = 0;
    while pixel < PIXELS {
        all[pixel] = pixel;
        pixel += 1;
    }
    all
};

/// No path dies in what only absorbs, so that nothing is left to chance.
#[test]
fn what_only_absorbs_makes_no_noise() {
    let filling = Filling { sigma_a: [0.5, 6.0, 30.0], sigma_s: [0.0; 3] };
    let world = blocks("absorbing fog", "null", &[&filling]);
    for image in images::<3>(&world, Color::Rgb, 4) {
        for channel in 0..3 {
            let exact = (-filling.sigma_t(channel)).exp();
            for &value in &image.planes[channel] {
                let error = (f64::from(value) / exact - 1.0).abs();
                assert!(error < ROUNDING, "{value} for {exact}");
            }
        }
    }
}

/// Behind glass, only what is reflected is: a sample is (1 - R)^2 often exp(-depth), and further
/// passes weigh nothing beside it.
#[test]
fn colored_glass_is_as_noisy_as_clear_glass() {
    for depth in [0.5, 2.0, 6.0, 12.0] {
        let filling = Filling { sigma_a: [depth; 3], sigma_s: [0.0; 3] };
        let world = blocks(&format!("glass of depth {depth}"), "dielectric", &[&filling]);
        let images = images::<1>(&world, MONO, 64);
        let (reflected, passed) = (0.04, (-depth).exp());
        let through = |passed: f64| {
            (1.0_f64 - reflected).powi(2) * passed / (1.0 - (reflected * passed).powi(2))
        };
        let mean = through(passed);
        let score = estimate(&images, 0, &EVERYWHERE).score(&Estimate::exact(mean), mean);
        let (found, right) =
            (noise(&images, 0, mean), through(passed * passed) / mean.powi(2) - 1.0);
        println!("{depth}: score {score:.2?}, variance {found:.4} for {right:.4}");
        assert!(score.is_none_or(|score| score.abs() < LIMIT), "{depth}: {score:?}");
        assert!(found < 1.2 * right, "{depth}: {found} for {right}");
    }
}

/// What comes straight through is Bouguer's law, whatever else is drawn, at wavelengths together
/// and through several pieces; the variance of a pixel is that of passing with the probability
/// exp(-sigma_d) or more. By extinction it would be exp(sigma_t) - 1: 402 for 2.8 in the thick ink.
#[test]
fn what_scatters_little_is_looked_through() {
    let thick = Filling { sigma_a: [5.7; 3], sigma_s: [0.3; 3] };
    let thin = Filling { sigma_a: [0.9; 3], sigma_s: [0.1; 3] };
    let mixed = Filling { sigma_a: [0.4, 2.0, 5.0], sigma_s: [0.6, 0.1, 0.0] };
    let white = Filling { sigma_a: [0.0; 3], sigma_s: [0.5; 3] };
    let sets: [&[&Filling]; 4] = [&[&thick], &[&thin, &mixed], &[&mixed], &[&white, &mixed, &thin]];
    for (set, fillings) in sets.into_iter().enumerate() {
        let world = blocks(&format!("ink {set}"), "null", fillings);
        let images = images::<3>(&world, Color::Rgb, 1);
        for channel in 0..3 {
            let depth: f64 = fillings.iter().map(|filling| filling.sigma_t(channel)).sum();
            let drawn: f64 = (fillings.iter())
                .map(|filling| (filling.sigma_s[channel] * filling.sigma_t(channel)).sqrt())
                .sum();
            let exact = (-depth).exp();
            let score =
                estimate(&images, channel, &EVERYWHERE).score(&Estimate::exact(exact), exact);
            let found = noise(&images, channel, exact);
            println!("{set}, {channel}: score {score:.2?}, variance {found:.3}, drawn {drawn:.3}");
            assert!(score.is_none_or(|score| score.abs() < LIMIT), "{set}: {score:?}");
            if set == 0 {
                assert!(found < 1.2 * drawn.exp_m1(), "{found} for {}", drawn.exp_m1());
            }
        }
    }
}

/// All orders of scattering, between lamps and walls that a medium fills, against each other.
#[test]
fn integrators_agree_in_what_absorbs_and_scatters() {
    for (name, sigma_a, sigma_s) in
        [("dark", [1.0, 2.0, 0.5], [0.05, 0.0, 0.5]), ("bright", [0.05, 0.2, 0.0], [1.0, 0.4, 0.5])]
    {
        let mut document = Document::default();
        let medium = document.medium(json!({"sigma_a": sigma_a, "sigma_s": sigma_s,
            "phase": "rayleigh"}));
        document.fill(medium);
        let wall = document.diffuse(0.6);
        document.room([wall; 6], &[]);
        let lamp = document.material(json!({"bsdf": "absorber"}));
        let lamp = document.emits(lamp, 5.0);
        let lamp = document.two_sided(lamp);
        document.quad(Vec3::Y * 0.6, Vec3::Z * 0.4, Vec3::X * 0.4, lamp);
        document.perspective(Vec3::Z * 0.9, Vec3::ZERO, 0.9, None);
        let world = document.load(&format!("absorbing room, {name}"));
        let scene = scene::<3>(&world, Color::Rgb, [EDGE; 2]);
        for mode in [Mode::Scalar, Mode::Polarized] {
            let found = [Integrator::Path, Integrator::Bdpt, Integrator::Ppm].map(|integrator| {
                let options = settings(integrator, mode, Color::Rgb, 32, 8);
                let images = replicates(&scene, &options, 16);
                [0, 1, 2].map(|channel| estimate(&images, channel, &EVERYWHERE))
            });
            let mut scores = Vec::new();
            for other in &found[1..] {
                for (a, b) in found[0].iter().zip(other) {
                    scores.extend(a.score(b, a.mean));
                }
            }
            println!("{name}, {mode:?}: {scores:.2?}");
            assert_eq!(scores.len(), 6);
            assert!(worst(&scores) < LIMIT, "{name}, {mode:?}: {scores:?}");
        }
    }
}
