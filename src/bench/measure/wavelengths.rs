//! Numbers of wavelengths, side by side.

use super::clock::{self, machine, timed};
use super::{MeasureError, Subject, Watch};
use crate::bench::wavelengths::{Case, Conditions, Taken, Wavelengths};
use crate::render::settings::WAVELENGTH_NM;
use crate::render::spectral::WAVELENGTHS;
use crate::render::threads::Threads;
use crate::render::{Mode, Options, Renderer, Settings, Spectral};
use crate::spectrum::Color;
use crate::transport::Sampling;

/// Options of a render at a number of wavelengths.
pub struct Carried {
    /// What light is carried at, in words.
    pub name: String,
    /// How many wavelengths.
    pub wavelengths: usize,
    /// All of them.
    pub options: Options,
}

/// What the rounds of a number of wavelengths took.
struct Timed {
    carried: Carried,
    /// Without polarization and with it.
    modes: [Vec<clock::Taken>; 2],
}

/// Options of renders at one wavelength, in RGB, and at every number of wavelengths that can be
/// carried together; which one it is, which range and which film are those of `options`, if these
/// say it.
pub fn carried(options: &Options) -> Vec<Carried> {
    let (mono, (film, range)) = match (&options.color, options.spectral) {
        (film, Some(spectral)) => (one_wavelength(), (film.clone(), spectral)),
        (mono @ Color::Mono { .. }, None) => (mono.clone(), (Color::Rgb, Spectral::default())),
        (Color::Rgb | Color::Bands(_) | Color::Responses(_), None) => {
            (one_wavelength(), (Color::Rgb, Spectral::default()))
        }
    };
    let plain = |color: &Color, rgb_white| {
        // What a film of spectra does with its channels.
        let (white_balance, raw_response) = (None, false);
        let options =
            Options { spectral: None, rgb_white, white_balance, raw_response, ..options.clone() };
        let (name, wavelengths) = (color.to_string(), color.channels());
        Carried { name, wavelengths, options: Options { color: color.clone(), ..options } }
    };
    let together = |wavelengths: u32| {
        let spectral = Some(Spectral { wavelengths, ..range });
        let options = Options { color: film.clone(), spectral, ..options.clone() };
        let name = format!("{wavelengths} wavelengths");
        Carried { name, wavelengths: wavelengths as usize, options }
    };
    let mut all = vec![plain(&mono, options.rgb_white), plain(&Color::Rgb, None)];
    all.extend(WAVELENGTHS.map(together));
    all
}

fn one_wavelength() -> Color {
    Color::Mono { wavelength_nm: WAVELENGTH_NM }
}

/// Measures each scene by each of the `plan`, polarized, with the samples of a round. All of the
/// plan have the same film and lengths of paths.
pub fn wavelengths(
    subjects: &[Subject],
    plan: &[Options],
    rounds: u32,
    threads: &Threads,
    watch: &impl Watch,
) -> Result<Wavelengths, MeasureError> {
    let mut cases = Vec::new();
    let mut cpu = true;
    for subject in subjects {
        for options in plan {
            let integrator = options.integrator_name();
            watch.at(&format!("{}, {integrator}", subject.name));
            let taken = case(subject, options, rounds, threads, watch)?;
            let mut all = taken.iter().flat_map(|timed| timed.modes.iter().flatten());
            cpu &= all.all(|taken| taken.cpu_seconds.is_some());
            cases.push((subject.label.clone(), options, taken));
        }
    }
    let seconds = |taken: &clock::Taken| match (cpu, taken.cpu_seconds) {
        (true, Some(seconds)) => seconds,
        (true, None) | (false, _) => taken.seconds,
    };
    let taken_of = |Timed { carried, modes }: Timed| {
        let rounds = modes.map(|rounds| rounds.iter().map(seconds).collect());
        Taken { name: carried.name, wavelengths: carried.wavelengths, rounds }
    };
    let case = |(scene, options, taken): (String, &Options, Vec<Timed>)| {
        let taken: Vec<Taken> = taken.into_iter().map(taken_of).collect();
        Case::new(scene, options.integrator_name().into(), options.samples, &taken)
    };
    let cases = cases.into_iter().map(case).collect();
    let options = plan.first().cloned().unwrap_or_default();
    let [width, height] = [options.width, options.height].map(|edge| edge.unwrap_or(0));
    let conditions = Conditions {
        machine: machine(threads),
        cpu,
        width,
        height,
        rounds,
        path_length_max: options.path_length_max,
        roulette_after: options.roulette_after,
        seed: options.seed,
    };
    Ok(Wavelengths { conditions, cases })
}

/// What every round of every number of wavelengths took, without polarization and with it.
fn case(
    subject: &Subject,
    options: &Options,
    rounds: u32,
    threads: &Threads,
    watch: &impl Watch,
) -> Result<Vec<Timed>, MeasureError> {
    let carried = carried(options);
    let mut renderers = Vec::new();
    for Carried { options, .. } in &carried {
        for mode in [Mode::Scalar, Mode::Polarized] {
            // Of the same paths in both modes, so that their ratio is what polarization costs.
            let sampling = Sampling::Intensity;
            let settings = Settings::new(Options { mode, sampling, ..options.clone() })?;
            renderers.push(Renderer::new(&subject.world, &settings)?);
        }
    }
    let mut taken: Vec<Vec<clock::Taken>> = renderers.iter().map(|_| Vec::new()).collect();
    for round in 0..=rounds {
        let up = 0..renderers.len();
        let order: Vec<usize> = if round % 2 == 0 { up.collect() } else { up.rev().collect() };
        for index in order {
            let advance = || renderers[index].advance(options.samples);
            let ((), took) = timed(|| threads.run(advance));
            if round > 0 {
                taken[index].push(took);
            }
        }
        watch.round();
    }
    let mut taken = taken.into_iter();
    let mut of_mode = || taken.next().unwrap_or_default();
    let timed = |carried| Timed { carried, modes: [of_mode(), of_mode()] };
    Ok(carried.into_iter().map(timed).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::spectral::columns;
    use crate::spectrum::White;

    #[test]
    fn all_numbers_of_wavelengths_are_carried() {
        let counts = |options: &Options| -> Vec<usize> {
            let check = |carried: Carried| {
                let settings = Settings::new(carried.options).expect("they go together");
                let columns = columns(&settings).expect("they have been checked");
                assert_eq!(columns.count(), carried.wavelengths);
                carried.wavelengths
            };
            carried(options).into_iter().map(check).collect()
        };
        assert_eq!(counts(&Options::default()), [1, 3, 4, 8]);
        let white = Some(White::E);
        let mono = Color::Mono { wavelength_nm: 633.0 };
        let mono = Options { color: mono, rgb_white: white, ..Options::default() };
        assert_eq!(carried(&mono)[0].name, "633 nm");
        assert_eq!(counts(&mono), [1, 3, 4, 8]);
        let spectral = Spectral { wavelengths: 4, range_nm: [400.0, 700.0] };
        let spectral = Options { spectral: Some(spectral), rgb_white: white, ..Options::default() };
        let last = carried(&spectral).pop().expect("four");
        assert_eq!(last.options.spectral.map(|it| it.range_nm), Some([400.0, 700.0]));
        assert_eq!(counts(&spectral), [1, 3, 4, 8]);
    }
}
