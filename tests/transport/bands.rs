//! Bands of spectral renders are what mono renders measure at their middles: of the tank of milk,
//! and of glass that disperses light next to, in and about everything else.
//!
//! Cells of pixels of independent replicates are compared, as in `agreement`: some 2,000 numbers,
//! of which a normal one exceeds the limit of 5.5 with a chance of 4e-8, so that noise fails them
//! in 1 of 12,000 cases.

use sunstone::internals::image::StokesImage;
use sunstone::internals::integrators::Integrator;
use sunstone::internals::render::{Mode, Options, Photons, PlacedWorld};
use sunstone::internals::scene::World;
use sunstone::internals::spectrum::Color;

use crate::support::dispersive::DISPERSIVE;
use crate::support::evidence;
use crate::support::rendering::{
    in_bands, in_package, path_finds_everything, scene, settings, spectral_replicates, world,
};
use crate::support::statistics::{cells, estimate, mean_s0, rms, rms_limits, worst};

const SIZE: [u32; 2] = [16, 16];
const CELL: usize = 4;
const REPLICATES: u32 = 16;
const LIMIT: f64 = 5.5;

/// What is rendered, and how.
struct Asked<'a> {
    name: &'a str,
    world: &'a PlacedWorld,
    integrator: Integrator,
    mode: Mode,
    wavelengths: u32,
    samples: u32,
}

impl Asked<'_> {
    fn options(&self, seed: u32) -> Options {
        let settings = settings(self.integrator, self.mode, mono(550.0), self.samples, 6);
        let radius = Some(0.01 * self.world.radius());
        let photons = Photons { per_iteration: Some(10_000), samples: Some(4), alpha: 1.0, radius };
        let seed = settings.seed + seed;
        Options { photons, seed, width: Some(SIZE[0]), height: Some(SIZE[1]), ..settings }
    }

    /// What is wrong, in words, with bands of a nanometer about some wavelengths.
    fn complaints(&self, centers_nm: &[f32]) -> Vec<String> {
        let bands: Vec<[f32; 2]> = centers_nm.iter().map(|nm| [*nm, 1.0]).collect();
        let options = in_bands(self.wavelengths, &bands, SIZE, self.options(0));
        let many = spectral_replicates(self.world, &options, REPLICATES);
        let mut complaints = Vec::new();
        for (channel, &nm) in centers_nm.iter().enumerate() {
            let seed = 0x1_0000 * (1 + channel as u32);
            let options = Options { color: mono(nm), ..self.options(seed) };
            let one = spectral_replicates(self.world, &options, REPLICATES);
            complaints.extend(self.compare((&many, channel), &one, nm));
        }
        complaints
    }

    fn compare(
        &self,
        (many, channel): (&[StokesImage], usize),
        one: &[StokesImage],
        nm: f32,
    ) -> Option<String> {
        let all = vec![true; (SIZE[0] * SIZE[1]) as usize];
        let scale = mean_s0(&evidence::mean(one)).max(f64::MIN_POSITIVE);
        let channels = many[0].color.channels();
        let mut scores = Vec::new();
        for component in 0..one[0].planes.len() {
            for cell in cells(SIZE[0] as usize, SIZE[1] as usize, CELL, &all) {
                let many = estimate(many, component * channels + channel, &cell);
                scores.extend(many.score(&estimate(one, component, &cell), scale));
            }
        }
        let (rms, worst) = (rms(&scores), worst(&scores));
        // Components behind a polarizer share their noise: one counts as a source of chance.
        let [_, high] = rms_limits(scores.len().div_ceil(one[0].planes.len()));
        let words = format!(
            "{}, {:?}, {:?}, {} wavelengths, {nm} nm: rms {rms:.2} of {} cells (up to {high:.2}), \
             worst {worst:.2}",
            self.name,
            self.integrator,
            self.mode,
            self.wavelengths,
            scores.len()
        );
        println!("{words}");
        (rms > high || worst > LIMIT).then_some(words)
    }
}

fn mono(wavelength_nm: f32) -> Color {
    Color::Mono { wavelength_nm }
}

fn placed(world: World) -> PlacedWorld {
    PlacedWorld::new(world).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn a_band_of_the_tank_is_mono() {
    let world = placed(world(&in_package("scenes/tank.gltf")));
    for (integrator, mode) in
        [(Integrator::Path, Mode::Polarized), (Integrator::Bdpt, Mode::Scalar)]
    {
        let name = "tank";
        let asked = Asked { name, world: &world, integrator, mode, wavelengths: 8, samples: 16 };
        let complaints = asked.complaints(&[550.0, 600.0]);
        assert!(complaints.is_empty(), "{complaints:?}");
    }
}

fn check(samples: u32, ways: &[(Integrator, Mode, u32)]) {
    let mut complaints = Vec::new();
    for (name, build) in DISPERSIVE {
        let made = build();
        let path_finds_everything = path_finds_everything(&scene::<1>(&made, mono(550.0), SIZE));
        let world = placed(made);
        for &(integrator, mode, wavelengths) in ways {
            if integrator == Integrator::Path && !path_finds_everything {
                continue;
            }
            let asked = Asked { name, world: &world, integrator, mode, wavelengths, samples };
            complaints.extend(asked.complaints(&[430.0, 550.0, 660.0]));
        }
    }
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn bands_are_mono_where_glass_disperses() {
    check(8, &[(Integrator::Bdpt, Mode::Polarized, 8)]);
}

#[test]
#[ignore = "minutes"]
fn bands_are_mono_where_glass_disperses_closely() {
    check(
        16,
        &[
            (Integrator::Path, Mode::Polarized, 4),
            (Integrator::Bdpt, Mode::Scalar, 8),
            (Integrator::Bdpt, Mode::Polarized, 4),
            (Integrator::Ppm, Mode::Polarized, 8),
            (Integrator::Ppm, Mode::Scalar, 4),
            (Integrator::Light, Mode::Polarized, 8),
        ],
    );
}
