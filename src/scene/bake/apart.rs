//! Sets surfaces that light goes through apart from what they lie on.
//!
//! A polarizer on a display, fog that fills a room to its walls, two such bodies side by side, two
//! sheets in one place, glass on a table: which of them a ray meets first would be left to
//! rounding, and differ between rays from the sensor and from the emitters. So they are moved by a
//! few times what rays keep off surfaces ([`CLEARANCE`]), once and for all rays:
//!
//! - sheets to the front of what they lie on, or apart from each other, in the order of the file;
//! - boundaries of media into what they bound: it shrinks, and of two in one place the one that
//!   bounds more stays outside;
//! - bodies of glass off opaque surfaces, twice as far, so that sheets and boundaries stay between:
//!   they shrink, so that they stand there with air between, but coat what faces the same way. Two
//!   of them are left where they are: see [`crate::scattering::nesting`];
//! - the two sides of a body of glass that is thinner than that, away from each other: rays that
//!   start at one would miss the other. Where it lies on something, both are moved off that.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::time::Duration;

use glam::{DVec3, Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};
use rayon::prelude::*;

use super::bodies::{alike, bodies, place};
use super::primitives::Primitives;
use crate::scene::baked::{RELATIVE_OFFSET, Sphere, Triangle};

/// How far surfaces are set apart, relative to the largest coordinate of either: four times the
/// offset of rays, two of which may come from either side.
pub const CLEARANCE: f64 = 4.0 * RELATIVE_OFFSET;

/// Thickness of bodies whose sides are moved together, relative to how far apart they must be: what
/// lies on something is moved off it by less.
const THIN: f64 = 3.0;

/// Least cosine between two planes that count as one.
const PARALLEL: f64 = 0.999;

/// How a surface gives way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Yields {
    /// Not at all: it is opaque.
    Never {
        /// Whether its back is as good as its front.
        two_sided: bool,
    },
    /// To opaque surfaces.
    AsBody,
    /// To the front of what it lies on.
    AsSheet,
    /// Into what it bounds.
    AsBoundary,
}

impl Yields {
    fn is_opaque(self) -> bool {
        matches!(self, Self::Never { .. })
    }
}

/// What a primitive that gives way lies on.
struct Contact {
    /// The one that gives way.
    primitive: usize,
    other: usize,
    /// How far they must be apart.
    clearance: f64,
}

/// What is close together.
#[derive(Default)]
struct Found {
    /// Primitives of different surfaces.
    contacts: Vec<Contact>,
    /// Triangles of alike surfaces whose fronts face away from each other.
    sides: Vec<Contact>,
}

/// Moves primitives of surfaces that give way, by `yields` of each surface.
pub fn set_apart(tables: &mut Primitives, yields: &[Yields]) {
    let Found { contacts, sides } = contacts(tables, yields);
    let mut moved: BTreeMap<usize, DVec3> = by_primitive(contacts)
        .into_iter()
        .filter_map(|(primitive, contacts)| {
            let step = step_of(tables, yields, primitive, &contacts)?;
            Some((primitive, step))
        })
        .collect();
    let sides = sides_of_bodies(tables, yields, sides);
    let is_flat = |it: &&Contact| before(tables, it.primitive, it.other) == Some(0.0);
    let alone: BTreeSet<usize> = sides.iter().filter(is_flat).map(|it| it.primitive).collect();
    let apart: Vec<(usize, DVec3)> = by_primitive(sides)
        .into_iter()
        .map(|(primitive, sides)| (primitive, step_of_side(tables, primitive, &sides, &moved)))
        .collect();
    moved.extend(apart.into_iter().filter(|(_, step)| *step != DVec3::ZERO));
    let moved: Vec<(usize, DVec3)> = moved.into_iter().collect();
    move_spheres(tables, yields, &moved);
    move_corners(tables, yields, &moved, &alone);
}

/// All pairs of a primitive that gives way and another surface's in the same place, and of the
/// sides of thin bodies.
fn contacts(tables: &Primitives, yields: &[Yields]) -> Found {
    let count = tables.triangles.len() + tables.spheres.len();
    let gives_way = |primitive: &usize| !yields_at(tables, yields, *primitive).is_opaque();
    let yielding: Vec<usize> = (0..count).filter(gives_way).collect();
    if yielding.is_empty() {
        return Found::default();
    }
    let tree = tree(tables, &yielding);
    let of_other = |other: usize| {
        let mut found = Found::default();
        tree.aabb_traverse(bounds(tables.shapes(), other), |tree, node| {
            let node = &tree.nodes[node as usize];
            let first = node.first_index as usize;
            for &index in &tree.primitive_indices[first..first + node.prim_count as usize] {
                let primitive = yielding[index as usize];
                let [one, two] = [primitive, other].map(|it| yields_at(tables, yields, it));
                if one == Yields::AsBody && !two.is_opaque() {
                    found.sides.extend(side(tables, primitive, other));
                    continue;
                }
                if let Some(clearance) = touch(tables, primitive, other) {
                    found.contacts.push(Contact { primitive, other, clearance });
                }
            }
            true
        });
        found
    };
    let of_others: Vec<Found> = (0..count).into_par_iter().map(of_other).collect();
    let mut all = Found::default();
    for Found { contacts, sides } in of_others {
        all.contacts.extend(contacts);
        all.sides.extend(sides);
    }
    for found in [&mut all.contacts, &mut all.sides] {
        found.sort_by_key(|contact| (contact.primitive, contact.other));
    }
    all
}

/// A tree over the primitives that give way.
fn tree(tables: &Primitives, yielding: &[usize]) -> Bvh2 {
    let bounds: Vec<Aabb> =
        yielding.iter().map(|primitive| bounds(tables.shapes(), *primitive)).collect();
    build_bvh2(&bounds, BvhBuildParams::fast_build(), &mut Duration::default())
}

/// The box of a primitive of these triangles and spheres, with room about it.
pub fn bounds(of: (&[Triangle], &[Sphere]), primitive: usize) -> Aabb {
    let [low, high] = match shape_of(of, primitive) {
        Shape::Triangle(Triangle { corners }) => {
            let [a, b, c] = corners.map(Vec3A::from);
            [a.min(b).min(c), a.max(b).max(c)]
        }
        Shape::Sphere(Sphere { center, radius }) => {
            [Vec3A::from(center) - radius, Vec3A::from(center) + radius]
        }
    };
    let room = 2.0 * CLEARANCE as f32 * low.abs().max(high.abs()).max_element();
    Aabb::new(low - room, high + room)
}

enum Shape {
    Triangle(Triangle),
    Sphere(Sphere),
}

fn shape(tables: &Primitives, primitive: usize) -> Shape {
    shape_of(tables.shapes(), primitive)
}

fn shape_of((triangles, spheres): (&[Triangle], &[Sphere]), primitive: usize) -> Shape {
    match primitive.checked_sub(triangles.len()) {
        None => Shape::Triangle(triangles[primitive]),
        Some(row) => Shape::Sphere(spheres[row]),
    }
}

fn yields_at(tables: &Primitives, yields: &[Yields], primitive: usize) -> Yields {
    yields[tables.surface_of_primitive[primitive] as usize]
}

/// How far two primitives of different surfaces must be apart, if they are in one place.
fn touch(tables: &Primitives, one: usize, other: usize) -> Option<f64> {
    if tables.surface_of_primitive[one] == tables.surface_of_primitive[other] {
        return None;
    }
    match (shape(tables, one), shape(tables, other)) {
        (Shape::Triangle(one), Shape::Triangle(other)) => {
            let corners = [one, other].map(|it| it.corners.map(|corner| corner.as_dvec3()));
            triangles_touch(corners)
        }
        (Shape::Sphere(one), Shape::Sphere(other)) => spheres_touch(one, other),
        (Shape::Triangle(_), Shape::Sphere(_)) | (Shape::Sphere(_), Shape::Triangle(_)) => None,
    }
}

fn triangles_touch(corners: [[DVec3; 3]; 2]) -> Option<f64> {
    let [one, other] = corners.map(normal);
    if one.normalize().dot(other.normalize()).abs() < PARALLEL {
        return None;
    }
    let clearance = clearance_of(corners);
    are_within(corners, clearance).then_some(clearance)
}

/// How far two triangles must be apart.
fn clearance_of(corners: [[DVec3; 3]; 2]) -> f64 {
    let reach = |most: f64, corner: &DVec3| most.max(corner.abs().max_element());
    CLEARANCE * corners.iter().flatten().fold(0.0, reach)
}

/// Whether the smaller of two triangles that are parallel lies over the larger, nearer than that.
fn are_within(corners: [[DVec3; 3]; 2], distance: f64) -> bool {
    let [one, other] = corners.map(normal);
    let [small, large] = if one.length() < other.length() { [0, 1] } else { [1, 0] };
    let plane = [one, other][large].normalize();
    let is_near = |corner: &DVec3| (*corner - corners[large][0]).dot(plane).abs() < distance;
    corners[small].iter().all(is_near) && overlap(corners, plane, clearance_of(corners))
}

/// Two triangles of alike surfaces whose fronts face away from each other, if what is between is so
/// thin that one might be moved through the other.
fn side(tables: &Primitives, primitive: usize, other: usize) -> Option<Contact> {
    let of =
        |primitive: usize| alike(&tables.surfaces[tables.surface_of_primitive[primitive] as usize]);
    if primitive == other || of(primitive) != of(other) {
        return None;
    }
    let (Shape::Triangle(a), Shape::Triangle(b)) = (shape(tables, primitive), shape(tables, other))
    else {
        return None;
    };
    let corners = [a, b].map(|it| it.corners.map(|corner| corner.as_dvec3()));
    let clearance = clearance_of(corners);
    let is_thin = before(tables, primitive, other)? >= 0.0 && are_within(corners, THIN * clearance);
    is_thin.then_some(Contact { primitive, other, clearance })
}

/// How far the first of two triangles is before the other, along its front; none if their fronts
/// do not face opposite ways.
fn before(tables: &Primitives, one: usize, other: usize) -> Option<f64> {
    let [front, back] = [one, other].map(|primitive| front(tables, primitive));
    let [small, large] =
        if area(tables, one) < area(tables, other) { [one, other] } else { [other, one] };
    let (Shape::Triangle(small), Shape::Triangle(large)) =
        (shape(tables, small), shape(tables, large))
    else {
        return None;
    };
    let [a, b, c] = small.corners.map(|corner| corner.as_dvec3());
    let height = ((a + b + c) / 3.0 - large.corners[0].as_dvec3()).dot(front);
    let height = if area(tables, one) < area(tables, other) { height } else { -height };
    (front.dot(back) < -PARALLEL).then_some(height)
}

/// Those that bound one body from two sides, and not two bodies in contact: of one with a
/// thickness, or sheets that have none.
fn sides_of_bodies(tables: &Primitives, yields: &[Yields], sides: Vec<Contact>) -> Vec<Contact> {
    if sides.is_empty() {
        return sides;
    }
    let bodies = bodies(tables, yields);
    // Of every body the first front, while all others are parallel to it.
    let mut fronts: HashMap<u32, Option<DVec3>> = HashMap::new();
    for (row, body) in bodies.iter().enumerate() {
        let own = front(tables, row);
        let of_body = fronts.entry(*body).or_insert(Some(own));
        *of_body = of_body.filter(|first| first.dot(own).abs() > PARALLEL);
    }
    let is_flat = |row: usize| fronts.get(&bodies[row]).is_some_and(Option::is_some);
    let bounds_one = |it: &Contact| {
        let is_thick = before(tables, it.primitive, it.other).is_some_and(|before| before > 0.0);
        bodies[it.primitive] == bodies[it.other] && is_thick
            || is_flat(it.primitive) && is_flat(it.other)
    };
    sides.into_iter().filter(bounds_one).collect()
}

/// Whether two triangles of one plane overlap by more than their edges.
fn overlap(corners: [[DVec3; 3]; 2], plane: DVec3, margin: f64) -> bool {
    let edges = corners.iter().flat_map(|[a, b, c]| [*b - *a, *c - *b, *a - *c]);
    edges.map(|edge| plane.cross(edge).normalize()).all(|axis| {
        let range = |corners: &[DVec3; 3]| {
            let along = corners.map(|corner| corner.dot(axis));
            along.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &at| {
                [low.min(at), high.max(at)]
            })
        };
        let [[a_low, a_high], [b_low, b_high]] = [range(&corners[0]), range(&corners[1])];
        a_high.min(b_high) - a_low.max(b_low) > margin
    })
}

fn spheres_touch(one: Sphere, other: Sphere) -> Option<f64> {
    let [a, b] = [one, other].map(|it| it.center.as_dvec3());
    let reach = a.abs().max(b.abs()).max_element() + f64::from(one.radius.max(other.radius));
    let clearance = CLEARANCE * reach;
    let gap = a.distance(b) + (f64::from(one.radius) - f64::from(other.radius)).abs();
    (gap < clearance).then_some(clearance)
}

/// To the front, of the length of twice the area.
fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// The contacts of every primitive that has any, in the order of the primitives.
fn by_primitive(contacts: Vec<Contact>) -> Vec<(usize, Vec<Contact>)> {
    let mut all: Vec<(usize, Vec<Contact>)> = Vec::new();
    for contact in contacts {
        match all.last_mut() {
            Some((primitive, of_primitive)) if *primitive == contact.primitive => {
                of_primitive.push(contact);
            }
            _ => all.push((contact.primitive, vec![contact])),
        }
    }
    all
}

/// Where a primitive is moved to, if it is: of a sphere only the length counts.
fn step_of(
    tables: &Primitives,
    yields: &[Yields],
    primitive: usize,
    contacts: &[Contact],
) -> Option<DVec3> {
    let clearance = contacts.iter().fold(0.0_f64, |most, contact| most.max(contact.clearance));
    let own = front(tables, primitive);
    let surface = |primitive: usize| tables.surface_of_primitive[primitive];
    let sort = |contact: &Contact| yields_at(tables, yields, contact.other);
    let mut before: Vec<u32> = contacts
        .iter()
        .filter(|contact| sort(contact) == yields_at(tables, yields, primitive))
        .filter(|contact| is_before(tables, yields, contact.other, primitive))
        .map(|contact| surface(contact.other))
        .collect();
    before.sort_unstable();
    before.dedup();
    let (direction, steps) = match yields_at(tables, yields, primitive) {
        Yields::Never { .. } => return None,
        Yields::AsBody => {
            let coats = |contact: &Contact| {
                let is_alike = own.dot(front(tables, contact.other)) > 0.0;
                is_alike && sort(contact) == Yields::Never { two_sided: false }
            };
            (if contacts.iter().any(coats) { own } else { -own }, 2)
        }
        Yields::AsSheet => {
            let opaque = contacts.iter().find(|contact| sort(contact).is_opaque());
            let body = || contacts.iter().find(|contact| sort(contact) == Yields::AsBody);
            match opaque.or_else(body) {
                Some(ground) => (front(tables, ground.other), before.len() + 1),
                None => (canonical(own), before.len()),
            }
        }
        Yields::AsBoundary => (-own, before.len() + 1),
    };
    (steps > 0).then(|| direction * clearance * steps as f64)
}

/// Where a side of a thin body is moved to: off what it or the other side lies on, and away from
/// that if need be.
fn step_of_side(
    tables: &Primitives,
    primitive: usize,
    sides: &[Contact],
    moved: &BTreeMap<usize, DVec3>,
) -> DVec3 {
    let own = front(tables, primitive);
    let of = |primitive: usize| moved.get(&primitive).copied().unwrap_or_default();
    let mut step = of(primitive);
    let mut apart = 0.0_f64;
    for side in sides {
        step = if step == DVec3::ZERO { of(side.other) } else { step };
        let thickness = before(tables, primitive, side.other).unwrap_or(side.clearance);
        apart = apart.max(0.5 * (side.clearance - thickness));
    }
    step + own * apart
}

/// Whether of two primitives in one place that give way alike one is the first, seen from outside
/// or in the order of the file.
fn is_before(tables: &Primitives, yields: &[Yields], one: usize, other: usize) -> bool {
    let order = |primitive: usize| tables.surface_of_primitive[primitive];
    match yields_at(tables, yields, one) {
        Yields::Never { .. } | Yields::AsBody => false,
        Yields::AsSheet => order(one) < order(other),
        Yields::AsBoundary => {
            let sizes = [one, other].map(|primitive| area(tables, primitive));
            let faces_alike = front(tables, one).dot(front(tables, other)) > 0.0;
            let is_larger =
                sizes[0] > sizes[1] || sizes[0] == sizes[1] && order(one) < order(other);
            faces_alike && is_larger
        }
    }
}

/// The unit normal to the front; of spheres any, the same for all.
fn front(tables: &Primitives, primitive: usize) -> DVec3 {
    match shape(tables, primitive) {
        Shape::Triangle(Triangle { corners }) => {
            normal(corners.map(|corner| corner.as_dvec3())).normalize()
        }
        Shape::Sphere(_) => DVec3::X,
    }
}

fn area(tables: &Primitives, primitive: usize) -> f64 {
    match shape(tables, primitive) {
        Shape::Triangle(Triangle { corners }) => {
            normal(corners.map(|corner| corner.as_dvec3())).length()
        }
        Shape::Sphere(Sphere { radius, .. }) => f64::from(radius),
    }
}

/// The direction or its opposite: the one whose largest component is positive.
fn canonical(direction: DVec3) -> DVec3 {
    let largest = direction.abs().max_position();
    if direction[largest] < 0.0 { -direction } else { direction }
}

/// Boundaries shrink; sheets grow, to the front of what they lie on, and bodies, which coat it.
fn move_spheres(tables: &mut Primitives, yields: &[Yields], moved: &[(usize, DVec3)]) {
    for &(primitive, step) in moved {
        let Some(row) = primitive.checked_sub(tables.triangles.len()) else { continue };
        let grows = yields_at(tables, yields, primitive) != Yields::AsBoundary;
        let radius = f64::from(tables.spheres[row].radius);
        let radius = if grows { radius + step.length() } else { radius - step.length() };
        tables.spheres[row].radius = radius.max(f64::from(f32::MIN_POSITIVE)) as f32;
    }
}

/// Moves corners, together with those of the same body in the same place, so that it stays closed:
/// as far along every step as that is long.
/// Those that are to be moved `alone` share their corners with another side.
fn move_corners(
    tables: &mut Primitives,
    yields: &[Yields],
    moved: &[(usize, DVec3)],
    alone: &BTreeSet<usize>,
) {
    let of_triangles = moved.iter().filter(|(it, _)| *it < tables.triangles.len());
    let mut steps: HashMap<(u32, [u32; 3]), DVec3> = HashMap::new();
    let bodies = match of_triangles.clone().next() {
        Some(_) => bodies(tables, yields),
        None => return,
    };
    for &(primitive, step) in of_triangles.clone().filter(|(it, _)| !alone.contains(it)) {
        for corner in tables.triangles[primitive].corners {
            let sum = steps.entry((bodies[primitive], place(corner))).or_default();
            let (length, direction) = (step.length(), step.normalize());
            *sum += direction * (length - sum.dot(direction)).max(0.0);
        }
    }
    let of_alone: Vec<(usize, DVec3)> =
        of_triangles.filter(|(it, _)| alone.contains(it)).copied().collect();
    let move_by = |corner: &mut Vec3, step: DVec3| *corner = (corner.as_dvec3() + step).as_vec3();
    for (primitive, (triangle, body)) in tables.triangles.iter_mut().zip(bodies).enumerate() {
        if alone.contains(&primitive) {
            continue;
        }
        for corner in &mut triangle.corners {
            if let Some(step) = steps.get(&(body, place(*corner))) {
                move_by(corner, *step);
            }
        }
    }
    for (primitive, step) in of_alone {
        tables.triangles[primitive].corners.iter_mut().for_each(|corner| move_by(corner, step));
    }
}
