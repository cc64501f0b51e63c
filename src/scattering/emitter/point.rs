//! Point lights, and what spots share with them: light from a point into a cone.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

use crate::math::elementary::sin_cos;
use crate::math::{F32s, Real, Vector};
use crate::scene::baked::{Bounds, Shapes};
use crate::scene::emitter::Point;

use super::aim::GAIN_MIN_OF_POINTS;
use super::area::COSINE_MIN;
use super::direct::{DirectLanes, Own, OwnLanes, Tables, finite, own, reachable};
use super::tree::Outline;
use super::{EmissionSample, Emits, Source};

/// Cosine at the edge of the cone that holds all directions.
const ALL: f32 = -1.0;

impl Emits for Point {
    const DELTA: bool = true;

    fn record(&self, _: &Shapes, probability: f32) -> Own {
        let [x, y, z] = self.position.to_array();
        own([x, y, z, probability * cone_pdf(ALL)])
    }

    #[inline(always)]
    fn choose<const N: usize>(
        (&[x, y, z, emission_pdf, ..], _): (&OwnLanes, &Tables),
        reference: Vector<F32s>,
        radiance: [F32s; N],
        chance: F32s,
        _: [F32s; 2],
    ) -> DirectLanes<N> {
        choose::<Self, N>(Vector::new(x, y, z), reference, radiance, [chance, emission_pdf])
    }

    fn density(&self, _: &Shapes, _: Vec3, _: Vec3, _: Vec3) -> f32 {
        1.0
    }

    fn outline(&self, _: &Shapes) -> Outline {
        Outline { even: 1.0, ..Outline::at(self.position) }
    }

    fn gain_of_aim(&self, _: &Shapes, ball: &Bounds) -> Option<f32> {
        cone_about(self.position, ball)?.gain(ALL)
    }

    fn emit<const N: usize>(
        &self,
        source: &Source<N>,
        _: [f32; 2],
        u_direction: [f32; 2],
    ) -> EmissionSample<N> {
        let direction = direction_of_path(source, self.position, (Vec3::Z, ALL), u_direction);
        emit::<Self, N>(source, self.position, direction, source.radiance, cone_pdf(ALL))
    }

    fn places(&self, _: &Shapes) -> Vec<(Vec3, Vec3)> {
        vec![(self.position, Vec3::ZERO)]
    }
}

/// Density per steradian of a uniform direction in a cone, by the cosine at its edge.
pub fn cone_pdf(cos_edge: f32) -> f32 {
    0.5 * FRAC_1_PI / (1.0 - cos_edge)
}

/// The cone in which a ball is seen.
#[derive(Clone, Copy, Debug)]
pub struct ConeAbout {
    /// To the center, unit length.
    pub axis: Vec3,
    /// One less the cosine at the edge: narrow cones have cosines that no `f32` tells from one.
    versine: f32,
}

/// The cone in which a ball is seen from a point; none from within.
pub fn cone_about(point: Vec3, ball: &Bounds) -> Option<ConeAbout> {
    let to_ball = ball.center.as_dvec3() - point.as_dvec3();
    let sine2 = f64::from(ball.radius).powi(2) / to_ball.length_squared();
    let versine = versine_of(sine2) as f32;
    (sine2 < 1.0).then(|| ConeAbout { axis: to_ball.normalize().as_vec3(), versine })
}

/// One less the cosine of an angle, by its squared sine.
#[inline(always)]
pub fn versine_of<F: Real>(sine2: F) -> F {
    sine2 / (F::one() + (F::one() - sine2).sqrt())
}

/// The same from a point of an area with this normal, that emits on so many `sides`; none if the
/// ball is not wholly before it.
pub fn cone_before((point, normal): (Vec3, Vec3), ball: &Bounds, sides: f32) -> Option<ConeAbout> {
    let height = normal.dot(ball.center - point);
    let height = if sides > 1.0 { height.abs() } else { height };
    (height > ball.radius).then(|| cone_about(point, ball)).flatten()
}

impl ConeAbout {
    /// [`Emits::gain_of_aim`] of a point that shines into a cone with this cosine at its edge.
    pub fn gain(self, cos_edge: f32) -> Option<f32> {
        Some((1.0 - cos_edge) / self.versine).filter(|&gain| gain > GAIN_MIN_OF_POINTS)
    }

    /// How many times as dense uniform directions in it are as those that fall off with the cosine
    /// to a normal, on one side of that or two.
    pub fn gain_over_cosine(self, cosine: f32, sides: f32) -> f32 {
        sides / (2.0 * self.versine * cosine.max(COSINE_MIN))
    }

    /// Cosine at the edge.
    pub fn cos_edge(self) -> f32 {
        1.0 - self.versine
    }

    /// A uniform direction in it.
    pub fn direction(self, u: [f32; 2]) -> Vec3 {
        let versine = u[0] * self.versine;
        let radius = (versine * (2.0 - versine)).sqrt();
        let (sine, cosine) = sin_cos(2.0 * PI * u[1]);
        let (tangent, bitangent) = self.axis.any_orthonormal_pair();
        let across = tangent * (radius * cosine) + bitangent * (radius * sine);
        (across + self.axis * (1.0 - versine)).normalize()
    }
}

/// The direction of a light path from a point: in the cone about what it is aimed at, else in that
/// of the light.
pub fn direction_of_path<const N: usize>(
    source: &Source<N>,
    position: Vec3,
    (axis, cos_edge): (Vec3, f32),
    u: [f32; 2],
) -> Vec3 {
    let about = source.aimed_at.and_then(|ball| cone_about(position, &ball));
    about.map_or_else(|| in_cone(axis, cos_edge, u), |cone| cone.direction(u))
}

/// A uniform direction in a cone.
pub fn in_cone(axis: Vec3, cos_edge: f32, u: [f32; 2]) -> Vec3 {
    let spread = 0.5 * FRAC_1_PI / cone_pdf(cos_edge);
    let z = 1.0 - u[0] * spread;
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sine, cosine) = sin_cos(2.0 * PI * u[1]);
    let (tangent, bitangent) = axis.any_orthonormal_pair();
    tangent * (radius * cosine) + bitangent * (radius * sine) + axis * z
}

/// Starts a path at a point along `direction`, where it has an `intensity`; the direction's
/// density per steradian is `pdf`.
pub fn emit<Model: Emits, const N: usize>(
    source: &Source<N>,
    position: Vec3,
    direction: Vec3,
    intensity: [f32; N],
    pdf: f32,
) -> EmissionSample<N> {
    let emission_pdf = source.probability * pdf;
    EmissionSample {
        position,
        normal: Vec3::ZERO,
        direction,
        beta: intensity.map(|intensity| intensity / emission_pdf),
        radiance: intensity,
        start_pdf: source.probability,
        emission_pdf,
        cos_at_light: 1.0,
        finite: Model::FINITE,
        two_sided: false,
        delta: Model::DELTA,
        emitter: source.row,
    }
}

/// Eight points of the radiant intensity `intensity`, which may yet depend on the direction.
#[inline(always)]
pub fn choose<Model: Emits, const N: usize>(
    point: Vector<F32s>,
    reference: Vector<F32s>,
    intensity: [F32s; N],
    [chance, emission_pdf]: [F32s; 2],
) -> DirectLanes<N> {
    let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
    let offset = point - reference;
    let distance2 = offset.length_squared();
    DirectLanes {
        direction: offset * (one / distance2.sqrt()),
        point,
        normal: Vector::new(zero, zero, zero),
        finite: finite::<Model>(),
        radiance: intensity,
        pdf_w: chance * distance2,
        emission_pdf,
        cos_at_light: one,
        reachable: reachable::<Model>(),
    }
}
