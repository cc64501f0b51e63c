//! The photons near a query, and how far to look where they are many.

use crate::math::columns::Column;
use crate::math::{F32s, LANES, Vector, lanes};

/// Packets that [`Candidates`] hold at a time, a power of two: the surroundings of a query, if it
/// finds some hundreds of photons.
const PACKETS: usize = 128;
/// Most runs of a query.
const RUNS: usize = 8;

/// Photons in a disk over those within half of its area from which on they lie unevenly, and fewest
/// of which that can be told.
const EVEN: usize = 3;
const EVEN_MIN: usize = 16;
/// Least square of a reach that was narrowed, relative to what it was.
const LEAST_REACH: f32 = 1e-8;
/// Distances that are kept of a crowd, relative to its size, before the farthest are dropped.
const KEPT_OF_CROWD: usize = 8;

/// The photons in the cells about a query, copied to one place for the queries after it that meet
/// the same cells.
pub(super) struct Candidates {
    /// The lowest of the cells.
    pub(super) corner: Option<[i32; 3]>,
    pub(super) runs: Runs,
    /// The run from which to go on, and the row.
    next: (usize, u32),
    /// Whether all packets are held at once.
    pub(super) is_whole: bool,
    len: usize,
    /// Lanes beyond the end of a run are infinitely far away.
    position: [Vector<F32s>; PACKETS],
    rows: [u32; PACKETS],
    hits: [Hit; PACKETS],
    hit_count: usize,
    /// Squared distances of photons in reach.
    distances: Vec<f32>,
}

/// A packet with photons in reach.
#[derive(Clone, Copy)]
pub(super) struct Hit {
    /// Of its distances.
    pub(super) squared: F32s,
    pub(super) row: u32,
}

impl Candidates {
    pub(super) fn new() -> Self {
        let zero = F32s::ZERO;
        Self {
            corner: None,
            runs: Runs::default(),
            next: (0, 0),
            is_whole: true,
            len: 0,
            position: [Vector { x: zero, y: zero, z: zero }; PACKETS],
            rows: [0; PACKETS],
            hits: [Hit { squared: zero, row: 0 }; PACKETS],
            hit_count: 0,
            distances: Vec::new(),
        }
    }

    /// Holds the first packets of the runs.
    pub(super) fn rewind(&mut self, position: &[Column; 3]) {
        self.next = (0, self.runs.list[0][0]);
        self.fill(position);
        self.is_whole = self.is_end();
    }

    /// Whether no packets come after those held.
    #[inline(always)]
    pub(super) fn is_end(&self) -> bool {
        self.next.0 >= self.runs.len
    }

    /// Holds the next packets.
    pub(super) fn fill(&mut self, position: &[Column; 3]) {
        self.len = 0;
        let (mut run, mut row) = self.next;
        while run < self.runs.len && self.len < PACKETS {
            let end = self.runs.list[run][1];
            let live = lanes::first((end - row) as usize);
            let far = Vector { x: F32s::splat(f32::INFINITY), y: F32s::ZERO, z: F32s::ZERO };
            let near = Vector::load(position, row as usize);
            self.position[self.len] = Vector::select(live, near, far);
            self.rows[self.len] = row;
            self.len += 1;
            row += LANES as u32;
            if row >= end {
                run += 1;
                row = self.runs.list[run % RUNS][0];
            }
        }
        self.next = (run, row);
    }

    /// Lists the packets held with photons whose squared distance is `reach` at most. Without a
    /// branch: whether a packet has any cannot be predicted.
    #[inline(always)]
    pub(super) fn test(&mut self, center: Vector<F32s>, reach: f32) {
        let (mut hits, reach) = (0, F32s::splat(reach));
        let packets = self.position[..self.len].iter().zip(&self.rows);
        for (position, &row) in packets {
            let squared = (*position - center).length_squared();
            self.hits[hits % PACKETS] = Hit { squared, row };
            hits += usize::from(squared.simd_le(reach).any());
        }
        self.hit_count = hits;
    }

    /// The packets listed.
    #[inline(always)]
    pub(super) fn hits(&self) -> &[Hit] {
        &self.hits[..self.hit_count]
    }

    /// Whether nothing at all is in reach.
    #[inline(always)]
    pub(super) fn has_none(&self) -> bool {
        self.hit_count == 0 && self.is_whole
    }

    /// False if no more photons than `crowd` are in reach.
    #[inline(always)]
    pub(super) fn may_be_more_than(&self, crowd: usize) -> bool {
        crowd < usize::MAX && (LANES * self.hit_count > crowd || !self.is_whole)
    }

    /// The square of how far to look where more photons than `crowd` have squared distances of
    /// `reach` at most, of which those of the packets held are listed: to the first after it, or so
    /// that those left lie evenly, where it lies aside.
    pub(super) fn crowded(
        &mut self,
        position: &[Column; 3],
        (center, reach): (Vector<F32s>, f32),
        crowd: usize,
    ) -> Option<f32> {
        let mut near = reach;
        self.distances.clear();
        loop {
            for hit in &self.hits[..self.hit_count] {
                push_up_to(&mut self.distances, hit.squared, near);
            }
            if self.distances.len() > KEPT_OF_CROWD * crowd {
                near = nth(&mut self.distances, crowd);
                self.distances.truncate(crowd + 1);
            }
            if self.is_end() {
                break;
            }
            self.fill(position);
            self.test(center, near);
        }
        let is_crowd = self.distances.len() > crowd;
        // Many may be in one place.
        is_crowd.then(|| even_reach(&mut self.distances, crowd).max(LEAST_REACH * reach))
    }
}

/// Appends the values of the lanes that are `most` at most.
#[inline(always)]
fn push_up_to(values: &mut Vec<f32>, lanes: F32s, most: f32) {
    let within = lanes.simd_le(F32s::splat(most)).to_bitmask();
    values.extend(
        (0..LANES).filter(|lane| within >> lane & 1 == 1).map(|lane| lanes.to_array()[lane]),
    );
}

/// The value after the `count` smallest of numbers that are not negative, which come first then.
fn nth(values: &mut [f32], count: usize) -> f32 {
    *values.select_nth_unstable_by_key(count, |value| value.to_bits()).1
}

/// The smallest but `crowd` of squared distances; half as far off, again and again, as long as too
/// few of those nearer are within that: what lies evenly has half of them there, and bright spots
/// aside would be smeared around themselves.
fn even_reach(squared: &mut [f32], crowd: usize) -> f32 {
    let (mut reach, mut count) = (nth(squared, crowd), crowd);
    while count >= EVEN_MIN {
        let half = squared[..crowd].iter().filter(|&&squared| squared < 0.5 * reach).count();
        if EVEN * half >= count {
            break;
        }
        (reach, count) = (0.5 * reach, half);
    }
    reach
}

/// Rows to look at: first and end of each run, none empty.
#[derive(Default)]
pub(super) struct Runs {
    list: [[u32; 2]; RUNS],
    pub(super) len: usize,
}

impl Runs {
    #[inline(always)]
    pub(super) fn push(&mut self, start: u32, end: u32) {
        if start < end {
            self.list[self.len] = [start, end];
            self.len += 1;
        }
    }
}
