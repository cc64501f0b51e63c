//! Mixtures of two models.

use super::SurfaceModel;
use super::material::Bsdf;
use crate::math::{Fault, Range};
use crate::polarization::{ALPHA_MIN, Distribution};
use crate::spectrum::Role;

/// Most blends within each other, the outermost one included.
pub const BLEND_DEPTH: usize = 4;

impl Bsdf {
    /// A mixture of two models, with the share of the second, within [0, 1]: [`Bsdf::Blend`]. What
    /// is added to a world must be of parts that light leaves in any direction; smooth metal is
    /// taken as of facets of alpha 0.001 here, and black as diffuse.
    ///
    /// ```
    /// use sunstone::world::{Bsdf, World};
    ///
    /// let mut world = World::new("kitchen");
    /// let steel = Bsdf::rough_metal("Fe", 0.2)?;
    /// world.add_material("dusty", Bsdf::blend(steel, Bsdf::diffuse(0.4), 0.3))?;
    /// let wet = Bsdf::blend(Bsdf::diffuse(0.4), Bsdf::dielectric(1.33), 0.3);
    /// assert!(world.add_material("wet", wet).is_err(), "glass cannot be a part");
    /// # Ok::<(), sunstone::SceneError>(())
    /// ```
    pub fn blend(first: impl Into<Self>, second: impl Into<Self>, weight: f32) -> Self {
        let [(first, _), (second, _)] = [first.into(), second.into()].map(Self::into_part);
        Self::Blend { parts: Box::new([first, second]), weight }
    }

    /// The same as a part of a blend, and whether it is another then: smooth metal has the least
    /// rough facets.
    pub(crate) fn into_part(self) -> (Self, bool) {
        if self == Self::Absorber {
            return (Self::diffuse(0.0), false);
        }
        if let Self::FilmedConductor { eta, k, film } = self {
            let (of, _) = Self::Conductor { eta, k }.into_part();
            return (of.filmed(film), true);
        }
        let Self::Conductor { eta, k } = self else { return (self, false) };
        let (alpha, distribution, multiple_scattering) = (ALPHA_MIN, Distribution::Ggx, true);
        (Self::RoughConductor { eta, k, alpha, distribution, multiple_scattering }, true)
    }

    /// How many blends are within each other.
    fn blend_depth(&self) -> usize {
        let Self::Blend { parts, .. } = self else { return 0 };
        1 + parts.iter().map(Self::blend_depth).max().unwrap_or_default()
    }

    /// Why it cannot be a part of a blend.
    pub(crate) fn check_part(&self) -> Result<(), Fault> {
        let refused = |problem: &str, remedy: &str| Err(Fault::new("", problem, remedy));
        match self {
            Self::Conductor { .. } | Self::FilmedConductor { .. } => refused(
                "smooth metal cannot be a part of a blend",
                "make it rough_conductor, if need be of alpha 0.001",
            ),
            Self::Absorber => {
                refused("an absorber cannot be a part of a blend", "make it diffuse, reflectance 0")
            }
            Self::Blend { .. } if self.blend_depth() >= BLEND_DEPTH => {
                let problem = format!("there are more than {BLEND_DEPTH} blends within each other");
                refused(&problem, "blend fewer")
            }
            Self::Brushed { of, .. } | Self::Filmed { of, .. } => of.check_part(),
            Self::Diffuse { .. }
            | Self::RoughConductor { .. }
            | Self::MetallicRoughness { .. }
            | Self::Layered { .. }
            | Self::Plastic { .. }
            | Self::Measured { .. }
            | Self::Blend { .. } => Ok(()),
            Self::RoughDielectric { .. }
            | Self::Dielectric { .. }
            | Self::DispersiveDielectric { .. }
            | Self::FilmedDielectric { .. }
            | Self::ThinDielectric { .. } => refused(
                "glass cannot be a part of a blend",
                "blend what reflects, or thin walls: glTF's KHR_materials_transmission",
            ),
            Self::Polarizer { .. } | Self::Retarder { .. } | Self::Sheet { .. } | Self::Null => {
                refused(
                    "what light goes straight through cannot be a part of a blend",
                    "for holes give the material an alpha, or a mask",
                )
            }
        }
    }
}

/// The parts with `sample` of their spectra: see [`SurfaceModel::sampled`].
pub(super) fn sampled_parts<S, T, E>(
    parts: &[SurfaceModel<S>; 2],
    // By way of a pointer, or each depth would be a function of its own.
    sample: &mut dyn FnMut(&S, &'static str, Role) -> Result<T, E>,
) -> Result<Box<[SurfaceModel<T>; 2]>, E> {
    let [first, second] = parts;
    Ok(Box::new([first.sampled(&mut *sample)?, second.sampled(&mut *sample)?]))
}

/// Refuses what cannot be mixed.
pub(super) fn check_blend(parts: &[Bsdf; 2], weight: f32) -> Result<(), Fault> {
    Range::UNIT.check("weight", weight)?;
    for (part, field) in parts.iter().zip(["first", "second"]) {
        let checked = part.check_part().and_then(|()| part.check());
        checked.map_err(|fault| fault.within(field))?;
    }
    Ok(())
}
