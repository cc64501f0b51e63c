//! The smooth metal under a thin film, whose reflections interfere.

use super::film::FilmRow;
use super::model::{Choice, Incidence, OneOfTwo, Scattered, Specular, Surface, reflect, strongest};
use crate::math::F32s;
use crate::polarization::{Block, s_axis};
use crate::scattering::side::Side;
use crate::scene::world::ThinFilm;

/// The index of refraction n - i k relative to vacuum, and the film.
#[derive(Clone, Copy, Debug)]
pub struct FilmedConductor<const N: usize> {
    /// Real part n > 0.
    eta: [f32; N],
    /// Extinction coefficient k >= 0.
    k: [f32; N],
    film: FilmRow<N>,
}

impl<const N: usize> FilmedConductor<N> {
    /// With the real part `eta` of the index of refraction, its extinction coefficient, and a film.
    pub fn of(eta: [f32; N], k: [f32; N], film: ThinFilm<[f32; N]>) -> Self {
        Self { eta, k, film: FilmRow::of(film) }
    }
}

impl<const N: usize> Surface for FilmedConductor<N> {
    fn scattered(&self) -> f32 {
        let reflectance = |n: usize| {
            let index = [self.eta[n], self.k[n]].map(F32s::splat);
            let [reflectance, ..] = self.film.at(n).on_metal(F32s::ONE, index).0.to_array();
            reflectance
        };
        strongest::<N>(std::array::from_fn(reflectance))
    }
}

impl<const N: usize> Specular<N> for FilmedConductor<N> {
    type Kernel = Block<F32s>;
    const ACHROMATIC: bool = false;

    #[inline(always)]
    fn scatter<const POLARIZED: bool>(
        at: &Incidence<Self>,
        _choose: impl FnOnce(OneOfTwo) -> Choice,
        _side: Side,
    ) -> Scattered<N, Self::Kernel> {
        let direction = reflect(at.direction, at.normal);
        let faces = at.front | at.two_sided;
        let stays = at.stays(direction);
        let mut weight = [F32s::splat(0.0); N];
        let mut kernels = [Block::identity(); N];
        for (n, (weight, kernel)) in weight.iter_mut().zip(&mut kernels).enumerate() {
            let eta = at.models.field(|model| model.eta[n]);
            let k = at.models.field(|model| model.k[n]);
            let film = FilmRow::lanes(&at.models, |model| &model.film, n);
            let (reflectance, block) = film.on_metal(at.cos_i, [eta, k]);
            *kernel = block;
            *weight = faces & stays & reflectance;
        }
        let axis = if POLARIZED { s_axis(at.normal, at.direction) } else { direction };
        Scattered { direction, weight, kernels, axis, alone: F32s::splat(0.0) }
    }
}
