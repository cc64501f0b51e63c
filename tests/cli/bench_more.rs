//! The verbs `bench overhead`, `bench scaling` and `bench error`: what they print, write and
//! refuse. How long things take is not tested.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::bench::{check_sums, number};
use crate::program::{Run, folder, names_in, scene, sunstone};

/// Runs a bench with its options as typed, in words.
fn bench(here: &Path, line: &str) -> Run {
    let words: Vec<&str> = std::iter::once("bench").chain(line.split_whitespace()).collect();
    sunstone(here, &words)
}

fn json(here: &Path, line: &str) -> Value {
    let run = bench(here, &format!("{line} --format json")).done();
    assert_eq!(run.stderr, "", "{}", run.command);
    serde_json::from_str(&run.stdout).unwrap()
}

fn list(value: &Value) -> &Vec<Value> {
    value.as_array().unwrap_or_else(|| panic!("{value} is no list"))
}

#[track_caller]
fn assert_near(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-9 * a.abs().max(b.abs()).max(1e-9), "{a} {b}");
}

/// The least film that can be measured.
const TINY_FILM: &str = "--width 24 --height 16";
/// The least that can be measured.
const TINY: &str = "--width 24 --height 16 --photons 500";

#[test]
fn overhead_adds_up_for_all_integrators() {
    let here = folder("overhead");
    let line = format!("overhead --integrator path,light --integrator bdpt,ppm --rounds 2 {TINY}");
    let report = json(&here, &format!("{line} --spp 4 --samples-per-iteration 2 --threads 2"));
    assert_eq!(report["conditions"]["width"], 24);
    let cases = list(&report["cases"]);
    let of = |key: &str| cases.iter().map(|case| case[key].as_str().unwrap()).collect::<Vec<_>>();
    assert_eq!(of("integrator"), ["path", "light", "bdpt", "ppm"].repeat(2));
    assert_eq!(of("scene")[3..5], ["mirror", "tank"]);
    for case in cases {
        assert_eq!((&case["same_paths"], &case["samples"]), (&Value::Bool(true), &4.into()));
        let has_photons = case["integrator"] == "ppm";
        // Two iterations of two samples.
        assert_eq!(case["photons_shot"].as_u64(), has_photons.then_some(1000));
        check_sums(case);
        check_shares(case);
        check_account(case);
    }
}

/// Two scenes of one file name, apart in the report, the plot and the record.
#[test]
fn scenes_of_one_name_are_told_apart() {
    let here = folder("overhead-names");
    for (folder, shipped) in [("one", "mirror"), ("two", "cornell")] {
        fs::create_dir(here.join(folder)).unwrap();
        fs::copy(scene(shipped), here.join(folder).join("room.gltf")).unwrap();
    }
    let line = "overhead one/room.gltf two/room.gltf --integrator path --rounds 1 --spp 1";
    let report =
        json(&here, &format!("{line} --width 16 --height 16 --plot a.svg --record a.ndjson"));
    let cases = list(&report["cases"]).iter().map(|case| case["scene"].as_str().unwrap());
    assert_eq!(cases.collect::<Vec<_>>(), ["one/room", "two/room"]);
    let plot = fs::read_to_string(here.join("a.svg")).unwrap();
    assert!(plot.contains("one/room path") && plot.contains("two/room path"), "{plot}");
    let record: Value = serde_json::from_slice(&fs::read(here.join("a.ndjson")).unwrap()).unwrap();
    let figures = record["figures"].as_object().unwrap();
    let of = |name: &str| figures.keys().filter(|key| key.starts_with(name)).count();
    let [one, two] = ["overhead.one_room.path.rgb.", "overhead.two_room.path.rgb."].map(of);
    assert!(one > 0 && one == two && one + two == figures.len(), "{figures:?}");
}

/// Shares of the overhead are those of the groups and add up to one.
fn check_shares(case: &Value) {
    let overhead = number(&case["all_stages"]["difference"]);
    let groups = list(&case["groups"]);
    let difference = |group: &Value| number(&group["difference"]);
    assert_near(groups.iter().map(difference).sum(), overhead);
    if overhead > 0.0 {
        let share = |group: &Value| number(&group["share_of_overhead"]);
        assert!((groups.iter().map(share).sum::<f64>() - 1.0).abs() < 1e-6, "{case}");
        assert!((share(&groups[0]) * overhead - difference(&groups[0])).abs() < 1e-9);
    } else {
        assert!(groups.iter().all(|group| group["share_of_overhead"].is_null()), "{case}");
    }
}

/// Of two rounds: the account is what the rounds say, and its verdict what the account says.
fn check_account(case: &Value) {
    if case["cpu"].is_null() {
        assert!(case["account"].is_null() && case["cpu_ratio"].is_null());
        return;
    }
    let rounds = list(&case["rounds"]);
    let mean = |of: &dyn Fn(&Value) -> f64| rounds.iter().map(of).sum::<f64>() / 2.0;
    let cpu = |round: &Value, mode: &str| number(&round[mode]["cpu_seconds"]);
    let difference = |round: &Value| cpu(round, "polarized") - cpu(round, "scalar");
    let account = &case["account"];
    assert_near(number(&account["measured"]), mean(&difference));
    assert_near(number(&case["cpu"]["difference"]), mean(&difference));
    let stages = |round: &Value, mode: &str| {
        list(&round[mode]["stages"]).iter().map(|stage| number(&stage[1])).sum::<f64>()
    };
    let gap = |round: &Value| {
        let counted = cpu(round, "polarized") + cpu(round, "scalar");
        let waiting = (stages(round, "polarized") + stages(round, "scalar")) / counted;
        let of_stages = stages(round, "polarized") - stages(round, "scalar");
        of_stages / waiting.max(1.0) - difference(round)
    };
    assert_near(number(&account["gap"]), mean(&gap));
    let [low, high] = ["low", "high"].map(|end| number(&account["gap_interval"][end]));
    let is_small = mean(&gap).abs() <= 0.1 * mean(&difference).abs();
    assert_eq!(account["adds_up"], is_small || (low <= 0.0 && high >= 0.0), "{account}");
    let ratio = &case["cpu_ratio"];
    let of_rounds = |round: &Value| cpu(round, "polarized") / cpu(round, "scalar");
    assert_near(number(&ratio["median_of_ratios"]), mean(&of_rounds));
}

#[test]
fn overhead_is_printed_drawn_and_recorded() {
    let here = folder("overhead-files");
    fs::copy(scene("caustic_glass"), here.join("my glass.gltf")).unwrap();
    let words = ["bench", "overhead", "my glass.gltf", "--integrator", "bdpt", "--color", "mono"];
    let files = ["--json", "a.json", "--plot", "a.svg", "--record", "a.ndjson"];
    let small = ["--wavelength", "633", "--rounds", "1", "--width", "16", "--height", "16"];
    let run = sunstone(&here, &[&words[..], &files, &small].concat()).done();
    for words in [
        "CPU time",
        "my glass bdpt",
        "633 nm, 16 x 16 pixels, 1 rounds a mode",
        "one round tells no interval",
        "of overhead",
        "the measured difference: medians",
        "Both modes had the same photons, rays and radii.",
    ] {
        assert!(run.stdout.contains(words), "{words:?}: {}", run.stdout);
    }
    assert!(run.stdout.lines().all(|line| line.chars().count() <= 100), "{}", run.stdout);
    let names = ["a.json", "a.ndjson", "a.svg", "my glass.gltf"];
    assert_eq!(names_in(&here), names);
    let svg = fs::read_to_string(here.join("a.svg")).unwrap();
    assert!(svg.starts_with("<svg") && svg.contains("my glass bdpt"), "{svg}");
    let record = fs::read_to_string(here.join("a.ndjson")).unwrap();
    let record: Value = serde_json::from_str(&record).unwrap();
    let report: Value =
        serde_json::from_str(&fs::read_to_string(here.join("a.json")).unwrap()).unwrap();
    let ratio = &report["cases"][0]["cpu_ratio"]["median_of_ratios"];
    assert_eq!(&record["figures"]["overhead.my_glass.bdpt.633_nm.ratio"], ratio);
    assert_eq!(record["bench"], "overhead");
}

/// Polarization is measured at several wavelengths, too, and in bands; figures tell them apart.
#[test]
fn overhead_of_wavelengths_has_a_name_of_its_own() {
    let here = folder("overhead-spectral");
    fs::copy(scene("mirror"), here.join("mirror.gltf")).unwrap();
    let line = "overhead mirror.gltf --integrator path --rounds 1 --spp 1 --color spectral";
    for (more, color, name) in [
        ("", "RGB of 8 wavelengths", "rgb_of_8_wavelengths"),
        ("--wavelengths 4", "RGB of 4 wavelengths", "rgb_of_4_wavelengths"),
        (
            "--bands 450:650:3 --wavelengths 4",
            "3 bands from 450 to 650 nm of 4 wavelengths",
            "3_bands_from_450_to_650_nm_of_4_wavelengths",
        ),
    ] {
        let report = json(&here, &format!("{line} {more} {TINY_FILM} --record a.ndjson"));
        assert_eq!(report["conditions"]["color"], color);
        assert_eq!(report["cases"][0]["same_paths"], true, "{color}");
        let record = fs::read_to_string(here.join("a.ndjson")).unwrap();
        let record: Value = serde_json::from_str(record.lines().last().unwrap()).unwrap();
        let figure = &record["figures"][format!("overhead.mirror.path.{name}.ratio")];
        assert!(number(figure) > 0.0, "{record}");
    }
}

/// Ratios and slopes of `bench wavelengths` are those of the rounds.
#[test]
fn wavelengths_are_compared_with_rgb() {
    let here = folder("bench-wavelengths");
    fs::copy(scene("cornell"), here.join("cornell.gltf")).unwrap();
    let line = "wavelengths cornell.gltf --integrator path --rounds 2 --spp 1 --threads 1";
    let files = "--record a.ndjson --plot a.svg";
    let report = json(&here, &format!("{line} {TINY_FILM} {files}"));
    let case = &report["cases"][0];
    let rows = list(&case["rows"]);
    let counts: Vec<u64> = rows.iter().map(|row| row["wavelengths"].as_u64().unwrap()).collect();
    assert_eq!(counts, [1, 3, 4, 8]);
    let names: Vec<&str> = rows.iter().map(|row| row["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["550 nm", "RGB", "4 wavelengths", "8 wavelengths"]);
    let rounds = |row: &Value, mode: &str| {
        list(&row[mode]["rounds"]).iter().map(number).collect::<Vec<f64>>()
    };
    let mean_ratio = |over: &[f64], under: &[f64]| {
        over.iter().zip(under).map(|(over, under)| over / under).sum::<f64>() / 2.0
    };
    for (index, mode) in ["scalar", "polarized"].into_iter().enumerate() {
        let rgb = rounds(&rows[1], mode);
        for row in rows {
            let of_row = rounds(row, mode);
            assert!(of_row.len() == 2 && of_row.iter().all(|seconds| *seconds > 0.0));
            assert_near(number(&row[mode]["ratio"]["median"]), mean_ratio(&of_row, &rgb));
            let modes = mean_ratio(&rounds(row, "polarized"), &rounds(row, "scalar"));
            assert_near(number(&row["modes"]["median"]), modes);
        }
        let logarithms = rows
            .iter()
            .map(|row| (number(&row["wavelengths"]).ln(), number(&row[mode]["seconds"]).ln()));
        let slope = slope_of(&logarithms.collect::<Vec<_>>());
        assert_near(number(&case["slopes"][index]["slope"]), slope);
    }
    let record = fs::read_to_string(here.join("a.ndjson")).unwrap();
    let record: Value = serde_json::from_str(&record).unwrap();
    let figure = |name: &str| &record["figures"][format!("wavelengths.cornell.path.{name}")];
    assert_eq!(figure("polarized.8.ratio"), &rows[3]["polarized"]["ratio"]["median"]);
    assert_eq!(figure("4.ratio"), &rows[2]["modes"]["median"]);
    assert_eq!(figure("scalar.slope"), &case["slopes"][0]["slope"]);
    assert!(fs::read_to_string(here.join("a.svg")).unwrap().contains("cornell path"));
    let run = bench(&here, &format!("{line} {TINY_FILM} --color mono --wavelength 633")).done();
    for words in ["\n633 nm        |", "\n8 wavelengths |", "log-log slope: "] {
        assert!(run.stdout.contains(words), "{words:?}: {}", run.stdout);
    }
    assert!(run.stdout.lines().all(|line| line.chars().count() <= 100), "{}", run.stdout);
}

#[test]
fn scaling_fits_lines_to_its_points() {
    let here = folder("scaling");
    let line = "scaling --width 16 --height 16 --spp 1 --points 3 --rounds 2 --threads 2";
    let report = json(&here, &format!("{line} --integrator path --record a.ndjson"));
    let series = list(&report["series"]);
    let names: Vec<&str> = series.iter().map(|series| series["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["threads", "samples", "photons", "pixels", "wavelengths"]);
    let sizes = [
        vec![1.0, 2.0],
        vec![1.0, 2.0, 4.0],
        vec![1e4, 3e4, 1e5],
        vec![4096.0, 16384.0, 65536.0],
        vec![1.0, 3.0, 4.0],
    ];
    for (series, sizes) in series.iter().zip(sizes) {
        let points = list(&series["points"]);
        let of: Vec<f64> = points.iter().map(|point| number(&point["size"])).collect();
        assert_eq!(of, sizes, "{}", series["name"]);
        for clock in ["cpu", "wall"].iter().filter(|clock| !points[0][**clock].is_null()) {
            let seconds = |point: &Value| number(&point[*clock]["seconds"]);
            assert!(points.iter().all(|point| seconds(point) > 0.0));
            let slope = if *clock == "cpu" { "slope" } else { "wall_slope" };
            let logarithms = points.iter().map(|p| (number(&p["size"]).ln(), seconds(p).ln()));
            let logarithms: Vec<(f64, f64)> = logarithms.collect();
            assert_near(number(&series[slope]["slope"]), slope_of(&logarithms));
            assert_eq!(series[slope]["standard_error"].is_null(), points.len() < 3);
        }
        assert_eq!(series["speedups"].is_null(), series["name"] != "threads");
    }
    let wall = |point: usize| number(&series[0]["points"][point]["wall"]["seconds"]);
    assert_near(number(&series[0]["speedups"][1]), wall(0) / wall(1));
    let record = fs::read_to_string(here.join("a.ndjson")).unwrap();
    let record: Value = serde_json::from_str(&record).unwrap();
    let figure = |name: &str| &record["figures"][format!("scaling.mirror.{name}")];
    assert_eq!(figure("ppm.rgb.photons.slope"), &series[2]["slope"]["slope"]);
    assert_eq!(figure("path.rgb.threads.speedup"), &series[0]["speedups"][1]);
}

/// The slope of a line through points as the mean of those through pairs, weighed by the square
/// of their distance: another way to the line of least squares.
fn slope_of(points: &[(f64, f64)]) -> f64 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for (index, a) in points.iter().enumerate() {
        for b in &points[..index] {
            sum += (a.1 - b.1) * (a.0 - b.0);
            weights += (a.0 - b.0).powi(2);
        }
    }
    sum / weights
}

#[test]
fn scaling_is_printed_and_drawn() {
    let here = folder("scaling-text");
    let line = "scaling --series samples,wavelengths --points 2 --rounds 1 --plot a.svg";
    let run = bench(&here, &format!("{line} {TINY} --integrator ppm --mode scalar")).done();
    for words in [
        "of mirror, scalar, RGB",
        "samples: ppm, RGB, 24 x 16 pixels, 500 light paths an iteration",
        "wavelengths: ppm, 24 x 16 pixels, 16 samples a pixel, 500 light paths",
        "log-log slope: ",
    ] {
        assert!(run.stdout.contains(words), "{words:?}: {}", run.stdout);
    }
    let svg = fs::read_to_string(here.join("a.svg")).unwrap();
    assert!(svg.contains("samples: ppm") && svg.contains("wall clock"), "{svg}");
}

/// The steps of an integrator, and its error in one component at each.
fn steps(report: &Value, integrator: usize, component: usize) -> Vec<(f64, f64)> {
    let steps = list(&report["integrators"][integrator]["steps"]).iter();
    let error = |step: &Value| number(&step["errors"][component]["relative_mse"]);
    steps.map(|step| (number(&step["seconds"]), error(step))).collect()
}

#[test]
fn errors_are_those_of_compare() {
    let here = folder("error");
    let cornell = scene("cornell");
    let size = ["--width", "24", "--height", "16"];
    let render = |name: &str, more: &[&str]| {
        // Measurements have a limit by default, renders none.
        let words = ["render", &cornell, "-o", name, "--quiet", "--max-path-length", "16"];
        sunstone(&here, &[&words[..], &size, more].concat()).done();
    };
    render("reference.exr", &["--spp", "64", "--seed", "9", "--variance"]);
    render("path.exr", &["--spp", "4", "--integrator", "path", "--seed", "1"]);
    let line = format!("error {cornell} --reference reference.exr --iterations 4 --seeds 1");
    let report = json(&here, &format!("{line} --integrator path,bdpt --seed 1 --plot a.svg"));
    assert_eq!(report["conditions"]["width"], 24);
    assert!(list(&report["reference"]["relative_variance"]).len() == 4);
    let compared = sunstone(&here, &["compare", "path.exr", "reference.exr", "--json"]).done();
    let compared: Value = serde_json::from_str(&compared.stdout).unwrap();
    let last = &report["integrators"][0]["steps"][2];
    assert_eq!(last["iterations"], 4);
    for (ours, theirs) in list(&last["errors"]).iter().zip(list(&compared["components"])) {
        assert_eq!(ours["name"], theirs["name"]);
        for key in ["rmse", "relative_mse"] {
            // The steps add up in another order than a render in one go.
            let (a, b) = (number(&ours[key]), number(&theirs[key]));
            assert!((a - b).abs() <= 1e-3 * b, "{key}: {a} {b}");
        }
    }
    let duels = list(&report["duels"]);
    assert_eq!(duels.len(), 4);
    let (first, other) = (steps(&report, 0, 0), steps(&report, 1, 0));
    for equal in list(&duels[0]["equal_time"]) {
        let at = number(&equal["at"]);
        let covers = |curve: &[(f64, f64)]| curve[0].0 <= at && at <= curve[curve.len() - 1].0;
        assert!(covers(&first) && covers(&other), "{equal} is beyond what was measured");
        assert!(number(&equal["ratio"]) > 0.0);
    }
    let svg = fs::read_to_string(here.join("a.svg")).unwrap();
    assert!(svg.contains("S3") && svg.contains("bdpt"), "{svg}");
}

#[test]
fn a_reference_is_rendered_if_none_is_given() {
    let here = folder("error-rendered");
    let mirror = scene("mirror");
    let small = "--reference-spp 16 --iterations 32 --seeds 2 --mode scalar --color mono";
    let line = format!("error {mirror} {small} --integrator ppm,path {TINY} --record a.ndjson");
    let run = bench(&here, &line).done();
    for words in [
        "mirror, scalar, 550 nm, 24 x 16 pixels",
        "means of 2 renders with different seeds",
        "The reference is bdpt with 16 samples a pixel, rendered here.",
        "Against ppm",
        "Caution: more than 10 % of the least error in S0",
    ] {
        assert!(run.stdout.contains(words), "{words:?}: {}", run.stdout);
    }
    assert!(!run.stdout.contains("S1"), "{}", run.stdout);
    let record = fs::read_to_string(here.join("a.ndjson")).unwrap();
    assert!(record.contains("error.mirror.ppm.550_nm.S0.relative_mse_seconds"), "{record}");
}

#[test]
fn references_that_do_not_fit_are_refused() {
    let here = folder("error-reference");
    let cornell = scene("cornell");
    let small = ["--spp", "1", "--width", "24", "--height", "16", "--quiet"];
    for (name, more) in [("a.exr", &[][..]), ("scalar.exr", &["--mode", "scalar"])] {
        let words = ["render", &cornell, "-o", name];
        sunstone(&here, &[&words[..], &small, more].concat()).done();
    }
    let before = names_in(&here);
    for (options, code, words) in [
        ("a.exr --width 32", 2, "a.exr is an RGB image of 24 x 16 pixels"),
        ("a.exr --width 32", 2, "cornell.gltf would be an RGB image of 32 x 16 pixels"),
        ("a.exr --color mono", 2, "would be a monochromatic image of 24 x 16 pixels: choose"),
        ("scalar.exr", 2, "goes with --mode scalar"),
        ("missing.exr", 1, "missing.exr"),
        ("a.exr --json a.exr", 2, "is the input a.exr"),
        ("a.exr --reference-spp 32", 2, "cannot be used with"),
        ("a.exr --integrator path,path", 2, "names an integrator twice"),
        ("a.exr --seconds nan", 2, "--seconds must be a number of seconds"),
        ("a.exr --iterations 0", 2, "--iterations must be from 1"),
        ("a.exr --seeds 0", 2, "--seeds must be from 1"),
    ] {
        let run = bench(&here, &format!("error {cornell} --reference {options}"));
        assert_eq!(run.code, code, "{}: {}", run.command, run.stderr);
        assert!(run.stderr.contains(words), "{}: {}", run.command, run.stderr);
        assert_eq!((run.stdout.as_str(), names_in(&here)), ("", before.clone()), "{}", run.command);
    }
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let here = folder("bench-more-errors");
    fs::copy(scene("mirror"), here.join("good.gltf")).unwrap();
    fs::create_dir(here.join("other")).unwrap();
    fs::copy(scene("mirror"), here.join("other/good.gltf")).unwrap();
    fs::write(here.join("broken.gltf"), "{").unwrap();
    let before = names_in(&here);
    for (line, code, words) in [
        ("overhead --rounds 0", 2, "--rounds must be from 1"),
        ("overhead --spp 0", 2, "--spp must be from 1"),
        ("overhead --spp 8 --iterations 2", 2, "cannot be used with"),
        ("overhead --spp 10", 2, "--spp 10 is not a multiple of --samples-per-iteration 16"),
        ("overhead --integrator path --photons 10", 2, "--photons goes with --integrator ppm"),
        ("overhead --integrator path,vcm", 2, "vcm"),
        ("overhead --integrator path,path", 2, "twice"),
        ("overhead --wavelength 500", 2, "--wavelength goes with --color mono"),
        ("overhead --wavelengths 4", 2, "--wavelengths goes with --color spectral"),
        ("overhead --color spectral --wavelengths 5", 2, "--wavelengths must be 4 or 8, not 5"),
        ("wavelengths --color spectral --wavelengths 4", 2, "every number of them is measured"),
        ("wavelengths --rounds 0", 2, "--rounds must be from 1"),
        ("overhead --width 70000", 2, "--width must be from 1"),
        ("overhead --max-path-length 0", 2, "--max-path-length must be from 1"),
        ("overhead --threads 0", 2, "--threads must be from 1"),
        ("overhead --json a --record a", 2, "choose different files"),
        ("overhead --plot a.png", 1, ".svg (plots are SVG)"),
        ("overhead --plot missing/a.svg", 1, "missing/a.svg"),
        ("overhead --record missing/a.ndjson", 1, "missing/a.ndjson"),
        ("overhead --record good.gltf good.gltf", 2, "is the input good.gltf"),
        ("overhead --record broken.gltf", 1, "broken.gltf is not a usable record file: line 1"),
        ("overhead good.gltf other/good.gltf ./good.gltf", 2, "good.gltf is named twice"),
        ("overhead good.gltf broken.gltf", 1, "broken.gltf"),
        ("scaling --series time", 2, "time"),
        ("scaling --series pixels,pixels", 2, "names a series twice"),
        ("scaling --rounds 0", 2, "--rounds must be from 1"),
        ("scaling --points 0", 2, "--points must be from 1"),
        ("scaling --spp 0", 2, "--spp must be from 1"),
        ("scaling --photons 100", 2, "--photons goes with --integrator ppm"),
        ("scaling missing.gltf", 1, "missing.gltf"),
        ("scaling good.gltf --json good.gltf", 2, "is the input good.gltf"),
        ("error", 2, "<SCENE>"),
        ("error good.gltf --reference-spp 8", 2, "--reference-spp must be 16 or more, not 8"),
        ("error broken.gltf", 1, "broken.gltf"),
    ] {
        let run = bench(&here, line);
        assert_eq!(run.code, code, "{}: {}", run.command, run.stderr);
        assert!(run.stderr.contains(words), "{}: {}", run.command, run.stderr);
        assert_eq!((run.stdout.as_str(), names_in(&here)), ("", before.clone()), "{}", run.command);
    }
}
