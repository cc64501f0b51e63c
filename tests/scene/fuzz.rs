//! Damaged files are refused or loaded, and never panic.

use crate::common::{glb, good, load_bytes, square_bytes};
use serde_json::json;
use sunstone::internals::scene::bake;
use sunstone::internals::spectrum::Carried;

/// Loads and, if that succeeds, bakes; whether the whole came out.
fn survives(bytes: &[u8]) -> bool {
    load_bytes("fuzz.glb", bytes).is_ok_and(|world| bake(&world, &Carried::RGB).is_ok())
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

#[test]
fn media_that_change_never_panic() {
    let mut document = good();
    document["nodes"][2]["extensions"]["SUNSTONE_polarization"]["interior"] = json!(0);
    document["extras"] = json!({"sunstone": {"medium": 1, "media": [
        {"phase": "mie", "host": {"eta": 1.33, "k": 1e-9}, "particles": [
            {"distribution": {"kind": "monodisperse", "radius_um": 0.25}, "eta": 1.5,
             "volume_fraction": 0.001}]},
        {"phase": "hg", "g": 0.5, "sigma_a": 0.1, "sigma_s": [1, 2, 3]},
        {"phase": "rayleigh", "depolarization": 0.1, "sigma_a": 0, "sigma_s": 1},
        {"phase": "mueller_table", "sigma_a": 0, "sigma_s": 1, "table": {
            "lambda_nm": [450, 450, 450, 650, 650, 650], "theta_deg": [0, 90, 180, 0, 90, 180],
            "m00": [1, 1, 1, 2, 1, 1], "m01": [0, 0.5, 0, 0, 0.5, 0],
            "m22": [0.5, 0, 0, 0, 0, 0], "m23": [0, 0.1, 0, 0, 0, 0]}},
    ]}});
    let good = glb(document, &square_bytes());
    assert!(survives(&good));
    let key = b"\"media\"";
    let start = good.windows(key.len()).position(|part| part == key).unwrap();
    let bytes: Vec<usize> = (start..start + 900).collect();
    for seed in 0..2_000 {
        let mut state = seed + 2_000_000;
        let mut changed = good.clone();
        for _ in 0..1 + seed % 3 {
            let at = bytes[next(&mut state) as usize % bytes.len()];
            let digits = b"0123456789.-e";
            let random = digits[next(&mut state) as usize % digits.len()];
            if good[at].is_ascii_digit() || seed % 8 == 0 {
                changed[at] = random;
            }
        }
        survives(&changed);
    }
}
