//! Scalar against polarized, for any scenes and integrators.

use super::clock::{compare_modes, machine};
use super::{MeasureError, Subject, Watch, color_in_words};
use crate::bench::costs::Costs;
use crate::bench::overhead::{Case, Conditions, Overhead};
use crate::render::threads::Threads;
use crate::render::{Mode, Options, Settings};
use crate::transport::Sampling;

/// How many rounds a plan takes for one scene, with those that warm up.
pub fn rounds_in_all(plan: &[Options], rounds: u32) -> u64 {
    plan.len() as u64 * (u64::from(rounds) + 1)
}

/// Measures each scene by each of the `plan`, polarized, with the samples of a round. All of the
/// plan have the same film, color and lengths of paths.
pub fn overhead(
    subjects: &[Subject],
    plan: &[Options],
    rounds: u32,
    threads: &Threads,
    watch: &impl Watch,
) -> Result<Overhead, MeasureError> {
    let mut cases = Vec::new();
    for subject in subjects {
        for options in plan {
            cases.push(case(subject, options, rounds, threads, watch)?);
        }
    }
    let options = plan.first().cloned().unwrap_or_default();
    let [width, height] = [options.width, options.height].map(|edge| edge.unwrap_or(0));
    let conditions = Conditions {
        machine: machine(threads),
        color: color_in_words(&options),
        width,
        height,
        rounds,
        path_length_max: options.path_length_max,
        roulette_after: options.roulette_after,
        seed: options.seed,
    };
    Ok(Overhead { conditions, cases })
}

fn case(
    subject: &Subject,
    options: &Options,
    rounds: u32,
    threads: &Threads,
    watch: &impl Watch,
) -> Result<Case, MeasureError> {
    let integrator = options.integrator_name();
    watch.at(&format!("{}, {integrator}", subject.name));
    // Of the same paths, so that the ratio is what polarization itself costs.
    let options = &Options { sampling: Sampling::Intensity, stage_times: true, ..options.clone() };
    let polarized = Settings::new(options.clone())?;
    let scalar = Settings::new(Options { mode: Mode::Scalar, ..options.clone() })?;
    let (modes, samples) = ([&scalar, &polarized], options.samples);
    let world = &subject.world;
    let (rounds, develop) = compare_modes(world, modes, (rounds, samples), threads, watch)?;
    let [width, height] = [options.width, options.height].map(|edge| edge.unwrap_or(0));
    let light_paths = u64::from(options.photons.light_paths([width, height]));
    let shot = light_paths * u64::from(samples / options.samples_of_photons());
    Ok(Case {
        scene: subject.label.clone(),
        integrator: integrator.into(),
        samples,
        photons_shot: options.shoots_photons().then_some(shot),
        costs: Costs::new(rounds),
        develop,
    })
}
