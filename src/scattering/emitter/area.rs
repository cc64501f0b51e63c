//! What emitters with an area share: they send the same radiance in all directions off a surface,
//! from uniformly chosen points.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

use crate::math::elementary::sin_cos;
use crate::math::{F32s, Real, Vector};
use crate::scene::baked::Bounds;

use super::aim::GAIN_MIN_OF_POINTS;
use super::direct::{DirectLanes, finite, reachable};
use super::point::cone_before;
use super::{EmissionSample, Emits, MetEmission, Source};

/// Least cosine at which light leaves: at the horizon the densities vanish.
pub const COSINE_MIN: f32 = 1e-6;

/// An emitter's area, as its densities see it.
#[derive(Clone, Copy)]
pub struct Area {
    /// In m^2.
    pub area: f32,
    /// Both sides emit.
    pub two_sided: bool,
}

impl Area {
    /// [`Emits::gain_of_aim`], by what is so at one point.
    pub fn gain_of_aim(self, at: (Vec3, Vec3), ball: &Bounds) -> Option<f32> {
        let cone = cone_before(at, ball, self.sides())?;
        let gain = cone.gain_over_cosine(cone.axis.dot(at.1).abs(), self.sides());
        Some(gain).filter(|&gain| gain > GAIN_MIN_OF_POINTS)
    }

    /// Sides that emit.
    pub fn sides(self) -> f32 {
        if self.two_sided { 2.0 } else { 1.0 }
    }

    /// Starts a path at `position`, where the normal to the front is `front`: at what it is aimed
    /// at, if that is before the point, else cosine-weighted, from either side if there are two.
    pub fn emit<Model: Emits, const N: usize>(
        self,
        source: &Source<N>,
        (position, front): (Vec3, Vec3),
        u: [f32; 2],
    ) -> EmissionSample<N> {
        let aimed_at = source.aimed_at.as_ref();
        let cone = aimed_at.and_then(|ball| cone_before((position, front), ball, self.sides()));
        let direction = match cone {
            Some(cone) => cone.direction(u),
            None => self.by_cosine(front, u),
        };
        let cos_at_light = direction.dot(front).abs().max(COSINE_MIN);
        let emission_pdf = self.emission_pdf(source, cos_at_light);
        EmissionSample {
            position,
            normal: front,
            direction,
            beta: source.radiance.map(|radiance| radiance * cos_at_light / emission_pdf),
            radiance: source.radiance,
            start_pdf: source.probability / self.area,
            emission_pdf,
            cos_at_light,
            finite: Model::FINITE,
            two_sided: self.two_sided,
            delta: Model::DELTA,
            emitter: source.row,
        }
    }

    /// A direction whose density falls off with the cosine.
    fn by_cosine(self, front: Vec3, mut u: [f32; 2]) -> Vec3 {
        let mut normal = front;
        if self.two_sided {
            let back = u[0] < 0.5;
            u[0] = u[0] * 2.0 - if back { 0.0 } else { 1.0 };
            normal = if back { -front } else { front };
        }
        let radius = u[0].sqrt();
        let (sine, cosine) = sin_cos(2.0 * PI * u[1]);
        let up = (1.0 - u[0]).sqrt().max(COSINE_MIN);
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        tangent * (radius * cosine) + bitangent * (radius * sine) + normal * up
    }

    /// What a ray along `direction` sees that meets it where the normal to the front is `front`.
    pub fn met<const N: usize>(
        self,
        source: &Source<N>,
        (front, direction): (Vec3, Vec3),
    ) -> Option<MetEmission<N>> {
        let cosine = -direction.dot(front);
        let cos_at_light = if self.two_sided { cosine.abs() } else { cosine };
        (cos_at_light > 0.0).then(|| MetEmission {
            radiance: source.radiance,
            density: None,
            emission_pdf: self.emission_pdf(source, cos_at_light),
            cos_at_light,
            normal: front,
        })
    }

    fn emission_pdf<const N: usize>(self, source: &Source<N>, cos_at_light: f32) -> f32 {
        source.probability * cos_at_light * FRAC_1_PI / (self.area * self.sides())
    }
}

/// Eight points on surfaces as seen from `reference`, chosen by the densities `pdf_a` per area,
/// where light paths start by `start_pdf`; `two_sided` is 1 where both sides emit, else 0.
#[inline(always)]
pub fn choose<Model: Emits, const N: usize>(
    (point, normal): (Vector<F32s>, Vector<F32s>),
    reference: Vector<F32s>,
    radiance: [F32s; N],
    [pdf_a, start_pdf]: [F32s; 2],
    two_sided: F32s,
) -> DirectLanes<N> {
    let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
    let offset = point - reference;
    let distance2 = offset.length_squared();
    let direction = offset * (one / distance2.sqrt());
    let cosine = -direction.dot(normal);
    let seen = Real::select(Real::gt(two_sided, zero), cosine.abs(), cosine);
    let faces = seen.simd_gt(zero);
    let cos_at_light = Real::select(faces, seen, one);
    DirectLanes {
        direction,
        point,
        normal,
        finite: finite::<Model>(),
        radiance: radiance.map(|radiance| faces & radiance),
        pdf_w: pdf_a * distance2 / cos_at_light,
        emission_pdf: start_pdf * cos_at_light * F32s::splat(FRAC_1_PI) / (one + two_sided),
        cos_at_light,
        reachable: reachable::<Model>(),
    }
}
