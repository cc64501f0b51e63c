//! What of a material textures feed.

use super::{Bsdf, Coverage, Paint, Parameter, Relief, Texture};
use crate::math::{Fault, Range};

/// What of a material differs from place to place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Textures {
    /// Parameters of its model.
    pub parameters: Vec<(Parameter, Paint)>,
    /// Its radiance.
    pub emission: Option<Paint>,
    /// Its shading normal.
    pub relief: Option<Relief>,
    /// How much of it is there.
    pub coverage: Option<Coverage>,
}

impl Textures {
    /// Whether nothing differs.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Refuses textures that do not go with a model.
    pub(crate) fn check(&self, bsdf: &Bsdf) -> Result<(), Fault> {
        let Ok(mut model) = bsdf.sampled(|_, _, _| Ok::<_, Fault>([0.0; 1])) else { return Ok(()) };
        for (parameter, _) in &self.parameters {
            if !model.set(*parameter, [0.0]) {
                let problem = format!("{parameter:?} is no parameter of its model");
                return Err(Fault::new("textures", problem, "take this texture away"));
            }
        }
        if self.coverage.is_some() && bsdf.transmits() {
            let problem = "what light goes through has no holes";
            return Err(Fault::new("alpha", problem, "make it opaque: alphaMode OPAQUE"));
        }
        for texture in self.textures() {
            if texture.set > 1 {
                let problem = format!("{} is not one of the two sets of coordinates", texture.set);
                return Err(Fault::new("texCoord", problem, "use 0 or 1"));
            }
        }
        let factors = self.paints().flat_map(|paint| paint.factor);
        factors.into_iter().try_for_each(|factor| Range::NOT_NEGATIVE.check("factor", factor))?;
        match &self.relief {
            Some(relief) => Range::ANY.check("scale", relief.scale),
            None => Ok(()),
        }
    }

    /// Whether there is more to them than a share that is the same everywhere.
    pub(crate) fn differ_by_place(&self) -> bool {
        let Self { parameters, emission, relief, coverage } = self;
        let is_even = coverage.as_ref().is_none_or(|coverage| coverage.even().is_some());
        !parameters.is_empty() || emission.is_some() || relief.is_some() || !is_even
    }

    /// All that is painted.
    pub fn paints(&self) -> impl Iterator<Item = &Paint> {
        let parameters = self.parameters.iter().map(|(_, paint)| paint);
        parameters.chain(&self.emission).chain(self.coverage.as_ref().map(|it| &it.paint))
    }

    /// All textures.
    pub fn textures(&self) -> impl Iterator<Item = &Texture> {
        let relief = self.relief.iter().map(|relief| &relief.texture);
        self.paints().filter_map(|paint| paint.texture.as_ref()).chain(relief)
    }

    /// Whether any of it goes by the colors of vertices.
    pub fn read_vertices(&self) -> bool {
        self.paints().any(|paint| paint.by_vertices)
    }
}
