//! Photons sorted into the cells of a hashed grid, so that those near a point are a few runs of
//! rows.
//!
//! A cell is as wide as the ball that queries look at, so a ball meets at most two cells along
//! each axis. The bucket of a cell is `hash(z) + y * stride + x`: cells that follow each other
//! along x have buckets that do too, and the eight cells of a query are four runs of two buckets.
//! Two of the runs may share a bucket; such queries list their buckets singly, or photons would
//! count twice. The stride is the extent of the photons along x, so that rows of cells side by
//! side are side by side in memory: with all rows scattered by a hash, most of gathering
//! was waiting for memory.
//!
//! Rows of one bucket keep the order of the table they come from, and a query visits runs in a
//! fixed order, so sums over photons depend on the order of the photons alone and not on threads.

use std::ops::Range;

use rayon::prelude::*;

use crate::math::columns::{Column, ColumnWork, Columns, Value, take};
use crate::math::{F32s, Vector, hash, lanes};

use super::photon_candidates::{Candidates, Runs};
use super::photon_queries::QueryOrder;
use super::photon_sort::PhotonSort;
use super::photons::{PhotonClass, PhotonTable};

/// Radii, in scene units, are taken to be within these bounds, so that their squares are numbers.
const RADIUS_RANGE: [f32; 2] = [1e-18, 1e18];
/// Cells are this much wider than the ball, more than the distances computed in `f32` are off.
const SLACK: f64 = 1.0 + 1.0 / 65536.0;
/// Coordinates of cells lie within this distance of zero; what is farther shares the last cells.
const COORDINATE_MAX: f64 = (1 << 30) as f64;
/// Stride of rows that are too long to lie side by side: they are strewn over all buckets.
const SCATTER: u32 = 0x9e37_79b1;
/// Fewest and most bits of the number of a bucket.
const BUCKET_BITS: Range<u32> = 4..28;

/// Rows of a column that a thread takes at a time.
const ROWS: usize = 1 << 14;

/// What becomes of the photons near each point of a batch.
///
/// For every query `begin`, then, if any photons may be in reach, `enclose` and `visit` once for
/// every packet of eight rows with any, then `finish`; other queries may begin and end in between.
/// A closure `(query, first_row, within, photons)` is a visitor, too.
pub trait PhotonVisitor<const N: usize> {
    /// What is kept, in registers with luck, while the packets of one query are visited.
    type State;

    /// Most photons that are visited, unless more are in one place: where more are in reach, that
    /// is narrowed. No limit by default.
    const CROWD: usize = usize::MAX;

    /// Starts the query at this row of the points.
    fn begin(&mut self, query: usize) -> Self::State;

    /// Nothing beyond `radius` will be visited.
    fn enclose(&mut self, _state: &mut Self::State, _query: usize, _radius: f32) {}

    /// The eight rows from `first_row` on, of which those in the mask `within` are in reach. The
    /// other rows hold any values, infinite ones included.
    fn visit(
        &mut self,
        state: &mut Self::State,
        first_row: usize,
        within: F32s,
        photons: &PhotonTable<N>,
    );

    /// Ends the query.
    fn finish(&mut self, query: usize, state: Self::State);
}

impl<const N: usize, F: FnMut(usize, usize, F32s, &PhotonTable<N>)> PhotonVisitor<N> for F {
    type State = usize;

    #[inline(always)]
    fn begin(&mut self, query: usize) -> usize {
        query
    }

    #[inline(always)]
    fn visit(&mut self, query: &mut usize, row: usize, within: F32s, photons: &PhotonTable<N>) {
        self(*query, row, within, photons);
    }

    #[inline(always)]
    fn finish(&mut self, _query: usize, _state: usize) {}
}

/// How space is cut into cells and cells are numbered.
#[derive(Clone, Copy, Debug)]
pub struct Cells {
    /// Cells per scene unit.
    per_unit: f64,
    /// Buckets from a cell to the next along y.
    stride: u32,
    /// Bits of the number of a bucket.
    pub(super) bits: u32,
}

impl Cells {
    /// Cells for balls of `radius` and about as many buckets as photons, whose finite positions
    /// are within `extent` along x.
    fn new(radius: f32, photons: usize, extent: [f32; 2]) -> Self {
        let bits = (usize::BITS - photons.leading_zeros()).saturating_sub(1);
        let bits = bits.clamp(BUCKET_BITS.start, BUCKET_BITS.end);
        let mut cells =
            Self { per_unit: 1.0 / (2.0 * f64::from(radius) * SLACK), stride: SCATTER, bits };
        let along_x = |x: f32| i64::from(cells.coordinates([x, 0.0, 0.0], 0.0)[0]);
        let stride = along_x(extent[1]) - along_x(extent[0]) + 3;
        // Longer rows would come around to the beginning, perhaps to where they began.
        if (4..1 << (bits - 2)).contains(&stride) {
            cells.stride = stride as u32;
        }
        cells
    }

    /// The bucket of the cell that contains a point.
    #[inline(always)]
    pub(super) fn bucket_of_point(&self, point: [f32; 3]) -> u32 {
        self.bucket(self.coordinates(point, 0.0))
    }

    /// The lowest of the eight cells that the ball about a point meets.
    #[inline(always)]
    pub(super) fn corner(&self, point: [f32; 3]) -> [i32; 3] {
        self.coordinates(point, 0.5)
    }

    /// The bucket of a cell.
    #[inline(always)]
    pub(super) fn bucket(&self, cell: [i32; 3]) -> u32 {
        let row =
            hash::mix(cell[2] as u32).wrapping_add((cell[1] as u32).wrapping_mul(self.stride));
        row.wrapping_add(cell[0] as u32) & (u32::MAX >> (32 - self.bits))
    }

    /// The cell of a point moved down by `offset` cells along each axis. In `f64`, coordinates are
    /// good to a millionth of a cell wherever the point is.
    #[inline(always)]
    fn coordinates(&self, point: [f32; 3], offset: f64) -> [i32; 3] {
        let along = |x: f32| {
            let cell = (f64::from(x) * self.per_unit).clamp(-COORDINATE_MAX, COORDINATE_MAX);
            (cell - offset).floor() as i32
        };
        [along(point[0]), along(point[1]), along(point[2])]
    }
}

/// Photons in the order of their buckets; made anew for every iteration, in the same memory.
pub struct PhotonGrid<const N: usize> {
    photons: PhotonTable<N>,
    /// First row of every bucket, and the number of rows in the end.
    starts: Vec<u32>,
    cells: Cells,
    radius: f32,
    sort: PhotonSort,
}

impl<const N: usize> PhotonGrid<N> {
    /// An empty grid for photons of `class`.
    pub fn new(class: PhotonClass) -> Self {
        let cells = Cells::new(1.0, 0, [0.0; 2]);
        Self {
            photons: PhotonTable::of_class(class, 0),
            starts: vec![0; (1 << cells.bits) + 1],
            cells,
            radius: 1.0,
            sort: PhotonSort::default(),
        }
    }

    /// The photons that can be found, in the order of their buckets.
    pub fn photons(&self) -> &PhotonTable<N> {
        &self.photons
    }

    /// Takes the photons of a table of the same class, those at finite positions, for gathers
    /// within `radius` (positive, in scene units).
    pub fn rebuild(&mut self, photons: &PhotonTable<N>, radius: f32) {
        self.photons.clear();
        self.photons.append_table(photons);
        self.sort(radius);
    }

    /// The table in which photons are stored that [`PhotonGrid::sort`] will sort.
    pub fn unsorted(&mut self) -> &mut PhotonTable<N> {
        &mut self.photons
    }

    /// Sorts the photons in place, column by column, and leaves out those that are not at finite
    /// positions, for gathers within `radius` (positive, in scene units).
    pub fn sort(&mut self, radius: f32) {
        assert!(radius > 0.0 && radius.is_finite(), "photons are gathered within {radius}");
        let photons = &mut self.photons;
        let radius = radius.clamp(RADIUS_RANGE[0], RADIUS_RANGE[1]);
        let extent = extent_of(&photons.position[0][..photons.len]);
        self.cells = Cells::new(radius, photons.len, extent);
        self.radius = radius;
        let order = self.sort.sort(&mut self.starts, photons, self.cells);
        photons.each(&TakeOnAllThreads(order));
        photons.len = order.len();
    }

    /// How space is cut, for [`QueryOrder::sort`].
    pub fn cells(&self) -> Cells {
        self.cells
    }

    /// Shows `visitor` the photons near the points of all queries in `order`; those at points
    /// that are not finite have none.
    pub fn gather<V: PhotonVisitor<N>>(
        &self,
        visitor: &mut V,
        order: &QueryOrder,
        points: &[Column; 3],
    ) {
        self.gather_some(visitor, order, points, 0..order.len());
    }

    /// [`PhotonGrid::gather`] for the queries at `places` of the order, so that several threads
    /// can share a batch.
    pub fn gather_some<V: PhotonVisitor<N>>(
        &self,
        visitor: &mut V,
        order: &QueryOrder,
        points: &[Column; 3],
        places: Range<usize>,
    ) {
        // Queries begin and end a block at a time: what they read and write is all over memory,
        // and only loads that follow each other closely are waited for together.
        const BLOCK: usize = 16;
        let mut block = [[0.0; 3]; BLOCK];
        let mut states = [const { None }; BLOCK];
        let mut candidates = Candidates::new();
        for start in places.clone().step_by(BLOCK) {
            let queries = order.queries(start..places.end.min(start + BLOCK));
            for (index, &query) in queries.iter().enumerate() {
                let row = order.row(query);
                block[index] = lanes::row_of(points, row);
                states[index] = Some(visitor.begin(row));
            }
            for ((point, &query), state) in block.iter().zip(queries).zip(&mut states) {
                if let Some(state) = state {
                    self.visit_near(visitor, state, &mut candidates, (*point, order.row(query)));
                }
            }
            for (state, &query) in states.iter_mut().zip(queries) {
                if let Some(state) = state.take() {
                    visitor.finish(order.row(query), state);
                }
            }
        }
    }

    #[inline(always)]
    fn visit_near<V: PhotonVisitor<N>>(
        &self,
        visitor: &mut V,
        state: &mut V::State,
        candidates: &mut Candidates,
        (point, query): ([f32; 3], usize),
    ) {
        let corner = self.cells.corner(point);
        if candidates.corner != Some(corner) {
            candidates.corner = Some(corner);
            self.find_runs(&mut candidates.runs, corner);
            candidates.rewind(&self.photons.position);
        }
        let (center, mut reach) = (Vector::splat(point), self.radius * self.radius);
        candidates.test(center, reach);
        if candidates.has_none() {
            return;
        }
        let mut radius = self.radius;
        if candidates.may_be_more_than(V::CROWD)
            && let Some(first_out) = self.crowded(candidates, (center, reach), V::CROWD)
        {
            (radius, reach) = (first_out.sqrt(), first_out.next_down());
        }
        visitor.enclose(state, query, radius);
        loop {
            for hit in candidates.hits() {
                let within = hit.squared.simd_le(F32s::splat(reach));
                visitor.visit(state, hit.row as usize, within, &self.photons);
            }
            if candidates.is_end() {
                break;
            }
            candidates.fill(&self.photons.position);
            candidates.test(center, reach);
        }
        if !candidates.is_whole {
            candidates.rewind(&self.photons.position);
        }
    }

    /// [`Candidates::crowded`], after which the first packets are tested again.
    #[inline(never)]
    fn crowded(
        &self,
        candidates: &mut Candidates,
        (center, reach): (Vector<F32s>, f32),
        crowd: usize,
    ) -> Option<f32> {
        let first_out = candidates.crowded(&self.photons.position, (center, reach), crowd);
        if !candidates.is_whole {
            candidates.rewind(&self.photons.position);
            candidates.test(center, first_out.unwrap_or(reach));
        }
        first_out
    }

    /// The rows of the eight cells from `corner` on.
    #[inline(always)]
    fn find_runs(&self, runs: &mut Runs, [x, y, z]: [i32; 3]) {
        let last = u32::MAX >> (32 - self.cells.bits);
        let mut buckets = [0; 4];
        for (row, bucket) in buckets.iter_mut().enumerate() {
            *bucket = self.cells.bucket([x, y + (row & 1) as i32, z + (row >> 1) as i32]);
        }
        runs.len = 0;
        if overlap(&buckets, last) {
            self.find_single_runs(runs, &buckets, last);
            return;
        }
        for &bucket in buckets.iter() {
            runs.push(self.starts[bucket as usize], self.starts[bucket as usize + 2]);
        }
    }

    /// Like the end of `find_runs`, but every bucket on its own and once.
    #[cold]
    fn find_single_runs(&self, runs: &mut Runs, buckets: &[u32; 4], last: u32) {
        let mut singles = [0; 8];
        for (row, &bucket) in buckets.iter().enumerate() {
            singles[2 * row] = bucket;
            singles[2 * row + 1] = (bucket + 1) & last;
        }
        singles.sort_unstable();
        for (place, &bucket) in singles.iter().enumerate() {
            if place == 0 || singles[place - 1] != bucket {
                runs.push(self.starts[bucket as usize], self.starts[bucket as usize + 1]);
            }
        }
    }
}

/// Whether two of the runs of two buckets share one, or a run goes on at bucket 0.
#[inline(always)]
fn overlap(buckets: &[u32; 4], last: u32) -> bool {
    let mut found = false;
    for first in 0..4 {
        found |= buckets[first] == last;
        for second in 0..first {
            let apart = buckets[first].wrapping_sub(buckets[second]).wrapping_add(1) & last;
            found |= apart < 3;
        }
    }
    found
}

/// The lowest and the highest of the finite values.
fn extent_of(column: &[f32]) -> [f32; 2] {
    let wider = |a: [f32; 2], b: [f32; 2]| [a[0].min(b[0]), a[1].max(b[1])];
    let none = [f32::MAX, f32::MIN];
    (column.par_chunks(ROWS))
        .map(|chunk| {
            chunk.iter().fold(
                none,
                |extent, &x| {
                    if x.is_finite() { wider(extent, [x, x]) } else { extent }
                },
            )
        })
        .reduce(|| none, wider)
}

/// Takes the rows of an order.
struct TakeOnAllThreads<'a>(&'a [u32]);

impl ColumnWork for TakeOnAllThreads<'_> {
    fn column<T: Value>(&self, column: &mut Vec<T>) {
        let mut taken = vec![T::ZERO; column.len()];
        taken[..self.0.len()]
            .par_chunks_mut(ROWS)
            .zip(self.0.par_chunks(ROWS))
            .for_each(|(to, order)| take(to, column, order, 0));
        *column = taken;
    }
}
