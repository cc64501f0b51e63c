//! Films on surfaces so thin that what their two faces reflect interferes.

use super::grain::sampled_within;
use super::{Bsdf, Parameter, SurfaceModel};
use crate::math::{Fault, Range};
use crate::spectrum::{Role, Spectrum};

/// Thicknesses in nanometers of which the phases are known in single precision.
const THICKNESS: Range = Range::new("from 0 to 100000 nm", |x| (0.0..=1e5).contains(&x));

/// A film of index eta - i k. What it covers and how thick it is may differ from place to place.
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
    /// The share of the surface that it covers, within [0, 1]; the rest is bare.
    pub share: f32,
    /// How thick it is over `thickness`, within [0, 1].
    pub portion: f32,
    /// That where a picture of it is black, and where it is white, within [0, 1].
    pub portions: [f32; 2],
}

impl ThinFilm<Spectrum> {
    /// With its index of refraction, and its thickness in nanometers; it covers all.
    pub fn new(eta: impl Into<Spectrum>, k: impl Into<Spectrum>, thickness_nm: f32) -> Self {
        Self {
            eta: eta.into(),
            k: k.into(),
            thickness: thickness_nm.into(),
            spread: 1.0.into(),
            share: 1.0,
            portion: 1.0,
            portions: [0.0, 1.0],
        }
    }

    /// The same, which is so many nanometers thick where a picture of that is black, and where it
    /// is white; without one, it is as where it is white.
    #[must_use]
    pub fn between(self, [black_nm, white_nm]: [f32; 2]) -> Self {
        let most = black_nm.max(white_nm);
        let of = |nm: f32| if most > 0.0 { nm / most } else { 0.0 };
        let portions = [of(black_nm), of(white_nm)];
        Self { thickness: most.into(), portion: portions[1], portions, ..self }
    }

    /// Refuses what is no film.
    pub(super) fn check(&self) -> Result<(), Fault> {
        self.eta.check("film.eta", Range::POSITIVE)?;
        self.k.check("film.k", Range::NOT_NEGATIVE)?;
        self.thickness.check("film.thickness_nm", THICKNESS)?;
        self.spread.check("film.spread", Range::UNIT)?;
        Range::UNIT.check("film.share", self.share)?;
        let portions = self.portions.iter().chain([&self.portion]);
        portions.copied().try_for_each(|portion| Range::UNIT.check("film.portion", portion))
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
            share: self.share,
            portion: self.portion,
            portions: self.portions,
        })
    }

    /// Gives it another value of a parameter; false if it has no such parameter.
    pub(super) fn set(&mut self, parameter: Parameter, number: f32) -> bool {
        let [black, white] = self.portions;
        if parameter == Parameter::FilmShare {
            self.share = number;
        } else if parameter == Parameter::FilmThickness {
            self.portion = black + (white - black) * number;
        } else {
            return false;
        }
        true
    }
}

/// Refuses films on what cannot have one here.
pub(super) fn check_film(of: &Bsdf, film: &ThinFilm<Spectrum>) -> Result<(), Fault> {
    of.check()?;
    film.check()?;
    let refused = |problem: &str, remedy: &str| Err(Fault::new("film", problem, remedy));
    match of.without_grain() {
        SurfaceModel::RoughConductor { .. } => Ok(()),
        SurfaceModel::RoughDielectric { ior, exterior_ior, .. } if ior == exterior_ior => refused(
            "facets between equal indices of refraction do not refract, whatever is on them",
            "make it a smooth dielectric",
        ),
        SurfaceModel::RoughDielectric {
            ior: Spectrum::Constant(_),
            exterior_ior: Spectrum::Constant(_),
            ..
        } => Ok(()),
        SurfaceModel::RoughDielectric { .. } | SurfaceModel::DispersiveDielectric { .. } => {
            refused(
                "films on glass with dispersion are not supported",
                "give indices that are numbers",
            )
        }
        SurfaceModel::MetallicRoughness { .. } => match film.k == Spectrum::Constant(0.0) {
            true => Ok(()),
            false => refused("of glTF's metallic-roughness absorbs", "take its `k` away"),
        },
        SurfaceModel::Absorber
        | SurfaceModel::Diffuse { .. }
        | SurfaceModel::Conductor { .. }
        | SurfaceModel::Layered { .. }
        | SurfaceModel::Plastic { .. }
        | SurfaceModel::Measured { .. }
        | SurfaceModel::Blend { .. }
        | SurfaceModel::Brushed { .. }
        | SurfaceModel::Filmed { .. }
        | SurfaceModel::FilmedConductor { .. }
        | SurfaceModel::FilmedDielectric { .. }
        | SurfaceModel::Dielectric { .. }
        | SurfaceModel::ThinDielectric { .. }
        | SurfaceModel::Polarizer { .. }
        | SurfaceModel::Retarder { .. }
        | SurfaceModel::Sheet { .. }
        | SurfaceModel::Null => refused(
            "this model has none",
            "use a conductor, glass without dispersion, or glTF's metallic-roughness",
        ),
    }
}

impl Bsdf {
    /// A surface under a thin film: smooth or rough metal, a smooth or rough boundary of glass
    /// without dispersion, or glTF's metallic-roughness; of the rough ones, facets may be stretched
    /// along a direction. Others are refused where they are added to a world.
    ///
    /// ```
    /// use sunstone::world::{Bsdf, ThinFilm, World};
    ///
    /// let mut world = World::new("kitchen");
    /// let oxide = ThinFilm::new(2.4, 0.0, 60.0);
    /// world.add_material("pan", Bsdf::rough_metal("Ti", 0.1)?.filmed(oxide))?;
    /// # Ok::<(), sunstone::SceneError>(())
    /// ```
    #[must_use]
    pub fn filmed(self, film: ThinFilm<Spectrum>) -> Self {
        self.under(film)
    }
}

/// A model under a film with `sample` of their spectra: see [`SurfaceModel::sampled`].
pub(super) fn filmed_within<S, T, E>(
    of: &SurfaceModel<S>,
    film: &ThinFilm<S>,
    // By way of a pointer, or each depth would be a function of its own.
    mut sample: &mut dyn FnMut(&S, &'static str, Role) -> Result<T, E>,
) -> Result<SurfaceModel<T>, E> {
    let of = sampled_within(of, sample)?;
    Ok(SurfaceModel::Filmed { of, film: film.sampled(&mut sample)? })
}

impl<S> SurfaceModel<S> {
    /// See [`Bsdf::filmed`].
    pub(super) fn under(self, film: ThinFilm<S>) -> Self {
        if let Self::Conductor { eta, k } = self {
            return Self::FilmedConductor { eta, k, film };
        }
        if let Self::Dielectric { ior, exterior_ior } = self {
            return Self::FilmedDielectric { ior, exterior_ior, film };
        }
        Self::Filmed { of: Box::new(self), film }
    }

    /// The model without its film, if that is a part of its own.
    pub(crate) fn without_film(&self) -> &Self {
        if let Self::Filmed { of, .. } = self { of } else { self }
    }
}
