//! The program on every shipped scene by every integrator, in every mode and color, as tiny images:
//! quick enough for builds that check every overflow and assertion, which is what it is for.

mod bits;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};
use rayon::prelude::*;
use serde_json::Value;

const INTEGRATORS: [&str; 4] = ["path", "light", "bdpt", "ppm"];
const MODES: [&str; 3] = ["scalar", "intensity", "polarized"];
const COLORS: [&str; 2] = ["rgb", "mono"];

/// Scenes that an integrator finds the light of by chance only, and hardly in so few samples.
const MAY_BE_BLACK: [(&str, &str); 1] = [("caustic_glass", "path")];

/// What is rendered how.
#[derive(Clone, Debug)]
struct Job {
    /// The scene's path below `scenes`, without its extension.
    scene: String,
    integrator: &'static str,
    mode: &'static str,
    color: &'static str,
}

/// What it came to.
struct Outcome {
    /// Names and values of the image's channels.
    channels: Vec<(String, Vec<f32>)>,
    /// Rays for closest hits, and for visibility.
    rays: [u64; 2],
}

/// Where the renders of this process keep tables of particles for each other.
fn cache() -> PathBuf {
    let name = format!("small-tables-{}", std::process::id());
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// The scenes of a folder below `scenes`.
fn scenes_in(folder: &str) -> Vec<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(folder);
    let files = fs::read_dir(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let names = files.map(|file| file.unwrap().file_name().to_string_lossy().into_owned());
    let scenes = names.filter_map(|name| name.strip_suffix(".gltf").map(|s| folder.to_owned() + s));
    let mut scenes: Vec<String> = scenes.collect();
    scenes.sort();
    assert!(!scenes.is_empty(), "no scenes in {}", path.display());
    scenes
}

/// Each scene by each integrator in each mode and color.
fn jobs(scenes: &[String]) -> Vec<Job> {
    let mut jobs = Vec::new();
    for scene in scenes {
        for integrator in INTEGRATORS {
            for mode in MODES {
                let of_color = |color| Job { scene: scene.clone(), integrator, mode, color };
                jobs.extend(COLORS.map(of_color));
            }
        }
    }
    jobs
}

impl Job {
    /// Renders on one thread.
    fn run(&self, options: &[&str]) -> Outcome {
        let name = format!("{}-{}-{}-{}", self.scene, self.integrator, self.mode, self.color);
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("small");
        let digest = bits::hash(options.concat().bytes());
        let image = folder.join(format!("{}-{digest:016x}.exr", name.replace('/', "-")));
        fs::create_dir_all(&folder).unwrap();
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
        let output = Command::new(env!("CARGO_BIN_EXE_sunstone"))
            .arg("render")
            .arg(scenes.join(format!("{}.gltf", self.scene)))
            .arg("-o")
            .arg(&image)
            .args(["--integrator", self.integrator, "--mode", self.mode, "--color", self.color])
            .args(["--threads", "1", "--stats", "json", "--quiet"])
            .args(options)
            .env("SUNSTONE_CACHE", cache())
            .output()
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{name}: {errors}");

        let statistics: Value = serde_json::from_slice(&output.stdout).unwrap();
        let rays = ["rays_closest", "rays_visibility"].map(|key| statistics[key].as_u64().unwrap());
        let read = read_first_flat_layer_from_file(&image).unwrap();
        let channels = read.layer_data.channel_data.list.into_iter().map(|channel| {
            let FlatSamples::F32(values) = channel.sample_data else { panic!("{name}: not f32") };
            (channel.name.to_string(), values)
        });
        let channels = channels.collect();
        fs::remove_file(&image).unwrap();
        Outcome { channels, rays }
    }
}

/// What is wrong with an image of so many pixels.
fn fault_of(job: &Job, image: &Outcome, pixels: usize) -> Option<String> {
    let values = || image.channels.iter().flat_map(|(_, values)| values);
    let sum: f32 = values().map(|value| value.abs()).sum();
    let may_be_black = MAY_BE_BLACK.contains(&(&job.scene, job.integrator));
    if image.channels.iter().any(|(_, values)| values.len() != pixels) {
        Some(format!("a channel has not {pixels} values"))
    } else if values().any(|value| !value.is_finite()) {
        Some("a value is not finite".to_owned())
    } else if sum == 0.0 && !may_be_black {
        Some("it is black".to_owned())
    } else {
        image.rays.contains(&0).then(|| format!("it took {:?} rays", image.rays))
    }
}

#[test]
fn every_scene_shows_light_and_nothing_but_numbers() {
    let size = ["--width", "16", "--height", "12", "--spp", "2"];
    let depth = ["--max-path-length", "8", "--roulette-after", "3"];
    let photons = ["--photons", "1000", "--samples-per-iteration", "2"];
    let faults = jobs(&scenes_in("")).into_par_iter().filter_map(|job| {
        let photons = if job.integrator == "ppm" { &photons[..] } else { &[] };
        let image = job.run(&[&size[..], &depth, photons].concat());
        fault_of(&job, &image, 16 * 12).map(|fault| format!("{job:?}: {fault}"))
    });
    let faults: Vec<String> = faults.collect();
    fs::remove_dir_all(cache()).unwrap();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
