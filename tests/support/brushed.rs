//! Scenes of facets that are stretched along a direction.

use serde_json::json;
use sunstone::internals::scene::World;
use sunstone::world::{Along, Bsdf, Filter, Grain, Material, Paint, Parameter, Reads, Textures};

use super::painted::{add, noise, paint, panel, quad as painted_quad, stage, texture};
use super::scenes::{Named, add_panel, pinhole, room, v};

/// All of them.
pub const BRUSHED: [Named; 2] = [("brushed", brushed), ("painted brushed", painted_brushed)];

/// Metal on a sphere, with the normals of one, and flat; glass; a blend of some.
fn brushed() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.4, 5.0);
    let gold = json!({"bsdf": "rough_conductor", "metal": "Au", "alpha_u": 0.5, "alpha_v": 0.2});
    let gold = scene.material(gold);
    let copper = json!({"bsdf": "rough_conductor", "metal": "Cu", "alpha_u": 0.25, "alpha_v": 0.8,
        "axis_deg": 30, "distribution": "beckmann"});
    let copper = scene.material(copper);
    let glass = json!({"bsdf": "rough_dielectric", "ior": 1.5, "alpha_u": 0.3, "alpha_v": 0.7});
    let glass = scene.material(glass);
    let gray = scene.diffuse(0.5);
    let dusty = json!({"bsdf": "blend", "first": copper, "second": gray, "weight": 0.3});
    let dusty = scene.material(dusty);
    let dusty = scene.two_sided(dusty);
    scene.sphere(v(-0.5, -0.4, -0.2), 0.45, gold);
    scene.ball(v(0.4, -0.2, -0.2), 0.4, 8, copper);
    scene.quad(v(0.0, -0.7, 0.3), v(0.7, 0.0, 0.1), v(0.0, 0.1, -0.4), dusty);
    scene.sphere(v(0.1, 0.4, -0.4), 0.3, glass);
    pinhole(scene).load("brushed")
}

/// glTF's, with its direction, strength and color by pictures.
fn painted_brushed() -> World {
    let mut world = stage(Textures::default());
    let number = |seed, reads| {
        let texture = Some(texture(noise(seed, 5), Filter::Linear));
        Paint { factor: [1.0; 3], texture, reads, by_vertices: false }
    };
    let color = paint([1.0, 0.9, 0.8], texture(noise(52, 4), Filter::Linear));
    let parameters = vec![
        (Parameter::BaseColor, color),
        (Parameter::Strength, number(53, Reads::Blue)),
        (Parameter::GrainRight, number(54, Reads::Red)),
        (Parameter::GrainUp, number(54, Reads::Green)),
    ];
    let of = Bsdf::MetallicRoughness {
        base_color: [1.0, 0.9, 0.8].into(),
        metallic: 0.7,
        alpha: 0.25,
        ior: 1.5,
        specular: 1.0,
    };
    let bsdf = Bsdf::brushed(of, Grain::new(Along::Strength(1.0)));
    let textures = Textures { parameters, ..Textures::default() };
    let plate = painted_quad(v(0.0, -0.3, 0.2), v(0.9, 0.0, 0.0), v(0.0, 0.4, -0.6));
    add(&mut world, "plate", (Material::from(bsdf).two_sided(), textures), plate);
    add(&mut world, "lamp", (Material::emitter(8.0), Textures::default()), panel(0.5));
    world
}
