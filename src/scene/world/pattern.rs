//! What the lights of a world emit by direction: measured luminaires and pictures.

use std::sync::Arc;

use hecs::{Entity, EntityRef};

use super::light::{Luminaire, Projection, Punctual, PunctualKind};
use super::{Name, Photometry, Picture, World};
use crate::math::Fault;
use crate::scene::error::SceneError;

impl World {
    /// Has a point light of this world emit as a luminaire that was measured: its intensity in W/sr
    /// is what one candela of that stands for.
    ///
    /// # Errors
    /// When it is no point.
    pub fn set_luminaire(
        &mut self,
        light: Entity,
        photometry: Photometry,
    ) -> Result<(), SceneError> {
        let name = self.entities.get::<&Name>(light).map_or(String::new(), |it| it.0.clone());
        let doubts = photometry.doubts().to_vec();
        let put = self.put_luminaire(light, Luminaire(Arc::new(photometry)));
        put.map_err(|fault| SceneError::at(&name, fault))?;
        self.warnings.extend(doubts.into_iter().map(|doubt| format!("{name}, ies {doubt}")));
        Ok(())
    }

    /// Has a spot of this world throw a picture ([`Projection`]), of the bytes of an OpenEXR,
    /// Radiance HDR, PNG, JPEG or WebP file (these three as sRGB).
    ///
    /// # Errors
    /// When the picture cannot be read, is black, polarized, or has negative or infinite values, or
    /// when the light is no spot, or one of more than 88.8 degrees to its edge.
    pub fn set_projection(&mut self, light: Entity, bytes: &[u8]) -> Result<(), SceneError> {
        let name = self.entities.get::<&Name>(light).map_or(String::new(), |it| it.0.clone());
        let picture = Picture::around(bytes, &format!("{name}, picture"))?;
        let put = self.put_projection(light, Projection(Arc::new(picture)));
        put.map_err(|fault| SceneError::at(&name, fault))
    }

    /// Has a point emit as a luminaire.
    pub(in crate::scene) fn put_luminaire(
        &mut self,
        light: Entity,
        luminaire: Luminaire,
    ) -> Result<(), Fault> {
        let kind = self.entities.get::<&Punctual>(light).ok().map(|light| light.kind);
        Luminaire::check(kind)?;
        self.insert(light, luminaire);
        Ok(())
    }

    /// Has a spot throw a picture.
    pub(in crate::scene) fn put_projection(
        &mut self,
        light: Entity,
        projection: Projection,
    ) -> Result<(), Fault> {
        let kind = self.entities.get::<&Punctual>(light).ok().map(|light| light.kind);
        projection.check(kind)?;
        self.insert(light, projection);
        Ok(())
    }
}

/// Refuses what a light of a kind does not emit.
pub(super) fn check(light: EntityRef, kind: PunctualKind) -> Result<(), Fault> {
    if light.has::<Luminaire>() {
        Luminaire::check(Some(kind))?;
    }
    light.get::<&Projection>().map_or(Ok(()), |projection| projection.check(Some(kind)))
}
