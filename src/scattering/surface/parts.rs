//! What models have in common that are made of rows of others.

use super::model::LaneRows;
use crate::math::{F32s, lanes};

/// A row in the table of one of several models.
#[derive(Clone, Copy, Debug)]
pub struct Part<K> {
    /// Which model.
    pub kind: K,
    /// Its row.
    pub row: usize,
}

/// Calls `each` with every kind that the parts of some of the lanes (`among`) are of, where
/// `part_of` says the part of a row: with its rows in the table of that kind, and the mask of the
/// lanes.
pub fn each_kind<K: Copy + PartialEq>(
    rows: LaneRows,
    part_of: impl Fn(usize) -> Part<K>,
    among: F32s,
    mut each: impl FnMut(K, &LaneRows, F32s),
) {
    let rows = match rows {
        LaneRows::Same(row) => {
            let Part { kind, row } = part_of(row);
            return each(kind, &LaneRows::Same(row), among);
        }
        LaneRows::Each(rows) => rows,
    };
    let parts = rows.map(part_of);
    let mut left = among;
    while left.any() {
        let Part { kind, row } = parts[left.to_bitmask().trailing_zeros() as usize];
        let is_one = |part: &Part<K>| part.kind == kind;
        let of_kind = parts.each_ref().map(|it| if is_one(it) { it.row } else { row });
        let mask = left & lanes::mask_of(parts.each_ref().map(is_one));
        each(kind, &LaneRows::Each(of_kind), mask);
        left &= !mask;
    }
}
