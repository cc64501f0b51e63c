//! A tree over the emitters at a finite distance, by which they are chosen for what they bring to a
//! point: as Conty Estevez and Kulla 2018 ("Importance sampling of many lights with adaptive tree
//! splitting") and pbrt-4 (section 12.6.3), but eight wide, and with estimates in place of their
//! bounds.
//!
//! A walk goes down from the root and takes a child with a probability in proportion to what that
//! brings to the point, an estimate from its box, the resultant of its normals and its intensity.
//! Where bounds are far above what there is (the cosines of a wide box are 1, and no closer than
//! its radius it brings the same everywhere), walks end at the wrong emitters; the estimate takes
//! the means of the cosines over the box, and the geometric mean of the least and the greatest
//! distance (as Lin and Yuksel 2020, "Real-time stochastic lightcuts", who average their weights).
//! Over a floor below 1,024 point lights one meter apart and 0.3 m high, the standard deviation of
//! a sample is 0.32 of its mean by these estimates and 1.6 by bounds.
//!
//! An estimate of zero is no proof that nothing arrives, only nearly so: whoever chooses by them
//! mixes in something that reaches all.

use std::ops::Add;

use glam::Vec3;

use crate::math::{F32s, LANES, Real, U32s, Vector, lanes};

/// How an emitter, or several, look from elsewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outline {
    /// Least corner of its box.
    pub lower: Vec3,
    /// Greatest corner.
    pub upper: Vec3,
    /// Along it, the intensity that falls off with the cosine to it, in W/sr; for an emitter that
    /// is infinitely far away, towards it and the irradiance of a plane that faces it, in W/m^2.
    pub axis: Vec3,
    /// The cosine to the axis counts on both sides.
    pub two_sided: bool,
    /// Intensity that is the same in all directions, or irradiance of all planes.
    pub even: f32,
    /// Largest area of an emitter as its intensity sees it, in m^2, or zero.
    pub area: f32,
    /// Cosine to the axis below which there is nothing; without meaning where it is -1.
    pub edge: f32,
}

impl Outline {
    /// Something at a point that sends nothing.
    pub fn at(point: Vec3) -> Self {
        Self {
            lower: point,
            upper: point,
            axis: Vec3::ZERO,
            two_sided: false,
            even: 0.0,
            area: 0.0,
            edge: -1.0,
        }
    }

    /// The same so many times as bright.
    pub fn scaled(self, radiance: f32) -> Self {
        Self { axis: self.axis * radiance, even: self.even * radiance, ..self }
    }

    /// Both. What the axes lose as they add up has no direction any more: the mean of the cosine
    /// over all of them stands for it.
    fn with(self, other: Self) -> Self {
        let two_sided = self.two_sided && other.two_sided;
        let (mut a, mut b) = (self, other);
        for one in [&mut a, &mut b] {
            if one.two_sided && !two_sided {
                (one.even, one.axis) = (one.even + 0.5 * one.axis.length(), Vec3::ZERO);
            }
        }
        if two_sided && a.axis.dot(b.axis) < 0.0 {
            b.axis = -b.axis;
        }
        let axis = a.axis + b.axis;
        let lost = (a.axis.length() + b.axis.length() - axis.length()).max(0.0);
        Self {
            lower: a.lower.min(b.lower),
            upper: a.upper.max(b.upper),
            axis,
            two_sided,
            even: a.even + b.even + lost * if two_sided { 0.5 } else { 0.25 },
            area: a.area.max(b.area),
            edge: -1.0,
        }
    }

    fn center(&self) -> Vec3 {
        0.5 * self.lower + 0.5 * self.upper
    }
}

/// A point that light is wanted at.
#[derive(Clone, Copy, Debug)]
pub struct Vantage {
    /// Where.
    pub position: Vec3,
    /// On a surface, the geometric normal towards the side from which its subpath comes, as light
    /// from the other is of no use; zero in a medium.
    pub normal: Vec3,
}

/// The tree.
#[derive(Clone, Debug)]
pub struct LightTree {
    /// The first is the root.
    nodes: Vec<Node>,
    /// For every emitter of the scene, the children from the root on to it, three bits each, the
    /// first in the lowest; without meaning for those that are not in the tree.
    way_to: Vec<u32>,
}

/// Eight children or fewer, a lane each.
#[derive(Clone, Debug)]
struct Node {
    center: Vector<F32s>,
    half: Vector<F32s>,
    axis: Vector<F32s>,
    /// Mask of the children whose axis counts on both sides.
    two_sided: F32s,
    even: F32s,
    /// Squared distance within which an area is as bright as it gets.
    near2: F32s,
    /// Least cosine times the length of the axis.
    edge: F32s,
    /// What the axis sees of the box: half its length along it, times that of the axis.
    spread: F32s,
    /// One over four times that.
    inverse_spread: F32s,
    children: [Child; LANES],
    count: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Child {
    Node(u32),
    Emitter(u32),
}

/// A vantage in all lanes.
#[derive(Clone, Copy)]
struct VantageLanes {
    position: Vector<F32s>,
    normal: Vector<F32s>,
    /// Mask: in a medium, where no cosine counts.
    in_medium: F32s,
}

impl From<&Vantage> for VantageLanes {
    #[inline(always)]
    fn from(&Vantage { position, normal }: &Vantage) -> Self {
        Self {
            position: Vector::splat(position),
            normal: Vector::splat(normal),
            in_medium: Vector::splat(normal).length_squared().simd_eq(F32s::splat(0.0)),
        }
    }
}

/// What the children of the root bring to a vantage.
#[derive(Clone, Copy, Debug)]
pub struct Brought {
    children: F32s,
    /// All together: irradiance in W/m^2, or what a sphere about the point receives in a medium.
    pub sum: f32,
}

impl LightTree {
    /// A tree over emitters, by their rows among the `count` of the scene; at least one.
    pub fn new(emitters: Vec<(u32, Outline)>, count: usize) -> Self {
        let mut tree = Self { nodes: Vec::new(), way_to: vec![0; count] };
        let mut emitters = emitters;
        tree.add(&mut emitters, (0, 0));
        tree
    }

    /// Adds a node over emitters, to which `way` leads in as many steps as `depth`; its place.
    fn add(&mut self, emitters: &mut [(u32, Outline)], (way, depth): (u32, u32)) -> u32 {
        let place = self.nodes.len();
        self.nodes.push(Node::empty());
        let mut outlines = [Outline::at(Vec3::ZERO); LANES];
        let mut children = [Child::Node(0); LANES];
        // As many as full subtrees hold, so that the lowest nodes, which are most, are full too.
        let mut most = 1;
        while most * LANES < emitters.len() {
            most *= LANES;
        }
        let mut parts = vec![emitters];
        while parts.len() < LANES && parts.iter().any(|part| part.len() > most) {
            parts = parts.into_iter().flat_map(halves).collect();
        }
        let count = parts.len();
        for (index, part) in parts.into_iter().enumerate() {
            outlines[index] =
                part.iter().map(|it| it.1).reduce(Outline::with).unwrap_or(outlines[index]);
            let way = way | (index as u32) << (3 * depth);
            children[index] = if let [(emitter, _)] = part {
                self.way_to[*emitter as usize] = way;
                Child::Emitter(*emitter)
            } else {
                Child::Node(self.add(part, (way, depth + 1)))
            };
        }
        self.nodes[place] = Node::new(&outlines, children, count);
        place as u32
    }

    /// What the emitters bring to a vantage.
    #[inline(always)]
    pub fn brought_to(&self, from: &Vantage) -> Brought {
        let children = self.nodes[0].brought_to(&from.into());
        Brought { children, sum: sums(children.to_array())[LANES - 1] }
    }

    /// What they bring to eight vantages.
    #[inline(always)]
    pub fn brought_to_all(&self, from: &[Vantage; LANES]) -> [Brought; LANES] {
        let mut all = [Brought { children: F32s::splat(0.0), sum: 0.0 }; LANES];
        for (brought, from) in all.iter_mut().zip(from) {
            *brought = self.brought_to(from);
        }
        all
    }

    /// The emitters that random numbers in [0, 1) choose from eight vantages, and the probabilities
    /// of that; without meaning where none is `wanted`.
    ///
    /// The walks go down side by side: one looks at eight children at a time, and all take their
    /// steps together.
    pub fn choose(
        &self,
        from: &[Vantage; LANES],
        brought: &[Brought; LANES],
        mut u: F32s,
        wanted: [bool; LANES],
    ) -> [(usize, f32); LANES] {
        let mut shares = lanes::each(|lane| brought[lane].children);
        let mut emitters = [0; LANES];
        let mut chance = F32s::splat(1.0);
        let mut nodes = [&self.nodes[0]; LANES];
        let mut open = wanted;
        while open.contains(&true) {
            let Step { child, chance: of_step, u: rest } = step(shares, &nodes, u);
            let is_open = lanes::mask_of(open);
            chance = Real::select(is_open, chance * of_step, chance);
            u = rest;
            let child = child.to_array();
            for lane in 0..LANES {
                if !open[lane] {
                    continue;
                }
                match nodes[lane].children[child[lane] as usize % LANES] {
                    Child::Emitter(emitter) => {
                        emitters[lane] = emitter as usize;
                        open[lane] = false;
                    }
                    Child::Node(next) => {
                        nodes[lane] = &self.nodes[next as usize];
                        shares[lane] = nodes[lane].brought_to(&(&from[lane]).into());
                    }
                }
            }
        }
        let chance = chance.to_array();
        lanes::each(|lane| (emitters[lane], chance[lane]))
    }

    /// The probability with which [`Self::choose`] chooses an emitter.
    pub fn chance(&self, from: &Vantage, brought: Brought, emitter: usize) -> f32 {
        let from = VantageLanes::from(from);
        let (mut node, mut shares) = (&self.nodes[0], brought.children);
        let mut way = self.way_to[emitter];
        let mut chance = 1.0;
        loop {
            let child = (way & 7) as usize;
            chance *= node.chance(shares, child);
            way >>= 3;
            match node.children[child] {
                Child::Emitter(_) => return chance,
                Child::Node(next) => node = &self.nodes[next as usize],
            }
            shares = node.brought_to(&from);
        }
    }
}

/// Two halves of a part, left and right of the middle one along the longest side of their centers'
/// box; a part of one stays. Ties go by their order in the scene.
fn halves(part: &mut [(u32, Outline)]) -> Vec<&mut [(u32, Outline)]> {
    if part.len() < 2 {
        return vec![part];
    }
    let centers = part.iter().map(|(_, outline)| outline.center());
    let lower = centers.clone().fold(Vec3::INFINITY, Vec3::min);
    let size = centers.fold(Vec3::NEG_INFINITY, Vec3::max) - lower;
    let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0);
    let middle = part.len() / 2;
    part.select_nth_unstable_by(middle, |a, b| {
        a.1.center()[axis].total_cmp(&b.1.center()[axis]).then(a.0.cmp(&b.0))
    });
    let (left, right) = part.split_at_mut(middle);
    vec![left, right]
}

/// A child taken from each of eight nodes.
struct Step {
    child: U32s,
    chance: F32s,
    /// What is left of the random numbers, in [0, 1).
    u: F32s,
}

/// Below one, and as close to it as can be.
const BELOW_ONE: f32 = 1.0 - 0.5 * f32::EPSILON;

impl Node {
    fn empty() -> Self {
        Self::new(&[Outline::at(Vec3::ZERO); LANES], [Child::Node(0); LANES], 0)
    }

    fn new(outlines: &[Outline; LANES], children: [Child; LANES], count: usize) -> Self {
        let of = |field: &dyn Fn(&Outline) -> f32| {
            F32s::from(lanes::each(|lane| field(&outlines[lane])))
        };
        let vector =
            |field: fn(&Outline) -> Vec3| Vector::gather(|lane| field(&outlines[lane]).to_array());
        let edge = |it: &Outline| match it.edge > -1.0 {
            true => it.edge * it.axis.length(),
            false => f32::MIN,
        };
        let half = vector(|it| 0.5 * it.upper - 0.5 * it.lower);
        let axis = vector(|it| it.axis);
        let spread = size(axis).dot(half);
        Self {
            center: vector(Outline::center),
            half,
            axis,
            spread,
            inverse_spread: inverse_of_four(spread),
            two_sided: lanes::mask_of(lanes::each(|lane| outlines[lane].two_sided)),
            even: of(&|it| it.even),
            near2: of(&|it| it.area * std::f32::consts::FRAC_1_PI),
            edge: of(&edge),
            children,
            count,
        }
    }

    /// Estimates of what the children bring.
    #[inline(always)]
    fn brought_to(&self, from: &VantageLanes) -> F32s {
        let zero = F32s::splat(0.0);
        let offset = self.center - from.position;
        let (away, half) = (size(offset), self.half);
        let gap = away - half;
        let gap = Vector::new(gap.x.fast_max(zero), gap.y.fast_max(zero), gap.z.fast_max(zero));
        let least = half.x.fast_min(half.y).fast_min(half.z) * F32s::splat(0.5);
        // Within a box the mean distance is of the order of its thinnest side.
        let nearest2 = gap.length_squared().fast_max(least * least).fast_max(F32s::splat(1e-24));
        let farthest2 = (away + half).length_squared().fast_max(F32s::splat(1e-24));
        let distance2 = mean_by_ratio(nearest2, farthest2) + self.near2;
        let (distance, inverse2) = (distance2.sqrt(), F32s::splat(1.0) / distance2);

        let along = -self.axis.dot(offset);
        let along = Real::select(self.two_sided, along.abs(), along);
        let lobe = mean_above_zero(along, self.spread, self.inverse_spread);
        let lobe = along.simd_ge(self.edge * distance) & lobe;
        let intensity = self.even.mul_add(distance, lobe);
        let spread = size(from.normal).dot(half);
        let height = from.normal.dot(offset);
        let height = mean_above_zero(height, spread, inverse_of_four(spread));
        let height = Real::select(from.in_medium, distance, height);
        // Intensity and cosine are both too large by the distance.
        (intensity * inverse2) * (height * inverse2)
    }

    /// The probability of [`step`].
    #[inline(always)]
    fn chance(&self, shares: F32s, child: usize) -> f32 {
        let shares = shares.to_array();
        let sum = sums(shares)[LANES - 1];
        if is_usable(sum) { shares[child] / sum } else { 1.0 / self.count as f32 }
    }
}

/// The children that random numbers choose, by the shares of all: a row of children a node.
#[inline(always)]
fn step(shares: [F32s; LANES], nodes: &[&Node; LANES], u: F32s) -> Step {
    let shares = F32s::transpose(shares);
    let sums = sums(shares);
    let sum = sums[LANES - 1];
    let place = (u * sum).fast_min(sum * F32s::splat(BELOW_ONE));
    let (mut share, mut before, mut child) = (shares[0], F32s::splat(0.0), F32s::splat(0.0));
    for next in 1..LANES {
        // A child without a share ends where it begins, and is passed.
        let passed = sums[next - 1].simd_le(place);
        share = Real::select(passed, shares[next], share);
        before = Real::select(passed, sums[next - 1], before);
        child = Real::select(passed, F32s::splat(next as f32), child);
    }
    let below_one = F32s::splat(BELOW_ONE);
    let rest = ((place - before) / share).fast_max(F32s::splat(0.0)).fast_min(below_one);
    let taken = Step { child: bytemuck::cast(child.round_int()), chance: share / sum, u: rest };
    let usable = sum.simd_gt(F32s::splat(f32::MIN_POSITIVE)) & sum.simd_le(F32s::splat(f32::MAX));
    if usable.to_bitmask() == lanes::mask_of([true; LANES]).to_bitmask() {
        return taken;
    }
    // Where no child brings anything, one is as good as another.
    let count = F32s::from(lanes::each(|lane| nodes[lane].count as f32));
    let place = (u * count).fast_min(count * below_one);
    let any = place.floor();
    Step {
        child: bytemuck::cast(Real::select(usable, child, any).round_int()),
        chance: Real::select(usable, taken.chance, F32s::splat(1.0) / count),
        u: Real::select(usable, rest, (place - any).fast_min(below_one)),
    }
}

/// Of each of eight numbers, the sum of those up to it.
#[inline(always)]
fn sums<T: Copy + Add<Output = T>>([a, b, c, d, e, f, g, h]: [T; LANES]) -> [T; LANES] {
    let (ab, cd, ef, gh) = (a + b, c + d, e + f, g + h);
    let abcd = ab + cd;
    let abcdef = abcd + ef;
    [a, ab, ab + c, abcd, abcd + e, abcdef, abcdef + g, abcdef + gh]
}

/// Whether shares of a sum can be taken.
pub fn is_usable(sum: f32) -> bool {
    sum > f32::MIN_POSITIVE && sum.is_finite()
}

/// The geometric mean of two numbers above zero, too large or small by 6 % at most: the mean of
/// their bits, which are nearly their logarithms. Exact where they are the same.
#[inline(always)]
fn mean_by_ratio(a: F32s, b: F32s) -> F32s {
    let [a, b]: [U32s; 2] = [a, b].map(bytemuck::cast);
    bytemuck::cast((a + b) >> 1)
}

/// The magnitude of each component.
#[inline(always)]
fn size(vector: Vector<F32s>) -> Vector<F32s> {
    Vector::new(vector.x.abs(), vector.y.abs(), vector.z.abs())
}

/// One over four times a number that is not negative, finite for zero.
#[inline(always)]
fn inverse_of_four(x: F32s) -> F32s {
    F32s::splat(0.25) / x.fast_max(F32s::splat(f32::MIN_POSITIVE))
}

/// The mean of what is above zero of a number that is spread evenly about `x`, `spread` to either
/// side; `inverse` is [`inverse_of_four`] of that.
#[inline(always)]
fn mean_above_zero(x: F32s, spread: F32s, inverse: F32s) -> F32s {
    let top = (x + spread).fast_max(F32s::splat(0.0));
    Real::select(x.simd_ge(spread), x, top * top * inverse)
}
