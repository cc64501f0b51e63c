//! Worlds made in code. What they are made of is kept by `sunstone/_world.py`, which makes them
//! anew when one is placed and goes on.

use std::collections::HashMap;

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sunstone::glam::{DQuat, DVec3};
use sunstone::hecs::Entity;
use sunstone::internals::math::text::sentence;
use sunstone::world::{
    ClearSky, EmittedStokes, Falloff, Filling, Lens, Photometry, Punctual, PunctualKind, Skin,
};

use crate::errors::{SCENE_ERROR, of_any};
use crate::geometry::Geometry;
use crate::keys::{Keys, extract};
use crate::place::{looking, place};
use crate::scene::Scene;
use crate::spectra::{lamp, stokes};
use crate::{material, medium};

/// Kinds of lights.
const LIGHTS: &str = "use one of directional, point, spot";

/// How a spot falls off.
fn falloff(keys: &Keys) -> PyResult<Falloff> {
    let Some(name) = keys.take::<String>("falloff")? else { return Ok(Falloff::default()) };
    let found = Falloff::ALL.into_iter().find(|falloff| falloff.name() == name);
    found.ok_or_else(|| keys.refuse("falloff", &format!("`{name}` is not known"), "cosine, angle"))
}

/// A world that things are added to, until it is placed.
#[pyclass(module = "sunstone._sunstone")]
pub struct World {
    world: Option<sunstone::World>,
    materials: HashMap<String, Entity>,
    media: HashMap<String, Entity>,
}

#[pymethods]
impl World {
    /// An empty one.
    #[new]
    fn new(name: String) -> Self {
        let world = Some(sunstone::World::new(name));
        Self { world, materials: HashMap::new(), media: HashMap::new() }
    }

    /// Adds a material.
    fn add_material(&mut self, name: &str, keys: &Bound<PyDict>) -> PyResult<()> {
        let place = free_place("material", name, &self.materials)?;
        let made = material::material(Keys::of(place, keys)?)?;
        let material::Made { material, stokes, incandescent, textures } = made;
        let entity = self.world()?.add_material(name, material).map_err(of_any)?;
        if !textures.is_empty() {
            self.world()?.set_textures(entity, textures).map_err(of_any)?;
        }
        self.polarize(entity, stokes)?;
        if incandescent {
            self.world()?.set_incandescent(entity).map_err(of_any)?;
        }
        self.materials.insert(name.to_owned(), entity);
        Ok(())
    }

    /// Adds a medium.
    fn add_medium(&mut self, name: &str, keys: &Bound<PyDict>) -> PyResult<()> {
        let place = free_place("medium", name, &self.media)?;
        let medium = medium::medium(Keys::of(place, keys)?)?;
        let entity = self.world()?.add_medium(name, medium).map_err(of_any)?;
        self.media.insert(name.to_owned(), entity);
        Ok(())
    }

    /// Adds a mesh.
    fn add_mesh(
        &mut self,
        name: &str,
        geometry: &Bound<PyAny>,
        keys: &Bound<PyDict>,
    ) -> PyResult<()> {
        let keys = Keys::of(format!("mesh `{name}`"), keys)?;
        let Ok(geometry) = geometry.cast::<Geometry>() else {
            let what = geometry.get_type();
            let what = format!("must be a Geometry, not a {}", what.name()?);
            return Err(PyTypeError::new_err(sentence(&keys.place_of("geometry"), &what)));
        };
        let (skin, place) = (self.skin(&keys)?, place(&keys)?);
        keys.finish("a mesh")?;
        let geometry = std::sync::Arc::clone(&geometry.get().0);
        self.world()?.add_mesh(name, geometry, skin, place).map(drop).map_err(of_any)
    }

    /// Adds a sphere.
    fn add_sphere(
        &mut self,
        name: &str,
        radius: &Bound<PyAny>,
        keys: &Bound<PyDict>,
    ) -> PyResult<()> {
        let keys = Keys::of(format!("sphere `{name}`"), keys)?;
        let radius = extract(&keys.place_of("radius"), radius)?;
        let (skin, place) = (self.skin(&keys)?, place(&keys)?);
        keys.finish("a sphere")?;
        self.world()?.add_sphere(name, radius, skin, place).map(drop).map_err(of_any)
    }

    /// Adds a light without extent.
    fn add_light(&mut self, name: &str, keys: &Bound<PyDict>) -> PyResult<()> {
        let keys = Keys::of(format!("light `{name}`"), keys)?;
        let kind: String = keys.need("kind", LIGHTS)?;
        let remedy = "W/sr, or W/m^2 if directional";
        let missing = || keys.refuse("intensity", "is missing", remedy);
        let intensity = keys.lamp("intensity")?.ok_or_else(missing)?;
        let light = match kind.as_str() {
            "directional" => match keys.take("angular_diameter")? {
                Some(diameter) => Punctual::sun(intensity, diameter),
                None => Punctual::directional(intensity),
            },
            "point" => Punctual::point(intensity),
            "spot" => {
                let outer = keys.need("outer", "give the half angle of the cone in radians")?;
                let inner = keys.take("inner")?.unwrap_or(0.0);
                let falloff = falloff(&keys)?;
                Punctual { kind: PunctualKind::Spot { inner, outer, falloff }, intensity }
            }
            kind => {
                let problem = format!("`{kind}` is not a kind of light");
                return Err(keys.refuse("kind", &problem, LIGHTS));
            }
        };
        let (ies, picture) = match kind.as_str() {
            "point" => (keys.take::<Vec<u8>>("ies")?, None),
            "spot" => (None, keys.take::<Vec<u8>>("picture")?),
            _ => (None, None),
        };
        let measured = ies.map(|file| {
            let text = String::from_utf8_lossy(&file);
            let read = Photometry::from_ies(&text);
            read.map_err(|fault| keys.refuse("ies", &fault.to_string(), ""))
        });
        let measured = measured.transpose()?;
        let stokes = keys.stokes("stokes")?;
        let place = looking(&keys)?;
        keys.finish(&format!("a light of kind \"{kind}\""))?;
        let world = self.world()?;
        let entity = world.add_light(name, light, place).map_err(of_any)?;
        if let Some(measured) = measured {
            world.set_luminaire(entity, measured).map_err(of_any)?;
        }
        if let Some(picture) = picture {
            world.set_projection(entity, &picture).map_err(of_any)?;
        }
        self.polarize(entity, stokes)
    }

    /// Sets the camera.
    fn set_camera(&mut self, name: &str, keys: &Bound<PyDict>) -> PyResult<()> {
        let keys = Keys::of(format!("camera `{name}`"), keys)?;
        let lens = lens(&keys)?;
        let resolution: Option<[u32; 2]> = keys.take("resolution")?;
        let place = looking(&keys)?;
        keys.finish("such a camera")?;
        let world = self.world()?;
        world.set_camera(name, lens, place).map_err(of_any)?;
        match resolution {
            Some(resolution) => world.set_resolution(resolution).map_err(of_any),
            None => Ok(()),
        }
    }

    /// Sets the environment.
    fn set_environment(
        &mut self,
        radiance: &Bound<PyAny>,
        state: Option<&Bound<PyAny>>,
    ) -> PyResult<()> {
        let radiance = lamp("environment, radiance", radiance)?;
        let state = state.map(|state| stokes("environment, stokes", state)).transpose()?;
        let entity = self.world()?.set_environment(radiance).map_err(of_any)?;
        self.polarize(entity, state)
    }

    /// Sets the environment by the bytes of a picture.
    fn set_environment_map(
        &mut self,
        picture: &[u8],
        factor: [f32; 3],
        rotation: [f64; 4],
    ) -> PyResult<()> {
        let rotation = DQuat::from_array(rotation);
        let entity = self.world()?.set_environment_map(picture, factor, rotation);
        entity.map(drop).map_err(of_any)
    }

    /// Sets the environment to a clear sky.
    fn set_clear_sky(&mut self, sun: [f64; 3], shape: [f64; 2], factor: f32) -> PyResult<()> {
        let [turbidity, max_degree] = shape;
        let sky = ClearSky { sun: DVec3::from_array(sun), turbidity, max_degree };
        self.world()?.set_clear_sky(sky, factor).map(drop).map_err(of_any)
    }

    /// Fills what is outside all boundaries.
    fn set_scene_medium(&mut self, name: Option<&str>) -> PyResult<()> {
        let medium = name.map(|name| find("scene, medium", "medium", name, &self.media));
        let medium = medium.transpose()?;
        self.world()?.set_scene_medium(medium).map_err(of_any)
    }

    /// What of it is not rendered as it was described.
    #[getter]
    fn warnings(&mut self) -> PyResult<Vec<String>> {
        Ok(self.world()?.warnings().to_vec())
    }

    /// Places the world, which is gone then; with the tree of another scene if that is the same.
    fn place(&mut self, py: Python, beside: Option<&Scene>) -> PyResult<Scene> {
        match (self.world.take(), beside) {
            (Some(world), Some(beside)) => beside.beside(py, world),
            (Some(world), None) => crate::scene::place(py, world),
            (None, _) => Err(gone()),
        }
    }
}

impl World {
    fn world(&mut self) -> PyResult<&mut sunstone::World> {
        self.world.as_mut().ok_or_else(gone)
    }

    /// Has what was just added emit in a state.
    fn polarize(&mut self, emitter: Entity, stokes: Option<EmittedStokes>) -> PyResult<()> {
        let Some(stokes) = stokes else { return Ok(()) };
        self.world()?.set_emitted_stokes(emitter, stokes).map_err(of_any)
    }

    /// What a shape is made of, and what is on its two sides.
    fn skin(&self, keys: &Keys) -> PyResult<Skin> {
        let material: String = keys.need("material", "give the name of a material")?;
        let place = keys.place_of("material");
        let mut skin = Skin::from(find(&place, "material", &material, &self.materials)?);
        skin.boundary.interior = self.filling(keys, "interior")?;
        skin.boundary.exterior = self.filling(keys, "exterior")?;
        skin.boundary.priority = keys.take("priority")?.unwrap_or(0);
        Ok(skin)
    }

    /// What is on a side: the name of a medium, or an empty one for nothing.
    fn filling(&self, keys: &Keys, side: &str) -> PyResult<Option<Filling>> {
        let Some(name) = keys.take::<String>(side)? else { return Ok(None) };
        if name == "none" && !self.media.contains_key("none") {
            return Ok(Some(Filling::Clear));
        }
        find(&keys.place_of(side), "medium", &name, &self.media).map(|medium| Some(medium.into()))
    }
}

fn gone() -> PyErr {
    SCENE_ERROR.says("the world has been placed")
}

/// What errors call a new object, whose name nobody has.
fn free_place(kind: &str, name: &str, known: &HashMap<String, Entity>) -> PyResult<String> {
    let place = format!("{kind} `{name}`");
    let refuse = |problem: &str| Err(SCENE_ERROR.says(sentence(&place, problem)));
    match (name.is_empty(), known.contains_key(name)) {
        (true, _) => refuse("needs a name, by which others find it"),
        (_, true) => refuse("there is one of this name already"),
        (false, false) => Ok(place),
    }
}

fn find(place: &str, kind: &str, name: &str, known: &HashMap<String, Entity>) -> PyResult<Entity> {
    known.get(name).copied().ok_or_else(|| {
        let mut names: Vec<&str> = known.keys().map(String::as_str).collect();
        names.sort_unstable();
        let names = if names.is_empty() { "none yet".to_owned() } else { names.join(", ") };
        SCENE_ERROR.says(format!("{place}: there is no {kind} `{name}`; there are: {names}"))
    })
}

fn lens(keys: &Keys) -> PyResult<Lens> {
    let yfov: Option<f64> = keys.take("yfov")?;
    let aspect: Option<f32> = keys.take("aspect")?;
    let half: [Option<f32>; 2] = [keys.take("half_width")?, keys.take("half_height")?];
    match (yfov, half) {
        (Some(yfov), [None, None]) => Ok(Lens::Perspective {
            yfov,
            aspect,
            aperture_radius: keys.take("aperture_radius")?.unwrap_or(0.0),
            focus_distance: keys.take("focus_distance")?.unwrap_or(1.0),
        }),
        (None, [Some(half_width), Some(half_height)]) if aspect.is_none() => {
            Ok(Lens::Orthographic { half_width, half_height })
        }
        _ => {
            let problem = "takes either `yfov` or both `half_width` and `half_height`";
            Err(keys.refuse("", problem, "yfov is the vertical angle of view in radians"))
        }
    }
}
