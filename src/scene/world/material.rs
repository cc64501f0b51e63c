//! Materials: how surfaces scatter light, and whether they emit it.

use super::blend::check_blend;
use super::grain::{Grain, check_grain};
use super::layers::COAT_IOR;
use super::measured::MeasuredTable;
use super::plastic::Coat;
use super::sheet::Action;
use super::thin_film::{ThinFilm, check_film};
use crate::math::{Fault, Range};
use crate::polarization::{ALPHA_MIN, Distribution};
use crate::scene::error::SceneError;
use crate::scene::world::Layers;
use crate::spectrum::{D_NM, Spectrum, metal, metal_names};

/// How a material scatters light.
pub type Bsdf = SurfaceModel<Spectrum>;

/// A model of how surfaces scatter, with its parameters. Those that depend on the wavelength are
/// an `S`: a spectrum in the world, values at the wavelengths of the render in what is baked.
#[derive(Clone, Debug, PartialEq)]
pub enum SurfaceModel<S> {
    /// Absorbs everything.
    Absorber,
    /// Lambertian.
    Diffuse {
        /// Directional-hemispherical reflectance, within [0, 1].
        reflectance: S,
    },
    /// Smooth metal of index n - i k.
    Conductor {
        /// Real part n > 0 of the index of refraction.
        eta: S,
        /// Extinction coefficient k >= 0.
        k: S,
    },
    /// Rough metal of index n - i k: facets that are mirrors.
    RoughConductor {
        /// Real part n > 0 of the index of refraction.
        eta: S,
        /// Extinction coefficient k >= 0.
        k: S,
        /// Roughness of the facets, within [0, 1]: the root mean square of Beckmann's slopes, and
        /// the median of GGX's. What is below 0.001 is smooth.
        alpha: f32,
        /// How the normals of facets are distributed.
        distribution: Distribution,
        /// Whether light that several facets have reflected is there; it is depolarized. Without
        /// it rough metal is darker than smooth one.
        multiple_scattering: bool,
    },
    /// Rough boundary between two dielectrics: facets that reflect and refract.
    RoughDielectric {
        /// Index of refraction behind the front, greater than zero; in RGB it is that of the line
        /// d.
        ior: S,
        /// Index of refraction before the front, greater than zero; 1 in vacuum.
        exterior_ior: S,
        /// Roughness of the facets, as of [`SurfaceModel::RoughConductor`].
        alpha: f32,
        /// How the normals of facets are distributed.
        distribution: Distribution,
        /// Whether light that several facets have scattered is there; it is depolarized.
        multiple_scattering: bool,
    },
    /// glTF's metallic-roughness: a mixture of a rough metal of that color, and a Lambertian base
    /// of the color under a rough dielectric coat.
    MetallicRoughness {
        /// Reflectance of the base, and of the metal at normal incidence, within [0, 1].
        base_color: S,
        /// Share of metal, within [0, 1].
        metallic: f32,
        /// Roughness of the facets (GGX), within [0, 1]: the square of glTF's. At least 0.001 is
        /// computed with.
        alpha: f32,
        /// Index of refraction of the coat, from 1 to 10.
        ior: f32,
        /// Share of what the coat would reflect that is there, within [0, 1].
        specular: f32,
    },
    /// The same with more about it: walls that light goes through, a clear coat, cloth.
    Layered {
        /// What it consists of.
        layers: Layers<S>,
    },
    /// Plastic: a base that depolarizes, under a dielectric interface of facets that light goes
    /// through polarized on its way in and out.
    Plastic {
        /// Reflectance of the base, within [0, 1].
        reflectance: S,
        /// The interface.
        coat: Coat,
    },
    /// Reflectance that was measured, as Mueller matrices.
    Measured {
        /// The matrices.
        table: MeasuredTable,
        /// Where wavelengths are among those of the table: [`MeasuredTable::places`].
        places: S,
    },
    /// Two models, of which each scatters on a share of the surface.
    Blend {
        /// The two; see [`Bsdf::blend`].
        parts: Box<[SurfaceModel<S>; 2]>,
        /// Share of the second, within [0, 1].
        weight: f32,
    },
    /// Rough metal, rough glass or glTF's metallic-roughness with facets that are stretched along a
    /// direction, as those of brushed metal.
    Brushed {
        /// The model, with the roughness across the direction.
        of: Box<SurfaceModel<S>>,
        /// The direction, and the roughness along it.
        grain: Grain,
    },
    /// Rough metal, rough glass or glTF's metallic-roughness under a thin film: see
    /// [`Bsdf::filmed`]. Facets of less roughness than 0.001 are taken as of that, but for metal's.
    /// Indices of glass are its own, whatever it touches.
    Filmed {
        /// What is under it, whose facets may be stretched along a direction.
        of: Box<SurfaceModel<S>>,
        /// The film.
        film: ThinFilm<S>,
    },
    /// Smooth boundary between two dielectrics.
    Dielectric {
        /// Index of refraction behind the front, greater than zero.
        ior: f32,
        /// Index of refraction before the front, greater than zero; 1 in vacuum.
        exterior_ior: f32,
    },
    /// The same with indices that depend on the wavelength. In RGB they are those of the line d,
    /// 587.56 nm.
    DispersiveDielectric {
        /// Index of refraction behind the front, greater than zero.
        ior: S,
        /// Index of refraction before the front, greater than zero; 1 in vacuum.
        exterior_ior: S,
    },
    /// Smooth metal of index n - i k under a thin film.
    FilmedConductor {
        /// Real part n > 0 of the index of refraction.
        eta: S,
        /// Extinction coefficient k >= 0.
        k: S,
        /// The film.
        film: ThinFilm<S>,
    },
    /// Smooth boundary between two dielectrics under a thin film. Its indices are its own, whatever
    /// it touches.
    FilmedDielectric {
        /// Index of refraction behind the front, greater than zero.
        ior: f32,
        /// Index of refraction before the front, greater than zero; 1 in vacuum.
        exterior_ior: f32,
        /// The film.
        film: ThinFilm<S>,
    },
    /// Pane of a dielectric, thin beside the scene but thick beside the wavelength: all reflections
    /// within it add up, without interference, and light goes straight on. Its indices may depend
    /// on the wavelength; in RGB they are those of the line d.
    ThinDielectric {
        /// Index of refraction of the pane, greater than zero.
        ior: S,
        /// Index of refraction on both sides, greater than zero; 1 in vacuum.
        exterior_ior: S,
    },
    /// Sheet polarizer.
    Polarizer {
        /// Transmission axis from the node's x axis, counter-clockwise about the front's normal.
        axis_deg: f64,
        /// Greatest over least transmittance, at least 1; infinite for an ideal polarizer.
        extinction_ratio: f64,
    },
    /// Linear retarder.
    Retarder {
        /// Fast axis from the node's x axis, counter-clockwise about the front's normal.
        axis_deg: f64,
        /// Retardance in degrees.
        retardance_deg: f64,
    },
    /// Sheet that does more than those two: polarizers by their transmittances, retarders with
    /// dispersion, circular polarizers, Mueller matrices.
    Sheet {
        /// Its axis from the node's x axis, counter-clockwise about the front's normal.
        axis_deg: f64,
        /// What it does to light in the frame of the axis.
        action: Action<S>,
    },
    /// Nothing but a boundary between media of the same index of refraction.
    Null,
}

impl Bsdf {
    /// A Lambertian reflector: a number, or red, green and blue, within [0, 1].
    pub fn diffuse(reflectance: impl Into<Spectrum>) -> Self {
        Self::Diffuse { reflectance: reflectance.into() }
    }

    /// A smooth metal, by its chemical symbol.
    ///
    /// # Errors
    /// When it is not tabulated; the error lists those that are.
    pub fn metal(symbol: &str) -> Result<Self, SceneError> {
        let (eta, k) = tabulated(symbol).map_err(|fault| SceneError::at("material", fault))?;
        Ok(Self::Conductor { eta, k })
    }

    /// A rough metal (GGX, with multiple scattering), by its chemical symbol; see
    /// [`Bsdf::RoughConductor`].
    ///
    /// # Errors
    /// When it is not tabulated; the error lists those that are.
    pub fn rough_metal(symbol: &str, alpha: f32) -> Result<Self, SceneError> {
        let (eta, k) = tabulated(symbol).map_err(|fault| SceneError::at("material", fault))?;
        Ok(Self::RoughConductor {
            eta,
            k,
            alpha,
            distribution: Distribution::default(),
            multiple_scattering: true,
        })
    }

    /// A smooth boundary between dielectrics of some indices of refraction, behind the front and
    /// before it; it disperses light if one of them depends on the wavelength.
    pub fn boundary(ior: impl Into<Spectrum>, exterior_ior: impl Into<Spectrum>) -> Self {
        match (ior.into(), exterior_ior.into()) {
            (Spectrum::Constant(ior), Spectrum::Constant(exterior_ior)) => {
                Self::Dielectric { ior, exterior_ior }
            }
            (ior, exterior_ior) => Self::DispersiveDielectric { ior, exterior_ior },
        }
    }

    /// A smooth boundary to a dielectric of an index of refraction, in vacuum.
    pub fn dielectric(ior: f32) -> Self {
        Self::Dielectric { ior, exterior_ior: 1.0 }
    }

    /// A thin pane of an index of refraction, in vacuum; see [`Bsdf::ThinDielectric`].
    pub fn thin_dielectric(ior: impl Into<Spectrum>) -> Self {
        Self::ThinDielectric { ior: ior.into(), exterior_ior: Spectrum::Constant(1.0) }
    }

    /// An ideal sheet polarizer; see [`Bsdf::Polarizer`].
    pub fn polarizer(axis_deg: f64) -> Self {
        Self::Polarizer { axis_deg, extinction_ratio: f64::INFINITY }
    }

    /// A linear retarder; see [`Bsdf::Retarder`].
    pub fn retarder(axis_deg: f64, retardance_deg: f64) -> Self {
        Self::Retarder { axis_deg, retardance_deg }
    }

    /// The same without dispersion: light is refracted, and reflected by panes, as that of the line
    /// d. `sample` gives an index of refraction there, by the name of its key.
    ///
    /// # Errors
    /// Those of `sample`.
    pub(crate) fn undispersed<E>(
        &self,
        mut sample: impl FnMut(&Spectrum, &'static str, f32) -> Result<f32, E>,
    ) -> Result<Self, E> {
        let mut at_d = |ior, exterior_ior| {
            Ok([sample(ior, "ior", D_NM)?, sample(exterior_ior, "exterior_ior", D_NM)?])
        };
        match self {
            Self::DispersiveDielectric { ior, exterior_ior } => {
                let [ior, exterior_ior] = at_d(ior, exterior_ior)?;
                Ok(Self::Dielectric { ior, exterior_ior })
            }
            Self::ThinDielectric { ior, exterior_ior } => {
                let [ior, exterior_ior] = at_d(ior, exterior_ior)?.map(Spectrum::Constant);
                Ok(Self::ThinDielectric { ior, exterior_ior })
            }
            &Self::RoughDielectric {
                ref ior,
                ref exterior_ior,
                alpha,
                distribution,
                multiple_scattering,
            } => {
                let [ior, exterior_ior] = at_d(ior, exterior_ior)?.map(Spectrum::Constant);
                Ok(Self::RoughDielectric {
                    ior,
                    exterior_ior,
                    alpha,
                    distribution,
                    multiple_scattering,
                })
            }
            Self::Brushed { of, grain } => {
                Ok(Self::brushed(of.undispersed_within(&mut sample)?, *grain))
            }
            Self::Absorber
            | Self::Diffuse { .. }
            | Self::Conductor { .. }
            | Self::RoughConductor { .. }
            | Self::MetallicRoughness { .. }
            | Self::Layered { .. }
            | Self::Plastic { .. }
            | Self::Measured { .. }
            | Self::Blend { .. }
            | Self::Filmed { .. }
            | Self::FilmedConductor { .. }
            | Self::FilmedDielectric { .. }
            | Self::Dielectric { .. }
            | Self::Polarizer { .. }
            | Self::Retarder { .. }
            | Self::Sheet { .. }
            | Self::Null => Ok(self.clone()),
        }
    }

    /// Whether light of other wavelengths may be refracted in other ways.
    pub(crate) fn disperses(&self) -> bool {
        match self {
            Self::DispersiveDielectric { ior, exterior_ior } => {
                [ior, exterior_ior].into_iter().any(|of| !of.is_flat())
            }
            // Facets send all wavelengths the same ways, unless it is smooth.
            Self::RoughDielectric { ior, exterior_ior, alpha, .. } if *alpha < ALPHA_MIN => {
                [ior, exterior_ior].into_iter().any(|of| !of.is_flat())
            }
            Self::Brushed { of, grain } => of.is_smooth(grain) && of.disperses(),
            Self::Absorber
            | Self::Diffuse { .. }
            | Self::Conductor { .. }
            | Self::RoughConductor { .. }
            | Self::RoughDielectric { .. }
            | Self::MetallicRoughness { .. }
            | Self::Layered { .. }
            | Self::Plastic { .. }
            | Self::Measured { .. }
            | Self::Blend { .. }
            | Self::Filmed { .. }
            | Self::FilmedConductor { .. }
            | Self::FilmedDielectric { .. }
            | Self::Dielectric { .. }
            | Self::ThinDielectric { .. }
            | Self::Polarizer { .. }
            | Self::Retarder { .. }
            | Self::Sheet { .. }
            | Self::Null => false,
        }
    }

    /// Refuses what no surface does.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        match self {
            // Tables are checked as they are read.
            Self::Absorber | Self::Measured { .. } | Self::Null => Ok(()),
            Self::Diffuse { reflectance } => reflectance.check("reflectance", Range::UNIT),
            Self::Conductor { eta, k } => check_metal(eta, k),
            Self::FilmedConductor { eta, k, film } => {
                check_metal(eta, k)?;
                film.check()
            }
            Self::FilmedDielectric { ior, exterior_ior, film } => {
                let [ior, exterior_ior] = [*ior, *exterior_ior].map(Spectrum::Constant);
                check_indices(&ior, &exterior_ior)?;
                film.check()
            }
            Self::RoughConductor { eta, k, alpha, distribution: _, multiple_scattering: _ } => {
                check_metal(eta, k)?;
                Range::UNIT.check("alpha", *alpha)
            }
            Self::RoughDielectric {
                ior,
                exterior_ior,
                alpha,
                distribution: _,
                multiple_scattering: _,
            } => {
                check_indices(ior, exterior_ior)?;
                Range::UNIT.check("alpha", *alpha)
            }
            Self::MetallicRoughness { base_color, metallic, alpha, ior, specular } => {
                base_color.check("base_color", Range::UNIT)?;
                Range::UNIT.check("metallic", *metallic)?;
                Range::UNIT.check("alpha", *alpha)?;
                COAT_IOR.check("ior", *ior)?;
                Range::UNIT.check("specular", *specular)
            }
            Self::Layered { layers } => layers.check(),
            Self::Plastic { reflectance, coat } => {
                reflectance.check("reflectance", Range::UNIT)?;
                coat.check()
            }
            Self::Blend { parts, weight } => check_blend(parts, *weight),
            Self::Brushed { of, grain } => check_grain(of, grain),
            Self::Filmed { of, film } => check_film(of, film),
            Self::Dielectric { ior, exterior_ior } => {
                let [ior, exterior_ior] = [*ior, *exterior_ior].map(Spectrum::Constant);
                check_indices(&ior, &exterior_ior)
            }
            Self::DispersiveDielectric { ior, exterior_ior }
            | Self::ThinDielectric { ior, exterior_ior } => check_indices(ior, exterior_ior),
            Self::Polarizer { axis_deg, extinction_ratio } => {
                Range::ANY.check("axis_deg", *axis_deg)?;
                if *extinction_ratio == f64::INFINITY {
                    return Ok(());
                }
                Range::AT_LEAST_ONE.check("extinction_ratio", *extinction_ratio)
            }
            Self::Retarder { axis_deg, retardance_deg } => {
                Range::ANY.check("axis_deg", *axis_deg)?;
                Range::ANY.check("retardance_deg", *retardance_deg)
            }
            Self::Sheet { axis_deg, action } => {
                Range::ANY.check("axis_deg", *axis_deg)?;
                action.check()
            }
        }
    }
}

/// The index of refraction n - i k of a metal, by its chemical symbol; the field of the fault is
/// `metal`.
pub(crate) fn tabulated(symbol: &str) -> Result<(Spectrum, Spectrum), Fault> {
    metal(symbol).ok_or_else(|| {
        let problem = format!("`{symbol}` is not tabulated");
        let names = metal_names().join(", ");
        let remedy = format!("use one of {names}, or give `eta` and `k`");
        Fault::new("metal", problem, remedy)
    })
}

/// Refuses an index of refraction n - i k that is none.
fn check_metal(eta: &Spectrum, k: &Spectrum) -> Result<(), Fault> {
    eta.check("eta", Range::POSITIVE)?;
    k.check("k", Range::NOT_NEGATIVE)
}

/// Refuses indices of refraction on two sides that are none, or whose ratio is no number.
pub(super) fn check_indices(ior: &Spectrum, exterior_ior: &Spectrum) -> Result<(), Fault> {
    ior.check("ior", Range::POSITIVE)?;
    exterior_ior.check("exterior_ior", Range::POSITIVE)?;
    let ends = |of: &Spectrum| {
        let values = of.values().iter().copied();
        values.fold([f32::INFINITY, 0.0_f32], |[least, most], it| [least.min(it), most.max(it)])
    };
    let ([least, most], [least_before, most_before]) = (ends(ior), ends(exterior_ior));
    for ratio in [least / most_before, most / least_before] {
        Range::POSITIVE.check("ior over exterior_ior", ratio)?;
    }
    Ok(())
}

/// Where light that goes through a surface gets to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passage {
    /// Nowhere: nothing passes.
    Closed,
    /// Behind a sheet, which bounds media only where the scene states some.
    Sheet,
    /// Into a body that displaces what is around it: clear space, unless the scene states more.
    Body,
    /// Behind a mere boundary: whatever fills the scene, unless the scene states more.
    Boundary,
}

impl<S> SurfaceModel<S> {
    /// Where light that goes through gets to.
    pub fn passage(&self) -> Passage {
        match self {
            Self::Layered { layers } if layers.transmits() => Passage::Sheet,
            Self::Blend { parts, .. } if parts.iter().any(Self::transmits) => Passage::Sheet,
            Self::Brushed { of, .. } | Self::Filmed { of, .. } => of.passage(),
            Self::Absorber
            | Self::Diffuse { .. }
            | Self::Conductor { .. }
            | Self::RoughConductor { .. }
            | Self::FilmedConductor { .. }
            | Self::MetallicRoughness { .. }
            | Self::Layered { .. }
            | Self::Plastic { .. }
            | Self::Measured { .. }
            | Self::Blend { .. } => Passage::Closed,
            Self::Dielectric { .. }
            | Self::DispersiveDielectric { .. }
            | Self::FilmedDielectric { .. }
            | Self::RoughDielectric { .. } => Passage::Body,
            Self::ThinDielectric { .. }
            | Self::Polarizer { .. }
            | Self::Retarder { .. }
            | Self::Sheet { .. } => Passage::Sheet,
            Self::Null => Passage::Boundary,
        }
    }

    /// Whether light passes through to the other side.
    pub fn transmits(&self) -> bool {
        self.passage() != Passage::Closed
    }
}

/// Which sides of a material's surfaces reflect and emit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sides {
    /// Back like front; otherwise the back is black and dark.
    pub two_sided: bool,
}

/// Light that leaves a material's surfaces, the same in all directions, unpolarized.
#[derive(Clone, Debug, PartialEq)]
pub struct Emission {
    /// Radiance in W/(m^2 sr); not negative. Zero throughout emits nothing.
    pub radiance: Spectrum,
}

impl Emission {
    /// Whether it is more than nothing.
    pub(in crate::scene) fn emits(&self) -> bool {
        self.radiance.values().iter().any(|value| *value > 0.0)
    }

    /// Refuses what cannot be emitted.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        self.radiance.check("radiance", Range::NOT_NEGATIVE)
    }
}

/// What [`World::add_material`](super::World::add_material) makes a material of: the components
/// of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// How it scatters light.
    pub bsdf: Bsdf,
    /// Which sides do.
    pub sides: Sides,
    /// What it emits.
    pub emission: Option<Emission>,
}

impl Material {
    /// Absorbs everything and emits a radiance in W/(m^2 sr).
    pub fn emitter(radiance: impl Into<Spectrum>) -> Self {
        Self::from(Bsdf::Absorber).emitting(radiance)
    }

    /// The same material, which emits a radiance in W/(m^2 sr) too.
    #[must_use]
    pub fn emitting(self, radiance: impl Into<Spectrum>) -> Self {
        Self { emission: Some(Emission { radiance: radiance.into() }), ..self }
    }

    /// The same material, whose back is like its front.
    #[must_use]
    pub fn two_sided(self) -> Self {
        Self { sides: Sides { two_sided: true }, ..self }
    }
}

/// One-sided, and it does not emit.
impl From<Bsdf> for Material {
    fn from(bsdf: Bsdf) -> Self {
        Self { bsdf, sides: Sides::default(), emission: None }
    }
}

/// Refuses components of a material that are wrong, or do not go together.
pub(super) fn check_material(bsdf: &Bsdf, emission: Option<&Emission>) -> Result<(), Fault> {
    bsdf.check()?;
    emission.map_or(Ok(()), Emission::check)
}
