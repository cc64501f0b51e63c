//! Light from pictures of all directions and from suns: what it brings to planes against integrals
//! that are found otherwise, and the frequencies of directions against their densities.
//!
//! Scores of renders are normal numbers; about 60 are compared with a limit of 5, so that chance
//! fails a change of the random numbers in 1 of 30,000 cases.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DQuat, DVec3, Quat, Vec3};
use sunstone::internals::image::StokesImage;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Mode, Options, Photons};
use sunstone::internals::scattering::Scene;
use sunstone::internals::scene::World;
use sunstone::internals::scene::panorama::Panorama;
use sunstone::internals::spectrum::{Carried, Color};
use sunstone::world::{Bsdf, ClearSky, Geometry, Lens, Material, Transform};

use crate::support::random::Random;
use crate::support::rendering::{replicates, scene, settings};
use crate::support::skies::{add_sun, direction_of, noise, openexr, panorama};
use crate::support::statistics::{Estimate, ROUNDING, cells, estimate};

const SIZE: [u32; 2] = [8, 8];
const LIMIT: f64 = 5.0;
const REFLECTANCE: f32 = 0.6;
const INTEGRATORS: [Integrator; 4] =
    [Integrator::Path, Integrator::Light, Integrator::Bdpt, Integrator::Ppm];

/// Pictures of all shapes: sizes, and how bright the brightest texel is.
const PICTURES: [([usize; 2], f32); 7] = [
    ([1, 1], 1.0),
    ([1, 3], 2.0),
    ([3, 1], 2.0),
    ([2, 2], 1.0),
    ([8, 4], 1.0),
    ([16, 8], 1e6),
    ([5, 9], 1e3),
];

fn pictures() -> impl Iterator<Item = ([usize; 2], Vec<[f32; 3]>, Panorama)> {
    PICTURES.into_iter().zip(1..).map(|((size, brightest), seed)| {
        let texels = noise(seed, size, brightest);
        let of = |column: usize, row: usize| texels[size[0] * row + column];
        let rotation = Quat::from_axis_angle(Vec3::new(1.0, 2.0, 3.0).normalize(), seed as f32);
        let made = panorama(size, of, rotation);
        (size, texels, made)
    })
}

/// Directions and the steradians that each stands for: Gauss's two points each way in a grid of
/// cells whose edges are the middles of a picture's texels, too.
fn around(size: [usize; 2], rotation: Quat, mut visit: impl FnMut(Vec3, f64)) {
    let fine = [24 * size[0], 16 * size[1]];
    let half = 0.5 / 3_f64.sqrt();
    for cell in 0..fine[0] * fine[1] {
        let [column, row] = [cell % fine[0], cell / fine[0]].map(|at| at as f64 + 0.5);
        for [a, b] in [[-half, -half], [-half, half], [half, -half], [half, half]] {
            let [u, v] = [(column + a) / fine[0] as f64, (row + b) / fine[1] as f64];
            let steradians = 0.25 * 2.0 * PI * PI * (PI * v).sin() / (fine[0] * fine[1]) as f64;
            visit(rotation * direction_of([u, v]), steradians);
        }
    }
}

/// The integral of a function over all directions.
fn integral(size: [usize; 2], rotation: Quat, of: impl Fn(Vec3) -> f64) -> f64 {
    let mut sum = 0.0;
    around(size, rotation, |direction, steradians| sum += steradians * of(direction));
    sum
}

fn rotation(seed: usize) -> Quat {
    Quat::from_axis_angle(Vec3::new(1.0, 2.0, 3.0).normalize(), seed as f32)
}

#[test]
fn pictures_show_what_is_where() {
    let red_green_blue = |column: usize, row: usize| {
        let is_in = |range: std::ops::Range<usize>, at| f32::from(u8::from(range.contains(&at)));
        [is_in(15..17, column), is_in(23..25, column), is_in(0..2, row)]
    };
    let sky = panorama([32, 16], red_green_blue, Quat::IDENTITY);
    let seen = |direction: Vec3| sky.radiance(direction, &Carried::RGB);
    assert_eq!([Vec3::X, Vec3::Z].map(seen), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!([Vec3::NEG_X, Vec3::NEG_Z].map(seen), [[0.0; 3]; 2]);
    assert_eq!((seen(Vec3::Y)[2], seen(Vec3::NEG_Y)[2]), (1.0, 0.0));
    let turned = panorama([32, 16], red_green_blue, Quat::from_rotation_y(PI as f32 / 2.0));
    assert_eq!(turned.radiance(Vec3::NEG_Z, &Carried::RGB), [1.0, 0.0, 0.0]);
}

#[test]
fn pictures_are_interpolated_around_and_held_at_the_poles() {
    let mut random = Random(5);
    for ((size, texels, sky), seed) in pictures().zip(1..) {
        let [width, height] = size;
        let most = texels.iter().flatten().copied().fold(0.0, f32::max);
        for _ in 0..200 {
            let [u, v] = [random.next(), random.next()].map(f64::from);
            let seen = sky.radiance(rotation(seed) * direction_of([u, v]), &Carried::RGB);
            let (x, y) = (u * width as f64 - 0.5, v * height as f64 - 0.5);
            let texel = |dx: f64, dy: f64, n: usize| {
                let column = (x.floor() + dx).rem_euclid(width as f64) as usize;
                let row = (y.floor() + dy).clamp(0.0, height as f64 - 1.0) as usize;
                f64::from(texels[width * row + column][n])
            };
            let (right, down) = (x - x.floor(), y - y.floor());
            for (n, seen) in seen.into_iter().enumerate() {
                let upper = texel(0.0, 0.0, n) * (1.0 - right) + texel(1.0, 0.0, n) * right;
                let lower = texel(0.0, 1.0, n) * (1.0 - right) + texel(1.0, 1.0, n) * right;
                let expected = upper * (1.0 - down) + lower * down;
                // Of a single-precision direction: so many texels off.
                let tolerance = 3e-5 * f64::from(most) + 1e-6;
                assert!((f64::from(seen) - expected).abs() < tolerance, "{size:?}, {u}, {v}");
            }
        }
    }
}

#[test]
fn densities_and_means_are_integrals() {
    for ((size, _, sky), seed) in pictures().zip(1..) {
        let whole = integral(size, rotation(seed), |direction| f64::from(sky.pdf(direction)));
        assert!((whole - 1.0).abs() < 1e-3, "{size:?}: {whole}");
        for (n, mean) in sky.mean().into_iter().enumerate() {
            let seen = |direction| f64::from(sky.radiance(direction, &Carried::RGB)[n]);
            let expected = integral(size, rotation(seed), seen) / (4.0 * PI);
            let error = f64::from(mean) / expected - 1.0;
            assert!(error.abs() < 1e-3, "{size:?}: {mean} for {expected}");
        }
    }
}

#[test]
fn what_is_drawn_has_its_density_and_is_seen() {
    let mut random = Random(6);
    for (size, _, sky) in pictures() {
        for _ in 0..2000 {
            let (direction, pdf) = sky.draw([random.next(), random.next()]);
            assert!(pdf > 0.0 && pdf.is_finite() && direction.is_normalized(), "{size:?}");
            // A single-precision direction is a little off.
            let again = sky.pdf(direction);
            assert!((again / pdf - 1.0).abs() < 2e-2, "{size:?}: {again} for {pdf}");
            assert!(sky.radiance(direction, &Carried::RGB) != [0.0; 3], "{size:?}");
        }
        let ends = [0.0, 1.0 - f32::EPSILON / 2.0];
        for u in ends {
            for v in ends {
                let (direction, pdf) = sky.draw([u, v]);
                assert!(pdf > 0.0 && pdf.is_finite() && direction.is_normalized(), "{u}, {v}");
            }
        }
    }
}

/// Pearson's statistic of 12 by 8 cells, made normal after Wilson and Hilferty 1931: one of seven
/// is beyond the limit in 1 of 500,000 cases.
#[test]
fn frequencies_are_those_of_the_densities() {
    const CELLS: [usize; 2] = [12, 8];
    const COUNT: usize = 40_000;
    const LEAST: f64 = 10.0;
    let mut random = Random(7);
    for ((size, _, sky), seed) in pictures().zip(1..) {
        let inverse = rotation(seed).inverse();
        let cell = |direction: Vec3| {
            let at = (inverse * direction).as_dvec3();
            let u = at.z.atan2(at.x) / (2.0 * PI) + 0.5;
            let v = at.y.clamp(-1.0, 1.0).acos() / PI;
            let [u, v] = [(u, CELLS[0]), (v, CELLS[1])]
                .map(|(at, count)| ((at * count as f64) as usize).min(count - 1));
            CELLS[0] * v + u
        };
        let mut cells = [[0.0; 2]; CELLS[0] * CELLS[1]];
        for _ in 0..COUNT {
            cells[cell(sky.draw([random.next(), random.next()]).0)][0] += 1.0;
        }
        around(size, rotation(seed), |direction, steradians| {
            let expected = steradians * f64::from(sky.pdf(direction)) * COUNT as f64;
            cells[cell(direction)][1] += expected;
        });
        // Rare ones count together.
        let (rare, mut cells): (Vec<_>, Vec<_>) =
            cells.into_iter().partition(|[_, expected]| *expected < LEAST);
        let rare = rare.into_iter().fold([0.0; 2], |sum, one| [sum[0] + one[0], sum[1] + one[1]]);
        if rare[1] > 0.0 {
            cells.push([rare[0], rare[1].max(LEAST)]);
        }
        let sum: f64 =
            cells.iter().map(|[found, expected]| (found - expected).powi(2) / expected).sum();
        let degrees = (cells.len() - 1).max(1) as f64;
        let spread = 2.0 / (9.0 * degrees);
        let score = ((sum / degrees).cbrt() - (1.0 - spread)) / spread.sqrt();
        println!("{size:?}: {score:.2} of {} cells", cells.len());
        assert!(score < LIMIT, "{size:?}: {score}");
    }
}

/// A floor, seen from above by parallel rays, on and above a plane.
fn floor() -> World {
    let mut world = World::new("floor");
    let white = world.add_material("white", Bsdf::diffuse(REFLECTANCE)).expect("sound");
    let shape = Geometry::quad(Vec3::ZERO, Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 0.0, -1.0));
    world.add_mesh("floor", shape, white, Transform::IDENTITY).expect("sound");
    let place = Transform::looking(DVec3::Y, DVec3::ZERO, DVec3::NEG_Z);
    let lens = Lens::Orthographic { half_width: 0.5, half_height: 0.5 };
    world.set_camera("eye", lens, place).expect("sound");
    world
}

/// Images of direct light.
fn images(scene: &Arc<Scene<3>>, integrator: Integrator) -> Vec<StokesImage> {
    let options = settings(integrator, Mode::Polarized, Color::Rgb, 16, 2);
    // So small a kernel that its bias drowns in the noise.
    let radius = Some(0.02 * scene.shapes.bounds.radius);
    let photons = Photons { alpha: 1.0, radius, ..options.photons };
    replicates(scene, &Options { photons, ..options }, 24)
}

/// Compares the mean radiance of all integrators with that of an irradiance.
fn check(world: &World, irradiance: [f64; 3], what: &str) {
    let scene = scene::<3>(world, Color::Rgb, SIZE);
    let all = vec![true; (SIZE[0] * SIZE[1]) as usize];
    let whole = &cells(SIZE[0] as usize, SIZE[1] as usize, SIZE[0] as usize, &all)[0];
    for integrator in INTEGRATORS {
        let images = images(&scene, integrator);
        for (plane, irradiance) in irradiance.into_iter().enumerate() {
            let expected = f64::from(REFLECTANCE) * irradiance / PI;
            let found = estimate(&images, plane, whole);
            let score = found.score(&Estimate::exact(expected), expected);
            println!("{what}, {integrator:?}: {} for {expected}, {score:?}", found.mean);
            match score {
                Some(score) => assert!(score.abs() < LIMIT, "{what}, {integrator:?}: {score}"),
                None => assert!((found.mean / expected - 1.0).abs() < ROUNDING, "{what}"),
            }
        }
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn pictures_light_planes_as_their_integrals_say() {
    for ((size, texels, sky), seed) in pictures().zip(1..) {
        let mut world = floor();
        let bytes = openexr(size, |column, row| texels[size[0] * row + column]);
        let turn = rotation(seed).as_dquat();
        world.set_environment_map(&bytes, [1.0, 0.5, 0.25], turn.normalize()).expect("sound");
        let irradiance = [1.0, 0.5, 0.25].into_iter().enumerate().map(|(n, factor)| {
            factor
                * integral(size.map(|side| 4 * side), rotation(seed), |direction| {
                    let cosine = f64::from(direction.y.max(0.0));
                    f64::from(sky.radiance(direction, &Carried::RGB)[n]) * cosine
                })
        });
        let irradiance: Vec<f64> = irradiance.collect();
        check(&world, [irradiance[0], irradiance[1], irradiance[2]], &format!("{size:?}"));
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn suns_light_planes_by_the_cosine_of_their_middle() {
    for (diameter, along) in [
        (0.0093, DVec3::new(0.3, -1.0, 0.2)),
        (1e-5, DVec3::new(2.0, -1.0, -1.0)),
        (1.0, DVec3::new(-0.3, -1.0, 0.2)),
    ] {
        let mut world = floor();
        add_sun(&mut world, along, 3.0, diameter);
        let cosine = -along.normalize().y;
        check(&world, [3.0 * cosine; 3], &format!("a sun of {diameter}"));
    }
}

/// An edge between a sun overhead and the floor: what of the sun is past it, point by point.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn suns_cast_penumbras() {
    const DIAMETER: f64 = 0.6;
    const HEIGHT: f64 = 0.5;
    let mut world = floor();
    let black = Material::from(Bsdf::Absorber).two_sided();
    let black = world.add_material("black", black).expect("sound");
    let at = Vec3::new(-2.0, HEIGHT as f32, 0.0);
    let shape = Geometry::quad(at, Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 0.0, -4.0));
    world.add_mesh("edge", shape, black, Transform::IDENTITY).expect("sound");
    add_sun(&mut world, DVec3::NEG_Y, 1.0, DIAMETER);
    // From below the edge, against what is lit.
    let place = Transform::looking(DVec3::new(0.0, 0.4, 0.0), DVec3::ZERO, DVec3::NEG_Z);
    let lens = Lens::Orthographic { half_width: 0.2, half_height: 0.2 };
    world.set_camera("eye", lens, place).expect("sound");
    let scene = scene::<3>(&world, Color::Rgb, SIZE);
    // Of directions that are even in projected solid angle, a disk.
    let sine = (0.5 * DIAMETER).sin();
    let lit = |x: f64| {
        const STEPS: usize = 400;
        let step = |index: usize| 2.0 * (index as f64 + 0.5) / STEPS as f64 - 1.0;
        let (mut sum, mut all) = (0.0, 0.0);
        for [a, b] in (0..STEPS * STEPS).map(|it| [step(it % STEPS), step(it / STEPS)]) {
            if a * a + b * b <= 1.0 {
                let [a, b] = [a, b].map(|it| it * sine);
                all += 1.0;
                sum += f64::from(u8::from(x + HEIGHT * a / (1.0 - a * a - b * b).sqrt() > 0.0));
            }
        }
        sum / all
    };
    for integrator in INTEGRATORS {
        let images = images(&scene, integrator);
        for column in 0..SIZE[0] as usize {
            let x = 0.4 * ((column as f64 + 0.5) / f64::from(SIZE[0]) - 0.5);
            // Over a column of pixels, the mean of three points.
            let of = |at: f64| lit(x + 0.4 / f64::from(SIZE[0]) * at);
            let offset = 0.5 * 0.6_f64.sqrt();
            let mean = (5.0 * of(-offset) + 8.0 * of(0.0) + 5.0 * of(offset)) / 18.0;
            let expected = f64::from(REFLECTANCE) / PI * mean;
            let rows = (0..SIZE[1] as usize).map(|row| SIZE[0] as usize * row + column);
            let found = estimate(&images, 0, &rows.collect::<Vec<_>>());
            // The quadrature's own error.
            let error = 2e-4 + found.variance.sqrt() * LIMIT;
            println!("{integrator:?} {column}: {} for {expected} +- {error}", found.mean);
            assert!((found.mean - expected).abs() < error, "{integrator:?}, {column}");
        }
    }
}

/// Seen straight, a sun is a disk of its radiance, and in a picture of one color nothing else.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn suns_and_pictures_are_seen_as_they_shine() {
    const DIAMETER: f64 = 0.3;
    let mut world = World::new("sun");
    let place = Transform::looking(DVec3::ZERO, DVec3::Z, DVec3::Y);
    world.set_camera("eye", Lens::pinhole(0.5), place).expect("sound");
    add_sun(&mut world, DVec3::NEG_Z, 2.0, DIAMETER);
    let grey = openexr([4, 2], |_, _| [0.25, 0.5, 1.0]);
    world.set_environment_map(&grey, [2.0; 3], DQuat::IDENTITY).expect("sound");
    let scene = scene::<3>(&world, Color::Rgb, [32, 32]);
    let radiance = 2.0 / (PI * (0.5 * DIAMETER).sin().powi(2));
    let share = 0.25 * PI * ((0.5 * DIAMETER).tan() / 0.25_f64.tan()).powi(2);
    for integrator in INTEGRATORS {
        let options = settings(integrator, Mode::Scalar, Color::Rgb, 16, 2);
        let images = replicates(&scene, &options, 24);
        let all: Vec<usize> = (0..32 * 32).collect();
        for (plane, grey) in [0.5, 1.0, 2.0].into_iter().enumerate() {
            let expected = share * radiance + grey;
            let found = estimate(&images, plane, &all);
            let score = found.score(&Estimate::exact(expected), expected);
            println!("{integrator:?}: {} for {expected}, {score:?}", found.mean);
            assert!(score.is_some_and(|score| score.abs() < LIMIT), "{integrator:?}: {score:?}");
        }
    }
}

/// A picture of one color is what a constant environment is.
#[test]
fn a_picture_of_one_color_is_a_constant_environment() {
    for size in [[1, 1], [7, 2], [16, 8]] {
        let mut world = floor();
        let bytes = openexr(size, |_, _| [0.5, 0.25, 2.0]);
        world.set_environment_map(&bytes, [1.0; 3], DQuat::IDENTITY).expect("sound");
        let radiance = [0.5, 0.25, 2.0].map(|it| PI * it);
        let scene = scene::<3>(&world, Color::Rgb, SIZE);
        let [lamp] = scene.optics.lamps[scene.optics.lamps.len() - 1..] else { panic!("one") };
        for (n, lamp) in lamp.into_iter().enumerate() {
            assert!((f64::from(lamp) * PI / radiance[n] - 1.0).abs() < 1e-5, "{size:?}: {lamp}");
        }
        let sky = panorama(size, |_, _| [1.0; 3], Quat::IDENTITY);
        assert!((sky.spread() - 1.0).abs() < 1e-5 && sky.middle().length() < 1e-5);
    }
}

/// OpenEXR of Stokes vectors that are S0 of red, green and blue times the same shares.
fn polarized(s0: [f32; 3], shares: [f32; 3]) -> Vec<u8> {
    let (width, height) = (16, 8);
    let mut image = StokesImage::new(width, height, Color::Rgb, 4);
    for (plane, values) in image.planes.iter_mut().enumerate() {
        let share = [1.0, shares[0], shares[1], shares[2]][plane / 3];
        values.fill(s0[plane % 3] * share);
    }
    let path = std::env::temp_dir().join(format!("sunstone-sky-{}.exr", std::process::id()));
    image.save(&path).expect("a scratch folder");
    let bytes = std::fs::read(&path).expect("what was just written");
    std::fs::remove_file(&path).expect("what was just written");
    bytes
}

/// Compares what is seen of a sky, by a camera that looks along a direction and is rolled, with
/// shares of S0.
fn look(world: &mut World, (at, roll): (DVec3, f64), expected: [f64; 3], tolerance: f64) {
    let place = Transform::looking(DVec3::ZERO, at, DVec3::Y);
    let place = Transform(place.0 * glam::DAffine3::from_rotation_z(roll));
    world.set_camera("eye", Lens::pinhole(0.01), place).expect("sound");
    let scene = scene::<3>(world, Color::Rgb, [2, 2]);
    // So narrow a look is met by few light paths.
    for integrator in [Integrator::Path, Integrator::Bdpt, Integrator::Ppm] {
        let options = settings(integrator, Mode::Polarized, Color::Rgb, 4, 2);
        let image = &replicates(&scene, &options, 1)[0];
        for (component, expected) in (1..4).zip(expected) {
            for channel in 0..3 {
                let [s0, value] = [channel, 3 * component + channel]
                    .map(|plane| image.planes[plane].iter().map(|it| f64::from(*it)).sum::<f64>());
                let found = value / s0;
                assert!(
                    (found - expected).abs() < tolerance,
                    "{integrator:?}, {at}, S{component}: {found} for {expected}"
                );
            }
        }
    }
}

/// Seen upright, a picture has the Stokes vectors of its texels, and by a rolled camera those of
/// the rolled frame.
#[test]
fn polarized_pictures_are_seen_in_the_frame_of_the_film() {
    let mut world = World::new("sky");
    let bytes = polarized([0.5, 1.0, 2.0], [0.5, -0.3, 0.2]);
    world.set_environment_map(&bytes, [1.0; 3], DQuat::IDENTITY).expect("sound");
    for at in [DVec3::X, DVec3::new(-1.0, 0.7, 0.4), DVec3::new(0.2, -1.0, -0.9)] {
        look(&mut world, (at, 0.0), [0.5, -0.3, 0.2], 2e-3);
        let roll = 0.4_f64;
        let (sine, cosine) = (2.0 * roll).sin_cos();
        let rolled = [0.5 * cosine - 0.3 * sine, -0.3 * cosine - 0.5 * sine, 0.2];
        look(&mut world, (at, roll), rolled, 2e-3);
    }
    // Turned with the picture: a quarter turn about the line of sight exchanges the axes.
    let turned = DQuat::from_axis_angle(DVec3::X, PI / 2.0);
    world.set_environment_map(&bytes, [1.0; 3], turned).expect("sound");
    look(&mut world, (DVec3::X, 0.0), [-0.5, 0.3, 0.2], 2e-3);
}

/// Air that scatters unpolarized sunlight once sends along a unit vector e across the line of sight
/// an intensity of 1 - (e . s)^2 (Rayleigh): by that the Stokes vectors in all frames.
#[test]
fn clear_skies_are_polarized_as_single_scattering_is() {
    let sun = DVec3::new(0.3, 0.6, -0.5).normalize();
    let mut world = World::new("sky");
    world.set_clear_sky(ClearSky { sun, turbidity: 2.5, max_degree: 1.0 }, 1.0).expect("sound");
    for at in [
        DVec3::new(1.0, 0.3, 0.2),
        DVec3::new(-0.4, 0.8, 0.3),
        DVec3::new(0.1, 0.5, 1.0),
        DVec3::new(-1.0, 0.05, -0.4),
    ] {
        let at = at.normalize();
        for roll in [0.0, 0.9] {
            let right = at.cross(DVec3::Y).normalize();
            let up = right.cross(at);
            let (sine, cosine) = f64::sin_cos(roll);
            let (right, up) = (right * cosine + up * sine, up * cosine - right * sine);
            let along = |e: DVec3| 1.0 - e.normalize().dot(sun).powi(2);
            let s0 = along(right) + along(up);
            let s1 = (along(right) - along(up)) / s0;
            let s2 = (along(right + up) - along(right - up)) / s0;
            look(&mut world, (at, roll), [s1, s2, 0.0], 5e-3);
        }
    }
}
