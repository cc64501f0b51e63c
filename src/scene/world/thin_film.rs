//! Films on surfaces so thin that what their two faces reflect interferes.

use crate::math::{Fault, Range};
use crate::spectrum::{Role, Spectrum};

/// Thicknesses in nanometers of which the phases are known in single precision.
const THICKNESS: Range = Range::new("from 0 to 100000 nm", |x| (0.0..=1e5).contains(&x));

/// A film of index eta - i k, the same all over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinFilm<S> {
    /// Real part of its index of refraction, greater than zero.
    pub eta: S,
    /// Its extinction coefficient, not negative.
    pub k: S,
    /// In nanometers in the world, in wavelengths in what is baked; from 0 to 100,000 nm.
    pub thickness: S,
    /// By how much of what a channel stands for fringes are blurred, within [0, 1]: 1 in the world
    /// unless a channel is one wavelength; half of the width over the wavelength in what is baked.
    pub spread: S,
}

impl ThinFilm<Spectrum> {
    /// With its index of refraction, and its thickness in nanometers.
    pub fn new(eta: impl Into<Spectrum>, k: impl Into<Spectrum>, thickness_nm: f32) -> Self {
        Self { eta: eta.into(), k: k.into(), thickness: thickness_nm.into(), spread: 1.0.into() }
    }

    /// Refuses what is no film.
    pub(super) fn check(&self) -> Result<(), Fault> {
        self.eta.check("film.eta", Range::POSITIVE)?;
        self.k.check("film.k", Range::NOT_NEGATIVE)?;
        self.thickness.check("film.thickness_nm", THICKNESS)?;
        self.spread.check("film.spread", Range::UNIT)
    }
}

impl<S> ThinFilm<S> {
    /// The film with `sample` of its spectra, each by the name of its key and by what it is.
    ///
    /// # Errors
    /// Those of `sample`.
    pub(super) fn sampled<T, E>(
        &self,
        sample: &mut impl FnMut(&S, &'static str, Role) -> Result<T, E>,
    ) -> Result<ThinFilm<T>, E> {
        Ok(ThinFilm {
            eta: sample(&self.eta, "film.eta", Role::Index)?,
            k: sample(&self.k, "film.k", Role::Index)?,
            thickness: sample(&self.thickness, "film.thickness_nm", Role::Waves)?,
            spread: sample(&self.spread, "film.spread", Role::Spread)?,
        })
    }
}
