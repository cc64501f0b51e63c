//! Floor 8: schedules. Each integrator reads as the list of its stages, over one chunk.

pub mod bdpt;
mod bounce;
pub mod light;
pub mod light_walk;
pub mod path;
pub mod photons;
pub mod ppm;
pub mod profile;
mod sensor_walk;
pub mod workspace;
