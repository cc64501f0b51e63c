//! All tables that a chunk needs, allocated once and reused.

use crate::geometry::{HitColumns, SurfaceColumns, TraceScratch};
use crate::math::LANES;
use crate::scattering::painting::PaintedModels;
use crate::transport::LightModel;
use crate::transport::chunk::ROWS;
use crate::transport::tables::connections::ConnectionTable;
use crate::transport::tables::crossings::CrossingTable;
use crate::transport::tables::flights::FlightTable;
use crate::transport::tables::kernels::DepartureColumns;
use crate::transport::tables::measured::{Measured, Splats};
use crate::transport::tables::merged::MergedRows;
use crate::transport::tables::partition::Partition;
use crate::transport::tables::paths::PathTable;
use crate::transport::tables::photon_queries::PhotonQueries;
use crate::transport::tables::photons::PhotonTable;
use crate::transport::tables::pieces::PieceTable;
use crate::transport::tables::vertices::{SlotOrder, VertexTable};

use super::profile::Profile;

/// The tables of one chunk in the making.
pub struct Workspace<const N: usize, M: LightModel<N>> {
    /// Sensor paths, and where they are sorted to.
    pub sensor: [PathTable<N, M::Sensor>; 2],
    /// Light paths, and where they are sorted to.
    pub light: [PathTable<N, M::Light>; 2],
    /// What walks work with beside.
    pub walk: WalkTables<N>,
    /// Vertices that look for photons.
    pub queries: PhotonQueries,
    /// Rows of sensor paths that have merged.
    pub merged: MergedRows,
    /// Pieces of segments that lamps are looked for from.
    pub pieces: PieceTable,
    /// Photons of surfaces, where light paths are to leave any.
    pub photons: Option<PhotonTable<N>>,
    /// Connections under test.
    pub connections: ConnectionTable<N>,
    /// Light vertices in the order of storing, and by slot.
    pub vertices: [VertexTable<N>; 2],
    /// How vertices are ordered by slot.
    pub slot_order: SlotOrder,
    /// What the sensor paths of the chunk have measured.
    pub measured: Measured<N>,
    /// What connections to the sensor have brought.
    pub splats: Splats<N>,
    /// Where time went.
    pub profile: Profile,
}

/// What a walk works with, of either side: rows are those of its paths.
pub struct WalkTables<const N: usize> {
    /// What rays have hit, and where that is sorted to.
    pub hits: [HitColumns; 2],
    /// The surfaces there.
    pub surfaces: SurfaceColumns,
    /// Their models where they are painted.
    pub models: PaintedModels<N>,
    /// Which rows do what next.
    pub partition: Partition,
    /// Where they go from there.
    pub departures: DepartureColumns<N>,
    /// Segments on their way through media and surfaces that let them straight on.
    pub flights: FlightTable<N>,
    /// Where they cross such surfaces.
    pub crossings: CrossingTable<N>,
    /// Others, while these are put aside.
    aside: (FlightTable<N>, CrossingTable<N>),
    /// What tracing needs.
    pub scratch: TraceScratch,
}

impl<const N: usize, M: LightModel<N>> Workspace<N, M> {
    /// Empty tables for films of so many components, with or without media and partial weights;
    /// its stages are timed or not.
    pub fn new(components: usize, with: (bool, bool), is_timed: bool) -> Self {
        Self {
            sensor: std::array::from_fn(|_| PathTable::new(ROWS, with)),
            light: std::array::from_fn(|_| PathTable::new(ROWS, with)),
            walk: WalkTables::new(),
            queries: PhotonQueries::default(),
            merged: MergedRows::new(ROWS),
            pieces: PieceTable::new(ROWS),
            photons: None,
            connections: ConnectionTable::new(4 * ROWS),
            vertices: std::array::from_fn(|_| VertexTable::new(4 * ROWS)),
            slot_order: SlotOrder::default(),
            measured: Measured::new(ROWS, components),
            splats: Splats::default(),
            profile: Profile { is_timed, ..Profile::default() },
        }
    }
}

impl<const N: usize> WalkTables<N> {
    fn new() -> Self {
        Self {
            hits: std::array::from_fn(|_| HitColumns::new(ROWS)),
            surfaces: SurfaceColumns::new(ROWS),
            models: PaintedModels::default(),
            partition: Partition::default(),
            departures: DepartureColumns::with_sparse_kernels(ROWS),
            flights: FlightTable::new(ROWS),
            crossings: CrossingTable::new(ROWS),
            aside: (FlightTable::new(LANES), CrossingTable::new(LANES)),
            scratch: TraceScratch::default(),
        }
    }

    /// Puts flights and crossings aside, or takes up those that were.
    pub fn swap_flights(&mut self) {
        std::mem::swap(&mut self.flights, &mut self.aside.0);
        std::mem::swap(&mut self.crossings, &mut self.aside.1);
    }
}
