//! Scenes of rough surfaces.

use glam::Vec3;
use serde_json::json;
use sunstone::internals::scene::World;

use super::scenes::{CEILING, add_panel, pinhole, room, v};

/// Rough metals of both distributions about each other and a smooth one, one with the normals of a
/// sphere: light is polarized in turned planes, and vertices of all sorts are connected.
pub fn metals() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.4, 5.0);
    let gold = json!({"bsdf": "rough_conductor", "metal": "Au", "alpha": 0.2});
    let gold = scene.material(gold);
    let copper = json!({"bsdf": "rough_conductor", "metal": "Cu", "roughness": 0.7,
        "distribution": "beckmann"});
    let copper = scene.material(copper);
    let single = json!({"bsdf": "rough_conductor", "metal": "Al", "alpha": 0.5,
        "multiple_scattering": false});
    let single = scene.material(single);
    let single = scene.two_sided(single);
    let mirror = scene.material(json!({"bsdf": "conductor", "metal": "Al"}));
    scene.sphere(v(-0.5, -0.4, -0.2), 0.45, gold);
    scene.ball(v(0.4, -0.2, -0.2), 0.4, 8, copper);
    scene.quad(v(0.0, -0.7, 0.3), v(0.7, 0.0, 0.1), v(0.0, 0.1, -0.4), single);
    scene.sphere(v(0.1, 0.4, -0.6), 0.3, mirror);
    pinhole(scene).load("rough metals")
}

/// Plastics of all sorts about a polarizer: what leaves them was refracted in two planes.
pub fn plastics() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.4, 5.0);
    let mut plastic = |mut keys: serde_json::Value| {
        keys["bsdf"] = json!("plastic");
        scene.material(keys)
    };
    let white = plastic(json!({"reflectance": 0.9, "alpha": 0.3, "ior": 1.6}));
    let red = plastic(json!({"reflectance": [0.7, 0.2, 0.1], "roughness": 0.8,
        "distribution": "beckmann", "internal_reflection": "lost", "specular": 0.5}));
    let dense = plastic(json!({"reflectance": [0.2, 0.4, 0.8], "alpha": 0.25, "ior": 2.5,
        "exterior_ior": 1.2, "internal_reflection": "linear"}));
    let dense = scene.two_sided(dense);
    let sheet = scene.material(json!({"bsdf": "polarizer", "axis_deg": 30}));
    scene.sphere(v(-0.5, -0.4, -0.2), 0.45, white);
    scene.ball(v(0.4, -0.2, -0.2), 0.4, 8, red);
    scene.quad(v(0.0, -0.7, 0.3), v(0.7, 0.0, 0.1), v(0.0, 0.1, -0.4), dense);
    scene.quad(v(-0.4, 0.4, 0.5), v(0.3, 0.0, 0.0), v(0.0, 0.3, 0.0), sheet);
    scene.sphere(v(0.1, 0.4, -0.6), 0.3, dense);
    pinhole(scene).load("plastics")
}

/// glTF's materials of partial metal and of plain coats, lit by points and a sky.
pub fn coats() -> World {
    let mut scene = room(&[CEILING]);
    scene.environment(0.5);
    scene.light(json!({"type": "point", "intensity": 1.5}), v(0.3, 0.5, 0.3), Vec3::NEG_Z);
    let plain = scene.metallic_roughness([0.8, 0.3, 0.1], 0.0, 0.5);
    let mixed = scene.metallic_roughness([0.9, 0.8, 0.4], 0.6, 0.6);
    let floor = scene.metallic_roughness([0.1, 0.1, 0.1], 0.0, 0.3);
    scene.sphere(v(-0.4, -0.5, 0.0), 0.4, plain);
    scene.ball(v(0.5, -0.4, 0.1), 0.4, 8, mixed);
    scene.quad(v(0.0, -0.95, 0.0), v(0.0, 0.0, 0.9), v(0.9, 0.0, 0.0), floor);
    scene.orthographic(v(0.3, 0.9, 3.0), Vec3::ZERO, 1.0);
    scene.load("rough coats")
}

/// Rough glass, narrow and wide, with the normals of a sphere and its own; a block of it that
/// touches smooth water full of murk, with a ball in both.
pub fn glasses() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.5, 4.0);
    let of = |ior: f32, alpha: f32| json!({"bsdf": "rough_dielectric", "ior": ior, "alpha": alpha});
    let [narrow, wide, block] =
        [(1.5, 0.15), (1.4, 0.7), (1.6, 0.4)].map(|(ior, alpha)| scene.material(of(ior, alpha)));
    let beckmann = json!({"bsdf": "rough_dielectric", "ior": 1.76, "roughness": 0.8,
        "distribution": "beckmann", "multiple_scattering": false});
    let beckmann = scene.material(beckmann);
    let water = scene.material(json!({"bsdf": "dielectric", "ior": 1.33}));
    let murk = scene.medium(json!({"phase": "isotropic", "sigma_a": 0.5, "sigma_s": 0.0}));
    scene.sphere(v(-0.55, 0.2, 0.0), 0.35, narrow);
    scene.ball(v(0.4, 0.25, -0.2), 0.35, 8, wide);
    scene.cuboid(v(-0.3, -0.7, 0.0), v(0.3, 0.3, 0.5), block);
    scene.around(Some(murk), None, |scene| {
        scene.cuboid(v(0.3, -0.7, 0.1), v(0.3, 0.2, 0.4), water);
    });
    scene.sphere(v(0.0, -0.55, 0.2), 0.15, beckmann);
    pinhole(scene).load("rough glasses")
}

/// Rough glass full of fog that polarizes, in fog, lit by points inside and outside.
pub fn glass_and_fog() -> World {
    let mut scene = room(&[CEILING]);
    let thin = scene.medium(json!({"phase": "hg", "g": 0.3, "sigma_a": 0.1, "sigma_s": 0.2}));
    scene.fill(thin);
    let air = json!({"phase": "rayleigh", "sigma_a": [0.2, 0.0, 0.5], "sigma_s": [1.0, 3.0, 2.0]});
    let air = scene.medium(air);
    let glass = json!({"bsdf": "rough_dielectric", "ior": 1.5, "alpha": 0.5});
    let glass = scene.material(glass);
    scene.around(Some(air), Some(thin), |scene| scene.sphere(v(0.1, -0.3, 0.2), 0.5, glass));
    scene.light(json!({"type": "point", "intensity": 2.0}), v(-0.5, 0.6, 0.4), Vec3::NEG_Z);
    scene.light(json!({"type": "point", "intensity": 0.5}), v(0.2, -0.2, 0.3), Vec3::NEG_Z);
    pinhole(scene).load("rough glass and fog")
}
