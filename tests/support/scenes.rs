//! Small scenes that between them hold every emitter, camera and material, and the combinations
//! in which strategies and polarization have most occasion to disagree.

use glam::Vec3;
use serde_json::json;
use sunstone::internals::scene::World;

use super::gltf::{Document, Flock};

/// A scene by name.
pub type Named = (&'static str, fn() -> World);

/// All of them.
pub const SCENES: [Named; 48] = [
    ("one-sided panel, pinhole", one_sided_panel),
    ("two-sided panel, lens", two_sided_panel),
    ("sphere light, orthographic", sphere_light),
    ("point light, pinhole", point_light),
    ("spot light, lens", spot_light),
    ("directional light, orthographic", directional_light),
    ("directional light, pinhole", directional_light_seen_by_pinhole),
    ("environment, lens", environment),
    ("environment, orthographic", environment_orthographic),
    ("all emitters", all_emitters),
    ("smooth-shaded diffuse ball", || smooth_shaded(Ball::Diffuse)),
    ("smooth-shaded glass ball", || smooth_shaded(Ball::Glass)),
    ("smooth-shaded mirror ball", || smooth_shaded(Ball::Mirror)),
    ("tilted normals, diffuse", || tilted_normals(Ball::Diffuse)),
    ("tilted normals, glass", || tilted_normals(Ball::Glass)),
    ("tilted normals, mirror", || tilted_normals(Ball::Mirror)),
    ("below a surface of water", below_water),
    ("two metals and glass", metals_and_glass),
    ("glass before a point light", glass_and_point_light),
    ("glass and mirror under an environment", glass_under_environment),
    ("sheets under a panel", sheets_under_panel),
    ("sheets under a point light", sheets_under_point_light),
    ("sheets and glass, orthographic", sheets_orthographic),
    ("fog about a point light", fog_about_point_light),
    ("fog fills the scene, orthographic", fog_everywhere),
    ("sun and sky on a block of fog", fog_under_the_sky),
    ("camera in thin air", camera_in_thin_air),
    ("stained fog in glass", stained_fog_in_glass),
    ("thin air between polarizers", thin_air_between_polarizers),
    ("milk and a mirror", milk_and_mirror),
    ("bottle of milk", bottle_of_milk),
    ("flock of instances", || flock(Flock::Instances)),
    ("many lamps about a partition", many_lamps),
    ("lamps and sky about a partition", lamps_and_sky),
    ("lamps in fog", lamps_in_fog),
    ("large sphere light on the floor", sphere_on_the_floor),
    ("glass and water that touch", glass_and_water),
    ("rough metals", super::rough::metals),
    ("plastics", super::rough::plastics),
    ("rough coats, orthographic", super::rough::coats),
    ("rough glasses", super::rough::glasses),
    ("rough glass and fog", super::rough::glass_and_fog),
    ("polarized panel and sky on glass and metal", super::polarized::panel_and_sky),
    ("polarized points in thin air", super::polarized::points_in_thin_air),
    ("polarized panes behind sheets", super::polarized::panes_behind_sheets),
    ("hot metals and glass", super::polarized::hot_metals),
    ("luminaires in thin air", super::luminaires::in_thin_air),
    ("projectors in thin air", super::projectors::in_thin_air),
];

/// In which boundaries contradict each other.
pub const CONTRADICTORY: [Named; 2] = [
    ("fogs that overlap", overlapping_fogs),
    ("glass half in fog, exterior not stated", glass_in_fog),
];

const WALLS: [f32; 6] = [0.7, 0.6, 0.5, 0.4, 0.3, 0.65];
const FRONT: usize = 5;
pub(super) const CEILING: usize = 1;

pub(super) fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// A room without front wall, and without those in `open`.
pub(super) fn room(open: &[usize]) -> Document {
    let mut scene = Document::default();
    let walls = WALLS.map(|reflectance| scene.diffuse(reflectance));
    scene.room(walls, &[&[FRONT], open].concat());
    scene
}

pub(super) fn pinhole(mut scene: Document) -> Document {
    scene.perspective(v(0.2, 0.1, 3.6), Vec3::ZERO, 0.62, None);
    scene
}

/// A panel that shines down from below the ceiling, of half edge `half`.
pub(super) fn add_panel(scene: &mut Document, half: f32, radiance: f32) {
    let panel = scene.material(json!({"bsdf": "absorber"}));
    let panel = scene.emits(panel, radiance);
    scene.quad(v(0.1, 0.95, 0.0), v(half, 0.0, 0.0), v(0.0, 0.0, half), panel);
}

fn one_sided_panel() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.3, 8.0);
    pinhole(scene).load("one-sided panel")
}

fn two_sided_panel() -> World {
    let mut scene = room(&[]);
    let panel = scene.diffuse(0.5);
    let panel = scene.two_sided(panel);
    let panel = scene.emits(panel, 2.0);
    scene.quad(v(-0.2, 0.1, 0.1), v(0.3, 0.1, 0.2), v(-0.1, 0.4, 0.1), panel);
    scene.perspective(v(0.2, 0.1, 3.6), Vec3::ZERO, 0.62, Some([0.2, 3.2]));
    scene.load("two-sided panel")
}

fn sphere_light() -> World {
    let mut scene = room(&[]);
    let bulb = scene.diffuse(0.4);
    let bulb = scene.emits(bulb, 3.0);
    scene.sphere(v(0.3, -0.2, 0.2), 0.25, bulb);
    let block = scene.diffuse(0.8);
    scene.sphere(v(-0.4, -0.5, 0.1), 0.3, block);
    scene.orthographic(v(0.3, 0.4, 3.0), Vec3::ZERO, 0.95);
    scene.load("sphere light")
}

fn point_light() -> World {
    let mut scene = room(&[]);
    scene.light(json!({"type": "point", "intensity": 2.0}), v(0.3, 0.2, 0.1), Vec3::NEG_Z);
    let ball = scene.diffuse(0.8);
    scene.sphere(v(-0.4, -0.5, 0.1), 0.3, ball);
    pinhole(scene).load("point light")
}

fn spot_light() -> World {
    let mut scene = room(&[]);
    let cone = json!({"innerConeAngle": 0.2, "outerConeAngle": 0.6});
    let spot = json!({"type": "spot", "intensity": 6.0, "spot": cone});
    scene.light(spot, v(0.4, 0.7, 0.3), v(-0.5, -1.0, -0.3));
    scene.perspective(v(0.2, 0.1, 3.6), Vec3::ZERO, 0.62, Some([0.2, 3.2]));
    scene.load("spot light")
}

fn sunny_room() -> Document {
    let mut scene = room(&[CEILING]);
    let sun = json!({"type": "directional", "intensity": 3.0});
    scene.light(sun, v(5.0, 5.0, 5.0), v(-0.4, -1.0, -0.5));
    let ball = scene.diffuse(0.8);
    scene.sphere(v(-0.4, -0.5, 0.1), 0.3, ball);
    scene
}

fn directional_light() -> World {
    let mut scene = sunny_room();
    scene.orthographic(v(0.3, 0.4, 3.0), Vec3::ZERO, 1.2);
    scene.load("directional light")
}

fn directional_light_seen_by_pinhole() -> World {
    pinhole(sunny_room()).load("directional light, pinhole")
}

pub(super) fn open_scene() -> Document {
    let mut scene = room(&[CEILING, 2]);
    scene.environment(0.8);
    let ball = scene.diffuse(0.8);
    scene.sphere(v(-0.3, -0.4, 0.1), 0.4, ball);
    scene
}

fn environment() -> World {
    let mut scene = open_scene();
    scene.perspective(v(0.2, 0.6, 3.6), Vec3::ZERO, 0.7, Some([0.15, 3.2]));
    scene.load("environment")
}

fn environment_orthographic() -> World {
    let mut scene = open_scene();
    scene.orthographic(v(0.3, 0.9, 3.0), Vec3::ZERO, 1.2);
    scene.load("environment, orthographic")
}

/// Their powers differ by less than ten, so that each is chosen often.
fn all_emitters() -> World {
    let mut scene = sunny_room();
    add_panel(&mut scene, 0.3, 4.0);
    let bulb = scene.diffuse(0.4);
    let bulb = scene.emits(bulb, 2.0);
    scene.sphere(v(0.5, -0.6, 0.2), 0.2, bulb);
    scene.light(json!({"type": "point", "intensity": 0.7}), v(-0.6, 0.3, 0.3), Vec3::NEG_Z);
    let cone = json!({"innerConeAngle": 0.3, "outerConeAngle": 0.3});
    let spot = json!({"type": "spot", "intensity": 9.0, "spot": cone});
    scene.light(spot, v(0.4, 0.7, 0.7), v(-0.5, -1.0, -0.9));
    scene.environment(0.2);
    scene.perspective(v(0.2, 0.1, 3.6), Vec3::ZERO, 0.7, Some([0.1, 3.2]));
    scene.load("all emitters")
}

/// Lamps of all sorts on both sides of walls that leave gaps: what is near is often hidden.
pub fn many_lamps() -> World {
    let mut scene = room(&[]);
    let wall = scene.diffuse(0.5);
    let wall = scene.two_sided(wall);
    scene.quad(v(0.1, -0.2, 0.0), v(0.0, 0.8, 0.0), v(0.0, 0.0, 0.7), wall);
    add_lamps(&mut scene, 1.0);
    pinhole(scene).load("many lamps")
}

/// The same without ceiling and one wall, under a sky that brings about as much.
pub fn lamps_and_sky() -> World {
    let mut scene = open_scene();
    let wall = scene.diffuse(0.5);
    let wall = scene.two_sided(wall);
    scene.quad(v(0.1, -0.2, 0.0), v(0.0, 0.8, 0.0), v(0.0, 0.0, 0.7), wall);
    add_lamps(&mut scene, 0.3);
    let sun = json!({"type": "directional", "intensity": 1.0});
    scene.light(sun, v(5.0, 5.0, 5.0), v(-0.4, -1.0, -0.5));
    scene.perspective(v(0.2, 0.6, 3.6), Vec3::ZERO, 0.7, None);
    scene.load("lamps and sky")
}

/// Panels of both kinds, balls, points and spots.
fn add_lamps(scene: &mut Document, strength: f32) {
    let lamp = scene.material(json!({"bsdf": "absorber"}));
    let lamp = scene.emits(lamp, 20.0 * strength);
    let both = scene.diffuse(0.3);
    let both = scene.two_sided(both);
    let both = scene.emits(both, 10.0 * strength);
    let bulb = scene.diffuse(0.4);
    let bulb = scene.emits(bulb, 8.0 * strength);
    for index in 0..9_u8 {
        let x = -0.8 + 0.2 * f32::from(index);
        let z = 0.7 - 0.35 * f32::from(index % 5);
        scene.quad(v(x, 0.9, z), v(0.05, 0.0, 0.0), v(0.0, 0.0, 0.05), lamp);
        scene.quad(v(x, -0.4, -z), v(0.0, 0.05, 0.0), v(0.02, 0.0, 0.05), both);
        scene.sphere(v(-x, -0.85, z), 0.06, bulb);
    }
    for x in [-0.5, 0.5] {
        let point = json!({"type": "point", "intensity": 0.1 * strength});
        scene.light(point, v(x, 0.3, 0.3), Vec3::NEG_Z);
        let cone = json!({"innerConeAngle": 0.1, "outerConeAngle": 0.4});
        let spot = json!({"type": "spot", "intensity": 2.0 * strength, "spot": cone});
        scene.light(spot, v(-x, 0.6, 0.2), v(0.3, -1.0, -0.2));
    }
}

/// Vertices without a normal choose among lamps in and out of the fog.
pub fn lamps_in_fog() -> World {
    let mut scene = foggy_room(json!({"phase": "rayleigh", "sigma_a": 0.1, "sigma_s": 0.6}));
    let bulb = scene.diffuse(0.4);
    let bulb = scene.emits(bulb, 6.0);
    for index in 0..6_u8 {
        let x = -0.75 + 0.3 * f32::from(index);
        scene.sphere(v(x, 0.5 - 0.2 * f32::from(index), 0.2), 0.1, bulb);
    }
    add_panel(&mut scene, 0.3, 4.0);
    pinhole(scene).load("lamps in fog")
}

/// Points all but touch what they choose points of.
pub fn sphere_on_the_floor() -> World {
    let mut scene = room(&[]);
    let bulb = scene.diffuse(0.4);
    let bulb = scene.emits(bulb, 1.0);
    scene.sphere(v(0.1, -0.4, -0.1), 0.6, bulb);
    pinhole(scene).load("large sphere light on the floor")
}

enum Ball {
    Diffuse,
    Glass,
    Mirror,
}

impl Ball {
    fn add_to(self, scene: &mut Document) -> usize {
        scene.material(match self {
            Ball::Diffuse => json!({"bsdf": "diffuse", "reflectance": 0.9}),
            Ball::Glass => json!({"bsdf": "dielectric", "ior": 1.5}),
            Ball::Mirror => json!({"bsdf": "conductor", "metal": "Al"}),
        })
    }
}

/// A coarse ball with the normals of a sphere: light and importance scatter differently there.
fn smooth_shaded(ball: Ball) -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.5, 4.0);
    let material = ball.add_to(&mut scene);
    scene.ball(v(-0.1, -0.2, 0.1), 0.5, 6, material);
    pinhole(scene).load("smooth-shaded ball")
}

/// Glass and diffuse balls on two grids, each of one mesh, large enough to be worth sharing; the
/// glass keeps a thin fog inside.
pub fn flock(of: Flock) -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.5, 4.0);
    let grid = |height: f32| -> Vec<Vec3> {
        let at = |index: usize| v((index % 4) as f32, height, (index / 4) as f32);
        (0..16).map(|index| (at(index) - v(1.5, 0.0, 1.5)) * v(0.45, 1.0, 0.45)).collect()
    };
    let diffuse = scene.diffuse(0.6);
    scene.flock(&grid(-0.6), 0.12, 32, diffuse, of);
    let glass = scene.material(json!({"bsdf": "dielectric", "ior": 1.4}));
    let fog = scene.medium(json!({"sigma_s": 1.0, "sigma_a": 0.2, "phase": "rayleigh"}));
    scene.around(Some(fog), None, |scene| scene.flock(&grid(0.0), 0.12, 32, glass, of));
    pinhole(scene).load("flock")
}

/// Normals that all lean the same way: what light paths forget to correct for does not average
/// out as it does over a ball.
fn tilted_normals(ball: Ball) -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.5, 4.0);
    let material = ball.add_to(&mut scene);
    scene.tilted_quad(
        v(0.0, -0.6, 0.0),
        v(0.0, 0.0, 0.9),
        v(0.9, 0.1, 0.0),
        v(0.7, 0.0, 0.3),
        material,
    );
    pinhole(scene).load("tilted normals")
}

/// The lower half of the room under water: radiance, unlike power, changes at its surface, and
/// nothing changes it back before the floor.
fn below_water() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.5, 4.0);
    let water = scene.material(json!({"bsdf": "dielectric", "ior": 1.33}));
    scene.quad(v(0.0, -0.2, 0.0), v(0.0, 0.0, 1.0), v(1.0, 0.0, 0.0), water);
    pinhole(scene).load("below water")
}

/// Reflections in turned planes of incidence, by metals and within glass, make S3.
fn metals_and_glass() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.5, 4.0);
    let gold = scene.material(json!({"bsdf": "conductor", "metal": "Au"}));
    let copper = scene.material(json!({"bsdf": "conductor", "metal": "Cu"}));
    let glass = scene.material(json!({"bsdf": "dielectric", "ior": 1.5}));
    scene.sphere(v(-0.5, -0.3, -0.2), 0.45, gold);
    scene.sphere(v(0.5, 0.1, -0.3), 0.4, copper);
    scene.sphere(v(0.2, -0.6, 0.5), 0.35, glass);
    pinhole(scene).load("two metals and glass")
}

/// Glass on the floor, water that absorbs up to it and over it, and a ball half in the water.
fn glass_and_water() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.5, 4.0);
    let [glass, water, ruby] =
        [1.5, 1.33, 1.76].map(|ior| scene.material(json!({"bsdf": "dielectric", "ior": ior})));
    let murk = scene.medium(json!({"phase": "isotropic", "sigma_a": 0.5, "sigma_s": 0.0}));
    scene.cuboid(v(-0.3, -0.7, 0.0), v(0.3, 0.3, 0.5), glass);
    scene.around(Some(murk), None, |scene| {
        scene.cuboid(v(0.3, -0.7, 0.1), v(0.3, 0.2, 0.4), water);
    });
    scene.sphere(v(0.3, -0.5, 0.2), 0.15, ruby);
    pinhole(scene).load("glass and water")
}

fn glass_and_point_light() -> World {
    let mut scene = room(&[]);
    scene.light(json!({"type": "point", "intensity": 2.0}), v(0.5, 0.7, 0.4), Vec3::NEG_Z);
    let glass = scene.material(json!({"bsdf": "dielectric", "ior": 1.5}));
    scene.sphere(v(0.1, -0.2, 0.1), 0.4, glass);
    pinhole(scene).load("glass and point light")
}

fn glass_under_environment() -> World {
    let mut scene = open_scene();
    let glass = scene.material(json!({"bsdf": "dielectric", "ior": 1.5}));
    let mirror = scene.material(json!({"bsdf": "conductor", "metal": "Al"}));
    scene.sphere(v(0.5, -0.5, 0.4), 0.35, glass);
    scene.ball(v(0.4, 0.5, -0.3), 0.35, 8, mirror);
    scene.perspective(v(0.2, 0.6, 3.6), Vec3::ZERO, 0.7, None);
    scene.load("glass under environment")
}

/// A polarizer, a retarder and a leaky polarizer in the light's way, mirrors beside it: light
/// paths carry polarization from one element to the next.
fn add_sheets(scene: &mut Document) {
    let first = scene.material(json!({"bsdf": "polarizer", "axis_deg": 20}));
    let plate = json!({"bsdf": "retarder", "axis_deg": 65, "retardance_deg": 100});
    let plate = scene.material(plate);
    let leaky = json!({"bsdf": "polarizer", "axis_deg": 100, "extinction_ratio": 15});
    let leaky = scene.material(leaky);
    for (y, material) in [(0.5, first), (0.4, plate), (0.3, leaky)] {
        scene.quad(v(0.1, y, 0.0), v(0.7, 0.1, 0.0), v(0.0, 0.05, -0.7), material);
    }
    let mirror = scene.material(json!({"bsdf": "conductor", "metal": "Au"}));
    scene.quad(v(-0.95, -0.2, 0.0), v(0.0, 0.6, 0.1), v(0.0, -0.1, 0.7), mirror);
}

fn sheets_under_panel() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.5, 6.0);
    add_sheets(&mut scene);
    pinhole(scene).load("sheets under panel")
}

fn sheets_under_point_light() -> World {
    let mut scene = room(&[]);
    scene.light(json!({"type": "point", "intensity": 3.0}), v(0.1, 0.8, 0.1), Vec3::NEG_Z);
    add_sheets(&mut scene);
    pinhole(scene).load("sheets under point light")
}

fn sheets_orthographic() -> World {
    let mut scene = open_scene();
    add_sheets(&mut scene);
    let glass = scene.material(json!({"bsdf": "dielectric", "ior": 1.5}));
    scene.sphere(v(0.5, -0.5, 0.4), 0.35, glass);
    scene.orthographic(v(0.3, 0.4, 3.0), Vec3::ZERO, 1.0);
    scene.load("sheets, orthographic")
}

/// Walls and air of a room that fog fills up to a handbreadth before the open front.
pub(super) fn foggy_room(fog: serde_json::Value) -> Document {
    let mut scene = room(&[]);
    let fog = scene.medium(fog);
    scene.fog(fog, |scene, null| {
        scene.cuboid(v(0.0, 0.0, -0.1), v(1.2, 1.2, 1.0), null);
    });
    scene
}

fn fog_about_point_light() -> World {
    let mut scene = foggy_room(json!({"phase": "isotropic", "sigma_a": 0.1, "sigma_s": 0.6}));
    scene.light(json!({"type": "point", "intensity": 1.0}), v(0.3, 0.2, 0.1), Vec3::NEG_Z);
    add_panel(&mut scene, 0.3, 4.0);
    pinhole(scene).load("fog about a point light")
}

fn fog_everywhere() -> World {
    let mut scene = room(&[]);
    let fog = scene.medium(json!({"phase": "hg", "g": -0.4, "sigma_a": 0.0, "sigma_s": 0.4}));
    scene.fill(fog);
    add_panel(&mut scene, 0.3, 8.0);
    let ball = scene.diffuse(0.8);
    scene.sphere(v(-0.4, -0.5, 0.1), 0.3, ball);
    scene.orthographic(v(0.3, 0.4, 3.0), Vec3::ZERO, 0.95);
    scene.load("fog fills the scene")
}

/// The medium where both are must not hang on which boundary was crossed first.
fn overlapping_fogs() -> World {
    let mut scene = room(&[FRONT]);
    let ceiling = scene.diffuse(0.2);
    let lamp = scene.emits(ceiling, 10.0);
    scene.quad(v(0.0, 0.95, 0.0), v(0.3, 0.0, 0.0), v(0.0, 0.0, 0.3), lamp);
    for (sigma_s, center, radius) in [(2.0, v(-0.2, 0.0, 0.0), 0.6), (5.0, v(0.3, 0.2, 0.1), 0.4)] {
        let fog = scene.medium(json!({"phase": "hg", "g": 0.3, "sigma_a": 0.2,
            "sigma_s": sigma_s}));
        scene.fog(fog, |scene, null| scene.sphere(center, radius, null));
    }
    pinhole(scene).load("overlapping-fogs")
}

/// What is outside of the glass hangs on where it is left.
fn glass_in_fog() -> World {
    let mut scene = room(&[FRONT]);
    let ceiling = scene.diffuse(0.2);
    let lamp = scene.emits(ceiling, 10.0);
    scene.quad(v(0.0, 0.95, 0.0), v(0.3, 0.0, 0.0), v(0.0, 0.0, 0.3), lamp);
    let fog = scene.medium(json!({"phase": "isotropic", "sigma_a": 0.5, "sigma_s": 2.0}));
    scene.fog(fog, |scene, null| scene.sphere(v(-0.3, 0.0, 0.0), 0.6, null));
    let glass = scene.material(json!({"bsdf": "dielectric", "ior": 1.5}));
    scene.sphere(v(0.3, -0.2, 0.1), 0.35, glass);
    pinhole(scene).load("glass-in-fog")
}

/// Anisotropic, in chromatic colors, and lit from infinity: paths enter through the boundary.
fn fog_under_the_sky() -> World {
    let mut scene = open_scene();
    let sun = json!({"type": "directional", "intensity": 2.0});
    scene.light(sun, v(5.0, 5.0, 5.0), v(-0.4, -1.0, -0.5));
    let fog = scene.medium(json!({"phase": "hg", "g": [0.6, 0.3, 0.0],
        "sigma_a": [0.3, 0.0, 0.1], "sigma_s": [0.5, 2.0, 4.0]}));
    scene.fog(fog, |scene, null| {
        scene.cuboid(v(0.4, -0.2, 0.3), v(0.4, 0.5, 0.3), null);
    });
    scene.perspective(v(0.2, 0.6, 3.6), Vec3::ZERO, 0.7, Some([0.15, 3.2]));
    scene.load("fog under the sky")
}

fn camera_in_thin_air() -> World {
    let mut scene = foggy_room(json!({"phase": "rayleigh", "sigma_a": 0, "sigma_s": 0.7}));
    add_panel(&mut scene, 0.3, 8.0);
    scene.perspective(v(0.2, 0.1, 0.8), v(0.0, 0.1, -0.5), 1.2, None);
    scene.load("camera in thin air")
}

fn stained_fog_in_glass() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.5, 4.0);
    let fog = scene.medium(json!({"phase": "hg", "g": [0.7, 0.5, 0.2],
        "sigma_a": [0.2, 0.0, 0.5], "sigma_s": [1.0, 3.0, 6.0]}));
    let glass = scene.material(json!({"bsdf": "dielectric", "ior": 1.5}));
    scene.around(Some(fog), None, |scene| scene.sphere(v(0.1, -0.3, 0.2), 0.5, glass));
    pinhole(scene).load("stained fog in glass")
}

/// Light polarized by a sheet, scattered by dipoles that depolarize a fifth, seen in part through
/// another sheet.
fn thin_air_between_polarizers() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.5, 6.0);
    let air = json!({"phase": "rayleigh", "depolarization": 0.2, "sigma_a": 0, "sigma_s": 2});
    let air = scene.medium(air);
    scene.fog(air, |scene, null| {
        scene.cuboid(v(0.0, -0.3, 0.1), v(0.6, 0.4, 0.5), null);
    });
    let first = scene.material(json!({"bsdf": "polarizer", "axis_deg": 20}));
    scene.quad(v(0.1, 0.5, 0.0), v(0.7, 0.1, 0.0), v(0.0, 0.05, -0.7), first);
    let second = scene.material(json!({"bsdf": "polarizer", "axis_deg": 70}));
    scene.quad(v(-0.4, -0.2, 0.9), v(0.4, 0.0, 0.1), v(0.0, 0.5, 0.0), second);
    pinhole(scene).load("thin air between polarizers")
}

/// Spheres as large as the wavelength turn linear polarization into circular, and so does gold.
fn milk_and_mirror() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.5, 4.0);
    let milk = scene.medium(json!({"phase": "mie", "sigma_a": 0.05, "sigma_s": [1.5, 2.0, 2.5],
        "milk": {"fat_percent": 0.1, "protein_percent": 3.4}}));
    scene.fog(milk, |scene, null| {
        scene.cuboid(v(0.2, -0.4, 0.2), v(0.6, 0.5, 0.4), null);
    });
    let gold = scene.material(json!({"bsdf": "conductor", "metal": "Au"}));
    scene.quad(v(-0.95, -0.2, 0.0), v(0.0, 0.6, 0.1), v(0.0, -0.1, 0.7), gold);
    pinhole(scene).load("milk and a mirror")
}

/// A wall of glass between air and milk.
fn bottle_of_milk() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.6, 4.0);
    let milk = scene.medium(json!({"phase": "mie", "sigma_a": 0.0, "sigma_s": [3.0, 4.0, 5.0],
        "milk": {"fat_percent": 3.5, "protein_percent": 3.4}}));
    let outer = scene.material(json!({"bsdf": "dielectric", "ior": 1.5}));
    let inner = json!({"bsdf": "dielectric", "ior": 1.34, "exterior_ior": 1.5});
    let inner = scene.material(inner);
    scene.sphere(v(0.1, -0.2, 0.2), 0.6, outer);
    scene.around(Some(milk), None, |scene| scene.sphere(v(0.1, -0.2, 0.2), 0.5, inner));
    pinhole(scene).load("bottle of milk")
}

/// A far panel, two sheets in between, and a floor that light reaches only through both. The
/// second axis is at `axis_deg` to the first.
pub fn two_sheets(axis_deg: f32) -> World {
    let mut scene = Document::default();
    let panel = scene.material(json!({"bsdf": "absorber"}));
    let panel = scene.emits(panel, 100.0);
    scene.quad(v(0.0, 4.0, 0.0), v(0.2, 0.0, 0.0), v(0.0, 0.0, 0.2), panel);
    let first = scene.material(json!({"bsdf": "polarizer", "axis_deg": 0}));
    let second = scene.material(json!({"bsdf": "polarizer", "axis_deg": axis_deg}));
    scene.quad(v(0.0, 2.0, 0.0), v(1.0, 0.0, 0.0), v(0.0, 0.0, -1.0), first);
    scene.quad(v(0.0, 1.9, 0.0), v(1.0, 0.0, 0.0), v(0.0, 0.0, -1.0), second);
    let floor = scene.diffuse(0.8);
    scene.quad(Vec3::ZERO, v(0.3, 0.0, 0.0), v(0.0, 0.0, -0.3), floor);
    // Looks under the sheets.
    scene.perspective(v(0.0, 0.8, 2.0), Vec3::ZERO, 0.2, None);
    scene.load("two sheets")
}

/// A room of depolarizers only.
pub fn depolarizers() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.3, 8.0);
    let ball = scene.diffuse(0.8);
    scene.ball(v(-0.3, -0.4, 0.1), 0.4, 6, ball);
    scene.light(json!({"type": "point", "intensity": 2.0}), v(0.3, 0.2, 0.1), Vec3::NEG_Z);
    pinhole(scene).load("depolarizers")
}
