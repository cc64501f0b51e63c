//! The unit of work: a tile of pixels for a few iterations, small enough to stay in the L2 cache
//! through all stages. Chunks are independent; threads take chunks.

use crate::scattering::{Sensor, Side};

use super::bounce::Sampling;

/// Edge of a tile in pixels.
pub const TILE: u32 = 16;
/// Iterations that a chunk takes together.
pub const ITERATIONS: u32 = 4;
/// Edge of a tile in pixels where a chunk has one iteration alone.
pub const WIDE_TILE: u32 = 2 * TILE;
/// Most rows that a chunk starts with.
pub const ROWS: usize = (TILE * TILE * ITERATIONS) as usize;

/// What one chunk has to do.
#[derive(Clone, Debug)]
pub struct Chunk {
    /// Left edge of the tile in pixels, of those that samples are taken in (`Layout::sampled`).
    pub x: u32,
    /// Top edge of the tile in pixels, likewise.
    pub y: u32,
    /// Width of the tile, at most [`TILE`], or [`WIDE_TILE`] with a single iteration.
    pub width: u32,
    /// Height of the tile, likewise.
    pub height: u32,
    /// Index of the first iteration in the random sequences.
    pub first_iteration: u32,
    /// Number of iterations, at most [`ITERATIONS`]; all have the same wavelengths.
    pub iterations: u32,
    /// Seed of all random sequences.
    pub seed: u32,
    /// Most segments of a path.
    pub path_length_max: u32,
    /// Path length from which on roulette may end a path, by [`Side`].
    pub roulette_after: [u32; 2],
    /// What directions are drawn by.
    pub sampling: Sampling,
    /// How paths share random sequences.
    pub sequence: Sequence,
    /// Whether the pixels of the tile are rendered. Where they are not, paths from emitters are
    /// traced alone, for what they bring to those that are.
    pub is_seen: bool,
}

/// How the paths of a chunk share random sequences.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sequence {
    /// Each path has its own, which its iterations stratify.
    PerPath,
    /// All paths of a row have the same, so that they are stratified among each other: photons.
    Shared,
}

impl Chunk {
    /// Number of pixels of the tile.
    pub fn pixels(&self) -> usize {
        (self.width * self.height) as usize
    }

    /// Number of slots: pixels times iterations.
    pub fn slots(&self) -> usize {
        self.pixels() * self.iterations as usize
    }

    /// Column and row, of those that samples are taken in, and iteration, of a slot.
    pub fn place(&self, slot: usize) -> (u32, u32, u32) {
        let pixel = (slot % self.pixels()) as u32;
        let iteration = self.first_iteration + (slot / self.pixels()) as u32;
        (self.x + pixel % self.width, self.y + pixel / self.width, iteration)
    }

    /// What the random numbers of a slot are drawn by: the path and the index in its sequence.
    pub fn sequence_of(&self, slot: usize, sensor: &Sensor) -> (u32, u32) {
        let (column, line, iteration) = self.place(slot);
        match self.sequence {
            Sequence::PerPath => (sensor.path_of([column, line]), iteration),
            Sequence::Shared => (self.x, iteration.wrapping_mul(ROWS as u32) + slot as u32),
        }
    }

    /// Whether roulette plays for paths of a side after `path_length` segments.
    pub fn plays_roulette(&self, side: Side, path_length: u32) -> bool {
        path_length >= self.roulette_after[side as usize]
    }
}

/// The tiles of a film, row by row: left, top, width, height, of which the last two are `edge` at
/// most.
pub fn tiles(size: [u32; 2], edge: u32) -> Vec<[u32; 4]> {
    aligned_tiles(([0; 2], size), edge)
}

/// The tiles of an area, by its start and size: those that all of the film has, cut off where it
/// ends.
pub fn aligned_tiles((start, size): ([u32; 2], [u32; 2]), edge: u32) -> Vec<[u32; 4]> {
    let pieces = |axis: usize| {
        let [first, end] = [start[axis], start[axis] + size[axis]];
        let starts = (first / edge * edge..end).step_by(edge as usize);
        starts.map(move |at| [at.max(first), end.min(at + edge)]).filter(|[from, to]| from < to)
    };
    pieces(1)
        .flat_map(|[top, below]| {
            pieces(0).map(move |[left, right]| [left, top, right - left, below - top])
        })
        .collect()
}
