//! Floor 5: tables of paths and vertices, and the systems that advance them.
//!
//! A stage is a free function that names the columns it writes (`&mut`, first) and reads. The
//! integrators call them in order; nothing else decides what happens next.

pub mod chunk;
pub mod light_model;
pub mod mis;
pub mod sampler;
pub mod stages;
pub mod strategy;
pub mod tables;

pub use chunk::Chunk;
pub use light_model::{LightModel, Polarized, Scalar};
pub use strategy::Strategy;
