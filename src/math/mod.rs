//! Floor 0: numbers, lanes, vectors and words. Knows nothing of light.

pub mod columns;
pub mod elementary;
pub mod equiangular;
pub mod exact;
pub mod gaussian;
pub mod hash;
pub mod lanes;
pub mod range;
pub mod real;
pub mod statistics;
pub mod text;
pub mod vector;
pub mod warp;

pub use lanes::{F32s, LANES, U32s};
pub use range::{Fault, Range};
pub use real::Real;
pub use vector::Vector;
