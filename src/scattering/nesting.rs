//! Nested dielectrics: what is refracted where closed bodies of glass or water overlap or touch.
//!
//! Of the bodies around a point the one of the highest priority counts, and of several the smallest
//! (in the manner of Schmidt and Budge 2002, "Simple nested dielectrics in ray traced images").
//! Which that is does not hang on what a path went through: it is looked for behind what is hit,
//! as far off it as rays may start off any of the two bodies. So paths of either side know the
//! same, whatever is inside or around, and faces in one place are one interface: what is hit first
//! tells what is behind it. What is before a surface is what was found where the path has come
//! from: what refracts it has one index of refraction between any two surfaces, and no light is
//! made or lost, even where a ray starts beyond a face that it should meet. Bodies that are apart
//! from all others are not looked for.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use glam::Vec3;

use super::immersion::{Crossed, DIRECTIONS, Immersion, STEPS, spread};
use super::patches::{Patches, wholes};
use super::surface::Surfaces;
use super::surface::model::LaneRows;
use crate::geometry::{Accelerator, offset_distance};
use crate::math::LANES;
use crate::scene::baked::{KEEP, NONE, Optics, Shapes, Slab, Solid};
use crate::scene::world::SurfaceModel;

/// How far off bodies others are looked for, in offsets of rays: with room for rounding.
const ROOM: f32 = 1.25;

/// Rays that are closer to along a slab are not known to leave it.
const LEAST_COSINE: f32 = 1e-3;

/// Looks from a body for surfaces around it that are not closed.
const LOOKS: usize = 64;

/// A closed body, which may be the only one far and wide.
struct Found {
    /// The first of its surfaces.
    whole: u32,
    patches: Patches,
    solid: Solid,
    /// How far off it one is for sure.
    step: f32,
}

/// Finds the solids that may reach into others.
pub fn nest(shapes: &mut Shapes, primitives: &[Vec<u32>]) {
    let mut found: Vec<Found> = Vec::new();
    for (whole, all) in wholes(shapes, primitives) {
        let surface = &shapes.surfaces[whole as usize];
        if !surface.is_body {
            continue;
        }
        let patches = Patches::new(shapes, &all);
        if patches.is_closed() {
            let (material, priority) = (surface.material, surface.priority);
            let solid = Solid {
                material,
                priority,
                size: patches.size(),
                bounds: patches.bounds(),
                ball: patches.ball(),
                slabs: Vec::new(),
                off: ROOM * patches.offset(),
                others: Vec::new(),
                filling: KEEP,
            };
            found.push(Found { whole, solid, step: patches.step(), patches });
        }
    }
    meet(&mut found);
    let mut new_row = BTreeMap::new();
    let mut solid_of = BTreeMap::new();
    for (row, Found { whole, solid, .. }) in (0_u32..).zip(&found) {
        if !solid.others.is_empty() {
            let kept = new_row.len() as u32;
            new_row.insert(row, kept);
            solid_of.insert(*whole, kept);
        }
    }
    for surface in &mut shapes.surfaces {
        if let Some(solid) = solid_of.get(&surface.whole) {
            (surface.solid, surface.material) = (*solid, surface.nested_material);
        }
    }
    let kept = found.into_iter().map(|it| it.solid).filter(|it| !it.others.is_empty());
    let renumbered = |mut solid: Solid| {
        solid.others.iter_mut().for_each(|other| *other = new_row[other]);
        solid
    };
    shapes.solids = kept.map(renumbered).collect();
}

/// Closed bodies that are inside of surfaces that are not closed, in part at least, each with one
/// of those: what is refracted there cannot be known.
pub fn engulfed(
    shapes: &Shapes,
    accelerator: &Accelerator,
    primitives: &[Vec<u32>],
) -> Vec<[u32; 2]> {
    let bodies = wholes(shapes, primitives)
        .into_iter()
        .filter(|(whole, _)| shapes.surfaces[*whole as usize].is_body);
    let bodies: Vec<(u32, Patches)> =
        bodies.map(|(whole, all)| (whole, Patches::new(shapes, &all))).collect();
    let (closed, open): (Vec<_>, Vec<_>) =
        bodies.into_iter().partition(|(_, patches)| patches.is_closed());
    if open.is_empty() {
        return Vec::new();
    }
    let is_open = |whole: u32| open.iter().any(|(row, _)| *row == whole);
    let immersion = Immersion::new(shapes, accelerator, false);
    let around = |(whole, patches): &(u32, Patches)| {
        let see = |((point, normal), aside): ((Vec3, Vec3), Vec3), side: f32| {
            let outwards = side * normal;
            let direction = (outwards + 0.99 * aside).normalize();
            immersion.first_body(point + patches.step() * outwards, direction)
        };
        let mut looks = patches.points(LOOKS).into_iter().zip(spread(LOOKS));
        looks.find_map(|look| {
            let around = see(look, 1.0).filter(|(_, is_behind)| *is_behind);
            let mut seen = around.into_iter().chain(see(look, -1.0)).map(|(other, _)| other);
            seen.find(|other| is_open(*other)).map(|other| [*whole, other])
        })
    };
    closed.iter().filter_map(around).collect()
}

/// Tells solids of the others that may reach into them, or up to them.
fn meet(found: &mut [Found]) {
    let pairs = pairs_of_boxes(found);
    for place in pairs.iter().flatten() {
        let Found { patches, solid, .. } = &mut found[*place];
        if solid.slabs.is_empty() {
            solid.slabs = patches.slabs();
        }
    }
    for [a, b] in pairs {
        if !are_apart(&found[a], &found[b]) {
            found[a].solid.others.push(b as u32);
            found[b].solid.others.push(a as u32);
        }
    }
}

/// The solids whose boxes reach into each other's, or up to them.
fn pairs_of_boxes(found: &[Found]) -> Vec<[usize; 2]> {
    let wide = |it: &Found| widened(it.solid.bounds, it.step);
    let boxes: Vec<[Vec3; 2]> = found.iter().map(wide).collect();
    let mut order: Vec<usize> = (0..found.len()).collect();
    order.sort_by(|&a, &b| boxes[a][0].x.total_cmp(&boxes[b][0].x));
    let mut pairs = Vec::new();
    for (place, &a) in order.iter().enumerate() {
        let high = boxes[a][1];
        let reached = order[place + 1..].iter().take_while(|&&b| boxes[b][0].x <= high.x);
        pairs.extend(reached.filter(|&&b| meet_boxes(boxes[a], boxes[b])).map(|&b| [a, b]));
    }
    pairs
}

/// Whether there is a gap between two solids, as seen along their faces or from one to the other.
fn are_apart(a: &Found, b: &Found) -> bool {
    let room = a.step + b.step;
    let gap = |along: Vec3| {
        let [[a_low, a_high], [b_low, b_high]] = [a, b].map(|it| it.patches.between(along));
        (b_low - a_high).max(a_low - b_high)
    };
    let between = b.solid.ball.center - a.solid.ball.center;
    let faces = a.solid.slabs.iter().chain(&b.solid.slabs).map(|slab| slab.normal);
    between.length() > a.solid.ball.radius + b.solid.ball.radius + room
        || between.try_normalize().into_iter().chain(faces).any(|along| gap(along) > room)
}

/// A box, `step` wider on all sides.
fn widened([low, high]: [Vec3; 2], step: f32) -> [Vec3; 2] {
    [low - step, high + step]
}

/// Whether two boxes have a point in common.
fn meet_boxes([a_low, a_high]: [Vec3; 2], [b_low, b_high]: [Vec3; 2]) -> bool {
    a_low.cmple(b_high).all() && b_low.cmple(a_high).all()
}

/// Notes what fills solids, of which `bodies` tell, and what is around them, where no other
/// boundary of media is: the boxes of all those are `others`, with how far off one is for sure.
pub fn fill(shapes: &mut Shapes, others: &[([Vec3; 2], f32)]) {
    if others.is_empty() {
        shapes.around_solids = shapes.scene_medium;
    }
    for body in &shapes.bodies {
        let row = shapes.surfaces[body.surface as usize].solid;
        let Some(solid) = shapes.solids.get_mut(row as usize) else { continue };
        let is_near =
            |&(bounds, step): &([Vec3; 2], f32)| meet_boxes(widened(bounds, step), solid.bounds);
        if !others.iter().any(is_near) {
            solid.filling = body.filling;
        }
    }
}

impl Immersion<'_> {
    /// The body that a ray sees first, unless something hides it, and whether from behind.
    fn first_body(&self, origin: Vec3, direction: Vec3) -> Option<(u32, bool)> {
        let surface = |crossed: &Crossed| &self.shapes().surfaces[crossed.surface as usize];
        let hides = |crossed: &Crossed| surface(crossed).is_opaque || surface(crossed).is_body;
        let first = self.crossed(origin, direction).find(hides)?;
        surface(&first).is_body.then_some((surface(&first).whole, first.cosine > 0.0))
    }

    /// The solid that counts next to a surface of `solid`, at a point on it, where the unit vector
    /// `outwards` points: to the front, or to the `inside`; [`NONE`] where there is none.
    pub fn solid_beside(&self, solid: u32, point: Vec3, outwards: Vec3, inside: bool) -> u32 {
        let solids = &self.shapes().solids;
        let of = |row: u32| &solids[row as usize];
        let is_there = |&other: &u32| {
            let off = of(solid).off.max(of(other).off) * outwards;
            self.is_in(other, point, off)
        };
        let around = of(solid).others.iter().copied().filter(is_there);
        let own = inside.then_some(solid);
        around.chain(own).max_by(|a, b| self.rank(*a, *b)).unwrap_or(NONE)
    }

    /// Which of two solids counts where both are.
    fn rank(&self, a: u32, b: u32) -> Ordering {
        let [first, second] = [a, b].map(|row| &self.shapes().solids[row as usize]);
        let by_priority = first.priority.cmp(&second.priority);
        by_priority.then(second.size.total_cmp(&first.size)).then(b.cmp(&a))
    }

    /// Whether what is `off` a point of a surface is in a solid, as most of three looks away from
    /// that surface have it.
    fn is_in(&self, solid: u32, point: Vec3, off: Vec3) -> bool {
        let point = point + off;
        if is_outside(&self.shapes().solids[solid as usize], point) {
            return false;
        }
        let gets_out = |direction: Vec3| {
            let away = direction * 1.0_f32.copysign(direction.dot(off));
            self.gets_out(solid, point, away.normalize())
        };
        let [a, b, c, ..] = DIRECTIONS;
        let (first, second) = (gets_out(a), gets_out(b));
        if first == second { first } else { gets_out(c) }
    }

    /// Whether a ray leaves a solid more often than it enters it.
    fn gets_out(&self, solid: u32, origin: Vec3, direction: Vec3) -> bool {
        let shapes = self.shapes();
        let end = end_of(&shapes.solids[solid as usize], origin, direction);
        let within = self.crossed(origin, direction).take_while(|crossed| crossed.distance <= end);
        let own = within.filter(|it| shapes.surfaces[it.surface as usize].solid == solid);
        own.map(|crossed| crossed.outwards()).sum::<i32>() > 0
    }
}

/// Whether a point is outside of what is about a solid, for sure.
fn is_outside(solid: &Solid, point: Vec3) -> bool {
    let &Solid { bounds: [low, high], ball, ref slabs, .. } = solid;
    let slack = slack(solid);
    let is_between = |slab: &Slab| {
        let [low, high] = slab.between;
        let at = slab.normal.dot(point);
        low - slack <= at && at <= high + slack
    };
    !(low.cmple(point).all() && point.cmple(high).all())
        || point.distance_squared(ball.center) > (ball.radius + slack).powi(2)
        || !slabs.iter().all(is_between)
}

/// The distance on a ray that starts in what is about a solid from which on it is outside of that,
/// with room for rounding.
fn end_of(solid: &Solid, origin: Vec3, direction: Vec3) -> f32 {
    let ([low, high], slack) = (solid.bounds, slack(solid));
    let far = Vec3::select(direction.cmpgt(Vec3::ZERO), high, low);
    let of_box = ((far - origin) / direction + slack / direction.abs()).min_element();
    let of_slab = |slab: &Slab| {
        let [along, at] = [direction, origin].map(|it| slab.normal.dot(it));
        let gap = if along > 0.0 { slab.between[1] - at } else { at - slab.between[0] };
        // Nearly along it a ray may be in it for ever, or not at all.
        if along.abs() > LEAST_COSINE { (gap + slack) / along.abs() } else { f32::INFINITY }
    };
    solid.slabs.iter().map(of_slab).fold(of_box, f32::min)
}

/// What rounding may make of places on a solid, and more.
fn slack(Solid { bounds: [low, high], .. }: &Solid) -> f32 {
    STEPS * offset_distance(low.abs().max(high.abs()).max_element())
}

/// The interfaces between all that solids are made of, and what is around them.
pub struct Interfaces {
    /// Which of the indices of refraction every solid has; the first is that around all.
    index_of: Vec<usize>,
    count: usize,
    /// Row in the table of dielectrics of the first; they follow by what is before, then by what
    /// is behind.
    first_row: usize,
}

impl Interfaces {
    /// Adds them to the table of dielectrics; nothing where there are no solids.
    pub fn new<const N: usize>(
        shapes: &Shapes,
        optics: &Optics<N>,
        surfaces: &mut Surfaces<N>,
    ) -> Option<Self> {
        if shapes.solids.is_empty() {
            return None;
        }
        let mut indices = vec![[1.0_f32; N]];
        let index = |solid: &Solid| {
            let ior = match *optics.materials[solid.material as usize].model.without_grain() {
                SurfaceModel::Dielectric { ior, .. } => [ior; N],
                SurfaceModel::DispersiveDielectric { ior, .. }
                | SurfaceModel::RoughDielectric { ior, .. } => ior,
                SurfaceModel::Absorber
                | SurfaceModel::Conductor { .. }
                | SurfaceModel::MetallicRoughness { .. }
                | SurfaceModel::Layered { .. }
                | SurfaceModel::Plastic { .. }
                | SurfaceModel::Measured { .. }
                | SurfaceModel::Blend { .. }
                | SurfaceModel::Brushed { .. }
                | SurfaceModel::Filmed { .. }
                | SurfaceModel::FilmedConductor { .. }
                | SurfaceModel::FilmedDielectric { .. }
                | SurfaceModel::RoughConductor { .. }
                | SurfaceModel::Diffuse { .. }
                | SurfaceModel::Null
                | SurfaceModel::Polarizer { .. }
                | SurfaceModel::Retarder { .. }
                | SurfaceModel::Sheet { .. }
                | SurfaceModel::ThinDielectric { .. } => [1.0; N],
            };
            indices.iter().position(|known| *known == ior).unwrap_or_else(|| {
                indices.push(ior);
                indices.len() - 1
            })
        };
        let index_of = shapes.solids.iter().map(index).collect();
        let mut rows = Vec::new();
        for &before in &indices {
            rows.extend(indices.iter().map(|&behind| surfaces.add_interface(behind, before)));
        }
        Some(Self { index_of, count: indices.len(), first_row: rows[0] as usize })
    }

    /// The number of the index of refraction of a solid, or of what is around all.
    pub fn index_of(&self, solid: u32) -> u32 {
        self.index_of.get(solid as usize).map_or(0, |index| *index as u32)
    }

    /// The row in the table of dielectrics of the interface between two indices of refraction, by
    /// their numbers, before and behind.
    pub fn row(&self, [before, behind]: [u32; 2]) -> usize {
        self.first_row + before as usize * self.count + behind as usize
    }
}

/// What a path does not know yet that has met no solid: the number of the index of refraction
/// that it is in.
pub const UNKNOWN: u32 = u32::MAX;

/// Eight interfaces that paths have come to.
pub struct InterfaceLanes {
    /// Their rows in the table of dielectrics.
    pub rows: LaneRows,
    /// The numbers of the indices of refraction that paths are in which stay before them, and which
    /// go through.
    pub inside: [[u32; 2]; LANES],
    /// The solids behind them, [`NONE`] for what is around all, where they are known.
    pub behind: [Option<u32>; LANES],
}
