//! Numbers that grow with every event, kept within their range.

use crate::math::columns::Column;

/// From here on what is relative to unpolarized light is scaled back. Until it is looked at again
/// it may grow by another [`LOOKS`] doublings.
const GREATEST: f32 = (1_u64 << 40) as f32;

/// Events after which it is looked at again: each at most doubles it.
pub const LOOKS: usize = 32;

/// A power of two by which a value is too great, so that dividing by it rounds nothing; 1 while it
/// is not.
#[inline(always)]
pub fn excess(value: f32) -> f32 {
    if value < GREATEST { 1.0 } else { f32::from_bits(value.to_bits() & 0x7f80_0000) }
}

/// Scales one row of some columns.
#[inline(always)]
pub fn scale_row<'a>(columns: impl Iterator<Item = &'a mut Column>, row: usize, scale: f32) {
    columns.for_each(|column| column[row] *= scale);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn excesses_are_powers_of_two_and_leave_a_number_about_one() {
        for value in [0.0, 1.0, 1e9] {
            assert_eq!(excess(value), 1.0);
        }
        for value in [1.2e13_f32, 3e20, 1.7e38] {
            let scale = excess(value);
            assert_eq!(scale.log2().fract(), 0.0);
            assert!((1.0..2.0).contains(&(value / scale)));
        }
    }
}
