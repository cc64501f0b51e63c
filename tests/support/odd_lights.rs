//! Lights in places that nobody thought of: tiny, huge, touching, stacked, inside out, in media and
//! behind sheets.

use glam::{DQuat, DVec3, Vec3};
use serde_json::{Value, json};
use sunstone::internals::scene::World;
use sunstone::world::ClearSky;

use super::gltf::Document;
use super::luminaires;
use super::projectors;
use super::scenes::{CEILING, Named, pinhole, room, v};
use super::skies::{noise, openexr};

/// All of them.
pub const ODD_LIGHTS: [Named; 10] = [
    ("a projector that touches the wall behind it", touching_projector),
    ("projectors and a luminaire in one place", stacked),
    ("a projector through crossed sheets", projector_behind_sheets),
    ("a luminaire and a projector in fog", in_fog),
    ("a projector of nearly half of all directions", wide_projector),
    ("a luminaire in a bubble in glass", in_a_bubble),
    ("hot metal inside out about a lamp", inside_out),
    ("a tiny hot ball and a polarized screen that touch", touching_lamps),
    ("a pictured sky through sheets", sky_behind_sheets),
    ("a clear sky and a sun through a pane", clear_through_a_pane),
];

fn slide(half_angle: f64, intensity: f64) -> Value {
    projectors::light(&projectors::file(17, [4, 3]), half_angle, intensity)
}

fn lobe(intensity: f64) -> Value {
    let file = luminaires::file(&[0.0, 60.0, 180.0], &[0.0, 90.0], &[9.0, 4.0, 0.0, 9.0, 1.0, 2.0]);
    luminaires::light(&file, intensity)
}

fn balls(scene: &mut Document) {
    let gold = scene.material(json!({"bsdf": "conductor", "metal": "Au"}));
    scene.sphere(v(-0.5, -0.6, -0.2), 0.4, gold);
    let plastic = scene.material(json!({"bsdf": "plastic", "alpha": 0.3, "reflectance": 0.6}));
    scene.sphere(v(0.4, -0.65, 0.1), 0.35, plastic);
}

fn touching_projector() -> World {
    let mut scene = room(&[CEILING]);
    balls(&mut scene);
    scene.light(slide(0.6, 3.0), v(-0.999_999, 0.2, 0.0), v(1.0, -0.4, 0.1));
    pinhole(scene).load("touching projector")
}

fn stacked() -> World {
    let mut scene = room(&[CEILING]);
    balls(&mut scene);
    for (half_angle, towards) in [(0.3, v(-0.4, -1.0, 0.0)), (0.7, v(0.4, -1.0, 0.2))] {
        scene.light(slide(half_angle, 1.0), Vec3::Y * 0.5, towards);
    }
    scene.light(lobe(0.2), Vec3::Y * 0.5, v(0.0, -1.0, 0.3));
    pinhole(scene).load("stacked")
}

fn projector_behind_sheets() -> World {
    let mut scene = room(&[CEILING]);
    balls(&mut scene);
    let mut light = slide(0.6, 6.0);
    light["extensions"]["SUNSTONE_polarization"]["stokes"] = json!([0.5, 0.0, 0.7]);
    scene.light(light, Vec3::Y * 0.9, v(0.1, -1.0, 0.1));
    for (height, keys) in [
        (0.6, json!({"bsdf": "polarizer", "axis_deg": 20})),
        (0.5, json!({"bsdf": "retarder", "axis_deg": 65, "retardance_deg": 100})),
        (0.4, json!({"bsdf": "polarizer", "axis_deg": 70})),
    ] {
        let sheet = scene.material(keys);
        scene.quad(Vec3::Y * height, Vec3::X * 0.5, Vec3::Z * 0.4, sheet);
    }
    pinhole(scene).load("projector behind sheets")
}

fn in_fog() -> World {
    let mut scene = room(&[CEILING]);
    scene.light(slide(0.5, 2.0), v(0.1, 0.3, 0.1), v(-0.3, -1.0, 0.0));
    scene.light(lobe(0.2), v(-0.3, -0.2, 0.2), v(1.0, 0.2, 0.3));
    let fog = json!({"phase": "rayleigh", "sigma_a": 0.05, "sigma_s": 0.8});
    let fog = scene.medium(fog);
    scene.fog(fog, |scene, null| scene.cuboid(Vec3::NEG_Y * 0.2, Vec3::splat(0.7), null));
    pinhole(scene).load("in fog")
}

fn wide_projector() -> World {
    let mut scene = room(&[CEILING]);
    balls(&mut scene);
    scene.light(slide(1.5, 0.05), v(0.2, 0.8, 0.2), v(0.0, -1.0, 0.1));
    pinhole(scene).load("wide projector")
}

fn in_a_bubble() -> World {
    let mut scene = room(&[CEILING]);
    scene.light(lobe(0.2), v(0.1, 0.0, 0.1), v(0.2, -1.0, 0.0));
    let pane = scene.material(json!({"bsdf": "thin_dielectric", "ior": 1.5}));
    scene.sphere(v(0.1, 0.0, 0.1), 0.2, pane);
    pinhole(scene).load("in a bubble")
}

fn inside_out() -> World {
    let mut scene = room(&[CEILING]);
    balls(&mut scene);
    let hot = json!({"bsdf": "conductor", "metal": "Al", "emission": 4.0, "incandescent": true});
    let hot = scene.material(hot);
    let hot = scene.two_sided(hot);
    // Its fronts face each other.
    scene.quad(v(-0.2, 0.5, 0.0), v(0.0, 0.2, 0.0), v(0.0, 0.0, 0.3), hot);
    scene.quad(v(0.2, 0.5, 0.0), v(0.0, 0.0, 0.3), v(0.0, 0.2, 0.0), hot);
    scene.light(lobe(0.05), v(0.0, 0.5, 0.0), v(0.1, -1.0, 0.0));
    pinhole(scene).load("inside out")
}

fn touching_lamps() -> World {
    let mut scene = room(&[CEILING]);
    balls(&mut scene);
    let screen = json!({"bsdf": "absorber", "emission": 3.0, "stokes": [-1.0, 0.0, 0.0]});
    let screen = scene.material(screen);
    scene.quad(v(0.0, 0.9, 0.0), Vec3::X * 0.4, Vec3::Z * 0.4, screen);
    let hot = json!({"bsdf": "conductor", "metal": "Au", "emission": 900.0, "incandescent": true});
    let hot = scene.material(hot);
    scene.sphere(v(0.1, 0.88, 0.1), 0.02, hot);
    pinhole(scene).load("touching lamps")
}

fn sky_behind_sheets() -> World {
    let mut scene = room(&[CEILING]);
    balls(&mut scene);
    for (height, keys) in [
        (0.9, json!({"bsdf": "polarizer", "axis_deg": 20})),
        (0.8, json!({"bsdf": "retarder", "axis_deg": 65, "retardance_deg": 100})),
    ] {
        let sheet = scene.material(keys);
        scene.quad(Vec3::Y * height, Vec3::X * 0.9, Vec3::Z * 0.9, sheet);
    }
    let mut world = pinhole(scene).load("sky behind sheets");
    let texels = noise(5, [12, 6], 40.0);
    let bytes = openexr([12, 6], |column, row| texels[12 * row + column]);
    world.set_environment_map(&bytes, [1.0; 3], DQuat::from_rotation_x(0.4)).expect("sound");
    world
}

fn clear_through_a_pane() -> World {
    let mut scene = room(&[CEILING]);
    balls(&mut scene);
    let pane = scene.material(json!({"bsdf": "thin_dielectric", "ior": 1.5}));
    scene.quad(v(0.0, 0.9, 0.0), Vec3::X, Vec3::Z, pane);
    let sun = json!({"type": "directional", "intensity": 2.0,
        "extensions": {"SUNSTONE_polarization": {"angular_diameter_deg": 20.0}}});
    scene.light(sun, Vec3::Y, v(0.3, -1.0, -0.2));
    let mut world = pinhole(scene).load("clear through a pane");
    let sun = DVec3::new(-0.3, 1.0, 0.2);
    world.set_clear_sky(ClearSky { sun, turbidity: 3.0, max_degree: 0.8 }, 0.1).expect("sound");
    world
}
