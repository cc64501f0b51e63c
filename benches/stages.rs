//! The stages of a sensor path's first bounce, one chunk of the polarized Cornell box at a time,
//! scalar against polarized.

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use sunstone::internals::geometry::{
    HitColumns, SurfaceColumns, TraceScratch, resolve_surfaces, trace_closest,
};
use sunstone::internals::scattering::{Scene, Side};
use sunstone::internals::scene::{bake, load};
use sunstone::internals::spectrum::Carried;
use sunstone::internals::transport::chunk::{ROWS, Sequence};
use sunstone::internals::transport::stages::advance_paths::advance_paths;
use sunstone::internals::transport::stages::collect_sensor::collect_sensor;
use sunstone::internals::transport::stages::connect_to_emitters::connect_to_emitters;
use sunstone::internals::transport::stages::generate_sensor_paths::generate_sensor_paths;
use sunstone::internals::transport::stages::partition_paths::partition_paths;
use sunstone::internals::transport::stages::scatter_surfaces::scatter_surfaces;
use sunstone::internals::transport::stages::trace_connections::trace_connections;
use sunstone::internals::transport::tables::connections::ConnectionTable;
use sunstone::internals::transport::tables::kernels::DepartureColumns;
use sunstone::internals::transport::tables::partition::Partition;
use sunstone::internals::transport::tables::paths::PathTable;
use sunstone::internals::transport::{
    Arrived, Bounce, Chunk, LightModel, Polarized, Sampling, Scalar, Strategy,
};

const N: usize = 3;

/// A tile in the middle of a 64x64 film, where both spheres are seen.
const CHUNK: Chunk = Chunk {
    x: 24,
    y: 32,
    width: 16,
    height: 16,
    first_iteration: 0,
    iterations: 4,
    seed: 0,
    path_length_max: 12,
    roulette_after: [100; 2],
    sampling: Sampling::Stokes,
    is_seen: true,
    sequence: Sequence::PerPath,
};

fn cornell() -> Scene<N> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/reference/cornell.gltf");
    let world = load(&file).expect("a shipped scene");
    Scene::new(bake(&world, &Carried::RGB).expect("a shipped scene"), 64, 64)
}

fn scatter<M: LightModel<N>>(
    departures: &mut DepartureColumns<N>,
    paths: &mut PathTable<N, M::Sensor>,
    surfaces: &SurfaceColumns,
    scene: &Scene<N>,
    partition: &Partition,
) {
    let at = scene.into();
    let bounce = Bounce { path_length: 1, side: Side::Sensor, sampling: Sampling::Stokes };
    if M::POLARIZED {
        scatter_surfaces::<N, true, _>(departures, paths, surfaces, at, partition, bounce);
    } else {
        scatter_surfaces::<N, false, _>(departures, paths, surfaces, at, partition, bounce);
    }
}

fn bounce<M: LightModel<N>>(criterion: &mut Criterion, mode: &str) {
    let scene = cornell();
    let mut paths = PathTable::<N, M::Sensor>::new(ROWS, (false, true));
    let mut sorted = PathTable::<N, M::Sensor>::new(ROWS, (false, true));
    let mut scratch = TraceScratch::default();
    let (mut hits, mut sorted_hits) = (HitColumns::new(ROWS), HitColumns::new(ROWS));
    paths.odds.fill(1.0);
    let mut partition = Partition::default();
    let mut surfaces = SurfaceColumns::new(ROWS);
    let mut connections = ConnectionTable::new(ROWS);
    let mut departures = DepartureColumns::new(ROWS);
    let rows = CHUNK.slots();
    let mut group = criterion.benchmark_group(format!("stage/{mode}"));
    group.throughput(Throughput::Elements(rows as u64));

    group.bench_function("generate_sensor_paths", |bench| {
        bench.iter(|| generate_sensor_paths(&mut paths, &CHUNK, &scene, 0.0, 4));
    });
    group.bench_function("trace_closest", |bench| {
        bench.iter(|| {
            trace_closest(&mut hits, &mut scratch, &paths.rays, 0..rows, &scene.accelerator);
        });
    });
    group.bench_function("partition_paths", |bench| {
        bench.iter(|| {
            partition_paths(&mut sorted, &mut sorted_hits, &mut partition, &paths, &hits, &scene);
        });
    });
    let live = sorted.len;
    group.bench_function("resolve_surfaces", |bench| {
        bench.iter(|| {
            let rays = &sorted.rays;
            resolve_surfaces(&mut surfaces, &sorted_hits, rays, 0..live, &scene.shapes);
        });
    });
    let (event, diffuse) = partition.connectable().next().expect("walls are diffuse");
    group.bench_function("connect_to_emitters", |bench| {
        bench.iter(|| {
            let (paths, surfaces, rows) = (&sorted, &surfaces, diffuse.clone());
            let arrived = Arrived { paths, surfaces, event, rows, path_length: 1 };
            let at = (&scene).into();
            connect_to_emitters(&mut connections, &arrived, at, Strategy::Unidirectional);
        });
    });
    group.bench_function("trace_connections", |bench| {
        bench.iter(|| trace_connections(&mut connections, &mut scratch, &scene));
    });
    group.bench_function("scatter_surfaces", |bench| {
        bench.iter(|| {
            scatter::<M>(&mut departures, &mut sorted, &surfaces, &scene, &partition);
        });
    });
    group.bench_function("collect_sensor", |bench| {
        bench.iter(|| {
            let directions = &sorted.rays.direction;
            let up = scene.sensor.up();
            collect_sensor(&mut sorted.carriers, &departures.kernels, directions, up, &partition);
            black_box(&mut sorted.carriers);
        });
    });
    group.bench_function("advance_paths", |bench| {
        bench.iter(|| advance_paths(&mut sorted, &departures.direction, &surfaces, &scene));
    });
    group.finish();
}

fn stages(criterion: &mut Criterion) {
    bounce::<Scalar>(criterion, "scalar");
    bounce::<Polarized>(criterion, "polarized");
}

criterion_group!(benches, stages);
criterion_main!(benches);
