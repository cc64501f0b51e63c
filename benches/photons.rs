//! Gathering photons: a million photons, a million queries in random order, 25 found by each, one
//! thread. [`PhotonGrid`] with its queries sorted first, against a hash grid as that of SmallVCM.
//! Both test each photon's direction and add up its power, and their sums are compared.

use std::hint::black_box;
use std::time::Instant;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use sunstone::internals::math::columns::{Channels, Column};
use sunstone::internals::math::{F32s, LANES, Vector, hash, lanes};
use sunstone::internals::transport::tables::nearest_photons::nearest_distances;
use sunstone::internals::transport::tables::photon_grid::{PhotonGrid, PhotonVisitor};
use sunstone::internals::transport::tables::photon_queries::QueryOrder;
use sunstone::internals::transport::tables::photons::{PhotonClass, PhotonTable};
use sunstone::internals::transport::tables::{channels, vectors};

const N: usize = 3;
const COUNT: usize = 1_000_000;
/// Photons that a query finds away from edges.
const FOUND: f32 = 25.0;
/// Queries of a small batch: what a chunk of a render asks at a time.
const BATCH: usize = 1024;

/// Points with normals: where photons lie and where they are asked for.
struct Points {
    position: [Column; 3],
    normal: [Column; 3],
}

fn uniform(salt: u32, row: usize, dimension: u32) -> f32 {
    let bits = hash::combine(hash::combine(salt, row as u32), dimension);
    (bits >> 8) as f32 / (1 << 24) as f32
}

/// One row of three columns.
#[inline(always)]
fn row_of(columns: &[Column; 3], row: usize) -> [f32; 3] {
    [columns[0][row], columns[1][row], columns[2][row]]
}

/// Points on the walls of the box from -1 to 1, in random order.
fn on_walls(salt: u32) -> Points {
    let mut points = Points { position: vectors(COUNT), normal: vectors(COUNT) };
    for row in 0..COUNT {
        let wall = (uniform(salt, row, 3) * 6.0) as usize;
        let side = if wall.is_multiple_of(2) { -1.0 } else { 1.0 };
        for axis in 0..3 {
            let inside = uniform(salt, row, axis as u32) * 2.0 - 1.0;
            points.position[axis][row] = if axis == wall / 2 { side } else { inside };
            points.normal[axis][row] = if axis == wall / 2 { -side } else { 0.0 };
        }
    }
    points
}

/// Points in the same box, with arbitrary normals.
fn in_volume(salt: u32) -> Points {
    let mut points = Points { position: vectors(COUNT), normal: vectors(COUNT) };
    for row in 0..COUNT {
        let normal = [3, 4, 5].map(|d| uniform(salt, row, d) - 0.5);
        let scale = 1.0 / normal.iter().map(|x| x * x).sum::<f32>().sqrt();
        for (axis, component) in normal.iter().enumerate() {
            points.position[axis][row] = uniform(salt, row, axis as u32) * 2.0 - 1.0;
            points.normal[axis][row] = component * scale;
        }
    }
    points
}

/// Photons at the points, whose light travels against the normals.
fn photons_at(points: &Points) -> PhotonTable<N> {
    let mut table = PhotonTable::of_class(PhotonClass::Power, COUNT);
    for row in (0..COUNT).step_by(LANES) {
        let number = |d: u32| F32s::from(lanes::each(|lane| uniform(99, row + lane, d)));
        let about = |d: u32| number(d) - F32s::splat(0.5);
        let around = Vector { x: about(0), y: about(1), z: about(2) }.normalize();
        let normal = Vector::load(&points.normal, row);
        let direction = (around * F32s::splat(0.999) - normal).normalize();
        let power = [number(3), number(4), number(5)];
        table.append_lanes(Vector::load(&points.position, row), direction, &power, LANES);
    }
    table
}

// ---- ours -------------------------------------------------------------------------------------

/// Sums the power of photons that arrive at the front.
struct Irradiance<'a> {
    normal: &'a [Column; 3],
    sum: &'a mut Channels<N>,
}

impl PhotonVisitor<N> for Irradiance<'_> {
    type State = (Vector<F32s>, [F32s; N]);

    #[inline(always)]
    fn begin(&mut self, query: usize) -> Self::State {
        let [x, y, z] = row_of(self.normal, query);
        let normal = Vector { x: F32s::splat(x), y: F32s::splat(y), z: F32s::splat(z) };
        (normal, [F32s::ZERO; N])
    }

    #[inline(always)]
    fn visit(
        &mut self,
        (normal, sum): &mut Self::State,
        row: usize,
        within: F32s,
        photons: &PhotonTable<N>,
    ) {
        let cosine = photons.directions_of_any_length(row).dot(*normal);
        let counts = within & cosine.simd_lt(F32s::ZERO);
        for (sum, power) in sum.iter_mut().zip(&photons.power) {
            *sum += lanes::load(power, row) & counts;
        }
    }

    #[inline(always)]
    fn finish(&mut self, query: usize, (_, sum): Self::State) {
        for (column, sum) in self.sum.iter_mut().zip(&sum) {
            column[query] = sum.reduce_add();
        }
    }
}

fn gather(
    sum: &mut Channels<N>,
    order: &mut QueryOrder,
    grid: &PhotonGrid<N>,
    queries: &Points,
    batch: usize,
) {
    for start in (0..COUNT).step_by(batch) {
        let rows = start..COUNT.min(start + batch);
        order.sort(&queries.position, rows, grid.cells());
        let mut visitor = Irradiance { normal: &queries.normal, sum };
        grid.gather(&mut visitor, order, &queries.position);
    }
}

// ---- theirs -----------------------------------------------------------------------------------

/// A photon of the comparison.
struct Particle {
    position: [f32; 3],
    direction: [f32; 3],
    power: [f32; N],
}

fn particles_of(photons: &PhotonTable<N>) -> Vec<Particle> {
    (0..photons.len)
        .map(|row| {
            let direction = photons.directions(row);
            Particle {
                position: [0, 1, 2].map(|axis| photons.position[axis][row]),
                direction: [direction.x, direction.y, direction.z].map(|x| x.to_array()[0]),
                power: [0, 1, 2].map(|n| photons.power[n][row]),
            }
        })
        .collect()
}

/// Built after the description of SmallVCM's: cells two radii wide, counted from the lower corner
/// of all particles, three primes hash a cell, one list of particle numbers in the order of the
/// cells, and a query looks through eight cells.
struct HashGrid {
    lower: [f32; 3],
    upper: [f32; 3],
    per_unit: f32,
    radius_squared: f32,
    ends: Vec<u32>,
    numbers: Vec<u32>,
}

impl HashGrid {
    fn new(particles: &[Particle], radius: f32) -> Self {
        let mut grid = Self {
            lower: [f32::INFINITY; 3],
            upper: [f32::NEG_INFINITY; 3],
            per_unit: 0.5 / radius,
            radius_squared: radius * radius,
            ends: vec![0; particles.len()],
            numbers: vec![0; particles.len()],
        };
        for particle in particles {
            for axis in 0..3 {
                grid.lower[axis] = grid.lower[axis].min(particle.position[axis]);
                grid.upper[axis] = grid.upper[axis].max(particle.position[axis]);
            }
        }
        for particle in particles {
            let cell = grid.cell_of(particle.position);
            grid.ends[cell] += 1;
        }
        let mut sum = 0;
        for end in &mut grid.ends {
            sum += std::mem::replace(end, sum);
        }
        for (number, particle) in particles.iter().enumerate() {
            let cell = grid.cell_of(particle.position);
            grid.numbers[grid.ends[cell] as usize] = number as u32;
            grid.ends[cell] += 1;
        }
        grid
    }

    fn index(&self, cell: [i32; 3]) -> usize {
        let [x, y, z] = cell.map(|coordinate| coordinate as u32);
        let hash =
            x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791);
        (hash % self.ends.len() as u32) as usize
    }

    fn cell_of(&self, point: [f32; 3]) -> usize {
        let mut cell = [0; 3];
        for axis in 0..3 {
            cell[axis] = ((point[axis] - self.lower[axis]) * self.per_unit).floor() as i32;
        }
        self.index(cell)
    }

    #[inline(always)]
    fn process(&self, particles: &[Particle], point: [f32; 3], mut found: impl FnMut(&Particle)) {
        let (mut cell, mut other) = ([0; 3], [0; 3]);
        for axis in 0..3 {
            if point[axis] < self.lower[axis] || point[axis] > self.upper[axis] {
                return;
            }
            let place = (point[axis] - self.lower[axis]) * self.per_unit;
            cell[axis] = place.floor() as i32;
            let step = if place - place.floor() < 0.5 { -1 } else { 1 };
            other[axis] = cell[axis] + step;
        }
        for corner in 0..8 {
            let mut at = cell;
            for axis in 0..3 {
                if corner >> axis & 1 == 1 {
                    at[axis] = other[axis];
                }
            }
            let index = self.index(at);
            let start = if index == 0 { 0 } else { self.ends[index - 1] };
            for &number in &self.numbers[start as usize..self.ends[index] as usize] {
                let particle = &particles[number as usize];
                let at = &particle.position;
                let (x, y, z) = (point[0] - at[0], point[1] - at[1], point[2] - at[2]);
                if x * x + y * y + z * z <= self.radius_squared {
                    found(particle);
                }
            }
        }
    }
}

fn gather_hashed(sum: &mut Channels<N>, grid: &HashGrid, particles: &[Particle], queries: &Points) {
    for query in 0..COUNT {
        let point = row_of(&queries.position, query);
        let [x, y, z] = row_of(&queries.normal, query);
        let mut total = [0.0; N];
        grid.process(particles, point, |particle| {
            let d = &particle.direction;
            if d[0] * x + d[1] * y + d[2] * z < 0.0 {
                for (total, power) in total.iter_mut().zip(&particle.power) {
                    *total += power;
                }
            }
        });
        for (column, total) in sum.iter_mut().zip(&total) {
            column[query] = *total;
        }
    }
}

// ---- side by side -----------------------------------------------------------------------------

/// The shortest of three runs, in nanoseconds per row.
fn nanoseconds(mut work: impl FnMut()) -> f64 {
    let mut shortest = f64::INFINITY;
    for _ in 0..3 {
        let start = Instant::now();
        work();
        shortest = shortest.min(start.elapsed().as_secs_f64());
    }
    shortest * 1e9 / COUNT as f64
}

fn checksum(sum: &Channels<N>) -> f64 {
    sum.iter().map(|column| column[..COUNT].iter().map(|&x| f64::from(x)).sum::<f64>()).sum()
}

fn compare(criterion: &mut Criterion, name: &str, place: fn(u32) -> Points, radius: f32) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
    let (photons, queries) = (photons_at(&place(1)), place(2));
    let mut sum = channels::<N>(COUNT);
    let particles = particles_of(&photons);
    let hash_grid = HashGrid::new(&particles, radius);
    let theirs = nanoseconds(|| gather_hashed(&mut sum, &hash_grid, &particles, &queries));
    let expected = checksum(&sum);

    let mut grid = PhotonGrid::new(PhotonClass::Power);
    let mut order = QueryOrder::default();
    let rebuild = nanoseconds(|| pool.install(|| grid.rebuild(&photons, radius)));
    let sort = nanoseconds(|| order.sort(&queries.position, 0..COUNT, grid.cells()));
    let ours = nanoseconds(|| gather(&mut sum, &mut order, &grid, &queries, COUNT));
    let found = checksum(&sum);
    assert!((found / expected - 1.0).abs() < 1e-5, "{found} is not {expected}");
    let small = nanoseconds(|| gather(&mut sum, &mut order, &grid, &queries, BATCH));
    assert_eq!(checksum(&sum), found);
    println!(
        "{name}: hash grid {:.3} Mq/s, ours {:.2} Mq/s, ratio {:.1}; sorting is {sort:.0} ns of \
         {ours:.0}; {small:.0} ns in batches of {BATCH}; rebuild {rebuild:.0} ns per photon",
        1e3 / theirs,
        1e3 / ours,
        theirs / ours
    );

    let mut group = criterion.benchmark_group(format!("photons/{name}"));
    group.sample_size(10);
    group.throughput(Throughput::Elements(COUNT as u64));
    group.bench_function("hash grid", |bench| {
        bench.iter(|| gather_hashed(&mut sum, &hash_grid, &particles, &queries));
    });
    group.bench_function("sort and gather", |bench| {
        bench.iter(|| gather(&mut sum, &mut order, &grid, &queries, COUNT));
    });
    group.bench_function("sort", |bench| {
        bench.iter(|| order.sort(&queries.position, 0..COUNT, grid.cells()));
    });
    group.bench_function("rebuild", |bench| {
        bench.iter(|| pool.install(|| grid.rebuild(black_box(&photons), radius)));
    });
    group.finish();
    let mut group = criterion.benchmark_group(format!("photons/{name}/nearest"));
    group.sample_size(10);
    let points: Vec<_> = (0..1000).map(|row| row_of(&queries.position, row)).collect();
    group.bench_function("1000 points", |bench| {
        bench.iter(|| pool.install(|| nearest_distances(&photons, &points, FOUND as usize)));
    });
    group.finish();
}

fn photons(criterion: &mut Criterion) {
    let density = COUNT as f32 / 24.0;
    let radius = (FOUND / (std::f32::consts::PI * density)).sqrt();
    compare(criterion, "walls", on_walls, radius);
    let density = COUNT as f32 / 8.0;
    let radius = (FOUND / (4.0 / 3.0 * std::f32::consts::PI * density)).cbrt();
    compare(criterion, "volume", in_volume, radius);
}

criterion_group!(benches, photons);
criterion_main!(benches);
