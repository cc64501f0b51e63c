//! Materials at other wavelengths, and as paths see them.

use super::blend::sampled_parts;
use super::grain::sampled_within;
use super::thin_film::filmed_within;
use super::{SurfaceModel, ThinFilm};
use crate::polarization::{ALPHA_MIN, Distribution};
use crate::spectrum::Role;

impl<S> SurfaceModel<S> {
    /// The model with `sample` of its spectra, each by the name of its key and by what it is.
    ///
    /// # Errors
    /// Those of `sample`.
    pub fn sampled<T, E>(
        &self,
        mut sample: impl FnMut(&S, &'static str, Role) -> Result<T, E>,
    ) -> Result<SurfaceModel<T>, E> {
        Ok(match self {
            Self::Absorber => SurfaceModel::Absorber,
            Self::Diffuse { reflectance } => SurfaceModel::Diffuse {
                reflectance: sample(reflectance, "reflectance", Role::Reflectance)?,
            },
            Self::Conductor { eta, k } => conductor(indices(&mut sample, [eta, k], ["eta", "k"])?),
            &Self::RoughConductor { ref eta, ref k, alpha, distribution, multiple_scattering } => {
                let [eta, k] = indices(&mut sample, [eta, k], ["eta", "k"])?;
                SurfaceModel::RoughConductor { eta, k, alpha, distribution, multiple_scattering }
            }
            Self::RoughDielectric {
                ior,
                exterior_ior,
                alpha,
                distribution,
                multiple_scattering,
            } => {
                let facets = (*alpha, *distribution, *multiple_scattering);
                rough_dielectric(indices(&mut sample, [ior, exterior_ior], INDICES)?, facets)
            }
            &Self::MetallicRoughness { ref base_color, metallic, alpha, ior, specular } => {
                let base_color = sample(base_color, "base_color", Role::Reflectance)?;
                SurfaceModel::MetallicRoughness { base_color, metallic, alpha, ior, specular }
            }
            Self::Layered { layers } => SurfaceModel::Layered { layers: layers.sampled(sample)? },
            &Self::Plastic { ref reflectance, coat } => {
                let reflectance = sample(reflectance, "reflectance", Role::Reflectance)?;
                SurfaceModel::Plastic { reflectance, coat }
            }
            Self::Measured { table, places } => {
                let places = sample(places, "wvls", Role::Index)?;
                SurfaceModel::Measured { table: table.clone(), places }
            }
            Self::Blend { parts, weight } => blend(sampled_parts(parts, &mut sample)?, *weight),
            Self::Brushed { of, grain } => {
                SurfaceModel::Brushed { of: sampled_within(of, &mut sample)?, grain: *grain }
            }
            Self::Filmed { of, film } => filmed_within(of, film, &mut sample)?,
            &Self::Dielectric { ior, exterior_ior } => {
                SurfaceModel::Dielectric { ior, exterior_ior }
            }
            Self::FilmedConductor { eta, k, film } => {
                let [eta, k] = indices(&mut sample, [eta, k], ["eta", "k"])?;
                SurfaceModel::FilmedConductor { eta, k, film: film.sampled(&mut sample)? }
            }
            &Self::FilmedDielectric { ior, exterior_ior, ref film } => {
                filmed_dielectric([ior, exterior_ior], film.sampled(&mut sample)?)
            }
            Self::DispersiveDielectric { ior, exterior_ior } => {
                dispersive_dielectric(indices(&mut sample, [ior, exterior_ior], INDICES)?)
            }
            Self::ThinDielectric { ior, exterior_ior } => {
                thin_dielectric(indices(&mut sample, [ior, exterior_ior], INDICES)?)
            }
            &Self::Polarizer { axis_deg, extinction_ratio } => {
                SurfaceModel::Polarizer { axis_deg, extinction_ratio }
            }
            &Self::Retarder { axis_deg, retardance_deg } => {
                SurfaceModel::Retarder { axis_deg, retardance_deg }
            }
            Self::Sheet { axis_deg, action } => {
                SurfaceModel::Sheet { axis_deg: *axis_deg, action: action.sampled(&mut sample)? }
            }
            Self::Null => SurfaceModel::Null,
        })
    }

    /// What paths make of it: a boundary between equal indices of refraction is none to them, and
    /// metal that is hardly rough is smooth.
    pub fn simplified(self) -> Self
    where
        S: PartialEq,
    {
        match self {
            Self::Dielectric { ior, exterior_ior } if ior == exterior_ior => Self::Null,
            Self::ThinDielectric { ior, exterior_ior } if ior == exterior_ior => Self::Null,
            Self::RoughConductor { eta, k, alpha, .. } if alpha < ALPHA_MIN => {
                Self::Conductor { eta, k }
            }
            rough @ Self::RoughDielectric { .. } if rough.is_nothing() => Self::Null,
            Self::RoughDielectric { ior, exterior_ior, alpha, .. } if alpha < ALPHA_MIN => {
                Self::DispersiveDielectric { ior, exterior_ior }
            }
            Self::Brushed { of, grain } if of.is_smooth(&grain) => of.simplified(),
            Self::Brushed { of, grain } => match of.is_nothing() {
                true => Self::Null,
                false => Self::Brushed { of, grain },
            },
            Self::Filmed { of, film } if of.is_smooth_metal() => of.simplified().under(film),
            Self::Absorber
            | Self::Diffuse { .. }
            | Self::Conductor { .. }
            | Self::RoughConductor { .. }
            | Self::RoughDielectric { .. }
            | Self::MetallicRoughness { .. }
            | Self::Layered { .. }
            | Self::Plastic { .. }
            | Self::Measured { .. }
            | Self::Blend { .. }
            | Self::Filmed { .. }
            | Self::FilmedConductor { .. }
            | Self::FilmedDielectric { .. }
            | Self::Dielectric { .. }
            | Self::DispersiveDielectric { .. }
            | Self::ThinDielectric { .. }
            | Self::Polarizer { .. }
            | Self::Retarder { .. }
            | Self::Sheet { .. }
            | Self::Null => self,
        }
    }
}

impl<S> SurfaceModel<S> {
    /// Whether it is rough metal whose facets are all too even to be computed with.
    fn is_smooth_metal(&self) -> bool {
        if let Self::Brushed { of, grain } = self {
            return of.is_smooth(grain) && of.is_smooth_metal();
        }
        matches!(self, Self::RoughConductor { alpha, .. } if *alpha < ALPHA_MIN)
    }
}

impl<S: PartialEq> SurfaceModel<S> {
    /// Whether it is rough glass between equal indices of refraction.
    fn is_nothing(&self) -> bool {
        matches!(self, Self::RoughDielectric { ior, exterior_ior, .. } if ior == exterior_ior)
    }
}

/// Keys of indices of refraction behind and before.
const INDICES: [&str; 2] = ["ior", "exterior_ior"];

/// Samples two indices of refraction, or the parts of one, by the names of their keys.
fn indices<S, T, E>(
    sample: &mut impl FnMut(&S, &'static str, Role) -> Result<T, E>,
    [first, second]: [&S; 2],
    [one, other]: [&'static str; 2],
) -> Result<[T; 2], E> {
    Ok([sample(first, one, Role::Index)?, sample(second, other, Role::Index)?])
}

/// A blend of parts, with the share of the second.
fn blend<T>(parts: Box<[SurfaceModel<T>; 2]>, weight: f32) -> SurfaceModel<T> {
    SurfaceModel::Blend { parts, weight }
}

/// Smooth metal of an index of refraction, by its parts.
fn conductor<T>([eta, k]: [T; 2]) -> SurfaceModel<T> {
    SurfaceModel::Conductor { eta, k }
}

/// Smooth glass between two indices of refraction, behind and before.
fn dispersive_dielectric<T>([ior, exterior_ior]: [T; 2]) -> SurfaceModel<T> {
    SurfaceModel::DispersiveDielectric { ior, exterior_ior }
}

/// A pane between the same.
fn thin_dielectric<T>([ior, exterior_ior]: [T; 2]) -> SurfaceModel<T> {
    SurfaceModel::ThinDielectric { ior, exterior_ior }
}

/// Rough glass between two indices of refraction, behind and before, with these facets.
fn rough_dielectric<T>(
    [ior, exterior_ior]: [T; 2],
    (alpha, distribution, multiple_scattering): (f32, Distribution, bool),
) -> SurfaceModel<T> {
    SurfaceModel::RoughDielectric { ior, exterior_ior, alpha, distribution, multiple_scattering }
}

/// Glass between two indices of refraction, behind and before, under a film.
fn filmed_dielectric<T>([ior, exterior_ior]: [f32; 2], film: ThinFilm<T>) -> SurfaceModel<T> {
    SurfaceModel::FilmedDielectric { ior, exterior_ior, film }
}
