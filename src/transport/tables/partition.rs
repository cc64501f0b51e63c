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
    starts: Vec<u32>,
}

/// Key of a row that ends.
const DROPPED: u8 = u8::MAX;

/// The kinds that scatter, in the order of their rows.
const KINDS: [MaterialKind; 5] = [
    MaterialKind::Diffuse,
    MaterialKind::Conductor,
    MaterialKind::Dielectric,
    MaterialKind::Polarizer,
    MaterialKind::Retarder,
];

impl Partition {
    /// Groups the rows `0..rows`; `kind_and_class` is none for rows that end.
    pub fn group(
        &mut self,
        rows: usize,
        classes: usize,
        kind_and_class: impl Fn(usize) -> Option<(MaterialKind, usize)>,
    ) {
        self.keys.clear();
        self.starts.clear();
        self.starts.resize(KINDS.len() * classes + 1, 0);
        for row in 0..rows {
            let key = match kind_and_class(row) {
                Some((kind, class)) if kind != MaterialKind::Absorber => {
                    let key = (kind as usize - MaterialKind::Diffuse as usize) * classes + class;
                    self.starts[key + 1] += 1;
                    key as u8
                }
                _ => DROPPED,
            };
            self.keys.push(key);
        }
        self.list_parts(classes);
        self.order.clear();
        self.order.resize(self.starts[KINDS.len() * classes] as usize, 0);
        for (row, &key) in self.keys.iter().enumerate() {
            if key != DROPPED {
                let place = &mut self.starts[key as usize];
                self.order[*place as usize] = row as u32;
                *place += 1;
            }
        }
    }

    /// All rows of one kind; they are contiguous.
    pub fn rows_of(&self, kind: MaterialKind) -> Range<usize> {
        let mut parts = self.parts.iter().filter(|part| part.kind == kind);
        let Some(first) = parts.next() else { return 0..0 };
        first.rows.start..parts.next_back().unwrap_or(first).rows.end
    }

    /// Turns the counts in `starts` into running sums and the parts that they bound.
    fn list_parts(&mut self, classes: usize) {
        self.parts.clear();
        for key in 0..KINDS.len() * classes {
            let start = self.starts[key];
            self.starts[key + 1] += start;
            let rows = start as usize..self.starts[key + 1] as usize;
            if !rows.is_empty() {
                self.parts.push(Part { kind: KINDS[key / classes], class: key % classes, rows });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_stable_and_drop_the_dead() {
        use MaterialKind::{Absorber, Dielectric, Diffuse, Retarder};
        let rows = [
            Some((Dielectric, 1)),
            Some((Diffuse, 0)),
            None,
            Some((Retarder, 1)),
            Some((Absorber, 0)),
            Some((Diffuse, 0)),
            Some((Dielectric, 0)),
            Some((Dielectric, 1)),
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
