//! Sets of wavelengths at the edge: lines and lasers, dark first wavelengths, glass that disperses
//! at some wavelengths of the render and not at others, zeros with a sign, short paths.

use sunstone::spectra::{Line, LineShape};
use sunstone::{Band, Color, Integrator, Mode, Options, PlacedWorld, Spectrum};

use crate::agreement::{REPLICATES, compare, options};
use crate::measured::{images, spectral};
use crate::scenes::{dispersive_room, dispersive_room_under, table};

/// Lines of some middles and widths in nanometers, of a value of 5 in their width.
fn lines(lines: &[[f64; 2]]) -> Spectrum {
    let line =
        |&[center_nm, width_nm]: &[f64; 2]| Line { center_nm, power: 5.0 * width_nm, width_nm };
    let lines: Vec<Line> = lines.iter().map(line).collect();
    Spectrum::lines(&lines, LineShape::Box).expect("sound lines")
}

/// What bands take of what mono renders at their middles measure: `share` of it.
fn bands_are_mono(
    world: &PlacedWorld,
    bands: &[Band],
    share: f32,
    (wavelengths, path_length_max): (u32, u32),
    what: &str,
) {
    let some = if cfg!(debug_assertions) { 1 } else { 3 };
    let integrators = [Integrator::Path, Integrator::Bdpt, Integrator::Ppm];
    for (index, integrator) in integrators.into_iter().take(some).enumerate() {
        let mode = if integrator == Integrator::Bdpt { Mode::Scalar } else { Mode::Polarized };
        let seed = 5000 * (1 + index as u32);
        let asked = Options { path_length_max, ..options(integrator, mode, seed) };
        let mut many =
            images(world, &spectral(wavelengths, bands.to_vec(), asked.clone()), REPLICATES);
        let planes = many.iter_mut().flat_map(|image| &mut image.planes);
        planes.flatten().for_each(|value| *value /= share);
        for (channel, band) in bands.iter().enumerate() {
            let color = Color::Mono { wavelength_nm: band.center_nm };
            let seed = seed + 100 * (1 + channel as u32);
            let mono = images(world, &Options { color, seed, ..asked.clone() }, REPLICATES);
            let what = format!("{what}: {integrator:?}, {} nm", band.center_nm);
            compare((&many, channel), (&mono, 0), &what);
        }
    }
}

const STEEP: [f32; 4] = [1.9, 1.7, 1.55, 1.4];

/// Most of the band is dark, and with it most of the first wavelengths.
#[test]
fn lines_in_the_dark() {
    let world = dispersive_room_under(lines(&[[450.0, 0.5], [640.0, 0.5]]), table(STEEP));
    let bands = [Band::new(450.0, 5.0), Band::new(640.0, 5.0)];
    bands_are_mono(&world, &bands, 0.1, (8, 5), "lines");
    bands_are_mono(&world, &bands, 0.1, (4, 2), "lines, two segments");
}

/// A band nearly as narrow as may be, of which single precision has few wavelengths.
#[test]
fn a_laser() {
    let world = dispersive_room_under(lines(&[[589.0, 1.0]]), table(STEEP));
    let bands = [Band::new(589.0, 0.012)];
    bands_are_mono(&world, &bands, 1.0, (8, 5), "a laser");
}

/// Where nearly all of the light is, glass refracts all of it alike, so that most sets have one
/// index throughout: paths are of the same kind in all of them.
#[test]
fn glass_that_does_not_disperse_where_it_is_lit() {
    let world = dispersive_room_under(lines(&[[450.0, 2.0]]), {
        Spectrum::table(&[400.0, 500.0, 700.0], &[1.6, 1.6, 1.4]).expect("a sound table")
    });
    let bands = [Band::new(450.0, 1.0), Band::new(600.0, 1.0)];
    bands_are_mono(&world, &bands[..1], 1.0, (8, 5), "flat");
    // The other is in the sets now and then, and dark.
    let asked = spectral(8, bands.to_vec(), options(Integrator::Path, Mode::Polarized, 0));
    let all = images(&world, &asked, 4);
    assert!(all.iter().all(|image| image.plane(0, 1).iter().all(|value| *value == 0.0)));
    assert!(all.iter().all(|image| image.plane(0, 0).iter().any(|value| *value > 0.0)));
}

/// Negative zeros are zeros: paths tell by their sign what dispersion has done to them.
#[test]
fn zeros_have_no_sign() {
    let image = |zero: f32| {
        let world = dispersive_room_under(table([5.0, zero, zero, 0.0]), table(STEEP));
        let bands = [420.0, 460.0, 530.0, 560.0].map(|nm| Band::new(nm, 10.0)).to_vec();
        let asked = spectral(4, bands, options(Integrator::Bdpt, Mode::Polarized, 3));
        images(&world, &asked, 1).remove(0).planes
    };
    assert!(image(-0.0) == image(0.0));
}

/// Direct light and emission alone, by which no path is refracted twice.
#[test]
fn short_paths() {
    let bands = [420.0, 690.0].map(|nm| Band::new(nm, 0.5));
    for (wavelengths, segments) in [(4, 1), (8, 2), (4, 3)] {
        let what = format!("{segments} segments, {wavelengths} wavelengths");
        bands_are_mono(&dispersive_room(), &bands, 1.0, (wavelengths, segments), &what);
    }
}
