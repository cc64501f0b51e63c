//! Facets that are stretched along a direction, as those of brushed metal.

use super::{Bsdf, Parameter, SurfaceModel};
use crate::math::{Fault, Range};
use crate::polarization::ALPHA_MIN;
use crate::spectrum::{Role, Spectrum};

/// How the facets of [`SurfaceModel::Brushed`] differ by direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    /// The roughness along the direction. Across it, it is that of the model.
    pub along: Along,
    /// The direction, to the right and up of pictures on the surface (glTF's tangent and
    /// bitangent); of any length. Surfaces without coordinates of pictures have the x axis of
    /// their node to the right, and spheres go round its z axis.
    pub direction: [f32; 2],
    /// By how much that is turned in radians, counter-clockwise about the front's normal.
    pub turn: f32,
    /// The direction as a unit vector of the world, where a surface has been hit.
    pub place: [f32; 3],
}

/// A roughness along a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Along {
    /// Itself, within [0, 1]: as `alpha` of [`SurfaceModel::RoughConductor`].
    Alpha(f32),
    /// By a strength within [0, 1], whose square leads from the roughness across to 1
    /// (KHR_materials_anisotropy).
    Strength(f32),
}

impl Grain {
    /// Along the right of pictures.
    pub fn new(along: Along) -> Self {
        Self { along, direction: [1.0, 0.0], turn: 0.0, place: [1.0, 0.0, 0.0] }
    }

    /// The roughness along, and across, of facets that have this across.
    pub fn alphas(&self, across: f32) -> [f32; 2] {
        let along = match self.along {
            Along::Alpha(alpha) => alpha,
            Along::Strength(strength) => across + (1.0 - across) * (strength * strength),
        };
        [along, across]
    }

    /// Gives it another value of a parameter; false if it has no such parameter.
    pub(super) fn set(&mut self, parameter: Parameter, number: f32) -> bool {
        let [right, up] = &mut self.direction;
        if parameter == Parameter::GrainRight {
            *right = 2.0 * number - 1.0;
        } else if parameter == Parameter::GrainUp {
            *up = 2.0 * number - 1.0;
        } else if let (Parameter::Strength, Along::Strength(strength)) =
            (parameter, &mut self.along)
        {
            *strength = number;
        } else {
            return false;
        }
        true
    }

    fn check(&self) -> Result<(), Fault> {
        match self.along {
            Along::Alpha(alpha) => Range::UNIT.check("alpha_u", alpha)?,
            Along::Strength(strength) => Range::UNIT.check("strength", strength)?,
        }
        let [right, up] = self.direction;
        for number in [right, up, self.turn] {
            Range::ANY.check("axis_deg", number)?;
        }
        Ok(())
    }
}

/// Refuses facets that are not stretched, or cannot be.
pub(super) fn check_grain(of: &Bsdf, grain: &Grain) -> Result<(), Fault> {
    of.check()?;
    if of.facets_alpha().is_none() {
        let problem = "facets of this model cannot be stretched along a direction";
        let remedy = "use rough_conductor, rough_dielectric or glTF's metallic-roughness";
        return Err(Fault::new("", problem, remedy));
    }
    grain.check()
}

impl<S> SurfaceModel<S> {
    /// The roughness of facets that can be stretched.
    pub(crate) fn facets_alpha(&self) -> Option<&f32> {
        match self {
            Self::RoughConductor { alpha, .. }
            | Self::RoughDielectric { alpha, .. }
            | Self::MetallicRoughness { alpha, .. } => Some(alpha),
            Self::Absorber
            | Self::Diffuse { .. }
            | Self::Conductor { .. }
            | Self::Layered { .. }
            | Self::Plastic { .. }
            | Self::Measured { .. }
            | Self::Blend { .. }
            | Self::Brushed { .. }
            | Self::Filmed { .. }
            | Self::FilmedConductor { .. }
            | Self::FilmedDielectric { .. }
            | Self::Dielectric { .. }
            | Self::DispersiveDielectric { .. }
            | Self::ThinDielectric { .. }
            | Self::Polarizer { .. }
            | Self::Retarder { .. }
            | Self::Sheet { .. }
            | Self::Null => None,
        }
    }

    /// The same, to be changed.
    pub(crate) fn facets_alpha_mut(&mut self) -> Option<&mut f32> {
        self.facets_alpha()?;
        let (Self::RoughConductor { alpha, .. }
        | Self::RoughDielectric { alpha, .. }
        | Self::MetallicRoughness { alpha, .. }) = self
        else {
            return None;
        };
        Some(alpha)
    }

    /// Whether it, or a part of it, has facets that are stretched along a direction.
    pub(crate) fn has_grain(&self) -> bool {
        if let Self::Blend { parts, .. } = self {
            return parts.iter().any(Self::has_grain);
        }
        matches!(self.without_film(), Self::Brushed { .. })
    }

    /// Whether all facets are too even to be computed with.
    pub(super) fn is_smooth(&self, grain: &Grain) -> bool {
        let alphas = self.facets_alpha().map(|across| grain.alphas(*across));
        alphas.is_some_and(|alphas| alphas.iter().all(|alpha| *alpha < ALPHA_MIN))
    }

    /// Calls `each` with the grain of it, or of its parts.
    pub(crate) fn for_each_grain(&mut self, each: &mut impl FnMut(&mut Grain)) {
        if let Self::Brushed { grain, .. } = self {
            each(grain);
        } else if let Self::Filmed { of, .. } = self {
            of.for_each_grain(each);
        } else if let Self::Blend { parts, .. } = self {
            parts.iter_mut().for_each(|part| part.for_each_grain(each));
        }
    }

    /// The model without its grain.
    pub(crate) fn without_grain(&self) -> &Self {
        if let Self::Brushed { of, .. } = self { of } else { self }
    }
}

/// A model with `sample` of its spectra, as one within another: see [`SurfaceModel::sampled`].
pub(super) fn sampled_within<S, T, E>(
    of: &SurfaceModel<S>,
    // By way of a pointer, or each depth would be a function of its own.
    sample: &mut dyn FnMut(&S, &'static str, Role) -> Result<T, E>,
) -> Result<Box<SurfaceModel<T>>, E> {
    of.sampled(sample).map(Box::new)
}

impl Bsdf {
    /// Rough metal, rough glass or glTF's metallic-roughness with facets of another roughness along
    /// a direction than across it, where that of the model holds: [`Bsdf::Brushed`].
    ///
    /// ```
    /// use sunstone::world::{Along, Bsdf, Grain, World};
    ///
    /// let mut world = World::new("kitchen");
    /// let steel = Bsdf::rough_metal("Fe", 0.1)?;
    /// world.add_material("pan", Bsdf::brushed(steel, Grain::new(Along::Alpha(0.4))))?;
    /// # Ok::<(), sunstone::SceneError>(())
    /// ```
    pub fn brushed(of: Self, grain: Grain) -> Self {
        Self::Brushed { of: Box::new(of), grain }
    }

    /// [`Bsdf::undispersed`] of a model within another.
    pub(super) fn undispersed_within<E>(
        &self,
        sample: &mut dyn FnMut(&Spectrum, &'static str, f32) -> Result<f32, E>,
    ) -> Result<Self, E> {
        self.undispersed(sample)
    }
}
