//! What emitters with an area share: they send the same radiance in all directions off a surface,
//! from uniformly chosen points.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

use crate::math::{F32s, Real, Vector};

use super::direct::{DirectLanes, finite, reachable};
use super::{EmissionSample, Emits, MetEmission, Source};

/// An emitter's area, as its densities see it.
#[derive(Clone, Copy)]
pub struct Area {
    /// In m^2.
    pub area: f32,
    /// Both sides emit.
    pub two_sided: bool,
}

impl Area {
    /// Starts a path at `position`, where the normal to the front is `front`: cosine-weighted,
    /// from either side if there are two.
    pub fn emit<Model: Emits, const N: usize>(
        self,
        source: &Source<N>,
        (position, front): (Vec3, Vec3),
        mut u: [f32; 2],
    ) -> EmissionSample<N> {
        let mut normal = front;
        if self.two_sided {
            let back = u[0] < 0.5;
            u[0] = u[0] * 2.0 - if back { 0.0 } else { 1.0 };
            normal = if back { -front } else { front };
        }
        let radius = u[0].sqrt();
        let (sine, cosine) = (2.0 * PI * u[1]).sin_cos();
        // Kept off the horizon, where the densities vanish.
        let cos_at_light = (1.0 - u[0]).sqrt().max(1e-6);
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        let direction =
            tangent * (radius * cosine) + bitangent * (radius * sine) + normal * cos_at_light;
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

    /// What is seen at a cosine to the normal of the front.
    pub fn met<const N: usize>(self, source: &Source<N>, cosine: f32) -> Option<MetEmission<N>> {
        let cos_at_light = if self.two_sided { cosine.abs() } else { cosine };
        (cos_at_light > 0.0).then(|| MetEmission {
            radiance: source.radiance,
            emission_pdf: self.emission_pdf(source, cos_at_light),
            cos_at_light,
        })
    }

    fn emission_pdf<const N: usize>(self, source: &Source<N>, cos_at_light: f32) -> f32 {
        let sides = if self.two_sided { 2.0 } else { 1.0 };
        source.probability * cos_at_light * FRAC_1_PI / (self.area * sides)
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
