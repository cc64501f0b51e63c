//! Batches in tasks, as machines of a cluster would do them, and what makes engines run them:
//! templates are checked and unfolded by Open Job Description's own library, and scripts are run by
//! bash. `.ci/farm/run` has the engines themselves.

use std::fs;
use std::path::{Path, PathBuf};

use openjd_model::format_string::FormatStringOptions;
use openjd_model::{
    CallerLimits, DocumentType, JobParameterInputValues, PathParameterOptions, StepDependencyGraph,
    StepParameterSpaceIterator,
};
use serde_json::Value;
use sunstone::StokesImage;
use sunstone::internals::image;

use crate::program::{Run, folder, names_in, scene, sunstone};

const JOBS: &str = r#"version = 1
[defaults]
scene = "lab.gltf"
iterations = 6
width = 8
height = 8
[[jobs]]
name = "swept"
output = "out/{name} {integrator}-{angle}.exr"
variance = true
sweep = [
    { name = "integrator", key = "integrator", values = ["path", "ppm"] },
    { name = "angle", key = "materials/half-wave plate/axis_deg", values = [0, 30] },
]
[[jobs]]
name = "still"
integrator = "bdpt"
output = "{name}.hdr"
"#;
const FARM: &str = "[farm]\ntasks = 4\nparts = 3\n";
const OUTPUTS: [&str; 5] = [
    "out/swept path-0.exr",
    "out/swept path-30.exr",
    "out/swept ppm-0.exr",
    "out/swept ppm-30.exr",
    "still.S0.hdr",
];

/// A folder with a scene, and a job file of this text.
fn lab(name: &str, jobs: &str) -> PathBuf {
    let here = folder(&format!("farm-{name}"));
    fs::copy(scene("cornell"), here.join("lab.gltf")).unwrap();
    fs::write(here.join("jobs.toml"), jobs).unwrap();
    here
}

fn batch(here: &Path, arguments: &[&str]) -> Run {
    sunstone(here, &[&["batch", "jobs.toml", "--threads", "2"][..], arguments].concat())
}

/// Runs all tasks, the last one first.
fn tasks(here: &Path, count: u32) -> Vec<Run> {
    let task = |number: u32| batch(here, &["--task", &format!("{number}/{count}")]).done();
    (1..=count).rev().map(task).collect()
}

fn load(path: &Path) -> StokesImage {
    image::load(path).unwrap_or_else(|error| panic!("{error}"))
}

/// The images of one plain batch.
fn assert_same_images(here: &Path, other: &Path) {
    for output in OUTPUTS {
        let [own, plain] = [here, other].map(|folder| load(&folder.join(output)));
        assert!(own.planes == plain.planes && own.variance == plain.variance, "{output}");
        assert!(own.planes[0].iter().any(|value| *value > 0.0), "{output} is black");
    }
}

fn plain(name: &str) -> PathBuf {
    let here = lab(name, JOBS);
    batch(&here, &[]).done();
    here
}

fn records(here: &Path) -> Vec<Value> {
    let text = fs::read_to_string(here.join("results.jsonl")).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn tasks_make_what_one_batch_makes() {
    let other = plain("tasks-plain");
    let here = lab("tasks", &format!("{JOBS}{FARM}"));
    let run = batch(&here, &["--task", "2/4", "--dry-run"]).done();
    let line = "    1  to do  out/swept path-30.exr.2-of-3.part  \"swept\" (integrator \"path\", \
                angle 30), part 2/3";
    assert!(run.stdout.lines().any(|it| it == line), "{}", run.stdout);
    assert_eq!(names_in(&here), ["jobs.toml", "lab.gltf"]);
    let first = tasks(&here, 4);
    let parts: Vec<_> = first.iter().map(|run| run.stderr.split(" in ").next().unwrap()).collect();
    assert_eq!(parts.len(), 4);
    let is_told = |it: &&str| *it == "jobs.toml: 4 parts" || *it == "jobs.toml: 3 parts";
    assert!(parts.iter().all(is_told), "{parts:?}");
    assert_eq!(names_in(&here.join("out")).len(), 12);
    for run in tasks(&here, 4) {
        assert!(run.stderr.contains(" 0 parts in ") && run.stderr.contains("were done before"));
    }
    // By other shares, nothing is left either.
    for run in tasks(&here, 2) {
        assert!(run.stderr.contains(" 0 parts in "), "{}", run.stderr);
    }
    // Of another division: it has to be there no longer in the end.
    fs::write(here.join("out/swept ppm-0.exr.9-of-9.part"), "of old").unwrap();
    batch(&here, &["--merge"]).done();
    assert_same_images(&here, &other);
    let last: Vec<String> = OUTPUTS[..4].iter().map(|it| it[4..].to_owned()).collect();
    assert_eq!(names_in(&here.join("out")), last);
    assert_eq!(names_in(&here), names_in(&other));
    let known = |mut record: Value| {
        for key in ["seconds", "checksum"] {
            assert!(!record[key].take().is_null());
        }
        record
    };
    let sorted = |folder: &Path| {
        let mut all: Vec<Value> = records(folder).into_iter().map(known).collect();
        all.sort_by_key(|record| record["index"].as_u64());
        all
    };
    assert_eq!(sorted(&here), sorted(&other));
    // All of it is done, whoever asks.
    for arguments in [&["--merge"][..], &[], &["--task", "1/2"]] {
        let run = batch(&here, arguments).done();
        assert!(run.stderr.contains(" 0 "), "{}", run.stderr);
    }
    assert!(load(&here.join(OUTPUTS[0])).metadata.iter().any(|it| it.0 == "parts" && it.1 == "3"));
}

#[test]
fn a_merge_names_what_is_missing_and_tasks_do_what_is_left() {
    let other = plain("missing-plain");
    let here = lab("missing", &format!("{JOBS}{FARM}"));
    tasks(&here, 2);
    let [gone, damaged, cut] = ["path-0", "path-30", "ppm-0"]
        .map(|name| here.join("out").join(format!("swept {name}.exr.2-of-3.part")));
    fs::remove_file(&gone).unwrap();
    let mut bytes = fs::read(&damaged).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&damaged, bytes).unwrap();
    fs::write(&cut, &fs::read(&cut).unwrap()[..100]).unwrap();
    // Of another scene, another build or other options.
    let strange = here.join("out/swept ppm-30.exr.1-of-3.part");
    let files = names_in(&here.join("results.jsonl.tasks"));
    assert_eq!(files, ["jobs.toml.1-of-2.jsonl", "jobs.toml.2-of-2.jsonl"]);
    for file in files {
        let path = here.join("results.jsonl.tasks").join(file);
        let text = fs::read_to_string(&path).unwrap();
        let lines = text.lines().filter(|line| !line.contains("ppm-30.exr.1-of-3"));
        fs::write(&path, lines.map(|line| format!("{line}\n")).collect::<String>()).unwrap();
    }
    let merge = batch(&here, &["--merge"]);
    assert_eq!(merge.code, 1, "{}", merge.stderr);
    let job = |index: u32, name: &str, angle: u32| {
        format!("error: job {index} \"swept\" (integrator \"{name}\", angle {angle}): part ")
    };
    for words in [
        &format!(
            "{}2/3 is missing: there is no out/swept path-0.exr.2-of-3.part; run the tasks again",
            job(0, "path", 0)
        ),
        &format!("{}2/3, out/swept path-30.exr.2-of-3.part, is damaged", job(1, "path", 30)),
        &format!("{}2/3, out/swept ppm-0.exr.2-of-3.part, is damaged", job(2, "ppm", 0)),
        &format!(
            "{}1/3, out/swept ppm-30.exr.1-of-3.part, is there, but no task has noted",
            job(3, "ppm", 30)
        ),
        "jobs.toml: 1 image in ",
        "error: jobs.toml: 4 jobs failed",
    ] {
        assert!(merge.stderr.contains(words), "{words}: {}", merge.stderr);
    }
    assert!(strange.exists() && !here.join("still.hdr.1-of-3.part").exists());
    assert_eq!(records(&here).len(), 5);
    let merge = batch(&here, &["--merge", "--parts", "1"]);
    let words =
        "the image is missing: there is no out/swept path-0.exr (there is out/swept path-0.exr.";
    assert!(merge.code == 1 && merge.stderr.contains(words), "{}", merge.stderr);
    let words: String = tasks(&here, 2).into_iter().map(|run| run.stderr).collect();
    assert_eq!(words.matches(" 2 parts in ").count(), 2, "{words}");
    batch(&here, &["--merge"]).done();
    assert_same_images(&here, &other);
    assert_eq!(names_in(&here), names_in(&other));
}

#[test]
fn jobs_that_cannot_be_rendered_stop_no_other() {
    let failing =
        "[[jobs]]\nname = \"bad\"\noutput = \"bad.exr\"\nset = { \"materials/glass/ior\" = -1 }\n";
    for (name, farm) in [("whole", ""), ("in-parts", FARM)] {
        let here = lab(name, &format!("{JOBS}{failing}{farm}"));
        let words: String = tasks(&here, 3).into_iter().map(|run| run.stderr).collect();
        assert!(words.contains("error: job 5 \"bad\""), "{words}");
        assert!(words.contains("failed, and would again; --merge will tell"), "{words}");
        assert!(!words.contains("trying again"), "{words}");
        let merge = batch(&here, &["--merge"]);
        assert_eq!(merge.code, 1, "{}", merge.stderr);
        assert!(merge.stderr.contains("error: jobs.toml: 1 job failed"), "{}", merge.stderr);
        let all = records(&here);
        let errors: Vec<&str> = all.iter().filter_map(|record| record["error"].as_str()).collect();
        assert!(all.len() == 6 && errors.len() == 1 && errors[0].contains("ior"), "{errors:?}");
        assert!(!errors[0].contains("run the tasks again"), "{errors:?}");
        assert!(OUTPUTS.iter().all(|output| here.join(output).exists()));
    }
}

#[test]
fn what_makes_no_sense_is_refused_before_anything_is_rendered() {
    let here = lab("refused", "");
    let jobs = |more: &str| {
        let defaults = "version = 1\n[defaults]\nscene = \"lab.gltf\"\nintegrator = \"path\"\n\
                        width = 8\nheight = 8\n[[jobs]]\nname = \"a\"\noutput = \"a.exr\"\n";
        fs::write(here.join("jobs.toml"), format!("{defaults}{more}")).unwrap();
    };
    let refused = |words: &str| {
        for verb in [
            &["batch", "jobs.toml", "--task", "1/2"][..],
            &["batch", "jobs.toml", "--merge"],
            &["farm", "slurm", "jobs.toml", "-o", "a.sh"],
        ] {
            let run = sunstone(&here, verb);
            assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{}: {}", run.command, run.stderr);
            assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
        }
        assert_eq!(names_in(&here), ["jobs.toml", "lab.gltf"]);
    };
    let parts = "[farm]\nparts = 9";
    jobs(&format!("spp = 8\n{parts}"));
    refused("job 0 \"a\", part 9/9: an image of 8 samples a pixel has 8 iterations, and no more");
    jobs(&format!("spp = 64\ntime_limit = 3\n{parts}"));
    refused("job 0 \"a\", part goes without a time limit");
    jobs(&format!("spp = 32\nintegrator = \"auto\"\n{parts}"));
    refused("has 8 iterations, and no more parts (by ppm, which auto may choose: choose yourself)");
    jobs(&format!("spp = 16\nreplicates = 4\n{parts}"));
    refused("4 blocks that its variances come from");
    jobs("[farm]\nparts = 0");
    refused("farm: `parts` must be a whole number from 1 to 1000000");
    // Nothing of that matters where there are no parts.
    jobs("spp = 2\ntime_limit = 3\n[farm]\nparts = 4");
    for (arguments, words) in [
        (&["batch", "jobs.toml", "--task", "3/2"][..], "must be from 1/N to N/N, not 3/2"),
        (&["batch", "jobs.toml", "--task", "two"], "must be K/N, as in 3/20"),
        (&["batch", "jobs.toml", "--parts", "2"], "--parts goes with --task or --merge"),
        (&["batch", "jobs.toml", "--task", "1/2", "--merge"], "cannot be used with"),
        (&["batch", "jobs.toml", "--task", "1/2", "--parts", "0"], "parts must be from 1 on"),
        (&["farm", "pbs", "jobs.toml"], "[possible values: slurm, openjd]"),
        (
            &["farm", "slurm", "jobs.toml", "--parts", "1", "--tasks", "1001"],
            "tasks must be from 1 to 1000, not 1001",
        ),
        (
            &["farm", "slurm", "jobs.toml", "--parts", "1", "-o", "lab.gltf"],
            "the output lab.gltf is the input",
        ),
        (
            &["farm", "slurm", "jobs.toml", "--parts", "1", "--cpus", "0"],
            "--cpus must be from 1 to",
        ),
    ] {
        let run = sunstone(&here, arguments);
        assert_eq!(run.code, 2, "{}: {}", run.command, run.stderr);
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
    }
    assert_eq!(names_in(&here), ["jobs.toml", "lab.gltf"]);
    batch(&here, &[]).done();
}

/// What a step of a job runs: programs with their arguments.
type Actions = Vec<(String, Vec<String>)>;

/// The steps of a template in the order of their dependencies, as the library of Open Job
/// Description unfolds them.
fn unfolded(path: &Path) -> Vec<(String, Actions)> {
    let limits = CallerLimits::default();
    let text = fs::read_to_string(path).unwrap();
    let object =
        |kind| openjd_model::template::parse::document_string_to_object(&text, kind, &limits);
    let value = object(DocumentType::Json).unwrap();
    assert_eq!(value, object(DocumentType::Yaml).unwrap(), "JSON is YAML");
    let template = openjd_model::decode_job_template(value, None, &limits).unwrap();
    let home = path.parent().unwrap().to_str().unwrap();
    let options = PathParameterOptions::new(home, home);
    let none = JobParameterInputValues::new();
    let values = openjd_model::preprocess_job_parameters(&template, &none, &[], &options).unwrap();
    let context = template.default_validation_context();
    let job = openjd_model::create_job(&template, &values, &context).unwrap();
    let order = StepDependencyGraph::new(&job).unwrap().topo_sorted_names().unwrap();
    let step = |name: String| {
        let step = job.steps.iter().find(|step| step.name == name).unwrap();
        let action = &step.script.actions.on_run;
        let mut symbols = openjd_model::build_symbol_table(&values).unwrap();
        // A session adds those that it might have to map to another machine: paths.
        for (name, value) in &values {
            symbols.set(&format!("Param.{name}"), value.value.clone()).unwrap();
        }
        let space = step.parameter_space.as_ref();
        let tasks: Vec<_> = match space {
            Some(space) => StepParameterSpaceIterator::new(space).unwrap().collect(),
            None => vec![Default::default()],
        };
        let run = tasks.into_iter().map(|task| {
            for (name, value) in task {
                symbols.set(&format!("Task.Param.{name}"), value.value).unwrap();
            }
            let word = |text: &openjd_model::FormatString| {
                text.resolve_string_with(&symbols, &FormatStringOptions::default()).unwrap()
            };
            (word(&action.command), action.args.iter().flatten().map(word).collect())
        });
        (name, run.collect())
    };
    order.into_iter().map(step).collect()
}

#[test]
fn templates_are_open_job_descriptions_that_make_the_images() {
    let other = plain("openjd-plain");
    // Nothing in a name is a reference, or anything to a shell.
    let here = lab("openjd {{Param.Task}} it's $(a) \"b\"", "");
    let jobs = "{{Job.Name}} & 'jobs'.toml";
    fs::remove_file(here.join("jobs.toml")).unwrap();
    fs::write(here.join(jobs), format!("{JOBS}{FARM}")).unwrap();
    sunstone(&here, &["farm", "openjd", jobs, "-o", "job.json", "--cpus", "2"]).done();
    let steps = unfolded(&here.join("job.json"));
    let counts: Vec<_> = steps.iter().map(|(name, run)| (name.as_str(), run.len())).collect();
    assert_eq!(counts, [("render", 4), ("merge", 1)]);
    let elsewhere = folder("farm-openjd-session");
    for (program, arguments) in steps.iter().flat_map(|(_, run)| run) {
        assert_eq!(Path::new(program), Path::new(env!("CARGO_BIN_EXE_sunstone")));
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        sunstone(&elsewhere, &arguments).done();
    }
    assert_same_images(&here, &other);
    assert!(names_in(&elsewhere).is_empty());
    // Beside the job file or above, and of as many tasks as there is work for.
    let above = here.parent().unwrap();
    let folder_name = here.file_name().unwrap().to_str().unwrap();
    let typed = format!("{folder_name}/{jobs}");
    let run = sunstone(above, &["farm", "openjd", &typed, "--tasks", "100", "--parts", "1"]).done();
    assert!(run.stderr.contains("note: 5 tasks: there is no work for 100"), "{}", run.stderr);
    fs::write(above.join("farm-above.json"), run.stdout).unwrap();
    sunstone(above, &["farm", "openjd", &typed, "-o", "farm-above.json"]).done();
    let steps = unfolded(&above.join("farm-above.json"));
    assert_eq!(Path::new(&steps[1].1[0].1[1]), here.join(jobs));
    let run = sunstone(above, &["farm", "openjd", &typed, "-o", "farm-openjd-session/job.json"]);
    assert!(run.code == 2 && run.stderr.contains("or one above that"), "{}", run.stderr);
}

/// An `sbatch` that runs an array at once, and what depends on it only if that went well.
#[cfg(unix)]
const SBATCH: &str = r#"#!/usr/bin/env bash
here=$(dirname -- "$0")
echo "$*" >> "$here/asked"
id=$(wc -l < "$here/asked")
array=() after=
while [[ $1 == -* ]]; do
    case $1 in
    --array=1-*) array=($(seq "${1#--array=1-}")) ;;
    --dependency=afterok:*) after=${1#--dependency=afterok:} ;;
    --output=*) log=${1#--output=} ;;
    --cpus-per-task=*) export SLURM_CPUS_PER_TASK=${1#*=} ;;
    esac
    shift
done
echo "$id;cluster"
[ -e "$here/failed-$after" ] && exit
for task in "${array[@]:-}"; do
    SLURM_ARRAY_TASK_ID=$task bash "$@" >> "$log" 2>&1 || touch "$here/failed-$id"
done
"#;

#[test]
#[cfg(unix)]
fn scripts_hand_in_an_array_and_a_merge_behind_it() {
    use std::os::unix::fs::PermissionsExt;
    use std::process::Command;
    let other = plain("slurm-plain");
    let here = lab("slurm it's $(a) \"b\"", &format!("{JOBS}{FARM}"));
    let jobs = "-x & 'jobs'.toml";
    fs::rename(here.join("jobs.toml"), here.join(jobs)).unwrap();
    let tools = folder("farm-slurm-tools");
    fs::write(tools.join("sbatch"), SBATCH).unwrap();
    fs::set_permissions(tools.join("sbatch"), fs::Permissions::from_mode(0o755)).unwrap();
    let path = format!("{}:{}", tools.display(), std::env::var("PATH").unwrap());
    let submit = || {
        let mut command = Command::new("bash");
        command.args(["my batch.sh", "--mem=16G", "--comment=a b"]).current_dir(&here);
        crate::program::run(command.env("PATH", &path).env("SUNSTONE_CACHE", "off")).done()
    };
    sunstone(&here, &["farm", "slurm", &format!("./{jobs}"), "--cpus", "2", "-o", "my batch.sh"])
        .done();
    // A task that cannot begin: nothing is merged.
    let script = fs::read_to_string(here.join("my batch.sh")).unwrap();
    let broken = script
        .replace("\nrender)\n", "\nrender)\n    [ \"$SLURM_ARRAY_TASK_ID\" != 3 ] || exit 1\n");
    fs::write(here.join("my batch.sh"), broken).unwrap();
    submit();
    assert!(!here.join("still.S0.hdr").exists() && here.join("still.hdr.3-of-3.part").exists());
    fs::write(here.join("my batch.sh"), script).unwrap();
    let words = submit().stdout;
    assert!(
        words.starts_with("-x____jobs_: 4 tasks are job 3, the merge after them is job 4; logs"),
        "{words}"
    );
    assert_same_images(&here, &other);
    let asked = fs::read_to_string(tools.join("asked")).unwrap();
    let asked: Vec<&str> = asked.lines().collect();
    for (line, words) in [
        (2, "--array=1-4"),
        (2, "--requeue"),
        (2, "--cpus-per-task=2 --mem=16G --comment=a b"),
        (3, "--dependency=afterok:3"),
        (3, "--kill-on-invalid-dep=yes"),
    ] {
        assert!(asked[line].contains(words), "{words}: {}", asked[line]);
    }
    let logs = names_in(&here.join("-x____jobs_.slurm"));
    assert_eq!(logs, ["%A_%a.log", "%j_merge.log"]);
}
