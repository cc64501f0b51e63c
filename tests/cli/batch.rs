//! The verb `batch`: sweeps are single renders, what is done is skipped, what fails stops no other.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use sunstone::internals::image;

use crate::program::{Run, folder, names_in, scene, sunstone};

/// Longest that anything here takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// A folder with a scene, `lab.gltf`, and a job file of this text behind the usual defaults.
fn lab(name: &str, jobs: &str) -> PathBuf {
    let here = folder(&format!("batch-{name}"));
    fs::copy(scene("cornell"), here.join("lab.gltf")).unwrap();
    write(&here, jobs);
    here
}

fn write(here: &Path, jobs: &str) {
    let defaults = "[defaults]\nscene = \"lab.gltf\"\nintegrator = \"path\"\nspp = 2\nwidth = 8\n\
                    height = 8\n";
    fs::write(here.join("jobs.toml"), format!("version = 1\n{defaults}{jobs}")).unwrap();
}

fn batch(here: &Path, arguments: &[&str]) -> Run {
    sunstone(here, &[&["batch", "jobs.toml", "--threads", "2"][..], arguments].concat())
}

fn planes(path: &Path) -> Vec<Vec<f32>> {
    image::load(path).unwrap_or_else(|error| panic!("{error}")).planes
}

fn records(here: &Path) -> Vec<Value> {
    let text = fs::read_to_string(here.join("results.jsonl")).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// The SHA-256 that other people's program finds.
fn sha256sum(path: &Path) -> Option<String> {
    let output = Command::new("sha256sum").arg(path).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    text.split_whitespace().next().map(str::to_owned)
}

const SWEEP: &str = r#"
[[jobs]]
name = "sweep"
output = "out/{name}-{angle:05.1}-{ior}-{yfov}.exr"
set = { "media/fog/g" = 0 }
sweep = [
    { name = "angle", key = "materials/half-wave plate/axis_deg", from = 0, to = 45, count = 2 },
    { name = "ior", key = "materials/#5/ior", values = [1.33, 1.7] },
    { name = "yfov", key = "cameras/camera/perspective.yfov", values = [0.5, 0.75] },
]
[[jobs]]
output = "out/{name} {index:04}.exr"
sweep = [{ name = "x", key = "nodes/glass ball/translation.0", values = [-0.5, -0.4] }]
"#;

#[test]
fn jobs_are_single_renders_of_edited_files() {
    let here = lab("single", &SWEEP.replace("set = { \"media/fog/g\" = 0 }\n", ""));
    batch(&here, &[]).done();
    let edited = |name: &str, edit: &dyn Fn(&mut Value)| {
        let text = fs::read_to_string(here.join("lab.gltf")).unwrap();
        let mut document: Value = serde_json::from_str(&text).unwrap();
        edit(&mut document);
        fs::write(here.join("edited.gltf"), document.to_string()).unwrap();
        let mut arguments = vec!["render", "edited.gltf", "-o", "single.exr", "--spp", "2"];
        arguments.extend(["--width", "8", "--height", "8", "--integrator", "path"]);
        sunstone(&here, &[&arguments[..], &["--threads", "1"]].concat()).done();
        let [own, other] =
            [here.join("out").join(name), here.join("single.exr")].map(|it| planes(&it));
        assert!(own == other, "{name}");
    };
    let extension = |document: &mut Value, material: usize, key: &str, value: Value| {
        document["materials"][material]["extensions"]["SUNSTONE_polarization"][key] = value;
    };
    for (angle, angle_name) in [(0, "000.0"), (45, "045.0")] {
        for ior in [1.33, 1.7] {
            for yfov in [0.5, 0.75] {
                edited(&format!("sweep-{angle_name}-{ior}-{yfov}.exr"), &|document| {
                    extension(document, 12, "axis_deg", json!(angle));
                    extension(document, 5, "ior", json!(ior));
                    document["cameras"][0]["perspective"]["yfov"] = json!(yfov);
                });
            }
        }
    }
    for (index, x) in [(8, -0.5), (9, -0.4)] {
        edited(&format!("job8 {index:04}.exr"), &|document| {
            document["nodes"][12]["matrix"][12] = json!(x);
        });
    }
    let records = records(&here);
    assert_eq!(records.len(), 10);
    for record in &records {
        let output = here.join(record["output"].as_str().unwrap());
        if let Some(sum) = sha256sum(&output) {
            assert_eq!(record["checksum"], json!(sum));
        }
        assert!(record["error"].is_null() && record["seconds"].as_f64().unwrap() > 0.0, "{record}");
    }
    let of = |index: usize| records.iter().find(|it| it["index"] == json!(index)).unwrap();
    assert_eq!(of(5)["values"], json!({"angle": 45, "ior": 1.33, "yfov": 0.75}));
    assert_eq!((&of(9)["name"], &of(9)["values"]), (&json!("job8"), &json!({"x": -0.4})));
}

#[test]
fn media_and_lights_are_edited_too() {
    let jobs = "
[[jobs]]
name = \"milk\"
scene = \"tank.gltf\"
output = \"{name}-{dilution}-{power}.exr\"
sweep = [
    { name = \"dilution\", key = \"media/#0/milk.dilution\", values = [0.001, 0.5] },
    { name = \"power\", key = \"lights/#0/intensity\", values = [100, 200] },
]";
    let here = lab("media", jobs);
    fs::copy(scene("tank"), here.join("tank.gltf")).unwrap();
    batch(&here, &[]).done();
    let image = |name: &str| planes(&here.join(name));
    let [thin, thick, bright] =
        ["milk-0.001-100.exr", "milk-0.5-100.exr", "milk-0.5-200.exr"].map(image);
    assert!(thin != thick);
    let sum = |image: &[Vec<f32>]| f64::from(image[0].iter().sum::<f32>());
    assert!((sum(&bright) / sum(&thick) - 2.0).abs() < 1e-3);
}

/// As `render` says it, by the integrator that renders.
#[test]
fn what_images_lack_is_told_by_job() {
    let jobs = "[[jobs]]\noutput = \"a.exr\"\nintegrator = \"light\"";
    let here = lab("lacks", jobs);
    let single = ["render", "lab.gltf", "-o", "b.exr", "--integrator", "light", "--spp", "2"];
    let single =
        sunstone(&here, &[&single[..], &["--width", "8", "--height", "8"]].concat()).done();
    let lacks: Vec<&str> =
        single.stderr.lines().filter_map(|line| line.strip_prefix("warning: ")).collect();
    let told = batch(&here, &["-q"]).done().stderr;
    assert!(!lacks.is_empty(), "{}", single.stderr);
    for lack in lacks {
        assert!(told.contains(&format!("warning: job 0 \"job0\": {lack}")), "{told}");
    }
}

#[test]
fn the_same_seed_in_all_jobs_or_each_its_own() {
    let jobs = "
[[jobs]]
name = \"same\"
output = \"{name}{seed}-{index}.exr\"
sweep = [{ name = \"twice\", key = \"variance\", values = [true, false] }]
[[jobs]]
name = \"own\"
seed = \"job\"
output = \"{name}{seed}.exr\"
sweep = [{ name = \"ior\", key = \"materials/glass/ior\", values = [1.5, 1.5] }]";
    let here = lab("seeds", jobs);
    batch(&here, &[]).done();
    let images = ["own2.exr", "own3.exr", "same0-0.exr", "same0-1.exr"];
    let names = names_in(&here);
    assert!(images.iter().all(|name| names.iter().any(|it| it == name)), "{names:?}");
    let [own2, own3, same0, same1] = images.map(|name| planes(&here.join(name)));
    assert!(same0 == same1 && own2 != own3 && own2 != same0);
    assert!(image::load(&here.join("same0-0.exr")).unwrap().variance.is_some());
}

/// What of the outputs has been written again, by their times of change.
fn times(here: &Path) -> BTreeMap<String, std::time::SystemTime> {
    let out = here.join("out");
    let time = |name: String| {
        let time = fs::metadata(out.join(&name)).unwrap().modified().unwrap();
        (name, time)
    };
    names_in(&out).into_iter().map(time).collect()
}

#[test]
fn what_is_done_is_skipped_until_anything_changes() {
    let jobs = |ior: &str| {
        format!(
            "[[jobs]]\nname = \"a\"\noutput = \"out/{{name}}{{ior}}.exr\"\nsweep = [{{ name = \
             \"ior\", key = \"materials/glass/ior\", values = [1.3, 1.4, 1.5, {ior}] }}]"
        )
    };
    let here = lab("skipped", &jobs("1.6"));
    batch(&here, &[]).done();
    let first = times(&here);
    let changed = |words: &str, expected: &[&str]| {
        let before = times(&here);
        let run = batch(&here, &[]).done();
        assert!(run.stderr.contains(words), "{}", run.stderr);
        let after = times(&here);
        let is_new = |name: &&String| before.get(*name) != after.get(*name);
        let new: Vec<&str> = after.keys().filter(is_new).map(String::as_str).collect();
        assert_eq!(new, expected);
        let records = records(&here);
        assert_eq!(records.len(), 4, "{records:?}");
    };
    changed("0 images in", &[]);
    assert_eq!(times(&here), first);
    // An image that is gone, and one that is damaged.
    fs::remove_file(here.join("out/a1.3.exr")).unwrap();
    let mut damaged = fs::read(here.join("out/a1.5.exr")).unwrap();
    let last = damaged.len() - 1;
    damaged[last] ^= 1;
    fs::write(here.join("out/a1.5.exr"), damaged).unwrap();
    changed("2 images in", &["a1.3.exr", "a1.5.exr"]);
    // Another value in the sweep: the last one is forgotten, and its image left alone.
    write(&here, &jobs("1.7"));
    changed("3 were done before", &["a1.7.exr"]);
    // The scene in other words.
    let text = fs::read_to_string(here.join("lab.gltf")).unwrap();
    fs::write(here.join("lab.gltf"), format!("{text}\n")).unwrap();
    changed("4 images in", &["a1.3.exr", "a1.4.exr", "a1.5.exr", "a1.7.exr"]);
    // A line that was cut off as the machine stopped, and one that is none.
    let results = here.join("results.jsonl");
    let text = fs::read_to_string(&results).unwrap();
    fs::write(&results, format!("no line\n{}", &text[..text.len() - 9])).unwrap();
    let cut = output_of_the_last(&text);
    changed("1 image in", &[&cut]);
}

/// The file name of the output of the last record.
fn output_of_the_last(text: &str) -> String {
    let record: Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
    record["output"].as_str().unwrap().trim_start_matches("out/").to_owned()
}

#[test]
fn twenty_jobs_are_done_although_ten_fail() {
    let here = lab("failing", "");
    let text = fs::read_to_string(here.join("lab.gltf")).unwrap();
    let mut document: Value = serde_json::from_str(&text).unwrap();
    document["buffers"][0]["uri"] = json!("gone.bin");
    fs::write(here.join("bufferless.gltf"), document.to_string()).unwrap();
    fs::write(here.join("damaged.gltf"), &text[..text.len() / 2]).unwrap();
    fs::create_dir(here.join("taken")).unwrap();
    let mut lines = Vec::new();
    for number in 0..20 {
        let set = json!({"materials/glass/ior": 1.1 + 0.05 * f64::from(number)});
        lines.push(json!({"name": format!("good {number}"), "set": set}));
    }
    let failing = [
        (json!({"set": {"materials/glass/ior": -1.0}}), "ior"),
        (json!({"set": {"materials/glass/ior": "x"}}), "no substance"),
        (json!({"set": {"materials/white/reflectance": [0.5, 2.0, 0.5]}}), "reflectance"),
        (json!({"set": {"materials/gold/metal": "Xx"}}), "Xx"),
        (json!({"set": {"nodes/pool/matrix": vec![1; 16]}}), "\"pool\""),
        (json!({"set": {"cameras/camera/perspective.yfov": 7.0}}), "yfov"),
        (json!({"scene": "bufferless.gltf"}), "gone.bin"),
        (json!({"scene": "damaged.gltf"}), "is not glTF"),
        (
            json!({"scene": "nowhere.gltf", "set": {"materials/x/ior": 1}}),
            "nowhere.gltf: cannot read it: ",
        ),
        (json!({"width": 65535, "height": 32000}), "of memory"),
    ];
    for (number, (job, _)) in failing.iter().enumerate() {
        let mut job = job.clone();
        job["name"] = json!(format!("bad {number}"));
        lines.insert(2 * number, job);
    }
    let complete = |mut line: Value| {
        let own =
            json!({"scene": "lab.gltf", "width": 8, "height": 8, "spp": 2, "integrator": "path"});
        for (key, value) in own.as_object().unwrap() {
            let line = line.as_object_mut().unwrap();
            line.entry(key).or_insert(value.clone());
        }
        line["output"] = json!("out/{name}.exr");
        line.to_string() + "\n"
    };
    let text: String = lines.into_iter().map(complete).collect();
    fs::write(here.join("jobs.jsonl"), text).unwrap();
    let run = sunstone(&here, &["batch", "jobs.jsonl", "--threads", "2"]);
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(run.stderr.contains("error: jobs.jsonl: 10 jobs failed"), "{}", run.stderr);
    assert_eq!(names_in(&here.join("out")).len(), 20);
    let records = records(&here);
    assert_eq!(records.len(), 30);
    for (number, (_, words)) in failing.iter().enumerate() {
        let name = format!("bad {number}");
        let record = records.iter().find(|record| record["name"] == json!(name)).unwrap();
        let error = record["error"].as_str().unwrap_or("none");
        assert!(error.contains(words), "{name}: {error}");
        let line = format!("error: job {} \"{name}\": ", 2 * number);
        assert!(run.stderr.contains(&line), "{line} in {}", run.stderr);
    }
    // They are tried again, and the others are not.
    let again = sunstone(&here, &["batch", "jobs.jsonl"]);
    assert_eq!(again.code, 1);
    assert!(again.stderr.contains("0 images in") && again.stderr.contains("20 were done before"));
    assert_eq!(self::records(&here).len(), 30);
}

/// What is wrong in many ways.
const WRONG: &str = r#"
[[jobs]]
name = "keys"
output = "out/{name}{nothing}.exr"
sweep = [{ name = "index", key = "spp", values = 3 }]
[[jobs]]
name = "names"
output = "out/{name}.exr"
set = { "materials/snow/ior" = 1.0, "materials/glass/colour" = 1.0, "shapes/a/b" = 1 }
spq = 3
[[jobs]]
name = "options"
output = "out/{name}.exr"
spp = -3
width = 0
iterations = 3
threads = 3
[[jobs]]
name = "one"
output = "out/same.exr"
[[jobs]]
name = "two"
output = "./out/../out/same.exr"
[[jobs]]
name = "swept"
output = "out/{name}.exr"
sweep = [{ name = "ior", key = "materials/glass/ior", values = [1, 2, 3] }]
[[jobs]]
name = "outside"
output = "../{name}.exr"
[[jobs]]
name = "format"
output = "{name}.jpg"
[[jobs]]
name = "scene"
output = "lab.gltf.exr/{name}.exr"
[[jobs]]
name = "itself"
output = "results.jsonl"
[farm]
tasks = 0
"#;

/// A batch that is refused in these words, before anything is made.
fn refused(here: &Path, words: &[&str]) {
    let run = batch(here, &[]);
    assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{}", run.stderr);
    assert!(run.stderr.ends_with("nothing has been rendered\n"), "{}", run.stderr);
    for words in words {
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
    }
}

#[test]
fn what_the_file_shows_stops_all_of_it_and_is_told_at_once() {
    let here = lab("wrong", WRONG);
    fs::write(here.join("lab.gltf.exr"), "in the way").unwrap();
    refused(
        &here,
        &[
            "job 0 \"keys\", output: {nothing} is not known; there are {name}, {index}, {seed}",
            "job 0 \"keys\", sweep, axis \"index\": `values` is not a list",
            "farm: `tasks` must be a whole number from 1 to 1000000",
            "job 1 \"names\", spq: is not an option; options are alpha,",
            "job 1 \"names\", materials/snow/ior: no material is called `snow`; the materials are",
            "job 1 \"names\", materials/glass/colour: a material has no key `colour`; keys are",
            "job 1 \"names\", shapes/a/b: `shapes` is no kind of object",
            "job 2 \"options\", spp: invalid value '-3'",
            "job 2 \"options\", threads: cannot be set for a job",
            "job 4 \"two\", output ./out/../out/same.exr is that of job 3 \"one\" too",
            "job 6 \"swept\" and 1 more of its sweep, output out/swept.exr is that of job 5 \
             \"swept\" (ior 1) too; write {ior}",
            "job 8 \"outside\", output ../outside.exr is outside of the folder of the job file",
            "job 9 \"format\", ",
            "job 10 \"scene\", output lab.gltf.exr/scene.exr: cannot write",
            "job 11 \"itself\", ",
        ],
    );
    let left = ["jobs.toml", "lab.gltf", "lab.gltf.exr"];
    assert_eq!(names_in(&here), left, "nothing is made");
}

#[test]
fn what_is_no_job_file_is_refused() {
    let here = lab("no-file", "");
    for (text, words) in [
        ("", "has no version"),
        ("version = 2", "version 2 is not known"),
        ("version = 1", "has no jobs"),
        ("version = 1\n[job]", "`job` is not a key of a job file"),
        ("version = 1\n[[jobs]]\nname", "TOML parse error at line 3"),
        ("version = 1\n[[jobs]]\nset = 3", "job 0, `set` is not a table of edits"),
        ("version = 1\n[[jobs]]\noutput = \"a.exr\"", "job 0 has no `scene`"),
        ("version = 1\n[[jobs]]\nx = 2020-01-01", "the date 2020-01-01"),
        ("version = 1\n[[jobs]]\nx = nan", "the number NaN"),
        ("version = 1\n[defaults]\nname = \"a\"", "defaults: `name` belongs to a job"),
    ] {
        fs::write(here.join("jobs.toml"), text).unwrap();
        refused(&here, &[words, "jobs.toml: "]);
    }
    assert_eq!(sunstone(&here, &["batch", "gone.toml"]).code, 2);
    assert_eq!(sunstone(&here, &["batch", "lab.gltf"]).code, 2);
}

/// Gold by name, and the same by indices of its own.
const SWAPPED: &str = r#"
[[jobs]]
name = "own"
output = "out/{name}.exr"
unset = ["materials/gold/metal"]
set = { "materials/gold/eta" = [0.2, 0.4, 1.3], "materials/gold/k" = [3.9, 2.5, 1.9] }

[[jobs]]
name = "turned"
output = "out/{name}.exr"
unset = ["nodes/glass ball/matrix"]
[jobs.set]
"nodes/glass ball/translation" = [0.3, 0.3, 0.2]
"nodes/glass ball/scale" = [0.2, 0.2, 0.2]
"#;

#[test]
fn what_is_taken_away_makes_room_for_what_excludes_it() {
    let here = lab("unset", SWAPPED);
    batch(&here, &[]).done();
    let names = ["own", "turned"].map(|name| planes(&here.join(format!("out/{name}.exr"))));
    assert_ne!(names[0], names[1]);
    // A line of JSON may say null.
    let line = json!({
        "scene": "lab.gltf", "integrator": "path", "spp": 2, "width": 8, "height": 8,
        "output": "null.exr", "set": {
            "materials/gold/metal": null,
            "materials/gold/eta": [0.2, 0.4, 1.3], "materials/gold/k": [3.9, 2.5, 1.9],
        },
    });
    fs::write(here.join("jobs.jsonl"), line.to_string()).unwrap();
    sunstone(&here, &["batch", "jobs.jsonl", "--results", "null.jsonl"]).done();
    assert_eq!(planes(&here.join("null.exr")), names[0]);
}

#[test]
fn edits_that_do_not_go_together_stop_all() {
    let job = |text: &str| format!("[[jobs]]\noutput = \"{{index}}.exr\"\n{text}\n");
    let jobs = [
        "unset = \"materials/gold/metal\"",
        "unset = [\"materials/gold/metal\"]\nset = { \"materials/gold/metal\" = \"Cu\" }",
        "unset = [\"materials/snow/metal\"]",
        "unset = [\"nodes/glass ball/matrix.0\"]",
        "set = { \"nodes/glass ball/scale\" = [1, 1, 1] }",
        "set = { \"cameras/camera/film.resolution\" = [8, 8] }",
    ];
    let here = lab("together", &jobs.map(job).concat());
    refused(
        &here,
        &[
            "job 0, `unset` is not a list of KIND/NAME/KEY",
            "job 1, `materials/gold/metal` is stated twice",
            "job 2, materials/snow/metal: no material is called `snow`",
            "job 3, nodes/glass ball/matrix.0 is an item of a list",
            "job 4, nodes/glass ball/scale: the node has a `matrix`",
            "job 5, cameras/camera/film.resolution: means nothing where `width` and `height`",
        ],
    );
    fs::write(
        here.join("jobs.jsonl"),
        "{\"spp\": 1, \"spp\": 2}\n{\"set\": {\"a/b/c\": 1, \"a/b/c\": 1}}",
    )
    .unwrap();
    let run = sunstone(&here, &["batch", "jobs.jsonl"]);
    assert_eq!(run.code, 2);
    for words in ["line 1: `spp` is stated twice\n", "line 2: `a/b/c` is stated twice\n"] {
        assert!(run.stderr.contains(words), "{}", run.stderr);
    }
}

#[test]
fn a_dry_run_lists_the_jobs_and_makes_nothing() {
    let here = lab("dry", &SWEEP.replace("set = { \"media/fog/g\" = 0 }\n", ""));
    let run = batch(&here, &["--dry-run"]).done();
    assert!(run.stderr.is_empty(), "{}", run.stderr);
    let line =
        "    1  to do  out/sweep-000.0-1.33-0.75.exr  \"sweep\" (angle 0, ior 1.33, yfov 0.75)";
    assert!(run.stdout.lines().any(|it| it == line), "{}", run.stdout);
    assert!(run.stdout.ends_with("10 jobs, 10 to do\n"), "{}", run.stdout);
    assert_eq!(names_in(&here), ["jobs.toml", "lab.gltf"]);
    batch(&here, &["-q"]).done();
    let run = batch(&here, &["--dry-run"]).done();
    assert!(run.stdout.ends_with("10 jobs, 0 to do\n"), "{}", run.stdout);
}

/// A batch in work.
fn start(here: &Path) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sunstone"));
    command.args(["batch", "jobs.toml", "--threads", "2"]).current_dir(here);
    command.stderr(Stdio::piped()).spawn().unwrap()
}

/// Waits until so many jobs have come to an end.
fn wait_for(here: &Path, count: usize) {
    let start = Instant::now();
    let lines =
        || fs::read_to_string(here.join("results.jsonl")).unwrap_or_default().lines().count();
    while lines() < count {
        assert!(start.elapsed() < PATIENCE, "nothing happens");
        std::thread::sleep(Duration::from_millis(5));
    }
}

const MANY: &str = "
[[jobs]]
name = \"many\"
output = \"out/{index:03}.exr\"
sweep = [{ name = \"ior\", key = \"materials/glass/ior\", from = 1.1, to = 2.0, count = 60 }]";

#[test]
#[cfg(unix)]
fn a_batch_that_is_killed_loses_what_was_in_work() {
    let here = lab("killed", MANY);
    for lines in [3, 20] {
        let mut child = start(&here);
        wait_for(&here, lines);
        child.kill().unwrap();
        child.wait().unwrap();
        for name in names_in(&here.join("out")).iter().filter(|name| name.ends_with(".exr")) {
            planes(&here.join("out").join(name));
        }
    }
    let run = batch(&here, &[]).done();
    let before = run.stderr.split("images in").nth(1).unwrap_or_default();
    assert!(before.contains("were done before"), "{}", run.stderr);
    let names = names_in(&here.join("out"));
    assert_eq!(names.len(), 60, "{names:?}");
    assert_eq!(names_in(&here), ["jobs.toml", "lab.gltf", "out", "results.jsonl"]);
    assert_eq!(records(&here).len(), 60);
    // As if nothing had happened.
    let whole = lab("whole", MANY);
    batch(&whole, &["--threads", "1"]).done();
    for name in names {
        let [own, other] = [&here, &whole].map(|it| planes(&it.join("out").join(&name)));
        assert!(own == other, "{name}");
    }
}

#[test]
#[cfg(unix)]
fn a_signal_ends_a_batch_with_what_is_done() {
    let here = lab("signal", &MANY.replace("60", "2000"));
    let child = start(&here);
    wait_for(&here, 5);
    let pid = child.id().to_string();
    assert!(Command::new("kill").args(["-s", "INT", &pid]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(130), "{stderr}");
    assert!(stderr.contains("SIGINT: ") && stderr.contains("start the batch again"), "{stderr}");
    let records = records(&here);
    assert_eq!(names_in(&here.join("out")).len(), records.len());
    assert!(records.len() < 2000 && records.iter().all(|record| record["error"].is_null()));
}

#[test]
#[cfg(unix)]
fn results_are_written_by_one_and_where_they_can_be() {
    let here = lab("results", &MANY.replace("60", "400"));
    let mut child = start(&here);
    wait_for(&here, 1);
    let second = batch(&here, &[]);
    assert_eq!(second.code, 2);
    assert!(second.stderr.contains("another batch is at work"), "{}", second.stderr);
    child.kill().unwrap();
    child.wait().unwrap();
    write(&here, &MANY.replace("60", "2"));
    let elsewhere = batch(&here, &["--results", "gone/results.jsonl"]);
    assert_eq!(elsewhere.code, 2);
    assert!(elsewhere.stderr.contains("cannot write gone/results.jsonl"), "{}", elsewhere.stderr);
    batch(&here, &["--results", "more.jsonl"]).done();
    assert_eq!(fs::read_to_string(here.join("more.jsonl")).unwrap().lines().count(), 2);
    // Another job file in the same folder keeps what this one has noted.
    batch(&here, &[]).done();
    fs::copy(here.join("jobs.toml"), here.join("others.toml")).unwrap();
    let text = fs::read_to_string(here.join("others.toml")).unwrap().replace("out/", "more/");
    fs::write(here.join("others.toml"), text).unwrap();
    sunstone(&here, &["batch", "others.toml"]).done();
    assert_eq!(records(&here).len(), 4);
    assert!(batch(&here, &[]).done().stderr.contains("2 were done before"));
}
