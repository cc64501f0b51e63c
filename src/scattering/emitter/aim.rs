//! Where light paths are aimed: at balls around what matters in a scene that is large against it,
//! mixed with all of the scene.
//!
//! A light path starts along a line, and whether that meets a ball does not hang on the vertices
//! along it. So its density, that of the mixture, is the same whoever asks: the path itself when it
//! starts, a sensor path that meets the emitter, and a vertex that connects to it.
//!
//! From an area, paths are aimed at balls that are wholly before the point where they start; those
//! of other points leave as if they were not aimed.

use glam::{DVec3, Vec3};

use crate::math::elementary::{exp, ln};
use crate::math::{F32s, LANES, Real, Vector, lanes};
use crate::scene::baked::{Bounds, Shapes};
use crate::scene::emitter::Emitter;

use super::direct::DirectLanes;
use super::point::{ConeAbout, cone_before, versine_of};
use super::{EmissionSample, gain_of_aim, sides_of_area};

/// Share of the light paths of an emitter that are aimed at some ball, if the camera sees a small
/// part of the scene, and if not: then the rest of it is seen too.
const AIMED: f32 = 0.75;
const AIMED_IN_ROOMS: f32 = 0.5;

/// A ball is aimed at if that makes paths so much denser at least.
pub const GAIN_MIN: f32 = 4.0;
/// And those of points, which are near the rest of the scene too: all that is lit by it, in turn,
/// lights what is seen.
pub const GAIN_MIN_OF_POINTS: f32 = 64.0;

/// A ball that light paths are aimed at, which all others are as well worth as its `weight`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Where it is.
    pub ball: Bounds,
    /// Its part in the sum of all weights is its part of the paths that are aimed.
    pub weight: f32,
}

/// What light paths are aimed at.
#[derive(Clone, Debug, Default)]
pub struct Targets {
    /// Balls; they may overlap.
    pub all: Vec<Target>,
    /// Whether the camera sees a small part of the scene, at least on half of the film.
    pub sees_little: bool,
}

/// The balls, and how likely each emitter is to aim at which.
#[derive(Clone, Debug)]
pub struct Aim {
    balls: Vec<Bounds>,
    /// For every emitter, one row.
    rows: Vec<Row>,
    /// For every emitter, a number for every ball: how likely a path is to be aimed at one up to
    /// that.
    chances: Vec<f32>,
    /// And the densities of lines that are, with the probability of that: over those of lines that
    /// are aimed at the whole scene. From an area that hangs on the line, and this is the
    /// probability alone.
    gains: Vec<f32>,
}

#[derive(Clone, Copy, Debug)]
struct Row {
    /// Probability of aiming at the whole scene.
    whole: f32,
    /// Whether light leaves points, and so meets a ball on one side of them only.
    is_finite: bool,
    /// Sides that emit of an area, else zero.
    sides: f32,
}

/// An emitter, and a line along which its light travels.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Row of the emitter.
    pub emitter: usize,
    /// Where it leaves the emitter, or any point of the line if that is infinitely far away.
    pub point: Vec3,
    /// The emitter's normal there, if it has a surface.
    pub normal: Vec3,
    /// Along the light, unit length.
    pub direction: Vec3,
}

impl Aim {
    /// At the targets, as far as they are small for the emitters, whose probabilities then follow
    /// what of their power comes there. None where there is nothing to aim at.
    pub fn new(targets: &Targets, shapes: &Shapes, emitters: &mut [Emitter]) -> Option<Self> {
        let Targets { all: targets, sees_little } = targets;
        let share_aimed = if *sees_little { AIMED } else { AIMED_IN_ROOMS };
        let sum: f32 = targets.iter().map(|target| target.weight).sum();
        let balls: Vec<Bounds> = targets.iter().map(|target| target.ball).collect();
        let mut aim = Self { balls, rows: Vec::new(), chances: Vec::new(), gains: Vec::new() };
        let mut comes = Vec::new();
        for emitter in &*emitters {
            let is_finite = emitter.model.is_finite();
            let is_aimed = *sees_little || !is_finite;
            let sides = sides_of_area(&emitter.model);
            let (mut aimed, mut brought) = (0.0, 0.0);
            for target in targets {
                let gain = gain_of_aim(&emitter.model, shapes, &target.ball);
                let gain = gain.filter(|_| is_aimed);
                let chance = gain.map_or(0.0, |_| share_aimed * target.weight / sum);
                aimed += chance;
                brought -= gain.map_or(0.0, ln) * target.weight / sum;
                aim.chances.push(aimed);
                aim.gains.push(if sides > 0.0 { chance } else { chance * gain.unwrap_or(0.0) });
            }
            comes.push(exp(brought));
            aim.rows.push(Row { whole: 1.0 - aimed, is_finite, sides });
        }
        if aim.rows.iter().all(|row| row.whole == 1.0) {
            return None;
        }
        favor(emitters, &comes);
        Some(aim)
    }

    /// The ball at which an emitter aims by a random number in [0, 1); none if at all of the scene.
    pub fn draw(&self, emitter: usize, u: f32) -> Option<usize> {
        let chances = &self.chances[self.of(emitter)];
        let ball = chances.partition_point(|&chance| chance <= u);
        (ball < chances.len()).then_some(ball)
    }

    /// A ball.
    pub fn ball(&self, index: usize) -> Bounds {
        self.balls[index]
    }

    /// Weighs a light path as one of the mixture: until then it has the density of those that are
    /// aimed at all of the scene. It has been aimed at the ball `drawn`, which rounding errors do
    /// not let it miss.
    pub fn weigh<const N: usize>(&self, sample: &mut EmissionSample<N>, drawn: Option<usize>) {
        let &mut EmissionSample { emitter, position: point, normal, direction, .. } = sample;
        let gain = self.gain_with(Line { emitter, point, normal, direction }, drawn);
        sample.beta.iter_mut().for_each(|beta| *beta /= gain);
        sample.emission_pdf *= gain;
    }

    /// The `emission` density of a line over that by paths which are aimed at all of the scene.
    pub fn gain(&self, line: Line) -> f32 {
        self.gain_with(line, None)
    }

    fn gain_with(&self, line: Line, drawn: Option<usize>) -> f32 {
        let row = self.rows[line.emitter];
        let mut sum = row.whole;
        let gains = &self.gains[self.of(line.emitter)];
        for (index, (ball, &gain)) in self.balls.iter().zip(gains).enumerate() {
            if gain == 0.0 {
                continue;
            }
            let seen = Seen::of(ball, &line, row.sides);
            if matches!(seen, Seen::NotBefore)
                || drawn == Some(index)
                || line.meets(ball, row.is_finite)
            {
                sum += gain * seen.denser(&line, row.sides);
            }
        }
        sum
    }

    /// The same for eight choices of `emitters` from the points `reference`, which still have the
    /// densities of paths that are aimed at all of the scene.
    #[inline(always)]
    pub fn mix<const N: usize>(
        &self,
        chosen: &mut DirectLanes<N>,
        emitters: [usize; LANES],
        reference: Vector<F32s>,
    ) {
        let mut sum = F32s::from(emitters.map(|emitter| self.rows[emitter].whole));
        let point = Vector::select(chosen.finite, chosen.point, reference);
        let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
        let sides = F32s::from(emitters.map(|emitter| self.rows[emitter].sides));
        let has_area = sides.simd_gt(zero);
        for (index, ball) in self.balls.iter().enumerate() {
            let gain = |lane: usize| self.gains[emitters[lane] * self.balls.len() + index];
            let to_ball = Vector::splat(ball.center) - point;
            let off = to_ball.cross(chosen.direction).length_squared();
            let radius = F32s::splat(ball.radius);
            let is_before = to_ball.dot(chosen.direction).simd_lt(zero);
            let is_on_side = Real::select(chosen.finite, is_before, lanes::first(LANES));
            let meets = off.simd_lt(radius * radius) & is_on_side;
            let gain = F32s::from(lanes::each(gain));
            let height = to_ball.dot(chosen.normal);
            let height = Real::select(sides.simd_gt(one), height.abs(), height);
            let versine = versine_of(radius * radius / to_ball.length_squared());
            let denser = sides / ((versine + versine) * chosen.cos_at_light);
            let of_area = Real::select(height.simd_gt(radius), meets & denser, one);
            sum += gain * Real::select(has_area, of_area, meets & one);
        }
        chosen.emission_pdf *= sum;
    }

    fn of(&self, emitter: usize) -> std::ops::Range<usize> {
        let count = self.balls.len();
        emitter * count..(emitter + 1) * count
    }
}

/// Lets light paths start at emitters by the mean of their powers and of what of these `comes` to
/// where they are aimed, in the geometric mean: what of the sun's falls on a large ground says
/// little about what is seen.
fn favor(emitters: &mut [Emitter], comes: &[f32]) {
    let all: f32 = emitters.iter().zip(comes).map(|(of, share)| of.probability * share).sum();
    for (emitter, share) in emitters.iter_mut().zip(comes) {
        emitter.probability *= 0.5 + 0.5 * (share / all);
    }
}

/// How an area sees a ball from the point of a line.
enum Seen {
    /// There is no area.
    Apart,
    /// Not wholly before the point.
    NotBefore,
    /// In the cone about it.
    In(ConeAbout),
}

impl Seen {
    fn of(ball: &Bounds, line: &Line, sides: f32) -> Self {
        if sides == 0.0 {
            return Self::Apart;
        }
        cone_before((line.point, line.normal), ball, sides).map_or(Self::NotBefore, Self::In)
    }

    /// The density of a line that is aimed at the ball over that of those which are not, which fall
    /// off with the cosine: 1 where that is not known here.
    fn denser(&self, line: &Line, sides: f32) -> f32 {
        match self {
            Self::Apart | Self::NotBefore => 1.0,
            Self::In(cone) => cone.gain_over_cosine(line.direction.dot(line.normal).abs(), sides),
        }
    }
}

impl Line {
    fn meets(&self, ball: &Bounds, is_finite: bool) -> bool {
        let [to_ball, direction] = [ball.center - self.point, self.direction].map(Vec3::as_dvec3);
        let off: DVec3 = to_ball.cross(direction);
        let is_on_side = !is_finite || to_ball.dot(direction) > 0.0;
        is_on_side && off.length_squared() < f64::from(ball.radius).powi(2)
    }
}
