//! Every bad scene is refused with an error that names the object, the field and the remedy.

use std::fs;

use crate::common::{data_uri, glb, good, load_bytes, load_json, scratch, square_bytes};
use serde_json::{Value, json};
use sunstone::internals::scene::{Reading, View, bake, load, load_with};
use sunstone::internals::spectrum::Carried;

/// What is done to the good document, and what the error must say.
pub type Case = (fn(&mut Value), &'static [&'static str]);

#[track_caller]
pub fn refused(cases: &[Case]) {
    for (number, (spoil, expected)) in cases.iter().enumerate() {
        let mut document = good();
        spoil(&mut document);
        let Err(error) = load_json(&document) else {
            panic!("case {number} ({expected:?}) was accepted");
        };
        assert!(error.contains("scene.gltf: "), "case {number} names no file: {error}");
        for part in *expected {
            assert!(error.contains(part), "case {number}: no `{part}` in: {error}");
        }
    }
}

fn material(document: &mut Value, body: Value) {
    document["materials"][0]["extensions"]["SUNSTONE_polarization"] = body;
}

fn camera(document: &mut Value, body: Value) {
    document["cameras"][0]["extensions"] = json!({"SUNSTONE_polarization": body});
}

/// Replaces the material by plain glTF.
fn pbr(document: &mut Value, body: Value) {
    document["materials"][0] = json!({"name": "glow", "pbrMetallicRoughness": body});
}

fn positions(document: &mut Value, positions: [[f32; 3]; 4]) {
    let mut bytes: Vec<u8> =
        positions.as_flattened().iter().flat_map(|float| float.to_le_bytes()).collect();
    bytes.extend(&square_bytes()[48..]);
    document["buffers"][0]["uri"] = data_uri(&bytes).into();
}

#[test]
fn the_good_document_is_good() {
    let world = load_json(&good()).unwrap();
    assert_eq!(world.warnings(), [] as [String; 0]);
    assert_eq!(world.name(), "good");
    let world = load_bytes("scene.glb", &glb(good(), &square_bytes())).unwrap();
    assert_eq!(bake(&world, &Carried::RGB).unwrap().shapes.triangles.len(), 2);
}

#[test]
fn structure() {
    refused(&[
        (|d| d["asset"]["version"] = json!("1.0"), &["asset.version", "glTF 2.0"]),
        (
            |d| d["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]),
            &["extensionsRequired", "`KHR_draco_mesh_compression`", "gltf-pipeline"],
        ),
        (
            |d| d["extensionsRequired"] = json!(["A", "B"]),
            &["`A` is not supported", "`B` is not supported", "export without"],
        ),
        (|d| d["scenes"] = json!([]), &["scene: 0 is not an index", "0 scenes"]),
        (
            |d| {
                d["scenes"] = json!([]);
                d["scene"] = Value::Null;
                d["nodes"] = json!([]);
            },
            &["no scene"],
        ),
        (|d| d["scenes"][0]["nodes"] = json!([0, 3, 9]), &["9 is not an index"]),
        (|d| d["nodes"][1]["mesh"] = json!(7), &["node 1 \"panel\", mesh", "7", "2 meshes"]),
        (|d| d["nodes"][1]["mesh"] = json!(4_294_967_296u64), &["node 1", "4294967296"]),
        (|d| d["nodes"][1]["mesh"] = json!(-1), &["node 1 \"panel\", mesh", "-1"]),
        (|d| d["nodes"][1]["translation"] = json!("up"), &["node 1 \"panel\"", "invalid type"]),
        (|d| d["nodes"][0]["camera"] = json!(1), &["node 0 \"eye\", camera", "1 cameras"]),
        (
            |d| d["nodes"][3]["extensions"]["KHR_lights_punctual"]["light"] = json!(2),
            &["node 3 \"lamp\", KHR_lights_punctual.light", "1 lights"],
        ),
        (|d| d["scenes"][0]["nodes"] = json!([0, 9]), &["scene 0 \"good\", nodes", "9"]),
        (|d| d["nodes"][1]["children"] = json!([9]), &["node 1 \"panel\", children", "9"]),
        (|d| d["nodes"][1]["children"] = json!([1]), &["node 1 \"panel\"", "cycle"]),
        (
            |d| {
                d["nodes"][1]["children"] = json!([2]);
                d["nodes"][2]["children"] = json!([1]);
            },
            &["node 1 \"panel\"", "cycle"],
        ),
        (
            |d| {
                d["nodes"][1]["children"] = json!([3]);
                d["nodes"][2]["children"] = json!([3]);
            },
            &["node 3 \"lamp\"", "node 1 \"panel\" and node 2 \"ball\""],
        ),
    ]);
}

#[test]
fn transforms() {
    refused(&[
        (|d| d["nodes"][2]["scale"] = json!([1, 0, 1]), &["node 2 \"ball\"", "singular"]),
        (|d| d["nodes"][3]["scale"] = json!([1, 0, 1]), &["node 3 \"lamp\"", "singular"]),
        (
            |d| d["nodes"][1]["scale"] = json!([1e200, 1e200, 1]),
            &["node 1 \"panel\"", "not finite"],
        ),
        (|d| d["nodes"][1]["rotation"] = json!([0, 0, 0, 0]), &["node 1", "rotation", "length 1"]),
        (
            |d| d["nodes"][2]["matrix"] = json!([0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]),
            &["node 2", "singular"],
        ),
        (
            |d| d["nodes"][1]["matrix"] = json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            &["node 1", "matrix", "last row"],
        ),
        (|d| d["nodes"][2]["scale"] = json!([1, 2, 1]), &["node 2 \"ball\"", "sphere", "scale"]),
        (|d| d["nodes"][0]["scale"] = json!([-1, 1, 1]), &["node 0 \"eye\"", "mirrored"]),
        (
            |d| d["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            &["node 0 \"eye\"", "sheared"],
        ),
    ]);
}

#[test]
fn meshes() {
    refused(&[
        (
            |d| d["meshes"][0]["primitives"][0]["attributes"] = json!({"NORMAL": 1}),
            &["mesh 0 \"square\", primitive 0", "no POSITION"],
        ),
        (
            |d| d["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(8),
            &["mesh 0 \"square\", primitive 0, POSITION", "8"],
        ),
        (|d| d["meshes"][0]["primitives"][0]["indices"] = json!(3), &["indices", "3 accessors"]),
        (|d| d["meshes"][0]["primitives"][0]["material"] = json!(2), &["material", "2 materials"]),
        (|d| d["meshes"][0]["primitives"][0]["mode"] = json!(9), &["mesh 0", "mode", "not known"]),
        (
            |d| d["meshes"][0]["extras"] = json!({"sunstone_bsdf": "diffuse"}),
            &["mesh 0 \"square\", extras.sunstone_bsdf", "use its material or node"],
        ),
        (|d| d["accessors"][2]["count"] = json!(5), &["mesh 0", "5 corners"]),
        (
            |d| positions(d, [[0.0; 3], [f32::NAN; 3], [1.0; 3], [0.0; 3]]),
            &["mesh 0", "POSITION", "vertex 1 is not finite"],
        ),
        (
            |d| positions(d, [[0.0; 3], [1.0; 3], [f32::INFINITY; 3], [0.0; 3]]),
            &["mesh 0", "vertex 2 is not finite"],
        ),
        (
            |d| {
                let mut bytes = square_bytes();
                bytes[98] = 4;
                d["buffers"][0]["uri"] = data_uri(&bytes).into();
            },
            &["mesh 0", "indices", "4 is not one of the 4 vertices"],
        ),
    ]);
}

#[test]
fn accessors_and_buffers() {
    refused(&[
        (|d| d["accessors"][0]["count"] = json!(5), &["accessor 0", "5 elements do not fit"]),
        (|d| d["accessors"][0]["count"] = json!(0), &["accessor 0", "0 elements"]),
        (|d| d["accessors"][0]["count"] = json!(u64::MAX), &["mesh 0", "vertices and corners"]),
        (|d| d["accessors"][1]["count"] = json!(3), &["NORMAL", "3 normals for 4 vertices"]),
        (|d| d["accessors"][0]["byteOffset"] = json!(u64::MAX), &["accessor 0", "do not fit"]),
        (|d| d["accessors"][0]["type"] = json!("VEC2"), &["POSITION, accessor 0", "VEC3"]),
        (|d| d["accessors"][0]["componentType"] = json!(5125), &["accessor 0", "FLOAT"]),
        (
            |d| d["accessors"][2]["componentType"] = json!(5126),
            &["indices, accessor 2", "unsigned"],
        ),
        (|d| d["accessors"][0]["bufferView"] = json!(3), &["accessor 0, bufferView", "3"]),
        (|d| d["bufferViews"][0]["buffer"] = json!(1), &["bufferView 0, buffer", "1 buffers"]),
        (|d| d["bufferViews"][0]["byteLength"] = json!(u64::MAX), &["bufferView 0", "buffer 0"]),
        (|d| d["bufferViews"][0]["byteOffset"] = json!(80), &["bufferView 0", "108 bytes"]),
        (|d| d["bufferViews"][0]["byteStride"] = json!(8), &["bufferView 0, byteStride", "12"]),
        (|d| d["bufferViews"][0]["byteStride"] = json!(u64::MAX), &["byteStride", "252"]),
        (|d| d["buffers"][0]["byteLength"] = json!(1u64 << 40), &["buffer 0, byteLength", "108"]),
        (|d| d["buffers"][0]["uri"] = Value::Null, &["buffer 0", "no uri"]),
        (|d| d["buffers"][0]["uri"] = json!("data:;base64,@@"), &["buffer 0, uri", "base64"]),
        (|d| d["buffers"][0]["uri"] = json!("data:plain"), &["buffer 0, uri", "without a comma"]),
        (|d| d["buffers"][0]["uri"] = json!("data:,%41b"), &["buffer 0, byteLength", "are 2"]),
        (|d| d["buffers"][0]["uri"] = json!("no such.bin"), &["buffer 0, uri", "no such.bin"]),
        (|d| d["buffers"][0]["uri"] = json!("/etc/passwd"), &["uri", "not a path relative"]),
        (|d| d["buffers"][0]["uri"] = json!("../../Cargo.toml"), &["uri", "cannot read"]),
        (|d| d["buffers"][0]["uri"] = json!(".."), &["uri", "outside", "--allow-outside"]),
        (|d| d["buffers"][0]["uri"] = json!("%2E%2e%2F"), &["uri", "outside", "--allow-outside"]),
        (|d| d["buffers"][0]["uri"] = json!("https://a.b/c"), &["uri", "not a path relative"]),
        (|d| d["buffers"][0]["uri"] = json!("."), &["buffer 0, uri", "not a file"]),
    ]);
}

#[test]
fn materials_of_the_extension() {
    refused(&[
        (
            |d| material(d, json!({"bsdf": "diffuse", "shiny": 1})),
            &[
                "material 0 \"glow\", SUNSTONE_polarization.shiny",
                "axis_deg, birefringence, blocked, bsdf, bump_scale, bump_texture, coverage",
            ],
        ),
        (|d| material(d, json!({"bsdf": "velvet"})), &["`velvet` is not a model", "conductor"]),
        (|d| material(d, json!({"bsdf": "rough_dielectric"})), &["alpha", "is missing"]),
        (
            |d| material(d, json!({"bsdf": "diffuse", "alpha": 0.1})),
            &["alpha", "means nothing for a diffuse"],
        ),
        (|d| material(d, json!({"bsdf": 3})), &["bsdf", "not a string"]),
        (|d| material(d, json!([])), &["SUNSTONE_polarization", "not an object"]),
        (|d| material(d, json!({"reflectance": 0.5})), &["reflectance but no `bsdf`"]),
        (
            |d| material(d, json!({"bsdf": "diffuse", "k": 1})),
            &["k", "a diffuse takes: reflectance"],
        ),
        (
            |d| material(d, json!({"bsdf": "diffuse", "reflectance": 1.5})),
            &["reflectance", "1.5", "within [0, 1]"],
        ),
        (
            |d| material(d, json!({"bsdf": "diffuse", "reflectance": [0.1, -0.2, 0.3]})),
            &["reflectance", "-0.2"],
        ),
        (
            |d| material(d, json!({"bsdf": "diffuse", "reflectance": [0.1, 0.2]})),
            &["reflectance", "not a spectrum"],
        ),
        (
            |d| material(d, json!({"bsdf": "diffuse", "reflectance": {"nm": [500], "v": [1]}})),
            &["reflectance.v", "nm, value"],
        ),
        (
            |d| {
                material(
                    d,
                    json!({"bsdf": "diffuse",
                                "reflectance": {"nm": [600, 500], "value": [1, 1]}}),
                )
            },
            &["reflectance", "increasing"],
        ),
    ]);
}

#[test]
fn glass_metal_and_contradictions() {
    refused(&[
        (
            |d| material(d, json!({"bsdf": "conductor", "eta": 0, "k": 1})),
            &["eta", "greater than 0"],
        ),
        (|d| material(d, json!({"bsdf": "conductor", "eta": 1, "k": -1})), &["k", "not negative"]),
        (|d| material(d, json!({"bsdf": "conductor", "eta": 1})), &["both `eta` and `k`"]),
        (|d| material(d, json!({"bsdf": "conductor", "metal": "Al", "k": 1})), &["either `metal`"]),
        (|d| material(d, json!({"bsdf": "conductor", "metal": "Xx"})), &["`Xx`", "Ag, Al, Au, Be"]),
        (|d| material(d, json!({"bsdf": "conductor", "eta": 1e39, "k": 1})), &["eta"]),
        (|d| material(d, json!({"bsdf": "dielectric", "ior": 0})), &["ior", "greater than 0"]),
        (
            |d| material(d, json!({"bsdf": "polarizer", "extinction_ratio": 0.5})),
            &["extinction_ratio", "at least 1"],
        ),
        (|d| material(d, json!({"bsdf": "polarizer", "axis_deg": "x"})), &["axis_deg", "number"]),
        (|d| material(d, json!({"bsdf": "retarder"})), &["retardance_deg", "missing"]),
        (
            |d| d["materials"][0]["extras"] = json!({"sunstone_bsdf": "absorber"}),
            &["extras.sunstone_bsdf", "contradicts", "SUNSTONE_polarization.bsdf"],
        ),
        (
            |d| d["materials"][0]["extras"] = json!({"sunstone": {"reflectance": 0.25}}),
            &["extras.sunstone.reflectance", "contradicts"],
        ),
        (
            |d| d["materials"][0]["extras"] = json!({"sunstone_color": 1}),
            &["extras.sunstone_color", "not a key"],
        ),
        (
            |d| d["materials"][0]["emissiveFactor"] = json!([-1, 0, 0]),
            &["material 0 \"glow\"", "emissiveFactor", "not negative"],
        ),
        (
            |d| d["materials"][0]["normalTexture"] = json!({"index": 0}),
            &["material 0 \"glow\", normalTexture", "no `index`", "export"],
        ),
    ]);
}

#[test]
fn materials_of_gltf() {
    refused(&[
        (|d| pbr(d, json!({"metallicFactor": 2.0})), &["material 0", "within [0, 1]"]),
        (
            |d| pbr(d, json!({"metallicFactor": 0.0, "baseColorFactor": [2, 0, 0, 1]})),
            &["material 0", "within [0, 1]"],
        ),
        (
            |d| pbr(d, json!({"metallicFactor": 0.0, "baseColorTexture": {"index": 0}})),
            &["baseColorTexture", "no `index`"],
        ),
        (
            |d| {
                d["materials"][0]["extensions"] =
                    json!({"KHR_materials_transmission": {"transmissionFactor": 1.5}});
            },
            &["material 0", "KHR_materials_transmission.transmissionFactor", "within [0, 1]"],
        ),
        (
            |d| {
                pbr(d, json!({"metallicFactor": 0.0, "roughnessFactor": 0.0}));
                d["materials"][0]["extensions"] = json!({
                "KHR_materials_ior": {"ior": -1.0},
                "KHR_materials_transmission": {"transmissionFactor": 1.0}});
            },
            &["material 0", "KHR_materials_ior.ior", "greater than 0"],
        ),
    ]);
}

#[test]
fn spheres() {
    fn sphere(document: &mut Value, body: Value) {
        document["nodes"][2]["extensions"]["SUNSTONE_polarization"] = body;
    }
    refused(&[
        (|d| sphere(d, json!({"shape": 1})), &["node 2 \"ball\"", "shape", "1"]),
        (|d| sphere(d, json!({"shape": 0, "sphere_radius": 1})), &["node 2", "either `shape`"]),
        (|d| sphere(d, json!({"sphere_radius": 0})), &["sphere_radius", "greater than 0"]),
        (|d| sphere(d, json!({"shape": 0, "material": 0})), &["material", "contradicts the mesh"]),
        (|d| sphere(d, json!({"material": 0})), &["material", "belongs to a sphere"]),
        (|d| sphere(d, json!({"shape": 0, "interior": 0})), &["interior", "0 media"]),
        (|d| d["nodes"][2]["mesh"] = Value::Null, &["node 2 \"ball\"", "no material"]),
        (
            |d| d["extensions"]["KHR_implicit_shapes"]["shapes"][0]["type"] = json!("box"),
            &["KHR_implicit_shapes, shape 0", "`box`"],
        ),
        (
            |d| d["extensions"]["KHR_implicit_shapes"]["shapes"][0]["sphere"]["radius"] = json!(-1),
            &["KHR_implicit_shapes, shape 0, sphere.radius", "greater than 0"],
        ),
    ]);
}

#[test]
fn lights_cameras_and_scenes() {
    refused(&[
        (|d| camera(d, json!({"film": {"resolution": [0, 5]}})), &["film.resolution", "whole"]),
        (|d| camera(d, json!({"film": {"resolution": [5]}})), &["film.resolution"]),
        (|d| camera(d, json!({"film": {"iso": 100}})), &["film.iso", "resolution"]),
        (|d| camera(d, json!({"film": {"analyzer": {}}})), &["film.analyzer.kind", "is missing"]),
        (|d| camera(d, json!({"aperture_radius": 0.1})), &["aperture_radius", "focus_distance"]),
        (|d| camera(d, json!({"focus_distance": 0})), &["focus_distance", "greater than 0"]),
        (|d| d["cameras"][0]["perspective"]["yfov"] = json!(4), &["camera 0 \"lens\", yfov"]),
        (|d| d["cameras"][0]["perspective"]["aspectRatio"] = json!(0), &["aspectRatio"]),
        (
            |d| {
                d["cameras"][0] = json!({"type": "orthographic", "orthographic":
            {"xmag": 0.0, "ymag": 1.0, "znear": 0.1, "zfar": 10.0}})
            },
            &["camera 0, xmag"],
        ),
        (|d| d["cameras"][0]["type"] = json!("fisheye"), &["camera 0", "no projection"]),
        (
            |d| d["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = json!(-1),
            &["node 3 \"lamp\", light 0 \"bulb\"", "intensity", "not negative"],
        ),
        (
            |d| d["extensions"]["KHR_lights_punctual"]["lights"][0]["type"] = json!("tube"),
            &["light 0 \"bulb\", type"],
        ),
        (
            |d| {
                d["extensions"]["KHR_lights_punctual"]["lights"][0]["extras"] =
                    json!({"sunstone_units": "watts"})
            },
            &["extras.sunstone_units", "`watts`"],
        ),
        (
            |d| {
                d["extensions"]["KHR_lights_punctual"]["lights"][0] = json!({"type": "spot",
            "spot": {"innerConeAngle": 1.0, "outerConeAngle": 0.5}})
            },
            &["light 0, spot", "outer"],
        ),
        (
            |d| d["scenes"][0]["extras"] = json!({"sunstone": {"environment": {}}}),
            &["scene 0 \"good\"", "environment", "neither `radiance`"],
        ),
        (
            |d| d["scenes"][0]["extras"] = json!({"sunstone": {"environment": {"radiance": -1}}}),
            &["environment.radiance", "not negative"],
        ),
        (
            |d| {
                let sky = json!({"sunstone": {"environment": {"radiance": 1}}});
                d["scenes"][0]["extras"] = sky.clone();
                d["extras"] = sky;
            },
            &["environment", "described twice"],
        ),
    ]);
}

#[test]
fn a_camera_that_is_not_there_lists_those_that_are() {
    let path = scratch("cameras.gltf");
    let mut document = good();
    document["nodes"].as_array_mut().unwrap().push(json!({"camera": 1, "translation": [0, 0, 7]}));
    document["scenes"][0]["nodes"] = json!([0, 1, 2, 3, 4]);
    let second = json!({"type": "orthographic",
        "orthographic": {"xmag": 1.0, "ymag": 1.0, "znear": 0.1, "zfar": 9.0}});
    document["cameras"].as_array_mut().unwrap().push(second);
    fs::write(&path, document.to_string()).unwrap();
    let load = |name| load_with(&path, &Reading { view: View::by(name), ..Reading::default() });
    for (name, height) in
        [("eye", "5.0000"), ("lens", "5.0000"), ("#0", "5."), ("#1", "7.0000"), ("1", "7.")]
    {
        let text = load(name).unwrap().describe();
        assert!(text.contains(&format!("at (0.0000, 0.0000, {height}")), "{name}: {text}");
    }
    for name in ["nose", "#2", "2", "#-1", "#x", ""] {
        let error = load(name).unwrap_err().to_string();
        assert!(error.contains(&format!("`{name}`")), "{error}");
        assert!(error.contains("the cameras are #0 eye or lens, #1"), "{error}");
    }
}

#[test]
fn files_that_are_no_scenes() {
    let utf16: Vec<u8> = "{}".encode_utf16().flat_map(u16::to_le_bytes).collect();
    let cases: [(&str, Vec<u8>, &str); 8] = [
        ("h.gltf", [&[0xff, 0xfe][..], &utf16].concat(), "save it as UTF-8"),
        ("a.gltf", b"hello".to_vec(), "is not glTF"),
        ("b.gltf", Vec::new(), "is not glTF"),
        ("c.gltf", format!("{}{}", "[".repeat(10_000), "]".repeat(10_000)).into(), "recursion"),
        ("d.glb", b"glTF\x02\0\0\0\xff\xff\xff\xff".to_vec(), "claims 4294967295 bytes"),
        ("e.glb", b"glTF\x01\0\0\0\x0c\0\0\0".to_vec(), "version 1"),
        ("f.glb", b"glTF\x02\0\0\0\x0c\0\0\0".to_vec(), "JSON chunk"),
        ("g.glb", b"glTF\x02\0\0\0\x14\0\0\0\xff\xff\xff\x7fJSON".to_vec(), "chunk 0 is cut off"),
    ];
    for (name, bytes, expected) in cases {
        let error = load_bytes(name, &bytes).expect_err(name);
        assert!(error.contains(expected) && error.contains(name), "{error}");
    }
    let missing = load(&scratch("missing.gltf")).unwrap_err().to_string();
    assert!(missing.contains("missing.gltf") && missing.contains("cannot read"), "{missing}");
    assert!(load(scratch("x").parent().unwrap()).is_err(), "a folder is no scene");
}

#[test]
fn deep_hierarchies_are_fine() {
    let mut document = good();
    let nodes = document["nodes"].as_array_mut().unwrap();
    let first = nodes.len();
    nodes[1]["children"] = json!([first]);
    for node in first..first + 20_000 {
        nodes.push(json!({"children": [node + 1]}));
    }
    nodes.push(json!({"mesh": 0, "translation": [0, 0, 1]}));
    let world = load_json(&document).unwrap();
    assert_eq!(bake(&world, &Carried::RGB).unwrap().shapes.triangles.len(), 4);
}

#[test]
fn a_small_file_cannot_ask_for_billions_of_triangles() {
    let mut document = good();
    let primitive = document["meshes"][0]["primitives"][0].clone();
    document["meshes"][0]["primitives"] = vec![primitive; 10_000].into();
    let nodes = document["nodes"].as_array_mut().unwrap();
    let first = nodes.len();
    nodes.extend((0..10_000).map(|_| json!({"mesh": 0})));
    document["nodes"][1]["children"] = (first..first + 10_000).collect::<Vec<_>>().into();
    let error = load_json(&document).unwrap_err();
    assert!(error.contains("vertices and corners"), "{error}");
}

/// Nodes that all show mesh 0, which is a grid of 128 x 128 quads.
fn grids(count: usize) -> Value {
    let mut document = good();
    let edge = 129_u32;
    let positions = (0..edge * edge).flat_map(|at| [(at % edge) as f32, (at / edge) as f32, 0.0]);
    let mut bytes: Vec<u8> = positions.flat_map(f32::to_le_bytes).collect();
    let indices = (0..edge * edge).filter(|at| at % edge + 1 < edge && at / edge + 1 < edge);
    let quad = |at: u32| [at, at + 1, at + edge + 1, at, at + edge + 1, at + edge];
    let indices: Vec<u8> = indices.flat_map(quad).flat_map(u32::to_le_bytes).collect();
    let (views, accessors) = (bytes.len(), indices.len() / 4);
    bytes.extend(&indices);
    document["bufferViews"] = json!([
        {"buffer": 0, "byteOffset": 0, "byteLength": views},
        {"buffer": 0, "byteOffset": views, "byteLength": indices.len()},
    ]);
    document["buffers"] = json!([{"byteLength": bytes.len(), "uri": data_uri(&bytes)}]);
    document["accessors"] = json!([
        {"bufferView": 0, "componentType": 5126, "count": edge * edge, "type": "VEC3",
         "min": [0.0, 0.0, 0.0], "max": [128.0, 128.0, 0.0]},
        {"bufferView": 1, "componentType": 5125, "count": accessors, "type": "SCALAR"},
    ]);
    let part = json!({"attributes": {"POSITION": 0}, "indices": 1, "material": 0});
    document["meshes"] = json!([{"name": "grid", "primitives": [part]}]);
    document["nodes"][2] = json!({"name": "grids", "children": []});
    let nodes = document["nodes"].as_array_mut().unwrap();
    let first = nodes.len();
    nodes.extend((0..count).map(|at| json!({"mesh": 0, "translation": [0.0, 0.0, at]})));
    document["nodes"][2]["children"] = (first..first + count).collect::<Vec<_>>().into();
    document
}

#[test]
fn instances_are_kept_once_unless_they_emit_or_are_stretched() {
    let counts = |document: &Value| {
        let scene = bake(&load_json(document).unwrap(), &Carried::RGB).unwrap();
        (scene.shapes.instanced.instances().len(), scene.shapes.triangles.len() >> 15)
    };
    // Node 1 shows the mesh too.
    let mut document = grids(3);
    assert_eq!(counts(&document), (0, 4), "what emits");
    document["materials"][0]["emissiveFactor"] = json!([0, 0, 0]);
    assert_eq!(counts(&document), (4, 0));
    document["nodes"][5]["scale"] = json!([1, 1, 40]);
    assert_eq!(counts(&document), (3, 1), "what is stretched");
    document["nodes"][6]["scale"] = json!([1, 1, -40]);
    assert_eq!(counts(&document), (0, 4), "what would save little");
}

#[test]
fn copies_without_end_are_refused_and_instances_are_not() {
    let mut document = grids(2100);
    let world = load_json(&document).unwrap();
    let error = bake(&world, &Carried::RGB).unwrap_err().to_string();
    assert!(error.contains("triangles in copies"), "{error}");
    document["materials"][0]["emissiveFactor"] = json!([0, 0, 0]);
    let scene = bake(&load_json(&document).unwrap(), &Carried::RGB).unwrap();
    assert_eq!(scene.shapes.instanced.instances().len(), 2101);
    let last = scene.shapes.instanced.instances().last().unwrap();
    assert_eq!(scene.shapes.surface_of(last.first_primitive + 32_767), last.surface);
    let normal = scene.shapes.geometric_normal(last.first_primitive, last.bounds[0]);
    assert_eq!(normal, glam::Vec3::Z);
}

#[test]
fn what_only_the_bake_can_see() {
    let mut metal = good();
    material(&mut metal, json!({"bsdf": "conductor", "metal": "Au"}));
    let world = load_json(&metal).unwrap();
    assert!(bake(&world, &Carried::at([500.0])).is_ok());
    let error = bake(&world, &Carried::at([1100.0])).unwrap_err().to_string();
    assert!(error.contains("material 0 \"glow\"") && error.contains("292.4 to"), "{error}");

    let mut document = good();
    document["nodes"][1]["scale"] = json!([1e17, 1e17, 1e17]);
    let world = load_json(&document).unwrap();
    let error = bake(&world, &Carried::RGB).unwrap_err().to_string();
    assert!(error.contains("coordinates"), "{error}");
}

#[test]
fn triangles_that_vanish_in_their_place_are_dropped() {
    let mut document = good();
    document["nodes"][1]["scale"] = json!([1e-25, 1e-25, 1e-25]);
    document["nodes"][3]["mesh"] = json!(0);
    document["nodes"][3]["scale"] = json!([1.0, 1e-8, 1.0]);
    document["nodes"][3]["translation"] = json!([0.0, 3e7, 0.0]);
    let world = load_json(&document).unwrap();
    let scene = bake(&world, &Carried::RGB).unwrap();
    assert!(scene.shapes.triangles.is_empty());
    let [warning] = &scene.shapes.warnings[..] else { panic!("{:?}", scene.shapes.warnings) };
    assert!(warning.starts_with("node 1 \"panel\", mesh 0 \"square\""), "{warning}");
    assert!(warning.contains("and 1 other: 4 triangles without area in the world"), "{warning}");
}
