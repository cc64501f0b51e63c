//! Where photons about a vertex count: the part of the kernel's ball or disk that nothing cuts off.
//!
//! Every shape that reaches into the kernel is kept out by a plane: that through its nearest point,
//! to which the way there is perpendicular. A triangle lies on one side of it, all of it, so what
//! is left is seen from the vertex, lies in its medium and on its side of every wall, and is
//! convex, so that its size can be computed. Over that size, and not over that of the whole ball or
//! disk, the sum over the photons in it is a density wherever the vertex is. On surfaces the disk
//! is looked at from a little above it and below: what stands on the surface cuts it, and what
//! leads away from it behind an edge; what lies in it does not.

use std::f32::consts::{PI, TAU};
use std::sync::LazyLock;

use glam::{Vec2, Vec3A};

use crate::geometry::{
    Accelerator, FRONTS_MAX, Neighborhood, Planes, Shape, Surroundings, nearest_in_triangle,
};
use crate::math::{F32s, LANES, Vector, lanes};

/// Planes that keep shapes out at most, the nearest: more is cut off by fine meshes alone, of which
/// a smaller kernel meets less.
const PLANES_MAX: usize = FRONTS_MAX;
/// How far above and below a surface the disk is looked at, relative to the radius.
const LIFT: f32 = 1.0 / 16.0;
/// How far off the disk's plane photons may be, relative to the radius: curved surfaces are.
const THICKNESS: f32 = 1.0 / 4.0;
/// How far planes on surfaces are moved towards the vertex, relative to the radius: photons of what
/// stands there lie on them.
const MARGIN: f32 = 1.0 / 1024.0;
/// Nearer than this, relative to the radius, the way to a shape does not tell its side.
const TOUCHING: f32 = 1e-4;
/// So near to the middle of a ring, relative to its radius, a disk ends where it meets that.
const ROUND: f32 = 0.75;
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
        [F32s::from(of(f32::cos)), F32s::from(of(f32::sin))]
    })
});

/// A spiral of equal steps in height (Gonzalez 2010).
static SPIRAL: LazyLock<[Vector<F32s>; PACKETS]> = LazyLock::new(|| {
    let direction = |row: usize| {
        let height = 1.0 - (2.0 * row as f32 + 1.0) / DIRECTIONS as f32;
        let (sine, cosine) = (TAU * 0.618_034 * row as f32).sin_cos();
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
    /// The surface's normal, if it is on one.
    normal: Option<Vec3A>,
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

/// A shape that is to be kept out.
#[derive(Clone, Copy)]
struct Cut {
    distance: f32,
    by: By,
    /// Points that say all about where it is; none lies anywhere else.
    points: [Vec3A; 3],
}

/// How a shape is kept out.
#[derive(Clone, Copy)]
enum By {
    /// A plane, with the unit vector from it to the vertex.
    Plane(Vec3A),
    /// The same for a sphere that the vertex is in.
    Shell(Vec3A, (Vec3A, f32)),
    /// A smaller radius.
    Radius,
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
            accelerator,
            crossed: None,
            cuts_of: |shape, offer: &mut dyn FnMut(Cut)| {
                offer(match shape {
                    Shape::Triangle(corners) => cut_of_triangle(center, &corners),
                    Shape::Sphere(middle, radius) => cut_of_sphere(center, (middle, radius)),
                });
            },
        };
        let is_listed = search.list(&clearing);
        for count in 0..PLANES_MAX {
            let Some(cut) = search.nearest(&clearing, is_listed) else { break };
            if count == 0 {
                clearing.radius = radius.min(cut.distance.max(at_boundary));
            }
            if cut.distance >= clearing.radius {
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
        radius: f32,
        accelerator: &Accelerator,
        around: &mut Nearby,
    ) -> Self {
        let mut clearing = Self::whole(Vec3A::from(center), radius, Some(normal));
        let (center, height) = (clearing.center, radius * LIFT);
        let planes = Planes { normal, offset: -normal.dot(center), height };
        let axes = normal.any_orthonormal_pair();
        let lifted = [height, -height].map(|height| Plane { center, normal, axes, height });
        let mut search = Search {
            around,
            accelerator,
            crossed: Some(planes),
            cuts_of: |shape, offer: &mut dyn FnMut(Cut)| {
                let cuts = lifted.iter().filter_map(|plane| match shape {
                    Shape::Triangle(corners) => plane.cut_of_triangle(&corners),
                    Shape::Sphere(middle, radius) => plane.cut_of_sphere((middle, radius)),
                });
                cuts.for_each(offer);
            },
        };
        let is_listed = search.list(&clearing);
        for _ in 0..PLANES_MAX {
            let Some(cut) = search.nearest(&clearing, is_listed) else { break };
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

    fn whole(center: Vec3A, radius: f32, normal: Option<Vec3A>) -> Self {
        let planes = [(Vec3A::ZERO, 0.0); PLANES_MAX];
        Self { center, radius, planes, len: 0, is_smaller: false, normal, shell: None, gain: 1.0 }
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
        let Some(normal) = self.normal else { return 1.0 };
        let share = match self.planes[..self.len] {
            [] => 1.0,
            [(_, distance)] => {
                let u = (distance / self.radius).clamp(0.0, 1.0);
                1.0 - (u.acos() - u * (1.0 - u * u).sqrt()) / PI
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
        if let Some(normal) = self.normal {
            let height = offset.dot(Vector::splat(normal.to_array()));
            held &= height.abs().simd_le(F32s::splat(THICKNESS * self.radius));
        }
        for (normal, distance) in &self.planes[..self.len] {
            let before = offset.dot(Vector::splat(normal.to_array()));
            held &= before.simd_gt(F32s::splat(-distance));
        }
        held
    }
}

/// Looks for what is to be kept out.
struct Search<'a, F> {
    around: &'a mut Nearby,
    accelerator: &'a Accelerator,
    /// The planes that shapes must cross, if any.
    crossed: Option<Planes>,
    /// Offers the cuts of a shape.
    cuts_of: F,
}

impl<F: Fn(Shape, &mut dyn FnMut(Cut))> Search<'_, F> {
    /// Lists all cuts within the radius of what is not cut yet; false if they are too many.
    fn list(&mut self, clearing: &Clearing) -> bool {
        let near = Neighborhood {
            crossed: self.crossed,
            ..Neighborhood::ball(clearing.center, clearing.radius)
        };
        let Nearby { surroundings, cuts } = &mut *self.around;
        cuts.clear();
        surroundings.look(self.accelerator, &near, |shape| {
            (self.cuts_of)(shape, &mut |cut: Cut| {
                if cut.distance < clearing.radius && cuts.len() <= LISTED_MAX {
                    cuts.push(cut);
                }
            });
            if cuts.len() <= LISTED_MAX { clearing.radius } else { 0.0 }
        });
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
        let near = Neighborhood { crossed: self.crossed, fronts, front_count: *len, ..ball };
        let (mut reach, mut nearest) = (*radius, None);
        self.around.surroundings.look(self.accelerator, &near, |shape| {
            (self.cuts_of)(shape, &mut |cut: Cut| {
                if cut.distance < reach && !clearing.has_out(&cut) {
                    (reach, nearest) = (cut.distance, Some(cut));
                }
            });
            reach
        });
        nearest
    }
}

fn cut_of_sphere(center: Vec3A, (middle, radius): (Vec3A, f32)) -> Cut {
    let offset = center - middle;
    let outwards = offset.normalize_or(Vec3A::Z);
    let height = offset.length() - radius;
    let point = middle + outwards * radius;
    let normal = outwards * height.signum();
    let by = if height < 0.0 { By::Shell(normal, (middle, radius)) } else { By::Plane(normal) };
    Cut { distance: height.abs(), by, points: [point; 3] }
}

fn cut_of_triangle(center: Vec3A, corners: &[Vec3A; 3]) -> Cut {
    let [a, b, c] = *corners;
    let offset = center - nearest_in_triangle(center, corners);
    let distance = offset.length();
    let of_face = (b - a).cross(c - a).normalize_or_zero();
    let side = of_face.dot(center - a);
    // The way to the face itself is along its normal, which rounding does not turn.
    let is_face = side.abs() >= distance * (1.0 - TOUCHING) && of_face != Vec3A::ZERO;
    let normal = if is_face { of_face * 1.0_f32.copysign(side) } else { offset / distance };
    Cut { distance, by: By::Plane(normal), points: *corners }
}

/// The plane in which the disk of a surface is looked at.
struct Plane {
    center: Vec3A,
    normal: Vec3A,
    /// Of the coordinates in the plane.
    axes: (Vec3A, Vec3A),
    /// Of the plane above the surface, or below it.
    height: f32,
}

impl Plane {
    /// Coordinates in the plane.
    fn flat(&self, point: Vec3A) -> Vec2 {
        let (x, y) = self.axes;
        Vec2::new(x.dot(point - self.center), y.dot(point - self.center))
    }

    fn cut(&self, distance: f32, normal: Vec2, points: [Vec2; 2]) -> Cut {
        let (x, y) = self.axes;
        let [p, q] = points.map(|point| self.center + x * point.x + y * point.y);
        let normal = x * normal.x + y * normal.y;
        Cut { distance, by: By::Plane(normal), points: [p, q, q] }
    }

    /// What a triangle that crosses the plane keeps of it: a line, of which the vertex is on one
    /// side.
    fn cut_of_triangle(&self, corners: &[Vec3A; 3]) -> Option<Cut> {
        let heights = corners.map(|corner| self.normal.dot(corner - self.center) - self.height);
        let mut ends = [Vec2::ZERO; 2];
        let mut count = 0;
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let (below, above) = (heights[from], heights[to]);
            if (below < 0.0) != (above < 0.0) && count < 2 {
                let along = below / (below - above);
                ends[count] = self.flat(corners[from].lerp(corners[to], along));
                count += 1;
            }
        }
        if count < 2 {
            return None;
        }
        let [p, q] = ends;
        let along = q - p;
        let place = (-p.dot(along) / along.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        let nearest = p + along * place;
        let distance = nearest.length();
        // Where the vertex touches it, its side is not known.
        (distance > TOUCHING * self.height.abs())
            .then(|| self.cut(distance, -nearest / distance, ends))
    }

    /// The same of a sphere; near to the middle of the ring it is the disk that ends there.
    fn cut_of_sphere(&self, (middle, radius): (Vec3A, f32)) -> Option<Cut> {
        let off = self.normal.dot(middle - self.center) - self.height;
        if off.abs() > radius {
            return None;
        }
        let ring = (radius * radius - off * off).sqrt();
        let middle = self.flat(middle);
        let apart = middle.length();
        if apart < ROUND * ring {
            return Some(Cut { distance: ring - apart, by: By::Radius, points: [self.center; 3] });
        }
        let away = -middle / apart.max(f32::MIN_POSITIVE);
        let distance = apart - ring;
        Some(self.cut(distance.abs(), away * distance.signum(), [away * -distance; 2]))
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::math::hash;
    use crate::scene::baked::{Sphere, Triangle};

    fn uniform(row: usize, dimension: u32) -> f32 {
        let bits = hash::combine(hash::combine(5, row as u32), dimension);
        (bits >> 8) as f32 / (1 << 24) as f32
    }

    const RADIUS: f32 = 0.1;
    const POINTS: usize = 100_000;

    /// The gain against the count of points of the whole ball or disk that `is_free` and that the
    /// clearing holds: the former must equal the reciprocal of the share of the latter.
    fn check(clearing: &Clearing, free: impl Fn(Vec3) -> bool, limit: f32) -> f32 {
        let mut held = 0;
        let (x, y) = clearing.normal.unwrap_or(Vec3A::Z).any_orthonormal_pair();
        for first in (0..POINTS).step_by(LANES) {
            let offset = |lane| -> [f32; 3] {
                let number = |dimension| 2.0 * uniform(first + lane, dimension) - 1.0;
                let in_cube = Vec3A::new(number(0), number(1), number(2));
                let in_square = x * in_cube.x + y * in_cube.y;
                let of = if clearing.normal.is_some() { in_square } else { in_cube };
                (clearing.center + of * RADIUS).to_array()
            };
            let points = Vector::gather(offset);
            let from_center = points - Vector::splat(clearing.center.to_array());
            let within = from_center.length_squared().simd_le(F32s::splat(RADIUS * RADIUS));
            let mask = (within & clearing.holds(points)).to_bitmask();
            for lane in (0..LANES).filter(|lane| mask >> lane & 1 == 1) {
                assert!(free(Vec3::from(offset(lane))), "{:?} is not free", offset(lane));
            }
            held += mask.count_ones();
        }
        let of_box = if clearing.normal.is_some() { PI / 4.0 } else { PI / 6.0 };
        let share = held as f32 / POINTS as f32 / of_box;
        let off = (clearing.gain * share - 1.0).abs();
        let noise = 5.0 / (held as f32).sqrt();
        assert!(off < limit + noise, "{} {share}", clearing.gain);
        share
    }

    fn wall(origin: Vec3, x: Vec3, y: Vec3) -> [Triangle; 2] {
        let [a, b, c, d] = [-x - y, x - y, x + y, y - x].map(|corner| origin + corner);
        [[a, b, c], [a, c, d]].map(|corners| Triangle { corners })
    }

    fn corner() -> Accelerator {
        let walls = [
            wall(Vec3::new(0.0, 1.0, 1.0), Vec3::Y, Vec3::Z),
            wall(Vec3::new(1.0, 0.0, 1.0), Vec3::X, Vec3::Z),
            wall(Vec3::new(1.0, 1.0, 0.0), Vec3::X, Vec3::Y),
        ];
        Accelerator::build(walls.as_flattened(), &[])
    }

    /// Shares are those of random points, within five standard errors of their number, beside what
    /// the directions leave inexact.
    #[test]
    fn balls_in_a_corner_are_as_large_as_what_they_hold() {
        let (accelerator, mut around) = (corner(), Nearby::default());
        for place in [1e-4, 0.002, 0.03, 0.07, 0.2] {
            for center in [[place; 3], [0.5, place, place], [0.5, 0.4, place]] {
                let clearing =
                    Clearing::in_medium(center, [RADIUS, 0.6 * RADIUS], &accelerator, &mut around);
                check(&clearing, |point| point.min_element() >= -1e-6, 0.03);
            }
        }
    }

    #[test]
    fn disks_in_a_corner_are_as_large_as_what_they_hold() {
        let (accelerator, mut around) = (corner(), Nearby::default());
        for place in [0.002, 0.03, 0.07, 0.2] {
            for center in [[place, place, 0.0], [0.5, place, 0.0]] {
                let clearing =
                    Clearing::on_surface(center, Vec3A::Z, RADIUS, &accelerator, &mut around);
                check(&clearing, |point| point.min_element() >= -1e-6, 0.02);
            }
        }
    }

    #[test]
    fn nothing_behind_a_thin_wall_is_held() {
        let floor = wall(Vec3::ZERO, Vec3::X, Vec3::Y);
        let [near, far] = [0.01, 0.011].map(|x| wall(Vec3::X * x, Vec3::Y, Vec3::Z));
        let accelerator = Accelerator::build([floor, near, far].as_flattened(), &[]);
        let mut around = Nearby::default();
        let clearing = Clearing::on_surface([0.0; 3], Vec3A::Z, RADIUS, &accelerator, &mut around);
        assert!(check(&clearing, |point| point.x < 0.01, 0.01) < 0.57);
        // What lies on the floor lies on the edge of the wall's disk.
        let clearing = Clearing::on_surface(
            [0.01, 0.0, 0.02],
            Vec3A::NEG_X,
            RADIUS,
            &accelerator,
            &mut around,
        );
        let on_floor = Vector::gather(|lane| [0.01 - 0.001 * lane as f32, 0.0, 0.0]);
        assert!(!clearing.holds(on_floor).any());
    }

    #[test]
    fn balls_inside_and_outside_of_spheres_keep_to_their_side() {
        let sphere = Sphere { center: Vec3::ZERO, radius: 0.4 };
        let (accelerator, mut around) = (Accelerator::build(&[], &[sphere]), Nearby::default());
        for off in [0.001, 0.02, 0.06] {
            let outside =
                Clearing::in_medium([0.4 + off, 0.0, 0.0], [RADIUS; 2], &accelerator, &mut around);
            check(&outside, |point| point.length() >= 0.3999, 0.01);
            let inside =
                Clearing::in_medium([0.4 - off, 0.0, 0.0], [RADIUS; 2], &accelerator, &mut around);
            // The tangent plane lets a sliver through, where no photons are.
            assert!(inside.gain >= outside.gain);
        }
    }

    #[test]
    fn surfaces_that_only_bend_cut_nothing() {
        let sphere = Sphere { center: 2.0 * Vec3::NEG_Z, radius: 2.0 };
        let accelerator = Accelerator::build(&wall(Vec3::ZERO, Vec3::X, Vec3::Y), &[sphere]);
        let mut around = Nearby::default();
        let clearing = Clearing::on_surface([0.0; 3], Vec3A::Z, RADIUS, &accelerator, &mut around);
        assert_eq!((clearing.gain, clearing.len), (1.0, 0));
        assert!(clearing.holds(lanes_on_disk()).all());
    }

    fn lanes_on_disk() -> Vector<F32s> {
        let at = lanes::each(|lane| 0.012 * lane as f32);
        Vector { x: F32s::from(at), y: F32s::splat(0.0), z: F32s::splat(-0.004) }
    }
}
