//! Sizes of clearings against counts of points.

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
    let (x, y) = clearing.surface.map_or(Vec3A::Z, |it| it.0).any_orthonormal_pair();
    for first in (0..POINTS).step_by(LANES) {
        let offset = |lane| -> [f32; 3] {
            let number = |dimension| 2.0 * uniform(first + lane, dimension) - 1.0;
            let in_cube = Vec3A::new(number(0), number(1), number(2));
            let in_square = x * in_cube.x + y * in_cube.y;
            let of = if clearing.surface.is_some() { in_square } else { in_cube };
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
    let of_box = if clearing.surface.is_some() { PI / 4.0 } else { PI / 6.0 };
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
    let rims = Rims::default();
    let shapes = (&accelerator, &rims);
    for place in [0.002, 0.03, 0.07, 0.2] {
        for center in [[place, place, 0.0], [0.5, place, 0.0]] {
            let clearing =
                Clearing::on_surface(center, Vec3A::Z, (RADIUS, 1e-6), shapes, &mut around);
            check(&clearing, |point| point.min_element() >= -1e-6, 0.02);
        }
    }
}

#[test]
fn nothing_behind_a_thin_wall_is_held() {
    let floor = wall(Vec3::ZERO, Vec3::X, Vec3::Y);
    let [near, far] = [0.01, 0.011].map(|x| wall(Vec3::X * x, Vec3::Y, Vec3::Z));
    let triangles = [floor, near, far];
    let accelerator = Accelerator::build(triangles.as_flattened(), &[]);
    let (rims, mut around) = (Rims::of_triangles(triangles.as_flattened()), Nearby::default());
    let shapes = (&accelerator, &rims);
    let clearing = Clearing::on_surface([0.0; 3], Vec3A::Z, (RADIUS, 1e-6), shapes, &mut around);
    assert!(check(&clearing, |point| point.x < 0.01, 0.01) < 0.57);
    // What lies on the floor lies on the edge of the wall's disk.
    let clearing =
        Clearing::on_surface([0.01, 0.0, 0.02], Vec3A::NEG_X, (RADIUS, 1e-6), shapes, &mut around);
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
    let wall = wall(Vec3::ZERO, Vec3::X, Vec3::Y);
    let accelerator = Accelerator::build(&wall, &[sphere]);
    let (rims, mut around) = (Rims::of_triangles(&wall), Nearby::default());
    let shapes = (&accelerator, &rims);
    let clearing = Clearing::on_surface([0.0; 3], Vec3A::Z, (RADIUS, 1e-6), shapes, &mut around);
    assert_eq!((clearing.gain, clearing.len), (1.0, 0));
    assert!(clearing.holds(lanes_on_disk()).all());
}

#[test]
fn disks_end_where_surfaces_do() {
    let sheet = wall(Vec3::ZERO, 0.05 * Vec3::X, 0.03 * Vec3::Y);
    let (accelerator, mut around) = (Accelerator::build(&sheet, &[]), Nearby::default());
    let rims = Rims::of_triangles(&sheet);
    for center in [[0.0; 3], [0.049, 0.0, 0.0], [0.04, -0.029, 0.0]] {
        let shapes = (&accelerator, &rims);
        let clearing = Clearing::on_surface(center, Vec3A::Z, (RADIUS, 1e-6), shapes, &mut around);
        let is_on = |point: Vec3| point.x.abs() < 0.0501 && point.y.abs() < 0.0301;
        check(&clearing, is_on, 0.03);
    }
}

/// On fine meshes and spheres that are much smaller than the kernel that is asked for, the disk is
/// not much larger than what lies in it.
#[test]
fn disks_on_small_balls_are_smaller() {
    let sphere = Sphere { center: Vec3::ZERO, radius: 0.02 };
    let of_mesh = |row: u32, column: u32| {
        let (theta, phi) = (PI * row as f32 / 24.0, PI * column as f32 / 24.0);
        let (sine, cosine) = theta.sin_cos();
        0.02 * Vec3::new(sine * phi.cos(), sine * phi.sin(), cosine)
    };
    let quads = (0..24).flat_map(|row| (0..48).map(move |column| (row, column)));
    let mesh: Vec<Triangle> = quads
        .flat_map(|(r, c)| {
            let [a, b] = [of_mesh(r, c), of_mesh(r + 1, c)];
            let [d, e] = [of_mesh(r + 1, (c + 1) % 48), of_mesh(r, (c + 1) % 48)];
            [[a, b, d], [a, d, e]].map(|corners| Triangle { corners })
        })
        .filter(|Triangle { corners: [a, b, c] }| a != b && b != c && a != c)
        .collect();
    let normal = Vec3A::new(0.6, 0.48, 0.64);
    for accelerator in [Accelerator::build(&mesh, &[]), Accelerator::build(&[], &[sphere])] {
        let (rims, mut around) = (Rims::default(), Nearby::default());
        for radius in [0.02, 0.05, 0.2] {
            let center = (0.0199 * normal).to_array();
            let shapes = (&accelerator, &rims);
            let clearing =
                Clearing::on_surface(center, normal, (radius, 1e-6), shapes, &mut around);
            let (reach, most) = (clearing.radius / 0.02, (RADIUS_MIN * radius / 0.02).max(0.7));
            assert!((0.1..most * 1.001).contains(&reach), "{radius}: {reach} of the ball's radius");
        }
    }
}

fn lanes_on_disk() -> Vector<F32s> {
    let at = lanes::each(|lane| 0.012 * lane as f32);
    Vector { x: F32s::from(at), y: F32s::splat(0.0), z: F32s::splat(-0.004) }
}
