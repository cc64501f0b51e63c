//! What README.md says is true: its commands run as printed, and its links lead somewhere.

use std::fs;
use std::path::Path;

use crate::program::{folder, sunstone};

const PROGRAM: &str = "cargo run --release -- ";
/// Other commands that the README may print; they are not run here.
const OTHERS: [&str; 9] = [
    "cargo build --release",
    "cargo test --profile checks",
    "RUSTFLAGS=\"-C target-cpu=native\" cargo build --release",
    ".ci/run",
    ".ci/view/run",
    "bash malus.sh --partition=long --time=4:00:00",
    "openjd run malus.json",
    "maturin build --release --zig --out wheels",
    "pip install wheels/sunstone-*.whl",
];
/// What makes a printed render small: the last of equal options counts.
const SMALL: [&str; 6] = ["--spp", "16", "--width", "24", "--height", "16"];
/// The same with photons.
const SMALL_PHOTONS: [&str; 8] =
    ["--photons", "1000", "--iterations", "2", "--width", "24", "--height", "16"];

/// What makes a printed measurement small.
fn small_bench(bench: &str) -> &'static [&'static str] {
    match bench {
        "table1" => &SMALL_PHOTONS,
        "overhead" | "wavelengths" => {
            &["--spp", "16", "--rounds", "1", "--width", "24", "--height", "16"]
        }
        "scaling" => &["--points", "2", "--rounds", "1", "--width", "16", "--height", "16"],
        "error" => &["--reference-spp", "16", "--iterations", "2", "--width", "16"],
        "history" => &[],
        other => panic!("how small is `bench {other}`?"),
    }
}

fn readme() -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).unwrap()
}

/// Lines of the blocks that are marked as shell commands.
fn commands(text: &str) -> Vec<String> {
    let blocks = text.split("```sh\n").skip(1).filter_map(|rest| rest.split("```").next());
    let lines = blocks.flat_map(str::lines).map(str::trim);
    lines.filter(|line| !line.is_empty() && !line.starts_with('#')).map(str::to_owned).collect()
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn the_commands_run_as_printed() {
    let here = folder("readme");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    fs::create_dir_all(here.join("scenes")).unwrap();
    for entry in fs::read_dir(root.join("scenes")).unwrap().map(Result::unwrap) {
        if entry.path().is_file() {
            fs::copy(entry.path(), here.join("scenes").join(entry.file_name())).unwrap();
        }
    }
    let mut verbs = Vec::new();
    for command in commands(&readme()) {
        let Some(line) = command.strip_prefix(PROGRAM) else {
            assert!(OTHERS.contains(&command.as_str()), "what is `{command}`?");
            continue;
        };
        let mut words: Vec<&str> = line.split_whitespace().collect();
        verbs.push(words[..if words[0] == "bench" { 2 } else { 1 }].join(" "));
        match words[0] {
            "render" if words.contains(&"ppm") => words.extend(SMALL_PHOTONS),
            "render" => words.extend(SMALL),
            "bench" => words.extend(small_bench(words[1])),
            _ => {}
        }
        sunstone(&here, &words).done();
    }
    let benches = ["table1", "overhead", "wavelengths", "scaling", "error", "history"];
    let benches = benches.map(|bench| format!("bench {bench}"));
    let rest =
        ["render", "merge", "batch", "report", "farm", "visualize", "view", "compare", "inspect"];
    let rest = rest.map(str::to_owned);
    for verb in benches.iter().chain(&rest) {
        assert!(verbs.contains(verb), "the README does not show `{verb}`");
    }
}

#[test]
fn the_links_lead_somewhere() {
    let text = readme();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut count = 0;
    for rest in text.split("](").skip(1) {
        let link = rest.split(')').next().unwrap().split('#').next().unwrap();
        if !link.is_empty() && !link.starts_with("http") {
            assert!(root.join(link).exists(), "nothing at {link}");
            count += 1;
        }
    }
    assert!(count > 3, "only {count} links");
}
