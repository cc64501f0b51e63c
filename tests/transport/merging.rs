//! Photon mapping where it was wrong: at boundaries of media, in dense ones and in those that
//! scatter forwards, behind thin walls, beside closed boxes and close to lamps.
//!
//! Means are within 5 standard errors of the truth, or of what path tracing finds, beside the bias
//! that the kernel may have after so few iterations, which is stated (some ten numbers: by
//! Student's t of 15 degrees of freedom, a change of all random numbers fails by chance in 1 of
//! 600).

use glam::Vec3;
use serde_json::{Value, json};
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Mode, Options, Photons};
use sunstone::internals::scene::World;

use crate::support::gltf::Document;
use crate::support::rendering::{MONO, image, replicates, scene, settings};
use crate::support::statistics::{Estimate, estimate};

const SIZE: [u32; 2] = [8, 8];
const REPLICATES: u32 = 16;
const STANDARD_ERRORS: f64 = 5.0;

/// How much a render does.
#[derive(Clone, Copy)]
struct Effort {
    iterations: u32,
    photons: u32,
    path_length: u32,
}

fn options(integrator: Integrator, effort: Effort) -> Options {
    let Effort { iterations, photons, path_length } = effort;
    let options = settings(integrator, Mode::Scalar, MONO, iterations, path_length);
    let photons = Photons { per_iteration: Some(photons), samples: Some(1), ..Photons::default() };
    Options { photons, ..options }
}

/// The mean of S0 over the film.
fn mean(world: &World, integrator: Integrator, effort: Effort) -> Estimate {
    let scene = scene::<1>(world, MONO, SIZE);
    let images = replicates(&scene, &options(integrator, effort), REPLICATES);
    let pixels: Vec<usize> = (0..(SIZE[0] * SIZE[1]) as usize).collect();
    estimate(&images, 0, &pixels)
}

/// Expects what photons find to be `truth`, but for noise and a share of `bias`. `error_max` keeps
/// the test sharp.
fn check(what: &str, found: Estimate, truth: Estimate, [bias, error_max]: [f64; 2]) {
    let error = (found.variance + truth.variance).sqrt();
    println!("{what}: {:.5} +- {error:.5}, should be {:.5}", found.mean, truth.mean);
    assert!(error < error_max * truth.mean, "{what}: an error of {error}");
    let off = (found.mean - truth.mean).abs();
    let allowed = bias * truth.mean + STANDARD_ERRORS * error;
    assert!(off < allowed, "{what}: {} for {}, {error}", found.mean, truth.mean);
}

/// What stands in surroundings of radiance 1, seen from outside.
fn in_surroundings(medium: Value, shape: impl FnOnce(&mut Document, usize)) -> World {
    let mut document = Document::default();
    let medium = document.medium(medium);
    document.fog(medium, shape);
    document.environment(1.0);
    document.perspective(Vec3::new(0.7, 0.9, 3.0), Vec3::ZERO, 0.3, None);
    document.load("furnace")
}

/// All that comes in goes out again, and kernels hold no less of it at the boundary.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn fog_is_invisible_in_a_furnace_at_32_iterations() {
    let effort = Effort { iterations: 32, photons: 10_000, path_length: 400 };
    for sigma in [4, 15] {
        let fog = json!({"phase": "isotropic", "sigma_a": 0, "sigma_s": sigma});
        let cube = in_surroundings(fog.clone(), |document, null| {
            document.cuboid(Vec3::ZERO, Vec3::splat(0.5), null);
        });
        let ball = in_surroundings(fog, |document, null| document.sphere(Vec3::ZERO, 0.6, null));
        for (shape, world) in [("cube", cube), ("ball", ball)] {
            let found = mean(&world, Integrator::Ppm, effort);
            check(&format!("{shape} {sigma}"), found, Estimate::exact(1.0), [0.01, 0.005]);
        }
    }
}

/// Photons hardly ever come along the way in which such media send light to the sensor.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn media_that_scatter_forwards_are_invisible_in_a_furnace() {
    let size = json!({"kind": "monodisperse", "radius_um": 17.5});
    let (air, droplets) =
        (json!({"eta": 1.0}), json!({"distribution": size, "eta": 1.33, "volume_fraction": 1e-6}));
    let media = [
        json!({"phase": "hg", "g": 0.99, "sigma_a": 0, "sigma_s": 5}),
        json!({"phase": "hg", "g": 0.999, "sigma_a": 0, "sigma_s": 5}),
        json!({"phase": "mie", "particles": [droplets], "host": air, "sigma_a": 0, "sigma_s": 5}),
    ];
    let effort = Effort { iterations: 32, photons: 1_000, path_length: 400 };
    for medium in media {
        let what = medium.to_string();
        let world = in_surroundings(medium, |document, null| {
            document.cuboid(Vec3::ZERO, Vec3::splat(0.6), null);
        });
        let found = mean(&world, Integrator::Ppm, effort);
        check(&what, found, Estimate::exact(1.0), [0.0, 0.004]);
    }
}

/// Light in the peak of a phase function is found by paths that go on and the rest by photons,
/// each once: of a lamp at the side and of one behind, whose light is scattered by little.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn peaks_of_phase_functions_are_as_bright_as_path_tracing_says() {
    for (g, error_max) in [(0.5, 0.008), (0.85, 0.014)] {
        let mut document = Document::default();
        let fog = json!({"phase": "hg", "g": g, "sigma_a": 0.2, "sigma_s": 4});
        let fog = document.medium(fog);
        document.fog(fog, |document, null| document.cuboid(Vec3::ZERO, Vec3::splat(0.5), null));
        let black = document.diffuse(0.0);
        let glow = document.emits(black, 5.0);
        document.quad(Vec3::new(0.0, 1.5, 0.0), Vec3::X * 0.5, Vec3::Z * 0.5, glow);
        document.quad(Vec3::new(0.3, 0.2, -1.5), Vec3::X * 0.5, Vec3::Y * 0.5, glow);
        document.perspective(Vec3::new(0.7, 0.9, 3.0), Vec3::ZERO, 0.3, None);
        let world = document.load("peak");
        let effort = Effort { iterations: 32, photons: 10_000, path_length: 50 };
        let truth = mean(&world, Integrator::Path, Effort { iterations: 512, ..effort });
        let found = mean(&world, Integrator::Ppm, effort);
        check(&format!("a peak of {g}"), found, truth, [0.01, error_max]);
    }
}

/// Where mean free paths are so short that kernels hold no photons, paths go on.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn dense_media_in_glass_are_as_bright_as_path_tracing_says() {
    for sigma in [100.0, 1e3, 1e5] {
        let mut document = Document::default();
        let (sigma_a, sigma_s) = (0.1 * sigma, 0.9 * sigma);
        let paint = json!({"phase": "isotropic", "sigma_a": sigma_a, "sigma_s": sigma_s});
        let paint = document.medium(paint);
        let glass = document.material(json!({"bsdf": "dielectric", "ior": 1.33}));
        document.around(Some(paint), None, |document| {
            document.cuboid(Vec3::ZERO, Vec3::splat(0.05), glass);
        });
        document.environment(1.0);
        document.perspective(Vec3::new(0.3, 0.25, 0.1), Vec3::ZERO, 0.1, None);
        let world = document.load("paint");
        let effort = Effort { iterations: 16, photons: 20_000, path_length: 100 };
        let truth = mean(&world, Integrator::Path, Effort { iterations: 128, ..effort });
        let found = mean(&world, Integrator::Ppm, effort);
        check(&format!("paint of {sigma}"), found, truth, [0.02, 0.01]);
    }
}

/// Two rooms on one floor, a lamp in one of them; the other stays black to the last bit.
#[test]
fn no_light_leaks_through_a_wall() {
    for thickness in [1e-3, 0.01, 0.05, 0.2] {
        let mut document = Document::default();
        let white = document.diffuse(0.7);
        let white = document.two_sided(white);
        document.room([white; 6], &[]);
        for x in [0.0, thickness] {
            document.quad(Vec3::X * x, Vec3::Y, Vec3::Z, white);
        }
        let lamp = json!({"type": "point", "intensity": 10.0});
        document.light(lamp, Vec3::new(-0.5, 0.1, 0.0), Vec3::X);
        document.perspective(Vec3::new(0.9, 0.2, 0.1), Vec3::new(0.0, -0.4, 0.0), 1.5, None);
        let world = document.load("two rooms");
        let effort = Effort { iterations: 4, photons: 20_000, path_length: 16 };
        let scene = scene::<1>(&world, MONO, [16, 16]);
        let dark = image(&scene, &options(Integrator::Ppm, effort));
        let brightest = dark.planes[0].iter().copied().fold(0.0, f32::max);
        assert_eq!(brightest, 0.0, "behind {thickness} m");
    }
}

/// A white body of about 0.1 in a room of 2, seen from so far that its image has the size `share`
/// of the film's.
fn in_a_room(share: f32, body: impl FnOnce(&mut Document, usize)) -> World {
    let mut document = Document::default();
    let wall = document.diffuse(0.5);
    document.room([wall; 6], &[]);
    let glow = document.material(json!({"bsdf": "absorber"}));
    let glow = document.emits(glow, 10.0);
    document.quad(Vec3::new(0.0, 0.99, 0.0), 0.3 * Vec3::X, 0.3 * Vec3::Z, glow);
    let white = document.diffuse(0.8);
    body(&mut document, white);
    document.perspective(Vec3::new(0.0, 0.1, 0.9), Vec3::ZERO, 0.11 / share, None);
    document.load("small body")
}

/// Kernels end where surfaces do, and are no larger than what is seen: what is small against the
/// distances of photons is as bright as large things are.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn small_bodies_are_as_bright_as_path_tracing_says() {
    type Body = fn(&mut Document, usize);
    let bodies: [(&str, Body); 4] = [
        ("sphere", |document, white| document.sphere(Vec3::ZERO, 0.05, white)),
        ("mesh", |document, white| document.ball(Vec3::ZERO, 0.05, 12, white)),
        ("cube", |document, white| document.cuboid(Vec3::ZERO, Vec3::splat(0.05), white)),
        ("sheet", |document, white| {
            let white = document.two_sided(white);
            let up = Vec3::new(0.0, 0.04, -0.03);
            document.quad(Vec3::ZERO, 0.05 * Vec3::X, up, white);
        }),
    ];
    for (name, body) in bodies {
        for share in [1.0, 0.3] {
            let world = in_a_room(share, body);
            let effort = Effort { iterations: 128, photons: 4096, path_length: 100 };
            let found = mean(&world, Integrator::Ppm, effort);
            let truth = mean(&world, Integrator::Path, Effort { iterations: 256, ..effort });
            check(&format!("{name} {share}"), found, truth, [0.005, 0.01]);
        }
    }
}

/// Photons on a sheet are none of what lies close below it. What its edges shade is blurred.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn sheets_above_each_other_keep_their_photons() {
    let world = in_a_room(0.3, |document, white| {
        let white = document.two_sided(white);
        let [side, up] = [0.1 * Vec3::X, Vec3::new(0.0, 0.07, -0.07)];
        for above in [0.0, 0.01] {
            document.quad(above * Vec3::Y, side, up, white);
        }
    });
    let effort = Effort { iterations: 128, photons: 4096, path_length: 100 };
    let found = mean(&world, Integrator::Ppm, effort);
    let truth = mean(&world, Integrator::Path, Effort { iterations: 256, ..effort });
    check("sheets", found, truth, [0.015, 0.01]);
}

/// Photons in a closed box are none of the floor beside it, from the first iteration on.
#[test]
fn a_bright_box_does_not_shine_on_the_floor_beside_it() {
    let world = |lamp_in_box: f32| {
        let mut document = Document::default();
        let gray = document.diffuse(0.5);
        let gray = document.two_sided(gray);
        document.quad(Vec3::ZERO, Vec3::Z * 5.0, Vec3::X * 5.0, gray);
        document.cuboid(Vec3::new(-1.5, 1.001, 0.0), Vec3::ONE, gray);
        for (intensity, x) in [(lamp_in_box, -1.5), (10.0, 3.0)] {
            let lamp = json!({"type": "point", "intensity": intensity});
            document.light(lamp, Vec3::new(x, 1.5, 0.0), Vec3::X);
        }
        document.perspective(Vec3::new(3.0, 2.0, 5.0), Vec3::new(1.0, 0.0, 0.0), 0.5, None);
        document.load("closet")
    };
    let effort = Effort { iterations: 64, photons: 20_000, path_length: 16 };
    let truth = mean(&world(1e-3), Integrator::Path, effort);
    let found = mean(&world(30.0), Integrator::Ppm, Effort { iterations: 16, ..effort });
    check("floor beside a box", found, truth, [0.01, 0.02]);
}

/// Without photons of more than a segment, merging is path tracing, to the last bits: emission met
/// and emission connected are weighed alike. One connection alone had 1,300 times the variance
/// here.
#[test]
fn direct_light_is_that_of_path_tracing() {
    let mut document = Document::default();
    let gray = document.diffuse(0.5);
    document.quad(Vec3::ZERO, Vec3::Z, Vec3::X, gray);
    let glow = document.diffuse(0.0);
    let glow = document.emits(glow, 1.0);
    document.quad(Vec3::Y * 0.05, Vec3::X, Vec3::Z, glow);
    document.perspective(Vec3::new(1.05, 0.025, 0.0), Vec3::ZERO, 0.5, None);
    let scene = scene::<1>(&document.load("low lamp"), MONO, SIZE);
    let effort = Effort { iterations: 16, photons: 100, path_length: 2 };
    let by_path = image(&scene, &options(Integrator::Path, effort));
    let seed = options(Integrator::Path, effort).seed;
    let by_ppm = image(&scene, &Options { seed, ..options(Integrator::Ppm, effort) });
    assert!(by_path.planes[0].iter().any(|&value| value > 0.1));
    for (path, ppm) in by_path.planes[0].iter().zip(&by_ppm.planes[0]) {
        assert!((path - ppm).abs() <= 1e-5 * path, "{ppm} for {path}");
    }
}
