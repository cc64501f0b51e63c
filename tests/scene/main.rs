//! The scene floor: what glTF files mean, what is refused, and the shipped scenes.

mod common;
mod errors;
mod fuzz;
mod meaning;
mod media;
mod reference;
