//! Pictures on spheres, by formulas of their coordinates, and pictures of heights, by differences
//! of places on the surfaces that they raise.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec2, DVec3, Vec2, Vec3};
use sunstone::internals::image::StokesImage;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::Mode;
use sunstone::internals::scattering::Scene;
use sunstone::internals::scene::World;
use sunstone::internals::scene::bake;
use sunstone::internals::scene::painting::normal_at;
use sunstone::internals::spectrum::{Carried, Color};
use sunstone::world::{
    Bsdf, Filter, Geometry, Lens, Material, Reads, Relief, ReliefOf, Texture, Textures, Transform,
    Wrap,
};

use crate::support::painted::{noise, paint, quad, texture};
use crate::support::random::Random;
use crate::support::rendering::{replicates, scene, settings};
use crate::support::statistics::Estimate;

/// A place of a sphere: turned, scaled, and mirrored or not.
fn place(mirror: bool) -> Transform {
    let turn = DQuat::from_rotation_x(0.7) * DQuat::from_rotation_z(-2.1);
    let scale = DVec3::new(if mirror { -1.5 } else { 1.5 }, 1.5, 1.5);
    Transform(DAffine3::from_scale_rotation_translation(scale, turn, DVec3::new(0.3, -0.2, 0.9)))
}

/// The point of a unit sphere in its own space at coordinates.
fn on_sphere(at: DVec2) -> DVec3 {
    let (turn, fall) = (TAU * at.x, PI * at.y);
    DVec3::new(fall.sin() * turn.cos(), fall.sin() * turn.sin(), fall.cos())
}

fn lamp(emission: Texture, place: Transform) -> World {
    let mut world = World::new("globe");
    let lamp = world.add_material("lamp", Material::emitter([1.0, 2.0, 0.5])).unwrap();
    let emission = Some(paint([1.0, 2.0, 0.5], emission));
    world.set_textures(lamp, Textures { emission, ..Textures::default() }).unwrap();
    world.add_sphere("globe", 0.4, lamp, place).unwrap();
    let eye = Transform::looking(DVec3::Z * 9.0, DVec3::ZERO, DVec3::Y);
    world.set_camera("eye", Lens::pinhole(0.3), eye).unwrap();
    world
}

#[test]
fn spheres_emit_what_their_pictures_say() {
    let mut way = texture(noise(3, 5), Filter::Linear);
    (way.wrap, way.transform) = ([Wrap::Mirror; 2], [[2.0, 0.3, 0.1], [-0.2, 1.4, 0.4]]);
    let mut random = Random(4);
    for mirror in [false, true] {
        let place = place(mirror);
        let scene: Arc<Scene<3>> = scene(&lamp(way.clone(), place), Color::Rgb, [4, 4]);
        for _ in 0..200 {
            let at = DVec2::new(random.next().into(), random.next().into());
            let point = place.0.transform_point3(0.4 * on_sphere(at)) - scene.shapes.origin;
            let tint = Vec3::from(scene.tint(0, point.as_vec3(), Vec3::Z));
            let [red, green, blue, _] = way.at(at.as_vec2());
            let error = (tint - Vec3::new(red, green, blue)).abs().max_element();
            assert!(error < 1e-4, "{mirror} {at}: {tint}, not {red} {green} {blue}");
        }
    }
}

/// Nine numbers are compared within 4.5 standard errors of 16 images: noise fails it in 1 of 1,000
/// cases at most. The sum is right to about 1e-4.
#[test]
fn light_of_a_painted_sphere_is_the_sum_over_it() {
    let way = texture(noise(6, 5), Filter::Linear);
    let place = place(false);
    let mut world = lamp(way.clone(), place);
    let floor = world.add_material("floor", Bsdf::diffuse(1.0)).unwrap();
    let under = Vec3::new(0.3, -1.2, 0.9);
    let shape = quad(under, Vec3::X * 0.01, Vec3::NEG_Z * 0.01);
    world.add_mesh("floor", shape, floor, Transform::IDENTITY).unwrap();
    let below = under.as_dvec3();
    let eye = Transform::looking(below + DVec3::Y * 0.2, below, DVec3::Z);
    let lens = Lens::Orthographic { half_width: 0.01, half_height: 0.01 };
    world.set_camera("eye", lens, eye).unwrap();
    const STEPS: usize = 600;
    let mut sum = DVec3::ZERO;
    for (i, j) in (0..STEPS * STEPS).map(|at| (at % STEPS, at / STEPS)) {
        let at = DVec2::new(i as f64 + 0.5, j as f64 + 0.5) / STEPS as f64;
        let point = place.0.transform_point3(0.4 * on_sphere(at));
        let normal = (point - place.0.translation).normalize();
        let to = point - below;
        let cosines = to.y.max(0.0) * (-to.dot(normal)).max(0.0);
        let area = 0.36 * 2.0 * PI * PI * (PI * at.y).sin();
        let [red, green, blue, _] = way.at(at.as_vec2());
        sum += DVec3::new(red.into(), green.into(), blue.into()) * cosines * area
            / to.length_squared().powi(2);
    }
    let expected = sum * DVec3::new(1.0, 2.0, 0.5) / (PI * (STEPS * STEPS) as f64);
    let scene: Arc<Scene<3>> = scene(&world, Color::Rgb, [2, 2]);
    for integrator in [Integrator::Path, Integrator::Light, Integrator::Bdpt] {
        let options = settings(integrator, Mode::Scalar, Color::Rgb, 256, 2);
        let images = replicates(&scene, &options, 16);
        for channel in 0..3 {
            let of =
                |image: &StokesImage| f64::from(image.planes[channel].iter().sum::<f32>()) / 4.0;
            let means: Vec<f64> = images.iter().map(of).collect();
            let found = Estimate::of(&means);
            let score = found.score(&Estimate::exact(expected[channel]), expected[channel]);
            let far = (found.mean / expected[channel] - 1.0).abs();
            assert!(
                score.unwrap_or(0.0).abs() < 4.5 && far < 0.1,
                "{integrator:?} {channel}: {}, not {expected}",
                found.mean
            );
        }
    }
}

/// A world of one shape that is raised, under a sky.
fn raised(relief: Relief, add: impl FnOnce(&mut World, sunstone::hecs::Entity)) -> World {
    let mut world = World::new("raised");
    let material = world.add_material("raised", Bsdf::diffuse(0.5)).unwrap();
    let textures = Textures { relief: Some(relief), ..Textures::default() };
    world.set_textures(material, textures).unwrap();
    add(&mut world, material);
    world.set_environment(1.0).unwrap();
    let eye = Transform::looking(DVec3::Z * 9.0, DVec3::ZERO, DVec3::Y);
    world.set_camera("eye", Lens::pinhole(0.3), eye).unwrap();
    world
}

/// The normal of a surface, of which `point` says places by coordinates, with the same sign as one.
fn by_differences(point: impl Fn(DVec2) -> DVec3, at: DVec2, along: DVec3) -> DVec3 {
    const STEP: f64 = 1e-4;
    let change = |axis: DVec2| point(at + STEP * axis) - point(at - STEP * axis);
    let normal = change(DVec2::X).cross(change(DVec2::Y)).normalize();
    normal * normal.dot(along).signum()
}

/// A texture of heights at coordinates; steps between its texels are avoided by the caller.
fn height(way: &Texture, at: DVec2) -> f64 {
    f64::from(way.at(at.as_vec2())[0])
}

/// Whether a texel's edge is farther than differences reach.
fn is_smooth(way: &Texture, at: DVec2) -> bool {
    let [width, height] = way.picture.texels().size().map(|side| side as f32);
    let place = way.place(at.as_vec2()) * Vec2::new(width, height) - 0.5;
    let off = place - place.round();
    off.abs().min_element() > 0.01
}

#[test]
fn heights_bend_normals_as_raised_triangles_do() {
    let mut way = texture(noise(7, 4), Filter::Linear);
    (way.wrap, way.transform) = ([Wrap::Mirror; 2], [[1.7, 0.4, 0.1], [-0.3, 2.2, 0.4]]);
    let mut random = Random(8);
    for mirror in [false, true] {
        let place = place(mirror);
        let scale = 0.2_f32;
        let relief = Relief { texture: way.clone(), scale, of: ReliefOf::Heights(Reads::Red) };
        let shape = quad(Vec3::ZERO, Vec3::new(0.5, 0.1, 0.0), Vec3::new(0.2, 0.8, 0.0));
        let geometry = shape.clone();
        let world = raised(relief.clone(), |world, material| {
            world.add_mesh("quad", shape, material, place).unwrap();
        });
        let baked = bake::<1>(&world, &Carried::at([550.0])).unwrap();
        let on = baked.shapes.painted(0).unwrap();
        let normal = baked.shapes.geometric_normal(0, Vec3::ZERO);
        for _ in 0..200 {
            let pair = [random.next(), random.next()];
            let weights = if pair[0] + pair[1] < 1.0 { pair } else { pair.map(|it| 1.0 - it) };
            let at = on.coordinates(0, weights).as_dvec2();
            if !is_smooth(&way, at) {
                continue;
            }
            // The corner of (0, 1) is the first, and right and up are the edges of the quad.
            let point = |at: DVec2| {
                let corner = geometry.positions[0].as_dvec3();
                let [right, up] = [1, 3].map(|it| geometry.positions[it].as_dvec3() - corner);
                let flat = corner + right * at.x + up * (1.0 - at.y);
                let high = f64::from(scale) * height(&way, at);
                place.0.transform_point3(flat) + normal.as_dvec3() * high
            };
            let expected = by_differences(point, at, normal.as_dvec3());
            let found = normal_at(&relief, (&on, weights), [normal; 2]);
            let error = (found.as_dvec3() - expected).length();
            assert!(error < 2e-3, "{mirror} {at}: {found}, not {expected}");
        }
    }
}

/// What is curved is left out of normals: of heights of a ten thousandth of the radius, that is as
/// much.
#[test]
fn heights_bend_normals_as_raised_spheres_do() {
    let way = texture(noise(9, 6), Filter::Linear);
    let mut random = Random(10);
    for (mirror, sign) in [(false, 1.0_f32), (true, -1.0)] {
        let place = place(mirror);
        let scale = sign * 1e-3;
        let relief = Relief { texture: way.clone(), scale, of: ReliefOf::Heights(Reads::Red) };
        let world = raised(relief.clone(), |world, material| {
            world.add_sphere("ball", 6.0, material, place).unwrap();
        });
        let baked = bake::<1>(&world, &Carried::at([550.0])).unwrap();
        let on = baked.shapes.painted(0).unwrap();
        for _ in 0..200 {
            let at = DVec2::new(random.next().into(), 0.05 + 0.9 * f64::from(random.next()));
            if !is_smooth(&way, at) {
                continue;
            }
            let center = place.0.translation;
            let outwards = |at: DVec2| (place.0.matrix3 * on_sphere(at)).normalize();
            let point =
                |at: DVec2| center + outwards(at) * (9.0 + f64::from(scale) * height(&way, at));
            let normal = outwards(at);
            let weights = on.weights_at((point(at) - baked.shapes.origin).as_vec3());
            let found = normal_at(&relief, (&on, weights), [normal.as_vec3(); 2]);
            let expected = by_differences(point, at, normal);
            let bent = (expected - normal).length();
            let error = (found.as_dvec3() - expected).length();
            assert!(error < 1e-2 * bent + 1e-6, "{mirror} {at}: {found}, not {expected} ({bent})");
        }
    }
}

/// At poles there is no right, and heights that are the same everywhere, or infinitely high, are
/// something to render.
#[test]
fn odd_spheres_render() {
    let heights = texture(noise(11, 4), Filter::Linear);
    for (scale, filter) in [(0.0, Filter::Linear), (1e30, Filter::Linear), (1.0, Filter::Nearest)] {
        let texture = Texture { filter, ..heights.clone() };
        let relief = Relief { texture, scale, of: ReliefOf::Heights(Reads::Luminance) };
        let world = raised(relief, |world, material| {
            let tiny = Transform::from(DVec3::new(0.0, 0.0, 1e-3));
            world.add_sphere("ball", 1e-3, material, tiny).unwrap();
            world.add_sphere("ball", 1.0, material, Transform::IDENTITY).unwrap();
            let shape = Geometry { normals: Vec::new(), ..quad(Vec3::ZERO, Vec3::X, Vec3::Y) };
            world.add_mesh("quad", shape, material, Transform::IDENTITY).unwrap();
        });
        let scene: Arc<Scene<3>> = scene(&world, Color::Rgb, [4, 4]);
        for integrator in [Integrator::Bdpt, Integrator::Ppm] {
            let options = settings(integrator, Mode::Polarized, Color::Rgb, 2, 3);
            let seen = &replicates(&scene, &options, 1)[0];
            assert!(seen.planes.concat().iter().all(|value| value.is_finite()), "{scale}");
        }
    }
    let baked = |scale| {
        let relief = Relief { texture: heights.clone(), scale, of: ReliefOf::Heights(Reads::Red) };
        let world = raised(relief.clone(), |world, material| {
            world.add_sphere("ball", 1.0, material, Transform::IDENTITY).unwrap();
        });
        (bake::<1>(&world, &Carried::at([550.0])).unwrap(), relief)
    };
    for pole in [Vec3::Z, Vec3::NEG_Z] {
        let (baked, relief) = baked(0.1);
        let on = baked.shapes.painted(0).unwrap();
        let found = normal_at(&relief, (&on, on.weights_at(pole)), [pole; 2]);
        assert_eq!(found, pole);
    }
}
