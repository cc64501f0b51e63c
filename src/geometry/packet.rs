//! Eight rays that run alike on one way through the tree.
//!
//! The bounds of a child are tested against all eight. In leaves each ray goes on alone, and so it
//! does below nodes that hardly any of the others enters.

use crate::math::{F32s, LANES, lanes};

use super::block::{Node, Reference};
use super::prepared::Prepared;
use super::rays::Hit;
use super::tree::View;
use super::walk::{Inside, Walk};

/// Up to so many rays go on alone.
const FEW: u32 = 2;

/// Takes eight rays to their ends, which are prepared one after the other. With `ANY` the first
/// hit of each is its last.
#[inline(always)]
pub(super) fn walk_alike<const FLIGHT: usize, const ANY: bool>(
    tree: &View,
    prepared: &Prepared,
    mut walks: [Walk; LANES],
    alike: &mut [(F32s, Reference)],
    (entries, inside): (&mut [(f32, Reference)], &mut Inside),
    better: &mut impl FnMut(usize, Hit) -> bool,
) {
    let first = walks[0].ray;
    let mut t_max: [f32; LANES] = std::array::from_fn(|lane| walks[lane].t_max);
    let mut top = 1;
    alike[0] = (F32s::ZERO, tree.root);
    while top > 0 {
        top -= 1;
        let (enter, next) = alike[top];
        let limit = lanes::load(&t_max, 0);
        let is_in = enter.simd_le(limit).to_bitmask();
        if !next.is_leaf() && is_in.count_ones() > FEW {
            let node = &tree.nodes[next.row()];
            let push = if ANY || FLIGHT == 1 { push_alike::<false> } else { push_alike::<true> };
            top = push(alike, top, prepared, first, (tree, node), limit);
            continue;
        }
        for lane in (0..LANES).filter(|lane| is_in >> lane & 1 == 1) {
            let walk = &mut walks[lane];
            walk.next = next;
            if next.is_leaf() {
                walk.meet_leaf::<ANY>(tree, prepared, inside, better);
            } else {
                while walk.step::<ANY>(tree, prepared, entries, inside, better) {}
            }
            let is_over = ANY && walk.has_hit();
            t_max[lane] = if is_over { f32::NEG_INFINITY } else { walk.t_max };
        }
    }
}

/// Pushes the children that any ray enters, with the nearest on top, as the first of those rays
/// sees it; returns the new top. To ask for all of their memory makes the search for nearest hits
/// in large trees 12 % faster; other searches end before they visit most of it.
#[inline(always)]
fn push_alike<const PREFETCH: bool>(
    stack: &mut [(F32s, Reference)],
    base: usize,
    prepared: &Prepared,
    first: usize,
    (tree, node): (&View, &Node),
    t_max: F32s,
) -> usize {
    let mut top = base;
    let mut keys = [0.0; LANES];
    // Not before anything, as infinity would be before no limit.
    let never = F32s::splat(f32::NAN);
    for (lane, child) in node.children.iter().enumerate() {
        if *child == Reference::NONE {
            break;
        }
        let (enter, is_in) = prepared.enter_one(first, node, lane, t_max);
        let lanes = is_in.to_bitmask();
        if lanes == 0 {
            continue;
        }
        let key = enter.as_array()[(lanes.trailing_zeros() & 7) as usize];
        let entry = (is_in.select(enter, never), *child);
        let mut slot = top;
        while slot > base && keys[(slot - base - 1) & 7] < key {
            stack[slot] = stack[slot - 1];
            keys[(slot - base) & 7] = keys[(slot - base - 1) & 7];
            slot -= 1;
        }
        stack[slot] = entry;
        if PREFETCH {
            tree.prefetch(*child);
        }
        keys[(slot - base) & 7] = key;
        top += 1;
    }
    top
}
