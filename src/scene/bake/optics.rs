//! What a medium does to light at the wavelengths of the render: coefficients and phase function,
//! from numbers that the file gives or from the particles that it describes.

use std::f64::consts::PI;

use super::grid::Grid;
use super::outside_table;
use super::phase::{self, Elements};
use crate::polarization::kept;
use crate::polarization::mie::PhaseElements;
use crate::polarization::milk::{MILK_WAVELENGTHS_NM, Milk};
use crate::polarization::particles::{Particles, Suspension};
use crate::scene::baked::{Medium, Phase};
use crate::scene::error::SceneError;
use crate::scene::world::{self, Spheres};
use crate::spectrum::{Beyond, Carried, OutsideTable, Role, Spectrum};

/// Greatest size parameter of particles: more takes too long, and no table could hold its peak.
const SIZE_PARAMETER_MAX: f64 = 2000.0;

/// The row of a medium; `name` is how errors call it. What its particles do may be known already.
pub fn medium_row<const N: usize>(
    medium: &world::Medium,
    carried: &Carried<N>,
    (name, known): (&str, Option<&Grid>),
) -> Result<Medium<N>, SceneError> {
    let outside = |error: OutsideTable| outside_table(name, error);
    let mut derived = match (&medium.phase, known) {
        (_, Some(grid)) => grid.at(carried),
        (phase, None) => derived(phase, carried, name)?,
    };
    if let (Phase::Table(table), true) = (&mut derived.phase, carried.is_one_of_many()) {
        (table.spheres, table.achromatic) = everywhere(&medium.phase);
    }
    let coefficient = |given: &Option<Spectrum>, derived: [f32; N]| match given {
        Some(spectrum) => spectrum.sample(carried, Role::Coefficient).map_err(outside),
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

/// Whether a table of a phase function is that of spheres, and achromatic, at all wavelengths
/// together.
fn everywhere(phase: &world::Phase) -> (bool, bool) {
    match phase {
        world::Phase::HenyeyGreenstein { .. } => (false, true),
        world::Phase::Rayleigh { depolarization } => (*depolarization == 0.0, true),
        world::Phase::Spheres(_) | world::Phase::Milk(_) => (true, false),
        world::Phase::Table(matrices) => (phase::are_of_spheres(matrices), matrices.len() == 1),
    }
}

/// What a medium does of itself.
fn derived<const N: usize>(
    phase: &world::Phase,
    carried: &Carried<N>,
    name: &str,
) -> Result<Derived<N>, SceneError> {
    let outside = |error: OutsideTable| outside_table(name, error);
    Ok(match phase {
        world::Phase::HenyeyGreenstein { g } => Derived::of(Phase::HenyeyGreenstein {
            g: g.sample(carried, Role::Index).map_err(outside)?,
        }),
        world::Phase::Rayleigh { depolarization } => {
            Derived::of(Phase::Table(phase::rayleigh(*depolarization)))
        }
        world::Phase::Spheres(spheres) => suspended(spheres, carried, name)?,
        world::Phase::Milk(milk) => milked(milk, carried, name)?,
        world::Phase::Table(matrices) => {
            let ends_nm = phase::ends_nm(matrices).map(|ends| ends.map(|nm| nm as f32));
            let places = match ends_nm {
                Some(ends_nm) => carried.within(ends_nm).map_err(outside)?,
                None => *carried.wavelengths_nm(),
            };
            Derived::of(Phase::Table(phase::tabulated(matrices, places.map(f64::from))))
        }
    })
}

/// Particles in their host at one wavelength in nanometers, and what the host absorbs beside them
/// per meter; none if a phase function is of something else.
///
/// # Errors
/// When they are not known there.
pub fn suspension_at<'a>(
    phase: &'a world::Phase,
    (nm, beyond): (f64, Beyond),
    name: &str,
) -> Result<Option<(Suspension<'a>, f64)>, SceneError> {
    let carried = Carried::at([nm as f32]).beyond(beyond);
    match phase {
        world::Phase::Milk(milk) => {
            check_milk(&carried, name)?;
            let serum = milk.serum(nm);
            let absorbed = serum.sigma_a_riboflavin + serum.sigma_a_water;
            Ok(Some((milk.suspension(nm), absorbed)))
        }
        world::Phase::Spheres(spheres) => {
            let [host_k] = spheres
                .host_k
                .sample(&carried, Role::Index)
                .map_err(|error| outside_table(name, error))?;
            let [suspension] = suspensions(spheres, &carried, name)?;
            let absorbed = host_sigma_a(spheres, host_k, suspension.wavelength_nm);
            Ok(Some((suspension, absorbed)))
        }
        world::Phase::HenyeyGreenstein { .. }
        | world::Phase::Rayleigh { .. }
        | world::Phase::Table(_) => Ok(None),
    }
}

/// Intervals of the table of particles of a size parameter.
///
/// # Errors
/// When they are too large for one.
pub fn intervals_of(size_parameter: f64, name: &str) -> Result<usize, SceneError> {
    if size_parameter > SIZE_PARAMETER_MAX {
        let problem = format!("has particles of size parameter {size_parameter:.0}");
        let remedy = format!("keep it below {SIZE_PARAMETER_MAX}, or use hg or mueller_table");
        return Err(SceneError::new(name, problem, remedy));
    }
    Ok(phase::intervals(size_parameter))
}

/// Refuses what a series has not converged to.
///
/// # Errors
/// When a phase function has a value that is none.
pub fn check_series(matrix: &[Elements], name: &str) -> Result<(), SceneError> {
    if matrix.iter().any(|m| !(m.m00.is_finite() && m.m00 > 0.0)) {
        let problem = "the series of its particles does not converge";
        return Err(SceneError::new(name, problem, "check radii and indices of refraction"));
    }
    Ok(())
}

/// What a host absorbs where there are no particles, per meter.
fn host_sigma_a(spheres: &Spheres, host_k: f32, wavelength_nm: f64) -> f64 {
    let filled: f64 = spheres.components.iter().map(|component| component.volume_fraction).sum();
    let host = 4.0 * PI * f64::from(host_k) / (1e-9 * wavelength_nm);
    (1.0 - filled).max(0.0) * host
}

/// Refuses wavelengths at which milk is not known, unless what is known at its ends is held: then
/// its indices of refraction are.
fn check_milk<const N: usize>(carried: &Carried<N>, name: &str) -> Result<(), SceneError> {
    let ends_nm = MILK_WAVELENGTHS_NM.map(|nm| nm as f32);
    carried.within(ends_nm).map(|_| ()).map_err(|error| outside_table(name, error))
}

/// A phase function, and the coefficients that go with it; zero where there are none.
pub struct Derived<const N: usize> {
    pub sigma_a: [f32; N],
    pub sigma_s: [f32; N],
    pub phase: Phase<N>,
}

impl<const N: usize> Derived<N> {
    fn of(phase: Phase<N>) -> Self {
        Self { sigma_a: [0.0; N], sigma_s: [0.0; N], phase }
    }
}

/// Wavelengths of the columns in nanometers.
fn wavelengths<const N: usize>(carried: &Carried<N>) -> [f64; N] {
    carried.wavelengths_nm().map(f64::from)
}

/// All elements of spheres' matrices.
pub fn elements_of(matrix: &[PhaseElements]) -> Vec<Elements> {
    let elements = |m: &PhaseElements| {
        let (m00, m01, m22, m23) = (m.m00, m.m01, m.m22, m.m23);
        Elements { m00, m01, m11: m00, m22, m23, m33: m22 }
    };
    matrix.iter().map(elements).collect()
}

/// Milk at the wavelengths of the render.
fn milked<const N: usize>(
    milk: &Milk,
    carried: &Carried<N>,
    name: &str,
) -> Result<Derived<N>, SceneError> {
    check_milk(carried, name)?;
    let wavelengths = wavelengths(carried);
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
    carried: &Carried<N>,
    name: &str,
) -> Result<Derived<N>, SceneError> {
    let sample = |spectrum: &Spectrum| {
        let values = spectrum.sample(carried, Role::Index);
        values.map_err(|error| outside_table(name, error))
    };
    let host_k = sample(&spheres.host_k)?;
    let suspensions = suspensions(spheres, carried, name)?;
    let largest = suspensions.iter().map(Suspension::size_parameter_max).fold(0.0, f64::max);
    let intervals = intervals_of(largest, name)?;
    let scattering = suspensions.map(|suspension| {
        let found = kept::scattering(&suspension, intervals);
        (found, suspension.wavelength_nm)
    });
    let sigma_a = std::array::from_fn(|channel| {
        let (found, nm) = &scattering[channel];
        (found.sigma_a + host_sigma_a(spheres, host_k[channel], *nm)) as f32
    });
    let sigma_s = scattering.each_ref().map(|(found, _)| found.sigma_s as f32);
    let matrices = scattering.map(|(found, _)| elements_of(&found.matrix));
    matrices.iter().try_for_each(|matrix| check_series(matrix, name))?;
    Ok(Derived { sigma_a, sigma_s, phase: Phase::Table(phase::table(&matrices)) })
}

/// The spheres and their host, one wavelength each.
fn suspensions<'a, const N: usize>(
    spheres: &'a Spheres,
    carried: &Carried<N>,
    name: &str,
) -> Result<[Suspension<'a>; N], SceneError> {
    let sample = |spectrum: &Spectrum| {
        let values = spectrum.sample(carried, Role::Index);
        values.map_err(|error| outside_table(name, error))
    };
    let host_n = sample(&spheres.host_eta)?;
    let wavelengths = wavelengths(carried);
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
