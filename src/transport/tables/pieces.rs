//! Pieces of segments that lie within one medium, and lamps are looked for from.

use crate::math::columns::{Column, columns};
use crate::math::{LANES, lanes};
use crate::scene::baked::NONE;

columns! {
    /// Pieces in one medium, of segments that have come to where they begin.
    pub table PieceTable of Piece {
        /// The path.
        pub row: Vec<u32>,
        /// Where it begins, from the segment's start.
        pub from: Column,
        /// Where it ends unless the path meets a particle of the medium before.
        pub to: Column,
        /// The lamp that is looked for: a row of the scene's emitters.
        pub lamp: Vec<u32>,
        /// The probability of that.
        pub chance: Column,
        /// A random number in [0, 1) for the place to look from.
        pub place: Column,
    } beside {
        /// The medium that all of them lie in.
        pub medium: u32 = NONE,
    }
}

columns! {
    /// For paths that have met particles, the pieces of their segments within that medium.
    pub struct LastPieceColumns {
        /// As in [`PieceTable`].
        pub from: Column,
        /// As in [`PieceTable`].
        pub to: Column,
    }
}

impl LastPieceColumns {
    /// Whether there are columns at all.
    #[inline(always)]
    pub fn present(&self) -> bool {
        !self.from.is_empty()
    }

    /// Makes the columns for `capacity` rows, unless there are.
    pub fn make(&mut self, capacity: usize) {
        if !self.present() {
            *self = Self::new(capacity);
        }
    }
}

impl PieceTable {
    /// A row, or the last one for what is beyond.
    #[inline(always)]
    pub fn in_use(&self, row: usize) -> usize {
        row.min(self.len - 1)
    }

    /// The paths of the eight rows from `first` on.
    #[inline(always)]
    pub fn rows_of_paths(&self, first: usize) -> [usize; LANES] {
        lanes::each(|lane| self.row[self.in_use(first + lane)] as usize)
    }
}
