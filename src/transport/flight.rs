//! What paths do in and between media, whichever stage asks.

use glam::Vec3;

use crate::geometry::{Hit, Ray, offset_distance};
use crate::math::{F32s, LANES, lanes};
use crate::scattering::Scene;
use crate::scene::baked::KEEP;

use super::sampler::{Purpose, draw};
use super::tables::flights::{Flight, FlightTable};
use super::tables::paths::IdentityColumns;

/// The wavelength that a path's distances and angles are drawn for.
#[inline(always)]
pub fn wavelength_of<const N: usize>(identity: &IdentityColumns, row: usize) -> [u32; LANES] {
    if N == 1 {
        return [0; LANES];
    }
    let seed = lanes::load_u32(&identity.seed, row);
    let iteration = lanes::load_u32(&identity.iteration, row);
    let [u, _] = draw(seed, iteration, 0, Purpose::Wavelength);
    let place = (u * F32s::splat(N as f32)).to_array();
    lanes::each(|lane| (place[lane] as u32).min(N as u32 - 1))
}

/// Moves the flight at `index`, which has reached a boundary, behind it and to the end of the
/// rows in use.
///
/// The step off the boundary is along the ray, so that it counts as part of the next piece in
/// full; along the normal, slanted rays would lose optical depth. A ray that grazes may meet the
/// boundary again, which does no harm: the medium behind it is the same every time.
pub fn step_over<const N: usize>(flights: &mut FlightTable<N>, index: usize, scene: &Scene<N>) {
    let of = |columns| Vec3::from(lanes::row_of(columns, index));
    let (origin, direction) = (of(&flights.rays.origin), of(&flights.rays.direction));
    let (t, primitive) = (flights.hits.t[index], flights.hits.primitive[index]);
    let position = origin + direction * t;
    let normal = scene.shapes.geometric_normal(primitive, position);
    let skipped = offset_distance(scene.reach);
    let after = position + direction * skipped;
    let row = flights.row[index];
    let to_front = normal.dot(direction) > 0.0;
    let inside = beyond(scene, primitive, to_front, flights.inside[index]);
    flights.push_row(Flight {
        row,
        rays: Ray { origin: after.to_array(), direction: direction.to_array() },
        hits: Hit::MISS,
        inside,
        travelled: flights.travelled[index] + t + skipped,
    });
    let sigma_t = &scene.medium(inside).sigma_t;
    for (depth, sigma) in flights.depth[row as usize].iter_mut().zip(sigma_t) {
        *depth += sigma * skipped;
    }
}

/// The medium on the side of a surface that is entered, for a path in the medium `before`.
#[inline(always)]
pub fn beyond<const N: usize>(
    scene: &Scene<N>,
    primitive: u32,
    to_front: bool,
    before: u32,
) -> u32 {
    let surface = &scene.shapes.surfaces[scene.shapes.surface_of(primitive) as usize];
    match if to_front { surface.exterior } else { surface.interior } {
        KEEP => before,
        medium => medium,
    }
}
