//! Renders that are stopped, killed or cut into parts have the bits of one that is not.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use sunstone::internals::image::{self, StokesImage};

use crate::program::{Run, folder, names_in, scene, sunstone};

const RENDER: [&str; 9] =
    ["-q", "--width", "16", "--spp", "64", "--threads", "2", "--max-path-length", "6"];

/// The command line of a render of the Cornell box.
fn command(options: &[&str]) -> Vec<String> {
    let scene = scene("cornell");
    let words = ["render", &scene].into_iter().chain(RENDER).chain(options.iter().copied());
    words.map(String::from).collect()
}

fn render(here: &Path, options: &[&str]) -> Run {
    let words = command(options);
    sunstone(here, &words.iter().map(String::as_str).collect::<Vec<_>>())
}

fn begin(here: &Path, options: &[&str]) -> Child {
    let mut program = Command::new(env!("CARGO_BIN_EXE_sunstone"));
    program.args(command(options)).current_dir(here).stderr(Stdio::piped()).spawn().unwrap()
}

fn load(here: &Path, name: &str) -> StokesImage {
    image::load(&here.join(name)).unwrap()
}

#[track_caller]
fn assert_same(one: &StokesImage, other: &StokesImage) {
    assert!(one.planes == other.planes, "values differ");
    assert!(one.variance == other.variance, "variances differ");
}

/// Killed without a word at moments that are not chosen, and taken up again until it is done.
#[test]
fn a_killed_render_goes_on_to_the_same_bits() {
    const GOES_ON: [&str; 5] = ["--checkpoint", "a b.ck", "--checkpoint-every", "0", "--resume"];
    for (name, options) in [
        ("killed-path", &["--integrator", "path", "--variance"][..]),
        ("killed-ppm", &["--integrator", "ppm", "--photons", "5000"]),
    ] {
        let here = folder(name);
        render(&here, &[options, &["-o", "whole.exr"]].concat()).done();
        let goes_on = [options, &["-o", "out.exr"], &GOES_ON].concat();
        for milliseconds in [30, 110, 170, 260, 90, 140] {
            let mut child = begin(&here, &goes_on);
            std::thread::sleep(Duration::from_millis(milliseconds));
            child.kill().unwrap();
            child.wait().unwrap();
            if here.join("out.exr").exists() {
                fs::remove_file(here.join("out.exr")).unwrap();
            }
        }
        render(&here, &goes_on).done();
        assert_same(&load(&here, "out.exr"), &load(&here, "whole.exr"));
        assert_eq!(names_in(&here), ["out.exr", "whole.exr"]);
    }
}

/// A signal leaves the image so far and what is needed to go on.
#[test]
#[cfg(unix)]
fn a_signal_leaves_a_checkpoint() {
    let here = folder("signal-checkpoint");
    let long = ["--spp", "100000", "-o", "out.exr", "--checkpoint", "c.part"];
    let child = begin(&here, &long);
    // The first is written as soon as there is something to go on from.
    while !here.join("c.part").exists() {
        std::thread::sleep(Duration::from_millis(20));
    }
    let kill = Command::new("kill").args(["-s", "TERM", &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(143), "{stderr}");
    assert!(stderr.contains("--checkpoint c.part --resume goes on"), "{stderr}");
    assert_eq!(names_in(&here), ["c.part", "out.exr"]);

    let told = sunstone(&here, &["inspect", "c.part"]).done().stdout;
    assert!(told.contains("seed: 0") && told.contains("end sample: 100000"), "{told}");
    let refused = render(&here, &long);
    assert_eq!(refused.code, 2, "{}", refused.stderr);
    assert!(refused.stderr.contains("go on from it with --resume"), "{}", refused.stderr);
    let other = render(&here, &[&long[..], &["--resume", "--seed", "5"]].concat());
    assert_eq!(other.code, 1);
    assert!(other.stderr.contains("its seed is 0, and here it is 5"), "{}", other.stderr);
    assert_eq!(names_in(&here), ["c.part", "out.exr"]);
}

#[test]
fn parts_merge_to_the_bits_of_one_render() {
    for (name, options) in [
        ("parts-bdpt", &["--integrator", "bdpt", "--variance"][..]),
        ("parts-ppm", &["--integrator", "ppm", "--photons", "2000", "--replicates", "7"]),
        ("parts-light", &["--integrator", "light", "--color", "mono"]),
    ] {
        let here = folder(name);
        render(&here, &[options, &["-o", "whole.exr"]].concat()).done();
        let names: Vec<String> = (1..=7).map(|number| format!("p{number}.part")).collect();
        for (name, number) in names.iter().zip(1..) {
            let part = format!("{number}/7");
            let part = ["-o", name, "--part", &part, "--threads", "1"];
            render(&here, &[options, &part].concat()).done();
        }
        let merge = |names: &[String]| {
            let words = names.iter().map(String::as_str);
            let all: Vec<&str> = ["merge", "-o", "merged.exr"].into_iter().chain(words).collect();
            sunstone(&here, &all)
        };
        let missing = merge(&names[..6]);
        assert_eq!(missing.code, 1);
        assert!(missing.stderr.contains("part 7/7 is missing"), "{}", missing.stderr);
        merge(&names).done();
        assert_same(&load(&here, "merged.exr"), &load(&here, "whole.exr"));
    }
}

/// Parts and checkpoints are known by what they hold, and no variance goes in silence.
#[test]
fn parts_have_any_name_and_images_keep_what_their_formats_do() {
    let here = folder("parts-named");
    for number in ["1", "2"] {
        let part = ["--variance", "-o", "p.part", "--part", &format!("{number}/2")];
        render(&here, &part).done();
        fs::rename(here.join("p.part"), here.join(["one.gltf", "two"][usize::from(number == "2")]))
            .unwrap();
    }
    for (name, part) in [("one.gltf", "part: 1/2"), ("two", "part: 2/2")] {
        let told = sunstone(&here, &["inspect", name]).done().stdout;
        assert!(told.contains(part) && told.contains("variance: blocks"), "{told}");
    }
    for (output, stored) in [("a.exr", true), ("a.hdr", false), ("a.png", false)] {
        let run = sunstone(&here, &["merge", "-q", "one.gltf", "two", "-o", output]).done();
        let words = format!(
            "warning: no variances are stored: .{} files hold none; the parts do, and an output \
             that ends in .exr keeps them\n",
            &output[2..]
        );
        assert_eq!(run.stderr, if stored { String::new() } else { words });
    }
    // Where none are asked for, nothing is lost.
    for number in ["1", "2"] {
        let name = format!("q{number}.part");
        render(&here, &["-o", &name, "--part", &format!("{number}/2")]).done();
    }
    let run = sunstone(&here, &["merge", "-q", "q1.part", "q2.part", "-o", "b.png"]).done();
    assert_eq!(run.stderr, "");
    fs::write(here.join("short"), "sunstone").unwrap();
    fs::write(here.join("no.part"), "nothing").unwrap();
    for (name, words) in [("short", "short"), ("no.part", "is not a usable part file")] {
        let run = sunstone(&here, &["inspect", name]);
        assert!(run.code == 1 && run.stderr.contains(words), "{}", run.stderr);
    }
}

#[test]
fn parts_are_refused_where_they_are_none() {
    let here = folder("parts-refused");
    for (options, expected) in [
        (&["--part", "1/2", "-o", "a.exr"][..], "needs an output that ends in .part"),
        (&["-o", "a.part"], "say which part of the image it is"),
        (&["--part", "3/2", "-o", "a.part"], "must be from 1/N to N/N, not 3/2"),
        (&["--part", "half", "-o", "a.part"], "must be K/N, as in 3/7"),
        (&["--part", "1/65", "-o", "a.part"], "has 64 iterations, and no more parts"),
        (&["--part", "1/2", "--time-limit", "1", "-o", "a.part"], "cannot be used with"),
        (&["--resume", "-o", "a.exr"], "--checkpoint <FILE>"),
        (&["--checkpoint", "a.exr", "-o", "a.exr"], "choose another name"),
    ] {
        let run = render(&here, options);
        assert_eq!(run.code, 2, "{}: {}", run.command, run.stderr);
        assert!(run.stderr.contains(expected), "{}: {}", run.command, run.stderr);
    }
    let none = sunstone(&here, &["merge", "-o", "a.exr", &scene("cornell")]);
    assert_eq!(none.code, 1);
    assert!(none.stderr.contains("cornell.gltf is not a usable part file"), "{}", none.stderr);
    assert!(names_in(&here).is_empty());
}
