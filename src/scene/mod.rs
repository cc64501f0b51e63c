//! Floor 2: what the user describes, and the tables it is baked into.

pub mod baked;
