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
    /// The color of its glass or metal.
    pub stain: Stain,
}

/// The color of glass and metal, beyond what their indices of refraction make of light: shares that
/// are left of it whatever its direction and polarization. All of it, where nothing is said.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stain {
    /// Of what is reflected.
    pub reflected: Option<Paint>,
    /// Of what goes through, each time.
    pub transmitted: Option<Paint>,
}

impl Stain {
    /// Both.
    pub fn paints(&self) -> impl Iterator<Item = &Paint> {
        self.reflected.iter().chain(&self.transmitted)
    }

    /// Whether there is one.
    pub fn is_some(&self) -> bool {
        self.paints().next().is_some()
    }

    /// Whether it differs from place to place.
    pub fn differs(&self) -> bool {
        self.paints().any(|paint| paint.texture.is_some() || paint.by_vertices)
    }

    /// Whether a model may have one of what it reflects, and of what it lets through.
    pub fn goes_with(bsdf: &Bsdf) -> [bool; 2] {
        match bsdf {
            Bsdf::Brushed { of, .. } => Self::goes_with(of),
            Bsdf::Filmed { .. } => [false; 2],
            Bsdf::Conductor { .. } | Bsdf::FilmedConductor { .. } | Bsdf::RoughConductor { .. } => {
                [true, false]
            }
            other => [Self::is_of_glass(other) && other.clone().simplified() != Bsdf::Null; 2],
        }
    }

    /// Whether a model is glass, if only between equal indices of refraction.
    pub(crate) fn is_of_glass(bsdf: &Bsdf) -> bool {
        match bsdf {
            Bsdf::Brushed { of, .. } | Bsdf::Filmed { of, .. } => Self::is_of_glass(of),
            Bsdf::Dielectric { .. }
            | Bsdf::DispersiveDielectric { .. }
            | Bsdf::FilmedDielectric { .. }
            | Bsdf::RoughDielectric { .. }
            | Bsdf::ThinDielectric { .. } => true,
            Bsdf::Absorber
            | Bsdf::Conductor { .. }
            | Bsdf::FilmedConductor { .. }
            | Bsdf::RoughConductor { .. }
            | Bsdf::Diffuse { .. }
            | Bsdf::MetallicRoughness { .. }
            | Bsdf::Layered { .. }
            | Bsdf::Plastic { .. }
            | Bsdf::Measured { .. }
            | Bsdf::Blend { .. }
            | Bsdf::Polarizer { .. }
            | Bsdf::Retarder { .. }
            | Bsdf::Sheet { .. }
            | Bsdf::Null => false,
        }
    }

    /// Refuses what is more than all light, and what a model has not.
    fn check(&self, bsdf: &Bsdf) -> Result<(), Fault> {
        let of = [("reflected", &self.reflected), ("transmitted", &self.transmitted)];
        for ((field, paint), has) in of.into_iter().zip(Self::goes_with(bsdf)) {
            let Some(paint) = paint else { continue };
            if !has {
                let problem = "is of glass that refracts, or, if reflected, of metal";
                return Err(Fault::new(field, problem, "take it away"));
            }
            paint.factor.into_iter().try_for_each(|it| Range::UNIT.check(field, it))?;
        }
        Ok(())
    }
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
        self.stain.check(bsdf)?;
        if self.coverage.is_some() && !Self::may_have_holes(bsdf) {
            let problem = "glass that refracts, sheets and boundaries have no holes";
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
        let Some(relief) = &self.relief else { return Ok(()) };
        if !Self::may_bend(bsdf) {
            let problem = "are by a texture, and sheets and null have none to bend";
            return Err(Fault::new("normals", problem, "take this texture away"));
        }
        Range::ANY.check("scale", relief.scale)
    }

    /// Whether a model goes by shading normals. Black is black by any.
    pub fn may_bend(bsdf: &Bsdf) -> bool {
        match bsdf {
            Bsdf::Polarizer { .. } | Bsdf::Retarder { .. } | Bsdf::Sheet { .. } | Bsdf::Null => {
                false
            }
            Bsdf::Absorber
            | Bsdf::Diffuse { .. }
            | Bsdf::Conductor { .. }
            | Bsdf::FilmedConductor { .. }
            | Bsdf::RoughConductor { .. }
            | Bsdf::MetallicRoughness { .. }
            | Bsdf::Layered { .. }
            | Bsdf::Plastic { .. }
            | Bsdf::Measured { .. }
            | Bsdf::Blend { .. }
            | Bsdf::Brushed { .. }
            | Bsdf::Filmed { .. }
            | Bsdf::Dielectric { .. }
            | Bsdf::DispersiveDielectric { .. }
            | Bsdf::FilmedDielectric { .. }
            | Bsdf::RoughDielectric { .. }
            | Bsdf::ThinDielectric { .. } => true,
        }
    }

    /// Whether a model may be there by a share: what has nothing behind it, walls and panes.
    pub fn may_have_holes(bsdf: &Bsdf) -> bool {
        match bsdf {
            Bsdf::ThinDielectric { .. } => bsdf.clone().simplified() != Bsdf::Null,
            Bsdf::Absorber
            | Bsdf::Diffuse { .. }
            | Bsdf::Conductor { .. }
            | Bsdf::FilmedConductor { .. }
            | Bsdf::RoughConductor { .. }
            | Bsdf::MetallicRoughness { .. }
            | Bsdf::Layered { .. }
            | Bsdf::Plastic { .. }
            | Bsdf::Measured { .. }
            | Bsdf::Blend { .. } => true,
            Bsdf::Brushed { of, .. } | Bsdf::Filmed { of, .. } => Self::may_have_holes(of),
            Bsdf::Dielectric { .. }
            | Bsdf::DispersiveDielectric { .. }
            | Bsdf::FilmedDielectric { .. }
            | Bsdf::RoughDielectric { .. }
            | Bsdf::Polarizer { .. }
            | Bsdf::Retarder { .. }
            | Bsdf::Sheet { .. }
            | Bsdf::Null => false,
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
            let Self { emission, relief, coverage, stain, .. } = textures;
            if emission.is_some() || relief.is_some() || coverage.is_some() || stain.is_some() {
                let problem = "a part of a blend has a lamp, normals, holes or a color of metal \
                               of its own by textures";
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
        let own = own.chain(self.stain.paints());
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
