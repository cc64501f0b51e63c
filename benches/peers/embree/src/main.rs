//! Races Sunstone's tree against Embree 4: rays a second of one thread, interleaved, in ratios.
//!
//! ```text
//! cargo run --release --manifest-path benches/peers/embree/Cargo.toml -- libembree4.so
//! ```

mod embree;
mod random;
mod rays;
mod report;
mod scenes;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use sunstone::internals::geometry::{
    Accelerator, HitColumns, TraceScratch, trace_closest, trace_visibility,
};
use sunstone::internals::math::LANES;
use sunstone::internals::transport::chunk::ROWS;

use embree::{Embree, Hit, INVALID, Ray, RayHit, RayHit16};
use rays::Set;
use report::{Built, Raced, Report};
use scenes::Scene;

/// Races Sunstone's ray tracing against Embree 4.
#[derive(Parser)]
struct Arguments {
    /// The shared library of Embree 4; the wheel `embreex` from PyPI carries one.
    library: PathBuf,
    /// Rounds, of which medians are taken.
    #[arg(long, default_value_t = 9)]
    rounds: usize,
    /// Only these scenes: cornell, bunny, room, landscape.
    #[arg(long)]
    scene: Vec<String>,
    /// Threads that build trees; rays are traced by one.
    #[arg(long, default_value_t = 2)]
    threads: usize,
    /// Prints JSON.
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    match race(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn race(arguments: &Arguments) -> Result<(), String> {
    let mut report = Report::default();
    let wanted = |scene: &Scene| {
        arguments.scene.is_empty() || arguments.scene.iter().any(|name| name == scene.name)
    };
    for scene in scenes::all()?.iter().filter(|scene| wanted(scene)) {
        let start = Instant::now();
        let tree = Accelerator::build(&scene.triangles, &[]);
        let seconds = start.elapsed().as_secs_f64();
        let mut peer = Embree::new(&arguments.library, &scene.triangles, arguments.threads)?;
        report.built.push(Built {
            scene: scene.name,
            triangles: scene.triangles.len(),
            seconds: [seconds, peer.build_seconds],
            bytes: tree.statistics().bytes + size_of_val(scene.triangles.as_slice()),
        });
        for set in rays::sets(scene, &tree) {
            if set.name == "camera" {
                report.raced.push(coherent(scene, &set, &tree, &mut peer, arguments.rounds));
            }
            report.raced.push(single(scene, &set, &tree, &mut peer, arguments.rounds));
        }
    }
    if arguments.json {
        println!("{:#}", report.to_json());
    } else {
        println!("{report}");
    }
    Ok(())
}

/// One ray at a time for Embree, chunks as the renderer has them for Sunstone.
fn single(scene: &Scene, set: &Set, tree: &Accelerator, peer: &mut Embree, rounds: usize) -> Raced {
    let scratch = &mut TraceScratch::default();
    if set.far.is_empty() {
        let mut results = [HitColumns::new(set.count), HitColumns::new(set.count)];
        let nanoseconds = interleave(rounds, set.count, &mut results, |who, hits| match who {
            0 => in_chunks(set.count, |rows| trace_closest(hits, scratch, &set.rays, rows, tree)),
            _ => intersect(hits, set, peer),
        });
        let differing = differing(&results, set.count);
        return Raced { scene: scene.name, set: set.name, nanoseconds, differing };
    }
    let mut results = [vec![0; set.count + LANES], vec![0; set.count + LANES]];
    let nanoseconds = interleave(rounds, set.count, &mut results, |who, blocked| match who {
        0 => in_chunks(set.count, |rows| {
            trace_visibility(blocked, scratch, &set.rays, &set.far, rows, tree);
        }),
        _ => occlude(blocked, set, peer),
    });
    let [ours, theirs] = &results;
    let differing = ours.iter().zip(theirs).take(set.count).filter(|(a, b)| a != b).count();
    Raced { scene: scene.name, set: set.name, nanoseconds, differing }
}

/// Sixteen camera rays at a time for Embree, told that they are coherent.
fn coherent(
    scene: &Scene,
    set: &Set,
    tree: &Accelerator,
    peer: &mut Embree,
    rounds: usize,
) -> Raced {
    let scratch = &mut TraceScratch::default();
    let mut results = [HitColumns::new(set.count), HitColumns::new(set.count)];
    let nanoseconds = interleave(rounds, set.count, &mut results, |who, hits| match who {
        0 => in_chunks(set.count, |rows| trace_closest(hits, scratch, &set.rays, rows, tree)),
        _ => intersect_coherent(hits, set, peer),
    });
    let differing = differing(&results, set.count);
    Raced { scene: scene.name, set: "coherent camera", nanoseconds, differing }
}

/// Nanoseconds per ray of both in every round; one round first warms up, and every other round
/// begins with the other.
fn interleave<T>(
    rounds: usize,
    count: usize,
    results: &mut [T; 2],
    mut trace: impl FnMut(usize, &mut T),
) -> Vec<[f64; 2]> {
    let mut nanoseconds = vec![[0.0; 2]; rounds + 1];
    for (round, of_round) in nanoseconds.iter_mut().enumerate() {
        for who in [round % 2, 1 - round % 2] {
            let start = Instant::now();
            trace(who, &mut results[who]);
            of_round[who] = start.elapsed().as_secs_f64() * 1e9 / count as f64;
        }
    }
    nanoseconds.split_off(1)
}

fn in_chunks(count: usize, mut trace: impl FnMut(std::ops::Range<usize>)) {
    for first in (0..count).step_by(ROWS) {
        trace(first..(first + ROWS).min(count));
    }
}

fn differing([ours, theirs]: &[HitColumns; 2], count: usize) -> usize {
    let same = |row: usize| {
        let near = (ours.t[row] - theirs.t[row]).abs() <= 1e-3 * theirs.t[row];
        ours.primitive[row] == theirs.primitive[row] || near
    };
    (0..count).filter(|row| !same(*row)).count()
}

fn ray(set: &Set, row: usize) -> Ray {
    Ray {
        origin: std::array::from_fn(|axis| set.rays.origin[axis][row]),
        near: 0.0,
        direction: std::array::from_fn(|axis| set.rays.direction[axis][row]),
        time: 0.0,
        far: set.far.get(row).copied().unwrap_or(f32::INFINITY),
        mask: u32::MAX,
        id: 0,
        flags: 0,
    }
}

fn intersect(hits: &mut HitColumns, set: &Set, peer: &mut Embree) {
    for row in 0..set.count {
        let hit = Hit {
            normal: [0.0; 3],
            u: 0.0,
            v: 0.0,
            primitive: INVALID,
            geometry: INVALID,
            instances: [INVALID; 5],
        };
        let mut query = RayHit { ray: ray(set, row), hit };
        peer.intersect(&mut query);
        hits.t[row] = query.ray.far;
        hits.u[row] = query.hit.u;
        hits.v[row] = query.hit.v;
        hits.primitive[row] = query.hit.primitive;
    }
}

fn occlude(blocked: &mut [u32], set: &Set, peer: &mut Embree) {
    for (row, blocked) in blocked.iter_mut().enumerate().take(set.count) {
        let mut query = ray(set, row);
        peer.occluded(&mut query);
        *blocked = if query.far < 0.0 { u32::MAX } else { 0 };
    }
}

fn intersect_coherent(hits: &mut HitColumns, set: &Set, peer: &mut Embree) {
    let sixteen = |column: &[f32], first: usize| std::array::from_fn(|lane| column[first + lane]);
    for first in (0..set.count).step_by(16) {
        let mut query = RayHit16 {
            origin: std::array::from_fn(|axis| sixteen(&set.rays.origin[axis], first)),
            near: [0.0; 16],
            direction: std::array::from_fn(|axis| sixteen(&set.rays.direction[axis], first)),
            time: [0.0; 16],
            far: [f32::INFINITY; 16],
            mask: [u32::MAX; 16],
            id: [0; 16],
            flags: [0; 16],
            normal: [[0.0; 16]; 3],
            u: [0.0; 16],
            v: [0.0; 16],
            primitive: [INVALID; 16],
            geometry: [INVALID; 16],
            instances: [[INVALID; 16]; 3],
        };
        peer.intersect_coherent(&mut query);
        hits.t[first..first + 16].copy_from_slice(&query.far);
        hits.u[first..first + 16].copy_from_slice(&query.u);
        hits.v[first..first + 16].copy_from_slice(&query.v);
        hits.primitive[first..first + 16].copy_from_slice(&query.primitive);
    }
}
