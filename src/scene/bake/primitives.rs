//! Triangles and spheres in world space.

use glam::{DAffine3, DMat3, DVec3, Vec3};
use hecs::Entity;

use super::media::Media;
use super::{Materials, check_range};
use crate::scene::baked::{Sphere, Surface, Triangle};
use crate::scene::error::SceneError;
use crate::scene::world::{Ball, Boundary, Geometry, MadeOf, Mesh, Name, Transform, World};

/// Shading normals that are this close to the geometric one are the geometric one.
const FLAT_TOLERANCE: f32 = 1e-4;
/// Least cosine between a shading normal and the geometric one.
const LEAST_COSINE: f32 = 1e-3;

/// The tables of primitives and their surfaces: see `BakedScene`.
#[derive(Default)]
pub struct Primitives {
    pub triangles: Vec<Triangle>,
    pub shading_normals: Vec<[Vec3; 3]>,
    pub spheres: Vec<Sphere>,
    pub surface_of_primitive: Vec<u32>,
    pub surfaces: Vec<Surface>,
}

/// Flattens all instances.
pub fn primitives<const N: usize>(
    world: &World,
    materials: &Materials<N>,
    media: &Media<N>,
) -> Result<Primitives, SceneError> {
    type Placed<'a, Shape> = (&'a Name, &'a Transform, Shape, (&'a MadeOf, &'a Boundary));
    let mut tables = Primitives::default();
    let surface = |material: &Entity, to_world: &DAffine3, boundary: &Boundary| {
        let material = materials.row_of.get(material).copied().unwrap_or(0);
        let kind = materials.rows[material as usize].kind;
        let (interior, exterior) = media.sides(kind, boundary);
        Surface {
            material,
            axis_x: to_world.matrix3.x_axis.normalize().as_vec3(),
            axis_y: to_world.matrix3.y_axis.normalize().as_vec3(),
            interior,
            exterior,
        }
    };
    let meshes = world.in_order::<Placed<&Mesh>, _>(|(name, at, mesh, (of, boundary))| {
        (name.clone(), mesh.clone(), at.0, surface(&of.0, &at.0, boundary))
    });
    for (name, mesh, to_world, surface) in meshes {
        let surface = tables.add_surface(surface);
        tables.add_mesh(&mesh.0, &to_world, &name.0)?;
        tables.surface_of_primitive.resize(tables.triangles.len(), surface);
    }
    if tables.shading_normals.iter().all(|corners| *corners == [Vec3::ZERO; 3]) {
        tables.shading_normals = Vec::new();
    } else {
        tables.fill_flat_normals();
    }
    let balls = world.in_order::<Placed<&Ball>, _>(|(name, at, ball, (of, boundary))| {
        (name.clone(), ball.radius, at.0, surface(&of.0, &at.0, boundary))
    });
    for (name, radius, to_world, surface) in balls {
        let surface = tables.add_surface(surface);
        tables.surface_of_primitive.push(surface);
        let radius = (radius * to_world.matrix3.x_axis.length()) as f32;
        if !(radius >= f32::MIN_POSITIVE && radius.is_finite()) {
            let problem = format!("a radius of {radius} is out of range");
            return Err(SceneError::new(name.0, problem, "check its scale"));
        }
        tables.spheres.push(Sphere { center: to_world.translation.as_vec3(), radius });
    }
    Ok(tables)
}

impl Primitives {
    fn add_surface(&mut self, surface: Surface) -> u32 {
        self.surfaces.push(surface);
        (self.surfaces.len() - 1) as u32
    }

    /// Appends the triangles of an instance and their shading normals; those of flat triangles
    /// are zero for now.
    fn add_mesh(
        &mut self,
        geometry: &Geometry,
        to_world: &DAffine3,
        name: &str,
    ) -> Result<(), SceneError> {
        let mirrored = to_world.matrix3.determinant() < 0.0;
        let normal_to_world = normal_matrix(&to_world.matrix3);
        let positions: Vec<Vec3> = geometry
            .positions
            .iter()
            .map(|position| to_world.transform_point3(position.as_dvec3()).as_vec3())
            .collect();
        for position in &positions {
            check_range(position.as_dvec3(), position.as_dvec3(), name)?;
        }
        for (index, triangle) in geometry.triangles.iter().enumerate() {
            // A reflection turns the winding round; the front stays the front.
            let [a, b, c] = *triangle;
            let triangle = if mirrored { [a, c, b] } else { [a, b, c] };
            let corners = triangle.map(|vertex| positions[vertex as usize]);
            let Some(normal) = geometric_normal(corners) else {
                let problem = format!("triangle {index} has no area in world space, as f32");
                let remedy = "dissolve it, or scale the scene or move it towards the origin";
                return Err(SceneError::new(name, problem, remedy));
            };
            self.triangles.push(Triangle { corners });
            let normals = triangle.map(|vertex| {
                let own = geometry.normals.get(vertex as usize).copied().unwrap_or_default();
                shading_normal((normal_to_world * own.as_dvec3()).as_vec3(), normal)
            });
            let flat = normals.iter().all(|own| (*own - normal).length() < FLAT_TOLERANCE);
            self.shading_normals.push(if flat { [Vec3::ZERO; 3] } else { normals });
        }
        Ok(())
    }

    fn fill_flat_normals(&mut self) {
        for (triangle, normals) in self.triangles.iter().zip(&mut self.shading_normals) {
            if *normals == [Vec3::ZERO; 3] {
                *normals = [geometric_normal(triangle.corners).unwrap_or_default(); 3];
            }
        }
    }
}

/// What turns normals when `matrix` turns points, up to a positive factor: the inverse transpose,
/// which keeps a normal on its side even in a reflection.
fn normal_matrix(matrix: &DMat3) -> DMat3 {
    let scale = matrix.determinant().abs().cbrt().recip();
    (*matrix * scale).inverse().transpose()
}

/// The unit normal of a triangle, as later stages will compute it in `f32`; none if that fails.
fn geometric_normal([a, b, c]: [Vec3; 3]) -> Option<Vec3> {
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
