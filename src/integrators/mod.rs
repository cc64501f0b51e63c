//! Floor 8: schedules. Paths of either side take one walk over a chunk; each integrator says what
//! is done at its vertices.
//!
//! Adding one: its file, with a type that is a [`Schedule`], and its line in the list below.

pub mod bdpt;
mod connect;
pub mod light;
pub mod path;
pub mod photons;
pub mod ppm;
pub mod profile;
mod sides;
mod walk;
pub mod workspace;

use crate::scattering::Scene;
use crate::transport::tables::photon_maps::PhotonMaps;
use crate::transport::{Chunk, LightModel};

use workspace::Workspace;

/// What makes an integrator.
pub trait Schedule {
    /// What reports and the command line call it.
    const NAME: &'static str;
    /// How it finds light, in a line.
    const SUMMARY: &'static str;
    /// Whether its sensor paths measure light, in `workspace.measured`.
    const MEASURES: bool;
    /// Whether its light paths reach the film, by `workspace.splats`.
    const SPLATS: bool;
    /// Whether photons are shot before its chunks.
    const PHOTONS: bool;
    /// Path length from which on roulette plays for sensor paths, if nothing else is asked for:
    /// what has measured best.
    const ROULETTE_AFTER: u32 = 5;

    /// Renders one chunk. There are photons if [`Schedule::PHOTONS`] asks for them.
    fn chunk<const N: usize, M: LightModel<N>>(
        workspace: &mut Workspace<N, M>,
        scene: &Scene<N>,
        chunk: &Chunk,
        photons: Option<&PhotonMaps<N>>,
    );
}

macro_rules! integrators {
    ($($(#[$doc:meta])* $name:ident = $schedule:ty,)*) => {
        /// How light is found.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Integrator {
            $($(#[$doc])* $name,)*
        }

        impl Integrator {
            /// All integrators.
            pub const ALL: &[Self] = &[$(Self::$name),*];

            /// What reports and the command line call it.
            pub fn name(self) -> &'static str {
                match self { $(Self::$name => <$schedule>::NAME,)* }
            }

            /// How it finds light, in a line.
            pub fn summary(self) -> &'static str {
                match self { $(Self::$name => <$schedule>::SUMMARY,)* }
            }

            /// Whether its sensor paths measure light.
            pub fn measures(self) -> bool {
                match self { $(Self::$name => <$schedule>::MEASURES,)* }
            }

            /// Whether its light paths reach the film.
            pub fn splats(self) -> bool {
                match self { $(Self::$name => <$schedule>::SPLATS,)* }
            }

            /// Whether it merges photons, which are shot before its chunks.
            pub fn shoots_photons(self) -> bool {
                match self { $(Self::$name => <$schedule>::PHOTONS,)* }
            }

            /// Whether paths carry partial weights of all strategies that find them: those do of
            /// integrators whose light paths reach the film.
            pub(crate) fn weighs_strategies(self) -> bool {
                self.splats()
            }

            /// Path length from which on roulette plays for sensor paths, if nothing else is asked
            /// for.
            pub fn roulette_after(self) -> u32 {
                match self { $(Self::$name => <$schedule>::ROULETTE_AFTER,)* }
            }

            /// Renders one chunk.
            pub(crate) fn chunk<const N: usize, M: LightModel<N>>(
                self,
                workspace: &mut Workspace<N, M>,
                scene: &Scene<N>,
                chunk: &Chunk,
                photons: Option<&PhotonMaps<N>>,
            ) {
                match self {
                    $(Self::$name => <$schedule>::chunk(workspace, scene, chunk, photons),)*
                }
            }
        }
    };
}

integrators! {
    /// From the sensor, with next-event estimation.
    Path = path::Path,
    /// From the emitters, connected to the sensor.
    Light = light::Light,
    /// From both, with all connections.
    Bdpt = bdpt::Bdpt,
    /// From both, merged: progressive photon mapping.
    Ppm = ppm::Ppm,
}
