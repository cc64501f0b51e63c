//! Nested dielectrics: what comes through glass and water that touch, overlap or are inside one
//! another, along the normal, where it follows from the indices of refraction on both sides of each
//! interface; and that none of it makes or loses light.

use std::ops::ControlFlow;

use sunstone::glam::{DVec3, Vec3};
use sunstone::hecs::Entity;
use sunstone::world::{Bsdf, Geometry, Lens, Material, Medium, Phase, Skin, Transform};
use sunstone::{Color, Integrator, Mode, Options, PlacedWorld, Renderer, Settings, World};

/// Of 20,000 normal numbers, one exceeds it with a chance of 1e-3; 60 are compared.
const LIMIT: f64 = 5.5;
const SIZE: u32 = 12;
const GLASS: f32 = 1.5;
const WATER: f32 = 1.33;
/// Absorption of ink, in 1/m.
const INK: f32 = 0.7;

/// A world with a camera that looks down the z axis, slightly off it.
struct Bench(World);

impl Bench {
    fn new() -> Self {
        let mut world = World::new("bench");
        let lens = Lens::Orthographic { half_width: 0.1, half_height: 0.1 };
        let aside = DVec3::new(0.031, 0.017, 0.0);
        let place = Transform::looking(aside + 8.0 * DVec3::Z, aside, DVec3::Y);
        world.set_camera("eye", lens, place).unwrap();
        world.set_resolution([SIZE; 2]).unwrap();
        Self(world)
    }

    fn body(&mut self, ior: f32) -> Entity {
        self.0.add_material("body", Bsdf::dielectric(ior)).unwrap()
    }

    /// A box about the z axis.
    fn slab(&mut self, ior: f32, z: [f32; 2], half: f32, priority: i32) {
        let [low, high] = [Vec3::new(-half, -half, z[0]), Vec3::new(half, half, z[1])];
        let skin = Skin::from(self.body(ior)).priority(priority);
        self.0.add_mesh("slab", Geometry::cuboid(low, high), skin, Transform::IDENTITY).unwrap();
    }

    /// A cube about the origin, full of ink or clear.
    fn cube(&mut self, ior: f32, half: f32, priority: i32, is_inky: bool) {
        let mut skin = Skin::from(self.body(ior)).priority(priority);
        if is_inky {
            let phase = Phase::HenyeyGreenstein { g: 0.0.into() };
            let ink = self.0.add_medium("ink", Medium::new(INK, 0.0, phase)).unwrap();
            skin = skin.interior(ink);
        }
        let cube = Geometry::cuboid(Vec3::splat(-half), Vec3::splat(half));
        self.0.add_mesh("cube", cube, skin, Transform::IDENTITY).unwrap();
    }

    /// A closed cube of glass with walls from `inner` to 1, of one mesh.
    fn hollow_cube(&mut self, inner: f32, priority: i32) {
        let outside = Geometry::cuboid(Vec3::splat(-1.0), Vec3::ONE);
        let inside = Geometry::cuboid(Vec3::splat(-inner), Vec3::splat(inner));
        let turned = inside.triangles.iter().map(|&[a, b, c]| [8 + a, 8 + c, 8 + b]);
        let triangles = outside.triangles.iter().copied().chain(turned).collect();
        let shell = Geometry::new([outside.positions, inside.positions].concat(), triangles);
        let skin = Skin::from(self.body(GLASS)).priority(priority);
        self.0.add_mesh("shell", shell, skin, Transform::IDENTITY).unwrap();
    }

    fn ball(&mut self, ior: f32, center: DVec3, radius: f64) {
        let skin = Skin::from(self.body(ior));
        self.0.add_sphere("ball", radius, skin, center).unwrap();
    }

    /// Lit from the other end of the z axis alone.
    fn wall(&mut self) {
        let dark = self.0.add_material("wall", Material::emitter(1.0)).unwrap();
        let quad = Geometry::quad(Vec3::NEG_Z * 4.0, Vec3::X * 2.0, Vec3::Y * 2.0);
        self.0.add_mesh("wall", quad, dark, Transform::IDENTITY).unwrap();
    }

    /// The mean of the pixels, and its standard error as they differ.
    fn mean(self, integrator: Integrator, mode: Mode) -> (f64, f64) {
        let options = Options {
            integrator: Some(integrator),
            mode,
            color: Color::Mono { wavelength_nm: 550.0 },
            samples: 256,
            ..Options::default()
        };
        let placed = PlacedWorld::new(self.0).unwrap();
        let mut renderer = Renderer::new(&placed, &Settings::new(options).unwrap()).unwrap();
        renderer.run(|_| ControlFlow::Continue(()));
        let values: Vec<f64> =
            renderer.finish().planes[0].iter().map(|&value| f64::from(value)).collect();
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
        (mean, (squares / (count - 1.0) / count).sqrt())
    }
}

/// What comes through interfaces between these indices of refraction along their normals, with all
/// reflections between them.
fn through(indices: &[f32]) -> f64 {
    let lost = indices.windows(2).map(|pair| {
        let [a, b] = [pair[0], pair[1]].map(f64::from);
        let reflectance = ((a - b) / (a + b)).powi(2);
        reflectance / (1.0 - reflectance)
    });
    1.0 / (1.0 + lost.sum::<f64>())
}

/// What comes through layers of these indices of refraction and thicknesses of ink, between clear
/// air, along their normals.
fn through_ink(layers: &[(f32, f32)]) -> f64 {
    let (mut passed, mut reflected_back, mut before) = (1.0, 0.0, 1.0_f64);
    for (index, ink) in layers.iter().copied().chain([(1.0, 0.0)]) {
        let index = f64::from(index);
        let reflectance = ((before - index) / (before + index)).powi(2);
        let between = 1.0 - reflected_back * reflectance;
        let depth = (-f64::from(INK * ink)).exp();
        passed *= (1.0 - reflectance) / between * depth;
        let back = reflectance + (1.0 - reflectance).powi(2) * reflected_back / between;
        (reflected_back, before) = (back * depth * depth, index);
    }
    passed
}

#[track_caller]
fn check_through_ink(build: impl Fn(&mut Bench), layers: &[(f32, f32)]) {
    let lit = |bench: &mut Bench| {
        build(bench);
        bench.wall();
    };
    check(lit, through_ink(layers), &[Integrator::Path]);
}

#[track_caller]
fn check(build: impl Fn(&mut Bench), expected: f64, integrators: &[Integrator]) {
    for &integrator in integrators {
        for mode in [Mode::Scalar, Mode::Polarized] {
            let mut bench = Bench::new();
            build(&mut bench);
            let (mean, error) = bench.mean(integrator, mode);
            // Strata leave less noise than pixels show; single precision leaves the rest.
            let off = (mean - expected).abs() - 2e-5;
            assert!(off < LIMIT * error, "{integrator:?} {mode:?}: {mean} +- {error}, {expected}");
        }
    }
}

#[track_caller]
fn check_through(build: impl Fn(&mut Bench), indices: &[f32]) {
    let lit = |bench: &mut Bench| {
        build(bench);
        bench.wall();
    };
    check(lit, through(indices), &[Integrator::Path, Integrator::Bdpt]);
}

#[test]
fn faces_in_one_place_are_one_interface() {
    let layers = [(GLASS, [0.0, 1.0]), (WATER, [1.0, 2.0]), (GLASS, [2.0, 3.0])];
    for order in [[0, 1, 2], [2, 1, 0], [1, 0, 2]] {
        for gap in [0.0, 1e-7] {
            let build = |bench: &mut Bench| {
                for which in order {
                    let (ior, [low, high]) = layers[which];
                    bench.slab(ior, [low + gap, high - gap], 1.0, 0);
                }
            };
            check_through(build, &[1.0, GLASS, WATER, GLASS, 1.0]);
        }
    }
    let optical_contact = |bench: &mut Bench| {
        bench.slab(GLASS, [0.0, 1.0], 1.0, 0);
        bench.slab(GLASS, [1.0, 2.0], 0.5, 0);
    };
    check_through(optical_contact, &[1.0, GLASS, 1.0]);
    let apart = |bench: &mut Bench| {
        bench.slab(GLASS, [0.0, 1.0], 1.0, 0);
        bench.slab(GLASS, [1.0001, 2.0], 1.0, 0);
    };
    check_through(apart, &[1.0, GLASS, 1.0, GLASS, 1.0]);
}

#[test]
fn of_overlapping_bodies_the_higher_priority_counts_then_the_smaller() {
    let lens = |priority: i32| {
        move |bench: &mut Bench| {
            bench.slab(GLASS, [0.0, 1.0], 1.0, 0);
            bench.slab(WATER, [0.8, 2.2], 1.2, priority);
            bench.slab(GLASS, [2.0, 3.0], 1.0, 0);
        }
    };
    check_through(lens(1), &[1.0, GLASS, WATER, GLASS, 1.0]);
    check_through(lens(-1), &[1.0, GLASS, WATER, GLASS, 1.0]);
    let inside = |priority: i32| {
        move |bench: &mut Bench| {
            bench.slab(WATER, [-1.0, 3.0], 1.5, priority);
            bench.slab(2.4, [0.0, 1.0], 0.5, 0);
        }
    };
    check_through(inside(0), &[1.0, WATER, 2.4, WATER, 1.0]);
    check_through(inside(1), &[1.0, WATER, 1.0]);
    let twice = |bench: &mut Bench| {
        bench.slab(GLASS, [0.0, 1.0], 1.0, 0);
        bench.slab(GLASS, [0.0, 1.0], 1.0, 0);
    };
    check_through(twice, &[1.0, GLASS, 1.0]);
}

/// Whose priority is the highest is all there is where it is, ink and index, also where others are
/// wholly inside of it; else what is inside is.
#[test]
fn priority_is_of_what_fills_bodies_too() {
    let water = |priority: i32| {
        move |bench: &mut Bench| {
            bench.cube(WATER, 0.85, priority, true);
            bench.cube(1.0, 0.8, 0, false);
        }
    };
    check_through_ink(water(1), &[(WATER, 1.7)]);
    let wall = (WATER, 0.05);
    check_through_ink(water(0), &[wall, (1.0, 0.0), wall]);
    check_through_ink(water(-1), &[wall, (1.0, 0.0), wall]);
    let clear_water = |bench: &mut Bench| {
        bench.cube(WATER, 0.8, 1, false);
        bench.cube(2.0, 0.4, 0, true);
    };
    check_through_ink(clear_water, &[(WATER, 0.0)]);
    // Ice in that water, in the air in a glass, which ends where the water does or before that.
    for half in [0.8, 0.85] {
        let drink = |bench: &mut Bench| {
            bench.cube(GLASS, 1.0, 0, false);
            bench.cube(1.0, 0.8, 0, false);
            bench.cube(WATER, half, 1, true);
            bench.cube(2.0, 0.3, 2, false);
        };
        let (glass, water) = ((GLASS, 0.0), (WATER, half - 0.3));
        check_through_ink(drink, &[glass, water, (2.0, 0.0), water, glass]);
    }
}

/// A hollow body has two outsides, and what is in its cavity is not what is around it.
#[test]
fn what_is_in_a_cavity_is_not_what_is_around_it() {
    let (glass, ice) = ((GLASS, 0.0), (2.0, 0.0));
    // Water that reaches into the wall, up to it, by less than rays see, and not so far.
    let orders = [[0, 1, 2], [2, 1, 0], [1, 2, 0]];
    for (half, orders) in
        [(0.85, &orders[..1]), (0.801, &orders[1..2]), (0.800_002, &orders), (0.8, &orders[2..])]
    {
        for order in orders {
            let drink = |bench: &mut Bench| {
                for which in *order {
                    match which {
                        0 => bench.hollow_cube(0.8, 0),
                        1 => bench.cube(WATER, half, 0, true),
                        _ => bench.cube(2.0, 0.3, 0, false),
                    }
                }
            };
            let water = (WATER, half - 0.3);
            check_through_ink(drink, &[glass, water, ice, water, glass]);
        }
    }
    let strong_glass = |bench: &mut Bench| {
        bench.hollow_cube(0.8, 1);
        bench.cube(WATER, 0.85, 0, true);
        bench.cube(2.0, 0.3, 2, false);
    };
    let water = (WATER, 0.5);
    check_through_ink(strong_glass, &[glass, water, ice, water, glass]);
    let bubble = |bench: &mut Bench| {
        bench.hollow_cube(0.8, 0);
        bench.cube(WATER, 0.7, 0, true);
        bench.cube(2.0, 0.3, 0, false);
    };
    let (air, water) = ((1.0, 0.0), (WATER, 0.4));
    check_through_ink(bubble, &[glass, air, water, ice, water, air, glass]);
}

#[test]
fn air_in_glass_refracts() {
    let drilled = |bench: &mut Bench| {
        bench.slab(GLASS, [-1.0, 1.0], 1.0, 0);
        bench.slab(1.0, [0.0, 0.5], 0.3, 0);
    };
    check_through(drilled, &[1.0, GLASS, 1.0, GLASS, 1.0]);
    let flush = |bench: &mut Bench| {
        bench.slab(GLASS, [-1.0, 1.0], 1.0, 0);
        bench.slab(1.0, [0.0, 1.0], 0.3, 0);
    };
    check_through(flush, &[1.0, GLASS, 1.0]);
}

/// In light from everywhere nothing is seen of what absorbs nothing.
#[test]
fn no_light_is_made_or_lost() {
    let surrounded = |build: fn(&mut Bench)| {
        move |bench: &mut Bench| {
            build(bench);
            bench.0.set_environment(1.0).unwrap();
        }
    };
    let clusters: [fn(&mut Bench); 6] = [
        |bench| {
            bench.ball(GLASS, DVec3::X * -0.5, 1.0);
            bench.ball(WATER, DVec3::X * 0.5, 1.0);
        },
        |bench| {
            bench.slab(WATER, [-1.0, 1.0], 1.0, 0);
            bench.ball(GLASS, DVec3::ZERO, 0.7);
            bench.ball(2.4, DVec3::X * 0.3, 0.3);
            bench.ball(1.8, DVec3::Z, 0.4);
        },
        |bench| {
            for index in 0..9_i32 {
                let at = f64::from(index);
                let center = DVec3::new(0.1 * at - 0.4, 0.2 * (3.0 * at).sin(), 0.1 * at);
                bench.ball(1.2 + 0.1 * (index % 5) as f32, center, 0.4);
            }
        },
        |bench| {
            bench.slab(GLASS, [-1.5, -0.5], 1.0, 0);
            bench.slab(WATER, [-0.5, 0.5], 1.0, 0);
            bench.slab(GLASS, [0.5, 1.5], 1.0, 0);
        },
        // Air that is drilled into glass, and a bubble that breaks through its surface.
        |bench| {
            bench.slab(GLASS, [-1.0, 1.0], 1.0, 0);
            bench.slab(1.0, [-0.5, 1.5], 0.3, 1);
        },
        |bench| {
            bench.ball(GLASS, DVec3::ZERO, 0.6);
            bench.ball(1.0, DVec3::Z * 0.7, 0.3);
        },
    ];
    for build in clusters {
        check(surrounded(build), 1.0, &[Integrator::Path]);
    }
}

/// Rays start off surfaces by about as much, more off larger ones, and so beyond faces at times.
#[test]
fn gaps_that_rays_jump_over_make_no_light() {
    for gap in [2e-7, 6e-7, 8e-7, 1e-6, 1.2e-6, 1.5e-6] {
        let small_on_large = |bench: &mut Bench| {
            bench.slab(GLASS, [0.0, 1.0], 1.5, 0);
            bench.slab(WATER, [1.0 + gap, 2.0], 0.3, 0);
        };
        let flush = |bench: &mut Bench| {
            bench.slab(GLASS, [0.0, 1.0], 1.0, 0);
            bench.slab(2.4, [0.5, 1.0 - gap], 0.4, 0);
        };
        for build in [&small_on_large as &dyn Fn(&mut Bench), &flush] {
            let surrounded = |bench: &mut Bench| {
                build(bench);
                bench.0.set_environment(1.0).unwrap();
                let lens = Lens::Orthographic { half_width: 0.3, half_height: 0.3 };
                let place = Transform::looking(DVec3::new(0.1, 2.2, 8.0), DVec3::Z, DVec3::Y);
                bench.0.set_camera("aslant", lens, place).unwrap();
                bench.0.set_resolution([SIZE; 2]).unwrap();
            };
            check(surrounded, 1.0, &[Integrator::Path]);
        }
    }
}

#[test]
fn bodies_in_open_water_are_warned_of() {
    let warnings = |height: f64, is_closed: bool| {
        let mut bench = Bench::new();
        bench.ball(GLASS, DVec3::Z * height, 0.2);
        if is_closed {
            bench.slab(WATER, [-1.0, 0.0], 1.0, 0);
        } else {
            let surface = Geometry::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
            let water = bench.body(WATER);
            bench.0.add_mesh("surface", surface, water, Transform::IDENTITY).unwrap();
        }
        let placed = PlacedWorld::new(bench.0).unwrap();
        placed.warnings().map(str::to_owned).collect::<Vec<_>>()
    };
    for height in [-0.5, 0.1] {
        let found = warnings(height, false);
        let [one] = &found[..] else { panic!("{height}: {found:?}") };
        assert!(one.contains("ball") && one.contains("surface") && one.contains("closed"), "{one}");
        assert!(warnings(height, true).is_empty());
    }
    assert!(warnings(0.5, false).is_empty());
}

#[test]
fn an_opaque_body_has_no_priority() {
    let mut world = World::new("opaque");
    let paint = world.add_material("paint", Bsdf::diffuse(0.5)).unwrap();
    let skin = Skin::from(paint).priority(1);
    let error = world.add_sphere("ball", 1.0, skin, DVec3::ZERO).unwrap_err().to_string();
    assert!(error.contains("priority") && error.contains("opaque"), "{error}");
}
