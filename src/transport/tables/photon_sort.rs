//! A stable parallel counting sort of photons by bucket, whose outcome does not depend on the
//! number of threads.
//!
//! Two levels, so that both write to a part of memory that stays in cache and belongs to one
//! thread: blocks of rows are grouped by the leading bits of the bucket (its part), and then each
//! part collects its groups from all blocks, in order, and counts by the remaining bits.

use rayon::prelude::*;

use super::photon_grid::Cells;
use super::photons::PhotonTable;

/// Rows of a block.
const BLOCK: usize = 1 << 14;
/// Most leading bits that make a part.
const PART_BITS: u32 = 8;
/// Starts of the groups of a block: of every part, of the rows that are left out, and the end.
const STARTS: usize = (1 << PART_BITS) + 2;
/// Bucket of rows that are left out.
const NOWHERE: u32 = u32::MAX;

/// Memory of the sort, kept between iterations.
#[derive(Default)]
pub(super) struct PhotonSort {
    /// For every row its bucket.
    buckets: Vec<u32>,
    /// Bucket and row, block by block, grouped by part.
    groups: Vec<[u32; 2]>,
    /// First row of every group within its block, [`STARTS`] per block.
    group_starts: Vec<u32>,
    /// Rows of each part.
    part_sizes: Vec<u32>,
    /// For every new row, the old one.
    order: Vec<u32>,
}

/// What the parts have in common.
#[derive(Clone, Copy)]
struct Groups<'a> {
    groups: &'a [[u32; 2]],
    group_starts: &'a [u32],
    part_sizes: &'a [u32],
    /// Bits of a bucket below those of its part.
    low_bits: u32,
}

impl PhotonSort {
    /// For every new row the old one. `starts` becomes the first new row of every bucket, and the
    /// number of all in the end. Photons whose position is not finite are left out.
    pub fn sort<const N: usize>(
        &mut self,
        starts: &mut Vec<u32>,
        photons: &PhotonTable<N>,
        cells: Cells,
    ) -> &[u32] {
        let part_bits = cells.bits.min(PART_BITS);
        let low_bits = cells.bits - part_bits;
        self.group_blocks(photons, cells, low_bits, 1 << part_bits);
        self.part_sizes.clear();
        self.part_sizes.resize(1 << part_bits, 0);
        for block in self.group_starts.chunks_exact(STARTS) {
            for (part, size) in self.part_sizes.iter_mut().enumerate() {
                *size += block[part + 1] - block[part];
            }
        }
        let kept = self.part_sizes.iter().sum::<u32>() as usize;
        self.order.resize(kept, 0);
        starts.resize((1 << cells.bits) + 1, 0);
        let (groups, group_starts) = (&self.groups[..], &self.group_starts[..]);
        let part_sizes = &self.part_sizes[..];
        let groups = Groups { groups, group_starts, part_sizes, low_bits };
        let buckets = 1 << cells.bits;
        sort_parts(&mut self.order, &mut starts[..buckets], groups, 0, 0);
        starts[buckets] = kept as u32;
        &self.order
    }

    /// The first level.
    fn group_blocks<const N: usize>(
        &mut self,
        photons: &PhotonTable<N>,
        cells: Cells,
        low_bits: u32,
        parts: usize,
    ) {
        let len = photons.len;
        self.buckets.resize(len, 0);
        self.groups.resize(len, [0; 2]);
        self.group_starts.resize(len.div_ceil(BLOCK) * STARTS, 0);
        let position = &photons.position;
        self.buckets
            .par_chunks_mut(BLOCK)
            .zip(self.groups.par_chunks_mut(BLOCK))
            .zip(self.group_starts.par_chunks_mut(STARTS))
            .enumerate()
            .for_each(|(block, ((buckets, groups), starts))| {
                let first = block * BLOCK;
                let rows = first..first + buckets.len();
                let columns = [0, 1, 2].map(|axis| &position[axis][rows.clone()]);
                find_buckets(buckets, columns, cells);
                group_block(groups, starts, buckets, first as u32, |bucket| {
                    if bucket == NOWHERE { parts } else { (bucket >> low_bits) as usize }
                });
            });
    }
}

fn find_buckets(buckets: &mut [u32], position: [&[f32]; 3], cells: Cells) {
    for (row, bucket) in buckets.iter_mut().enumerate() {
        let point = [position[0][row], position[1][row], position[2][row]];
        let is_finite = point[0].is_finite() & point[1].is_finite() & point[2].is_finite();
        *bucket = if is_finite { cells.bucket_of_point(point) } else { NOWHERE };
    }
}

/// Groups the rows of one block by part.
fn group_block(
    groups: &mut [[u32; 2]],
    starts: &mut [u32],
    buckets: &[u32],
    first_row: u32,
    part_of: impl Fn(u32) -> usize,
) {
    let mut places = [0; STARTS];
    for &bucket in buckets {
        places[part_of(bucket)] += 1;
    }
    let mut sum = 0;
    for (place, start) in places.iter_mut().zip(starts.iter_mut()) {
        *start = sum;
        sum += std::mem::replace(place, sum);
    }
    for (row, &bucket) in buckets.iter().enumerate() {
        let place = &mut places[part_of(bucket)];
        groups[*place as usize] = [bucket, first_row + row as u32];
        *place += 1;
    }
}

/// The second level: sorts the parts from `part` on, as many as `starts` has buckets for, into
/// `order`, whose first row is `base`. Halves the work until it is one part.
fn sort_parts(order: &mut [u32], starts: &mut [u32], groups: Groups, part: usize, base: u32) {
    let parts = starts.len() >> groups.low_bits;
    if parts == 1 {
        sort_part(order, starts, groups, part, base);
        return;
    }
    let middle = part + parts / 2;
    let rows = groups.part_sizes[part..middle].iter().sum::<u32>();
    let (order, order_above) = order.split_at_mut(rows as usize);
    let (starts, starts_above) = starts.split_at_mut((parts / 2) << groups.low_bits);
    rayon::join(
        || sort_parts(order, starts, groups, part, base),
        || sort_parts(order_above, starts_above, groups, middle, base + rows),
    );
}

fn sort_part(order: &mut [u32], starts: &mut [u32], groups: Groups, part: usize, base: u32) {
    let low = (1 << groups.low_bits) - 1;
    let runs = || {
        groups.group_starts.chunks_exact(STARTS).enumerate().flat_map(move |(block, starts)| {
            let first = block * BLOCK;
            &groups.groups[first + starts[part] as usize..first + starts[part + 1] as usize]
        })
    };
    starts.fill(0);
    runs().for_each(|[bucket, _]| starts[(bucket & low) as usize] += 1);
    let mut sum = 0;
    for start in starts.iter_mut() {
        sum += std::mem::replace(start, sum);
    }
    runs().for_each(|[bucket, row]| {
        let place = &mut starts[(bucket & low) as usize];
        order[*place as usize] = *row;
        *place += 1;
    });
    // Every place has moved on to the next bucket's start: move back, and count from the first
    // row of all.
    let mut start = base;
    for place in starts.iter_mut() {
        start = std::mem::replace(place, start) + base;
    }
}
