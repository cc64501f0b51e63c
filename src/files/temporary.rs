//! Temporary files: named after the process that writes them, so that those of the dead are found
//! and removed by whoever writes into the folder next.

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{LazyLock, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// What the names of all temporary files begin with.
const PREFIX: &str = ".sunstone-";
/// What they end with.
const SUFFIX: &str = ".tmp";

/// Creates an empty file that nobody else has. Its name is short and its own, so that it fits
/// wherever the target's name does.
pub fn create(folder: &Path) -> io::Result<(File, PathBuf)> {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    remove_dead(folder);
    loop {
        let number = COUNTER.fetch_add(1, Ordering::Relaxed);
        let path = folder.join(name(std::process::id(), number));
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(file) => return Ok((file, path)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
}

/// Whether a file is called as temporary files are, of whichever machine.
pub fn is_name(name: &str) -> bool {
    name.starts_with(PREFIX) && name.ends_with(SUFFIX)
}

fn name(process: u32, number: u64) -> String {
    format!("{PREFIX}{}-{process}-{number}{SUFFIX}", *PLACE)
}

/// Time between two looks at a folder.
const INTERVAL: Duration = Duration::from_secs(10);
/// Most folders of which it is known when that was.
const FOLDERS_MAX: usize = 1000;

/// Removes the temporary files of processes that were ended as they wrote, unless that has just
/// been done: a folder may hold a hundred thousand images. Whatever cannot be listed or removed
/// stays.
fn remove_dead(folder: &Path) {
    static LATEST: Mutex<BTreeMap<PathBuf, Instant>> = Mutex::new(BTreeMap::new());
    let mut latest = LATEST.lock().unwrap_or_else(PoisonError::into_inner);
    if latest.get(folder).is_some_and(|latest| latest.elapsed() < INTERVAL) {
        return;
    }
    if latest.len() == FOLDERS_MAX {
        latest.clear();
    }
    latest.insert(folder.to_owned(), Instant::now());
    drop(latest);
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let writer = entry.file_name().to_str().and_then(process_of);
        if writer.is_some_and(is_dead) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// The process that a name is of, if it is one of this machine's.
fn process_of(name: &str) -> Option<u32> {
    let rest = name.strip_prefix(PREFIX)?.strip_suffix(SUFFIX)?;
    let (process, number) = rest.strip_prefix(&**PLACE)?.strip_prefix('-')?.split_once('-')?;
    number.parse::<u64>().ok()?;
    process.parse().ok()
}

/// Where the numbers of processes mean what they mean here: the machine and, in containers, the
/// name space. A folder may be shared with others.
static PLACE: LazyLock<String> = LazyLock::new(|| {
    let host = host().unwrap_or_default();
    let letters = host.chars().filter(char::is_ascii_alphanumeric).take(24);
    let space = fs::read_link("/proc/self/ns/pid").unwrap_or_default();
    let digits = space.to_string_lossy().into_owned();
    letters.chain(digits.chars().filter(char::is_ascii_digit)).collect()
});

#[cfg(any(target_os = "linux", target_vendor = "apple"))]
fn host() -> Option<String> {
    Some(rustix::system::uname().nodename().to_string_lossy().into_owned())
}

#[cfg(not(any(target_os = "linux", target_vendor = "apple")))]
fn host() -> Option<String> {
    None
}

/// Whether there is certainly no such process any more.
#[cfg(any(target_os = "linux", target_vendor = "apple"))]
fn is_dead(process: u32) -> bool {
    let process = i32::try_from(process).ok().and_then(rustix::process::Pid::from_raw);
    process.is_some_and(|process| {
        rustix::process::test_kill_process(process) == Err(rustix::io::Errno::SRCH)
    })
}

/// Nothing tells.
#[cfg(not(any(target_os = "linux", target_vendor = "apple")))]
fn is_dead(_: u32) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_of_this_machine_are_read() {
        assert_eq!(process_of(&name(1234, 5)), Some(1234));
        for other in [".sunstone-1234-5.tmp", ".sunstone-elsewhere-1234-5.tmp", "a.exr", ".tmp"] {
            assert_eq!(process_of(other), None, "{other}");
        }
        assert!(is_name(".sunstone-elsewhere-1234-5.tmp") && !is_name("a.tmp"));
        assert!(!is_dead(std::process::id()) && !is_dead(0));
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn what_the_dead_leave_is_removed() {
        let folder = std::env::temp_dir().join(format!("sunstone-dead-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let mut child = std::process::Command::new("true").spawn().unwrap();
        child.wait().unwrap();
        let alive = name(1, 0);
        let names = [name(child.id(), 7), alive.clone(), ".sunstone-elsewhere-99-0.tmp".to_owned()];
        names.iter().for_each(|name| fs::write(folder.join(name), "half").unwrap());
        let (_, own) = create(&folder).unwrap();
        assert!(own.exists());
        let left = names.each_ref().map(|name| folder.join(name).exists());
        fs::remove_dir_all(&folder).unwrap();
        assert_eq!(left, [false, true, true]);
    }
}
