//! What all walks have in common between two traced segments.

use crate::geometry::{HitColumns, SurfaceColumns};
use crate::math::columns::Column;
use crate::scattering::{Met, Scene};
use crate::scene::baked::MaterialKind;
use crate::transport::bounce::Bounce;
use crate::transport::stages::partition_paths::partition_paths;
use crate::transport::stages::play_roulette::play_roulette;
use crate::transport::stages::scatter_diffuse::scatter_diffuse;
use crate::transport::stages::scatter_medium::scatter_medium;
use crate::transport::stages::scatter_specular::scatter_specular;
use crate::transport::tables::carriers::CarrierTable;
use crate::transport::tables::kernels::KernelColumns;
use crate::transport::tables::partition::Partition;
use crate::transport::tables::paths::PathTable;
use crate::transport::{Chunk, LightModel};

/// Plays roulette and groups the rows that go on.
pub fn sort<const N: usize, C: CarrierTable>(
    sorted: &mut PathTable<N, C>,
    paths: &mut PathTable<N, C>,
    [hits, sorted_hits]: &mut [HitColumns; 2],
    partition: &mut Partition,
    scene: &Scene<N>,
    chunk: &Chunk,
    bounce: Bounce,
) {
    if chunk.plays_roulette(bounce.path_length) {
        play_roulette(paths, hits, scene, bounce.path_length);
    }
    partition_paths(sorted, sorted_hits, partition, paths, hits, scene);
}

/// Draws a new direction for every row, with its kernel where the mode asks for one.
pub fn scatter<const N: usize, M: LightModel<N>, C>(
    drawn: &mut [Column; 3],
    kernels: &mut KernelColumns<N>,
    paths: &mut PathTable<N, C>,
    surfaces: &SurfaceColumns,
    scene: &Scene<N>,
    partition: &Partition,
    bounce: Bounce,
) {
    let diffuse = partition.rows_of(Met::Surface(MaterialKind::Diffuse));
    scatter_diffuse(drawn, paths, surfaces, scene, diffuse, bounce);
    if M::POLARIZED {
        scatter_specular::<N, true, C>(drawn, kernels, paths, surfaces, scene, partition, bounce);
        scatter_medium::<N, true, C>(drawn, kernels, paths, scene, partition, bounce);
    } else {
        scatter_specular::<N, false, C>(drawn, kernels, paths, surfaces, scene, partition, bounce);
        scatter_medium::<N, false, C>(drawn, kernels, paths, scene, partition, bounce);
    }
}
