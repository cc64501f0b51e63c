//! The scene floor: what files of glTF and Mitsuba mean, what is refused, and the shipped scenes.

mod built;
mod common;
mod errors;
mod far;
mod framed;
mod fuzz;
mod meaning;
mod media;
mod mended;
mod mitsuba;
mod mitsuba_errors;
mod moving;
mod reference;
mod refused;
mod room;
mod rough;
mod sheets;
mod spectra;
mod textures;
