//! Floor 4: what the user describes, and the tables it is baked into.
//!
//! [`World`] is a hecs world of meshes, spheres, materials, media, lights and a camera, made in
//! code or by [`load`] from a file of glTF or Mitsuba; its components know what is wrong with them.
//! [`bake`] checks all of that and queries it into the dense tables of [`baked`], in world space
//! and at the wavelengths of the render.

mod bake;
pub mod baked;
pub mod corners;
pub mod emitted;
pub mod emitter;
mod error;
mod file;
mod gltf;
pub mod instanced;
pub mod luminaire;
mod mitsuba;
pub mod painting;
pub mod panorama;
pub mod pattern;
mod projector;
mod ramp;
mod view;
pub mod warnings;
pub mod world;

pub use self::bake::{
    Brightness, Common, Emitters, Lamp, Plan, Suspensions, bake, bake_camera, bake_emission,
    bake_emitters, bake_optics, bake_optics_at, bake_shapes, held_spectra, lamps, plan_shapes,
};
pub use self::error::SceneError;
pub use self::file::{Reading, SceneFile, is_of_mitsuba, load, load_from_memory, load_with};
pub use self::gltf::{Edit, Editable, EditedFile, Written, extension_keys, keys_of_kind};
pub use self::view::{AUTO, LightChoice, View};
pub use self::world::World;
