//! How far the photons nearest to some points are: what the first radius of a render is made of.

use rayon::prelude::*;

use crate::math::columns::Column;
use crate::math::{F32s, LANES, Vector, lanes};

use super::photons::PhotonTable;

/// Points that a thread takes at a time.
const POINTS: usize = 8;
/// Photons that all points of a group look at before the next photons are read.
const ROWS: usize = 4096;

/// For each of `points`, a thousand at most or it takes long, the distance in scene units to the
/// photon that is the `count`-th nearest; infinite if there are fewer. Every photon is looked at,
/// those at positions that are not finite do not count.
pub fn nearest_distances<const N: usize>(
    photons: &PhotonTable<N>,
    points: &[[f32; 3]],
    count: usize,
) -> Vec<f32> {
    assert!(count > 0, "the nearest photon is number one");
    let mut distances = vec![0.0; points.len()];
    let groups = distances.par_chunks_mut(POINTS).zip(points.par_chunks(POINTS));
    groups.for_each(|(distances, points)| {
        let mut nearest: Vec<_> = points.iter().map(|_| vec![f32::INFINITY; count]).collect();
        for start in (0..photons.len).step_by(ROWS) {
            let end = photons.len.min(start + ROWS);
            for (nearest, point) in nearest.iter_mut().zip(points) {
                look_at(nearest, &photons.position, start..end, *point);
            }
        }
        for (distance, nearest) in distances.iter_mut().zip(&nearest) {
            *distance = nearest[count - 1].sqrt();
        }
    });
    distances
}

/// Keeps in `nearest` the smallest squared distances, in ascending order.
fn look_at(
    nearest: &mut [f32],
    position: &[Column; 3],
    rows: std::ops::Range<usize>,
    point: [f32; 3],
) {
    let center = Vector::splat(point);
    let last = nearest.len() - 1;
    for row in rows.clone().step_by(LANES) {
        let squared = (Vector::load(position, row) - center).length_squared();
        let nearer = squared.simd_lt(F32s::splat(nearest[last])) & lanes::first(rows.end - row);
        if nearer.any() {
            let (squared, mut left) = (squared.to_array(), nearer.to_bitmask());
            while left != 0 {
                insert(nearest, squared[left.trailing_zeros() as usize]);
                left &= left - 1;
            }
        }
    }
}

fn insert(nearest: &mut [f32], squared: f32) {
    let place = nearest.partition_point(|&other| other <= squared);
    if place < nearest.len() {
        nearest[place..].rotate_right(1);
        nearest[place] = squared;
    }
}
