//! Streams of deflate in the making: what is stored, and what refers to earlier bytes (RFC 1951).

/// Most bytes of a stored block.
const STORED_MAX: usize = 0xffff;
/// Most bytes of a reference, and fewest.
const REFERENCE_MAX: usize = 258;
const REFERENCE_MIN: usize = 3;
/// The symbol that ends a block.
const END: u32 = 256;
/// The symbol of the shortest reference, and that of the longest.
const SHORTEST: u32 = 257;
const LONGEST: u32 = 285;
/// The first symbol with eight bits and the code that it has; those from [`END`] on have seven.
const LONG_CODES: (u32, u32) = (280, 0xc0);
/// Bits before a block: whether it is the last one, and its kind.
const HEADER_BITS: u32 = 3;
/// Of a block with the codes that every reader knows.
const KNOWN_CODES: u32 = 0b010;

/// Bytes of a stream, and the bits of one that is not complete.
#[derive(Default)]
pub struct Bits {
    bytes: Vec<u8>,
    held: u32,
    count: u32,
}

impl Bits {
    /// Begins a stream.
    pub fn begin(&mut self, bytes: &[u8]) {
        self.bytes.clear();
        self.bytes.extend_from_slice(bytes);
    }

    /// Ends the blocks, and adds some bytes behind them.
    pub fn end(&mut self, bytes: &[u8]) -> &[u8] {
        self.header(true, 0);
        self.bytes.extend_from_slice(bytes);
        &self.bytes
    }

    /// Blocks of bytes as they are.
    pub fn store(&mut self, bytes: &[u8]) {
        for block in bytes.chunks(STORED_MAX) {
            self.header(false, block.len() as u16);
            self.bytes.extend_from_slice(block);
        }
    }

    /// A block of as many bytes as are `distance` bytes earlier: three or more, up to 2^15 earlier.
    pub fn refer(&mut self, length: usize, distance: usize) {
        self.put(KNOWN_CODES, HEADER_BITS);
        let mut left = length;
        while left > 0 {
            // What is left must be long enough for another reference.
            let now = match left - left.min(REFERENCE_MAX) {
                1..REFERENCE_MIN => REFERENCE_MAX - REFERENCE_MIN,
                _ => left.min(REFERENCE_MAX),
            };
            self.length(now as u32);
            self.distance(distance as u32);
            left -= now;
        }
        self.symbol(END);
    }

    /// Blocks that others write to so many bytes, of which they return how many they have written.
    pub fn blocks(&mut self, room: usize, write: impl FnOnce(&mut [u8]) -> usize) {
        if self.count > 0 {
            self.header(false, 0);
        }
        let start = self.bytes.len();
        self.bytes.resize(start + room, 0);
        let length = write(&mut self.bytes[start..]);
        self.bytes.truncate(start + length);
    }

    /// The head of a stored block, which ends with a byte.
    fn header(&mut self, is_last: bool, length: u16) {
        self.put(is_last.into(), HEADER_BITS);
        self.put(0, self.count.wrapping_neg() % 8);
        self.bytes.extend([length.to_le_bytes(), (!length).to_le_bytes()].as_flattened());
    }

    /// The length of a reference: a symbol for each up to 10, then four for every power of two.
    fn length(&mut self, length: u32) {
        let beyond = length - REFERENCE_MIN as u32;
        if length == REFERENCE_MAX as u32 {
            self.symbol(LONGEST);
        } else if beyond < 8 {
            self.symbol(SHORTEST + beyond);
        } else {
            let bits = beyond.ilog2() - 2;
            self.symbol(SHORTEST + 4 * bits + (beyond >> bits));
            self.put(beyond & ((1 << bits) - 1), bits);
        }
    }

    /// The distance of a reference: a symbol for each up to 4, then two for every power of two.
    fn distance(&mut self, distance: u32) {
        let beyond = distance - 1;
        let bits = beyond.max(2).ilog2() - 1;
        self.code(2 * bits + (beyond >> bits), 5);
        self.put(beyond & ((1 << bits) - 1), bits);
    }

    /// A symbol that is no byte.
    fn symbol(&mut self, symbol: u32) {
        let (first, code) = LONG_CODES;
        match symbol.checked_sub(first) {
            Some(beyond) => self.code(code + beyond, 8),
            None => self.code(symbol - END, 7),
        }
    }

    /// A code, which begins with its highest bit.
    fn code(&mut self, code: u32, count: u32) {
        self.put(code.reverse_bits() >> (u32::BITS - count), count);
    }

    /// Up to 16 bits, the lowest first.
    fn put(&mut self, bits: u32, count: u32) {
        self.held |= bits << self.count;
        self.count += count;
        while self.count >= 8 {
            self.bytes.push(self.held as u8);
            self.held >>= 8;
            self.count -= 8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// References of all lengths and distances, read by another.
    #[test]
    fn what_is_referred_to_comes_again() {
        let bytes: Vec<u8> = (0..1_u32 << 15).map(|i| (i * i / 7 % 251) as u8).collect();
        let powers = (0..15).flat_map(|power| [(1 << power) - 1, 1 << power, (1 << power) + 1]);
        let distances: Vec<usize> = powers.filter(|&it| it > 0).chain([1 << 15]).collect();
        for length in (3..600).chain([3839, 70_000]) {
            let (mut bits, mut expected) = (Bits::default(), bytes.clone());
            bits.begin(&[]);
            bits.store(&bytes);
            for &distance in &distances {
                bits.refer(length, distance);
                (0..length).for_each(|_| expected.push(expected[expected.len() - distance]));
                bits.store(&[7]);
                expected.push(7);
            }
            let mut read = vec![0; expected.len()];
            let mut inflate = zlib_rs::Inflate::new(false, 15);
            let status =
                inflate.decompress(bits.end(&[]), &mut read, zlib_rs::InflateFlush::Finish);
            assert_eq!(status, Ok(zlib_rs::Status::StreamEnd), "{length}");
            assert!(read == expected, "{length}");
        }
    }
}
