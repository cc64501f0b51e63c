//! `--record` and `bench history`: the file of figures that grows, and its trends.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::bench::number;
use crate::program::{Run, folder, names_in, run, sunstone};

/// A line of a record, as another program might write it.
fn line(cpu: &str, figures: &str) -> String {
    format!(
        "{{\"date\": \"2026-01-31T12:00:00+01:00\", \"commit\": \"abc1234\", \"cpu\": \"{cpu}\", \
         \"processors\": 2, \"threads\": 2, \"version\": \"0.1.0\", \"bench\": \"peers\", \
         \"figures\": {{{figures}}}, \"more\": 1}}\n"
    )
}

fn history(here: &Path, options: &str) -> Run {
    let words = ["bench", "history", "a.ndjson"].into_iter().chain(options.split_whitespace());
    sunstone(here, &words.collect::<Vec<&str>>())
}

fn measure(here: &Path, record: &str) -> Run {
    let words = "bench table1 --iterations 1 --photons 100 --samples-per-iteration 1 --record";
    let size = ["--width", "16", "--height", "16"];
    let words: Vec<&str> = words.split(' ').chain([record]).chain(size).collect();
    sunstone(here, &words)
}

#[test]
fn trends_are_those_of_the_lines() {
    let here = folder("history");
    let records = [
        line("Fast 1", "\"a.ratio\": 2.0, \"a.speedup\": 1.0, \"b\": 0"),
        line("Slow 2", "\"a.ratio\": 50.0"),
        line("Fast 1", "\"a.ratio\": 1.0, \"a.speedup\": 4.0"),
        line("Fast 1", "\"a.ratio\": 1.5, \"a.speedup\": 2.0, \"b\": 1"),
    ];
    fs::write(here.join("a.ndjson"), records.concat()).unwrap();
    let report = history(&here, "--format json --plot a.svg --json a.json").done().stdout;
    assert_eq!(fs::read_to_string(here.join("a.json")).unwrap(), report);
    let report: Value = serde_json::from_str(&report).unwrap();
    let machines = report["machines"].as_array().unwrap();
    assert_eq!((machines[0]["cpu"].as_str(), machines.len()), (Some("Fast 1"), 2));
    let trends = machines[0]["trends"].as_array().unwrap();
    let names: Vec<&str> = trends.iter().map(|trend| trend["figure"].as_str().unwrap()).collect();
    assert_eq!(names, ["a.ratio", "a.speedup", "b"]);
    let keys = ["records", "first", "previous", "latest", "best"];
    let expected =
        [[3.0, 2.0, 1.0, 1.5, 1.0], [3.0, 1.0, 4.0, 2.0, 4.0], [2.0, 0.0, 0.0, 1.0, 0.0]];
    for (trend, expected) in trends.iter().zip(expected) {
        assert_eq!(keys.map(|key| number(&trend[key])), expected, "{trend}");
    }
    assert_eq!(number(&trends[0]["since_previous_percent"]), 50.0);
    assert_eq!(number(&trends[0]["since_first_percent"]), -25.0);
    assert_eq!(trends[2]["since_first_percent"], Value::Null, "it began with zero");
    let svg = fs::read_to_string(here.join("a.svg")).unwrap();
    assert!(svg.contains("Fast 1") && svg.contains("a.speedup"), "{svg}");
    let text = history(&here, "--figure a.s --figure b --cpu Fast").done().stdout;
    for words in ["Fast 1, 2 processors, 2 threads", "a.speedup", "-50.0 %", "+100.0 %"] {
        assert!(text.contains(words), "{words:?}: {text}");
    }
    assert!(!text.contains("Slow 2") && !text.contains("a.ratio"), "{text}");
}

#[test]
fn histories_that_cannot_be_told_are_refused() {
    let here = folder("history-errors");
    let good = line("A", "\"a\": 1");
    for (text, options, code, words) in [
        (
            format!("{good}\n{{\"date\": 1}}\n"),
            "",
            1,
            "a.ndjson is not a usable record file: line 3",
        ),
        (good.replace("1.0\"", "1.0\" 7") + &good, "", 1, "line 1"),
        (good.clone() + &good[..40], "", 1, "line 2"),
        (good.replace("2026-01-31T", "2026-01-31 "), "", 1, "is not RFC 3339"),
        (good.replace("\"a\": 1", "\"a\": \"1\""), "", 1, "line 1"),
        (String::new(), "", 1, "holds no records yet"),
        (good.clone(), "--cpu B", 1, "its processors are A"),
        (good.clone(), "--figure b", 1, "fits --figure; its processors"),
        (good.clone(), "--figure b --cpu x", 1, "fits --figure and --cpu; its processors"),
        (good.clone(), "--json a.ndjson", 2, "is the input a.ndjson"),
        (good.clone(), "--plot a.png", 1, ".svg (plots are SVG)"),
        (
            line("A", &(0..13).map(|i| format!("\"a{i}\": 1")).collect::<Vec<_>>().join(", ")),
            "--plot a.svg",
            2,
            "choose some with --figure",
        ),
    ] {
        fs::write(here.join("a.ndjson"), &text).unwrap();
        let run = history(&here, options);
        assert_eq!(run.code, code, "{}: {}", run.command, run.stderr);
        assert!(run.stderr.contains(words), "{}: {words:?}: {}", run.command, run.stderr);
        assert_eq!(run.stdout, "", "{}", run.command);
        assert_eq!(fs::read_to_string(here.join("a.ndjson")).unwrap(), text);
        assert_eq!(names_in(&here), ["a.ndjson"]);
    }
    let run = sunstone(&here, &["bench", "history", "missing"]);
    assert_eq!((run.code, run.stderr.contains("missing")), (1, true), "{}", run.stderr);
}

/// What was there stays as it was, whatever comes.
#[test]
fn a_record_only_grows() {
    let here = folder("record");
    // The last line may lack its end.
    let before = line("A", "\"a\": 1").trim_end().to_owned();
    fs::write(here.join("a.ndjson"), &before).unwrap();
    measure(&here, "a.ndjson").done();
    measure(&here, "a.ndjson").done();
    let text = fs::read_to_string(here.join("a.ndjson")).unwrap();
    assert!(text.starts_with(&before) && text.ends_with('\n'), "{text}");
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.len(), 3);
    for line in &lines[1..] {
        let keys: Vec<&String> = line.as_object().unwrap().keys().collect();
        let expected = "bench commit cpu date figures processors threads version";
        assert_eq!(keys, expected.split(' ').collect::<Vec<_>>());
        assert_eq!(line["bench"], "table1");
        assert_eq!(line["version"], env!("CARGO_PKG_VERSION"));
        assert!(number(&line["figures"]["table1.mirror.ratio"]) > 0.0);
        assert!(number(&line["figures"]["table1.tank.wall_ratio"]) > 0.0);
    }
    assert_eq!(names_in(&here), ["a.ndjson"]);
    // A file that is damaged is left alone, and nothing is measured for it.
    let damaged = format!("{text}{{\"date\"\n");
    fs::write(here.join("a.ndjson"), &damaged).unwrap();
    let run = measure(&here, "a.ndjson");
    assert_eq!((run.code, run.stdout.as_str()), (1, ""), "{}", run.stderr);
    assert!(run.stderr.contains("line 4"), "{}", run.stderr);
    assert_eq!(fs::read_to_string(here.join("a.ndjson")).unwrap(), damaged);
}

/// The commit is that of the repository that the record lies in; the record itself does not make
/// it dirty.
#[test]
fn records_name_their_commit() {
    let here = folder("record-commit");
    let git = |arguments: &[&str]| {
        let identity =
            ["-c", "user.name=a", "-c", "user.email=a@b.c", "-c", "commit.gpgsign=false"];
        let mut command = Command::new("git");
        command.current_dir(&here).args(identity).args(arguments);
        run(&mut command).done().stdout.trim().to_owned()
    };
    if Command::new("git").arg("--version").output().is_err() {
        eprintln!("git is not installed: not tested");
        return;
    }
    git(&["init", "--quiet"]);
    fs::create_dir(here.join("kept")).unwrap();
    fs::write(here.join("kept/a.ndjson"), "").unwrap();
    fs::write(here.join("file"), "1").unwrap();
    git(&["add", "--all"]);
    git(&["commit", "--quiet", "--message", "a"]);
    let head = git(&["rev-parse", "--short", "HEAD"]);
    let record = |dirty: bool| {
        measure(&here, "kept/a.ndjson").done();
        let text = fs::read_to_string(here.join("kept/a.ndjson")).unwrap();
        let line: Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
        assert_eq!(line["commit"], format!("{head}{}", if dirty { "-dirty" } else { "" }));
    };
    record(false);
    record(false);
    fs::write(here.join("file"), "2").unwrap();
    record(true);
}
