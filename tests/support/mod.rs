//! What the tests of whole renders share: rendering in replicates, statistics of the differences,
//! scenes built in code, and the evidence left behind by a failure.

pub mod blends;
pub mod brushed;
pub mod dispersive;
pub mod evidence;
pub mod fields;
pub mod filmed;
pub mod filters;
pub mod gltf;
pub mod layers;
pub mod luminaires;
pub mod odd_lights;
pub mod painted;
pub mod polarized;
pub mod projectors;
pub mod random;
pub mod rendering;
pub mod rough;
pub mod scenes;
pub mod skies;
pub mod statistics;
