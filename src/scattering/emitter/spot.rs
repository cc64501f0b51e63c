//! Spots: points whose light falls off from an axis, as KHR_lights_punctual recommends: with the
//! square of a ramp in the cosine.

use glam::Vec3;

use crate::math::elementary::acos;
use crate::math::{F32s, Vector};
use crate::scene::baked::{Bounds, Shapes};
use crate::scene::emitter::Spot;

use super::direct::{DirectLanes, Own, OwnLanes, Tables, own};
use super::point::{self, cone_about, cone_pdf, direction_of_path};
use super::tree::Outline;
use super::{EmissionSample, Emits, Source};

impl Emits for Spot {
    const DELTA: bool = true;

    fn record(&self, _: &Shapes, probability: f32) -> Own {
        let [x, y, z] = self.position.to_array();
        let [dx, dy, dz] = self.direction.to_array();
        let emission_pdf = probability * cone_pdf(self.cos_outer);
        own([x, y, z, dx, dy, dz, self.cos_inner, self.cos_outer, emission_pdf])
    }

    #[inline(always)]
    fn choose<const N: usize>(
        (&[x, y, z, dx, dy, dz, inner, outer, emission_pdf, ..], _): (&OwnLanes, &Tables),
        reference: Vector<F32s>,
        radiance: [F32s; N],
        chance: F32s,
        _: [F32s; 2],
    ) -> DirectLanes<N> {
        let densities = [chance, emission_pdf];
        let mut lanes =
            point::choose::<Self, N>(Vector::new(x, y, z), reference, radiance, densities);
        let ramp = (-lanes.direction.dot(Vector::new(dx, dy, dz)) - outer) / (inner - outer);
        let ramp = ramp.max(F32s::splat(0.0)).min(F32s::splat(1.0));
        lanes.radiance = radiance.map(|intensity| intensity * (ramp * ramp));
        lanes
    }

    fn density(&self, _: &Shapes, _: Vec3, _: Vec3, _: Vec3) -> f32 {
        1.0
    }

    fn outline(&self, _: &Shapes) -> Outline {
        let edge = self.cos_outer;
        Outline { axis: self.direction, edge, ..Outline::at(self.position) }
    }

    fn gain_of_aim(&self, _: &Shapes, ball: &Bounds) -> Option<f32> {
        let cone = cone_about(self.position, ball)?;
        let between = acos(self.direction.dot(cone.axis).clamp(-1.0, 1.0));
        let reach = acos(self.cos_outer) + acos(cone.cos_edge());
        cone.gain(self.cos_outer).filter(|_| between < reach)
    }

    fn emit<const N: usize>(
        &self,
        source: &Source<N>,
        _: [f32; 2],
        u_direction: [f32; 2],
    ) -> EmissionSample<N> {
        let cone = (self.direction, self.cos_outer);
        let direction = direction_of_path(source, self.position, cone, u_direction);
        let cosine = direction.dot(self.direction);
        let ramp = (cosine - self.cos_outer) / (self.cos_inner - self.cos_outer);
        let ramp = ramp.clamp(0.0, 1.0);
        let falloff = ramp * ramp;
        let intensity = source.radiance.map(|intensity| intensity * falloff);
        point::emit::<Self, N>(
            source,
            self.position,
            direction,
            intensity,
            cone_pdf(self.cos_outer),
        )
    }

    fn places(&self, _: &Shapes) -> Vec<(Vec3, Vec3)> {
        vec![(self.position, Vec3::ZERO)]
    }
}
