//! Media at the wavelengths of the render, and the rows of them on both sides of a surface.

use super::emitters::Emitters;
use hecs::Entity;

use super::grid::Suspensions;
use super::{Rows, optics};
use crate::scene::baked::{KEEP, Medium, NONE};
use crate::scene::error::SceneError;
use crate::scene::world::{self, Boundary, Filling, Name, Passage, World};
use crate::spectrum::Carried;

/// All media, in the file's order. What their particles do may be known already.
pub fn media<const N: usize>(
    world: &World,
    carried: &Carried<N>,
    known: Option<&Suspensions>,
) -> Result<Vec<Medium<N>>, SceneError> {
    let row = |(entity, name, medium): (Entity, &Name, &world::Medium)| {
        let known = known.and_then(|known| known.of(entity));
        optics::medium_row(medium, carried, (&name.0, known))
    };
    world.in_order::<(Entity, &Name, &world::Medium), _>(row).into_iter().collect()
}

impl Rows {
    /// What lies behind and before a surface, and whether that is not stated.
    pub fn sides(&self, passage: Passage, boundary: &Boundary) -> [(u32, bool); 2] {
        let row = |filling: Filling| match filling {
            Filling::Clear => NONE,
            Filling::Medium(entity) => self.media.get(&entity).copied().unwrap_or(NONE),
        };
        let (interior, exterior) = (boundary.interior.map(row), boundary.exterior.map(row));
        let or_around = |side: Option<u32>| (side.unwrap_or(self.scene_medium), side.is_none());
        let bounds_nothing = interior.is_none() && exterior.is_none();
        match passage {
            Passage::Closed => [(KEEP, false); 2],
            Passage::Sheet if bounds_nothing => [(KEEP, false); 2],
            Passage::Body => [(interior.unwrap_or(NONE), false), or_around(exterior)],
            Passage::Sheet | Passage::Boundary => [interior, exterior].map(or_around),
        }
    }
}

/// Refuses light from infinity in a medium without end: none of it would arrive.
pub fn check_lights<const N: usize>(
    world: &World,
    media: &[Medium<N>],
    scene_medium: u32,
    emitters: &Emitters,
) -> Result<(), SceneError> {
    let Some(medium) = media.get(scene_medium as usize) else { return Ok(()) };
    let attenuates = medium.sigma_a.iter().chain(&medium.sigma_s).any(|sigma| *sigma > 0.0);
    if attenuates && emitters.rows.iter().any(|row| !row.model.is_finite()) {
        let names = world.in_order::<(&Name, &world::Medium), _>(|(name, _)| name.0.clone());
        let place = &names[scene_medium as usize];
        let problem = "fills the scene, so no light of a directional light or environment would \
                       ever arrive";
        let remedy = "bound the medium by a mesh of the bsdf `null`, or use other lights";
        return Err(SceneError::new(place, problem, remedy));
    }
    Ok(())
}
