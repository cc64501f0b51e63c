//! Light paths that are aimed: densities of the mixture against lines that are drawn and measures
//! that are known, and caustics on grounds that are large against them.

use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use serde_json::json;
use sunstone::internals::image::StokesImage;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::math::{F32s, LANES, Vector};
use sunstone::internals::render::{Mode, Options, Photons};
use sunstone::internals::scattering::Scene;
use sunstone::internals::scattering::emitter::aim::Line;
use sunstone::internals::scattering::emitter::{
    EmissionSample, aimed_pdf, met_emission, sample_emission,
};
use sunstone::internals::scene::World;
use sunstone::internals::scene::baked::Shapes;
use sunstone::internals::scene::emitter::EmitterModel;

use crate::support::gltf::Document;
use crate::support::random::Random;
use crate::support::rendering::{MONO, in_package, rendered, replicates, scene, settings, world};
use crate::support::statistics::{Estimate, estimate};

fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

impl Random {
    fn emission(&mut self, scene: &Scene<1>) -> EmissionSample<1> {
        let mut pair = || [self.next(), self.next()];
        let [choice, aim, position, direction] = [pair(), pair(), pair(), pair()];
        sample_emission(scene, choice, aim[0], position, direction)
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Lamp {
    Sun,
    Sky,
    /// So high above.
    Point(f32),
    Spot(f32),
    /// A ball of a twentieth of the height.
    Ball(f32),
    /// A square with edges of a tenth of the height, whose front faces the floor.
    Panel(f32),
}

/// The floor's radiance without anything in the way, for a reflectance of 0.5, is about one.
fn add_lamp(scene: &mut Document, lamp: Lamp) {
    let intensity = |height: f32| 2.0 * std::f32::consts::PI * height * height;
    match lamp {
        Lamp::Sun => {
            let sun = json!({"type": "directional", "intensity": 2.0 * PI});
            scene.light(sun, Vec3::ZERO, v(-0.1, -1.0, 0.15));
        }
        Lamp::Sky => scene.environment(2.0),
        Lamp::Point(height) => {
            let point = json!({"type": "point", "intensity": intensity(height)});
            scene.light(point, v(0.0, height, 0.0), Vec3::NEG_Y);
        }
        Lamp::Spot(height) => {
            let cone = json!({"innerConeAngle": 0.9, "outerConeAngle": 1.1});
            let spot = json!({"type": "spot", "intensity": intensity(height), "spot": cone});
            scene.light(spot, v(0.0, height, 0.0), v(0.1, -1.0, 0.0));
        }
        Lamp::Ball(height) => {
            let shines = black_that_emits(scene, 800.0);
            scene.sphere(v(0.1, 1.0, 0.0) * height, 0.05 * height, shines);
        }
        Lamp::Panel(height) => {
            let shines = black_that_emits(scene, 200.0 * PI as f32);
            let shines = scene.two_sided(shines);
            let [x, z] = [Vec3::X, Vec3::Z].map(|axis| 0.05 * height * axis);
            scene.quad(v(0.1, 1.0, 0.0) * height, x, z, shines);
        }
    }
}

fn black_that_emits(scene: &mut Document, radiance: f32) -> usize {
    let black = scene.material(json!({"bsdf": "absorber"}));
    scene.emits(black, radiance)
}

/// A ground of so many meters to all sides of the origin, with balls of glass above.
fn ground(extent: f32, lamps: &[Lamp], balls: &[Vec3]) -> Document {
    let mut scene = Document::default();
    let floor = scene.diffuse(0.5);
    scene.quad(Vec3::ZERO, v(0.0, 0.0, extent), v(extent, 0.0, 0.0), floor);
    let glass = scene.material(json!({"bsdf": "dielectric", "ior": 1.5}));
    balls.iter().for_each(|&ball| scene.sphere(ball, 0.25, glass));
    lamps.iter().for_each(|&lamp| add_lamp(&mut scene, lamp));
    scene
}

/// Where the ball is.
const BALL: Vec3 = Vec3::new(0.0, 0.35, 0.0);

/// Seen from the side.
fn caustic(extent: f32, lamp: Lamp) -> World {
    let mut scene = ground(extent, &[lamp], &[BALL]);
    scene.perspective(v(0.0, 1.2, 1.6), Vec3::ZERO, 0.4, None);
    scene.load("caustic")
}

fn many(count: u16) -> World {
    let lamps = [Lamp::Sun, Lamp::Sky, Lamp::Point(9.0), Lamp::Point(0.4), Lamp::Spot(12.0)];
    let mut random = Random(count.into());
    let place = |_| (v(random.next(), 0.0, random.next()) - v(0.5, 0.0, 0.5)) * 90.0 + BALL;
    let balls: Vec<Vec3> = (0..count).map(place).collect();
    let mut scene = ground(200.0, &lamps, &balls);
    scene.orthographic(v(0.0, 1.2, 1.6), Vec3::ZERO, 0.5);
    scene.load("many")
}

fn aimed_scenes() -> Vec<Arc<Scene<1>>> {
    let worlds = [
        caustic(1.0, Lamp::Sun),
        caustic(1000.0, Lamp::Sky),
        caustic(100.0, Lamp::Point(10.0)),
        caustic(100.0, Lamp::Spot(10.0)),
        caustic(100.0, Lamp::Ball(10.0)),
        caustic(5.0, Lamp::Ball(1000.0)),
        caustic(100.0, Lamp::Panel(10.0)),
        many(1),
        many(300),
    ];
    let scenes: Vec<_> = worlds.iter().map(|it| scene::<1>(it, MONO, [16, 16])).collect();
    for (scene, index) in scenes.iter().zip(0..) {
        assert!(scene.aim.is_some(), "scene {index} is not aimed at");
    }
    scenes
}

/// A path that starts, one that meets the emitter and a vertex that connects to it name the same
/// density for the same line, but for lines that graze a ball, of which they may think differently.
#[test]
fn a_line_has_one_density_whoever_asks() {
    let mut random = Random(3);
    for scene in aimed_scenes() {
        let aim = scene.aim.as_ref().unwrap();
        let mut grazes = 0;
        for _ in 0..4000 {
            let start = random.emission(&scene);
            let emitter = &scene.optics.emitters[start.emitter];
            let middle = if start.finite { BALL } else { scene.shapes.bounds.center };
            let along = (middle - start.position).dot(start.direction).max(1.0);
            let vertex = start.position + along * start.direction;
            let line = Line {
                emitter: start.emitter,
                point: if start.finite { start.position } else { vertex },
                normal: start.normal,
                direction: start.direction,
            };
            let reference = Vector::splat(vertex.to_array());
            let own = [start.emitter; LANES];
            let half = [F32s::splat(0.5); 2];
            let mut chosen =
                scene.direct.sample(&scene.optics.lamps, (own, F32s::splat(1.0)), reference, half);
            // An area's own choice of a point is another one, with another cosine.
            if start.normal != Vec3::ZERO {
                let cosine = chosen.cos_at_light;
                chosen.point = Vector::splat(start.position.to_array());
                chosen.normal = Vector::splat(start.normal.to_array());
                chosen.direction = Vector::splat((-start.direction).to_array());
                chosen.cos_at_light = F32s::splat(start.cos_at_light);
                chosen.emission_pdf *= chosen.cos_at_light / cosine;
                let again = pdf_met(&scene, &start, start.position);
                grazes += usize::from((again / start.emission_pdf - 1.0).abs() > 1e-4);
            }
            // The sky's own choice of a direction is another one.
            if matches!(emitter.model, EmitterModel::Environment(_)) {
                chosen.direction = Vector::splat((-start.direction).to_array());
                let met = pdf_met(&scene, &start, vertex);
                let whole = chosen.emission_pdf.to_array()[0];
                let again = aim.gain(line) * whole;
                assert!((met / again - 1.0).abs() < 1e-5, "{start:?}");
            }
            aim.mix(&mut chosen, own, reference);
            let found = chosen.emission_pdf.to_array()[0];
            grazes += usize::from((found / start.emission_pdf - 1.0).abs() > 1e-4);
        }
        assert!(grazes <= 8, "{grazes} of 4000");
    }
}

/// The density of the start of a light path, asked by a sensor path that meets it at a point.
fn pdf_met(scene: &Scene<1>, start: &EmissionSample<1>, point: Vec3) -> f32 {
    let met = met_emission(scene, start.emitter, point, -start.direction).unwrap();
    aimed_pdf(scene, start.emitter, &met, (point, -start.direction))
}

/// Points spread evenly over a triangle: the middles of smaller ones.
fn inside([a, b, c]: [Vec3; 3]) -> Vec<Vec3> {
    const STEPS: usize = 32;
    let at = |u: f32, v: f32| a + (u * (b - a) + v * (c - a)) / STEPS as f32;
    let mut points = Vec::new();
    for i in 0..STEPS {
        for j in 0..STEPS - i {
            let (u, v) = (i as f32, j as f32);
            points.push(at(u + 1.0 / 3.0, v + 1.0 / 3.0));
            if i + j + 1 < STEPS {
                points.push(at(u + 2.0 / 3.0, v + 2.0 / 3.0));
            }
        }
    }
    points
}

/// What lines measure that meet a ball: all directions times its disk, one disk, a solid angle, or
/// the sum of those of all points.
fn measure(model: &EmitterModel, shapes: &Shapes, (ball, radius): (Vec3, f64)) -> Option<f64> {
    let solid_angle = |point: Vec3| {
        let sine2 = radius * radius / f64::from((ball - point).length_squared());
        2.0 * PI * (1.0 - (1.0 - sine2).sqrt())
    };
    match model {
        EmitterModel::Environment(_) => Some(4.0 * PI * PI * radius * radius),
        EmitterModel::Panorama(_) | EmitterModel::Sun(_) => None,
        EmitterModel::Directional(_) => Some(PI * radius * radius),
        EmitterModel::Point(it) => {
            let is_outside = f64::from(ball.distance(it.position)) > radius;
            is_outside.then(|| solid_angle(it.position))
        }
        EmitterModel::Triangle(it) => {
            let corners = shapes.triangles[it.primitive as usize].corners;
            let points = inside(corners);
            let front = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            let is_before = |point: &Vec3| f64::from(front.dot(ball - *point)) > radius;
            let sum: f64 = points.iter().map(|&point| solid_angle(point)).sum();
            let mean = sum / points.len() as f64;
            points.iter().all(is_before).then_some(f64::from(it.area) * mean)
        }
        EmitterModel::Patterned(_) | EmitterModel::Spot(_) | EmitterModel::Sphere(_) => None,
    }
}

/// One over the density is an estimate of what all lines measure that meet a ball, be that one at
/// which paths are aimed, a part of it, or one at which they are not. Of 60 scores one exceeds 5
/// with a chance of 3e-5.
#[test]
fn densities_sum_to_what_lines_measure() {
    const DRAWS: usize = 40_000;
    let mut random = Random(4);
    for scene in aimed_scenes() {
        let bounds = scene.shapes.bounds;
        let apart = bounds.center + 0.5 * bounds.radius * Vec3::X;
        let balls = [(BALL, 0.25), (BALL + v(0.1, 0.0, 0.0), 0.2), (apart, 0.3 * bounds.radius)];
        let starts: Vec<_> = (0..DRAWS).map(|_| random.emission(&scene)).collect();
        for (row, emitter) in scene.optics.emitters.iter().enumerate() {
            for (ball, radius) in balls {
                let Some(exact) = measure(&emitter.model, &scene.shapes, (ball, radius.into()))
                else {
                    continue;
                };
                let value = |start: &EmissionSample<1>| {
                    let to_ball = ball - start.position;
                    let off = to_ball.cross(start.direction).length();
                    let is_on_side = !start.finite || to_ball.dot(start.direction) > 0.0;
                    let meets = start.emitter == row && off < radius && is_on_side;
                    if meets { 1.0 / f64::from(start.emission_pdf) } else { 0.0 }
                };
                // Means of many, whose distribution is close to a normal one.
                let mean = |some: &[EmissionSample<1>]| {
                    some.iter().map(value).sum::<f64>() / some.len() as f64
                };
                let means: Vec<f64> = starts.chunks(DRAWS / 40).map(mean).collect();
                let found = Estimate::of(&means);
                let score = found.score(&Estimate::exact(exact), exact).unwrap_or(0.0);
                let text = format!("{} for {exact}: {:?} {ball}", found.mean, emitter.model);
                assert!(score.abs() < 5.0, "{text}, {score}");
            }
        }
    }
}

/// Scenes of which the camera sees the whole are not aimed at, so their paths are what they were.
#[test]
fn rooms_are_not_aimed_at() {
    for name in ["cornell", "mirror", "tank", "reference/mirror", "reference/tank"] {
        let path = in_package("scenes").join(Path::new(name).with_extension("gltf"));
        let aim = &scene::<1>(&world(&path), MONO, [32, 32]).aim;
        assert!(aim.is_none(), "{name}: {aim:?}");
    }
}

/// Pixels along an edge.
const EDGE: u32 = 24;
/// Independent images.
const REPLICATES: u32 = 16;

fn options(integrator: Integrator, mode: Mode) -> Options {
    let photons = Photons { per_iteration: Some(20_000), samples: Some(1), ..Photons::default() };
    // To the floor, through the ball, to the lamp, and once more to the floor.
    let options = settings(integrator, mode, MONO, 32, 5);
    // The window is many times as large.
    Options { photons: Photons { radius: Some(0.01), ..photons }, ..options.clone() }
}

/// Around the caustic, where the camera sees the floor straight.
fn window() -> Vec<usize> {
    let edge = EDGE as usize;
    (12..17).flat_map(|y| (9..15).map(move |x| y * edge + x)).collect()
}

fn images(world: &World, integrator: Integrator, mode: Mode) -> Vec<StokesImage> {
    let scene = scene::<1>(world, MONO, [EDGE, EDGE]);
    replicates(&scene, &options(integrator, mode), REPLICATES)
}

const FINDING: [Integrator; 3] = [Integrator::Bdpt, Integrator::Light, Integrator::Ppm];

/// Nine scores; one exceeds 4.5 with a chance of 6e-5.
#[test]
fn the_suns_caustic_is_the_same_on_any_ground() {
    let near = estimate(&images(&caustic(10.0, Lamp::Sun), FINDING[0], Mode::Scalar), 0, &window());
    assert!(near.variance.sqrt() < 0.01 * near.mean, "{near:?}");
    for extent in [1.0, 100.0, 1000.0] {
        for integrator in FINDING {
            let images = images(&caustic(extent, Lamp::Sun), integrator, Mode::Scalar);
            let found = estimate(&images, 0, &window());
            let score = found.score(&near, near.mean).unwrap_or(0.0);
            assert!(score.abs() < 4.5, "{integrator:?} at {extent}: {found:?}, {near:?}: {score}");
        }
    }
}

/// The same for a sky and a lamp far above, against paths from the sensor or light paths, each in
/// one of the modes, which aim alike: 14 scores; one exceeds 4.5 with a chance of 1e-4.
#[test]
fn integrators_agree_on_large_grounds() {
    for (lamp, by, mode) in [
        (Lamp::Sky, Integrator::Path, Mode::Polarized),
        (Lamp::Point(10.0), Integrator::Light, Mode::Scalar),
        (Lamp::Spot(10.0), Integrator::Light, Mode::Polarized),
        (Lamp::Ball(10.0), Integrator::Path, Mode::Scalar),
        (Lamp::Panel(10.0), Integrator::Path, Mode::Polarized),
    ] {
        let world = caustic(300.0, lamp);
        let expected = estimate(&images(&world, by, mode), 0, &window());
        for integrator in FINDING.into_iter().filter(|it| *it != by) {
            let found = estimate(&images(&world, integrator, mode), 0, &window());
            let score = found.score(&expected, expected.mean).unwrap_or(0.0);
            let text = format!("{integrator:?} {mode:?} {lamp:?}: {found:?}, {expected:?}");
            assert!(score.abs() < 4.5, "{text}: {score}");
        }
    }
}

/// The sky on the ground is as bright as half of the sky is: 0.5 times 2 by light paths. One score;
/// 4 with a chance of 6e-5.
#[test]
fn light_paths_bring_all_of_the_sky_to_the_ground() {
    let mut scene = ground(1000.0, &[Lamp::Sky], &[]);
    scene.perspective(v(0.0, 1.2, 1.6), Vec3::ZERO, 0.4, None);
    let images = images(&scene.load("plain"), Integrator::Light, Mode::Scalar);
    let all: Vec<usize> = (0..(EDGE * EDGE) as usize).collect();
    let found = estimate(&images, 0, &all);
    assert!(found.variance.sqrt() < 0.02, "{found:?}");
    let score = found.score(&Estimate::exact(1.0), 1.0).unwrap();
    assert!(score.abs() < 4.0, "{found:?}: {score}");
}

/// A ball of a scattering medium in the sky, with a lamp within.
fn lit_from_within(center: Vec3, radius: f32, glass: bool) -> World {
    let mut scene = Document::default();
    let fog = scene.medium(json!({"phase": "isotropic", "sigma_a": 0.5, "sigma_s": 0.3}));
    let boundary =
        if glass { json!({"bsdf": "dielectric", "ior": 1.33}) } else { json!({"bsdf": "null"}) };
    let boundary = scene.material(boundary);
    scene.around(Some(fog), None, |scene| scene.sphere(Vec3::ZERO, 1.0, boundary));
    let lamp = scene.material(json!({"bsdf": "absorber"}));
    let lamp = scene.emits(lamp, 3.0);
    scene.sphere(center, radius, lamp);
    scene.environment(1.0);
    scene.perspective(v(0.0, 0.0, 4.0), Vec3::ZERO, 0.5, None);
    scene.load("within")
}

/// A lamp of which the camera's rays find a single point, two and more: a ball about a point has no
/// extent, and what is beside it is neither near nor far.
#[test]
fn a_single_point_that_is_seen_can_be_aimed_at() {
    for radius in [0.02, 0.05, 0.08, 0.1, 0.2] {
        for center in [v(0.064, 0.064, 0.0), v(0.0, 0.3, 0.0), v(0.064, 0.0, 0.9)] {
            let scene = scene::<1>(&lit_from_within(center, radius, true), MONO, [16, 16]);
            let probabilities = scene.optics.emitters.iter().map(|it| it.probability);
            let sum: f32 = probabilities.clone().sum();
            let text = format!("{radius} {center}: {probabilities:?}");
            assert!(probabilities.clone().all(|it| it > 0.0) && (sum - 1.0).abs() < 1e-5, "{text}");
        }
    }
}

/// And no sample is lost to that. Three scores, of which one exceeds 4.5 with a chance of 2e-5;
/// photons are merged over a radius, so that theirs are not compared.
#[test]
fn integrators_agree_on_a_lamp_that_few_rays_of_the_camera_find() {
    let all: Vec<usize> = (0..(EDGE * EDGE) as usize).collect();
    for (center, radius, glass, mode) in [
        (v(0.064, 0.064, 0.0), 0.05, true, Mode::Polarized),
        (v(0.064, 0.064, 0.0), 0.05, false, Mode::Scalar),
        (v(0.0, 0.3, 0.0), 0.1, true, Mode::Scalar),
    ] {
        let scene = scene::<1>(&lit_from_within(center, radius, glass), MONO, [EDGE, EDGE]);
        for integrator in [Integrator::Path, Integrator::Bdpt, Integrator::Ppm] {
            let profile = rendered(&scene, &options(integrator, mode)).profile();
            assert_eq!(profile.not_finite, 0, "{integrator:?} {mode:?} {center} {glass}");
        }
        let [expected, found] = [Integrator::Path, Integrator::Bdpt].map(|integrator| {
            estimate(&replicates(&scene, &options(integrator, mode), REPLICATES), 0, &all)
        });
        assert!(expected.variance.sqrt() < 0.01 * expected.mean, "{expected:?}");
        let score = found.score(&expected, expected.mean).unwrap_or(0.0);
        let text = format!("{mode:?} {center} {glass}: {found:?}, {expected:?}");
        assert!(score.abs() < 4.5, "{text}: {score}");
    }
}

/// Relative error of a pixel of the caustic.
fn error(extent: f32, lamp: Lamp) -> f64 {
    let images = images(&caustic(extent, lamp), Integrator::Bdpt, Mode::Scalar);
    let each = window().into_iter().map(|pixel| estimate(&images, 0, &[pixel]));
    let (variance, mean) =
        each.fold((0.0, 0.0), |sum, it| (sum.0 + it.variance, sum.1 + it.mean * it.mean));
    (f64::from(REPLICATES) * variance / mean).sqrt()
}

/// It grew with the ground, until the caustic was never found.
#[test]
fn the_error_of_a_caustic_does_not_grow_with_the_ground() {
    for lamp in [Lamp::Sun, Lamp::Point(10.0), Lamp::Ball(10.0)] {
        let [near, far] = [10.0, 1000.0].map(|extent| error(extent, lamp));
        assert!(far < 1.3 * near, "{lamp:?}: {near} {far}");
    }
}
