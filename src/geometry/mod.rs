//! Floor 5: what a ray meets.
//!
//! ```text
//! triangles, spheres, instances -> obvhs (binary tree) -> collapse -> Accelerator
//! RayColumns -> trace_closest -> HitColumns -> resolve_surfaces -> SurfaceColumns
//! RayColumns, t_max -> trace_visibility, or past what lets rays through -> blocked
//! RayColumns, HitColumns -> trace_next -> the hits behind those, of the same rays
//! ```
//!
//! Four ways to trace, with the same kernels and the same bits: a scene of at most
//! [`SHORT_SCENE`] primitives is a list that eight rays at a time walk through; eight rays that
//! run alike take one way through the tree; others go alone, against eight children or primitives
//! at a time; and in trees that exceed the caches, several of those are on their way at once. What
//! is instanced has a tree of its own, below a leaf of the scene's.

mod accelerator;
mod block;
mod builder;
mod collapse;
mod columns;
mod kernel;
mod near;
mod next;
mod offset;
mod packet;
mod prepared;
mod rays;
mod rims;
mod surface;
mod table;
mod tree;
mod walk;

pub use accelerator::{Accelerator, SHORT_SCENE, Statistics};
pub use columns::{CROSSES, trace_closest, trace_visibility, trace_visibility_past};
pub use near::{FRONTS_MAX, Neighborhood, Planes, Shape, Surroundings, nearest_in_triangle};
pub use next::trace_next;
pub use offset::{offset_distance, offset_origin, reach, reach_of_triangle};
pub use rays::{Hit, HitColumns, IN_MEDIUM, Ray, RayColumns, medium_met};
pub use rims::Rims;
pub use surface::{SurfaceColumns, resolve_surfaces};
pub use walk::TraceScratch;
