//! Floor 6: where measured light is added up. No files, no render loop.

pub mod accumulator;
pub mod image;

pub use accumulator::Film;
pub use image::StokesImage;
