//! What a world must be before it is baked: every component as it is checked when it is added, and
//! entities that go together.

use std::collections::BTreeSet;
use std::sync::Arc;

use hecs::{Entity, EntityRef};

use super::incandescent::Incandescent;
use super::light::{Luminaire, Projection};
use super::material::check_material;
use super::pattern;
use super::{
    Ball, Boundary, Bsdf, Emission, EmittedStokes, Environment, Filling, FillsScene, Geometry,
    Lens, MEDIA_MAX, MadeOf, Medium, Mesh, Name, Order, Punctual, Raster, Resolution, Sides,
    Textures, Transform, Window, World,
};
use crate::math::Fault;
use crate::polarization::Analyzer;
use crate::scene::error::SceneError;

/// What an entity is, by the component that no other kind has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Material,
    Medium,
    Mesh,
    Sphere,
    Light,
    Camera,
    Environment,
}

type Has = fn(EntityRef) -> bool;

/// Which component makes which kind of entity.
const KINDS: [(Kind, &str, Has); 7] = [
    (Kind::Material, "material", has::<Bsdf>),
    (Kind::Medium, "medium", has::<Medium>),
    (Kind::Mesh, "mesh", has::<Mesh>),
    (Kind::Sphere, "sphere", has::<Ball>),
    (Kind::Light, "light", has::<Punctual>),
    (Kind::Camera, "camera", has::<Lens>),
    (Kind::Environment, "environment", has::<Environment>),
];

/// The other components: whose they are, and whether these cannot be without.
const PARTS: [(&str, Has, &[Kind], bool); 15] = [
    ("Sides", has::<Sides>, &[Kind::Material], true),
    ("Emission", has::<Emission>, &[Kind::Material], false),
    (
        "EmittedStokes",
        has::<EmittedStokes>,
        &[Kind::Material, Kind::Light, Kind::Environment],
        false,
    ),
    ("Luminaire", has::<Luminaire>, &[Kind::Light], false),
    ("Projection", has::<Projection>, &[Kind::Light], false),
    ("Incandescent", has::<Incandescent>, &[Kind::Material], false),
    ("Textures", has::<Textures>, &[Kind::Material], false),
    ("FillsScene", has::<FillsScene>, &[Kind::Medium], false),
    ("Analyzer", has::<Analyzer>, &[Kind::Camera], false),
    ("Resolution", has::<Resolution>, &[Kind::Camera], false),
    ("Raster", has::<Raster>, &[Kind::Camera], false),
    ("Window", has::<Window>, &[Kind::Camera], false),
    ("MadeOf", has::<MadeOf>, &[Kind::Mesh, Kind::Sphere], true),
    ("Boundary", has::<Boundary>, &[Kind::Mesh, Kind::Sphere], true),
    ("Transform", has::<Transform>, &[Kind::Mesh, Kind::Sphere, Kind::Light, Kind::Camera], true),
];

fn has<T: hecs::Component>(entity: EntityRef) -> bool {
    entity.has::<T>()
}

impl World {
    /// Checks all that has been added, read or edited, as `bake` does before anything else.
    ///
    /// ```
    /// use sunstone::world::Bsdf;
    /// use sunstone::{PlacedWorld, load};
    ///
    /// let mut world = load("scenes/cornell.gltf".as_ref())?;
    /// let white = world.find("white").expect("the box has a white material");
    /// *world.entities_mut().get::<&mut Bsdf>(white)? = Bsdf::diffuse(2.5);
    /// let error = PlacedWorld::new(world).map(|_| ()).unwrap_err().to_string();
    /// assert!(error.contains("\"white\", reflectance: 2.5 must be within [0, 1]"), "{error}");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// With the entity, its field and the remedy, when a value is not physical, a component is
    /// missing or on the wrong entity, a material or medium is gone, or there is not one camera
    /// and at most one environment and one medium of the scene.
    pub fn check(&self) -> Result<(), SceneError> {
        self.check_all().map_err(|error| error.in_file(&self.file))
    }

    fn check_all(&self) -> Result<(), SceneError> {
        let mut entities: Vec<EntityRef> = self.entities.iter().collect();
        entities.sort_by_cached_key(|entity| entity.get::<&Order>().map(|order| order.0));
        let mut counted: [Vec<String>; 4] = Default::default();
        let [cameras, skies, filling, media] = &mut counted;
        let mut seen = BTreeSet::new();
        for entity in entities {
            let name = || match entity.get::<&Name>() {
                Some(name) => name.0.clone(),
                None => format!("entity {}", entity.entity().id()),
            };
            let at = |fault: Fault| SceneError::at(&name(), fault);
            let Some(kind) = kind(entity).map_err(at)? else { continue };
            self.check_components(entity, kind, &mut seen).map_err(at)?;
            match kind {
                Kind::Camera => cameras.push(name()),
                Kind::Environment => skies.push(name()),
                Kind::Medium => {
                    media.push(name());
                    filling.extend(entity.has::<FillsScene>().then(name));
                }
                Kind::Material | Kind::Mesh | Kind::Sphere | Kind::Light => {}
            }
        }
        if cameras.is_empty() {
            let remedy = "add one with `set_camera`";
            return Err(SceneError::new("camera", "the world has no camera", remedy));
        }
        let most = [("camera", 1), ("environment", 1), ("medium of the scene", 1)];
        let most = most.into_iter().chain([("medium", MEDIA_MAX)]);
        for (names, (what, most)) in counted.iter().zip(most) {
            if let Some(name) = names.get(most) {
                let problem = format!("is one {what} too many, after {}", names[most - 1]);
                return Err(SceneError::new(name, problem, format!("keep {most} at most")));
            }
        }
        Ok(())
    }

    /// Checks what is in the components of an entity that has those it needs.
    fn check_components(
        &self,
        entity: EntityRef,
        kind: Kind,
        seen: &mut BTreeSet<usize>,
    ) -> Result<(), Fault> {
        if let Some(stokes) = entity.get::<&EmittedStokes>() {
            stokes.check()?;
            if entity.get::<&Environment>().is_some_and(|sky| sky.is_polarized()) {
                return Err(Environment::polarized_twice());
            }
            if kind == Kind::Material && !entity.has::<Emission>() {
                return Err(EmittedStokes::without_emission());
            }
        }
        match kind {
            Kind::Material => {
                let emission = entity.get::<&Emission>();
                let bsdf = part::<&Bsdf>(entity)?;
                check_material(&bsdf, emission.as_deref())?;
                let textures = entity.get::<&Textures>();
                if entity.has::<Incandescent>() {
                    let stokes = entity.get::<&EmittedStokes>();
                    let of = (emission.as_deref(), stokes.as_deref(), textures.as_deref());
                    Incandescent::check(&bsdf, of.0, of.1, of.2)?;
                }
                textures.map_or(Ok(()), |textures| textures.check(&bsdf))
            }
            Kind::Medium => part::<&Medium>(entity)?.check(),
            Kind::Mesh => {
                part::<&Transform>(entity)?.check()?;
                let mesh = part::<&Mesh>(entity)?;
                if !self.is_checked(&mesh.0) && seen.insert(Arc::as_ptr(&mesh.0).addr()) {
                    mesh.0.check()?;
                }
                let of = part::<&MadeOf>(entity)?;
                self.check_skin(&of, &*part::<&Boundary>(entity)?)?;
                self.check_painted(of.0, &mesh.0)
            }
            Kind::Sphere => {
                part::<&Ball>(entity)?.check()?;
                Ball::check_place(&*part::<&Transform>(entity)?)?;
                let of = part::<&MadeOf>(entity)?;
                self.check_skin(&of, &*part::<&Boundary>(entity)?)
            }
            Kind::Light => {
                part::<&Transform>(entity)?.check()?;
                let light = part::<&Punctual>(entity)?;
                pattern::check(entity, light.kind)?;
                light.check()
            }
            Kind::Camera => {
                Lens::check_place(&*part::<&Transform>(entity)?)?;
                part::<&Lens>(entity)?.check()?;
                let analyzer =
                    entity.get::<&Analyzer>().map_or(Ok(()), |analyzer| analyzer.check());
                analyzer.map_err(|fault| fault.within("analyzer"))?;
                entity.get::<&Window>().map_or(Ok(()), |window| window.check())?;
                let resolution = entity.get::<&Resolution>().map(|resolution| *resolution);
                resolution.map_or(Ok(()), Resolution::check)?;
                entity.get::<&Raster>().map_or(Ok(()), |raster| raster.check(resolution))
            }
            Kind::Environment => part::<&Environment>(entity)?.check(),
        }
    }

    /// Whether a geometry has been checked when it was added.
    pub(super) fn is_checked(&self, geometry: &Arc<Geometry>) -> bool {
        self.checked.contains_key(&Arc::as_ptr(geometry).addr())
    }

    /// Refuses a material or medium that is not there, and media that do not go with the material.
    pub(super) fn check_skin(&self, of: &MadeOf, boundary: &Boundary) -> Result<(), Fault> {
        let Ok(bsdf) = self.entities.get::<&Bsdf>(of.0) else {
            let problem = "is not a material of this world (any more)";
            return Err(Fault::new("material", problem, "use one that `add_material` returned"));
        };
        boundary.check(&bsdf)?;
        for (field, filling) in boundary.stated() {
            match filling {
                Filling::Clear => {}
                Filling::Medium(medium) => self.check_medium(field, medium)?,
            }
        }
        Ok(())
    }

    /// Refuses textures on meshes without coordinates for them. Spheres have their own.
    pub(super) fn check_painted(&self, material: Entity, geometry: &Geometry) -> Result<(), Fault> {
        let Ok(textures) = self.entities.get::<&Textures>(material) else { return Ok(()) };
        let sets = [&geometry.texture_coordinates, &geometry.texture_coordinates_1];
        let missing = textures.textures().find(|texture| sets[texture.set].is_empty());
        if let Some(texture) = missing {
            let name = self.entities.get::<&Name>(material);
            let name = name.map_or_else(|_| "its material".to_owned(), |name| name.0.clone());
            let problem = format!("is missing, and a texture of {name} goes by it");
            let remedy = "unwrap the mesh, or give the texture a set that it has";
            return Err(Fault::new(format!("TEXCOORD_{}", texture.set), problem, remedy));
        }
        Ok(())
    }

    /// Refuses, as the value of a field, what is not a medium of this world.
    pub(super) fn check_medium(&self, field: &str, medium: Entity) -> Result<(), Fault> {
        if self.entities.satisfies::<&Medium>(medium) {
            return Ok(());
        }
        let problem = "is not a medium of this world (any more)";
        Err(Fault::new(field, problem, "use one that `add_medium` returned"))
    }
}

/// What an entity is; none of ours if it has no component that makes one. Refuses entities of two
/// kinds, without a component that they need, or with one that means nothing to them.
fn kind(entity: EntityRef) -> Result<Option<Kind>, Fault> {
    let mut kinds = KINDS.iter().filter(|(_, _, is)| is(entity));
    let Some((kind, text, _)) = kinds.next() else { return Ok(None) };
    if let Some((_, other, _)) = kinds.next() {
        let problem = format!("is both a {text} and a {other}");
        return Err(Fault::new("", problem, "make two entities of it"));
    }
    let common: [(&str, Has); 2] = [("Order", has::<Order>), ("Name", has::<Name>)];
    let needed = PARTS.iter().filter(|(_, _, owners, needed)| *needed && owners.contains(kind));
    for (part, is_there) in common.into_iter().chain(needed.map(|(part, is, ..)| (*part, *is))) {
        if !is_there(entity) {
            let remedy = format!("a {text} needs this component");
            return Err(Fault::new(part, "is missing", remedy));
        }
    }
    let foreign = PARTS.iter().find(|(_, is, owners, _)| !owners.contains(kind) && is(entity));
    match foreign {
        Some((part, ..)) => {
            let problem = format!("means nothing for a {text}");
            Err(Fault::new(*part, problem, "remove this component"))
        }
        None => Ok(Some(*kind)),
    }
}

/// A component that `kind` has found.
fn part<'a, T: hecs::ComponentRef<'a>>(entity: EntityRef<'a>) -> Result<T::Ref, Fault> {
    entity.get::<T>().ok_or_else(|| Fault::new("", "has lost a component", ""))
}
