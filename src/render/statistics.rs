//! What a render took: for `--stats json` and for the closing lines on the terminal.

use std::fmt;

use serde::Serialize;

use super::system::memory_of_process;
use crate::math::text::counted;

/// The account of one render.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RenderStatistics {
    /// The scene as it was named.
    pub scene: String,
    /// The integrator's name.
    pub integrator: String,
    /// `scalar` or `polarized`.
    pub mode: String,
    /// What the channels stand for, in words.
    pub color: String,
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Samples a pixel.
    pub iterations: u64,
    /// Worker threads.
    pub threads: usize,
    /// Wall clock seconds of the render, without loading and saving.
    pub seconds: f64,
    /// Seconds of all cores together, where the system tells.
    pub cpu_seconds: Option<f64>,
    /// Pixel samples per wall clock second.
    pub samples_per_second: f64,
    /// Rays traced to the closest hit.
    pub rays_closest: u64,
    /// Rays traced for visibility alone.
    pub rays_visibility: u64,
    /// Radii of the last kernels of photons, in scene units: on surfaces, then in the media;
    /// none where there would be too few photons, and paths go on instead.
    pub radii: Vec<Option<f32>>,
    /// Seconds per stage, in the order of the schedule.
    pub stages: Vec<(String, f64)>,
    /// Largest resident memory of the process in bytes, where the system tells.
    pub peak_memory_bytes: Option<u64>,
}

impl RenderStatistics {
    /// Fills `samples_per_second` from size, iterations and seconds.
    pub fn count_samples(&mut self) {
        let samples = self.width as f64 * self.height as f64 * self.iterations as f64;
        self.samples_per_second = if self.seconds > 0.0 { samples / self.seconds } else { 0.0 };
    }
}

/// What every pixel has of samples, for [`counted`]: of one, and of several.
pub const SAMPLES: [&str; 2] = ["sample a pixel", "samples a pixel"];

/// The largest resident memory of this process so far, in bytes, where the system tells.
pub fn peak_memory_bytes() -> Option<u64> {
    memory_of_process("VmHWM:")
}

impl fmt::Display for RenderStatistics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { scene, integrator, mode, color, width, height, iterations, threads, .. } = self;
        writeln!(f, "{scene}: {integrator}, {mode}, {color}, {width} x {height}")?;
        let samples = counted(*iterations as usize, SAMPLES);
        let threads = counted(*threads, ["thread", "threads"]);
        write!(f, "{samples} in {:.2} s on {threads}", self.seconds)?;
        if let Some(cpu_seconds) = self.cpu_seconds {
            write!(f, " ({cpu_seconds:.2} s of CPU time)")?;
        }
        let rays = (self.rays_closest + self.rays_visibility) as f64;
        let rays_per_second = if self.seconds > 0.0 { rays / self.seconds } else { 0.0 };
        write!(
            f,
            "\n{}samples/s, {}rays/s: {}rays to the closest hit, {}rays for visibility",
            scaled(self.samples_per_second),
            scaled(rays_per_second),
            scaled(self.rays_closest as f64),
            scaled(self.rays_visibility as f64),
        )?;
        if let [on_surfaces, in_media @ ..] = &self.radii[..] {
            let kernel = |radius: &Option<f32>| match radius {
                Some(radius) => format!("have a radius of {radius:.4e} in the end"),
                None => "would hold hardly any, so paths go on instead".to_owned(),
            };
            write!(f, "\nkernels of photons {}", kernel(on_surfaces))?;
            in_media
                .iter()
                .try_for_each(|radius| write!(f, "; in a medium they {}", kernel(radius)))?;
        }
        if let Some(bytes) = self.peak_memory_bytes {
            write!(f, "\n{:.1} MiB of memory at most", bytes as f64 / (1 << 20) as f64)?;
        }
        let total: f64 = self.stages.iter().map(|(_, seconds)| seconds).sum();
        for (name, seconds) in &self.stages {
            let share = if total > 0.0 { 100.0 * seconds / total } else { 0.0 };
            write!(f, "\n  {name:<28} {seconds:>9.3} s {share:>5.1}%")?;
        }
        Ok(())
    }
}

/// Three digits with the prefix of the unit that follows.
fn scaled(value: f64) -> String {
    let prefixes = [(1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, "")];
    let (size, prefix) = prefixes.into_iter().find(|(size, _)| value >= *size).unwrap_or((1.0, ""));
    format!("{:.2} {prefix}", value / size)
}
