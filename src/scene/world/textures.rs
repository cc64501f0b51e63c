//! What of a material textures feed.

use super::{Bsdf, Coverage, Paint, Parameter, Relief, SurfaceModel, Texture};
use crate::math::{Fault, Range};

/// What of a material differs from place to place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Textures {
    /// Parameters of its model.
    pub parameters: Vec<(Parameter, Paint)>,
    /// The same of the parts of its model, if that is a blend: none, or of each, and nothing else.
    pub parts: Vec<Self>,
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
        self.check_parameters(&mut model)?;
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
        let Self { emission, relief, coverage, .. } = self;
        let is_even = coverage.as_ref().is_none_or(|coverage| coverage.even().is_some());
        self.feed_model() || emission.is_some() || relief.is_some() || !is_even
    }

    /// Refuses parameters that a model, or its parts, do not have.
    fn check_parameters(&self, model: &mut SurfaceModel<[f32; 1]>) -> Result<(), Fault> {
        for (parameter, _) in &self.parameters {
            if !model.set(*parameter, [0.0]) {
                let problem = format!("{parameter:?} is no parameter of its model");
                return Err(Fault::new("textures", problem, "take this texture away"));
            }
        }
        if self.parts.is_empty() {
            return Ok(());
        }
        let SurfaceModel::Blend { parts, .. } = model else {
            let problem = "has textures of parts, and its model is no blend";
            return Err(Fault::new("textures", problem, "take them away"));
        };
        if self.parts.len() != parts.len() {
            let problem = format!("has textures of {} parts of two", self.parts.len());
            return Err(Fault::new("textures", problem, "give those of each"));
        }
        for (textures, part) in self.parts.iter().zip(parts.iter_mut()) {
            let Self { emission, relief, coverage, .. } = textures;
            if emission.is_some() || relief.is_some() || coverage.is_some() {
                let problem =
                    "a part of a blend has a lamp, normals or holes of its own by textures";
                return Err(Fault::new("textures", problem, "give them to the blend"));
            }
            textures.check_parameters(part)?;
        }
        Ok(())
    }

    /// Whether they feed the model.
    #[inline]
    pub fn feed_model(&self) -> bool {
        !self.parameters.is_empty() || self.parts.iter().any(Self::feed_model)
    }

    /// All that is painted.
    pub fn paints(&self) -> Box<dyn Iterator<Item = &Paint> + '_> {
        let parameters = self.parameters.iter().map(|(_, paint)| paint);
        let own =
            parameters.chain(&self.emission).chain(self.coverage.as_ref().map(|it| &it.paint));
        Box::new(own.chain(self.parts.iter().flat_map(Self::paints)))
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
