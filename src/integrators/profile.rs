//! Where the time of a render goes, stage by stage.

use std::time::{Duration, Instant};

/// Groups of stages that are timed together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Stage {
    /// Starting paths.
    Start = 0,
    /// Closest hits.
    Trace,
    /// Free flights through media.
    Flight,
    /// Emitters met.
    Emission,
    /// Roulette, grouping, moving rows, surfaces, partial weights.
    Sort,
    /// Choosing and weighing connections, storing vertices.
    Connect,
    /// Visibility of connections.
    Visibility,
    /// Adding up open connections.
    Gather,
    /// Storing photons and sorting them into cells.
    Store,
    /// Merging vertices with the photons about them.
    Merge,
    /// New directions and kernels.
    Scatter,
    /// Mueller kernels applied to carriers.
    Mueller,
    /// Next segments.
    Advance,
    /// Adding to the film.
    Film,
}

/// Names of the stages, in their order.
pub const STAGES: [&str; 14] = [
    "start",
    "trace",
    "flight",
    "emission",
    "sort",
    "connect",
    "visibility",
    "gather",
    "store",
    "merge",
    "scatter",
    "mueller",
    "advance",
    "film",
];

/// Time per stage and rays traced.
#[derive(Clone, Debug, Default)]
pub struct Profile {
    /// Whether stages are timed.
    pub is_timed: bool,
    /// Time per stage, summed over threads.
    pub times: [Duration; STAGES.len()],
    /// Closest-hit rays.
    pub rays_closest: u64,
    /// Visibility rays.
    pub rays_visibility: u64,
    /// Photons stored.
    pub photons: u64,
    /// Samples that were left out because they are no finite numbers.
    pub not_finite: u64,
    /// What the limit of segments has cut off the paths of either side, by
    /// [`crate::scattering::Side`].
    pub cut: [Cut; 2],
}

/// Throughput of paths, summed over them; the mean over the wavelengths of each.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cut {
    /// At the start.
    pub started: f64,
    /// Of those that would have gone on at their last segment.
    pub cut: f64,
}

impl Cut {
    /// The share of the throughput that is cut off.
    pub fn share(&self) -> f64 {
        if self.started > 0.0 { self.cut / self.started } else { 0.0 }
    }
}

impl Profile {
    /// Runs `work` on the clock of `stage`.
    #[inline(always)]
    pub fn time<R>(&mut self, stage: Stage, work: impl FnOnce() -> R) -> R {
        self.time_of_threads(stage, 1, work)
    }

    /// Runs `work`, which keeps `threads` threads busy, on the clock of `stage`.
    #[inline(always)]
    pub fn time_of_threads<R>(
        &mut self,
        stage: Stage,
        threads: usize,
        work: impl FnOnce() -> R,
    ) -> R {
        let start = self.clock();
        let result = work();
        if let Some(start) = start {
            self.add_time(stage, threads, start);
        }
        result
    }

    // Out of line: stages are many.
    #[inline(never)]
    fn clock(&self) -> Option<Instant> {
        self.is_timed.then(Instant::now)
    }

    #[cold]
    #[inline(never)]
    fn add_time(&mut self, stage: Stage, threads: usize, start: Instant) {
        self.times[stage as usize] += start.elapsed() * threads as u32;
    }

    /// Adds another profile.
    pub fn add(&mut self, other: &Profile) {
        for (time, other) in self.times.iter_mut().zip(other.times) {
            *time += other;
        }
        self.rays_closest += other.rays_closest;
        self.rays_visibility += other.rays_visibility;
        self.photons += other.photons;
        self.not_finite += other.not_finite;
        for (cut, other) in self.cut.iter_mut().zip(other.cut) {
            cut.started += other.started;
            cut.cut += other.cut;
        }
    }
}
