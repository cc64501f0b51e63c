//! From the world to the tables: primitives -> bounds and the camera are the shapes, materials,
//! media -> emitters the optics.
//!
//! The order of every table follows the file's order alone, so that the same file gives the same
//! tables, bit for bit. What can still fail here is what depends on the wavelengths of the render
//! or on world space in `f32`.

mod apart;
mod beside;
mod bodies;
mod divide;
mod emitters;
mod media;
mod optics;
mod origin;
mod phase;
mod primitives;
mod sharing;

use std::collections::HashMap;
use std::path::PathBuf;

use glam::{DVec3, Vec3};
use hecs::Entity;

use super::baked::{BakedScene, Bounds, Camera, KEEP, Material, NONE, Optics, Projection, Shapes};
use super::error::SceneError;
use super::warnings::Warnings;
use super::world::{
    Bsdf, Emission, FillsScene, Lens, Medium, Name, Resolution, Sides, SurfaceModel, Transform,
    World,
};
use crate::math::elementary::tan;
use crate::polarization::Analyzer;
use crate::spectrum::{Asked, OutsideTable, Role, Spectrum};

use self::beside::Passable;
use self::origin::Center;
use self::primitives::Placed;

/// Shapes and optics in one.
///
/// # Errors
/// Those of [`bake_shapes`] and [`bake_optics`].
pub fn bake<const N: usize>(
    world: &World,
    asked: impl Into<Asked>,
) -> Result<BakedScene<N>, SceneError> {
    let shapes = bake_shapes(&plan_shapes(world)?)?;
    let camera = bake_camera(world, &shapes)?;
    let optics = bake_optics(world, &shapes, asked.into())?;
    Ok(BakedScene { shapes, camera, optics })
}

/// All that the shapes of a world are baked from: worlds whose plans are equal have the same
/// shapes, to the last bit. What a material does to light has no part in it, but for whether it
/// emits and what it lets through.
#[derive(Clone, PartialEq)]
pub struct Plan {
    center: Center,
    placed: Placed,
    /// Lights that have a place.
    lights: Vec<Vec3>,
    scene_medium: u32,
    /// For errors.
    file: PathBuf,
}

/// Gathers what shapes are baked from.
///
/// # Errors
/// When the world is not as it should be ([`World::check`]), or coordinates are out of range.
pub fn plan_shapes(world: &World) -> Result<Plan, SceneError> {
    plan(world).map_err(|error| error.in_file(&world.file))
}

/// Places all shapes in world space. Wavelengths have no part in it, nor has the camera, but for
/// where world space has its origin.
///
/// # Errors
/// When coordinates are out of range.
pub fn bake_shapes(plan: &Plan) -> Result<Shapes, SceneError> {
    shapes(plan).map_err(|error| error.in_file(&plan.file))
}

/// Places the camera among the shapes of the same world.
///
/// # Errors
/// When there is none.
pub fn bake_camera(world: &World, shapes: &Shapes) -> Result<Camera, SceneError> {
    let camera = camera(world, shapes.origin).map_err(|error| error.in_file(&world.file))?;
    let passable = Passable::at(&[camera.position], shapes);
    Ok(Camera { position: passable.before(camera.position), ..camera })
}

/// Evaluates materials, media and emitters for the color that is asked for. `N` is the number of
/// its channels; `shapes` are those of the same world.
///
/// # Errors
/// When the world is not as it should be ([`World::check`]), `N` does not fit, a spectrum's table
/// does not cover the wavelengths, nothing emits, or a medium lets no light in.
pub fn bake_optics<const N: usize>(
    world: &World,
    shapes: &Shapes,
    asked: Asked,
) -> Result<Optics<N>, SceneError> {
    optics_of(world, shapes, asked).map_err(|error| error.in_file(&world.file))
}

fn plan(world: &World) -> Result<Plan, SceneError> {
    world.check()?;
    let rows = Rows::of(world);
    let center = origin::center(world)?;
    Ok(Plan {
        center,
        placed: Placed::of(world, &rows, center.origin),
        lights: emitters::positions(world, center.origin),
        scene_medium: rows.scene_medium,
        file: world.file.clone(),
    })
}

fn shapes(plan: &Plan) -> Result<Shapes, SceneError> {
    let mut warnings = Warnings::default();
    let primitives = primitives::primitives(&plan.placed, plan.center.near, &mut warnings)?;
    let bounds = bounds(&plan.lights, &primitives)?;
    Ok(Shapes {
        triangles: primitives.triangles,
        shading_normals: primitives.shading_normals,
        spheres: primitives.spheres,
        instanced: primitives.instanced,
        surface_of_primitive: primitives.surface_of_primitive,
        surfaces: primitives.surfaces,
        bodies: Vec::new(),
        overlaps: false,
        are_bodies_all: false,
        solids: Vec::new(),
        around_solids: KEEP,
        scene_medium: plan.scene_medium,
        origin: plan.center.origin,
        warnings: warnings.sentences(),
        bounds,
    })
}

fn optics_of<const N: usize>(
    world: &World,
    shapes: &Shapes,
    asked: Asked,
) -> Result<Optics<N>, SceneError> {
    if N != asked.color.channels() {
        let problem =
            format!("{N} channels were asked for, but {:?} has another number", asked.color);
        return Err(SceneError::new("bake", problem, ""));
    }
    world.check()?;
    let mut materials = materials(world, asked)?;
    // Of air among other bodies.
    materials.radiance.push([0.0; N]);
    let media = media::media(world, asked)?;
    let emitters = emitters::emitters(world, asked, &materials, shapes)?;
    media::check_lights(world, &media, shapes.scene_medium, &emitters)?;
    let mut rows = materials.rows;
    let has_air = shapes.surfaces.iter().any(|it| it.nested_material as usize == rows.len());
    if has_air && !rows.is_empty() {
        let model = SurfaceModel::Dielectric { ior: 1.0, exterior_ior: 1.0 };
        rows.push(Material { model, two_sided: false });
    }
    Ok(Optics {
        materials: if rows.is_empty() { vec![Material::absorber()] } else { rows },
        media,
        emitters: emitters.rows,
        emitter_of_primitive: emitters.emitter_of_primitive,
        environment: emitters.environment,
    })
}

/// Which rows of the tables of materials and media the entities become.
struct Rows {
    materials: HashMap<Entity, u32>,
    media: HashMap<Entity, u32>,
    /// What fills the scene, or [`NONE`].
    scene_medium: u32,
}

impl Rows {
    fn of(world: &World) -> Self {
        let numbered = |entities: Vec<Entity>| entities.into_iter().zip(0..).collect();
        let media =
            world.in_order::<(Entity, &Medium, Option<&FillsScene>), _>(|(entity, _, fills)| {
                (entity, fills.is_some())
            });
        // Of several that do, the last.
        let filling = media.iter().rposition(|(_, fills)| *fills);
        Self {
            materials: numbered(world.in_order::<(Entity, &Bsdf), _>(|(entity, _)| entity)),
            media: numbered(media.into_iter().map(|(entity, _)| entity).collect()),
            scene_medium: filling.map_or(NONE, |row| row as u32),
        }
    }
}

impl Rows {
    /// The row behind those of the materials, for air among other bodies.
    fn air(&self) -> u32 {
        self.materials.len() as u32
    }
}

/// The material table.
struct Materials<const N: usize> {
    rows: Vec<Material<N>>,
    /// Emitted radiance of each row; zero if it does not emit.
    radiance: Vec<[f32; N]>,
}

fn materials<const N: usize>(world: &World, asked: Asked) -> Result<Materials<N>, SceneError> {
    type Components<'a> = (&'a Name, &'a Bsdf, &'a Sides, Option<&'a Emission>);
    let mut table = Materials { rows: Vec::new(), radiance: Vec::new() };
    let rows = world.in_order::<Components, _>(|(name, bsdf, sides, emission)| {
        let black = Spectrum::Constant(0.0);
        let radiance = emission.map_or(&black, |emission| &emission.radiance);
        let radiance = radiance.sample(asked, Role::Emission);
        let model = bsdf.sampled(|spectrum, role| spectrum.sample(asked, role));
        let row = model.and_then(|model| {
            let model = model.simplified();
            Ok((Material { model, two_sided: sides.two_sided }, radiance?))
        });
        row.map_err(|error| outside_table(&name.0, error))
    });
    for row in rows {
        let (material, radiance) = row?;
        table.rows.push(material);
        table.radiance.push(radiance);
    }
    Ok(table)
}

fn outside_table(place: &str, error: OutsideTable) -> SceneError {
    let remedy = "render within the table, or extend it";
    SceneError::new(place, format!("a spectrum does not cover the render: {error}"), remedy)
}

/// Greatest coordinate that tables may hold: squares of areas must still fit into an `f32`.
const COORDINATE_MAX: f64 = 1e9;

/// Refuses what is further out.
fn check_range(low: DVec3, high: DVec3, place: &str) -> Result<(), SceneError> {
    if low.abs().max(high.abs()).max_element() <= COORDINATE_MAX {
        return Ok(());
    }
    let problem = format!("coordinates reach beyond {COORDINATE_MAX:e}");
    Err(SceneError::new(place, problem, "scale the scene down"))
}

/// Sphere about the box of all primitives and of the lights that have a place. Its radius is a
/// little larger than half the diagonal, so that rounding leaves nothing outside.
fn bounds(lights: &[Vec3], primitives: &primitives::Primitives) -> Result<Bounds, SceneError> {
    const MARGIN: f64 = 1.0 + 1e-5;
    let mut low = DVec3::INFINITY;
    let mut high = DVec3::NEG_INFINITY;
    let mut add = |point: Vec3, radius: f32| {
        low = low.min(point.as_dvec3() - f64::from(radius));
        high = high.max(point.as_dvec3() + f64::from(radius));
    };
    for triangle in &primitives.triangles {
        triangle.corners.iter().for_each(|corner| add(*corner, 0.0));
    }
    primitives.spheres.iter().for_each(|sphere| add(sphere.center, sphere.radius));
    for instance in primitives.instanced.instances() {
        instance.bounds.iter().for_each(|corner| add(*corner, 0.0));
    }
    lights.iter().for_each(|position| add(*position, 0.0));
    if low.x > high.x {
        // Nothing but an environment or directional light.
        return Ok(Bounds { center: Vec3::ZERO, radius: 1.0 });
    }
    check_range(low, high, "bounds of the scene")?;
    let half = 0.5 * (high - low).length() * MARGIN;
    let radius = if half > 0.0 { half as f32 } else { 1.0 };
    Ok(Bounds { center: (0.5 * (low + high)).as_vec3(), radius: radius.max(f32::MIN_POSITIVE) })
}

fn camera(world: &World, origin: DVec3) -> Result<Camera, SceneError> {
    type Film<'a> = (Option<&'a Resolution>, Option<&'a Analyzer>);
    type Components<'a> = (&'a Transform, &'a Lens, Film<'a>);
    let cameras = world.in_order::<Components, _>(|(place, lens, (resolution, analyzer))| {
        (*place, *lens, (resolution.copied(), analyzer.copied()))
    });
    let Some((place, lens, (resolution, analyzer))) = cameras.into_iter().next() else {
        return Err(SceneError::new("bake", "the world has no camera", "add one"));
    };
    // Rounded from orthonormal double-precision axes, hence orthonormal to the last bit of f32.
    let right = place.0.matrix3.x_axis.normalize();
    let up = place.0.matrix3.y_axis.reject_from_normalized(right).normalize();
    let projection = match lens {
        Lens::Perspective { yfov, aspect, aperture_radius, focus_distance } => {
            let tan_half_y = tan(0.5 * yfov) as f32;
            Projection::Perspective { tan_half_y, aspect, aperture_radius, focus_distance }
        }
        Lens::Orthographic { half_width, half_height } => {
            Projection::Orthographic { half_width, half_height }
        }
    };
    Ok(Camera {
        projection,
        position: place.about(origin).translation.as_vec3(),
        right: right.as_vec3(),
        up: up.as_vec3(),
        forward: up.cross(right).as_vec3(),
        resolution: resolution.map(|Resolution(sides)| sides),
        analyzer,
    })
}
