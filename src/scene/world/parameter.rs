//! Parameters of materials that may differ from place to place.

use super::SurfaceModel;
use crate::spectrum::Role;

/// A parameter of some models that may differ from place to place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Parameter {
    /// `reflectance` of [`SurfaceModel::Diffuse`] and [`SurfaceModel::Plastic`].
    Reflectance,
    /// `base_color` of [`SurfaceModel::MetallicRoughness`].
    BaseColor,
    /// `metallic` of [`SurfaceModel::MetallicRoughness`].
    Metallic,
    /// The root of `alpha` of [`SurfaceModel::MetallicRoughness`] and
    /// [`SurfaceModel::RoughDielectric`]: what glTF calls roughness.
    Roughness,
    /// `alpha` of [`SurfaceModel::RoughConductor`] and [`SurfaceModel::RoughDielectric`].
    Alpha,
}

impl Parameter {
    /// What it is, if it is a spectrum; numbers are the same at all wavelengths.
    pub(crate) fn role(self) -> Option<Role> {
        match self {
            Self::Reflectance | Self::BaseColor => Some(Role::Reflectance),
            Self::Metallic | Self::Roughness | Self::Alpha => None,
        }
    }
}

impl<const N: usize> SurfaceModel<[f32; N]> {
    /// Gives a parameter another value, or the first of it to one that is a number; false if the
    /// model has no such parameter.
    #[inline]
    pub(crate) fn set(&mut self, parameter: Parameter, value: [f32; N]) -> bool {
        let number = value[0].clamp(0.0, 1.0);
        match self {
            Self::Diffuse { reflectance } | Self::Plastic { reflectance, .. } => match parameter {
                Parameter::Reflectance => *reflectance = value,
                Parameter::BaseColor
                | Parameter::Metallic
                | Parameter::Roughness
                | Parameter::Alpha => return false,
            },
            Self::MetallicRoughness { base_color, metallic, alpha, .. } => match parameter {
                Parameter::BaseColor => *base_color = value,
                Parameter::Metallic => *metallic = number,
                Parameter::Roughness => *alpha = number * number,
                Parameter::Reflectance | Parameter::Alpha => return false,
            },
            Self::RoughConductor { alpha, .. } => match parameter {
                Parameter::Alpha => *alpha = number,
                Parameter::Reflectance
                | Parameter::BaseColor
                | Parameter::Metallic
                | Parameter::Roughness => return false,
            },
            Self::RoughDielectric { alpha, .. } => match parameter {
                Parameter::Roughness => *alpha = number * number,
                Parameter::Alpha => *alpha = number,
                Parameter::Reflectance | Parameter::BaseColor | Parameter::Metallic => {
                    return false;
                }
            },
            Self::Absorber
            | Self::Conductor { .. }
            | Self::Dielectric { .. }
            | Self::DispersiveDielectric { .. }
            | Self::ThinDielectric { .. }
            | Self::Polarizer { .. }
            | Self::Retarder { .. }
            | Self::Null => return false,
        }
        true
    }
}
