//! What is known of a world's spectra, against the wavelengths of a render.

use std::convert::Infallible;

use super::emitters::lamps;
use super::phase::ends_nm;
use crate::polarization::milk::MILK_WAVELENGTHS_NM;
use crate::scene::error::SceneError;
use crate::scene::world::{Bsdf, Medium, Name, Phase, World};
use crate::spectrum::{Beyond, Carried, Spectrum};

/// Something of a world that is known between two wavelengths, and what a render asks of it.
struct Known {
    /// Whose it is, and by which key.
    place: String,
    ends_nm: [f32; 2],
    asked_nm: [f32; 2],
}

impl Known {
    /// What it lacks of the wavelengths that are asked for.
    fn is_short(&self) -> bool {
        self.asked_nm[0] < self.ends_nm[0] || self.ends_nm[1] < self.asked_nm[1]
    }

    fn refused(&self) -> SceneError {
        let [first, last] = self.ends_nm;
        let asked = match self.asked_nm {
            [from, to] if from == to => format!("{from} nm"),
            [from, to] => format!("{from} to {to} nm"),
        };
        let problem = format!("covers {first} to {last} nm only, and the render asks for {asked}");
        let remedy = "render within that, extend it, or hold what is at its ends (--hold-spectra)";
        SceneError::new(&self.place, problem, remedy)
    }

    /// Which wavelengths it is held over, in words.
    fn held(&self) -> String {
        let ([first, last], [from, to]) = (self.ends_nm, self.asked_nm);
        let below = (from < first).then(|| format!("below {first} nm down to {from}"));
        let above = (last < to).then(|| format!("above {last} nm up to {to}"));
        let sides: Vec<String> = below.into_iter().chain(above).collect();
        format!("{}: {}", self.place, sides.join(" and "))
    }
}

/// Refuses what does not cover the wavelengths of a render, or says what of it is held at its ends,
/// one sentence for each: whose, by which key, and over which wavelengths.
///
/// # Errors
/// With the first that is not held.
pub fn held<const N: usize>(
    world: &World,
    carried: &Carried<N>,
) -> Result<Vec<String>, SceneError> {
    let short = known(world, carried).into_iter().filter(Known::is_short);
    let of = |known: Known| match carried.held_beyond() {
        Beyond::Refused => Err(known.refused()),
        Beyond::Held => Ok(known.held()),
    };
    short.map(of).collect()
}

/// All that does not cover every wavelength there is.
fn known<const N: usize>(world: &World, carried: &Carried<N>) -> Vec<Known> {
    let nm = || carried.wavelengths_nm().iter().copied();
    let asked_nm = [nm().fold(f32::INFINITY, f32::min), nm().fold(0.0, f32::max)];
    let of = |name: &str, key: &str, spectrum: &Spectrum, asked_nm| {
        let ends_nm = spectrum.ends_nm()?;
        Some(Known { place: format!("{name}, {key}"), ends_nm, asked_nm })
    };
    let materials = world.in_order::<(&Name, &Bsdf), _>(|(Name(name), bsdf)| {
        of_bsdf(bsdf, carried.is_rgb(), asked_nm, |key, spectrum, asked_nm| {
            of(name, key, spectrum, asked_nm)
        })
    });
    let media = world.in_order::<(&Name, &Medium), _>(|(Name(name), medium)| {
        let coefficients = [("sigma_a", &medium.sigma_a), ("sigma_s", &medium.sigma_s)];
        let coefficients = coefficients
            .into_iter()
            .filter_map(|(key, spectrum)| of(name, key, spectrum.as_ref()?, asked_nm));
        let phase = of_phase(&medium.phase).into_iter().map(|(key, ends_nm)| {
            let place = format!("{name}, {key}");
            Known { place, ends_nm, asked_nm }
        });
        coefficients.chain(phase).collect::<Vec<_>>()
    });
    let lamps = lamps(world).into_iter().filter(|lamp| !lamp.is_black());
    let lamps = lamps.flat_map(|lamp| {
        let radiance = of(&lamp.name, "what it emits", &lamp.spectrum, asked_nm);
        let states = lamp.state.iter().flat_map(|state| state.spectra());
        let states = states.filter_map(|it| of(&lamp.name, "stokes", it, asked_nm));
        radiance.into_iter().chain(states).collect::<Vec<_>>()
    });
    materials.into_iter().chain(media).flatten().chain(lamps).collect()
}

/// Spectra of a material, as `of` has them. In RGB dielectrics ask for one wavelength alone.
fn of_bsdf(
    bsdf: &Bsdf,
    is_rgb: bool,
    asked_nm: [f32; 2],
    of: impl Fn(&'static str, &Spectrum, [f32; 2]) -> Option<Known>,
) -> Vec<Known> {
    let mut found = Vec::new();
    let mut note = |spectrum: &Spectrum, key: &'static str, asked_nm: [f32; 2]| {
        found.extend(of(key, spectrum, asked_nm));
        Ok::<f32, Infallible>(1.0)
    };
    let Ok(bsdf) = match is_rgb {
        true => bsdf.undispersed(|spectrum, key, nm| note(spectrum, key, [nm; 2])),
        false => Ok(bsdf.clone()),
    };
    let Ok(_) = bsdf.sampled(|spectrum, key, _| note(spectrum, key, asked_nm));
    found
}

/// The keys of a phase function, and between which wavelengths they are known.
fn of_phase(phase: &Phase) -> Vec<(String, [f32; 2])> {
    let of = |key: String, spectrum: &Spectrum| Some((key, spectrum.ends_nm()?));
    match phase {
        Phase::HenyeyGreenstein { g } => of("g".to_owned(), g).into_iter().collect(),
        Phase::Rayleigh { .. } => Vec::new(),
        Phase::Milk(_) => vec![("milk".to_owned(), MILK_WAVELENGTHS_NM.map(|nm| nm as f32))],
        Phase::Table(matrices) => {
            let ends_nm = ends_nm(matrices).map(|ends| ends.map(|nm| nm as f32));
            ends_nm.map(|ends_nm| ("table".to_owned(), ends_nm)).into_iter().collect()
        }
        Phase::Spheres(spheres) => {
            let host = [("host.eta", &spheres.host_eta), ("host.k", &spheres.host_k)];
            let host = host.into_iter().map(|(key, spectrum)| of(key.to_owned(), spectrum));
            let particles = spheres.components.iter().enumerate().flat_map(|(index, of_one)| {
                [("eta", &of_one.eta), ("k", &of_one.k)]
                    .map(|(key, spectrum)| of(format!("particles[{index}].{key}"), spectrum))
            });
            host.chain(particles).flatten().collect()
        }
    }
}
