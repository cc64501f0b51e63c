//! Bands against renders of one wavelength, by the spread between independent renders.

use sunstone::{Band, Color, Integrator, Mode, Options, Photons, PlacedWorld, StokesImage};

use crate::measured::{images, spectral};
use crate::scenes::{dispersive_room, gray_fogs, gray_room, tabulated_fog, tabulated_room};

/// Images of each, and samples per pixel: few where nothing is optimized.
pub const REPLICATES: u32 = if cfg!(debug_assertions) { 8 } else { 16 };
const SAMPLES: u32 = if cfg!(debug_assertions) { 4 } else { 16 };
/// Edge of a cell of pixels in pixels.
const CELL: usize = 8;
/// What no score exceeds: about 1,000 numbers are compared, of Student's distribution with some 30
/// degrees of freedom, or some 100 with some 14.
const LIMIT: f64 = 7.0;

/// Options of a quick render.
pub fn options(integrator: Integrator, mode: Mode, seed: u32) -> Options {
    let photons =
        Photons { per_iteration: Some(2_000), samples: Some(2), alpha: 1.0, radius: Some(0.05) };
    Options {
        integrator: Some(integrator),
        mode,
        samples: SAMPLES,
        path_length_max: 5,
        seed,
        photons,
        ..Options::default()
    }
}

/// Means over cells of the planes of a channel, and the squared standard errors of these.
fn cells(images: &[StokesImage], component: usize, channel: usize) -> Vec<[f64; 2]> {
    let [height, width, ..] = images[0].shape();
    let corners = (0..height).step_by(CELL);
    let corners = corners.flat_map(|top| (0..width).step_by(CELL).map(move |left| [top, left]));
    let of_cell = |[top, left]: [usize; 2]| {
        let mean = |image: &StokesImage| {
            let plane = image.plane(component, channel);
            let rows = (top..top + CELL).map(|y| &plane[y * width + left..][..CELL]);
            rows.flatten().map(|value| f64::from(*value)).sum::<f64>() / (CELL * CELL) as f64
        };
        let means: Vec<f64> = images.iter().map(mean).collect();
        let count = means.len() as f64;
        let mean = means.iter().sum::<f64>() / count;
        let squares = means.iter().map(|it| (it - mean).powi(2)).sum::<f64>();
        [mean, squares / (count * (count - 1.0))]
    };
    corners.map(of_cell).collect()
}

/// Compares a channel of some images with one of others; the worst score.
pub fn compare(one: (&[StokesImage], usize), other: (&[StokesImage], usize), what: &str) {
    let components = one.0[0].shape()[3];
    let (mut worst, mut squares, mut count) = (0.0_f64, 0.0, 0.0);
    for component in 0..components {
        let pairs =
            cells(one.0, component, one.1).into_iter().zip(cells(other.0, component, other.1));
        for ([a, a_variance], [b, b_variance]) in pairs {
            let scale = (a_variance + b_variance).sqrt() + 1e-6 * a.abs().max(1e-3);
            let score = (a - b) / scale;
            worst = worst.max(score.abs());
            squares += score * score;
            count += 1.0;
        }
    }
    let rms = f64::sqrt(squares / count);
    println!("{what}: worst score {worst:.2}, rms {rms:.2}");
    assert!(worst < LIMIT, "{what}: {worst}");
    assert!(rms < 1.0 + 4.0 / f64::sqrt(count), "{what}: rms {rms}");
}

const INTEGRATORS: [Integrator; 3] = [Integrator::Path, Integrator::Bdpt, Integrator::Ppm];

/// Equal energy, gray materials: every band, broad or narrow, is what one wavelength measures.
#[test]
fn bands_of_a_gray_scene_are_mono() {
    gray_bands_are_mono(&gray_room(), 0);
}

/// Of gray media, too.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn bands_of_gray_fog_are_mono() {
    for (first_seed, world) in [20_000, 30_000].into_iter().zip(gray_fogs()) {
        gray_bands_are_mono(&world, first_seed);
    }
}

fn gray_bands_are_mono(world: &PlacedWorld, first_seed: u32) {
    for (index, integrator) in INTEGRATORS.into_iter().enumerate() {
        let all =
            [(Mode::Polarized, 8), (Mode::Scalar, 4), (Mode::Polarized, 4), (Mode::Intensity, 8)];
        let some = if cfg!(debug_assertions) { &all[index..=index] } else { &all };
        for &(mode, wavelengths) in some {
            let seed = first_seed + 1000 * index as u32;
            let mono = Color::Mono { wavelength_nm: 550.0 };
            let mono = Options { color: mono, ..options(integrator, mode, seed) };
            let bands =
                vec![Band::new(450.0, 80.0), Band::new(550.0, 2.0), Band::new(640.0, 150.0)];
            let many = spectral(wavelengths, bands, options(integrator, mode, seed + 500));
            let [mono, many] = [&mono, &many].map(|options| images(world, options, REPLICATES));
            for channel in 0..3 {
                let what = format!("{integrator:?}, {mode:?}, {wavelengths}, band {channel}");
                compare((&many, channel), (&mono, 0), &what);
            }
        }
    }
}

/// Narrow bands of tabulated materials and light, also where the light is weak.
#[test]
fn bands_of_tables_are_mono_at_their_centers() {
    narrow_bands_are_mono(&tabulated_room(), 50_000);
}

/// The same in a medium that is tabulated.
#[test]
#[cfg_attr(debug_assertions, ignore = "long without optimization")]
fn bands_of_tabulated_fog_are_mono_at_their_centers() {
    narrow_bands_are_mono(&tabulated_fog(), 110_000);
}

/// The same where light is refracted in other ways at other wavelengths.
#[test]
fn bands_of_glass_that_disperses_are_mono_at_their_centers() {
    narrow_bands_are_mono(&dispersive_room(), 70_000);
}

fn narrow_bands_are_mono(world: &PlacedWorld, first_seed: u32) {
    let centers = [410.0, 480.0, 590.0, 690.0];
    let some = if cfg!(debug_assertions) { &INTEGRATORS[..1] } else { &INTEGRATORS };
    for (index, &integrator) in some.iter().enumerate() {
        let mode = if integrator == Integrator::Bdpt { Mode::Scalar } else { Mode::Polarized };
        let seed = first_seed + 2000 * index as u32;
        let bands = centers.map(|nm| Band::new(nm, 0.5)).to_vec();
        let many = spectral(8, bands, options(integrator, mode, seed));
        let many = images(world, &many, REPLICATES);
        for (channel, wavelength_nm) in centers.into_iter().enumerate() {
            let mono = Color::Mono { wavelength_nm };
            let seed = seed + 100 * (1 + channel as u32);
            let mono = Options { color: mono, ..options(integrator, mode, seed) };
            let what = format!("{integrator:?}, {mode:?}, {wavelength_nm} nm");
            compare((&many, channel), (&images(world, &mono, REPLICATES), 0), &what);
        }
    }
}

/// Light paths that are connected to the sensor are measured by the same bands.
#[test]
fn paths_of_both_sides_measure_the_same_bands() {
    let world = gray_room();
    let bands = || vec![Band::new(450.0, 60.0), Band::new(600.0, 20.0)];
    for mode in [Mode::Scalar, Mode::Polarized] {
        let of = |integrator, seed| {
            let options = options(integrator, mode, seed);
            let options = spectral(8, bands(), Options { path_length_max: 3, ..options });
            images(&world, &options, REPLICATES)
        };
        let (light, bdpt) = (of(Integrator::Light, 90_000), of(Integrator::Bdpt, 91_000));
        for channel in 0..2 {
            // The left half of the film sees neither the plate nor the ball.
            let left = |images: &[StokesImage]| images.iter().map(left_columns).collect::<Vec<_>>();
            let what = format!("light and bdpt, {mode:?}, band {channel}");
            compare((&left(&light), channel), (&left(&bdpt), channel), &what);
        }
    }
}

/// The two columns at the left of an image, repeated to a whole cell.
fn left_columns(image: &StokesImage) -> StokesImage {
    let [height, width, ..] = image.shape();
    let components = image.shape()[3];
    let mut left = StokesImage::new(CELL, height, image.color.clone(), components);
    for (to, from) in left.planes.iter_mut().zip(&image.planes) {
        for (index, value) in to.iter_mut().enumerate() {
            *value = from[index / CELL * width + index % CELL % 2];
        }
    }
    left
}
