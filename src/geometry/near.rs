//! What lies near a point: the shapes that cut into a small ball or disk about it.

use glam::{Affine3A, Mat3A, Vec3A};

use crate::math::{F32s, Vector};

use super::accelerator::Accelerator;
use super::block::{Node, Reference, TriangleBlock};
use super::tree::View;

/// Shapes that are found at least, if as many are near; the nearest.
pub const SHAPES_MAX: usize = 64;

/// Bounds are taken to be this much wider than they are, relative to the coordinates.
const PADDING: f32 = 4.0 * f32::EPSILON;

/// The ball in which shapes are looked for, and a pair of planes of which they must cross one, if
/// any.
#[derive(Clone, Copy, Debug)]
pub struct Neighborhood {
    /// Middle of the ball.
    pub center: Vec3A,
    /// Radius of the ball, in scene units.
    pub radius: f32,
    /// The planes, the same height above and below another.
    pub crossed: Option<Planes>,
}

/// Planes of all points `p` with `n . p + o` the height or its negative.
#[derive(Clone, Copy, Debug)]
pub struct Planes {
    /// Normal `n`.
    pub normal: Vec3A,
    /// Offset `o`.
    pub offset: f32,
    /// The height, positive.
    pub height: f32,
}

/// The shapes that were found, and the memory that it takes to find them.
#[derive(Clone, Debug, Default)]
pub struct Surroundings {
    /// Corners of triangles.
    pub triangles: Vec<[Vec3A; 3]>,
    /// Centers and radii of spheres.
    pub spheres: Vec<(Vec3A, f32)>,
    /// Where they are looked for, which shrinks when there are too many.
    center: Vec3A,
    reach: f32,
    distances: Vec<f32>,
    stack: Vec<Reference>,
}

impl Surroundings {
    /// Finds the shapes whose surfaces may be in the ball and cross a plane: none that do is
    /// missing. If there are more than twice [`SHAPES_MAX`] of them, some of the farthest are.
    pub fn find(&mut self, accelerator: &Accelerator, near: &Neighborhood) {
        self.triangles.clear();
        self.spheres.clear();
        self.stack.clear();
        (self.center, self.reach) = (near.center, near.radius);
        self.look(&accelerator.tree.view(), near, None);
    }

    /// Looks through a tree; `near` is in its space, which `to_world` leads out of.
    fn look(&mut self, tree: &View, near: &Neighborhood, to_world: Option<&Affine3A>) {
        let bottom = self.stack.len();
        let mut ball = Ball::new(near, tree.reach);
        let stretch = near.radius / self.reach;
        self.stack.push(tree.root);
        while self.stack.len() > bottom {
            let Some(next) = self.stack.pop() else { return };
            if !next.is_leaf() {
                let node = &tree.nodes[next.row()];
                let lanes = ball.meets_bounds(node);
                self.stack.extend(lanes_of(lanes).map(|lane| node.children[lane]));
            } else if next.is_of_triangles() {
                for block in &tree.triangle_blocks[next.blocks()] {
                    self.take_triangles(block, &ball, near, to_world);
                }
            } else if let Some(row) = next.as_instance() {
                let instance = &tree.instances[row];
                let object = &tree.objects[instance.object as usize].view();
                let near = Neighborhood { radius: self.reach, ..*near };
                let inside = near.inside(&instance.to_world, &instance.to_object);
                self.look(object, &inside, Some(&instance.to_world));
            } else {
                for block in &tree.sphere_blocks[next.blocks()] {
                    let near_ones = block.spheres().filter(|sphere| near.meets_sphere(*sphere));
                    self.spheres.extend(near_ones);
                }
            }
            if self.len() > 2 * SHAPES_MAX {
                self.keep_nearest();
                let radius = stretch * self.reach;
                ball = Ball::new(&Neighborhood { radius, ..*near }, tree.reach);
            }
        }
    }

    /// Keeps [`SHAPES_MAX`] shapes, the nearest, whatever the order in which they were found, and
    /// goes on looking nearer than the last of them.
    fn keep_nearest(&mut self) {
        let of_triangle = |corners: &[Vec3A; 3]| distance_to_triangle(self.center, corners);
        let of_sphere =
            |&(center, radius): &(Vec3A, f32)| ((center - self.center).length() - radius).abs();
        self.distances.clear();
        self.distances.extend(self.triangles.iter().map(of_triangle));
        self.distances.extend(self.spheres.iter().map(of_sphere));
        let (_, &mut farthest, _) =
            self.distances.select_nth_unstable_by(SHAPES_MAX - 1, f32::total_cmp);
        self.triangles.retain(|corners| of_triangle(corners) <= farthest);
        self.triangles.truncate(SHAPES_MAX);
        self.spheres.retain(|sphere| of_sphere(sphere) <= farthest);
        self.spheres.truncate(SHAPES_MAX - self.triangles.len());
        self.reach = farthest;
    }

    /// Shapes found.
    pub fn len(&self) -> usize {
        self.triangles.len() + self.spheres.len()
    }

    /// Whether nothing was found.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn take_triangles(
        &mut self,
        block: &TriangleBlock,
        ball: &Ball,
        near: &Neighborhood,
        to_world: Option<&Affine3A>,
    ) {
        let corners = block.corners([0, 1, 2]);
        let mut mask = ball.meets_boxes(&corners);
        if let Some(Planes { normal, offset, height }) = near.crossed {
            let normal = Vector::splat(normal.to_array());
            let [a, b, c] = corners.map(|corner| corner.dot(normal) + F32s::splat(offset));
            let (lower, upper) = (a.min(b).min(c), a.max(b).max(c));
            let crosses = |height: F32s| lower.simd_le(height) & upper.simd_ge(height);
            mask &= crosses(F32s::splat(height)) | crosses(F32s::splat(-height));
        }
        for lane in lanes_of(mask.to_bitmask()) {
            let of_lane = corners.map(|corner| Vec3A::from(<[f32; 3]>::from(corner.lane(lane))));
            // Vacant lanes are points.
            if of_lane[0] == of_lane[1] && of_lane[1] == of_lane[2] {
                continue;
            }
            let in_world = |corner| to_world.map_or(corner, |map| map.transform_point3a(corner));
            self.triangles.push(of_lane.map(in_world));
        }
    }
}

impl Neighborhood {
    /// The same in the space of an instance: a ball that holds what becomes of this one.
    fn inside(&self, to_world: &Affine3A, to_object: &Mat3A) -> Self {
        let [x, y, z] = [to_object.x_axis, to_object.y_axis, to_object.z_axis];
        let stretch = (x.length_squared() + y.length_squared() + z.length_squared()).sqrt();
        let crossed = self.crossed.map(|Planes { normal, offset, height }| Planes {
            normal: to_world.matrix3.transpose() * normal,
            offset: offset + normal.dot(to_world.translation),
            height,
        });
        Self {
            center: *to_object * (self.center - to_world.translation),
            radius: self.radius * stretch,
            crossed,
        }
    }

    fn meets_sphere(&self, (center, radius): (Vec3A, f32)) -> bool {
        let distance = (center - self.center).length();
        let crosses = self.crossed.is_none_or(|Planes { normal, offset, height }| {
            let off = normal.dot(center) + offset;
            (off - height).abs() <= radius || (off + height).abs() <= radius
        });
        crosses && (distance - radius).abs() <= self.radius
    }
}

fn distance_to_triangle(point: Vec3A, corners: &[Vec3A; 3]) -> f32 {
    (point - nearest_in_triangle(point, corners)).length()
}

/// The point of a triangle that is nearest to `point` (Ericson 2005, "Real-time collision
/// detection", section 5.1.5).
pub fn nearest_in_triangle(point: Vec3A, &[a, b, c]: &[Vec3A; 3]) -> Vec3A {
    let (ab, ac) = (b - a, c - a);
    let from = |corner: Vec3A| [ab.dot(point - corner), ac.dot(point - corner)];
    let ([d1, d2], [d3, d4], [d5, d6]) = (from(a), from(b), from(c));
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if d1 <= 0.0 && d2 <= 0.0 {
        a
    } else if d3 >= 0.0 && d4 <= d3 {
        b
    } else if d6 >= 0.0 && d5 <= d6 {
        c
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        a + ab * (d1 / (d1 - d3))
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        a + ac * (d2 / (d2 - d6))
    } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))
    } else {
        let sum = va + vb + vc;
        a + ab * (vb / sum) + ac * (vc / sum)
    }
}

/// The ball for eight tests at a time.
struct Ball {
    center: Vector<F32s>,
    radius_squared: F32s,
}

impl Ball {
    /// That of a neighborhood in a tree whose largest coordinate is `reach`.
    fn new(near: &Neighborhood, reach: f32) -> Self {
        let slack = (near.center.abs().max_element() + reach) * PADDING;
        Self {
            center: Vector::splat(near.center.to_array()),
            radius_squared: F32s::splat((near.radius + slack).powi(2)),
        }
    }

    /// Which children's bounds the ball meets.
    #[inline(always)]
    fn meets_bounds(&self, node: &Node) -> u32 {
        let [[x, below_x], [y, below_y], [z, below_z]] = node.bounds;
        let (lower, upper) = (Vector::new(x, y, z), Vector::new(below_x, below_y, below_z));
        self.meets_box(lower, upper).to_bitmask()
    }

    /// Which triangles' boxes the ball meets.
    #[inline(always)]
    fn meets_boxes(&self, [a, b, c]: &[Vector<F32s>; 3]) -> F32s {
        let lower = Vector::new(
            a.x.fast_min(b.x).fast_min(c.x),
            a.y.fast_min(b.y).fast_min(c.y),
            a.z.fast_min(b.z).fast_min(c.z),
        );
        let upper = Vector::new(
            a.x.fast_max(b.x).fast_max(c.x),
            a.y.fast_max(b.y).fast_max(c.y),
            a.z.fast_max(b.z).fast_max(c.z),
        );
        self.meets_box(lower, upper)
    }

    #[inline(always)]
    fn meets_box(&self, lower: Vector<F32s>, upper: Vector<F32s>) -> F32s {
        let zero = F32s::splat(0.0);
        let off =
            |lower: F32s, upper: F32s, at: F32s| (lower - at).fast_max(at - upper).fast_max(zero);
        let off = Vector::new(
            off(lower.x, upper.x, self.center.x),
            off(lower.y, upper.y, self.center.y),
            off(lower.z, upper.z, self.center.z),
        );
        off.length_squared().simd_le(self.radius_squared)
    }
}

/// The lanes of a bit mask.
fn lanes_of(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = mask.trailing_zeros();
        mask &= mask.wrapping_sub(1);
        (lane < 32).then_some((lane & 7) as usize)
    })
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::math::hash;
    use crate::scene::baked::{Sphere, Triangle};

    fn uniform(salt: u32, row: usize, dimension: u32) -> f32 {
        let bits = hash::combine(hash::combine(salt, row as u32), dimension);
        (bits >> 8) as f32 / (1 << 24) as f32
    }

    fn point(salt: u32, row: usize) -> Vec3 {
        Vec3::from([0, 1, 2].map(|axis| uniform(salt, row, axis)))
    }

    /// Points all over a triangle.
    fn points(Triangle { corners: [a, b, c] }: &Triangle) -> impl Iterator<Item = Vec3> {
        let (a, ab, ac) = (*a, *b - *a, *c - *a);
        let steps = (0..=20).flat_map(|i| (0..=20 - i).map(move |j| (i, j)));
        steps.map(move |(i, j)| a + ab * (i as f32 / 20.0) + ac * (j as f32 / 20.0))
    }

    #[test]
    fn no_shape_that_is_near_and_crosses_is_missing() {
        let small = |row| Triangle {
            corners: [1, 2, 3].map(|salt| point(9, row) + 0.2 * point(salt, row)),
        };
        let triangles: Vec<Triangle> = (0..300).map(small).collect();
        let ball = |row| Sphere { center: point(7, row), radius: 0.01 + 0.1 * uniform(8, row, 0) };
        let spheres: Vec<Sphere> = (0..100).map(ball).collect();
        let accelerator = Accelerator::build(&triangles, &spheres);
        let mut around = Surroundings::default();
        let mut found = 0;
        for query in 0..200 {
            let center = point(20, query);
            let normal = (point(21, query) - Vec3::splat(0.5)).normalize();
            let offset = -normal.dot(center);
            let planes = Planes { normal: normal.into(), offset, height: 0.01 };
            let crossed = (query % 2 == 1).then_some(planes);
            let near = Neighborhood { center: center.into(), radius: 0.05, crossed };
            around.find(&accelerator, &near);
            if around.len() >= SHAPES_MAX {
                continue;
            }
            for triangle in &triangles {
                let is_near = points(triangle).any(|point| point.distance(center) < near.radius);
                let crosses = crossed.is_none()
                    || [0.01, -0.01].into_iter().any(|height| {
                        let below = |corner| normal.dot(corner - center) < height;
                        let signs = triangle.corners.map(below);
                        signs != [signs[0]; 3]
                    });
                let corners = triangle.corners.map(Vec3A::from);
                let is_found = around.triangles.contains(&corners);
                assert!(is_found || !(is_near && crosses), "{triangle:?}");
                found += usize::from(is_near && crosses);
            }
            let near_ones = spheres.iter().filter(|sphere| {
                let off = (sphere.center.distance(center) - sphere.radius).abs();
                let height = normal.dot(sphere.center - center).abs() - 0.01;
                off < 0.99 * near.radius && (crossed.is_none() || height.abs() < sphere.radius)
            });
            let missing = near_ones.filter(|sphere| {
                let center = Vec3A::from(sphere.center);
                !around.spheres.iter().any(|found| found.0 == center)
            });
            assert_eq!(missing.count(), 0);
        }
        assert!(found > 50, "{found} triangles were near");
    }

    #[test]
    fn of_too_many_shapes_the_nearest_are_found() {
        let flake = |row| Triangle {
            corners: [1, 2, 3].map(|salt| point(9, row) + 0.02 * point(salt, row)),
        };
        let flakes: Vec<Triangle> = (0..20 * SHAPES_MAX).map(flake).collect();
        let accelerator = Accelerator::build(&flakes, &[]);
        let center = Vec3A::splat(0.5);
        let distance = |corners: &[Vec3A; 3]| distance_to_triangle(center, corners);
        let mut distances: Vec<f32> =
            flakes.iter().map(|it| distance(&it.corners.map(Vec3A::from))).collect();
        distances.sort_by(f32::total_cmp);
        let mut around = Surroundings::default();
        around.find(&accelerator, &Neighborhood { center, radius: 1.0, crossed: None });
        let mut found: Vec<f32> = around.triangles.iter().map(distance).collect();
        found.sort_by(f32::total_cmp);
        assert_eq!(found[..SHAPES_MAX], distances[..SHAPES_MAX]);
        assert!(found.len() <= 2 * SHAPES_MAX, "{}", found.len());
    }

    #[test]
    fn of_many_shapes_in_one_place_some_are_found() {
        let flake = Triangle { corners: [Vec3::ZERO, Vec3::X, Vec3::Y] };
        let accelerator = Accelerator::build(&vec![flake; 10 * SHAPES_MAX], &[]);
        let near = Neighborhood { center: Vec3A::ZERO, radius: 0.1, crossed: None };
        let mut around = Surroundings::default();
        around.find(&accelerator, &near);
        assert!((SHAPES_MAX..=2 * SHAPES_MAX).contains(&around.len()), "{}", around.len());
    }
}
