//! Which integrator is chosen for which scene, what is said about it, and how many photons and
//! samples an iteration has where nobody says so.

use sunstone::glam::{DVec3, Vec3};
use sunstone::world::{Bsdf, Geometry, Lens, Material, Medium, Phase, Punctual, Transform};
use sunstone::{
    Color, Distribution, Error, Integrator, Mode, Options, Photons, PlacedWorld, Renderer, Rule,
    Settings, World,
};

/// How large the room is, in meters.
const SIZES: [f32; 3] = [1e-3, 1.0, 1e3];

/// What stands in a white room, and how large that is; everything else grows with it.
struct Room {
    world: World,
    size: f32,
}

impl Room {
    /// The room, its half edge `size`, with a camera that looks along -z.
    fn new(size: f32) -> Result<Self, Error> {
        let mut world = World::new("room");
        let white = world.add_material("wall", Material::from(Bsdf::diffuse(0.7)).two_sided())?;
        let walls = Geometry::cuboid(-size * Vec3::ONE, size * Vec3::ONE);
        world.add_mesh("walls", walls, white, Transform::IDENTITY)?;
        let eye = DVec3::Z * 0.9 * f64::from(size);
        let place = Transform::looking(eye, DVec3::ZERO, DVec3::Y);
        world.set_camera("eye", Lens::pinhole(1.2), place)?;
        world.set_resolution([24, 16])?;
        Ok(Self { world, size })
    }

    /// With a ball before the camera, or behind it.
    fn ball(mut self, bsdf: Bsdf, place: Vec3) -> Result<Self, Error> {
        let skin = self.world.add_material("ball", bsdf)?;
        let place = (self.size * place).as_dvec3();
        self.world.add_sphere("ball", f64::from(0.2 * self.size), skin, place)?;
        Ok(self)
    }

    /// With a square lamp of so large a half edge, under the ceiling.
    fn lamp(mut self, half: f32, place: Vec3) -> Result<Self, Error> {
        let glow = self.world.add_material("glow", Material::emitter([9.0; 3]).two_sided())?;
        let half = half * self.size;
        let lamp = Geometry::quad(self.size * place, Vec3::X * half, Vec3::Z * half);
        self.world.add_mesh("lamp", lamp, glow, Transform::IDENTITY)?;
        Ok(self)
    }

    /// With a lamp without extent.
    fn light(mut self, light: Punctual, place: Vec3) -> Result<Self, Error> {
        self.world.add_light("spark", light, (self.size * place).as_dvec3())?;
        Ok(self)
    }

    /// With fog all over.
    fn fog(mut self) -> Result<Self, Error> {
        let sigma = 0.3 / self.size;
        let fog = Medium::new([0.0; 3], [sigma; 3], Phase::isotropic());
        let fog = self.world.add_medium("fog", fog)?;
        self.world.set_scene_medium(fog)?;
        Ok(self)
    }

    /// With a pane of solid glass from wall to wall, above the camera.
    fn pane(mut self) -> Result<Self, Error> {
        let skin = self.world.add_material("pane", glass())?;
        let [low, high] = [[-0.999, 0.3, -0.999], [0.999, 0.4, 0.999]];
        let [low, high] = [low, high].map(|corner| self.size * Vec3::from_array(corner));
        self.world.add_mesh("pane", Geometry::cuboid(low, high), skin, Transform::IDENTITY)?;
        Ok(self)
    }

    /// With a closed box about a place.
    fn closed_box(self, bsdf: Bsdf, place: Vec3) -> Result<Self, Error> {
        self.box_of(bsdf, place, 12)
    }

    /// With so many of the triangles of such a box.
    fn box_of(mut self, bsdf: Bsdf, place: Vec3, triangles: usize) -> Result<Self, Error> {
        let skin = self.world.add_material("box", Material::from(bsdf).two_sided())?;
        let [low, high] = [-0.1, 0.1].map(|to| self.size * (place + to * Vec3::ONE));
        let mut walls = Geometry::cuboid(low, high);
        walls.triangles.truncate(triangles);
        self.world.add_mesh("box", walls, skin, Transform::IDENTITY)?;
        Ok(self)
    }
}

const CEILING: Vec3 = Vec3::new(0.0, 0.95, 0.0);
const BEFORE: Vec3 = Vec3::new(0.2, -0.5, -0.2);
const BEHIND: Vec3 = Vec3::new(0.0, 0.5, 0.7);
const CORNER: Vec3 = Vec3::new(-0.6, 0.5, -0.5);

fn glass() -> Bsdf {
    Bsdf::dielectric(1.5)
}

fn spark() -> Punctual {
    Punctual::point([3.0; 3])
}

fn rule(world: &PlacedWorld, options: Options) -> (Rule, Integrator) {
    let settings = Settings::new(options).expect("sound options");
    let renderer = Renderer::new(world, &settings).expect("a sound world");
    let resolved = renderer.settings();
    (resolved.rule.expect("nothing was asked for"), resolved.integrator)
}

fn notes(world: &PlacedWorld, integrator: Option<Integrator>) -> Vec<String> {
    let settings = Settings::new(Options { integrator, ..Options::default() }).expect("sound");
    world.notes(&settings).expect("a sound world")
}

/// Rooms by what is in them, with the rule that holds.
fn rooms(size: f32) -> Result<Vec<(&'static str, Room, Rule)>, Error> {
    let room = || Room::new(size);
    let metal = || Bsdf::metal("Al");
    let sheet = Bsdf::polarizer(30.0);
    let spot = Punctual::spot([3.0; 3], 0.1, 0.2);
    Ok(vec![
        ("lamp", room()?.lamp(0.3, CEILING)?, Rule::Plain),
        ("small lamp", room()?.lamp(0.003, CEILING)?, Rule::Plain),
        ("point", room()?.light(spark(), CORNER)?, Rule::Plain),
        ("sheet", room()?.light(spark(), CORNER)?.ball(sheet, BEFORE)?, Rule::Plain),
        ("lamp, glass", room()?.lamp(0.5, CEILING)?.ball(glass(), BEFORE)?, Rule::Plain),
        ("lamp, metal", room()?.lamp(0.5, CEILING)?.ball(metal()?, BEFORE)?, Rule::Plain),
        ("small, glass", room()?.lamp(0.01, CEILING)?.ball(glass(), BEFORE)?, Rule::Small),
        // Glass is before hardly anything that the camera sees.
        ("small bulb", room()?.lamp(0.01, BEFORE)?.ball(glass(), BEFORE)?, Rule::SmallHidden),
        ("small, behind", room()?.lamp(0.01, CEILING)?.ball(glass(), BEHIND)?, Rule::Small),
        ("point, glass", room()?.light(spark(), CORNER)?.ball(glass(), BEFORE)?, Rule::PointsSeen),
        ("point, metal", room()?.light(spark(), CORNER)?.ball(metal()?, BEHIND)?, Rule::Points),
        ("point in fog", room()?.light(spark(), CORNER)?.fog()?, Rule::PointsInMedia),
        ("lamp in fog", room()?.lamp(0.3, CEILING)?.fog()?, Rule::Plain),
        // All light comes through it, from a lamp that is not so small.
        ("lamp, pane", room()?.lamp(0.3, CEILING)?.pane()?, Rule::SmallHidden),
        // A bulb: the lamp is inside of the glass.
        ("bulb", room()?.light(spark(), BEFORE)?.ball(glass(), BEFORE)?, Rule::PointsSeen),
        // It shines downwards, beside the ball.
        ("spot, beside", room()?.light(spot.clone(), CORNER)?.ball(glass(), BEFORE)?, Rule::Plain),
        (
            "point in a box",
            room()?
                .lamp(0.5, CEILING)?
                .ball(glass(), BEFORE)?
                .light(spark(), CORNER)?
                .closed_box(Bsdf::diffuse(0.5), CORNER)?,
            Rule::Plain,
        ),
    ])
}

#[test]
fn lamps_and_what_hides_them_decide_in_rooms_of_any_size() {
    for size in SIZES {
        for (name, room, expected) in rooms(size).expect("sound rooms") {
            let world = PlacedWorld::new(room.world).expect("a sound room");
            let found = rule(&world, Options::default());
            assert_eq!(found, (expected, expected.integrator()), "{name}, size {size}");
        }
    }
}

#[test]
fn nothing_but_the_scene_decides() {
    for (name, room, expected) in rooms(1.0).expect("sound rooms") {
        let world = PlacedWorld::new(room.world).expect("a sound room");
        let mono = Color::Mono { wavelength_nm: 450.0 };
        let others = [
            Options { mode: Mode::Scalar, seed: 7, samples: 3, ..Options::default() },
            Options { width: Some(7), height: Some(90), ..Options::default() },
            Options { color: mono, path_length_max: 2, ..Options::default() },
        ];
        for options in others {
            assert_eq!(rule(&world, options.clone()).0, expected, "{name}, {options:?}");
        }
    }
}

#[test]
fn the_sun_on_glass_decides_and_the_sky_does_not() -> Result<(), Error> {
    let world = |sun: Option<f32>| -> Result<World, Error> {
        let mut world = World::new("field");
        let gray = world.add_material("ground", Material::from(Bsdf::diffuse(0.5)).two_sided())?;
        let clear = world.add_material("glass", glass())?;
        let ground = Geometry::quad(Vec3::ZERO, Vec3::X * 1000.0, Vec3::Z * 1000.0);
        world.add_mesh("ground", ground, gray, Transform::IDENTITY)?;
        world.add_sphere("ball", 0.5, clear, DVec3::Y * 0.6)?;
        let place = Transform::looking(DVec3::new(0.0, 1.0, 4.0), DVec3::Y * 0.5, DVec3::Y);
        world.set_camera("eye", Lens::pinhole(0.8), place)?;
        world.set_environment([0.5; 3])?;
        if let Some(irradiance) = sun {
            let down = Transform::looking(DVec3::Y, DVec3::new(1.0, 0.0, 0.0), DVec3::X);
            world.add_light("sun", Punctual::directional([irradiance; 3]), down)?;
        }
        Ok(world)
    };
    for (sun, expected) in [(None, Rule::Plain), (Some(3.0), Rule::PointsSeen)] {
        let world = PlacedWorld::new(world(sun)?)?;
        assert_eq!(rule(&world, Options::default()).0, expected, "{sun:?}");
    }
    Ok(())
}

#[test]
fn what_was_asked_for_and_what_was_chosen_is_kept() -> Result<(), Error> {
    let room = Room::new(1.0)?.light(spark(), CORNER)?.ball(glass(), BEFORE)?;
    let world = PlacedWorld::new(room.world)?;
    let image = |integrator| -> Result<_, Error> {
        let settings = Settings::new(Options { integrator, samples: 6, ..Options::default() })?;
        let mut renderer = Renderer::new(&world, &settings)?;
        renderer.step();
        Ok(renderer.finish())
    };
    let chosen = image(None)?;
    for (key, value) in [
        ("integrator", "ppm"),
        ("integrator asked for", "auto"),
        ("photons an iteration", "10000"),
        ("samples an iteration", "3"),
        ("iterations", "3"),
    ] {
        assert_eq!(chosen.metadata(key), Some(value), "{key}");
    }
    let rule = chosen.metadata("integrator rule").expect("there is one");
    assert!(rule.contains("points"), "{rule}");
    let asked = image(Some(Integrator::Path))?;
    assert_eq!(asked.metadata("integrator asked for"), Some("path"));
    assert_eq!(asked.metadata("integrator rule"), None);
    assert_eq!(asked.metadata("photons an iteration"), None);
    assert_eq!(image(Some(Integrator::Ppm))?.planes, chosen.planes);
    Ok(())
}

#[test]
fn iterations_are_of_as_many_samples_as_the_integrator_takes() -> Result<(), Error> {
    let room = Room::new(1.0)?.light(spark(), CORNER)?.ball(glass(), BEFORE)?;
    let world = PlacedWorld::new(room.world)?;
    let photons = Photons { samples: Some(3), ..Photons::default() };
    let cases = [
        (None, Photons::default(), 20),
        (Some(Integrator::Ppm), photons, 15),
        (Some(Integrator::Path), photons, 5),
    ];
    for (integrator, photons, expected) in cases {
        let options = Options { integrator, photons, iterations: Some(5), ..Options::default() };
        let renderer = Renderer::new(&world, &Settings::new(options)?)?;
        assert_eq!(renderer.settings().samples, expected, "{integrator:?}");
    }
    Ok(())
}

/// Four samples for each pass, or as many as divide what is asked for and leave passes enough.
#[test]
fn photons_and_samples_are_balanced_where_nobody_says_how_many() {
    let ppm = Options { integrator: Some(Integrator::Ppm), ..Options::default() };
    for (samples, replicates, variance, expected) in [
        (64, 1, false, 4),
        (6, 1, false, 3),
        (7, 1, false, 1),
        (1, 1, false, 1),
        (64, 17, false, 2),
        (64, 64, false, 1),
        (4, 1, true, 2),
        (2, 1, true, 1),
    ] {
        let options = Options { samples, replicates, variance, ..ppm.clone() };
        assert_eq!(options.samples_of_photons(), expected, "{options:?}");
        Settings::new(options).expect("they fit");
    }
    let photons = Photons::default();
    for (film, expected) in [
        ([16, 16], 10_000),
        ([256, 256], 262_144),
        ([512, 512], 1_048_576),
        ([65_535, 1_000], 4_000_000),
    ] {
        assert_eq!(photons.light_paths(film), expected, "{film:?}");
    }
    let given = Photons { per_iteration: Some(77), samples: Some(5), ..photons };
    assert_eq!(given.light_paths([512, 512]), 77);
    assert_eq!(Options { photons: given, samples: 10, ..ppm.clone() }.samples_of_photons(), 5);
    // Whatever would be chosen.
    let auto = Options { integrator: None, photons: given, samples: 11, ..ppm.clone() };
    let error = Settings::new(auto).expect_err("11 is no multiple of 5").to_string();
    assert!(error.contains("multiple of the 5 samples"), "{error}");
}

#[test]
fn what_an_integrator_does_not_find_is_said_and_nothing_else() {
    let [path, light, bdpt, ppm] =
        [Integrator::Path, Integrator::Light, Integrator::Bdpt, Integrator::Ppm].map(Some);
    let say = |name: &str, rule: Rule, integrator| match (rule, integrator) {
        // It is found, if not so well.
        _ if name == "lamp, pane" => None,
        (Rule::PointsSeen | Rule::Points, it) if it == path => Some("`path` does not find"),
        (Rule::SmallHidden | Rule::Small, it) if it == path => Some("only by chance"),
        (Rule::PointsSeen, it) if it == bdpt => Some("`bdpt` does not find"),
        (Rule::SmallHidden, it) if it == bdpt => Some("only by chance"),
        _ => None,
    };
    for (name, room, rule) in rooms(1.0).expect("sound rooms") {
        let world = PlacedWorld::new(room.world).expect("a sound room");
        let boxed = name == "point in a box";
        for integrator in [path, bdpt, ppm] {
            let mut found = notes(&world, integrator);
            found.retain(|note| !(boxed && note.contains("past what is opaque")));
            match say(name, rule, integrator) {
                Some(part) => assert!(found.len() == 1 && found[0].contains(part), "{found:?}"),
                None => assert_eq!(found, Vec::<String>::new(), "{name}, {integrator:?}"),
            }
        }
        let found = notes(&world, light);
        let is_blind = found.iter().any(|note| note.contains("solid glass"));
        let sees = name.contains("glass") || name.contains("metal") || name.contains("bulb");
        let sees = sees || name.contains("pane");
        let before = sees && rule != Rule::Points || boxed || name == "spot, beside";
        assert_eq!(is_blind, before, "{name}: {found:?}");
        assert!(notes(&world, None)[0].contains("--integrator auto takes"), "{name}");
    }
}

/// A ball and a light in a larger ball.
fn spheres(bsdf: Bsdf, light: Punctual) -> Result<World, Error> {
    let mut world = World::new("spheres");
    let white = world.add_material("wall", Material::from(Bsdf::diffuse(0.7)).two_sided())?;
    world.add_sphere("wall", 1.0, white, DVec3::ZERO)?;
    let skin = world.add_material("ball", bsdf)?;
    world.add_sphere("ball", 0.2, skin, BEFORE.as_dvec3())?;
    world.add_light("spark", light, CORNER.as_dvec3())?;
    let place = Transform::looking(0.9 * DVec3::Z, DVec3::ZERO, DVec3::Y);
    world.set_camera("eye", Lens::pinhole(1.2), place)?;
    Ok(world)
}

#[test]
fn what_one_world_finds_holds_beside_it_only_where_nothing_else_is_seen() -> Result<(), Error> {
    let spot = || Punctual::spot([3.0; 3], 0.1, 0.2);
    let all = || -> Result<Vec<World>, Error> {
        let metal = || Bsdf::metal("Al");
        Ok(vec![
            spheres(metal()?, spark())?,
            spheres(Bsdf::diffuse(0.5), spark())?,
            spheres(Bsdf::metal("Cu")?, spark())?,
            spheres(metal()?, spot())?,
            spheres(glass(), spark())?,
            spheres(Bsdf::dielectric(1.7), spark())?,
            spheres(Bsdf::polarizer(10.0), spark())?,
        ])
    };
    let is_known = |a: &PlacedWorld, b: &World| a.shares_shapes(b).expect("a sound world");
    let first = PlacedWorld::new(all()?.swap_remove(0))?;
    let shared = all()?.iter().filter(|world| is_known(&first, world)).count();
    assert!(shared >= 4, "{shared} share shapes with a metal ball");
    let mut rules = Vec::new();
    for (alone, beside) in all()?.into_iter().zip(all()?) {
        let (alone, beside) = (PlacedWorld::new(alone)?, first.beside(beside)?);
        let options = Options::default;
        assert_eq!(rule(&alone, options()), rule(&beside, options()));
        for &integrator in Integrator::ALL {
            assert_eq!(notes(&alone, Some(integrator)), notes(&beside, Some(integrator)));
        }
        rules.push(rule(&beside, options()).0);
    }
    let (seen, plain) = (Rule::PointsSeen, Rule::Plain);
    assert_eq!(rules, [seen, plain, seen, plain, seen, seen, plain]);
    Ok(())
}

#[test]
fn a_lamp_in_a_closed_box_is_named_and_one_in_glass_or_with_a_gap_is_not() -> Result<(), Error> {
    let said = |room: Room| -> Result<Vec<String>, Error> {
        let world = PlacedWorld::new(room.world)?;
        Ok(notes(&world, Some(Integrator::Ppm)))
    };
    for size in SIZES {
        let lit = || -> Result<Room, Error> {
            Room::new(size)?.lamp(0.3, CEILING)?.light(spark(), CORNER)
        };
        let [shut] = &said(lit()?.closed_box(Bsdf::diffuse(0.5), CORNER)?)?[..] else {
            panic!("one note")
        };
        assert!(shut.contains("`spark`: no light gets from it"), "{shut}");
        assert!(said(lit()?.closed_box(glass(), CORNER)?)?.is_empty());
        assert!(said(lit()?)?.is_empty());
        assert!(said(lit()?.box_of(Bsdf::diffuse(0.5), CORNER, 11)?)?.is_empty());
        // A lamp of its own in the box, and one just under the ceiling.
        let close = Vec3::new(0.0, 1.0 - 1e-4, 0.0);
        assert!(said(Room::new(size)?.lamp(0.3, close)?)?.is_empty());
        let inside = Room::new(size)?.lamp(0.05, CORNER)?.closed_box(Bsdf::diffuse(0.5), CORNER)?;
        let [shut] = &said(inside)?[..] else { panic!("one note") };
        assert!(shut.contains("`lamp`: no light gets"), "{shut}");
    }
    Ok(())
}

#[test]
fn particle_tracing_does_not_see_a_sky_by_parallel_rays() -> Result<(), Error> {
    let said = |lens: Lens, integrator| -> Result<Vec<String>, Error> {
        let mut world = World::new("plate");
        let gray = world.add_material("plate", Material::from(Bsdf::diffuse(0.5)).two_sided())?;
        let plate = Geometry::quad(Vec3::ZERO, Vec3::X * 0.5, Vec3::Y * 0.5);
        world.add_mesh("plate", plate, gray, Transform::IDENTITY)?;
        world.set_environment([1.0; 3])?;
        world.set_camera("eye", lens, Transform::looking(DVec3::Z, DVec3::ZERO, DVec3::Y))?;
        Ok(notes(&PlacedWorld::new(world)?, Some(integrator)))
    };
    let parallel = |half| Lens::Orthographic { half_width: half, half_height: half };
    let [note] = &said(parallel(1.0), Integrator::Light)?[..] else { panic!("one note") };
    assert!(note.contains("a sky by parallel rays") && note.contains("75 %"), "{note}");
    // Where the plate fills the view, by rays that are not parallel, and by other integrators.
    assert!(said(parallel(0.4), Integrator::Light)?.is_empty());
    assert!(said(Lens::pinhole(1.5), Integrator::Light)?.is_empty());
    for integrator in [Integrator::Path, Integrator::Bdpt, Integrator::Ppm] {
        assert!(said(parallel(1.0), integrator)?.is_empty());
    }
    Ok(())
}

/// What `light` does not see of a wall through what is before it.
#[test]
fn particle_tracing_tells_what_polished_surfaces_and_panes_hide() -> Result<(), Error> {
    let said = |walls: &[Bsdf], integrator| -> Result<Vec<String>, Error> {
        let mut world = World::new("walls");
        for (index, bsdf) in walls.iter().enumerate() {
            let name = format!("wall {index}");
            let material = Material::from(bsdf.clone());
            let material = match bsdf {
                Bsdf::Diffuse { .. } | Bsdf::RoughConductor { .. } => material.two_sided(),
                _ => material,
            };
            let material = world.add_material(&name, material)?;
            let at = Vec3::NEG_Z * index as f32;
            let wall = Geometry::quad(at, Vec3::X * 9.0, Vec3::Y * 9.0);
            world.add_mesh(&name, wall, material, Transform::IDENTITY)?;
        }
        world.set_environment([1.0; 3])?;
        let from = Transform::looking(DVec3::Z, DVec3::ZERO, DVec3::Y);
        world.set_camera("eye", Lens::pinhole(0.5), from)?;
        Ok(notes(&PlacedWorld::new(world)?, Some(integrator)))
    };
    let metal = |alpha| Bsdf::rough_metal("Al", alpha);
    let (rough, polished, smooth) = (metal(0.3)?, metal(0.02)?, metal(0.001)?);
    let pane = Bsdf::thin_dielectric(1.5);
    let glass = |alpha: f32| Bsdf::RoughDielectric {
        ior: 1.5.into(),
        exterior_ior: 1.0.into(),
        alpha,
        distribution: Distribution::default(),
        multiple_scattering: true,
    };
    let white = Bsdf::diffuse(0.5);
    for (walls, words) in [
        (vec![polished.clone()], &["polished", "(100 % of the view)"][..]),
        (vec![smooth], &["polished"]),
        (vec![glass(0.02), white.clone()], &["polished"]),
        (vec![pane.clone(), polished], &["polished", "what panes mirror"]),
        (vec![pane, white.clone()], &["what panes mirror"]),
    ] {
        let found = said(&walls, Integrator::Light)?.concat();
        assert!(words.iter().all(|word| found.contains(word)), "{walls:?}: {found}");
        assert_eq!(found.contains("polished"), words.contains(&"polished"), "{walls:?}: {found}");
        assert!(!said(&walls, Integrator::Path)?.concat().contains("light"), "{walls:?}");
    }
    for walls in [vec![rough], vec![glass(0.3), white]] {
        assert_eq!(said(&walls, Integrator::Light)?, [] as [String; 0], "{walls:?}");
    }
    Ok(())
}
