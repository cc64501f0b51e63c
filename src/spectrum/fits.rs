//! Fits of colors that are remembered: a table that threads read and write without waiting for each
//! other.
//!
//! A color may be in one of four places, by a hash, which it shares with others: where there is no
//! empty one, it takes that of another. A place is a few words that are written one by one, the
//! last of them a sum of the others. Whoever reads words of two colors finds that the sum is
//! another, and makes the fit anew.

use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};

use bytemuck::Zeroable;

use super::color_space::White;
use super::upsampling::Sigmoid;

/// Bits of the number of a place: pages of the table that no color is in take no memory.
const BITS: u32 = 20;
/// Places where a color may be.
const WAYS: u64 = 4;

/// Red, green and blue, the coefficients of their fit, and the sum: a line of the cache.
#[derive(Zeroable)]
#[repr(C, align(64))]
struct Place([AtomicU64; WORDS]);

const WORDS: usize = 7;

static PLACES: LazyLock<Box<[Place]>> = LazyLock::new(|| bytemuck::zeroed_slice_box(1 << BITS));

/// The fit of a color under a white: the remembered one, or what `fitted` finds.
pub fn remembered(rgb: [f64; 3], white: White, fitted: impl FnOnce() -> Sigmoid) -> Sigmoid {
    let key = rgb.map(f64::to_bits);
    let hash = mixed(&key, white);
    let place = |way: u64| &PLACES[((hash >> (u64::BITS - BITS)) ^ way) as usize];
    let mut free = None;
    for way in 0..WAYS {
        let [r, g, b, c0, c1, c2, sum] = place(way).read();
        if [r, g, b] == key && sum == mixed(&[r, g, b, c0, c1, c2], white) {
            return Sigmoid { c: [c0, c1, c2].map(f64::from_bits) };
        }
        if sum == 0 {
            free = Some(way);
            break;
        }
    }
    let fit = fitted();
    let ([r, g, b], [c0, c1, c2]) = (key, fit.c.map(f64::to_bits));
    let sum = mixed(&[r, g, b, c0, c1, c2], white);
    place(free.unwrap_or(hash % WAYS)).write([r, g, b, c0, c1, c2, sum]);
    fit
}

impl Place {
    fn read(&self) -> [u64; WORDS] {
        std::array::from_fn(|word| self.0[word].load(Ordering::Relaxed))
    }

    fn write(&self, values: [u64; WORDS]) {
        for (word, value) in self.0.iter().zip(values) {
            word.store(value, Ordering::Relaxed);
        }
    }
}

/// A hash of words and a white.
fn mixed(words: &[u64], white: White) -> u64 {
    let start = 0x517c_c1b7_2722_0a95 + white as u64;
    words.iter().fold(start, |mixed, word| {
        (mixed.rotate_left(21) ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fit that tells of which color it is.
    fn fit_of(rgb: [f64; 3], white: White) -> Sigmoid {
        Sigmoid { c: rgb.map(|it| it + 10.0 * (1.0 + white as u64 as f64)) }
    }

    #[test]
    fn threads_find_the_fits_of_their_colors_whatever_others_write() {
        let read = |start: u64| {
            let mut state = start;
            let mut made = 0;
            for _ in 0..200_000 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                // A few thousand colors, again and again, by all threads.
                let color = f64::from((state >> 52) as u32);
                let rgb = [color, color + 0.25, -color];
                let white = White::ALL[(state >> 40) as usize % 2];
                let found = remembered(rgb, white, || {
                    made += 1;
                    fit_of(rgb, white)
                });
                assert_eq!(found, fit_of(rgb, white));
            }
            made
        };
        let made: Vec<u32> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..4).map(|start| scope.spawn(move || read(start))).collect();
            threads.into_iter().map(|thread| thread.join().expect("no thread fails")).collect()
        });
        // Most are found: places are many more than colors.
        assert!(made.iter().sum::<u32>() < 100_000, "{made:?}");
    }
}
