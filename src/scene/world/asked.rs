//! How a scene asks to be rendered: defaults, of which none is part of what it is.

/// Which end paths are followed from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Walk {
    /// The sensor.
    FromSensor,
    /// The emitters.
    FromEmitters,
}

/// What a scene asks for where a render does not say it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Asked {
    /// Samples per pixel.
    pub samples: Option<u32>,
    /// Seed of all randomness.
    pub seed: Option<u32>,
    /// Most segments of a path.
    pub path_length_max: Option<u32>,
    /// Segments after which roulette may end a path.
    pub roulette_after: Option<u32>,
    /// Which end paths are followed from.
    pub walk: Option<Walk>,
}
