//! Floor 0: files of no particular content: temporary ones, and those of the cache.

pub mod cache;
pub mod temporary;
pub mod tensors;

use std::io::ErrorKind;

/// Whether what the system refuses may go well a moment later: a full disk, a server that does not
/// answer; not a file that is not there, or that nobody may read.
pub fn may_pass(kind: ErrorKind) -> bool {
    let stays = [
        ErrorKind::NotFound,
        ErrorKind::PermissionDenied,
        ErrorKind::InvalidInput,
        ErrorKind::InvalidData,
        ErrorKind::InvalidFilename,
        ErrorKind::IsADirectory,
        ErrorKind::NotADirectory,
        ErrorKind::ReadOnlyFilesystem,
    ];
    !stays.contains(&kind)
}
