//! Reading a file as a whole.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use super::error::OutputError;

/// The first bytes of a file, `limit` at most. Whatever is not a file, a pipe or a device, might
/// never end and is refused.
pub fn read_bytes(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let found = fs::metadata(path)?;
    if !found.is_file() {
        return Err(io::Error::other("not a file"));
    }
    // As much as is there, and no more: a vector that grows has up to twice that.
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(usize::try_from(found.len().min(limit)).unwrap_or(usize::MAX))?;
    File::open(path)?.take(limit).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The bytes of an image's file.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, OutputError> {
    read_bytes(path, u64::MAX).map_err(|error| OutputError::read(path, error))
}
