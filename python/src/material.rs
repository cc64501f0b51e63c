//! Materials of keyword arguments, which are those of the scene files.

use pyo3::prelude::*;
use sunstone::spectra::{metal, metal_names};
use sunstone::world::{
    Action, Bsdf, Coat, Delay, EmittedStokes, Grid, Hand, InternalReflection, Material,
    MeasuredTable, Sides, Textures, ThinFilm,
};
use sunstone::{Distribution, Spectrum};

use crate::keys::Keys;
use crate::spectra::Part;
use crate::textures::textures;

/// Index of refraction that glTF gives to dielectrics.
const IOR: f32 = 1.5;
/// Reflectance of what does not state one.
const REFLECTANCE: f32 = 0.8;

/// Values of `bsdf`.
const MODELS: &str = "use one of absorber, circular_polarizer, conductor, dielectric, diffuse, \
                      measured, mueller, null, plastic, polarizer, retarder, rough_conductor, \
                      rough_dielectric, thin_dielectric";

/// A material with what is said of it besides.
pub struct Made {
    /// The material.
    pub material: Material,
    /// How what it emits is polarized.
    pub stokes: Option<EmittedStokes>,
    /// Whether it emits by its heat.
    pub incandescent: bool,
    /// What of it differs from place to place.
    pub textures: Textures,
}

/// What parameters are that are not stated, where pictures multiply them or not.
struct Defaults {
    reflectance: f32,
    alpha: Option<f32>,
}

impl Defaults {
    fn of(painted: Option<&Keys>) -> PyResult<Self> {
        let has = |slot| painted.map_or(Ok(false), |painted| painted.has(slot));
        Ok(Self {
            reflectance: if has("reflectance")? { 1.0 } else { REFLECTANCE },
            alpha: has("alpha")?.then_some(1.0),
        })
    }
}

/// A material by its keys.
pub fn material(keys: Keys) -> PyResult<Made> {
    let model: String = keys.need("bsdf", MODELS)?;
    let two_sided = keys.flag("two_sided")?;
    let emission = keys.lamp("emission")?;
    let stokes = keys.stokes("stokes")?;
    if stokes.is_some() && emission.is_none() {
        let problem = "is the state of what is emitted, and nothing is";
        return Err(keys.refuse("stokes", problem, "add an emission"));
    }
    let incandescent = keys.flag("incandescent")?;
    let painted = keys.part("textures")?;
    let bsdf = bsdf(&keys, &model, &Defaults::of(painted.as_ref())?)?;
    let material = Material { bsdf, sides: Sides { two_sided }, emission: None };
    let material = match emission {
        Some(radiance) => material.emitting(radiance),
        None => material,
    };
    let textures = textures(&keys, painted, &material)?;
    keys.finish(&format!("a material of bsdf \"{model}\""))?;
    Ok(Made { material, stokes, incandescent, textures })
}

fn bsdf(keys: &Keys, model: &str, or: &Defaults) -> PyResult<Bsdf> {
    let axis_deg = || Ok::<f64, PyErr>(keys.take("axis_deg")?.unwrap_or(0.0));
    Ok(match model {
        "absorber" => Bsdf::Absorber,
        "conductor" => conductor(keys)?,
        "dielectric" => {
            let [ior, exterior_ior] = indices(keys)?;
            filmed(Bsdf::boundary(ior, exterior_ior), keys)?
        }
        "diffuse" => Bsdf::diffuse(keys.spectrum("reflectance")?.unwrap_or(or.reflectance.into())),
        "null" => Bsdf::Null,
        "plastic" => plastic(keys, or)?,
        "circular_polarizer" => {
            let hand: Option<String> = keys.take("handedness")?;
            let hand = match hand.as_deref() {
                None => Hand::default(),
                Some(name) => Hand::named(name).ok_or_else(|| {
                    let problem = format!("`{name}` is no sense of rotation");
                    keys.refuse("handedness", &problem, "use right or left")
                })?,
            };
            let retarder = delay(keys)?.unwrap_or(Delay::Degrees(90.0.into()));
            let action = Action::Circular { polarizer: grid(keys)?, retarder, hand };
            Bsdf::Sheet { axis_deg: axis_deg()?, action }
        }
        "measured" => {
            let bytes: Vec<u8> = keys.need("table", "the bytes of a file of tensors, `.pbsdf`")?;
            let read = MeasuredTable::new("table", bytes);
            let table = read.map_err(|fault| keys.fault(&fault.within("table")))?;
            Bsdf::Measured { places: table.places(), table }
        }
        "mueller" => {
            let axis_deg = axis_deg()?;
            Bsdf::Sheet { axis_deg, action: Action::Matrix(matrix(keys)?) }
        }
        "polarizer" => match (axis_deg()?, grid(keys)?) {
            (axis_deg, Grid { transmittance, blocked: Spectrum::Constant(blocked) })
                if transmittance == 1.0.into() =>
            {
                Bsdf::Polarizer { axis_deg, extinction_ratio: f64::from(blocked).recip() }
            }
            (axis_deg, grid) => Bsdf::Sheet { axis_deg, action: Action::Polarizer(grid) },
        },
        "retarder" => {
            let remedy = "90 for a quarter-wave plate, 180 for a half-wave plate";
            let missing = || keys.refuse("retardance_deg", "is missing", remedy);
            match (axis_deg()?, delay(keys)?.ok_or_else(missing)?) {
                (axis_deg, Delay::Degrees(Spectrum::Constant(degrees))) => {
                    Bsdf::retarder(axis_deg, degrees.into())
                }
                (axis_deg, delay) => Bsdf::Sheet { axis_deg, action: Action::Retarder(delay) },
            }
        }
        "rough_conductor" => rough_conductor(keys, or)?,
        "rough_dielectric" => {
            let [ior, exterior_ior] = indices(keys)?;
            let (alpha, distribution, multiple_scattering) = facets(keys, or)?;
            let bsdf = Bsdf::RoughDielectric {
                ior,
                exterior_ior,
                alpha,
                distribution,
                multiple_scattering,
            };
            filmed(bsdf, keys)?
        }
        "thin_dielectric" => {
            let [ior, exterior_ior] = indices(keys)?;
            Bsdf::ThinDielectric { ior, exterior_ior }
        }
        model => return Err(keys.refuse("bsdf", &format!("`{model}` is not a model"), MODELS)),
    })
}

/// Transmittances of a polarizer, of which that across the axis may follow from a ratio.
fn grid(keys: &Keys) -> PyResult<Grid<Spectrum>> {
    let transmittance = keys.spectrum("transmittance")?.unwrap_or(1.0.into());
    let blocked = match (keys.spectrum("blocked")?, keys.take::<f32>("extinction_ratio")?) {
        (Some(blocked), None) => blocked,
        (None, None) => 0.0.into(),
        (None, Some(ratio)) if ratio >= 1.0 => transmittance.clone().scaled(ratio.recip()),
        (None, Some(ratio)) => {
            return Err(keys.refuse(
                "extinction_ratio",
                &format!("{ratio} must be at least 1"),
                "",
            ));
        }
        (Some(_), Some(_)) => {
            let problem = "a polarizer takes either `blocked` or `extinction_ratio`";
            return Err(keys.refuse("", problem, "remove one of them"));
        }
    };
    Ok(Grid { transmittance, blocked })
}

/// What a retarder does, if it is stated.
fn delay(keys: &Keys) -> PyResult<Option<Delay<Spectrum>>> {
    let degrees = keys.spectrum("retardance_deg")?;
    match (degrees, keys.spectrum("birefringence")?, keys.take::<f32>("thickness_um")?) {
        (None, None, None) => Ok(None),
        (Some(degrees), None, None) => Ok(Some(Delay::Degrees(degrees))),
        (None, Some(birefringence), Some(um)) => {
            let thickness = Spectrum::Constant(um * 1000.0);
            Ok(Some(Delay::Crystal { birefringence, thickness }))
        }
        _ => {
            let problem = "a retarder takes either `retardance_deg` or both `birefringence` and \
                           `thickness_um`";
            Err(keys.refuse("", problem, "state the retardance once"))
        }
    }
}

/// Four rows of four numbers.
fn matrix(keys: &Keys) -> PyResult<[Spectrum; 16]> {
    let rows: Vec<Vec<f32>> = keys.need("matrix", "four lists of four numbers")?;
    let is_square = rows.len() == 4 && rows.iter().all(|row| row.len() == 4);
    let elements: Vec<Spectrum> = rows.into_iter().flatten().map(Spectrum::Constant).collect();
    match <[Spectrum; 16]>::try_from(elements) {
        Ok(elements) if is_square => Ok(elements),
        _ => Err(keys.refuse("matrix", "is not 4 by 4", "give four lists of four numbers")),
    }
}

fn indices(keys: &Keys) -> PyResult<[Spectrum; 2]> {
    let [ior, exterior_ior] = [keys.index("ior")?, keys.index("exterior_ior")?];
    Ok([ior.unwrap_or(IOR.into()), exterior_ior.unwrap_or(1.0.into())])
}

fn conductor(keys: &Keys) -> PyResult<Bsdf> {
    let (eta, k) = metal_index(keys, "conductor")?;
    filmed(Bsdf::Conductor { eta, k }, keys)
}

/// A model under its film, if it has one.
fn filmed(bsdf: Bsdf, keys: &Keys) -> PyResult<Bsdf> {
    Ok(match film(keys)? {
        Some(film) => bsdf.filmed(film),
        None => bsdf,
    })
}

/// A thin film, if there is one.
fn film(keys: &Keys) -> PyResult<Option<ThinFilm<Spectrum>>> {
    let Some(film) = keys.part("film")? else { return Ok(None) };
    let remedy = "the real part of the film's index of refraction";
    let eta = film.refraction("eta", Part::Real)?;
    let eta = eta.ok_or_else(|| film.refuse("eta", "is missing", remedy))?;
    let k = film.refraction("k", Part::Extinction)?.unwrap_or(0.0.into());
    let thickness_nm: f32 = film.need("thickness_nm", "in nanometers, as 300")?;
    let share = film.take("share")?.unwrap_or(1.0);
    film.finish("a film")?;
    Ok(Some(ThinFilm { share, ..ThinFilm::new(eta, k, thickness_nm) }))
}

fn rough_conductor(keys: &Keys, or: &Defaults) -> PyResult<Bsdf> {
    let (eta, k) = metal_index(keys, "rough_conductor")?;
    let (alpha, distribution, multiple_scattering) = facets(keys, or)?;
    filmed(Bsdf::RoughConductor { eta, k, alpha, distribution, multiple_scattering }, keys)
}

/// What facets are like, and whether what several of them scatter is given back.
fn facets(keys: &Keys, or: &Defaults) -> PyResult<(f32, Distribution, bool)> {
    let distribution = distribution(keys)?;
    let multiple_scattering = keys.flag_or("multiple_scattering", true)?;
    Ok((alpha(keys, or.alpha)?, distribution, multiple_scattering))
}

fn plastic(keys: &Keys, or: &Defaults) -> PyResult<Bsdf> {
    let internal_reflection = match keys.take::<String>("internal_reflection")? {
        None => InternalReflection::default(),
        Some(name) => InternalReflection::named(&name).ok_or_else(|| {
            let problem = format!("`{name}` is not what becomes of light reflected within");
            keys.refuse("internal_reflection", &problem, "use one of lost, linear, nonlinear")
        })?,
    };
    Ok(Bsdf::Plastic {
        reflectance: keys.spectrum("reflectance")?.unwrap_or(or.reflectance.into()),
        coat: Coat {
            ior: number(keys, "ior", IOR)?,
            exterior_ior: number(keys, "exterior_ior", 1.0)?,
            alpha: alpha(keys, None)?,
            distribution: distribution(keys)?,
            specular: keys.take("specular")?.unwrap_or(1.0),
            internal_reflection,
        },
    })
}

/// An index of refraction that is one number.
fn number(keys: &Keys, key: &str, default: f32) -> PyResult<f32> {
    match keys.index(key)? {
        None => Ok(default),
        Some(Spectrum::Constant(value)) => Ok(value),
        Some(Spectrum::Rgb(_) | Spectrum::Table(_) | Spectrum::Formula(_)) => {
            Err(keys.refuse(key, "must be one number", "that of the sodium line, as 1.5"))
        }
    }
}

/// How the normals of facets are distributed.
fn distribution(keys: &Keys) -> PyResult<Distribution> {
    match keys.take::<String>("distribution")? {
        None => Ok(Distribution::default()),
        Some(name) => Distribution::named(&name).ok_or_else(|| {
            let problem = format!("`{name}` is not a distribution of facets");
            keys.refuse("distribution", &problem, "use ggx or beckmann")
        }),
    }
}

/// The roughness of facets: itself, or its root.
fn alpha(keys: &Keys, default: Option<f32>) -> PyResult<f32> {
    match (keys.take::<f32>("alpha")?.or(default), keys.take::<f32>("roughness")?) {
        (Some(alpha), None) => Ok(alpha),
        (None, Some(roughness)) if (0.0..=1.0).contains(&roughness) => Ok(roughness * roughness),
        (None, Some(roughness)) => {
            let problem = format!("{roughness} must be within [0, 1]");
            Err(keys.refuse("roughness", &problem, "it is the root of `alpha`"))
        }
        _ => {
            let problem = "facets take either `alpha` or `roughness`, its root";
            Err(keys.refuse("", problem, "both are within [0, 1]"))
        }
    }
}

/// The index of refraction of a metal of the model `name`.
fn metal_index(keys: &Keys, name: &str) -> PyResult<(Spectrum, Spectrum)> {
    let symbol: Option<String> = keys.take("metal")?;
    let [eta, k] = [keys.refraction("eta", Part::Real)?, keys.refraction("k", Part::Extinction)?];
    match (symbol, eta, k) {
        (Some(symbol), None, None) => metal(&symbol).ok_or_else(|| {
            let problem = format!("`{symbol}` is not tabulated");
            let names = metal_names().join(", ");
            keys.refuse("metal", &problem, &format!("use one of {names}, or give `eta` and `k`"))
        }),
        (None, Some(eta), Some(k)) => Ok((eta, k)),
        _ => {
            let problem = format!("a {name} takes either `metal` or both `eta` and `k`");
            let remedy = format!("with `metal` one of {}", metal_names().join(", "));
            Err(keys.refuse("", &problem, &remedy))
        }
    }
}
