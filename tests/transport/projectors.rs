//! Projectors: what they throw where, and how light paths are drawn from them. That all
//! integrators agree before them is for `agreement`.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DMat3, DQuat, DVec3, Vec3};
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Mode, Options};
use sunstone::internals::scene::pattern::Pattern;
use sunstone::internals::scene::{World, bake};
use sunstone::internals::spectrum::{Carried, Color};
use sunstone::world::{Bsdf, Geometry, Lens, Punctual, Transform};

use crate::support::gltf::Document;
use crate::support::projectors::{file, light};
use crate::support::random::Random;
use crate::support::rendering::{replicates, scene, settings};
use crate::support::skies::{noise, openexr};
use crate::support::statistics::estimate;

fn turn() -> DQuat {
    DQuat::from_rotation_y(0.4) * DQuat::from_rotation_x(1.2) * DQuat::from_rotation_z(2.0)
}

/// A world of one wall and a projector of a picture.
fn world(file: &[u8], half_angle: f64, place: impl Into<Transform>) -> World {
    let mut world = World::new("projector");
    let wall = world.add_material("wall", Bsdf::diffuse(0.5)).unwrap();
    let quad = Geometry::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
    world.add_mesh("wall", quad, wall, Transform::IDENTITY).unwrap();
    let spot = world.add_light("lamp", Punctual::spot(1.0, 0.0, half_angle), place).unwrap();
    world.set_projection(spot, file).unwrap();
    let place = Transform::looking(5.0 * DVec3::Z, DVec3::ZERO, DVec3::Y);
    world.set_camera("eye", Lens::pinhole(0.6), place).unwrap();
    world
}

/// The pattern of one that is turned.
fn turned(file: &[u8], half_angle: f64) -> Arc<Vec<Pattern>> {
    let place = Transform::from(glam::DAffine3::from_scale_rotation_translation(
        DVec3::splat(3.0),
        turn(),
        DVec3::Y,
    ));
    bake(&world(file, half_angle, place), &Carried::RGB).unwrap().optics.patterns
}

/// The value of a picture between its texels, from the sum of tents that it is: by reflection at
/// its edges, which the library does not do.
fn tents(texels: &[[f32; 3]], [width, height]: [usize; 2], at: [f64; 2]) -> [f64; 3] {
    let tent = |distance: f64| (1.0 - distance.abs()).max(0.0);
    let along = |index: usize, size: usize, at: f64| {
        let middle = index as f64 + 0.5;
        tent(at - middle) + tent(at + middle) + tent(at - 2.0 * size as f64 + middle)
    };
    let mut sum = [0.0; 3];
    for row in 0..height {
        for column in 0..width {
            let share = along(column, width, at[0]) * along(row, height, at[1]);
            for (sum, value) in sum.iter_mut().zip(texels[width * row + column]) {
                *sum += share * f64::from(value);
            }
        }
    }
    sum
}

/// Right in the picture is the node's x, up is y, and off the axis the cube of the cosine takes
/// away what the angle and the distance take on the wall.
#[test]
fn shares_are_those_of_the_picture_on_a_wall() {
    let mut random = Random(5);
    for (size, half) in [([1, 1], 0.7), ([5, 3], 1.2), ([2, 7], 0.2), ([4, 4], 1e-3)] {
        let texels = noise(9, size, 4.0);
        let patterns = turned(&openexr(size, |column, row| texels[size[0] * row + column]), half);
        let pattern = &patterns[0];
        let sizes = size.map(|it| it as f64);
        let halves = [half.tan(), half.tan() * sizes[1] / sizes[0]];
        let to_world = DMat3::from_quat(turn());
        for _ in 0..100 {
            let shares: [f64; 2] = [0; 2].map(|_| f64::from(random.next()));
            let across = [0, 1].map(|axis: usize| (2.0 * shares[axis] - 1.0) * halves[axis]);
            let local = DVec3::new(across[0], -across[1], -1.0);
            let direction = (to_world * local).normalize().as_vec3();
            let at = [shares[0] * sizes[0], shares[1] * sizes[1]];
            let expected = tents(&texels, size, at).map(|value| value * local.length().powi(3));
            let found = pattern.share(direction, &Carried::RGB);
            for (found, expected) in found.into_iter().zip(expected) {
                let found = f64::from(found) * pattern.mean();
                assert!(
                    (found - expected).abs() < 2e-3 * (1.0 + expected),
                    "{size:?}: {found}, {expected}"
                );
            }
        }
        for outside in [DVec3::Z, DVec3::new(1.01 * halves[0], 0.0, -1.0), DVec3::Y] {
            let direction = (to_world * outside).normalize().as_vec3();
            assert_eq!(pattern.share(direction, &Carried::RGB), [0.0; 3]);
            assert_eq!(pattern.density(direction), 0.0);
        }
    }
}

/// An eighth of the directions is drawn by brightness per steradian, the others as light is thrown;
/// and what is drawn fills the picture by its density, which adds up to one: of some 70 texels one
/// is off by 5 standard errors with a chance of 4e-5.
#[test]
fn directions_are_drawn_by_brightness() {
    const DRAWS: u32 = 20_000;
    /// Places along either edge of a texel.
    const PLACES: usize = 64;
    let mut random = Random(11);
    let pictures = [([1, 1], 0.7), ([5, 3], 1.2), ([2, 7], 0.2), ([4, 4], 1e-3), ([3, 3], 1.5)];
    for (size, half) in pictures {
        let texels: Vec<[f32; 3]> = noise(9, size, 4.0).iter().map(|it| [it[1]; 3]).collect();
        let patterns = turned(&openexr(size, |column, row| texels[size[0] * row + column]), half);
        let pattern = &patterns[0];
        let to_world = DMat3::from_quat(turn());
        let sizes = size.map(|it| it as f64);
        let halves = [half.tan(), half.tan() * sizes[1] / sizes[0]];
        // Of every texel what is thrown and seen of it, and drawn.
        let mut sums = vec![[0.0; 3]; size[0] * size[1]];
        let area = 4.0 * halves[0] * halves[1] / (sizes[0] * sizes[1] * (PLACES * PLACES) as f64);
        let mut densities = Vec::new();
        for (texel, sums) in sums.iter_mut().enumerate() {
            for place in 0..PLACES * PLACES {
                let within = [place % PLACES, place / PLACES];
                let corner = [texel % size[0], texel / size[0]];
                let across = [0, 1].map(|axis: usize| {
                    let share = (within[axis] as f64 + 0.5) / PLACES as f64;
                    (2.0 * (corner[axis] as f64 + share) / sizes[axis] - 1.0) * halves[axis]
                });
                let local = DVec3::new(across[0], -across[1], -1.0);
                let direction = (to_world * local).normalize().as_vec3();
                let solid_angle = area / local.length().powi(3);
                let thrown = f64::from(pattern.share(direction, &Carried::RGB)[0]) / (4.0 * PI);
                let seen = thrown / local.length().powi(3);
                let density = f64::from(pattern.density(direction));
                for (sum, value) in sums.iter_mut().zip([thrown, seen, density]) {
                    *sum += value * solid_angle;
                }
                densities.push([thrown, seen, density]);
            }
        }
        let [thrown, seen, drawn] = [0, 1, 2].map(|n| sums.iter().map(|it| it[n]).sum::<f64>());
        assert!((thrown - 1.0).abs() < 5e-3, "{size:?}: {thrown}");
        assert!((drawn - 1.0).abs() < 5e-3, "{size:?}: {drawn}");
        for [of_thrown, of_seen, density] in densities {
            let expected = 0.875 * of_thrown / thrown + 0.125 * of_seen / seen;
            let off = (density - expected).abs();
            assert!(off <= 0.05 * expected, "{size:?}: {density}, {expected}");
        }
        let mut counts = vec![0.0; size[0] * size[1]];
        for _ in 0..DRAWS {
            let drawn = pattern.direction([random.next(), random.next()]);
            let local = to_world.transpose() * drawn.as_dvec3();
            let at = [local.x / -local.z / halves[0], local.y / local.z / halves[1]];
            let cell = [0, 1].map(|axis: usize| {
                ((0.5 + 0.5 * at[axis]) * sizes[axis]).clamp(0.0, sizes[axis] - 0.5) as usize
            });
            counts[size[0] * cell[1] + cell[0]] += 1.0 / f64::from(DRAWS);
        }
        for (found, [_, _, expected]) in counts.iter().zip(&sums) {
            let error = (expected * (1.0 - expected).abs() / f64::from(DRAWS)).sqrt();
            let allowed = 5.0 * error + 2e-3 * expected;
            assert!((found - expected).abs() <= allowed, "{size:?}: {found}, {expected}");
        }
    }
}

/// A wall at a distance shows the picture in full color: its radiance is the reflectance over pi
/// times the intensity times the texel over the square of the distance; by all integrators. Of the
/// 4 times 108 numbers one is off by 6 standard errors with a chance of 1e-6.
#[test]
fn walls_show_the_picture() {
    const DISTANCE: f64 = 2.0;
    const SIZE: [usize; 2] = [3, 2];
    let texels = noise(21, SIZE, 2.0);
    let file = openexr(SIZE, |column, row| texels[SIZE[0] * row + column]);
    let half_angle = (0.6 / DISTANCE).atan();
    let mut document = Document::default();
    let wall = document.diffuse(0.5);
    document.quad(Vec3::ZERO, 1.5 * Vec3::X, 1.5 * Vec3::Y, wall);
    document.light(light(&file, half_angle, 3.0), Vec3::Z * DISTANCE as f32, Vec3::NEG_Z);
    document.orthographic(3.0 * Vec3::Z, Vec3::ZERO, 0.6);
    let scene = scene::<3>(&document.load("wall"), Color::Rgb, [6, 6]);
    let expected = |channel: usize, column: usize, row: usize| {
        const PLACES: usize = 16;
        let mut sum = 0.0;
        for place in 0..PLACES * PLACES {
            let inside = |index: usize, place: usize| {
                (index as f64 + (place as f64 + 0.5) / PLACES as f64) / 6.0
            };
            let (u, v) = (inside(column, place % PLACES), inside(row, place / PLACES));
            // The picture is two thirds as high as the film.
            let v = (v - 0.5) * 1.5 + 0.5;
            if (0.0..=1.0).contains(&v) {
                sum += tents(&texels, SIZE, [u * 3.0, v * 2.0])[channel];
            }
        }
        sum / (PLACES * PLACES) as f64 * 0.5 / PI * 3.0 / DISTANCE.powi(2)
    };
    for &integrator in Integrator::ALL {
        let options = settings(integrator, Mode::Scalar, Color::Rgb, 64, 2);
        let images = replicates(&scene, &Options { samples: 64, ..options }, 8);
        for (channel, pixel) in (0..108).map(|it| (it / 36, it % 36)) {
            let found = estimate(&images, channel, &[pixel]);
            let expected = expected(channel, pixel % 6, pixel / 6);
            let error = (found.mean - expected).abs();
            let most = 6.0 * found.variance.sqrt() + 4e-3 * expected + 1e-4;
            assert!(error < most, "{integrator:?} {channel} {pixel}: {found:?}, not {expected}");
        }
    }
}

#[test]
fn what_cannot_be_thrown_is_refused() {
    let put = |light: Punctual, bytes: &[u8]| {
        let mut world = World::new("lights");
        let light = world.add_light("lamp", light, DVec3::Y).unwrap();
        world.set_projection(light, bytes).map_err(|error| error.to_string())
    };
    let good = file(1, [3, 2]);
    let spot = |outer: f64| Punctual::spot(1.0, 0.0, outer);
    assert!(put(spot(0.4), &good).is_ok() && put(spot(1e-5), &good).is_ok());
    let black = openexr([2, 2], |_, _| [0.0; 3]);
    let bright = openexr([2, 2], |_, _| [3e38; 3]);
    let negative = openexr([2, 2], |_, _| [-1.0; 3]);
    for (light, bytes, words) in [
        (Punctual::point(1.0), &good, "make the light a spot"),
        (Punctual::directional(1.0), &good, "make the light a spot"),
        (spot(1.56), &good, "outer angle"),
        (spot(1e-6), &good, "outer angle"),
        (spot(0.4), &black, "black"),
        (spot(1.55), &bright, "too bright"),
        (spot(0.4), &negative, "negative"),
        (spot(0.4), &b"nothing".to_vec(), "picture"),
        (spot(0.4), &Vec::new(), "picture"),
    ] {
        let error = put(light, bytes).unwrap_err();
        assert!(error.contains("lamp") && error.contains(words), "{error}");
    }
    let world = world(&good, 0.4, DVec3::Z);
    assert!(world.describe().contains("throws a picture of 3 x 2"), "{}", world.describe());
}
