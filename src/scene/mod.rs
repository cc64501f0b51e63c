//! Floor 2: what the user describes, and the tables it is baked into.
//!
//! `load` reads a glTF file into a [`World`], a hecs world of meshes, spheres, materials, lights
//! and a camera, all validated; [`bake`] queries that into the dense tables of [`baked`], in
//! world space and at the wavelengths of the render.

mod bake;
pub mod baked;
pub mod emitter;
mod error;
mod gltf;
pub mod instanced;
pub mod world;

pub use self::bake::{bake, bake_optics, bake_shapes};
pub use self::error::SceneError;
pub use self::gltf::{extension_keys, load, load_from_memory, load_with};
pub use self::world::World;
