//! Whole renders of the reference scenes, one thread: every integrator in both modes.

use std::ops::ControlFlow;
use std::path::Path;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Mode, Options, PlacedWorld, Renderer, Settings};
use sunstone::internals::scene::load;

const EDGE: u32 = 128;
const ITERATIONS: u32 = 4;

fn renders(criterion: &mut Criterion) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
    for name in ["cornell", "mirror"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/reference");
        let world = load(&folder.join(name).with_extension("gltf")).expect("a shipped scene");
        let world = PlacedWorld::new(world).expect("a shipped scene");
        let mut group = criterion.benchmark_group(format!("render/{name}/rgb"));
        group.sample_size(10);
        group.throughput(Throughput::Elements(u64::from(EDGE * EDGE * ITERATIONS)));
        for integrator in [Integrator::Path, Integrator::Light, Integrator::Bdpt] {
            for mode in [Mode::Scalar, Mode::Polarized] {
                let settings = Settings::new(Options {
                    integrator: Some(integrator),
                    mode,
                    width: Some(EDGE),
                    height: Some(EDGE),
                    samples: ITERATIONS,
                    path_length_max: 12,
                    roulette_after: Some(100),
                    ..Options::default()
                });
                let settings = settings.expect("sound options");
                let id = BenchmarkId::new(format!("{integrator:?}"), format!("{mode:?}"));
                group.bench_with_input(id, &settings, |bench, settings| {
                    bench.iter(|| {
                        let mut renderer =
                            Renderer::new(&world, settings).expect("a shipped scene");
                        pool.install(|| renderer.run(|_| ControlFlow::Continue(())));
                    });
                });
            }
        }
        group.finish();
    }
}

criterion_group!(benches, renders);
criterion_main!(benches);
