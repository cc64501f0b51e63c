//! Shapes: spheres, what all shapes are made of, and what lies on their two sides.

use hecs::Entity;

use super::material::{Bsdf, Passage};
use super::transform::Transform;
use crate::math::{Fault, Range};

/// A sphere about the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Radius before the transform, greater than zero.
    pub radius: f64,
}

impl Ball {
    /// Refuses what is no sphere.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        Range::POSITIVE.check("radius", self.radius)
    }

    /// Refuses a place that would make it an ellipsoid.
    pub(crate) fn check_place(place: &Transform) -> Result<(), Fault> {
        place.check()?;
        if place.is_similarity() {
            return Ok(());
        }
        let problem = "a sphere cannot be scaled differently along its axes, or sheared";
        Err(Fault::new("", problem, "apply the scale, or scale all axes by the same factor"))
    }
}

/// The material entity of a mesh part or sphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MadeOf(pub Entity);

/// What is said about the media on the two sides of a surface. What is not is up to the material;
/// see `bake`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Boundary {
    /// Behind the surface, against its normal.
    pub interior: Option<Filling>,
    /// Before the surface.
    pub exterior: Option<Filling>,
    /// Where closed bodies overlap or touch, the one of the highest priority counts, and of several
    /// the smallest.
    pub priority: i32,
}

impl Boundary {
    /// What is said, with the names of the fields.
    pub(super) fn stated(&self) -> impl Iterator<Item = (&'static str, Filling)> {
        let sides = [("interior", self.interior), ("exterior", self.exterior)];
        sides.into_iter().filter_map(|(field, filling)| Some((field, filling?)))
    }

    /// Refuses media about an opaque surface, and a null surface without any.
    pub(crate) fn check(&self, bsdf: &Bsdf) -> Result<(), Fault> {
        let stated = self.stated().next();
        if let Some((field, _)) = stated
            && !bsdf.transmits()
        {
            let problem = "an opaque surface has nothing behind it";
            let remedy = "remove it, or use a material that transmits: dielectric or null";
            return Err(Fault::new(field, problem, remedy));
        }
        if self.priority != 0 && !bsdf.transmits() {
            let problem = "light gets to the inside of no opaque body";
            let remedy = "remove it, or use a material that transmits: dielectric or null";
            return Err(Fault::new("priority", problem, remedy));
        }
        if stated.is_none() && bsdf.passage() == Passage::Boundary {
            let problem = "a null surface without media is not there at all";
            return Err(Fault::new("", problem, "add `interior`, the medium that is inside"));
        }
        Ok(())
    }
}

/// What fills a space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filling {
    /// Nothing that absorbs or scatters.
    Clear,
    /// A medium entity.
    Medium(Entity),
}

/// The medium.
impl From<Entity> for Filling {
    fn from(medium: Entity) -> Self {
        Self::Medium(medium)
    }
}

/// What a shape is made of and what it bounds: what is given for the shapes that are added to a
/// [`World`](super::World). A material alone says nothing about media.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Skin {
    /// The material entity.
    pub material: Entity,
    /// The media on the two sides.
    pub boundary: Boundary,
}

impl Skin {
    /// The same material, with something behind the surface, against its normal.
    #[must_use]
    pub fn interior(mut self, filling: impl Into<Filling>) -> Self {
        self.boundary.interior = Some(filling.into());
        self
    }

    /// The same material, with something before the surface.
    #[must_use]
    pub fn exterior(mut self, filling: impl Into<Filling>) -> Self {
        self.boundary.exterior = Some(filling.into());
        self
    }

    /// The same material, for a body that counts where ones of lower priority, 0 if none is given,
    /// overlap with it or touch it.
    #[must_use]
    pub fn priority(mut self, priority: i32) -> Self {
        self.boundary.priority = priority;
        self
    }
}

/// A material without media.
impl From<Entity> for Skin {
    fn from(material: Entity) -> Self {
        Self { material, boundary: Boundary::default() }
    }
}
