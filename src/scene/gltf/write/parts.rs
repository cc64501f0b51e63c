//! What written materials have beside their keys, and blends in their parts: textures, and tables
//! in files.

use serde_json::{Value, json};

use super::super::blends;
use super::super::extension::EXTENSION;
use super::painted::Painter;
use super::stored::open;
use super::{Writer, called};
use crate::scene::error::SceneError;
use crate::scene::world::{Bsdf, Name, Sides, Textures};

impl Writer<'_> {
    /// Adds the textures of a material, and those of its parts to theirs.
    pub(super) fn paint(
        &mut self,
        name: &Name,
        (bsdf, textures): (&Bsdf, &Textures),
        material: &mut Value,
    ) -> Result<(), SceneError> {
        let Self { world, stored, lists, .. } = self;
        let mut painter = Painter { world, stored, lists, name: &name.0, material: &mut *material };
        painter.paint(bsdf, textures)?;
        for ((part, index), textures) in blends::parts(bsdf, material).zip(&textures.parts) {
            self.of_part(index, |writer, own| writer.paint(name, (part, textures), own))?;
        }
        Ok(())
    }

    /// Stores the measured tables of a material and of its parts.
    pub(super) fn store_tables(
        &mut self,
        name: &Name,
        bsdf: &Bsdf,
        material: &mut Value,
    ) -> Result<(), SceneError> {
        if let Bsdf::Measured { table, places } = bsdf {
            if *places != table.places() {
                let problem = "is measured at one wavelength for all, which is not written";
                return Err(SceneError::new(&name.0, problem, "keep the scene's own file"));
            }
            let stored = self.stored.file(table.bytes(), self.world);
            let number = stored.map_err(|error| SceneError::new(&name.0, error, ""))?;
            material["extensions"][EXTENSION]["file"] = open(number);
        }
        for (part, index) in blends::parts(bsdf, material) {
            self.of_part(index, |writer, own| writer.store_tables(name, part, own))?;
        }
        Ok(())
    }

    /// Adds something to the material of a part.
    fn of_part<R>(&mut self, index: usize, add: impl FnOnce(&mut Self, &mut Value) -> R) -> R {
        let mut own = std::mem::take(&mut self.materials[index]);
        let result = add(self, &mut own);
        self.materials[index] = own;
        result
    }

    /// Writes a part of a blend as a material; its place.
    pub(super) fn part(&mut self, name: &Name, part: &Bsdf, which: &str) -> usize {
        let mut material = self.material(name, part, Sides::default(), None);
        material["name"] = json!(format!("{}, {which}", called(name)));
        self.materials.push(material);
        self.materials.len() - 1
    }
}
