//! What paths do in and between media, whichever stage asks.

use glam::Vec3;

use crate::geometry::{Hit, Ray, offset_distance};
use crate::math::lanes;
use crate::scattering::Scene;

use super::tables::flights::{Flight, FlightTable};

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
    let inside = scene.medium_beyond(primitive, to_front, flights.inside[index]);
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
