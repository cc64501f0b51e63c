//! Floor 1: the algebra of polarized light. No rendering here.
//!
//! # Conventions (the one statement of them; the same as Mitsuba 3's)
//!
//! - A Stokes vector `(S0, S1, S2, S3)` lives in a right-handed frame `(x, y, k)`: `k` is the
//!   direction in which the light travels and `y = k x x`, so the axis `x` alone names the frame.
//! - Fields are phasors `exp(+i w t)`, metals are `n - i k` with `k > 0`.
//!   `S1 = |Ex|^2 - |Ey|^2`, `S2 = 2 Re(Ex Ey*)`, `S3 = -2 Im(Ex Ey*)`.
//!   `S3 > 0` is right circular: clockwise for a receiver who looks at the source.
//! - A new frame: `S' = R(a) S`, with `a` the signed angle about `+k` from the old `x` to the new.
//! - At an event `x` is the s axis, perpendicular to the plane of incidence or of scattering, and
//!   the same vector before and after; its sign does not matter. Hence the Verdet sign of r_p:
//!   at normal incidence `r_p = -r_s`.
//! - Kernels are relative to their first element `M00`, which the scalar throughput carries. In
//!   the frames of the event they are the block `[[1,a,0,0],[a,1,0,0],[0,0,c,s],[0,0,-s,c]]`.
//! - Transmittances are those of power. Radiance that is refracted also changes by
//!   `(n_t / n_i)^2`, which belongs to the transport and is found nowhere in this module.
//!
//! # Sides
//!
//! Light carriers `scatter` (`S <- M S`), sensor carriers `collect` (`T <- T M`), and the two
//! `measure` where they meet (`T S`). They are different types and there is no `*`.

pub mod albedo;
pub mod analyzer;
pub mod carrier;
pub mod cloth;
pub mod elements;
pub mod film;
pub mod frame;
pub mod fresnel;
pub mod kept;
pub mod kernel;
pub mod microfacet;
pub mod mie;
pub mod milk;
pub mod particles;
mod physical;
pub mod rayleigh;
pub mod stokes;

pub use albedo::{Albedo, CoatAlbedo};
pub use analyzer::Analyzer;
pub use carrier::{
    Arrival, Departure, LightCarrier, SensorColumn, SensorEvent, SensorMatrix, SensorRow,
};
pub use film::{Film, Filmed, filmed_conductor, filmed_dielectric};
pub use frame::{Rotation, film_axis, s_axis};
pub use fresnel::{
    Interface, Pane, conductor, conductor_reflectance, dielectric, dielectric_reflectance, pane,
};
pub use kernel::{Block, Dense, Kernel, SpheroidBlock};
pub use microfacet::{
    ALPHA_MIN, Distribution, Even, FacetReflection, FacetRefraction, Facets, Slopes, Stretched,
};
pub use physical::physical;
pub use stokes::Stokes;
