//! From primitives to a binary tree: obvhs builds it, nothing of it is traced.

use std::time::Duration;

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};

use crate::scene::baked::{Sphere, Triangle};

/// Up to so many primitives are worth the slower, better build.
const CAREFUL_BUILD: usize = 200_000;

/// A binary tree with one primitive a leaf over all primitives, triangles first. Single-threaded
/// and free of hashing, so the same input gives the same tree.
pub(super) fn build_binary(triangles: &[Triangle], spheres: &[Sphere]) -> Bvh2 {
    let bounds = primitive_bounds(triangles, spheres);
    let preset = if bounds.len() <= CAREFUL_BUILD {
        BvhBuildParams::slow_build()
    } else {
        BvhBuildParams::medium_build()
    };
    let parameters = BvhBuildParams { pre_split: false, max_prims_per_leaf: 1, ..preset };
    build_bvh2(&bounds, parameters, &mut Duration::default())
}

fn primitive_bounds(triangles: &[Triangle], spheres: &[Sphere]) -> Vec<Aabb> {
    let of_triangle = |triangle: &Triangle| {
        let [a, b, c] = triangle.corners.map(Vec3A::from);
        Aabb::new(a.min(b).min(c), a.max(b).max(c))
    };
    let of_sphere = |sphere: &Sphere| {
        let (center, radius) = (Vec3A::from(sphere.center), Vec3A::splat(sphere.radius));
        Aabb::new(center - radius, center + radius)
    };
    triangles.iter().map(of_triangle).chain(spheres.iter().map(of_sphere)).collect()
}

/// The largest magnitude of any coordinate of a primitive.
pub(super) fn largest_coordinate(triangles: &[Triangle], spheres: &[Sphere]) -> f32 {
    let of_triangles = triangles.iter().flat_map(|triangle| triangle.corners);
    let of_triangles = of_triangles.map(|corner| corner.abs().max_element());
    let of_spheres = spheres.iter().map(|s| s.center.abs().max_element() + s.radius);
    of_triangles.chain(of_spheres).fold(0.0, f32::max)
}
