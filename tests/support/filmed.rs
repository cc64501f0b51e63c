//! Scenes of thin films on rough surfaces.

use serde_json::json;
use sunstone::internals::scene::World;
use sunstone::world::{Bsdf, Filter, Material, Paint, Parameter, Reads, Textures, ThinFilm};

use super::painted::{add, noise, paint, panel, quad as painted_quad, stage, texture};
use super::scenes::{Named, add_panel, pinhole, room, v};

/// All of them.
pub const FILMED: [Named; 2] = [("filmed", filmed), ("painted films", painted_films)];

/// Oxidized metal on a sphere and brushed flat; a bubble of rough glass; a plate of plastic.
fn filmed() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.4, 5.0);
    let metal = json!({"bsdf": "rough_conductor", "metal": "Ti", "alpha": 0.3,
        "film": {"eta": 2.4, "thickness_nm": 75}});
    let metal = scene.material(metal);
    let brushed = json!({"bsdf": "rough_conductor", "metal": "Al", "alpha_u": 0.5, "alpha_v": 0.2,
        "distribution": "beckmann", "film": {"eta": 1.5, "thickness_nm": 300, "share": 0.6}});
    let brushed = scene.material(brushed);
    let brushed = scene.two_sided(brushed);
    let glass = json!({"bsdf": "rough_dielectric", "ior": 1.5, "alpha": 0.4,
        "film": {"eta": 2.2, "k": 0.05, "thickness_nm": 120}});
    let glass = scene.material(glass);
    let iridescence = json!({"KHR_materials_iridescence": {"iridescenceFactor": 1.0,
        "iridescenceIor": 1.8, "iridescenceThicknessMaximum": 350.0}});
    let pbr = json!({"metallicFactor": 0.3, "roughnessFactor": 0.6,
        "baseColorFactor": [0.6, 0.3, 0.2, 1.0]});
    let plastic = scene.plain(pbr, iridescence);
    scene.sphere(v(-0.5, -0.4, -0.2), 0.45, metal);
    scene.ball(v(0.4, -0.2, -0.2), 0.4, 8, plastic);
    scene.quad(v(0.0, -0.7, 0.3), v(0.7, 0.0, 0.1), v(0.0, 0.1, -0.4), brushed);
    scene.sphere(v(0.1, 0.4, -0.4), 0.3, glass);
    pinhole(scene).load("filmed")
}

/// glTF's, of which the film, what it covers and what lies under it are by pictures.
fn painted_films() -> World {
    let mut world = stage(Textures::default());
    let number = |seed, reads| {
        let texture = Some(texture(noise(seed, 5), Filter::Linear));
        Paint { factor: [1.0; 3], texture, reads, by_vertices: false }
    };
    let color = paint([1.0, 0.9, 0.8], texture(noise(62, 4), Filter::Linear));
    let parameters = vec![
        (Parameter::BaseColor, color),
        (Parameter::FilmShare, number(63, Reads::Red)),
        (Parameter::FilmThickness, number(64, Reads::Green)),
    ];
    let of = Bsdf::MetallicRoughness {
        base_color: [1.0, 0.9, 0.8].into(),
        metallic: 0.5,
        alpha: 0.25,
        ior: 1.5,
        specular: 1.0,
    };
    let bsdf = of.filmed(ThinFilm::new(1.6, 0.0, 0.0).between([100.0, 500.0]));
    let textures = Textures { parameters, ..Textures::default() };
    let plate = painted_quad(v(0.0, -0.3, 0.2), v(0.9, 0.0, 0.0), v(0.0, 0.4, -0.6));
    add(&mut world, "plate", (Material::from(bsdf).two_sided(), textures), plate);
    add(&mut world, "lamp", (Material::emitter(8.0), Textures::default()), panel(0.5));
    world
}
