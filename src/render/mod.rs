//! Floor 9: renders. A [`PlacedWorld`] is what a world is baked to; a [`Renderer`] runs an
//! integrator over the tiles of a film of it, the one place where scalar or polarized, and how
//! many wavelengths, is chosen.

pub mod doubts;
mod facts;
mod immersed;
mod layers;
pub mod memory;
mod photon_pass;
mod place;
mod placed;
mod recorded;
mod renderer;
pub mod resolved;
mod run;
mod sets;
pub mod settings;
mod shared;
pub mod spectral;
pub mod statistics;
mod sums;
pub mod system;
pub mod threads;
mod tiles;

pub use place::{Part, check_part};
pub use placed::PlacedWorld;
pub use recorded::{
    BUILD, PartError, describe as describe_part, is_part, merge, merge_as_asked_for,
};
pub use renderer::{Progress, RenderError, Renderer, Stop};
pub use resolved::{Passes, Resolved, Rule};
pub use settings::{Mode, Options, Photons, Settings, SettingsError};
pub use spectral::Spectral;
