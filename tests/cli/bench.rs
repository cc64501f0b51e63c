//! The verb `bench table1`: what it prints, writes and refuses. How long things take is not tested.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::program::{Run, folder, names_in, scene, sunstone};

const TINY: [&str; 10] = [
    "--width",
    "64",
    "--height",
    "64",
    "--photons",
    "2000",
    "--iterations",
    "2",
    "--samples-per-iteration",
    "2",
];

fn table1(here: &Path, more: &[&str]) -> Run {
    sunstone(here, &[&["bench", "table1"], &TINY[..], more].concat())
}

/// The number that a value is.
pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// The shipped scenes come with the program: the folder is empty.
#[test]
fn both_tables_are_printed_for_the_shipped_scenes() {
    let here = folder("bench-text");
    let run = table1(&here, &[]).done();
    for words in [
        "Table 1: seconds per iteration",
        "   3 mirror ",
        "   4 tank ",
        "527K      8     14  1.75",
        "300K     17     33  1.94",
        "averages over 500 iterations, each of 1000000 light paths",
        "2 iterations a mode, each of 2000 light paths\nand 2 samples a pixel",
        "with a chance of 50.0 %",
        "Both modes had the same photons, rays and radii.",
        "mirror, stage by stage",
        "tank, stage by stage",
        "sample (start, scatter, emission, flight) ",
        "apply Mueller ",
        "all stages ",
    ] {
        assert!(run.stdout.contains(words), "{words:?}: {}", run.stdout);
    }
    assert_eq!(run.stderr, "");
    assert!(run.stdout.lines().all(|line| line.chars().count() <= 100), "{}", run.stdout);
    assert!(names_in(&here).is_empty());
}

#[test]
fn the_report_is_json_and_adds_up() {
    let here = folder("bench-json");
    let run = table1(&here, &["--format", "json", "--json", "a.json", "--threads", "2"]).done();
    // Nothing but, of long runs, how far they are.
    assert!(run.stderr.lines().all(|line| line.contains(" rounds in ")), "{}", run.stderr);
    assert_eq!(fs::read_to_string(here.join("a.json")).unwrap(), run.stdout);
    let json: Value = serde_json::from_str(&run.stdout).unwrap();
    let conditions = &json["conditions"];
    assert_eq!(conditions["version"], env!("CARGO_PKG_VERSION"));
    for (key, value) in [("threads", 2), ("width", 64), ("photons_shot", 2000), ("iterations", 2)] {
        assert_eq!(conditions[key], value, "{key}");
    }
    for (scene, name) in json["scenes"].as_array().unwrap().iter().zip(["mirror", "tank"]) {
        assert_eq!(scene["scene"], name);
        assert_eq!(scene["same_paths"], true, "{name}");
        assert_eq!(scene["rounds"].as_array().unwrap().len(), 2);
        assert!(number(&scene["photons"]) > 0.0, "{name}");
        check_sums(scene);
    }
}

/// Two rounds, their ratios and groups of a scene are consistent.
pub fn check_sums(scene: &Value) {
    let is_near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs().max(b.abs()).max(1e-3);
    let rounds = scene["rounds"].as_array().unwrap();
    assert_ne!(rounds[0]["polarized_first"], rounds[1]["polarized_first"]);
    for mode in ["scalar", "polarized"] {
        let mean = |of: &dyn Fn(&Value) -> f64| {
            rounds.iter().map(|round| of(&round[mode])).sum::<f64>() / rounds.len() as f64
        };
        let seconds = mean(&|measured| number(&measured["seconds"]));
        assert!(is_near(seconds, number(&scene[format!("{mode}_seconds")])), "two rounds");
        let stages = mean(&|measured| {
            measured["stages"].as_array().unwrap().iter().map(|stage| number(&stage[1])).sum()
        });
        let groups = scene["groups"].as_array().unwrap();
        let of_groups: f64 = groups.iter().map(|group| number(&group[mode])).sum();
        assert!(is_near(stages, of_groups), "{mode}: {stages} {of_groups}");
        assert!(is_near(stages, number(&scene["all_stages"][mode])), "{mode}");
        assert!(stages > 0.0 && seconds > 0.0);
    }
    let ratio = number(&scene["polarized_seconds"]) / number(&scene["scalar_seconds"]);
    assert!(is_near(ratio, number(&scene["ratio_of_medians"])));
    let interval = &scene["ratio_interval"];
    let median = number(&scene["median_of_ratios"]);
    assert!(number(&interval["low"]) <= median && median <= number(&interval["high"]));
    assert_eq!(number(&interval["coverage"]), 0.5);
}

#[test]
fn scenes_are_named_by_path() {
    let here = folder("bench-paths");
    fs::copy(scene("mirror"), here.join("copy.gltf")).unwrap();
    let named = ["copy.gltf", &scene("reference/cornell")];
    let more = [&["--format", "json", "--photons", "500", "--iterations", "1"], &named[..]];
    let json: Value = serde_json::from_str(&table1(&here, &more.concat()).done().stdout).unwrap();
    let scenes = json["scenes"].as_array().unwrap();
    let names: Vec<&str> = scenes.iter().map(|scene| scene["scene"].as_str().unwrap()).collect();
    assert_eq!(names, named);
    assert_eq!(scenes[0]["paper"]["figure"], 3, "a copy of a shipped scene is that scene");
    assert_eq!(scenes[1]["paper"], Value::Null);
    assert_eq!(scenes[0]["ratio_interval"], Value::Null, "one round has no interval");
    let text = table1(&here, &["--iterations", "1", "copy.gltf"]).done().stdout;
    assert!(text.contains("one round tells none"), "{text}");
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let here = folder("bench-errors");
    fs::copy(scene("mirror"), here.join("good.gltf")).unwrap();
    fs::write(here.join("broken.gltf"), "{").unwrap();
    let before = names_in(&here);
    let cases: [(&[&str], i32, &str); 16] = [
        (&["--iterations", "0"], 2, "--iterations must be from 1"),
        (&["--iterations", "1073741824"], 2, "--iterations must be from 1"),
        (&["--photons", "0"], 2, "--photons must be from 1"),
        (&["--photons", "4294967295"], 2, "--photons must be from 1"),
        (&["--samples-per-iteration", "0"], 2, "--samples-per-iteration must be from 1"),
        (&["--width", "0"], 2, "--width must be from 1"),
        (&["--height", "70000"], 2, "--height must be from 1"),
        (&["--width", "65000", "--height", "65000"], 2, "65000 x 65000"),
        (&["--threads", "0"], 2, "--threads must be from 1"),
        (&["--format", "xml"], 2, "text, json"),
        (&["--json", "good.gltf", "good.gltf"], 2, "is the input good.gltf"),
        (&["--json", "missing/a.json"], 1, "missing/a.json"),
        (&["missing.gltf"], 1, "missing.gltf"),
        // The last scene is looked at before the first is measured.
        (&["--iterations", "100000", "good.gltf", "broken.gltf"], 1, "broken.gltf"),
        (&["--spp", "4"], 2, "--spp"),
        (&["--plot", "a.png"], 1, ".svg (plots are SVG)"),
    ];
    for (options, code, words) in cases {
        let run = table1(&here, options);
        assert_eq!(run.code, code, "{}: {}", run.command, run.stderr);
        assert!(run.stderr.contains(words), "{}: {}", run.command, run.stderr);
        assert_eq!(run.stdout, "", "{}", run.command);
        assert_eq!(names_in(&here), before, "{}", run.command);
    }
    for (arguments, words) in [(&["bench"][..], "table1"), (&["bench", "table2"], "table2")] {
        let run = sunstone(&here, arguments);
        assert_eq!(run.code, 2, "{}: {}", run.command, run.stderr);
        assert!(run.stderr.contains(words), "{}: {}", run.command, run.stderr);
    }
}
