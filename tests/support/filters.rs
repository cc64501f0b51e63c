//! Small scenes with surfaces that let light straight on, in every place: before lamps and cameras
//! of each kind, between media, tilted, stacked and crossed.

use glam::Vec3;
use serde_json::{Value, json};
use sunstone::internals::scene::World;

use super::gltf::Document;
use super::scenes::{Named, add_panel, foggy_room, open_scene, pinhole, room, v};

/// All of them.
pub const FILTERS: [Named; 30] = [
    ("polarizers before panel and pinhole", || behind(true, &[POLARIZER], &[ANALYZER])),
    ("polarizers before point and pinhole", || behind(false, &[POLARIZER], &[ANALYZER])),
    ("wave plates before point and pinhole", || {
        behind(false, &[POLARIZER, PLATE], &[PLATE, LEAKY])
    }),
    ("crossed sheets before a panel", || behind(true, &[POLARIZER, CROSSED], &[])),
    ("thin panes before panel and pinhole", || behind(true, &[PANE], &[PANE])),
    ("thin panes before point and pinhole", || behind(false, &[PANE], &[PANE])),
    ("stack of panes", || behind(true, &[PANE, PANE], &[PANE, POLARIZER, PANE])),
    ("matched panes before point and pinhole", || behind(false, &[MATCHED], &[MATCHED])),
    ("thin water, polarizers", || behind(true, &[POLARIZER, THIN_WATER], &[THIN_WATER, ANALYZER])),
    ("analyzer before a lens, tilted pane at a spot", spot_and_lens),
    ("analyzer before an orthographic film, sphere light", sphere_and_orthographic),
    ("sun through a tilted polarizer", sun_and_polarizer),
    ("sky through sheets, lens", || sky(Some([0.15, 3.2]))),
    ("sky through sheets, orthographic", || sky(None)),
    ("sheets that emit", sheets_that_emit),
    ("panes that emit", panes_that_emit),
    ("fog whose boundary shines", shining_fog),
    ("fog from beyond the walls", fog_beyond_walls),
    ("fog behind an analyzer", fog_behind_analyzer),
    ("sheets within fog", sheets_within_fog),
    ("polarizer between two media", polarizer_between_media),
    ("pane between fog and air", pane_between_fog_and_air),
    ("sheet within glass", sheet_within_glass),
    ("sheet and pane before a mirror", before_a_mirror),
    ("sheets laid on panel, mirror and glass", laid_on),
    ("fog that fills half a room, beside another", side_by_side),
    ("real polarizers before panel and pinhole", || behind(true, &[REAL], &[CIRCULAR])),
    ("circular polarizers before point and pinhole", || {
        behind(false, &[CIRCULAR, DISPERSIVE], &[MATRIX, CIRCULAR])
    }),
    ("a matrix before a panel, real ones crossed", || {
        behind(true, &[MATRIX, CIRCULAR, REAL], &[DISPERSIVE, ANALYZER])
    }),
    ("films on metal and glass", films),
];

const POLARIZER: &str = r#"{"bsdf": "polarizer", "axis_deg": 20}"#;
const ANALYZER: &str = r#"{"bsdf": "polarizer", "axis_deg": 75}"#;
const CROSSED: &str = r#"{"bsdf": "polarizer", "axis_deg": 105}"#;
const LEAKY: &str = r#"{"bsdf": "polarizer", "axis_deg": 100, "extinction_ratio": 8}"#;
const PLATE: &str = r#"{"bsdf": "retarder", "axis_deg": 65, "retardance_deg": 100}"#;
const REAL: &str = r#"{"bsdf": "polarizer", "axis_deg": 100, "transmittance": [0.9, 0.8, 0.6],
    "blocked": [0.01, 0.05, 0.2]}"#;
const CIRCULAR: &str = r#"{"bsdf": "circular_polarizer", "axis_deg": -30, "handedness": "left",
    "extinction_ratio": 40, "retardance_deg": [70, 90, 120]}"#;
const DISPERSIVE: &str = r#"{"bsdf": "retarder", "axis_deg": 15, "birefringence": 0.01,
    "thickness_um": 30}"#;
/// Turns S1 to S2, S2 to S3 and that to S1, and depolarizes half of the light.
const MATRIX: &str = r#"{"bsdf": "mueller", "axis_deg": 40, "matrix": [[0.6, 0.1, 0.0, 0.0],
    [0.0, 0.0, 0.0, 0.3], [0.1, 0.3, 0.0, 0.0], [0.0, 0.0, 0.3, 0.0]]}"#;
const PANE: &str = r#"{"bsdf": "thin_dielectric", "ior": 1.6}"#;
const THIN_WATER: &str = r#"{"bsdf": "thin_dielectric", "ior": 1.33}"#;
const MATCHED: &str = r#"{"bsdf": "dielectric", "ior": 1.4, "exterior_ior": 1.4}"#;

fn sheet(scene: &mut Document, body: &str) -> usize {
    let body: Value = serde_json::from_str(body).expect("JSON");
    scene.material(body)
}

/// Filters below the ceiling, tilted a little, the first nearest to the lamp.
fn before_lamp(scene: &mut Document, filters: &[&str]) {
    for (index, body) in filters.iter().enumerate() {
        let material = sheet(scene, body);
        let y = 0.6 - 0.1 * index as f32;
        scene.quad(v(0.1, y, 0.0), v(0.85, 0.05, 0.0), v(0.0, 0.05, -0.9), material);
    }
}

/// Filters between the room and the camera, the first nearest to the room.
fn before_camera(scene: &mut Document, filters: &[&str]) {
    for (index, body) in filters.iter().enumerate() {
        let material = sheet(scene, body);
        let z = 1.4 + 0.2 * index as f32;
        scene.quad(v(0.0, 0.0, z), v(1.3, 0.0, 0.2), v(0.0, 1.3, -0.1), material);
    }
}

/// A room with a panel or a point light, filters before it and before the camera.
fn behind(of_panel: bool, lamp: &[&str], camera: &[&str]) -> World {
    let mut scene = room(&[]);
    if of_panel {
        add_panel(&mut scene, 0.4, 6.0);
    } else {
        scene.light(json!({"type": "point", "intensity": 3.0}), v(0.1, 0.8, 0.1), Vec3::NEG_Z);
    }
    before_lamp(&mut scene, lamp);
    before_camera(&mut scene, camera);
    pinhole(scene).load("filters before lamp and camera")
}

fn spot_and_lens() -> World {
    let mut scene = room(&[]);
    let spot = json!({"type": "spot", "intensity": 5.0, "spot":
        {"innerConeAngle": 0.3, "outerConeAngle": 1.0}});
    scene.light(spot, v(0.1, 0.9, 0.1), v(0.1, -1.0, -0.1));
    before_lamp(&mut scene, &[LEAKY, PANE]);
    before_camera(&mut scene, &[ANALYZER]);
    scene.perspective(v(0.2, 0.1, 3.6), Vec3::ZERO, 0.62, Some([0.1, 3.4]));
    scene.load("spot and lens")
}

fn sphere_and_orthographic() -> World {
    let mut scene = room(&[]);
    let bulb = scene.diffuse(0.4);
    let bulb = scene.emits(bulb, 6.0);
    scene.sphere(v(0.0, 0.75, 0.0), 0.2, bulb);
    before_lamp(&mut scene, &[PLATE, POLARIZER]);
    before_camera(&mut scene, &[ANALYZER]);
    scene.orthographic(v(0.3, 0.4, 3.0), Vec3::ZERO, 0.95);
    scene.load("sphere light and orthographic camera")
}

fn sun_and_polarizer() -> World {
    let mut scene = room(&[1]);
    let sun = json!({"type": "directional", "intensity": 3.0});
    scene.light(sun, v(5.0, 5.0, 5.0), v(-0.3, -1.0, -0.2));
    before_lamp(&mut scene, &[POLARIZER, THIN_WATER]);
    before_camera(&mut scene, &[PLATE, ANALYZER]);
    pinhole(scene).load("sun and polarizer")
}

fn sky(lens: Option<[f32; 2]>) -> World {
    let mut scene = open_scene();
    let [roof, side] = [POLARIZER, PANE].map(|body| sheet(&mut scene, body));
    scene.quad(v(0.0, 1.1, 0.0), v(1.0, 0.0, 0.0), v(0.0, 0.0, -1.0), roof);
    scene.quad(v(0.0, 0.2, 1.1), v(1.0, 0.0, 0.1), v(0.0, 1.0, 0.0), side);
    match lens {
        Some(_) => scene.perspective(v(0.2, 0.6, 3.6), Vec3::ZERO, 0.7, lens),
        None => scene.orthographic(v(0.3, 0.9, 3.0), Vec3::ZERO, 1.2),
    }
    scene.load("sky through sheets")
}

/// Lamps whose light other sheets, and they themselves, let pass.
fn sheets_that_emit() -> World {
    let mut scene = room(&[]);
    let shining = sheet(&mut scene, POLARIZER);
    let shining = scene.emits(shining, 5.0);
    scene.quad(v(0.1, 0.8, 0.0), v(0.5, 0.0, 0.0), v(0.0, 0.0, 0.5), shining);
    let glowing = sheet(&mut scene, PLATE);
    let glowing = scene.emits(glowing, 1.5);
    let glowing = scene.two_sided(glowing);
    scene.quad(v(-0.3, -0.3, 0.3), v(0.4, 0.0, 0.1), v(0.0, 0.4, 0.0), glowing);
    before_lamp(&mut scene, &[ANALYZER]);
    pinhole(scene).load("sheets that emit")
}

fn panes_that_emit() -> World {
    let mut scene = room(&[]);
    let shining = sheet(&mut scene, PANE);
    let shining = scene.emits(shining, 4.0);
    let shining = scene.two_sided(shining);
    scene.quad(v(0.1, 0.6, 0.0), v(0.6, 0.0, 0.0), v(0.0, 0.1, 0.6), shining);
    before_camera(&mut scene, &[PANE]);
    pinhole(scene).load("panes that emit")
}

fn shining_fog() -> World {
    let mut scene = room(&[]);
    let fog = scene.medium(json!({"phase": "hg", "g": 0.3, "sigma_a": 0.3, "sigma_s": 0.8}));
    let skin = scene.material(json!({"bsdf": "null"}));
    let skin = scene.emits(skin, 2.0);
    let skin = scene.two_sided(skin);
    scene.around(Some(fog), None, |scene| scene.sphere(v(0.1, 0.1, 0.1), 0.4, skin));
    before_camera(&mut scene, &[ANALYZER]);
    pinhole(scene).load("fog whose boundary shines")
}

/// The walls hide all of its boundary.
fn fog_beyond_walls() -> World {
    let mut scene = room(&[]);
    let fog = scene.medium(json!({"phase": "rayleigh", "sigma_a": 0.1, "sigma_s": 0.5}));
    scene.fog(fog, |scene, null| {
        scene.cuboid(v(0.0, 0.0, 0.0), v(5.0, 5.0, 5.0), null);
    });
    add_panel(&mut scene, 0.5, 6.0);
    before_lamp(&mut scene, &[POLARIZER]);
    pinhole(scene).load("fog from beyond the walls")
}

fn fog_behind_analyzer() -> World {
    let fog = json!({"phase": "rayleigh", "depolarization": 0.1, "sigma_a": 0.1, "sigma_s": 0.7});
    let mut scene = foggy_room(fog);
    add_panel(&mut scene, 0.5, 4.0);
    before_camera(&mut scene, &[PANE, ANALYZER]);
    pinhole(scene).load("fog behind an analyzer")
}

fn sheets_within_fog() -> World {
    let mut scene = foggy_room(json!({"phase": "hg", "g": 0.4, "sigma_a": 0.1, "sigma_s": 0.5}));
    add_panel(&mut scene, 0.5, 6.0);
    before_lamp(&mut scene, &[POLARIZER, PLATE, PANE]);
    pinhole(scene).load("sheets within fog")
}

fn polarizer_between_media() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.5, 6.0);
    let air = json!({"phase": "rayleigh", "depolarization": 0.2, "sigma_a": 0.1, "sigma_s": 0.8});
    let fog = json!({"phase": "isotropic", "sigma_a": 0.2, "sigma_s": [0.3, 0.6, 0.9]});
    let (above, below) = (scene.medium(air), scene.medium(fog));
    let null = scene.material(json!({"bsdf": "null"}));
    let lid = sheet(&mut scene, POLARIZER);
    // A box of two floors, the lid between them: all without bottom and top of their own there.
    let half = v(0.7, 0.3, 0.6);
    for (medium, y) in [(above, 0.2), (below, -0.4)] {
        scene.around(Some(medium), None, |scene| {
            let (x, z) = (Vec3::X * half.x, Vec3::Z * half.z);
            let up = Vec3::Y * half.y;
            let center = v(0.0, y, 0.0);
            for (face, u, v) in [(x, up, z), (-x, z, up), (z, x, up), (-z, up, x)] {
                scene.quad(center + face, u, v, null);
            }
        });
    }
    let (x, z) = (Vec3::X * half.x, Vec3::Z * half.z);
    scene.around(Some(above), None, |scene| scene.quad(v(0.0, 0.5, 0.0), z, x, null));
    scene.around(Some(below), None, |scene| scene.quad(v(0.0, -0.7, 0.0), x, z, null));
    scene.around(Some(below), Some(above), |scene| scene.quad(v(0.0, -0.1, 0.0), z, x, lid));
    pinhole(scene).load("polarizer between two media")
}

fn pane_between_fog_and_air() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.5, 6.0);
    let fog = scene.medium(json!({"phase": "isotropic", "sigma_a": 0.2, "sigma_s": 0.9}));
    let pane = sheet(&mut scene, PANE);
    scene.around(Some(fog), None, |scene| {
        scene.cuboid(v(0.0, -0.3, 0.1), v(0.6, 0.4, 0.5), pane);
    });
    pinhole(scene).load("pane between fog and air")
}

fn sheet_within_glass() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.6, 5.0);
    let glass = scene.material(json!({"bsdf": "dielectric", "ior": 1.5}));
    scene.cuboid(v(0.1, -0.4, 0.2), v(0.6, 0.4, 0.4), glass);
    let plate = sheet(&mut scene, PLATE);
    scene.quad(v(0.1, -0.4, 0.2), v(0.5, 0.0, 0.1), v(0.0, 0.35, 0.0), plate);
    let polarizer = sheet(&mut scene, POLARIZER);
    scene.quad(v(0.1, -0.4, 0.3), v(0.5, 0.0, 0.1), v(0.0, 0.35, 0.0), polarizer);
    pinhole(scene).load("sheet within glass")
}

fn before_a_mirror() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.6, 5.0);
    let gold = scene.material(json!({"bsdf": "conductor", "metal": "Au"}));
    scene.quad(v(0.0, 0.0, -0.8), v(0.8, 0.0, 0.0), v(0.0, 0.8, 0.0), gold);
    let [plate, pane] = [PLATE, PANE].map(|body| sheet(&mut scene, body));
    scene.quad(v(-0.2, 0.0, -0.799), v(0.5, 0.0, 0.0), v(0.0, 0.6, 0.0), plate);
    scene.quad(v(0.2, 0.0, -0.7), v(0.5, 0.0, 0.1), v(0.0, 0.6, 0.0), pane);
    pinhole(scene).load("sheet and pane before a mirror")
}

/// Sheets without a gap to what they lie on, and two in one place.
fn laid_on() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.6, 6.0);
    let [polarizer, plate] = [POLARIZER, PLATE].map(|body| sheet(&mut scene, body));
    scene.quad(v(0.1, 0.95, 0.0), v(0.7, 0.0, 0.0), v(0.0, 0.0, -0.7), polarizer);
    scene.quad(v(0.1, 0.95, 0.0), v(0.7, 0.0, 0.0), v(0.0, 0.0, 0.7), plate);
    let gold = scene.material(json!({"bsdf": "conductor", "metal": "Au"}));
    scene.quad(v(0.0, 0.2, -0.8), v(0.8, 0.0, 0.0), v(0.0, 0.6, 0.0), gold);
    scene.quad(v(-0.2, 0.2, -0.8), v(0.5, 0.0, 0.0), v(0.0, 0.5, 0.0), plate);
    let glass = scene.material(json!({"bsdf": "dielectric", "ior": 1.5}));
    scene.cuboid(v(0.2, -0.6, 0.2), v(0.5, 0.3, 0.4), glass);
    scene.quad(v(0.2, -0.6, 0.6), v(0.4, 0.0, 0.0), v(0.0, 0.25, 0.0), polarizer);
    pinhole(scene).load("sheets laid on panel, mirror and glass")
}

/// Films are no sheets, but are seen through them.
fn films() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.6, 5.0);
    let metal = r#"{"bsdf": "conductor", "metal": "Ti", "film": {"eta": 2.2, "thickness_nm": 90}}"#;
    let metal = sheet(&mut scene, metal);
    scene.quad(v(0.0, 0.0, -0.8), v(0.8, 0.0, 0.0), v(0.0, 0.8, 0.0), metal);
    let glass = r#"{"bsdf": "dielectric", "ior": 1.5,
        "film": {"eta": 1.8, "k": 0.05, "thickness_nm": 400}}"#;
    let glass = sheet(&mut scene, glass);
    scene.sphere(v(0.3, -0.5, 0.2), 0.4, glass);
    before_camera(&mut scene, &[ANALYZER]);
    pinhole(scene).load("films on metal and glass")
}

/// Media that share walls with the room and with each other.
fn side_by_side() -> World {
    let mut scene = room(&[]);
    add_panel(&mut scene, 0.5, 6.0);
    let air = json!({"phase": "rayleigh", "depolarization": 0.2, "sigma_a": 0.1, "sigma_s": 0.8});
    let fog = json!({"phase": "isotropic", "sigma_a": 0.2, "sigma_s": [0.3, 0.6, 0.9]});
    for (medium, x) in [(fog, -0.5), (air, 0.5)] {
        let medium = scene.medium(medium);
        scene.fog(medium, |scene, null| {
            scene.cuboid(v(x, -0.5, 0.0), v(0.5, 0.5, 1.0), null);
        });
    }
    pinhole(scene).load("fog that fills half a room, beside another")
}
