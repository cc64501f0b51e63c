//! The leaf kernels in eight lanes, over a chunk of 1,024 rows that stays in cache: what one
//! polarizing event costs against one scalar multiplication.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use sunstone::internals::math::{F32s, LANES, U32s, Vector, lanes, warp};
use sunstone::internals::polarization::kernel::{Block, Kernel};
use sunstone::internals::polarization::{Rotation, Stokes, fresnel};
use sunstone::internals::transport::sampler::{Purpose, Stream, draw, path_seed};

const ROWS: usize = 1024;
const CHANNELS: usize = 3;

/// A column of numbers in [0.1, 0.9).
fn column(salt: u32) -> Vec<f32> {
    let seed = U32s::splat(path_seed(salt, Stream::Light, 0));
    let number = |row: u32| draw(seed, U32s::splat(row), 0, Purpose::Direction)[0].to_array()[0];
    (0..ROWS as u32).map(|row| 0.1 + 0.8 * number(row)).collect()
}

fn columns<const K: usize>(salt: u32) -> [Vec<f32>; K] {
    std::array::from_fn(|index| column(salt + index as u32))
}

/// Cosines and sines of arbitrary angles: kernels and rotations that neither amplify nor damp, so
/// that what is run through them again and again stays of order one.
fn unit_circle(salt: u32) -> [Vec<f32>; 2] {
    let angles = column(salt);
    [angles.iter().map(|angle| angle.cos()).collect(), angles.iter().map(|a| a.sin()).collect()]
}

fn blocks(group: &[Vec<f32>; 3], row: usize) -> Block<F32s> {
    let [a, c, s] = [0, 1, 2].map(|index| lanes::load(&group[index], row));
    Block { a, c, s }
}

fn coefficients() -> [[Vec<f32>; 3]; CHANNELS] {
    std::array::from_fn(|channel| {
        let [c, s] = unit_circle(100 + channel as u32);
        [vec![0.0; ROWS], c, s]
    })
}

fn load_turn([cos2, sin2]: &[Vec<f32>; 2], row: usize) -> Rotation<F32s> {
    Rotation { cos2: lanes::load(cos2, row), sin2: lanes::load(sin2, row) }
}

fn mueller(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("mueller");
    group.throughput(Throughput::Elements(ROWS as u64));
    let coefficients = coefficients();
    let turns = unit_circle(200);
    let turn = |row| load_turn(&turns, row);

    let mut beta: [Vec<f32>; CHANNELS] = columns(1);
    let one = vec![1.0; ROWS];
    group.bench_function("scalar multiply, RGB", |bench| {
        bench.iter(|| {
            for row in (0..ROWS).step_by(LANES) {
                for beta in &mut beta {
                    let value = lanes::load(beta, row) * lanes::load(&one, row);
                    lanes::store(beta, row, ROWS, value);
                }
            }
            black_box(&mut beta);
        });
    });

    let mut stokes: [[Vec<f32>; 4]; CHANNELS] = std::array::from_fn(|n| columns(10 + 4 * n as u32));
    group.bench_function("rotate and block on Stokes, RGB", |bench| {
        bench.iter(|| {
            for row in (0..ROWS).step_by(LANES) {
                let turn = turn(row);
                for (channel, stokes) in stokes.iter_mut().enumerate() {
                    let old = Stokes([0, 1, 2, 3].map(|i| lanes::load(&stokes[i], row)));
                    let Stokes(new) = blocks(&coefficients[channel], row).scatter(turn.apply(old));
                    for (column, value) in stokes.iter_mut().zip(&new) {
                        lanes::store(column, row, ROWS, *value);
                    }
                }
            }
            black_box(&mut stokes);
        });
    });

    group.finish();
}

fn matrices(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("mueller");
    group.throughput(Throughput::Elements(ROWS as u64));
    let coefficients = coefficients();
    let turns = unit_circle(200);
    let turn = |row| load_turn(&turns, row);
    let mut matrices: [[Vec<f32>; 16]; CHANNELS] =
        std::array::from_fn(|n| columns(30 + 16 * n as u32));
    group.bench_function("rotate and block on 4x4, RGB", |bench| {
        bench.iter(|| {
            for row in (0..ROWS).step_by(LANES) {
                let turn = turn(row);
                for (channel, matrix) in matrices.iter_mut().enumerate() {
                    let old = [0, 1, 2, 3]
                        .map(|i| [0, 1, 2, 3].map(|j| lanes::load(&matrix[4 * i + j], row)));
                    let block = blocks(&coefficients[channel], row);
                    let new = block.collect_columns(turn.collect_matrix(old));
                    for (column, value) in matrix.iter_mut().zip(new.as_flattened()) {
                        lanes::store(column, row, ROWS, *value);
                    }
                }
            }
            black_box(&mut matrices);
        });
    });

    group.bench_function("first event to 4x4, RGB", |bench| {
        bench.iter(|| {
            for row in (0..ROWS).step_by(LANES) {
                let turn = turn(row);
                for (channel, matrix) in matrices.iter_mut().enumerate() {
                    let new = blocks(&coefficients[channel], row).first_event(turn);
                    for (column, value) in matrix.iter_mut().zip(new.as_flattened()) {
                        lanes::store(column, row, ROWS, *value);
                    }
                }
            }
            black_box(&mut matrices);
        });
    });
    group.finish();
}

fn leaves(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("leaf");
    group.throughput(Throughput::Elements(ROWS as u64));
    let inputs: [Vec<f32>; 9] = columns(300);
    let vector = |first: usize, row: usize| {
        Vector::new(
            lanes::load(&inputs[first], row),
            lanes::load(&inputs[first + 1], row),
            lanes::load(&inputs[first + 2], row),
        )
    };
    let mut run = |name: &str, leaf: &dyn Fn(usize) -> F32s| {
        group.bench_function(name, |bench| {
            bench.iter(|| {
                let mut sum = F32s::splat(0.0);
                for row in (0..ROWS).step_by(LANES) {
                    sum += leaf(row);
                }
                black_box(sum)
            });
        });
    };
    let ior = F32s::splat(1.5);
    run("rotation between axes", &|row| {
        let turn = Rotation::between(vector(0, row), vector(3, row), vector(6, row));
        turn.cos2 + turn.sin2
    });
    run("dielectric reflectance", &|row| {
        fresnel::dielectric_reflectance(lanes::load(&inputs[0], row), ior).0
    });
    run("dielectric with kernels", &|row| {
        let interface = fresnel::dielectric(lanes::load(&inputs[0], row), ior);
        interface.reflection.a + interface.reflection.c + interface.transmission.c
    });
    run("conductor reflectance", &|row| {
        let k = lanes::load(&inputs[1], row);
        fresnel::conductor_reflectance(lanes::load(&inputs[0], row), ior, k)
    });
    run("conductor with kernel", &|row| {
        let k = lanes::load(&inputs[1], row);
        let (reflectance, block) = fresnel::conductor(lanes::load(&inputs[0], row), ior, k);
        reflectance + block.a + block.c + block.s
    });
    run("random pair", &|row| {
        let [x, y] = draw(U32s::splat(7), U32s::splat(row as u32), 3, Purpose::Direction);
        x + y
    });
    run("cosine hemisphere", &|row| {
        let u = [lanes::load(&inputs[0], row), lanes::load(&inputs[1], row)];
        warp::cosine_hemisphere(vector(3, row), u).0.x
    });
    group.finish();
}

criterion_group!(benches, mueller, matrices, leaves);
criterion_main!(benches);
