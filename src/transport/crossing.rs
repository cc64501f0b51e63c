//! Segments that go straight on through surfaces, whichever stage asks.
//!
//! A segment is followed from one surface to the next without being started anew: all hits are
//! distances from its start, and two surfaces in the same place are met one after the other.

use crate::geometry::{Hit, TraceScratch, trace_next};
use crate::math::columns::Rows;
use crate::math::{Vector, lanes};
use crate::polarization::Dense;
use crate::scattering::Scene;
use crate::scattering::surface::{StraightOn, SurfaceKind, for_straight_on};
use crate::transport::tables::crossings::CrossingTable;
use crate::transport::tables::flights::FlightTable;

/// Appends the crossings of all flights to the table, from what they have met last on, until each
/// meets something else, or nothing: `end` is told of that.
pub fn follow<const N: usize>(
    crossings: &mut CrossingTable<N>,
    (flights, scratch): (&mut FlightTable<N>, &mut TraceScratch),
    scene: &Scene<N>,
    mut end: impl FnMut(u32, Hit),
) {
    while flights.len > 0 {
        push_wave(crossings, flights, scene);
        step(flights, scratch, scene, &mut end);
    }
}

/// Takes all flights to what they meet next; those that do not go on there drop out.
pub fn step<const N: usize>(
    flights: &mut FlightTable<N>,
    scratch: &mut TraceScratch,
    scene: &Scene<N>,
    mut end: impl FnMut(u32, Hit),
) {
    let FlightTable { hits, rays, t_max, len, .. } = &mut *flights;
    trace_next(hits, scratch, rays, t_max, 0..*len, &scene.accelerator);
    let mut kept = 0;
    for index in 0..flights.len {
        if !scene.is_straight_on(flights.hits.primitive[index]) {
            end(flights.row[index], flights.hits.get(index));
            continue;
        }
        if kept < index {
            flights.set(kept, flights.get(index));
        }
        kept += 1;
    }
    flights.len = kept;
}

/// One crossing of every flight, grouped by kind.
fn push_wave<const N: usize>(
    crossings: &mut CrossingTable<N>,
    flights: &FlightTable<N>,
    scene: &Scene<N>,
) {
    for &kind in &scene.straight_on_kinds {
        let first = crossings.len;
        for index in 0..flights.len {
            let hit = flights.hits.get(index);
            if scene.material_at(hit.primitive).crossed() == Some(kind) {
                crossings.push(flights.row[index], flights.rays.get(index), hit);
            }
        }
        crossings.close_part(kind, first);
    }
}

/// Dense kernels of a crossing, for light along the segment's ray or, of those that the sensor's
/// end starts, against it.
#[inline(never)]
pub fn dense_at<const N: usize>(
    crossings: &CrossingTable<N>,
    (kind, index): (SurfaceKind, usize),
    scene: &Scene<N>,
    from_sensor: bool,
) -> [Dense<f32>; N] {
    let CrossingTable { surfaces, rays, .. } = crossings;
    let model = match scene.is_painted() {
        true => scene.model_row(surfaces, index),
        false => scene.material_at(surfaces.primitive[index]).row as usize,
    };
    let mut kernels = [Dense([[0.0; 4]; 4]); N];
    for_straight_on!(scene.surfaces, kind, models => kernels = models[model].matrices());
    let normal: Vector<f32> = lanes::row_of(&surfaces.geometric_normal, index).into();
    let direction: Vector<f32> = lanes::row_of(&rays.direction, index).into();
    let meets_front = direction.dot(normal) < 0.0;
    match meets_front == from_sensor {
        true => kernels.map(|kernel| kernel.reversed()),
        false => kernels,
    }
}
