//! Renders end when they should, with variances. The only test of its binary, so that no other has
//! the processors.

#[allow(dead_code, reason = "every test binary uses its own part")]
mod support;

use std::sync::Arc;
use std::time::{Duration, Instant};

use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Mode, Options, Photons};
use sunstone::internals::scattering::Scene;
use support::rendering::{MONO, in_package, rendered, scene, settings, world};

fn options(integrator: Integrator, samples: u32) -> Options {
    let photons = Photons { per_iteration: Some(2_000), samples: Some(1), ..Photons::default() };
    let settings = settings(integrator, Mode::Scalar, MONO, samples, 6);
    Options { photons, variance: true, ..settings }
}

fn ends_in_time(scene: &Arc<Scene<1>>, integrator: Integrator, limit: Duration) {
    let start = Instant::now();
    rendered(scene, &options(integrator, 2));
    let iteration = start.elapsed() / 2;
    let options = Options { time_limit: Some(limit), ..options(integrator, 1 << 20) };
    let start = Instant::now();
    let renderer = rendered(scene, &options);
    let taken = start.elapsed();
    assert!(taken >= limit && !renderer.is_done(), "{integrator:?}: {taken:?}");
    // An iteration, and some for other programs on the processors.
    let late = limit / 10 + 4 * iteration + Duration::from_millis(200);
    eprintln!("{integrator:?}: {taken:?} for {limit:?}, an iteration {iteration:?}");
    assert!(taken < limit + late, "{integrator:?}: {taken:?}, an iteration {iteration:?}");
    assert!(renderer.finish().variance.is_some(), "{integrator:?}");
}

/// A pass of photons that would take minutes.
fn photons_end_in_time(scene: &Arc<Scene<1>>) {
    let photons =
        Photons { per_iteration: Some(50_000_000), samples: Some(1), ..Photons::default() };
    let time_limit = Some(Duration::from_millis(300));
    let options = Options { photons, time_limit, ..options(Integrator::Ppm, 64) };
    let start = Instant::now();
    let renderer = rendered(scene, &options);
    let taken = start.elapsed();
    assert_eq!(renderer.samples(), 1, "some photons are better than none");
    assert!(taken < Duration::from_secs(6), "{taken:?}");
    assert!(renderer.finish().planes[0].iter().any(|value| *value > 0.0));
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn renders_end_in_time_and_with_variances() {
    let scene = scene::<1>(&world(&in_package("scenes/cornell.gltf")), MONO, [128, 128]);
    for &integrator in Integrator::ALL {
        ends_in_time(&scene, integrator, Duration::from_millis(700));
    }
    photons_end_in_time(&scene);
}
