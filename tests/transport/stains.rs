//! Colors of glass and metal, and panes with holes, against sums of Fresnel's shares, and against
//! images of which they are mixtures.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};
use sunstone::Distribution;
use sunstone::internals::image::StokesImage;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::Mode;
use sunstone::internals::scattering::Scene;
use sunstone::internals::scene::World;
use sunstone::internals::spectrum::Color;
use sunstone::world::{
    Bsdf, Coverage, Filter, Geometry, Lens, Material, Paint, Reads, Stain, Textures, Transform,
};

use crate::support::painted::{noise, paint, quad, texture};
use crate::support::rendering::{image, replicates, scene, settings};
use crate::support::statistics::Estimate;

const ALL: [Integrator; 4] =
    [Integrator::Path, Integrator::Light, Integrator::Bdpt, Integrator::Ppm];
const REFLECTED: [f32; 3] = [0.2, 0.9, 0.5];
const TRANSMITTED: [f32; 3] = [0.9, 0.6, 0.1];

fn even(factor: [f32; 3]) -> Option<Paint> {
    Some(Paint { factor, texture: None, reads: Reads::Color, by_vertices: false })
}

fn stained(reflected: [f32; 3], transmitted: [f32; 3]) -> Textures {
    let stain = Stain { reflected: even(reflected), transmitted: even(transmitted) };
    Textures { stain, ..Textures::default() }
}

/// A shape of a material, seen along the z axis.
fn looked_at(bsdf: Bsdf, textures: Textures, shape: Geometry, place: Transform) -> World {
    let mut world = World::new("stained");
    let material = world.add_material("stained", Material::from(bsdf).two_sided()).unwrap();
    world.set_textures(material, textures).unwrap();
    world.add_mesh("shape", shape, material, place).unwrap();
    let eye = Transform::looking(DVec3::Z * 3.0, DVec3::ZERO, DVec3::Y);
    let lens = Lens::Orthographic { half_width: 0.2, half_height: 0.2 };
    world.set_camera("eye", lens, eye).unwrap();
    world
}

/// The image's mean of a channel of a component against what it should be, in standard errors.
fn scores(world: &World, integrator: Integrator, expected: &[[f64; 3]]) -> Vec<(f64, f64)> {
    let mode = if expected.len() == 1 { Mode::Scalar } else { Mode::Polarized };
    let scene: Arc<Scene<3>> = scene(world, Color::Rgb, [4, 4]);
    let images = replicates(&scene, &settings(integrator, mode, Color::Rgb, 64, 40), 16);
    let score = |plane: usize, expected: f64| {
        let mean = |image: &StokesImage| f64::from(image.planes[plane].iter().sum::<f32>()) / 16.0;
        let found = Estimate::of(&images.iter().map(mean).collect::<Vec<_>>());
        let score = found.score(&Estimate::exact(expected), 1.0);
        // Where there is no noise, rounding is left.
        (score.unwrap_or((found.mean - expected) * 2e5), found.mean)
    };
    let planes = expected.as_flattened().iter().enumerate();
    planes.map(|(plane, expected)| score(plane, *expected)).collect()
}

/// Of 24 numbers one is off by 4.5 standard errors of 16 images in 1 of 1,000 cases.
fn check(world: &World, expected: &[[f64; 3]], label: &str) {
    // From the sky no light path comes into a camera without extent in directions.
    for integrator in ALL.into_iter().filter(|it| *it != Integrator::Light) {
        for (place, (score, mean)) in scores(world, integrator, expected).into_iter().enumerate() {
            assert!(score.abs() < 4.5, "{label} {integrator:?} {place}: {mean}, {expected:?}");
        }
    }
}

/// At normal incidence, under a sky of 1.
#[test]
fn panes_and_slabs_leave_the_shares_of_their_stains() {
    let face: f64 = (0.5_f64 / 2.5).powi(2);
    let of = |n: usize| [f64::from(REFLECTED[n]), f64::from(TRANSMITTED[n])];
    let textures = stained(REFLECTED, TRANSMITTED);
    let shape = quad(Vec3::ZERO, Vec3::X, Vec3::Y);
    let pane = |n: usize| {
        let [reflected, transmitted] = of(n);
        let all = 2.0 * face / (1.0 + face);
        all * reflected + (1.0 - all) * transmitted
    };
    let thin = Bsdf::thin_dielectric(1.5);
    let mut world = looked_at(thin, textures.clone(), shape, Transform::IDENTITY);
    world.set_environment(1.0).unwrap();
    check(&world, &[[0, 1, 2].map(pane)], "pane");
    let slab = |n: usize| {
        let [reflected, transmitted] = of(n);
        let (back, through) = (face * reflected, (1.0 - face) * transmitted);
        back + through * through / (1.0 - back)
    };
    let shape = || Geometry::cuboid(Vec3::new(-1.0, -1.0, -0.1), Vec3::new(1.0, 1.0, 0.1));
    let alpha = Distribution::default();
    let smooth = Bsdf::RoughDielectric {
        ior: 1.5.into(),
        exterior_ior: 1.0.into(),
        alpha: 0.0,
        distribution: alpha,
        multiple_scattering: false,
    };
    for glass in [Bsdf::dielectric(1.5), smooth] {
        let mut world = looked_at(glass, textures.clone(), shape(), Transform::IDENTITY);
        world.set_environment(1.0).unwrap();
        check(&world, &[[0, 1, 2].map(slab)], "slab");
    }
    let mirror = Bsdf::metal("Al").unwrap();
    let bright = |textures: Textures| {
        let shape = quad(Vec3::ZERO, Vec3::X, Vec3::Y);
        let mut world = looked_at(mirror.clone(), textures, shape, Transform::IDENTITY);
        world.set_environment(1.0).unwrap();
        let scene: Arc<Scene<3>> = scene(&world, Color::Rgb, [2, 2]);
        image(&scene, &settings(Integrator::Path, Mode::Scalar, Color::Rgb, 4, 2))
    };
    let stain = Stain { reflected: even(REFLECTED), transmitted: None };
    let [plain, colored] =
        [Textures::default(), Textures { stain, ..Textures::default() }].map(bright);
    for (n, share) in REFLECTED.into_iter().enumerate() {
        let [all, left] = [&plain, &colored].map(|image| image.planes[n][0]);
        assert!((left - share * all).abs() < 1e-6 && all > 0.5, "{n}: {left}, {all}");
    }
}

/// A pane by a share before a lamp: of polarized light, too. The axis of the film is s.
#[test]
fn panes_by_a_share_let_the_rest_through_as_it_is() {
    let tilt = 1.5_f64.atan();
    let place = Transform(DAffine3::from_rotation_x(tilt));
    for share in [0.3_f32, 0.8] {
        let paint = even([share; 3]).unwrap();
        let coverage = Some(Coverage { paint, cutoff: None });
        let textures = Textures { coverage, ..stained(REFLECTED, TRANSMITTED) };
        let shape = quad(Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 2.0);
        let mut world = looked_at(Bsdf::thin_dielectric(1.5), textures, shape, place);
        let lamp = world.add_material("lamp", Material::emitter(1.0)).unwrap();
        let behind = Geometry::quad(Vec3::Z * -4.0, Vec3::X * 2.0, Vec3::Y * 2.0);
        world.add_mesh("lamp", behind, lamp, Transform::IDENTITY).unwrap();
        // At Brewster's angle nothing of p is reflected, and of s by each face so much:
        let face = ((1.5_f64.powi(2) - 1.0) / (1.5_f64.powi(2) + 1.0)).powi(2);
        let through = (1.0 - face) / (1.0 + face);
        let share = f64::from(share);
        let s0 = |n: usize| 1.0 - share + share * f64::from(TRANSMITTED[n]) * 0.5 * (1.0 + through);
        let s1 = |n: usize| share * f64::from(TRANSMITTED[n]) * 0.5 * (through - 1.0);
        let expected = [[0, 1, 2].map(s0), [0, 1, 2].map(s1), [0.0; 3], [0.0; 3]];
        check(&world, &expected, "by a share");
    }
}

/// Of one event, images are sums of what is reflected and what goes through, path by path.
#[test]
fn rough_glass_and_metal_are_sums_of_their_ways() {
    let facets = |ior: f32| Bsdf::RoughDielectric {
        ior: ior.into(),
        exterior_ior: 1.0.into(),
        alpha: 0.3,
        distribution: Distribution::Ggx,
        multiple_scattering: true,
    };
    let brushed =
        Bsdf::brushed(facets(1.5), sunstone::world::Grain::new(sunstone::world::Along::Alpha(0.1)));
    let metal = Bsdf::rough_metal("Cu", 0.3).unwrap();
    for (bsdf, is_glass) in [(facets(1.5), true), (brushed, true), (metal, false)] {
        for integrator in [Integrator::Path, Integrator::Bdpt] {
            let of = |textures: Textures| {
                let shape = quad(Vec3::ZERO, Vec3::X, Vec3::Y);
                let mut world = looked_at(bsdf.clone(), textures, shape, Transform::IDENTITY);
                world.set_environment([0.5, 1.0, 2.0]).unwrap();
                let scene: Arc<Scene<3>> = scene(&world, Color::Rgb, [4, 4]);
                let mut options = settings(integrator, Mode::Polarized, Color::Rgb, 8, 2);
                options.path_length_max = 2;
                image(&scene, &options).planes
            };
            let ways = |reflected, transmitted| match is_glass {
                true => stained(reflected, transmitted),
                false => Textures {
                    stain: Stain { reflected: even(reflected), transmitted: None },
                    ..Textures::default()
                },
            };
            let (none, all) = ([0.0; 3], [1.0; 3]);
            let [mixed, back, through] =
                [of(ways(REFLECTED, TRANSMITTED)), of(ways(all, none)), of(ways(none, all))];
            assert!(back[0].iter().sum::<f32>() > 0.01);
            for plane in 0..mixed.len() {
                for (pixel, mixed) in mixed[plane].iter().enumerate() {
                    let n = plane % 3;
                    let sum =
                        REFLECTED[n] * back[plane][pixel] + TRANSMITTED[n] * through[plane][pixel];
                    assert!((mixed - sum).abs() < 2e-5, "{integrator:?} {plane}: {mixed}, {sum}");
                }
            }
        }
    }
}

/// A picture before a lamp, seen through a pane without a boundary to speak of.
#[test]
fn stains_are_where_their_pictures_are() {
    let way = texture(noise(41, 4), Filter::Nearest);
    let transmitted = Some(paint([1.0; 3], way.clone()));
    let textures =
        Textures { stain: Stain { reflected: None, transmitted }, ..Textures::default() };
    for bsdf in [Bsdf::thin_dielectric(1.001), Bsdf::dielectric(1.001)] {
        let shape = quad(Vec3::ZERO, Vec3::X * 0.2, Vec3::Y * 0.2);
        let mut world = looked_at(bsdf, textures.clone(), shape, Transform::IDENTITY);
        let lamp = world.add_material("lamp", Material::emitter(1.0)).unwrap();
        let behind = Geometry::quad(Vec3::Z * -4.0, Vec3::X, Vec3::Y);
        world.add_mesh("lamp", behind, lamp, Transform::IDENTITY).unwrap();
        let scene: Arc<Scene<3>> = scene(&world, Color::Rgb, [4, 4]);
        let seen = image(&scene, &settings(Integrator::Path, Mode::Scalar, Color::Rgb, 16, 4));
        for pixel in 0..16 {
            let at = [pixel % 4, pixel / 4].map(|it| (it as f32 + 0.5) / 4.0);
            let texel = way.at(at.into());
            for (n, plane) in seen.planes.iter().enumerate().take(3) {
                // Radiance in glass is that times the square of its index.
                let error = (plane[pixel] - texel[n]).abs();
                assert!(error < 3e-3, "{pixel}: {}, not {texel:?}", plane[pixel]);
            }
        }
    }
}

#[test]
fn stains_are_refused_where_they_mean_nothing() {
    let mut world = World::new("refused");
    let mut set = |bsdf: Bsdf, textures: Textures| {
        let material = world.add_material("", bsdf).unwrap();
        world.set_textures(material, textures).map_err(|error| error.to_string())
    };
    let plain = || stained(REFLECTED, TRANSMITTED);
    for bsdf in [
        Bsdf::diffuse(0.5),
        Bsdf::metal("Al").unwrap(),
        Bsdf::thin_dielectric(1.0),
        Bsdf::polarizer(0.0),
    ] {
        let error = set(bsdf, plain()).unwrap_err();
        assert!(error.contains("is of glass that refracts"), "{error}");
    }
    let bright =
        Textures { stain: Stain { reflected: even([1.5; 3]), transmitted: None }, ..plain() };
    assert!(set(Bsdf::dielectric(1.5), bright).unwrap_err().contains("must be within [0, 1]"));
    let coverage = Some(Coverage { paint: even([0.5; 3]).unwrap(), cutoff: None });
    let holes = || Textures { coverage: coverage.clone(), ..Textures::default() };
    for bsdf in [Bsdf::dielectric(1.5), Bsdf::polarizer(0.0), Bsdf::thin_dielectric(1.0)] {
        assert!(set(bsdf, holes()).unwrap_err().contains("have no holes"));
    }
    set(Bsdf::thin_dielectric(1.5), holes()).expect("panes may have holes");
}
