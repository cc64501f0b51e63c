//! Rough surfaces: what their materials mean, and which are refused.

use serde_json::{Value, json};
use sunstone::internals::polarization::Distribution;
use sunstone::internals::scene::world::SurfaceModel;

use crate::common::good;
use crate::errors::refused;
use crate::meaning::{baked, warnings};

/// The good document with another first material.
fn with(material: Value) -> Value {
    let mut document = good();
    document["materials"][0] = material;
    document
}

#[test]
fn plain_materials_that_are_rough_are_one_model() {
    let rough = |pbr: Value, extensions: Value| {
        let material = json!({"doubleSided": true, "pbrMetallicRoughness": pbr,
            "extensions": extensions});
        let document = with(material);
        assert_eq!(warnings(&document), "");
        let row = baked(&document).optics.materials[0].clone();
        assert!(row.two_sided);
        row.model
    };
    let mixed = |base_color, metallic, alpha, ior, specular| SurfaceModel::MetallicRoughness {
        base_color,
        metallic,
        alpha,
        ior,
        specular,
    };
    let matte = json!({"metallicFactor": 0.0, "baseColorFactor": [0.1, 0.2, 0.3, 1.0]});
    assert_eq!(rough(matte, json!({})), mixed([0.1, 0.2, 0.3], 0.0, 1.0, 1.5, 1.0));
    let none_stated = rough(json!({}), json!({}));
    assert_eq!(none_stated, mixed([1.0; 3], 1.0, 1.0, 1.5, 1.0), "glTF's own default");
    let polished = json!({"metallicFactor": 0.25, "roughnessFactor": 0.5});
    let coat = json!({"KHR_materials_ior": {"ior": 1.75},
        "KHR_materials_specular": {"specularFactor": 0.5}});
    assert_eq!(rough(polished, coat), mixed([1.0; 3], 0.25, 0.25, 1.75, 0.5));
    // Metal lets nothing through.
    let opaque = json!({"KHR_materials_transmission": {"transmissionFactor": 1.0}});
    assert_eq!(rough(json!({}), opaque), none_stated);
    let hardly = with(json!({"pbrMetallicRoughness": {"roughnessFactor": 0.03}}));
    let model = baked(&hardly).optics.materials[0].model.clone();
    assert!(matches!(model, SurfaceModel::Conductor { .. }), "{model:?}");
}

#[test]
fn rough_metal() {
    let with = |body: Value| {
        let material = json!({"extensions": {"SUNSTONE_polarization": body}});
        baked(&with(material)).optics.materials[0].model.clone()
    };
    let gold = with(json!({"bsdf": "conductor", "metal": "Au"}));
    let SurfaceModel::Conductor { eta, k } = gold else { panic!("{gold:?}") };
    let rough = |alpha, distribution, multiple_scattering| SurfaceModel::RoughConductor {
        eta,
        k,
        alpha,
        distribution,
        multiple_scattering,
    };
    let plain = json!({"bsdf": "rough_conductor", "metal": "Au", "alpha": 0.25});
    assert_eq!(with(plain), rough(0.25, Distribution::Ggx, true));
    let other = json!({"bsdf": "rough_conductor", "metal": "Au", "roughness": 0.5,
        "distribution": "beckmann", "multiple_scattering": false});
    assert_eq!(with(other), rough(0.25, Distribution::Beckmann, false));
    let smooth = json!({"bsdf": "rough_conductor", "metal": "Au", "alpha": 0.0009});
    assert_eq!(with(smooth), gold);
}

/// Makes the first material rough gold with these keys.
fn rough_gold(document: &mut Value, keys: Value) {
    rough(document, "Au", keys);
}

/// Makes the first material a rough metal with these keys; without a name if it has none.
fn rough(document: &mut Value, metal: &str, mut keys: Value) {
    keys["bsdf"] = json!("rough_conductor");
    if !metal.is_empty() {
        keys["metal"] = json!(metal);
    }
    document["materials"][0]["extensions"]["SUNSTONE_polarization"] = keys;
}

#[test]
fn rough_metals_that_are_none() {
    refused(&[
        (
            |d| rough(d, "", json!({"alpha": 0.1})),
            &["a rough_conductor takes either `metal` or both `eta` and `k`"],
        ),
        (
            |d| rough_gold(d, json!({})),
            &["SUNSTONE_polarization.alpha", "is missing", "`roughness`, its root"],
        ),
        (
            |d| rough_gold(d, json!({"alpha": 0.1, "roughness": 0.1})),
            &["takes either `alpha` or `roughness`"],
        ),
        (|d| rough_gold(d, json!({"alpha": 1.5})), &["alpha", "1.5 must be within [0, 1]"]),
        (|d| rough_gold(d, json!({"roughness": -0.5})), &["roughness", "within [0, 1]"]),
        (
            |d| rough_gold(d, json!({"alpha": 0.1, "distribution": "phong"})),
            &["distribution", "`phong`", "use ggx or beckmann"],
        ),
        (
            |d| rough_gold(d, json!({"alpha": 0.1, "multiple_scattering": 1})),
            &["multiple_scattering", "neither true nor false"],
        ),
    ]);
}

/// Makes the first material plain glTF, with these extensions.
fn plain(document: &mut Value, pbr: Value, extensions: Value) {
    document["materials"][0] =
        json!({"name": "glow", "pbrMetallicRoughness": pbr, "extensions": extensions});
}

#[test]
fn plain_materials_that_are_none() {
    refused(&[
        (
            |d| plain(d, json!({}), json!({"KHR_materials_ior": {"ior": 0.0}})),
            &["material 0", "KHR_materials_ior.ior", "from 1 to 10"],
        ),
        (
            |d| plain(d, json!({}), json!({"KHR_materials_specular": {"specularFactor": 1.5}})),
            &["material 0", "KHR_materials_specular.specularFactor", "within [0, 1]"],
        ),
        (
            |d| plain(d, json!({}), json!({"KHR_materials_specular": {"specularFactor": "all"}})),
            &["material 0", "KHR_materials_specular.specularFactor", "must be a number"],
        ),
    ]);
}
