//! Triangles and spheres in world space.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3, Vec4, Vec4Swizzles};
use hecs::Entity;

use super::apart::{Yields, set_apart};
use super::divide::divide;
use super::sharing::{instanced, shared};
use super::{Rows, check_range};
use crate::math::elementary::cbrt;
use crate::scene::baked::{KEEP, LEAST_COSINE, NONE, Sphere, Surface, Triangle};
use crate::scene::corners::{Corner, Corners, Needs};
use crate::scene::error::SceneError;
use crate::scene::instanced::Instanced;
use crate::scene::warnings::Warnings;
use crate::scene::world::{
    Ball, Boundary, Bsdf, Emission, Geometry, MadeOf, Mesh, Name, Passage, Sides, Textures,
    Transform, World,
};
use crate::spectrum::Spectrum;

/// Shading normals that are this close to the geometric one are the geometric one.
const FLAT_TOLERANCE: f32 = 1e-4;

/// Most triangles that a scene holds one by one: what a file of a few kilobytes can ask for must
/// not fill the memory.
const TRIANGLES_MAX: usize = 1 << 26;

/// The tables of primitives and their surfaces: see `Shapes`.
#[derive(Default)]
pub struct Primitives {
    pub triangles: Vec<Triangle>,
    pub shading_normals: Vec<[Vec3; 3]>,
    pub corners: Corners,
    pub spheres: Vec<Sphere>,
    pub instanced: Instanced,
    pub surface_of_primitive: Vec<u32>,
    pub surfaces: Vec<Surface>,
    /// How each surface gives way to others in its place.
    yields: Vec<Yields>,
}

/// All meshes and spheres in their places, before their triangles are.
#[derive(Clone, PartialEq)]
pub struct Placed {
    parts: Vec<Part>,
    balls: Vec<PlacedBall>,
}

/// A sphere in its place.
#[derive(Clone, PartialEq)]
struct PlacedBall {
    name: String,
    radius: f64,
    to_world: DAffine3,
    surface: (Surface, Yields),
}

/// The part of a mesh that has one material, in one place.
#[derive(Clone)]
pub struct Part {
    pub name: String,
    pub geometry: Arc<Geometry>,
    pub to_world: DAffine3,
    pub surface: (Surface, Yields),
    pub emits: bool,
    /// What its textures go by.
    pub needs: Needs,
}

impl PartialEq for Part {
    /// Geometries are the same if they are one: which of them are decides what is instanced.
    fn eq(&self, other: &Self) -> bool {
        let Self { name, geometry, to_world, surface, emits, needs } = self;
        Arc::ptr_eq(geometry, &other.geometry)
            && (name, to_world, surface, emits, needs)
                == (&other.name, &other.to_world, &other.surface, &other.emits, &other.needs)
    }
}

/// Triangles and the shading normals of their corners.
#[derive(Default)]
pub struct Triangles {
    pub rows: Vec<Triangle>,
    /// Those of flat triangles are zero until [`Triangles::finish_normals`].
    pub shading_normals: Vec<[Vec3; 3]>,
    /// What textures go by.
    pub paint: Corners,
}

impl Placed {
    /// Those of a world about an origin.
    pub fn of(world: &World, rows: &Rows, origin: DVec3) -> Self {
        type Shown<'a, Shape> = (&'a Name, &'a Transform, Shape, (&'a MadeOf, &'a Boundary));
        let parts = world.in_order::<Shown<&Mesh>, _>(|(name, at, mesh, (of, boundary))| {
            let surface = surface(world, rows, of.0, &at.0, boundary);
            let emits = world.entities().satisfies::<&Emission>(of.0);
            let (name, geometry) = (name.0.clone(), Arc::clone(&mesh.0));
            let needs = needs(world, of.0);
            Part { name, geometry, to_world: at.about(origin), surface, emits, needs }
        });
        let balls = world.in_order::<Shown<&Ball>, _>(|(name, at, ball, (of, boundary))| {
            let surface = surface(world, rows, of.0, &at.0, boundary);
            let (name, radius) = (name.0.clone(), ball.radius);
            PlacedBall { name, radius, to_world: at.about(origin), surface }
        });
        Self { parts, balls }
    }
}

/// The tables of all meshes and spheres; `near` are coordinates up to which triangles stay whole.
pub fn primitives(
    placed: &Placed,
    near: f32,
    warnings: &mut Warnings,
) -> Result<Primitives, SceneError> {
    let Placed { parts, balls } = placed.clone();
    let mut tables = Primitives::default();
    let instances = tables.add_parts(parts, near, warnings)?;
    for PlacedBall { name, radius, to_world, surface } in balls {
        let surface = tables.add_surface(surface);
        tables.surface_of_primitive.push(surface);
        let radius = (radius * to_world.matrix3.x_axis.length()) as f32;
        if !(radius >= f32::MIN_POSITIVE && radius.is_finite()) {
            let problem = format!("a radius of {radius} is out of range");
            return Err(SceneError::new(name, problem, "check its scale"));
        }
        tables.spheres.push(Sphere { center: to_world.translation.as_vec3(), radius });
    }
    let yields = std::mem::take(&mut tables.yields);
    set_apart(&mut tables, &yields);
    tables.instanced = instanced(&instances, tables.surface_of_primitive.len(), warnings)?;
    Ok(tables)
}

/// What the textures of a material go by, and its facets.
fn needs(world: &World, material: Entity) -> Needs {
    let textures = world.entities().get::<&Textures>(material);
    let needs = textures.map_or(Needs::default(), |textures| Needs::of(&textures));
    let bsdf = world.entities().get::<&Bsdf>(material);
    match bsdf.is_ok_and(|bsdf| bsdf.has_grain()) {
        true => needs.and(Needs::TO_THE_RIGHT),
        false => needs,
    }
}

/// How a tangent stands where the triangles of a mesh do.
fn along(tangent: Vec4, transform: impl Fn(DVec3) -> DVec3, mirrored: bool) -> Vec4 {
    let [tip, tail] = [tangent.xyz().as_dvec3(), DVec3::ZERO].map(transform);
    let side = if mirrored { -tangent.w } else { tangent.w };
    (tip - tail).normalize_or_zero().as_vec3().extend(side)
}

/// Whether light gets through a material by holes.
fn has_holes(world: &World, material: Entity) -> bool {
    let textures = world.entities().get::<&Textures>(material);
    textures.is_ok_and(|textures| textures.coverage.is_some())
}

/// The row of a surface, with its material and what lies on its sides, and how it gives way.
fn surface(
    world: &World,
    rows: &Rows,
    material: Entity,
    to_world: &DAffine3,
    boundary: &Boundary,
) -> (Surface, Yields) {
    let bsdf = world.entities().get::<&Bsdf>(material);
    let bsdf = bsdf.as_deref().unwrap_or(&Bsdf::Absorber);
    let has_holes = has_holes(world, material);
    let passage = match bsdf.passage() {
        Passage::Closed if has_holes => Passage::Sheet,
        passage @ (Passage::Closed | Passage::Sheet | Passage::Body | Passage::Boundary) => passage,
    };
    let sides = rows.sides(passage, boundary);
    let [interior, exterior] = sides.map(|(row, _)| row);
    let is_two_sided = world.entities().get::<&Sides>(material).is_ok_and(|sides| sides.two_sided);
    let yields = match passage {
        Passage::Closed => Yields::Never { two_sided: is_two_sided },
        Passage::Body => Yields::AsBody,
        Passage::Sheet if [interior, exterior] == [KEEP; 2] => Yields::AsSheet,
        Passage::Sheet | Passage::Boundary => Yields::AsBoundary,
    };
    let own_material = rows.materials.get(&material).copied().unwrap_or(0);
    let is_air = matches!(bsdf, Bsdf::Dielectric { ior: 1.0, exterior_ior: 1.0 })
        && !world.entities().satisfies::<&Emission>(material);
    let surface = Surface {
        material: own_material,
        nested_material: if is_air { rows.air() } else { own_material },
        axis_x: to_world.matrix3.x_axis.normalize().as_vec3(),
        axis_y: to_world.matrix3.y_axis.normalize().as_vec3(),
        axis_z: to_world.matrix3.z_axis.normalize().as_vec3(),
        interior,
        exterior,
        unstated: sides.map(|(_, is_unstated)| is_unstated),
        is_opaque: passage == Passage::Closed,
        is_body: match bsdf.without_grain() {
            Bsdf::Dielectric { exterior_ior, .. } => *exterior_ior == 1.0,
            Bsdf::DispersiveDielectric { exterior_ior, .. }
            | Bsdf::RoughDielectric { exterior_ior, .. } => {
                *exterior_ior == Spectrum::Constant(1.0)
            }
            Bsdf::Absorber
            | Bsdf::Diffuse { .. }
            | Bsdf::Conductor { .. }
            | Bsdf::MetallicRoughness { .. }
            | Bsdf::Layered { .. }
            | Bsdf::Plastic { .. }
            | Bsdf::Measured { .. }
            | Bsdf::Blend { .. }
            | Bsdf::Brushed { .. }
            | Bsdf::Filmed { .. }
            | Bsdf::FilmedConductor { .. }
            | Bsdf::FilmedDielectric { .. }
            | Bsdf::RoughConductor { .. }
            | Bsdf::ThinDielectric { .. }
            | Bsdf::Polarizer { .. }
            | Bsdf::Retarder { .. }
            | Bsdf::Sheet { .. }
            | Bsdf::Null => false,
        },
        priority: boundary.priority,
        whole: NONE,
        solid: NONE,
    };
    (surface, yields)
}

impl Primitives {
    /// Triangles and spheres, which are numbered in this order.
    pub fn shapes(&self) -> (&[Triangle], &[Sphere]) {
        (&self.triangles, &self.spheres)
    }

    fn add_surface(&mut self, (surface, yields): (Surface, Yields)) -> u32 {
        let row = self.surfaces.len() as u32;
        self.surfaces.push(Surface { whole: row, ..surface });
        self.yields.push(yields);
        row
    }

    /// Adds the surfaces of all parts, and the triangles of those that are not shared, in pieces if
    /// they reach far beyond `near`; returns the others with the rows of their surfaces.
    fn add_parts(
        &mut self,
        parts: Vec<Part>,
        near: f32,
        warnings: &mut Warnings,
    ) -> Result<Vec<(Part, u32)>, SceneError> {
        let mut instances = Vec::new();
        let is_shared = shared(&parts);
        let own = parts.iter().zip(&is_shared).filter(|(_, is_shared)| !**is_shared);
        let needs = own.fold(Needs::default(), |needs, (part, _)| needs.and(part.needs));
        let mut triangles = Triangles { paint: Corners::new(needs), ..Triangles::default() };
        check_count(parts.iter().zip(&is_shared).filter(|(_, is_shared)| !**is_shared))?;
        for (part, is_shared) in parts.into_iter().zip(is_shared) {
            let surface = self.add_surface(part.surface);
            if is_shared {
                instances.push((part, surface));
                continue;
            }
            let normal_to_world = normal_matrix(&part.to_world.matrix3);
            let to_world = |p| part.to_world.transform_point3(p);
            let dropped = triangles.add(&part, to_world, normal_to_world)?;
            warn_of_dropped(&part, dropped, warnings);
            self.surface_of_primitive.resize(triangles.rows.len(), surface);
        }
        divide(&mut triangles, &mut self.surface_of_primitive, near);
        triangles.finish_normals();
        let Triangles { rows, shading_normals, paint } = triangles;
        (self.triangles, self.shading_normals, self.corners) = (rows, shading_normals, paint);
        Ok(instances)
    }
}

/// Refuses, before anything is placed, what would fill the memory.
fn check_count<'a>(parts: impl Iterator<Item = (&'a Part, &'a bool)>) -> Result<(), SceneError> {
    let mut triangles = 0;
    for (part, _) in parts {
        triangles += part.geometry.triangles.len();
        if triangles > TRIANGLES_MAX {
            let problem = format!("brings the scene above {TRIANGLES_MAX} triangles in copies");
            let remedy = "use smaller or fewer meshes; what emits or is stretched is not shared";
            return Err(SceneError::new(&part.name, problem, remedy));
        }
    }
    Ok(())
}

impl Triangles {
    /// Appends a part, its positions and the directions of its normals transformed. Returns how
    /// many triangles have been dropped, because nothing is left of their area.
    pub fn add(
        &mut self,
        part: &Part,
        transform: impl Fn(DVec3) -> DVec3,
        normals: DMat3,
    ) -> Result<usize, SceneError> {
        let before = self.rows.len();
        let Part { name, geometry, .. } = part;
        let positions: Vec<Vec3> =
            geometry.positions.iter().map(|p| transform(p.as_dvec3()).as_vec3()).collect();
        for position in &positions {
            check_range(position.as_dvec3(), position.as_dvec3(), name)?;
        }
        let mirrored = normals.determinant() < 0.0;
        for triangle in &geometry.triangles {
            // A reflection turns the winding round; the front stays the front.
            let [a, b, c] = *triangle;
            let triangle = if mirrored { [a, c, b] } else { [a, b, c] };
            let corners = triangle.map(|vertex| positions[vertex as usize]);
            let Some(normal) = geometric_normal(corners) else { continue };
            self.rows.push(Triangle { corners });
            self.paint.push(triangle.map(|vertex| {
                let corner = Corner::of(geometry, vertex as usize);
                Corner { tangent: along(corner.tangent, &transform, mirrored), ..corner }
            }));
            let own = triangle.map(|vertex| {
                let own = geometry.normals.get(vertex as usize).copied().unwrap_or_default();
                shading_normal((normals * own.as_dvec3()).as_vec3(), normal)
            });
            let flat = own.iter().all(|own| (*own - normal).length() < FLAT_TOLERANCE);
            self.shading_normals.push(if flat { [Vec3::ZERO; 3] } else { own });
        }
        Ok(geometry.triangles.len() - (self.rows.len() - before))
    }

    /// Drops the shading normals if all triangles are flat; else the flat ones get theirs.
    pub fn finish_normals(&mut self) {
        if self.shading_normals.iter().all(|corners| *corners == [Vec3::ZERO; 3]) {
            self.shading_normals = Vec::new();
        }
        for (triangle, normals) in self.rows.iter().zip(&mut self.shading_normals) {
            if *normals == [Vec3::ZERO; 3] {
                *normals = [geometric_normal(triangle.corners).unwrap_or_default(); 3];
            }
        }
    }
}

/// Says what a part has lost in its place.
pub fn warn_of_dropped(part: &Part, dropped: usize, warnings: &mut Warnings) {
    const TRIANGLES: [&str; 2] = ["triangle", "triangles"];
    let text = "without area in the world (as `f32`) dropped: too small, or too far away";
    warnings.add_counted(&part.name, dropped, TRIANGLES, text);
}

/// What turns normals when `matrix` turns points, up to a positive factor: the inverse transpose,
/// which keeps a normal on its side even in a reflection.
fn normal_matrix(matrix: &DMat3) -> DMat3 {
    let scale = cbrt(matrix.determinant().abs()).recip();
    (*matrix * scale).inverse().transpose()
}

/// The unit normal of a triangle, as later stages will compute it in `f32`; none if that fails.
pub fn geometric_normal([a, b, c]: [Vec3; 3]) -> Option<Vec3> {
    let normal = (b - a).cross(c - a);
    let length_squared = normal.length_squared();
    (length_squared.is_normal() && length_squared.is_finite())
        .then(|| normal.as_dvec3().normalize().as_vec3())
}

/// The shading normal that a vertex normal stands for: on the side of the geometric normal,
/// mirrored onto it if need be, and the geometric normal itself where there is none.
fn shading_normal(own: Vec3, geometric: Vec3) -> Vec3 {
    let own = own.as_dvec3().normalize_or_zero();
    if own == DVec3::ZERO {
        return geometric;
    }
    let geometric = geometric.as_dvec3();
    let cosine = own.dot(geometric);
    if cosine >= f64::from(LEAST_COSINE) {
        return own.as_vec3();
    }
    let tangent = own - cosine * geometric;
    (tangent + cosine.abs().max(f64::from(LEAST_COSINE)) * geometric).normalize().as_vec3()
}
