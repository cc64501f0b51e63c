//! Integer hashes, one value or eight lanes at a time: the root of all randomness.

use super::U32s;

/// A bijection of 32 bits with good avalanche (Ellis 2018, "Hash function prospecting",
/// `lowbias32`).
#[inline(always)]
pub fn mix(mut bits: u32) -> u32 {
    bits ^= bits >> 16;
    bits = bits.wrapping_mul(0x7feb_352d);
    bits ^= bits >> 15;
    bits = bits.wrapping_mul(0x846c_a68b);
    bits ^ (bits >> 16)
}

/// Folds `word` into the hash `seed`; the order of words matters.
#[inline(always)]
pub fn combine(seed: u32, word: u32) -> u32 {
    mix(seed.rotate_left(5) ^ word.wrapping_mul(0x9e37_79b9))
}

/// [`mix`] in eight lanes.
#[inline(always)]
pub fn mix_lanes(mut bits: U32s) -> U32s {
    bits ^= bits >> 16;
    bits *= U32s::splat(0x7feb_352d);
    bits ^= bits >> 15;
    bits *= U32s::splat(0x846c_a68b);
    bits ^ (bits >> 16)
}

/// Reverses the order of the bits of each lane.
#[inline(always)]
pub fn reverse_bits(bits: U32s) -> U32s {
    #[inline(always)]
    fn swap<const WIDTH: u32>(bits: U32s, low: u32) -> U32s {
        let mask = U32s::splat(low);
        ((bits & mask) << WIDTH) | ((bits >> WIDTH) & mask)
    }
    let bits = swap::<1>(bits, 0x5555_5555);
    let bits = swap::<2>(bits, 0x3333_3333);
    let bits = swap::<4>(bits, 0x0f0f_0f0f);
    let bits = swap::<8>(bits, 0x00ff_00ff);
    (bits << 16) | (bits >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_equal_scalar() {
        let words: [u32; 8] = std::array::from_fn(|lane| mix(lane as u32 + 17));
        let lanes = U32s::from(words);
        assert_eq!(mix_lanes(lanes).to_array(), words.map(mix));
        assert_eq!(reverse_bits(lanes).to_array(), words.map(u32::reverse_bits));
    }
}
