//! What of Mitsuba's files is refused, with line and name; and damaged ones never panic.

use std::fs;

use crate::common::{load_bytes, scratch};
use crate::mitsuba::scene;
use sunstone::internals::scene::{bake, load};
use sunstone::internals::spectrum::Carried;

fn refused(text: &str) -> String {
    load_bytes("wrong.xml", text.as_bytes()).map(|_| ()).unwrap_err()
}

#[test]
fn what_is_wrong_is_told_with_its_line_and_name() {
    let cases = [
        ("<bsdf/>", "line 3, bsdf, type is missing"),
        ("<shape type='rectangle'><ref id='a'/></shape>", "line 3, ref: no object has the id `a`"),
        (
            "<shape type='cube'><float name='size' value='1'/></shape>",
            "line 3, shape (cube), size is no property of it",
        ),
        (
            "<shape type='sphere'><string name='radius' value='1'/></shape>",
            "line 3, shape (sphere), radius is of kind string, and must be a float",
        ),
        ("<shape type='sphere'>\n<float name='radius' value='-1'/></shape>", "line 4, shape (sphe"),
        ("<float name='a' value='1..5'/>", "line 3, float a: `1..5` is not a number"),
        ("<rgb name='a' value='1 2'/>", "line 3, rgb a must be one number, or three"),
        ("<shape type='cube'><rfilter type='box'/></shape>", "(cube) has no place for ``"),
        ("<emitter type='sunsky'/>", "line 3, emitter (sunsky): `sunsky` is not supported"),
        ("<integrator type='magic'/>", "line 3, integrator (magic): `magic` is not supported"),
        ("<include filename='nothing.xml'/>", "line 3, include: cannot read"),
        ("<include filename='/etc/hostname'/>", "is not a path relative to the scene"),
        ("<shape type='ply'><string name='filename' value='a.ply'/></shape>", "cannot read"),
        ("<shape type='$what'/>", "line 3, shape, type: the parameter $what is not defined"),
        ("<nonsense/>", "line 3: <nonsense> is not known here"),
        ("<shape type='cube' color='red'/>", "line 3, shape has no attribute `color`"),
        (
            "<bsdf type='null' id='a'/>\n<bsdf type='null' id='a'/>",
            "line 4, bsdf \"a\" (null) has the id of another: line 3",
        ),
        (
            "<shape type='cube'><bsdf type='twosided'><bsdf type='dielectric'/></bsdf></shape>",
            "(twosided): its bsdf transmits",
        ),
        (
            "<shape type='cube'><bsdf type='diffuse'><float name='reflectance' value='2'/></bsdf>\
             </shape>",
            "(diffuse), reflectance: 2 must be within [0, 1]",
        ),
        (
            "<shape type='sphere'><bsdf type='polarizer'/></shape>",
            "a sheet with an axis needs a shape",
        ),
        (
            "<bsdf type='twosided' id='a'><ref id='b'/></bsdf>\
             <bsdf type='twosided' id='b'><ref id='a'/></bsdf>",
            "is part of itself",
        ),
        (
            "<shape type='rectangle'><emitter type='area'/><bsdf type='twosided'>\
             <bsdf type='diffuse'/></bsdf></shape>",
            "is two-sided, and emits from the front alone",
        ),
        (
            "<shape type='rectangle'><transform name='to_world'><rotate angle='1'/></transform>\
             </shape>",
            "line 3, rotate: the axis is zero",
        ),
    ];
    for (body, expected) in cases {
        let error = refused(&scene(body));
        assert!(error.contains(expected), "{body}\n{error}\nis not\n{expected}");
    }
}

#[test]
fn all_that_is_wrong_is_told_at_once() {
    let error = refused(&scene(
        "<shape type='torus'/><shape type='cube'><bsdf type='velvet'/></shape>\
         <emitter type='laser'/>",
    ));
    assert!(error.contains("3 things are wrong"), "{error}");
    for word in ["torus", "velvet", "laser"] {
        assert!(error.contains(word), "{error}");
    }
}

#[test]
fn what_is_no_scene_is_refused() {
    for (text, expected) in [
        ("", "is not XML"),
        ("<scene", "is not XML"),
        ("<scene/>", "version is missing"),
        ("<scene version='4.0.0'/>", "`4.0.0` is not known"),
        ("<bsdf version='3.0.0' type='null'/>", "is no scene"),
        ("<scene version='3.0.0'/>", "has nothing that could be seen"),
        ("<!DOCTYPE a [<!ENTITY b 'c'>]><scene version='3.0.0'/>", "is not XML"),
        ("<scene version='3.0.0'><film type='hdrfilm'/></scene>", "has no place in a scene"),
    ] {
        let error = refused(text);
        assert!(error.contains(expected), "{text}: {error}");
    }
    let deep = "<bsdf type='twosided'>".repeat(100) + &"</bsdf>".repeat(100);
    assert!(refused(&scene(&deep)).contains("objects within each other"));
}

/// A small generator of random numbers (splitmix64).
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut x = *state;
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[test]
fn damaged_files_never_panic() {
    let good = include_str!("../data/images/polarizers/scene.xml");
    // The comments say nothing.
    let good: String = good.lines().filter(|line| !line.contains("<!--")).collect();
    let good = good.split("-->").last().unwrap().as_bytes().to_vec();
    let survives = |bytes: &[u8]| {
        load_bytes("fuzz.xml", bytes).is_ok_and(|world| bake(&world, &Carried::RGB).is_ok())
    };
    assert!(survives(&good));
    for length in (0..good.len()).step_by(41) {
        assert!(!survives(&good[..length]), "{length} bytes");
    }
    for seed in 0..150 {
        let mut state = seed;
        let mut bytes = good.clone();
        for _ in 0..1 + seed % 4 {
            let at = next(&mut state) as usize % bytes.len();
            bytes[at] = b' ' + (next(&mut state) % 95) as u8;
        }
        survives(&bytes);
    }
}

/// A tetrahedron of each format, with its extension.
fn meshes() -> Vec<(&'static str, Vec<u8>)> {
    let points: [[f32; 3]; 4] =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let faces: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let list = |face: &[u32; 3], first: u32| face.map(|row| (row + first).to_string()).join(" ");
    let mut obj = "# a tetrahedron\no it\n".to_owned();
    let mut ascii = String::new();
    for point in points {
        let text = point.map(|x| x.to_string()).join(" ");
        obj += &format!("v {text}\n");
        ascii += &format!("{text}\n");
    }
    faces.iter().for_each(|face| obj += &format!("f {}\n", list(face, 1)));
    faces.iter().for_each(|face| ascii += &format!("3 {}\n", list(face, 0)));
    let header = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\ncomment none\nelement vertex 4\nproperty float x\n\
             property float y\nproperty float z\nelement face 4\n\
             property list uchar int vertex_indices\nend_header\n"
        )
    };
    let mut little = header("binary_little_endian").into_bytes();
    let mut big = header("binary_big_endian").into_bytes();
    for number in points.as_flattened() {
        little.extend(number.to_le_bytes());
        big.extend(number.to_be_bytes());
    }
    for face in faces {
        little.push(3);
        big.push(3);
        face.iter().for_each(|row| little.extend(row.to_le_bytes()));
        face.iter().for_each(|row| big.extend(row.to_be_bytes()));
    }
    let text = (header("ascii") + &ascii).into_bytes();
    vec![
        ("obj", obj.into_bytes()),
        ("ply", text),
        ("ply", little),
        ("ply", big),
        ("serialized", serialized(&points, &faces)),
    ]
}

/// Two meshes of version 4 in a file, of which the second is whole.
fn serialized(points: &[[f32; 3]; 4], faces: &[[u32; 3]; 4]) -> Vec<u8> {
    use std::io::Write;
    let mut mesh = 0x1000_u32.to_le_bytes().to_vec();
    mesh.extend(b"it\0");
    mesh.extend(4_u64.to_le_bytes());
    mesh.extend(4_u64.to_le_bytes());
    points.as_flattened().iter().for_each(|number| mesh.extend(number.to_le_bytes()));
    faces.as_flattened().iter().for_each(|row| mesh.extend(row.to_le_bytes()));
    let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(&mesh).unwrap();
    let packed = packed.finish().unwrap();
    let header = [0x1c, 0x04, 0x04, 0x00];
    let mut file = header.to_vec();
    file.extend(b"no mesh");
    let second = file.len() as u64;
    file.extend(header);
    file.extend(packed);
    file.extend(0_u64.to_le_bytes());
    file.extend(second.to_le_bytes());
    file.extend(2_u32.to_le_bytes());
    file
}

/// The scene of a mesh file.
fn scene_of(mesh: &std::path::Path) -> String {
    let plugin = mesh.extension().unwrap().to_string_lossy().into_owned();
    let index = if plugin == "serialized" { "<integer name='shape_index' value='1'/>" } else { "" };
    let name = mesh.file_name().unwrap().to_string_lossy().into_owned();
    scene(&format!(
        "<shape type='{plugin}'><string name='filename' value='{name}'/>\
         <boolean name='face_normals' value='true'/>{index}</shape>"
    ))
}

#[test]
fn meshes_of_all_formats_are_read_and_damaged_ones_refused() {
    for (extension, bytes) in meshes() {
        let mesh = scratch(&format!("mesh.{extension}"));
        let path = mesh.with_extension("xml");
        fs::write(&path, scene_of(&mesh)).unwrap();
        fs::write(&mesh, &bytes).unwrap();
        let world = load(&path).unwrap_or_else(|error| panic!("{error}"));
        let baked = bake(&world, &Carried::RGB).unwrap();
        let volume: f64 = baked
            .shapes
            .triangles
            .iter()
            .map(|row| {
                let [a, b, c] = row.corners.map(|at| at.as_dvec3() + baked.shapes.origin);
                a.dot(b.cross(c)) / 6.0
            })
            .sum();
        assert!((volume - 1.0 / 6.0).abs() < 1e-6, "{extension}: {volume}");
        // The last line or list may be without effect.
        for length in (0..bytes.len().saturating_sub(28)).step_by(7) {
            fs::write(&mesh, &bytes[..length]).unwrap();
            let world = load(&path);
            let is_whole = world.is_ok_and(|world| world.warnings().is_empty());
            assert!(!is_whole || extension == "obj", "{extension}, {length} bytes");
        }
        for seed in 0..60 {
            let mut state = seed;
            let mut damaged = bytes.clone();
            let at = next(&mut state) as usize % damaged.len();
            damaged[at] = next(&mut state) as u8;
            fs::write(&mesh, &damaged).unwrap();
            let _ = load(&path);
        }
        fs::remove_file(&mesh).unwrap();
        fs::remove_file(&path).unwrap();
    }
}

#[test]
fn numbers_out_of_range_are_told_in_the_units_of_the_file() {
    let cases = [
        (
            "<shape type='cube'><bsdf type='roughconductor'><float name='alpha' value='-1'/></bsdf>\
             </shape>",
            "(roughconductor), alpha: -1 must be within [0, 1]\n  help: give one number from 0",
        ),
        (
            "<shape type='cube'><bsdf type='roughplastic'><float name='alpha' value='3'/></bsdf>\
             </shape>",
            "(roughplastic), alpha: 3 must be within [0, 1]\n  help: give one number from 0",
        ),
        (
            "<shape type='cube'><bsdf type='roughplastic'><texture type='checkerboard' \
             name='alpha'/></bsdf></shape>",
            "(roughplastic), alpha must be one number\n  help: give one number from 0",
        ),
        (
            "<emitter type='spot'><float name='cutoff_angle' value='91'/></emitter>",
            "the beam_width 68.25 and the cutoff_angle 91 do not fit\n  help: degrees",
        ),
    ];
    for (body, expected) in cases {
        let error = refused(&scene(body));
        assert!(error.contains(expected), "{body}\n{error}\nis not\n{expected}");
    }
}
