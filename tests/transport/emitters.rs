//! The choice of emitters: probabilities that can be asked for again, densities both ways, and what
//! many lamps, hidden ones, skies and spheres cost in noise.

use std::sync::Arc;

use glam::Vec3;
use serde_json::json;
use sunstone::internals::image::StokesImage;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::math::{F32s, LANES, Vector};
use sunstone::internals::render::{Mode, Options};
use sunstone::internals::scattering::Scene;
use sunstone::internals::scattering::emitter::direct_pdf;
use sunstone::internals::scattering::emitter::tree::Vantage;
use sunstone::internals::scene::World;

use crate::support::gltf::Document;
use crate::support::random::Random;
use crate::support::rendering::{MONO, replicates, scene, settings};
use crate::support::scenes::{lamps_and_sky, lamps_in_fog, many_lamps, sphere_on_the_floor};

fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

impl Random {
    fn direction(&mut self) -> Vec3 {
        loop {
            let point = v(self.next(), self.next(), self.next()) * 2.0 - 1.0;
            if (0.01..1.0).contains(&point.length_squared()) {
                return point.normalize();
            }
        }
    }

    /// In and about a room, on a surface or not.
    fn vantage(&mut self) -> Vantage {
        let position = (v(self.next(), self.next(), self.next()) * 2.0 - 1.0) * 1.2;
        let normal = if self.next() < 0.3 { Vec3::ZERO } else { self.direction() };
        Vantage { position, normal }
    }
}

/// Point lights in rows over a floor.
fn grid(edge: i16, height: f32) -> Document {
    let mut scene = Document::default();
    let floor = scene.diffuse(0.5);
    let half = 0.5 * f32::from(edge);
    scene.quad(Vec3::ZERO, v(0.0, 0.0, half), v(half, 0.0, 0.0), floor);
    let at = |index: i16| f32::from(index) - half + 0.5;
    for (x, z) in (0..edge).flat_map(|x| (0..edge).map(move |z| (x, z))) {
        let place = v(at(x), height, at(z));
        scene.light(json!({"type": "point", "intensity": 1.0}), place, Vec3::NEG_Y);
    }
    scene.up(Vec3::Z);
    scene.perspective(v(0.0, 3.0, 0.0), Vec3::ZERO, 0.3, None);
    scene
}

fn all_scenes() -> Vec<Arc<Scene<1>>> {
    let worlds = [
        many_lamps(),
        lamps_and_sky(),
        lamps_in_fog(),
        sphere_on_the_floor(),
        grid(1, 0.3).load("one light"),
        grid(2, 0.0).load("lights on the floor"),
        grid(13, 0.3).load("lights"),
    ];
    worlds.iter().map(|world| scene::<1>(world, MONO, [8, 8])).collect()
}

#[test]
fn probabilities_of_all_emitters_sum_to_one_from_everywhere() {
    let mut random = Random(1);
    for scene in all_scenes() {
        let count = scene.optics.emitters.len();
        for _ in 0..200 {
            let from = random.vantage();
            let chances = (0..count).map(|emitter| scene.choice.chance(&from, emitter));
            let chances: Vec<f64> = chances.map(f64::from).collect();
            let sum: f64 = chances.iter().sum();
            assert!((sum - 1.0).abs() < 1e-5, "{sum} from {from:?} among {count}");
            // None is out of reach: an eighth, a twentieth and an object's share of it.
            let least = 0.125 * 0.05 / count as f64 * 0.2;
            assert!(chances.iter().all(|&chance| chance > least), "{chances:?} from {from:?}");
        }
    }
}

/// About 3,000 counts; a normal number exceeds 5.5 with a chance of 4e-8, so 1 in 8,000 such suites
/// fails by chance.
#[test]
fn emitters_are_chosen_as_often_as_is_said() {
    const DRAWS: u32 = 20_000;
    let mut random = Random(2);
    for scene in all_scenes() {
        let count = scene.optics.emitters.len();
        for _ in 0..8 {
            let from = random.vantage();
            let mut counts = vec![0_u32; count];
            for _ in 0..DRAWS / LANES as u32 {
                let numbers = [0; 2].map(|_| [0; LANES].map(|_| random.next()));
                for (emitter, chance) in scene.choice.choose(&[from; LANES], numbers, LANES) {
                    let again = scene.choice.chance(&from, emitter);
                    assert_eq!(chance, again, "{emitter} from {from:?}");
                    counts[emitter] += 1;
                }
            }
            for (emitter, &found) in counts.iter().enumerate() {
                let chance = f64::from(scene.choice.chance(&from, emitter));
                let expected = chance * f64::from(DRAWS);
                let deviation = (expected * (1.0 - chance)).sqrt();
                let score = (f64::from(found) - expected) / deviation.max(1.0);
                assert!(score.abs() < 5.5, "{found}, not {expected}: {emitter} from {from:?}");
            }
        }
    }
}

/// A sphere light and a floor.
fn ball(center: Vec3, radius: f32) -> Arc<Scene<1>> {
    let mut scene = Document::default();
    let floor = scene.diffuse(0.5);
    scene.quad(v(0.0, -9.0, 0.0), v(0.0, 0.0, 5.0), v(5.0, 0.0, 0.0), floor);
    let bulb = scene.diffuse(0.5);
    let bulb = scene.emits(bulb, 3.0);
    scene.sphere(center, radius, bulb);
    scene.perspective(v(0.0, 0.0, 9.0), Vec3::ZERO, 0.5, None);
    crate::support::rendering::scene::<1>(&scene.load("ball"), MONO, [8, 8])
}

/// From near and far, the points chosen are on the sphere, where they are seen, and as dense as the
/// solid angle of the sphere says, by both of the functions that know.
#[test]
fn points_of_spheres_are_chosen_by_solid_angle() {
    let mut random = Random(3);
    for radius in [1e-4_f32, 0.05, 1.0, 300.0] {
        for distance in [1.000_01, 1.001, 1.1, 2.0, 10.0, 1e3, 1e5_f64] {
            let axis = random.direction();
            let center = axis * radius * 0.3;
            let scene = ball(center, radius);
            let reference = center + axis * (f64::from(radius) * distance) as f32;
            // As far as the reference can be represented.
            let distance = (reference - center).as_dvec3().length() / f64::from(radius);
            let sine2 = 1.0 / (distance * distance);
            let exact = std::f64::consts::TAU * sine2 / (1.0 + (1.0 - sine2).max(0.0).sqrt());
            for _ in 0..20 {
                let u = [0; 2].map(|_| F32s::from([0; LANES].map(|_| random.next())));
                let lanes = scene.direct.sample(
                    &scene.optics.lamps,
                    ([0; LANES], F32s::splat(1.0)),
                    Vector::splat(reference.to_array()),
                    u,
                );
                let (points, directions) = (lanes.point.to_rows(), lanes.direction.to_rows());
                let (pdf, cosine) = (lanes.pdf_w.to_array(), lanes.cos_at_light.to_array());
                assert!(lanes.radiance[0].to_array().iter().all(|&seen| seen == 3.0));
                for lane in 0..LANES {
                    let point = Vec3::from(points[lane]);
                    let direction = Vec3::from(directions[lane]);
                    let place = format!("{radius} {distance} {point} {direction}");
                    assert!((f64::from(pdf[lane]) * exact - 1.0).abs() < 2e-3, "{place}");
                    let off = (point - center).length() / radius - 1.0;
                    assert!(off.abs() < 1e-5, "{place}: {off} off the sphere");
                    let way = point - reference;
                    let miss = way.cross(direction).length();
                    let rounding = 1e-5 * (radius + way.length());
                    assert!(miss < rounding.max(2e-3 * radius), "{place}: {miss} off the ray");
                    let facing = -direction.dot((point - center) / radius);
                    assert!((facing - cosine[lane]).abs() < 2e-3, "{place}: {facing}");
                    if cosine[lane] < 0.05 || way.length() < 1e-3 * radius {
                        continue;
                    }
                    let from = Vantage { position: reference, normal: Vec3::ZERO };
                    let pdf_a = direct_pdf(&scene, (0, None), &from, (point, direction));
                    let again = pdf_a * way.length_squared() / cosine[lane];
                    assert!((again / pdf[lane] - 1.0).abs() < 0.02, "{place}: {again}");
                    // Light paths start off the sphere, which is much if that is tiny.
                    let off = point + (point - center) * 0.1;
                    let pdf_off = direct_pdf(&scene, (0, None), &from, (off, direction));
                    assert!(distance < 1e2 || (pdf_off / pdf_a - 1.0).abs() < 0.01, "{place}");
                }
            }
        }
    }
}

/// Root of the mean squared error of a pixel between `count` replicates of so many samples, over
/// the mean; and that.
fn error(world: &World, integrator: Integrator, samples: u32) -> (f64, f64) {
    const COUNT: u32 = 16;
    let scene = scene::<1>(world, MONO, [16, 16]);
    let options = settings(integrator, Mode::Scalar, MONO, samples, 3);
    let images = replicates(&scene, &Options { ..options.clone() }, COUNT);
    let pixels = images[0].planes[0].len();
    let value = |image: &StokesImage, pixel: usize| f64::from(image.planes[0][pixel]);
    let (mut squares, mut sum) = (0.0, 0.0);
    for pixel in 0..pixels {
        let mean = images.iter().map(|image| value(image, pixel)).sum::<f64>() / f64::from(COUNT);
        let spread = images.iter().map(|image| (value(image, pixel) - mean).powi(2));
        squares += spread.sum::<f64>() / f64::from(COUNT - 1);
        sum += mean;
    }
    let mean = sum / pixels as f64;
    ((squares / pixels as f64).sqrt() / mean, mean)
}

/// A small lamp under a dim sky, above a ground that reaches so far.
fn lamp_and_sky(reach: f32) -> World {
    let mut scene = Document::default();
    let floor = scene.diffuse(0.5);
    scene.quad(Vec3::ZERO, v(0.0, 0.0, reach), v(reach, 0.0, 0.0), floor);
    let lamp = scene.material(json!({"bsdf": "absorber"}));
    let lamp = scene.emits(lamp, 100.0);
    scene.quad(v(0.0, 1.0, 0.0), v(0.1, 0.0, 0.0), v(0.0, 0.0, 0.1), lamp);
    scene.environment(0.02);
    scene.up(Vec3::Z);
    scene.perspective(v(0.0, 3.0, 0.5), Vec3::ZERO, 0.4, None);
    scene.load("lamp and sky")
}

/// Errors are those of variances with 15 degrees of freedom for each of 256 pixels, which differ by
/// chance by 1.2 % at one standard deviation: the limits are ten of them away from what was found.
#[test]
fn the_error_of_a_lamp_under_a_sky_does_not_hang_on_the_ground() {
    let [(small, at_small), (large, at_large)] =
        [2.0, 2000.0].map(|reach| error(&lamp_and_sky(reach), Integrator::Path, 64));
    assert!(small < 0.044 && large < 1.15 * small, "{small} {large}");
    assert!((at_small / at_large - 1.0).abs() < 0.02, "{at_small} {at_large}");
}

/// 0.03 is what is asked for.
#[test]
fn many_lamps_are_chosen_by_what_they_bring() {
    let (error, _) = error(&grid(32, 0.3).load("1,024 lights"), Integrator::Path, 64);
    assert!(error < 0.03, "{error}");
}

/// A white plate under the middle of a strip that is far longer than wide and than it is high: it
/// receives as from an endless one. Single precision tells no directions to such triangles apart.
#[test]
fn long_strips_shine_as_endless_ones() {
    for [length, half, height] in [[5.0, 0.01, 0.01], [300.0, 1.0, 1.0], [1000.0, 1.0, 1.0]] {
        let mut scene = Document::default();
        let plate = scene.diffuse(0.8);
        scene.quad(Vec3::ZERO, Vec3::X * 0.1 * height, Vec3::Y * 0.1 * height, plate);
        let strip = scene.material(json!({"bsdf": "absorber"}));
        let strip = scene.emits(strip, 1.0);
        scene.quad(v(0.0, 0.0, height), Vec3::X * length, Vec3::NEG_Y * half, strip);
        scene.up(Vec3::Z);
        scene.perspective(v(0.0, -2.0, 0.6) * height, Vec3::ZERO, 0.01, None);
        let scene = crate::support::rendering::scene::<1>(&scene.load("strip"), MONO, [16, 16]);
        for integrator in [Integrator::Path, Integrator::Bdpt] {
            let options = settings(integrator, Mode::Scalar, MONO, 256, 8);
            let pixels = &crate::support::rendering::image(&scene, &options).planes[0];
            let count = pixels.len() as f64;
            let mean = pixels.iter().map(|&it| f64::from(it)).sum::<f64>() / count;
            let squares = pixels.iter().map(|&it| (f64::from(it) - mean).powi(2)).sum::<f64>();
            let error = (squares / (count - 1.0) / count).sqrt();
            let expected = 0.8 * f64::from(half / half.hypot(height));
            // One of six exceeds 4.5 errors with a chance of 4e-5; the ends are missing by 1e-5.
            let off = (mean - expected).abs() - 1e-4;
            assert!(off < 4.5 * error, "{length}: {mean} +- {error}, {expected}");
        }
    }
}

/// A lamp above a floor, and a closed box with one so many times as bright beside it.
fn hidden_lamp(times: f32) -> World {
    let mut scene = grid(2, 0.3);
    let box_of = scene.material(json!({"bsdf": "absorber"}));
    let box_of = scene.two_sided(box_of);
    scene.cuboid(v(3.0, 0.0, 0.0), Vec3::splat(0.3), box_of);
    let hidden = json!({"type": "point", "intensity": times});
    scene.light(hidden, v(3.0, 0.0, 0.0), Vec3::NEG_Y);
    scene.load("hidden lamp")
}

/// All four lamps in view bring the same mean whatever is hidden; by a lamp of 1e8 their image was
/// black. The mean of path's 16 replicates is known to 0.1 %.
#[test]
fn a_lamp_in_a_closed_box_takes_nothing_from_others() {
    for integrator in [Integrator::Path, Integrator::Bdpt] {
        let [(open, at_open), (hidden, at_hidden)] =
            [1.0, 1e8].map(|times| error(&hidden_lamp(times), integrator, 64));
        assert!(hidden < (3.0 * open).max(0.1), "{integrator:?} {open} {hidden}");
        assert!((at_hidden / at_open - 1.0).abs() < 0.02, "{at_open} {at_hidden}");
    }
}
