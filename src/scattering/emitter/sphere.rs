//! Emitting spheres.

use glam::Vec3;

use crate::math::{F32s, Vector};
use crate::scattering::immersion::spread;
use crate::scene::baked::Shapes;
use crate::scene::emitter::Sphere;

use super::area::{self, Area};
use super::direct::{DirectLanes, Own, OwnLanes, own};
use super::infinity::{any_direction, any_directions};
use super::{EmissionSample, Emits, MetEmission, Source};

/// Points on a sphere where its media are looked for.
const PLACES: usize = 128;

impl Emits for Sphere {
    const DELTA: bool = false;

    fn record(&self, shapes: &Shapes, _: f32) -> Own {
        let sphere = self.shape(shapes);
        let [x, y, z] = sphere.center.to_array();
        own([x, y, z, sphere.radius, 1.0 / self.area])
    }

    #[inline(always)]
    fn choose<const N: usize>(
        &[x, y, z, radius, per_area, ..]: &OwnLanes,
        reference: Vector<F32s>,
        radiance: [F32s; N],
        probability: F32s,
        u: [F32s; 2],
    ) -> DirectLanes<N> {
        let normal = any_directions(u);
        let point = normal.mul_add(radius, Vector::new(x, y, z));
        let one_side = F32s::splat(0.0);
        area::choose::<Self, N>(
            (point, normal),
            reference,
            radiance,
            probability * per_area,
            one_side,
        )
    }

    fn emit<const N: usize>(
        &self,
        source: &Source<N>,
        u_position: [f32; 2],
        u_direction: [f32; 2],
    ) -> EmissionSample<N> {
        let sphere = self.shape(source.shapes);
        let normal = any_direction(u_position);
        let point = sphere.center + normal * sphere.radius;
        area_of(self).emit::<Self, N>(source, (point, normal), u_direction)
    }

    fn met<const N: usize>(
        &self,
        source: &Source<N>,
        position: Vec3,
        direction: Vec3,
    ) -> Option<MetEmission<N>> {
        let outwards = source.shapes.geometric_normal(self.primitive, position);
        area_of(self).met(source, -direction.dot(outwards))
    }

    fn reach(&self, shapes: &Shapes) -> f32 {
        let sphere = self.shape(shapes);
        sphere.center.abs().max_element() + sphere.radius
    }

    fn primitive(&self) -> u32 {
        self.primitive
    }

    fn places(&self, shapes: &Shapes) -> Vec<(Vec3, Vec3)> {
        let sphere = self.shape(shapes);
        spread(PLACES).map(|normal| (sphere.center + normal * sphere.radius, normal)).collect()
    }
}

/// The area that emits.
fn area_of(sphere: &Sphere) -> Area {
    Area { area: sphere.area, two_sided: false }
}
