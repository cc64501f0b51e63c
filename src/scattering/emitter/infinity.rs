//! What emitters at infinity share: their light enters the scene through a disk that hides it all.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

use crate::math::elementary::sin_cos;
use crate::math::{F32s, Vector, warp};
use crate::scene::baked::{Bounds, Shapes};

use super::aim::GAIN_MIN;
use super::direct::{DirectLanes, finite, reachable};
use super::{EmissionSample, Emits, Source};

/// Density per steradian of a uniform direction.
pub const SPHERE_PDF: f32 = FRAC_1_PI / 4.0;

/// Density per area of a point on the disk through which parallel light enters the scene.
pub fn disk_pdf(shapes: &Shapes) -> f32 {
    let radius = shapes.bounds.radius;
    FRAC_1_PI / (radius * radius)
}

/// [`Emits::gain_of_aim`]: the ratio of the two disks.
pub fn gain_of_aim(shapes: &Shapes, ball: &Bounds) -> Option<f32> {
    let ratio = shapes.bounds.radius / ball.radius;
    Some(ratio * ratio).filter(|&gain| gain > GAIN_MIN)
}

/// A uniform direction.
pub fn any_direction(u: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * u[0];
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sine, cosine) = sin_cos(2.0 * PI * u[1]);
    Vec3::new(radius * cosine, radius * sine, z)
}

/// Eight uniform directions.
#[inline(always)]
pub fn any_directions(u: [F32s; 2]) -> Vector<F32s> {
    let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
    warp::cone(Vector::new(zero, zero, one), -one, u)
}

/// Starts a path along `direction`, chosen with a density per steradian.
pub fn emit<Model: Emits, const N: usize>(
    source: &Source<N>,
    (direction, direction_pdf): (Vec3, f32),
    u: [f32; 2],
) -> EmissionSample<N> {
    let bounds = source.shapes.bounds;
    let disk = source.aimed_at.unwrap_or(bounds);
    let radius = disk.radius * u[0].sqrt();
    let (sine, cosine) = sin_cos(2.0 * PI * u[1]);
    let (tangent, bitangent) = direction.any_orthonormal_pair();
    let on_disk = tangent * (radius * cosine) + bitangent * (radius * sine);
    // Before the whole scene, whichever part of it is aimed at.
    let before = bounds.radius + direction.dot(disk.center - bounds.center);
    let start_pdf = source.probability * direction_pdf;
    let emission_pdf = start_pdf * disk_pdf(source.shapes);
    EmissionSample {
        position: disk.center + on_disk - direction * before,
        normal: Vec3::ZERO,
        direction,
        beta: source.radiance.map(|radiance| radiance / emission_pdf),
        radiance: source.radiance,
        start_pdf,
        emission_pdf,
        cos_at_light: 1.0,
        finite: Model::FINITE,
        two_sided: false,
        delta: Model::DELTA,
        emitter: source.row,
    }
}

/// Eight directions to emitters.
#[inline(always)]
pub fn choose<Model: Emits, const N: usize>(
    direction: Vector<F32s>,
    radiance: [F32s; N],
    [pdf_w, emission_pdf]: [F32s; 2],
) -> DirectLanes<N> {
    let zero = F32s::splat(0.0);
    let nowhere = Vector::new(zero, zero, zero);
    DirectLanes {
        direction,
        point: nowhere,
        normal: nowhere,
        finite: finite::<Model>(),
        radiance,
        pdf_w,
        emission_pdf,
        cos_at_light: F32s::splat(1.0),
        reachable: reachable::<Model>(),
    }
}
