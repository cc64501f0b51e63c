//! Pictures of all directions, and small scenes under them and under suns.

use std::f32::consts::FRAC_PI_3;
use std::io::Cursor;
use std::sync::Arc;

use exr::prelude::{Image, SpecificChannels, Vec2 as Place, WritableImage};
use glam::{DAffine3, DQuat, DVec3, Mat3, Quat, Vec3};
use sunstone::internals::image::texels::Texels;
use sunstone::internals::scene::World;
use sunstone::internals::scene::panorama::Panorama;
use sunstone::world::{Bsdf, ClearSky, Geometry, Lens, Material, Picture, Punctual, Transform};

use super::random::Random;
use super::scenes::{Named, v};

/// All of them.
pub const SKIES: [Named; 5] = [
    ("a sky by a picture", pictured),
    ("a single texel shines on glass", single_texel),
    ("a sky by a picture, suns and lamps", pictured_with_lamps),
    ("a wide sun and mirrors", mirrored_sun),
    ("a clear sky on glass and metal", clear),
];

/// An OpenEXR file of a picture, by column and row.
pub fn openexr(
    [width, height]: [usize; 2],
    texel: impl Fn(usize, usize) -> [f32; 3] + Sync,
) -> Vec<u8> {
    let channels = SpecificChannels::rgb(|at: Place<usize>| {
        let [red, green, blue] = texel(at.x(), at.y());
        (red, green, blue)
    });
    let mut bytes = Cursor::new(Vec::new());
    let image = Image::from_channels((width, height), channels);
    image.write().non_parallel().to_buffered(&mut bytes).expect("memory takes pictures");
    bytes.into_inner()
}

/// The picture of such a file, turned by a rotation.
pub fn panorama(
    size: [usize; 2],
    texel: impl Fn(usize, usize) -> [f32; 3] + Sync,
    rotation: Quat,
) -> Panorama {
    let texels = Texels::decode(&openexr(size, texel)).expect("what was just written");
    let picture = Arc::new(Picture::new(texels, 0));
    Panorama::new(picture, [1.0; 3], Mat3::from_quat(rotation))
}

/// Random texels of all sizes, of which some are black, and one is so many times as bright.
pub fn noise(seed: u64, [width, height]: [usize; 2], brightest: f32) -> Vec<[f32; 3]> {
    let mut random = Random(seed);
    let mut texels: Vec<[f32; 3]> = (0..width * height)
        .map(|_| {
            let is_black = random.next() < 0.2;
            [0; 3].map(|_| if is_black { 0.0 } else { random.next().powi(3) })
        })
        .collect();
    let brightest_at = texels.len() / 3;
    texels[brightest_at] = texels[brightest_at].map(|value| (value + 0.5) * brightest);
    texels
}

/// The rotation of the scenes.
fn turned() -> DQuat {
    DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7)
}

/// A picture of some noise about a world.
fn surround(world: &mut World, seed: u64, brightest: f32) {
    const SIZE: [usize; 2] = [8, 4];
    let texels = noise(seed, SIZE, brightest);
    let bytes = openexr(SIZE, |column, row| texels[SIZE[0] * row + column]);
    world.set_environment_map(&bytes, [0.6, 0.8, 1.0], turned()).expect("sound");
}

/// A floor, a wall, and a ball of some material on the floor.
fn stage(ball: Bsdf) -> World {
    let mut world = World::new("under the sky");
    let white = Material::from(Bsdf::diffuse([0.7, 0.6, 0.5])).two_sided();
    let white = world.add_material("white", white).expect("sound");
    let floor = Geometry::quad(v(0.0, -1.0, 0.0), v(1.2, 0.0, 0.0), v(0.0, 0.0, -1.2));
    world.add_mesh("floor", floor, white, Transform::IDENTITY).expect("sound");
    let wall = Geometry::quad(v(-1.0, 0.0, 0.0), v(0.0, 0.0, -1.0), v(0.0, 1.0, 0.0));
    world.add_mesh("wall", wall, white, Transform::IDENTITY).expect("sound");
    let ball = world.add_material("ball", ball).expect("sound");
    world.add_sphere("ball", 0.5, ball, DVec3::new(0.3, -0.4, 0.0)).expect("sound");
    let place = Transform::looking(DVec3::new(0.6, 0.5, 3.6), DVec3::new(0.0, -0.4, 0.0), DVec3::Y);
    world.set_camera("eye", Lens::pinhole(0.62), place).expect("sound");
    world
}

/// A sun that shines along a direction, of an angle in radians.
pub fn add_sun(world: &mut World, along: DVec3, irradiance: f32, diameter: f64) {
    let rotation = DQuat::from_rotation_arc(DVec3::NEG_Z, along.normalize());
    let place = Transform(DAffine3::from_quat(rotation));
    world.add_light("sun", Punctual::sun(irradiance, diameter), place).expect("sound");
}

fn pictured() -> World {
    let mut world = stage(Bsdf::dielectric(1.5));
    surround(&mut world, 3, 8.0);
    world
}

fn single_texel() -> World {
    const SIZE: [usize; 2] = [12, 6];
    let mut world = stage(Bsdf::diffuse(0.5));
    let pane = world.add_material("pane", Bsdf::thin_dielectric(1.5)).expect("sound");
    let shape = Geometry::quad(v(0.2, 0.6, 0.3), v(0.6, 0.2, 0.0), v(0.0, 0.1, -0.6));
    world.add_mesh("pane", shape, pane, Transform::IDENTITY).expect("sound");
    let bytes = openexr(
        SIZE,
        |column, row| {
            if [column, row] == [8, 1] { [30.0, 20.0, 10.0] } else { [0.0; 3] }
        },
    );
    world.set_environment_map(&bytes, [1.0; 3], DQuat::IDENTITY).expect("sound");
    world
}

fn pictured_with_lamps() -> World {
    let mut world = stage(Bsdf::metal("Al").expect("it is tabulated"));
    surround(&mut world, 4, 3.0);
    add_sun(&mut world, DVec3::new(0.3, -1.0, -0.4), 1.0, f64::from(FRAC_PI_3));
    add_sun(&mut world, DVec3::new(-0.6, -0.7, 0.4), 2.0, 0.1);
    let lamp = world.add_material("lamp", Material::emitter(3.0)).expect("sound");
    let shape = Geometry::quad(v(0.1, 0.9, 0.0), v(0.3, 0.0, 0.0), v(0.0, 0.0, 0.3));
    world.add_mesh("lamp", shape, lamp, Transform::IDENTITY).expect("sound");
    let point = Transform(DAffine3::from_translation(DVec3::new(-0.5, 0.5, 0.5)));
    world.add_light("point", Punctual::point(0.3), point).expect("sound");
    world
}

fn mirrored_sun() -> World {
    let mut world = stage(Bsdf::metal("Cu").expect("it is tabulated"));
    let metal = Material::from(Bsdf::metal("Al").expect("it is tabulated")).two_sided();
    let metal = world.add_material("mirror", metal).expect("sound");
    let shape = Geometry::quad(v(0.9, 0.0, -0.4), v(0.0, 0.0, 0.7), v(-0.2, 0.8, 0.0));
    world.add_mesh("mirror", shape, metal, Transform::IDENTITY).expect("sound");
    add_sun(&mut world, DVec3::new(0.6, -1.0, -0.5), 2.0, 0.7);
    world
}

fn clear() -> World {
    let mut world = stage(Bsdf::dielectric(1.5));
    let metal = Material::from(Bsdf::metal("Cu").expect("it is tabulated")).two_sided();
    let metal = world.add_material("mirror", metal).expect("sound");
    let shape = Geometry::quad(v(0.9, 0.0, -0.4), v(0.0, 0.0, 0.7), v(-0.2, 0.8, 0.0));
    world.add_mesh("mirror", shape, metal, Transform::IDENTITY).expect("sound");
    let sun = DVec3::new(-0.4, 0.5, 0.6);
    world.set_clear_sky(ClearSky { sun, turbidity: 3.0, max_degree: 0.8 }, 0.1).expect("sound");
    world
}

/// The direction to a place of the unit square of a picture in its own space.
pub fn direction_of([u, v]: [f64; 2]) -> Vec3 {
    let (azimuth, polar) = (std::f64::consts::TAU * (u - 0.5), std::f64::consts::PI * v);
    let [x, y, z] = [polar.sin() * azimuth.cos(), polar.cos(), polar.sin() * azimuth.sin()];
    DVec3::new(x, y, z).as_vec3()
}
