//! Ray against triangle and ray against sphere, eight at a time: one ray and eight primitives, or
//! eight rays and one primitive.

use crate::math::{F32s, U32s, Vector};
use crate::scene::baked::NONE;

/// Origins that are alike differ by less than this, relative to the scene.
const ALIKE_ORIGINS: f32 = 0.02;
/// Directions that are alike differ by less than this.
const ALIKE_DIRECTIONS: f32 = 0.1;

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
    pub local: Vector<F32s>,
    /// Slope of the ray along the first two renamed axes.
    pub shear: [F32s; 2],
    /// Ray parameter per length along the last renamed axis.
    pub scale: F32s,
}

/// The edges of eight triangles, seen along the rays.
struct Sides {
    /// Twice the areas that the rays span with the edges opposite to each corner, signed.
    weights: [F32s; 3],
    /// Depths of the corners along the last renamed axis.
    depths: [F32s; 3],
    /// Where no two weights differ in sign.
    inside: F32s,
}

impl Sides {
    /// On which side of each edge the rays pass, of triangles as they see them.
    #[inline(always)]
    fn new(a: Vector<F32s>, b: Vector<F32s>, c: Vector<F32s>) -> Self {
        // Never fused: rounding each product is what makes a sign right or zero.
        let weights = [c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x];
        let smallest = weights[0].fast_min(weights[1]).fast_min(weights[2]);
        let largest = weights[0].fast_max(weights[1]).fast_max(weights[2]);
        let inside = smallest.simd_ge(F32s::ZERO) | largest.simd_le(F32s::ZERO);
        Self { weights, depths: [a.z, b.z, c.z], inside }
    }
}

/// What eight tests found; only lanes in `mask` count.
pub(super) struct Candidates {
    pub t: F32s,
    pub u: F32s,
    pub v: F32s,
    /// Where there is a hit with `t > 0`.
    pub mask: F32s,
}

/// The renamed axes when the last is `main`, in cyclic order.
#[inline(always)]
pub(super) fn renamed(main: usize) -> [usize; 3] {
    [[1, 2, 0], [2, 0, 1], [0, 1, 2]][main]
}

impl Rays {
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

    /// Tests triangles, corners with their axes renamed; stops early where nothing is inside. `u`
    /// and `v` are the barycentric weights of the second and the third corner.
    #[inline(always)]
    pub fn meet_triangles(&self, corners: [Vector<F32s>; 3]) -> Option<Candidates> {
        let [a, b, c] = corners;
        let sides = Sides::new(self.sheared(a), self.sheared(b), self.sheared(c));
        sides.inside.any().then(|| self.cross(&sides))
    }

    /// [`Rays::meet_triangles`] with corners from [`Rays::sheared`]. With `HOPEFUL` it does not
    /// stop early, as that costs more than it saves if something mostly is inside.
    #[inline(always)]
    pub fn meet_sheared<const HOPEFUL: bool>(
        &self,
        a: Vector<F32s>,
        b: Vector<F32s>,
        c: Vector<F32s>,
    ) -> Option<Candidates> {
        let sides = Sides::new(a, b, c);
        (HOPEFUL || sides.inside.any()).then(|| self.cross(&sides))
    }

    /// Whether the rays start close to each other and run alike, within a scene of coordinates up
    /// to `reach`, so that most primitives are met by all or by none.
    #[inline(always)]
    pub fn are_alike(origin: Vector<F32s>, direction: Vector<F32s>, reach: f32) -> bool {
        let deviation = |vector: Vector<F32s>| {
            let of = |lanes: F32s| (lanes - F32s::splat(lanes.as_array()[0])).abs();
            of(vector.x).fast_max(of(vector.y)).fast_max(of(vector.z))
        };
        let near = deviation(origin).simd_le(F32s::splat(ALIKE_ORIGINS * reach));
        let along = deviation(direction).simd_le(F32s::splat(ALIKE_DIRECTIONS));
        (near & along).all()
    }

    /// A point with its axes renamed as the rays see it, along themselves.
    #[inline(always)]
    pub fn sheared(&self, point: Vector<F32s>) -> Vector<F32s> {
        let from = point - self.local;
        Vector {
            x: from.z.mul_neg_add(self.shear[0], from.x),
            y: from.z.mul_neg_add(self.shear[1], from.y),
            z: from.z,
        }
    }

    /// Where the rays cross the planes of the triangles.
    #[inline(always)]
    fn cross(&self, sides: &Sides) -> Candidates {
        let [a, b, c] = sides.weights;
        let inverse = F32s::ONE / (a + b + c);
        let depth = a.mul_add(sides.depths[0], b.mul_add(sides.depths[1], c * sides.depths[2]));
        let t = depth * self.scale * inverse;
        let mask = sides.inside & t.simd_gt(F32s::ZERO);
        Candidates { t, u: b * inverse, v: c * inverse, mask }
    }

    /// Tests spheres, and stops early where none is near: the discriminant from the distance of
    /// the ray to the center (Haines et al. 2019, "Precision Improvements for Ray/Sphere
    /// Intersection", Ray Tracing Gems 7). From inside the far root counts.
    #[inline(always)]
    pub fn meet_spheres(&self, center: Vector<F32s>, radius_squared: F32s) -> Option<Candidates> {
        let [near, far, is_near] = self.cross_spheres(center, radius_squared)?;
        let t = near.simd_gt(F32s::ZERO).select(near, far);
        let mask = is_near & t.simd_gt(F32s::ZERO);
        Some(Candidates { t, u: F32s::ZERO, v: F32s::ZERO, mask })
    }

    /// [`Rays::meet_spheres`] with both roots.
    #[inline(always)]
    pub fn meet_spheres_twice(
        &self,
        center: Vector<F32s>,
        radius_squared: F32s,
    ) -> Option<[Candidates; 2]> {
        let [near, far, is_near] = self.cross_spheres(center, radius_squared)?;
        Some([near, far].map(|t| {
            let mask = is_near & t.simd_gt(F32s::ZERO);
            Candidates { t, u: F32s::ZERO, v: F32s::ZERO, mask }
        }))
    }

    /// Where the rays enter and leave the spheres, and which of them do.
    #[inline(always)]
    fn cross_spheres(&self, center: Vector<F32s>, radius_squared: F32s) -> Option<[F32s; 3]> {
        let from = self.origin - center;
        let length_squared = self.direction.length_squared();
        // The same for all spheres, so that it is divided by once.
        let inverse = F32s::ONE / length_squared;
        let towards = -from.dot(self.direction);
        let closest = self.direction.mul_add(towards * inverse, from);
        let discriminant = length_squared * (radius_squared - closest.length_squared());
        let is_near = discriminant.simd_ge(F32s::ZERO);
        if !is_near.any() {
            return None;
        }
        let root = discriminant.sqrt();
        let q = towards + towards.simd_ge(F32s::ZERO).select(root, -root);
        let first = (from.length_squared() - radius_squared) / q;
        let second = q * inverse;
        Some([first.fast_min(second), first.fast_max(second), is_near])
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
    #[inline(always)]
    fn of(direction: Vector<F32s>) -> Self {
        let [x, y, z] = [direction.x.abs(), direction.y.abs(), direction.z.abs()];
        let main_x = x.simd_ge(y) & x.simd_ge(z);
        Self { main_x, main_y: !main_x & y.simd_ge(z) }
    }

    /// The axis that becomes the last; the smallest index of several as long.
    #[inline(always)]
    pub fn main_axis(self) -> U32s {
        let [one, two] = [1, 2].map(U32s::splat);
        self.main_x.select(U32s::splat(0), self.main_y.select(one, two))
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

    /// Takes over what is nearer, of what comes after hits, by their distances and primitives;
    /// primitives come in ascending order.
    #[inline(always)]
    pub fn offer_beyond(&mut self, (t, last): (F32s, U32s), found: &Candidates, primitive: u32) {
        let primitive = U32s::splat(primitive);
        let is_higher: F32s = bytemuck::cast(primitive.simd_gt(last));
        let is_beyond = found.t.simd_gt(t) | found.t.simd_eq(t) & is_higher;
        let mask = found.mask & is_beyond & found.t.simd_lt(self.t);
        self.replace(mask, found, primitive);
    }

    /// Takes over what is nearer; primitives come in ascending order.
    #[inline(always)]
    pub fn offer_in_order(&mut self, found: &Candidates, primitive: u32) {
        let mask = found.mask & found.t.simd_lt(self.t);
        self.replace(mask, found, U32s::splat(primitive));
    }
}
