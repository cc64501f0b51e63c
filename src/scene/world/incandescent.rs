//! Surfaces that glow by their heat.

use super::{Bsdf, Emission, EmittedStokes, Textures};
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
        let refuse = |problem: &str, remedy: &str| Err(Fault::new("incandescent", problem, remedy));
        if emission.is_none() {
            return refuse(
                "is of what emits, and nothing is emitted",
                "add a blackbody's emission",
            );
        }
        if stokes.is_some() {
            return refuse("says how the light is polarized, and so does stokes", "keep one");
        }
        if textures.is_some_and(|textures| textures.feed_model() || textures.stain.is_some()) {
            return refuse("is of one surface, and textures paint it", "remove the textures");
        }
        match share(&bsdf.clone().simplified()) {
            Some(_) => Ok(()),
            None => refuse("is of smooth surfaces", "use a conductor or a dielectric"),
        }
    }
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
