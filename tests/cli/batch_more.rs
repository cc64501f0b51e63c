//! Batches among other things: job files in one folder, damaged results, parts that tasks have
//! left, images of former runs, and what is wrong with options.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use sunstone::internals::image;

use crate::program::{Run, folder, names_in, scene, sunstone};

const DEFAULTS: &str = "version = 1\n[defaults]\nscene = \"lab.gltf\"\nintegrator = \"path\"\n\
                        spp = 4\nwidth = 8\nheight = 8\n";
const SWEEP: &str = "[[jobs]]\nname = \"swept\"\noutput = \"out/{zeta}.exr\"\nsweep = [{ name = \
                     \"zeta\", key = \"materials/glass/ior\", values = [1.7, 1.4] }]\n";

/// A folder with a scene and a job file.
fn lab(name: &str, jobs: &str) -> PathBuf {
    let here = folder(&format!("batch-more-{name}"));
    fs::copy(scene("cornell"), here.join("lab.gltf")).unwrap();
    write(&here, "jobs.toml", jobs);
    here
}

fn write(here: &Path, name: &str, jobs: &str) {
    fs::write(here.join(name), format!("{DEFAULTS}{jobs}")).unwrap();
}

fn batch(here: &Path, arguments: &[&str]) -> Run {
    sunstone(here, &[&["batch"][..], arguments, &["--threads", "2"]].concat())
}

/// Refused in these words, before anything is rendered.
#[track_caller]
fn refused(run: &Run, words: &[&str]) {
    assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{}", run.stderr);
    assert!(run.stderr.ends_with("nothing has been rendered\n"), "{}", run.stderr);
    for words in words {
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
    }
}

fn records(here: &Path) -> Vec<Value> {
    let text = fs::read_to_string(here.join("results.jsonl")).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn two_job_files_do_not_make_two_images_of_one_output() {
    let here = lab("two", SWEEP);
    batch(&here, &["jobs.toml"]).done();
    let image = fs::read(here.join("out/1.7.exr")).unwrap();
    // A copy asks for the same images, and they are there.
    fs::copy(here.join("jobs.toml"), here.join("copy.toml")).unwrap();
    let run = batch(&here, &["copy.toml"]).done();
    assert!(run.stderr.contains("copy.toml: 0 images in "), "{}", run.stderr);
    assert!(run.stderr.contains("2 were done before"), "{}", run.stderr);
    // For others it has to go elsewhere.
    write(&here, "copy.toml", &SWEEP.replace("1.4", "1.7").replace("1.7, 1.7", "1.4, 1.7"));
    batch(&here, &["copy.toml"]).done();
    let finer = SWEEP.replace("name = \"swept\"", "name = \"finer\"\nspp = 5");
    write(&here, "copy.toml", &finer);
    let words = [
        "copy.toml: job 0 \"finer\" and 1 more of its sweep, output out/1.7.exr is that of job 0 \
         \"swept\" in jobs.toml too, which makes another image of it",
        "remove or rename jobs.toml if it is not needed any more",
    ];
    for arguments in [&["copy.toml"][..], &["copy.toml", "--dry-run"], &["copy.toml", "--merge"]] {
        refused(&batch(&here, arguments), &words);
    }
    assert!(fs::read(here.join("out/1.7.exr")).unwrap() == image);
    // Somebody may just be writing it.
    write(&here, "jobs.toml", "[[[");
    let words = "out/1.4.exr was made for jobs.toml, which cannot be read now: mend that";
    refused(&batch(&here, &["copy.toml"]), &[words]);
    assert!(fs::read(here.join("out/1.7.exr")).unwrap() == image);
    // One that does not ask for the output any more has nothing against it.
    write(&here, "jobs.toml", &SWEEP.replace("out/", "elsewhere/"));
    batch(&here, &["copy.toml"]).done();
    assert!(fs::read(here.join("out/1.7.exr")).unwrap() != image);
}

#[test]
fn a_job_file_takes_its_results_along_when_it_is_renamed() {
    let here = lab("renamed", SWEEP);
    write(&here, "other.toml", &SWEEP.replace("out/", "other/"));
    batch(&here, &["jobs.toml"]).done();
    batch(&here, &["other.toml"]).done();
    fs::rename(here.join("jobs.toml"), here.join("malus.toml")).unwrap();
    let run = batch(&here, &["malus.toml"]).done();
    assert!(run.stderr.contains("malus.toml: 0 images in "), "{}", run.stderr);
    // Renamed and changed, it makes its images anew.
    fs::rename(here.join("malus.toml"), here.join("more.toml")).unwrap();
    write(&here, "more.toml", &SWEEP.replace("out/", "./out/").replace("1.4", "1.5"));
    batch(&here, &["more.toml"]).done();
    write(&here, "more.toml", &SWEEP.replace("name = \"swept\"", "spp = 5"));
    batch(&here, &["more.toml"]).done();
    let files: Vec<Value> = records(&here).iter().map(|it| it["jobs"].clone()).collect();
    assert_eq!(files, ["other.toml", "other.toml", "more.toml", "more.toml"]);
}

#[test]
fn lines_that_cannot_be_read_are_counted() {
    let here = lab("damaged", SWEEP);
    for task in ["1/2", "2/2"] {
        batch(&here, &["jobs.toml", "--task", task]).done();
    }
    let of_task = here.join("results.jsonl.tasks/jobs.toml.2-of-2.jsonl");
    let text = fs::read_to_string(&of_task).unwrap();
    fs::write(&of_task, format!("{{}}\n\nnonsense\n{}", &text[..text.len() - 20])).unwrap();
    let words = "jobs.toml.2-of-2.jsonl: 3 lines cannot be read; what only they tell of";
    let merge = batch(&here, &["jobs.toml", "--merge"]);
    assert_eq!(merge.code, 1, "{}", merge.stderr);
    assert_eq!(merge.stderr.matches(words).count(), 1, "{}", merge.stderr);
    let missing = "out/1.4.exr, is there, but no task has noted that it made it";
    assert!(merge.stderr.contains(missing), "{}", merge.stderr);
    // What is cut off may be in the writing as long as tasks are at work.
    let words = words.replace('3', "2");
    for arguments in [&["jobs.toml", "--dry-run"][..], &["jobs.toml", "--task", "1/1"]] {
        let run = batch(&here, arguments).done();
        assert!(run.stderr.contains(&words), "{}", run.stderr);
    }
    let results = here.join("results.jsonl");
    let good = fs::read_to_string(&results).unwrap();
    fs::write(&results, format!("nonsense\n{good}")).unwrap();
    let words = "warning: results.jsonl: 1 line cannot be read";
    let run = batch(&here, &["jobs.toml", "-q"]).done();
    assert!(run.stderr.contains(words), "{}", run.stderr);
    assert_eq!(records(&here).len(), 2);
    assert_eq!(batch(&here, &["jobs.toml", "-q"]).done().stderr, "");
    // The last line need not end as one.
    let good = fs::read_to_string(&results).unwrap();
    fs::write(&results, good.trim_end()).unwrap();
    assert_eq!(batch(&here, &["jobs.toml", "-q"]).done().stderr, "");
    assert_eq!(fs::read_to_string(&results).unwrap(), good);
}

#[test]
fn a_plain_batch_takes_parts_that_are_all_there() {
    let here = lab("parts", SWEEP);
    let parts = ["jobs.toml", "--parts", "2", "--task"];
    for task in ["1/4", "2/4", "3/4"] {
        batch(&here, &[&parts[..], &[task]].concat()).done();
    }
    fs::write(here.join("out/1.4.exr.7-of-7.part"), "of somebody else").unwrap();
    let left = ["1.4.exr.1-of-2.part", "1.4.exr.7-of-7.part", "1.7.exr.1-of-2.part"];
    assert_eq!(names_in(&here.join("out"))[..3], left);
    let run = batch(&here, &["jobs.toml"]).done();
    for words in [
        "note: tasks have rendered 1 part of 1 image and not all of any",
        "note: beside the images are left: out/1.4.exr.7-of-7.part; no task has noted",
        "jobs.toml: 2 images in ",
    ] {
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
    }
    let names = names_in(&here.join("out"));
    assert_eq!(names, ["1.4.exr", "1.4.exr.7-of-7.part", "1.7.exr"]);
    assert_eq!(names_in(&here), ["jobs.toml", "lab.gltf", "out", "results.jsonl"]);
    let metadata = |name: &str| image::load(&here.join("out").join(name)).unwrap().metadata;
    let of_parts = |name: &str| metadata(name).iter().any(|(key, _)| key == "parts");
    assert!(of_parts("1.7.exr") && !of_parts("1.4.exr"));
    // To the bits of one that had no tasks.
    let plain = lab("no-parts", SWEEP);
    batch(&plain, &["jobs.toml"]).done();
    for name in ["1.4.exr", "1.7.exr"] {
        let [one, other] =
            [&here, &plain].map(|it| image::load(&it.join("out").join(name)).unwrap().planes);
        assert!(one == other, "{name}");
    }
    let run = batch(&here, &["jobs.toml", "-q"]).done();
    assert_eq!(run.stderr, "");
}

#[test]
fn an_image_of_a_former_run_is_told_from_that_of_a_job_that_failed() {
    let here = lab("former", SWEEP);
    batch(&here, &["jobs.toml"]).done();
    write(&here, "jobs.toml", &SWEEP.replace("ior\",", "ior\", step_with = \"x\",").replace(
        "sweep = [",
        "sweep = [{ name = \"x\", key = \"nodes/glass ball/translation.0\", values = [0, \"y\"] \
         }, ",
    ));
    let run = batch(&here, &["jobs.toml"]);
    assert_eq!(run.code, 1, "{}", run.stderr);
    let words = "warning: job 1 \"swept\" (x \"y\", zeta 1.4): out/1.4.exr is of a former run";
    assert_eq!(run.stderr.matches("former run").count(), 1, "{}", run.stderr);
    assert!(run.stderr.contains(words), "{}", run.stderr);
    assert!(here.join("out/1.4.exr").exists());
    let run = sunstone(&here, &["report", ".", "-o", "report.html"]).done();
    let words = "2 jobs, 1 failed, 1 of these with an image of a former run;";
    assert!(run.stderr.contains(words), "{}", run.stderr);
    let page = fs::read_to_string(here.join("report.html")).unwrap();
    assert!(page.contains("\"former\":true") && page.contains("\"link\":\"out/1.4.exr\""));
    // Axes stand in the order of the sweep.
    assert!(page.contains("\"values\":{\"x\":0,\"zeta\":1.7}"));
    let text = fs::read_to_string(here.join("results.jsonl")).unwrap();
    assert!(text.contains("\"values\":{\"x\":\"y\",\"zeta\":1.4}"), "{text}");
    fs::remove_file(here.join("out/1.4.exr")).unwrap();
    let run = batch(&here, &["jobs.toml"]);
    assert!(run.code == 1 && !run.stderr.contains("former run"), "{}", run.stderr);
}

#[test]
fn values_of_a_wrong_kind_are_told_at_once_by_job_and_key() {
    let jobs = r#"
replicates = "few"
[[jobs]]
name = "one"
output = "{name}.exr"
spp = "many"
width = -1
[[jobs]]
name = "swept"
output = "{name}{a}{seed}.exr"
variance = "yes"
sweep = [
    { name = "a", key = "spp", values = [1, "two", 3.5] },
    { name = "seed", key = "seed", values = [1, -1] },
]
[[jobs]]
color = 3
[[jobs]]
name = "broken"
height = true
output = "{c}.exr"
sweep = [
    { name = "c", key = "max_path_length", values = [[1]] },
    { name = "d", values = [3] },
]
[[jobs]]
name = "last"
output = "{name}.exr"
scene = ["a"]
camera = { a = 1 }
"#;
    let here = lab("kinds", jobs);
    let words = [
        "defaults, replicates: invalid value 'few'",
        "job 0 \"one\", spp: invalid value 'many'",
        "job 0 \"one\", width: invalid value '-1'",
        "job 1 \"swept\" and 5 more of its sweep, variance: is true or false",
        "job 3 \"swept\" and 1 more of its sweep, spp: invalid value 'two'",
        "job 5 \"swept\" and 1 more of its sweep, spp: invalid value '3.5'",
        "job 2 \"swept\" and 2 more of its sweep, seed: invalid value '-1'",
        "job 7, color: invalid value '3'",
        "job 7 has no `output`",
        "job 8 \"broken\", height: takes one number or word",
        "job 8 \"broken\", max_path_length: takes one number or word",
        "job 8 \"broken\", sweep, axis \"d\": has no `key`",
        "job 9 \"last\", scene: is not the path",
        "job 9 \"last\", camera: takes one number or word",
        "jobs.toml: 14 things are wrong",
    ];
    refused(&batch(&here, &["jobs.toml"]), &words);
    // Lines are counted as editors do.
    let line = json!({"name": "a", "scene": "lab.gltf", "output": "a.exr", "spp": "many"});
    fs::write(here.join("jobs.jsonl"), format!("\n{line}\n")).unwrap();
    let words = ["jobs.jsonl: line 2, job 0 \"a\", spp: invalid value 'many'"];
    refused(&batch(&here, &["jobs.jsonl"]), &words);
    assert_eq!(names_in(&here), ["jobs.jsonl", "jobs.toml", "lab.gltf"]);
}

#[test]
fn names_that_no_file_can_have_are_told_at_once() {
    let long = "x".repeat(300);
    for (name, [output, other], words) in [
        ("long", [&*format!("new/{long}.exr"), "b.exr"], "invalid filename"),
        ("zero", ["a\\u0000.exr", "b.exr"], "NUL byte"),
        ("within", ["s.exr", "s.exr/b.exr"], "would be in a folder s.exr, which is the image of"),
    ] {
        let job = |output: &str| format!("[[jobs]]\noutput = \"{output}\"\n");
        let here = lab(name, &format!("{}{}", job(output), job(other)));
        refused(&batch(&here, &["jobs.toml"]), &[words]);
        refused(&batch(&here, &["jobs.toml", "--dry-run"]), &[words]);
    }
}

#[test]
fn tables_that_are_swept_have_their_numbers_in_names() {
    let sweep = SWEEP.replace("{zeta}", "{zeta:02}").replace("glass/ior", "red/reflectance");
    let sweep = sweep.replace(
        "[1.7, 1.4]",
        "[{ nm = [400, 700], value = [0.1, 0.8] }, { nm = [400, 700], value = [0.8, 0.1] }]",
    );
    let here = lab("tables", &sweep);
    let run = batch(&here, &["jobs.toml"]).done();
    assert_eq!(names_in(&here.join("out")), ["00.exr", "01.exr"], "{}", run.stderr);
    // Results have the values themselves.
    let records = records(&here);
    let second = records.iter().find(|record| record["index"] == 1).unwrap();
    assert_eq!(second["values"]["zeta"]["value"], json!([0.8, 0.1]));
}

#[test]
fn jobs_say_otherwise_than_the_defaults() {
    let jobs = "color = \"mono\"\nwavelength = 633\n[[jobs]]\nname = \"a\"\noutput = \"{name}{n}\
                {c}.exr\"\nsweep = [{ name = \"n\", key = \"iterations\", values = [1, 2] }, { \
                name = \"c\", key = \"color\", values = [\"rgb\", \"mono\"] }]\n";
    let here = lab("rivals", jobs);
    batch(&here, &["jobs.toml"]).done();
    for (name, samples, channels) in [
        ("a1rgb.exr", "1", 3),
        ("a2rgb.exr", "2", 3),
        ("a1mono.exr", "1", 1),
        ("a2mono.exr", "2", 1),
    ] {
        let image = image::load(&here.join(name)).unwrap();
        assert_eq!(image.color.channels(), channels, "{name}");
        let found = image.metadata.iter().any(|(key, it)| key == "iterations" && it == samples);
        assert!(found, "{name}: {:?}", image.metadata);
    }
}

#[test]
fn results_go_over_nothing_else() {
    let here = lab("over", SWEEP);
    fs::write(here.join("notes.txt"), "mine\n").unwrap();
    fs::create_dir(here.join("folder")).unwrap();
    let before: Vec<Vec<u8>> =
        ["lab.gltf", "jobs.toml"].map(|name| fs::read(here.join(name)).unwrap()).into();
    for (results, words) in [
        ("lab.gltf", "results would go over lab.gltf, which the batch needs; name another"),
        ("./lab.gltf", "results would go over ./lab.gltf, which the batch needs"),
        ("jobs.toml", "results would go over jobs.toml, which the batch needs"),
        ("out/1.4.exr", "output out/1.4.exr is a file that the batch needs"),
        ("notes.txt", "notes.txt: holds no results of a batch; name another file, or remove it"),
        ("folder", "cannot write folder: "),
    ] {
        for more in [&[][..], &["--merge"], &["--task", "1/1", "--dry-run"]] {
            // Who only looks need not be able to write.
            if more.contains(&"--dry-run") && ["notes.txt", "folder"].contains(&results) {
                continue;
            }
            let run = batch(&here, &[&["jobs.toml", "--results", results][..], more].concat());
            refused(&run, &[words]);
        }
    }
    assert_eq!(names_in(&here), ["folder", "jobs.toml", "lab.gltf", "notes.txt"]);
    assert_eq!(fs::read(here.join("lab.gltf")).unwrap(), before[0]);
    assert_eq!(fs::read(here.join("jobs.toml")).unwrap(), before[1]);
    assert_eq!(fs::read_to_string(here.join("notes.txt")).unwrap(), "mine\n");
}
