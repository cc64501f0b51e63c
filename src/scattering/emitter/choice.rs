//! Which emitter a light path starts at, and which a vertex connects to.
//!
//! Light paths start at emitters by their power. Vertices choose in two steps. First between what
//! is infinitely far away (sky, sun) and what is near, by estimates of what both bring to the
//! vertex, neither less than one time in eight: their powers cannot be compared, as that of the sky
//! grows with the scene. Then among those that are near by a [`LightTree`], mixed with a uniform
//! choice among objects (and by power among the emitters of one): the tree does not know what
//! stands in the way, and an emitter that it overlooks must not become noise. Every probability can
//! be asked for again, from the vertex for which it holds, as the weights of emitters that are met
//! need it.

use crate::math::{F32s, LANES, lanes};
use crate::scene::baked::{NONE, Shapes};
use crate::scene::emitter::Emitter;

use super::tree::{Brought, LightTree, Outline, Vantage, is_usable};
use super::{outline, primitive};

/// Least probability of what is near, and of what is infinitely far away, where there are both.
const LEAST_SHARE: f32 = 0.125;
/// Share of the uniform choice among objects, if those are few; one object's at most.
const UNIFORM_MOST: f32 = 0.25;
/// And if they are many.
const UNIFORM_LEAST: f32 = 0.0625;

/// The probabilities of a scene's emitters.
#[derive(Clone, Debug)]
pub struct Choice {
    /// Running sum of the powers: first zero, last exactly one.
    power: Vec<f64>,
    /// How vertices choose; none where there is nothing to choose, or two triangles of one object
    /// only, which go by power.
    by_vantage: Option<ByVantage>,
}

#[derive(Clone, Debug)]
struct ByVantage {
    near: Option<Near>,
    /// Emitters infinitely far away.
    far: Vec<(usize, Outline)>,
}

/// Emitters at a finite distance.
#[derive(Clone, Debug)]
struct Near {
    tree: LightTree,
    /// Rows of the emitters of each object, in their order.
    objects: Vec<[usize; 2]>,
    /// Probability of choosing uniformly.
    uniform: f32,
    /// For every emitter, the probability of choosing it so.
    uniformly: Vec<f32>,
}

impl Choice {
    /// For all emitters of a scene.
    pub fn new(shapes: &Shapes, emitters: &[Emitter]) -> Self {
        let mut power = vec![0.0];
        for emitter in emitters {
            power.push(power[power.len() - 1] + f64::from(emitter.probability));
        }
        let sum = power[power.len() - 1];
        power.iter_mut().for_each(|of| *of /= sum);
        let outline_of = |(row, emitter): (usize, &Emitter)| {
            (row, outline(&emitter.model, shapes).scaled(emitter.brightness))
        };
        let (near, far): (Vec<_>, Vec<_>) = emitters
            .iter()
            .enumerate()
            .map(outline_of)
            .partition(|(row, _)| emitters[*row].model.is_finite());
        let objects = objects(shapes, emitters, &near);
        let is_plain = far.is_empty() && objects.len() == 1 && near.len() <= 2;
        if is_plain || emitters.len() == 1 {
            return Self { power, by_vantage: None };
        }
        let near = (!near.is_empty()).then(|| Near::new(near, objects, &power));
        Self { power, by_vantage: Some(ByVantage { near, far }) }
    }

    /// The emitter that two random numbers in [0, 1) choose by its power.
    pub fn by_power(&self, u: [f32; 2]) -> usize {
        let u = place_of(u);
        self.power[1..self.power.len() - 1].partition_point(|&sum| sum <= u)
    }

    /// Of the rows from `first` to `end`, the one that the running sum has at `u`.
    fn within(&self, first: usize, end: usize, u: f64) -> usize {
        let [low, high] = [self.power[first], self.power[end]];
        let place = low + u * (high - low);
        let chosen = first + self.power[first + 1..end].partition_point(|&sum| sum <= place);
        chosen.min(end - 1)
    }

    /// Whether choices depend on the vertex.
    #[inline(always)]
    pub fn depends_on_vantage(&self) -> bool {
        self.by_vantage.is_some()
    }

    /// [`Self::by_power`] of two emitters at most, as there are where choices do not depend on the
    /// vertex: the mask of the lanes that choose the second.
    #[inline(always)]
    pub fn second_by_power(&self, u: [[f32; LANES]; 2]) -> F32s {
        if self.power.len() < 3 {
            return F32s::splat(0.0);
        }
        let second = self.power[1];
        lanes::mask_of(lanes::each(|lane| second <= place_of([u[0][lane], u[1][lane]])))
    }

    /// The emitters that pairs of random numbers in [0, 1) choose for eight vertices to connect to,
    /// and the probabilities of that. Only the first `live` have a meaning.
    pub fn choose(
        &self,
        from: &[Vantage; LANES],
        numbers: [[f32; LANES]; 2],
        live: usize,
    ) -> [(usize, f32); LANES] {
        let pair = |lane: usize| numbers.map(|of| of[lane]);
        let Some(ByVantage { near, far }) = &self.by_vantage else {
            let chosen = lanes::each(|lane| self.by_power(pair(lane)));
            return chosen
                .map(|of| (of, share_of_power(&self.power, of, [0, self.power.len() - 1])));
        };
        let Some(near) = near else {
            return lanes::each(|lane| choose_far(far, &from[lane], numbers[1][lane]));
        };
        let brought = near.tree.brought_to_all(from);
        let mut shares = [0.0; LANES];
        if !far.is_empty() {
            shares = lanes::each(|lane| share_of_far(far, &from[lane], brought[lane]));
        }
        // What is left of the second number for the choice among those that are near.
        let rest = lanes::each(|lane| (numbers[1][lane] - shares[lane]) / (1.0 - shares[lane]));
        let by_tree = lanes::each(|lane| lane < live && rest[lane] >= near.uniform);
        let mut chosen = near.tree.choose(from, &brought, numbers[0].into(), by_tree);
        for lane in 0..live {
            let [u, v] = pair(lane);
            if v < shares[lane] {
                let (emitter, chance) = choose_far(far, &from[lane], v / shares[lane]);
                chosen[lane] = (emitter, chance * shares[lane]);
                continue;
            }
            if !by_tree[lane] {
                let emitter = self.uniform(near, [u, rest[lane] / near.uniform]);
                let chance = near.tree.chance(&from[lane], brought[lane], emitter);
                chosen[lane] = (emitter, chance);
            }
            let (emitter, chance) = chosen[lane];
            chosen[lane].1 = (1.0 - shares[lane]) * near.mixed(chance, emitter);
        }
        chosen
    }

    /// The probability with which [`Self::choose`] chooses an emitter.
    pub fn chance(&self, from: &Vantage, emitter: usize) -> f32 {
        let Some(ByVantage { near, far }) = &self.by_vantage else {
            return share_of_power(&self.power, emitter, [0, self.power.len() - 1]);
        };
        let as_far = far.iter().position(|(row, _)| *row == emitter);
        let Some(near) = near else { return as_far.map_or(0.0, |it| chance_of_far(far, from, it)) };
        let brought = near.tree.brought_to(from);
        let share = if far.is_empty() { 0.0 } else { share_of_far(far, from, brought) };
        match as_far {
            Some(index) => share * chance_of_far(far, from, index),
            None => {
                let by_tree = near.tree.chance(from, brought, emitter);
                (1.0 - share) * near.mixed(by_tree, emitter)
            }
        }
    }

    /// An emitter of any object.
    fn uniform(&self, near: &Near, [u, v]: [f32; 2]) -> usize {
        let object = (v * near.objects.len() as f32) as usize;
        let [first, end] = near.objects[object.min(near.objects.len() - 1)];
        self.within(first, end, f64::from(u))
    }
}

/// A number made of both: an emitter's share may be less than the steps of one.
#[inline(always)]
fn place_of(u: [f32; 2]) -> f64 {
    f64::from(u[0]) + f64::from(u[1]) * f64::from(f32::EPSILON)
}

/// The part that an emitter has in the power of the rows from `first` to `end`.
fn share_of_power(power: &[f64], emitter: usize, [first, end]: [usize; 2]) -> f32 {
    let of = |first: usize, end: usize| power[end] - power[first];
    (of(emitter, emitter + 1) / of(first, end)) as f32
}

impl Near {
    fn new(emitters: Vec<(usize, Outline)>, objects: Vec<[usize; 2]>, power: &[f64]) -> Self {
        let count = power.len() - 1;
        let uniform = (1.0 / objects.len() as f32).clamp(UNIFORM_LEAST, UNIFORM_MOST);
        let mut uniformly = vec![0.0; count];
        for &[first, end] in &objects {
            for (chance, emitter) in uniformly[first..end].iter_mut().zip(first..) {
                let share = share_of_power(power, emitter, [first, end]);
                *chance = uniform * share / objects.len() as f32;
            }
        }
        let rows = emitters.into_iter().map(|(row, outline)| (row as u32, outline)).collect();
        Self { tree: LightTree::new(rows, count), objects, uniform, uniformly }
    }

    /// The probability of an emitter that the tree chooses with the probability `by_tree`.
    #[inline(always)]
    fn mixed(&self, by_tree: f32, emitter: usize) -> f32 {
        (1.0 - self.uniform) * by_tree + self.uniformly[emitter]
    }
}

/// The objects of emitters at a finite distance: rows next to each other whose primitives are of
/// one surface, or a single one.
fn objects(shapes: &Shapes, emitters: &[Emitter], near: &[(usize, Outline)]) -> Vec<[usize; 2]> {
    let mut objects: Vec<([usize; 2], u32)> = Vec::new();
    for &(row, _) in near {
        let surface = match primitive(&emitters[row].model) {
            NONE => NONE,
            primitive => shapes.surface_of(primitive),
        };
        match objects.last_mut() {
            Some(([_, end], of)) if *end == row && *of == surface && surface != NONE => *end += 1,
            Some(_) | None => objects.push(([row, row + 1], surface)),
        }
    }
    objects.into_iter().map(|(rows, _)| rows).collect()
}

/// What an emitter brings that is infinitely far away: irradiance.
fn brought_from_afar(outline: &Outline, from: &Vantage) -> f32 {
    let along = from.normal.dot(outline.axis).max(0.0);
    let in_medium = from.normal == glam::Vec3::ZERO;
    outline.even + if in_medium { outline.axis.length() } else { along }
}

fn sum_from_afar(far: &[(usize, Outline)], from: &Vantage) -> f32 {
    far.iter().map(|(_, outline)| brought_from_afar(outline, from)).sum()
}

/// Probability of choosing among what is infinitely far away, if there are others too.
fn share_of_far(far: &[(usize, Outline)], from: &Vantage, brought: Brought) -> f32 {
    let afar = sum_from_afar(far, from);
    let sum = afar + brought.sum;
    let share = if is_usable(sum) { afar / sum } else { 0.5 };
    share.clamp(LEAST_SHARE, 1.0 - LEAST_SHARE)
}

/// Of what is infinitely far away: by what each brings, mixed with a uniform choice.
fn choose_far(far: &[(usize, Outline)], from: &Vantage, v: f32) -> (usize, f32) {
    let all = sum_from_afar(far, from);
    let mut left = v;
    let (mut emitter, mut chance) = (0, 0.0);
    for of in far {
        (emitter, chance) = (of.0, chance_among(far.len(), brought_from_afar(&of.1, from), all));
        if left < chance {
            break;
        }
        left -= chance;
    }
    (emitter, chance)
}

fn chance_of_far(far: &[(usize, Outline)], from: &Vantage, index: usize) -> f32 {
    let all = sum_from_afar(far, from);
    chance_among(far.len(), brought_from_afar(&far[index].1, from), all)
}

/// The probability of one of `count` that brings so much of what `all` bring.
fn chance_among(count: usize, brought: f32, all: f32) -> f32 {
    let uniform = 1.0 / count as f32;
    if count == 1 || !is_usable(all) {
        return uniform;
    }
    (1.0 - UNIFORM_MOST) * (brought / all) + UNIFORM_MOST * uniform
}
