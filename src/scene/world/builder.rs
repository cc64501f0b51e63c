//! Making a world: what programs call, and what readers of files call with their own names.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use glam::{DQuat, Vec3};
use hecs::{DynamicBundle, Entity, EntityBuilder};

use super::incandescent::Incandescent;
use super::material::check_material;
use super::{
    Asked, Backdrop, BackdropSource, Ball, Bsdf, ClearSky, Emission, EmittedStokes, Environment,
    FillsScene, Film, Geometry, Lens, MadeOf, Material, Medium, Mesh, Name, Order, Picture,
    Punctual, Raster, Resolution, Skin, Textures, Transform, World,
};
use crate::math::Fault;
use crate::polarization::Analyzer;
use crate::scene::error::SceneError;
use crate::spectrum::Spectrum;

/// Functions that add return the entity, or say which of its fields is wrong and add nothing.
/// Errors call an entity by its kind and name, ``sphere `ball` `` for instance; an empty name is
/// replaced by a number.
///
/// ```
/// use sunstone::glam::{DVec3, Vec3};
/// use sunstone::world::{Bsdf, Geometry, Lens, Material, Transform, World};
///
/// let mut world = World::new("room");
/// let white = world.add_material("white", Material::from(Bsdf::diffuse(0.7)).two_sided())?;
/// let glass = world.add_material("glass", Bsdf::dielectric(1.5))?;
/// let steel = world.add_material("plate", Bsdf::metal("Al")?)?;
/// let lamp = world.add_material("lamp", Material::emitter([20.0, 18.0, 15.0]))?;
/// let walls = Geometry::cuboid(Vec3::splat(-1.0), Vec3::splat(1.0));
/// world.add_mesh("walls", walls, white, Transform::IDENTITY)?;
/// let under = |y, size| Geometry::quad(Vec3::Y * y, Vec3::X * size, Vec3::Z * size);
/// world.add_mesh("lamp", under(0.99, 0.3), lamp, Transform::IDENTITY)?;
/// world.add_mesh("plate", Geometry::quad(Vec3::NEG_Y * 0.9, Vec3::Z, Vec3::X), steel,
///     Transform::IDENTITY)?;
/// world.add_sphere("ball", 0.4, glass, DVec3::new(0.2, -0.4, 0.0))?;
/// let place = Transform::looking(DVec3::Z * 0.9, DVec3::ZERO, DVec3::Y);
/// world.set_camera("eye", Lens::pinhole(1.2), place)?;
///
/// let error = world.add_material("snow", Bsdf::diffuse(2.5)).unwrap_err();
/// assert_eq!(error.to_string(), "material `snow`, reflectance: 2.5 must be within [0, 1]");
/// # Ok::<(), sunstone::SceneError>(())
/// ```
impl World {
    /// An empty scene.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            entities: hecs::World::new(),
            name: name.into(),
            file: PathBuf::new(),
            files: Vec::new(),
            checksums: Vec::new(),
            warnings: Vec::new(),
            put_in: Vec::new(),
            asked: Asked::default(),
            order: 0,
            checked: HashMap::new(),
        }
    }

    /// Adds a material: what it scatters, and perhaps emits.
    ///
    /// # Errors
    /// When a value is not physical.
    pub fn add_material(
        &mut self,
        name: &str,
        material: impl Into<Material>,
    ) -> Result<Entity, SceneError> {
        self.called("material", name, |world, name| world.put_material(name, material.into()))
    }

    /// Paints a material of this world with textures, before it is given to any mesh.
    ///
    /// # Errors
    /// When it is none, or the textures do not go with its model.
    pub fn set_textures(&mut self, material: Entity, textures: Textures) -> Result<(), SceneError> {
        let name = self.entities.get::<&Name>(material).map_or(String::new(), |it| it.0.clone());
        let checked = match self.entities.get::<&Bsdf>(material) {
            Ok(bsdf) => textures.check(&bsdf),
            Err(_) => {
                let remedy = "use one that `add_material` returned";
                Err(Fault::new("material", "is not a material of this world", remedy))
            }
        };
        checked.map_err(|fault| SceneError::at(&name, fault))?;
        self.insert(material, textures);
        Ok(())
    }

    /// Has what a material, a light or the environment of this world emits be polarized.
    ///
    /// ```
    /// use sunstone::world::{EmittedStokes, Material, World};
    ///
    /// let mut world = World::new("desk");
    /// let display = world.add_material("display", Material::emitter(200.0))?;
    /// // Along the y axis of the node.
    /// world.set_emitted_stokes(display, EmittedStokes::new([-1.0, 0.0, 0.0])?)?;
    /// assert!(EmittedStokes::new([0.9, 0.9, 0.0]).is_err(), "none is polarized more than wholly");
    /// # Ok::<(), sunstone::Error>(())
    /// ```
    ///
    /// # Errors
    /// When it is none of these, does not emit, or the state is not physical.
    pub fn set_emitted_stokes(
        &mut self,
        emitter: Entity,
        stokes: EmittedStokes,
    ) -> Result<(), SceneError> {
        let name = self.entities.get::<&Name>(emitter).map_or(String::new(), |it| it.0.clone());
        self.put_stokes(emitter, stokes).map_err(|fault| SceneError::at(&name, fault))
    }

    /// Has a material of this world emit by its heat ([`Incandescent`]): its emission is what a
    /// black body would emit.
    ///
    /// ```
    /// use sunstone::Spectrum;
    /// use sunstone::world::{Bsdf, Material, World};
    ///
    /// let mut world = World::new("forge");
    /// let hot = Material::from(Bsdf::metal("W")?).emitting(Spectrum::blackbody(2800.0)?);
    /// let hot = world.add_material("filament", hot)?;
    /// world.set_incandescent(hot)?;
    /// # Ok::<(), sunstone::Error>(())
    /// ```
    ///
    /// # Errors
    /// When it is no smooth metal or glass, does not emit, or emits in a stated state.
    pub fn set_incandescent(&mut self, material: Entity) -> Result<(), SceneError> {
        let name = self.entities.get::<&Name>(material).map_or(String::new(), |it| it.0.clone());
        self.put_incandescent(material).map_err(|fault| SceneError::at(&name, fault))
    }

    /// Adds a mesh in a place, of a material of this world. Meshes that are given as clones of one
    /// `Arc` are kept once.
    ///
    /// # Errors
    /// When an index is out of range, a value is not finite, a triangle has no area, the transform
    /// is singular, or the skin does not go together.
    pub fn add_mesh(
        &mut self,
        name: &str,
        geometry: impl Into<Arc<Geometry>>,
        skin: impl Into<Skin>,
        place: impl Into<Transform>,
    ) -> Result<Entity, SceneError> {
        let (mesh, skin, place) = (Mesh(geometry.into()), skin.into(), place.into());
        self.called("mesh", name, |world, name| world.put_mesh(name, mesh, skin, place))
    }

    /// Adds an analytic sphere about the origin of its place, of a material of this world.
    ///
    /// # Errors
    /// When the radius is not greater than zero, the transform is singular or would make it an
    /// ellipsoid, or the skin does not go together.
    pub fn add_sphere(
        &mut self,
        name: &str,
        radius: f64,
        skin: impl Into<Skin>,
        place: impl Into<Transform>,
    ) -> Result<Entity, SceneError> {
        let (ball, skin, place) = (Ball { radius }, skin.into(), place.into());
        self.called("sphere", name, |world, name| world.put_ball(name, ball, skin, place))
    }

    /// Adds a light without extent, that shines along the -z axis of its place.
    ///
    /// # Errors
    /// When its intensity or its cone is not physical, or the transform is singular.
    pub fn add_light(
        &mut self,
        name: &str,
        light: Punctual,
        place: impl Into<Transform>,
    ) -> Result<Entity, SceneError> {
        let place = place.into();
        self.called("light", name, |world, name| world.put_light(name, light, place))
    }

    /// Adds a medium, which fills nothing yet.
    ///
    /// # Errors
    /// When a value is not physical.
    pub fn add_medium(
        &mut self,
        name: &str,
        medium: impl Into<Medium>,
    ) -> Result<Entity, SceneError> {
        self.called("medium", name, |world, name| world.put_medium(name, medium.into()))
    }

    /// Puts the camera in its place: the only one, in place of that which was there, with its
    /// resolution and analyzer; those of the new one are to be set anew.
    ///
    /// # Errors
    /// When the projection is none, or the place is sheared, mirrored or singular.
    pub fn set_camera(
        &mut self,
        name: &str,
        lens: Lens,
        place: impl Into<Transform>,
    ) -> Result<Entity, SceneError> {
        let place = place.into();
        let camera = self.called("camera", name, |world, name| {
            world.put_camera(name, lens, place, Film::default())
        })?;
        self.keep_only::<Lens>(camera);
        Ok(camera)
    }

    /// Has the camera ask for a film size: width and height in pixels, from 1 to 65,535.
    ///
    /// # Errors
    /// When there is no camera, or a side is out of range.
    pub fn set_resolution(&mut self, resolution: [u32; 2]) -> Result<(), SceneError> {
        let (camera, name) = self.camera("resolution")?;
        let resolution = Resolution(resolution);
        resolution.check().map_err(|fault| SceneError::at(&name.0, fault))?;
        self.insert(camera, resolution);
        Ok(())
    }

    /// Says how the pixels of the film see where a render does not: their filter, which of them are
    /// rendered, and their shape.
    ///
    /// # Errors
    /// When there is no camera, or its resolution does not go with that.
    pub fn set_raster(&mut self, raster: Raster) -> Result<(), SceneError> {
        let (camera, name) = self.camera("raster")?;
        let resolution = self.entities.get::<&Resolution>(camera).ok().map(|it| *it);
        raster.check(resolution).map_err(|fault| SceneError::at(&name.0, fault))?;
        self.insert(camera, raster);
        Ok(())
    }

    /// Puts an ideal analyzer before the film, in the film's frame, in place of that which was
    /// there; or none: the image is then of the light as it comes. In scalar mode it lets half of
    /// all light pass.
    ///
    /// # Errors
    /// When there is no camera, or an axis is not finite.
    pub fn set_analyzer(&mut self, analyzer: Option<Analyzer>) -> Result<(), SceneError> {
        let (camera, name) = self.camera("analyzer")?;
        let Some(analyzer) = analyzer else {
            // There is nothing to remove where there was none.
            let _ = self.entities.remove_one::<Analyzer>(camera);
            return Ok(());
        };
        analyzer.check().map_err(|fault| SceneError::at(&name.0, fault.within("analyzer")))?;
        self.insert(camera, analyzer);
        Ok(())
    }

    /// The camera, which is to get something of this name.
    fn camera(&self, part: &str) -> Result<(Entity, Name), SceneError> {
        let cameras =
            self.in_order::<(Entity, &Name, &Lens), _>(|(camera, name, _)| (camera, name.clone()));
        cameras
            .into_iter()
            .next()
            .ok_or_else(|| SceneError::new(part, "the world has no camera", "set the camera first"))
    }

    /// Has light of a radiance in W/(m^2 sr) come from everywhere outside the scene, in place of
    /// what came from there.
    ///
    /// # Errors
    /// When the radiance is negative or not finite.
    pub fn set_environment(&mut self, radiance: impl Into<Spectrum>) -> Result<Entity, SceneError> {
        self.set_sky(radiance, Vec3::ZERO)
    }

    /// The same for a sky that is brighter on one side: from the direction d of world space comes
    /// the radiance times 1 + d . gradient.
    ///
    /// # Errors
    /// As [`World::set_environment`], and when the gradient is longer than 1.
    pub fn set_sky(
        &mut self,
        radiance: impl Into<Spectrum>,
        gradient: Vec3,
    ) -> Result<Entity, SceneError> {
        self.replace_environment(Environment { gradient, ..Environment::constant(radiance) })
    }

    /// The same for what a picture of all directions says: the bytes of an OpenEXR, Radiance, PNG,
    /// JPEG or WebP file (these three as sRGB), equirectangular, times a factor. In its own space
    /// its middle shows +x, right of that lies +z, and the upper edge is +y; the rotation turns
    /// that to world space.
    ///
    /// # Errors
    /// When the picture cannot be read or has negative or infinite values, the factor is negative
    /// or not finite, or the rotation is none.
    pub fn set_environment_map(
        &mut self,
        bytes: &[u8],
        factor: [f32; 3],
        rotation: DQuat,
    ) -> Result<Entity, SceneError> {
        let picture = Arc::new(Picture::around(bytes, "environment")?);
        let backdrop = Some(Backdrop { picture, rotation, source: BackdropSource::Memory });
        self.replace_environment(Environment { backdrop, ..Environment::constant(factor) })
    }

    /// The same for a clear sky, which is polarized, times a factor.
    ///
    /// # Errors
    /// When the sun is not above the horizon, the turbidity or the degree of polarization is out of
    /// range, or the factor is negative or not finite.
    pub fn set_clear_sky(&mut self, sky: ClearSky, factor: f32) -> Result<Entity, SceneError> {
        sky.check().map_err(|fault| SceneError::at("environment", fault))?;
        let backdrop = Some(sky.into());
        self.replace_environment(Environment { backdrop, ..Environment::constant(factor) })
    }

    fn replace_environment(&mut self, environment: Environment) -> Result<Entity, SceneError> {
        let name = Name("environment".to_owned());
        let added = self.put_environment(name, environment);
        let added = added.map_err(|fault| SceneError::at("environment", fault))?;
        self.keep_only::<Environment>(added);
        Ok(added)
    }

    /// Fills the scene outside all boundaries with a medium of this world, or with none.
    ///
    /// # Errors
    /// When the entity is not a medium of this world.
    pub fn set_scene_medium(
        &mut self,
        medium: impl Into<Option<Entity>>,
    ) -> Result<(), SceneError> {
        let medium = medium.into();
        if let Some(medium) = medium {
            self.check_medium("medium", medium).map_err(|fault| SceneError::at("scene", fault))?;
        }
        for filling in self.in_order::<(Entity, &FillsScene), _>(|(filling, _)| filling) {
            // It has just been found, so this cannot fail.
            let _ = self.entities.remove_one::<FillsScene>(filling);
        }
        if let Some(medium) = medium {
            self.insert(medium, FillsScene);
        }
        Ok(())
    }

    /// Adds with a name in the words of programs, which errors get.
    fn called(
        &mut self,
        kind: &str,
        name: &str,
        put: impl FnOnce(&mut Self, Name) -> Result<Entity, Fault>,
    ) -> Result<Entity, SceneError> {
        let name = match name {
            "" => format!("{kind} {}", self.order + 1),
            name => format!("{kind} `{name}`"),
        };
        put(self, Name(name.clone())).map_err(|fault| SceneError::at(&name, fault))
    }

    /// Removes all entities with a component but one.
    fn keep_only<T: hecs::Component>(&mut self, kept: Entity) {
        for other in self.in_order::<(Entity, &T), _>(|(entity, _)| entity) {
            if other != kept {
                // It has just been found, so this cannot fail.
                let _ = self.entities.despawn(other);
            }
        }
    }
}

/// What readers of files add, with the names and orders of their own. All return the fault of a
/// field, and readers know where in the file that stands.
impl World {
    pub(in crate::scene) fn put_material(
        &mut self,
        name: Name,
        Material { bsdf, sides, emission }: Material,
    ) -> Result<Entity, Fault> {
        check_material(&bsdf, emission.as_ref())?;
        Ok(match emission {
            Some(emission) => self.spawn(name, (bsdf, sides, emission)),
            None => self.spawn(name, (bsdf, sides)),
        })
    }

    pub(in crate::scene) fn put_mesh(
        &mut self,
        name: Name,
        mesh: Mesh,
        skin: Skin,
        place: Transform,
    ) -> Result<Entity, Fault> {
        place.check()?;
        self.check_skin(&MadeOf(skin.material), &skin.boundary)?;
        self.check_once(&name, &mesh.0)?;
        self.check_painted(skin.material, &mesh.0)?;
        Ok(self.spawn(name, (place, mesh, MadeOf(skin.material), skin.boundary)))
    }

    pub(in crate::scene) fn put_ball(
        &mut self,
        name: Name,
        ball: Ball,
        skin: Skin,
        place: Transform,
    ) -> Result<Entity, Fault> {
        ball.check()?;
        Ball::check_place(&place)?;
        self.check_skin(&MadeOf(skin.material), &skin.boundary)?;
        Ok(self.spawn(name, (place, ball, MadeOf(skin.material), skin.boundary)))
    }

    pub(in crate::scene) fn put_light(
        &mut self,
        name: Name,
        light: Punctual,
        place: Transform,
    ) -> Result<Entity, Fault> {
        place.check()?;
        light.check()?;
        Ok(self.spawn(name, (place, light)))
    }

    pub(in crate::scene) fn put_medium(
        &mut self,
        name: Name,
        medium: Medium,
    ) -> Result<Entity, Fault> {
        medium.check()?;
        Ok(self.spawn(name, (medium,)))
    }

    /// Adds a camera to those that are there.
    pub(in crate::scene) fn put_camera(
        &mut self,
        name: Name,
        lens: Lens,
        place: Transform,
        Film { resolution, raster, analyzer }: Film,
    ) -> Result<Entity, Fault> {
        Lens::check_place(&place)?;
        lens.check()?;
        resolution.map_or(Ok(()), Resolution::check)?;
        raster.check(resolution).map_err(|fault| fault.within("film"))?;
        let checked = analyzer.map_or(Ok(()), Analyzer::check);
        checked.map_err(|fault| fault.within("film.analyzer"))?;
        let camera = self.spawn(name, (place, lens));
        resolution.into_iter().for_each(|resolution| self.insert(camera, resolution));
        analyzer.into_iter().for_each(|analyzer| self.insert(camera, analyzer));
        if !raster.is_plain() {
            self.insert(camera, raster);
        }
        Ok(camera)
    }

    /// Adds an environment to those that are there.
    pub(in crate::scene) fn put_environment(
        &mut self,
        name: Name,
        environment: Environment,
    ) -> Result<Entity, Fault> {
        environment.check()?;
        Ok(self.spawn(name, (environment,)))
    }

    /// Has a material emit by its heat.
    pub(in crate::scene) fn put_incandescent(&mut self, material: Entity) -> Result<(), Fault> {
        let Ok(bsdf) = self.entities.get::<&Bsdf>(material) else {
            let remedy = "use one that `add_material` returned";
            return Err(Fault::new("material", "is not a material of this world", remedy));
        };
        let emission = self.entities.get::<&Emission>(material).ok();
        let stokes = self.entities.get::<&EmittedStokes>(material).ok();
        let textures = self.entities.get::<&Textures>(material).ok();
        Incandescent::check(&bsdf, emission.as_deref(), stokes.as_deref(), textures.as_deref())?;
        drop((bsdf, emission, stokes, textures));
        self.insert(material, Incandescent);
        Ok(())
    }

    /// Adds a state of polarization to what emits.
    pub(in crate::scene) fn put_stokes(
        &mut self,
        emitter: Entity,
        stokes: EmittedStokes,
    ) -> Result<(), Fault> {
        stokes.check()?;
        type Emitting<'a> = hecs::Or<hecs::Or<&'a Emission, &'a Punctual>, &'a Environment>;
        if !self.entities.satisfies::<Emitting>(emitter) {
            return Err(EmittedStokes::without_emission());
        }
        if self.entities.get::<&Environment>(emitter).is_ok_and(|sky| sky.is_polarized()) {
            return Err(Environment::polarized_twice());
        }
        self.insert(emitter, stokes);
        Ok(())
    }

    /// Drops triangles without area from a geometry, checks the others, and keeps in mind that it
    /// is as it should be if any are left. Returns it and how many were dropped.
    pub(in crate::scene) fn cleaned(
        &mut self,
        mut geometry: Geometry,
    ) -> Result<(Arc<Geometry>, usize), Fault> {
        let dropped = geometry.clean()?;
        let geometry = Arc::new(geometry);
        self.keep_in_mind(&geometry);
        Ok((geometry, dropped))
    }

    /// Checks a geometry that has not been seen before, and says what will be mended in it.
    fn check_once(&mut self, name: &Name, geometry: &Arc<Geometry>) -> Result<(), Fault> {
        if self.is_checked(geometry) {
            return Ok(());
        }
        geometry.check()?;
        self.keep_in_mind(geometry);
        let behind = geometry.corners_behind();
        if behind > 0 {
            self.warnings.push(format!(
                "{}: {behind} corners have a normal on the back of their triangle (or none); it \
                 is mirrored to the front",
                name.0
            ));
        }
        Ok(())
    }

    /// Takes notice that a geometry is as it should be.
    pub(in crate::scene) fn keep_in_mind(&mut self, geometry: &Arc<Geometry>) {
        self.checked.insert(Arc::as_ptr(geometry).addr(), Arc::downgrade(geometry));
    }

    fn spawn(&mut self, name: Name, components: impl DynamicBundle) -> Entity {
        self.order += 1;
        let mut entity = EntityBuilder::new();
        entity.add(Order(self.order)).add(name).add_bundle(components);
        self.entities.spawn(entity.build())
    }

    pub(super) fn insert(&mut self, entity: Entity, component: impl hecs::Component) {
        // Callers have just found it, so this cannot fail.
        let _ = self.entities.insert_one(entity, component);
    }
}
