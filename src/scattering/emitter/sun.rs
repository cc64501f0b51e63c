//! The sun as a disk infinitely far away. Directions to it are drawn evenly.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

use crate::math::elementary::sin_cos;
use crate::math::{F32s, Vector, warp};
use crate::scene::baked::{Bounds, Shapes};
use crate::scene::emitter::Sun;

use super::direct::{DirectLanes, Own, OwnLanes, Tables, own};
use super::infinity::{self, disk_pdf};
use super::tree::Outline;
use super::{EmissionSample, Emits, MetEmission, Source};

impl Sun {
    /// Density per steradian of a direction to it.
    fn pdf(&self) -> f32 {
        0.5 * FRAC_1_PI / self.versine
    }
}

impl Emits for Sun {
    const DELTA: bool = false;

    fn record(&self, shapes: &Shapes, probability: f32) -> Own {
        let [x, y, z] = (-self.direction).to_array();
        let pdf = self.pdf();
        own([x, y, z, self.versine, pdf, probability * pdf * disk_pdf(shapes)])
    }

    #[inline(always)]
    fn choose<const N: usize>(
        (&[x, y, z, versine, pdf, emission_pdf, ..], _): (&OwnLanes, &Tables),
        _: Vector<F32s>,
        radiance: [F32s; N],
        chance: F32s,
        u: [F32s; 2],
    ) -> DirectLanes<N> {
        let axis = Vector::new(x, y, z);
        let one = F32s::splat(1.0);
        let versine = u[0] * versine;
        let radius = (versine * (one + one - versine)).sqrt();
        let (sine, cosine) = warp::sin_cos_turns(u[1]);
        let tangent = axis.any_perpendicular();
        let bitangent = axis.cross(tangent);
        let across = bitangent.mul_add(radius * sine, axis * (one - versine));
        let direction = tangent.mul_add(radius * cosine, across);
        infinity::choose::<Self, N>(direction, radiance, [chance * pdf, emission_pdf])
    }

    fn density(&self, _: &Shapes, _: Vec3, _: Vec3, _: Vec3) -> f32 {
        self.pdf()
    }

    fn outline(&self, _: &Shapes) -> Outline {
        Outline { axis: -self.direction * self.faced() as f32, ..Outline::at(Vec3::ZERO) }
    }

    fn gain_of_aim(&self, shapes: &Shapes, ball: &Bounds) -> Option<f32> {
        infinity::gain_of_aim(shapes, ball)
    }

    fn share_of_sky(&self) -> Option<f64> {
        Some(0.5 * f64::from(self.versine))
    }

    fn emit<const N: usize>(
        &self,
        source: &Source<N>,
        u_position: [f32; 2],
        u_direction: [f32; 2],
    ) -> EmissionSample<N> {
        let versine = u_direction[0] * self.versine;
        let radius = (versine * (2.0 - versine)).sqrt();
        let (sine, cosine) = sin_cos(2.0 * PI * u_direction[1]);
        let (tangent, bitangent) = self.direction.any_orthonormal_pair();
        let across = tangent * (radius * cosine) + bitangent * (radius * sine);
        let direction = (across + self.direction * (1.0 - versine)).normalize();
        infinity::emit::<Self, N>(source, (direction, self.pdf()), u_position)
    }

    fn met<const N: usize>(
        &self,
        source: &Source<N>,
        _: Vec3,
        direction: Vec3,
    ) -> Option<MetEmission<N>> {
        // Half the square of the chord is one less the cosine.
        let versine = 0.5 * (direction + self.direction).length_squared();
        (versine <= self.versine).then(|| MetEmission {
            radiance: source.radiance,
            density: None,
            emission_pdf: source.probability * self.pdf() * disk_pdf(source.shapes),
            cos_at_light: 1.0,
            normal: Vec3::ZERO,
        })
    }
}
