//! What files do to meshes: animations, morph targets, skins, copies, integers in place of floats.

use std::fs;

use crate::common::{data_uri, good, load_json, scratch};
use crate::meaning::{baked, warnings};
use crate::textures::painted;
use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3, Vec4};
use serde_json::{Value, json};
use sunstone::internals::scene::{Reading, SceneError, View, World, bake, load_with};
use sunstone::internals::spectrum::Carried;
use sunstone::world::Mesh;

const FLOAT: u32 = 5126;

/// Adds an accessor of some bytes; its index.
fn accessor(document: &mut Value, bytes: &[u8], kind: (u32, &str), count: usize) -> usize {
    let push = |document: &mut Value, list: &str, item: Value| {
        let list = document[list].as_array_mut().unwrap();
        list.push(item);
        list.len() - 1
    };
    let uri = data_uri(bytes);
    let buffer = push(document, "buffers", json!({"byteLength": bytes.len(), "uri": uri}));
    let view = json!({"buffer": buffer, "byteLength": bytes.len()});
    let view = push(document, "bufferViews", view);
    let of = json!({"bufferView": view, "componentType": kind.0, "type": kind.1, "count": count});
    push(document, "accessors", of)
}

/// Adds an accessor of floats, so many to an element; its index.
fn floats(document: &mut Value, numbers: &[f32], shape: &str, size: usize) -> usize {
    let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    accessor(document, &bytes, (FLOAT, shape), numbers.len() / size)
}

/// Gives the panel a channel of an animation.
fn animate(document: &mut Value, node: usize, path: &str, curve: (&str, &[f32], &[f32])) {
    let (interpolation, times, values) = curve;
    let (shape, size) = match path {
        "rotation" => ("VEC4", 4),
        "weights" => ("SCALAR", 1),
        _ => ("VEC3", 3),
    };
    let input = floats(document, times, "SCALAR", 1);
    let output = floats(document, values, shape, size);
    let animation = json!({
        "channels": [{"sampler": 0, "target": {"node": node, "path": path}}],
        "samplers": [{"input": input, "output": output, "interpolation": interpolation}],
    });
    match document["animations"].as_array_mut() {
        Some(animations) => animations.push(animation),
        None => document["animations"] = json!([animation]),
    }
}

fn at(document: &Value, time: f64) -> Result<World, SceneError> {
    let path = scratch("moving.gltf");
    fs::write(&path, document.to_string()).unwrap();
    let view = View { time: Some(time), ..View::default() };
    load_with(&path, &Reading { view, ..Reading::default() })
}

/// The first corner of the first triangle at a time.
fn corner(document: &Value, time: f64) -> Vec3 {
    let world = at(document, time).unwrap_or_else(|error| panic!("{error}"));
    let baked = bake(&world, &Carried::RGB).unwrap();
    baked.shapes.triangles[0].corners[0] + baked.shapes.origin.as_vec3()
}

#[track_caller]
fn assert_near(found: Vec3, expected: Vec3) {
    assert!(found.distance(expected) < 1e-5, "{found} is not {expected}");
}

/// Where the panel's first corner is without any move.
const CORNER: Vec3 = Vec3::new(-1.0, -1.0, 0.0);

#[test]
fn nodes_move_in_time() {
    let times = [1.0, 2.0, 4.0];
    let mut linear = good();
    let places = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 4.0, 0.0];
    animate(&mut linear, 1, "translation", ("LINEAR", &times, &places));
    let mut steps = good();
    animate(&mut steps, 1, "translation", ("STEP", &times, &places));
    let expected = [
        (0.0, [0.0, 0.0], [0.0, 0.0]),
        (1.0, [0.0, 0.0], [0.0, 0.0]),
        (1.25, [0.25, 0.0], [0.0, 0.0]),
        (2.0, [1.0, 0.0], [1.0, 0.0]),
        (3.5, [1.0, 3.0], [1.0, 0.0]),
        (4.0, [1.0, 4.0], [1.0, 4.0]),
        (1e9, [1.0, 4.0], [1.0, 4.0]),
    ];
    for (time, of_linear, of_steps) in expected {
        for (document, [x, y]) in [(&linear, of_linear), (&steps, of_steps)] {
            assert_near(corner(document, time), CORNER + Vec3::new(x, y, 0.0));
        }
    }
    assert!(warnings(&linear).contains("--time SECONDS shows a moment"));
    assert_near(baked(&linear).shapes.triangles[0].corners[0], CORNER);
}

/// A cubic spline with the right tangents is any cubic; here t^3, t^2 and 1 - t.
#[test]
fn cubic_splines_are_cubics() {
    let cubic = |t: f32| [t * t * t, t * t, 1.0 - t];
    let tangent = |t: f32| [3.0 * t * t, 2.0 * t, -1.0];
    let times = [0.5, 2.0, 2.5];
    let rows = times.map(|t| [tangent(t), cubic(t), tangent(t)]);
    let mut document = good();
    let rows = rows.as_flattened().as_flattened();
    animate(&mut document, 1, "translation", ("CUBICSPLINE", &times, rows));
    for t in [0.5f32, 0.9, 1.7, 2.0, 2.2, 2.5] {
        assert_near(corner(&document, t.into()), CORNER + Vec3::from_array(cubic(t)));
    }
}

#[test]
fn rotations_turn_evenly_the_short_way() {
    let turn = |degrees: f32| glam::Quat::from_rotation_z(degrees.to_radians());
    // The second key is the same rotation by the other quaternion.
    let keys = [turn(0.0).to_array(), (-turn(90.0)).to_array()];
    let mut document = good();
    animate(&mut document, 1, "rotation", ("LINEAR", &[0.0, 1.0], keys.as_flattened()));
    for share in [0.0, 0.3, 0.5, 1.0] {
        assert_near(corner(&document, f64::from(share)), turn(90.0 * share) * CORNER);
    }
    // Normalized bytes are rotations too.
    let mut document = good();
    let input = floats(&mut document, &[0.0], "SCALAR", 1);
    let output = accessor(&mut document, &[0, 0, 127, 0], (5120, "VEC4"), 1);
    document["accessors"][output]["normalized"] = json!(true);
    document["animations"] = json!([{
        "channels": [{"sampler": 0, "target": {"node": 1, "path": "rotation"}}],
        "samplers": [{"input": input, "output": output}]}]);
    assert_near(corner(&document, 0.0), -CORNER);
}

#[test]
fn of_animations_that_move_the_same_the_first_is_played() {
    let mut document = good();
    animate(&mut document, 1, "translation", ("STEP", &[0.0], &[3.0, 0.0, 0.0]));
    animate(&mut document, 1, "translation", ("STEP", &[0.0], &[0.0, 3.0, 0.0]));
    animate(&mut document, 1, "scale", ("STEP", &[0.0], &[2.0, 2.0, 2.0]));
    assert_near(corner(&document, 0.0), 2.0 * CORNER + 3.0 * Vec3::X);
    let told = at(&document, 0.0).unwrap().warnings().join("\n");
    assert!(
        told.contains("not played, as others before them move the same: animation 1"),
        "{told}"
    );
}

#[test]
fn broken_animations_are_refused_by_name() {
    let error = |document: &Value, time: f64| at(document, time).unwrap_err().to_string();
    assert!(error(&good(), 0.0).contains("animations: the file has none"));
    type Spoil = fn(&mut Value);
    let cases: [(Spoil, &str); 8] = [
        (|d| d["animations"][0]["samplers"][0]["input"] = json!(99), "channel 0, input"),
        (|d| d["animations"][0]["samplers"][0]["output"] = json!(-1), "channel 0, output"),
        (|d| d["animations"][0]["channels"][0]["sampler"] = json!(1), "channel 0, sampler"),
        (|d| d["animations"][0]["channels"][0]["target"]["node"] = json!(9), "target.node"),
        (|d| d["animations"][0]["samplers"][0]["interpolation"] = json!("X"), "CUBICSPLINE"),
        (|d| d["animations"][0]["samplers"][0]["interpolation"] = json!("CUBICSPLINE"), "go with"),
        (|d| d["animations"][0]["channels"][0]["target"]["path"] = json!("rotation"), "VEC4"),
        (
            |d| d["nodes"][1]["matrix"] = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            "has a matrix",
        ),
    ];
    for (spoil, expected) in cases {
        let mut document = good();
        let values = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        animate(&mut document, 1, "translation", ("LINEAR", &[0.0, 1.0], &values));
        spoil(&mut document);
        let error = error(&document, 0.5);
        assert!(error.contains(expected), "{expected}: {error}");
    }
    for times in [[1.0, 1.0], [2.0, 1.0], [0.0, f32::NAN]] {
        let mut document = good();
        animate(&mut document, 1, "scale", ("LINEAR", &times, &[1.0; 6]));
        assert!(error(&document, 0.5).contains("later than the one before"));
    }
    let mut document = good();
    animate(&mut document, 1, "scale", ("LINEAR", &[0.0], &[1.0, f32::INFINITY, 1.0]));
    assert!(error(&document, 0.5).contains("is not finite"));
}

/// The square with two morph targets: to the right, and up for its first corner.
fn morphing() -> Value {
    let mut document = good();
    let right = [1.0f32, 0.0, 0.0].repeat(4);
    let up = [0.0f32, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let right = floats(&mut document, &right, "VEC3", 3);
    let up = floats(&mut document, &up, "VEC3", 3);
    document["meshes"][0]["primitives"][0]["targets"] =
        json!([{"POSITION": right}, {"POSITION": up}]);
    document
}

#[test]
fn morph_targets_add_up() {
    let mut document = morphing();
    assert_near(baked(&document).shapes.triangles[0].corners[0], CORNER);
    document["meshes"][0]["weights"] = json!([0.5, 0.25]);
    let moved = CORNER + Vec3::new(0.5, 0.25, 0.0);
    assert_near(baked(&document).shapes.triangles[0].corners[0], moved);
    document["nodes"][1]["weights"] = json!([0.0, 1.0]);
    assert_near(baked(&document).shapes.triangles[0].corners[0], CORNER + Vec3::Y);
    let values = [1.0, 0.0, 0.0, 1.0];
    animate(&mut document, 1, "weights", ("LINEAR", &[0.0, 1.0], &values));
    assert_near(corner(&document, 0.25), CORNER + Vec3::new(0.75, 0.25, 0.0));
    // Another node with the same mesh goes its own way.
    document["nodes"][2] = json!({"mesh": 0, "translation": [0, 0, 9]});
    let world = at(&document, 0.0).unwrap();
    let shapes = bake(&world, &Carried::RGB).unwrap().shapes;
    let first = shapes.triangles.iter().map(|it| it.corners[0] + shapes.origin.as_vec3());
    let first: Vec<Vec3> = first.collect();
    assert_near(first[0], CORNER + Vec3::X);
    assert!(first.iter().any(|at| at.distance(CORNER + Vec3::new(0.5, 0.25, 9.0)) < 1e-5));
}

#[test]
fn morph_targets_of_other_meshes_are_refused() {
    let mut document = morphing();
    document["meshes"][0]["weights"] = json!([1.0]);
    document["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = json!(2);
    let error = load_json(&document).unwrap_err();
    assert!(error.contains("target 0, POSITION: 6 elements for 4 vertices"), "{error}");
    document["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = json!(77);
    let error = load_json(&document).unwrap_err();
    assert!(error.contains("targets: 77 is not an index"), "{error}");
}

/// The square hung on two joints by halves: its lower corners on one, its upper ones on the other.
fn skinned(weights: [[f32; 4]; 4]) -> Value {
    let mut document = good();
    let rows: [[u8; 4]; 4] = [[0, 1, 0, 0]; 4];
    let rows = accessor(&mut document, rows.as_flattened(), (5121, "VEC4"), 4);
    let weights = floats(&mut document, weights.as_flattened(), "VEC4", 4);
    let attributes = &mut document["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(rows);
    attributes["WEIGHTS_0"] = json!(weights);
    // Bound where the joints are at the origin and two above it.
    let mut bound = [[0.0f32; 16]; 2];
    for (joint, matrix) in bound.iter_mut().enumerate() {
        (0..4).for_each(|axis| matrix[5 * axis] = 1.0);
        matrix[13] = -2.0 * joint as f32;
    }
    let bound = floats(&mut document, bound.as_flattened(), "MAT4", 16);
    let nodes = document["nodes"].as_array_mut().unwrap();
    nodes.push(json!({"children": [5]}));
    nodes.push(json!({"translation": [0, 2, 0]}));
    document["scenes"][0]["nodes"] = json!([0, 1, 2, 3, 4]);
    document["skins"] = json!([{"joints": [4, 5], "inverseBindMatrices": bound}]);
    document["nodes"][1]["skin"] = json!(0);
    document
}

#[test]
fn skins_follow_their_joints() {
    let halves = [[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0], [0.0; 4]];
    let mut document = skinned(halves);
    // As it was bound; the mesh's own node has no part in it.
    document["nodes"][1]["translation"] = json!([100, 0, 0]);
    let corners = |document: &Value| {
        let shapes = baked(document).shapes;
        let at = |corner: Vec3| corner + shapes.origin.as_vec3();
        // Corners 0 1 2 and 0 2 3.
        let [[a, b, c], [_, _, d]] = [shapes.triangles[0].corners, shapes.triangles[1].corners];
        [a, b, c, d].map(at)
    };
    for (found, expected) in corners(&document).into_iter().zip([
        Vec3::new(-1.0, -1.0, 0.0),
        Vec3::new(1.0, -1.0, 0.0),
        Vec3::new(1.0, 1.0, 0.0),
        Vec3::new(-1.0, 1.0, 0.0),
    ]) {
        assert_near(found, expected);
    }
    // The first joint moves, the second turns about where it is.
    document["nodes"][4]["translation"] = json!([0, 0, 3]);
    document["nodes"][5]["rotation"] = json!([0, 0, 1, 0]);
    let moved = DAffine3::from_translation(DVec3::Z * 3.0);
    let half_turn = DQuat::from_rotation_z(std::f64::consts::PI);
    let above = DAffine3::from_rotation_translation(half_turn, DVec3::new(0.0, 2.0, 3.0));
    let above = above * DAffine3::from_translation(DVec3::NEG_Y * 2.0);
    let third = DVec3::new(1.0, 1.0, 0.0);
    let blend = 0.5 * (moved.transform_point3(third) + above.transform_point3(third));
    let found = corners(&document);
    assert_near(found[0], Vec3::new(-1.0, -1.0, 3.0));
    assert_near(found[2], blend.as_vec3());
    // Without weights it goes with the first joint.
    assert_near(found[3], Vec3::new(-1.0, 1.0, 3.0));
}

#[test]
fn broken_skins_are_refused_by_name() {
    type Spoil = fn(&mut Value);
    let cases: [(Spoil, &str); 6] = [
        (|d| d["nodes"][1]["skin"] = json!(3), "3 is not an index into the file's 1 skins"),
        (|d| d["skins"][0]["joints"] = json!([]), "has no joints"),
        (|d| d["skins"][0]["joints"] = json!([4, 99]), "skin 0, joints"),
        (|d| d["skins"][0]["joints"] = json!([4]), "1 is not one of the 1 joints"),
        (|d| d["skins"][0]["inverseBindMatrices"] = json!(0), "must be MAT4"),
        (
            |d| {
                drop(
                    d["meshes"][0]["primitives"][0]["attributes"]
                        .as_object_mut()
                        .and_then(|all| all.remove("WEIGHTS_0")),
                )
            },
            "no JOINTS and WEIGHTS",
        ),
    ];
    for (spoil, expected) in cases {
        let mut document = skinned([[0.5, 0.5, 0.0, 0.0]; 4]);
        spoil(&mut document);
        let error = load_json(&document).unwrap_err();
        assert!(error.contains(expected), "{expected}: {error}");
    }
}

#[test]
fn integers_are_positions_and_normals() {
    let mut document = good();
    let positions: [[i16; 4]; 4] = [
        [-32767, -32767, 0, 0],
        [32767, -32767, 0, 0],
        [32767, 32767, 0, 0],
        [-32768, 32767, 0, 0],
    ];
    let bytes: Vec<u8> =
        positions.as_flattened().iter().flat_map(|number| number.to_le_bytes()).collect();
    let index = accessor(&mut document, &bytes, (5122, "VEC3"), 4);
    let view = document["accessors"][index]["bufferView"].as_u64().unwrap() as usize;
    document["bufferViews"][view]["byteStride"] = json!(8);
    document["accessors"][index]["normalized"] = json!(true);
    let normals = accessor(&mut document, &[0, 0, 127, 0].repeat(4), (5120, "VEC3"), 4);
    let view = document["accessors"][normals]["bufferView"].as_u64().unwrap() as usize;
    document["bufferViews"][view]["byteStride"] = json!(4);
    document["accessors"][normals]["normalized"] = json!(true);
    document["meshes"][0]["primitives"][0]["attributes"] =
        json!({"POSITION": index, "NORMAL": normals});
    document["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    assert_eq!(baked(&document).shapes.triangles, baked(&good()).shapes.triangles);
    // Not normalized they are what they are.
    document["accessors"][index]["normalized"] = json!(false);
    document["nodes"][1]["scale"] = json!([1.0 / 32767.0, 1.0 / 32767.0, 1]);
    assert_near(baked(&document).shapes.triangles[0].corners[0], CORNER);
}

/// As gltfpack writes them: tangents of bytes, and coordinates that a transform of the texture
/// scales, where they are not normalized.
#[test]
fn integers_are_tangents_and_coordinates() {
    let mut document = painted();
    let tangents = accessor(&mut document, &[0, 127, 0, 129].repeat(4), (5120, "VEC4"), 4);
    document["accessors"][tangents]["normalized"] = json!(true);
    let places: Vec<u8> = [[-3_i16, 0], [4, 0], [4, 100], [-3, 100]]
        .as_flattened()
        .iter()
        .flat_map(|number| number.to_le_bytes())
        .collect();
    let places = accessor(&mut document, &places, (5122, "VEC2"), 4);
    let attributes = &mut document["meshes"][0]["primitives"][0]["attributes"];
    attributes["TANGENT"] = json!(tangents);
    attributes["TEXCOORD_0"] = json!(places);
    document["materials"][0]["normalTexture"] = json!({"index": 0});
    document["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let world = load_json(&document).unwrap();
    let mut query = world.entities().query::<&Mesh>();
    let geometries = query.iter().map(|Mesh(geometry)| geometry.clone());
    let [geometry] = &geometries.collect::<Vec<_>>()[..] else { panic!("not one mesh") };
    assert_eq!(geometry.tangents, [Vec4::new(0.0, 1.0, 0.0, -1.0); 4]);
    let expected = [[-3.0, 0.0], [4.0, 0.0], [4.0, 100.0], [-3.0, 100.0]].map(Vec2::from_array);
    assert_eq!(geometry.texture_coordinates, expected);
}

#[test]
fn meshes_stand_where_their_copies_do() {
    let mut document = good();
    let moves = [0.0, 0.0, -1.0, 5.0, 0.0, -1.0, 0.0, 5.0, -1.0];
    let moves = floats(&mut document, &moves, "VEC3", 3);
    let scales = [1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 0.0, 0.0, 0.0];
    let scales = floats(&mut document, &scales, "VEC3", 3);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let turns = [[0.0, 0.0, half, half], [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0]];
    let turns = floats(&mut document, turns.as_flattened(), "VEC4", 4);
    document["nodes"][1]["extensions"]["EXT_mesh_gpu_instancing"] = json!({"attributes":
        {"TRANSLATION": moves, "ROTATION": turns, "SCALE": scales}});
    document["nodes"][1]["translation"] = json!([0, 0, 1]);
    let shapes = baked(&document).shapes;
    let corners: Vec<Vec3> = (0..shapes.triangles.len())
        .map(|row| shapes.triangles[row].corners[0] + shapes.origin.as_vec3())
        .collect();
    assert_eq!(corners.len(), 4, "of one copy nothing is left");
    for expected in [Vec3::new(1.0, -1.0, 0.0), Vec3::new(3.0, -2.0, 0.0)] {
        assert!(corners.iter().any(|at| at.distance(expected) < 1e-5), "{expected} {corners:?}");
    }
    assert!(warnings(&document).contains("1 copy of no size skipped"));
    document["accessors"][scales]["count"] = json!(2);
    let error = load_json(&document).unwrap_err();
    assert!(error.contains("not of one length"), "{error}");
    document["nodes"][1]["extensions"]["EXT_mesh_gpu_instancing"] = json!({"attributes": {}});
    assert!(load_json(&document).unwrap_err().contains("where the copies stand"));
}

#[test]
fn what_a_scale_of_zero_makes_flat_is_flat() {
    let mut document = good();
    document["nodes"][1] =
        json!({"mesh": 0, "scale": [2, 3, 0], "rotation": [0, 0, 0, 1], "translation": [4, 0, 0]});
    let shapes = baked(&document).shapes;
    assert_near(shapes.triangles[0].corners[0], Vec3::new(2.0, -3.0, 0.0));
    assert!(warnings(&document).contains("scale of zero"));
    // Without bytes all positions are zero.
    let mut nowhere = good();
    nowhere["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert!(baked(&nowhere).shapes.triangles.is_empty());
    nowhere["accessors"][0]["count"] = json!(1 << 25);
    assert!(load_json(&nowhere).unwrap_err().contains("zeros"));
    document["nodes"][1]["scale"] = json!([0, 0, 0]);
    assert!(baked(&document).shapes.triangles.is_empty());
    assert!(warnings(&document).contains("no triangle with an area and is skipped"));
}

#[test]
fn what_is_hidden_is_not_there() {
    let mut document = good();
    document["nodes"][1]["extensions"]["KHR_node_visibility"] = json!({"visible": false});
    document["nodes"].as_array_mut().unwrap().push(json!({"mesh": 0}));
    document["nodes"][1]["children"] = json!([4]);
    assert!(baked(&document).shapes.triangles.is_empty());
    document["nodes"][1]["extensions"]["KHR_node_visibility"] = json!({"visible": true});
    assert_eq!(baked(&document).shapes.triangles.len(), 4);
}

#[test]
fn files_of_no_scene_or_of_several_show_one() {
    let mut document = good();
    document.as_object_mut().unwrap().remove("scene");
    document.as_object_mut().unwrap().remove("scenes");
    let all = baked(&document).shapes;
    assert_eq!(all.triangles, baked(&good()).shapes.triangles);
    assert_eq!(all.spheres.len(), 1);
    let mut document = good();
    document.as_object_mut().unwrap().remove("scene");
    document["scenes"] = json!([{"nodes": [0, 1]}, {"nodes": [0, 2, 3]}]);
    assert_eq!(baked(&document).shapes.spheres.len(), 0);
    assert!(warnings(&document).contains("2 scenes and does not say which"));
}

#[test]
fn all_that_is_refused_is_told_with_what_to_do() {
    let mut document = good();
    document["extensionsRequired"] =
        json!(["KHR_draco_mesh_compression", "KHR_texture_basisu", "ACME_gizmo"]);
    document["materials"][0]["extensions"]["SUNSTONE_polarization"]["bsdf"] = json!("wool");
    let error = load_json(&document).unwrap_err();
    for told in ["4 things are wrong", "gltf-pipeline", "PNG or JPEG", "`ACME_gizmo`", "`wool`"] {
        assert!(error.contains(told), "{told}: {error}");
    }
    // What is compressed without the file requiring it has no plain form to fall back to.
    let mut document = good();
    document["meshes"][0]["primitives"][0]["extensions"] =
        json!({"KHR_draco_mesh_compression": {"bufferView": 0}});
    assert!(load_json(&document).is_ok());
    document["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    let error = load_json(&document).unwrap_err();
    assert!(error.contains("`KHR_draco_mesh_compression` is not supported"), "{error}");
    let mut document = good();
    document["buffers"].as_array_mut().unwrap().push(
        json!({"byteLength": 9, "extensions": {"EXT_meshopt_compression": {"fallback": true}}}),
    );
    let error = load_json(&document).unwrap_err();
    assert!(error.contains("gltfpack"), "{error}");
    for harmless in ["KHR_materials_variants", "KHR_xmp_json_ld"] {
        let mut document = good();
        document["extensionsRequired"] = json!([harmless]);
        assert_eq!(warnings(&document), "");
    }
}

#[test]
fn unlit_materials_emit_their_color_and_light_no_scene() {
    let mut document = good();
    document["scenes"][0]["nodes"] = json!([0, 1]);
    let color = json!({"baseColorFactor": [0.2, 0.4, 0.6, 1]});
    document["materials"][0] =
        json!({"pbrMetallicRoughness": color, "extensions": {"KHR_materials_unlit": {}}});
    let world = load_json(&document).unwrap();
    assert!(world.put_in().iter().any(|it| it.what == "light"), "it is no lamp");
    let text = world.describe();
    assert!(text.contains("absorber, two-sided, emits radiance [0.2, 0.4, 0.6]"), "{text}");
}

#[test]
fn digits_that_change_in_what_moves_never_panic() {
    let mut document = skinned([[0.5, 0.5, 0.0, 0.0]; 4]);
    document["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 0}]);
    document["meshes"][0]["weights"] = json!([0.5]);
    animate(&mut document, 4, "rotation", ("LINEAR", &[0.0, 1.0], &[0.5; 8]));
    document["nodes"][2] = json!({"mesh": 0});
    let moves = floats(&mut document, &[1.0; 6], "VEC3", 3);
    document["nodes"][2]["extensions"]["EXT_mesh_gpu_instancing"] =
        json!({"attributes": {"TRANSLATION": moves}});
    assert!(at(&document, 0.5).is_ok());
    let text = document.to_string().into_bytes();
    let digits: Vec<usize> = (0..text.len()).filter(|&at| text[at].is_ascii_digit()).collect();
    let path = scratch("digits.gltf");
    // A linear congruential generator (Knuth's MMIX) suffices to choose digits.
    let mut state = 1u64;
    let mut next = |below: usize| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for round in 0..1_000 {
        let mut changed = text.clone();
        for _ in 0..1 + round % 3 {
            changed[digits[next(digits.len())]] = b'0' + next(10) as u8;
        }
        fs::write(&path, &changed).unwrap();
        let view = View { time: (round % 2 == 0).then_some(0.5), ..View::by("auto") };
        let world = load_with(&path, &Reading { view, ..Reading::default() });
        let _ = world.map(|world| bake(&world, &Carried::RGB).is_ok());
    }
}
