//! Gathering photons from the grid against looking at every photon.

use sunstone::internals::math::columns::Column;
use sunstone::internals::math::{F32s, LANES, Vector, hash, lanes};
use sunstone::internals::transport::tables::nearest_photons::nearest_distances;
use sunstone::internals::transport::tables::photon_grid::{PhotonGrid, PhotonVisitor};
use sunstone::internals::transport::tables::photon_queries::QueryOrder;
use sunstone::internals::transport::tables::photons::{PhotonClass, PhotonTable};
use sunstone::internals::transport::tables::vectors;

/// A number in [0, 1).
fn uniform(salt: u32, row: usize, dimension: u32) -> f32 {
    let bits = hash::combine(hash::combine(salt, row as u32), dimension);
    (bits >> 8) as f32 / (1 << 24) as f32
}

fn points(count: usize, point: impl Fn(usize) -> [f32; 3]) -> [Column; 3] {
    let mut columns = vectors(count);
    for row in 0..count {
        for (column, coordinate) in columns.iter_mut().zip(&point(row)) {
            column[row] = *coordinate;
        }
    }
    columns
}

/// Photons at `position`, with power by row; polarized for the classes that have columns for it.
fn photons(class: PhotonClass, position: &[Column; 3]) -> PhotonTable<2> {
    let mut table = PhotonTable::of_class(class, 0);
    let count = position[0].len() - LANES;
    for row in (0..count).step_by(LANES) {
        let live = LANES.min(count - row);
        let number = |d: u32| F32s::from(lanes::each(|lane| uniform(9, row + lane, d)));
        let half = F32s::splat(0.5);
        let direction = Vector { x: number(0), y: number(1), z: number(2) - half }.normalize();
        table.append_lanes(Vector::load(position, row), direction, &[number(3), number(4)], live);
        for channel in 0..class.channels(2) {
            let states = [number(5) - half, number(6), half - number(7 + channel as u32)];
            table.store_stokes(row, row + live, channel, states);
        }
    }
    table
}

/// For every query the number of photons and the sum of their power.
struct Sums<'a> {
    found: &'a mut [(u32, f32)],
}

impl PhotonVisitor<2> for Sums<'_> {
    type State = (u32, F32s);

    fn begin(&mut self, _query: usize) -> Self::State {
        (0, F32s::ZERO)
    }

    fn visit(
        &mut self,
        state: &mut Self::State,
        row: usize,
        within: F32s,
        photons: &PhotonTable<2>,
    ) {
        assert!(within.any(), "a packet without photons in reach");
        state.0 += within.to_bitmask().count_ones();
        state.1 += lanes::load(&photons.power[1], row) & within;
    }

    fn finish(&mut self, query: usize, state: Self::State) {
        self.found[query] = (state.0, state.1.reduce_add());
    }
}

fn gathered(grid: &PhotonGrid<2>, queries: &[Column; 3]) -> Vec<(u32, f32)> {
    let count = queries[0].len() - LANES;
    let mut found = vec![(u32::MAX, 0.0); count];
    let mut order = QueryOrder::default();
    order.sort(queries, 0..count, grid.cells());
    grid.gather(&mut Sums { found: &mut found }, &order, queries);
    found
}

/// The same by looking at every photon, with the same arithmetic for the distance.
fn searched(table: &PhotonTable<2>, queries: &[Column; 3], radius: f32) -> Vec<(u32, f64)> {
    let count = queries[0].len() - LANES;
    let radius = radius.clamp(1e-18, 1e18);
    let point = |columns: &[Column; 3], row: usize| {
        Vector::new(columns[0][row], columns[1][row], columns[2][row])
    };
    (0..count)
        .map(|query| {
            let center = point(queries, query);
            let (mut found, mut sum) = (0, 0.0);
            for row in 0..table.len {
                let offset = point(&table.position, row) - center;
                if offset.length_squared() <= radius * radius {
                    found += 1;
                    sum += f64::from(table.power[1][row]);
                }
            }
            (found, sum)
        })
        .collect()
}

/// Returns how many photons were found in all.
fn compare(position: &[Column; 3], queries: &[Column; 3], radius: f32, what: &str) -> u32 {
    let table = photons(PhotonClass::Power, position);
    let mut grid = PhotonGrid::new(PhotonClass::Power);
    grid.rebuild(&table, radius);
    let found = gathered(&grid, queries);
    let expected = searched(&table, queries, radius);
    for (query, (found, expected)) in found.iter().zip(&expected).enumerate() {
        assert_eq!(found.0, expected.0, "{what}, radius {radius}, query {query}");
        let off = (f64::from(found.1) - expected.1).abs();
        assert!(off <= 1e-5 * expected.1, "{what}, radius {radius}, query {query}: {off}");
    }
    found.iter().map(|found| found.0).sum()
}

fn cube(count: usize, salt: u32, edge: f32, center: [f32; 3]) -> [Column; 3] {
    points(count, |row| {
        [0, 1, 2].map(|axis| center[axis] + edge * (uniform(salt, row, axis as u32) - 0.5))
    })
}

#[test]
fn gathers_equal_searches_in_a_volume() {
    for center in [[0.0; 3], [-40.0, 13.0, 900.0], [1e6, -1e6, 3e7]] {
        for radius in [1e-30, 1e-6, 0.01, 0.1, 0.7, 5.0, 1e30] {
            let edge = if center[0] > 1e5 { 100.0 } else { 1.0 };
            let position = cube(3000, 1, edge, center);
            let queries = cube(300, 2, 1.1 * edge, center);
            let sum = compare(&position, &queries, radius * edge, "volume");
            assert!((radius < 0.1) || sum > 300, "{sum} found");
            compare(&position, &position, radius * edge, "photons as queries");
        }
    }
}

#[test]
fn gathers_equal_searches_where_photons_cluster() {
    let clustered = |salt: u32, count: usize| {
        points(count, |row| {
            let cluster = row % 5;
            [0, 1, 2].map(|axis| {
                let spread = uniform(salt, row, axis) * uniform(salt, row, 7).powi(4);
                uniform(77, cluster, axis) * 10.0 - 5.0 + spread
            })
        })
    };
    for radius in [1e-4, 1e-3, 0.02, 0.3, 4.0] {
        compare(&clustered(1, 4000), &clustered(2, 300), radius, "clusters");
    }
    let one_cell = cube(1000, 5, 1e-4, [0.3, 0.3, 0.3]);
    assert_eq!(compare(&one_cell, &one_cell, 0.01, "one cell"), 1_000_000);
    let one_point = cube(1000, 5, 0.0, [0.3, -7.0, 0.0]);
    assert_eq!(compare(&one_point, &one_point, 1e-20, "one point"), 1_000_000);
}

#[test]
fn gathers_equal_searches_on_the_edges_of_cells() {
    // Everything lies on a lattice whose steps are those of the cells, or of half of them.
    let lattice = |step: f32| {
        points(2000, move |row| [0, 1, 2].map(|a| (uniform(3, row, a) * 9.0).floor() * step - 1.0))
    };
    for step in [0.125, 0.25, 0.5] {
        for radius in [0.125, 0.25, 0.250_001] {
            compare(&lattice(step), &lattice(step), radius, "lattice");
        }
    }
}

#[test]
fn no_photon_counts_twice_where_buckets_collide() {
    // Few photons make few buckets, so that many of the four runs of a query overlap.
    for count in [0, 1, 2, 15, 16, 17, 63, 200] {
        for salt in 0..20 {
            let position = cube(count, salt, 1.0, [0.0; 3]);
            for radius in [0.03, 0.1, 0.4] {
                compare(&position, &cube(100, salt + 50, 1.0, [0.0; 3]), radius, "few");
            }
        }
    }
}

#[test]
fn points_that_are_not_finite_find_nothing_and_are_not_found() {
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e38, -3e38];
    let spoil = |columns: &mut [Column; 3]| {
        for row in (0..columns[0].len() - LANES).step_by(3) {
            columns[row % 7 % 3][row] = bad[row % 5];
        }
    };
    let (mut position, mut queries) = (cube(2000, 1, 1.0, [0.0; 3]), cube(100, 2, 1.0, [0.0; 3]));
    spoil(&mut position);
    spoil(&mut queries);
    for radius in [0.05, 0.5, 1e25] {
        compare(&position, &queries, radius, "not finite");
    }
    let mut grid = PhotonGrid::new(PhotonClass::Power);
    grid.rebuild(&photons(PhotonClass::Power, &position), 0.1);
    let finite = |row: &usize| position.iter().all(|column| column[*row].is_finite());
    assert_eq!(grid.photons().len, (0..2000).filter(finite).count());
}

#[test]
fn rebuilding_leaves_nothing_of_the_photons_before() {
    let mut grid = PhotonGrid::new(PhotonClass::Power);
    let queries = cube(200, 3, 1.0, [0.0; 3]);
    for (count, radius) in [(50_000, 0.05), (300, 0.2), (0, 1.0), (20_000, 0.03)] {
        let table = photons(PhotonClass::Power, &cube(count, 1, 1.0, [0.0; 3]));
        grid.rebuild(&table, radius);
        let mut fresh = PhotonGrid::new(PhotonClass::Power);
        fresh.rebuild(&table, radius);
        assert_eq!(gathered(&grid, &queries), gathered(&fresh, &queries));
    }
}

#[test]
fn bits_do_not_depend_on_threads() {
    for class in [PhotonClass::Power, PhotonClass::Stokes, PhotonClass::SpectralStokes] {
        let table = photons(class, &cube(100_000, 1, 1.0, [0.0; 3]));
        let queries = cube(1000, 2, 1.0, [0.0; 3]);
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let mut grid = PhotonGrid::new(class);
            pool.expect("threads").install(|| grid.rebuild(&table, 0.04));
            let sums: Vec<u32> =
                gathered(&grid, &queries).iter().map(|found| found.1.to_bits()).collect();
            (grid, sums)
        };
        let (one, sums) = run(1);
        for threads in [2, 5] {
            let (other, other_sums) = run(threads);
            let (one, other) = (one.photons(), other.photons());
            assert_eq!(sums, other_sums);
            assert_eq!(one.len, other.len);
            let rows = ..one.len;
            assert_eq!(one.direction[rows], other.direction[rows]);
            let floats = |table: &PhotonTable<2>| -> Vec<Vec<f32>> {
                let columns = table.position.iter().chain(&table.power);
                columns.map(|column| column[rows].to_vec()).collect()
            };
            assert_eq!(floats(one), floats(other));
            assert!(one.stokes == other.stokes);
        }
    }
}

#[test]
fn photons_keep_their_columns_together_and_their_order_within_a_cell() {
    let class = PhotonClass::SpectralStokes;
    let mut table = photons(class, &cube(40_000, 1, 1.0, [0.0; 3]));
    for row in 0..table.len {
        table.power[0][row] = row as f32;
    }
    let mut grid = PhotonGrid::new(class);
    grid.rebuild(&table, 0.05);
    let sorted = grid.photons();
    assert_eq!(sorted.len, table.len);
    let mut seen = vec![false; table.len];
    for row in 0..sorted.len {
        let from = sorted.power[0][row] as usize;
        assert!(!std::mem::replace(&mut seen[from], true));
        assert_eq!(sorted.direction[row], table.direction[from]);
        assert_eq!(sorted.power[1][row], table.power[1][from]);
        for axis in 0..3 {
            assert_eq!(sorted.position[axis][row], table.position[axis][from]);
            assert!((0..2).all(|n| sorted.stokes[axis][n][row] == table.stokes[axis][n][from]));
        }
    }
    let one_cell = photons(class, &cube(5000, 1, 1e-3, [0.5; 3]));
    grid.rebuild(&one_cell, 10.0);
    assert_eq!(grid.photons().direction[..5000], one_cell.direction[..5000]);
}

#[test]
fn batches_can_be_shared_and_start_anywhere() {
    let table = photons(PhotonClass::Power, &cube(20_000, 1, 1.0, [0.0; 3]));
    let mut grid = PhotonGrid::new(PhotonClass::Power);
    grid.rebuild(&table, 0.06);
    let queries = cube(1000, 2, 1.0, [0.0; 3]);
    let whole = gathered(&grid, &queries);
    let mut order = QueryOrder::default();
    for rows in [0..1000, 100..101, 37..900, 5..5] {
        order.sort(&queries, rows.clone(), grid.cells());
        assert_eq!(order.len(), rows.len());
        let mut found = vec![(u32::MAX, 0.0); 1000];
        let middle = order.len() / 3;
        for places in [middle..order.len(), 0..middle] {
            let mut sums = Sums { found: &mut found };
            grid.gather_some(&mut sums, &order, &queries, places);
        }
        for (row, found) in found.iter().enumerate() {
            let expected = if rows.contains(&row) { whole[row] } else { (u32::MAX, 0.0) };
            assert_eq!(*found, expected);
        }
        let mut sorted: Vec<usize> = order.rows().collect();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(rows));
    }
}

#[test]
fn closures_are_visitors() {
    let table = photons(PhotonClass::Power, &cube(5000, 1, 1.0, [0.0; 3]));
    let mut grid = PhotonGrid::new(PhotonClass::Power);
    grid.rebuild(&table, 0.1);
    let queries = cube(100, 2, 1.0, [0.0; 3]);
    let mut order = QueryOrder::default();
    order.sort(&queries, 0..100, grid.cells());
    let mut found = [0; 100];
    let mut count = |query: usize, _row: usize, within: F32s, _photons: &PhotonTable<2>| {
        found[query] += within.to_bitmask().count_ones();
    };
    grid.gather(&mut count, &order, &queries);
    let expected: Vec<u32> = gathered(&grid, &queries).iter().map(|found| found.0).collect();
    assert_eq!(found[..], expected);
}

#[test]
fn nearest_distances_equal_sorted_ones() {
    let mut position = cube(10_001, 1, 1.0, [5.0; 3]);
    for row in (0..10_001).step_by(100) {
        position[row % 3][row] = [f32::NAN, f32::INFINITY][row / 100 % 2];
    }
    let table = photons(PhotonClass::Power, &position);
    let points: Vec<[f32; 3]> =
        (0..50).map(|row| [0, 1, 2].map(|d| uniform(2, row, d) + 4.5)).collect();
    for count in [1, 25, 300] {
        let found = nearest_distances(&table, &points, count);
        for (point, found) in points.iter().zip(&found) {
            let squares = (0..table.len).map(|row| {
                let offset = [0, 1, 2].map(|axis| position[axis][row] - point[axis]);
                offset.iter().map(|&x| f64::from(x).powi(2)).sum::<f64>()
            });
            let mut squares: Vec<f64> = squares.filter(|square| square.is_finite()).collect();
            squares.sort_by(f64::total_cmp);
            let expected = squares[count - 1].sqrt();
            assert!((f64::from(*found) / expected - 1.0).abs() < 1e-5, "{found}, {expected}");
        }
    }
    let few = photons(PhotonClass::Power, &cube(5, 1, 1.0, [0.0; 3]));
    assert!(nearest_distances(&few, &points, 5).iter().all(|distance| distance.is_finite()));
    assert_eq!(nearest_distances(&few, &points, 6), vec![f32::INFINITY; 50]);
    assert!(nearest_distances(&few, &[], 6).is_empty());
}

/// Densities on a plane by what a crowd encloses.
struct Densities<'a> {
    found: &'a mut [f64],
    radius: f32,
}

impl PhotonVisitor<2> for Densities<'_> {
    type State = (u32, f32);

    const CROWD: usize = 60;

    fn begin(&mut self, _query: usize) -> Self::State {
        (0, self.radius)
    }

    fn enclose(&mut self, state: &mut Self::State, _query: usize, radius: f32) {
        assert!(radius <= self.radius);
        state.1 = radius;
    }

    fn visit(&mut self, state: &mut Self::State, _: usize, within: F32s, _: &PhotonTable<2>) {
        state.0 += within.to_bitmask().count_ones();
    }

    fn finish(&mut self, query: usize, (count, radius): Self::State) {
        assert!(count <= Self::CROWD as u32);
        self.found[query] = f64::from(count) / (std::f64::consts::PI * f64::from(radius).powi(2));
    }
}

/// The mean density at the queries.
fn mean_density(position: &[Column; 3], queries: &[Column; 3], radius: f32) -> f64 {
    let mut grid = PhotonGrid::new(PhotonClass::Power);
    grid.rebuild(&photons(PhotonClass::Power, position), radius);
    let count = queries[0].len() - LANES;
    let mut found = vec![0.0; count];
    let mut order = QueryOrder::default();
    order.sort(queries, 0..count, grid.cells());
    grid.gather(&mut Densities { found: &mut found, radius }, &order, queries);
    found.iter().sum::<f64>() / count as f64
}

/// Of disks side by side, each with a crowd of 60: their mean has a standard error of 1/sqrt(60 n),
/// of which four are left with a chance of 6e-5. In the large radius there are more photons than
/// are held at a time.
#[test]
fn crowds_enclose_what_the_density_is() {
    let on_plane = |row: usize| [uniform(3, row, 0), uniform(3, row, 1), 0.0];
    let position = points(20_000, on_plane);
    let queries =
        points(225, |row| [0.06 * (row % 15) as f32 + 0.08, 0.06 * (row / 15) as f32 + 0.08, 0.0]);
    for radius in [0.075, 0.3] {
        let density = mean_density(&position, &queries, radius);
        let z = (density / 20_000.0 - 1.0) * (60.0_f64 * 225.0).sqrt();
        assert!(z.abs() < 4.0, "{density} photons in a unit of area, z {z}");
    }
}

/// Outside a bright spot its photons would make up for 3.8 times the density that is there.
#[test]
fn crowds_aside_do_not_count() {
    let position = points(7_000, |row| {
        let [u, v] = [0, 1].map(|dimension| uniform(4, row, dimension));
        if row < 2_000 {
            return [u, v, 0.0];
        }
        let (sine, cosine) = (std::f32::consts::TAU * v).sin_cos();
        [0.5 + 0.01 * u.sqrt() * cosine, 0.5 + 0.01 * u.sqrt() * sine, 0.0]
    });
    let queries = points(64, |row| {
        let (sine, cosine) = (std::f32::consts::TAU * row as f32 / 64.0).sin_cos();
        [0.5 + 0.05 * cosine, 0.5 + 0.05 * sine, 0.0]
    });
    let density = mean_density(&position, &queries, 0.2);
    assert!((1_000.0..3_000.0).contains(&density), "{density} where there are 2,000");
}
