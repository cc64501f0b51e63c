//! The two sides that paths are traced from, as types.

use crate::geometry::SurfaceColumns;
use crate::scattering::{Scene, Side};
use crate::transport::chunk::ROWS;
use crate::transport::emission::Finding;
use crate::transport::stages::collect_crossed_emission::collect_crossed_emission;
use crate::transport::stages::collect_emission::collect_emission;
use crate::transport::stages::collect_sensor::collect_sensor;
use crate::transport::stages::depolarize_light::depolarize_light;
use crate::transport::stages::depolarize_sensor::depolarize_sensor;
use crate::transport::stages::emit_light_paths::emit_light_paths;
use crate::transport::stages::generate_sensor_paths::generate_sensor_paths;
use crate::transport::stages::rescale_light::rescale_light;
use crate::transport::stages::rescale_sensor::rescale_sensor;
use crate::transport::stages::scatter_light::scatter_light;
use crate::transport::stages::store_crossed_photons::store_crossed_photons;
use crate::transport::stages::weigh_choice::weigh_choice;
use crate::transport::tables::crossings::Crossing;
use crate::transport::tables::kernels::KernelColumns;
use crate::transport::tables::partition::Partition;
use crate::transport::tables::paths::PathTable;
use crate::transport::{Chunk, LightModel, Strategy};

use super::connect::connect_lamps;
use super::profile::{Profile, Stage};
use super::walk::WalkSide;
use super::workspace::{WalkTables, Workspace};

/// Paths from the sensor, `workspace.sensor`.
pub struct SensorWalk;

/// Paths from the emitters, `workspace.light`.
pub struct LightWalk;

impl SensorWalk {
    /// Starts the paths of a chunk. `light_paths` is the number of light paths an iteration that
    /// connect to the sensor, or zero.
    pub fn start<const N: usize, M: LightModel<N>>(
        w: &mut Workspace<N, M>,
        scene: &Scene<N>,
        chunk: &Chunk,
        light_paths: f32,
    ) {
        w.profile.time(Stage::Start, || {
            w.measured.clear();
            if scene.choice.depends_on_vantage() {
                w.sensor.iter_mut().for_each(|paths| paths.last.make(ROWS));
            }
            if light_paths == 0.0 {
                // Else vertices of light paths need theirs.
                w.walk.models.start(scene);
            }
            start_nesting(&mut w.sensor, scene);
            start_media(&mut w.sensor, scene);
            if scene.lamps.is_some() {
                w.sensor.iter_mut().for_each(|paths| paths.piece.make(ROWS));
            }
            let components = w.measured.components();
            generate_sensor_paths(&mut w.sensor[0], chunk, scene, light_paths, components);
        });
    }
}

impl LightWalk {
    /// Emits the paths of a chunk.
    pub fn start<const N: usize, M: LightModel<N>>(
        w: &mut Workspace<N, M>,
        scene: &Scene<N>,
        chunk: &Chunk,
    ) {
        w.profile.time(Stage::Start, || {
            w.splats.clear();
            w.walk.models.start(scene);
            start_nesting(&mut w.light, scene);
            start_media(&mut w.light, scene);
            emit_light_paths(&mut w.light[0], chunk, scene);
        });
    }
}

/// Paths that start know of no dielectrics, where they are to know of any.
fn start_nesting<const N: usize, C>(tables: &mut [PathTable<N, C>], scene: &Scene<N>) {
    if scene.interfaces.is_some() {
        tables.iter_mut().for_each(|paths| paths.nested.start(ROWS));
    }
}

/// Paths know of their wavelengths what the media that they may come to tell of these.
fn start_media<const N: usize, C>(tables: &mut [PathTable<N, C>], scene: &Scene<N>) {
    if scene.has_media() {
        let are_told = scene.has_chromatic_media();
        tables.iter_mut().for_each(|paths| paths.media.tell_wavelengths_apart(are_told));
    }
}

impl<const N: usize, M: LightModel<N>> WalkSide<N, M> for SensorWalk {
    type Carriers = M::Sensor;
    const SIDE: Side = Side::Sensor;

    #[inline(always)]
    fn tables(
        w: &mut Workspace<N, M>,
    ) -> (&mut [PathTable<N, M::Sensor>; 2], &mut WalkTables<N>, &mut Profile) {
        (&mut w.sensor, &mut w.walk, &mut w.profile)
    }

    fn vertices_kept(_strategy: Strategy, _path_length: u32) -> f32 {
        1.0
    }

    fn segments(chunk: &Chunk) -> u32 {
        chunk.path_length_max
    }

    fn comes_from_infinity(scene: &Scene<N>) -> bool {
        !scene.sensor.is_finite()
    }

    fn meet_emitters(w: &mut Workspace<N, M>, scene: &Scene<N>, finding: Finding) {
        let (paths, hits) = (&w.sensor[0], &w.walk.hits[0]);
        w.profile.time(Stage::Emission, || {
            collect_emission(&mut w.measured, paths, hits, scene, finding);
        });
        w.merged.end(&mut w.walk.hits[0], &w.sensor[0].rays.direction);
    }

    fn meet_emitters_crossed(
        w: &mut Workspace<N, M>,
        crossing: &Crossing<N>,
        scene: &Scene<N>,
        finding: Finding,
    ) {
        let (paths, flights) = (&w.sensor[0], &w.walk.flights);
        w.profile.time(Stage::Emission, || {
            collect_crossed_emission(&mut w.measured, paths, crossing, flights, scene, finding);
        });
    }

    /// They leave nothing.
    fn leave_crossed(_: &mut Workspace<N, M>, _: &Crossing<N>, _: &Scene<N>, _: Finding) {}

    fn connect_flights(
        w: &mut Workspace<N, M>,
        crossing: Option<&Crossing<N>>,
        scene: &Scene<N>,
        finding: Finding,
    ) {
        connect_lamps(w, crossing, scene, finding);
    }

    /// The sensor's rays are known.
    fn weigh_start(_: &mut PathTable<N, M::Sensor>, _: &SurfaceColumns, _: &Scene<N>) {}

    fn depolarize(w: &mut Workspace<N, M>) {
        let Workspace { sensor: [_, sorted], walk, measured, profile, .. } = w;
        let PathTable { carriers, beta, identity, .. } = sorted;
        profile.time(Stage::Mueller, || {
            depolarize_sensor(carriers, beta, measured, identity, &walk.partition);
        });
    }

    fn rescale(paths: &mut PathTable<N, M::Sensor>) {
        rescale_sensor(&mut paths.carriers, &mut paths.beta, paths.len);
    }

    fn apply_kernels(
        paths: &mut PathTable<N, M::Sensor>,
        kernels: &KernelColumns<N>,
        partition: &Partition,
        scene: &Scene<N>,
    ) {
        let (directions, up) = (&paths.rays.direction, scene.sensor.up());
        collect_sensor(&mut paths.carriers, kernels, directions, up, partition);
    }
}

impl<const N: usize, M: LightModel<N>> WalkSide<N, M> for LightWalk {
    type Carriers = M::Light;
    const SIDE: Side = Side::Light;

    #[inline(always)]
    fn tables(
        w: &mut Workspace<N, M>,
    ) -> (&mut [PathTable<N, M::Light>; 2], &mut WalkTables<N>, &mut Profile) {
        (&mut w.light, &mut w.walk, &mut w.profile)
    }

    /// The light of photons of one segment is found otherwise. Of the others, more cost more to
    /// merge than they gain where surfaces are bright; dark ones would have too few.
    fn vertices_kept(strategy: Strategy, path_length: u32) -> f32 {
        match (strategy, path_length) {
            (Strategy::Merging, 1) => 0.0,
            (Strategy::Merging, _) => 0.5,
            (Strategy::Unidirectional | Strategy::Bidirectional, _) => 1.0,
        }
    }

    /// One more leads to the sensor.
    fn segments(chunk: &Chunk) -> u32 {
        chunk.path_length_max.saturating_sub(1)
    }

    /// Which paths do is known by their densities.
    fn comes_from_infinity(_scene: &Scene<N>) -> bool {
        true
    }

    /// Emitters do not scatter light.
    fn meet_emitters(_: &mut Workspace<N, M>, _: &Scene<N>, _: Finding) {}

    /// Nor does their light stop there.
    fn meet_emitters_crossed(_: &mut Workspace<N, M>, _: &Crossing<N>, _: &Scene<N>, _: Finding) {}

    /// Where photons are shot: all but those that come straight from an emitter, as elsewhere.
    fn leave_crossed(
        w: &mut Workspace<N, M>,
        crossing: &Crossing<N>,
        scene: &Scene<N>,
        Finding { path_length, .. }: Finding,
    ) {
        let Workspace { photons: Some(photons), light: [paths, _], walk, profile, .. } = w else {
            return;
        };
        if path_length > 1 {
            let flights = &walk.flights;
            profile.time(Stage::Store, || {
                store_crossed_photons(photons, paths, crossing, flights, scene, path_length);
            });
        }
    }

    /// What they leave in media is stored there.
    fn connect_flights(_: &mut Workspace<N, M>, _: Option<&Crossing<N>>, _: &Scene<N>, _: Finding) {
    }

    /// How likely connections are to start paths where they did.
    fn weigh_start(
        paths: &mut PathTable<N, M::Light>,
        surfaces: &SurfaceColumns,
        scene: &Scene<N>,
    ) {
        weigh_choice(paths, surfaces, scene);
    }

    fn depolarize(w: &mut Workspace<N, M>) {
        let Workspace { light: [_, sorted], walk, profile, .. } = w;
        profile.time(Stage::Mueller, || {
            depolarize_light(&mut sorted.carriers, &mut sorted.beta, &walk.partition);
        });
    }

    fn rescale(paths: &mut PathTable<N, M::Light>) {
        rescale_light(&mut paths.carriers, &mut paths.beta, paths.len);
    }

    fn apply_kernels(
        paths: &mut PathTable<N, M::Light>,
        kernels: &KernelColumns<N>,
        partition: &Partition,
        _scene: &Scene<N>,
    ) {
        scatter_light(&mut paths.carriers, kernels, &paths.rays.direction, partition);
    }
}
