//! Parameters of materials that may differ from place to place.

use super::SurfaceModel;
use crate::spectrum::Role;

/// A parameter of some models that may differ from place to place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Parameter {
    /// `reflectance` of [`SurfaceModel::Diffuse`] and [`SurfaceModel::Plastic`].
    Reflectance,
    /// `base_color` of [`SurfaceModel::MetallicRoughness`] and of layers.
    BaseColor,
    /// `metallic` of [`SurfaceModel::MetallicRoughness`] and of layers.
    Metallic,
    /// The root of `alpha` of [`SurfaceModel::MetallicRoughness`],
    /// [`SurfaceModel::RoughConductor`], [`SurfaceModel::RoughDielectric`] and layers: what glTF
    /// calls roughness.
    Roughness,
    /// `specular` of [`Layers`](super::Layers).
    Specular,
    /// `specular_color` of layers.
    SpecularColor,
    /// `transmission` of layers.
    Transmission,
    /// `diffuse_transmission` of layers.
    DiffuseTransmission,
    /// `diffuse_transmission_color` of layers.
    DiffuseTransmissionColor,
    /// `coat` of layers.
    Coat,
    /// The root of `coat_alpha` of layers.
    CoatRoughness,
    /// `cloth_color` of layers.
    ClothColor,
    /// The root of `cloth_alpha` of layers.
    ClothRoughness,
    /// `alpha` of [`SurfaceModel::RoughConductor`] and [`SurfaceModel::RoughDielectric`].
    Alpha,
    /// `weight` of [`SurfaceModel::Blend`].
    Weight,
    /// The strength of [`Along::Strength`](super::Along::Strength).
    Strength,
    /// The first number of [`Grain::direction`](super::Grain::direction), from -1 to 1 as from 0 to
    /// 1.
    GrainRight,
    /// The second one, likewise.
    GrainUp,
    /// `share` of a [`ThinFilm`](super::ThinFilm).
    FilmShare,
    /// `portion` of a film, between its `portions`.
    FilmThickness,
}

impl Parameter {
    /// What it is, if it is a spectrum; numbers are the same at all wavelengths.
    pub(crate) fn role(self) -> Option<Role> {
        match self {
            Self::Reflectance
            | Self::BaseColor
            | Self::SpecularColor
            | Self::DiffuseTransmissionColor
            | Self::ClothColor => Some(Role::Reflectance),
            Self::Metallic
            | Self::Roughness
            | Self::Alpha
            | Self::Weight
            | Self::Strength
            | Self::GrainRight
            | Self::GrainUp
            | Self::FilmShare
            | Self::FilmThickness
            | Self::Specular
            | Self::Transmission
            | Self::DiffuseTransmission
            | Self::Coat
            | Self::CoatRoughness
            | Self::ClothRoughness => None,
        }
    }
}

impl<const N: usize> SurfaceModel<[f32; N]> {
    /// Gives a parameter another value, or the first of it to one that is a number; false if the
    /// model has no such parameter.
    #[inline]
    pub(crate) fn set(&mut self, parameter: Parameter, value: [f32; N]) -> bool {
        let number = value[0].clamp(0.0, 1.0);
        match (self, parameter) {
            (
                Self::Diffuse { reflectance } | Self::Plastic { reflectance, .. },
                Parameter::Reflectance,
            ) => *reflectance = value,
            (Self::MetallicRoughness { base_color, .. }, Parameter::BaseColor) => {
                *base_color = value;
            }
            (Self::MetallicRoughness { metallic, .. }, Parameter::Metallic) => *metallic = number,
            (
                Self::MetallicRoughness { alpha, .. }
                | Self::RoughConductor { alpha, .. }
                | Self::RoughDielectric { alpha, .. },
                Parameter::Roughness,
            ) => *alpha = number * number,
            (
                Self::RoughConductor { alpha, .. } | Self::RoughDielectric { alpha, .. },
                Parameter::Alpha,
            ) => *alpha = number,
            (Self::Brushed { of, grain }, parameter) => {
                return grain.set(parameter, number) || of.set(parameter, value);
            }
            (Self::Filmed { of, film }, parameter) => {
                return film.set(parameter, number) || of.set(parameter, value);
            }
            (
                Self::FilmedConductor { film, .. } | Self::FilmedDielectric { film, .. },
                parameter,
            ) => return film.set(parameter, number),
            (Self::Blend { weight, .. }, Parameter::Weight) => *weight = number,
            (Self::Layered { layers }, parameter) => return layers.set(parameter, value),
            (
                Self::Absorber
                | Self::Diffuse { .. }
                | Self::Plastic { .. }
                | Self::MetallicRoughness { .. }
                | Self::RoughDielectric { .. }
                | Self::Conductor { .. }
                | Self::RoughConductor { .. }
                | Self::Measured { .. }
                | Self::Blend { .. }
                | Self::Sheet { .. }
                | Self::Dielectric { .. }
                | Self::DispersiveDielectric { .. }
                | Self::ThinDielectric { .. }
                | Self::Polarizer { .. }
                | Self::Retarder { .. }
                | Self::Null,
                _parameter,
            ) => return false,
        }
        true
    }
}
