//! What becomes of a batch when the program fails.
//!
//! A panic ends the process: one that unwinds is a twelfth larger. Jobs are not to be lost by the
//! fault of one of them, so the process begins anew with the same command line. What was in work is
//! done alone then, one job after the other; a job that was alone when the program failed has
//! failed, and the others go on.

use std::collections::{BTreeMap, BTreeSet};
use std::panic::{self, PanicHookInfo};
use std::process::{self, Command};
use std::sync::{LazyLock, Mutex, PoisonError};
use std::{env, io};

use serde::{Deserialize, Serialize};

/// The variable by which a process tells the one that takes its place.
const VARIABLE: &str = "SUNSTONE_BATCH_FAILED";
/// How often a batch begins anew, at most: something is wrong then that has to do with no job.
const TIMES_MAX: usize = 100;
/// The exit code of a program that has panicked.
const PANICKED: i32 = 101;

/// The outputs of jobs that are in work.
static IN_WORK: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());

/// What earlier processes of this batch have found out, by the outputs of jobs.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Failures {
    /// Jobs one of which may be at fault.
    alone: BTreeSet<String>,
    /// Jobs at which the program fails, and what it says.
    failed: BTreeMap<String, String>,
    /// How often the program has failed.
    times: usize,
}

impl Failures {
    /// Those of this process: read once, and of the processes that it starts no more.
    pub fn known() -> &'static Self {
        static KNOWN: LazyLock<Failures> = LazyLock::new(|| {
            let text = env::var(VARIABLE).unwrap_or_default();
            serde_json::from_str(&text).unwrap_or_default()
        });
        &KNOWN
    }

    /// Whether a job is to be done while no other is.
    pub fn is_suspect(&self, output: &str) -> bool {
        self.alone.contains(output)
    }

    /// What the program says when it fails at a job, if it does.
    pub fn words(&self, output: &str) -> Option<&str> {
        self.failed.get(output).map(String::as_str)
    }

    /// With a failure while these were in work; nothing if there have been too many, or if no job
    /// was.
    fn and(&self, in_work: &BTreeSet<String>, words: &str) -> Option<Self> {
        let mut all = self.clone();
        all.times += 1;
        match in_work.len() {
            0 => return None,
            1 => all.failed.extend(in_work.iter().map(|output| (output.clone(), words.to_owned()))),
            _ => all.alone.extend(in_work.iter().cloned()),
        }
        (all.times <= TIMES_MAX).then_some(all)
    }
}

/// A job that is in work for as long as this is there.
pub struct InWork(String);

impl InWork {
    /// A job, by its output.
    pub fn new(output: &str) -> Self {
        IN_WORK.lock().unwrap_or_else(PoisonError::into_inner).insert(output.to_owned());
        fail_on_purpose(output);
        Self(output.to_owned())
    }
}

impl Drop for InWork {
    fn drop(&mut self) {
        IN_WORK.lock().unwrap_or_else(PoisonError::into_inner).remove(&self.0);
    }
}

/// Sees to it that this program ends when it panics, on whichever thread, and that a batch begins
/// anew.
pub fn watch() {
    let tell = panic::take_hook();
    panic::set_hook(Box::new(move |found| {
        tell(found);
        go_on_after(found);
        process::exit(PANICKED);
    }));
}

/// Lets a new process take the place of this one if there are jobs in work. Returns if not, or if
/// that cannot be.
fn go_on_after(found: &PanicHookInfo) {
    // Kept to the end: other threads that panic wait here.
    let in_work = IN_WORK.lock().unwrap_or_else(PoisonError::into_inner);
    let words = found.payload_as_str().unwrap_or_default();
    let failures = Failures::known().and(&in_work, words);
    let Some(text) = failures.and_then(|all| serde_json::to_string(&all).ok()) else { return };
    let Ok(program) = env::current_exe() else { return };
    let mut command = Command::new(program);
    command.args(env::args_os().skip(1)).env(VARIABLE, text);
    let error = replace_by(&mut command);
    eprintln!("error: the batch cannot begin anew: {error}");
}

/// Returns if it fails.
#[cfg(unix)]
fn replace_by(command: &mut Command) -> io::Error {
    std::os::unix::process::CommandExt::exec(command)
}

/// Returns if it fails. This process waits for the other.
#[cfg(not(unix))]
fn replace_by(command: &mut Command) -> io::Error {
    match command.status() {
        Ok(status) => process::exit(status.code().unwrap_or(PANICKED)),
        Err(error) => error,
    }
}

/// For tests, which are of programs that check themselves: fails at a job.
#[cfg(debug_assertions)]
fn fail_on_purpose(output: &str) {
    let at = env::var("SUNSTONE_PANIC_AT").unwrap_or_default();
    assert!(!at.split(',').any(|at| at == output), "on purpose");
}

#[cfg(not(debug_assertions))]
fn fail_on_purpose(_: &str) {}

#[cfg(test)]
mod tests {
    use super::*;

    fn outputs(names: &[&str]) -> BTreeSet<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    #[test]
    fn a_job_that_was_alone_has_failed_and_others_are_done_alone() {
        let none = Failures::default();
        assert_eq!(none.and(&outputs(&[]), "no job"), None);
        let two = none.and(&outputs(&["a.exr", "b.exr"]), "one of two").expect("a first time");
        assert!(two.is_suspect("a.exr") && two.is_suspect("b.exr") && !two.is_suspect("c.exr"));
        assert_eq!(two.words("a.exr"), None);
        let one = two.and(&outputs(&["b.exr"]), "it \"fails\"").expect("a second time");
        assert_eq!([one.words("a.exr"), one.words("b.exr")], [None, Some("it \"fails\"")]);
        let text = serde_json::to_string(&one).expect("text");
        assert_eq!(serde_json::from_str::<Failures>(&text).expect("the same"), one);
    }

    #[test]
    fn it_does_not_go_on_for_ever() {
        let mut all = Failures::default();
        for _ in 0..TIMES_MAX {
            all = all.and(&outputs(&["a.exr"]), "again").expect("not too often");
        }
        assert_eq!(all.and(&outputs(&["a.exr"]), "again"), None);
    }
}
