//! The paper's Table 1.

use super::clock::{compare_modes, machine};
use super::{MeasureError, Subject, Watch, color_in_words};
use crate::bench::table1::{Conditions, SceneReport, Table1};
use crate::render::threads::Threads;
use crate::render::{Mode, Options, Settings};
use crate::transport::Sampling;

/// Measures each scene in `iterations` of these settings, polarized, and as many scalar.
pub fn table1(
    subjects: &[Subject],
    options: &Options,
    iterations: u32,
    threads: &Threads,
    watch: &impl Watch,
) -> Result<Table1, MeasureError> {
    // Of the same paths, as the paper's.
    let sampling = Sampling::Intensity;
    let options = &Options { sampling, stage_times: true, ..options.clone() };
    let polarized = Settings::new(options.clone())?;
    let scalar = Settings::new(Options { mode: Mode::Scalar, ..options.clone() })?;
    let rounds = (iterations, options.samples_of_photons());
    let measured = subjects.iter().map(|subject| {
        watch.at(&subject.name);
        let modes = [&scalar, &polarized];
        let (rounds, _) = compare_modes(&subject.world, modes, rounds, threads, watch)?;
        Ok(SceneReport::new(subject.name.clone(), subject.paper, rounds))
    });
    let scenes: Vec<SceneReport> = measured.collect::<Result<_, MeasureError>>()?;
    let [width, height] = [options.width, options.height].map(|edge| edge.unwrap_or(0));
    let conditions = Conditions {
        machine: machine(threads),
        integrator: options.integrator_name().into(),
        color: color_in_words(options),
        width,
        height,
        iterations,
        photons_shot: options.photons.light_paths([width, height]),
        samples_per_iteration: options.samples_of_photons(),
        alpha: options.photons.alpha,
        path_length_max: options.path_length_max,
        roulette_after: options.roulette_after,
        seed: options.seed,
    };
    Ok(Table1::new(conditions, scenes))
}
