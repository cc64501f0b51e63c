//! What boundaries do not say, and what they say against each other. The media absorb and do not
//! scatter, and connections through them take the light's transmittance, so that what comes
//! through is known to the last digits of the numbers.

use std::f32::consts::PI;
use std::ops::ControlFlow;

use sunstone::glam::{DAffine3, DVec3, Vec3};
use sunstone::hecs::Entity;
use sunstone::world::{
    Bsdf, Filling, Geometry, Lens, Material, Medium, Phase, Punctual, PunctualKind, Skin, Transform,
};
use sunstone::{Color, Integrator, Mode, Options, PlacedWorld, Renderer, Settings, World};

/// A world of nulls and media, in light along z.
struct Bench {
    world: World,
    null: Entity,
}

impl Bench {
    fn new() -> Self {
        let mut world = World::new("bench");
        let null = world.add_material("null", Bsdf::Null).unwrap();
        Self { world, null }
    }

    fn medium(&mut self, name: &str, sigma_a: f32) -> Entity {
        let phase = Phase::HenyeyGreenstein { g: 0.0.into() };
        self.world.add_medium(name, Medium::new(sigma_a, 0.0, phase)).unwrap()
    }

    /// A box about the z axis, whose exterior is not stated.
    fn slab(&mut self, name: &str, filling: impl Into<Filling>, z: [f32; 2], half: f32) {
        let [low, high] = [Vec3::new(-half, -half, z[0]), Vec3::new(half, half, z[1])];
        let skin = Skin::from(self.null).interior(filling);
        self.world.add_mesh(name, Geometry::cuboid(low, high), skin, Transform::IDENTITY).unwrap();
    }

    /// What comes through along z at `x` to a white screen at 5 times `side`, and what is said.
    fn shone_through(mut self, x: f64, side: f64) -> (f32, Vec<String>) {
        let white = self.world.add_material("white", Bsdf::diffuse(1.0)).unwrap();
        let screen = Geometry::quad(Vec3::ZERO, Vec3::X * 0.5, Vec3::Y * 0.5);
        let (at, aside) = (DVec3::new(x, 0.0, 5.0 * side), DVec3::new(x, 0.0, 4.0 * side));
        let facing = Transform::looking(aside, at, DVec3::Y);
        let on_screen = Transform::from(DAffine3 { translation: at, ..facing.0 });
        self.world.add_mesh("screen", screen, white, on_screen).unwrap();
        let sun = Punctual { kind: PunctualKind::Directional, intensity: PI.into() };
        let from_beyond = Transform::looking(DVec3::X * x, at, DVec3::Y);
        self.world.add_light("sun", sun, from_beyond).unwrap();
        let place = Transform::looking(aside, at, DVec3::Y);
        let (values, warnings) = seen_from(self.world, place);
        let spread = values.iter().fold(0.0, |spread: f32, v| spread.max((v - values[0]).abs()));
        assert!(spread < 1e-3, "nothing is random here: {values:?}");
        (values[0], warnings)
    }
}

/// What a narrow camera sees from its place, and what is said.
fn seen_from(mut world: World, place: Transform) -> (Vec<f32>, Vec<String>) {
    let lens = Lens::Orthographic { half_width: 0.01, half_height: 0.01 };
    world.set_camera("eye", lens, place).unwrap();
    world.set_resolution([2, 2]).unwrap();
    let options = Options {
        integrator: Some(Integrator::Path),
        mode: Mode::Scalar,
        color: Color::Mono { wavelength_nm: 550.0 },
        samples: 4,
        ..Options::default()
    };
    let placed = PlacedWorld::new(world).unwrap();
    let mut renderer = Renderer::new(&placed, &Settings::new(options).unwrap()).unwrap();
    renderer.run(|_| ControlFlow::Continue(()));
    (renderer.finish().planes[0].clone(), placed.warnings().map(str::to_owned).collect())
}

/// From both ends, the depth along z at `x` is the same; what is said.
#[track_caller]
fn check(build: impl Fn(&mut Bench), x: f64, depth: f32) -> Vec<String> {
    let [(front, warnings), (back, _)] = [1.0, -1.0].map(|side| {
        let mut bench = Bench::new();
        build(&mut bench);
        bench.shone_through(x, side)
    });
    for seen in [front, back] {
        assert!((seen.ln() + depth).abs() < 1e-3, "{} for {depth}", -seen.ln());
    }
    warnings
}

#[test]
fn what_is_not_stated_is_what_surrounds() {
    // A ball of another medium, and a hole, in a box of fog; one of them deep within.
    let build = |bench: &mut Bench| {
        let [fog, smoke] = [("fog", 0.5), ("smoke", 2.0)].map(|(name, a)| bench.medium(name, a));
        let (smoke_skin, hole) = (
            Skin::from(bench.null).interior(smoke),
            Skin::from(bench.null).interior(Filling::Clear),
        );
        bench.world.add_sphere("ball", 0.5, smoke_skin, DVec3::ZERO).unwrap();
        bench.world.add_sphere("hole", 0.25, hole, DVec3::ZERO).unwrap();
        bench.slab("fog", fog, [-1.0, 2.0], 3.0);
    };
    assert!(check(build, 0.0, 0.5 * 2.0 + 2.0 * 0.5).is_empty());
    assert!(check(build, 1.0, 0.5 * 3.0).is_empty());
    // What is only stated before a surface: what is behind it is the rest.
    let bubble = |bench: &mut Bench| {
        let fog = bench.medium("fog", 0.5);
        let skin = Skin::from(bench.null).exterior(fog);
        bench.world.add_sphere("bubble", 1.0, skin, DVec3::ZERO).unwrap();
        bench.slab("fog", fog, [-2.0, 2.0], 3.0);
    };
    assert!(check(bubble, 0.0, 0.5 * 2.0).is_empty());
}

/// What a lamp of radiance 1 is seen at, at an end of a closed dark room, 2 m off.
fn seen_in_a_room(furnish: impl Fn(&mut Bench)) -> f32 {
    let mut bench = Bench::new();
    let world = &mut bench.world;
    let dark = world.add_material("dark", Material::from(Bsdf::Absorber).two_sided()).unwrap();
    let lamp = world.add_material("lamp", Material::emitter(1.0)).unwrap();
    let walls = Geometry::cuboid(Vec3::splat(-2.0), Vec3::splat(2.0));
    world.add_mesh("walls", walls, dark, Transform::IDENTITY).unwrap();
    let panel = Geometry::quad(Vec3::NEG_Z, Vec3::X, Vec3::Y);
    world.add_mesh("panel", panel, lamp, Transform::IDENTITY).unwrap();
    furnish(&mut bench);
    let (values, warnings) =
        seen_from(bench.world, Transform::looking(DVec3::Z, DVec3::NEG_Z, DVec3::Y));
    assert_eq!(warnings, [""; 0]);
    values[0]
}

/// Whose boundary is within the walls, in them, and where they hide it.
#[test]
fn fog_fills_rooms_whose_walls_hide_its_boundary() {
    for half in [1.9, 2.0, 2.002, 2.2, 40.0] {
        let fill = |bench: &mut Bench| {
            let fog = bench.medium("fog", 0.5);
            bench.slab("fog", fog, [-half, half], half);
        };
        let seen = seen_in_a_room(fill);
        assert!((seen.ln() + 0.5 * 2.0).abs() < 1e-3, "a box of {half}: {}", -seen.ln());
        let with_a_hole = |bench: &mut Bench| {
            fill(bench);
            let hole = Skin::from(bench.null).interior(Filling::Clear);
            bench.world.add_sphere("hole", 0.25, hole, DVec3::ZERO).unwrap();
        };
        let seen = seen_in_a_room(with_a_hole);
        assert!((seen.ln() + 0.5 * 1.5).abs() < 1e-3, "a hole, {half}: {}", -seen.ln());
    }
    // What is beyond the walls, and does not enclose them, is not in them.
    let beside = |bench: &mut Bench| {
        let fog = bench.medium("fog", 0.5);
        bench.slab("fog", fog, [2.5, 6.0], 40.0);
    };
    assert_eq!(seen_in_a_room(beside), 1.0);
}

#[test]
fn where_media_overlap_the_smaller_one_is() {
    for order in [[0, 1], [1, 0]] {
        let build = |bench: &mut Bench| {
            let [a, b] = [("a", 0.5), ("b", 2.0)].map(|(name, sigma)| bench.medium(name, sigma));
            for which in order {
                match which {
                    0 => bench.slab("large", a, [-2.0, 1.0], 2.0),
                    _ => bench.slab("small", b, [0.5, 1.5], 1.0),
                }
            }
        };
        let warnings = check(build, 0.1, 0.5 * 2.5 + 2.0 * 1.0);
        let [warning] = &warnings[..] else { panic!("{warnings:?}") };
        assert!(warning.contains("`large`") && warning.contains("`small`"), "{warning}");
        assert!(warning.contains("overlaps") && warning.contains("smaller"), "{warning}");
        assert_eq!(check(build, 1.5, 0.5 * 3.0).len(), 1);
    }
    // The same medium in both is there once.
    let build = |bench: &mut Bench| {
        let fog = bench.medium("fog", 0.5);
        bench.slab("large", fog, [-2.0, 1.0], 2.0);
        bench.slab("small", fog, [0.5, 1.5], 1.0);
    };
    check(build, 0.1, 0.5 * 3.5);
}

/// A cube about the origin, hollow from `inner` on if that is not zero.
fn cube(half: f32, inner: f32) -> Geometry {
    let outside = Geometry::cuboid(Vec3::splat(-half), Vec3::splat(half));
    if inner == 0.0 {
        return outside;
    }
    let inside = Geometry::cuboid(Vec3::splat(-inner), Vec3::splat(inner));
    let turned = inside.triangles.iter().map(|&[a, b, c]| [8 + a, 8 + c, 8 + b]);
    let triangles = outside.triangles.iter().copied().chain(turned).collect();
    Geometry::new([outside.positions, inside.positions].concat(), triangles)
}

/// Cubes about the origin: half an edge, where they are hollow, coefficient and priority of each.
#[track_caller]
fn check_cubes(cubes: &[(f32, f32, f32, i32)], depth: f32) {
    let build = |is_turned: bool| {
        move |bench: &mut Bench| {
            let mut cubes = cubes.to_vec();
            if is_turned {
                cubes.reverse();
            }
            for (half, inner, sigma, priority) in cubes {
                let medium = bench.medium("medium", sigma);
                let skin = Skin::from(bench.null).interior(medium).priority(priority);
                let place = Transform::IDENTITY;
                bench.world.add_mesh("cube", cube(half, inner), skin, place).unwrap();
            }
        }
    };
    check(build(false), 0.11, depth);
    check(build(true), 0.11, depth);
}

#[test]
fn the_highest_priority_counts_for_what_is_inside_too() {
    let (ink, fog) = (0.7, 0.1);
    check_cubes(&[(0.85, 0.0, ink, 1), (0.8, 0.0, fog, 0)], 1.7 * ink);
    check_cubes(&[(0.85, 0.0, ink, 1), (0.8, 0.0, fog, 1)], 0.1 * ink + 1.6 * fog);
    check_cubes(&[(0.85, 0.0, ink, 0), (0.8, 0.0, fog, 1)], 0.1 * ink + 1.6 * fog);
    // What is in what does not count counts by itself.
    let three = [(0.85, 0.0, ink, 1), (0.8, 0.0, fog, 0), (0.3, 0.0, 2.0, 2)];
    check_cubes(&three, 1.1 * ink + 0.6 * 2.0);
    let three = [(0.85, 0.0, ink, 1), (0.8, 0.0, fog, 0), (0.3, 0.0, 2.0, 1)];
    check_cubes(&three, 1.1 * ink + 0.6 * 2.0);
    let three = [(0.85, 0.0, ink, 2), (0.8, 0.0, fog, 0), (0.3, 0.0, 2.0, 1)];
    check_cubes(&three, 1.7 * ink);
}

/// A hollow body has two outsides.
#[test]
fn cavities_hold_what_is_in_them() {
    for half in [0.7_f32, 0.8, 0.801, 0.85] {
        let wall = 2.0 * (0.2 - (half - 0.8).max(0.0));
        let depth = 2.0 * wall + 0.7 * 2.0 * (half - 0.3) + 0.1 * 0.6;
        check_cubes(&[(1.0, 0.8, 2.0, 0), (half, 0.0, 0.7, 0), (0.3, 0.0, 0.1, 0)], depth);
        let depth = 2.0 * wall + 0.7 * 2.0 * half;
        check_cubes(&[(1.0, 0.8, 2.0, 0), (half, 0.0, 0.7, 0)], depth);
        let depth = 2.0 * wall + 0.7 * 2.0 * (half - 0.6) + 0.1 * 0.6;
        check_cubes(&[(1.0, 0.8, 2.0, 0), (half, 0.6, 0.7, 0), (0.3, 0.0, 0.1, 0)], depth);
    }
}

/// Bodies know nothing of what is not closed, and have no say where that tells what is there.
#[test]
fn what_is_sealed_off_by_walls_is_what_its_boundary_says() {
    let build = |bench: &mut Bench| {
        let [fog, smoke] = [("fog", 0.5), ("smoke", 2.0)].map(|(name, a)| bench.medium(name, a));
        bench.slab("fog", fog, [-3.0, 3.0], 3.0);
        let mut dome = cube(1.0, 0.0);
        dome.triangles.drain(..2);
        let skin = Skin::from(bench.null).interior(smoke).exterior(fog);
        bench.world.add_mesh("dome", dome, skin, Transform::IDENTITY).unwrap();
        let dark = Material::from(Bsdf::Absorber).two_sided();
        let dark = bench.world.add_material("dark", dark).unwrap();
        let wall = Geometry::quad(Vec3::X * -0.9, Vec3::Y * 1.5, Vec3::Z * 1.5);
        bench.world.add_mesh("wall", wall, dark, Transform::IDENTITY).unwrap();
        let hole = Skin::from(bench.null).interior(Filling::Clear);
        bench.world.add_sphere("hole", 0.5, hole, DVec3::ZERO).unwrap();
    };
    check(build, 0.0, 0.5 * 4.0 + 2.0 * 1.0);
}

#[test]
fn media_that_touch_are_nothing_special() {
    for order in [[0, 1, 2], [2, 1, 0], [1, 2, 0]] {
        let build = |bench: &mut Bench| {
            let media = [("a", 0.5), ("b", 2.0), ("c", 1.0)].map(|(n, s)| bench.medium(n, s));
            for which in order {
                let z = [[-1.0, 0.0], [0.0, 0.25], [0.25, 1.25]][which];
                bench.slab(&format!("layer {which}"), media[which], z, 1.0);
            }
        };
        assert_eq!(check(build, 0.3, 0.5 + 0.5 + 1.0), [""; 0]);
    }
}

#[test]
fn contradictions_name_both_surfaces_and_have_one_meaning() {
    let build = |bench: &mut Bench| {
        let [fog, smoke] = [("fog", 0.5), ("smoke", 2.0)].map(|(name, a)| bench.medium(name, a));
        let skin = Skin::from(bench.null).interior(Filling::Clear).exterior(smoke);
        bench.world.add_sphere("bubble", 0.5, skin, DVec3::ZERO).unwrap();
        bench.slab("box", fog, [-1.0, 2.0], 3.0);
    };
    let warnings = check(build, 0.0, 0.5 * 2.0);
    let [warning] = &warnings[..] else { panic!("{warnings:?}") };
    assert!(warning.contains("`bubble`") && warning.contains("`box`"), "{warning}");
    // A sea without a bottom: where it ends is not known.
    let mut bench = Bench::new();
    let water = bench.medium("water", 0.5);
    let skin = Skin::from(bench.null).interior(water).exterior(Filling::Clear);
    let sea = Geometry::quad(Vec3::ZERO, Vec3::X * 9.0, Vec3::Y * 9.0);
    bench.world.add_mesh("sea", sea, skin, Transform::IDENTITY).unwrap();
    let (_, warnings) = bench.shone_through(0.0, -1.0);
    let [warning] = &warnings[..] else { panic!("{warnings:?}") };
    assert!(warning.contains("`sea`") && warning.contains("cannot be known"), "{warning}");
}
