//! Free flights to the surfaces that let paths straight on.

use crate::geometry::HitColumns;
use crate::math::LANES;
use crate::scattering::Scene;
use crate::transport::flight::fly;
use crate::transport::tables::crossings::Crossing;
use crate::transport::tables::flights::FlightTable;
use crate::transport::tables::paths::AnyPaths;

/// Takes the rows of a part to their crossings, unless they meet a particle of the medium before.
///
/// From: draw_distances, cross_surfaces. To: collect_crossed_emission, store_crossed_photons,
/// choose_passage, fly_through_media.
/// Writes: hits, flights. Reads: paths, crossing, scene.
pub fn fly_to_crossings<const N: usize>(
    hits: &mut HitColumns,
    flights: &mut FlightTable<N>,
    paths: &AnyPaths<N>,
    crossing: &Crossing<N>,
    scene: &Scene<N>,
) {
    let &Crossing { crossings, part, .. } = crossing;
    for index in part.rows.clone() {
        let row = crossings.row[index] as usize;
        if !flights.progress[row].is_over {
            let start = row - row % LANES;
            let wavelength = paths.identity.wavelength::<N>(start)[row - start];
            fly(hits, flights, paths, scene, (row, crossings.hits.t[index], wavelength));
        }
    }
}
