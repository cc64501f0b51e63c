//! Rough surfaces under a thin film: metal, glass, and glTF's metallic-roughness, whose facets
//! reflect and refract as smooth surfaces under the film do.
//!
//! They are the models of [`super::rough_conductor`], [`super::rough_dielectric`] and
//! [`super::metallic_roughness`] with other facets, which may be stretched as those of
//! [`super::brushed`]. What several facets scatter is given back as there, with the film in the
//! means: of metal, the mean reflectance over the hemisphere at each wavelength; of a coat, its
//! albedo at each wavelength, which the base lies under; of glass, the albedo of the
//! mean reflectance of all wavelengths, and of a film that absorbs what that leaves of light which
//! meets several facets.
//!
//! A film costs more than all else about such a surface, so that this is compiled once for any
//! number of wavelengths, and for all of these models.

mod made;
mod rows;

use super::facing::Facing;
use super::glossy::{Glossy, Lobes};
use super::model::{Drawn, ModelLanes, Surface};
use super::rough::peak;
use super::rough_dielectric::{self, OfSide, SIDES};
use crate::math::{F32s, LANES, Real, Vector};
use crate::polarization::albedo::POWERS;
use crate::polarization::{Albedo, Block, Distribution, SpheroidBlock, fresnel, s_axis};
use crate::scattering::event::{Elements, Form};
use crate::scattering::side::Side;
use crate::scattering::vertex::Kernels;
use crate::scene::world::{SurfaceModel, ThinFilm};
use made::Making;
use rows::Rows;

/// One material, where it is.
#[derive(Clone, Copy, Debug)]
pub struct Filmed<const N: usize> {
    fixed: Fixed,
    spectra: [[f32; N]; SPECTRA],
}

/// What is the same at all wavelengths.
#[derive(Clone, Copy, Debug)]
pub struct Fixed {
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
    /// Means over the wavelengths: coefficients of what the coat reflects, as of
    /// [`crate::polarization::CoatAlbedo`],
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
        let mut spectra = [[0.0; N]; SPECTRA];
        spectra[FILM..INDEX].copy_from_slice(&[film.eta, film.k, film.thickness, film.spread]);
        spectra[FILM + 2].iter_mut().for_each(|thickness| *thickness *= film.portion);
        let mut filmed = Self { fixed: Fixed::bare(grain, across, film.share), spectra };
        if let &SurfaceModel::RoughDielectric {
            ior,
            exterior_ior,
            distribution,
            multiple_scattering,
            ..
        } = model
        {
            let indices = [exterior_ior[0], ior[0]];
            filmed.making().glass(indices, (distribution, multiple_scattering));
        } else if let &SurfaceModel::RoughConductor {
            eta,
            k,
            distribution,
            multiple_scattering,
            ..
        } = model
        {
            filmed.spectra[INDEX..BASE].copy_from_slice(&[eta, k]);
            filmed.making().metal(1.0, (distribution, multiple_scattering));
        } else if let &SurfaceModel::MetallicRoughness {
            base_color, metallic, ior, specular, ..
        } = model
        {
            let k = base_color.map(fresnel::k_of_reflectance);
            filmed.spectra[INDEX..SEVERAL].copy_from_slice(&[[1.0; N], k, base_color]);
            let mut making = filmed.making();
            making.metal(metallic, (Distribution::Ggx, true));
            making.coat(specular, ior);
        } else {
            unreachable!("worlds are checked: no other model has a film here")
        }
        filmed
    }

    fn making(&mut self) -> Making<'_> {
        let spectra = self.spectra.as_flattened_mut();
        Making { fixed: &mut self.fixed, spectra, wavelengths: N }
    }
}

impl<const N: usize> Surface for Filmed<N> {
    fn scattered(&self) -> f32 {
        self.fixed.scattered
    }

    fn peak(&self) -> f32 {
        let alpha = self.fixed.alpha_mean();
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
