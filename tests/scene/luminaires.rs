//! EXT_lights_ies: point lights by files of IES LM-63.

use serde_json::{Value, json};
use sunstone::internals::scene::bake;
use sunstone::internals::spectrum::Carried;

use crate::common::{data_uri, good, load_json};
use crate::room::has_all;

/// All around the same: 10 candela straight down to 0 at the horizon.
const FILE: &str = "IES:LM-63-2019\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n10 0\n";

/// The good document with such a light in the place of its own, and a body of the node.
fn with(node: Value, profile: &Value) -> Value {
    let mut document = good();
    document["extensions"]["EXT_lights_ies"] = json!({"lights": [profile]});
    document["nodes"][3]["extensions"] = json!({"EXT_lights_ies": node});
    document["extensionsRequired"] = json!(["EXT_lights_ies"]);
    document["extensionsUsed"] = json!([
        "EXT_lights_ies",
        "SUNSTONE_polarization",
        "KHR_implicit_shapes",
        "KHR_lights_punctual"
    ]);
    document
}

#[test]
fn files_have_luminaires() {
    let profile = json!({"uri": data_uri(FILE.as_bytes())});
    let node = json!({"light": 0, "multiplier": 68.3, "color": [1.0, 0.5, 0.25]});
    let world = load_json(&with(node, &profile)).unwrap();
    has_all(&world.describe(), &["node 3", "EXT_lights_ies", "measured"]);
    let optics = bake(&world, &Carried::RGB).unwrap().optics;
    assert_eq!(optics.patterns.len(), 1);
    // The mean of 10 (1 - theta / 90) over half the directions, by hand: 5 (1 - 2 / pi).
    let mean = 5.0 * (1.0 - 2.0 / std::f64::consts::PI) as f32;
    assert!((optics.patterns[0].mean() as f32 / mean - 1.0).abs() < 1e-6);
    let lamp = optics.lamps.iter().rev().find(|lamp| lamp[0] > 0.0).unwrap();
    for (found, share) in lamp.iter().zip([1.0, 0.5, 0.25]) {
        assert!((found / (0.1 * share * mean) - 1.0).abs() < 1e-5, "{found} of {mean}");
    }
    let plain = load_json(&with(json!({"light": 0}), &profile)).unwrap();
    assert_eq!(bake(&plain, &Carried::RGB).unwrap().optics.patterns.len(), 1);
    let dark = load_json(&with(json!({"light": 0, "multiplier": 0}), &profile)).unwrap();
    assert!(bake(&dark, &Carried::RGB).unwrap().optics.patterns.is_empty());
}

/// They are rendered all the same.
#[test]
fn doubts_are_told_with_the_place() {
    let said = |from: &str, to: &str| {
        let file = FILE.replacen(from, to, 1);
        let profile = json!({"uri": data_uri(file.as_bytes())});
        load_json(&with(json!({"light": 0}), &profile)).unwrap().warnings().join("\n")
    };
    assert_eq!(said("", ""), "");
    let place = "node 3 \"lamp\", EXT_lights_ies";
    has_all(
        &said("10 0\n", "10 0 5\n"),
        &[place, "EXT_lights_ies goes on behind its last candela"],
    );
    has_all(&said("NONE", "tilt.dat"), &[place, "names a file for TILT"]);
}

#[test]
fn broken_ones_are_refused() {
    let sound = json!({"uri": data_uri(FILE.as_bytes())});
    for (node, profile, words) in [
        (json!({"light": 1}), sound.clone(), "not an index into the file's 1 profiles"),
        (json!({}), sound.clone(), "not an index"),
        (json!({"light": 0, "multiplier": -1}), sound.clone(), "not negative"),
        (json!({"light": 0, "multiplier": "much"}), sound.clone(), "no sound multiplier"),
        (json!({"light": 0, "color": [1, "red", 0]}), sound, "no sound multiplier or color"),
        (json!({"light": 0}), json!({}), "neither `uri` nor `bufferView`"),
        (json!({"light": 0}), json!({"uri": data_uri(b"nothing")}), "TILT is missing"),
        (json!({"light": 0}), json!({"uri": "nowhere.ies"}), "nowhere.ies"),
    ] {
        let error = load_json(&with(node, &profile)).unwrap_err();
        has_all(&error, &["node 3", "EXT_lights_ies", words]);
    }
}
