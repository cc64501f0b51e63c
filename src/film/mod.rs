//! Floor 6: where measured light is added up. No files, no render loop.

pub mod image;
