//! What of a rough surface under a film follows from its parameters.

use std::f32::consts::FRAC_1_PI;

use super::{BASE, COAT, FILM, Fixed, INDEX, SEVERAL};
use crate::math::F32s;
use crate::polarization::albedo::{Angles, POWERS, mean_over_cosines};
use crate::polarization::{Albedo, CoatAlbedo, Distribution, Film, Filmed};
use crate::scattering::surface::film::Covering;
use crate::scattering::surface::metallic_roughness::THROUGH_MIN;
use crate::scattering::surface::rough::{Reflected, TINY};
use crate::scattering::surface::rough_dielectric::{OfSide, SIDES, sides};
use crate::scene::world::Grain;

impl Fixed {
    /// Facets that reflect nothing, of this roughness across what a grain says, under a film that
    /// covers a share.
    pub fn bare(grain: Option<&Grain>, across: f32, share: f32) -> Self {
        let none = OfSide { terms: [0.0; _], through: 0.0, back: 0.0, beyond: 0.0 };
        let nothing = Albedo { terms: [0.0; _], mean: 1.0 };
        Self {
            is_glass: false,
            along: grain.map(|grain| grain.place),
            alpha: grain.map_or([across; 2], |grain| grain.alphas(across)),
            beckmann: 0.0,
            share,
            metallic: 0.0,
            coat: 0.0,
            indices: [1.0; 2],
            of_facets: nothing,
            of_coat: [0.0; POWERS],
            color: 0.0,
            single: 0.0,
            multiple: 0.0,
            sides: [none; SIDES],
            scattered: 1.0,
        }
    }

    /// The root mean square of the roughness along the grain and across.
    pub fn alpha_mean(&self) -> f32 {
        let [along, across] = self.alpha;
        if along == across {
            return across;
        }
        (0.5 * (along * along + across * across)).sqrt()
    }

    fn be_of(&mut self, distribution: Distribution) {
        self.of_facets = Albedo::of_facets(distribution, self.alpha_mean());
        self.beckmann = if distribution == Distribution::Beckmann { 1.0 } else { 0.0 };
    }
}

/// A row in the making, of any number of wavelengths.
pub struct Making<'a> {
    /// What is the same at all wavelengths.
    pub fixed: &'a mut Fixed,
    /// The rest, spectrum by spectrum.
    pub spectra: &'a mut [f32],
    /// How many there are.
    pub wavelengths: usize,
}

impl Making<'_> {
    fn at(&mut self, which: usize, n: usize) -> &mut f32 {
        &mut self.spectra[which * self.wavelengths + n]
    }

    fn film(&self, n: usize) -> Covering<F32s> {
        let of = |which: usize| F32s::splat(self.spectra[(FILM + which) * self.wavelengths + n]);
        let film = Film { eta: of(0), k: of(1), waves: of(2), spread: of(3) };
        Covering { film, share: F32s::splat(self.fixed.share) }
    }

    /// A share of metal of the index of refraction that is there already.
    pub fn metal(&mut self, share: f32, (distribution, is_given_back): (Distribution, bool)) {
        self.fixed.be_of(distribution);
        self.fixed.metallic = share;
        let (once, part) = (self.fixed.of_facets.mean, share / self.wavelengths as f32);
        self.fixed.scattered = 0.0;
        for n in 0..self.wavelengths {
            let film = self.film(n);
            let index = [0, 1].map(|of| F32s::splat(*self.at(INDEX + of, n)));
            let mean = mean_over_cosines(|cos| film.on_metal(cos, index).0);
            let of_facets = &self.fixed.of_facets;
            let Reflected { gain: [gain], single: [single], multiple: [multiple] } =
                Reflected::of_means([mean], of_facets, is_given_back);
            *self.at(SEVERAL, n) = share * gain;
            self.fixed.single += part * single;
            self.fixed.multiple += part * multiple;
            let scattered = share * (single * once + multiple * (1.0 - once));
            self.fixed.scattered = self.fixed.scattered.max(scattered);
        }
    }

    /// A base of the color that is there already, under a coat of which a share is there, where
    /// there is no metal.
    pub fn coat(&mut self, specular: f32, ior: f32) {
        let plain = 1.0 - self.fixed.metallic;
        let alpha = self.fixed.alpha_mean();
        let index = [ior, 0.0].map(F32s::splat);
        let (mut scattered, part) = (0.0_f32, 1.0 / self.wavelengths as f32);
        for n in 0..self.wavelengths {
            let film = self.film(n);
            let reflectance = Angles::sampled(|cos| film.on_metal(cos, index).0);
            let coat = CoatAlbedo::of_any(Distribution::Ggx, &reflectance, alpha).scaled(specular);
            for (power, term) in coat.reflected.into_iter().enumerate() {
                *self.at(COAT + power, n) = term;
                self.fixed.of_coat[power] += part * term;
            }
            let color = plain * *self.at(BASE, n);
            self.fixed.color += part * color;
            *self.at(BASE, n) = color * FRAC_1_PI / (1.0 - coat.mean).max(THROUGH_MIN);
            scattered = scattered.max(plain * coat.mean + color * (1.0 - coat.mean));
        }
        self.fixed.scattered = (self.fixed.scattered + scattered).min(1.0);
        self.fixed.indices = [1.0, ior];
        self.fixed.coat = plain * specular;
    }

    /// Glass between two indices of refraction, before and behind the front.
    pub fn glass(
        &mut self,
        indices: [f32; 2],
        (distribution, is_given_back): (Distribution, bool),
    ) {
        self.fixed.be_of(distribution);
        self.fixed.is_glass = true;
        self.fixed.indices = indices;
        let relative = indices[1] / indices[0];
        let lower = usize::from(relative < 1.0);
        let reflectance = Angles::sampled(|cos| self.reflected(lower, cos));
        let alpha = self.fixed.alpha_mean();
        let albedos = [relative, 1.0 / relative]
            .map(|ior| Albedo::of_any_glass(distribution, (ior, &reflectance), alpha));
        let of_side = |_: f32, side: usize| mean_over_cosines(|cos| self.reflected(side, cos));
        self.fixed.sides = sides(relative, (&albedos, is_given_back), of_side);
        let missing = 1.0 - 0.5 * (albedos[0].mean + albedos[1].mean);
        for n in 0..self.wavelengths {
            let of_side = |side| mean_over_cosines(|cos| self.leaves(side, n, cos)[0]);
            let left = (0.5 * (of_side(0) + of_side(1))).min(1.0);
            *self.at(SEVERAL, n) = left * left * (1.0 - missing) / (1.0 - left * missing);
        }
    }

    /// What leaves glass of light on a side at a wavelength, and the share of it that is reflected.
    fn leaves(&self, side: usize, n: usize, cos: F32s) -> [F32s; 2] {
        let indices = self.fixed.indices;
        let around = [indices[side], indices[1 - side]].map(F32s::splat);
        let Filmed { reflectance, transmittance, .. } = self.film(n).on_glass(cos, around);
        let leaves = reflectance + transmittance;
        [leaves, reflectance / leaves.fast_max(F32s::splat(TINY))]
    }

    /// The mean of that share over the wavelengths.
    fn reflected(&self, side: usize, cos: F32s) -> F32s {
        let of = (0..self.wavelengths).map(|n| self.leaves(side, n, cos)[1]);
        let sum = of.fold(F32s::ZERO, |sum, of| sum + of);
        sum * F32s::splat(1.0 / self.wavelengths as f32)
    }
}
