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
mod grid;
mod held;
mod media;
mod optics;
mod origin;
mod phase;
mod primitives;
mod sharing;

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use hecs::Entity;

use super::baked::{
    self, BakedScene, Bounds, Camera, KEEP, Material, NONE, Optics, Projection, Shapes,
};
use super::emitted::EmittedStates;
use super::error::SceneError;
use super::painting::Painting;
use super::warnings::Warnings;
use super::world::{
    Bsdf, FillsScene, Lens, Medium, Name, Raster, Resolution, Sides, SurfaceModel, Textures,
    Transform, Window, World,
};
use crate::math::elementary::tan;
use crate::polarization::Analyzer;
use crate::spectrum::{Beyond, Carried, OutsideTable, Role, Spectrum, White};

use self::beside::Passable;
pub use self::emitters::{Brightness, Emitters, Lamp, lamps};
pub use self::grid::Suspensions;
pub use self::held::held;
use self::origin::Center;
use self::primitives::Placed;

/// Shapes and optics in one.
///
/// # Errors
/// Those of [`bake_shapes`] and [`bake_optics`].
pub fn bake<const N: usize>(
    world: &World,
    carried: &Carried<N>,
) -> Result<BakedScene<N>, SceneError> {
    let shapes = bake_shapes(&plan_shapes(world)?)?;
    let camera = bake_camera(world, &shapes)?;
    let optics = bake_optics(world, &shapes, carried)?;
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

/// Evaluates materials, media and emitters at what light is carried at; `shapes` are those of the
/// same world.
///
/// # Errors
/// When the world is not as it should be ([`World::check`]), a spectrum does not cover the
/// wavelengths and is not held beyond its ends, nothing emits, or a medium lets no light in.
pub fn bake_optics<const N: usize>(
    world: &World,
    shapes: &Shapes,
    carried: &Carried<N>,
) -> Result<Optics<N>, SceneError> {
    optics_of(world, shapes, carried).map_err(|error| error.in_file(&world.file))
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
        corners: primitives.corners,
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
    carried: &Carried<N>,
) -> Result<Optics<N>, SceneError> {
    world.check()?;
    let held = held(world, carried)?;
    let materials = material_rows(world, shapes, carried)?;
    let media = media::media(world, carried, None)?;
    let lamps = emitters::lamps(world);
    let states = emitters::states(&lamps, carried, emitters::has_polarized_picture(world))?;
    let lamps = emitters::radiance(&lamps, carried)?;
    let brightness: Vec<Brightness> = lamps.iter().map(Brightness::of_columns).collect();
    let emitters = emitters::emitters(world, shapes, &brightness)?;
    media::check_lights(world, &media, shapes.scene_medium, &emitters)?;
    let painting = painting(world, carried).map(Arc::new);
    let optics = with_emitters(materials, media, lamps, (emitters, carried));
    Ok(Optics { held, painting, states, ..optics })
}

/// Refuses spectra that do not cover the wavelengths of a render, or says which are held beyond
/// their ends, one sentence each.
///
/// # Errors
/// With the first that is not held.
pub fn held_spectra<const N: usize>(
    world: &World,
    carried: &Carried<N>,
) -> Result<Vec<String>, SceneError> {
    held(world, carried).map_err(|error| error.in_file(&world.file))
}

/// Places all that emits, each as bright as its lamp is on the whole ([`lamps`]).
///
/// # Errors
/// When nothing emits.
pub fn bake_emitters(
    world: &World,
    shapes: &Shapes,
    brightness: &[Brightness],
) -> Result<Emitters, SceneError> {
    let emitters = emitters::emitters(world, shapes, brightness);
    emitters.map_err(|error| error.in_file(&world.file))
}

/// What each lamp emits at wavelengths in nanometers, by a white and by what is beyond the ends of
/// tables; nothing if it is black.
///
/// # Errors
/// When a table does not cover them.
pub fn bake_emission(
    world: &World,
    lamps: &[Lamp],
    wavelengths_nm: &[f64],
    by: (White, Beyond),
) -> Result<Vec<Vec<f64>>, SceneError> {
    let emitted: Result<_, SceneError> =
        lamps.iter().map(|lamp| lamp.emitted(wavelengths_nm, by)).collect();
    emitted.map_err(|error| error.in_file(&world.file))
}

/// What is the same at all wavelengths of a range.
#[derive(Debug)]
pub struct Common {
    /// What emits, by its spectra ([`lamps`]).
    pub lamps: Vec<Lamp>,
    /// Media of particles.
    pub suspensions: Suspensions,
}

/// Evaluates a world that has been checked at some wavelengths of a range, of which more is known.
/// None of this takes longer for more triangles.
///
/// # Errors
/// When a spectrum's table does not cover the wavelengths, or a medium lets no light in.
pub fn bake_optics_at<const N: usize>(
    world: &World,
    shapes: &Shapes,
    carried: &Carried<N>,
    common: &Common,
    emitters: Emitters,
) -> Result<Optics<N>, SceneError> {
    let bake = || {
        let materials = material_rows(world, shapes, carried)?;
        let media = media::media(world, carried, Some(&common.suspensions))?;
        let states =
            emitters::states(&common.lamps, carried, emitters::has_polarized_picture(world))?;
        let lamps = emitters::radiance(&common.lamps, carried)?;
        media::check_lights(world, &media, shapes.scene_medium, &emitters)?;
        let painting = painting(world, carried).map(Arc::new);
        let optics = with_emitters(materials, media, lamps, (emitters.clone(), carried));
        Ok(Optics { painting, states, ..optics })
    };
    bake().map_err(|error: SceneError| error.in_file(&world.file))
}

fn with_emitters<const N: usize>(
    materials: Vec<Material<N>>,
    media: Vec<baked::Medium<N>>,
    lamps: Vec<[f32; N]>,
    (emitters, carried): (Emitters, &Carried<N>),
) -> Optics<N> {
    let Emitters { rows: emitters, patterns, emitter_of_primitive, skies } = emitters;
    Optics {
        materials,
        media,
        emitters,
        lamps,
        states: EmittedStates::default(),
        patterns,
        emitter_of_primitive,
        skies,
        carried: *carried,
        painting: None,
        held: Vec::new(),
    }
}

/// The textures of the materials, in the order of these.
fn painting<const N: usize>(world: &World, carried: &Carried<N>) -> Option<Painting<N>> {
    let of_material = world.in_order::<(&Bsdf, Option<&Textures>), _>(|(_, textures)| {
        textures.filter(|textures| !textures.is_empty()).cloned()
    });
    Painting::new(of_material, carried)
}

/// All materials, with air where bodies overlap; at least one.
fn material_rows<const N: usize>(
    world: &World,
    shapes: &Shapes,
    carried: &Carried<N>,
) -> Result<Vec<Material<N>>, SceneError> {
    let mut rows = materials(world, carried)?;
    let has_air = shapes.surfaces.iter().any(|it| it.nested_material as usize == rows.len());
    if has_air && !rows.is_empty() {
        // In the table of the others.
        let disperses =
            |row: &Material<N>| matches!(row.model, SurfaceModel::DispersiveDielectric { .. });
        let model = match rows.iter().any(disperses) {
            false => SurfaceModel::Dielectric { ior: 1.0, exterior_ior: 1.0 },
            true => SurfaceModel::DispersiveDielectric { ior: [1.0; N], exterior_ior: [1.0; N] },
        };
        rows.push(Material { model, two_sided: false });
    }
    Ok(if rows.is_empty() { vec![Material::absorber()] } else { rows })
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

fn materials<const N: usize>(
    world: &World,
    carried: &Carried<N>,
) -> Result<Vec<Material<N>>, SceneError> {
    type Parts<'a> = (&'a Name, &'a Bsdf, &'a Sides, Option<&'a Textures>);
    let rows = world.in_order::<Parts, _>(|(name, bsdf, sides, textures)| {
        let at_d = |spectrum: &Spectrum, _, nm| {
            let [index] =
                spectrum.sample(&Carried::at([nm]).beyond(carried.held_beyond()), Role::Index)?;
            Ok(index)
        };
        let model = match carried.is_rgb() {
            true => bsdf.undispersed(at_d),
            false => Ok(bsdf.clone()),
        };
        // At other wavelengths of the render it is of the same kind.
        let model = model.map(SurfaceModel::simplified);
        let sample = |spectrum: &Spectrum, _, role| spectrum.sample(carried, role);
        let model = model.and_then(|model| model.sampled(sample));
        let paint = |model| match textures {
            Some(textures) => Painting::mean_model(model, textures, carried),
            None => model,
        };
        let model = model.map(paint);
        let row = |model: SurfaceModel<[f32; N]>| Material {
            model: if carried.is_one_of_many() { model } else { model.simplified() },
            two_sided: sides.two_sided,
        };
        model.map(row).map_err(|error| outside_table(&name.0, error))
    });
    let mut rows = rows.into_iter().collect::<Result<Vec<_>, SceneError>>()?;
    let disperses = match carried.is_one_of_many() {
        true => world.disperses(),
        false => rows.iter().any(disperses_here),
    };
    make_alike(&mut rows, disperses);
    Ok(rows)
}

/// Whether light is refracted in other ways at some of these wavelengths.
fn disperses_here<const N: usize>(row: &Material<N>) -> bool {
    let differs = |of: &[f32; N]| of.iter().any(|ior| *ior != of[0]);
    matches!(&row.model, SurfaceModel::DispersiveDielectric { ior, exterior_ior }
        if differs(ior) || differs(exterior_ior))
}

/// Makes all dielectrics of one sort, as they may be nested: with dispersion if any has it, and
/// without else.
fn make_alike<const N: usize>(rows: &mut [Material<N>], disperses: bool) {
    for Material { model, .. } in rows {
        if disperses {
            if let SurfaceModel::Dielectric { ior, exterior_ior } = *model {
                let [ior, exterior_ior] = [ior, exterior_ior].map(|index| [index; N]);
                *model = SurfaceModel::DispersiveDielectric { ior, exterior_ior };
            }
        } else if let SurfaceModel::DispersiveDielectric { ior, exterior_ior } = *model {
            let plain = SurfaceModel::Dielectric { ior: ior[0], exterior_ior: exterior_ior[0] };
            *model = plain.simplified();
        }
    }
}

fn outside_table(place: &str, error: OutsideTable) -> SceneError {
    let remedy = "render within that, extend it, or hold what is at its ends (--hold-spectra); a \
                  lamp of [r, g, b] is known where rgb_white is";
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
    type Seen<'a> = (Option<&'a Analyzer>, Option<&'a Window>);
    type Film<'a> = (Option<&'a Resolution>, Option<&'a Raster>, Seen<'a>);
    type Components<'a> = (&'a Transform, &'a Lens, Film<'a>);
    let cameras = world.in_order::<Components, _>(
        |(place, lens, (resolution, raster, (analyzer, window)))| {
            let film = (resolution.copied(), raster.copied(), (analyzer.copied(), window.copied()));
            (*place, *lens, film)
        },
    );
    let Some((place, lens, (resolution, raster, (analyzer, window)))) = cameras.into_iter().next()
    else {
        return Err(SceneError::new("bake", "the world has no camera", "add one"));
    };
    // Rounded from orthonormal double-precision axes, hence orthonormal to the last bit of f32.
    let right = place.0.matrix3.x_axis.normalize();
    let up = place.0.matrix3.y_axis.reject_from_normalized(right).normalize();
    let projection = match lens {
        Lens::Perspective { yfov, aspect, aperture_radius, focus_distance } => {
            let tan_half_y = tan(0.5 * yfov) as f32;
            let tan_half_x_min = window.map_or(0.0, |window| window.tan_half_x);
            Projection::Perspective {
                tan_half_y,
                tan_half_x_min,
                aspect,
                aperture_radius,
                focus_distance,
            }
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
        raster: raster.unwrap_or_default(),
        analyzer,
    })
}
