//! Floor 3: what a ray meets.
//!
//! ```text
//! triangles, spheres -> obvhs (binary tree) -> collapse -> Accelerator (eight-wide tree, blocks)
//! RayColumns -> trace_closest -> HitColumns -> resolve_surfaces -> SurfaceColumns
//! RayColumns, t_max -> trace_visibility -> blocked
//! ```
//!
//! Two ways to trace, with the same kernels and the same bits: the tree takes one ray at a time
//! against eight children or primitives; a scene of at most [`SHORT_SCENE`] primitives is a list
//! that eight rays at a time walk through, which needs no horizontal step at all.

mod accelerator;
mod block;
mod builder;
mod collapse;
mod columns;
mod kernel;
mod offset;
mod surface;

pub use accelerator::{Accelerator, Hit, SHORT_SCENE, Statistics};
pub use columns::{HitColumns, IN_MEDIUM, RayColumns, medium_met, trace_closest, trace_visibility};
pub use offset::{offset_distance, offset_origin, reach};
pub use surface::{SurfaceColumns, resolve_surfaces};
