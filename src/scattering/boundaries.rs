//! What the sides of boundaries are that do not say so themselves, or that contradict each other.
//!
//! A side that is not stated is what surrounds it: what those boundaries state that can be seen
//! from there, or what theirs turn out to be. Where boundaries say different things about the same
//! place, because they overlap, touch or are wrong, the medium of a point is that of the smallest
//! body around it, whatever crosses whichever surface: the innermost where bodies are nested. So
//! paths of either side know the same.

use std::collections::{BTreeMap, BTreeSet};

use glam::Vec3;
use rayon::prelude::*;

use super::immersion::{Immersion, Seen, spread};
use super::nesting::{engulfed, fill, nest};
use super::patches::{Patches, join, primitives_of_surfaces, wholes};
use crate::geometry::Accelerator;
use crate::scene::baked::{Body, KEEP, NONE, SOUGHT, Shapes};

/// Looks from all boundaries together, about, and from one of them.
const LOOKS: usize = 1 << 15;
const LOOKS_OF_SURFACE: [usize; 2] = [8, 64];

/// Points of all sides together, about, and of one of them, at which the bodies around are compared
/// with what it says.
const CHECKS: usize = 1 << 13;
const CHECKS_OF_SIDE: [usize; 2] = [2, 16];

/// The share of looks that may disagree with the others: they slip through seams, or along edges.
const SLIPS: f64 = 1.0 / 32.0;

/// Rounds in which unstated sides learn from each other.
const ROUNDS: usize = 64;

/// What boundaries leave in doubt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doubt {
    /// Two closed surfaces overlap: the smaller counts.
    Overlap([u32; 2]),
    /// Another surface says something else about a side of this one (0 behind, 1 before it).
    Contradiction {
        /// The surface.
        surface: u32,
        /// Its side.
        side: usize,
        /// The other surface.
        other: u32,
    },
    /// This closed body of a dielectric is inside of the other surface, which is not closed.
    Engulfed([u32; 2]),
    /// From a side of this surface, one looks out of the scene, where there is another medium.
    Open {
        /// The surface.
        surface: u32,
        /// Its side.
        side: usize,
    },
}

/// A surface that bounds something.
struct Boundary {
    surface: u32,
    /// The first of the surfaces that bound the same together.
    whole: u32,
    /// Points on it and the normals there.
    points: Vec<(Vec3, Vec3)>,
    /// How far off it one is on a side of it.
    step: f32,
    /// Whether nothing gets out of it but through it.
    is_closed: bool,
    /// Volume of its box.
    size: f32,
    /// The corners of its box.
    bounds: [Vec3; 2],
    /// What is seen from behind and before it.
    seen: [Vec<Seen>; 2],
}

/// What the looks from a side say: how many say which medium, and one of the surfaces that did.
type Tally = BTreeMap<u32, (usize, Option<u32>)>;

/// Finds what boundaries do not say, and what they say wrongly.
pub fn settle(shapes: &mut Shapes, accelerator: &Accelerator) -> Vec<Doubt> {
    let bounds =
        |row: u32| shapes.surfaces[row as usize].is_body || sides_of(shapes, row) != [KEEP; 2];
    let primitives = primitives_of_surfaces(shapes, bounds);
    join(shapes, &primitives);
    nest(shapes, &primitives);
    let engulfed = engulfed(shapes, accelerator, &primitives);
    let mut doubts: Vec<Doubt> = engulfed.into_iter().map(Doubt::Engulfed).collect();
    if is_one_medium(shapes) {
        return doubts;
    }
    let boundaries = look_around(shapes, accelerator, &primitives);
    let open = learn(shapes, &boundaries);
    shapes.bodies = bodies(shapes, &boundaries, &open);
    surround(shapes, accelerator, &boundaries, &open);
    let none = BTreeSet::new();
    let tallies =
        boundaries.iter().map(|it| it.seen.each_ref().map(|seen| tally(shapes, &none, seen)));
    let tallies: Vec<[Tally; 2]> = tallies.collect();
    let immersion = Immersion::new(shapes, accelerator, true);
    let told = Told::by(&immersion, &boundaries, &open);
    let mut sought = told.misled(shapes, &boundaries);
    let are_bodies_all = told.is_by_bodies_alone(&boundaries);
    for (boundary, tallies) in boundaries.iter().zip(&tallies) {
        for (side, tally) in tallies.iter().enumerate() {
            judge(&immersion, &boundaries, (boundary, side, tally), &mut sought, &mut doubts);
        }
    }
    doubts.dedup();
    let is_new = |index: usize| !doubts[..index].contains(&doubts[index]);
    let doubts = (0..doubts.len()).filter(|&index| is_new(index)).map(|index| doubts[index]);
    let doubts = doubts.collect();
    if !sought.is_empty() {
        shapes.are_bodies_all = are_bodies_all;
        seek(shapes, &boundaries, &sought);
    }
    doubts
}

fn sides_of(shapes: &Shapes, surface: u32) -> [u32; 2] {
    let surface = &shapes.surfaces[surface as usize];
    [surface.interior, surface.exterior]
}

/// Whether all that boundaries say is the same.
fn is_one_medium(shapes: &Shapes) -> bool {
    let sides = shapes.surfaces.iter().flat_map(|surface| [surface.interior, surface.exterior]);
    sides.into_iter().all(|side| side == KEEP || side == shapes.scene_medium)
}

/// All boundaries, with what is seen from both sides of each.
fn look_around(
    shapes: &Shapes,
    accelerator: &Accelerator,
    primitives: &[Vec<u32>],
) -> Vec<Boundary> {
    let rows = 0..shapes.surfaces.len() as u32;
    let bounding: Vec<u32> = rows.filter(|&row| sides_of(shapes, row) != [KEEP; 2]).collect();
    let [least, most] = LOOKS_OF_SURFACE;
    let count = (LOOKS / bounding.len().max(1)).clamp(least, most);
    let wholes = wholes(shapes, primitives);
    let immersion = Immersion::new(shapes, accelerator, true);
    let boundary = |&surface: &u32| {
        let patches = Patches::new(shapes, &primitives[surface as usize]);
        let points = patches.points(count);
        let step = patches.step();
        let look = |side: f32| {
            let ray = |(&(point, normal), aside): (&(Vec3, Vec3), Vec3)| {
                let outwards = normal * side;
                (point + step * outwards, (outwards + 0.99 * aside).normalize())
            };
            let rays = || points.iter().zip(spread(points.len())).map(ray);
            let seen: Vec<Seen> =
                rays().map(|(origin, direction)| immersion.see(origin, direction)).collect();
            if seen.iter().any(|seen| *seen != Seen::Nothing) {
                return seen;
            }
            let around =
                |(index, (origin, direction))| immersion.see_around(origin, direction, index);
            (0..).zip(rays()).map(around).collect()
        };
        let seen = [look(-1.0), look(1.0)];
        let whole = shapes.surfaces[surface as usize].whole;
        let all = Patches::new(shapes, &wholes[&whole]);
        let (is_closed, size, bounds) = (all.is_closed(), all.size(), all.bounds());
        Boundary { surface, whole, points, step, is_closed, size, bounds, seen }
    };
    bounding.iter().map(boundary).collect()
}

/// Settles the sides that are not stated, nearest to what is stated first; those that nothing is
/// seen from are left.
fn learn(shapes: &mut Shapes, boundaries: &[Boundary]) -> BTreeSet<(u32, usize)> {
    let is_unstated = |shapes: &Shapes, surface: u32, side: usize| {
        shapes.surfaces[surface as usize].unstated[side]
    };
    let mut open: BTreeSet<(u32, usize)> = boundaries
        .iter()
        .flat_map(|boundary| [(boundary.surface, 0), (boundary.surface, 1)])
        .filter(|&(surface, side)| is_unstated(shapes, surface, side))
        .collect();
    for _ in 0..ROUNDS {
        let known = |boundary: &Boundary, side: usize| {
            let tally = tally(shapes, &open, &boundary.seen[side]);
            let most = tally.iter().max_by_key(|(_, (count, _))| *count)?;
            Some((boundary.surface, side, *most.0))
        };
        let sides = boundaries.iter().flat_map(|boundary| [(boundary, 0), (boundary, 1)]);
        let asked = sides.filter(|(boundary, side)| open.contains(&(boundary.surface, *side)));
        let learned: Vec<_> = asked.filter_map(|(boundary, side)| known(boundary, side)).collect();
        if learned.is_empty() {
            break;
        }
        for (surface, side, medium) in learned {
            open.remove(&(surface, side));
            let surface = &mut shapes.surfaces[surface as usize];
            *[&mut surface.interior, &mut surface.exterior][side] = medium;
        }
    }
    open
}

/// What closed boundaries hold, but for those of which that is open.
fn bodies(shapes: &Shapes, boundaries: &[Boundary], open: &BTreeSet<(u32, usize)>) -> Vec<Body> {
    let body = |boundary: &Boundary| {
        let filling = sides_of(shapes, boundary.surface)[0];
        let is_known = filling != KEEP && !open.contains(&(boundary.surface, 0));
        let is_body = boundary.is_closed && is_known && boundary.surface == boundary.whole;
        let priority = shapes.surfaces[boundary.surface as usize].priority;
        is_body.then_some(Body {
            surface: boundary.surface,
            filling,
            priority,
            size: boundary.size,
        })
    };
    boundaries.iter().filter_map(body).collect()
}

/// Settles the sides that walls hide from all others by the bodies around. What a closed surface
/// does not say of its inside is the rest of the scene.
fn surround(
    shapes: &mut Shapes,
    accelerator: &Accelerator,
    boundaries: &[Boundary],
    open: &BTreeSet<(u32, usize)>,
) {
    for boundary in boundaries {
        let Some(&(point, normal)) = boundary.points.first() else { continue };
        for (side, off) in [(0, -boundary.step), (1, boundary.step)] {
            let is_inside = side == 0 && boundary.is_closed;
            if is_inside || !open.contains(&(boundary.surface, side)) {
                continue;
            }
            let immersion = Immersion::new(shapes, accelerator, true);
            let medium = immersion.behind_walls(point + off * normal);
            let surface = &mut shapes.surfaces[boundary.surface as usize];
            *[&mut surface.interior, &mut surface.exterior][side] = medium;
        }
    }
}

/// What the sides of boundaries have been told, as far as closed bodies say what is there: a medium
/// is that of the body which counts, wherever one is.
struct Told {
    /// Per boundary and side, whether bodies have other media there than its own, in places.
    strays: Vec<[bool; 2]>,
    /// Whether what it says comes of closed bodies alone.
    by_bodies: Vec<[bool; 2]>,
}

impl Told {
    fn by(immersion: &Immersion, boundaries: &[Boundary], open: &BTreeSet<(u32, usize)>) -> Self {
        if immersion.shapes().bodies.is_empty() {
            let none = vec![[false; 2]; boundaries.len()];
            return Self { strays: none.clone(), by_bodies: none };
        }
        let [least, most] = CHECKS_OF_SIDE;
        let count = (CHECKS / boundaries.len().max(1)).clamp(least, most);
        let strays = |it: &Boundary| {
            let is_checked = |side: usize| {
                !it.is_unknown(side, open) && (side == 1 || may_be_outranked(immersion, it))
            };
            [0, 1].map(|side| is_checked(side) && strays(immersion, (it, side), count))
        };
        let strays: Vec<[bool; 2]> = boundaries.par_iter().map(strays).collect();
        let is_stated = |it: &Boundary, side| is_stated(immersion.shapes(), it, side);
        // What closed bodies hold is theirs to say; what else is stated is to agree with that.
        let by_bodies = |(it, strays): (&Boundary, &[bool; 2])| {
            [0, 1].map(|side| match it.is_closed && side == 0 {
                true => !it.is_unknown(side, open),
                false => !is_stated(it, side) || !strays[side],
            })
        };
        let mut by_bodies: Vec<_> = boundaries.iter().zip(&strays).map(by_bodies).collect();
        let sides = (0..boundaries.len()).flat_map(|index| [(index, 0), (index, 1)]);
        let mut learned: Vec<(usize, usize)> =
            sides.filter(|&(index, side)| !is_stated(&boundaries[index], side)).collect();
        let row_of: BTreeMap<u32, usize> =
            boundaries.iter().zip(0..).map(|(it, row)| (it.surface, row)).collect();
        for _ in 0..ROUNDS {
            let is_by_bodies = |seen: &Seen| match *seen {
                Seen::Nothing | Seen::Outside => true,
                Seen::Side(surface, side) => by_bodies[row_of[&surface]][side],
            };
            let (kept, other): (Vec<_>, Vec<_>) = learned
                .into_iter()
                .partition(|&(index, side)| boundaries[index].seen[side].iter().all(is_by_bodies));
            if other.is_empty() {
                break;
            }
            other.into_iter().for_each(|(index, side)| by_bodies[index][side] = false);
            learned = kept;
        }
        Self { strays, by_bodies }
    }

    /// Surfaces on whose sides the medium is not all over what they state or have been told: where
    /// a body of higher priority is around them, and where they were told by a side that is in
    /// several media, as the outside of a hollow body is.
    fn misled(&self, shapes: &Shapes, boundaries: &[Boundary]) -> BTreeSet<u32> {
        let is_misled = |&(index, it): &(usize, &Boundary)| {
            let is_own = |side: usize| it.is_closed && side == 0 || !is_stated(shapes, it, side);
            let [strays, by_bodies] = [&self.strays, &self.by_bodies].map(|of| of[index]);
            (0..2).any(|side| strays[side] && by_bodies[side] && is_own(side))
        };
        boundaries.iter().enumerate().filter(is_misled).map(|(_, it)| it.whole).collect()
    }

    /// Whether bodies say of every place what is there.
    fn is_by_bodies_alone(&self, boundaries: &[Boundary]) -> bool {
        boundaries.iter().all(|it| it.is_closed) && self.by_bodies.iter().flatten().all(|it| *it)
    }
}

impl Boundary {
    /// Whether nothing is known of what is in it.
    fn is_unknown(&self, side: usize, open: &BTreeSet<(u32, usize)>) -> bool {
        self.is_closed && side == 0 && open.contains(&(self.surface, side))
    }
}

fn is_stated(shapes: &Shapes, boundary: &Boundary, side: usize) -> bool {
    !shapes.surfaces[boundary.surface as usize].unstated[side]
}

/// Whether something else may be behind a boundary than what it holds.
fn may_be_outranked(immersion: &Immersion, boundary: &Boundary) -> bool {
    let Shapes { surfaces, bodies, .. } = immersion.shapes();
    let own = surfaces[boundary.surface as usize].priority;
    !boundary.is_closed || bodies.iter().any(|body| body.priority > own)
}

/// Whether closed bodies have other media than its own on a side of a boundary, in places.
fn strays(immersion: &Immersion, (boundary, side): (&Boundary, usize), checks: usize) -> bool {
    let own = sides_of(immersion.shapes(), boundary.surface)[side];
    let off = boundary.step * if side == 0 { -1.0 } else { 1.0 };
    let stride = boundary.points.len().div_ceil(checks);
    let checked = || boundary.points.iter().step_by(stride.max(1));
    let is_other =
        |(point, normal): &&(Vec3, Vec3)| immersion.behind_walls(*point + off * *normal) != own;
    is_many(checked().filter(is_other).count(), checked().count())
}

/// Whether so many of all that disagree are more than slip through.
fn is_many(count: usize, all: usize) -> bool {
    count >= 2 && count as f64 > SLIPS * all as f64
}

/// What looks say, but for those that end on sides of which nothing is known.
fn tally(shapes: &Shapes, open: &BTreeSet<(u32, usize)>, seen: &[Seen]) -> Tally {
    let mut tally = Tally::new();
    for seen in seen {
        let (medium, by) = match *seen {
            Seen::Nothing => continue,
            Seen::Outside => (shapes.scene_medium, None),
            Seen::Side(surface, side) if open.contains(&(surface, side)) => continue,
            Seen::Side(surface, side) => (sides_of(shapes, surface)[side], Some(surface)),
        };
        let entry = tally.entry(medium).or_insert((0, by));
        entry.0 += 1;
        entry.1 = entry.1.or(by);
    }
    tally
}

/// Notes what is doubtful about a side, and between which surfaces the medium is to be sought.
fn judge(
    immersion: &Immersion,
    boundaries: &[Boundary],
    (boundary, side, tally): (&Boundary, usize, &Tally),
    sought: &mut BTreeSet<u32>,
    doubts: &mut Vec<Doubt>,
) {
    let surface = boundary.surface;
    let own = sides_of(immersion.shapes(), surface)[side];
    let all: usize = tally.values().map(|(count, _)| count).sum();
    let others: Vec<_> = tally.iter().filter(|(medium, _)| **medium != own).collect();
    let dissent: usize = others.iter().map(|(_, (count, _))| count).sum();
    if !is_many(dissent, all) {
        return;
    }
    let mut partners: Vec<u32> = tally.values().filter_map(|(_, by)| *by).collect();
    let whole_of = |row: &u32| immersion.shapes().surfaces[*row as usize].whole;
    partners.retain(|partner| whole_of(partner) != boundary.whole);
    let other = |row: u32| boundaries.iter().find(|it| it.surface == row);
    let closed: Vec<&Boundary> =
        partners.iter().filter_map(|&row| other(row)).filter(|it| it.is_closed).collect();
    if boundary.is_closed && closed.len() == partners.len() && !closed.is_empty() {
        sought.extend(closed.iter().map(|it| it.whole).chain([boundary.whole]));
        let meetings: Vec<Meeting> =
            closed.iter().map(|other| meeting(immersion, boundary, other)).collect();
        if let Some(at) = meetings.iter().position(|it| *it == Meeting::Overlap) {
            let [a, b] = [boundary.whole, closed[at].whole];
            doubts.push(Doubt::Overlap([a.min(b), a.max(b)]));
            return;
        }
        if meetings.contains(&Meeting::Touch) {
            return;
        }
    }
    doubts.push(match others.iter().find_map(|(_, (_, by))| *by).or(partners.first().copied()) {
        Some(other) => Doubt::Contradiction { surface, side, other },
        None => Doubt::Open { surface, side },
    });
}

/// How two closed surfaces meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Meeting {
    /// One is inside of the other, or they are apart.
    Nowhere,
    /// From outside, in places.
    Touch,
    /// One is inside of the other in part.
    Overlap,
}

fn meeting(immersion: &Immersion, a: &Boundary, b: &Boundary) -> Meeting {
    let mut is_touching = false;
    for (boundary, other) in [(a, b), (b, a)] {
        let is_within = |side: f32, &(point, normal): &(Vec3, Vec3)| {
            immersion.is_within(other.whole, point + side * boundary.step * normal)
        };
        let before: Vec<_> = boundary.points.iter().filter(|point| is_within(1.0, point)).collect();
        let inside = before.iter().filter(|point| is_within(-1.0, point)).count();
        if 0 < inside && inside < boundary.points.len() {
            return Meeting::Overlap;
        }
        is_touching |= inside < before.len();
    }
    if is_touching { Meeting::Touch } else { Meeting::Nowhere }
}

/// Has the medium sought at the given surfaces.
fn seek(shapes: &mut Shapes, boundaries: &[Boundary], sought: &BTreeSet<u32>) {
    shapes.overlaps = true;
    let is_other = |it: &&Boundary| shapes.surfaces[it.surface as usize].solid == NONE;
    let others: Vec<_> =
        boundaries.iter().filter(is_other).map(|it| (it.bounds, it.step)).collect();
    fill(shapes, &others);
    for surface in &mut shapes.surfaces {
        if sought.contains(&surface.whole) {
            (surface.interior, surface.exterior) = (SOUGHT, SOUGHT);
        }
    }
}
