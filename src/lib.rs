//! Sunstone: a bidirectional, polarized, data-oriented light-transport renderer.
//!
//! The modules are floors; each imports only from lower ones (`tests/floors` checks):
//!
//! | floor | module | holds |
//! |---|---|---|
//! | 0 | `math` | numbers, lanes, vectors, hashing, statistics |
//! | 1 | `spectrum` | wavelengths and color |
//! | 1 | `polarization` | Stokes vectors, Mueller kernels, Fresnel, carriers |
//! | 2 | `image` | Stokes images, their formats, maps and comparison |
//! | 3 | `film` | where measured light is added up |
//! | 4 | `scene` | glTF in, a hecs world, dense tables out |
//! | 5 | `geometry` | the tree: closest hit, visibility |
//! | 6 | `scattering` | materials, emitters, the sensor |
//! | 7 | `transport` | tables of paths and the stages that advance them |
//! | 8 | `integrators` | schedules of stages: `path`, `light`, `bdpt`, `ppm` |
//! | 9 | `render` | schedules over a film: tiles, photon passes, threads |
//! | 10 | `bench` | what measures and reports |
//! | 11 | `cli` | arguments, jobs, verbs |
//!
//! A film develops into an image, hence the order of these two; both lie below the scene, which
//! reads images.
//!
//! hecs holds the scene that the user describes; `bake` reads it once into dense tables. Paths,
//! vertices and film samples are structure-of-arrays tables of their own and the systems that
//! advance them are free functions, so do not look for a `World` there.

mod bench;
mod cli;
mod film;
mod geometry;
mod image;
mod integrators;
mod math;
mod polarization;
mod render;
mod scattering;
mod scene;
mod spectrum;
mod transport;

/// The rooms behind the door, for the tests of one room and the benches of kernels. Nothing in here
/// is promised to stay.
#[doc(hidden)]
pub mod internals {
    pub mod bench {
        pub use crate::bench::*;
    }
    pub mod cli {
        pub use crate::cli::*;
    }
    pub mod film {
        pub use crate::film::*;
    }
    pub mod geometry {
        pub use crate::geometry::*;
    }
    pub mod image {
        pub use crate::image::*;
    }
    pub mod integrators {
        pub use crate::integrators::*;
    }
    pub mod math {
        pub use crate::math::*;
    }
    pub mod polarization {
        pub use crate::polarization::*;
    }
    pub mod render {
        pub use crate::render::*;
    }
    pub mod scattering {
        pub use crate::scattering::*;
    }
    pub mod scene {
        pub use crate::scene::*;
    }
    pub mod spectrum {
        pub use crate::spectrum::*;
    }
    pub mod transport {
        pub use crate::transport::*;
    }
}
