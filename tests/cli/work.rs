//! Work is not lost: a render that is asked to end, or cannot write where it should, leaves its
//! image.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use sunstone::internals::image;

use crate::program::{folder, names_in, scene, sunstone};

/// Longest that anything here takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// A render without end, when it has begun to listen to signals.
struct Endless(Child);

impl Endless {
    fn start(folder: &Path, script: &str, options: &[&str]) -> Self {
        let mut command = Command::new("sh");
        command.args(["-c", &format!("{script} exec \"$0\" \"$@\"")]);
        command.args([env!("CARGO_BIN_EXE_sunstone"), "render", &scene("cornell"), "-q"]);
        command.args(["-o", "out.exr", "--spp", "100000000"]).args(options);
        let child = command.current_dir(folder).stderr(Stdio::piped()).spawn().unwrap();
        let endless = Self(child);
        endless.wait_for(|status| catches(status, 15));
        endless
    }

    /// Waits until something can be read from its status.
    fn wait_for(&self, is_so: impl Fn(&str) -> bool) {
        let path = format!("/proc/{}/status", self.0.id());
        let start = Instant::now();
        while !is_so(&fs::read_to_string(&path).unwrap()) {
            assert!(start.elapsed() < PATIENCE, "it never listens");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn send(&self, signal: &str) {
        let mut kill = Command::new("kill");
        let sent = kill.args(["-s", signal, &self.0.id().to_string()]).status().unwrap();
        assert!(sent.success());
    }

    /// Exit code and standard error.
    fn end(self) -> (i32, String) {
        let output = self.0.wait_with_output().unwrap();
        (output.status.code().unwrap_or(-1), String::from_utf8(output.stderr).unwrap())
    }
}

fn catches(status: &str, signal: u32) -> bool {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
    u64::from_str_radix(mask.trim(), 16).unwrap() >> (signal - 1) & 1 == 1
}

#[test]
#[cfg(target_os = "linux")]
fn a_signal_ends_a_render_with_its_image() {
    for (signal, code) in [("INT", 130), ("TERM", 143), ("HUP", 129)] {
        let here = folder(&format!("work-{signal}"));
        // As scripts start what runs in their background.
        let render = Endless::start(&here, "trap '' INT;", &["--width", "16"]);
        render.send(signal);
        let (found, stderr) = render.end();
        assert_eq!(found, code, "{stderr}");
        assert!(stderr.contains(&format!("SIG{signal}")) && stderr.contains("out.exr"), "{stderr}");
        let image = image::load(&here.join("out.exr")).unwrap();
        let value = |key: &str| image.metadata.iter().find(|(name, _)| name == key).unwrap();
        assert_eq!(value("interrupted").1, format!("SIG{signal}"));
        assert!(value("iterations").1.parse::<u32>().unwrap() > 0);
        assert!(value("integrator").1 == "bdpt" && value("command").1.contains("--spp"));
        assert_eq!(names_in(&here), ["out.exr"]);
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_second_signal_ends_it_at_once() {
    let here = folder("work-twice");
    let render = Endless::start(&here, "", &["--width", "2000"]);
    render.send("TERM");
    render.send("INT");
    let start = Instant::now();
    let (code, stderr) = render.end();
    assert!([130, 143].contains(&code), "{code}: {stderr}");
    assert!(start.elapsed() < PATIENCE, "it takes its time");
    assert_eq!(names_in(&here), [] as [&str; 0]);
}

/// Who starts a program with `nohup` wants it to go on.
#[test]
#[cfg(target_os = "linux")]
fn a_hangup_that_is_ignored_stays_so() {
    let here = folder("work-nohup");
    let render = Endless::start(&here, "trap '' HUP;", &["--width", "16"]);
    render.wait_for(|status| !catches(status, 1));
    render.send("HUP");
    std::thread::sleep(Duration::from_millis(200));
    render.send("TERM");
    assert_eq!(render.end().0, 143);
}

/// Renders for a second into a folder with which something happens meanwhile.
fn render_while(name: &str, happens: impl FnOnce(&Path)) -> (std::path::PathBuf, i32, String) {
    let here = folder(name);
    fs::create_dir(here.join("folder")).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_sunstone"));
    command.args(["render", &scene("cornell"), "-o", "folder/out.exr", "-q", "--width", "16"]);
    command.args(["--spp", "100000000", "--time-limit", "2"]).current_dir(&here);
    let child = Endless(command.stderr(Stdio::piped()).spawn().unwrap());
    child.wait_for(|status| catches(status, 15));
    happens(&here.join("folder"));
    let (code, stderr) = child.end();
    (here, code, stderr)
}

#[test]
#[cfg(target_os = "linux")]
fn a_folder_that_is_gone_is_made_anew() {
    let (here, code, stderr) = render_while("work-gone", |folder| fs::remove_dir(folder).unwrap());
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("made anew"), "{stderr}");
    assert!(image::load(&here.join("folder/out.exr")).is_ok());
}

#[test]
#[cfg(target_os = "linux")]
fn an_image_that_cannot_be_written_goes_elsewhere() {
    let (here, code, stderr) = render_while("work-elsewhere", |folder| {
        fs::remove_dir(folder).unwrap();
        fs::write(folder, "a file").unwrap();
        fs::write(folder.with_file_name("out.exr"), "the user's").unwrap();
    });
    assert_eq!(code, 1, "{stderr}");
    assert!(stderr.contains("folder/out.exr") && stderr.contains("  it is in "), "{stderr}");
    assert!(image::load(&here.join("out-1.exr")).is_ok(), "{stderr}");
    assert_eq!(fs::read(here.join("out.exr")).unwrap(), b"the user's");
    // The folder is fine: another render does what it should.
    let options = ["render", &scene("cornell"), "-o", "b.exr", "--spp", "1", "--width", "8"];
    sunstone(&here, &options).done();
}
