//! Running the program, and what it says to users in general.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What a run of the program came to.
pub struct Run {
    /// Its command line, for messages.
    pub command: String,
    /// Exit code; -1 if a signal ended it.
    pub code: i32,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Run {
    /// The run, if it did what it was asked.
    #[track_caller]
    pub fn done(self) -> Self {
        assert_eq!(self.code, 0, "{}: {}", self.command, self.stderr);
        self
    }
}

/// Runs the program in a folder, with no cache.
pub fn sunstone(folder: &Path, arguments: &[&str]) -> Run {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sunstone"));
    run(command.args(arguments).current_dir(folder).env("SUNSTONE_CACHE", "off"))
}

/// Runs a command to its end.
pub fn run(command: &mut Command) -> Run {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    Run {
        command: format!("{command:?}"),
        code: output.status.code().unwrap_or(-1),
        stdout: String::from_utf8(output.stdout).expect("the program prints UTF-8"),
        stderr: String::from_utf8(output.stderr).expect("the program prints UTF-8"),
    }
}

/// An empty folder of this name.
pub fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli").join(name);
    if folder.exists() {
        fs::remove_dir_all(&folder).unwrap();
    }
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// The path of a shipped scene.
pub fn scene(name: &str) -> String {
    format!("{}/scenes/{name}.gltf", env!("CARGO_MANIFEST_DIR"))
}

/// Names of what lies in a folder, hidden files too.
pub fn names_in(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn help_and_version_go_to_standard_output() {
    let here = folder("help");
    for arguments in [&["help"][..], &["--version"], &["help", "render"], &["visualize", "-h"]] {
        let run = sunstone(&here, arguments).done();
        assert!(!run.stdout.is_empty() && run.stderr.is_empty(), "{}", run.command);
    }
    let version = sunstone(&here, &["--version"]).stdout;
    assert_eq!(version.trim(), concat!("sunstone ", env!("CARGO_PKG_VERSION")));
}

#[test]
fn every_option_of_every_verb_is_explained() {
    let here = folder("explained");
    let verbs =
        ["render", "merge", "batch", "report", "farm", "visualize", "view", "compare", "inspect"];
    let benches = ["table1", "overhead", "scaling", "error", "history"];
    let benches = benches.iter().map(|bench| format!("bench {bench}"));
    for verb in verbs.iter().map(|verb| verb.to_string()).chain(benches) {
        let arguments: Vec<&str> = std::iter::once("help").chain(verb.split(' ')).collect();
        let help = sunstone(&here, &arguments).done().stdout;
        let lines: Vec<&str> = help.lines().collect();
        for (index, line) in lines.iter().enumerate() {
            let option = line.trim_start();
            if option.starts_with('-') && !option.starts_with("- ") {
                let has_words = option.contains("  ")
                    || lines.get(index + 1).is_some_and(|next| !next.trim().is_empty());
                assert!(has_words, "{verb}: {line}");
            }
        }
    }
}

/// A processor without AVX2 gets words and exit code 1. Needs qemu's user emulation, which this
/// test does without where it is not installed.
#[test]
#[cfg(all(target_arch = "x86_64", target_os = "linux", target_feature = "avx2"))]
fn a_processor_that_is_too_old_is_refused_in_words() {
    let emulated = |model: &str| {
        let mut command = Command::new("qemu-x86_64");
        command.args(["-cpu", model, env!("CARGO_BIN_EXE_sunstone"), "--version"]);
        command
    };
    if emulated("max").output().is_err() {
        eprintln!("qemu-x86_64 is not installed: not tested");
        return;
    }
    for model in ["qemu64", "Nehalem", "IvyBridge"] {
        let run = run(&mut emulated(model));
        assert_eq!(run.code, 1, "{model}: {}", run.stderr);
        assert!(run.stdout.is_empty(), "{model}: {}", run.stdout);
        for words in ["AVX2", "RUSTFLAGS=\"-C target-cpu=native\" cargo build --release"] {
            assert!(run.stderr.contains(words), "{model}: {}", run.stderr);
        }
    }
    run(&mut emulated("Haswell")).done();
}
