//! What the system tells about time, memory and processors, where it does.

use std::path::Path;
use std::process::{Command, Stdio};

/// Seconds that all threads of this process have computed so far.
pub fn cpu_seconds() -> Option<f64> {
    #[cfg(any(target_os = "linux", target_vendor = "apple"))]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        Some(time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9)
    }
    #[cfg(not(any(target_os = "linux", target_vendor = "apple")))]
    None
}

/// Bytes of memory that can still be taken without swapping: what the machine has left, or what
/// the limit of the control group leaves if that is less.
pub fn available_memory() -> Option<u64> {
    let machine = meminfo(&std::fs::read_to_string("/proc/meminfo").ok()?)?;
    let number = |name: &str| -> Option<u64> {
        let text = std::fs::read_to_string(format!("/sys/fs/cgroup/{name}")).ok()?;
        text.trim().parse().ok()
    };
    let group = number("memory.max")
        .map(|limit| limit.saturating_sub(number("memory.current").unwrap_or(0)));
    Some(group.map_or(machine, |group| machine.min(group)))
}

fn meminfo(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
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
        assert_eq!(meminfo(text), Some(8192));
        assert_eq!(meminfo("MemTotal:  16 kB\n"), None);
    }

    #[test]
    fn computing_takes_time() {
        let Some(start) = cpu_seconds() else { return };
        let sum = (0..1_000_000_u64).fold(0, |sum: u64, i| std::hint::black_box(sum ^ i));
        assert!(cpu_seconds().expect("known a moment ago") > start, "{sum}");
    }
}
