//! The environment: radiance from all directions, the same or more from one side. Directions are
//! drawn evenly.

use std::f32::consts::PI;

use glam::Vec3;

use crate::math::{F32s, Vector};
use crate::scene::baked::{Bounds, Shapes};
use crate::scene::emitter::Environment;

use super::direct::{DirectLanes, Own, OwnLanes, Tables, own};
use super::infinity::{self, SPHERE_PDF, any_direction, any_directions, disk_pdf};
use super::tree::Outline;
use super::{EmissionSample, Emits, MetEmission, Source};

impl Environment {
    /// What comes from a direction, over the mean.
    fn share(&self, direction: Vec3) -> f32 {
        (1.0 + self.gradient.dot(direction)).max(0.0)
    }
}

impl Emits for Environment {
    const DELTA: bool = false;

    fn record(&self, shapes: &Shapes, probability: f32) -> Own {
        let [x, y, z] = self.gradient.to_array();
        own([probability * SPHERE_PDF * disk_pdf(shapes), x, y, z])
    }

    #[inline(always)]
    fn choose<const N: usize>(
        (&[emission_pdf, x, y, z, ..], _): (&OwnLanes, &Tables),
        _: Vector<F32s>,
        radiance: [F32s; N],
        chance: F32s,
        u: [F32s; 2],
    ) -> DirectLanes<N> {
        let densities = [chance * F32s::splat(SPHERE_PDF), emission_pdf];
        let direction = any_directions(u);
        let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
        let share = (one + Vector::new(x, y, z).dot(direction)).max(zero);
        infinity::choose::<Self, N>(direction, radiance.map(|it| it * share), densities)
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

    fn share_of_sky(&self) -> Option<f64> {
        Some(1.0)
    }

    fn emit<const N: usize>(
        &self,
        source: &Source<N>,
        u_position: [f32; 2],
        u_direction: [f32; 2],
    ) -> EmissionSample<N> {
        let direction = -any_direction(u_direction);
        let radiance = source.radiance.map(|it| it * self.share(-direction));
        let source = Source { radiance, ..*source };
        infinity::emit::<Self, N>(&source, (direction, SPHERE_PDF), u_position)
    }

    fn met<const N: usize>(
        &self,
        source: &Source<N>,
        _: Vec3,
        direction: Vec3,
    ) -> Option<MetEmission<N>> {
        Some(MetEmission {
            radiance: source.radiance.map(|it| it * self.share(direction)),
            density: None,
            emission_pdf: source.probability * SPHERE_PDF * disk_pdf(source.shapes),
            cos_at_light: 1.0,
            normal: Vec3::ZERO,
        })
    }
}
