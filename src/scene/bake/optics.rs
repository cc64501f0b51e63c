//! What a medium does to light at the wavelengths of the render: coefficients and phase function,
//! from numbers that the file gives or from the particles that it describes.

use std::f64::consts::PI;

use super::outside_table;
use super::phase::{self, Elements};
use crate::polarization::kept;
use crate::polarization::mie::PhaseElements;
use crate::polarization::milk::{MILK_WAVELENGTHS_NM, Milk};
use crate::polarization::particles::{Particles, Suspension};
use crate::scene::baked::{Medium, Phase};
use crate::scene::error::SceneError;
use crate::scene::world::{self, Spheres};
use crate::spectrum::{Asked, Color, OutsideTable, RGB_WAVELENGTHS_NM, Role, Spectrum};

/// Greatest size parameter of particles: more takes too long, and no table could hold its peak.
const SIZE_PARAMETER_MAX: f64 = 2000.0;

/// The row of a medium; `name` is how errors call it.
pub fn medium_row<const N: usize>(
    medium: &world::Medium,
    asked: Asked,
    name: &str,
) -> Result<Medium<N>, SceneError> {
    let outside = |error: OutsideTable| outside_table(name, error);
    let derived = match &medium.phase {
        world::Phase::HenyeyGreenstein { g } => Derived::of(Phase::HenyeyGreenstein {
            g: g.sample(asked, Role::Index).map_err(outside)?,
        }),
        world::Phase::Rayleigh { depolarization } => {
            Derived::of(Phase::Table(phase::rayleigh(*depolarization)))
        }
        world::Phase::Spheres(spheres) => suspended(spheres, asked, name)?,
        world::Phase::Milk(milk) => milked(milk, asked.color, name)?,
        world::Phase::Table(matrices) => {
            let table = phase::tabulated(matrices, wavelengths(asked.color)).map_err(outside)?;
            Derived::of(Phase::Table(table))
        }
    };
    let coefficient = |given: &Option<Spectrum>, derived: [f32; N]| match given {
        Some(spectrum) => spectrum.sample(asked, Role::Coefficient).map_err(outside),
        None => Ok(derived),
    };
    let sigma_a = coefficient(&medium.sigma_a, derived.sigma_a)?;
    let sigma_s = coefficient(&medium.sigma_s, derived.sigma_s)?;
    if let Some(sigma) = sigma_a.iter().chain(&sigma_s).find(|sigma| !sigma.is_finite()) {
        let problem = format!("has a coefficient of {sigma} 1/m");
        return Err(SceneError::new(name, problem, "check volume fractions and radii"));
    }
    Ok(Medium { sigma_a, sigma_s, phase: derived.phase })
}

/// A phase function, and the coefficients that go with it; zero where there are none.
struct Derived<const N: usize> {
    sigma_a: [f32; N],
    sigma_s: [f32; N],
    phase: Phase<N>,
}

impl<const N: usize> Derived<N> {
    fn of(phase: Phase<N>) -> Self {
        Self { sigma_a: [0.0; N], sigma_s: [0.0; N], phase }
    }
}

/// Wavelengths of the channels in nanometers.
fn wavelengths<const N: usize>(color: Color) -> [f64; N] {
    std::array::from_fn(|channel| match color {
        Color::Rgb => f64::from(RGB_WAVELENGTHS_NM[channel % RGB_WAVELENGTHS_NM.len()]),
        Color::Mono { wavelength_nm } => f64::from(wavelength_nm),
    })
}

fn elements_of(matrix: &[PhaseElements]) -> Vec<Elements> {
    let elements = |m: &PhaseElements| {
        let (m00, m01, m22, m23) = (m.m00, m.m01, m.m22, m.m23);
        Elements { m00, m01, m11: m00, m22, m23, m33: m22 }
    };
    matrix.iter().map(elements).collect()
}

/// Milk at the wavelengths of the render.
fn milked<const N: usize>(milk: &Milk, color: Color, name: &str) -> Result<Derived<N>, SceneError> {
    let wavelengths = wavelengths::<N>(color);
    let [first, last] = MILK_WAVELENGTHS_NM;
    if let Some(nm) = wavelengths.iter().find(|nm| !(first..=last).contains(nm)) {
        let problem = format!("milk is tabulated from {first} to {last} nm, not at {nm} nm");
        return Err(SceneError::new(name, problem, "render within the table"));
    }
    let sizes = wavelengths.map(|nm| milk.size_parameter_max(nm));
    let intervals = phase::intervals(sizes.into_iter().fold(0.0, f64::max));
    let optics =
        wavelengths.map(|nm| (kept::scattering(&milk.suspension(nm), intervals), milk.serum(nm)));
    let sigma_a = optics.each_ref().map(|(found, serum)| {
        (found.sigma_a + serum.sigma_a_riboflavin + serum.sigma_a_water) as f32
    });
    let sigma_s = optics.each_ref().map(|(found, _)| found.sigma_s as f32);
    let matrices = optics.map(|(found, _)| elements_of(&found.matrix));
    Ok(Derived { sigma_a, sigma_s, phase: Phase::Table(phase::table(&matrices)) })
}

/// Spheres in their host at the wavelengths of the render.
fn suspended<const N: usize>(
    spheres: &Spheres,
    asked: Asked,
    name: &str,
) -> Result<Derived<N>, SceneError> {
    let sample = |spectrum: &Spectrum| {
        spectrum.sample::<N>(asked, Role::Index).map_err(|error| outside_table(name, error))
    };
    let host_k = sample(&spheres.host_k)?;
    let suspensions = suspensions(spheres, asked, name)?;
    let largest = suspensions.iter().map(Suspension::size_parameter_max).fold(0.0, f64::max);
    if largest > SIZE_PARAMETER_MAX {
        let problem = format!("has particles of size parameter {largest:.0}");
        let remedy = format!("keep it below {SIZE_PARAMETER_MAX}, or use hg or mueller_table");
        return Err(SceneError::new(name, problem, remedy));
    }
    let scattering = suspensions.map(|suspension| {
        let found = kept::scattering(&suspension, phase::intervals(largest));
        (found, suspension.wavelength_nm)
    });
    let filled: f64 = spheres.components.iter().map(|component| component.volume_fraction).sum();
    let sigma_a = std::array::from_fn(|channel| {
        let (found, nm) = &scattering[channel];
        // The host absorbs where there are no particles.
        let host = 4.0 * PI * f64::from(host_k[channel]) / (1e-9 * nm);
        (found.sigma_a + (1.0 - filled).max(0.0) * host) as f32
    });
    let sigma_s = scattering.each_ref().map(|(found, _)| found.sigma_s as f32);
    let matrices = scattering.map(|(found, _)| elements_of(&found.matrix));
    if matrices.iter().flatten().any(|m| !(m.m00.is_finite() && m.m00 > 0.0)) {
        let problem = "the series of its particles does not converge";
        return Err(SceneError::new(name, problem, "check radii and indices of refraction"));
    }
    Ok(Derived { sigma_a, sigma_s, phase: Phase::Table(phase::table(&matrices)) })
}

/// The spheres and their host, one wavelength each.
fn suspensions<'a, const N: usize>(
    spheres: &'a Spheres,
    asked: Asked,
    name: &str,
) -> Result<[Suspension<'a>; N], SceneError> {
    let sample = |spectrum: &Spectrum| {
        spectrum.sample::<N>(asked, Role::Index).map_err(|error| outside_table(name, error))
    };
    let host_n = sample(&spheres.host_eta)?;
    let wavelengths = wavelengths::<N>(asked.color);
    let mut suspensions: [Suspension; N] = std::array::from_fn(|channel| Suspension {
        particles: Vec::new(),
        host_n: f64::from(host_n[channel]),
        wavelength_nm: wavelengths[channel],
    });
    for component in &spheres.components {
        let (n, k) = (sample(&component.eta)?, sample(&component.k)?);
        for (channel, suspension) in suspensions.iter_mut().enumerate() {
            if n[channel] == host_n[channel] && k[channel] == 0.0 {
                let problem = "particles of the host's own index do not scatter";
                return Err(SceneError::new(name, problem, "check `eta` of both"));
            }
            suspension.particles.push(Particles {
                sizes: &component.sizes,
                n: f64::from(n[channel]),
                k: f64::from(k[channel]),
                volume_fraction: component.volume_fraction,
            });
        }
    }
    Ok(suspensions)
}
