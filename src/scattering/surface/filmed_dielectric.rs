//! The smooth boundary of glass or water under a thin film: reflects or refracts, and what the
//! film's faces do interferes.

use super::film::FilmRow;
use super::model::{Choice, Incidence, OneOfTwo, Scattered, Specular, Surface, reflect, refract};
use crate::math::{F32s, Real, Vector};
use crate::polarization::{Block, Filmed, s_axis};
use crate::scattering::side::Side;
use crate::scene::world::ThinFilm;

/// Without dispersion of the glass: all wavelengths go the same ways. Its index on both sides is
/// its own, whatever it touches.
#[derive(Clone, Copy, Debug)]
pub struct FilmedDielectric<const N: usize> {
    /// Indices of refraction before and behind the front, greater than 0.
    indices: [f32; 2],
    film: FilmRow<N>,
}

impl<const N: usize> FilmedDielectric<N> {
    /// With the indices of refraction behind and before the front, and a film.
    pub fn of(ior: f32, exterior_ior: f32, film: ThinFilm<[f32; N]>) -> Self {
        Self { indices: [exterior_ior, ior], film: FilmRow::of(film) }
    }
}

impl<const N: usize> Surface for FilmedDielectric<N> {
    fn scattered(&self) -> f32 {
        1.0
    }
}

impl<const N: usize> Specular<N> for FilmedDielectric<N> {
    type Kernel = Block<F32s>;
    const ACHROMATIC: bool = false;

    /// Of two ways, one is drawn by the mean reflectance of all wavelengths.
    #[inline(always)]
    fn scatter<const POLARIZED: bool>(
        at: &Incidence<Self>,
        choose: impl FnOnce(OneOfTwo) -> Choice,
        side: Side,
    ) -> Scattered<N, Self::Kernel> {
        let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
        let [front, back] = [0, 1].map(|of| at.models.field(|model| model.indices[of]));
        let before = Real::select(at.front, front, back);
        let behind = Real::select(at.front, back, front);
        let film_at = |n| FilmRow::lanes(&at.models, |model| &model.film, n);
        let first = film_at(0).on_glass(at.cos_i, [before, behind]);
        let mut all = [first; N];
        for (n, filmed) in all.iter_mut().enumerate().skip(1) {
            *filmed = film_at(n).on_glass(at.cos_i, [before, behind]);
        }
        let mut sums = [zero; 2];
        for Filmed { reflectance, reflection, .. } in &all {
            sums = [sums[0] + *reflectance, reflectance.mul_add(reflection.a, sums[1])];
        }
        let share = sums[0] * F32s::splat(1.0 / N as f32);
        let diattenuation = Real::select(sums[0].simd_gt(zero), sums[1] / sums[0], zero);
        let axis = if POLARIZED { s_axis(at.normal, at.direction) } else { at.direction };
        let Choice { first: reflects, gain } = choose(OneOfTwo { share, diattenuation, axis });
        let eta = behind / before;
        let reflected = reflect(at.direction, at.normal);
        let refracted = refract(at.direction, at.normal, at.cos_i, first.cos_t, eta);
        let direction = Vector::select(reflects, reflected, refracted);
        // Radiance grows with the square of the index; importance, and power, do not.
        let squeeze = match side {
            Side::Sensor => one / (eta * eta),
            Side::Light => one,
        };
        let consistent = !(at.stays(direction) ^ reflects);
        let mut weight = [zero; N];
        let mut kernels = [Block::identity(); N];
        for (filmed, (weight, kernel)) in all.iter().zip(weight.iter_mut().zip(&mut kernels)) {
            let of_reflected = filmed.reflectance / share;
            let of_refracted = squeeze * (filmed.transmittance / (one - share));
            let of_way = Real::select(reflects, of_reflected, of_refracted);
            *weight = consistent & (of_way / gain);
            *kernel = Block::select(reflects, filmed.reflection, filmed.transmission);
        }
        Scattered { direction, weight, kernels, axis, alone: zero }
    }
}
