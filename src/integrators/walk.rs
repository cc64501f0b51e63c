//! The walk that paths of either side take, from vertex to vertex. An integrator says what is
//! done at each.

use crate::geometry::{SurfaceColumns, resolve_surfaces, trace_closest};
use crate::math::columns::Columns;
use crate::scattering::event::END;
use crate::scattering::{Scene, Side};
use crate::transport::emission::Finding;
use crate::transport::scale::LOOKS;
use crate::transport::stages::advance_paths::advance_paths;
use crate::transport::stages::choose_passage::choose_passage;
use crate::transport::stages::cross_surfaces::cross_surfaces;
use crate::transport::stages::draw_distances::draw_distances;
use crate::transport::stages::fly_through_media::fly_through_media;
use crate::transport::stages::fly_to_crossings::fly_to_crossings;
use crate::transport::stages::follow_paths::follow_paths;
use crate::transport::stages::keep_pieces::keep_pieces;
use crate::transport::stages::paint_surfaces::paint_surfaces;
use crate::transport::stages::partition_paths::partition_paths;
use crate::transport::stages::pass_surfaces::pass_surfaces;
use crate::transport::stages::play_roulette::{pay_out, play_roulette};
use crate::transport::stages::scatter_medium::scatter_medium;
use crate::transport::stages::scatter_surfaces::scatter_surfaces;
use crate::transport::stages::weigh_arrival::weigh_arrival;
use crate::transport::tables::carriers::CarrierTable;
use crate::transport::tables::crossings::{Crossing, CrossingTable};
use crate::transport::tables::kernels::{DepartureColumns, KernelColumns};
use crate::transport::tables::partition::Partition;
use crate::transport::tables::paths::PathTable;
use crate::transport::{Bounce, Chunk, LightModel, Strategy};

use super::profile::{Profile, Stage};
use super::workspace::{WalkTables, Workspace};

/// What the walks of the two sides do not have in common.
pub trait WalkSide<const N: usize, M: LightModel<N>> {
    /// Polarization that paths carry along.
    type Carriers: CarrierTable;
    /// Which way paths are traced.
    const SIDE: Side;

    /// The paths and where they are sorted to, what the walk works with, and its clock.
    fn tables(
        workspace: &mut Workspace<N, M>,
    ) -> (&mut [PathTable<N, Self::Carriers>; 2], &mut WalkTables<N>, &mut Profile);

    /// How many of the vertices after `path_length` segments are needed if paths end there.
    fn vertices_kept(strategy: Strategy, path_length: u32) -> f32;

    /// Segments that are traced at most.
    fn segments(chunk: &Chunk) -> u32;

    /// Whether first segments may come from infinity.
    fn comes_from_infinity(scene: &Scene<N>) -> bool;

    /// Does what there is to do with emitters that the segments just traced have met.
    fn meet_emitters(workspace: &mut Workspace<N, M>, scene: &Scene<N>, finding: Finding);

    /// The same for emitters that are crossed.
    fn meet_emitters_crossed(
        workspace: &mut Workspace<N, M>,
        crossing: &Crossing<N>,
        scene: &Scene<N>,
        finding: Finding,
    );

    /// Leaves at a crossing what is left there whether the path passes or not.
    fn leave_crossed(
        workspace: &mut Workspace<N, M>,
        crossing: &Crossing<N>,
        scene: &Scene<N>,
        finding: Finding,
    );

    /// Looks for lamps from the media that the segments are about to go through: up to a crossing,
    /// or to their ends.
    fn connect_flights(
        workspace: &mut Workspace<N, M>,
        crossing: Option<&Crossing<N>>,
        scene: &Scene<N>,
        finding: Finding,
    );

    /// Brings what is known of starts only at their ends to the partial weights.
    fn weigh_start(
        paths: &mut PathTable<N, Self::Carriers>,
        surfaces: &SurfaceColumns,
        scene: &Scene<N>,
    );

    /// Ends the polarization of the sorted paths at depolarizers.
    fn depolarize(workspace: &mut Workspace<N, M>);

    /// Keeps polarization within the range of numbers.
    fn rescale(paths: &mut PathTable<N, Self::Carriers>);

    /// Applies the kernels of polarizing events; `paths` still have the old directions.
    fn apply_kernels(
        paths: &mut PathTable<N, Self::Carriers>,
        kernels: &KernelColumns<N>,
        partition: &Partition,
        scene: &Scene<N>,
    );
}

/// Takes the paths of a chunk, which have been started, from vertex to vertex, and calls `visit`
/// with the segments so far whenever they have arrived at vertices that are not their last ones.
/// `workspace.walk` holds these, in the order of the sorted paths.
pub fn walk<S: WalkSide<N, M>, const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
    strategy: Strategy,
    mut visit: impl FnMut(&mut Workspace<N, M>, u32),
) {
    let segments = S::segments(chunk);
    let started = throughput::<S, N, M>(w, |_| true);
    S::tables(w).2.cut[S::SIDE as usize].started += started;
    for path_length in 1..=segments {
        if (path_length as usize).is_multiple_of(LOOKS) {
            let ([paths, _], _, profile) = S::tables(w);
            profile.time(Stage::Mueller, || S::rescale(paths));
        }
        let is_last = path_length == chunk.path_length_max;
        let finding = Finding { path_length, is_last, strategy };
        trace::<S, N, M>(w, scene, finding);
        S::meet_emitters(w, scene, finding);
        if path_length == segments {
            let goes_on = |hit| scene.event_hit(hit) != END;
            let cut = throughput::<S, N, M>(w, goes_on);
            S::tables(w).2.cut[S::SIDE as usize].cut += cut;
        }
        if is_last {
            break;
        }
        arrive::<S, N, M>(w, scene, chunk, path_length, strategy);
        visit(w, path_length);
        if path_length == segments || !depart::<S, N, M>(w, scene, chunk, path_length) {
            break;
        }
    }
}

/// The throughput of the paths under way, summed over those whose hits `count`.
fn throughput<S: WalkSide<N, M>, const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    counts: impl Fn(u32) -> bool,
) -> f64 {
    let ([paths, _], WalkTables { hits: [hits, _], .. }, _) = S::tables(w);
    let rows = (0..paths.len).filter(|&row| counts(hits.primitive[row]));
    let sum: f64 =
        rows.flat_map(|row| paths.beta.iter().map(move |beta| f64::from(beta[row]))).sum();
    sum / N as f64
}

/// Finds the ends of the next segments, on surfaces or in media.
fn trace<S: WalkSide<N, M>, const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    finding: Finding,
) {
    let ([paths, _], walk, profile) = S::tables(w);
    let WalkTables { hits: [hits, _], flights, crossings, scratch, .. } = walk;
    profile.rays_closest += paths.len as u64;
    profile.time(Stage::Trace, || {
        trace_closest(hits, scratch, &paths.rays, 0..paths.len, &scene.accelerator);
    });
    if scene.has_straight_on {
        profile.time(Stage::Flight, || {
            follow_paths(crossings, hits, (flights, scratch), paths, scene);
            pass_surfaces_of::<N, M>(crossings, scene);
        });
    } else if scene.has_media() {
        flights.start(paths.len);
    }
    if scene.has_media() {
        profile.time(Stage::Flight, || draw_distances(flights, paths, scene, finding.path_length));
    }
    cross::<S, N, M>(w, scene, finding);
    if scene.has_media() {
        S::connect_flights(w, None, scene, finding);
        let ([paths, _], WalkTables { hits: [hits, _], flights, .. }, profile) = S::tables(w);
        profile.time(Stage::Flight, || {
            fly_through_media(hits, paths, flights, scene);
            if paths.piece.present() {
                keep_pieces(paths, hits, flights);
            }
        });
    }
}

/// Takes paths through the surfaces that let them straight on.
fn cross<S: WalkSide<N, M>, const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    finding: Finding,
) {
    if !scene.has_straight_on {
        return;
    }
    let crossings = std::mem::replace(&mut S::tables(w).1.crossings, CrossingTable::absent());
    for (crossed, part) in crossings.parts.iter().enumerate() {
        if crossed % LOOKS == LOOKS - 1 {
            let ([paths, _], _, profile) = S::tables(w);
            profile.time(Stage::Mueller, || S::rescale(paths));
        }
        let crossing = &Crossing { crossings: &crossings, part, side: S::SIDE };
        if scene.has_media() {
            S::connect_flights(w, Some(crossing), scene, finding);
            let ([paths, _], WalkTables { hits: [hits, _], flights, .. }, profile) = S::tables(w);
            profile.time(Stage::Flight, || fly_to_crossings(hits, flights, paths, crossing, scene));
        }
        if scene.has_emitting_straight_on {
            S::meet_emitters_crossed(w, crossing, scene, finding);
        }
        S::leave_crossed(w, crossing, scene, finding);
        let ([paths, _], walk, profile) = S::tables(w);
        let WalkTables { hits: [hits, _], flights, partition, departures, .. } = walk;
        let kernels = &mut departures.kernels;
        profile.time(Stage::Flight, || {
            choose_passage(hits, flights, paths, crossing, finding.path_length);
            let to = (&mut *kernels, &mut *partition);
            if M::POLARIZED {
                cross_surfaces::<N, true, _>(paths, to, crossing, flights, scene);
            } else {
                cross_surfaces::<N, false, _>(paths, to, crossing, flights, scene);
            }
        });
        profile.time(Stage::Mueller, || S::apply_kernels(paths, kernels, partition, scene));
    }
    S::tables(w).1.crossings = crossings;
}

/// What surfaces do to light that goes straight on, in the mode of the light model.
pub fn pass_surfaces_of<const N: usize, M: LightModel<N>>(
    crossings: &mut CrossingTable<N>,
    scene: &Scene<N>,
) {
    if M::POLARIZED {
        pass_surfaces::<N, true>(crossings, scene);
    } else {
        pass_surfaces::<N, false>(crossings, scene);
    }
}

/// Plays roulette, groups the paths by what they have hit and brings them there.
fn arrive<S: WalkSide<N, M>, const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
    path_length: u32,
    strategy: Strategy,
) {
    let ([paths, sorted], tables, profile) = S::tables(w);
    let WalkTables { hits: [hits, sorted_hits], flights, surfaces, models, partition, .. } = tables;
    profile.time(Stage::Sort, || {
        if chunk.plays_roulette(S::SIDE, path_length) {
            let kept = S::vertices_kept(strategy, path_length);
            play_roulette(paths, hits, (scene, flights), path_length, kept);
        } else {
            paths.odds[..paths.len].fill(1.0);
        }
        partition_paths(sorted, sorted_hits, partition, paths, hits, scene);
        resolve_surfaces(surfaces, sorted_hits, &sorted.rays, 0..sorted.len, &scene.shapes);
        paint_surfaces(surfaces, models, (sorted_hits, sorted), scene, S::SIDE);
        if strategy == Strategy::Bidirectional {
            let from_infinity = path_length == 1 && S::comes_from_infinity(scene);
            weigh_arrival(sorted, sorted_hits, surfaces, (scene, partition), from_infinity);
            if path_length == 1 {
                S::weigh_start(sorted, surfaces, scene);
            }
        }
    });
    S::depolarize(w);
}

/// Sends the sorted paths that go on on in new directions; false if there are none.
fn depart<S: WalkSide<N, M>, const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
    path_length: u32,
) -> bool {
    let (tables, walk, profile) = S::tables(w);
    let sorted = &mut tables[1];
    sorted.len = walk.partition.keep_going_on();
    if sorted.len == 0 {
        return false;
    }
    let bounce = Bounce { path_length, side: S::SIDE, sampling: chunk.sampling };
    profile.time(Stage::Scatter, || {
        if chunk.plays_roulette(S::SIDE, path_length) {
            pay_out(sorted);
        }
        scatter::<N, M, _>(sorted, walk, scene, bounce);
    });
    let WalkTables { surfaces, partition, departures, .. } = walk;
    let DepartureColumns { direction, kernels } = departures;
    profile.time(Stage::Mueller, || S::apply_kernels(sorted, kernels, partition, scene));
    profile.time(Stage::Advance, || advance_paths(sorted, direction, surfaces, scene));
    tables.swap(0, 1);
    true
}

/// Draws a new direction for every row, with its kernel where the mode asks for one.
fn scatter<const N: usize, M: LightModel<N>, C: CarrierTable>(
    paths: &mut PathTable<N, C>,
    walk: &mut WalkTables<N>,
    scene: &Scene<N>,
    bounce: Bounce,
) {
    let WalkTables { surfaces, models, partition, departures, .. } = walk;
    let at = models.of(scene);
    if M::POLARIZED {
        scatter_surfaces::<N, true, C>(departures, paths, surfaces, at, partition, bounce);
        scatter_medium::<N, true, C>(departures, paths, scene, partition, bounce);
    } else {
        scatter_surfaces::<N, false, C>(departures, paths, surfaces, at, partition, bounce);
        scatter_medium::<N, false, C>(departures, paths, scene, partition, bounce);
    }
}
