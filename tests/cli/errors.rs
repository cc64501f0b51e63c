//! What goes wrong is said once, in words that name the file and the field, with exit code 1 or
//! 2, and leaves nothing behind.

use std::fs;
use std::path::Path;
use std::process::Command;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

use crate::program::{Run, folder, names_in, run, scene, sunstone};

/// Checks an unsuccessful run: its exit code, one error that contains all `words`, no panic, and
/// nothing in the folder but what was there.
#[track_caller]
fn expect_error(here: &Path, before: &[String], run: &Run, code: i32, words: &[&str]) {
    let Run { command, stderr, .. } = run;
    assert_eq!(run.code, code, "{command}: {stderr}");
    let errors = stderr.lines().filter(|line| line.starts_with("error:")).count();
    assert_eq!(errors, 1, "{command}: {stderr}");
    assert!(!stderr.contains("panicked"), "{command}: {stderr}");
    assert_eq!(run.stdout, "", "{command}");
    for word in words {
        assert!(stderr.contains(word), "{command}: {stderr:?} lacks {word:?}");
    }
    assert_eq!(names_in(here), before, "{command} left something behind");
}

/// The shipped scene with something changed.
fn changed_scene(change: impl Fn(&mut Value)) -> String {
    let text = fs::read_to_string(scene("reference/cornell")).unwrap();
    let mut document: Value = serde_json::from_str(&text).unwrap();
    change(&mut document);
    document.to_string()
}

/// A folder of scenes and images that are wrong, each in its way.
fn folder_of_trouble(name: &str) -> std::path::PathBuf {
    let here = folder(name);
    let write = |name: &str, bytes: &[u8]| fs::write(here.join(name), bytes).unwrap();
    write("good.gltf", changed_scene(|_| {}).as_bytes());
    write("broken.gltf", b"{\"asset\": {\"version\": \"2.0\"}, \"nodes\": [");
    write("empty.gltf", b"");
    write("scene.obj", b"v 0 0 0\nf 1 1 1\n");
    write("noise.glb", b"glTF and then something else");
    write("dark.gltf", changed_scene(without_light).as_bytes());
    write("blind.gltf", changed_scene(without_camera).as_bytes());
    write("typo.gltf", changed_scene(with_unknown_key).as_bytes());
    write("range.gltf", changed_scene(with_reflectance_above_one).as_bytes());
    write("broken.exr", b"this is no OpenEXR file");
    write("file", b"a file, not a folder");
    fs::create_dir(here.join("folder.exr")).unwrap();
    here
}

fn without_light(document: &mut Value) {
    for material in document["materials"].as_array_mut().unwrap() {
        material.as_object_mut().unwrap().remove("emissiveFactor");
    }
}

fn without_camera(document: &mut Value) {
    for node in document["nodes"].as_array_mut().unwrap() {
        node.as_object_mut().unwrap().remove("camera");
    }
}

fn with_unknown_key(document: &mut Value) {
    document["materials"][4]["extensions"]["SUNSTONE_polarization"]["iro"] = 1.5.into();
}

fn with_reflectance_above_one(document: &mut Value) {
    document["materials"][0]["extensions"]["SUNSTONE_polarization"]["reflectance"] = 1.5.into();
}

#[test]
fn scenes_that_are_wrong_are_refused() {
    let here = folder_of_trouble("errors-scenes");
    let before = names_in(&here);
    let cases: [(&str, &[&str]); 7] = [
        ("missing.gltf", &["missing.gltf"]),
        ("scene.obj", &["scene.obj", "glTF"]),
        ("broken.gltf", &["broken.gltf"]),
        ("empty.gltf", &["empty.gltf"]),
        ("noise.glb", &["noise.glb"]),
        ("typo.gltf", &["typo.gltf", "material 4 \"glass\"", "SUNSTONE_polarization.iro"]),
        ("range.gltf", &["range.gltf", "material 0 \"white\"", "reflectance"]),
    ];
    for (scene, words) in cases {
        let run = sunstone(&here, &["render", scene, "-o", "out.exr", "--spp", "1"]);
        expect_error(&here, &before, &run, 1, words);
    }
    for (options, words) in [
        (["dark.gltf", "--light", "none"], ["dark.gltf", "emi"]),
        (["blind.gltf", "--camera", "nose"], ["blind.gltf", "camera"]),
    ] {
        let run = [&["render", "-o", "out.exr", "--spp", "1"], &options[..]].concat();
        expect_error(&here, &before, &sunstone(&here, &run), 1, &words);
    }
    for (scene, words) in [("missing.gltf", "missing.gltf"), ("broken.gltf", "broken.gltf")] {
        expect_error(&here, &before, &sunstone(&here, &["inspect", scene]), 1, &[words]);
    }
}

#[test]
fn outputs_that_cannot_be_written_are_refused_before_the_render() {
    let here = folder_of_trouble("errors-outputs");
    let before = names_in(&here);
    for (output, words) in [
        ("out.bmp", "format of out.bmp"),
        ("out", "format of out"),
        ("out.npy", "out.npy: .npy files cannot be written"),
    ] {
        for more in [&[][..], &["--variance"], &["--spp", "0"]] {
            let run = [&["render", "none.gltf", "-o", output][..], more].concat();
            expect_error(&here, &before, &sunstone(&here, &run), 2, &[words, ".exr, .hdr, .png"]);
        }
    }
    let cases: [(&str, &[&str]); 4] = [
        ("file/out.exr", &["file/out.exr"]),
        ("missing/out.exr", &["missing/out.exr"]),
        ("missing/out.hdr", &["missing/out"]),
        ("folder.exr", &["folder.exr", "a folder"]),
    ];
    for (output, words) in cases {
        // Would take hours if it were begun.
        let run = sunstone(&here, &["render", "good.gltf", "-o", output, "--spp", "100000000"]);
        expect_error(&here, &before, &run, 1, words);
    }
}

#[test]
#[cfg(unix)]
fn devices_are_not_replaced() {
    let here = folder_of_trouble("errors-devices");
    std::os::unix::fs::symlink("/dev/null", here.join("null.exr")).unwrap();
    let before = names_in(&here);
    let run = sunstone(&here, &["render", "good.gltf", "-o", "null.exr", "--spp", "1"]);
    expect_error(&here, &before, &run, 1, &["null.exr", "a device"]);
}

/// What never ends, or is no image, is not waited for.
#[test]
#[cfg(unix)]
fn pipes_and_devices_are_not_read() {
    let here = folder_of_trouble("errors-pipes");
    assert!(Command::new("mkfifo").arg(here.join("pipe.exr")).status().unwrap().success());
    for name in ["zero.exr", "zero.hdr", "zero.npy"] {
        std::os::unix::fs::symlink("/dev/zero", here.join(name)).unwrap();
    }
    let before = names_in(&here);
    for image in ["pipe.exr", "zero.exr", "zero.hdr", "zero.npy"] {
        let cases: [&[&str]; 3] = [
            &["inspect", image],
            &["compare", image, image],
            &["visualize", image, "-o", "out.png"],
        ];
        for arguments in cases {
            let run = sunstone(&here, arguments);
            expect_error(&here, &before, &run, 1, &[image, "not a file"]);
        }
    }
}

#[test]
#[cfg(unix)]
fn files_that_are_read_only_or_read_are_not_replaced() {
    use std::os::unix::fs::PermissionsExt;
    let here = folder_of_trouble("errors-precious");
    fs::write(here.join("precious.exr"), "precious").unwrap();
    let mode = fs::Permissions::from_mode(0o444);
    fs::set_permissions(here.join("precious.exr"), mode).unwrap();
    let buffer = changed_scene(|document| {
        let uri = document["buffers"][0]["uri"].as_str().unwrap().to_owned();
        let (_, text) = uri.split_once(',').unwrap();
        fs::write(here.join("buffer.png"), STANDARD.decode(text).unwrap()).unwrap();
        document["buffers"][0]["uri"] = "buffer.png".into();
    });
    fs::write(here.join("beside.gltf"), buffer).unwrap();
    let before = names_in(&here);
    let run = sunstone(&here, &["render", "good.gltf", "-o", "precious.exr", "--spp", "1"]);
    expect_error(&here, &before, &run, 1, &["precious.exr", "read-only"]);
    assert_eq!(fs::read(here.join("precious.exr")).unwrap(), b"precious");
    let run = sunstone(&here, &["render", "beside.gltf", "-o", "buffer.png", "--spp", "1"]);
    expect_error(&here, &before, &run, 2, &["buffer.png", "is the input"]);
    let run = ["render", "beside.gltf", "-o", "out.png", "--spp", "1", "--width", "8"];
    sunstone(&here, &run).done();
}

/// A scene of a stranger is read with its own files, or with those that the user lets it read.
#[test]
fn files_outside_the_folder_of_a_scene_need_leave() {
    let here = folder_of_trouble("errors-outside");
    fs::create_dir(here.join("scene")).unwrap();
    let outside = changed_scene(|document| {
        let uri = document["buffers"][0]["uri"].as_str().unwrap().to_owned();
        let (_, text) = uri.split_once(',').unwrap();
        fs::write(here.join("buffer.bin"), STANDARD.decode(text).unwrap()).unwrap();
        document["buffers"][0]["uri"] = "../buffer.bin".into();
    });
    fs::write(here.join("scene/scene.gltf"), outside).unwrap();
    let before = names_in(&here);
    let render = ["render", "scene/scene.gltf", "-o", "out.exr", "--spp", "1", "--width", "8"];
    let inspect = ["inspect", "scene/scene.gltf"];
    for arguments in [&render[..], &inspect] {
        let run = sunstone(&here, arguments);
        expect_error(&here, &before, &run, 1, &["outside the folder", "--allow-outside"]);
        sunstone(&here, &[arguments, &["--allow-outside"]].concat()).done();
        let _ = fs::remove_file(here.join("out.exr"));
    }
}

/// Limits that are known beforehand are told in numbers, not met.
#[test]
#[cfg(target_os = "linux")]
fn memory_that_will_not_suffice_is_told_before() {
    let here = folder_of_trouble("errors-limits");
    fs::write(here.join("many.glb"), many_triangles(500)).unwrap();
    let before = names_in(&here);
    let limited = |kibibytes: &str, arguments: &[&str]| {
        let mut command = Command::new("sh");
        command.args(["-c", "ulimit -v \"$0\"; exec \"$@\"", kibibytes]);
        command.arg(env!("CARGO_BIN_EXE_sunstone")).args(["render", "-o", "out.exr"]);
        run(command.args(arguments).current_dir(&here))
    };
    let photons = ["good.gltf", "--integrator", "ppm", "--photons", "4000000", "--threads", "1"];
    let words = ["4000000 light paths", "MiB of memory", "available", "fewer photons"];
    expect_error(&here, &before, &limited("400000", &photons), 1, &words);
    let words = ["500000 triangles", "needs 162 MiB", "available", "fewer meshes"];
    expect_error(&here, &before, &limited("150000", &["many.glb"]), 1, &words);
}

/// A .glb with a mesh of so many squares along both edges.
#[cfg(target_os = "linux")]
fn many_triangles(edge: u32) -> Vec<u8> {
    let vertex = |at: u32| [(at % (edge + 1)) as f32, (at / (edge + 1)) as f32, 0.0];
    let vertices = (edge + 1) * (edge + 1);
    let positions = (0..vertices).flat_map(vertex).flat_map(f32::to_le_bytes);
    let square = |at: u32| {
        let a = at / edge * (edge + 1) + at % edge;
        [a, a + 1, a + edge + 2, a, a + edge + 2, a + edge + 1]
    };
    let indices = (0..edge * edge).flat_map(square).flat_map(u32::to_le_bytes);
    let mut binary: Vec<u8> = positions.chain(indices).collect();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let of_positions = 12 * vertices as usize;
    let mut text = serde_json::json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"camera": 0}, {"mesh": 0}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": vertices, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": 6 * edge * edge, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": of_positions},
            {"buffer": 0, "byteOffset": of_positions, "byteLength": binary.len() - of_positions},
        ],
        "buffers": [{"byteLength": binary.len()}],
    })
    .to_string();
    text.extend(std::iter::repeat_n(' ', text.len().next_multiple_of(4) - text.len()));
    let size = |length: usize| (length as u32).to_le_bytes();
    let mut bytes = [&b"glTF"[..], &size(2), &size(28 + text.len() + binary.len())].concat();
    bytes.extend([&size(text.len())[..], b"JSON", text.as_bytes()].concat());
    bytes.extend([&size(binary.len())[..], b"BIN\0", &binary].concat());
    bytes
}

/// A disk that fills up, played by a limit on the size of files.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_leaves_the_former_file() {
    let here = folder_of_trouble("errors-full");
    fs::write(here.join("out.exr"), b"the former file").unwrap();
    let before = names_in(&here);
    // Blocks of 512 bytes: at once, and in the midst of the image.
    for (blocks, width) in [(1, "64"), (20, "64"), (600, "800")] {
        let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
        let mut command = Command::new("sh");
        command.args(["-c", &script, env!("CARGO_BIN_EXE_sunstone"), "render", "good.gltf"]);
        command.args(["-o", "out.exr", "--width", width, "--spp", "1"]).current_dir(&here);
        expect_error(&here, &before, &run(&mut command), 1, &["out.exr"]);
        assert_eq!(fs::read(here.join("out.exr")).unwrap(), b"the former file");
    }
}

#[test]
fn command_lines_that_are_wrong_are_refused() {
    let here = folder_of_trouble("errors-usage");
    let before = names_in(&here);
    let cases: [(&[&str], &str); 20] = [
        (&["--spp", "0"], "--spp"),
        (&["--spp", "4294967295"], "--spp"),
        (&["--spp", "many"], "--spp"),
        (&["--width", "0"], "--width"),
        (&["--height", "70000"], "--height"),
        (&["--width", "65000", "--height", "65000"], "65000 x 65000"),
        (&["--max-path-length", "0"], "--max-path-length"),
        (&["--threads", "0"], "--threads"),
        (&["--threads", "100000"], "--threads"),
        (&["--time-limit", "NaN"], "--time-limit"),
        (&["--time-limit=-1"], "--time-limit"),
        (&["--seed", "-1"], "'-1' for '--seed <N>': -1 is not in 0..=4294967295"),
        (&["--seed", "4294967296"], "'--seed <N>': 4294967296 is not in 0..=4294967295"),
        (&["--spp", "-1"], "'-1' for '--spp <N>'"),
        (&["--replicates", "65"], "--replicates"),
        (&["--variance", "--replicates", "1"], "--replicates"),
        (&["--variance", "--spp", "1"], "--variance"),
        (&["--integrator", "photon"], "path, light, bdpt"),
        (&["--mode", "grey"], "scalar, intensity, polarized"),
        (&["--no-such-option"], "--no-such-option"),
    ];
    for (options, words) in cases {
        let arguments = [&["render", "good.gltf", "-o", "out.exr"][..], options].concat();
        expect_error(&here, &before, &sunstone(&here, &arguments), 2, &[words]);
    }
    let others: [(&[&str], &str); 6] = [
        (&["render", "good.gltf"], "--output"),
        (&["render", "good.gltf", "-o", "out.png", "--variance"], "out.png"),
        (&["visualize", "good.exr", "-o", "out.jpg"], "out.jpg"),
        (&["visualize", "good.exr", "-o", "out.png", "--map", "no"], "aolp"),
        (&["compare", "a.exr", "b.exr", "--difference", "d.gif"], "d.gif"),
        (&["bake"], "bake"),
    ];
    for (arguments, words) in others {
        expect_error(&here, &before, &sunstone(&here, arguments), 2, &[words]);
    }
    assert_eq!(sunstone(&here, &[]).code, 2);
}

#[test]
fn colors_that_are_wrong_are_refused() {
    let here = folder_of_trouble("errors-color");
    let before = names_in(&here);
    let cases: [(&[&str], &str); 19] = [
        (&["--wavelength", "550"], "--color mono"),
        (&["--rgb-white", "e"], "--rgb-white goes with light at wavelengths"),
        (
            &["--color", "mono", "--wavelength", "299", "--rgb-white", "d65"],
            "--rgb-white d65 is known from 300 to 830 nanometers, not at 299",
        ),
        (&["--color", "mono", "--rgb-white", "d50"], "[possible values: d65, e]"),
        (&["--color", "mono", "--wavelength", "0"], "--wavelength"),
        (&["--color", "mono", "--wavelength", "1e9"], "--wavelength must be from 1 to 1000000"),
        (&["--color", "mono", "--wavelength", "-5"], "--wavelength must be from"),
        (&["--bands", "400:700:31"], "--bands goes with --color spectral"),
        (&["--color", "mono", "--range", "400:700"], "--range goes with --color spectral"),
        (&["--color", "spectral", "--wavelength", "5"], "--wavelength goes with --color mono"),
        (&["--color", "spectral", "--bands", "400:700"], "as in 400:700:31"),
        (&["--color", "spectral", "--bands", "700:400:3"], "turn them round"),
        (&["--color", "spectral", "--bands", "500:500:3"], "no width"),
        (&["--color", "spectral", "--bands", "NaN:500:3"], "--bands"),
        (
            &["--color", "spectral", "--bands", "400:700:31", "--wavelengths", "5"],
            "--wavelengths must be 4 or 8, not 5",
        ),
        (
            &["--color", "spectral", "--bands", "400:700:31", "--range", "400:700"],
            "--bands must be within range 400:700, and 400 nm reaches from 395 to 405 nm",
        ),
        (
            &["--color", "spectral", "--bands", "400:700:31", "--range", "710:390"],
            "--range must go from a shorter to a longer wavelength",
        ),
        (&["--color", "spectral", "--range", "blue"], "as in 380:780"),
        (
            &["--color", "spectral", "--bands", "400:700:31", "--output", "x.hdr"],
            "31 bands from 400 to 700 nm need an output that ends in .exr, .png, and x.hdr does",
        ),
    ];
    for (options, words) in cases {
        let arguments = [&["render", "good.gltf", "-o", "out.exr"][..], options].concat();
        expect_error(&here, &before, &sunstone(&here, &arguments), 2, &[words]);
    }
}

#[test]
fn a_film_that_exceeds_the_memory_is_refused_with_numbers() {
    let here = folder_of_trouble("errors-memory");
    let before = names_in(&here);
    let meminfo = fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let total =
        meminfo.lines().find_map(|line| line.strip_prefix("MemTotal:")?.split(' ').rev().nth(1));
    if total.is_none_or(|total| total.parse::<u64>().unwrap() > 500 << 20) {
        return; // unknown, or so much that the film might fit
    }
    let size = ["--width", "46000", "--height", "46000", "--spp", "32", "--variance"];
    let arguments = [&["render", "good.gltf", "-o", "out.exr"][..], &size].concat();
    let run = sunstone(&here, &arguments);
    expect_error(&here, &before, &run, 1, &["46000 x 46000", "1040.5 GiB", "available"]);
}

#[test]
fn images_that_are_wrong_are_refused() {
    let here = folder_of_trouble("errors-images");
    let render = |name: &str, width: &str| {
        let arguments = ["render", "good.gltf", "-o", name, "--spp", "1", "--width", width, "-q"];
        sunstone(&here, &arguments).done();
    };
    render("small.exr", "8");
    render("large.exr", "9");
    let before = names_in(&here);
    let cases: [(&[&str], &str); 8] = [
        (&["visualize", "missing.exr", "-o", "out.png"], "missing.exr"),
        (&["visualize", "broken.exr", "-o", "out.png"], "broken.exr"),
        (&["visualize", "good.gltf", "-o", "out.png"], "good.gltf"),
        (&["visualize", "small.exr", "-o", "missing/out.png"], "missing/out.png"),
        (&["compare", "small.exr", "large.exr"], "8 x 8"),
        (&["inspect", "file"], "of file: the extension must be one of .exr, .hdr, .npy, .gltf"),
        (&["inspect", "a.png"], "a.png: .png files cannot be read; those that can end in .exr"),
        (&["compare", "a.png", "b.png"], "a.png: .png files cannot be read"),
    ];
    for (arguments, words) in cases {
        expect_error(&here, &before, &sunstone(&here, arguments), 1, &[words]);
    }
}

/// Names in bytes that are no UTF-8 are names like others.
#[test]
#[cfg(target_os = "linux")]
fn names_need_not_be_utf8() {
    use std::os::unix::ffi::OsStrExt;
    let here = folder_of_trouble("errors-names");
    let mut command = Command::new(env!("CARGO_BIN_EXE_sunstone"));
    command.args(["render", "good.gltf", "--spp", "1", "--width", "8", "-o"]);
    command.arg(std::ffi::OsStr::from_bytes(b"caf\xe9.exr")).current_dir(&here);
    run(&mut command).done();
    assert!(names_in(&here).iter().any(|name| name.starts_with("caf")));
}

/// `sunstone inspect ... | head -1` is not an error.
#[test]
#[cfg(unix)]
fn a_reader_that_leaves_is_no_error() {
    let here = folder("errors-pipe");
    let script = "{ sleep 0.3; \"$0\" inspect \"$1\"; echo \"code $?\" >&2; } | true";
    let mut command = Command::new("sh");
    command.args(["-c", script, env!("CARGO_BIN_EXE_sunstone"), &scene("cornell")]);
    let run = run(command.current_dir(&here));
    assert_eq!(run.stderr.trim(), "code 0", "{}", run.stderr);
}
