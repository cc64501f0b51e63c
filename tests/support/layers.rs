//! Scenes of what glTF has beyond metallic-roughness: walls, clear coats, cloth.

use glam::Vec3;
use serde_json::json;
use sunstone::internals::scene::World;
use sunstone::world::{Bsdf, Filter, Layers, Material, Paint, Parameter, Reads, Textures};

use super::painted::{add, noise, paint, panel, quad as painted_quad, stage, texture};
use super::scenes::{CEILING, Named, add_panel, pinhole, room, v};

/// All of them.
pub const LAYERED: [Named; 4] = [
    ("coats and cloth", coats_and_cloth),
    ("walls", walls),
    ("walls in fog", walls_in_fog),
    ("painted layers", painted_layers),
];

/// Clear coats on metal and matte, one with the normals of a sphere; cloth over and under.
fn coats_and_cloth() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.4, 5.0);
    let lacquer = scene.plain(
        json!({"baseColorFactor": [0.6, 0.1, 0.05, 1.0], "metallicFactor": 0.7,
            "roughnessFactor": 0.8}),
        json!({"KHR_materials_clearcoat":
            {"clearcoatFactor": 1.0, "clearcoatRoughnessFactor": 0.5}}),
    );
    let velvet = scene.plain(
        json!({"baseColorFactor": [0.1, 0.1, 0.4, 1.0], "metallicFactor": 0.0}),
        json!({"KHR_materials_sheen":
            {"sheenColorFactor": [0.9, 0.7, 0.8], "sheenRoughnessFactor": 0.6}}),
    );
    let all = scene.plain(
        json!({"metallicFactor": 0.2, "roughnessFactor": 0.7}),
        json!({"KHR_materials_clearcoat":
                {"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.6},
            "KHR_materials_sheen":
                {"sheenColorFactor": [0.3, 0.3, 0.3], "sheenRoughnessFactor": 0.9},
            "KHR_materials_specular":
                {"specularFactor": 0.8, "specularColorFactor": [1.0, 0.5, 0.2]}}),
    );
    let all = scene.two_sided(all);
    let mirror = scene.material(json!({"bsdf": "conductor", "metal": "Al"}));
    scene.sphere(v(-0.5, -0.4, -0.2), 0.45, lacquer);
    scene.ball(v(0.4, -0.2, -0.2), 0.4, 8, velvet);
    scene.quad(v(0.0, -0.7, 0.3), v(0.7, 0.0, 0.1), v(0.0, 0.1, -0.4), all);
    scene.sphere(v(0.1, 0.4, -0.6), 0.3, mirror);
    pinhole(scene).load("coats and cloth")
}

/// A rough pane, one that is in part matte and metal, and a leaf, between the lamp and the floor;
/// a sphere of thin wall with a matte one inside.
fn walls() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.4, 5.0);
    let pane = scene.plain(
        json!({"metallicFactor": 0.0, "roughnessFactor": 0.5}),
        json!({"KHR_materials_transmission": {"transmissionFactor": 1.0}}),
    );
    let partial = scene.plain(
        json!({"baseColorFactor": [0.9, 0.6, 0.3, 1.0], "metallicFactor": 0.2,
            "roughnessFactor": 0.6}),
        json!({"KHR_materials_transmission": {"transmissionFactor": 0.6},
            "KHR_materials_clearcoat":
                {"clearcoatFactor": 0.7, "clearcoatRoughnessFactor": 0.5}}),
    );
    let leaf = scene.plain(
        json!({"baseColorFactor": [0.2, 0.5, 0.1, 1.0], "metallicFactor": 0.0,
            "roughnessFactor": 0.7}),
        json!({"KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.6,
            "diffuseTransmissionColorFactor": [0.7, 0.8, 0.2]}}),
    );
    let matte = scene.diffuse(0.7);
    scene.quad(v(-0.5, 0.2, 0.1), v(0.4, 0.1, 0.0), v(0.0, 0.1, 0.4), pane);
    scene.sphere(v(0.45, -0.3, 0.0), 0.4, partial);
    scene.sphere(v(0.45, -0.3, 0.0), 0.2, matte);
    scene.quad(v(-0.3, -0.5, 0.3), v(0.4, 0.0, 0.1), v(0.0, 0.3, -0.2), leaf);
    pinhole(scene).load("walls")
}

/// A rough pane and a shell about thicker fog, in fog, lit by points inside and outside.
fn walls_in_fog() -> World {
    let mut scene = room(&[CEILING]);
    let thin = scene.medium(json!({"phase": "hg", "g": 0.3, "sigma_a": 0.1, "sigma_s": 0.2}));
    scene.fill(thin);
    let air = json!({"phase": "rayleigh", "sigma_a": [0.2, 0.0, 0.5], "sigma_s": [1.0, 3.0, 2.0]});
    let air = scene.medium(air);
    let pane = |roughness: f32, share: f32| {
        (
            json!({"metallicFactor": 0.0, "roughnessFactor": roughness}),
            json!({"KHR_materials_transmission": {"transmissionFactor": share}}),
        )
    };
    let [shell, pane] =
        [pane(0.7, 0.8), pane(0.6, 1.0)].map(|(pbr, extensions)| scene.plain(pbr, extensions));
    scene.around(Some(air), Some(thin), |scene| scene.sphere(v(0.3, -0.3, 0.2), 0.45, shell));
    scene.quad(v(-0.5, 0.0, 0.2), v(0.4, 0.0, 0.2), v(0.0, 0.5, 0.0), pane);
    scene.light(json!({"type": "point", "intensity": 2.0}), v(-0.5, 0.6, -0.4), Vec3::NEG_Z);
    scene.light(json!({"type": "point", "intensity": 0.5}), v(0.4, -0.2, 0.3), Vec3::NEG_Z);
    pinhole(scene).load("walls in fog")
}

/// All of it by pictures.
fn painted_layers() -> World {
    let mut world = stage(Textures::default());
    let picture = noise(31, 5);
    let number = |reads| {
        let texture = Some(texture(picture.clone(), Filter::Linear));
        Paint { factor: [1.0; 3], texture, reads, by_vertices: false }
    };
    let color = |seed| paint([1.0, 0.9, 0.8], texture(noise(seed, 4), Filter::Linear));
    let parameters = vec![
        (Parameter::BaseColor, color(32)),
        (Parameter::Transmission, number(Reads::Red)),
        (Parameter::DiffuseTransmission, number(Reads::Green)),
        (Parameter::DiffuseTransmissionColor, color(33)),
        (Parameter::Coat, number(Reads::Blue)),
        (Parameter::ClothColor, color(34)),
        (Parameter::Specular, number(Reads::Alpha)),
        (Parameter::SpecularColor, color(35)),
    ];
    let bsdf = Bsdf::Layered {
        layers: Layers {
            transmission: 1.0,
            diffuse_transmission: 1.0,
            coat: 1.0,
            coat_alpha: 0.3,
            cloth_color: [1.0, 0.9, 0.8].into(),
            cloth_alpha: 0.5,
            ..Layers::plain([1.0, 0.9, 0.8], 0.1, 0.4)
        },
    };
    let textures = Textures { parameters, ..Textures::default() };
    let plate = painted_quad(v(0.0, -0.3, 0.2), v(0.9, 0.0, 0.0), v(0.0, 0.4, -0.6));
    add(&mut world, "plate", (Material::from(bsdf).two_sided(), textures), plate);
    add(&mut world, "lamp", (Material::emitter(8.0), Textures::default()), panel(0.5));
    world
}
