//! From hits to points on surfaces, or in media.

use std::ops::Range;

use glam::{Vec3, Vec3A};

use crate::math::columns::{Column, columns};
use crate::math::{F32s, LANES, Real, Vector, lanes};
use crate::scene::baked::{LEAST_COSINE, NONE, Shapes, Triangle};
use crate::scene::instanced::Instance;

use super::offset::{offset_distance, reach};
use super::rays::{HitColumns, IN_MEDIUM, RayColumns, medium_met};

columns! {
    /// What was hit. Rows without a hit hold zero vectors and [`NONE`], those that ended in a
    /// medium a position and no normals.
    #[derive(Clone, Debug, PartialEq)]
    pub struct SurfaceColumns {
        /// World-space position.
        pub position: [Column; 3],
        /// Unit normal on the primitive's own front side, not turned to the ray.
        pub geometric_normal: [Column; 3],
        /// Interpolated unit normal; the geometric one where the mesh has none.
        pub shading_normal: [Column; 3],
        /// How far off it rays start and end, see [`super::offset_origin`].
        pub offset: Column,
        /// Row in `surfaces` of the scene, or [`NONE`].
        pub surface: Vec<u32> = NONE,
        /// The primitive, [`NONE`], or a medium ([`super::IN_MEDIUM`]).
        pub primitive: Vec<u32> = NONE,
        /// The row in the table of its model where textures give it one of its own, or [`NONE`].
        /// Nothing writes it in scenes without textures.
        pub model: Vec<u32> = NONE,
    }
}

/// Position and the two normals of eight rows.
struct Points {
    position: Vector<F32s>,
    geometric_normal: Vector<F32s>,
    shading_normal: Vector<F32s>,
    /// Largest coordinate of the primitive.
    reach: F32s,
}

/// Finds the position and the normals of each hit in `rows`.
pub fn resolve_surfaces(
    surfaces: &mut SurfaceColumns,
    hits: &HitColumns,
    rays: &RayColumns,
    rows: Range<usize>,
    shapes: &Shapes,
) {
    let triangle_count = shapes.triangles.len() as u32;
    let own_count = triangle_count + shapes.spheres.len() as u32;
    for row in rows.clone().step_by(LANES) {
        let live = LANES.min(rows.end - row);
        let mut primitive = [NONE; LANES];
        primitive[..live].copy_from_slice(&hits.primitive[row..row + live]);
        let surface = lanes::each(|lane| shapes.surface_of(primitive[lane]));
        let is_sphere = primitive.map(|p| p >= triangle_count && p < own_count);
        let is_instanced = primitive.map(|p| p >= own_count && p < IN_MEDIUM);
        let is_particle = primitive.map(|p| medium_met(p).is_some());
        let mut points = if primitive.iter().any(|&p| p < triangle_count) {
            on_triangles(&primitive, hits, row, shapes)
        } else {
            nowhere()
        };
        if is_sphere.contains(&true) {
            let on_spheres = on_spheres(&primitive, hits, rays, row, shapes);
            points = select(lanes::mask_of(is_sphere), on_spheres, points);
        }
        if is_instanced.contains(&true) {
            let on_instances = on_instances(&primitive, hits, row, shapes);
            points = select(lanes::mask_of(is_instanced), on_instances, points);
        }
        if is_particle.contains(&true) {
            let in_media = along_rays(hits, rays, row);
            points = select(lanes::mask_of(is_particle), in_media, points);
        }
        points.position.store(&mut surfaces.position, row, rows.end);
        points.geometric_normal.store(&mut surfaces.geometric_normal, row, rows.end);
        points.shading_normal.store(&mut surfaces.shading_normal, row, rows.end);
        lanes::store(&mut surfaces.offset, row, rows.end, offset_distance(points.reach));
        lanes::store_u32(&mut surfaces.surface, row, rows.end, surface.into());
        lanes::store_u32(&mut surfaces.primitive, row, rows.end, primitive.into());
    }
}

/// Points in media, which have no normals.
#[inline(always)]
fn along_rays(hits: &HitColumns, rays: &RayColumns, row: usize) -> Points {
    let origin = Vector::load(&rays.origin, row);
    let direction = Vector::load(&rays.direction, row);
    Points { position: direction.mul_add(lanes::load(&hits.t, row), origin), ..nowhere() }
}

fn nowhere() -> Points {
    let zero = Vector::new(F32s::ZERO, F32s::ZERO, F32s::ZERO);
    Points { position: zero, geometric_normal: zero, shading_normal: zero, reach: F32s::ZERO }
}

#[inline(always)]
fn select(mask: F32s, a: Points, b: Points) -> Points {
    Points {
        position: Vector::select(mask, a.position, b.position),
        geometric_normal: Vector::select(mask, a.geometric_normal, b.geometric_normal),
        shading_normal: Vector::select(mask, a.shading_normal, b.shading_normal),
        reach: mask.select(a.reach, b.reach),
    }
}

/// `vector` of length one, or zero where it has no length.
#[inline(always)]
fn normalize_or_zero(vector: Vector<F32s>) -> Vector<F32s> {
    let length_squared = vector.length_squared();
    let inverse = F32s::ONE / length_squared.sqrt();
    vector * (length_squared.simd_gt(F32s::ZERO) & inverse)
}

/// Lanes that did not hit a triangle become zero.
#[inline(always)]
fn on_triangles(
    primitive: &[u32; LANES],
    hits: &HitColumns,
    row: usize,
    shapes: &Shapes,
) -> Points {
    let weights = [lanes::load(&hits.u, row), lanes::load(&hits.v, row)];
    let triangle_in = |lane: usize| shapes.triangles.get(primitive[lane] as usize);
    let mut points = interpolate(triangle_in, weights);
    if !shapes.shading_normals.is_empty() {
        let normals_in = |lane: usize| shapes.shading_normals.get(primitive[lane] as usize);
        points.shading_normal = interpolate_normals(normals_in, weights, points.geometric_normal);
    }
    points
}

/// Only lanes that hit a triangle of an instance count.
#[inline(never)]
fn on_instances(
    primitive: &[u32; LANES],
    hits: &HitColumns,
    row: usize,
    shapes: &Shapes,
) -> Points {
    let weights = [lanes::load(&hits.u, row), lanes::load(&hits.v, row)];
    let found = lanes::each(|lane| shapes.instanced.find(primitive[lane]));
    let triangle_in =
        |lane: usize| found[lane].and_then(|(_, object, row)| object.triangles.get(row));
    let own = interpolate(triangle_in, weights);
    let column = |of: fn(&Instance) -> Vec3A| {
        Vector::gather(|lane| {
            found[lane].map_or([0.0; 3], |(instance, ..)| of(instance).to_array())
        })
    };
    let columns = [
        column(|it| it.to_world.matrix3.x_axis),
        column(|it| it.to_world.matrix3.y_axis),
        column(|it| it.to_world.matrix3.z_axis),
    ];
    let [x, y, z] = columns;
    let moved = z.mul_add(own.position.z, column(|it| it.to_world.translation));
    let position = x.mul_add(own.position.x, y.mul_add(own.position.y, moved));
    // Normals take the transposed inverse, which leaves them on their side even in a reflection.
    let rows = [
        column(|it| it.to_object.x_axis),
        column(|it| it.to_object.y_axis),
        column(|it| it.to_object.z_axis),
    ];
    let turned = |n: Vector<F32s>| {
        normalize_or_zero(Vector::new(rows[0].dot(n), rows[1].dot(n), rows[2].dot(n)))
    };
    let geometric_normal = turned(own.geometric_normal);
    let mut shading_normal = geometric_normal;
    if shapes.instanced.has_shading_normals() {
        let normals_in =
            |lane: usize| found[lane].and_then(|(_, object, row)| object.shading_normals.get(row));
        let smooth = interpolate_normals(normals_in, weights, own.geometric_normal);
        shading_normal = to_front(turned(smooth), geometric_normal);
    }
    let reach = F32s::from(lanes::each(|lane| {
        found[lane].map_or(0.0, |(instance, ..)| {
            let [lower, upper] = instance.bounds;
            lower.abs().max(upper.abs()).max_element()
        })
    }));
    Points { position, geometric_normal, shading_normal, reach }
}

/// The shading normal itself where it is on the side of the geometric one, else the nearest that
/// is: what [`crate::scene::bake`] sees to may be lost when a place stretches its object.
#[inline(always)]
fn to_front(shading: Vector<F32s>, geometric: Vector<F32s>) -> Vector<F32s> {
    let least = F32s::splat(LEAST_COSINE);
    let cosine = shading.dot(geometric);
    let raised = normalize_or_zero(geometric.mul_add(least - cosine, shading));
    Vector::select(cosine.simd_lt(least), raised, shading)
}

/// Points on triangles that are flat.
#[inline(always)]
fn interpolate<'a>(
    triangle_in: impl Fn(usize) -> Option<&'a Triangle>,
    [u, v]: [F32s; 2],
) -> Points {
    let [a, b, c] = corners(|lane| triangle_in(lane).map(|triangle| &triangle.corners));
    let (edge_b, edge_c) = (b - a, c - a);
    let position = edge_b.mul_add(u, edge_c.mul_add(v, a));
    let geometric_normal = normalize_or_zero(edge_b.cross(edge_c));
    let reach = reach(a).max(reach(b)).max(reach(c));
    Points { position, geometric_normal, shading_normal: geometric_normal, reach }
}

/// What eight triangles have at their corners, zero where there is none.
#[inline(always)]
fn corners<'a>(of_lane: impl Fn(usize) -> Option<&'a [Vec3; 3]>) -> [Vector<F32s>; 3] {
    let mut corners = [&[Vec3::ZERO; 3]; LANES];
    for (lane, corners) in corners.iter_mut().enumerate() {
        if let Some(found) = of_lane(lane) {
            *corners = found;
        }
    }
    let at = |corner: usize| Vector::gather(|lane| corners[lane][corner].to_array());
    [at(0), at(1), at(2)]
}

/// Unit normals between those of the corners; `geometric` where there are none.
#[inline(always)]
fn interpolate_normals<'a>(
    normals_in: impl Fn(usize) -> Option<&'a [Vec3; 3]>,
    [u, v]: [F32s; 2],
    geometric: Vector<F32s>,
) -> Vector<F32s> {
    let [a, b, c] = corners(normals_in);
    let sum = b.mul_add(u, c.mul_add(v, a * (F32s::ONE - u - v)));
    let has_length = sum.length_squared().gt(F32s::ZERO);
    Vector::select(has_length, normalize_or_zero(sum), geometric)
}

/// Only lanes that hit a sphere count.
#[inline(always)]
fn on_spheres(
    primitive: &[u32; LANES],
    hits: &HitColumns,
    rays: &RayColumns,
    row: usize,
    shapes: &Shapes,
) -> Points {
    let first = shapes.triangles.len() as u32;
    let spheres = lanes::each(|lane| {
        match shapes.spheres.get(primitive[lane].wrapping_sub(first) as usize) {
            Some(sphere) => (sphere.center.to_array(), sphere.radius),
            None => ([0.0; 3], 0.0),
        }
    });
    let center = Vector::gather(|lane| spheres[lane].0);
    let radius = F32s::from(lanes::each(|lane| spheres[lane].1));
    let origin = Vector::load(&rays.origin, row);
    let direction = Vector::load(&rays.direction, row);
    let reached = direction.mul_add(lanes::load(&hits.t, row), origin - center);
    let normal = normalize_or_zero(reached);
    let position = normal.mul_add(radius, center);
    let reach = reach(center) + radius;
    Points { position, geometric_normal: normal, shading_normal: normal, reach }
}
