//! Polarization as components that rows have or lack.
//!
//! The class of a row says which columns exist for it; all else is known without storage:
//!
//! | side | class | columns | when |
//! |---|---|---|---|
//! | light | [`UNPOLARIZED`] | none | emitted unpolarized, or after a depolarizer |
//! | light | [`POLARIZED`] | Stokes, axis | after a polarizing event |
//! | sensor | [`FRESH`] | none: T = 1 in the film's frame | no event yet |
//! | sensor | [`PLAIN`] | none: c = r = e0 | after a depolarizer, nothing polarizing before |
//! | | | | (a film of intensities counts as one) |
//! | sensor | [`ROW`] | r, axis | a `PLAIN` row that met polarizing events since |
//! | sensor | [`COLUMN`] | c | polarizing events, then a depolarizer |
//! | sensor | [`RANK_ONE`] | c, r, axis | a `COLUMN` row that met polarizing events since |
//! | sensor | [`FULL`] | T, axis | polarizing events, no depolarizer yet |
//! | sensor | [`COMMON`] | T once, axis | the same, and no event has told wavelengths apart |
//!
//! After the first depolarizer T D = (T e0)(d e0^T) has rank one for ever: the column c is fixed
//! and only the row r is extended. Depolarizers fold what scales the intensity (r0, or T00 and the
//! light side's s0) into the throughput `beta`, so c is stored relative to its first element.

use super::partition::Part;
use super::{Channels, Column, channels, gather, vectors};

/// Light side: no columns.
pub const UNPOLARIZED: usize = 0;
/// Light side: `stokes` and `axis`.
pub const POLARIZED: usize = 1;

/// Sensor side: identity in the film's frame.
pub const FRESH: usize = 0;
/// Sensor side: intensity in, intensity out.
pub const PLAIN: usize = 1;
/// Sensor side: intensity out, `row` in.
pub const ROW: usize = 2;
/// Sensor side: `column` out, intensity in.
pub const COLUMN: usize = 3;
/// Sensor side: `column` out, `row` in.
pub const RANK_ONE: usize = 4;
/// Sensor side: `matrix`.
pub const FULL: usize = 5;
/// Sensor side: the first wavelength's `matrix`, for all of them. With one wavelength it is
/// [`FULL`].
pub const COMMON: usize = 6;

/// Columns of polarization that travel with the rows of a path table.
pub trait CarrierTable {
    /// Number of classes.
    const CLASSES: usize;

    /// An empty table for `capacity` rows.
    fn new(capacity: usize) -> Self;

    /// The class of a row.
    fn class(&self, row: usize) -> usize;

    /// Takes the rows `order[part.rows]` of `from`, all of one class, to `part.rows`: of those that
    /// meet a depolarizer, no more than what it leaves of them.
    fn gather(&mut self, from: &Self, order: &[u32], part: &Part);
}

/// Scalar mode: no columns at all.
impl CarrierTable for () {
    const CLASSES: usize = 1;
    fn new(_capacity: usize) -> Self {}
    #[inline(always)]
    fn class(&self, _row: usize) -> usize {
        0
    }
    #[inline(always)]
    fn gather(&mut self, _from: &Self, _order: &[u32], _part: &Part) {}
}

/// The light side's Stokes vectors, relative to the scalar throughput.
pub struct LightCarriers<const N: usize> {
    /// Class of every row.
    pub class: Vec<u8>,
    /// The x axis of the frame, perpendicular to the ray.
    pub axis: [Column; 3],
    /// S0..S3 over what the scalar renderer carries.
    pub stokes: [Channels<N>; 4],
}

/// The sensor side's matrices, relative to the scalar throughput.
pub struct SensorCarriers<const N: usize> {
    /// Class of every row.
    pub class: Vec<u8>,
    /// The x axis of the frame in which light is accepted, perpendicular to the ray.
    pub axis: [Column; 3],
    /// c1..c3 over c0.
    pub column: [Channels<N>; 3],
    /// r0..r3.
    pub row: [Channels<N>; 4],
    /// T, `[row][column]`.
    pub matrix: [[Channels<N>; 4]; 4],
}

impl<const N: usize> CarrierTable for LightCarriers<N> {
    const CLASSES: usize = 2;

    fn new(capacity: usize) -> Self {
        Self {
            class: vec![UNPOLARIZED as u8; capacity],
            axis: vectors(capacity),
            stokes: std::array::from_fn(|_| channels(capacity)),
        }
    }

    #[inline(always)]
    fn class(&self, row: usize) -> usize {
        self.class[row] as usize
    }

    fn gather(&mut self, from: &Self, order: &[u32], part: &Part) {
        let rows = part.rows.clone();
        self.class[rows.clone()].fill(part.class as u8);
        if part.class != POLARIZED {
            return;
        }
        let order = &order[rows.clone()];
        if part.is_depolarized() {
            return gather_group(&mut self.stokes[0], &from.stokes[0], order, rows.start);
        }
        gather_group(&mut self.axis, &from.axis, order, rows.start);
        for (to, from) in self.stokes.iter_mut().zip(&from.stokes) {
            gather_group(to, from, order, rows.start);
        }
    }
}

impl<const N: usize> CarrierTable for SensorCarriers<N> {
    const CLASSES: usize = 7;

    fn new(capacity: usize) -> Self {
        Self {
            class: vec![FRESH as u8; capacity],
            axis: vectors(capacity),
            column: std::array::from_fn(|_| channels(capacity)),
            row: std::array::from_fn(|_| channels(capacity)),
            matrix: std::array::from_fn(|_| std::array::from_fn(|_| channels(capacity))),
        }
    }

    #[inline(always)]
    fn class(&self, row: usize) -> usize {
        self.class[row] as usize
    }

    fn gather(&mut self, from: &Self, order: &[u32], part: &Part) {
        let (class, rows) = (part.class, part.rows.clone());
        self.class[rows.clone()].fill(class as u8);
        let order = &order[rows.clone()];
        // What is accepted after a depolarizer is intensity.
        let accepted = if part.is_depolarized() { 1 } else { 4 };
        if matches!(class, ROW | RANK_ONE | FULL | COMMON) && accepted > 1 {
            gather_group(&mut self.axis, &from.axis, order, rows.start);
        }
        if matches!(class, COLUMN | RANK_ONE) {
            for (to, from) in self.column.iter_mut().zip(&from.column) {
                gather_group(to, from, order, rows.start);
            }
        }
        if matches!(class, ROW | RANK_ONE) {
            for (to, from) in self.row[..accepted].iter_mut().zip(&from.row) {
                gather_group(to, from, order, rows.start);
            }
        }
        if matches!(class, FULL | COMMON) {
            let wavelengths = if class == COMMON { 1 } else { N };
            for (to, from) in self.matrix.iter_mut().zip(&from.matrix) {
                for (to, from) in to[..accepted].iter_mut().zip(from) {
                    gather_group(&mut to[..wavelengths], from, order, rows.start);
                }
            }
        }
    }
}

fn gather_group(to: &mut [Column], from: &[Column], order: &[u32], start: usize) {
    for (to, from) in to.iter_mut().zip(from) {
        gather(to, from, order, start);
    }
}
