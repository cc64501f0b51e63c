//! Rounds on the clock.

use std::time::Instant;

use super::{MeasureError, Watch};
use crate::bench::Machine;
use crate::bench::costs::{Cost, Measured, Round};
use crate::render::threads::Threads;
use crate::render::{PlacedWorld, Renderer, Settings, system};

/// What something took.
#[derive(Clone, Copy, Debug)]
pub struct Taken {
    /// Wall clock seconds.
    pub seconds: f64,
    /// Seconds of all cores together, where the system tells.
    pub cpu_seconds: Option<f64>,
}

/// Does something on the clock.
pub fn timed<R>(work: impl FnOnce() -> R) -> (R, Taken) {
    let (start, cpu_start) = (Instant::now(), system::cpu_seconds());
    let result = work();
    let seconds = start.elapsed().as_secs_f64();
    let cpu_seconds = system::cpu_seconds().zip(cpu_start).map(|(end, start)| end - start);
    (result, Taken { seconds, cpu_seconds })
}

/// Renders in both modes (scalar first in `settings`), `samples` per pixel of one and as many of
/// the other; every other round begins with the other mode. The first round warms up: it fills
/// tables that grow, and finds the radius of the kernels. Beside the rounds returns the seconds in
/// which the films become images.
pub fn compare_modes(
    world: &PlacedWorld,
    settings: [&Settings; 2],
    (rounds, samples): (u32, u32),
    threads: &Threads,
    watch: &impl Watch,
) -> Result<(Vec<Round>, Cost), MeasureError> {
    let [scalar, polarized] = settings.map(|settings| Renderer::new(world, settings));
    let mut renderers = [scalar?, polarized?];
    let mut measured_rounds = Vec::with_capacity(rounds as usize);
    for round in 0..=rounds {
        let first = (round % 2) as usize;
        let mut measured = [Measured::default(), Measured::default()];
        for mode in [first, 1 - first] {
            measured[mode] = advance(&mut renderers[mode], samples, threads);
        }
        if round > 0 {
            let [scalar, polarized] = measured;
            measured_rounds.push(Round { polarized_first: first == 1, scalar, polarized });
        }
        watch.round();
    }
    let [scalar, polarized] = renderers.map(|renderer| {
        let (_, taken) = timed(|| renderer.finish());
        taken.seconds
    });
    Ok((measured_rounds, Cost::new(scalar, polarized)))
}

/// Some samples and what they took.
fn advance(renderer: &mut Renderer, samples: u32, threads: &Threads) -> Measured {
    let before = renderer.profile();
    let ((), taken) = timed(|| threads.run(|| renderer.advance(samples)));
    let profiles = [&before, &renderer.profile()];
    Measured::new(taken.seconds, taken.cpu_seconds, profiles, renderer.radii())
}

/// The machine that a measurement runs on.
pub fn machine(threads: &Threads) -> Machine {
    Machine {
        version: env!("CARGO_PKG_VERSION").into(),
        processor: system::processor_model(),
        processors: processors().unwrap_or(threads.count()),
        threads: threads.count(),
    }
}

/// Processors that the program may use, where the system tells.
pub fn processors() -> Option<usize> {
    std::thread::available_parallelism().ok().map(usize::from)
}
