//! Participating media: what files say about them, what lies on the two sides of a surface, and
//! what is refused.

use crate::common::{good, load_json};
use serde_json::{Value, json};
use sunstone::scene::bake;
use sunstone::scene::baked::{BakedScene, KEEP, MaterialKind, NONE, Phase};
use sunstone::spectrum::Color;

/// The good document with two media; the sphere of glass is number 2 of its nodes.
fn with_media() -> Value {
    let mut document = good();
    document["extras"] = json!({"sunstone": {"media": [
        {"name": "fog", "phase": "hg", "g": [0.5, 0.6, 0.7], "sigma_a": 0.25, "sigma_s": [1, 2, 3]},
        {"phase": "rayleigh", "sigma_a": 0, "sigma_s": 1.5},
    ]}});
    document
}

/// Sets a key of the extension of the sphere's node.
fn side(document: &mut Value, key: &str, value: Value) {
    document["nodes"][2]["extensions"]["SUNSTONE_polarization"][key] = value;
}

/// Replaces the material of the sphere.
fn sphere_of(document: &mut Value, body: Value) {
    document["materials"][1]["extensions"]["SUNSTONE_polarization"] = body;
}

fn medium(document: &mut Value, index: usize) -> &mut Value {
    &mut document["extras"]["sunstone"]["media"][index]
}

#[track_caller]
fn baked(document: &Value) -> BakedScene<3> {
    let world = load_json(document).unwrap_or_else(|error| panic!("{error}"));
    bake::<3>(&world, Color::Rgb).unwrap_or_else(|error| panic!("{error}"))
}

/// Media behind and before the sphere, whose surface is the last.
#[track_caller]
fn sides(document: &Value) -> (u32, u32) {
    let surface = *baked(document).surfaces.last().unwrap();
    (surface.interior, surface.exterior)
}

#[test]
fn media_become_rows_in_their_order() {
    let mut document = with_media();
    document["scenes"][0]["extras"] = json!({"sunstone": {"medium": 1}});
    let scene = baked(&document);
    assert_eq!((scene.media.len(), scene.scene_medium), (2, 1));
    assert_eq!((scene.media[0].sigma_a, scene.media[0].sigma_s), ([0.25; 3], [1.0, 2.0, 3.0]));
    assert_eq!(scene.media[0].phase, Phase::HenyeyGreenstein { g: [0.5, 0.6, 0.7] });
    let Phase::Table(table) = &scene.media[1].phase else { panic!("not a table") };
    assert!(table.spheres && table.achromatic);
    let text = load_json(&document).unwrap().describe();
    for expected in ["[0] \"fog\": sigma_a 0.25, sigma_s [1, 2, 3]", "Rayleigh", "fills the scene"]
    {
        assert!(text.contains(expected), "no `{expected}` in: {text}");
    }
    let scene = baked(&good());
    assert_eq!((scene.media.len(), scene.scene_medium), (0, NONE));
}

#[test]
fn glass_is_clear_and_stands_in_the_scenes_medium() {
    let mut document = with_media();
    assert_eq!(sides(&document), (NONE, NONE));
    side(&mut document, "interior", json!(1));
    assert_eq!(sides(&document), (1, NONE));
    document["extras"]["sunstone"]["medium"] = json!(0);
    assert_eq!(sides(&document), (1, 0));
    side(&mut document, "exterior", json!(1));
    assert_eq!(sides(&document), (1, 1));
    for clear in [json!("none"), Value::Null] {
        side(&mut document, "interior", clear.clone());
        side(&mut document, "exterior", clear.clone());
        assert_eq!(sides(&document), (NONE, NONE));
        document["extras"]["sunstone"]["medium"] = clear;
        assert_eq!(baked(&document).scene_medium, NONE);
        document["extras"]["sunstone"]["medium"] = json!(0);
    }
}

#[test]
fn sheets_keep_the_medium_unless_told() {
    for body in [
        json!({"bsdf": "polarizer"}),
        json!({"bsdf": "retarder", "retardance_deg": 90}),
        json!({"bsdf": "diffuse"}),
        json!({"bsdf": "conductor", "metal": "Al"}),
        json!({"bsdf": "absorber"}),
    ] {
        let mut document = with_media();
        sphere_of(&mut document, body);
        document["extras"]["sunstone"]["medium"] = json!(0);
        assert_eq!(sides(&document), (KEEP, KEEP));
    }
    let mut document = with_media();
    sphere_of(&mut document, json!({"bsdf": "polarizer"}));
    document["extras"]["sunstone"]["medium"] = json!(0);
    side(&mut document, "interior", json!(1));
    assert_eq!(sides(&document), (1, 0));
}

#[test]
fn null_surfaces_bound_media() {
    let mut document = with_media();
    sphere_of(&mut document, json!({"bsdf": "null"}));
    side(&mut document, "interior", json!(0));
    assert_eq!(sides(&document), (0, NONE));
    assert_eq!(baked(&document).materials.last().unwrap().kind, MaterialKind::Null);
    document["extras"]["sunstone"]["medium"] = json!(1);
    assert_eq!(sides(&document), (0, 1));
    let node = &mut document["nodes"][2]["extensions"]["SUNSTONE_polarization"];
    *node = json!({"shape": 0, "exterior": "none"});
    assert_eq!(sides(&document), (1, NONE));
}

#[test]
fn meshes_have_sides_too() {
    let mut document = with_media();
    document["materials"][0]["extensions"]["SUNSTONE_polarization"] = json!({"bsdf": "dielectric"});
    document["nodes"][1]["extras"] = json!({"sunstone_interior": 0});
    let scene = baked(&document);
    assert_eq!((scene.surfaces[0].interior, scene.surfaces[0].exterior), (0, NONE));
}

#[test]
fn boundaries_between_dielectrics() {
    let mut document = good();
    sphere_of(&mut document, json!({"bsdf": "dielectric", "ior": 1.33, "exterior_ior": 1.5}));
    let row = *baked(&document).materials.last().unwrap();
    assert!((row.ior - 1.33 / 1.5).abs() < 1e-6);
    assert!(load_json(&document).unwrap().describe().contains("1.5 before it"));
}

/// What is done to the document with media, and what the error must say.
type Case = (fn(&mut Value), &'static [&'static str]);

#[track_caller]
pub fn refused(cases: &[Case]) {
    for (number, (spoil, expected)) in cases.iter().enumerate() {
        let mut document = with_media();
        spoil(&mut document);
        let error = match load_json(&document) {
            Ok(world) => bake::<3>(&world, Color::Rgb).map(|_| ()).map_err(|e| e.to_string()),
            Err(error) => Err(error),
        };
        let Err(error) = error else { panic!("case {number} ({expected:?}) was accepted") };
        assert!(error.contains("scene.gltf: "), "case {number} names no file: {error}");
        for part in *expected {
            assert!(error.contains(part), "case {number}: no `{part}` in: {error}");
        }
    }
}

#[test]
fn bad_media_are_refused() {
    refused(&[
        (|d| d["extras"]["sunstone"]["media"] = json!(3), &["root", "media", "not an array"]),
        (|d| *medium(d, 1) = json!(3), &["media[1]", "not an object"]),
        (|d| *medium(d, 0) = json!({}), &["media[0].", "phase", "missing", "hg, isotropic"]),
        (|d| medium(d, 0)["phase"] = json!("fog"), &["media[0] \"fog\".phase", "`fog`", "use one"]),
        (|d| medium(d, 0)["color"] = json!(1), &["media[0] \"fog\".color", "not a key", "sigma_a"]),
        (|d| medium(d, 0)["sigma_a"] = json!(-1), &["\"fog\".sigma_a", "-1", "not negative"]),
        (|d| medium(d, 0)["sigma_s"] = Value::Null, &["\"fog\".sigma_s", "not a spectrum"]),
        (|d| *medium(d, 1) = json!({"phase": "isotropic"}), &["media[1]", "sigma_a", "missing"]),
        (|d| medium(d, 0)["g"] = json!(1), &["\"fog\".g", "within (-1, 1)"]),
        (|d| medium(d, 1)["g"] = json!(0), &["media[1].g", "means nothing", "depolarization"]),
        (|d| medium(d, 1)["depolarization"] = json!(0.6), &["depolarization", "[0, 0.5]"]),
        (|d| medium(d, 1)["sigma_s"] = json!({"nm": [500, 600], "value": [1, 1]}), &["media[1]"]),
        (
            |d| {
                let fog = medium(d, 1).clone();
                d["extras"]["sunstone"]["media"] = vec![fog; 4097].into();
            },
            &["media", "4097", "more than 4096"],
        ),
        (|d| d["extras"]["sunstone"]["medium"] = json!(2), &["root", "medium", "2 media"]),
        (
            |d| d["scenes"][0]["extras"] = json!({"sunstone_media": []}),
            &["scene 0 \"good\", extras.sunstone_media", "described twice", "root"],
        ),
    ]);
}

#[test]
fn bad_boundaries_are_refused() {
    refused(&[
        (|d| side(d, "interior", json!(2)), &["node 2 \"ball\"", "interior", "2 media"]),
        (|d| side(d, "exterior", json!("air")), &["node 2 \"ball\"", "exterior", "\"air\""]),
        (
            |d| {
                sphere_of(d, json!({"bsdf": "conductor", "metal": "Al"}));
                side(d, "exterior", json!(0));
            },
            &["node 2 \"ball\"", "exterior", "an opaque surface has nothing behind it"],
        ),
        (
            |d| d["nodes"][1]["extras"] = json!({"sunstone_interior": 0}),
            &["node 1 \"panel\", extras.sunstone_interior", "opaque", "null"],
        ),
        (
            |d| d["nodes"][0]["extras"] = json!({"sunstone_interior": 0}),
            &["node 0 \"eye\", extras.sunstone_interior", "belongs to a mesh"],
        ),
        (|d| sphere_of(d, json!({"bsdf": "null"})), &["node 2 \"ball\"", "null", "`interior`"]),
        (
            |d| {
                sphere_of(d, json!({"bsdf": "null"}));
                side(d, "interior", json!(0));
                d["materials"][1]["emissiveFactor"] = json!([1, 1, 1]);
            },
            &["material 1 \"glass\"", "null", "cannot emit"],
        ),
        (|d| sphere_of(d, json!({"bsdf": "null", "ior": 1.5})), &["ior", "means nothing"]),
        (
            |d| sphere_of(d, json!({"bsdf": "dielectric", "exterior_ior": 0})),
            &["exterior_ior", "greater than 0"],
        ),
        (
            |d| sphere_of(d, json!({"bsdf": "dielectric", "ior": 1e30, "exterior_ior": 1e-30})),
            &["material 1 \"glass\", ior over exterior_ior"],
        ),
    ]);
}

#[test]
fn light_from_infinity_needs_a_clear_scene() {
    refused(&[
        (
            |d| {
                d["extras"]["sunstone"]["medium"] = json!(0);
                d["extras"]["sunstone"]["environment"] = json!({"radiance": 1});
            },
            &["media[0] \"fog\"", "fills the scene", "would ever arrive", "null"],
        ),
        (
            |d| {
                d["extras"]["sunstone"]["medium"] = json!(1);
                d["extensions"]["KHR_lights_punctual"]["lights"][0]["type"] = json!("directional");
            },
            &["media[1]", "fills the scene"],
        ),
    ]);
    let mut clear = with_media();
    clear["extras"]["sunstone"]["environment"] = json!({"radiance": 1});
    assert_eq!(baked(&clear).scene_medium, NONE);
    clear["extras"]["sunstone"]["medium"] = json!(1);
    medium(&mut clear, 1)["sigma_s"] = json!(0);
    assert_eq!(baked(&clear).scene_medium, 1);
}
