//! What light vertices do to light as connections find them again: eight rows of the table, which
//! may have met different things.

use crate::math::{F32s, LANES, U32s, Vector, lanes};
use crate::scattering::Met;
use crate::scattering::event::{Event, Form};
use crate::scattering::painting::SceneAt;
use crate::scattering::surface::Facing;
use crate::scattering::vertex::{KeptLanes, Scatterer, Turn, Vertices, for_scatterer};

use super::LightModel;
use super::tables::states::{self, LightState};
use super::tables::vertices::VertexTable;

/// What the `live` light vertices from `row` on do to light that leaves them along `direction`,
/// but for what is in their power.
#[inline(always)]
pub fn turn_of_light<const N: usize>(
    vertices: &VertexTable<N>,
    scene: SceneAt<N>,
    direction: Vector<F32s>,
    (row, live): (usize, usize),
) -> Turn<N> {
    let (first, others) = split(vertices, row, lanes::first(live));
    let turn = turn_of_event(vertices, scene, direction, row, first);
    if others.to_bitmask() == 0 {
        return turn;
    }
    turn_of_others(turn, vertices, scene, (direction, row), others)
}

/// Where vertices have met different things, which is not the rule.
#[inline(never)]
fn turn_of_others<const N: usize>(
    mut turn: Turn<N>,
    vertices: &VertexTable<N>,
    scene: SceneAt<N>,
    (direction, row): (Vector<F32s>, usize),
    others: F32s,
) -> Turn<N> {
    for (event, mask) in events(vertices, row, others) {
        let other = turn_of_event(vertices, scene, direction, row, (event, mask));
        turn = Turn::select(mask, other, turn);
    }
    turn
}

/// The turn of those in the mask, which have met the event.
#[inline(always)]
fn turn_of_event<const N: usize>(
    vertices: &VertexTable<N>,
    scene: SceneAt<N>,
    direction: Vector<F32s>,
    row: usize,
    (event, mask): (u32, F32s),
) -> Turn<N> {
    let given = Vector::load(&vertices.given, row);
    let kept = keep(vertices, row, mask);
    let turn = for_scatterer!(scene, scene.events[event as usize].met, all => {
        all.kept(kept).turn_of_light(given, direction)
    });
    turn.unwrap_or(Turn::none())
}

/// The light that leaves eight vertices along `direction`, where it is polarized.
#[inline(always)]
pub fn departing_states<const N: usize, M: LightModel<N>>(
    vertices: &VertexTable<N>,
    scene: SceneAt<N>,
    direction: Vector<F32s>,
    (row, live): (usize, usize),
) -> [Option<LightState<N>>; LANES] {
    let mut states = [None; LANES];
    if !(M::POLARIZED && scene.has_polarizing_vertices) {
        return states;
    }
    scatter_all(&mut states, vertices, scene, direction, (row, live));
    states
}

/// The states of eight vertices; out of the loops of all models that connect to them, which would
/// take long to build.
#[inline(never)]
fn scatter_all<const N: usize>(
    states: &mut [Option<LightState<N>>; LANES],
    vertices: &VertexTable<N>,
    scene: SceneAt<N>,
    direction: Vector<F32s>,
    (row, live): (usize, usize),
) {
    for (event, mask) in events(vertices, row, lanes::first(live)) {
        let Event { met, form, .. } = scene.events[event as usize];
        if form != Form::Depolarizer {
            scatter_states(states, vertices, (scene, met), direction, (row, mask));
        }
    }
}

/// The states of the lanes in the mask, which have all met the same.
#[inline(always)]
fn scatter_states<const N: usize>(
    states: &mut [Option<LightState<N>>; LANES],
    vertices: &VertexTable<N>,
    (scene, met): (SceneAt<N>, Met),
    direction: Vector<F32s>,
    (row, mask): (usize, F32s),
) {
    let k_in = -Vector::load(&vertices.given, row);
    let found = for_scatterer!(scene, met, all => {
        all.kept(keep(vertices, row, mask)).leaving(k_in, direction)
    });
    let Some(leaving) = found else { return };
    let mask = mask.to_bits().to_array();
    let lanes = (0..LANES).filter(|&lane| mask[lane] != 0);
    let state = |lane: usize| vertices.states.get(vertices.state[row + lane] as usize);
    let to = |lane: usize, light: &LightState<N>| states[lane] = Some(*light);
    states::scatter_states(&leaving, k_in, lanes, state, to);
}

/// What is kept of eight vertices; `mask` are those of the scatterer that they are for.
#[inline(always)]
fn keep<const N: usize>(vertices: &VertexTable<N>, row: usize, mask: F32s) -> KeptLanes {
    let facing = Facing {
        geometric: Vector::load(&vertices.geometric_normal, row),
        shading: Vector::load(&vertices.shading_normal, row),
        two_sided: lanes::load(&vertices.two_sided, row).simd_gt(F32s::splat(0.5)),
    };
    let mask: U32s = bytemuck::cast(mask);
    KeptLanes { facing, rows: lanes::load_u32(&vertices.row, row) & mask }
}

/// What the first of the vertices in the mask has met, with the mask of those that have met the
/// same, and the mask of the others. In lanes of neither mask there may be anything.
#[inline(always)]
fn split<const N: usize>(vertices: &VertexTable<N>, row: usize, mask: F32s) -> ((u32, F32s), F32s) {
    let event = vertices.event[row + mask.to_bitmask().trailing_zeros() as usize];
    let events = lanes::load_u32(&vertices.event, row);
    let same: F32s = bytemuck::cast(events.simd_eq(U32s::splat(event)));
    ((event, mask & same), mask & !same)
}

/// What those of the eight vertices from `row` on that are in the mask have met, each with the
/// mask of those that have.
#[inline(always)]
fn events<const N: usize>(
    vertices: &VertexTable<N>,
    row: usize,
    mask: F32s,
) -> impl Iterator<Item = (u32, F32s)> {
    let mut left = mask;
    std::iter::from_fn(move || {
        if left.to_bitmask() == 0 {
            return None;
        }
        let (event, others) = split(vertices, row, left);
        left = others;
        Some(event)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_that_are_not_in_use_stay_out_of_every_mask() {
        let mut vertices = VertexTable::<1>::new(LANES);
        vertices.event[..LANES].copy_from_slice(&[3, 1, 3, 2, 1, 3, 9, 9]);
        vertices.row[..LANES].copy_from_slice(&[4, 5, 6, 7, 8, 90, 91, 92]);
        let found: Vec<(u32, u32, [u32; LANES])> = events(&vertices, 0, lanes::first(5))
            .map(|(event, mask)| (event, mask.to_bitmask(), keep(&vertices, 0, mask).rows.into()))
            .collect();
        let expected = [
            (3, 0b00101, [4, 0, 6, 0, 0, 0, 0, 0]),
            (1, 0b10010, [0, 5, 0, 0, 8, 0, 0, 0]),
            (2, 0b01000, [0, 0, 0, 7, 0, 0, 0, 0]),
        ];
        assert_eq!(found, expected);
    }
}
