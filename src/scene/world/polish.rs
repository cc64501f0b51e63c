//! How smooth facets are.

use super::grain::Along;
use super::material::SurfaceModel;

/// Roughness below which facets are polished.
const POLISHED: f32 = 0.05;

impl<S> SurfaceModel<S> {
    /// Whether it mirrors or refracts along one way, or so nearly that connections find what it
    /// does only by chance.
    pub fn is_polished(&self) -> bool {
        let has = |ior: f32, specular: f32| ior != 1.0 && specular > 0.0;
        match self {
            Self::RoughConductor { alpha, .. } | Self::RoughDielectric { alpha, .. } => {
                *alpha < POLISHED
            }
            Self::MetallicRoughness { metallic, alpha, ior, specular, .. } => {
                *alpha < POLISHED && (*metallic > 0.0 || has(*ior, *specular))
            }
            Self::Layered { layers } => {
                let of_wall = layers.metallic > 0.0 || layers.transmission > 0.0;
                let has_facets = of_wall || has(layers.ior, layers.specular);
                layers.alpha < POLISHED && has_facets
                    || layers.coat_alpha < POLISHED && layers.coat > 0.0
            }
            Self::Plastic { coat, .. } => {
                coat.alpha < POLISHED && has(coat.ior / coat.exterior_ior, coat.specular)
            }
            Self::Blend { parts, weight } => {
                let [first, second] = &**parts;
                *weight < 1.0 && first.is_polished() || *weight > 0.0 && second.is_polished()
            }
            Self::Brushed { of, grain } => {
                let along = match grain.along {
                    Along::Alpha(alpha) => alpha < POLISHED,
                    // It leads from the roughness across to more.
                    Along::Strength(_) => false,
                };
                along || of.is_polished()
            }
            Self::Filmed { of, .. } => of.is_polished(),
            Self::Conductor { .. }
            | Self::FilmedConductor { .. }
            | Self::Dielectric { .. }
            | Self::DispersiveDielectric { .. }
            | Self::FilmedDielectric { .. }
            | Self::ThinDielectric { .. } => true,
            Self::Absorber
            | Self::Diffuse { .. }
            | Self::Measured { .. }
            | Self::Polarizer { .. }
            | Self::Retarder { .. }
            | Self::Sheet { .. }
            | Self::Null => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polarization::Distribution;
    use crate::scene::world::Grain;

    fn metal(alpha: f32) -> SurfaceModel<f32> {
        let (distribution, multiple_scattering) = (Distribution::Ggx, true);
        SurfaceModel::RoughConductor { eta: 1.0, k: 6.0, alpha, distribution, multiple_scattering }
    }

    fn gloss(alpha: f32, ior: f32, specular: f32) -> SurfaceModel<f32> {
        SurfaceModel::MetallicRoughness { base_color: 0.5, metallic: 0.0, alpha, ior, specular }
    }

    #[test]
    fn what_has_smooth_facets_is_polished_and_what_has_none_is_not() {
        assert!(metal(0.001).is_polished() && metal(0.049).is_polished());
        assert!(!metal(0.05).is_polished());
        assert!(gloss(0.01, 1.5, 1.0).is_polished());
        assert!(!gloss(0.01, 1.5, 0.0).is_polished() && !gloss(0.01, 1.0, 1.0).is_polished());
        let stretched = |alpha| SurfaceModel::Brushed {
            of: Box::new(metal(0.3)),
            grain: Grain::new(Along::Alpha(alpha)),
        };
        assert!(stretched(0.01).is_polished() && !stretched(0.2).is_polished());
        let blend = |weight| SurfaceModel::Blend {
            parts: Box::new([SurfaceModel::Diffuse { reflectance: 0.5 }, metal(0.01)]),
            weight,
        };
        assert!(blend(0.1).is_polished() && !blend(0.0).is_polished());
    }
}
