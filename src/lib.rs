//! Sunstone: a bidirectional, polarized, data-oriented light-transport renderer.
//!
//! The modules are floors; each imports only from lower ones (`tests/floors.rs` checks):
//!
//! | floor | module | holds |
//! |---|---|---|
//! | 0 | [`math`] | numbers, lanes, vectors, hashing |
//! | 1 | [`spectrum`] | wavelengths and color |
//! | 1 | [`polarization`] | Stokes vectors, Mueller kernels, Fresnel, carriers |
//! | 2 | [`scene`] | glTF in, a hecs world, dense tables out |
//! | 3 | [`geometry`] | the tree: closest hit, visibility |
//! | 4 | [`scattering`] | materials, emitters, the sensor |
//! | 5 | [`transport`] | tables of paths and the stages that advance them |
//! | 6 | [`film`] | where measured light is added up |
//! | 7 | [`integrators`] | schedules of stages: `path`, `light`, `bdpt`, `ppm` |
//! | 8 | [`output`] | EXR, HDR, PNG, comparison, reports |
//! | 9 | [`cli`] | arguments, jobs, verbs |
//!
//! hecs holds the scene that the user describes; `bake` reads it once into dense tables. Paths,
//! vertices and film samples are structure-of-arrays tables of their own and the systems that
//! advance them are free functions, so do not look for a `World` there.

pub mod cli;
pub mod film;
pub mod geometry;
pub mod integrators;
pub mod math;
pub mod output;
pub mod polarization;
pub mod scattering;
pub mod scene;
pub mod spectrum;
pub mod transport;
