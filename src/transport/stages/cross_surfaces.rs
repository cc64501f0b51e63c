//! Takes paths through surfaces that let them straight on.

use crate::math::{F32s, Vector, lanes};
use crate::polarization::Dense;
use crate::scattering::event::{Event, Form};
use crate::scattering::surface::{Crossed, SurfaceKind};
use crate::scattering::{Met, Scene, Side};
use crate::transport::crossing::dense_at;
use crate::transport::tables::carriers::CarrierTable;
use crate::transport::tables::crossings::Crossing;
use crate::transport::tables::flights::FlightTable;
use crate::transport::tables::kernels::KernelColumns;
use crate::transport::tables::partition::{Part, Partition};
use crate::transport::tables::paths::PathTable;

/// Takes the rows of a part that pass to the other side. With `POLARIZED`, leaves their kernels,
/// and lists them, for the carriers.
///
/// From: pass_surfaces, choose_passage. To: collect_sensor, scatter_light, fly_to_crossings,
/// fly_through_media, list_pieces.
/// Writes: paths (beta, mis, media), kernels, partition. Reads: crossing, flights, scene.
pub fn cross_surfaces<const N: usize, const POLARIZED: bool, C: CarrierTable>(
    paths: &mut PathTable<N, C>,
    (kernels, partition): (&mut KernelColumns<N>, &mut Partition),
    crossing: &Crossing<N>,
    flights: &FlightTable<N>,
    scene: &Scene<N>,
) {
    let &Crossing { crossings, part, side } = crossing;
    partition.parts.clear();
    let model = match part.kind {
        Crossed::Model(kind) => Some((kind, event_of(kind))),
        // They leave polarization as it is.
        Crossed::Holes => None,
    };
    for index in part.rows.clone() {
        let row = crossings.row[index] as usize;
        if flights.progress[row].is_over {
            continue;
        }
        if paths.media.present() {
            let inside = &mut paths.media.inside[row];
            *inside = scene.medium_behind(&crossings.surfaces, &crossings.rays, index, *inside);
        }
        if !part.kind.acts() {
            continue;
        }
        let chance = crossings.chance[index];
        paths.mis.pass(row, chance);
        for (beta, transmittance) in paths.beta.iter_mut().zip(crossings.transmittance[index]) {
            beta[row] *= transmittance / chance;
        }
        if POLARIZED && let Some((kind, event)) = model {
            let class = paths.carriers.place_of_class(row);
            match partition.parts.last_mut() {
                Some(part) if part.rows.end == row && part.class == class => part.rows.end += 1,
                Some(_) | None => {
                    partition.parts.push(Part { event, class, rows: row..row + 1 });
                }
            }
            let axis = Vector::splat(lanes::row_of(&crossings.axis, index));
            let of = (event.form, event.achromatic);
            if event.form == Form::Dense {
                let dense = dense_at(crossings, (kind, index), scene, side == Side::Sensor)
                    .map(|Dense(matrix)| Dense(matrix.map(|row| row.map(F32s::splat))));
                kernels.store_events(of, (&dense, axis), (row, row + 1));
            } else {
                let blocks = crossings.kernels(index, kind);
                kernels.store_events(of, (&blocks, axis), (row, row + 1));
            }
        }
    }
}

/// What goes straight on through a model has met.
fn event_of(kind: SurfaceKind) -> Event {
    Event {
        met: Met::Surface(kind),
        form: kind.form_straight_on(),
        achromatic: kind.passes_alike(),
    }
}
