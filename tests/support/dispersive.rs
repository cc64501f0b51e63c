//! Small scenes with glass that disperses light more than any does: touching, nested, in media,
//! about the camera, lamps and metals, and as panes.

use glam::Vec3;
use serde_json::{Value, json};
use sunstone::internals::scene::World;

use super::gltf::Document;
use super::scenes::{Named, add_panel, pinhole, room, v};

/// All of them.
pub const DISPERSIVE: [Named; 9] = [
    ("flint before a point light", flint_and_point_light),
    ("caustic of flint under a lamp", caustic),
    ("glasses that touch and overlap", in_contact),
    ("flint in fog", in_fog),
    ("fog in flint", around_fog),
    ("camera in flint", about_camera),
    ("lamps in flint", about_lamps),
    ("metals in water", metals_in_water),
    ("panes and a polarizer", panes),
];

/// An index that falls from violet to red.
fn index(least: f32, most: f32) -> Value {
    let at = |share: f32| most + (least - most) * share;
    json!({"nm": [360, 450, 560, 830], "value": [at(0.0), at(0.4), at(0.8), at(1.0)]})
}

fn glass(scene: &mut Document, least: f32, most: f32) -> usize {
    scene.material(json!({"bsdf": "dielectric", "ior": index(least, most)}))
}

fn flint_and_point_light() -> World {
    let mut scene = room(&[]);
    scene.light(json!({"type": "point", "intensity": 2.0}), v(0.5, 0.7, 0.4), Vec3::NEG_Z);
    let flint = glass(&mut scene, 1.5, 1.9);
    scene.sphere(v(0.1, -0.2, 0.1), 0.4, flint);
    pinhole(scene).load("flint and point light")
}

/// Light comes to the floor by two faces, or by a ball in which it may be totally reflected at some
/// wavelengths and not at others. The bulb is as large as paths from the sensor need to find it so
/// often that their spread tells their error.
fn caustic() -> World {
    let mut scene = room(&[]);
    let bulb = scene.diffuse(0.4);
    let bulb = scene.emits(bulb, 8.0);
    scene.sphere(v(0.3, 0.72, 0.2), 0.24, bulb);
    let flint = glass(&mut scene, 1.45, 1.95);
    scene.sphere(v(0.1, -0.4, 0.1), 0.35, flint);
    scene.cuboid(v(-0.6, -0.3, 0.0), v(0.15, 0.3, 0.2), flint);
    pinhole(scene).load("caustic of flint")
}

fn in_contact() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.5, 4.0);
    let [flint, water] = [(1.5, 1.9), (1.25, 1.5)].map(|(a, b)| glass(&mut scene, a, b));
    let plain = scene.material(json!({"bsdf": "dielectric", "ior": 1.5}));
    let murk = scene.medium(json!({"phase": "isotropic", "sigma_a": 0.5, "sigma_s": 0.0}));
    scene.cuboid(v(-0.3, -0.7, 0.0), v(0.3, 0.3, 0.5), flint);
    scene.around(Some(murk), None, |scene| {
        scene.cuboid(v(0.3, -0.7, 0.1), v(0.3, 0.2, 0.4), water);
    });
    scene.sphere(v(0.3, -0.5, 0.2), 0.15, plain);
    scene.sphere(v(-0.3, -0.6, 0.1), 0.15, flint);
    pinhole(scene).load("glasses that touch")
}

fn in_fog() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.5, 4.0);
    let fog =
        scene.medium(json!({"phase": "rayleigh", "sigma_a": 0.1, "sigma_s": [0.3, 0.6, 1.2]}));
    scene.fog(fog, |scene, null| scene.cuboid(v(0.0, 0.0, -0.1), v(1.2, 1.2, 1.0), null));
    let flint = glass(&mut scene, 1.5, 1.9);
    scene.around(None, Some(fog), |scene| scene.sphere(v(0.1, -0.3, 0.2), 0.4, flint));
    pinhole(scene).load("flint in fog")
}

fn around_fog() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.5, 4.0);
    let drops = json!({"kind": "monodisperse", "radius_um": 0.2});
    let beads = json!({"eta": index(1.55, 1.65), "volume_fraction": 1e-6, "distribution": drops});
    let fog = json!({"phase": "mie", "host": {"eta": index(1.5, 1.9)}, "particles": [beads]});
    let fog = scene.medium(fog);
    let flint = glass(&mut scene, 1.5, 1.9);
    scene.around(Some(fog), None, |scene| {
        scene.cuboid(v(0.0, -0.3, 0.1), v(0.4, 0.4, 0.3), flint);
    });
    pinhole(scene).load("fog in flint")
}

/// The camera looks out of glass, from some directions by total reflection.
fn about_camera() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.5, 4.0);
    let flint = glass(&mut scene, 1.4, 1.8);
    scene.cuboid(v(0.0, 0.0, 0.6), v(0.5, 0.4, 0.3), flint);
    scene.perspective(v(0.05, 0.1, 0.7), Vec3::ZERO, 1.4, None);
    scene.load("camera in flint")
}

fn about_lamps() -> World {
    let mut scene = room(&[]);
    let flint = glass(&mut scene, 1.4, 1.8);
    scene.sphere(v(-0.4, 0.2, 0.1), 0.4, flint);
    let bulb = scene.diffuse(0.4);
    let bulb = scene.emits(bulb, 20.0);
    scene.sphere(v(-0.4, 0.2, 0.1), 0.2, bulb);
    scene.cuboid(v(0.5, 0.1, 0.0), v(0.2, 0.3, 0.2), flint);
    scene.light(json!({"type": "point", "intensity": 1.0}), v(0.5, 0.15, 0.05), Vec3::NEG_Z);
    pinhole(scene).load("lamps in flint")
}

fn metals_in_water() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.5, 6.0);
    let [gold, copper] =
        ["Au", "Cu"].map(|metal| scene.material(json!({"bsdf": "conductor", "metal": metal})));
    let water = glass(&mut scene, 1.25, 1.5);
    scene.cuboid(v(0.0, -0.5, 0.0), v(0.9, 0.45, 0.9), water);
    scene.sphere(v(-0.3, -0.5, 0.0), 0.3, gold);
    scene.sphere(v(0.4, -0.4, 0.2), 0.3, copper);
    pinhole(scene).load("metals in water")
}

/// Of which light comes to flint, too.
fn panes() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.4, 6.0);
    let body = json!({"bsdf": "thin_dielectric", "ior": index(1.4, 2.2)});
    let [pane, tilted] = [(); 2].map(|()| scene.material(body.clone()));
    let polarizer = scene.material(json!({"bsdf": "polarizer", "axis_deg": 35}));
    scene.quad(v(0.1, 0.6, 0.0), v(0.85, 0.05, 0.0), v(0.0, 0.05, -0.9), pane);
    scene.quad(v(-0.2, -0.2, 0.3), v(0.5, 0.0, 0.5), v(0.0, 0.6, 0.0), tilted);
    scene.quad(v(0.0, 0.0, 1.6), v(1.3, 0.0, 0.2), v(0.0, 1.3, -0.1), polarizer);
    let matte = scene.diffuse(0.7);
    scene.sphere(v(0.2, -0.6, 0.0), 0.3, matte);
    let flint = glass(&mut scene, 1.5, 1.9);
    scene.sphere(v(-0.5, -0.65, 0.4), 0.25, flint);
    pinhole(scene).load("panes and a polarizer")
}
