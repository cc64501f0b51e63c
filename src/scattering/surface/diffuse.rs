//! The Lambertian reflector: an ideal depolarizer, so it needs no kernel and no frame.

use std::f32::consts::FRAC_1_PI;

use super::facing::Facing;
use super::model::{Connecting, Drawn, LaneRows, ModelLanes, Surface, strongest};
use crate::math::{F32s, Vector, warp};
use crate::scattering::event::Depolarizer;
use crate::scattering::side::Side;

/// Whose color it is.
#[derive(Clone, Copy, Debug)]
pub struct Diffuse<const N: usize> {
    /// Directional-hemispherical reflectance, within [0, 1].
    reflectance: [f32; N],
}

impl<const N: usize> Diffuse<N> {
    /// With the directional-hemispherical reflectance.
    pub fn of(reflectance: [f32; N]) -> Self {
        Self { reflectance }
    }
}

impl<const N: usize> Surface for Diffuse<N> {
    fn scattered(&self) -> f32 {
        strongest(self.reflectance)
    }
}

impl<const N: usize> Connecting<N> for &[Diffuse<N>] {
    type Kernel = Depolarizer;
    const ACHROMATIC: bool = true;
    const IS_EVEN: bool = true;
    type Lanes = ();

    #[inline(always)]
    fn factor(self, rows: &LaneRows) -> [F32s; N] {
        let mut factor = reflectance(self, rows);
        factor.iter_mut().for_each(|factor| *factor *= F32s::splat(FRAC_1_PI));
        factor
    }

    #[inline(always)]
    fn lanes(self, _rows: &LaneRows) {}

    #[inline(always)]
    fn shape(
        _of: &(),
        _facing: &Facing,
        _given: Vector<F32s>,
        _drawn: Vector<F32s>,
        _side: Side,
    ) -> [F32s; N] {
        [F32s::splat(1.0); N]
    }

    #[inline(always)]
    fn pdf(_of: &(), facing: &Facing, _given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
        warp::cosine_pdf(drawn.dot(facing.shading).abs())
    }

    #[inline(always)]
    fn draw(
        self,
        (rows, _of): (&LaneRows, &()),
        facing: &Facing,
        given: Vector<F32s>,
        [first, second, _]: [F32s; 3],
        _side: Side,
    ) -> Drawn<N> {
        let normal = facing.shading_towards(given);
        let (direction, cosine) = warp::cosine_hemisphere(normal, [first, second]);
        let (pdf, weight) = (warp::cosine_pdf(cosine), reflectance(self, rows));
        Drawn { direction, pdf, weight, lost: F32s::ZERO }
    }

    #[inline(always)]
    fn kernels(
        _of: &(),
        _facing: &Facing,
        k_in: Vector<F32s>,
        _k_out: Vector<F32s>,
    ) -> ([Depolarizer; N], Vector<F32s>) {
        ([Depolarizer; N], k_in.any_perpendicular())
    }
}

#[inline(always)]
fn reflectance<const N: usize>(table: &[Diffuse<N>], rows: &LaneRows) -> [F32s; N] {
    ModelLanes::new(table, *rows).spectrum(|model| &model.reflectance)
}
