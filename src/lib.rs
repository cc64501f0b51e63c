//! Sunstone: a bidirectional, polarized, data-oriented light-transport renderer.
//!
//! A [`World`] is made in code or read by [`load`]; placed, it is rendered by any number of
//! [`Renderer`]s:
//!
//! ```
//! use std::ops::ControlFlow;
//! use sunstone::glam::{DVec3, Vec3};
//! use sunstone::world::{Bsdf, Geometry, Lens, Material, Transform};
//! use sunstone::{Integrator, Options, PlacedWorld, Renderer, Settings, World};
//!
//! # fn main() -> Result<(), sunstone::Error> {
//! // A room with a lamp, a glass sphere and a metal plate.
//! let mut world = World::new("room");
//! let wall = world.add_material("wall", Material::from(Bsdf::diffuse(0.7)).two_sided())?;
//! let glass = world.add_material("glass", Bsdf::dielectric(1.5))?;
//! let metal = world.add_material("plate", Bsdf::metal("Al")?)?;
//! let glow = world.add_material("lamp", Material::emitter([20.0, 18.0, 15.0]).two_sided())?;
//! let here = Transform::IDENTITY;
//! world.add_mesh("walls", Geometry::cuboid(-Vec3::ONE, Vec3::ONE), wall, here)?;
//! let lamp = Geometry::quad(Vec3::Y * 0.99, Vec3::X * 0.3, Vec3::Z * 0.3);
//! world.add_mesh("lamp", lamp, glow, here)?;
//! let plate = Geometry::quad(Vec3::Z * -0.9, Vec3::X * 0.5, Vec3::Y * 0.5);
//! world.add_mesh("plate", plate, metal, here)?;
//! world.add_sphere("ball", 0.4, glass, DVec3::new(0.2, -0.6, 0.0))?;
//! let place = Transform::looking(DVec3::Z * 0.9, DVec3::ZERO, DVec3::Y);
//! world.set_camera("eye", Lens::pinhole(1.2), place)?;
//! world.set_resolution([32, 32])?;
//!
//! // Rendered with polarization, and stopped before the end.
//! let options = Options { integrator: Some(Integrator::Path), ..Options::default() };
//! let mut renderer = Renderer::new(&PlacedWorld::new(world)?, &Settings::new(options)?)?;
//! renderer.run(|progress| match progress.samples {
//!     32.. => ControlFlow::Break(()),
//!     _ => ControlFlow::Continue(()),
//! });
//! let image = renderer.finish();
//! let [height, width, channels, components] = image.shape();
//! assert_eq!([height, width, channels, components], [32, 32, 3, 4]);
//! let stokes: Vec<f32> = image.to_array();
//! assert!(stokes[(16 * width + 16) * channels * components] > 0.0);
//! # Ok(())
//! # }
//! ```
//!
//! # Rooms
//!
//! The modules are floors; each imports only from lower ones (`tests/floors` checks):
//!
//! | floor | module | holds |
//! |---|---|---|
//! | 0 | `files` | temporary files, and a cache of what takes long to compute |
//! | 0 | `math` | numbers, lanes, vectors, hashing, statistics, words |
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
//! | 11 | `batch` | many renders from one job file |
//! | 12 | `cli` | arguments, verbs |
//!
//! A film develops into an image, hence the order of these two; both lie below the scene, which
//! reads images.
//!
//! hecs holds the scene that the user describes; `bake` reads it once into dense tables. Paths,
//! vertices and film samples are structure-of-arrays tables of their own and the systems that
//! advance them are free functions, so do not look for a `World` there.

// What tests compare with may be the system's.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod batch;
mod bench;
mod cli;
mod files;
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

pub use crate::film::filter::{Filter, FilterKind, FilterSamples};
pub use crate::film::layout::{Crop, Layout};
pub use crate::image::cut::Cut;
pub use crate::image::texels::Coding;
pub use crate::image::{OutputError as ImageError, StokesImage};
pub use crate::integrators::Integrator;
pub use crate::polarization::{Analyzer, Distribution};
pub use crate::render::memory::MemoryError;
pub use crate::render::threads::{Threads, ThreadsError};
pub use crate::render::{
    Mode, Options, Part, PartError, Passes, Photons, PlacedWorld, Progress, RenderError, Renderer,
    Resolved, Rule, Settings, SettingsError, Spectral, Stop, merge,
};
pub use crate::scene::{
    Edit, EditedFile, LightChoice, Reading, SceneError, SceneFile, View, World, load, load_with,
    world,
};
pub use crate::spectrum::{Band, Bands, Color, Curves, Spectrum, White, WhiteBalance};
pub use crate::transport::Sampling;
pub use {glam, hecs};

use self::particles::Fault;

/// Whatever goes wrong between a world and its image.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// With the scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// With the settings of a render.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// With the memory: the film, the photons or the shapes are too large for it.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// With threads.
    #[error(transparent)]
    Threads(#[from] ThreadsError),
    /// With the file of an image.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// With a render that goes on from a file, or with parts of an image.
    #[error(transparent)]
    Part(#[from] PartError),
}

impl From<Fault> for Error {
    fn from(fault: Fault) -> Self {
        SceneError::alone(fault).into()
    }
}

impl From<RenderError> for Error {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Scene(error) => error.into(),
            RenderError::Settings(error) => error.into(),
            RenderError::Memory(error) => error.into(),
        }
    }
}

/// What media of spheres are made of: [`world::Phase::Spheres`] and [`world::Phase::Milk`].
///
/// What they do to light is computed once in a process and, where that takes milliseconds, kept for
/// other processes in the folder `sunstone` of the user's caches, or in `SUNSTONE_CACHE`, the
/// absolute path of another folder; `off` keeps none. No bit depends on it.
///
/// ```
/// use sunstone::particles::{Amount, Milk, Sizes};
/// use sunstone::world::{Component, Phase, Spheres, World};
///
/// let mut world = World::new("dairy");
/// let milk = Milk { fat_percent: 3.5, protein_percent: 3.4, dilution: 0.01 };
/// world.add_medium("milk", Phase::Milk(milk))?;
/// let sizes = Sizes::log_normal(0.5, 0.1, Amount::Number, None)?;
/// let beads = Component { sizes, eta: 1.59.into(), k: 0.0.into(), volume_fraction: 1e-4 };
/// let (host_eta, host_k) = (1.33.into(), 0.0.into());
/// let beads = Spheres { components: vec![beads], host_eta, host_k };
/// world.add_medium("beads", Phase::Spheres(beads))?;
/// # Ok::<(), sunstone::Error>(())
/// ```
pub mod particles {
    pub use crate::math::Fault;
    pub use crate::polarization::milk::Milk;
    pub use crate::polarization::particles::{Amount, Sizes};
}

/// Spectra by name and by formula.
///
/// ```
/// use sunstone::spectra::{Line, LineShape, index};
/// use sunstone::world::{Bsdf, Material};
/// use sunstone::{Spectrum, World};
///
/// let mut world = World::new("shop");
/// let (eta, k) = index("Ag").expect("silver is tabulated");
/// world.add_material("mirror", Bsdf::Conductor { eta, k })?;
/// let daylight = Spectrum::illuminant("D65").expect("it is one of the CIE's");
/// world.add_material("window", Material::emitter(daylight.scaled(30.0)))?;
/// world.add_material("bulb", Material::emitter(Spectrum::blackbody(2700.0)?))?;
/// let green = Line { center_nm: 532.0, power: 1.0, width_nm: 0.1 };
/// let laser = Spectrum::lines(&[green], LineShape::Gaussian)?;
/// world.add_material("laser", Material::emitter(laser))?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub mod spectra {
    pub use crate::spectrum::{
        D_NM, Formula, Line, LineShape, SpectrumTable, illuminant_names, index, index_names, metal,
        metal_names,
    };
}

/// What a camera of polarization records of a [`StokesImage`].
///
/// ```
/// use sunstone::mosaic::{Electrons, Filters, PolarizationSensor};
/// use sunstone::{Color, StokesImage};
///
/// // Light that is polarized along x: nothing passes at 90 degrees, all at 0, half between.
/// let mut image = StokesImage::new(2, 2, Color::Mono { wavelength_nm: 550.0 }, 4);
/// image.planes = vec![vec![0.5; 4], vec![0.5; 4], vec![0.0; 4], vec![0.0; 4]];
/// let ideal = PolarizationSensor::ideal(Filters::Mono, 12);
/// assert_eq!(ideal.record(&image)?.values, [0, 1024, 1024, 2048]);
///
/// // The same on a sensor with noise, whose numbers are electrons above 100.
/// let electrons = Electrons { full_well: 3000.0, gain: Some(1.0), read_noise: 2.5 };
/// let real = PolarizationSensor { electrons: Some(electrons), black_level: 100, ..ideal };
/// let raw = real.record(&image)?;
/// assert!(raw.values[0].abs_diff(100) < 20 && raw.values[3].abs_diff(1600) < 200);
/// # Ok::<(), sunstone::Error>(())
/// ```
pub mod mosaic {
    pub use crate::image::mosaic::{AXES_DEG, Electrons, Filters, PolarizationSensor, RawImage};
}

/// The rooms behind the door, for the tests of one room and the benches of kernels. Nothing in here
/// is promised to stay.
#[doc(hidden)]
pub mod internals {
    pub mod batch {
        pub use crate::batch::*;
    }
    pub mod bench {
        pub use crate::bench::*;
    }
    pub mod cli {
        pub use crate::cli::*;
    }
    pub mod files {
        pub use crate::files::*;
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
