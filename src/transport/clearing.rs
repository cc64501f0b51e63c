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

use glam::{Vec2, Vec3, Vec3A};

use crate::geometry::{Accelerator, Neighborhood, Planes, Surroundings, nearest_in_triangle};
use crate::math::{F32s, LANES, Vector, lanes};

/// Planes that keep shapes out at most, the nearest: more is cut off by fine meshes alone, of which
/// a smaller kernel meets less.
const PLANES_MAX: usize = 4;
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
/// Least part of a kernel, so that its reciprocal is a number.
const SHARE_MIN: f32 = 1e-3;
/// Directions by which sizes are computed where more than one plane cuts.
const DIRECTIONS: usize = 128;

/// Where photons count, and how much.
#[derive(Clone, Copy, Debug)]
pub struct Clearing {
    center: Vec3A,
    radius: f32,
    /// Normals and distances from the vertex of the planes before which photons count.
    planes: [(Vec3, f32); PLANES_MAX],
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

/// A shape that is to be kept out.
#[derive(Clone, Copy)]
struct Cut {
    distance: f32,
    /// Unit vector from it to the vertex.
    normal: Vec3A,
    /// Points that say all about where it is; none lies anywhere else.
    points: [Vec3A; 3],
}

impl Clearing {
    /// The part of the ball of `radius` about `center` that no surface cuts off. At the boundary of
    /// a medium, where kernels are one-sided, and what that makes wrong grows with the square of
    /// the radius, that is `at_boundary` at most.
    pub fn in_medium(
        center: [f32; 3],
        [radius, at_boundary]: [f32; 2],
        accelerator: &Accelerator,
        around: &mut Surroundings,
    ) -> Self {
        let center = Vec3A::from(center);
        around.find(accelerator, &Neighborhood { center, radius, crossed: None });
        let mut clearing = Self::whole(center, radius, None);
        if !around.is_empty() {
            let of_triangles =
                around.triangles.iter().map(|corners| cut_of_triangle(center, corners));
            let mut cuts: Vec<Cut> = of_triangles.collect();
            cuts.extend(around.spheres.iter().map(|&sphere| cut_of_sphere(center, sphere)));
            let encloses = |&&(middle, radius): &&(Vec3A, f32)| center.distance(middle) < radius;
            let smallest = |a: &&(Vec3A, f32), b: &&(Vec3A, f32)| a.1.total_cmp(&b.1);
            let nearest = cuts.iter().map(|cut| cut.distance).fold(radius, f32::min);
            clearing.radius = clearing.radius.min(nearest.max(at_boundary));
            clearing.shell = around.spheres.iter().filter(encloses).min_by(smallest).copied();
            clearing.cut(&mut cuts);
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
        around: &mut Surroundings,
    ) -> Self {
        let center = Vec3A::from(center);
        let height = radius * LIFT;
        let planes = Planes { normal, offset: -normal.dot(center), height };
        around.find(accelerator, &Neighborhood { center, radius, crossed: Some(planes) });
        let mut clearing = Self::whole(center, radius, Some(normal));
        if !around.is_empty() {
            let mut cuts: Vec<Cut> = Vec::new();
            for height in [height, -height] {
                let plane = Plane { center, normal, height };
                let triangles = around.triangles.iter();
                cuts.extend(triangles.filter_map(|corners| plane.cut_of_triangle(corners)));
                for cut in around.spheres.iter().filter_map(|sphere| plane.cut_of_sphere(*sphere)) {
                    match cut {
                        Ok(cut) => cuts.push(cut),
                        Err(radius) => clearing.radius = clearing.radius.min(radius),
                    }
                }
            }
            clearing.cut(&mut cuts);
            for (_, distance) in &mut clearing.planes[..clearing.len] {
                *distance = (*distance - MARGIN * clearing.radius).max(0.0);
            }
        }
        clearing.is_smaller = clearing.radius < radius;
        clearing.gain = (radius / clearing.radius).powi(2) / clearing.share_of_disk();
        clearing
    }

    fn whole(center: Vec3A, radius: f32, normal: Option<Vec3A>) -> Self {
        let planes = [(Vec3::ZERO, 0.0); PLANES_MAX];
        Self { center, radius, planes, len: 0, is_smaller: false, normal, shell: None, gain: 1.0 }
    }

    /// Keeps out what is cut, nearest first, but for what others keep out already.
    fn cut(&mut self, cuts: &mut [Cut]) {
        cuts.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        for cut in cuts.iter().filter(|cut| cut.distance.is_finite()) {
            if cut.distance >= self.radius {
                break;
            }
            let (center, tolerance) = (self.center, TOUCHING * self.radius);
            let is_out = self.planes[..self.len].iter().any(|(normal, distance)| {
                let beyond =
                    |point: &Vec3A| normal.dot((*point - center).into()) + distance <= tolerance;
                cut.points.iter().all(beyond)
            });
            if is_out {
                continue;
            }
            if self.len == PLANES_MAX {
                break;
            }
            self.planes[self.len] = (cut.normal.into(), cut.distance);
            self.len += 1;
        }
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
            _ => self.mean(|step| {
                // A spiral of equal steps in height (Gonzalez 2010).
                let height = 1.0 - (2.0 * step + 1.0) / DIRECTIONS as f32;
                let (sine, cosine) = (TAU * 0.618_034 * step).sin_cos();
                let flat = (1.0 - height * height).max(0.0).sqrt();
                (Vec3A::new(cosine * flat, sine * flat, height), 3)
            }),
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
                self.mean(|step| {
                    let (sine, cosine) = (TAU * step / DIRECTIONS as f32).sin_cos();
                    (x * cosine + y * sine, 2)
                })
            }
        };
        share.max(SHARE_MIN)
    }

    /// The mean of a power of how far the clearing goes, relative to its radius.
    fn mean(&self, direction: impl Fn(f32) -> (Vec3A, i32)) -> f32 {
        let mut sum = 0.0;
        for step in 0..DIRECTIONS {
            let (direction, power) = direction(step as f32);
            let mut reach = self.radius;
            if let Some((middle, radius)) = self.shell {
                let offset = self.center - middle;
                let along = offset.dot(direction);
                let within = (radius * radius - offset.length_squared()).max(0.0);
                reach = reach.min((along * along + within).sqrt() - along);
            }
            for (normal, distance) in &self.planes[..self.len] {
                let approach = -normal.dot(direction.into());
                if approach * reach > *distance {
                    reach = distance / approach;
                }
            }
            sum += (reach / self.radius).powi(power);
        }
        sum / DIRECTIONS as f32
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

fn cut_of_sphere(center: Vec3A, (middle, radius): (Vec3A, f32)) -> Cut {
    let offset = center - middle;
    let outwards = offset.normalize_or(Vec3A::Z);
    let height = offset.length() - radius;
    let point = middle + outwards * radius;
    Cut { distance: height.abs(), normal: outwards * height.signum(), points: [point; 3] }
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
    Cut { distance, normal, points: *corners }
}

/// The plane in which the disk of a surface is looked at.
struct Plane {
    center: Vec3A,
    normal: Vec3A,
    /// Of the plane above the surface, or below it.
    height: f32,
}

impl Plane {
    /// Coordinates in the plane.
    fn flat(&self, point: Vec3A) -> Vec2 {
        let (x, y) = self.normal.any_orthonormal_pair();
        Vec2::new(x.dot(point - self.center), y.dot(point - self.center))
    }

    fn cut(&self, distance: f32, normal: Vec2, points: [Vec2; 2]) -> Cut {
        let (x, y) = self.normal.any_orthonormal_pair();
        let [p, q] = points.map(|point| self.center + x * point.x + y * point.y);
        Cut { distance, normal: x * normal.x + y * normal.y, points: [p, q, q] }
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

    /// The same of a sphere; as an error the radius that a disk inside may have.
    fn cut_of_sphere(&self, (middle, radius): (Vec3A, f32)) -> Option<Result<Cut, f32>> {
        let off = self.normal.dot(middle - self.center) - self.height;
        if off.abs() > radius {
            return None;
        }
        let ring = (radius * radius - off * off).sqrt();
        let middle = self.flat(middle);
        let apart = middle.length();
        if apart < ROUND * ring {
            return Some(Err(ring - apart));
        }
        let away = -middle / apart.max(f32::MIN_POSITIVE);
        let distance = apart - ring;
        Some(Ok(self.cut(distance.abs(), away * distance.signum(), [away * -distance; 2])))
    }
}

#[cfg(test)]
mod tests {
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
        let (accelerator, mut around) = (corner(), Surroundings::default());
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
        let (accelerator, mut around) = (corner(), Surroundings::default());
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
        let mut around = Surroundings::default();
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
        let (accelerator, mut around) =
            (Accelerator::build(&[], &[sphere]), Surroundings::default());
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
        let mut around = Surroundings::default();
        let clearing = Clearing::on_surface([0.0; 3], Vec3A::Z, RADIUS, &accelerator, &mut around);
        assert_eq!((clearing.gain, clearing.len), (1.0, 0));
        assert!(clearing.holds(lanes_on_disk()).all());
    }

    fn lanes_on_disk() -> Vector<F32s> {
        let at = lanes::each(|lane| 0.012 * lane as f32);
        Vector { x: F32s::from(at), y: F32s::splat(0.0), z: F32s::splat(-0.004) }
    }
}
