//! Surfaces that glow by their heat.

use super::describe::kind;
use super::{Bsdf, Emission, EmittedStokes, Stain, Textures};
use crate::math::Fault;
use crate::polarization::fresnel::{conductor_reflectance, dielectric_reflectance};
use crate::spectrum::{Beyond, Carried, Role, Spectrum};

/// Angles that a mean over the half space is taken of.
const ANGLES: u32 = 64;
/// The wavelength in nanometers at which it is.
const MEAN_NM: f32 = 550.0;

/// A material whose surface is hot (Kirchhoff): of what it is said to emit, which is what a black
/// body of its temperature would, leaves in every direction what the surface does not reflect of
/// light from there, 1 - R, polarized as Fresnel has it. The surface is smooth metal, or glass and
/// thick enough within to be black.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Incandescent;

impl Incandescent {
    /// Refuses what does not go together with it.
    pub(super) fn check(
        bsdf: &Bsdf,
        emission: Option<&Emission>,
        stokes: Option<&EmittedStokes>,
        textures: Option<&Textures>,
    ) -> Result<(), Fault> {
        if emission.is_none() {
            return Err(Self::without_emission());
        }
        if stokes.is_some() {
            return refused("says how the light is polarized, and so does stokes", "keep one");
        }
        check_model(bsdf)?;
        let Some(textures) = textures else { return Ok(()) };
        if textures.stain.reflected.is_some() {
            let problem = "does not go with reflected, a color of what is reflected: what leaves \
                           follows from the index of refraction";
            return refused(problem, "remove reflected and its texture, or incandescent");
        }
        if textures.stain.transmitted.is_some() {
            let problem = "does not go with transmitted, or a base color by textures, a color of \
                           what goes through: hot glass is black within";
            return refused(problem, "remove the color and its texture, or incandescent");
        }
        if textures.feed_model() {
            let problem = "does not go with textures of the surface: it is the same all over";
            return refused(problem, "remove these textures, or incandescent");
        }
        Ok(())
    }

    /// The fault of a material that is said to be hot and emits nothing.
    pub(in crate::scene) fn without_emission() -> Fault {
        let problem = "is of what emits, and nothing is emitted";
        Fault::new("incandescent", problem, "add a blackbody's emission")
    }
}

fn refused(problem: impl Into<String>, remedy: &str) -> Result<(), Fault> {
    Err(Fault::new("incandescent", problem, remedy))
}

/// Refuses models of which it is not known what leaves them.
fn check_model(bsdf: &Bsdf) -> Result<(), Fault> {
    let simplified = bsdf.clone().simplified();
    if share(&simplified).is_some() {
        return Ok(());
    }
    if matches!(simplified, Bsdf::FilmedConductor { .. } | Bsdf::FilmedDielectric { .. }) {
        let problem = "does not go with film: what leaves is known of bare surfaces";
        return refused(
            problem,
            "remove the film (KHR_materials_iridescence too), or incandescent",
        );
    }
    if Stain::is_of_glass(bsdf) && simplified == Bsdf::Null {
        let problem = "is of glass that refracts, and ior is that of what is around it";
        return refused(problem, "give it another ior, or remove incandescent");
    }
    let problem = format!("is of smooth metal and glass, and the model is {}", kind(bsdf));
    refused(problem, "use a conductor or a dielectric")
}

/// The share of a black body's power that leaves a surface, about, or none of those that cannot be
/// incandescent.
pub(in crate::scene) fn share(bsdf: &Bsdf) -> Option<f64> {
    let at = |spectrum: &Spectrum| {
        let carried = Carried::at([MEAN_NM]).beyond(Beyond::Held);
        // What is held covers all.
        spectrum.sample(&carried, Role::Index).map_or(1.0, |[value]| f64::from(value))
    };
    let mean = |reflectance: &dyn Fn(f64) -> f64| {
        // Uniform in the square of the cosine.
        let cosine = |index: u32| (f64::from(index) + 0.5) / f64::from(ANGLES);
        let leaves = (0..ANGLES).map(|index| 1.0 - reflectance(cosine(index).sqrt()));
        leaves.sum::<f64>() / f64::from(ANGLES)
    };
    if let Bsdf::Conductor { eta, k } = bsdf {
        let (eta, k) = (at(eta), at(k));
        return Some(mean(&|cosine| conductor_reflectance(cosine, eta, k)));
    }
    let eta = if let Bsdf::Dielectric { ior, exterior_ior } = bsdf {
        f64::from(ior / exterior_ior)
    } else if let Bsdf::DispersiveDielectric { ior, exterior_ior } = bsdf {
        at(ior) / at(exterior_ior)
    } else {
        return None;
    };
    Some(mean(&|cosine| dielectric_reflectance(cosine, eta).0))
}
