//! Photons: light that arrived somewhere, as columns that gathering reads eight rows at a time.
//!
//! A photon is where it is, along which direction its light travels and what power it carries.
//! Photons on depolarizing surfaces need no more, in either mode: such a surface scatters the
//! intensity alone. Those in polarizing media keep their Stokes state relative to the intensity,
//! once for all wavelengths until an event depended on wavelength. The class says which:
//!
//! | class | columns beside position, direction, power | bytes, RGB |
//! |---|---|---|
//! | [`PhotonClass::Power`] | none | 28 |
//! | [`PhotonClass::Stokes`] | s1 s2 s3 | 34 |
//! | [`PhotonClass::SpectralStokes`] | s1 s2 s3 per wavelength | 46 |
//!
//! The lowest six bits of the first wavelength's power hold the segments of the photon's path, so
//! that paths can be kept within a length; that rounds the power by 8e-6 at most.
//!
//! The frame of the Stokes state is the canonical one of the direction *as stored*,
//! [`Vector::any_perpendicular`] of [`PhotonTable::directions`], so no axis is stored: rotate into
//! the frame of the rounded direction ([`round_directions`]) before storing.

use std::ops::Range;

use wide::i32x8;

use crate::math::columns::{Channels, Column, Columns, columns};
use crate::math::{F32s, LANES, Real, U32s, Vector, lanes};

/// Which columns of polarization the photons of a table have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhotonClass {
    /// None.
    Power,
    /// One Stokes state for all wavelengths, in channel 0.
    Stokes,
    /// One Stokes state per wavelength.
    SpectralStokes,
}

impl PhotonClass {
    /// Channels of the Stokes columns in use when there are `wavelengths`.
    #[inline(always)]
    pub fn channels(self, wavelengths: usize) -> usize {
        match self {
            Self::Power => 0,
            Self::Stokes => wavelengths.min(1),
            Self::SpectralStokes => wavelengths,
        }
    }
}

columns! {
    /// Photons of one class. Columns that the class lacks are absent.
    pub table PhotonTable<const N: usize> {
        /// Where, in scene units.
        pub position: [Column; 3],
        /// Along which unit vector the light travels, packed by [`pack_directions`].
        pub direction: Vec<u32>,
        /// Power per wavelength.
        pub power: Channels<N>,
        /// s1..s3 over s0 by wavelength, packed by [`lanes::store_signed`].
        pub stokes: [[Vec<i16>; N]; 3],
    } beside {
        /// Which columns there are.
        pub class: PhotonClass = PhotonClass::SpectralStokes,
    }
}

impl<const N: usize> PhotonTable<N> {
    /// An empty table for `capacity` rows; it grows if more come.
    pub fn of_class(class: PhotonClass, capacity: usize) -> Self {
        let mut table = Self { class, ..Self::new(capacity) };
        for group in &mut table.stokes {
            group[class.channels(N)..].fill_with(Columns::absent);
        }
        table
    }

    /// Removes all rows and keeps the memory.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Appends the first `live` lanes, at most eight. The Stokes states of the new rows, if the
    /// class has any, are to be stored by [`PhotonTable::store_stokes`].
    #[inline(always)]
    pub fn append_lanes(
        &mut self,
        position: Vector<F32s>,
        direction: Vector<F32s>,
        power: &[F32s; N],
        live: usize,
    ) {
        self.reserve(live);
        let (row, end) = (self.len, self.len + live);
        position.store(&mut self.position, row, end);
        let packed = pack_directions(direction).to_array();
        self.direction[row..end].copy_from_slice(&packed[..live]);
        for (column, value) in self.power.iter_mut().zip(power) {
            lanes::store(column, row, end, *value);
        }
        self.len = end;
    }

    /// Appends the rows `rows` of columns of floats, padded like those of a table.
    pub fn append_columns(
        &mut self,
        position: &[Column; 3],
        direction: &[Column; 3],
        power: &Channels<N>,
        rows: Range<usize>,
    ) {
        self.reserve(rows.len());
        for row in rows.clone().step_by(LANES) {
            let live = LANES.min(rows.end - row);
            let mut values = [F32s::ZERO; N];
            for n in 0..N {
                values[n] = lanes::load(&power[n], row);
            }
            let (position, direction) = (Vector::load(position, row), Vector::load(direction, row));
            self.append_lanes(position, direction, &values, live);
        }
    }

    /// Appends all rows of another table of the same class.
    pub fn append_table(&mut self, from: &Self) {
        assert_eq!(self.class, from.class, "photons of different classes");
        self.append(from);
    }

    /// Stores s1..s3 of wavelength `channel` over s0, each in [-1, 1], for the rows from `row` to
    /// `end`, at most eight. Class [`PhotonClass::Stokes`] has channel 0 alone.
    #[inline(always)]
    pub fn store_stokes(&mut self, row: usize, end: usize, channel: usize, states: [F32s; 3]) {
        for (group, state) in self.stokes.iter_mut().zip(&states) {
            lanes::store_signed(&mut group[channel], row, end, *state);
        }
    }

    /// The directions in which the light of the eight rows from `row` on travels, unit length.
    #[inline(always)]
    pub fn directions(&self, row: usize) -> Vector<F32s> {
        unpack_directions(lanes::load_u32(&self.direction, row))
    }

    /// Notes the segments of their paths in the powers of the rows from `start` on.
    pub fn note_path_length(&mut self, start: usize, path_length: u32) {
        let length = path_length.min(PATH_LENGTH_MAX);
        for power in &mut self.power[0][start..self.len] {
            *power = f32::from_bits((power.to_bits() & !PATH_LENGTH_MAX) | length);
        }
    }

    /// The mask of those of the eight rows from `row` on whose paths have `length_max` segments
    /// at most; all that have [`PATH_LENGTH_MAX`] or more count as having that many.
    #[inline(always)]
    pub fn no_longer_than(&self, row: usize, length_max: u32) -> F32s {
        let bits: U32s = bytemuck::cast(lanes::load(&self.power[0], row));
        let length = bits & U32s::splat(PATH_LENGTH_MAX);
        bytemuck::cast(length.simd_le(U32s::splat(length_max)))
    }

    /// [`PhotonTable::directions`] of any eight rows.
    #[inline(always)]
    pub fn directions_of(&self, rows: &[u32; LANES]) -> Vector<F32s> {
        unpack_directions(U32s::from(lanes::each(|lane| self.direction[rows[lane] as usize])))
    }

    /// The power at a wavelength of any eight rows.
    #[inline(always)]
    pub fn power_of(&self, rows: &[u32; LANES], wavelength: usize) -> F32s {
        let power = &self.power[wavelength];
        F32s::from(lanes::each(|lane| power[rows[lane] as usize]))
    }

    /// [`PhotonTable::states`] of any eight rows.
    #[inline(always)]
    pub fn states_of(&self, rows: &[u32; LANES], wavelength: usize) -> [F32s; 3] {
        let channel = if self.class == PhotonClass::Stokes { 0 } else { wavelength };
        let mut states = [F32s::ZERO; 3];
        for (state, group) in states.iter_mut().zip(&self.stokes) {
            let column = &group[channel];
            *state = lanes::load_signed(&lanes::each(|lane| column[rows[lane] as usize]), 0);
        }
        states
    }

    /// [`PhotonTable::directions`] times some positive length: enough to tell sides, and cheaper.
    #[inline(always)]
    pub fn directions_of_any_length(&self, row: usize) -> Vector<F32s> {
        unpack_octahedral(lanes::load_u32(&self.direction, row))
    }

    /// s1..s3 of the eight rows from `row` on over s0, in the canonical frame of
    /// [`PhotonTable::directions`]. Not for [`PhotonClass::Power`].
    #[inline(always)]
    pub fn states(&self, row: usize, wavelength: usize) -> [F32s; 3] {
        let channel = if self.class == PhotonClass::Stokes { 0 } else { wavelength };
        let mut states = [F32s::ZERO; 3];
        for (state, group) in states.iter_mut().zip(&self.stokes) {
            *state = lanes::load_signed(&group[channel], row);
        }
        states
    }
}

/// Longest path that photons can tell from longer ones, in segments: all ones.
pub const PATH_LENGTH_MAX: u32 = 63;

/// Steps from the middle to a corner of the octahedral map, along either axis.
const STEPS: f32 = 32767.0;

/// Unit vectors in 32 bits (Cigolle et al. 2014, "A survey of efficient representations for
/// independent unit vectors", octahedral map in 2 x 16 bits): at most 6.5e-5 radians off, and exact
/// along the coordinate axes.
#[inline(always)]
pub fn pack_directions(direction: Vector<F32s>) -> U32s {
    let one = F32s::ONE;
    let (x, y) = (direction.x, direction.y);
    let scale = one / (x.abs() + y.abs() + direction.z.abs());
    let (x, y) = (x * scale, y * scale);
    let below = direction.z.lt(F32s::ZERO);
    let folded_x = sign_of(x, one - y.abs());
    let folded_y = sign_of(y, one - x.abs());
    let steps = F32s::splat(STEPS);
    let x: U32s = bytemuck::cast((below.bitselect(folded_x, x) * steps).round_int());
    let y: U32s = bytemuck::cast((below.bitselect(folded_y, y) * steps).round_int());
    (x & U32s::splat(0xffff)) | (y << 16)
}

/// The inverse of [`pack_directions`].
#[inline(always)]
pub fn unpack_directions(packed: U32s) -> Vector<F32s> {
    unpack_octahedral(packed).normalize()
}

/// The unit vectors nearest to `direction` that a photon can have.
#[inline(always)]
pub fn round_directions(direction: Vector<F32s>) -> Vector<F32s> {
    unpack_directions(pack_directions(direction))
}

/// The point of the octahedron, whose corners are [`STEPS`] from its center.
#[inline(always)]
fn unpack_octahedral(packed: U32s) -> Vector<F32s> {
    let signed = |bits: U32s| (bytemuck::cast::<U32s, i32x8>(bits) >> 16_i32).round_float();
    let (x, y) = (signed(packed << 16), signed(packed));
    let z = F32s::splat(STEPS) - x.abs() - y.abs();
    let fold = (-z).fast_max(F32s::ZERO);
    Vector { x: x - sign_of(x, fold), y: y - sign_of(y, fold), z }
}

/// `magnitude` where `sign` is not negative, `-magnitude` elsewhere.
#[inline(always)]
fn sign_of(sign: F32s, magnitude: F32s) -> F32s {
    sign.lt(F32s::ZERO).bitselect(-magnitude, magnitude)
}

#[cfg(test)]
mod tests {
    use super::super::{channels, vectors};
    use super::*;
    use crate::math::{hash, warp};

    fn uniform(salt: u32, row: u32) -> F32s {
        let bits = lanes::each(|lane| hash::combine(salt, LANES as u32 * row + lane as u32));
        F32s::from(lanes::each(|lane| (bits[lane] >> 8) as f32 / (1 << 24) as f32))
    }

    fn direction(row: u32) -> Vector<F32s> {
        let zero = F32s::ZERO;
        let up = Vector { x: zero, y: zero, z: F32s::ONE };
        warp::cone(up, F32s::splat(-1.0), [uniform(1, row), uniform(2, row)])
    }

    fn components(vector: Vector<F32s>, lane: usize) -> [f32; 3] {
        [vector.x, vector.y, vector.z].map(|component| component.to_array()[lane])
    }

    #[test]
    fn directions_are_as_exact_as_stated() {
        let mut largest = 0.0_f32;
        for row in 0..50_000 {
            let given = direction(row);
            let rounded = round_directions(given);
            let error = (rounded - given).length().to_array();
            largest = error.iter().fold(largest, |a, &b| a.max(b));
            let length = rounded.length().to_array();
            assert!(length.iter().all(|length| (length - 1.0).abs() < 2e-7));
        }
        assert!(largest < 6.5e-5, "{largest}");
        assert!(largest > 6e-5, "{largest}: the statement is too careful");
    }

    #[test]
    fn axes_are_exact_and_rounding_is_idempotent() {
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let mut vector = [0.0; 3];
                vector[axis] = sign;
                let given = Vector::gather(|_| vector);
                let found = components(round_directions(given), 3);
                assert_eq!(found, vector);
            }
        }
        for row in 0..1000 {
            let once = pack_directions(direction(row));
            let twice = pack_directions(unpack_directions(once));
            assert_eq!(once.to_array(), twice.to_array());
        }
    }

    #[test]
    fn a_row_takes_the_memory_that_is_stated() {
        let bytes = |class| PhotonTable::<3>::of_class(class, 100).bytes_per_row();
        assert_eq!(bytes(PhotonClass::Power), 28);
        assert_eq!(bytes(PhotonClass::Stokes), 34);
        assert_eq!(bytes(PhotonClass::SpectralStokes), 46);
        for class in [PhotonClass::Power, PhotonClass::Stokes, PhotonClass::SpectralStokes] {
            let table = PhotonTable::<3>::of_class(class, 100);
            let floats = table.position.iter().chain(&table.power);
            let bytes = floats.map(|c| size_of_val(&c[..])).sum::<usize>()
                + size_of_val(&table.direction[..])
                + table.stokes.iter().flatten().map(|c| size_of_val(&c[..])).sum::<usize>();
            assert_eq!(bytes, table.bytes_per_row() * (100 + LANES));
        }
    }

    fn filled(class: PhotonClass, packets: u32, salt: u32) -> PhotonTable<2> {
        let mut table = PhotonTable::of_class(class, 3);
        for row in 0..packets {
            let live = 1 + (row as usize + salt as usize) % LANES;
            let position = direction(row + 100 * salt) * F32s::splat(3.0);
            let power = [uniform(salt, row), uniform(salt + 9, row)];
            let start = table.len;
            table.append_lanes(position, direction(row + salt), &power, live);
            for channel in 0..class.channels(2) {
                let values = direction(row + salt + 1000 * channel as u32);
                let states = [values.x, values.y, values.z];
                table.store_stokes(start, table.len, channel, states);
            }
        }
        table
    }

    #[test]
    fn tables_are_appended_row_by_row() {
        for class in [PhotonClass::Power, PhotonClass::Stokes, PhotonClass::SpectralStokes] {
            let (first, second) = (filled(class, 20, 1), filled(class, 30, 2));
            let mut both = PhotonTable::of_class(class, 0);
            both.append_table(&first);
            both.append_table(&second);
            assert_eq!(both.len, first.len + second.len);
            for row in 0..both.len {
                let (from, at) =
                    if row < first.len { (&first, row) } else { (&second, row - first.len) };
                assert_eq!(both.direction[row], from.direction[at]);
                assert!((0..3).all(|a| both.position[a][row] == from.position[a][at]));
                assert!((0..2).all(|n| both.power[n][row] == from.power[n][at]));
                for n in 0..class.channels(2) {
                    assert!((0..3).all(|s| both.stokes[s][n][row] == from.stokes[s][n][at]));
                }
            }
        }
    }

    #[test]
    fn states_survive_to_half_a_step() {
        let mut table = PhotonTable::<3>::of_class(PhotonClass::Stokes, 0);
        table.append_lanes(direction(0), direction(0), &[F32s::ONE; 3], 5);
        let given = [[-1.0, 1.0, 0.0, 0.3, -0.7], [0.5, 0.0, -0.0, 1e-3, 1e-6], [1.5; 5]];
        let mut states = [F32s::ZERO; 3];
        for component in 0..3 {
            let row = given[component];
            states[component] =
                F32s::from(lanes::each(|lane| if lane < 5 { row[lane] } else { 9.0 }));
        }
        table.store_stokes(0, 5, 0, states);
        for wavelength in 0..3 {
            let found = table.states(0, wavelength);
            for (found, given) in found.iter().zip(&given) {
                for (found, value) in found.to_array().iter().zip(given) {
                    let value = value.min(1.0);
                    let off = (found - value).abs();
                    assert!(off <= 0.5 / 32767.0, "{value}: {off}");
                    assert!(off == 0.0 || value.fract() != 0.0, "{value} is exact");
                }
            }
        }
    }

    #[test]
    fn columns_become_photons() {
        let rows = 37;
        let mut table = PhotonTable::<1>::of_class(PhotonClass::Power, 0);
        let (mut position, mut along) = (vectors(rows), vectors(rows));
        let mut power = channels::<1>(rows);
        for row in (0..rows).step_by(LANES) {
            direction(row as u32).store(&mut position, row, rows);
            direction(row as u32 + 1).store(&mut along, row, rows);
            lanes::store(&mut power[0], row, rows, uniform(5, row as u32));
        }
        table.append_columns(&position, &along, &power, 3..rows);
        assert_eq!(table.len, rows - 3);
        for row in 0..table.len {
            assert!((0..3).all(|axis| table.position[axis][row] == position[axis][row + 3]));
            assert_eq!(table.power[0][row], power[0][row + 3]);
            let found = components(table.directions(row / LANES * LANES), row % LANES);
            assert!((0..3).all(|axis| (found[axis] - along[axis][row + 3]).abs() < 6.5e-5));
        }
    }
}
