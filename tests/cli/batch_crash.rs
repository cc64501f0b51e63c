//! What becomes of a batch when the program itself fails. It does so on purpose where it checks
//! itself, which is without optimization.

use std::fs;
use std::process::Command;

use serde_json::Value;

use crate::program::{folder, names_in, run, scene};

#[test]
#[cfg_attr(not(debug_assertions), ignore = "released programs do not fail on purpose")]
fn jobs_at_which_the_program_fails_stop_no_others() {
    let here = folder("batch-crash");
    fs::copy(scene("cornell"), here.join("lab.gltf")).unwrap();
    let jobs = "version = 1\n[defaults]\nscene = \"lab.gltf\"\nintegrator = \"path\"\nspp = 1\n\
                width = 4\nheight = 4\n[[jobs]]\noutput = \"{n}.exr\"\n\
                sweep = [{ name = \"n\", key = \"materials/glass/ior\", \
                values = [1, 2, 3, 4, 5, 6] }]\n";
    fs::write(here.join("jobs.toml"), jobs).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_sunstone"));
    command.args(["batch", "jobs.toml", "--threads", "2"]).current_dir(&here);
    command.env("SUNSTONE_CACHE", "off").env("SUNSTONE_PANIC_AT", "3.exr,5.exr");
    let ended = run(&mut command);
    assert_eq!(ended.code, 1, "{}", ended.stderr);
    let names = names_in(&here);
    for n in 1..=6 {
        let is_there = names.contains(&format!("{n}.exr"));
        assert_eq!(is_there, ![3, 5].contains(&n), "{n}: {names:?}");
    }
    let results = fs::read_to_string(here.join("results.jsonl")).unwrap();
    let records: Vec<Value> =
        results.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let error_of = |name: &str| {
        let mut of = records.iter().filter(|record| record["output"] == name);
        of.next_back().and_then(|record| record["error"].as_str())
    };
    assert_eq!(error_of("3.exr"), Some("the program failed: on purpose"), "{results}");
    assert_eq!(error_of("5.exr"), Some("the program failed: on purpose"), "{results}");
    assert_eq!(error_of("4.exr"), None, "{results}");
    // Another time they are tried again, and do not fail.
    run(command.env_remove("SUNSTONE_PANIC_AT")).done();
    assert!(names_in(&here).contains(&"3.exr".to_owned()));
}
