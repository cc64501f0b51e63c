//! What lies near a point: the shapes that cut into a small ball or disk about it.

use glam::{Affine3A, Mat3A, Vec3A};

use crate::math::{F32s, LANES, Vector, lanes};

use super::accelerator::Accelerator;
use super::block::{Node, Reference, TriangleBlock};
use super::tree::View;

/// Bounds are taken to be this much wider than they are, relative to the coordinates.
const PADDING: f32 = 4.0 * f32::EPSILON;
/// Planes at most before which shapes are looked for.
pub const FRONTS_MAX: usize = 4;

/// Where shapes are looked for.
#[derive(Clone, Copy, Debug)]
pub struct Neighborhood {
    /// Middle of a ball.
    pub center: Vec3A,
    /// Radius of the ball, in scene units.
    pub radius: f32,
    /// A pair of planes of which shapes must cross one, if any.
    pub crossed: Option<Planes>,
    /// Planes of all points `p` with `n . p + o = 0`, by `n` and `o`: what is all where that is
    /// negative, for one of them, need not be found.
    pub fronts: [(Vec3A, f32); FRONTS_MAX],
    /// How many of these there are.
    pub front_count: usize,
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

/// A shape that is near.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// Corners of a triangle.
    Triangle([Vec3A; 3]),
    /// Center and radius of a sphere.
    Sphere(Vec3A, f32),
}

/// What it takes to look around, and how far is left to look.
#[derive(Clone, Debug, Default)]
pub struct Surroundings {
    /// What is yet to be looked at, and the square of how far off it is.
    stack: Vec<(Reference, f32)>,
    reach: f32,
}

impl Surroundings {
    /// Shows the shapes whose surfaces may be in the neighborhood. None that are is missing, but
    /// those farther off than what `offer` answers when it is shown one.
    pub fn look(
        &mut self,
        accelerator: &Accelerator,
        near: &Neighborhood,
        mut offer: impl FnMut(Shape) -> f32,
    ) {
        self.stack.clear();
        self.reach = near.radius;
        self.look_through(&accelerator.tree.view(), near, (1.0, None), &mut offer);
    }

    /// Looks through a tree; `near` is in its space, which is so many times as large as the world
    /// and which `to_world` leads out of.
    fn look_through(
        &mut self,
        tree: &View,
        near: &Neighborhood,
        (stretch, to_world): (f32, Option<&Affine3A>),
        offer: &mut impl FnMut(Shape) -> f32,
    ) {
        let bottom = self.stack.len();
        let probe = Probe::new(near, tree.reach);
        self.stack.push((tree.root, 0.0));
        while self.stack.len() > bottom {
            let Some((next, distance_squared)) = self.stack.pop() else { return };
            let limit = (stretch * self.reach + probe.slack).powi(2);
            if distance_squared > limit {
                continue;
            }
            if !next.is_leaf() {
                self.push_children(&tree.nodes[next.row()], &probe, limit);
            } else if next.is_of_triangles() {
                for block in &tree.triangle_blocks[next.blocks()] {
                    for triangle in probe.triangles(block, limit) {
                        let in_world =
                            |corner| to_world.map_or(corner, |map| map.transform_point3a(corner));
                        self.reach = offer(Shape::Triangle(triangle.map(in_world)));
                    }
                }
            } else if let Some(row) = next.as_instance() {
                let instance = &tree.instances[row];
                let object = &tree.objects[instance.object as usize].view();
                let near = Neighborhood { radius: self.reach, ..*near };
                let (inside, stretch) = near.inside(&instance.to_world, &instance.to_object);
                self.look_through(object, &inside, (stretch, Some(&instance.to_world)), offer);
            } else {
                for block in &tree.sphere_blocks[next.blocks()] {
                    for (center, radius) in block.spheres() {
                        if near.meets_sphere((center, radius)) {
                            self.reach = offer(Shape::Sphere(center, radius));
                        }
                    }
                }
            }
        }
    }

    /// Puts the children that are near on the stack, the nearest on top.
    fn push_children(&mut self, node: &Node, probe: &Probe, limit: f32) {
        let (distances, mask) = probe.meet_bounds(node, limit);
        let first = self.stack.len();
        self.stack.extend(lanes_of(mask).map(|lane| (node.children[lane], distances[lane])));
        let pushed = &mut self.stack[first..];
        let nearest = (0..pushed.len()).min_by(|&a, &b| pushed[a].1.total_cmp(&pushed[b].1));
        if let Some(nearest) = nearest {
            let last = pushed.len() - 1;
            pushed.swap(nearest, last);
        }
    }
}

impl Neighborhood {
    /// A ball.
    pub fn ball(center: Vec3A, radius: f32) -> Self {
        let fronts = [(Vec3A::ZERO, 0.0); FRONTS_MAX];
        Self { center, radius, crossed: None, fronts, front_count: 0 }
    }

    /// The same in the space of an instance, for a ball that holds what becomes of this one, and
    /// how many times as large that is.
    fn inside(&self, to_world: &Affine3A, to_object: &Mat3A) -> (Self, f32) {
        let [x, y, z] = [to_object.x_axis, to_object.y_axis, to_object.z_axis];
        let stretch = (x.length_squared() + y.length_squared() + z.length_squared()).sqrt();
        let inside = |(normal, offset): (Vec3A, f32)| {
            (to_world.matrix3.transpose() * normal, offset + normal.dot(to_world.translation))
        };
        let crossed = self.crossed.map(|Planes { normal, offset, height }| {
            let (normal, offset) = inside((normal, offset));
            Planes { normal, offset, height }
        });
        let near = Self {
            center: *to_object * (self.center - to_world.translation),
            radius: self.radius * stretch,
            crossed,
            fronts: self.fronts.map(inside),
            front_count: self.front_count,
        };
        (near, stretch)
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

/// A neighborhood for eight tests at a time.
struct Probe {
    center: Vector<F32s>,
    /// How much wider everything is taken to be, for rounding.
    slack: f32,
    /// The planes to be crossed, and their height.
    crossed: Option<(Front, F32s)>,
    fronts: [Front; FRONTS_MAX],
    front_count: usize,
}

/// A plane in all lanes.
#[derive(Clone, Copy)]
struct Front {
    normal: Vector<F32s>,
    offset: F32s,
    slack: F32s,
}

impl Front {
    const NONE: Self = Self {
        normal: Vector { x: F32s::ZERO, y: F32s::ZERO, z: F32s::ZERO },
        offset: F32s::ZERO,
        slack: F32s::ZERO,
    };

    fn new((normal, offset): (Vec3A, f32), slack: f32) -> Self {
        let slack = F32s::splat(slack * normal.abs().element_sum());
        Self { normal: Vector::splat(normal.to_array()), offset: F32s::splat(offset), slack }
    }

    /// The lowest and the highest of boxes, by their middles and half edges.
    #[inline(always)]
    fn of_boxes(&self, middle: Vector<F32s>, half: Vector<F32s>) -> [F32s; 2] {
        let at = middle.dot(self.normal) + self.offset;
        let [x, y, z] = [self.normal.x, self.normal.y, self.normal.z].map(|it| it.abs());
        let around = x * half.x + y * half.y + z * half.z + self.slack;
        [at - around, at + around]
    }

    /// The lowest and the highest of triangles.
    #[inline(always)]
    fn of_triangles(&self, corners: &[Vector<F32s>; 3]) -> [F32s; 2] {
        let [a, b, c] = corners.map(|corner| corner.dot(self.normal) + self.offset);
        let (lower, upper) = (a.fast_min(b).fast_min(c), a.fast_max(b).fast_max(c));
        [lower - self.slack, upper + self.slack]
    }
}

impl Probe {
    /// That of a neighborhood in a tree whose largest coordinate is `reach`.
    fn new(near: &Neighborhood, reach: f32) -> Self {
        let slack = (near.center.abs().max_element() + reach) * PADDING;
        let crossed = near.crossed.map(|Planes { normal, offset, height }| {
            (Front::new((normal, offset), slack), F32s::splat(height))
        });
        let mut fronts = [Front::NONE; FRONTS_MAX];
        for (to, front) in fronts.iter_mut().zip(&near.fronts[..near.front_count]) {
            *to = Front::new(*front, slack);
        }
        Self {
            center: Vector::splat(near.center.to_array()),
            slack,
            crossed,
            fronts,
            front_count: near.front_count,
        }
    }

    /// The squared distances of children's bounds, and which may hold what is looked for.
    #[inline(always)]
    fn meet_bounds(&self, node: &Node, limit: f32) -> ([f32; LANES], u32) {
        let [[x, below_x], [y, below_y], [z, below_z]] = node.bounds;
        let (lower, upper) = (Vector::new(x, y, z), Vector::new(below_x, below_y, below_z));
        let squared = self.distances_squared(lower, upper);
        let half = F32s::splat(0.5);
        let (middle, half) = ((lower + upper) * half, (upper - lower) * half);
        let mask = squared.simd_le(F32s::splat(limit));
        let mask = mask & self.admits(|front| front.of_boxes(middle, half));
        (squared.to_array(), mask.to_bitmask())
    }

    /// The triangles of a block that may be what is looked for.
    #[inline(always)]
    fn triangles(
        &self,
        block: &TriangleBlock,
        limit: f32,
    ) -> impl Iterator<Item = [Vec3A; 3]> + use<> {
        let corners = block.corners([0, 1, 2]);
        let [a, b, c] = corners;
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
        let mask = self.distances_squared(lower, upper).simd_le(F32s::splat(limit));
        let mask = mask & self.admits(|front| front.of_triangles(&corners));
        let of_lane = move |lane| {
            corners.map(|corner: Vector<F32s>| Vec3A::from(<[f32; 3]>::from(corner.lane(lane))))
        };
        // Vacant lanes are points.
        lanes_of(mask.to_bitmask()).map(of_lane).filter(|[a, b, c]| a != b || b != c)
    }

    /// What crosses and is not behind, by its lowest and its highest over a plane.
    #[inline(always)]
    fn admits(&self, extent: impl Fn(&Front) -> [F32s; 2]) -> F32s {
        let mut mask = lanes::first(LANES);
        if let Some((planes, height)) = &self.crossed {
            let [lower, upper] = extent(planes);
            let crosses = |height: F32s| lower.simd_le(height) & upper.simd_ge(height);
            mask = crosses(*height) | crosses(-*height);
        }
        for front in &self.fronts[..self.front_count] {
            mask &= extent(front)[1].simd_gt(F32s::splat(0.0));
        }
        mask
    }

    #[inline(always)]
    fn distances_squared(&self, lower: Vector<F32s>, upper: Vector<F32s>) -> F32s {
        let zero = F32s::splat(0.0);
        let off =
            |lower: F32s, upper: F32s, at: F32s| (lower - at).fast_max(at - upper).fast_max(zero);
        let off = Vector::new(
            off(lower.x, upper.x, self.center.x),
            off(lower.y, upper.y, self.center.y),
            off(lower.z, upper.z, self.center.z),
        );
        off.length_squared()
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
            let front = (point(22, query) - Vec3::splat(0.5)).normalize();
            let mut near = Neighborhood::ball(center.into(), 0.05);
            near.crossed = (query % 2 == 1).then_some(planes);
            near.fronts[0] = (front.into(), 0.01 - front.dot(center));
            near.front_count = query / 2 % 2;
            let (mut flakes, mut balls) = (Vec::new(), Vec::new());
            around.look(&accelerator, &near, |shape| {
                match shape {
                    Shape::Triangle(corners) => flakes.push(corners),
                    Shape::Sphere(center, _) => balls.push(center),
                }
                near.radius
            });
            for triangle in &triangles {
                let is_near = points(triangle).any(|point| point.distance(center) < near.radius);
                let crosses = near.crossed.is_none()
                    || [0.01, -0.01].into_iter().any(|height| {
                        let below = |corner| normal.dot(corner - center) < height;
                        let signs = triangle.corners.map(below);
                        signs != [signs[0]; 3]
                    });
                let is_before = near.front_count == 0
                    || triangle.corners.iter().any(|&it| front.dot(it - center) > -0.01);
                let is_wanted = is_near && crosses && is_before;
                let is_found = flakes.contains(&triangle.corners.map(Vec3A::from));
                assert!(is_found || !is_wanted, "{triangle:?}");
                found += usize::from(is_wanted);
            }
            let near_ones = spheres.iter().filter(|sphere| {
                let off = (sphere.center.distance(center) - sphere.radius).abs();
                let height = normal.dot(sphere.center - center).abs() - 0.01;
                let crosses = near.crossed.is_none() || height.abs() < sphere.radius;
                let before = front.dot(sphere.center - center) + 0.01 + sphere.radius;
                let is_before = near.front_count == 0 || before > 1e-5;
                off < 0.99 * near.radius && crosses && is_before
            });
            let missing = near_ones.filter(|sphere| !balls.contains(&Vec3A::from(sphere.center)));
            assert_eq!(missing.count(), 0);
        }
        assert!(found > 50, "{found} triangles were near");
    }

    #[test]
    fn the_nearest_of_many_shapes_is_found_without_looking_at_all() {
        let flake = |row| Triangle {
            corners: [1, 2, 3].map(|salt| point(9, row) + 0.02 * point(salt, row)),
        };
        let flakes: Vec<Triangle> = (0..5000).map(flake).collect();
        let accelerator = Accelerator::build(&flakes, &[]);
        let center = Vec3A::splat(0.5);
        let distance =
            |corners: &[Vec3A; 3]| (center - nearest_in_triangle(center, corners)).length();
        let distances = flakes.iter().map(|it| distance(&it.corners.map(Vec3A::from)));
        let nearest = distances.fold(f32::INFINITY, f32::min);
        let (mut found, mut shown) = (1.0, 0);
        Surroundings::default().look(&accelerator, &Neighborhood::ball(center, 1.0), |shape| {
            if let Shape::Triangle(corners) = shape {
                found = distance(&corners).min(found);
            }
            shown += 1;
            found
        });
        assert_eq!(found, nearest);
        assert!(shown < 100, "{shown} were shown");
    }
}
