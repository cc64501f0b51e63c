//! What glTF files mean: geometry, materials, lights and the extension's three spellings.

use std::collections::BTreeSet;
use std::f32::consts::PI;
use std::fs;
use std::path::Path;

use crate::common::{data_uri, good, load_json, scratch, square_bytes};
use glam::Vec3;
use serde_json::{Value, json};
use sunstone::internals::scene::baked::BakedScene;
use sunstone::internals::scene::emitter::EmitterModel;
use sunstone::internals::scene::world::SurfaceModel;
use sunstone::internals::scene::{bake, extension_keys, load};
use sunstone::internals::spectrum::{Carried, illuminant_names, index_names, metal_names};

#[track_caller]
pub fn baked(document: &Value) -> BakedScene<3> {
    let world = load_json(document).unwrap_or_else(|error| panic!("{error}"));
    bake(&world, &Carried::RGB).unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
pub fn warnings(document: &Value) -> String {
    load_json(document).unwrap_or_else(|error| panic!("{error}")).warnings().join("\n")
}

fn normal(scene: &BakedScene<3>, triangle: usize) -> Vec3 {
    let [a, b, c] = scene.shapes.triangles[triangle].corners;
    (b - a).cross(c - a).normalize()
}

#[test]
fn the_schema_has_the_loaders_keys() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/sunstone.schema.json");
    let schema: Value = serde_json::from_slice(&fs::read(path).unwrap()).unwrap();
    let definitions = schema["$defs"].as_object().unwrap();
    let with_keys: BTreeSet<&str> = definitions
        .iter()
        .filter(|(_, definition)| definition["properties"].is_object())
        .map(|(name, _)| name.as_str())
        .collect();
    assert_eq!(with_keys, extension_keys().map(|(name, _)| name).collect());
    for (name, known) in extension_keys() {
        let properties = definitions[name]["properties"].as_object().unwrap();
        let documented: BTreeSet<&str> = properties.keys().map(String::as_str).collect();
        assert_eq!(documented, known.iter().copied().collect(), "{name}");
        assert_eq!(definitions[name]["additionalProperties"], json!(false), "{name}");
        assert!(properties.values().all(|key| key["description"].is_string()), "{name}");
    }
    let mut document = good();
    document["materials"][0]["extras"] = json!({"sunstone": {"bsdf": ""}});
    document["materials"][0]["extensions"] = json!({});
    let error = load_json(&document).unwrap_err();
    let models = schema["$defs"]["material"]["properties"]["bsdf"]["enum"].as_array().unwrap();
    let models: Vec<&str> = models.iter().filter_map(Value::as_str).collect();
    assert!(error.ends_with(&format!("use one of {}", models.join(", "))), "{error}");
    for (pointer, names) in [
        ("material/properties/metal/enum", metal_names()),
        ("substance/enum", index_names()),
        ("emission/properties/illuminant/enum", illuminant_names()),
    ] {
        let listed = schema.pointer(&format!("/$defs/{pointer}")).unwrap();
        assert_eq!(listed, &json!(names), "{pointer}");
    }
}

#[test]
fn mirrored_meshes_keep_their_front() {
    for scale in [[1, 1, 1], [-1, 1, 1], [1, -2, 1], [-1, -1, 1]] {
        let mut document = good();
        document["nodes"][1]["scale"] = json!(scale);
        assert!(normal(&baked(&document), 0).z > 0.9, "{scale:?}");
    }
    let mut document = good();
    document["nodes"][1]["scale"] = json!([1, 1, -1]);
    let scene = baked(&document);
    assert!(normal(&scene, 0).z < -0.9);
    assert!(scene.shapes.shading_normals.is_empty(), "normals follow their mesh");
}

#[test]
fn children_move_with_their_parents() {
    let mut document = good();
    document["scenes"][0]["nodes"] = json!([0, 1, 3]);
    document["nodes"][1]["children"] = json!([2]);
    document["nodes"][1]["scale"] = json!([2, 2, 2]);
    document["nodes"][1]["translation"] = json!([1, 0, 0]);
    document["nodes"][0]["translation"] = json!([0, 0, 9]);
    let scene = baked(&document);
    assert_eq!(scene.shapes.spheres[0].center, Vec3::new(1.0, 0.0, 4.0));
    assert_eq!(scene.shapes.spheres[0].radius, 1.0);
    assert_eq!(scene.shapes.triangles[0].corners[0], Vec3::new(-1.0, -2.0, 0.0));
}

/// Replaces the normals of the square's four vertices.
fn with_normals(normals: [[f32; 3]; 4]) -> Value {
    let mut bytes = square_bytes();
    let new: Vec<u8> = normals.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes[48..96].copy_from_slice(&new);
    let mut document = good();
    document["buffers"][0]["uri"] = data_uri(&bytes).into();
    document
}

#[test]
fn shading_normals_stay_on_the_front() {
    let up = [0.0, 0.0, 1.0];
    let scene = baked(&with_normals([[0.6, 0.0, 0.8], up, up, up]));
    assert_eq!(scene.shapes.shading_normals.len(), 2);
    assert!((scene.shapes.shading_normals[0][0] - Vec3::new(0.6, 0.0, 0.8)).length() < 1e-6);

    let document = with_normals([[0.6, 0.0, -0.8], [0.0; 3], [1.0, 0.0, 0.0], up]);
    assert!(warnings(&document).contains("normal on the back"));
    let scene = baked(&document);
    for (triangle, normals) in scene.shapes.shading_normals.iter().enumerate() {
        for shading in normals {
            assert!(shading.dot(normal(&scene, triangle)) > 0.0);
            assert!((shading.length() - 1.0).abs() < 1e-6);
        }
    }
    assert!((scene.shapes.shading_normals[0][0] - Vec3::new(0.6, 0.0, 0.8)).length() < 1e-6);
    assert_eq!(scene.shapes.shading_normals[0][1], Vec3::Z);
    assert!(baked(&with_normals([[0.0, 0.0, 7.0]; 4])).shapes.shading_normals.is_empty());
}

#[test]
fn strips_fans_and_lists_without_indices() {
    // The square's vertices in the order of the buffer are a fan; a strip crosses over.
    for (mode, count) in [(6, 2), (5, 2)] {
        let mut document = good();
        let primitive = &mut document["meshes"][0]["primitives"][0];
        primitive["mode"] = json!(mode);
        primitive["indices"] = Value::Null;
        let scene = baked(&document);
        assert_eq!(scene.shapes.triangles.len(), count);
        assert!(normal(&scene, 0).z > 0.9);
        assert_eq!(normal(&scene, 1).z > 0.9, mode == 6);
    }
    let mut document = good();
    document["meshes"][0]["primitives"][0]["indices"] = Value::Null;
    document["accessors"][0]["count"] = json!(3);
    document["accessors"][1]["count"] = json!(3);
    assert_eq!(baked(&document).shapes.triangles.len(), 1);
}

#[test]
fn interleaved_vertices_and_external_buffers() {
    let square = square_bytes();
    let mut bytes: Vec<u8> = (0..4)
        .flat_map(|v| [&square[12 * v..][..12], &square[48 + 12 * v..][..12]].concat())
        .collect();
    bytes.extend(&square[96..]);
    let path = scratch("external.gltf");
    let buffer = format!("{} b.bin", path.file_stem().unwrap().to_str().unwrap());
    fs::write(path.with_file_name(&buffer), &bytes).unwrap();
    let mut document = good();
    document["bufferViews"][0] = json!({"buffer": 0, "byteLength": 96, "byteStride": 24});
    document["bufferViews"][1] = document["bufferViews"][0].clone();
    document["accessors"][1]["byteOffset"] = json!(12);
    document["buffers"][0]["uri"] = buffer.replace(' ', "%20").into();
    fs::write(&path, document.to_string()).unwrap();
    let scene = bake(&load(&path).unwrap(), &Carried::RGB).unwrap();
    let reference = baked(&good());
    assert_eq!(scene.shapes.triangles, reference.shapes.triangles);
    assert_eq!(scene.shapes.shading_normals, reference.shapes.shading_normals);
}

#[test]
fn the_extension_has_three_spellings() {
    let reference = baked(&good()).optics.materials;
    let mut object = good();
    object["materials"][0]["extensions"] = json!({});
    object["materials"][0]["extras"] = json!({"sunstone": {"bsdf": "diffuse", "reflectance": 0.5}});
    let mut flat = object.clone();
    flat["materials"][0]["extras"] =
        json!({"sunstone_bsdf": "diffuse", "sunstone_reflectance": 0.5});
    let mut both = good();
    both["materials"][0]["extras"] = json!({"sunstone_reflectance": 0.5, "unrelated": [1]});
    for document in [object, flat, both] {
        assert_eq!(baked(&document).optics.materials, reference);
    }
}

#[test]
fn metallic_roughness() {
    let with = |material: Value| {
        let mut document = good();
        document["materials"][0] = material;
        document
    };
    let metal = with(json!({"pbrMetallicRoughness":
        {"baseColorFactor": [1.0, 0.5, 0.25, 1.0], "roughnessFactor": 0.0}}));
    let row = baked(&metal).optics.materials[0].clone();
    let SurfaceModel::Conductor { eta, k } = row.model else { panic!("{row:?}") };
    for (f0, channel) in [0.999f32, 0.5, 0.25].into_iter().zip(0..) {
        let (eta, k) = (eta[channel], k[channel]);
        let found = ((eta - 1.0).powi(2) + k * k) / ((eta + 1.0).powi(2) + k * k);
        assert!((found - f0).abs() < 1e-5, "{found} {f0}");
    }
    let mut glass = json!({
        "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.0},
        "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1.0},
                       "KHR_materials_ior": {"ior": 1.33}}});
    let row = baked(&with(glass.clone())).optics.materials[0].clone();
    assert_eq!(row.model, SurfaceModel::ThinDielectric { ior: [1.33; 3], exterior_ior: [1.0; 3] });
    glass["extensions"]["KHR_materials_volume"] = json!({"thicknessFactor": 0.5,
        "attenuationDistance": 2.0, "attenuationColor": [1.0, 0.5, 0.25]});
    let solid = baked(&with(glass)).optics;
    let model = SurfaceModel::Dielectric { ior: 1.33, exterior_ior: 1.0 };
    assert_eq!(solid.materials[0].model, model);
    let absorbed = solid.media[0].sigma_a.map(|sigma| (-2.0 * sigma).exp());
    for (found, color) in absorbed.into_iter().zip([1.0_f32, 0.5, 0.25]) {
        assert!((found - color).abs() < 1e-6, "{absorbed:?}");
    }
    let diffuse = |reflectance| SurfaceModel::Diffuse { reflectance };
    let mut none = good();
    none["meshes"][0]["primitives"][0]["material"] = Value::Null;
    assert_eq!(baked(&none).optics.materials[0].model, diffuse([0.8; 3]));
    assert!(warnings(&none).contains("has no material"));
}

#[test]
fn no_back_is_black_but_where_the_file_says_so() {
    let two_sided = |material: Value| {
        let mut document = good();
        document["materials"][0] = material;
        baked(&document).optics.materials[0].two_sided
    };
    // glTF's own, of which viewers leave out the backs.
    assert!(two_sided(json!({})));
    assert!(two_sided(json!({"extensions": {"KHR_materials_unlit": {}}})));
    let coated = json!({"KHR_materials_clearcoat": {"clearcoatFactor": 1.0}});
    assert!(two_sided(json!({"extensions": coated})));
    // Lamps, and those of the extension, have the sides that they state.
    for sides in [false, true] {
        let lamp = json!({"emissiveFactor": [1, 1, 1], "doubleSided": sides});
        assert_eq!(two_sided(lamp), sides);
        let own = json!({"extras": {"sunstone": {"bsdf": "diffuse"}}, "doubleSided": sides});
        assert_eq!(two_sided(own), sides);
    }
}

#[test]
fn emitters_and_their_probabilities() {
    let mut document = good();
    document["materials"][0]["doubleSided"] = json!(true);
    document["materials"][1]["emissiveFactor"] = json!([1, 1, 1]);
    document["materials"][1]["extensions"]["KHR_materials_emissive_strength"] =
        json!({"emissiveStrength": 3.0});
    document["scenes"][0]["extras"] = json!({"sunstone": {"environment": {"radiance": 0.125}}});
    let scene = baked(&document);
    let models: Vec<EmitterModel> =
        scene.optics.emitters.iter().map(|row| row.model.clone()).collect();
    use EmitterModel::{Environment, Point, Sphere, Triangle};
    assert!(
        matches!(models[..], [Triangle(_), Triangle(_), Sphere(_), Point(_), Environment(_)]),
        "{models:?}"
    );
    assert_eq!(*scene.optics.emitter_of_primitive, [0, 1, 2]);
    assert_eq!(scene.optics.skies, 4..5);
    assert_eq!(scene.optics.radiance_of(2), [3.0; 3]);
    assert_eq!(scene.optics.radiance_of(3), [1.0; 3], "683 candela are 1 W/sr");
    let r2 = scene.shapes.bounds.radius.powi(2);
    let powers = [
        PI * 2.0 * 2.0 * (1.75 / 3.0),
        PI * 2.0 * 2.0 * (1.75 / 3.0),
        PI * PI * 3.0,
        4.0 * PI,
        4.0 * PI * PI * r2 * 0.125,
    ];
    let total: f32 = powers.iter().sum();
    for (row, power) in scene.optics.emitters.iter().zip(powers) {
        assert!((row.probability - power / total).abs() < 1e-6, "{:?}", row.model);
    }
}

#[test]
fn spots_directional_lights_and_units() {
    let mut document = good();
    document["nodes"][3]["rotation"] = json!([-0.5f32.sqrt(), 0.0, 0.0, 0.5f32.sqrt()]);
    document["extensions"]["KHR_lights_punctual"]["lights"][0] = json!({
        "type": "spot", "intensity": 2.0, "color": [1.0, 0.5, 0.25], "range": 10.0,
        "spot": {"innerConeAngle": 0.3, "outerConeAngle": 0.3},
        "extensions": {"SUNSTONE_polarization": {"units": "radiometric"}}});
    assert!(warnings(&document).contains("range is ignored"));
    let scene = baked(&document);
    let row = scene.optics.emitters.last().unwrap();
    assert_eq!(scene.optics.lamps.last(), Some(&[2.0, 1.0, 0.5]));
    let EmitterModel::Spot(spot) = row.model else { panic!("{row:?}") };
    assert!((spot.direction - Vec3::NEG_Y).length() < 1e-6);
    assert!(spot.cos_outer < spot.cos_inner && spot.cos_inner == 0.3f32.cos());
    assert_eq!(spot.position, Vec3::new(0.0, 3.0, 0.0));

    document["extensions"]["KHR_lights_punctual"]["lights"][0] =
        json!({"type": "directional", "intensity": 683.0});
    let scene = baked(&document);
    let row = scene.optics.emitters.last().unwrap();
    assert_eq!(scene.optics.lamps.last(), Some(&[1.0; 3]));
    let EmitterModel::Directional(sun) = row.model else { panic!("{row:?}") };
    assert!((sun.direction - Vec3::NEG_Y).length() < 1e-6);
    assert!(scene.shapes.bounds.center.y.abs() < 1e-6, "a sun is nowhere");
}

#[test]
fn an_environment_alone_is_a_scene() {
    let document = json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"camera": 0}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}],
        "extras": {"sunstone_environment": {"radiance": [1, 2, 3]}}});
    let scene = baked(&document);
    assert_eq!((&scene.optics.skies, scene.optics.emitters[0].probability), (&(0..1), 1.0));
    assert_eq!(scene.optics.radiance_of(0), [1.0, 2.0, 3.0]);
    assert_eq!((scene.optics.materials.len(), scene.camera.resolution), (1, None));
    assert!(scene.shapes.bounds.radius > 0.0);
    assert!(matches!(scene.optics.emitters[0].model, EmitterModel::Environment(_)));
}

#[test]
fn what_is_ignored_is_said() {
    let mut document = good();
    document["extensionsUsed"] = json!(["EXT_sparkle"]);
    for at in 0..40_000 {
        let part = json!({"attributes": {"POSITION": 0, "COLOR_0": 1}, "mode": 1});
        document["meshes"].as_array_mut().unwrap().push(json!({"primitives": [part]}));
        document["nodes"].as_array_mut().unwrap().push(json!({"mesh": at + 2}));
        document["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(at + 4));
    }
    document["materials"][0]["extensions"]["KHR_materials_glitter"] = json!({});
    document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(1);
    document["cameras"][0]["extensions"] =
        json!({"SUNSTONE_polarization": {"film": {"resolution": [64, 32]}}});
    let said = warnings(&document);
    assert_eq!(said.lines().count(), 3, "{said}");
    for expected in ["EXT_sparkle, KHR_materials_glitter", "top to bottom", "39999 others"] {
        assert!(said.contains(expected), "no `{expected}` in: {said}");
    }
}

#[test]
fn the_same_file_gives_the_same_tables() {
    let [first, second] = [0, 1].map(|_| format!("{:?}", baked(&good())));
    assert_eq!(first, second);
    let text = load_json(&good()).unwrap().describe();
    for expected in ["2 triangles", "1 analytic sphere", "smooth dielectric, ior 1.5", "Point"] {
        assert!(text.contains(expected), "no `{expected}` in: {text}");
    }
}
