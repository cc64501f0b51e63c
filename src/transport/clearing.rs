//! Where photons about a vertex count: the part of the kernel's ball or disk that nothing cuts off.
//!
//! Every shape that reaches into the kernel is kept out by a plane: that through its nearest point,
//! to which the way there is perpendicular. A triangle lies on one side of it, all of it, so what
//! is left is seen from the vertex, lies in its medium and on its side of every wall, and is
//! convex, so that its size can be computed. Over that size, and not over that of the whole ball or
//! disk, the sum over the photons in it is a density wherever the vertex is. On surfaces the disk
//! is looked at from a little above it and below: what stands on the surface cuts it, and what
//! leads away from it behind an edge; what lies in it does not. It ends where the surface does.
//! Where more shapes are about than there is room for, it is smaller.

mod cuts;

use std::f32::consts::{PI, TAU};
use std::sync::LazyLock;

use glam::Vec3A;

use crate::geometry::{Accelerator, FRONTS_MAX, Neighborhood, Planes, Rims, Shape, Surroundings};
use crate::math::elementary::{acos, cos, sin, sin_cos};
use crate::math::{F32s, LANES, Vector, lanes};

use self::cuts::{By, Cut, Plane, TOUCHING, cut_of_sphere, cut_of_triangle};

/// Planes that keep shapes out at most, the nearest; beyond, fine meshes mostly, it is a smaller
/// radius that does.
const PLANES_MAX: usize = FRONTS_MAX;
/// How far above and below a surface the disk is looked at, relative to the radius, and how far off
/// its plane photons may be: curved surfaces are.
const LIFT: f32 = 1.0 / 16.0;
/// How far planes on surfaces are moved towards the vertex, relative to the radius: photons of what
/// stands there lie on them.
const MARGIN: f32 = 1.0 / 1024.0;
/// Least radius where shapes are about on all sides, relative to what was asked for: smaller disks
/// would hardly ever hold a photon, and those would be too bright to be averaged.
const RADIUS_MIN: f32 = 1.0 / 6.0;
/// Shapes that are listed at most; the nearest of more are searched for one by one.
const LISTED_MAX: usize = 16;
/// Least part of a kernel, so that its reciprocal is a number.
const SHARE_MIN: f32 = 1e-3;
/// Directions by which sizes are computed where more than one plane cuts, in packets of eight.
const DIRECTIONS: usize = 128;
const PACKETS: usize = DIRECTIONS / LANES;

/// Cosines and sines of equal steps around a circle.
static CIRCLE: LazyLock<[[F32s; 2]; PACKETS]> = LazyLock::new(|| {
    let turn = |row: usize| TAU * row as f32 / DIRECTIONS as f32;
    std::array::from_fn(|packet| {
        let of = |part: fn(f32) -> f32| lanes::each(|lane| part(turn(packet * LANES + lane)));
        [F32s::from(of(cos)), F32s::from(of(sin))]
    })
});

/// A spiral of equal steps in height (Gonzalez 2010).
static SPIRAL: LazyLock<[Vector<F32s>; PACKETS]> = LazyLock::new(|| {
    let direction = |row: usize| {
        let height = 1.0 - (2.0 * row as f32 + 1.0) / DIRECTIONS as f32;
        let (sine, cosine) = sin_cos(TAU * 0.618_034 * row as f32);
        let flat = (1.0 - height * height).max(0.0).sqrt();
        [cosine * flat, sine * flat, height]
    };
    std::array::from_fn(|packet| Vector::gather(|lane| direction(packet * LANES + lane)))
});

/// Where photons count, and how much.
#[derive(Clone, Copy, Debug)]
pub struct Clearing {
    center: Vec3A,
    radius: f32,
    /// Normals and distances from the vertex of the planes before which photons count.
    planes: [(Vec3A, f32); PLANES_MAX],
    len: usize,
    /// Whether the radius is less than what was asked for.
    is_smaller: bool,
    /// The surface's normal, if it is on one, and how far off its plane photons may be.
    surface: Option<(Vec3A, f32)>,
    /// Center and radius of a sphere from which the ball cannot get out.
    shell: Option<(Vec3A, f32)>,
    /// What the kernel's height is multiplied by: the size of the whole ball or disk of the radius
    /// asked for over that of what is left.
    pub gain: f32,
}

/// What it takes to look around a vertex.
#[derive(Default)]
pub struct Nearby {
    surroundings: Surroundings,
    /// What reaches into the kernel, if that is not too much to list.
    cuts: Vec<Cut>,
}

impl Clearing {
    /// The part of the ball of `radius` about `center` that no surface cuts off. At the boundary of
    /// a medium, where kernels are one-sided, and what that makes wrong grows with the square of
    /// the radius, that is `at_boundary` at most.
    pub fn in_medium(
        center: [f32; 3],
        [radius, at_boundary]: [f32; 2],
        accelerator: &Accelerator,
        around: &mut Nearby,
    ) -> Self {
        let mut clearing = Self::whole(Vec3A::from(center), radius, None);
        let center = clearing.center;
        let mut search = Search {
            around,
            trees: [Some((accelerator, None)), None],
            cuts_of: |shape, _, offer: &mut dyn FnMut(Cut)| {
                offer(match shape {
                    Shape::Triangle(corners) => cut_of_triangle(center, &corners),
                    Shape::Sphere(middle, radius) => cut_of_sphere(center, (middle, radius)),
                });
            },
        };
        let is_listed = search.list(&clearing);
        while let Some(cut) = search.nearest(&clearing, is_listed) {
            if clearing.len == 0 {
                clearing.radius = radius.min(cut.distance.max(at_boundary));
            }
            if cut.distance >= clearing.radius {
                break;
            }
            if clearing.len == PLANES_MAX {
                clearing.radius = cut.distance.max(RADIUS_MIN * radius);
                break;
            }
            clearing.keep_out(&cut);
        }
        clearing.is_smaller = clearing.radius < radius;
        clearing.gain = (radius / clearing.radius).powi(3) / clearing.share_of_ball();
        clearing
    }

    /// The part of the disk of `radius` about `center` on a surface, whose unit `normal` points to
    /// where it is looked at from, that nothing cuts off which stands on it there.
    pub fn on_surface(
        center: [f32; 3],
        normal: Vec3A,
        (radius, offset): (f32, f32),
        (accelerator, rims): (&Accelerator, &Rims),
        around: &mut Nearby,
    ) -> Self {
        let (center, height) = (Vec3A::from(center), radius * LIFT);
        let clear = height_beside((center, normal), (height, offset), accelerator);
        let mut clearing = Self::whole(center, radius, Some((normal, clear)));
        let planes = Planes { normal, offset: -normal.dot(center), height };
        let axes = normal.any_orthonormal_pair();
        let [flat, lifted @ ..] =
            [0.0, height, -height].map(|height| Plane { center, normal, axes, height });
        let mut search = Search {
            around,
            trees: [Some((accelerator, Some(planes))), rims.tree().map(|tree| (tree, None))],
            cuts_of: |shape, is_rim, offer: &mut dyn FnMut(Cut)| {
                if let (true, Shape::Triangle([from, to, _])) = (is_rim, shape) {
                    return flat.cut_of_rim([from, to], height).into_iter().for_each(offer);
                }
                let cuts = lifted.iter().filter_map(|plane| match shape {
                    Shape::Triangle(corners) => plane.cut_of_triangle(&corners),
                    Shape::Sphere(middle, radius) => plane.cut_of_sphere((middle, radius)),
                });
                cuts.for_each(offer);
            },
        };
        let is_listed = search.list(&clearing);
        while let Some(cut) = search.nearest(&clearing, is_listed) {
            if clearing.len == PLANES_MAX {
                clearing.radius = cut.distance.max(RADIUS_MIN * radius);
                break;
            }
            clearing.keep_out(&cut);
            if clearing.radius <= cut.distance {
                break;
            }
        }
        for (_, distance) in &mut clearing.planes[..clearing.len] {
            *distance = (*distance - MARGIN * clearing.radius).max(0.0);
        }
        clearing.is_smaller = clearing.radius < radius;
        clearing.gain = (radius / clearing.radius).powi(2) / clearing.share_of_disk();
        clearing
    }

    fn whole(center: Vec3A, radius: f32, surface: Option<(Vec3A, f32)>) -> Self {
        let planes = [(Vec3A::ZERO, 0.0); PLANES_MAX];
        Self { center, radius, planes, len: 0, is_smaller: false, surface, shell: None, gain: 1.0 }
    }

    /// Whether what is to be kept out is out.
    fn has_out(&self, cut: &Cut) -> bool {
        if let By::Radius = cut.by {
            return false;
        }
        let (center, tolerance) = (self.center, TOUCHING * self.radius);
        self.planes[..self.len].iter().any(|(normal, distance)| {
            cut.points.iter().all(|point| normal.dot(*point - center) + distance <= tolerance)
        })
    }

    fn keep_out(&mut self, cut: &Cut) {
        let normal = match cut.by {
            By::Radius => {
                self.radius = cut.distance;
                return;
            }
            By::Plane(normal) => normal,
            By::Shell(normal, sphere) => {
                let smallest =
                    |shell: (Vec3A, f32)| if shell.1 < sphere.1 { shell } else { sphere };
                self.shell = Some(self.shell.map_or(sphere, smallest));
                normal
            }
        };
        self.planes[self.len] = (normal, cut.distance);
        self.len += 1;
    }

    /// What is left of the ball: closed for one plane, else the mean over directions of the cube
    /// of how far it goes.
    fn share_of_ball(&self) -> f32 {
        let share = match self.planes[..self.len] {
            [] => 1.0,
            [(_, distance)] if self.shell.is_none() => {
                let u = (distance / self.radius).min(1.0);
                (2.0 + u * (3.0 - u * u)) * 0.25
            }
            _ => self.mean(SPIRAL.iter().copied(), |reach| reach * reach * reach),
        };
        share.max(SHARE_MIN)
    }

    /// What is left of the disk: closed for one plane, else the mean over directions of the square
    /// of how far it goes.
    fn share_of_disk(&self) -> f32 {
        let Some((normal, _)) = self.surface else { return 1.0 };
        let share = match self.planes[..self.len] {
            [] => 1.0,
            [(_, distance)] => {
                let u = (distance / self.radius).clamp(0.0, 1.0);
                1.0 - (acos(u) - u * (1.0 - u * u).sqrt()) / PI
            }
            _ => {
                let (x, y) = normal.any_orthonormal_pair();
                let [x, y] = [x, y].map(|axis| Vector::splat(axis.to_array()));
                let directions = CIRCLE.iter().map(|&[cosine, sine]| x * cosine + y * sine);
                self.mean(directions, |reach| reach * reach)
            }
        };
        share.max(SHARE_MIN)
    }

    /// The mean over directions of a power of how far the clearing goes, relative to its radius.
    #[inline(always)]
    fn mean(
        &self,
        directions: impl Iterator<Item = Vector<F32s>>,
        power: impl Fn(F32s) -> F32s,
    ) -> f32 {
        let (mut sum, whole) = (F32s::splat(0.0), F32s::splat(self.radius));
        let shell = self.shell.map(|(middle, radius)| {
            let offset = self.center - middle;
            let within = (radius * radius - offset.length_squared()).max(0.0);
            (Vector::splat(offset.to_array()), F32s::splat(within))
        });
        for direction in directions {
            let mut reach = whole;
            if let Some((offset, within)) = shell {
                let along = offset.dot(direction);
                reach = reach.fast_min((along * along + within).sqrt() - along);
            }
            for (normal, distance) in &self.planes[..self.len] {
                let approach = -direction.dot(Vector::splat(normal.to_array()));
                let distance = F32s::splat(*distance);
                let meets = (approach * reach).simd_gt(distance);
                reach = meets.bitselect(distance / approach, reach);
            }
            sum += power(reach / whole);
        }
        sum.reduce_add() / DIRECTIONS as f32
    }

    /// Which of eight points, of those within the radius that was asked for, are in it.
    #[inline(always)]
    pub fn holds(&self, position: Vector<F32s>) -> F32s {
        let offset = position - Vector::splat(self.center.to_array());
        let mut held = lanes::first(LANES);
        if self.is_smaller {
            held = offset.length_squared().simd_le(F32s::splat(self.radius * self.radius));
        }
        if let Some((normal, most)) = self.surface {
            let height = offset.dot(Vector::splat(normal.to_array()));
            held &= height.abs().simd_le(F32s::splat(most));
        }
        for (normal, distance) in &self.planes[..self.len] {
            let before = offset.dot(Vector::splat(normal.to_array()));
            held &= before.simd_gt(F32s::splat(-distance));
        }
        held
    }
}

/// How far off the plane of a surface, up to `height`, photons may be: nearer to it than to others
/// that lie straight above or below. Rays start at `offset` from it.
fn height_beside(
    (center, normal): (Vec3A, Vec3A),
    (height, offset): (f32, f32),
    accelerator: &Accelerator,
) -> f32 {
    let free = |side: Vec3A| {
        let origin = center + side * offset;
        let hit = accelerator.closest(origin.into(), side.into(), 2.0 * height);
        0.5 * (offset + hit.t)
    };
    height.min(free(normal)).min(free(-normal))
}

/// Looks for what is to be kept out.
struct Search<'a, F> {
    around: &'a mut Nearby,
    /// All shapes, and the rims; and the planes that they must cross, if any.
    trees: [Option<(&'a Accelerator, Option<Planes>)>; 2],
    /// Offers the cuts of a shape, or of a rim.
    cuts_of: F,
}

impl<F: Fn(Shape, bool, &mut dyn FnMut(Cut))> Search<'_, F> {
    /// Lists all cuts within the radius of what is not cut yet; false if they are too many.
    fn list(&mut self, clearing: &Clearing) -> bool {
        let Nearby { surroundings, cuts } = &mut *self.around;
        cuts.clear();
        let ball = Neighborhood::ball(clearing.center, clearing.radius);
        for (tree, crossed, is_rim) in trees(&self.trees) {
            surroundings.look(tree, &Neighborhood { crossed, ..ball }, |shape| {
                (self.cuts_of)(shape, is_rim, &mut |cut: Cut| {
                    if cut.distance < clearing.radius && cuts.len() <= LISTED_MAX {
                        cuts.push(cut);
                    }
                });
                if cuts.len() <= LISTED_MAX { clearing.radius } else { 0.0 }
            });
        }
        cuts.len() <= LISTED_MAX
    }

    /// The nearest cut within the radius that is not out already.
    fn nearest(&mut self, clearing: &Clearing, is_listed: bool) -> Option<Cut> {
        if !is_listed {
            return self.search(clearing);
        }
        let is_left = |cut: &&Cut| cut.distance < clearing.radius && !clearing.has_out(cut);
        let left = self.around.cuts.iter().filter(is_left);
        left.min_by(|a, b| a.distance.total_cmp(&b.distance)).copied()
    }

    /// [`Self::nearest`] without the list.
    fn search(&mut self, clearing: &Clearing) -> Option<Cut> {
        let Clearing { center, radius, planes, len, .. } = clearing;
        let fronts = planes
            .map(|(normal, distance)| (normal, distance - normal.dot(*center) - TOUCHING * radius));
        let ball = Neighborhood::ball(*center, *radius);
        let (mut reach, mut nearest) = (*radius, None);
        for (tree, crossed, is_rim) in trees(&self.trees) {
            let near = Neighborhood { radius: reach, crossed, fronts, front_count: *len, ..ball };
            self.around.surroundings.look(tree, &near, |shape| {
                (self.cuts_of)(shape, is_rim, &mut |cut: Cut| {
                    if cut.distance < reach && !clearing.has_out(&cut) {
                        (reach, nearest) = (cut.distance, Some(cut));
                    }
                });
                reach
            });
        }
        nearest
    }
}

/// The trees that there are, and whether each is of rims.
fn trees<'a>(
    trees: &[Option<(&'a Accelerator, Option<Planes>)>; 2],
) -> impl Iterator<Item = (&'a Accelerator, Option<Planes>, bool)> {
    let [shapes, rims] = *trees;
    let of = |is_rim| move |(tree, crossed)| (tree, crossed, is_rim);
    shapes.map(of(false)).into_iter().chain(rims.map(of(true)))
}

#[cfg(test)]
mod tests;
