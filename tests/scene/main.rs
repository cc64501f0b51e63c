//! The scene floor: what files of glTF and Mitsuba mean, what is refused, and the shipped scenes.

mod blender;
mod built;
mod common;
mod errors;
mod far;
mod films;
mod framed;
mod fuzz;
mod layered;
mod luminaires;
mod meaning;
mod media;
mod mended;
mod mitsuba;
mod mitsuba_errors;
mod mitsuba_textures;
mod moving;
mod plastic;
mod reference;
mod refused;
mod room;
mod rough;
mod skies;
mod spectra;
mod stokes;
mod textures;
