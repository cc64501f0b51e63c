//! Colors of thin films, against Airy's sums at every wavelength.

use sunstone::internals::polarization::{Film, filmed_conductor};
use sunstone::spectra::metal;
use sunstone::world::{Bsdf, ThinFilm};
use sunstone::{Color, Mode, Options, Spectral, Spectrum};

use crate::measured::{images, mean};
use crate::mirrors::{options, seen, sheet};

/// Oxides on titanium, and a thick one.
const THICKNESSES_NM: [f64; 4] = [25.0, 60.0, 150.0, 900.0];
const OXIDE: f64 = 2.3;

/// Spectral renders within one percent, as those of bare metal; RGB, whose channels are three lines,
/// within 0.06, where lines without width are off by 0.3.
#[test]
fn films_have_their_colors() {
    let daylight = Spectrum::illuminant("D65").expect("it is tabulated");
    let (eta, k) = metal("Ti").expect("it is tabulated");
    let at = |of: &Spectrum, nm: f64| f64::from(of.at(nm as f32).expect("it covers that"));
    let samples = if cfg!(debug_assertions) { 128 } else { 512 };
    let mut worst = [0.0_f64; 2];
    for thickness_nm in THICKNESSES_NM {
        for deg in [0.0, 60.0] {
            let expected = seen(|nm| {
                let film = Film { eta: OXIDE, k: 0.0, waves: thickness_nm / nm, spread: 0.0 };
                let index = [at(&eta, nm), at(&k, nm)];
                let (m00, block) = filmed_conductor(f64::to_radians(deg).cos(), &film, index);
                [m00 * (1.0 + block.a), m00 * (1.0 - block.a)]
            });
            let film = ThinFilm::new(OXIDE as f32, 0.0, thickness_nm as f32);
            let bsdf = Bsdf::FilmedConductor { eta: eta.clone(), k: k.clone(), film };
            for (sort, sky) in [daylight.clone(), Spectrum::Constant(1.0)].into_iter().enumerate() {
                let world = sheet(bsdf.clone(), deg, sky, None);
                let spectral = (sort == 0).then(Spectral::default);
                let options =
                    Options { color: Color::Rgb, spectral, ..options(Mode::Polarized, samples) };
                let image = &images(&world, &options, 1)[0];
                for (component, expected) in expected.iter().enumerate() {
                    for (channel, expected) in expected.iter().enumerate() {
                        let off = mean(image, component, channel) - expected;
                        let most = [0.01, 0.06][sort];
                        worst[sort] = worst[sort].max(off.abs());
                        assert!(off.abs() < most, "{thickness_nm} nm, {deg}, {sort}: {off}");
                    }
                }
            }
        }
    }
    println!("colors are off by {:.1e} at most, in RGB by {:.1e}", worst[0], worst[1]);
}
