//! Energy: places where the radiance is known in closed form.
//!
//! In a closed box whose walls reflect a share `r` and emit the radiance 1, light of up to `n`
//! segments adds up to `1 + r + ... + r^(n - 1)` everywhere, in every direction. In surroundings
//! of radiance 1, whatever neither absorbs nor emits is invisible.
//!
//! Means over the image must be within 5 standard errors of the truth (about 250 numbers that are
//! not known exactly: by Student's t of 31 degrees of freedom, a change of all random numbers fails
//! by chance in 1 of 200), and standard errors below 2e-3 of it (those of `path` and `bdpt` are
//! mostly below 5e-4), so that this is sharp.

use glam::{DVec3, Vec3};
use serde_json::json;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::Mode;
use sunstone::internals::scene::World;
use sunstone::internals::scene::world::{Bsdf, Geometry, Lens, Material, Transform};
use sunstone::internals::spectrum::Color;

use crate::support::gltf::Document;
use crate::support::rendering::{MONO, replicates, scene, settings};
use crate::support::statistics::{Estimate, estimate};

const SIZE: [u32; 2] = [16, 16];
const REPLICATES: u32 = 32;
const STANDARD_ERRORS: f64 = 5.0;
const ERROR_MAX: f64 = 2e-3;
/// Rounding of `f32`, and where rays start so near to an edge of the cube that the offset from one
/// face takes them through another (7e-6 of the light).
const ROUNDING: f64 = 2e-5;

/// Renders in both modes and expects `truth` in the mean of S0, and no polarization.
fn check(world: &World, integrator: Integrator, iterations: u32, path_length: u32, truth: f64) {
    check_in::<1>(world, MONO, integrator, iterations, path_length, truth);
}

/// [`check`] in each of several colors.
fn check_in<const N: usize>(
    world: &World,
    color: Color,
    integrator: Integrator,
    iterations: u32,
    path_length: u32,
    truth: f64,
) {
    let scene = scene::<N>(world, color.clone(), SIZE);
    // Light paths are spread over everything, seen or not.
    let iterations = if integrator == Integrator::Light { 2 * iterations } else { iterations };
    let pixels: Vec<usize> = (0..(SIZE[0] * SIZE[1]) as usize).collect();
    for mode in [Mode::Scalar, Mode::Polarized] {
        let settings = settings(integrator, mode, color.clone(), iterations, path_length);
        let images = replicates(&scene, &settings, REPLICATES);
        let what = format!("{integrator:?}, {mode:?}");
        let expect = |plane: usize, truth: f64| {
            let Estimate { mean, variance, .. } = estimate(&images, plane, &pixels);
            let error = variance.sqrt();
            println!("{what}: plane {plane} = {mean:.6} +- {error:.6}, should be {truth:.6}");
            assert!(error < ERROR_MAX * truth.max(1.0), "{what}: an error of {error}");
            let tolerance = STANDARD_ERRORS * error + ROUNDING;
            assert!((mean - truth).abs() < tolerance, "{what}: plane {plane} = {mean} +- {error}");
        };
        (0..N).for_each(|plane| expect(plane, truth));
        (N..images[0].planes.len()).for_each(|plane| expect(plane, 0.0));
    }
}

/// The sum of the first `terms` powers of `ratio`.
fn geometric_sum(ratio: f64, terms: i32) -> f64 {
    (1.0 - ratio.powi(terms)) / (1.0 - ratio)
}

fn glowing_box(reflectance: f32) -> World {
    let mut scene = Document::default();
    let wall = scene.diffuse(reflectance);
    let wall = scene.emits(wall, 1.0);
    scene.room([wall; 6], &[]);
    scene.perspective(Vec3::new(0.3, 0.2, 0.6), Vec3::ZERO, 1.0, None);
    scene.load("glowing box")
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn closed_box_glows_as_the_series_says() {
    for integrator in [Integrator::Path, Integrator::Light, Integrator::Bdpt] {
        check(&glowing_box(0.5), integrator, 64, 6, geometric_sum(0.5, 6));
    }
}

/// Depth by depth, so that no two strategies can make up for each other.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn closed_box_glows_as_the_series_says_at_every_length() {
    for length in 1..=4 {
        for integrator in [Integrator::Path, Integrator::Light, Integrator::Bdpt] {
            let truth = geometric_sum(0.9, length as i32);
            check(&glowing_box(0.9), integrator, 64, length, truth);
        }
    }
}

/// Light of a sphere that fills all directions from a point inside is that of a furnace, too:
/// seen from outside, a glowing reflector in black surroundings has nothing to reflect.
#[test]
fn convex_glowing_ball_reflects_nothing() {
    let mut document = Document::default();
    let glow = document.diffuse(0.8);
    let glow = document.emits(glow, 1.0);
    document.sphere(Vec3::ZERO, 1.0, glow);
    document.orthographic(Vec3::new(0.0, 0.5, 3.0), Vec3::ZERO, 0.6);
    let world = document.load("glowing ball");
    for integrator in [Integrator::Path, Integrator::Light, Integrator::Bdpt] {
        check(&world, integrator, 32, 5, 1.0);
    }
}

/// Inside of a ball that shines to both sides there is a furnace, length by length.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn ball_glows_inside_as_the_series_says() {
    let world = |eye: Vec3| {
        let mut document = Document::default();
        let glow = document.diffuse(0.5);
        let glow = document.emits(glow, 1.0);
        let glow = document.two_sided(glow);
        document.sphere(Vec3::new(0.3, 0.1, 0.2), 1.0, glow);
        document.perspective(eye, Vec3::new(0.3, 0.1, -0.4), 0.9, None);
        document.load("ball that shines inwards")
    };
    let eye = Vec3::new(0.3, 0.3, 0.7);
    for length in [1, 2, 4] {
        let truth = geometric_sum(0.5, length as i32);
        for integrator in [Integrator::Path, Integrator::Light, Integrator::Bdpt, Integrator::Ppm] {
            check(&world(eye), integrator, 64, length, truth);
        }
    }
    for integrator in [Integrator::Path, Integrator::Bdpt] {
        check(&world(Vec3::new(0.3, 0.1, 1.6)), integrator, 64, 4, 1.0);
    }
}

/// Through a glowing boundary one sees what is within it, and its other side from within: what is
/// there is lit from everywhere, and what is off it by both sides.
#[test]
fn balls_of_light_shine_from_both_sides() {
    let lit = |[eye, target]: [Vec3; 2], half: f32, build: fn(&mut Document, usize)| {
        let mut document = Document::default();
        let clear = document.medium(json!({"phase": "isotropic", "sigma_a": 0, "sigma_s": 0}));
        document.fog(clear, |document, null| {
            let glow = document.emits(null, 1.0);
            let glow = document.two_sided(glow);
            document.sphere(Vec3::ZERO, 1.0, glow);
        });
        let gray = document.diffuse(0.5);
        build(&mut document, gray);
        document.orthographic(eye, target, half);
        document.load("ball of light")
    };
    let within = lit([Vec3::Z * 3.0, Vec3::ZERO], 0.2, |document, gray| {
        document.sphere(Vec3::new(0.1, 0.2, 0.0), 0.6, gray);
    });
    // Its radius is half the distance to its middle.
    let beside = lit([Vec3::Z * -1.5, Vec3::Z * -3.0], 0.005, |document, gray| {
        document.quad(Vec3::Z * -2.0, Vec3::X * 0.1, Vec3::Y * 0.1, gray);
    });
    for integrator in [Integrator::Path, Integrator::Bdpt] {
        check(&within, integrator, 128, 2, 1.0 + 0.5);
        check(&beside, integrator, 128, 2, 0.5 * 2.0 * 0.25);
    }
}

/// What stands in surroundings of radiance 1, seen from outside.
fn in_surroundings(build: impl FnOnce(&mut Document)) -> World {
    let mut scene = Document::default();
    build(&mut scene);
    scene.environment(1.0);
    scene.perspective(Vec3::new(0.7, 0.9, 3.0), Vec3::ZERO, 0.7, None);
    scene.load("furnace")
}

/// Reflection and refraction share all light between them, in or out; S1 to S3 of light reflected
/// and transmitted cancel. Total internal reflection keeps some paths of the cube in for ever, but
/// no path from outside gets to those; the rest has left after 64 segments.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn glass_is_invisible_in_a_furnace() {
    let ball = in_surroundings(|scene| {
        let glass = scene.material(json!({"bsdf": "dielectric", "ior": 1.5}));
        scene.sphere(Vec3::ZERO, 0.9, glass);
    });
    let cube = in_surroundings(|scene| {
        let glass = scene.material(json!({"bsdf": "dielectric", "ior": 1.5}));
        scene.cuboid(Vec3::ZERO, Vec3::splat(0.6), glass);
    });
    for world in [ball, cube] {
        for integrator in [Integrator::Path, Integrator::Bdpt] {
            check(&world, integrator, 64, 64, 1.0);
        }
    }
}

/// Within glass radiance is greater by the square of its index, which a white core must see and
/// the way out must undo; unlike without a core, these do not cancel on the way of a single path.
#[test]
fn white_core_of_glass_is_invisible_in_a_furnace() {
    let world = in_surroundings(|scene| {
        let glass = scene.material(json!({"bsdf": "dielectric", "ior": 1.5}));
        scene.sphere(Vec3::ZERO, 0.9, glass);
        let white = scene.diffuse(1.0);
        scene.sphere(Vec3::ZERO, 0.5, white);
    });
    for integrator in [Integrator::Path, Integrator::Bdpt] {
        check(&world, integrator, 128, 96, 1.0);
    }
}

/// A white diffuse ball, which light paths reach as well.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn white_ball_is_invisible_in_a_furnace() {
    let world = in_surroundings(|scene| {
        let white = scene.diffuse(1.0);
        scene.sphere(Vec3::ZERO, 0.9, white);
    });
    for integrator in [Integrator::Path, Integrator::Light, Integrator::Bdpt] {
        check(&world, integrator, 256, 4, 1.0);
    }
}

/// Media that only scatter, of an optical depth of about one.
fn conservative_media() -> [(&'static str, serde_json::Value); 4] {
    let milk = json!({"fat_percent": 3.5, "protein_percent": 3.4});
    [
        ("hg", json!({"phase": "hg", "g": 0.6, "sigma_a": 0, "sigma_s": 2})),
        ("rayleigh", json!({"phase": "rayleigh", "sigma_a": 0, "sigma_s": 1.2})),
        (
            "depolarizing rayleigh",
            json!({"phase": "rayleigh", "depolarization": 0.2, "sigma_a": 0, "sigma_s": 1.2}),
        ),
        ("milk", json!({"phase": "mie", "milk": milk, "sigma_a": 0, "sigma_s": 2})),
    ]
}

/// All that comes in goes out again; what polarizes once is polarized from everywhere, so that it
/// cancels.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn media_without_absorption_are_invisible_in_a_furnace() {
    for (name, medium) in conservative_media() {
        println!("{name}");
        let world = in_surroundings(|scene| {
            let medium = scene.medium(medium);
            scene.fog(medium, |scene, null| {
                scene.cuboid(Vec3::ZERO, Vec3::splat(0.6), null);
            });
        });
        for integrator in [Integrator::Path, Integrator::Bdpt] {
            check(&world, integrator, 64, 64, 1.0);
        }
    }
}

/// Total internal reflection keeps light in until it is scattered out, which takes long in milk:
/// after 128 segments 3e-4 of it are left.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn media_in_glass_are_invisible_in_a_furnace() {
    for (name, medium) in conservative_media() {
        println!("{name}");
        let world = in_surroundings(|scene| {
            let medium = scene.medium(medium);
            let glass = scene.material(json!({"bsdf": "dielectric", "ior": 1.5}));
            scene.around(Some(medium), None, |scene| {
                scene.sphere(Vec3::new(-0.4, 0.0, 0.0), 0.6, glass);
                scene.cuboid(Vec3::new(0.7, 0.1, 0.0), Vec3::splat(0.4), glass);
            });
        });
        for integrator in [Integrator::Path, Integrator::Bdpt] {
            check(&world, integrator, 64, 512, 1.0);
        }
    }
}

/// Distances and angles are drawn for one wavelength and weighed for all of them.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn stained_media_are_invisible_in_a_furnace() {
    let hg = json!({"phase": "hg", "g": [0.6, 0.3, 0], "sigma_a": 0, "sigma_s": [0.7, 1.5, 3]});
    let milk = json!({"fat_percent": 3.5, "protein_percent": 3.4});
    let milk = json!({"phase": "mie", "milk": milk, "sigma_a": 0, "sigma_s": [1, 2, 3]});
    for medium in [hg, milk] {
        let world = in_surroundings(|scene| {
            let medium = scene.medium(medium);
            scene.fog(medium, |scene, null| {
                scene.cuboid(Vec3::new(-0.5, 0.0, 0.0), Vec3::splat(0.4), null);
            });
            let glass = scene.material(json!({"bsdf": "dielectric", "ior": 1.5}));
            scene.around(Some(medium), None, |scene| {
                scene.sphere(Vec3::new(0.5, 0.0, 0.0), 0.5, glass);
            });
        });
        for integrator in [Integrator::Path, Integrator::Bdpt] {
            check_in::<3>(&world, Color::Rgb, integrator, 128, 128, 1.0);
        }
    }
}

/// Under a sky of mean radiance 1 and gradient g a plate of normal n receives pi (1 + 2/3 g . n).
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn plates_reflect_skies_with_a_gradient() {
    const REFLECTANCE: f32 = 0.6;
    let gradient = Vec3::new(0.3, -0.5, 0.6);
    for (normal, up) in [(Vec3::Z, Vec3::Y), (-Vec3::Y, Vec3::Z)] {
        let mut world = World::new("plate");
        let paint = Material::from(Bsdf::diffuse(REFLECTANCE)).two_sided();
        let paint = world.add_material("paint", paint).unwrap();
        let side = up.cross(normal);
        let plate = Geometry::quad(Vec3::ZERO, side, up);
        world.add_mesh("plate", plate, paint, Transform::IDENTITY).unwrap();
        let eye = 3.0 * normal.as_dvec3();
        let place = Transform::looking(eye, DVec3::ZERO, up.as_dvec3());
        let lens = Lens::Orthographic { half_width: 0.9, half_height: 0.9 };
        world.set_camera("eye", lens, place).unwrap();
        world.set_sky(1.0, gradient).unwrap();
        let truth = REFLECTANCE * (1.0 + 2.0 / 3.0 * gradient.dot(normal));
        for (integrator, iterations) in [
            (Integrator::Path, 16),
            (Integrator::Light, 64),
            (Integrator::Bdpt, 16),
            (Integrator::Ppm, 16),
        ] {
            check(&world, integrator, iterations, 3, truth.into());
        }
        // Past the plate the sky itself is seen.
        let away = Transform::looking(eye, 2.0 * eye, up.as_dvec3());
        world.set_camera("eye", lens, away).unwrap();
        let truth = 1.0 + gradient.dot(normal);
        for integrator in [Integrator::Path, Integrator::Bdpt] {
            check(&world, integrator, 4, 3, truth.into());
        }
    }
}
