//! Columns: the rows of a table field by field. A table's columns are declared once, with
//! `columns!`; room for rows, growing, pushing, appending and taking rows by an order follow.
//!
//! A column is a plain vector, padded by [`LANES`] rows so that the last ones can be read eight at
//! a time. These are columns, each in any of the others:
//!
//! | columns | a row holds |
//! |---|---|
//! | [`Column`] | a float |
//! | `Vec<T>` for a [`Value`] `T` | an identifier, a packed number, a short array |
//! | `[C; K]` of columns `C` | a vector, a value per wavelength ([`Channels`]), a matrix |
//! | a struct that `columns!` declares | what its fields hold |
//!
//! Columns that a table does without are absent: vectors without even the padding, which every
//! operation here passes over.

mod declare;

use std::ops::Range;

use super::LANES;

pub(crate) use declare::columns;

/// One float per row.
pub type Column = Vec<f32>;

/// One float per row and wavelength.
pub type Channels<const N: usize> = [Column; N];

/// What a row of a plain column holds.
pub trait Value: Copy + Send + Sync + 'static {
    /// What it holds if nothing was written and nothing else is said.
    const ZERO: Self;
}

impl Value for f32 {
    const ZERO: Self = 0.0;
}

impl Value for u32 {
    const ZERO: Self = 0;
}

impl Value for i16 {
    const ZERO: Self = 0;
}

impl<T: Value, const K: usize> Value for [T; K] {
    const ZERO: Self = [T::ZERO; K];
}

/// One or more columns with the same rows.
pub trait Columns: Sized {
    /// What rows hold that nothing was written to.
    type Fill: Copy;
    /// The fill of columns that are declared without one.
    const ZERO: Self::Fill;

    /// Columns of so many rows, padding included.
    fn filled(rows: usize, fill: Self::Fill) -> Self;

    /// No columns.
    fn absent() -> Self;

    /// Makes the columns that are present so many rows long, padding included.
    fn lengthen(&mut self, rows: usize, fill: Self::Fill);

    /// Rows of the first column that is present, padding included; 0 if none is.
    fn room(&self) -> usize;

    /// Memory of a row in the columns that are present.
    fn bytes_per_row(&self) -> usize;

    /// Does `work` for every column that is present, with its counterpart in another table.
    fn each_with(&mut self, from: &Self, work: &impl PairWork);

    /// Does `work` for every column that is present.
    fn each(&mut self, work: &impl ColumnWork);

    /// Columns for `capacity` rows.
    fn with_room(capacity: usize) -> Self {
        Self::filled(capacity + LANES, Self::ZERO)
    }

    /// Takes the rows `order` of `from` to the rows from `start` on.
    #[inline(always)]
    fn take_rows(&mut self, from: &Self, order: &[u32], start: usize) {
        self.each_with(from, &Take { order, start });
    }

    /// Copies the rows `rows` of `from` to the rows from `start` on.
    #[inline(always)]
    fn copy_rows(&mut self, from: &Self, rows: Range<usize>, start: usize) {
        self.each_with(from, &Copying { rows, start });
    }
}

/// Columns that are read and written row by row, too.
pub trait Rows: Columns {
    /// What one row holds, of all columns.
    type Row: Copy;

    /// Reads a row.
    fn get(&self, row: usize) -> Self::Row;

    /// Writes a row.
    fn set(&mut self, row: usize, value: Self::Row);
}

/// Work on a column and its counterpart in another table.
pub trait PairWork {
    /// Does it.
    fn column<T: Value>(&self, to: &mut [T], from: &[T]);
}

/// Work on a column.
pub trait ColumnWork {
    /// Does it; the column keeps its length.
    fn column<T: Value>(&self, column: &mut Vec<T>);
}

/// Takes the rows `order` of a column to the rows from `start` on.
// A call for each column, out of line: tables have dozens of them, and so do places that take rows.
#[inline(never)]
pub fn take<T: Copy>(to: &mut [T], from: &[T], order: &[u32], start: usize) {
    let (to, ends) = to[start..start + order.len()].as_chunks_mut::<LANES>();
    let (order, last) = order.as_chunks::<LANES>();
    for (to, rows) in to.iter_mut().zip(order) {
        for (to, &row) in to.iter_mut().zip(rows) {
            *to = from[row as usize];
        }
    }
    for (to, &row) in ends.iter_mut().zip(last) {
        *to = from[row as usize];
    }
}

struct Take<'a> {
    order: &'a [u32],
    start: usize,
}

impl PairWork for Take<'_> {
    #[inline(always)]
    fn column<T: Value>(&self, to: &mut [T], from: &[T]) {
        take(to, from, self.order, self.start);
    }
}

struct Copying {
    rows: Range<usize>,
    start: usize,
}

impl PairWork for Copying {
    #[inline(never)]
    fn column<T: Value>(&self, to: &mut [T], from: &[T]) {
        to[self.start..self.start + self.rows.len()].copy_from_slice(&from[self.rows.clone()]);
    }
}

impl<T: Value> Columns for Vec<T> {
    type Fill = T;
    const ZERO: T = T::ZERO;

    #[inline(never)]
    fn filled(rows: usize, fill: T) -> Self {
        vec![fill; rows]
    }

    fn absent() -> Self {
        Self::new()
    }

    fn lengthen(&mut self, rows: usize, fill: T) {
        if !self.is_empty() {
            self.resize(rows, fill);
        }
    }

    #[inline(always)]
    fn room(&self) -> usize {
        self.len()
    }

    fn bytes_per_row(&self) -> usize {
        if self.is_empty() { 0 } else { size_of::<T>() }
    }

    #[inline(always)]
    fn each_with(&mut self, from: &Self, work: &impl PairWork) {
        if !self.is_empty() {
            work.column(self, from);
        }
    }

    fn each(&mut self, work: &impl ColumnWork) {
        if !self.is_empty() {
            work.column(self);
        }
    }
}

impl<T: Value> Rows for Vec<T> {
    type Row = T;

    #[inline(always)]
    fn get(&self, row: usize) -> T {
        self[row]
    }

    #[inline(always)]
    fn set(&mut self, row: usize, value: T) {
        self[row] = value;
    }
}

impl<C: Columns, const K: usize> Columns for [C; K] {
    type Fill = C::Fill;
    const ZERO: C::Fill = C::ZERO;

    fn filled(rows: usize, fill: C::Fill) -> Self {
        std::array::from_fn(|_| C::filled(rows, fill))
    }

    fn absent() -> Self {
        std::array::from_fn(|_| C::absent())
    }

    fn lengthen(&mut self, rows: usize, fill: C::Fill) {
        self.iter_mut().for_each(|columns| columns.lengthen(rows, fill));
    }

    #[inline(always)]
    fn room(&self) -> usize {
        self.iter().map(C::room).find(|&room| room > 0).unwrap_or(0)
    }

    fn bytes_per_row(&self) -> usize {
        self.iter().map(C::bytes_per_row).sum()
    }

    #[inline(always)]
    fn each_with(&mut self, from: &Self, work: &impl PairWork) {
        for (columns, from) in self.iter_mut().zip(from) {
            columns.each_with(from, work);
        }
    }

    fn each(&mut self, work: &impl ColumnWork) {
        self.iter_mut().for_each(|columns| columns.each(work));
    }
}

impl<C: Rows, const K: usize> Rows for [C; K] {
    type Row = [C::Row; K];

    #[inline(always)]
    fn get(&self, row: usize) -> Self::Row {
        std::array::from_fn(|index| self[index].get(row))
    }

    #[inline(always)]
    fn set(&mut self, row: usize, value: Self::Row) {
        for (columns, value) in self.iter_mut().zip(value) {
            columns.set(row, value);
        }
    }
}
