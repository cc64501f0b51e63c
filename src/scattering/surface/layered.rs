//! What glTF's materials have beyond metallic-roughness: walls that light goes through, a clear
//! coat, cloth.
//!
//! **The wall.** A share of the base is a pane too thin to refract light, whose faces have the same
//! facets. What they reflect is what a pane does, all reflections within it summed, of which all
//! but the first have gone twice through the color. What goes through is scattered like what is
//! reflected, mirrored at the surface (as KHR_materials_transmission has it), with the pane's
//! transmittance at the facets, times the color; polarized by the pane's Mueller matrix between the
//! facets' plane of incidence and its mirror image. As the roughness goes to zero this is the
//! smooth pane. What meets several facets is missing of it, and is given back as at rough metal
//! ([`super::rough`]), half of it on each side.
//!
//! **The base** is that of [`super::metallic_roughness`]; a share of it sends light in all
//! directions behind the surface instead of before it (KHR_materials_diffuse_transmission).
//!
//! **The coat** has facets (GGX) of a dielectric of index 1.5, with Fresnel's Mueller matrix; **the
//! cloth** is that of [`crate::polarization::cloth`]. What is below gets through by what is left
//! over: with their albedos E at the cosines of the two directions, the lesser of the two `1 - E`,
//! which is reciprocal and adds no energy (as KHR_materials_sheen has it). Coats turn the
//! polarization of what goes through them by some hundredths; that is left out, and so is the
//! light that they reflect back to the base. A wall has them on both sides.

use std::f32::consts::FRAC_1_PI;

use super::facing::Facing;
use super::glossy::{Glossy, Lobes};
use super::model::{Drawn, ModelLanes, Surface, strongest};
use super::rough::{
    FacetLobe, Grazing, MISSING_MIN, NARROW, PDF_MIN, Reflected, TINY, is_above, peak,
};
use crate::math::{F32s, Real, Vector, warp};
use crate::polarization::albedo::{ClothAlbedo, POWERS, TERMS};
use crate::polarization::cloth::cloth;
use crate::polarization::{
    Albedo, Block, CoatAlbedo, Dense, Distribution, FacetReflection, Facets, Pane, Rotation,
    fresnel, pane, s_axis,
};
use crate::scattering::event::Form;
use crate::scattering::side::Side;
use crate::scattering::vertex::mean;
use crate::scene::world::Layers;

/// Index of refraction of clear coats: KHR_materials_clearcoat.
const COAT_IOR: f32 = 1.5;
/// Least share of light that gets through facets, on the average.
const THROUGH_MIN: f32 = 1e-3;
/// Share of draws by the cosine where there is little to draw by it: albedos are approximate.
const LEAST_CHANCE: f32 = 1e-3;
/// Ways to draw directions.
const WAYS: usize = 7;

/// One material.
#[derive(Clone, Copy, Debug)]
pub struct Layered<const N: usize> {
    /// The share of metal, within [0, 1].
    metallic: f32,
    /// The share of what facets of the rest would reflect that there is.
    specular: f32,
    ior: f32,
    alpha: f32,
    coat: f32,
    coat_alpha: f32,
    cloth_alpha: f32,
    /// The greatest reflectance of the threads.
    cloth_most: f32,
    /// 1 where light goes through.
    open: f32,
    /// The share of what facets reflect that is there at normal incidence.
    tint: [f32; N],
    /// Extinction coefficient of the metal.
    k: [f32; N],
    /// The share of what a pane's further faces reflect that is there.
    further: [f32; N],
    /// What facets let through, over that of a pane.
    through: [f32; N],
    /// What goes through or off several facets of the wall, by the product of what is missing.
    several: [f32; N],
    /// The base before and behind, by the product of what gets to it.
    base: [f32; N],
    behind: [f32; N],
    /// Reflectance of the threads.
    cloth: [f32; N],
    /// What facets of the dielectric reflect, and lossless ones; the coat, by its share; white
    /// threads.
    of_dielectric: CoatAlbedo,
    of_facets: Albedo,
    of_coat: CoatAlbedo,
    of_cloth: ClothAlbedo,
    /// What the metal reflects, by its share.
    metal: Reflected<N>,
}

impl<const N: usize> Layered<N> {
    /// With all that it consists of.
    pub fn of(layers: Layers<[f32; N]>) -> Self {
        let Layers { base_color, metallic, alpha, ior, specular, transmission, .. } = layers;
        let of_facets = Albedo::of_facets(Distribution::Ggx, alpha);
        let of_dielectric = CoatAlbedo::of(Distribution::Ggx, ior, alpha).scaled(specular);
        let k = base_color.map(fresnel::k_of_reflectance);
        let mut metal = Reflected::of([1.0; N], k, &of_facets, true);
        for values in [&mut metal.gain, &mut metal.single, &mut metal.multiple] {
            values.iter_mut().for_each(|value| *value *= metallic);
        }
        let plain = 1.0 - metallic;
        let matte =
            plain * (1.0 - transmission) * FRAC_1_PI / (1.0 - of_dielectric.mean).max(THROUGH_MIN);
        let diffuse = layers.diffuse_transmission;
        let missing = 1.0 - of_facets.mean;
        let half = match missing < MISSING_MIN {
            true => 0.0,
            false => 0.5 * plain * transmission * FRAC_1_PI / missing,
        };
        Self {
            metallic,
            specular,
            ior,
            alpha,
            coat: layers.coat,
            coat_alpha: layers.coat_alpha,
            cloth_alpha: layers.cloth_alpha,
            cloth_most: strongest(layers.cloth_color),
            open: if layers.transmits() { 1.0 } else { 0.0 },
            tint: layers.specular_color,
            k,
            further: base_color.map(|color| transmission * color * color),
            through: base_color.map(|color| plain * transmission * color),
            several: base_color.map(|color| half * color),
            base: base_color.map(|color| matte * (1.0 - diffuse) * color),
            behind: layers.diffuse_transmission_color.map(|color| matte * diffuse * color),
            cloth: layers.cloth_color,
            of_dielectric,
            of_facets,
            of_coat: CoatAlbedo::of(Distribution::Ggx, COAT_IOR, layers.coat_alpha)
                .scaled(layers.coat),
            of_cloth: ClothAlbedo::of(layers.cloth_alpha),
            metal,
        }
    }
}

impl<const N: usize> Surface for Layered<N> {
    fn scattered(&self) -> f32 {
        let Self { metallic, of_dielectric, of_facets, metal, of_coat, .. } = self;
        let below = 1.0 - of_dielectric.mean;
        let all = |n: usize| {
            let of_metal =
                metal.single[n] * of_facets.mean + metal.multiple[n] * (1.0 - of_facets.mean);
            let matte = (self.base[n] + self.behind[n]) * below * below / FRAC_1_PI;
            let inner = of_metal + (1.0 - metallic) * of_dielectric.mean + matte + self.through[n];
            let cloth = self.cloth[n] * self.of_cloth.mean;
            cloth + of_coat.mean + (1.0 - of_coat.mean - cloth).max(0.0) * inner
        };
        strongest::<N>(std::array::from_fn(all)).min(1.0)
    }

    /// About the light that goes on through a wall, too: paths go on from what is narrow whatever
    /// comes.
    fn peak(&self) -> f32 {
        if self.alpha < NARROW && strongest(self.through) > 0.0 {
            return 2.0;
        }
        let of_coat = if self.coat > 0.0 { peak(self.coat_alpha) } else { 0.0 };
        peak(self.alpha).max(of_coat)
    }
}

/// Eight of them.
#[derive(Clone, Copy)]
pub struct Layereds<const N: usize> {
    facets: Facets,
    coat_facets: Facets,
    metallic: F32s,
    specular: F32s,
    ior: F32s,
    coat: F32s,
    cloth_alpha: F32s,
    cloth_most: F32s,
    /// Mask of those that light goes through.
    open: F32s,
    tint: [F32s; N],
    k: [F32s; N],
    further: [F32s; N],
    through: [F32s; N],
    several: [F32s; N],
    base: [F32s; N],
    behind: [F32s; N],
    cloth: [F32s; N],
    gain: [F32s; N],
    /// Of [`CoatAlbedo`], [`Albedo`] and [`ClothAlbedo`].
    of_dielectric: [F32s; POWERS],
    of_facets: [F32s; TERMS],
    of_coat: [F32s; POWERS],
    of_coat_facets: [F32s; TERMS],
    of_cloth: [F32s; POWERS],
    /// Means over the wavelengths of what the metal reflects once and several times.
    single: F32s,
    multiple: F32s,
}

/// Two directions about eight surfaces.
struct Between {
    /// The shading normal on the side of the given direction.
    normal: Vector<F32s>,
    /// The given direction, and the drawn one, mirrored where it is behind the surface.
    given: Vector<F32s>,
    folded: Vector<F32s>,
    /// Mask of those that are drawn on the side of the given one.
    before: F32s,
    /// Mask of surfaces that do anything there.
    live: F32s,
    /// What lossless facets reflect between the two.
    facets: FacetReflection,
    /// What gets through the cloth, and through the coat as well.
    under_cloth: F32s,
    under: F32s,
}

impl<const N: usize> Layereds<N> {
    #[inline(always)]
    fn between(&self, facing: &Facing, given: Vector<F32s>, drawn: Vector<F32s>) -> Between {
        let zero = F32s::splat(0.0);
        let normal = facing.shading_towards(given);
        let cos = drawn.dot(normal);
        let before = cos.simd_gt(zero);
        let mirrored = normal.mul_add(cos * F32s::splat(-2.0), drawn);
        let folded = Vector::select(before, drawn, mirrored);
        let facets = self.facets.reflect(normal, given, folded);
        let front = given.dot(facing.shading).simd_gt(zero);
        let live = (self.open | (before & (front | facing.two_sided))) & is_above(&facets);
        let [cloth, both] = self.left_over(facets.cosines[0]);
        let [cloth_drawn, both_drawn] = self.left_over(facets.cosines[1]);
        let under_cloth = cloth.fast_min(cloth_drawn);
        let under = both.fast_min(both_drawn);
        Between { normal, given, folded, before, live, facets, under_cloth, under }
    }

    /// What cloth leaves of light of the cosine, and cloth and coat.
    #[inline(always)]
    fn left_over(&self, cos: F32s) -> [F32s; 2] {
        let one = F32s::splat(1.0);
        let mut cloth = one;
        if self.cloth_most.simd_gt(F32s::splat(0.0)).any() {
            cloth = one - self.cloth_most * ClothAlbedo::at(&self.of_cloth, cos).fast_min(one);
        }
        let missing = Albedo::missing(&self.of_coat_facets, cos);
        [cloth, cloth * (one - CoatAlbedo::at(missing, &self.of_coat, cos))]
    }

    /// What facets of the dielectric let through of light of the cosine, and what those that
    /// reflect all leave out.
    #[inline(always)]
    fn missing(&self, cos: F32s) -> [F32s; 2] {
        let of_facets = Albedo::missing(&self.of_facets, cos);
        [F32s::splat(1.0) - CoatAlbedo::at(of_facets, &self.of_dielectric, cos), of_facets]
    }

    /// What facets of the base and of the coat do.
    #[inline(always)]
    fn by_facets(&self, at: &Between) -> [FacetLobe; N] {
        let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
        let FacetReflection { cos_half: cos, value, .. } = at.facets;
        let once = (at.live & at.before) & (value * at.under);
        let passed = at.live & !at.before & (value * at.under);
        let face = fresnel::dielectric(cos, self.ior);
        let wall: Pane<F32s> = pane(cos, self.ior);
        let normal_incidence = (self.ior - one) / (self.ior + one);
        let least = normal_incidence * normal_incidence;
        let grazing = ((face.reflectance - least) / (one - least)).fast_max(zero);
        let of_dielectric = once * (one - self.metallic) * self.specular;
        let mut first = FacetLobe::none();
        if self.coat.simd_gt(zero).any() {
            let coat = self.coat_facets.reflect(at.normal, at.given, at.folded);
            let face = fresnel::dielectric(cos, F32s::splat(COAT_IOR));
            let value = coat.value * self.coat * at.under_cloth * face.reflectance;
            first = first.and(at.live & at.before & value, face.reflection);
        }
        let mut lobes = [first; N];
        for (n, lobe) in lobes.iter_mut().enumerate() {
            let tint = self.tint[n] + (one - self.tint[n]) * grazing;
            let (of_face, further) = (of_dielectric * tint, self.further[n]);
            *lobe = lobe.and(of_face * face.reflectance * (one - further), face.reflection);
            let reflected = one - wall.transmittance;
            *lobe = lobe.and(of_face * reflected * further, wall.reflection);
            let passed = passed * self.through[n];
            *lobe = lobe.and(passed * (one - self.specular), Block::identity());
            *lobe = lobe.and(passed * self.specular * wall.transmittance, wall.transmission);
        }
        if self.metallic.simd_gt(zero).any() {
            let of_metal = once * self.metallic;
            for (lobe, &k) in lobes.iter_mut().zip(&self.k) {
                let (reflectance, block) = fresnel::conductor(cos, one, k);
                *lobe = lobe.and(of_metal * reflectance, block);
            }
        }
        lobes
    }

    /// What is scattered otherwise.
    #[inline(always)]
    fn depolarized(&self, at: &Between) -> [F32s; N] {
        let [given, drawn] = at.facets.cosines.map(|cos| self.missing(cos));
        let [matte, several] = [0, 1].map(|of| at.live & (given[of] * drawn[of] * at.under));
        let mut values = [F32s::splat(0.0); N];
        for (n, value) in values.iter_mut().enumerate() {
            let matte = matte * Real::select(at.before, self.base[n], self.behind[n]);
            let of_metal = at.before & self.gain[n];
            *value = several.mul_add(of_metal + self.several[n], matte);
        }
        if self.cloth_most.simd_gt(F32s::splat(0.0)).any() {
            let threads = cloth(self.cloth_alpha, at.normal, at.given, at.folded);
            let one = F32s::splat(1.0);
            let [given, drawn] = at.facets.cosines.map(|cos| ClothAlbedo::at(&self.of_cloth, cos));
            // They scatter no more than they get.
            let threads = threads / given.fast_max(drawn).fast_max(one);
            let threads = at.live & at.before & threads;
            for (value, &color) in values.iter_mut().zip(&self.cloth) {
                *value = threads.mul_add(color, *value);
            }
        }
        values
    }

    /// The probabilities of drawing by the facets of the coat and of the base, through those, by
    /// the cosine before the surface and behind it, and by what facets leave out there; for a path
    /// that comes from a direction of the cosine.
    #[inline(always)]
    fn chances(&self, cos: F32s) -> [F32s; WAYS] {
        let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
        let [under_cloth, under] = self.left_over(cos);
        let [gets, missing] = self.missing(cos);
        let of_dielectric = one - gets;
        let through = mean(&self.through);
        let coat = under_cloth - under;
        let reflected = (one - self.metallic) * of_dielectric * F32s::splat(2.0);
        let facets = under * (self.single * (one - missing) + reflected);
        let passed = under * through * gets;
        let pi = F32s::splat(1.0 / FRAC_1_PI);
        let several = mean(&self.several) * pi * missing;
        let least = F32s::splat(LEAST_CHANCE);
        let up = under.mul_add(mean(&self.base) * pi * gets, (one - under_cloth) + least);
        let down = self.open & (under * (mean(&self.behind) * pi * gets + least));
        let low = under * (self.multiple * missing + several);
        let low_down = self.open & (under * several);
        let ways = [coat, facets, self.open & passed, up, down, low, low_down];
        let ways = ways.map(|way| way.fast_max(zero));
        let sum = ways[1..].iter().fold(ways[0], |sum, &way| sum + way);
        ways.map(|way| way / sum)
    }
}

impl<const N: usize> Lobes<N> for Layereds<N> {
    type Kernel = Dense<F32s>;

    #[inline(always)]
    fn values(
        &self,
        facing: &Facing,
        given: Vector<F32s>,
        drawn: Vector<F32s>,
        _side: Side,
    ) -> [F32s; N] {
        let at = self.between(facing, given, drawn);
        let mut values = self.depolarized(&at);
        for (value, lobe) in values.iter_mut().zip(self.by_facets(&at)) {
            *value += lobe.m00();
        }
        values
    }

    #[inline(always)]
    fn pdf(&self, facing: &Facing, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
        let normal = facing.shading_towards(given);
        let [coat, facets, passed, up, down, low, low_down] = self.chances(given.dot(normal));
        let cos = drawn.dot(normal);
        let before = cos.simd_gt(F32s::splat(0.0));
        let mirrored = normal.mul_add(cos * F32s::splat(-2.0), drawn);
        let folded = Vector::select(before, drawn, mirrored);
        let by_base = self.facets.pdf(normal, given, folded);
        let mut by_coat = F32s::splat(0.0);
        if self.coat.simd_gt(F32s::splat(0.0)).any() {
            by_coat = self.coat_facets.pdf(normal, given, folded);
        }
        let by_cosine = warp::cosine_pdf(cos.abs());
        let by_lobe = Grazing::of(&self.facets).pdf(cos.abs());
        let above = coat * by_coat + facets * by_base + up * by_cosine + low * by_lobe;
        Real::select(before, above, passed * by_base + down * by_cosine + low_down * by_lobe)
    }

    /// The first number chooses the way, too.
    #[inline(always)]
    fn draw(&self, facing: &Facing, given: Vector<F32s>, u: [F32s; 3], side: Side) -> Drawn<N> {
        let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
        let normal = facing.shading_towards(given);
        let chances = self.chances(given.dot(normal));
        // What is left of the first number, and which way it has come to.
        let (mut first, mut is_left, mut by) = (u[0], one.simd_gt(zero), [zero; WAYS]);
        let mut again = zero;
        for (mask, chance) in by.iter_mut().zip(chances) {
            *mask = is_left & first.simd_lt(chance);
            again = Real::select(*mask, first / chance.fast_max(F32s::splat(TINY)), again);
            is_left &= !*mask;
            first -= chance;
        }
        let [by_coat, by_base, by_passing, by_up, by_down, by_low, by_low_down] = by;
        // By rounding none may have been.
        let by_up = by_up | is_left;
        let below_one = F32s::splat(1.0 - f32::EPSILON / 2.0);
        let again = [again.fast_min(below_one), u[1]];
        let of_base = self.facets.draw(normal, given, again);
        let mut direction = of_base;
        if by_coat.any() {
            let of_coat = self.coat_facets.draw(normal, given, again);
            direction = Vector::select(by_coat, of_coat, direction);
        }
        let by_lobe = by_low | by_low_down;
        let low = Grazing::of(&self.facets).cosine_number(again[0]);
        let height = Real::select(by_lobe, low, again[0]);
        let (cosine, _) = warp::cosine_hemisphere(normal, [height, again[1]]);
        direction = Vector::select(by_up | by_down | by_lobe, cosine, direction);
        let cos = direction.dot(normal);
        // What facets send to the other side than they should meets others.
        let is_lost = (by_coat | by_base | by_passing) & cos.simd_le(zero);
        let mirrored = normal.mul_add(cos * F32s::splat(-2.0), direction);
        direction = Vector::select(by_passing | by_down | by_low_down, mirrored, direction);
        let pdf = self.pdf(facing, given, direction).fast_max(F32s::splat(PDF_MIN));
        let mut weight = self.values(facing, given, direction, side);
        let scale = !is_lost & (cos.abs() / pdf);
        weight.iter_mut().for_each(|weight| *weight *= scale);
        Drawn { direction, pdf, weight, lost: is_lost }
    }

    #[inline(always)]
    fn kernels(
        &self,
        facing: &Facing,
        k_in: Vector<F32s>,
        k_out: Vector<F32s>,
    ) -> ([Self::Kernel; N], Vector<F32s>) {
        let at = self.between(facing, -k_in, k_out);
        let (lobes, depolarized) = (self.by_facets(&at), self.depolarized(&at));
        let of_facets = s_axis(at.facets.half, k_in);
        // What goes through is turned into the plane of the two directions, and out of it.
        let across = s_axis(k_out, k_in);
        let axis = Vector::select(at.before, of_facets, across);
        let mirrored = at.normal.mul_add(of_facets.dot(at.normal) * F32s::splat(-2.0), of_facets);
        let leaving = Vector::select(at.before, of_facets, mirrored);
        let arriving = Rotation::between(axis, of_facets, k_in);
        let leaving = Rotation::between(leaving, axis, k_out);
        let mut kernels = [Dense([[F32s::splat(1.0); 4]; 4]); N];
        for (n, kernel) in kernels.iter_mut().enumerate() {
            *kernel = lobes[n].beside(depolarized[n]).dense().turned(arriving, leaving);
        }
        (kernels, axis)
    }
}

impl<const N: usize> Glossy<N> for Layered<N> {
    type Lanes<'a> = Layereds<N>;
    const FORM: Form = Form::Dense;
    const TRANSMITS: bool = true;

    #[inline(always)]
    fn lanes<'a>(models: &ModelLanes<'a, Self>) -> Layereds<N> {
        let ggx = F32s::splat(0.0);
        let open = models.field(|model| model.open).simd_gt(F32s::splat(0.5));
        Layereds {
            facets: Facets::new(models.field(|model| model.alpha), ggx),
            coat_facets: Facets::new(models.field(|model| model.coat_alpha), ggx),
            metallic: models.field(|model| model.metallic),
            specular: models.field(|model| model.specular),
            ior: models.field(|model| model.ior),
            coat: models.field(|model| model.coat),
            cloth_alpha: models.field(|model| model.cloth_alpha),
            cloth_most: models.field(|model| model.cloth_most),
            open,
            tint: models.spectrum(|model| &model.tint),
            k: models.spectrum(|model| &model.k),
            further: models.spectrum(|model| &model.further),
            through: models.spectrum(|model| &model.through),
            several: models.spectrum(|model| &model.several),
            base: models.spectrum(|model| &model.base),
            behind: models.spectrum(|model| &model.behind),
            cloth: models.spectrum(|model| &model.cloth),
            gain: models.spectrum(|model| &model.metal.gain),
            of_dielectric: models.spectrum(|model| &model.of_dielectric.reflected),
            of_facets: models.spectrum(|model| &model.of_facets.terms),
            of_coat: models.spectrum(|model| &model.of_coat.reflected),
            of_coat_facets: models.spectrum(|model| &model.of_coat.facets),
            of_cloth: models.spectrum(|model| &model.of_cloth.powers),
            single: mean(&models.spectrum(|model| &model.metal.single)),
            multiple: mean(&models.spectrum(|model| &model.metal.multiple)),
        }
    }
}

#[cfg(test)]
pub mod tests;
