//! Painted surfaces against what pictures say by loops of their own, lamps against sums over
//! texels, normals by pictures against those of meshes, and holes against shares.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec2, DVec3, Vec2, Vec3};
use sunstone::internals::image::StokesImage;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Mode, Options};
use sunstone::internals::scattering::Scene;
use sunstone::internals::scene::World;
use sunstone::internals::spectrum::Color;
use sunstone::world::{
    Bsdf, Coverage, Filter, Geometry, Lens, Material, Paint, Picture, Reads, Relief, ReliefFrame,
    ReliefOf, Texture, Textures, Transform, Wrap,
};

use crate::support::painted::{colored, paint, picture, quad, texture};
use crate::support::random::Random;
use crate::support::rendering::spectral_replicates;
use crate::support::rendering::{MONO, image, in_bands, replicates, scene, settings};
use crate::support::statistics::{Estimate, mean_s0};

/// A quad of half edge 1 that faces the camera, which sees all of it and nothing else.
fn screen(material: Material, textures: Textures) -> World {
    let mut world = World::new("screen");
    let material = world.add_material("screen", material).unwrap();
    world.set_textures(material, textures).unwrap();
    let shape = quad(Vec3::ZERO, Vec3::X, Vec3::Y);
    world.add_mesh("screen", shape, material, Transform::IDENTITY).unwrap();
    let place = Transform::looking(DVec3::Z * 2.0, DVec3::ZERO, DVec3::Y);
    let lens = Lens::Orthographic { half_width: 1.0, half_height: 1.0 };
    world.set_camera("eye", lens, place).unwrap();
    world
}

fn random_texels(seed: u64, side: usize) -> Vec<[u8; 4]> {
    let mut random = Random(seed);
    (0..side * side).map(|_| [0; 4].map(|_| (random.next() * 255.9) as u8)).collect()
}

fn picture_of(texels: &[[u8; 4]], side: usize) -> Arc<Picture> {
    picture(side as u32, |x, y| texels[y as usize * side + x as usize])
}

/// A column or row beyond the edges of a picture, as glTF's samplers have it.
fn wrapped(at: i64, side: i64, wrap: Wrap) -> usize {
    let within = match wrap {
        Wrap::Repeat => at.rem_euclid(side),
        Wrap::Mirror => {
            let turn = at.rem_euclid(2 * side);
            if turn < side { turn } else { 2 * side - 1 - turn }
        }
        Wrap::Clamp => at.clamp(0, side - 1),
    };
    within as usize
}

const SIDE: usize = 4;

/// Linear values of a picture at its own coordinates.
fn value_at(texels: &[[u8; 4]], [u, v]: [f64; 2], of: (&Filter, [Wrap; 2])) -> DVec3 {
    let texel = |x: i64, y: i64| {
        let [x, y] = [wrapped(x, SIDE as i64, of.1[0]), wrapped(y, SIDE as i64, of.1[1])];
        let [red, green, blue, _] = texels[y * SIDE + x].map(|byte| f64::from(byte) / 255.0);
        DVec3::new(red, green, blue)
    };
    let [x, y] = [u, v].map(|at| at * SIDE as f64);
    match of.0 {
        Filter::Nearest => texel(x.floor() as i64, y.floor() as i64),
        Filter::Linear => {
            let (x, y) = (x - 0.5, y - 0.5);
            let (left, top) = (x.floor(), y.floor());
            let (i, j) = (left as i64, top as i64);
            let upper = texel(i, j).lerp(texel(i + 1, j), x - left);
            let lower = texel(i, j + 1).lerp(texel(i + 1, j + 1), x - left);
            upper.lerp(lower, y - top)
        }
    }
}

/// Some ways to lay a picture on the screen.
fn ways() -> Vec<Texture> {
    let texels = random_texels(1, SIDE);
    let mut ways = Vec::new();
    for filter in [Filter::Nearest, Filter::Linear] {
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            for set in [0, 1] {
                let mut way = texture(picture_of(&texels, SIDE), filter);
                (way.wrap, way.set) = ([wrap, Wrap::Repeat], set);
                ways.push(way.clone());
                way.transform = [[1.3, 0.4, -0.7], [-0.6, 2.1, 0.9]];
                (way.wrap[1], way.set) = (wrap, set);
                ways.push(way);
            }
        }
    }
    ways
}

/// Where the screen is seen at (x, y), from -1 to 1 to the right and up, in a picture.
fn place(way: &Texture, at: DVec2) -> [f64; 2] {
    let first = DVec2::new(0.5 + 0.5 * at.x, 0.5 - 0.5 * at.y);
    let set = if way.set == 0 { first } else { 3.0 * first - 0.7 };
    way.transform.map(|row| {
        let [a, b, c] = row.map(f64::from);
        a * set.x + b * set.y + c
    })
}

#[test]
fn lamps_emit_what_their_pictures_say() {
    let texels = random_texels(1, SIDE);
    let mut random = Random(2);
    for way in ways() {
        let factor = [0.5, 2.0, 3.0];
        let emission = Some(paint(factor, way.clone()));
        let textures = Textures { emission, ..Textures::default() };
        let scene: Arc<Scene<3>> =
            scene(&screen(Material::emitter(factor), textures), Color::Rgb, [4, 4]);
        for _ in 0..50 {
            let at = DVec2::new(random.next().into(), random.next().into()) * 2.0 - 1.0;
            // Two triangles, the first below the diagonal.
            let emitter = usize::from(at.y > at.x);
            let tint = scene.tint(emitter, Vec3::new(at.x as f32, at.y as f32, 0.0), Vec3::Z);
            let place = place(&way, at);
            let expected = value_at(&texels, place, (&way.filter, way.wrap));
            let error = (DVec3::from(tint.map(f64::from)) - expected).abs().max_element();
            // Next to the edge of a texel rounding decides.
            let near = |at: f64| ((at * SIDE as f64).rem_euclid(1.0) - 0.5).abs() > 0.4999;
            let is_edge = way.filter == Filter::Nearest && place.iter().any(|&at| near(at));
            assert!(is_edge || error < 3e-5, "{way:?} at {at}: {tint:?}, not {expected}");
        }
    }
}

/// Every pixel sees one texel, and paths meet the emitter at once: without noise.
#[test]
fn pictures_are_seen_upright_by_rays() {
    let texels = random_texels(3, SIDE);
    let emission = Some(paint([1.0; 3], texture(picture_of(&texels, SIDE), Filter::Nearest)));
    let world = screen(Material::emitter(1.0), Textures { emission, ..Textures::default() });
    let scene: Arc<Scene<3>> = scene(&world, Color::Rgb, [SIDE as u32; 2]);
    let seen = image(&scene, &settings(Integrator::Path, Mode::Scalar, Color::Rgb, 16, 1));
    for (pixel, texel) in texels.iter().enumerate() {
        for channel in 0..3 {
            let (seen, texel) = (seen.planes[channel][pixel], f32::from(texel[channel]) / 255.0);
            assert!((seen - texel).abs() < 1e-5, "pixel {pixel}: {seen}, not {texel}");
        }
    }
}

/// A colored floor under a sky, with a picture or without.
fn floor(textures: Textures, bsdf: Bsdf) -> World {
    let mut world = screen(Material::from(bsdf).two_sided(), textures);
    world.set_environment([0.9, 1.0, 1.1]).unwrap();
    let gray = world.add_material("gray", Material::from(Bsdf::diffuse(0.6)).two_sided()).unwrap();
    let side = Geometry::quad(Vec3::X * -0.8 + Vec3::Z * 0.5, Vec3::Y, Vec3::Z * 0.5);
    world.add_mesh("side", side, gray, Transform::IDENTITY).unwrap();
    world
}

/// To the last bit: what textures cost is a look, and no path goes another way.
#[test]
fn a_picture_of_one_color_is_that_color() {
    let bytes = [51_u8, 153, 204, 255];
    let factor = [0.9_f32, 0.8, 0.7];
    let color = std::array::from_fn(|n| factor[n] * (f32::from(bytes[n]) / 255.0));
    let even = picture(3, |_, _| bytes);
    let mut textures = colored(texture(even, Filter::Linear));
    textures.parameters[0].1.factor = factor;
    let worlds = || {
        [
            floor(textures.clone(), Bsdf::diffuse(factor)),
            floor(Textures::default(), Bsdf::diffuse(color)),
        ]
    };
    for integrator in [Integrator::Path, Integrator::Bdpt, Integrator::Ppm] {
        for color in [Color::Rgb, MONO] {
            let options = settings(integrator, Mode::Polarized, color.clone(), 2, 4);
            let [painted, plain]: [StokesImage; 2] = worlds().map(|world| match color {
                Color::Rgb => image(&scene::<3>(&world, Color::Rgb, [8, 8]), &options),
                _ => image(&scene::<1>(&world, MONO, [8, 8]), &options),
            });
            assert!(mean_s0(&plain) > 0.1);
            assert_eq!(painted.planes, plain.planes, "{integrator:?} {color:?}");
        }
    }
    let bands = [[450.0, 40.0], [620.0, 40.0]];
    let [painted, plain] = worlds().map(|world| {
        let options = settings(Integrator::Path, Mode::Scalar, MONO, 2, 4);
        let options = in_bands(4, &bands, [8, 8], options);
        let placed = sunstone::PlacedWorld::new(world).unwrap();
        spectral_replicates(&placed, &options, 1).remove(0)
    });
    assert_eq!(painted.planes, plain.planes);
}

/// A floor of half edge 0.01 in the middle under a lamp of half edge 1 at a height of 1.
fn lit_by_picture(texels: &[[u8; 4]]) -> World {
    let mut world = World::new("lit by a picture");
    let floor = world.add_material("floor", Bsdf::diffuse(1.0)).unwrap();
    let shape = Geometry::quad(Vec3::ZERO, Vec3::X * 0.01, Vec3::Y * 0.01);
    world.add_mesh("floor", shape, floor, Transform::IDENTITY).unwrap();
    let factor = [1.0, 2.0, 0.5];
    let lamp = world.add_material("lamp", Material::emitter(factor)).unwrap();
    let way = texture(picture_of(texels, SIDE), Filter::Linear);
    let emission = Some(paint(factor, way));
    world.set_textures(lamp, Textures { emission, ..Textures::default() }).unwrap();
    // Seen from below: its picture is upright along -x and y.
    let shape = quad(Vec3::Z, Vec3::NEG_X, Vec3::Y);
    world.add_mesh("lamp", shape, lamp, Transform::IDENTITY).unwrap();
    let place = Transform::looking(DVec3::Z * 0.5, DVec3::ZERO, DVec3::Y);
    let lens = Lens::Orthographic { half_width: 0.01, half_height: 0.01 };
    world.set_camera("eye", lens, place).unwrap();
    world
}

/// What the middle of the floor gets, by a sum over the lamp.
fn irradiance(texels: &[[u8; 4]]) -> DVec3 {
    const STEPS: usize = 400;
    let mut sum = DVec3::ZERO;
    for (i, j) in (0..STEPS * STEPS).map(|at| (at % STEPS, at / STEPS)) {
        let [u, v] = [i, j].map(|at| (at as f64 + 0.5) / STEPS as f64);
        let value = value_at(texels, [u, v], (&Filter::Linear, [Wrap::Repeat; 2]));
        let distance2 = (2.0 * u - 1.0).powi(2) + (2.0 * v - 1.0).powi(2) + 1.0;
        sum += value / (distance2 * distance2);
    }
    sum * DVec3::new(1.0, 2.0, 0.5) * 4.0 / (STEPS * STEPS) as f64
}

/// The integral to about 1e-5, the floor's extent to 1e-4. Nine numbers are compared within 4.5
/// standard errors of at least 16 images: noise fails it in 1 of 1,000 cases at most.
#[test]
fn light_of_a_picture_is_the_sum_over_it() {
    let texels = random_texels(5, SIDE);
    let expected = irradiance(&texels) / PI;
    let scene: Arc<Scene<3>> = scene(&lit_by_picture(&texels), Color::Rgb, [2, 2]);
    for integrator in [Integrator::Path, Integrator::Light, Integrator::Bdpt] {
        let options = settings(integrator, Mode::Scalar, Color::Rgb, 256, 2);
        let images = replicates(&scene, &options, 16);
        for channel in 0..3 {
            let of =
                |image: &StokesImage| f64::from(image.planes[channel].iter().sum::<f32>()) / 4.0;
            let means: Vec<f64> = images.iter().map(of).collect();
            let found = Estimate::of(&means);
            let score = found.score(&Estimate::exact(expected[channel]), expected[channel]);
            let (score, mean) = (score.unwrap_or(0.0), found.mean);
            let far = (mean / expected[channel] - 1.0).abs();
            assert!(score.abs() < 4.5 && far < 0.1, "{integrator:?}: {mean}, not {expected}");
        }
    }
}

/// A mesh whose normals lean as one texel says, and one whose normals a picture of it bends.
#[test]
fn normals_by_a_picture_are_those_of_a_mesh_that_leans() {
    for bytes in [[180_u8, 90, 230, 255], [128, 128, 255, 255]] {
        let own = Vec3::from_array([0, 1, 2].map(|n| 2.0 * f32::from(bytes[n]) / 255.0 - 1.0));
        let leaning = |geometry: Geometry| {
            // The screen's right, up and front are x, y and z.
            let normals = vec![own.normalize(); geometry.positions.len()];
            Geometry { normals, ..geometry }
        };
        let relief = Relief {
            texture: texture(picture(2, |_, _| bytes), Filter::Linear),
            scale: 1.0,
            of: ReliefOf::Normals(ReliefFrame::Picture),
        };
        let bent = Textures { relief: Some(relief), ..Textures::default() };
        let of = |textures: Textures, shape: Geometry| {
            let mut world = World::new("leaning");
            let floor = world.add_material("floor", Bsdf::diffuse([0.8, 0.5, 0.3])).unwrap();
            world.set_textures(floor, textures).unwrap();
            world.add_mesh("floor", shape, floor, Transform::IDENTITY).unwrap();
            let light = sunstone::world::Punctual::point(3.0);
            let place = Transform::from(DVec3::new(0.4, 0.3, 1.0));
            world.add_light("lamp", light, place).unwrap();
            let place = Transform::looking(DVec3::Z * 2.0, DVec3::ZERO, DVec3::Y);
            let lens = Lens::Orthographic { half_width: 1.0, half_height: 1.0 };
            world.set_camera("eye", lens, place).unwrap();
            let scene: Arc<Scene<3>> = scene(&world, Color::Rgb, [8, 8]);
            image(&scene, &settings(Integrator::Path, Mode::Scalar, Color::Rgb, 4, 2))
        };
        let shape = quad(Vec3::ZERO, Vec3::X, Vec3::Y);
        let flat = shape.clone();
        let [painted, meshed] = [of(bent, shape.clone()), of(Textures::default(), leaning(shape))];
        assert!(mean_s0(&meshed) > 0.05);
        for (a, b) in painted.planes.concat().iter().zip(meshed.planes.concat()) {
            assert!((a - b).abs() <= 1e-5 * b.abs().max(0.01), "{bytes:?}: {a}, not {b}");
        }
        // Flat but for half a step of a byte.
        let plain = of(Textures::default(), flat);
        let far = (mean_s0(&painted) / mean_s0(&plain) - 1.0).abs();
        assert_eq!(far < 0.01, bytes[0] == 128, "{far}");
    }
}

/// Of a lamp behind a sheet what its holes let through is seen: exactly for holes that are there or
/// not, else by chance: of 32 pixels and 256 paths each, with a standard error of 0.0055 at most.
/// 4.5 of these are exceeded in 1 of 100,000 cases.
#[test]
fn holes_let_their_share_through() {
    let [low, high] = [51_u8, 204];
    for (cutoff, by) in [(None, 0.8_f64), (Some(0.5), 1.0)] {
        let way =
            texture(picture(2, |x, _| [0, 0, 0, if x == 0 { low } else { high }]), Filter::Nearest);
        let paint = Paint {
            factor: [by as f32; 3],
            texture: Some(way),
            reads: Reads::Alpha,
            by_vertices: false,
        };
        let coverage = Some(Coverage { paint, cutoff });
        let textures = Textures { coverage, ..Textures::default() };
        let mut world = screen(Material::from(Bsdf::Absorber).two_sided(), textures);
        let lamp = world.add_material("lamp", Material::emitter(1.0)).unwrap();
        let behind = Geometry::quad(Vec3::Z * -0.5, Vec3::X * 2.0, Vec3::Y * 2.0);
        world.add_mesh("lamp", behind, lamp, Transform::IDENTITY).unwrap();
        let scene: Arc<Scene<1>> = scene(&world, MONO, [8, 8]);
        for integrator in [Integrator::Path, Integrator::Bdpt, Integrator::Light] {
            let options = settings(integrator, Mode::Polarized, MONO, 256, 2);
            let seen = image(&scene, &options);
            for (side, byte) in [(0, low), (1, high)] {
                let pixels = (0..64).filter(|pixel| (pixel % 8 < 4) == (side == 0));
                let mean = pixels.map(|pixel| f64::from(seen.planes[0][pixel])).sum::<f64>() / 32.0;
                let alpha = by * f64::from(byte) / 255.0;
                let open = match cutoff {
                    Some(least) => f64::from(u8::from(alpha < f64::from(least))),
                    None => 1.0 - alpha,
                };
                let noise = if integrator == Integrator::Light { 0.1 } else { 0.025 };
                let exact = cutoff.is_some() && integrator != Integrator::Light;
                let allowed = if exact { 1e-5 } else { noise };
                assert!(
                    (mean - open).abs() < allowed,
                    "{integrator:?} {cutoff:?}: {mean}, not {open}"
                );
            }
        }
    }
}

#[test]
fn what_has_no_coordinates_takes_no_textures() {
    let way = texture(picture(1, |_, _| [9; 4]), Filter::Linear);
    let mut world = World::new("refused");
    let of = |world: &mut World, way: Texture| {
        let material = world.add_material("", Bsdf::diffuse(0.5)).unwrap();
        world.set_textures(material, colored(way)).unwrap();
        material
    };
    let material = of(&mut world, way.clone());
    let shape = Geometry::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
    let error = world.add_mesh("bare", shape, material, Transform::IDENTITY).unwrap_err();
    assert!(error.to_string().contains("TEXCOORD_0"), "{error}");
    world.add_sphere("ball", 1.0, material, DVec3::ZERO).expect("spheres have coordinates");
    let mut second = quad(Vec3::ZERO, Vec3::X, Vec3::Y);
    second.texture_coordinates_1 = Vec::new();
    let material = of(&mut world, Texture { set: 1, ..way.clone() });
    assert!(world.add_mesh("one set", second, material, Transform::IDENTITY).is_err());
    let glass = world.add_material("glass", Bsdf::dielectric(1.5)).unwrap();
    let error = world.set_textures(glass, colored(way)).unwrap_err();
    assert!(error.to_string().contains("no parameter"), "{error}");
    let mut broken = quad(Vec3::ZERO, Vec3::X, Vec3::Y);
    broken.colors[1].y = f32::NAN;
    let plain = world.add_material("plain", Bsdf::diffuse(0.5)).unwrap();
    assert!(world.add_mesh("broken", broken, plain, Transform::IDENTITY).is_err());
}

/// Coordinates of one point, or beyond all numbers, have some value, and frames that there are
/// none of leave the normal.
#[test]
fn odd_coordinates_render() {
    let texels = random_texels(7, SIDE);
    let way = texture(picture_of(&texels, SIDE), Filter::Linear);
    let relief = Some(Relief {
        texture: way.clone(),
        scale: 1e6,
        of: ReliefOf::Normals(ReliefFrame::Picture),
    });
    for odd in [Vec2::ZERO, Vec2::splat(1e30), Vec2::splat(-1e-30), Vec2::splat(f32::MAX)] {
        let textures = Textures { relief: relief.clone(), ..colored(way.clone()) };
        let mut world = floor(textures, Bsdf::diffuse(0.8));
        for mesh in world.entities_mut().query_mut::<&mut sunstone::world::Mesh>() {
            let geometry = Arc::make_mut(&mut mesh.0);
            geometry.texture_coordinates.iter_mut().for_each(|pair| *pair = odd);
        }
        let scene: Arc<Scene<3>> = scene(&world, Color::Rgb, [4, 4]);
        let options: Options = settings(Integrator::Bdpt, Mode::Polarized, Color::Rgb, 2, 3);
        let seen = image(&scene, &options);
        assert!(seen.planes.concat().iter().all(|value| value.is_finite()), "{odd}");
        assert!(mean_s0(&seen) > 0.0, "{odd}");
    }
}
