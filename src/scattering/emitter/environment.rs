//! The environment: the same radiance from all directions.

use std::f32::consts::PI;

use glam::Vec3;

use crate::math::{F32s, Vector};
use crate::scene::baked::{Bounds, Shapes};
use crate::scene::emitter::Environment;

use super::direct::{DirectLanes, Own, OwnLanes, own};
use super::infinity::{self, SPHERE_PDF, any_direction, any_directions, disk_pdf};
use super::tree::Outline;
use super::{EmissionSample, Emits, MetEmission, Source};

impl Emits for Environment {
    const DELTA: bool = false;

    fn record(&self, shapes: &Shapes, probability: f32) -> Own {
        own([probability * SPHERE_PDF * disk_pdf(shapes)])
    }

    #[inline(always)]
    fn choose<const N: usize>(
        &[emission_pdf, ..]: &OwnLanes,
        _: Vector<F32s>,
        radiance: [F32s; N],
        chance: F32s,
        u: [F32s; 2],
    ) -> DirectLanes<N> {
        let densities = [chance * F32s::splat(SPHERE_PDF), emission_pdf];
        infinity::choose::<Self, N>(any_directions(u), radiance, densities)
    }

    fn density(&self, _: &Shapes, _: Vec3, _: Vec3, _: Vec3) -> f32 {
        SPHERE_PDF
    }

    fn outline(&self, _: &Shapes) -> Outline {
        Outline { even: PI, ..Outline::at(Vec3::ZERO) }
    }

    fn gain_of_aim(&self, shapes: &Shapes, ball: &Bounds) -> Option<f32> {
        infinity::gain_of_aim(shapes, ball)
    }

    fn emit<const N: usize>(
        &self,
        source: &Source<N>,
        u_position: [f32; 2],
        u_direction: [f32; 2],
    ) -> EmissionSample<N> {
        let direction = -any_direction(u_direction);
        infinity::emit::<Self, N>(source, (direction, SPHERE_PDF), u_position)
    }

    fn met<const N: usize>(&self, source: &Source<N>, _: Vec3, _: Vec3) -> Option<MetEmission<N>> {
        Some(MetEmission {
            radiance: source.radiance,
            emission_pdf: source.probability * SPHERE_PDF * disk_pdf(source.shapes),
            cos_at_light: 1.0,
            normal: Vec3::ZERO,
        })
    }

    fn places(&self, _: &Shapes) -> Vec<(Vec3, Vec3)> {
        Vec::new()
    }
}
