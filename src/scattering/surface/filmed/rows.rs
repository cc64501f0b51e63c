//! Eight rough surfaces under films at any number of wavelengths.

use super::{BASE, COAT, FILM, Fixed, INDEX, SEVERAL};
use crate::math::{F32s, LANES, Real, Vector, lanes, warp};
use crate::polarization::{
    Albedo, Block, CoatAlbedo, FacetReflection, FacetRefraction, Facets, Film, Filmed, Stretched,
    fresnel,
};
use crate::scattering::surface::facing::Facing;
use crate::scattering::surface::film::Covering;
use crate::scattering::surface::rough::{
    FacetLobe, Grazing, Mixture, PDF_MIN, TINY, choose, is_above,
};
use crate::scattering::surface::rough_dielectric::OfSide;

/// Their rows.
pub struct Rows<'a> {
    /// What is the same at all wavelengths.
    pub fixed: [&'a Fixed; LANES],
    /// The rest, spectrum by spectrum.
    pub spectra: [&'a [f32]; LANES],
    /// How many there are.
    pub wavelengths: usize,
}

/// Two directions about eight surfaces.
pub struct Between {
    /// Mask of glass, and of what is drawn on the given side.
    pub glass: F32s,
    pub same: F32s,
    /// Mask of surfaces that do anything there.
    live: F32s,
    /// What lossless facets would do, and their normal.
    value: F32s,
    pub half: Vector<F32s>,
    cos_half: F32s,
    /// What is missing of the two directions, both together, per gain: of glass, with the gain.
    several: F32s,
    /// What lossless facets reflect of both directions, and their cosines.
    once: [F32s; 2],
    cosines: [F32s; 2],
    /// Indices of refraction on the given side, and on the other.
    pub indices: [F32s; 2],
    metallic: F32s,
    coat: F32s,
    share: F32s,
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
        Real::select(front, self.field(|it| of(&it.sides[0])), self.field(|it| of(&it.sides[1])))
    }

    /// Indices of refraction on the side of the given direction, and on the other.
    fn indices(&self, front: F32s) -> [F32s; 2] {
        let [before, behind] = [0, 1].map(|side| self.field(|it| it.indices[side]));
        [Real::select(front, before, behind), Real::select(front, behind, before)]
    }

    /// What the surfaces are between two directions away from them.
    #[inline(never)]
    pub fn between(&self, facing: &Facing, given: Vector<F32s>, drawn: Vector<F32s>) -> Between {
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
    pub fn at(&self, at: &Between, n: usize) -> (FacetLobe, F32s) {
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
            let Filmed { reflectance, transmittance, .. } =
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

    /// See [`super::Lobes::pdf`].
    #[inline(never)]
    pub fn pdf(&self, facing: &Facing, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
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
    pub fn draw(
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
