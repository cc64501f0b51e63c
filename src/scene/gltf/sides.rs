//! Which sides of a material's surfaces reflect and emit.

use super::Import;
use super::extension::{Body, MATERIAL};
use super::materials::KHR_UNLIT;
use crate::scene::error::SceneError;
use crate::scene::world::{Bsdf, Emission, Sides};

impl Import<'_> {
    /// Those of a material. Viewers leave out the back of what glTF calls one-sided, and show what
    /// is behind it; nothing real lets light through one way only, and black would be worse. So
    /// the backs of glTF's own models are like their fronts; those of lamps are dark. Of what light
    /// goes through both sides are seen.
    pub fn sides(
        &self,
        index: usize,
        label: &str,
        (bsdf, emission): (&Bsdf, &Option<Emission>),
    ) -> Result<Sides, SceneError> {
        let value = &self.document.value["materials"][index];
        let has_own = Body::of(value, label, &MATERIAL)?.has("bsdf");
        let is_lamp = emission.is_some() && !value["extensions"][KHR_UNLIT].is_object();
        let is_layered = matches!(bsdf, Bsdf::Layered { .. } | Bsdf::Blend { .. });
        let is_open = is_layered && bsdf.transmits();
        let is_stated = self.document.root.materials[index].double_sided;
        Ok(Sides { two_sided: is_stated || is_open || !(has_own || is_lamp) })
    }
}
