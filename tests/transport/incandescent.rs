//! Surfaces that glow by their heat: against Fresnel's equations, and against the second law. That
//! all integrators agree before them is for `agreement`.

use glam::{DVec3, Vec3};
use sunstone::Spectrum;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Mode, Options};
use sunstone::internals::scene::World;
use sunstone::internals::spectrum::Color;
use sunstone::world::{Bsdf, EmittedStokes, Geometry, Lens, Material, Transform};

use crate::support::fields::reflected;
use crate::support::rendering::{MONO, image, replicates, scene, settings};
use crate::support::statistics::{cells, estimate, rms, worst};

const RADIANCE: f32 = 2.0;
const SEEING: [Integrator; 3] = [Integrator::Path, Integrator::Bdpt, Integrator::Ppm];

/// A material that is hot.
fn hot(world: &mut World, name: &str, bsdf: Bsdf) -> hecs::Entity {
    let material = world.add_material(name, Material::from(bsdf).emitting(RADIANCE)).unwrap();
    world.set_incandescent(material).unwrap();
    material
}

fn metal(eta: impl Into<Spectrum>, k: impl Into<Spectrum>) -> Bsdf {
    Bsdf::Conductor { eta: eta.into(), k: k.into() }
}

fn seen_from(world: &mut World, eye: DVec3) {
    let lens = Lens::Orthographic { half_width: 0.4, half_height: 0.3 };
    world.set_camera("eye", lens, Transform::looking(eye, DVec3::ZERO, DVec3::Y)).unwrap();
}

/// S0 to S3 over the radiance of a black body, about the s axis, of what leaves at an angle: what
/// of s and p is not reflected.
fn leaving(angle: f64, eta: f64, k: f64) -> [f64; 4] {
    let [e_s, e_p] = [1.0, -1.0].map(|s1| 1.0 - reflected([s1, 0.0, 0.0], angle.cos(), eta, k)[0]);
    [0.5 * (e_s + e_p), 0.5 * (e_s - e_p), 0.0, 0.0]
}

/// Hot floors of metal and glass at every angle, in all modes and channels.
#[test]
fn surfaces_emit_what_they_do_not_reflect() {
    let floors = [(0.4, 2.6), (2.8, 3.2), (1.5, 0.0), (1.1, 0.3)];
    for ((eta, k), angle) in
        floors.into_iter().flat_map(|floor| [0.0_f64, 0.4, 0.98, 1.5].map(|angle| (floor, angle)))
    {
        let bsdf = match k {
            0.0 => Bsdf::dielectric(eta as f32),
            k => metal(eta as f32, k as f32),
        };
        let mut world = World::new("hot floor");
        let floor = hot(&mut world, "floor", bsdf);
        let quad = Geometry::quad(Vec3::ZERO, 20.0 * Vec3::Z, 3.0 * Vec3::X);
        world.add_mesh("floor", quad, floor, Transform::IDENTITY).unwrap();
        // Nearly straight down the camera has an up axis still.
        let eye = DVec3::new(0.0, angle.cos(), angle.sin().max(1e-4));
        seen_from(&mut world, 10.0 * eye);
        let scene = scene::<1>(&world, MONO, [5, 4]);
        let expected = leaving(angle, eta, k).map(|it| f64::from(RADIANCE) * it);
        for integrator in SEEING {
            for mode in Mode::ALL {
                let found = image(&scene, &settings(integrator, mode, MONO, 8, 3));
                for (plane, expected) in found.planes.iter().zip(expected) {
                    for &value in plane {
                        let error = (f64::from(value) - expected).abs();
                        let what = format!("{eta} - i {k} at {angle}, {integrator:?}, {mode:?}");
                        assert!(error < 3e-6, "{what}: {value}, not {expected}");
                    }
                }
            }
        }
    }
}

/// By wavelength: the index is that of each channel.
#[test]
fn every_channel_has_its_own() {
    let mut world = World::new("hot floor");
    let floor = hot(&mut world, "floor", metal([0.4, 1.0, 1.8], [2.6, 1.0, 3.0]));
    let quad = Geometry::quad(Vec3::ZERO, 3.0 * Vec3::Z, 3.0 * Vec3::X);
    world.add_mesh("floor", quad, floor, Transform::IDENTITY).unwrap();
    seen_from(&mut world, 3.0 * DVec3::new(0.0, 0.5_f64.cos(), 0.5_f64.sin()));
    let options = settings(Integrator::Path, Mode::Polarized, Color::Rgb, 4, 3);
    let found = image(&scene::<3>(&world, Color::Rgb, [5, 4]), &options);
    for (channel, (eta, k)) in [(0.4, 2.6), (1.0, 1.0), (1.8, 3.0)].into_iter().enumerate() {
        for (component, expected) in leaving(0.5, eta, k).into_iter().enumerate() {
            let value = f64::from(found.planes[3 * component + channel][0] / RADIANCE);
            assert!((value - expected).abs() < 2e-6, "{channel}: {value}, not {expected}");
        }
    }
}

/// Bodies of one temperature under a sky of the same: metal, and what scatters evenly and emits
/// what it absorbs.
fn of_one_temperature(with_wall: bool) -> World {
    let mut world = World::new("oven");
    world.set_environment(RADIANCE).unwrap();
    let dark = hot(&mut world, "dark metal", metal(2.0, 1.0));
    world.add_sphere("ball", 0.5, dark, DVec3::new(0.3, 0.4, 0.0)).unwrap();
    let bright = hot(&mut world, "metal", metal(1.2, 1.5));
    let here = Transform::IDENTITY;
    let floor = Geometry::quad(-0.3 * Vec3::Y, 1.5 * Vec3::Z, 1.5 * Vec3::X);
    world.add_mesh("floor", floor, bright, here).unwrap();
    world
        .add_mesh("box", Geometry::cuboid(-Vec3::splat(0.2), Vec3::splat(0.2)), dark, here)
        .unwrap();
    if with_wall {
        let gray = Material::from(Bsdf::diffuse(0.5)).emitting(0.5 * RADIANCE);
        let gray = world.add_material("gray", gray).unwrap();
        let wall = Geometry::quad(-0.8 * Vec3::Z, Vec3::X, Vec3::Y);
        world.add_mesh("wall", wall, gray, here).unwrap();
    }
    let place = Transform::looking(DVec3::new(0.4, 0.9, 3.0), DVec3::ZERO, DVec3::Y);
    world.set_camera("eye", Lens::pinhole(0.6), place).unwrap();
    world
}

/// The second law: nothing is to be seen in an oven of one temperature, whatever its walls, and no
/// polarization. Metals reflect to one side alone, so that there is no noise, unless light paths
/// bring some of what is seen.
#[test]
fn nothing_is_seen_in_an_oven() {
    let scene = scene::<1>(&of_one_temperature(false), MONO, [12, 12]);
    for integrator in [Integrator::Path, Integrator::Ppm] {
        // The dark metals leave 1e-7 of what has been reflected so often.
        let found = image(&scene, &settings(integrator, Mode::Polarized, MONO, 4, 16));
        for (plane, expected) in found.planes.iter().zip([RADIANCE, 0.0, 0.0, 0.0]) {
            let off = plane.iter().fold(0.0, |most: f32, it| most.max((it - expected).abs()));
            assert!(off < 2e-5, "{integrator:?}: {off}");
        }
    }
}

/// The same with a wall that scatters, by every way that light is found: within noise. Of some 600
/// numbers one is off by more than 5 with a chance of 4e-4.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn nothing_but_noise_is_seen_before_a_wall() {
    let scene = scene::<1>(&of_one_temperature(true), MONO, [8, 8]);
    for integrator in SEEING {
        let options = settings(integrator, Mode::Polarized, MONO, 64, 12);
        let options = Options { roulette_after: Some(4), ..options };
        let images = replicates(&scene, &options, 24);
        let mut scores = Vec::new();
        for cell in cells(8, 8, 2, &[true; 64]) {
            for (plane, expected) in [RADIANCE, 0.0, 0.0, 0.0].into_iter().enumerate() {
                let found = estimate(&images, plane, &cell);
                let expected = crate::support::statistics::Estimate::exact(f64::from(expected));
                scores.extend(found.score(&expected, f64::from(RADIANCE)));
            }
        }
        println!("{integrator:?}: {} scores, worst {:.2}", scores.len(), worst(&scores));
        assert!(scores.len() > 20 && worst(&scores) < 5.0 && rms(&scores) < 1.6);
    }
}

#[test]
fn what_cannot_be_incandescent_is_refused() {
    let mut world = World::new("refused");
    let mut refused = |material: Material, words: &str| {
        let material = world.add_material("it", material).unwrap();
        let error = world.set_incandescent(material).unwrap_err().to_string();
        assert!(error.contains("incandescent") && error.contains(words), "{error}");
    };
    refused(Material::from(Bsdf::diffuse(0.5)).emitting(1.0), "smooth");
    refused(Material::from(Bsdf::thin_dielectric(1.5)).emitting(1.0), "smooth");
    refused(Material::from(Bsdf::metal("W").unwrap()), "nothing is emitted");
    let both = world.add_material("both", Material::emitter(1.0)).unwrap();
    world.set_emitted_stokes(both, EmittedStokes::new([1.0, 0.0, 0.0]).unwrap()).unwrap();
    *world.entities_mut().get::<&mut Bsdf>(both).unwrap() = Bsdf::metal("W").unwrap();
    let error = world.set_incandescent(both).unwrap_err().to_string();
    assert!(error.contains("stokes"), "{error}");
}
