//! What the system tells about time, memory and processors, where it does.

use std::path::Path;
use std::process::{Command, Stdio};

/// Seconds that all threads of this process have computed so far.
pub fn cpu_seconds() -> Option<f64> {
    #[cfg(any(target_os = "linux", target_vendor = "apple"))]
    return seconds_of(rustix::time::ClockId::ProcessCPUTime);
    #[cfg(not(any(target_os = "linux", target_vendor = "apple")))]
    None
}

/// Seconds that this thread has computed so far.
pub fn thread_cpu_seconds() -> Option<f64> {
    #[cfg(any(target_os = "linux", target_vendor = "apple"))]
    return seconds_of(rustix::time::ClockId::ThreadCPUTime);
    #[cfg(not(any(target_os = "linux", target_vendor = "apple")))]
    None
}

#[cfg(any(target_os = "linux", target_vendor = "apple"))]
fn seconds_of(clock: rustix::time::ClockId) -> Option<f64> {
    let time = rustix::time::clock_gettime(clock);
    Some(time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9)
}

/// Bytes of memory that can still be taken without swapping: what the machine has left, or what
/// the limit of the control group or of the process's addresses leaves if that is less.
pub fn available_memory() -> Option<u64> {
    let machine = bytes_of(&std::fs::read_to_string("/proc/meminfo").ok()?, "MemAvailable:")?;
    let number = |name: &str| -> Option<u64> {
        let text = std::fs::read_to_string(format!("/sys/fs/cgroup/{name}")).ok()?;
        text.trim().parse().ok()
    };
    let group = number("memory.max")
        .map(|limit| limit.saturating_sub(number("memory.current").unwrap_or(0)));
    [group, available_addresses()].into_iter().flatten().chain([machine]).min()
}

/// What the limit of the process's addresses leaves (`ulimit -v`), if there is one: three quarters
/// of it, as tables and allocators take more addresses than they use.
#[cfg(target_os = "linux")]
fn available_addresses() -> Option<u64> {
    let limit = rustix::process::getrlimit(rustix::process::Resource::As).current?;
    Some(limit.saturating_sub(memory_of_process("VmSize:")?) / 4 * 3)
}

#[cfg(not(target_os = "linux"))]
fn available_addresses() -> Option<u64> {
    None
}

/// A number of bytes that the system keeps about this process, by its name there; `None` where
/// there is no `/proc/self/status`.
pub fn memory_of_process(name: &str) -> Option<u64> {
    bytes_of(&std::fs::read_to_string("/proc/self/status").ok()?, name)
}

/// The bytes that stand as kibibytes in the line that begins with a name.
fn bytes_of(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// The model of the processor.
pub fn processor_model() -> Option<String> {
    model_name(&std::fs::read_to_string("/proc/cpuinfo").ok()?)
}

fn model_name(cpuinfo: &str) -> Option<String> {
    let mut fields = cpuinfo.lines().filter_map(|line| line.split_once(':'));
    let (_, name) = fields.find(|(key, _)| key.trim() == "model name")?;
    Some(name.trim().to_owned())
}

/// The commit of the repository that a file is in, as git abbreviates it, with `-dirty` if files
/// that git knows differ from it, the file itself aside; nothing where there is no git, no
/// repository or no commit.
pub fn commit_beside(file: &Path) -> Option<String> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
    let git = |arguments: &[&str]| {
        let mut command = Command::new("git");
        command.arg("-C").arg(folder.unwrap_or(Path::new("."))).args(arguments);
        let output = command.stdin(Stdio::null()).output().ok()?;
        let text = output.status.success().then_some(output.stdout)?;
        Some(String::from_utf8_lossy(&text).trim().to_owned())
    };
    let commit = git(&["rev-parse", "--short", "HEAD"])?;
    let itself = format!(":(exclude,literal){}", file.file_name()?.to_string_lossy());
    let changes = git(&["status", "--porcelain", "--untracked-files=no", "--", ":/", &itself])?;
    Some(if changes.is_empty() { commit } else { commit + "-dirty" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn processors_are_named_by_their_line() {
        let text = "processor\t: 0\nmodel\t\t: 17\nmodel name\t: A 16-Core: fast\nflags\t: x\n";
        assert_eq!(model_name(text).as_deref(), Some("A 16-Core: fast"));
        assert_eq!(model_name("Features\t: asimd\n"), None);
    }

    #[test]
    fn available_memory_is_read_from_its_line() {
        let text = "MemTotal:  16 kB\nMemFree:  1 kB\nMemAvailable:    8 kB\n";
        assert_eq!(bytes_of(text, "MemAvailable:"), Some(8192));
        assert_eq!(bytes_of("MemTotal:  16 kB\n", "MemAvailable:"), None);
    }

    #[test]
    fn computing_takes_time() {
        let Some(start) = cpu_seconds() else { return };
        let sum = (0..1_000_000_u64).fold(0, |sum: u64, i| std::hint::black_box(sum ^ i));
        assert!(cpu_seconds().expect("known a moment ago") > start, "{sum}");
    }
}
