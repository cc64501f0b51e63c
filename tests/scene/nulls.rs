//! Keys of the extension that are null.

use serde_json::{Value, json};

use crate::common::{good, load_json};
use crate::room::has_all;

/// As edits have it: null takes away what a key says. Only of what is on a side of a surface, or
/// fills the scene, is nothing something.
#[test]
fn keys_that_are_null_are_not_there() {
    let schema: Value =
        serde_json::from_str(include_str!("../../scenes/sunstone.schema.json")).unwrap();
    let nulls = |definition: &str| {
        let keys = schema["$defs"][definition]["properties"].as_object().expect("it has keys");
        let is_null = |key: &&String| !["interior", "exterior", "medium"].contains(&key.as_str());
        keys.keys().filter(is_null).map(|key| (key.clone(), Value::Null)).collect::<Vec<_>>()
    };
    let mut plain = good();
    plain["extras"]["sunstone"] = json!({"environment": {"radiance": 1}, "media": [
        {"name": "fog", "phase": "mie", "sigma_s": 1, "sigma_a": 0, "host": {"eta": 1.33},
            "particles": [{"eta": 1.5, "volume_fraction": 1e-3,
                "distribution": {"kind": "monodisperse", "radius_um": 0.1}}]}]});
    let lens = json!({"film": {"resolution": [8, 8], "analyzer": {"kind": "none"}}});
    plain["cameras"][0]["extensions"]["SUNSTONE_polarization"] = lens;
    let lamp = json!({"stokes": [0, 0, 0]});
    plain["extensions"]["KHR_lights_punctual"]["lights"][0]["extensions"] =
        json!({"SUNSTONE_polarization": lamp});
    let film = json!({"eta": {"cauchy": {"a": 1.3, "range_nm": [300, 800]}}, "thickness_nm": 90});
    plain["materials"][1]["extensions"]["SUNSTONE_polarization"]["film"] = film;
    let own = "extensions/SUNSTONE_polarization";
    let mut nulled = plain.clone();
    let mut added = 0;
    for (place, definition) in [
        (format!("/materials/0/{own}"), "material"),
        (format!("/materials/1/{own}"), "material"),
        (format!("/materials/1/{own}/film"), "thin_film"),
        (format!("/materials/1/{own}/film/eta"), "index"),
        (format!("/materials/1/{own}/film/eta/cauchy"), "cauchy"),
        (format!("/nodes/2/{own}"), "node"),
        (format!("/cameras/0/{own}"), "camera"),
        (format!("/cameras/0/{own}/film"), "film"),
        (format!("/cameras/0/{own}/film/analyzer"), "analyzer"),
        (format!("/extensions/KHR_lights_punctual/lights/0/{own}"), "light"),
        ("/extras/sunstone".into(), "scene"),
        ("/extras/sunstone/environment".into(), "environment"),
        ("/extras/sunstone/media/0".into(), "medium"),
        ("/extras/sunstone/media/0/host".into(), "host"),
        ("/extras/sunstone/media/0/particles/0".into(), "particles"),
        ("/extras/sunstone/media/0/particles/0/distribution".into(), "distribution"),
    ] {
        let object = nulled.pointer_mut(&place).unwrap_or_else(|| panic!("no {place}"));
        let object = object.as_object_mut().expect("it has keys");
        for (key, null) in nulls(definition) {
            added += usize::from(!object.contains_key(&key));
            object.entry(key).or_insert(null);
        }
    }
    assert!(added > 120, "{added}");
    let told = |document: &Value| {
        let world = load_json(document).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(world.warnings(), [""; 0]);
        world.describe()
    };
    let without_name = |text: String| text.lines().skip(1).collect::<Vec<_>>().join("\n");
    assert_eq!(without_name(told(&nulled)), without_name(told(&plain)));
    let of = |body: Value| {
        let mut document = good();
        document["materials"][0]["extensions"]["SUNSTONE_polarization"] = body;
        load_json(&document).map(drop).unwrap_err()
    };
    has_all(&of(json!({"bsdf": "diffuse", "shine": null})), &["shine is not a key"]);
    has_all(&of(json!({"bsdf": "conductor", "metal": null})), &["either `metal` or"]);
}
