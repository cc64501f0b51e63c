//! Floor 6: where light starts, turns and ends. One file per model: sampling, evaluation,
//! densities and Mueller kernels.
//!
//! Before light goes through it, a scene is looked at: `patches` joins surfaces to bodies,
//! `boundaries` finds what is on their sides, by the looks of `immersion`, and `nesting` which of
//! them share a place; `look` and `shut_in` find what integrators will have to do with (what
//! `subject` says looks the same is looked at once), and `targets` what light paths are aimed at.
//!
//! Scalar values only decide where paths go; kernels are relative to them (`polarization`), so
//! that scalar and polarized renders trace the same paths.

pub mod boundaries;
pub mod emitter;
pub mod event;
pub mod immersion;
pub mod look;
pub mod medium;
pub mod nesting;
pub mod painting;
pub mod patches;
pub mod phase;
pub mod scene;
pub mod sensor;
pub mod shut_in;
pub mod side;
pub mod subject;
pub mod surface;
pub mod targets;
pub mod vertex;

pub use event::{Event, Met};
pub use look::Look;
pub use scene::Scene;
pub use sensor::Sensor;
pub use side::Side;
pub use subject::Looks;
