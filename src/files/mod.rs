//! Floor 0: files of no particular content: temporary ones, and those of the cache.

pub mod cache;
pub mod temporary;
