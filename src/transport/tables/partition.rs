//! Rows grouped by what happens to them next, so that every group is one branch-free loop.

use std::ops::Range;

use crate::scene::baked::MaterialKind;

/// The rows that one loop works on: one kind of material, one class of carrier.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// What the rows have hit.
    pub kind: MaterialKind,
    /// Class of their carriers (`carriers`).
    pub class: usize,
    /// The rows.
    pub rows: Range<usize>,
}

/// A stable grouping of rows by material kind, then carrier class.
#[derive(Default)]
pub struct Partition {
    /// For every new row, the old one; rows that end here are missing.
    pub order: Vec<u32>,
    /// The groups, in the order of the new rows; none is empty.
    pub parts: Vec<Part>,
    keys: Vec<u8>,
    counts: Vec<u32>,
}

/// The kinds that scatter, in the order of their rows.
const KINDS: [MaterialKind; 5] = [
    MaterialKind::Diffuse,
    MaterialKind::Conductor,
    MaterialKind::Dielectric,
    MaterialKind::Polarizer,
    MaterialKind::Retarder,
];

impl Partition {
    /// Groups the rows `0..rows`; rows whose kind is [`MaterialKind::Absorber`] end.
    pub fn group(
        &mut self,
        rows: usize,
        classes: usize,
        kind_and_class: impl Fn(usize) -> (MaterialKind, usize),
    ) {
        // Key 0 is that of the rows that end: they are sorted like the others, without a branch
        // that would be guessed wrong, and cut off in the end.
        let keys = KINDS.len() * classes + 1;
        self.keys.clear();
        self.counts.clear();
        self.counts.resize(keys, 0);
        for row in 0..rows {
            let (kind, class) = kind_and_class(row);
            let place = (kind as usize).wrapping_sub(MaterialKind::Diffuse as usize);
            let key = place.wrapping_mul(classes).wrapping_add(class + 1);
            let key = if kind == MaterialKind::Absorber { 0 } else { key };
            self.counts[key] += 1;
            self.keys.push(key as u8);
        }
        let ended = self.list_parts(classes);
        self.order.clear();
        self.order.resize(rows, 0);
        for (row, &key) in self.keys.iter().enumerate() {
            let place = &mut self.counts[key as usize];
            self.order[*place as usize] = row as u32;
            *place += 1;
        }
        self.order.truncate(rows - ended);
    }

    /// All rows of one kind; they are contiguous.
    pub fn rows_of(&self, kind: MaterialKind) -> Range<usize> {
        let mut parts = self.parts.iter().filter(|part| part.kind == kind);
        let Some(first) = parts.next() else { return 0..0 };
        first.rows.start..parts.next_back().unwrap_or(first).rows.end
    }

    /// Turns the counts into the first place of each key, those of key 0 behind all others, lists
    /// the parts, and returns how many rows end.
    fn list_parts(&mut self, classes: usize) -> usize {
        self.parts.clear();
        let mut start = 0;
        for key in 1..self.counts.len() {
            let end = start + self.counts[key];
            if end > start {
                let (kind, class) = (KINDS[(key - 1) / classes], (key - 1) % classes);
                self.parts.push(Part { kind, class, rows: start as usize..end as usize });
            }
            self.counts[key] = start;
            start = end;
        }
        std::mem::replace(&mut self.counts[0], start) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_stable_and_drop_the_dead() {
        use MaterialKind::{Absorber, Dielectric, Diffuse, Retarder};
        let rows = [
            (Dielectric, 1),
            (Diffuse, 0),
            (Absorber, 1),
            (Retarder, 1),
            (Absorber, 0),
            (Diffuse, 0),
            (Dielectric, 0),
            (Dielectric, 1),
        ];
        let mut partition = Partition::default();
        partition.group(rows.len(), 2, |row| rows[row]);
        assert_eq!(partition.order, [1, 5, 6, 0, 7, 3]);
        assert_eq!(partition.rows_of(Diffuse), 0..2);
        assert_eq!(partition.rows_of(Dielectric), 2..5);
        assert_eq!(partition.rows_of(MaterialKind::Conductor), 0..0);
        assert_eq!(partition.parts.len(), 4);
    }
}
