//! What the models of surfaces under a film have in common.

use super::model::ModelLanes;
use crate::math::F32s;
use crate::polarization::Film;
use crate::scene::world::ThinFilm;

/// A film at every wavelength.
#[derive(Clone, Copy, Debug)]
pub struct FilmRow<const N: usize>(ThinFilm<[f32; N]>);

impl<const N: usize> FilmRow<N> {
    /// That of a material.
    pub fn of(film: ThinFilm<[f32; N]>) -> Self {
        Self(film)
    }

    /// At a wavelength.
    pub fn at(&self, n: usize) -> Film<f32> {
        let ThinFilm { eta, k, thickness, spread } = &self.0;
        Film { eta: eta[n], k: k[n], waves: thickness[n], spread: spread[n] }
    }

    /// Those of eight rows at a wavelength.
    #[inline(always)]
    pub fn lanes<M>(
        models: &ModelLanes<M>,
        film: impl Fn(&M) -> &Self + Copy,
        n: usize,
    ) -> Film<F32s> {
        Film {
            eta: models.field(|model| film(model).0.eta[n]),
            k: models.field(|model| film(model).0.k[n]),
            waves: models.field(|model| film(model).0.thickness[n]),
            spread: models.field(|model| film(model).0.spread[n]),
        }
    }
}
