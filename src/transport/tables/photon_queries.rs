//! Points around which photons are to be gathered, in the order of the photons: queries that
//! follow each other look at the same rows, which are still in cache.

use std::ops::Range;

use crate::math::columns::Column;

use super::super::clearing::Nearby;
use super::photon_grid::Cells;

/// Bits that one pass of the sort looks at.
const DIGIT_BITS: u32 = 11;
/// Below this number of queries, comparing them is cheaper than counting.
const COUNTED_MIN: usize = 128;

/// Vertices that look for photons, and what is about one of them.
#[derive(Default)]
pub struct PhotonQueries {
    /// In which order they do.
    pub order: QueryOrder,
    /// The shapes that cut into the kernel.
    pub around: Nearby,
}

/// A batch of queries in the order of the buckets they start from; keeps its memory.
#[derive(Default)]
pub struct QueryOrder {
    /// Bucket in the upper half, index from the first row in the lower.
    queries: Vec<u64>,
    sorted: Vec<u64>,
    counts: Vec<u32>,
    first_row: usize,
}

impl QueryOrder {
    /// Takes the rows `rows` of `points`, fewer than 2^32, as queries to the grid that `cells`
    /// comes from.
    pub fn sort(&mut self, points: &[Column; 3], rows: Range<usize>, cells: Cells) {
        self.first_row = rows.start;
        self.queries.clear();
        let [x, y, z] = [0, 1, 2].map(|axis| &points[axis][rows.clone()]);
        self.queries.extend((0..rows.len()).map(|row| {
            let bucket = cells.bucket(cells.corner([x[row], y[row], z[row]]));
            u64::from(bucket) << 32 | row as u64
        }));
        if rows.len() < COUNTED_MIN {
            self.queries.sort_unstable();
            return;
        }
        let mut shift = 32;
        while shift < 32 + cells.bits {
            self.sort_by_digit(shift);
            shift += DIGIT_BITS;
        }
    }

    /// A stable sort by the digit from bit `shift` on.
    fn sort_by_digit(&mut self, shift: u32) {
        let digit = |query: u64| (query >> shift) as usize & ((1 << DIGIT_BITS) - 1);
        self.counts.clear();
        self.counts.resize(1 << DIGIT_BITS, 0);
        for &query in &self.queries {
            self.counts[digit(query)] += 1;
        }
        let mut sum = 0;
        for count in &mut self.counts {
            sum += std::mem::replace(count, sum);
        }
        self.sorted.resize(self.queries.len(), 0);
        for &query in &self.queries {
            let place = &mut self.counts[digit(query)];
            self.sorted[*place as usize] = query;
            *place += 1;
        }
        std::mem::swap(&mut self.queries, &mut self.sorted);
    }

    /// Number of queries.
    pub fn len(&self) -> usize {
        self.queries.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.queries.is_empty()
    }

    /// Rows of the queries in their order.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = usize> + '_ {
        self.queries.iter().map(|&query| self.row(query))
    }

    #[inline(always)]
    pub(super) fn queries(&self, places: Range<usize>) -> &[u64] {
        &self.queries[places]
    }

    /// The row of a query in the columns of points.
    #[inline(always)]
    pub(super) fn row(&self, query: u64) -> usize {
        self.first_row + (query as u32) as usize
    }
}
