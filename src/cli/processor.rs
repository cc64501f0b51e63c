//! Whether this processor can run what was compiled, asked before anything else is done.
//!
//! On x86-64 the program is compiled for the level v3 (`.cargo/config.toml`), and an older
//! processor would end it with "illegal instruction" at the first one that it does not know.
//! `is_x86_feature_detected!` does not help: where a build takes a feature for granted, the macro
//! answers at compile time. So the processor itself is asked, for all that the build uses and that
//! `cpuid` can tell. Nothing here, nor in `main` and [`super::run`] before this, may use such
//! instructions: plain comparisons of integers with constants, no loops, no formatting.

/// What to say to a processor that cannot run this build; nothing if it can.
#[inline(never)]
pub fn refusal() -> Option<&'static str> {
    if is_supported() {
        return None;
    }
    Some(if cfg!(target_feature = "avx512f") {
        "error: this build of sunstone needs a processor with AVX-512, and this one has none.
To build for this processor: RUSTFLAGS=\"-C target-cpu=native\" cargo build --release
"
    } else {
        "error: this build of sunstone needs a processor with AVX2, FMA and BMI2 (x86-64-v3: Intel \
         since Haswell 2013, AMD since Zen 2017), and this one lacks some of these.
To build for this processor: RUSTFLAGS=\"-C target-cpu=native\" cargo build --release
"
    })
}

#[cfg(not(target_arch = "x86_64"))]
fn is_supported() -> bool {
    true
}

#[cfg(target_arch = "x86_64")]
fn is_supported() -> bool {
    use std::arch::x86_64::{__cpuid, __cpuid_count};

    // Every processor with AVX has leaf 0xd; leaves above the highest one say nothing of use.
    if cfg!(target_feature = "avx") && __cpuid(0).eax < 0xd {
        return false;
    }
    if __cpuid(1).ecx & needed::LEAF_1_ECX != needed::LEAF_1_ECX {
        return false;
    }
    if needed::LEAF_7_EBX != 0 && __cpuid_count(7, 0).ebx & needed::LEAF_7_EBX != needed::LEAF_7_EBX
    {
        return false;
    }
    if needed::EXTENDED_ECX != 0
        && __cpuid(0x8000_0001).ecx & needed::EXTENDED_ECX != needed::EXTENDED_ECX
    {
        return false;
    }
    // The system saves the upper halves of the registers only if it knows of them: then its save
    // area holds more than the legacy part, the header and less than the 256 bytes of these.
    !cfg!(target_feature = "avx") || __cpuid_count(0xd, 0).ebx >= 512 + 64 + 256
}

/// The bits of `cpuid` that this build needs (Intel SDM volume 2A, CPUID; AMD APM volume 3, E.4).
#[cfg(target_arch = "x86_64")]
mod needed {
    const fn bit(is_used: bool, index: u32) -> u32 {
        (is_used as u32) << index
    }

    pub const LEAF_1_ECX: u32 = bit(cfg!(target_feature = "sse3"), 0)
        | bit(cfg!(target_feature = "ssse3"), 9)
        | bit(cfg!(target_feature = "fma"), 12)
        | bit(cfg!(target_feature = "sse4.1"), 19)
        | bit(cfg!(target_feature = "sse4.2"), 20)
        | bit(cfg!(target_feature = "movbe"), 22)
        | bit(cfg!(target_feature = "popcnt"), 23)
        | bit(cfg!(target_feature = "avx"), 27) // the system uses XSAVE
        | bit(cfg!(target_feature = "avx"), 28)
        | bit(cfg!(target_feature = "f16c"), 29);

    pub const LEAF_7_EBX: u32 = bit(cfg!(target_feature = "bmi1"), 3)
        | bit(cfg!(target_feature = "avx2"), 5)
        | bit(cfg!(target_feature = "bmi2"), 8)
        | bit(cfg!(target_feature = "avx512f"), 16)
        | bit(cfg!(target_feature = "avx512dq"), 17)
        | bit(cfg!(target_feature = "avx512cd"), 28)
        | bit(cfg!(target_feature = "avx512bw"), 30)
        | bit(cfg!(target_feature = "avx512vl"), 31);

    pub const EXTENDED_ECX: u32 = bit(cfg!(target_feature = "lzcnt"), 5);
}

#[cfg(test)]
mod tests {
    /// The tests themselves run on a processor that can run them.
    #[test]
    fn this_processor_is_not_refused() {
        assert_eq!(super::refusal(), None);
    }
}
