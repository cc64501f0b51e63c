//! A deflate for differences of bytes, of which the most are noise.
//!
//! No deflate makes noise shorter, and every one takes its time to find that out. What is left are
//! runs of one byte, where nothing changes, and what is in the file twice. They are told apart
//! before, strip by strip, which is what a channel has of a row:
//!
//! | strip | becomes |
//! |---|---|
//! | the same as one before it in the row | a reference to that |
//! | noise | itself |
//! | another | what zlib-rs makes of its runs, or of all that it finds where runs are not all |
//!
//! Bytes change with nothing but bytes, not with the processor or the number of threads.

use std::ops::Range;

use zlib_rs::adler32::adler32;
use zlib_rs::{Deflate, DeflateConfig, DeflateFlush, Method, Strategy, compress_bound};

use super::bits::Bits;

/// What a stream of zlib begins with: references of up to 2^15 bytes, packed fast.
const START: [u8; 2] = [0x78, 0x01];
/// How far references reach.
const REACH: usize = 1 << 15;
/// Level of the deflate: beyond it, noise takes longer and does not shrink.
const LEVEL: i32 = 2;
/// The window in which it looks for what has been there: 2^14 bytes are faster than 2^15, and do.
const WINDOW_BITS: i32 = 14;
/// The largest table of symbols that deflate knows.
const MEMORY_LEVEL: i32 = 9;
/// Bytes beyond the bound of a stream, for the end of one that goes on.
const FLUSH: usize = 64;
/// Shorter strips are not looked at: a deflate has many of them in its window.
const STRIP_MIN: usize = 1 << 10;
/// Bytes that are noise, or not, as a whole.
const PIECE: usize = 1 << 12;

/// Packs one block after the other, in the same memory.
pub struct Deflater {
    all: Deflate,
    runs: Deflate,
    parts: Vec<Part>,
    to: Bits,
}

/// Bytes that become the same.
struct Part {
    kind: Kind,
    bytes: Range<usize>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// A reference to what is so many bytes before.
    Reference(usize),
    /// Themselves.
    Stored,
    /// Shorter, it is hoped.
    Deflated,
}

impl Deflater {
    /// One that has packed nothing yet.
    pub fn new() -> Self {
        let [all, runs] = [Strategy::Default, Strategy::Rle].map(|strategy| {
            Deflate::new_with_config(DeflateConfig {
                level: LEVEL,
                method: Method::Deflated,
                // Negative: neither a start nor a checksum.
                window_bits: -WINDOW_BITS,
                mem_level: MEMORY_LEVEL,
                strategy,
            })
        });
        Self { all, runs, parts: Vec::new(), to: Bits::default() }
    }

    /// The stream of some bytes, which are rows of `strips` strips of `strip` bytes each; nothing
    /// if the deflate fails.
    pub fn pack(&mut self, bytes: &[u8], strip: usize, strips: usize) -> Option<&[u8]> {
        self.divide(bytes, strip, strips);
        let Self { all, runs, parts, to } = self;
        to.begin(&START);
        for Part { kind, bytes: range } in parts.iter() {
            let part = &bytes[range.clone()];
            match kind {
                Kind::Reference(distance) => to.refer(part.len(), *distance),
                Kind::Stored => to.store(part),
                Kind::Deflated if strip >= STRIP_MIN && has_runs_alone(part) => {
                    deflate(runs, part, to)?;
                }
                Kind::Deflated => deflate(all, part, to)?,
            }
        }
        Some(to.end(&adler32(1, bytes).to_be_bytes()))
    }

    /// Finds the parts.
    fn divide(&mut self, bytes: &[u8], strip: usize, strips: usize) {
        self.parts.clear();
        if strip < STRIP_MIN {
            self.add(Kind::Deflated, 0..bytes.len());
            return;
        }
        for (row, start) in bytes.chunks(strip * strips).zip((0..).step_by(strip * strips)) {
            for at in (0..row.len()).step_by(strip) {
                let (first, end) = (start + at, start + at + strip);
                if let Some(distance) = repeated(row, at, strip) {
                    // This is the difference to the end of the strip before.
                    self.add(Kind::Stored, first..first + 1);
                    self.add(Kind::Reference(distance), first + 1..end);
                    continue;
                }
                for first in (first..end).step_by(PIECE) {
                    let piece = first..end.min(first + PIECE);
                    let is_noise = is_noise(&bytes[piece.clone()]);
                    self.add(if is_noise { Kind::Stored } else { Kind::Deflated }, piece);
                }
            }
        }
    }

    /// Adds bytes to the parts.
    fn add(&mut self, kind: Kind, bytes: Range<usize>) {
        match self.parts.last_mut() {
            Some(last) if last.kind == kind => last.bytes.end = bytes.end,
            // One byte is nothing to begin a block for.
            Some(last) if bytes.len() == 1 && last.kind == Kind::Deflated => {
                last.bytes.end = bytes.end;
            }
            Some(_) | None => self.parts.push(Part { kind, bytes }),
        }
    }
}

/// Appends what a deflate makes of a part.
fn deflate(deflate: &mut Deflate, part: &[u8], to: &mut Bits) -> Option<()> {
    deflate.reset();
    let mut is_done = false;
    to.blocks(compress_bound(part.len()) + FLUSH, |room| {
        let status = deflate.compress(part, room, DeflateFlush::SyncFlush);
        is_done = status.is_ok() && deflate.total_in() as usize == part.len();
        deflate.total_out() as usize
    });
    is_done.then_some(())
}

/// How far before a strip of a row the same is, but for its first byte. What repeats itself all the
/// time is left to the deflate, for which that is short.
fn repeated(row: &[u8], at: usize, strip: usize) -> Option<usize> {
    let rest_at = |at: usize| &row[at + 1..at + strip];
    let rest = rest_at(at);
    let distances = (strip..=at.min(REACH)).step_by(strip);
    let distance = distances.into_iter().find(|distance| rest_at(at - distance) == rest)?;
    let regular = rest.iter().zip(&rest[2..]).filter(|(a, b)| a == b).count();
    (2 * regular < strip).then_some(distance)
}

/// Whether bytes hardly ever repeat the second one before, unless they repeat the last: numbers
/// that are the same in a row have differences that come in turn.
fn has_runs_alone(bytes: &[u8]) -> bool {
    let in_turn = |piece: &[u8]| -> u16 {
        let second = piece.iter().zip(piece.iter().skip(1)).zip(piece.iter().skip(2));
        second.map(|((a, b), c)| u16::from(a == c) & u16::from(b != c)).sum()
    };
    let in_turn: usize = bytes.chunks(PIECE).map(|piece| usize::from(in_turn(piece))).sum();
    32 * in_turn < bytes.len()
}

/// Whether bytes are spread so evenly that no code makes them shorter by a twentieth.
fn is_noise(bytes: &[u8]) -> bool {
    let mut counts = [[0_u16; 256]; 4];
    // Of four tables, as it takes its time to add to what has just been added to.
    let fours = bytes.as_chunks::<4>().0;
    for four in fours {
        for (counts, byte) in counts.iter_mut().zip(four) {
            counts[usize::from(*byte)] += 1;
        }
    }
    let count = |byte: usize| counts.iter().map(|counts| u64::from(counts[byte])).sum::<u64>();
    let of_equals: u64 = (0..256).map(|byte| count(byte).pow(2)).sum();
    // Of all pairs of bytes one of 256 is of equals in noise, and more with any shorter code. Each
    // byte is with itself, too.
    let all = 4 * fours.len() as u64;
    200 * (of_equals - all) < all * all
}

#[cfg(test)]
mod tests {
    use zlib_rs::{Inflate, InflateFlush, Status};

    use super::*;
    use crate::math::hash::combine;

    fn read_back(packed: &[u8], length: usize) -> Vec<u8> {
        let mut read = vec![0; length];
        let status = Inflate::new(true, 15).decompress(packed, &mut read, InflateFlush::Finish);
        assert_eq!(status, Ok(Status::StreamEnd));
        read
    }

    /// Rows of strips of all kinds, of even and odd lengths.
    #[test]
    fn what_is_packed_comes_back() {
        let noise = |index: usize| combine(3, index as u32) as u8;
        let mut deflater = Deflater::new();
        for strip in [2, 64, 1024, 1026, 3840, 5000, 12_000] {
            for (strips, rows) in [(1, 3), (4, 1), (6, 2), (15, 16)] {
                let bytes = (0..strip * strips * rows).map(|index| match index / strip % strips {
                    0 | 3 => noise(index % strip),
                    1 => [128, noise(index)][usize::from(noise(index / 100) > 200)],
                    2 => [3, 250][index % 2],
                    4 => noise(index),
                    _ => 128,
                });
                let bytes: Vec<u8> = bytes.collect();
                let packed = deflater.pack(&bytes, strip, strips).expect("it is packed");
                assert!(read_back(packed, bytes.len()) == bytes, "{strip} {strips} {rows}");
                assert!(packed.len() < bytes.len() + bytes.len() / 64 + 64, "{strip} {strips}");
            }
        }
    }

    /// Noise costs a few bytes, what is there twice nothing, and one byte alone nearly nothing.
    #[test]
    fn each_kind_is_as_short_as_it_can_be() {
        const STRIP: usize = 4096;
        let noise: Vec<u8> = (0..STRIP as u32).map(|index| combine(5, index) as u8).collect();
        assert!(is_noise(&noise) && !has_runs_alone(&[1, 2].repeat(STRIP)));
        let mut deflater = Deflater::new();
        let mut length_of =
            |bytes: &[u8], strips| deflater.pack(bytes, STRIP, strips).expect("it is packed").len();
        assert!(length_of(&noise, 1) < STRIP + 20);
        assert!(length_of(&noise.repeat(4), 4) < STRIP + 300);
        assert!(length_of(&[128; 64 * STRIP], 4) < 400);
        assert!(length_of(&[1, 2].repeat(32 * STRIP), 4) < 1200);
    }
}
