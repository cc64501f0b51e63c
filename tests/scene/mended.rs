//! Files that are almost good: what does not matter is dropped with a warning, and what does is
//! told at once.

use std::fs;

use crate::common::{data_uri, good, load_bytes, load_json, scratch, square_bytes};
use crate::errors::refused;
use crate::meaning::{baked, warnings};
use glam::Vec3;
use serde_json::{Value, json};
use sunstone::internals::scene::{Reading, View, load_with};

#[test]
fn triangles_without_area_are_dropped_with_a_warning() {
    let mut bytes = square_bytes();
    bytes[104] = 0;
    let mut document = good();
    document["buffers"][0]["uri"] = data_uri(&bytes).into();
    assert_eq!(baked(&document).shapes.triangles.len(), 1);
    assert_eq!(
        warnings(&document),
        "mesh 0 \"square\", primitive 0: 1 triangle without area dropped"
    );

    // Corners 0, 2 and 3 in line, exactly and up to rounding.
    for middle in [[0.0f32, 0.0, 0.0], [0.3, 0.3, 1e-8]] {
        let mut bytes = square_bytes();
        let middle: Vec<u8> = middle.iter().flat_map(|x| x.to_le_bytes()).collect();
        bytes[36..48].copy_from_slice(&middle);
        document["buffers"][0]["uri"] = data_uri(&bytes).into();
        assert_eq!(baked(&document).shapes.triangles.len(), 1);
        assert!(warnings(&document).contains("1 triangle without area dropped"));
    }
    let mut bytes = square_bytes();
    bytes[..48].fill(0);
    document["buffers"][0]["uri"] = data_uri(&bytes).into();
    assert_eq!(baked(&document).shapes.triangles.len(), 0);
    assert!(warnings(&document).contains("no triangle with an area and is skipped"));
}

#[test]
fn points_and_lines_are_skipped_with_a_warning() {
    for mode in [0, 1, 2, 3] {
        let mut document = good();
        let loose = json!({"attributes": {"POSITION": 0}, "mode": mode});
        document["meshes"][0]["primitives"].as_array_mut().unwrap().push(loose);
        assert_eq!(baked(&document).shapes.triangles.len(), 2);
        let expected = "primitive 1: points and lines have no surface and are skipped";
        assert!(warnings(&document).ends_with(expected), "{}", warnings(&document));
    }
}

#[test]
fn what_nobody_reads_may_be_wrong() {
    let mut document = good();
    document["animations"] = json!([{"channels": [{"sampler": 0, "target": {"path": "weights"}}],
        "samplers": [{"input": 0, "output": 0, "interpolation": 0}]}]);
    for key in ["images", "samplers", "skins", "textures"] {
        document[key] = json!(["nothing"]);
    }
    document["scenes"].as_array_mut().unwrap().push(json!({"name": "empty"}));
    document["materials"][1]["occlusionTexture"] = json!({"index": 3});
    let said = warnings(&document);
    assert_eq!(said.lines().count(), 2, "{said}");
    assert!(said.contains("nothing moves") && said.contains("material 1"), "{said}");
    assert_eq!(baked(&document).shapes.triangles.len(), 2);
}

#[test]
fn a_byte_order_mark_is_no_part_of_the_text() {
    let bytes = [b"\xef\xbb\xbf", good().to_string().as_bytes()].concat();
    assert!(load_bytes("mark.gltf", &bytes).is_ok());
}

#[test]
fn scenes_that_list_children_show_them_once() {
    let listing = |nodes: Value| {
        let mut document = good();
        document["scenes"][0]["nodes"] = nodes;
        document["nodes"][1]["children"] = json!([2]);
        document["nodes"][1]["translation"] = json!([1, 0, 0]);
        document
    };
    let center = |document: &Value| {
        let spheres = baked(document).shapes.spheres;
        assert_eq!(spheres.len(), 1);
        spheres[0].center
    };
    let moved = Vec3::new(1.0, 0.0, 2.0);
    assert_eq!(
        (center(&listing(json!([0, 1, 3]))), warnings(&listing(json!([0, 1, 3])))),
        (moved, String::new())
    );
    for nodes in [json!([0, 1, 2, 3]), json!([2, 0, 3, 1]), json!([0, 1, 1, 3])] {
        let document = listing(nodes);
        assert_eq!(center(&document), moved);
        assert!(warnings(&document).contains("shown once"), "{}", warnings(&document));
    }
    let alone = listing(json!([0, 2, 3]));
    assert_eq!(center(&alone), moved);
    assert!(warnings(&alone).contains("without its parent"), "{}", warnings(&alone));
    assert_eq!(baked(&alone).shapes.triangles.len(), 0);
}

/// The square's last corner and the corners of its second triangle, put in by sparse parts.
#[test]
fn sparse_accessors_replace_what_they_name() {
    let mut document = good();
    let corner: Vec<u8> = [-1.0f32, 2.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let bytes = [&square_bytes()[..], &corner, &[3, 0, 0, 0]].concat();
    document["buffers"] = json!([{"byteLength": bytes.len(), "uri": data_uri(&bytes)}]);
    let views = document["bufferViews"].as_array_mut().unwrap();
    views.push(json!({"buffer": 0, "byteOffset": 108, "byteLength": 12}));
    views.push(json!({"buffer": 0, "byteOffset": 120, "byteLength": 1}));
    document["accessors"][0]["sparse"] = json!({
        "count": 1, "indices": {"bufferView": 4, "componentType": 5121},
        "values": {"bufferView": 3}});
    let corners = |document: &Value| {
        baked(document).shapes.triangles.iter().map(|t| t.corners).collect::<Vec<_>>()
    };
    assert_eq!(corners(&document)[1][2], Vec3::new(-1.0, 2.0, 0.0));
    assert_eq!(corners(&document)[0], corners(&good())[0]);

    // Without a buffer view, all others are zeros: a triangle of corners 0, 0, 3 is none.
    let sparse = json!({
        "count": 2, "indices": {"bufferView": 5, "componentType": 5121},
        "values": {"bufferView": 5, "byteOffset": 1}});
    document["accessors"][2] =
        json!({"componentType": 5121, "count": 3, "type": "SCALAR", "sparse": sparse});
    let bytes = [&bytes[..], &[1, 2, 3]].concat();
    document["buffers"] = json!([{"byteLength": bytes.len(), "uri": data_uri(&bytes)}]);
    document["bufferViews"]
        .as_array_mut()
        .unwrap()
        .push(json!({"buffer": 0, "byteOffset": 124, "byteLength": 3}));
    assert_eq!(corners(&document).len(), 1);
    assert_eq!(corners(&document)[0][2], Vec3::new(-1.0, 2.0, 0.0));
}

/// Gives the square's positions a sparse part with something changed.
fn sparse(document: &mut Value, field: &str, value: Value) {
    document["accessors"][0]["sparse"] = json!({
        "count": 1, "indices": {"bufferView": 2, "componentType": 5123},
        "values": {"bufferView": 0}});
    *document["accessors"][0]["sparse"].pointer_mut(field).unwrap() = value;
}

#[test]
fn sparse_accessors() {
    refused(&[
        (|d| sparse(d, "/count", json!(7)), &["accessor 0, sparse: 7 elements do not fit"]),
        (|d| sparse(d, "/count", json!(0)), &["accessor 0, sparse: 0 elements do not fit"]),
        (|d| sparse(d, "/indices/bufferView", json!(3)), &["sparse.indices.bufferView", "3"]),
        (|d| sparse(d, "/values/bufferView", json!(-1)), &["sparse.values.bufferView", "-1"]),
        (|d| sparse(d, "/indices/componentType", json!(5126)), &["accessor 0, sparse", "5125"]),
        (
            |d| sparse(d, "/indices", json!({"bufferView": 0, "componentType": 5125})),
            &["accessor 0, sparse: 3212836864 is not one of the 4 elements"],
        ),
        (
            |d| {
                sparse(d, "/count", json!(1));
                d["accessors"][0]["bufferView"] = Value::Null;
                d["accessors"][0]["count"] = json!(1u64 << 40);
            },
            &["mesh 0", "vertices and corners"],
        ),
        (
            |d| {
                sparse(d, "/count", json!(1));
                d["accessors"][1] = d["accessors"][0].clone();
                d["accessors"][1]["bufferView"] = Value::Null;
                d["accessors"][1]["count"] = json!(1u64 << 40);
            },
            &["mesh 0", "NORMAL", "1099511627776 normals for 4 vertices"],
        ),
    ]);
}

/// What is wrong is told at once, each thing once.
#[test]
fn all_that_is_wrong_is_told() {
    let mut document = good();
    document["materials"][0]["normalTexture"] = json!({"index": 0});
    document["materials"][0]["emissiveTexture"] = json!({"index": 0});
    document["nodes"][2]["extensions"]["SUNSTONE_polarization"] = json!({"sphere_radius": -1});
    document["nodes"].as_array_mut().unwrap().push(json!({"mesh": 0, "name": "again"}));
    document["scenes"][0]["nodes"] = json!([0, 1, 2, 3, 4]);
    document["cameras"][0]["perspective"]["yfov"] = json!(4);
    let error = load_json(&document).unwrap_err();
    assert!(error.contains("scene.gltf: 4 things are wrong\n"), "{error}");
    for part in ["0 \"glow\", normalTexture", "emissiveTexture", "sphere_radius", "yfov"] {
        assert_eq!(error.matches(part).count(), 1, "{part}: {error}");
    }
    assert_eq!(error.matches("help: export it again").count(), 1, "{error}");

    let mut document = good();
    document["nodes"][1]["mesh"] = json!(7);
    document["nodes"][3]["translation"] = json!([0, 0]);
    document["meshes"][0]["primitives"][0]["indices"] = json!(9);
    let error = load_json(&document).unwrap_err();
    assert!(error.contains("2 things are wrong") && error.contains("node 1"), "{error}");
    document["nodes"] = vec![json!({"mesh": "first"}); 50].into();
    let error = load_json(&document).unwrap_err();
    assert!(error.contains("and 41 more") && error.lines().count() < 16, "{error}");
}

/// What a file says reaches a terminal as text.
#[test]
fn names_and_values_are_quoted_safely() {
    let mut document = good();
    document["materials"][0]["name"] = json!("\u{1b}[2J\nred");
    document["materials"][0]["normalTexture"] = json!({"index": 0});
    let error = load_json(&document).unwrap_err();
    assert!(error.contains("material 0 \"\\u{1b}[2J\\nred\", normalTexture"), "{error}");
    document["materials"][0].as_object_mut().unwrap().remove("normalTexture");
    let text = load_json(&document).unwrap().describe();
    assert!(text.contains("\\u{1b}[2J\\nred") && !text.contains('\u{1b}'), "{text}");
    document["buffers"][0]["uri"] = "x".repeat(100_000).into();
    assert!(load_json(&document).unwrap_err().len() < 4000);
}

/// What a scene of a stranger refers to is in its folder, whatever it is called.
#[test]
#[cfg(unix)]
fn scenes_read_nothing_outside_their_folder_unless_allowed() {
    let folder = scratch("stranger");
    let inner = folder.join("scene");
    fs::create_dir_all(inner.join("deep")).unwrap();
    fs::write(folder.join("secret.bin"), square_bytes()).unwrap();
    fs::write(inner.join("own.bin"), square_bytes()).unwrap();
    std::os::unix::fs::symlink("../secret.bin", inner.join("link.bin")).unwrap();
    let absolute = folder.join("secret.bin").display().to_string();
    let path = inner.join("scene.gltf");
    let load = |uri: &str, allow_outside| {
        let mut document = good();
        document["buffers"][0]["uri"] = uri.into();
        fs::write(&path, document.to_string()).unwrap();
        let world = load_with(&path, &Reading { allow_outside, ..Reading::default() });
        world.map(|world| world.files().to_vec()).map_err(|error| error.to_string())
    };
    for uri in ["../secret.bin", "%2E%2E%2Fsecret.bin", "deep/../../secret.bin", "link.bin"] {
        let error = load(uri, false).unwrap_err();
        assert!(error.contains("outside the folder of the scene"), "{error}");
        let files = load(uri, true).unwrap();
        assert_eq!(files, [path.clone(), folder.canonicalize().unwrap().join("secret.bin")]);
    }
    assert!(load(&absolute, false).unwrap_err().contains("not a path relative"));
    assert!(load(&absolute, true).is_ok());
    for uri in ["own.bin", "./own.bin", "deep/../own.bin", "../scene/own.bin"] {
        assert!(load(uri, false).is_ok(), "{uri}");
    }
    let device = "../".repeat(20) + "proc/self/environ";
    assert!(load(&device, false).unwrap_err().contains("outside"));
}

/// A table that is none does not tell what it is.
#[test]
fn cells_are_quoted_only_if_they_are_short_and_harmless() {
    let error = |cell: &str| {
        let csv = format!("theta_deg,m00,m01,m22,m23\n{cell},1,0,1,0\n");
        let mut document = good();
        document["extras"] = json!({"sunstone_media": [{"phase": "mueller_table", "sigma_a": 0,
            "sigma_s": 1, "table": data_uri(csv.as_bytes())}]});
        load_json(&document).unwrap_err()
    };
    assert!(error("1..5").contains("line 2: `1..5` is not a number"));
    for cell in ["AWS_SECRET_ACCESS_KEY=5f3a", "\u{1b}[2J"] {
        let error = error(cell);
        assert!(error.contains("line 2: the cell of theta_deg is not a number"), "{error}");
    }
}

#[test]
fn cameras_of_one_name_are_told_apart() {
    let path = scratch("cameras-of-one-name.gltf");
    let mut document = good();
    let node = json!({"name": "lens", "camera": 1, "translation": [0, 0, 7]});
    document["nodes"].as_array_mut().unwrap().push(node);
    document["scenes"][0]["nodes"] = json!([0, 1, 2, 3, 4]);
    let second = json!({"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}});
    document["cameras"].as_array_mut().unwrap().push(second);
    fs::write(&path, document.to_string()).unwrap();
    let load = |name| load_with(&path, &Reading { view: View::by(name), ..Reading::default() });
    let error = load("lens").unwrap_err().to_string();
    assert!(error.contains("several cameras are called `lens`"), "{error}");
    assert!(error.contains("the cameras are #0 eye or lens, #1 lens"), "{error}");
    assert!(load("#1").unwrap().describe().contains("7.0000"));
}
