//! The scene as the user describes it: entities with components in a hecs world.
//!
//! | entity | components |
//! |---|---|
//! | material | [`Order`], [`Name`], [`Bsdf`], [`Sides`], [`Emission`] if it emits |
//! | medium | [`Order`], [`Name`], [`Medium`], [`FillsScene`] if it does |
//! | part of a mesh instance | those of all shapes, [`Mesh`] |
//! | sphere | those of all shapes, [`Ball`] |
//! | all shapes | [`Order`], [`Name`], [`Transform`], [`MadeOf`], [`Boundary`] |
//! | punctual light | [`Order`], [`Name`], [`Transform`], [`Punctual`] |
//! | camera | [`Order`], [`Name`], [`Transform`], [`Lens`], [`Film`] if the file states its size |
//! | environment | [`Order`], [`Name`], [`Environment`] |
//!
//! Everything in here has been validated by the loader; `bake` adds what depends on the
//! wavelengths and on world space.

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use glam::{DAffine3, Vec3};
use hecs::Entity;

use crate::polarization::milk::Milk;
use crate::polarization::particles::Sizes;
use crate::spectrum::Spectrum;

/// A loaded scene.
pub struct World {
    pub(super) entities: hecs::World,
    pub(super) name: String,
    pub(super) file: PathBuf,
    pub(super) warnings: Vec<String>,
}

impl fmt::Debug for World {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let count = self.entities.len();
        write!(f, "World {:?} from {:?} of {count} entities", self.name, self.file)
    }
}

impl World {
    /// The entities; see the module's table for their components.
    pub fn entities(&self) -> &hecs::World {
        &self.entities
    }

    /// The scene's own name, or the file's if it has none.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What the file asks for and the renderer ignores, one sentence each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Entities that match a query, in the file's order, each turned into what `f` makes of it.
    pub(super) fn in_order<Q: hecs::Query, T>(
        &self,
        f: impl for<'a> Fn(Q::Item<'a>) -> T,
    ) -> Vec<T> {
        let mut query = self.entities.query::<(&Order, Q)>();
        let mut rows: Vec<(u32, T)> =
            query.iter().map(|(order, components)| (order.0, f(components))).collect();
        rows.sort_by_key(|(order, _)| *order);
        rows.into_iter().map(|(_, row)| row).collect()
    }
}

/// Position in the file: what makes the order of all tables a function of the file alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Order(pub u32);

/// How errors and reports call the entity: kind, index in the file and name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Name(pub String);

/// From the entity's own space to world space; invertible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform(pub DAffine3);

/// Triangles, shared by all instances of a mesh.
#[derive(Clone, Debug)]
pub struct Mesh(pub Arc<Geometry>);

/// Indexed triangles in the space of the mesh, counter-clockwise from the front.
#[derive(Clone, Debug)]
pub struct Geometry {
    /// Vertex positions, finite.
    pub positions: Vec<Vec3>,
    /// Unit vertex normals, as many as positions, or none. Where the file's are not usable, zero.
    pub normals: Vec<Vec3>,
    /// Corners: rows of `positions`. Not empty; every triangle has an area.
    pub triangles: Vec<[u32; 3]>,
}

/// A sphere about the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Radius before the transform, greater than zero.
    pub radius: f64,
}

/// The material entity of a mesh part or sphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MadeOf(pub Entity);

/// How a material scatters light.
#[derive(Clone, Debug, PartialEq)]
pub enum Bsdf {
    /// Absorbs everything.
    Absorber,
    /// Lambertian.
    Diffuse {
        /// Directional-hemispherical reflectance, within [0, 1].
        reflectance: Spectrum,
    },
    /// Smooth metal of index n - i k.
    Conductor {
        /// Real part n > 0 of the index of refraction.
        eta: Spectrum,
        /// Extinction coefficient k >= 0.
        k: Spectrum,
    },
    /// Smooth boundary between two dielectrics.
    Dielectric {
        /// Index of refraction behind the front, greater than zero.
        ior: f32,
        /// Index of refraction before the front, greater than zero; 1 in vacuum.
        exterior_ior: f32,
    },
    /// Sheet polarizer.
    Polarizer {
        /// Transmission axis from the node's x axis, counter-clockwise about the front's normal.
        axis_deg: f64,
        /// Greatest over least transmittance, at least 1; infinite for an ideal polarizer.
        extinction_ratio: f64,
    },
    /// Linear retarder.
    Retarder {
        /// Fast axis from the node's x axis, counter-clockwise about the front's normal.
        axis_deg: f64,
        /// Retardance in degrees.
        retardance_deg: f64,
    },
    /// Nothing but a boundary between media of the same index of refraction.
    Null,
}

impl Bsdf {
    /// Whether light passes through to the other side.
    pub fn transmits(&self) -> bool {
        match self {
            Self::Absorber | Self::Diffuse { .. } | Self::Conductor { .. } => false,
            Self::Dielectric { .. }
            | Self::Polarizer { .. }
            | Self::Retarder { .. }
            | Self::Null => true,
        }
    }
}

/// What the file says about the media on the two sides of a surface. What it does not say is
/// up to the material; see `bake`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Boundary {
    /// Behind the surface, against its normal.
    pub interior: Option<Filling>,
    /// Before the surface.
    pub exterior: Option<Filling>,
}

/// What fills a space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filling {
    /// Nothing that absorbs or scatters.
    Clear,
    /// A medium entity.
    Medium(Entity),
}

/// Marks the medium that fills the scene outside all boundaries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FillsScene;

/// A homogeneous participating medium.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium {
    /// Absorption coefficient in 1/m, not negative; none if it follows from the particles.
    pub sigma_a: Option<Spectrum>,
    /// Scattering coefficient in 1/m, not negative; none if it follows from the particles.
    pub sigma_s: Option<Spectrum>,
    /// How it scatters.
    pub phase: Phase,
}

/// A phase function, or what it follows from.
#[derive(Clone, Debug, PartialEq)]
pub enum Phase {
    /// Henyey and Greenstein 1941, an ideal depolarizer.
    HenyeyGreenstein {
        /// Mean cosine of the scattering angle, within (-1, 1); 0 is isotropic.
        g: Spectrum,
    },
    /// Particles much smaller than the wavelength.
    Rayleigh {
        /// Ratio of the two intensities scattered at 90 degrees from unpolarized light, 0 to 1/2.
        depolarization: f64,
    },
    /// Spheres in a host, by the theory of Lorenz and Mie.
    Spheres(Spheres),
    /// Fat and casein in water, likewise.
    Milk(Milk),
    /// Phase matrices at increasing wavelengths; one alone holds for all wavelengths.
    Table(Vec<TabulatedMatrix>),
}

/// Spheres in a host that absorbs but does not scatter.
#[derive(Clone, Debug, PartialEq)]
pub struct Spheres {
    /// What is suspended; not empty, and together no more than the whole volume.
    pub components: Vec<Component>,
    /// Real part of the host's index of refraction n - i k.
    pub host_eta: Spectrum,
    /// Extinction coefficient of the host.
    pub host_k: Spectrum,
}

/// Spheres of one substance.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// Their sizes.
    pub sizes: Sizes,
    /// Real part of their index of refraction n - i k.
    pub eta: Spectrum,
    /// Extinction coefficient k.
    pub k: Spectrum,
    /// Share of the volume that they fill, within (0, 1].
    pub volume_fraction: f64,
}

/// A phase matrix of one wavelength at some angles.
#[derive(Clone, Debug, PartialEq)]
pub struct TabulatedMatrix {
    /// Wavelength in vacuum in nanometers; none if it holds for all.
    pub wavelength_nm: Option<f64>,
    /// Scattering angles in degrees, increasing from 0 to 180.
    pub theta_deg: Vec<f64>,
    /// M00, M01, M11, M22, M23, M33 in 1/sr at each angle: finite, M00 not negative and not less
    /// than any other, its integral over the sphere of directions about one.
    pub elements: Vec<[f64; 6]>,
}

/// Which sides of a material's surfaces reflect and emit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sides {
    /// Back like front; otherwise the back is black and dark.
    pub two_sided: bool,
}

/// Light that leaves a material's surfaces, the same in all directions, unpolarized.
#[derive(Clone, Debug, PartialEq)]
pub struct Emission {
    /// Radiance in W/(m^2 sr); not negative, not zero throughout.
    pub radiance: Spectrum,
}

/// A light without extent, along the -z axis of its transform.
#[derive(Clone, Debug, PartialEq)]
pub struct Punctual {
    /// Its shape.
    pub kind: PunctualKind,
    /// Radiant intensity in W/sr, or irradiance in W/m^2 if directional; not negative, not zero
    /// throughout.
    pub intensity: Spectrum,
}

/// Shapes of punctual lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PunctualKind {
    /// The same in all directions.
    Point,
    /// A cone.
    Spot {
        /// Half angle of full intensity in radians, at least 0.
        inner: f64,
        /// Half angle of the whole cone in radians, at most pi/2, not less than `inner`.
        outer: f64,
    },
    /// Infinitely far away.
    Directional,
}

/// How the camera projects; it looks along the -z axis of its transform, y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// Pinhole or thin lens.
    Perspective {
        /// Vertical angle of view in radians, within (0, pi).
        yfov: f64,
        /// Width over height, if the file states it.
        aspect: Option<f32>,
        /// Radius of the lens; 0 for a pinhole.
        aperture_radius: f32,
        /// Distance of the plane in focus, greater than zero.
        focus_distance: f32,
    },
    /// Parallel projection.
    Orthographic {
        /// Half the width of the picture, greater than zero.
        half_width: f32,
        /// Half the height of the picture, greater than zero.
        half_height: f32,
    },
}

/// The film's size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Film {
    /// Width and height in pixels.
    pub resolution: [u32; 2],
}

/// Constant radiance from all directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Radiance in W/(m^2 sr); not negative, not zero throughout.
    pub radiance: Spectrum,
}
