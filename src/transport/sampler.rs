//! The only source of randomness: a pure function of (seed, stream, path, path length, purpose,
//! iteration), so that no bit depends on threads, chunks or the order of rows.
//!
//! Every purpose gets a two-dimensional Sobol' sequence over the iterations, Owen-scrambled and
//! index-shuffled by a hash of everything else (Burley 2020, "Practical hash-based Owen
//! scrambling"; padding, section 5), so there is no limit on the number of dimensions.

use crate::math::hash::{combine, mix_lanes, reverse_bits};
use crate::math::{F32s, U32s};

/// What a pair of random numbers is for. Adding a purpose shifts no other.
#[derive(Clone, Copy, Debug)]
#[repr(u32)]
pub enum Purpose {
    /// Position within the pixel.
    Pixel = 0,
    /// Position on the lens.
    Lens,
    /// Which emitter starts a light path (first number).
    EmitterOfPath,
    /// Position on the emitter of a light path, or on the disk an infinite one shines through.
    EmissionPosition,
    /// Direction of emission.
    EmissionDirection,
    /// Which emitter a vertex connects to (first number).
    Emitter,
    /// Position on, or direction to, that emitter.
    EmitterPosition,
    /// New direction at a vertex.
    Direction,
    /// Reflection or transmission (first number), roulette (second).
    Decision,
    /// Position on the lens of a connection to the sensor.
    LensConnection,
    /// Optical depth to the next particle of a medium (first number).
    Distance,
    /// The wavelength that a path's distances and angles in media are drawn for (first number).
    Wavelength,
    /// Whether a path passes a surface that scatters some of them (first number).
    Passage,
    /// Whether a vertex far along its path connects to others (first number), and to which.
    Connections,
    /// What a light path is aimed at (first number).
    Aim,
    /// Which lamp a path looks for on its way through a medium (first number), and from where.
    Lamp,
}

/// Purposes per path length; a power of two that exceeds the last [`Purpose`].
const PURPOSES: u32 = 16;

/// Random streams that must not share numbers.
#[derive(Clone, Copy, Debug)]
#[repr(u32)]
pub enum Stream {
    /// Paths from the sensor.
    Sensor = 1,
    /// Paths from the emitters.
    Light = 2,
    /// The pixels that connections from these to the sensor count for.
    Splat = 3,
    /// The lattices that samples lie in which neighbors share.
    Film = 4,
}

/// The seed of one path's sequences; a column of the path tables.
#[inline(always)]
pub fn path_seed(job_seed: u32, stream: Stream, path: u32) -> u32 {
    combine(combine(job_seed, stream as u32), path)
}

/// Two numbers in [0, 1) per lane for the vertex after `path_length` segments.
///
/// `seed` is [`path_seed`], `iteration` the index in the sequence.
// Out of line: it is called everywhere, once for eight vertices.
#[inline(never)]
pub fn draw(seed: U32s, iteration: U32s, path_length: u32, purpose: Purpose) -> [F32s; 2] {
    let (x, shuffle) = first_dimension(seed, iteration, path_length, purpose);
    let second = mix_lanes(shuffle ^ U32s::splat(0xb529_7a4d));
    [first_number(x, shuffle), unit(owen(sobol_second(x), second))]
}

/// The first of the two numbers of [`draw`], at two thirds of its price.
#[inline(never)]
pub fn draw_first(seed: U32s, iteration: U32s, path_length: u32, purpose: Purpose) -> F32s {
    let (x, shuffle) = first_dimension(seed, iteration, path_length, purpose);
    first_number(x, shuffle)
}

/// The first Sobol' dimension of shuffled sequences, and what shuffles them.
#[inline(always)]
fn first_dimension(
    seed: U32s,
    iteration: U32s,
    path_length: u32,
    purpose: Purpose,
) -> (U32s, U32s) {
    let set = path_length * PURPOSES + purpose as u32;
    let shuffle = mix_lanes(seed ^ U32s::splat(combine(0x5bd1_e995, set)));
    (owen_reversed(reverse_bits(iteration), shuffle), shuffle)
}

#[inline(always)]
fn first_number(x: U32s, shuffle: U32s) -> F32s {
    unit(owen(x, mix_lanes(shuffle ^ U32s::splat(0x51ed_270b))))
}

/// Owen scrambling of a number whose bits are already reversed (Laine and Karras 2011; constants
/// of Vegdahl 2021).
#[inline(always)]
fn owen_reversed(bits: U32s, seed: U32s) -> U32s {
    let bits = bits ^ (bits * U32s::splat(0x3d20_adea));
    let bits = bits + seed;
    let bits = bits * ((seed >> 16) | U32s::splat(1));
    let bits = bits ^ (bits * U32s::splat(0x0552_6c56));
    bits ^ (bits * U32s::splat(0x53a2_2864))
}

#[inline(always)]
fn owen(bits: U32s, seed: U32s) -> U32s {
    reverse_bits(owen_reversed(reverse_bits(bits), seed))
}

/// The second Sobol' dimension from the first: multiplication by the Pascal matrix modulo two in
/// log steps (Ahmed 2024, "An implementation algorithm of 2D Sobol sequence").
#[inline(always)]
pub fn sobol_second(first: U32s) -> U32s {
    let bits = first ^ (first << 16);
    let bits = bits ^ ((bits & U32s::splat(0x00ff_00ff)) << 8);
    let bits = bits ^ ((bits & U32s::splat(0x0f0f_0f0f)) << 4);
    let bits = bits ^ ((bits & U32s::splat(0x3333_3333)) << 2);
    bits ^ ((bits & U32s::splat(0x5555_5555)) << 1)
}

/// The upper 23 bits as the mantissa of a number in [1, 2), less one: never 1.
#[inline(always)]
fn unit(bits: U32s) -> F32s {
    let mantissa = (bits >> 9) | U32s::splat(0x3f80_0000);
    bytemuck::cast::<U32s, F32s>(mantissa) - F32s::splat(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(seed: u32, count: u32) -> Vec<[f32; 2]> {
        let seeds = U32s::splat(path_seed(seed, Stream::Sensor, 5));
        (0..count)
            .map(|iteration| {
                let [x, y] = draw(seeds, U32s::splat(iteration), 3, Purpose::Direction);
                [x.to_array()[0], y.to_array()[0]]
            })
            .collect()
    }

    /// A (0, m, 2)-net in base two: every elementary interval of area 1/2^m holds one point.
    #[test]
    fn every_purpose_is_a_digital_net() {
        for seed in 0..8 {
            let points = points(seed, 256);
            for x_bits in 0..=8_u32 {
                let mut cells = [0; 256];
                for [x, y] in &points {
                    let column = (x * (1 << x_bits) as f32) as usize;
                    let row = (y * (1 << (8 - x_bits)) as f32) as usize;
                    cells[(row << x_bits) + column] += 1;
                }
                assert!(cells.iter().all(|&count| count == 1), "seed {seed}, {x_bits} bits");
            }
        }
    }

    #[test]
    fn numbers_stay_below_one() {
        assert!(unit(U32s::splat(u32::MAX)).to_array()[0] < 1.0);
        assert_eq!(unit(U32s::splat(0)).to_array()[0], 0.0);
    }

    /// Pairs of different purposes must be uncorrelated: with 4096 independent samples the
    /// correlation has a standard deviation of 1/64; 5 sigma.
    #[test]
    fn purposes_are_independent() {
        let iterations = U32s::from(std::array::from_fn(|lane| lane as u32));
        let mut sum = 0.0_f64;
        for path in 0..512 {
            let seed = U32s::splat(path_seed(9, Stream::Light, path));
            let [a, _] = draw(seed, iterations, 1, Purpose::Direction);
            let [b, _] = draw(seed, iterations, 1, Purpose::Decision);
            for (a, b) in a.to_array().into_iter().zip(b.to_array()) {
                sum += 12.0 * (f64::from(a) - 0.5) * (f64::from(b) - 0.5);
            }
        }
        assert!((sum / 4096.0).abs() < 5.0 / 64.0, "correlation {}", sum / 4096.0);
    }
}
