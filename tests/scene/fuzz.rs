//! Damaged files are refused or loaded, and never panic.

use crate::common::{glb, good, load_bytes, square_bytes};
use sunstone::scene::bake;
use sunstone::spectrum::Color;

/// Loads and, if that succeeds, bakes; whether the whole came out.
fn survives(bytes: &[u8]) -> bool {
    load_bytes("fuzz.glb", bytes).is_ok_and(|world| bake::<3>(&world, Color::Rgb).is_ok())
}

/// A small generator of random numbers (splitmix64).
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut x = *state;
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[test]
fn a_truncated_file_is_refused_at_every_length() {
    let bytes = glb(good(), &square_bytes());
    assert!(survives(&bytes));
    for length in 0..bytes.len() {
        assert!(!survives(&bytes[..length]), "{length} bytes");
        // The same with a header that does not give it away.
        let mut cut = bytes[..length].to_vec();
        if length >= 12 {
            cut[8..12].copy_from_slice(&(length as u32).to_le_bytes());
        }
        survives(&cut);
    }
}

#[test]
fn random_bytes_never_panic() {
    let good = glb(good(), &square_bytes());
    for seed in 0..4_000 {
        let mut state = seed;
        let mut bytes = good.clone();
        for _ in 0..1 + seed % 8 {
            let at = next(&mut state) as usize % bytes.len();
            bytes[at] = next(&mut state) as u8;
        }
        survives(&bytes);
    }
}

#[test]
fn digits_that_change_never_panic() {
    // Random digits and signs leave the JSON valid and hit indices, counts and offsets.
    let good = glb(good(), &square_bytes());
    let digits: Vec<usize> =
        (20..good.len() - 120).filter(|&at| good[at].is_ascii_digit()).collect();
    for seed in 0..4_000 {
        let mut state = seed + 1_000_000;
        let mut bytes = good.clone();
        for _ in 0..1 + seed % 4 {
            let at = digits[next(&mut state) as usize % digits.len()];
            bytes[at] = b'0' + (next(&mut state) % 10) as u8;
        }
        survives(&bytes);
    }
}
