//! Scenes whose lamps emit polarized light: every kind of emitter, states that are the same at all
//! wavelengths and that are not, before what changes them in every way there is.

use glam::Vec3;
use serde_json::{Value, json};
use sunstone::internals::scene::World;

use super::gltf::Document;
use super::scenes::{CEILING, pinhole, room, v};

/// What absorbs all light and emits it in a state.
fn glowing(scene: &mut Document, radiance: f32, stokes: Value) -> usize {
    scene.material(json!({"bsdf": "absorber", "emission": radiance, "stokes": stokes}))
}

/// A state of every component that is another in every channel.
fn of_colors() -> Value {
    json!([[0.7, -0.3, 0.2], [0.2, 0.6, -0.5], [-0.5, 0.4, 0.8]])
}

/// Areas and a sky light glass, metals, rough metal and a wall.
pub fn panel_and_sky() -> World {
    let mut scene = room(&[CEILING]);
    let panel = glowing(&mut scene, 6.0, json!([0.3, -0.6, 0.7]));
    scene.quad(v(0.1, 0.95, 0.0), v(0.5, 0.0, 0.1), v(0.0, 0.1, 0.5), panel);
    let bulb = glowing(&mut scene, 2.0, of_colors());
    scene.sphere(v(0.6, 0.5, -0.3), 0.3, bulb);
    scene.sky(json!({"radiance": 0.5, "gradient": [0.0, 0.3, 0.4], "stokes": [0.0, 0.9, 0.3]}));
    let gold = scene.material(json!({"bsdf": "conductor", "metal": "Au"}));
    scene.sphere(v(-0.5, -0.3, -0.2), 0.4, gold);
    let glass = scene.material(json!({"bsdf": "dielectric", "ior": 1.5}));
    scene.sphere(v(0.3, -0.5, 0.3), 0.4, glass);
    let steel = json!({"bsdf": "rough_conductor", "metal": "Al", "alpha": 0.3});
    let steel = scene.material(steel);
    scene.quad(v(0.0, 0.1, -0.9), v(0.4, 0.0, 0.0), v(0.0, 0.4, 0.1), steel);
    pinhole(scene).load("polarized panel and sky")
}

fn state(stokes: Value) -> Value {
    json!({"SUNSTONE_polarization": {"stokes": stokes}})
}

/// A point, a spot and parallel light in air that scatters as small spheres do.
pub fn points_in_thin_air() -> World {
    let mut scene = room(&[CEILING]);
    let point = json!({"type": "point", "intensity": 0.6, "extensions": state(of_colors())});
    scene.light(point, v(-0.5, 0.3, 0.2), Vec3::NEG_Z);
    let cone = json!({"innerConeAngle": 0.3, "outerConeAngle": 0.5});
    let spot = json!({"type": "spot", "intensity": 3.0, "spot": cone,
        "extensions": state(json!([-0.8, 0.0, 0.6]))});
    scene.light(spot, v(0.5, 0.6, 0.4), v(-0.5, -1.0, -0.3));
    let sun = json!({"type": "directional", "intensity": 1.0,
        "extensions": state(json!([0.5, 0.5, 0.0]))});
    scene.light(sun, v(5.0, 5.0, 5.0), v(-0.4, -1.0, -0.5));
    let air = json!({"phase": "rayleigh", "sigma_a": 0.05, "sigma_s": [0.2, 0.3, 0.5]});
    let air = scene.medium(air);
    scene.fog(air, |scene, null| scene.cuboid(v(0.0, -0.1, 0.0), v(0.8, 0.8, 0.8), null));
    pinhole(scene).load("polarized points in thin air")
}

/// Panes that emit and let light pass, a polarizer and a wave plate in the way of a panel and of a
/// lamp in a state.
pub fn panes_behind_sheets() -> World {
    let mut scene = room(&[]);
    let panel = glowing(&mut scene, 6.0, json!([0.0, 0.8, 0.5]));
    scene.quad(v(0.1, 0.95, 0.0), v(0.6, 0.0, 0.0), v(0.0, 0.0, 0.6), panel);
    let pane = json!({"bsdf": "thin_dielectric", "ior": 1.5, "emission": 0.7,
        "stokes": [0.6, 0.3, -0.2]});
    let pane = scene.material(pane);
    let pane = scene.two_sided(pane);
    scene.quad(v(0.3, 0.1, 0.2), v(0.4, 0.0, 0.1), v(0.0, 0.4, 0.0), pane);
    let plate = json!({"bsdf": "retarder", "axis_deg": 65, "retardance_deg": 100});
    let plate = scene.material(plate);
    scene.quad(v(-0.4, 0.6, 0.0), v(0.4, 0.0, 0.0), v(0.0, 0.0, 0.5), plate);
    let polarizer = scene.material(json!({"bsdf": "polarizer", "axis_deg": 20}));
    scene.quad(v(0.0, 0.1, 0.6), v(0.6, 0.0, 0.1), v(0.0, 0.5, 0.0), polarizer);
    let sphere = scene.diffuse(0.7);
    scene.sphere(v(-0.3, -0.6, 0.1), 0.3, sphere);
    pinhole(scene).load("polarized panes behind sheets")
}

/// A room with glass, metal and thin air under a panel, which is in a state or behind a sheet.
pub fn under_a_panel(is_behind_a_sheet: bool) -> World {
    let mut scene = room(&[]);
    let mut panel = json!({"bsdf": "absorber", "emission": 6.0, "stokes": [-1.0, 0.0, 0.0]});
    if is_behind_a_sheet {
        panel = json!({"bsdf": "absorber", "emission": 12.0});
    }
    let panel = scene.material(panel);
    let (u, w) = (Vec3::X * 0.5, Vec3::Z * 0.5);
    scene.quad(Vec3::Y * 0.95, u, w, panel);
    if is_behind_a_sheet {
        // It passes what is across the node's x axis, which it absorbs, in whatever direction.
        let sheet = scene.material(json!({"bsdf": "polarizer", "axis_deg": 90}));
        scene.quad(Vec3::Y * 0.9499, u * 1.001, w * 1.001, sheet);
    }
    let gold = scene.material(json!({"bsdf": "conductor", "metal": "Au"}));
    scene.sphere(Vec3::new(-0.5, -0.3, -0.2), 0.4, gold);
    let glass = scene.material(json!({"bsdf": "dielectric", "ior": 1.5}));
    scene.sphere(Vec3::new(0.4, -0.5, 0.3), 0.4, glass);
    let air = scene.medium(json!({"phase": "rayleigh", "sigma_a": 0.05, "sigma_s": 0.3}));
    scene.fog(air, |scene, null| scene.cuboid(Vec3::Y * 0.4, Vec3::splat(0.3), null));
    pinhole(scene).load("under a panel")
}

/// A floor and fog that know intensities alone, under a panel and a point in a state or none.
pub fn floor_and_fog(stokes: Option<Value>) -> World {
    let mut document = room(&[CEILING]);
    let mut panel = json!({"bsdf": "absorber", "emission": 5.0});
    let mut light = json!({"type": "point", "intensity": 1.0});
    if let Some(stokes) = stokes {
        panel["stokes"] = stokes.clone();
        light["extensions"] = json!({"SUNSTONE_polarization": {"stokes": stokes}});
    }
    let panel = document.material(panel);
    document.quad(Vec3::Y * 0.9, Vec3::X * 0.4, Vec3::Z * 0.4, panel);
    document.light(light, Vec3::new(0.4, 0.1, 0.2), Vec3::NEG_Z);
    let fog = document.medium(json!({"phase": "hg", "g": 0.4, "sigma_a": 0.1, "sigma_s": 0.5}));
    document.fog(fog, |document, null| {
        document.cuboid(Vec3::ZERO, Vec3::splat(0.5), null);
    });
    // Turned off the panel, which shows its state.
    document.perspective(Vec3::new(0.2, 0.1, 3.6), Vec3::NEG_Y * 0.3, 0.3, None);
    document.load("depolarizers")
}

/// A ball and a plate of metal and a ball of glass that glow by their heat light a room.
pub fn hot_metals() -> World {
    let mut scene = room(&[]);
    let hot = |scene: &mut Document, mut body: Value, radiance: f32| {
        body["emission"] = json!(radiance);
        body["incandescent"] = json!(true);
        scene.material(body)
    };
    let tungsten = hot(&mut scene, json!({"bsdf": "conductor", "metal": "W"}), 6.0);
    scene.sphere(v(-0.4, 0.4, 0.0), 0.35, tungsten);
    let copper = hot(&mut scene, json!({"bsdf": "conductor", "metal": "Cu"}), 9.0);
    scene.quad(v(0.2, 0.9, 0.0), v(0.5, 0.1, 0.0), v(0.0, 0.0, 0.5), copper);
    let glass = hot(&mut scene, json!({"bsdf": "dielectric", "ior": 1.6}), 1.0);
    scene.sphere(v(0.4, -0.5, 0.3), 0.35, glass);
    let air = scene.medium(json!({"phase": "rayleigh", "sigma_a": 0.05, "sigma_s": 0.3}));
    scene.fog(air, |scene, null| scene.cuboid(v(-0.5, -0.6, 0.2), Vec3::splat(0.3), null));
    pinhole(scene).load("hot metals")
}
