//! What the models of surfaces under a film have in common.

use super::model::ModelLanes;
use crate::math::{F32s, Real};
use crate::polarization::{Block, Film, Filmed, film};
use crate::scene::world::ThinFilm;

/// A film at every wavelength.
#[derive(Clone, Copy, Debug)]
pub struct FilmRow<const N: usize>(ThinFilm<[f32; N]>);

/// A film on some surfaces, and the share of them that it covers: of the rest, what a film of no
/// thickness does.
#[derive(Clone, Copy, Debug)]
pub struct Covering<F> {
    /// The film.
    pub film: Film<F>,
    /// Within [0, 1].
    pub share: F,
}

impl<const N: usize> FilmRow<N> {
    /// That of a material.
    pub fn of(film: ThinFilm<[f32; N]>) -> Self {
        Self(film)
    }

    /// At a wavelength.
    pub fn at(&self, n: usize) -> Covering<F32s> {
        let ThinFilm { eta, k, thickness, spread, portion, share, portions: _ } = &self.0;
        let [eta, k, spread] = [eta, k, spread].map(|of| F32s::splat(of[n]));
        let waves = F32s::splat(thickness[n] * portion);
        Covering { film: Film { eta, k, waves, spread }, share: F32s::splat(*share) }
    }

    /// Those of eight rows at a wavelength.
    #[inline(always)]
    pub fn lanes<M>(
        models: &ModelLanes<M>,
        film: impl Fn(&M) -> &Self + Copy,
        n: usize,
    ) -> Covering<F32s> {
        let field =
            |of: fn(&ThinFilm<[f32; N]>, usize) -> f32| models.field(|model| of(&film(model).0, n));
        Covering {
            film: Film {
                eta: field(|film, n| film.eta[n]),
                k: field(|film, n| film.k[n]),
                waves: field(|film, n| film.thickness[n] * film.portion),
                spread: field(|film, n| film.spread[n]),
            },
            share: field(|film, _| film.share),
        }
    }
}

impl Covering<F32s> {
    /// The same film of no thickness, if any of the surfaces is not covered by it.
    #[inline(always)]
    fn bare(&self) -> Option<Film<F32s>> {
        let is_bare = self.share.simd_lt(F32s::ONE).any();
        is_bare.then_some(Film { waves: F32s::ZERO, ..self.film })
    }

    /// `M00`, and the kernel relative to it, of what is covered and what is not.
    #[inline(always)]
    fn mixed(
        &self,
        (covered, block): (F32s, Block<F32s>),
        (bare, bare_block): (F32s, Block<F32s>),
    ) -> (F32s, Block<F32s>) {
        let (first, second) = (self.share * covered, (F32s::ONE - self.share) * bare);
        let m00 = first + second;
        let part = Real::select(m00.simd_gt(F32s::ZERO), first / m00, F32s::ONE);
        // What is covered throughout is as if no other were there.
        let mix = |of: F32s, other: F32s| {
            let mixed = part.mul_add(of - other, other);
            Real::select(self.share.simd_ge(F32s::ONE), of, mixed)
        };
        let block = Block {
            a: mix(block.a, bare_block.a),
            c: mix(block.c, bare_block.c),
            s: mix(block.s, bare_block.s),
        };
        (m00, block)
    }

    /// [`film::filmed_conductor`] of them: one copy for all models, colors and modes.
    #[inline(never)]
    pub fn on_metal(&self, cos_i: F32s, index: [F32s; 2]) -> (F32s, Block<F32s>) {
        let covered = metal(cos_i, &self.film, index);
        match self.bare() {
            Some(bare) => self.mixed(covered, metal(cos_i, &bare, index)),
            None => covered,
        }
    }

    /// [`film::filmed_dielectric`] of them: one copy for all models, colors and modes.
    #[inline(never)]
    pub fn on_glass(&self, cos_i: F32s, indices: [F32s; 2]) -> Filmed<F32s> {
        let of = glass(cos_i, &self.film, indices);
        let Some(bare) = self.bare() else { return of };
        let bare = glass(cos_i, &bare, indices);
        let (reflectance, reflection) =
            self.mixed((of.reflectance, of.reflection), (bare.reflectance, bare.reflection));
        let (transmittance, transmission) = self
            .mixed((of.transmittance, of.transmission), (bare.transmittance, bare.transmission));
        Filmed { reflectance, reflection, transmittance, transmission, cos_t: of.cos_t }
    }
}

#[inline(never)]
fn metal(cos_i: F32s, film: &Film<F32s>, index: [F32s; 2]) -> (F32s, Block<F32s>) {
    film::filmed_conductor(cos_i, film, index)
}

#[inline(never)]
fn glass(cos_i: F32s, film: &Film<F32s>, indices: [F32s; 2]) -> Filmed<F32s> {
    film::filmed_dielectric(cos_i, film, indices)
}
