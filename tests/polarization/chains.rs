//! The order of matrices, the frames and the signs, against 120 chains of events that were traced
//! elsewhere as electric fields in three dimensions, without any Stokes vector.

use sunstone::internals::math::{F32s, LANES, Real, Vector};
use sunstone::internals::polarization::{Arrival, Block, Dense, Kernel, LightCarrier};
use sunstone::internals::polarization::{SensorMatrix, SensorRow, Stokes};

use crate::traced::{self, Traced, lift, trace};
use crate::vertex::Vertex;

/// Double precision leaves a few units in the last place per event.
const TOLERANCE_F64: f64 = 1e-12;

/// Single precision: five events and five rotations, each to about 1e-7, and cosines of rounded
/// directions; relative to the chain's scalar throughput.
const TOLERANCE_F32: f64 = 1e-5;

fn scatter<F: Real>(light: LightCarrier<F>, event: &Vertex<F>) -> LightCarrier<F> {
    light.scatter(&event.arrival(light.x), event.kernel)
}

fn scatter_all<F: Real>(light: LightCarrier<F>, events: &[Vertex<F>]) -> LightCarrier<F> {
    events.iter().fold(light, scatter)
}

fn collect<F: Real, K: Kernel<F>>(
    sensor: SensorMatrix<F>,
    event: &Vertex<F, K>,
) -> SensorMatrix<F> {
    sensor.collect(&event.departure(sensor.x), event.kernel)
}

fn collect_all<F: Real>(film_x: Vector<F>, events: &[Vertex<F>]) -> SensorMatrix<F> {
    events.iter().rev().fold(SensorMatrix::identity(film_x), collect)
}

fn collect_row<F: Real>(sensor: SensorRow<F>, event: &Vertex<F>) -> SensorRow<F> {
    sensor.collect(&event.departure(sensor.x), event.kernel)
}

/// The four rows of the sensor's matrix as four films with an analyzer would carry them.
fn collect_rows<F: Real>(film_x: Vector<F>, events: &[Vertex<F>]) -> [SensorRow<F>; 4] {
    SensorMatrix::identity(film_x)
        .matrix
        .map(|row| events.iter().rev().fold(SensorRow { row, x: film_x }, collect_row))
}

/// The film's Stokes vector over the scalar throughput, with the subpaths joined at each segment
/// in turn, from matrices and from rows. The first is all sensor, the last all light.
fn split_everywhere<F: Real>(traced: &Traced<F>) -> Vec<[F; 4]> {
    let mut measured = Vec::new();
    for (join, &k) in traced.directions.iter().enumerate() {
        let (before, after) = traced.events.split_at(join);
        let light = scatter_all(traced.light, before);
        let meets = |x| Arrival::between(light.x, x, k);
        let matrix = collect_all(traced.film_x, after);
        measured.push(matrix.measure(&light, &meets(matrix.x)).0);
        let rows = collect_rows(traced.film_x, after);
        measured.push(rows.map(|row| row.measure(&light, &meets(row.x))));
    }
    measured
}

#[test]
fn every_split_of_every_chain_measures_the_field() {
    let (mut worst, mut splits) = (0.0_f64, 0);
    for chain in traced::load() {
        let traced = trace::<f64>(&chain);
        for measured in split_everywhere(&traced) {
            splits += 1;
            for (component, expected) in measured.iter().zip(chain.stokes_out) {
                let error = (traced.beta * component - expected).abs();
                assert!(error <= TOLERANCE_F64, "chain {}: error {error:e}", chain.id);
                worst = worst.max(error);
            }
        }
    }
    println!("f64: {splits} splits, largest error {worst:e}");
    assert!(splits > 800);
}

#[test]
fn directions_and_film_frames_are_those_of_the_field() {
    for chain in traced::load() {
        let traced = trace::<f64>(&chain);
        let direction = *traced.directions.last().expect("at least one segment");
        assert!((direction - lift(chain.dir_out)).length() <= TOLERANCE_F64);
        assert!((traced.film_x - lift(chain.camera_x)).length() <= TOLERANCE_F64);
    }
}

/// Eight values side by side.
fn pack(values: impl Fn(usize) -> f32) -> F32s {
    F32s::from(std::array::from_fn::<f32, LANES, _>(values))
}

fn pack_vector(vectors: impl Fn(usize) -> Vector<f32>) -> Vector<F32s> {
    Vector::gather(|lane| vectors(lane).into())
}

/// Eight chains side by side; the shorter ones end in events that change nothing.
fn pack_chains(lanes: &[Traced<f32>]) -> Traced<F32s> {
    let length = lanes.iter().map(|lane| lane.events.len()).max().expect("eight chains");
    let direction = |lane: &Traced<f32>, i: usize| lane.directions[i.min(lane.events.len())];
    let event = |lane: &Traced<f32>, i: usize| {
        let k = direction(lane, i);
        let idle = Vertex { kernel: Block::identity(), x: lane.film_x, k_in: k, k_out: k };
        lane.events.get(i).copied().unwrap_or(idle)
    };
    let packed_event = |i: usize| Vertex {
        kernel: Block {
            a: pack(|l| event(&lanes[l], i).kernel.a),
            c: pack(|l| event(&lanes[l], i).kernel.c),
            s: pack(|l| event(&lanes[l], i).kernel.s),
        },
        x: pack_vector(|l| event(&lanes[l], i).x),
        k_in: pack_vector(|l| event(&lanes[l], i).k_in),
        k_out: pack_vector(|l| event(&lanes[l], i).k_out),
    };
    Traced {
        beta: pack(|l| lanes[l].beta),
        light: LightCarrier {
            stokes: Stokes(std::array::from_fn(|j| pack(|l| lanes[l].light.stokes.0[j]))),
            x: pack_vector(|l| lanes[l].light.x),
        },
        directions: (0..=length).map(|i| pack_vector(|l| direction(&lanes[l], i))).collect(),
        events: (0..length).map(packed_event).collect(),
        film_x: pack_vector(|l| lanes[l].film_x),
    }
}

#[test]
fn eight_chains_side_by_side_measure_the_field() {
    let chains = traced::load();
    let (mut worst_absolute, mut worst_relative) = (0.0_f64, 0.0_f64);
    for group in chains.chunks_exact(LANES) {
        let lanes: Vec<Traced<f32>> = group.iter().map(trace).collect();
        let packed = pack_chains(&lanes);
        let beta = packed.beta.to_array();
        for measured in split_everywhere(&packed) {
            for (j, component) in measured.iter().enumerate() {
                let component = component.to_array();
                for (lane, chain) in group.iter().enumerate() {
                    let beta = f64::from(beta[lane]);
                    let error = (beta * f64::from(component[lane]) - chain.stokes_out[j]).abs();
                    worst_absolute = worst_absolute.max(error);
                    worst_relative = worst_relative.max(error / beta);
                }
            }
        }
    }
    println!("f32 lanes: largest error {worst_absolute:e}, over beta {worst_relative:e}");
    assert_eq!(chains.len() % LANES, 0);
    assert!(worst_absolute <= TOLERANCE_F32);
    assert!(worst_relative <= TOLERANCE_F32);
}

/// A depolarizer in the place of an event.
fn depolarizer(event: &Vertex<f64>) -> Vertex<f64, Dense<f64>> {
    let mut matrix = [[0.0; 4]; 4];
    matrix[0][0] = 1.0;
    let Vertex { x, k_in, k_out, .. } = *event;
    Vertex { kernel: Dense(matrix), x, k_in, k_out }
}

/// Replaces each event in turn by a depolarizer: a column and a row then say all that the full
/// matrix says, and so do the row and what it measures over the column's intensity.
#[test]
fn after_a_depolarizer_a_column_and_a_row_suffice() {
    for chain in traced::load() {
        let Traced { light, directions, events, film_x, .. } = trace::<f64>(&chain);
        for (middle, event) in events.iter().enumerate() {
            let first = collect_all(film_x, &events[middle + 1..]);
            let full = collect(first, &depolarizer(event));
            let full = events[..middle].iter().rev().fold(full, collect);
            let k = directions[0];
            let expected = full.measure(&light, &Arrival::between(light.x, full.x, k));

            let row = SensorRow::intensity(event.x);
            let row = events[..middle].iter().rev().fold(row, collect_row);
            let measured = row.measure(&light, &Arrival::between(light.x, row.x, k));
            let rank_one = first.depolarized().spread(measured);
            let (gain, column) = first.depolarized().normalized();
            let folded = column.spread(gain * measured);
            for ((a, b), c) in rank_one.0.iter().zip(expected.0).zip(folded.0) {
                assert!((a - b).abs() <= 1e-14 && (c - b).abs() <= 1e-14);
            }
            let scattered = scatter_all(light, &events[..middle]).depolarized();
            assert!((measured - scattered).abs() <= 1e-14);
        }
    }
}

/// Carriers that hold nothing yet need not be multiplied.
#[test]
fn first_events_have_a_shorter_form() {
    for chain in traced::load() {
        let Traced { light, events, film_x, .. } = trace::<f64>(&chain);
        let event = events.last().expect("chains have events");
        let expected = collect(SensorMatrix::identity(film_x), event);
        let short = SensorMatrix::first_event(&event.departure(film_x), event.kernel);
        for (a, b) in short.matrix.as_flattened().iter().zip(expected.matrix.as_flattened()) {
            assert!((a - b).abs() <= 1e-15);
        }
        assert_eq!(short.x, expected.x);
        let expected = collect_row(SensorRow::intensity(film_x), event);
        assert_eq!(SensorRow::first_event(event.kernel, event.x), expected);
        let expected = scatter(LightCarrier::unpolarized(light.x), event);
        assert_eq!(LightCarrier::first_event(event.kernel, event.x), expected);
    }
}
