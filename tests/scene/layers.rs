//! What glTF says beyond metallic-roughness: what becomes of it, and what is refused.

use serde_json::{Value, json};
use sunstone::internals::scene::world::{Layers, SurfaceModel};
use sunstone::internals::scene::{World, Written, load};

use crate::common::{good, load_json, scratch};
use crate::errors::refused;
use crate::meaning::{baked, warnings};
use crate::textures::painted;

/// The good document with another first material, of these extensions.
fn with(pbr: Value, extensions: Value) -> Value {
    let mut document = good();
    document["materials"][0] = json!({"pbrMetallicRoughness": pbr, "extensions": extensions});
    document
}

fn model(document: &Value) -> SurfaceModel<[f32; 3]> {
    baked(document).optics.materials[0].model.clone()
}

fn plain(base_color: f32, metallic: f32, alpha: f32) -> Layers<[f32; 3]> {
    Layers {
        base_color: [base_color; 3],
        metallic,
        alpha,
        ior: 1.5,
        specular: 1.0,
        specular_color: [1.0; 3],
        transmission: 0.0,
        diffuse_transmission: 0.0,
        diffuse_transmission_color: [1.0; 3],
        coat: 0.0,
        coat_alpha: 0.0,
        cloth_color: [0.0; 3],
        cloth_alpha: 0.0,
    }
}

#[test]
fn extensions_are_layers() {
    let matte = || json!({"metallicFactor": 0.0, "roughnessFactor": 0.5});
    let own = plain(1.0, 0.0, 0.25);
    let cases = [
        (
            json!({"KHR_materials_clearcoat":
                {"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.5}}),
            Layers { coat: 0.5, coat_alpha: 0.25, ..own },
        ),
        (
            json!({"KHR_materials_sheen":
                {"sheenColorFactor": [0.5, 0.25, 0.125], "sheenRoughnessFactor": 0.5}}),
            Layers { cloth_color: [0.5, 0.25, 0.125], cloth_alpha: 0.25, ..own },
        ),
        (
            json!({"KHR_materials_transmission": {"transmissionFactor": 0.5},
                "KHR_materials_ior": {"ior": 1.25}}),
            Layers { transmission: 0.5, ior: 1.25, ..own },
        ),
        // A rough pane.
        (
            json!({"KHR_materials_transmission": {"transmissionFactor": 1.0}}),
            Layers { transmission: 1.0, ..own },
        ),
        (
            json!({"KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.5,
                "diffuseTransmissionColorFactor": [1.0, 0.5, 0.25]}}),
            Layers {
                diffuse_transmission: 0.5,
                diffuse_transmission_color: [1.0, 0.5, 0.25],
                ..own
            },
        ),
        (
            json!({"KHR_materials_specular":
                {"specularFactor": 0.5, "specularColorFactor": [1.0, 0.5, 1.0]}}),
            Layers { specular: 0.5, specular_color: [1.0, 0.5, 1.0], ..own },
        ),
    ];
    for (extensions, layers) in cases {
        let document = with(matte(), extensions.clone());
        assert_eq!(warnings(&document), "", "{extensions}");
        assert_eq!(model(&document), SurfaceModel::Layered { layers }, "{extensions}");
    }
}

#[test]
fn what_adds_nothing_is_metallic_roughness() {
    let nothing = json!({"KHR_materials_clearcoat": {}, "KHR_materials_sheen": {},
        "KHR_materials_transmission": {}, "KHR_materials_diffuse_transmission": {},
        "KHR_materials_specular": {}});
    let document = with(json!({"metallicFactor": 0.5}), nothing);
    assert_eq!(warnings(&document), "");
    assert!(matches!(model(&document), SurfaceModel::MetallicRoughness { .. }));
    // Metal lets nothing through.
    let metal = with(json!({}), json!({"KHR_materials_transmission": {"transmissionFactor": 0.5}}));
    assert!(matches!(model(&metal), SurfaceModel::MetallicRoughness { .. }));
    // Smooth panes stay such that lamps behind them are found.
    let clear = json!({"metallicFactor": 0.0, "roughnessFactor": 0.0});
    let pane = with(clear, json!({"KHR_materials_transmission": {"transmissionFactor": 1.0}}));
    assert!(matches!(model(&pane), SurfaceModel::ThinDielectric { .. }));
}

/// What is left of light that goes through the first material, but for pictures and vertices.
fn transmitted(document: &Value) -> [f32; 3] {
    let optics = baked(document).optics;
    let painting = optics.painting.expect("it has a color");
    let stain = &painting.of(0).expect("it has a color").stain;
    stain.transmitted.as_ref().expect("it has a color").factor
}

#[test]
fn colored_panes_are_stained() {
    let through = || json!({"KHR_materials_transmission": {"transmissionFactor": 1.0}});
    let green = json!({"metallicFactor": 0.0, "roughnessFactor": 0.0,
        "baseColorFactor": [0.25, 0.5, 0.25, 1.0]});
    let document = with(green, through());
    let pane = SurfaceModel::ThinDielectric { ior: [1.5; 3], exterior_ior: [1.0; 3] };
    assert_eq!(model(&document), pane);
    assert_eq!(transmitted(&document), [0.25, 0.5, 0.25]);
    assert_eq!(warnings(&document), "");
    // So are those whose color is a picture, or that of their vertices.
    for by_vertices in [false, true] {
        let mut document = painted();
        let pbr = &mut document["materials"][0]["pbrMetallicRoughness"];
        *pbr = match by_vertices {
            false => json!({"metallicFactor": 0.0, "roughnessFactor": 0.0,
                "baseColorTexture": {"index": 0}}),
            true => json!({"metallicFactor": 0.0, "roughnessFactor": 0.0}),
        };
        if by_vertices {
            document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(5);
        }
        document["materials"][0]["extensions"] = through();
        assert_eq!(model(&document), pane, "{by_vertices}");
        assert_eq!(transmitted(&document), [1.0; 3], "{by_vertices}");
        assert_eq!(warnings(&document), "", "{by_vertices}");
    }
}

#[test]
fn what_is_approximated_is_said() {
    let solid = json!({"KHR_materials_transmission": {"transmissionFactor": 0.5},
        "KHR_materials_volume": {"thicknessFactor": 1.0}});
    let said = warnings(&with(json!({"metallicFactor": 0.0}), solid));
    assert!(said.contains("without being refracted"), "{said}");
    let coated = json!({"KHR_materials_transmission": {"transmissionFactor": 1.0},
        "KHR_materials_volume": {"thicknessFactor": 1.0},
        "KHR_materials_clearcoat": {"clearcoatFactor": 1.0}});
    let said = warnings(&with(json!({"metallicFactor": 0.0}), coated));
    assert!(said.contains("are ignored on glass"), "{said}");
    let bright = json!({"KHR_materials_specular": {"specularColorFactor": [25.0, 5.0, 0.0]}});
    let said = warnings(&with(json!({}), bright));
    assert!(said.contains("more than facets of index 10 reflect"), "{said}");
}

#[test]
fn bright_facets_are_of_a_greater_index() {
    // Index 1.5 reflects 0.04 towards the normal; four times that is what 7 / 3 does.
    let bright = json!({"KHR_materials_specular": {"specularColorFactor": [4.0, 1.0, 0.0]}});
    let document = with(json!({"metallicFactor": 0.0}), bright.clone());
    assert_eq!(warnings(&document), "");
    let SurfaceModel::Layered { layers } = model(&document) else { panic!("not layered") };
    assert_eq!(layers.specular_color, [1.0, 0.25, 0.0]);
    assert!((layers.ior - 7.0 / 3.0).abs() < 1e-6, "{}", layers.ior);
    // Glass is refracted as it says.
    let mut extensions = bright;
    extensions["KHR_materials_transmission"] = json!({"transmissionFactor": 1.0});
    extensions["KHR_materials_volume"] = json!({"thicknessFactor": 1.0});
    let clear = json!({"metallicFactor": 0.0, "roughnessFactor": 0.0});
    let model = model(&with(clear, extensions));
    assert_eq!(model, SurfaceModel::Dielectric { ior: 1.5, exterior_ior: 1.0 });
}

#[test]
fn colored_solids_absorb_their_color() {
    let glass = |distance: Value| {
        let pbr = json!({"metallicFactor": 0.0, "roughnessFactor": 0.0,
            "baseColorFactor": [0.25, 0.5, 1.0, 1.0]});
        let extensions = json!({"KHR_materials_transmission": {"transmissionFactor": 1.0},
            "KHR_materials_volume": {"thicknessFactor": 0.5, "attenuationDistance": distance,
                "attenuationColor": [0.5, 1.0, 1.0]}});
        let mut document = with(pbr, extensions);
        // The thickness is in the mesh's own space: 1.5 of the world.
        document["nodes"][1]["scale"] = json!([3.0, 3.0, 3.0]);
        document
    };
    for (distance, red) in [(Value::Null, 0.25_f32), (json!(1.5), 0.125)] {
        let document = glass(distance);
        assert!(warnings(&document).contains("absorbs over its thicknessFactor"));
        let optics = baked(&document).optics;
        assert_eq!(
            optics.materials[0].model,
            SurfaceModel::Dielectric { ior: 1.5, exterior_ior: 1.0 }
        );
        let left = optics.media[0].sigma_a.map(|sigma| (-1.5 * sigma).exp());
        for (found, wanted) in left.into_iter().zip([red, 0.5, 1.0]) {
            assert!((found - wanted).abs() < 1e-6, "{left:?}");
        }
    }
    // A mesh that a node makes flat is there all the same.
    let mut flat = glass(Value::Null);
    flat["nodes"][1]["scale"] = json!([3.0, 0.0, 3.0]);
    flat["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([0, 0, 0, 1]);
    flat["materials"][0]["extensions"]["KHR_materials_volume"]["thicknessFactor"] = json!(1e-36);
    load_json(&flat).unwrap();
}

#[test]
fn pictures_of_metal_may_leave_glass() {
    // As exporters write it: the share of metal is the picture's alone, and mostly 0.
    let mut document = painted();
    document["materials"][0] = json!({"name": "painted",
        "pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 0}},
        "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1.0},
            "KHR_materials_volume": {"thicknessFactor": 1.0, "attenuationDistance": 1.0,
                "attenuationColor": [0.5, 1.0, 1.0]}}});
    let optics = baked(&document).optics;
    assert!(optics.materials[0].model.transmits());
    assert_eq!(optics.media.len(), 1);
    // Where all is metal nothing goes through.
    let pbr = &mut document["materials"][0]["pbrMetallicRoughness"];
    *pbr = json!({"metallicFactor": 1.0});
    document["materials"][0]["extensions"]["KHR_materials_clearcoat"] =
        json!({"clearcoatFactor": 1.0});
    assert!(!model(&document).transmits());
}

#[test]
fn factors_that_are_none_are_refused() {
    refused(&[
        (
            |d| *d = with(json!({}), json!({"KHR_materials_clearcoat": {"clearcoatFactor": 2}})),
            &["material 0", "KHR_materials_clearcoat.clearcoatFactor", "within [0, 1]"],
        ),
        (
            |d| {
                let rough = json!({"clearcoatRoughnessFactor": "very"});
                *d = with(json!({}), json!({"KHR_materials_clearcoat": rough}));
            },
            &["KHR_materials_clearcoat.clearcoatRoughnessFactor", "must be a number"],
        ),
        (
            |d| *d = with(json!({}), json!({"KHR_materials_sheen": {"sheenColorFactor": [1, 1]}})),
            &["KHR_materials_sheen.sheenColorFactor", "three numbers"],
        ),
        (
            |d| {
                let color = json!({"sheenColorFactor": [1, -1, 1], "sheenRoughnessFactor": -1});
                *d = with(json!({}), json!({"KHR_materials_sheen": color}));
            },
            &["sheenColorFactor", "sheenRoughnessFactor", "within [0, 1]"],
        ),
    ]);
}

#[test]
fn what_is_written_is_read_again() {
    let extensions = json!({
        "KHR_materials_ior": {"ior": 1.25},
        "KHR_materials_transmission": {"transmissionFactor": 0.5},
        "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.25,
            "diffuseTransmissionColorFactor": [1.0, 0.5, 0.25]},
        "KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.25},
        "KHR_materials_sheen":
            {"sheenColorFactor": [0.5, 0.25, 0.125], "sheenRoughnessFactor": 0.5},
        "KHR_materials_specular":
            {"specularFactor": 0.5, "specularColorFactor": [1.0, 0.5, 1.0]},
    });
    let document = with(json!({"metallicFactor": 0.5, "roughnessFactor": 0.5}), extensions);
    let world = load_json(&document).unwrap();
    let written = Written::of(&world).unwrap_or_else(|error| panic!("{error}"));
    let path = scratch("layers.gltf");
    written.save(&path).unwrap();
    let again = load(&path).unwrap_or_else(|error| panic!("{error}"));
    std::fs::remove_file(&path).unwrap();
    let told = |world: &World| {
        let text = world.describe();
        let (_, told) = text.split_once(": layers").expect("it is there");
        told.lines().next().map(str::to_owned)
    };
    assert_eq!(told(&world), told(&again));
    assert!(told(&world).is_some_and(|told| told.contains("clear coat of share 0.5")));
}
