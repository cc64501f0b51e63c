//! Numbers out of bytes.

/// Bytes from the first to the last.
pub struct Bytes<'a> {
    rest: &'a [u8],
    is_big_endian: bool,
}

impl<'a> Bytes<'a> {
    /// All of them, from a number of either end first.
    pub fn new(rest: &'a [u8], is_big_endian: bool) -> Self {
        Self { rest, is_big_endian }
    }

    /// How many are left.
    pub fn left(&self) -> usize {
        self.rest.len()
    }

    /// The next ones, in the order of little ends; none if there are not as many.
    pub fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.rest.split_first_chunk::<N>()?;
        self.rest = rest;
        let mut bytes = *first;
        if self.is_big_endian {
            bytes.reverse();
        }
        Some(bytes)
    }

    /// Leaves some out.
    pub fn skip(&mut self, count: usize) -> Option<()> {
        self.rest = self.rest.get(count..)?;
        Some(())
    }
}
