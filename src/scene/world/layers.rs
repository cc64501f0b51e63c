//! What glTF's materials consist of where they have more than metallic-roughness: layers of cloth
//! and of a clear coat over it, and walls that light goes through.

use super::Parameter;
use crate::math::{Fault, Range};
use crate::spectrum::{Role, Spectrum};

/// glTF's metallic-roughness as a wall that light may go through, under a clear coat, under cloth.
/// Shares are within [0, 1]. Spectra are an `S`, as in [`SurfaceModel`](super::SurfaceModel).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layers<S> {
    /// Reflectance of the base, of the metal at normal incidence, and what the wall lets through;
    /// within [0, 1].
    pub base_color: S,
    /// Share of metal.
    pub metallic: f32,
    /// Roughness of the facets (GGX), within [0, 1]: the square of glTF's. At least 0.001 is
    /// computed with.
    pub alpha: f32,
    /// Index of refraction of what the facets are of, from 1 to 10.
    pub ior: f32,
    /// Share of what the facets would reflect that is there.
    pub specular: f32,
    /// Share of that at normal incidence, within [0, 1]; at grazing all of it is there.
    pub specular_color: S,
    /// Share of the base that is a thin wall, through which facets let light.
    pub transmission: f32,
    /// Share of the rest that is lit from behind as well as reflecting: what goes through it is
    /// scattered in all directions.
    pub diffuse_transmission: f32,
    /// Color of that, within [0, 1].
    pub diffuse_transmission_color: S,
    /// Share of the clear coat, of index of refraction 1.5.
    pub coat: f32,
    /// Roughness of its facets, as `alpha`.
    pub coat_alpha: f32,
    /// Reflectance of the threads of cloth, within [0, 1]; black is none.
    pub cloth_color: S,
    /// Roughness of the cloth, within [0, 1]: the square of glTF's. At least 0.05 is computed with.
    pub cloth_alpha: f32,
}

/// Indices of refraction of facets of coats.
pub(super) const COAT_IOR: Range = Range::new("from 1 to 10", |x| (1.0..=10.0).contains(&x));

impl<S> Layers<S> {
    /// Whether light goes through, at least where a picture of shares of metal has none.
    pub fn transmits(&self) -> bool {
        self.transmission > 0.0 || self.diffuse_transmission > 0.0
    }

    /// The same with `sample` of the spectra, each by the name of its key.
    ///
    /// # Errors
    /// Those of `sample`.
    pub fn sampled<T, E>(
        &self,
        mut sample: impl FnMut(&S, &'static str, Role) -> Result<T, E>,
    ) -> Result<Layers<T>, E> {
        let mut color = |of: &S, key| sample(of, key, Role::Reflectance);
        Ok(Layers {
            base_color: color(&self.base_color, "base_color")?,
            metallic: self.metallic,
            alpha: self.alpha,
            ior: self.ior,
            specular: self.specular,
            specular_color: color(&self.specular_color, "specular_color")?,
            transmission: self.transmission,
            diffuse_transmission: self.diffuse_transmission,
            diffuse_transmission_color: color(
                &self.diffuse_transmission_color,
                "diffuse_transmission_color",
            )?,
            coat: self.coat,
            coat_alpha: self.coat_alpha,
            cloth_color: color(&self.cloth_color, "cloth_color")?,
            cloth_alpha: self.cloth_alpha,
        })
    }
}

impl Layers<Spectrum> {
    /// Metallic-roughness of this color and these facets with nothing else about it: no wall, no
    /// coat, no cloth.
    pub fn plain(base_color: impl Into<Spectrum>, metallic: f32, alpha: f32) -> Self {
        let [black, white] = [0.0, 1.0].map(Spectrum::Constant);
        Self {
            base_color: base_color.into(),
            metallic,
            alpha,
            ior: 1.5,
            specular: 1.0,
            specular_color: white.clone(),
            transmission: 0.0,
            diffuse_transmission: 0.0,
            diffuse_transmission_color: white,
            coat: 0.0,
            coat_alpha: 0.0,
            cloth_color: black,
            cloth_alpha: 0.0,
        }
    }

    /// Whether there is any cloth.
    pub(super) fn has_cloth(&self) -> bool {
        self.cloth_color.values().iter().any(|value| *value > 0.0)
    }

    /// Refuses what no surface does.
    pub(super) fn check(&self) -> Result<(), Fault> {
        let Self { base_color, specular_color, diffuse_transmission_color, .. } = self;
        base_color.check("base_color", Range::UNIT)?;
        specular_color.check("specular_color", Range::UNIT)?;
        diffuse_transmission_color.check("diffuse_transmission_color", Range::UNIT)?;
        self.cloth_color.check("cloth_color", Range::UNIT)?;
        COAT_IOR.check("ior", self.ior)?;
        for (field, share) in [
            ("metallic", self.metallic),
            ("alpha", self.alpha),
            ("specular", self.specular),
            ("transmission", self.transmission),
            ("diffuse_transmission", self.diffuse_transmission),
            ("coat", self.coat),
            ("coat_alpha", self.coat_alpha),
            ("cloth_alpha", self.cloth_alpha),
        ] {
            Range::UNIT.check(field, share)?;
        }
        Ok(())
    }
}

impl<const N: usize> Layers<[f32; N]> {
    /// Gives a parameter another value, or the first of it to one that is a number; false if there
    /// is no such parameter.
    pub(super) fn set(&mut self, parameter: Parameter, value: [f32; N]) -> bool {
        let number = value[0].clamp(0.0, 1.0);
        match parameter {
            Parameter::BaseColor => self.base_color = value,
            Parameter::Metallic => self.metallic = number,
            Parameter::Roughness => self.alpha = number * number,
            Parameter::Specular => self.specular = number,
            Parameter::SpecularColor => self.specular_color = value,
            Parameter::Transmission => self.transmission = number,
            Parameter::DiffuseTransmission => self.diffuse_transmission = number,
            Parameter::DiffuseTransmissionColor => self.diffuse_transmission_color = value,
            Parameter::Coat => self.coat = number,
            Parameter::CoatRoughness => self.coat_alpha = number * number,
            Parameter::ClothColor => self.cloth_color = value,
            Parameter::ClothRoughness => self.cloth_alpha = number * number,
            Parameter::Reflectance
            | Parameter::Alpha
            | Parameter::Weight
            | Parameter::Strength
            | Parameter::GrainRight
            | Parameter::GrainUp
            | Parameter::FilmShare
            | Parameter::FilmThickness => return false,
        }
        true
    }
}
