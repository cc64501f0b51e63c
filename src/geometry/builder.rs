//! From primitives to a binary tree: obvhs builds it, nothing of it is traced.

use std::time::Duration;

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};

use super::collapse::Shapes;

/// Up to so many primitives are worth the slower, better build.
const CAREFUL_BUILD: usize = 200_000;

/// A binary tree with one shape a leaf over all shapes. The same input gives the same tree, with
/// any number of threads.
pub(super) fn build_binary(shapes: &Shapes) -> Bvh2 {
    let bounds = bounds_of(shapes);
    let preset = if bounds.len() <= CAREFUL_BUILD {
        BvhBuildParams::slow_build()
    } else {
        // A second round of reinsertions made no ray faster that was measured, and fewer in the
        // first cost shadow rays 5 %.
        BvhBuildParams {
            post_collapse_reinsertion_batch_ratio_multiplier: 0.0,
            ..BvhBuildParams::medium_build()
        }
    };
    let parameters = BvhBuildParams { pre_split: false, max_prims_per_leaf: 1, ..preset };
    build_bvh2(&bounds, parameters, &mut Duration::default())
}

fn bounds_of(shapes: &Shapes) -> Vec<Aabb> {
    let of_triangles = shapes.triangles.iter().map(|triangle| {
        let [a, b, c] = triangle.corners.map(Vec3A::from);
        Aabb::new(a.min(b).min(c), a.max(b).max(c))
    });
    let of_spheres = shapes.spheres.iter().map(|sphere| {
        let (center, radius) = (Vec3A::from(sphere.center), Vec3A::splat(sphere.radius));
        Aabb::new(center - radius, center + radius)
    });
    let of_instances = shapes.instances.iter().map(|instance| {
        let [low, high] = instance.bounds.map(Vec3A::from);
        Aabb::new(low, high)
    });
    of_triangles.chain(of_spheres).chain(of_instances).collect()
}

/// Roots of the largest subtrees of at most `most` primitives each, depth first.
pub(super) fn parts_of(binary: &Bvh2, most: u32) -> Vec<u32> {
    match subtree(binary, 0, most, FORKS) {
        Subtree::Small(_) => vec![0],
        Subtree::Large(parts) => parts,
    }
}

/// Levels of the tree whose two sides are looked at in parallel.
const FORKS: u32 = 10;

/// A subtree of at most so many primitives, or the parts that a larger one consists of.
enum Subtree {
    Small(u32),
    Large(Vec<u32>),
}

fn subtree(binary: &Bvh2, index: u32, most: u32, forks: u32) -> Subtree {
    let node = &binary.nodes[index as usize];
    if node.is_leaf() {
        return Subtree::Small(node.prim_count);
    }
    let [left, right] = [node.first_index, node.first_index + 1];
    let below = |child: u32| subtree(binary, child, most, forks.saturating_sub(1));
    let (of_left, of_right) = if forks > 0 {
        rayon::join(|| below(left), || below(right))
    } else {
        (below(left), below(right))
    };
    if let (Subtree::Small(a), Subtree::Small(b)) = (&of_left, &of_right)
        && a + b <= most
    {
        return Subtree::Small(a + b);
    }
    let mut parts = Vec::new();
    for (child, found) in [(left, of_left), (right, of_right)] {
        match found {
            Subtree::Small(_) => parts.push(child),
            Subtree::Large(more) => parts.extend(more),
        }
    }
    Subtree::Large(parts)
}

/// The largest magnitude of any coordinate of a shape.
pub(super) fn largest_coordinate(shapes: &Shapes) -> f32 {
    let of_triangles = shapes.triangles.iter().flat_map(|triangle| triangle.corners);
    let of_instances = shapes.instances.iter().flat_map(|instance| instance.bounds);
    let of_points = of_triangles.chain(of_instances).map(|point| point.abs().max_element());
    let of_spheres = shapes.spheres.iter().map(|s| s.center.abs().max_element() + s.radius);
    of_points.chain(of_spheres).fold(0.0, f32::max)
}
