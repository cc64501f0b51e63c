//! The environment by a picture: directions are drawn by how bright they are. What comes from where
//! is looked up where it is met, or needed (`painting`); elsewhere stands its mean.

use glam::Vec3;

use crate::math::{F32s, Vector};
use crate::scene::baked::{Bounds, Shapes};
use crate::scene::emitter::Panorama;

use super::direct::{DirectLanes, Own, OwnLanes, Tables, own};
use super::infinity::{self, disk_pdf};
use super::tree::Outline;
use super::{EmissionSample, Emits, MetEmission, Source};

impl Emits for Panorama {
    const DELTA: bool = false;

    fn record(&self, shapes: &Shapes, probability: f32) -> Own {
        own([probability * disk_pdf(shapes)])
    }

    #[inline(always)]
    fn choose<const N: usize>(
        (&[start_pdf, ..], tables): (&OwnLanes, &Tables),
        _: Vector<F32s>,
        radiance: [F32s; N],
        chance: F32s,
        u: [F32s; 2],
    ) -> DirectLanes<N> {
        let (direction, pdf) = draw(tables, u);
        infinity::choose::<Self, N>(direction, radiance, [chance * pdf, start_pdf * pdf])
    }

    fn density(&self, _: &Shapes, _: Vec3, _: Vec3, direction: Vec3) -> f32 {
        self.pdf(direction)
    }

    fn outline(&self, _: &Shapes) -> Outline {
        // Exact for a sky that is the same everywhere and for a single point of light, and the
        // slope is that of the first spherical harmonics about the former.
        let middle = self.middle();
        let one_sided = middle.length();
        Outline {
            even: std::f32::consts::PI * (1.0 - one_sided),
            axis: middle * (2.0 * std::f32::consts::PI * (1.0 + one_sided)),
            ..Outline::at(Vec3::ZERO)
        }
    }

    fn gain_of_aim(&self, shapes: &Shapes, ball: &Bounds) -> Option<f32> {
        infinity::gain_of_aim(shapes, ball)
    }

    fn share_of_sky(&self) -> Option<f64> {
        Some(self.spread())
    }

    fn emit<const N: usize>(
        &self,
        source: &Source<N>,
        u_position: [f32; 2],
        u_direction: [f32; 2],
    ) -> EmissionSample<N> {
        let (direction, pdf) = self.draw(u_direction);
        infinity::emit::<Self, N>(source, (-direction, pdf), u_position)
    }

    fn met<const N: usize>(
        &self,
        source: &Source<N>,
        _: Vec3,
        direction: Vec3,
    ) -> Option<MetEmission<N>> {
        let (radiance, pdf) = self.seen(direction, source.carried);
        // Where nothing is drawn it is black.
        (pdf > 0.0).then(|| MetEmission {
            radiance,
            density: Some(pdf),
            emission_pdf: source.probability * pdf * disk_pdf(source.shapes),
            cos_at_light: 1.0,
            normal: Vec3::ZERO,
        })
    }
}

/// Eight directions, with their densities per steradian.
// Once for all colors.
#[inline(never)]
fn draw(tables: &Tables, u: [F32s; 2]) -> (Vector<F32s>, F32s) {
    let Some(panorama) = &tables.panorama else {
        unreachable!("there is an emitter of this model");
    };
    panorama.draw_lanes(u)
}
