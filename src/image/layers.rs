//! Layers beside the light: what the camera sees first, for those who train networks or take away
//! noise.

use std::str::FromStr;

use crate::math::text::listed;

/// Something that a pixel sees first, through nothing: glass, mirrors and sheets are what is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayerKind {
    /// Distance along the viewing direction, in meters: the mean of what is hit, and infinite where
    /// nothing is.
    Depth,
    /// Unit normal in world space, turned to the camera, with its normal map: the mean, zero of
    /// what hits nothing.
    Normal,
    /// Red, green and blue of the base: reflectance or base color, that of metal at normal
    /// incidence, 1 of what is clear; the mean, zero of what hits nothing.
    Albedo,
    /// Place in world space, in meters: the mean of what is hit, and zero where nothing is.
    Position,
    /// First texture coordinates at the pixel's center, u to the right and v down; zero where the
    /// material has no texture by them.
    Uv,
    /// Number of the material at the pixel's center, from 1; 0 is nothing.
    Material,
    /// Number of the object at the pixel's center, a part of a mesh or a sphere, from 1; 0 is
    /// nothing.
    Object,
}

impl LayerKind {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Depth,
        Self::Normal,
        Self::Albedo,
        Self::Position,
        Self::Uv,
        Self::Material,
        Self::Object,
    ];

    /// What users call it, and what the names of its channels begin with.
    pub fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::Normal => "normal",
            Self::Albedo => "albedo",
            Self::Position => "position",
            Self::Uv => "uv",
            Self::Material => "material",
            Self::Object => "object",
        }
    }

    /// What its channels are called, in files behind its name and a dot.
    pub fn channels(self) -> &'static [&'static str] {
        match self {
            Self::Depth => &["Z"],
            Self::Normal | Self::Position => &["X", "Y", "Z"],
            Self::Albedo => &["R", "G", "B"],
            Self::Uv => &["U", "V"],
            Self::Material | Self::Object => &["id"],
        }
    }

    /// The names of its channels in files.
    pub fn channel_names(self) -> impl Iterator<Item = String> {
        self.channels().iter().map(move |channel| format!("{}.{channel}", self.name()))
    }

    /// What metadata call the names of what is numbered, a list of JSON, if anything is.
    pub fn names_key(self) -> Option<&'static str> {
        match self {
            Self::Material => Some("materials"),
            Self::Object => Some("objects"),
            Self::Depth | Self::Normal | Self::Albedo | Self::Position | Self::Uv => None,
        }
    }
}

impl FromStr for LayerKind {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| {
            let names: Vec<String> = Self::ALL.map(|kind| kind.name().to_owned()).to_vec();
            format!("layers are {}", listed(&names))
        })
    }
}

/// A layer of an image: a plane for each of its channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// What it is.
    pub kind: LayerKind,
    /// Rows from the top, pixels from the left, for every channel.
    pub planes: Vec<Vec<f32>>,
}

/// The plane of a channel by its name in files, if it is one of these.
pub fn plane<'a>(layers: &'a [Layer], name: &str) -> Option<&'a Vec<f32>> {
    layers.iter().find_map(|layer| {
        let channel = layer.kind.channel_names().position(|known| known == name)?;
        layer.planes.get(channel)
    })
}
