//! Media of keyword arguments, which are those of the scene files.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use sunstone::Spectrum;
use sunstone::particles::{Amount, Milk, Sizes};
use sunstone::world::{Component, Medium, Phase, Spheres, TabulatedMatrix};

use crate::keys::Keys;
use crate::spectra::Part;

/// Values of `phase`.
const PHASES: &str = "use one of hg, isotropic, mie, mueller_table, rayleigh";
/// Values of a distribution's `kind`.
const KINDS: &str = "use one of gamma, log_normal, monodisperse, table";
/// Elements of a table, in the order of the library.
const ELEMENTS: [&str; 6] = ["m00", "m01", "m11", "m22", "m23", "m33"];

/// A medium.
pub fn medium(keys: Keys) -> PyResult<Medium> {
    let model: String = keys.need("phase", PHASES)?;
    let (sigma_a, sigma_s) = (keys.spectrum("sigma_a")?, keys.spectrum("sigma_s")?);
    let phase = match model.as_str() {
        "hg" => {
            let remedy = "give the mean cosine of the scattering angle, within (-1, 1)";
            Phase::HenyeyGreenstein { g: keys.need_spectrum("g", remedy)? }
        }
        "isotropic" => Phase::isotropic(),
        "mie" => mie(&keys)?,
        "mueller_table" => {
            let table: Bound<PyDict> = keys.need("table", "give the columns by name")?;
            Phase::Table(matrices(&keys, &table)?)
        }
        "rayleigh" => {
            Phase::Rayleigh { depolarization: keys.take("depolarization")?.unwrap_or(0.0) }
        }
        model => {
            let problem = format!("`{model}` is not a phase function");
            return Err(keys.refuse("phase", &problem, PHASES));
        }
    };
    keys.finish(&format!("the phase function {model}"))?;
    Ok(Medium { sigma_a, sigma_s, phase })
}

fn mie(keys: &Keys) -> PyResult<Phase> {
    let particles: Option<Vec<Bound<PyDict>>> = keys.take("particles")?;
    match (keys.part("milk")?, particles, keys.part("host")?) {
        (Some(milk), None, None) => {
            let remedy = "whole milk has 3.5 % fat and 3.4 % protein";
            let phase = Phase::Milk(Milk {
                fat_percent: milk.need("fat_percent", remedy)?,
                protein_percent: milk.need("protein_percent", remedy)?,
                dilution: milk.take("dilution")?.unwrap_or(1.0),
            });
            milk.finish("milk")?;
            Ok(phase)
        }
        (None, Some(particles), Some(host)) => {
            let components = particles.iter().enumerate().map(|(index, particles)| {
                component(Keys::of(keys.place_of(&format!("particles[{index}]")), particles)?)
            });
            let components = components.collect::<PyResult<_>>()?;
            let (host_eta, host_k) = index(&host)?;
            host.finish("a host")?;
            Ok(Phase::Spheres(Spheres { components, host_eta, host_k }))
        }
        _ => {
            let problem = "mie takes either `milk` or both `particles` and `host`";
            Err(keys.refuse("", problem, "state what scatters once"))
        }
    }
}

/// Index of refraction n - i k.
fn index(keys: &Keys) -> PyResult<(Spectrum, Spectrum)> {
    let Some(eta) = keys.refraction("eta", Part::Real)? else {
        let remedy = "give the real part of the index of refraction";
        return Err(keys.refuse("eta", "is missing", remedy));
    };
    Ok((eta, keys.refraction("k", Part::Extinction)?.unwrap_or(0.0.into())))
}

fn component(keys: Keys) -> PyResult<Component> {
    let Some(distribution) = keys.part("distribution")? else {
        return Err(keys.refuse("distribution", "is missing", "give the sizes of the particles"));
    };
    let sizes = sizes(distribution)?;
    let (eta, k) = index(&keys)?;
    let remedy = "give the share of the volume that the particles fill";
    let volume_fraction = keys.need("volume_fraction", remedy)?;
    keys.finish("particles")?;
    Ok(Component { sizes, eta, k, volume_fraction })
}

fn sizes(keys: Keys) -> PyResult<Sizes> {
    let kind: String = keys.need("kind", KINDS)?;
    let radius = |key: &str| keys.need::<f64>(key, "give it in micrometers");
    let sizes = match kind.as_str() {
        "monodisperse" => Sizes::monodisperse(radius("radius_um")?),
        "table" => {
            let remedy = "give the radii and the density at each";
            let radii: Vec<f64> = keys.need("radii_um", remedy)?;
            let density: Vec<f64> = keys.need("density", remedy)?;
            Sizes::table(&radii, &density, amount(&keys)?)
        }
        "gamma" | "log_normal" => {
            let (mean, sd) = (radius("mean_um")?, radius("sd_um")?);
            let (of, range) = (amount(&keys)?, keys.take::<[f64; 2]>("range_um")?);
            match kind.as_str() {
                "gamma" => Sizes::gamma(mean, sd, of, range),
                _ => Sizes::log_normal(mean, sd, of, range),
            }
        }
        kind => {
            let problem = format!("`{kind}` is not a distribution");
            return Err(keys.refuse("kind", &problem, KINDS));
        }
    };
    let sizes = sizes.map_err(|fault| keys.fault(&fault))?;
    keys.finish(&format!("the distribution {kind}"))?;
    Ok(sizes)
}

/// What the density counts.
fn amount(keys: &Keys) -> PyResult<Amount> {
    let remedy = "use \"number\" or \"volume\"";
    match keys.need::<String>("of", remedy)?.as_str() {
        "number" => Ok(Amount::Number),
        "volume" => Ok(Amount::Volume),
        other => {
            let problem = format!("`{other}` is not what a density counts");
            Err(keys.refuse("of", &problem, remedy))
        }
    }
}

/// Phase matrices of columns by name, a block of rows for each wavelength.
fn matrices(keys: &Keys, table: &Bound<PyDict>) -> PyResult<Vec<TabulatedMatrix>> {
    let columns = Keys::of(keys.place_of("table"), table)?;
    let remedy = "the columns are theta_deg, m00, m01, m22, m23, and perhaps m11, m33, lambda_nm";
    let theta: Vec<f64> = columns.need("theta_deg", remedy)?;
    let wavelengths: Option<Vec<f64>> = columns.take("lambda_nm")?;
    let mut elements: Vec<Vec<f64>> = Vec::new();
    for name in ELEMENTS {
        let column = match (columns.take(name)?, name) {
            (Some(column), _) => column,
            // As for spheres.
            (None, "m11") => elements[0].clone(),
            (None, "m33") => elements[3].clone(),
            (None, name) => return Err(columns.refuse(name, "is missing", remedy)),
        };
        elements.push(column);
    }
    if elements.iter().chain(&wavelengths).any(|column| column.len() != theta.len()) {
        return Err(columns.refuse("", "has columns of different lengths", remedy));
    }
    columns.finish("a phase matrix")?;
    let mut matrices: Vec<TabulatedMatrix> = Vec::new();
    for (row, theta_deg) in theta.into_iter().enumerate() {
        let wavelength_nm = wavelengths.as_ref().map(|column| column[row]);
        let values = std::array::from_fn(|element| elements[element][row]);
        match matrices.last_mut().filter(|last| last.wavelength_nm == wavelength_nm) {
            Some(last) => {
                last.theta_deg.push(theta_deg);
                last.elements.push(values);
            }
            None => matrices.push(TabulatedMatrix {
                wavelength_nm,
                theta_deg: vec![theta_deg],
                elements: vec![values],
            }),
        }
    }
    Ok(matrices)
}
