//! Rough surfaces under a thin film: metal, glass, and glTF's metallic-roughness, whose facets
//! reflect and refract as smooth surfaces under the film do.
//!
//! They are the models of [`super::rough_conductor`], [`super::rough_dielectric`] and
//! [`super::metallic_roughness`] with other facets, which may be stretched as those of
//! [`super::brushed`]. What several facets scatter is given back as there, with the film in the
//! means: of metal, the mean reflectance over the hemisphere at each wavelength; of a coat, its
//! albedo at each wavelength, which the base lies under ([`Angles`]); of glass, the albedo of the
//! mean reflectance of all wavelengths, and of a film that absorbs what that leaves of light which
//! meets several facets.
//!
//! A film costs more than all else about such a surface, so that this is compiled once for any
//! number of wavelengths, and for all of these models.

use std::f32::consts::FRAC_1_PI;

use super::facing::Facing;
use super::film::{Covering, FilmRow};
use super::glossy::{Glossy, Lobes};
use super::metallic_roughness::THROUGH_MIN;
use super::model::{Drawn, ModelLanes, Surface, strongest};
use super::rough::{FacetLobe, Grazing, Mixture, PDF_MIN, Reflected, TINY, choose, is_above, peak};
use super::rough_dielectric::{self, OfSide, SIDES, sides};
use crate::math::{F32s, LANES, Real, Vector, lanes, warp};
use crate::polarization::albedo::{Angles, POWERS, mean_over_cosines};
use crate::polarization::{
    Albedo, Block, CoatAlbedo, Distribution, FacetReflection, FacetRefraction, Facets, Film,
    Filmed as FilmedFace, SpheroidBlock, Stretched, fresnel, s_axis,
};
use crate::scattering::event::{Elements, Form};
use crate::scattering::side::Side;
use crate::scattering::vertex::Kernels;
use crate::scene::world::{Grain, SurfaceModel, ThinFilm};

/// One material, where it is.
#[derive(Clone, Copy, Debug)]
pub struct Filmed<const N: usize> {
    fixed: Fixed,
    spectra: [[f32; N]; SPECTRA],
}

/// What is the same at all wavelengths.
#[derive(Clone, Copy, Debug)]
struct Fixed {
    /// Whether light is refracted; else there are a metal, a coat and a base.
    is_glass: bool,
    /// A unit vector along the surface, if facets are stretched.
    along: Option<[f32; 3]>,
    /// The roughness along it and across.
    alpha: [f32; 2],
    /// 1 for Beckmann's distribution, else 0.
    beckmann: f32,
    /// The share of the surface that the film covers.
    share: f32,
    /// Shares of metal, and of what the coat would reflect that there is.
    metallic: f32,
    coat: f32,
    /// Indices of refraction before and behind the front: of glass, or the coat's.
    indices: [f32; 2],
    /// What lossless facets reflect once.
    of_facets: Albedo,
    /// Means over the wavelengths: coefficients of what the coat reflects (see [`CoatAlbedo`]),
    of_coat: [f32; POWERS],
    /// what the base reflects, and the metal once and several times.
    color: f32,
    single: f32,
    multiple: f32,
    /// What glass gives back.
    sides: [OfSide; SIDES],
    /// See [`Surface::scattered`].
    scattered: f32,
}

/// Rows of [`Filmed::spectra`]: the film's eta, k, thickness in wavelengths and spread; the index
/// of the metal; the base over what the coat lets through; what several facets of metal reflect, or
/// what the film of glass leaves of that; and the coat.
const FILM: usize = 0;
const INDEX: usize = 4;
const BASE: usize = 6;
const SEVERAL: usize = 7;
const COAT: usize = 8;
const SPECTRA: usize = COAT + POWERS;

impl<const N: usize> Filmed<N> {
    /// Of a model under a film.
    #[allow(clippy::boxed_local, reason = "the list of models hands on what materials hold")]
    pub fn of(of: Box<SurfaceModel<[f32; N]>>, film: ThinFilm<[f32; N]>) -> Self {
        let grain = if let SurfaceModel::Brushed { grain, .. } = &*of { Some(grain) } else { None };
        let model = of.without_grain();
        let across = model.facets_alpha().copied().unwrap_or(1.0);
        let facets = Grained::of(grain, across);
        let mut filmed = Self::bare(&facets, &film);
        let films = |n: usize| FilmRow::of(film.clone()).at(n);
        if let SurfaceModel::RoughDielectric {
            ior,
            exterior_ior,
            distribution,
            multiple_scattering,
            ..
        } = model
        {
            let of_facets = (*distribution, facets.mean, *multiple_scattering);
            filmed.be_glass([exterior_ior[0], ior[0]], of_facets, films);
        } else if let SurfaceModel::RoughConductor {
            eta,
            k,
            distribution,
            multiple_scattering,
            ..
        } = model
        {
            filmed.be_of(*distribution, facets.mean);
            let scattered = filmed.add_metal([*eta, *k], (1.0, *multiple_scattering), films);
            filmed.fixed.scattered = strongest(scattered).min(1.0);
        } else if let SurfaceModel::MetallicRoughness {
            base_color,
            metallic,
            ior,
            specular,
            ..
        } = model
        {
            filmed.be_of(Distribution::Ggx, facets.mean);
            let k = base_color.map(fresnel::k_of_reflectance);
            let of_metal = filmed.add_metal([[1.0; N], k], (*metallic, true), &films);
            let of_coat = filmed.add_coat((base_color, *specular, *ior), facets.mean, films);
            let both = std::array::from_fn::<_, N, _>(|n| of_metal[n] + of_coat[n]);
            filmed.fixed.scattered = strongest(both).min(1.0);
        } else {
            unreachable!("worlds are checked: no other model has a film here")
        }
        filmed
    }

    /// Facets that reflect nothing.
    fn bare(facets: &Grained, film: &ThinFilm<[f32; N]>) -> Self {
        let mut spectra = [[0.0; N]; SPECTRA];
        spectra[FILM..INDEX].copy_from_slice(&[film.eta, film.k, film.thickness, film.spread]);
        spectra[FILM + 2].iter_mut().for_each(|thickness| *thickness *= film.portion);
        spectra[INDEX] = [1.0; N];
        let none = OfSide { terms: [0.0; _], through: 0.0, back: 0.0, beyond: 0.0 };
        let fixed = Fixed {
            is_glass: false,
            along: facets.along,
            alpha: facets.alpha,
            beckmann: 0.0,
            share: film.share,
            metallic: 0.0,
            coat: 0.0,
            indices: [1.0; 2],
            of_facets: Albedo::of_facets(Distribution::Ggx, facets.mean),
            of_coat: [0.0; POWERS],
            color: 0.0,
            single: 0.0,
            multiple: 0.0,
            sides: [none; SIDES],
            scattered: 1.0,
        };
        Self { fixed, spectra }
    }

    fn be_of(&mut self, distribution: Distribution, alpha: f32) {
        self.fixed.of_facets = Albedo::of_facets(distribution, alpha);
        self.fixed.beckmann = if distribution == Distribution::Beckmann { 1.0 } else { 0.0 };
    }

    /// A share of metal of an index of refraction; what it scatters.
    fn add_metal(
        &mut self,
        [eta, k]: [[f32; N]; 2],
        (share, is_given_back): (f32, bool),
        films: impl Fn(usize) -> Covering<F32s>,
    ) -> [f32; N] {
        let means = std::array::from_fn(|n| {
            let (film, index) = (films(n), [eta[n], k[n]].map(F32s::splat));
            mean_over_cosines(|cos| film.on_metal(cos, index).0)
        });
        let reflected = Reflected::of_means(means, &self.fixed.of_facets, is_given_back);
        self.spectra[INDEX..BASE].copy_from_slice(&[eta, k]);
        self.spectra[SEVERAL] = reflected.gain.map(|gain| share * gain);
        self.fixed.metallic = share;
        self.fixed.single = share * mean(&reflected.single);
        self.fixed.multiple = share * mean(&reflected.multiple);
        let (once, Reflected { single, multiple, .. }) = (self.fixed.of_facets.mean, reflected);
        std::array::from_fn(|n| share * (single[n] * once + multiple[n] * (1.0 - once)))
    }

    /// A base of a color under a coat of which a share is there, where there is no metal; what they
    /// scatter.
    fn add_coat(
        &mut self,
        (color, specular, ior): (&[f32; N], f32, f32),
        alpha: f32,
        films: impl Fn(usize) -> Covering<F32s>,
    ) -> [f32; N] {
        let mut scattered = [0.0; N];
        let plain = 1.0 - self.fixed.metallic;
        let index = [ior, 0.0].map(F32s::splat);
        for (n, color) in color.iter().enumerate() {
            let film = films(n);
            let reflectance = Angles::sampled(|cos| film.on_metal(cos, index).0);
            let coat = CoatAlbedo::of_any(Distribution::Ggx, &reflectance, alpha).scaled(specular);
            for (power, term) in coat.reflected.into_iter().enumerate() {
                self.spectra[COAT + power][n] = term;
            }
            self.spectra[BASE][n] = plain * color * FRAC_1_PI / (1.0 - coat.mean).max(THROUGH_MIN);
            scattered[n] = plain * (coat.mean + color * (1.0 - coat.mean));
        }
        let powers = &self.spectra[COAT..];
        self.fixed.of_coat = std::array::from_fn(|power| mean(&powers[power]));
        self.fixed.indices = [1.0, ior];
        self.fixed.coat = plain * specular;
        self.fixed.color = plain * mean(color);
        scattered
    }

    /// Glass between two indices of refraction, before and behind the front.
    fn be_glass(
        &mut self,
        indices: [f32; 2],
        (distribution, alpha, is_given_back): (Distribution, f32, bool),
        films: impl Fn(usize) -> Covering<F32s>,
    ) {
        // What leaves a side at a wavelength, and the share of it that is reflected.
        let leaves = |side: usize, n: usize, cos: F32s| {
            let around = [indices[side], indices[1 - side]].map(F32s::splat);
            let FilmedFace { reflectance, transmittance, .. } = films(n).on_glass(cos, around);
            let leaves = reflectance + transmittance;
            [leaves, reflectance / leaves.fast_max(F32s::splat(TINY))]
        };
        let reflected = |side: usize, cos: F32s| {
            let sum = (1..N).fold(leaves(side, 0, cos)[1], |sum, n| sum + leaves(side, n, cos)[1]);
            sum * F32s::splat(1.0 / N as f32)
        };
        let relative = indices[1] / indices[0];
        let lower = usize::from(relative < 1.0);
        let reflectance = Angles::sampled(|cos| reflected(lower, cos));
        let albedos = [relative, 1.0 / relative]
            .map(|ior| Albedo::of_any_glass(distribution, (ior, &reflectance), alpha));
        let of_side = |_: f32, side: usize| mean_over_cosines(|cos| reflected(side, cos));
        self.be_of(distribution, alpha);
        self.fixed.is_glass = true;
        self.fixed.indices = indices;
        self.fixed.sides = sides(relative, (&albedos, is_given_back), of_side);
        self.spectra[SEVERAL] = std::array::from_fn(|n| {
            let of_side = |side| mean_over_cosines(|cos| leaves(side, n, cos)[0]);
            let left = (0.5 * (of_side(0) + of_side(1))).min(1.0);
            let missing = 1.0 - 0.5 * (albedos[0].mean + albedos[1].mean);
            left * left * (1.0 - missing) / (1.0 - left * missing)
        });
    }
}

fn mean<const N: usize>(values: &[f32; N]) -> f32 {
    values.iter().sum::<f32>() / N as f32
}

/// Facets, by what a material says of them.
struct Grained {
    along: Option<[f32; 3]>,
    alpha: [f32; 2],
    /// The root mean square of both.
    mean: f32,
}

impl Grained {
    fn of(grain: Option<&Grain>, across: f32) -> Self {
        let Some(grain) = grain else {
            return Self { along: None, alpha: [across; 2], mean: across };
        };
        let alpha = grain.alphas(across);
        let mean = (0.5 * (alpha[0] * alpha[0] + alpha[1] * alpha[1])).sqrt();
        Self { along: Some(grain.place), alpha, mean }
    }

    /// That of a row.
    fn mean_of(fixed: &Fixed) -> f32 {
        let [along, across] = fixed.alpha;
        (0.5 * (along * along + across * across)).sqrt()
    }
}

impl<const N: usize> Surface for Filmed<N> {
    fn scattered(&self) -> f32 {
        self.fixed.scattered
    }

    fn peak(&self) -> f32 {
        let alpha = Grained::mean_of(&self.fixed);
        match self.fixed.is_glass {
            true => rough_dielectric::peak(alpha),
            false => peak(alpha),
        }
    }
}

/// Eight of them.
#[derive(Clone, Copy)]
pub struct FilmedLanes<'a, const N: usize> {
    rows: [&'a Filmed<N>; LANES],
}

/// The same for any number of wavelengths.
struct Rows<'a> {
    fixed: [&'a Fixed; LANES],
    /// Spectrum by spectrum.
    spectra: [&'a [f32]; LANES],
    wavelengths: usize,
}

/// Two directions about eight surfaces.
struct Between {
    /// Mask of glass, and of what is drawn on the given side.
    glass: F32s,
    same: F32s,
    /// Mask of surfaces that do anything there.
    live: F32s,
    /// What lossless facets would do, and their normal.
    value: F32s,
    half: Vector<F32s>,
    cos_half: F32s,
    /// What is missing of the two directions, both together, per gain: of glass, with the gain.
    several: F32s,
    /// What lossless facets reflect of both directions, and their cosines.
    once: [F32s; 2],
    cosines: [F32s; 2],
    /// Indices of refraction on the given side, and on the other.
    indices: [F32s; 2],
    metallic: F32s,
    coat: F32s,
    share: F32s,
}

impl<'a, const N: usize> FilmedLanes<'a, N> {
    #[inline(always)]
    fn rows(&self) -> Rows<'a> {
        Rows {
            fixed: self.rows.map(|row| &row.fixed),
            spectra: self.rows.map(|row| row.spectra.as_flattened()),
            wavelengths: N,
        }
    }
}

impl Rows<'_> {
    #[inline(always)]
    fn field(&self, of: impl Fn(&Fixed) -> f32) -> F32s {
        F32s::from(lanes::each(|lane| of(self.fixed[lane])))
    }

    #[inline(always)]
    fn mask(&self, of: impl Fn(&Fixed) -> bool) -> F32s {
        lanes::mask_of(lanes::each(|lane| of(self.fixed[lane])))
    }

    #[inline(always)]
    fn spectrum(&self, which: usize, n: usize) -> F32s {
        F32s::from(lanes::each(|lane| self.spectra[lane][which * self.wavelengths + n]))
    }

    fn film(&self, share: F32s, n: usize) -> Covering<F32s> {
        let [eta, k, waves, spread] = [0, 1, 2, 3].map(|of| self.spectrum(FILM + of, n));
        Covering { film: Film { eta, k, waves, spread }, share }
    }

    /// The facets of surfaces of this normal.
    #[inline(never)]
    fn facets(&self, normal: Vector<F32s>) -> Facets<Stretched> {
        let any = normal.any_perpendicular();
        let stated = Vector::gather(|lane| self.fixed[lane].along.unwrap_or_default());
        let along = Vector::select(self.mask(|it| it.along.is_some()), stated, any);
        let alpha = [0, 1].map(|side| self.field(|it| it.alpha[side]));
        let beckmann = self.field(|it| it.beckmann).simd_gt(F32s::splat(0.5));
        Facets::stretched(along, alpha, beckmann)
    }

    /// What lossless facets leave out at a cosine of even ones.
    fn missing(&self, cos: F32s) -> F32s {
        let terms = std::array::from_fn(|term| self.field(|it| it.of_facets.terms[term]));
        Albedo::missing(&terms, cos)
    }

    /// The same of glass, of light on the sides of the masks.
    fn missing_of_glass(&self, cos: F32s, front: F32s) -> F32s {
        let at = |side: usize| {
            let terms = std::array::from_fn(|term| self.field(|it| it.sides[side].terms[term]));
            Albedo::missing(&terms, cos)
        };
        Real::select(front, at(0), at(1))
    }

    #[inline(always)]
    fn side(&self, front: F32s, of: impl Fn(&OfSide) -> f32) -> F32s {
        Real::select(
            front,
            self.field(|it| of(&it.sides[0])),
            self.field(|it| of(&it.sides[1])),
        )
    }

    /// Indices of refraction on the side of the given direction, and on the other.
    fn indices(&self, front: F32s) -> [F32s; 2] {
        let [before, behind] = [0, 1].map(|side| self.field(|it| it.indices[side]));
        [Real::select(front, before, behind), Real::select(front, behind, before)]
    }

    #[inline(never)]
    fn between(&self, facing: &Facing, given: Vector<F32s>, drawn: Vector<F32s>) -> Between {
        let glass = self.mask(|it| it.is_glass);
        let normal = facing.shading_towards(given);
        let front = !glass | given.dot(facing.shading).simd_gt(F32s::ZERO);
        let same = drawn.dot(normal).simd_gt(F32s::ZERO);
        let facets = self.facets(normal);
        let reflection = facets.reflect(normal, given, drawn);
        let indices = self.indices(front);
        let mut at = Between {
            glass,
            same,
            live: glass | facing.reflects(given, drawn),
            value: reflection.value,
            half: reflection.half,
            cos_half: reflection.cos_half,
            several: F32s::ZERO,
            once: [F32s::ZERO; 2],
            cosines: reflection.cosines,
            indices,
            metallic: self.field(|it| it.metallic),
            coat: self.field(|it| it.coat),
            share: self.field(|it| it.share),
        };
        if !glass.all() {
            self.leave_out(&mut at, &reflection);
        }
        if glass.any() {
            let FacetRefraction { half, cos_half, value, .. } =
                facets.refract(normal, given, drawn, indices[1] / indices[0]);
            let passes = glass & !same;
            at.half = Vector::select(passes, half, at.half);
            at.cos_half = Real::select(passes, cos_half, at.cos_half);
            at.value = Real::select(passes, value, at.value);
            let even = [given, drawn].map(|v| facets.even(normal, v, v.dot(normal)).abs());
            let several = self.several_of_glass((front, same), even);
            at.several = Real::select(glass, several, at.several);
        }
        at
    }

    /// What facets that do not refract leave out.
    fn leave_out(&self, at: &mut Between, reflection: &FacetReflection) {
        let missing = reflection.even.map(|cos| self.missing(cos));
        let above = !at.glass & is_above(reflection);
        at.several = above & (missing[0] * missing[1]);
        at.once = missing.map(|missing| above & (F32s::ONE - missing));
    }

    /// What has met several facets of glass, of which lossless ones keep all, for radiance that
    /// arrives along the drawn direction.
    fn several_of_glass(&self, (front, same): (F32s, F32s), even: [F32s; 2]) -> F32s {
        let given = self.missing_of_glass(even[0], front);
        let there = Real::select(same, front, !front);
        let drawn = self.missing_of_glass(even[1], there);
        // Radiance that arrives on the other side gets through by what there is there.
        let back = self.side(front, |side| side.back);
        let beyond = self.side(!front, |side| side.beyond);
        given * drawn * Real::select(same, back, beyond)
    }

    /// What facets do at a wavelength, and what is scattered otherwise.
    #[inline(never)]
    fn at(&self, at: &Between, n: usize) -> (FacetLobe, F32s) {
        let film = self.film(at.share, n);
        let value = at.live & at.value;
        let opaque = !at.glass & value;
        let mut lobe = FacetLobe::none();
        let is_there = |share: F32s| share.simd_gt(F32s::ZERO).any();
        if is_there(at.metallic) {
            let index = [self.spectrum(INDEX, n), self.spectrum(INDEX + 1, n)];
            let (reflectance, block) = film.on_metal(at.cos_half, index);
            lobe = lobe.and(opaque * at.metallic * reflectance, block);
        }
        if is_there(at.coat) {
            let (reflectance, block) = film.on_metal(at.cos_half, [at.indices[1], F32s::ZERO]);
            lobe = lobe.and(opaque * at.coat * reflectance, block);
        }
        if at.glass.any() {
            let face = film.on_glass(at.cos_half, at.indices);
            let share = Real::select(at.same, face.reflectance, face.transmittance);
            let block = Block::select(at.same, face.reflection, face.transmission);
            lobe = lobe.and(at.glass & (value * share), block);
        }
        let mut rest = at.several * self.spectrum(SEVERAL, n);
        let base = self.spectrum(BASE, n);
        if is_there(base) {
            let powers = std::array::from_fn(|power| self.spectrum(COAT + power, n));
            let through = [0, 1].map(|of| {
                let missing = F32s::ONE - at.once[of];
                F32s::ONE - CoatAlbedo::at(missing, &powers, at.cosines[of])
            });
            let is_lit = at.once[0].simd_gt(F32s::ZERO);
            rest += is_lit & (base * through[0] * through[1]);
        }
        (lobe, at.live & rest)
    }

    /// The share of what facets of glass scatter that they reflect: the mean of all wavelengths.
    #[inline(never)]
    fn reflected(&self, cos_half: F32s, indices: [F32s; 2]) -> F32s {
        let share = self.field(|it| it.share);
        let mut sums = [F32s::ZERO; 2];
        for n in 0..self.wavelengths {
            let FilmedFace { reflectance, transmittance, .. } =
                self.film(share, n).on_glass(cos_half, indices);
            sums = [sums[0] + reflectance, sums[1] + transmittance];
        }
        let [reflected, passed] = sums;
        reflected / (reflected + passed).fast_max(F32s::splat(TINY))
    }

    /// The directions that opaque ones draw, for a path from a direction of the cosine.
    fn mixture(&self, facets: Facets<Stretched>, cos: F32s) -> Mixture<Stretched> {
        let missing = self.missing(cos);
        let powers = std::array::from_fn(|power| self.field(|it| it.of_coat[power]));
        let coat = CoatAlbedo::at(missing, &powers, cos);
        let once = self.field(|it| it.single) * (F32s::ONE - missing);
        let by_facets = (F32s::ONE - self.field(|it| it.metallic)).mul_add(coat, once);
        let several = self.field(|it| it.multiple) * missing;
        let others = self.field(|it| it.color).mul_add(F32s::ONE - coat, several);
        let least = F32s::splat(f32::MIN_POSITIVE);
        Mixture {
            facets,
            chance: by_facets / (by_facets + others).fast_max(least),
            grazing: several / others.fast_max(least),
        }
    }

    /// The probability of drawing by facets of glass, for a path from a direction of the cosine.
    fn chance_of_glass(&self, cos: F32s, front: F32s) -> F32s {
        let gives_back = self.side(front, |it| it.back + it.beyond).simd_gt(F32s::ZERO);
        F32s::ONE - (gives_back & self.missing_of_glass(cos, front))
    }

    #[inline(never)]
    fn pdf(&self, facing: &Facing, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
        let glass = self.mask(|it| it.is_glass);
        let normal = facing.shading_towards(given);
        let facets = self.facets(normal);
        let cos_given = given.dot(normal);
        let mut pdf = F32s::ZERO;
        if !glass.all() {
            pdf = self.mixture(facets, cos_given).pdf(normal, given, drawn);
        }
        if glass.none() {
            return pdf;
        }
        let front = given.dot(facing.shading).simd_gt(F32s::ZERO);
        let cos = drawn.dot(normal);
        let same = cos.simd_gt(F32s::ZERO);
        let indices = self.indices(front);
        let refraction = facets.refract(normal, given, drawn, indices[1] / indices[0]);
        let reflection = facets.reflect(normal, given, drawn);
        let cos_half = Real::select(same, reflection.cos_half, refraction.cos_half);
        let reflected = self.reflected(cos_half, indices);
        let of_facets = Real::select(
            same,
            reflected * facets.pdf(normal, given, drawn),
            (F32s::ONE - reflected) * refraction.pdf,
        );
        let through = self.side(front, |side| side.through);
        let share = Real::select(same, F32s::ONE - through, through);
        let of_lobe = share * Grazing::of(&facets).pdf(cos.abs());
        let of_glass = self.chance_of_glass(cos_given, front).mul_add(of_facets - of_lobe, of_lobe);
        Real::select(glass, of_glass, pdf)
    }

    /// A direction, its density, and the mask of what is lost; the third number chooses a side.
    #[inline(never)]
    fn draw(
        &self,
        facing: &Facing,
        given: Vector<F32s>,
        [first, second, third]: [F32s; 3],
    ) -> (Vector<F32s>, F32s, F32s) {
        let glass = self.mask(|it| it.is_glass);
        let normal = facing.shading_towards(given);
        let facets = self.facets(normal);
        let cos_given = given.dot(normal);
        let mut direction = normal;
        let mut lost = F32s::ZERO;
        if !glass.all() {
            let mixture = self.mixture(facets, cos_given);
            (direction, _) = mixture.draw(normal, given, [first, second]);
            lost = direction.dot(normal).simd_le(F32s::ZERO);
        }
        if glass.any() {
            let front = given.dot(facing.shading).simd_gt(F32s::ZERO);
            let indices = self.indices(front);
            let (by_facets, again) = choose(first, self.chance_of_glass(cos_given, front));
            let half = facets.draw_half(normal, given, [again, second]);
            let cos_half = given.dot(half).fast_max(F32s::ZERO).fast_min(F32s::ONE);
            let eta = indices[1] / indices[0];
            let (_, cos_t) = fresnel::dielectric_reflectance(cos_half, eta);
            let mirrored = half * (cos_half + cos_half) - given;
            let refracted = half * (cos_half / eta - cos_t) - given * (F32s::ONE / eta);
            let reflects = third.simd_lt(self.reflected(cos_half, indices));
            let of_facets = Vector::select(reflects, mirrored, refracted);
            let lobe = [Grazing::of(&facets).cosine_number(again), second];
            let (cosine, _) = warp::cosine_hemisphere(normal, lobe);
            let passes = third.simd_lt(self.side(front, |side| side.through));
            let beyond = normal * (cosine.dot(normal) * F32s::splat(-2.0)) + cosine;
            let of_cosine = Vector::select(passes, beyond, cosine);
            let of_glass = Vector::select(by_facets, of_facets, of_cosine).normalize();
            // What facets send to the other side than they should meets others.
            let is_lost = by_facets & (of_glass.dot(normal).simd_gt(F32s::ZERO) ^ reflects);
            direction = Vector::select(glass, of_glass, direction);
            lost = Real::select(glass, is_lost, lost);
        }
        let pdf = self.pdf(facing, given, direction).fast_max(F32s::splat(PDF_MIN));
        (direction, pdf, lost)
    }
}

impl<const N: usize> Lobes<N> for FilmedLanes<'_, N> {
    type Kernel = SpheroidBlock<F32s>;

    fn values(
        &self,
        facing: &Facing,
        given: Vector<F32s>,
        drawn: Vector<F32s>,
        side: Side,
    ) -> [F32s; N] {
        let rows = self.rows();
        let at = rows.between(facing, given, drawn);
        let eta = at.indices[1] / at.indices[0];
        // Radiance grows with the square of the index; power does not.
        let squeeze = match side {
            Side::Sensor => F32s::ONE,
            Side::Light => Real::select(at.glass & !at.same, eta * eta, F32s::ONE),
        };
        let mut values = [F32s::ZERO; N];
        for (n, value) in values.iter_mut().enumerate() {
            let (lobe, rest) = rows.at(&at, n);
            *value = (lobe.m00() + rest) * squeeze;
        }
        values
    }

    fn pdf(&self, facing: &Facing, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
        self.rows().pdf(facing, given, drawn)
    }

    fn draw(&self, facing: &Facing, given: Vector<F32s>, u: [F32s; 3], side: Side) -> Drawn<N> {
        let (direction, pdf, lost) = self.rows().draw(facing, given, u);
        let mut weight = self.values(facing, given, direction, side);
        let scale = !lost & (direction.dot(facing.shading).abs() / pdf);
        weight.iter_mut().for_each(|weight| *weight *= scale);
        Drawn { direction, pdf, weight, lost }
    }

    fn kernels(&self, facing: &Facing, k_in: Vector<F32s>, k_out: Vector<F32s>) -> Kernels<N> {
        let rows = self.rows();
        let at = rows.between(facing, -k_in, k_out);
        let mut kernels = [Block::identity().spheroid(); N];
        for (n, kernel) in kernels.iter_mut().enumerate() {
            let (lobe, rest) = rows.at(&at, n);
            *kernel = lobe.beside(rest);
        }
        (kernels, s_axis(at.half, k_in))
    }
}

impl<const N: usize> Glossy<N> for Filmed<N> {
    type Lanes<'a> = FilmedLanes<'a, N>;
    const FORM: Form = Form::Spheroid;
    const TRANSMITS: bool = true;

    #[inline(always)]
    fn lanes<'a>(models: &ModelLanes<'a, Self>) -> FilmedLanes<'a, N> {
        FilmedLanes { rows: models.each() }
    }
}

#[cfg(test)]
mod tests;
