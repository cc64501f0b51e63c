//! Ray against triangle and ray against sphere, eight at a time: one ray and eight primitives, or
//! eight rays and one primitive.

use glam::Vec3;

use crate::math::{F32s, U32s, Vector};
use crate::scene::baked::NONE;

/// Eight rays, or eight times the same, prepared for the kernels.
///
/// The triangle test is that of Woop, Benthin and Wald 2013, "Watertight Ray/Triangle
/// Intersection": the axes are renamed so that the ray advances most along the last, then sheared
/// so that it runs along it. A vertex shared by several triangles becomes the same two numbers in
/// all of them, and the sign of an edge function is right or zero, so nothing slips between two
/// triangles that share an edge or a corner.
#[derive(Clone, Copy)]
pub(super) struct Rays {
    /// Origin.
    pub origin: Vector<F32s>,
    /// Direction, of any length but zero.
    pub direction: Vector<F32s>,
    /// Origin with its axes renamed.
    local: Vector<F32s>,
    /// Slope of the ray along the first two renamed axes.
    shear: [F32s; 2],
    /// Ray parameter per length along the last renamed axis.
    scale: F32s,
}

/// What eight tests found; only lanes in `mask` count.
pub(super) struct Candidates {
    pub t: F32s,
    pub u: F32s,
    pub v: F32s,
    /// Where there is a hit with `t > 0`.
    pub mask: F32s,
}

/// The axis along which `direction` advances most; the smallest index of several.
#[inline(always)]
pub(super) fn main_axis(direction: Vec3) -> usize {
    let [x, y, z] = direction.abs().to_array();
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// The renamed axes when the last is `main`, in cyclic order.
#[inline(always)]
pub(super) fn renamed(main: usize) -> [usize; 3] {
    [[1, 2, 0], [2, 0, 1], [0, 1, 2]][main]
}

/// `vector` in all lanes.
#[inline(always)]
pub(super) fn splat(vector: [f32; 3]) -> Vector<F32s> {
    Vector::new(F32s::splat(vector[0]), F32s::splat(vector[1]), F32s::splat(vector[2]))
}

impl Rays {
    /// One ray in all lanes; `axes` from [`renamed`].
    #[inline(always)]
    pub fn one(origin: Vec3, direction: Vec3, axes: [usize; 3]) -> Self {
        let (o, d) = (origin.to_array(), direction.to_array());
        let [x, y, z] = axes;
        let scale = 1.0 / d[z];
        Self {
            origin: splat(o),
            direction: splat(d),
            local: splat([o[x], o[y], o[z]]),
            shear: [F32s::splat(d[x] * scale), F32s::splat(d[y] * scale)],
            scale: F32s::splat(scale),
        }
    }

    /// Eight rays, and how each renames its axes.
    #[inline(always)]
    pub fn eight(origin: Vector<F32s>, direction: Vector<F32s>) -> (Self, Renaming) {
        let renaming = Renaming::of(direction);
        let local = renaming.apply(direction);
        let scale = F32s::ONE / local.z;
        let rays = Self {
            origin,
            direction,
            local: renaming.apply(origin),
            shear: [local.x * scale, local.y * scale],
            scale,
        };
        (rays, renaming)
    }

    /// Tests triangles, corners with their axes renamed. `u` and `v` are the barycentric weights
    /// of the second and the third corner.
    #[inline(always)]
    pub fn meet_triangles(&self, corners: [Vector<F32s>; 3]) -> Candidates {
        let [a, b, c] = corners.map(|corner| {
            let from = corner - self.local;
            Vector {
                x: from.z.mul_neg_add(self.shear[0], from.x),
                y: from.z.mul_neg_add(self.shear[1], from.y),
                z: from.z,
            }
        });
        // Never fused: rounding each product is what makes a sign right or zero.
        let weight_a = c.x * b.y - c.y * b.x;
        let weight_b = a.x * c.y - a.y * c.x;
        let weight_c = b.x * a.y - b.y * a.x;
        let smallest = weight_a.fast_min(weight_b).fast_min(weight_c);
        let largest = weight_a.fast_max(weight_b).fast_max(weight_c);
        let inside = smallest.simd_ge(F32s::ZERO) | largest.simd_le(F32s::ZERO);
        let inverse = F32s::ONE / (weight_a + weight_b + weight_c);
        let depth = weight_a.mul_add(a.z, weight_b.mul_add(b.z, weight_c * c.z));
        let t = depth * self.scale * inverse;
        Candidates {
            t,
            u: weight_b * inverse,
            v: weight_c * inverse,
            mask: inside & t.simd_gt(F32s::ZERO),
        }
    }

    /// Tests spheres: the discriminant from the distance of the ray to the center (Haines et al.
    /// 2019, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems 7). From
    /// inside the far root counts.
    #[inline(always)]
    pub fn meet_spheres(&self, center: Vector<F32s>, radius_squared: F32s) -> Candidates {
        let from = self.origin - center;
        let length_squared = self.direction.length_squared();
        let towards = -from.dot(self.direction);
        let closest = self.direction.mul_add(towards / length_squared, from);
        let discriminant = length_squared * (radius_squared - closest.length_squared());
        let root = discriminant.sqrt();
        let q = towards + towards.simd_ge(F32s::ZERO).select(root, -root);
        let first = (from.length_squared() - radius_squared) / q;
        let second = q / length_squared;
        let near = first.fast_min(second);
        let far = first.fast_max(second);
        let t = near.simd_gt(F32s::ZERO).select(near, far);
        let mask = discriminant.simd_ge(F32s::ZERO) & t.simd_gt(F32s::ZERO);
        Candidates { t, u: F32s::ZERO, v: F32s::ZERO, mask }
    }
}

/// Per lane, how the axes are renamed.
#[derive(Clone, Copy)]
pub(super) struct Renaming {
    /// Where x becomes the last axis.
    main_x: F32s,
    /// Where y becomes the last axis.
    main_y: F32s,
}

impl Renaming {
    /// As [`main_axis`] chooses.
    #[inline(always)]
    fn of(direction: Vector<F32s>) -> Self {
        let [x, y, z] = [direction.x.abs(), direction.y.abs(), direction.z.abs()];
        let main_x = x.simd_ge(y) & x.simd_ge(z);
        Self { main_x, main_y: !main_x & y.simd_ge(z) }
    }

    /// The vector with its axes renamed, as [`renamed`] does.
    #[inline(always)]
    pub fn apply(self, v: Vector<F32s>) -> Vector<F32s> {
        let cycle = |if_x: F32s, if_y: F32s, if_z: F32s| {
            self.main_x.select(if_x, self.main_y.select(if_y, if_z))
        };
        Vector::new(cycle(v.y, v.z, v.x), cycle(v.z, v.x, v.y), cycle(v.x, v.y, v.z))
    }
}

/// The nearest hit so far, lane by lane.
#[derive(Clone, Copy)]
pub(super) struct Nearest {
    pub t: F32s,
    pub u: F32s,
    pub v: F32s,
    pub primitive: U32s,
}

impl Nearest {
    /// Nothing yet; only what is nearer than `t_max` will count.
    #[inline(always)]
    pub fn none(t_max: F32s) -> Self {
        Self { t: t_max, u: F32s::ZERO, v: F32s::ZERO, primitive: U32s::splat(NONE) }
    }

    #[inline(always)]
    fn replace(&mut self, mask: F32s, found: &Candidates, primitive: U32s) {
        self.t = mask.select(found.t, self.t);
        self.u = mask.select(found.u, self.u);
        self.v = mask.select(found.v, self.v);
        self.primitive = mask.select(primitive, self.primitive);
    }

    /// Takes over what is nearer, or as near with a smaller primitive; whether there was any.
    /// As a signed number [`NONE`] is smaller than all, so a hit at `t_max` does not count.
    #[inline(always)]
    pub fn offer(&mut self, found: &Candidates, primitive: U32s) -> bool {
        let candidates = found.mask & found.t.simd_le(self.t);
        if !candidates.any() {
            return false;
        }
        let smaller = primitive.cast_signed().simd_lt(self.primitive.cast_signed());
        let smaller = F32s::from_bits(smaller.cast_unsigned());
        let mask = candidates & (found.t.simd_lt(self.t) | smaller);
        self.replace(mask, found, primitive);
        true
    }

    /// [`Nearest::offer`] when primitives come in ascending order.
    #[inline(always)]
    pub fn offer_in_order(&mut self, found: &Candidates, primitive: u32) {
        let mask = found.mask & found.t.simd_lt(self.t);
        self.replace(mask, found, U32s::splat(primitive));
    }

    /// The distance of the nearest of all lanes.
    #[inline(always)]
    pub fn smallest_t(&self) -> f32 {
        let [a, b, c, d, e, f, g, h] = self.t.to_array();
        let least = |a: f32, b: f32| if a < b { a } else { b };
        least(least(least(a, b), least(c, d)), least(least(e, f), least(g, h)))
    }
}
