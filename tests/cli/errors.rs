//! What goes wrong is said once, in words that name the file and the field, with exit code 1 or
//! 2, and leaves nothing behind.

use std::fs;
use std::path::Path;
use std::process::Command;

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
    let cases: [(&str, &[&str]); 9] = [
        ("missing.gltf", &["missing.gltf"]),
        ("scene.obj", &["scene.obj", "glTF"]),
        ("broken.gltf", &["broken.gltf"]),
        ("empty.gltf", &["empty.gltf"]),
        ("noise.glb", &["noise.glb"]),
        ("dark.gltf", &["dark.gltf", "emi"]),
        ("blind.gltf", &["blind.gltf", "camera"]),
        ("typo.gltf", &["typo.gltf", "material 4 \"glass\"", "SUNSTONE_polarization.iro"]),
        ("range.gltf", &["range.gltf", "material 0 \"white\"", "reflectance"]),
    ];
    for (scene, words) in cases {
        let run = sunstone(&here, &["render", scene, "-o", "out.exr", "--spp", "1"]);
        expect_error(&here, &before, &run, 1, words);
    }
    for (scene, words) in [("missing.gltf", "missing.gltf"), ("broken.gltf", "broken.gltf")] {
        expect_error(&here, &before, &sunstone(&here, &["inspect", scene]), 1, &[words]);
    }
}

#[test]
fn outputs_that_cannot_be_written_are_refused_before_the_render() {
    let here = folder_of_trouble("errors-outputs");
    let before = names_in(&here);
    let cases: [(&str, &[&str]); 6] = [
        ("out.bmp", &["out.bmp", ".exr, .hdr, .png"]),
        ("out", &["out", ".exr, .hdr, .png"]),
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

/// A disk that fills up, played by a limit on the size of files.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_leaves_the_former_file() {
    let here = folder_of_trouble("errors-full");
    fs::write(here.join("out.exr"), b"the former file").unwrap();
    let before = names_in(&here);
    let script = "trap '' XFSZ; ulimit -f 1; exec \"$0\" \"$@\"";
    let mut command = Command::new("sh");
    command.args(["-c", script, env!("CARGO_BIN_EXE_sunstone"), "render", "good.gltf"]);
    command.args(["-o", "out.exr", "--width", "64", "--spp", "1"]).current_dir(&here);
    expect_error(&here, &before, &run(&mut command), 1, &["out.exr"]);
    assert_eq!(fs::read(here.join("out.exr")).unwrap(), b"the former file");
}

#[test]
fn command_lines_that_are_wrong_are_refused() {
    let here = folder_of_trouble("errors-usage");
    let before = names_in(&here);
    let cases: [(&[&str], &str); 19] = [
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
        (&["--wavelength", "550"], "--color mono"),
        (&["--color", "mono", "--wavelength", "0"], "--wavelength"),
        (&["--replicates", "65"], "--replicates"),
        (&["--variance", "--replicates", "1"], "--replicates"),
        (&["--variance", "--spp", "2"], "--replicates"),
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
    expect_error(&here, &before, &run, 1, &["46000 x 46000", "756.7 GiB", "available"]);
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
    let cases: [(&[&str], &str); 6] = [
        (&["visualize", "missing.exr", "-o", "out.png"], "missing.exr"),
        (&["visualize", "broken.exr", "-o", "out.png"], "broken.exr"),
        (&["visualize", "good.gltf", "-o", "out.png"], "good.gltf"),
        (&["visualize", "small.exr", "-o", "missing/out.png"], "missing/out.png"),
        (&["compare", "small.exr", "large.exr"], "8 x 8"),
        (&["inspect", "file"], "file"),
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
