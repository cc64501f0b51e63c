//! Media at the wavelengths of the render, and the rows of them on both sides of a surface.

use std::collections::HashMap;

use hecs::Entity;

use super::emitters::Emitters;
use super::optics;
use crate::scene::baked::{EmitterKind, KEEP, MaterialKind, Medium, NONE};
use crate::scene::error::SceneError;
use crate::scene::world::{self, Boundary, Filling, FillsScene, Name, World};
use crate::spectrum::Color;

/// The table of media: see `BakedScene`.
pub struct Media<const N: usize> {
    pub rows: Vec<Medium<N>>,
    pub scene_medium: u32,
    names: Vec<String>,
    row_of: HashMap<Entity, u32>,
}

/// All media, in the file's order.
pub fn media<const N: usize>(world: &World, color: Color) -> Result<Media<N>, SceneError> {
    type Components<'a> = (Entity, &'a Name, &'a world::Medium, Option<&'a FillsScene>);
    let mut table =
        Media { rows: Vec::new(), scene_medium: NONE, names: Vec::new(), row_of: HashMap::new() };
    let rows = world.in_order::<Components, _>(|(entity, name, medium, fills)| {
        let row = optics::medium_row(medium, color, &name.0);
        (entity, name.0.clone(), row, fills.is_some())
    });
    for (entity, name, row, fills) in rows {
        let index = table.rows.len() as u32;
        table.rows.push(row?);
        table.names.push(name);
        table.row_of.insert(entity, index);
        if fills {
            table.scene_medium = index;
        }
    }
    Ok(table)
}

impl<const N: usize> Media<N> {
    /// What lies behind and before a surface.
    pub fn sides(&self, kind: MaterialKind, boundary: &Boundary) -> (u32, u32) {
        let row = |filling: Filling| match filling {
            Filling::Clear => NONE,
            Filling::Medium(entity) => self.row_of.get(&entity).copied().unwrap_or(NONE),
        };
        let (interior, exterior) = (boundary.interior.map(row), boundary.exterior.map(row));
        let bounds_nothing = interior.is_none() && exterior.is_none();
        match kind {
            MaterialKind::Absorber | MaterialKind::Diffuse | MaterialKind::Conductor => {
                (KEEP, KEEP)
            }
            MaterialKind::Polarizer | MaterialKind::Retarder if bounds_nothing => (KEEP, KEEP),
            // Glass displaces what is around it.
            MaterialKind::Dielectric => {
                (interior.unwrap_or(NONE), exterior.unwrap_or(self.scene_medium))
            }
            MaterialKind::Polarizer | MaterialKind::Retarder | MaterialKind::Null => {
                (interior.unwrap_or(self.scene_medium), exterior.unwrap_or(self.scene_medium))
            }
        }
    }

    /// Refuses light from infinity in a medium without end: none of it would arrive.
    pub fn check_lights(&self, emitters: &Emitters<N>) -> Result<(), SceneError> {
        let Some(medium) = self.rows.get(self.scene_medium as usize) else { return Ok(()) };
        let attenuates = medium.sigma_a.iter().chain(&medium.sigma_s).any(|sigma| *sigma > 0.0);
        let infinite = |kind| matches!(kind, EmitterKind::Directional | EmitterKind::Environment);
        if attenuates && emitters.rows.iter().any(|row| infinite(row.kind)) {
            let place = &self.names[self.scene_medium as usize];
            let problem = "fills the scene, so no light of a directional light or environment \
                           would ever arrive";
            let remedy = "bound the medium by a mesh of the bsdf `null`, or use other lights";
            return Err(SceneError::new(place, problem, remedy));
        }
        Ok(())
    }
}
