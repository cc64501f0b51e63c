//! Directional lights: parallel light, as the sun's nearly is.

use glam::Vec3;

use crate::math::{F32s, Vector};
use crate::scene::baked::{Bounds, Shapes};
use crate::scene::emitter::Directional;

use super::direct::{DirectLanes, Own, OwnLanes, Tables, own};
use super::infinity::{self, disk_pdf};
use super::tree::Outline;
use super::{EmissionSample, Emits, Source};

impl Emits for Directional {
    const DELTA: bool = true;

    fn record(&self, shapes: &Shapes, probability: f32) -> Own {
        let [x, y, z] = (-self.direction).to_array();
        own([x, y, z, probability * disk_pdf(shapes)])
    }

    #[inline(always)]
    fn choose<const N: usize>(
        (&[x, y, z, emission_pdf, ..], _): (&OwnLanes, &Tables),
        _: Vector<F32s>,
        radiance: [F32s; N],
        chance: F32s,
        _: [F32s; 2],
    ) -> DirectLanes<N> {
        infinity::choose::<Self, N>(Vector::new(x, y, z), radiance, [chance, emission_pdf])
    }

    fn density(&self, _: &Shapes, _: Vec3, _: Vec3, _: Vec3) -> f32 {
        1.0
    }

    fn outline(&self, _: &Shapes) -> Outline {
        Outline { axis: -self.direction, ..Outline::at(Vec3::ZERO) }
    }

    fn gain_of_aim(&self, shapes: &Shapes, ball: &Bounds) -> Option<f32> {
        infinity::gain_of_aim(shapes, ball)
    }

    fn emit<const N: usize>(
        &self,
        source: &Source<N>,
        u_position: [f32; 2],
        _: [f32; 2],
    ) -> EmissionSample<N> {
        infinity::emit::<Self, N>(source, (self.direction, 1.0), u_position)
    }
}
