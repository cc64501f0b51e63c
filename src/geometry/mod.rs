//! Floor 3: what a ray meets.
