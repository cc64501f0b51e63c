//! The one SIMD width of the renderer and how lanes move to and from columns.
//!
//! Lanes are an alias and not a type parameter: the instruction set is fixed when the binary is
//! built, so a width parameter would multiply instances and gain nothing.
//!
//! Transcendental functions are polynomials. `exp` and `ln` of `wide` have relative errors below
//! 1.2e-7 where media need them (`exp` from -80 to 0, `ln` from 2^-24 to 1); sines, cosines and
//! angles are in [`super::warp`], with their errors.

use wide::{f32x8, i16x8, i32x8, u32x8};

use super::Real;

/// Rows that one instruction of a stage works on.
pub const LANES: usize = 8;

/// Eight rows of a column of floats.
pub type F32s = f32x8;

/// Eight rows of a column of identifiers, bits or counters.
pub type U32s = u32x8;

/// Numbers that a column of floats yields: one row, or eight from it on.
pub trait FromColumn: Real {
    /// Reads at `row`, and from there on.
    fn load(column: &[f32], row: usize) -> Self;
}

impl FromColumn for f32 {
    #[inline(always)]
    fn load(column: &[f32], row: usize) -> Self {
        column[row]
    }
}

impl FromColumn for F32s {
    #[inline(always)]
    fn load(column: &[f32], row: usize) -> Self {
        load(column, row)
    }
}

/// Reads the eight rows from `row` on. Columns are padded by [`LANES`], so a tail reads garbage
/// that [`store`] never writes back.
#[inline(always)]
pub fn load(column: &[f32], row: usize) -> F32s {
    let lanes: [f32; LANES] = column[row..row + LANES].try_into().expect("eight lanes");
    F32s::from(lanes)
}

/// Writes the rows from `row` to `end` (exclusive), at most eight.
#[inline(always)]
pub fn store(column: &mut [f32], row: usize, end: usize, value: F32s) {
    let lanes = value.to_array();
    if row + LANES <= end {
        column[row..row + LANES].copy_from_slice(&lanes);
    } else {
        store_tail(column, row, end, &lanes);
    }
}

/// The last rows of [`store`]: out of line, as there are hundreds of places that store.
#[cold]
#[inline(never)]
fn store_tail<T: Copy>(column: &mut [T], row: usize, end: usize, lanes: &[T; LANES]) {
    column[row..end].copy_from_slice(&lanes[..end - row]);
}

/// Multiplies the rows from `row` to `end` (exclusive), at most eight.
#[inline(always)]
pub fn scale(column: &mut [f32], row: usize, end: usize, factor: F32s) {
    let product = load(column, row) * factor;
    store(column, row, end, product);
}

/// [`load`] for identifiers.
#[inline(always)]
pub fn load_u32(column: &[u32], row: usize) -> U32s {
    let lanes: [u32; LANES] = column[row..row + LANES].try_into().expect("eight lanes");
    U32s::from(lanes)
}

/// [`store`] for identifiers.
#[inline(always)]
pub fn store_u32(column: &mut [u32], row: usize, end: usize, value: U32s) {
    let lanes = value.to_array();
    if row + LANES <= end {
        column[row..row + LANES].copy_from_slice(&lanes);
    } else {
        store_tail(column, row, end, &lanes);
    }
}

/// Steps of a packed signed number from 0 to 1.
const SIGNED_STEPS: f32 = i16::MAX as f32;

/// [`load`] for numbers in [-1, 1] in 16 bits; -1, 0 and 1 are exact.
#[inline(always)]
pub fn load_signed(column: &[i16], row: usize) -> F32s {
    let lanes: [i16; LANES] = column[row..row + LANES].try_into().expect("eight lanes");
    i32x8::from_i16x8(i16x8::from(lanes)).round_float() * F32s::splat(1.0 / SIGNED_STEPS)
}

/// [`store`] for [`load_signed`]; what lies outside of [-1, 1] becomes its end.
#[inline(always)]
pub fn store_signed(column: &mut [i16], row: usize, end: usize, value: F32s) {
    let steps = F32s::splat(SIGNED_STEPS);
    let steps = (value * steps).fast_max(-steps).fast_min(steps).round_int();
    let lanes = i16x8::from_i32x8_saturate(steps).to_array();
    if row + LANES <= end {
        column[row..row + LANES].copy_from_slice(&lanes);
    } else {
        store_tail(column, row, end, &lanes);
    }
}

/// The mask of the first `live` lanes; of all if there are more than eight.
#[inline(always)]
pub fn first(live: usize) -> F32s {
    let live = i32x8::splat(live.min(LANES) as i32);
    bytemuck::cast(live.simd_gt(i32x8::from([0, 1, 2, 3, 4, 5, 6, 7])))
}

/// The mask of the lanes that are so.
#[inline(always)]
pub fn mask_of(lanes: [bool; LANES]) -> F32s {
    let mut mask = [0.0; LANES];
    for (bits, is_so) in mask.iter_mut().zip(lanes) {
        *bits = f32::from_bits(u32::from(is_so).wrapping_neg());
    }
    F32s::from(mask)
}

/// The mask of the lanes that have a bit set.
#[inline(always)]
pub fn are_set(lanes: U32s, bit: u32) -> F32s {
    let bit = U32s::splat(bit);
    bytemuck::cast((lanes & bit).simd_eq(bit))
}

/// One row of three columns.
#[inline(always)]
pub fn row_of(columns: &[Vec<f32>; 3], row: usize) -> [f32; 3] {
    [columns[0][row], columns[1][row], columns[2][row]]
}

/// One lane of values per wavelength.
#[inline(always)]
pub fn row_of_lanes<const N: usize>(values: &[[f32; LANES]; N], lane: usize) -> [f32; N] {
    let mut row = [0.0; N];
    for (row, values) in row.iter_mut().zip(values) {
        *row = values[lane];
    }
    row
}

/// The columns of the rows that eight lanes hold.
#[inline(always)]
pub fn columns<'a, const N: usize>(of_lane: impl Fn(usize) -> &'a [f32; N]) -> [F32s; N] {
    let mut columns = [F32s::splat(0.0); N];
    let (eights, rest) = columns.as_chunks_mut::<LANES>();
    for (place, eight) in eights.iter_mut().enumerate() {
        let mut rows = [F32s::splat(0.0); LANES];
        for (lane, row) in rows.iter_mut().enumerate() {
            *row = load(of_lane(lane), place * LANES);
        }
        *eight = F32s::transpose(rows);
    }
    let first = N - rest.len();
    for (place, column) in rest.iter_mut().enumerate() {
        *column = F32s::from(each(|lane| of_lane(lane)[first + place]));
    }
    columns
}

/// One value per lane. A plain loop: `array::from_fn` and `map` with closures of some size are not
/// always inlined, and then cost more than what they compute.
#[inline(always)]
pub fn each<T: Copy + Default>(of_lane: impl Fn(usize) -> T) -> [T; LANES] {
    let mut values = [T::default(); LANES];
    for (lane, value) in values.iter_mut().enumerate() {
        *value = of_lane(lane);
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_those_of_the_rows() {
        let rows: [[f32; 11]; LANES] =
            std::array::from_fn(|lane| std::array::from_fn(|place| (lane * 100 + place) as f32));
        for (place, column) in columns(|lane| &rows[lane]).iter().enumerate() {
            assert_eq!(column.to_array(), rows.map(|row| row[place]));
        }
    }

    #[test]
    fn masks_select_the_lanes_that_are_so() {
        let odd = each(|lane| lane % 2 == 1);
        let chosen = mask_of(odd).select(F32s::splat(1.0), F32s::splat(2.0)).to_array();
        assert_eq!(chosen, odd.map(|odd| if odd { 1.0 } else { 2.0 }));
        assert_eq!(mask_of([true; LANES]).to_bitmask(), 0xff);
    }

    #[test]
    fn exp_and_ln_are_exact_to_their_stated_errors() {
        let (mut of_exp, mut of_ln) = (0.0_f64, 0.0_f64);
        for step in 0..200_000_u32 {
            let x = -80.0 * step as f32 / 200_000.0;
            let expected = f64::from(x).exp();
            let found = f64::from(F32s::splat(x).exp().to_array()[0]);
            of_exp = of_exp.max((found - expected).abs() / expected);
            let u = 2.0_f32.powf(-24.0 * step as f32 / 200_000.0);
            let expected = f64::from(u).ln();
            let found = f64::from(F32s::splat(u).ln().to_array()[0]);
            of_ln = of_ln.max((found - expected).abs() / expected.abs().max(1e-30));
        }
        assert!(of_exp < 1.2e-7 && of_ln < 1.2e-7, "{of_exp:e} {of_ln:e}");
    }
}
