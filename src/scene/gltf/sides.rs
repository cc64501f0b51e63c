//! Which sides of a material's surfaces reflect and emit.

use super::Import;
use super::extension::{Body, MATERIAL};
use super::materials::KHR_UNLIT;
use crate::scene::error::SceneError;
use crate::scene::world::{Bsdf, Emission, Sides};

/// Says that the back of a material is black and dark where glTF would have it like the front.
pub const ONE_SIDED: &str = "one_sided";

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
        let body = Body::of(value, label, &MATERIAL)?;
        let is_lamp = emission.is_some() && !value["extensions"][KHR_UNLIT].is_object();
        let is_stated = self.document.root.materials[index].double_sided;
        if body.flag(ONE_SIDED)?.unwrap_or(false) {
            return match is_stated {
                true => {
                    let problem = "contradicts doubleSided";
                    Err(SceneError::new(body.field(ONE_SIDED), problem, "keep one of them"))
                }
                false => Ok(Sides { two_sided: false }),
            };
        }
        let two_sided = is_stated || has_backs(bsdf, (body.has("bsdf"), is_lamp));
        Ok(Sides { two_sided })
    }
}

/// Whether the back of what states nothing of it is like the front: of a model that the extension
/// names or not, of a lamp or not.
pub fn has_backs(bsdf: &Bsdf, (has_own, is_lamp): (bool, bool)) -> bool {
    let is_layered = matches!(bsdf, Bsdf::Layered { .. } | Bsdf::Blend { .. });
    is_layered && bsdf.transmits() || !(has_own || is_lamp)
}
