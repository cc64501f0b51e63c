//! Scenes of blends.

use glam::Vec3;
use serde_json::json;
use sunstone::internals::scene::World;
use sunstone::world::{Bsdf, Filter, Material, Paint, Parameter, Reads, Textures};

use super::painted::{add, noise, paint, panel, quad as painted_quad, stage, texture};
use super::scenes::{CEILING, Named, add_panel, pinhole, room, v};

/// All of them.
pub const BLENDS: [Named; 3] =
    [("blends", blends), ("blends in fog", blends_in_fog), ("painted blends", painted_blends)];

/// Metal, plastic and matte mixed, a blend of a blend, one with the normals of a sphere.
fn blends() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.4, 5.0);
    let gold = json!({"bsdf": "rough_conductor", "metal": "Au", "alpha": 0.3});
    let gold = scene.material(gold);
    let copper = json!({"bsdf": "rough_conductor", "metal": "Cu", "roughness": 0.7,
        "distribution": "beckmann"});
    let copper = scene.material(copper);
    let red = scene.material(json!({"bsdf": "plastic", "reflectance": [0.7, 0.2, 0.1],
        "alpha": 0.4}));
    let gray = scene.diffuse(0.5);
    let of = |first: usize, second: usize, weight: f32| {
        json!({"bsdf": "blend", "first": first, "second": second,
            "weight": weight})
    };
    let dusty = scene.material(of(gold, gray, 0.4));
    let worn = scene.material(of(red, copper, 0.6));
    let all = scene.material(of(worn, dusty, 0.3));
    let all = scene.two_sided(all);
    let mirror = scene.material(json!({"bsdf": "conductor", "metal": "Al"}));
    scene.sphere(v(-0.5, -0.4, -0.2), 0.45, dusty);
    scene.ball(v(0.4, -0.2, -0.2), 0.4, 8, worn);
    scene.quad(v(0.0, -0.7, 0.3), v(0.7, 0.0, 0.1), v(0.0, 0.1, -0.4), all);
    scene.sphere(v(0.1, 0.4, -0.6), 0.3, mirror);
    pinhole(scene).load("blends")
}

/// What light goes through in part, in fog: a rough pane, of which some is metal, and a shell.
fn blends_in_fog() -> World {
    let mut scene = room(&[CEILING]);
    let thin = scene.medium(json!({"phase": "hg", "g": 0.3, "sigma_a": 0.1, "sigma_s": 0.2}));
    scene.fill(thin);
    let air = json!({"phase": "rayleigh", "sigma_a": [0.2, 0.0, 0.5], "sigma_s": [1.0, 3.0, 2.0]});
    let air = scene.medium(air);
    let pane = scene.plain(
        json!({"metallicFactor": 0.0, "roughnessFactor": 0.6}),
        json!({"KHR_materials_transmission": {"transmissionFactor": 1.0}}),
    );
    let metal = scene.material(json!({"bsdf": "rough_conductor", "metal": "Al", "alpha": 0.4}));
    let gray = scene.diffuse(0.6);
    let of = |second: usize, weight: f32| {
        json!({"bsdf": "blend", "first": pane, "second": second,
            "weight": weight})
    };
    let mesh = scene.material(of(metal, 0.3));
    let mesh = scene.two_sided(mesh);
    let dusty = scene.material(of(gray, 0.4));
    scene.around(Some(air), Some(thin), |scene| scene.sphere(v(0.3, -0.3, 0.2), 0.45, dusty));
    scene.quad(v(-0.5, 0.0, 0.2), v(0.4, 0.0, 0.2), v(0.0, 0.5, 0.0), mesh);
    scene.light(json!({"type": "point", "intensity": 2.0}), v(-0.5, 0.6, -0.4), Vec3::NEG_Z);
    scene.light(json!({"type": "point", "intensity": 0.5}), v(0.4, -0.2, 0.3), Vec3::NEG_Z);
    pinhole(scene).load("blends in fog")
}

/// Of parts and a weight by pictures.
fn painted_blends() -> World {
    let mut world = stage(Textures::default());
    let number = |seed, reads| {
        let texture = Some(texture(noise(seed, 5), Filter::Linear));
        Paint { factor: [1.0; 3], texture, reads, by_vertices: false }
    };
    let color = paint([1.0, 0.9, 0.8], texture(noise(42, 4), Filter::Linear));
    let of_matte =
        Textures { parameters: vec![(Parameter::Reflectance, color)], ..Textures::default() };
    let textures = Textures {
        parameters: vec![(Parameter::Weight, number(43, Reads::Red))],
        parts: vec![of_matte, Textures::default()],
        ..Textures::default()
    };
    let metal = Bsdf::rough_metal("Cu", 0.35).expect("it is tabulated");
    let bsdf = Bsdf::blend(Bsdf::diffuse(0.8), metal, 1.0);
    let plate = painted_quad(v(0.0, -0.3, 0.2), v(0.9, 0.0, 0.0), v(0.0, 0.4, -0.6));
    add(&mut world, "plate", (Material::from(bsdf).two_sided(), textures), plate);
    add(&mut world, "lamp", (Material::emitter(8.0), Textures::default()), panel(0.5));
    world
}
