//! Films against sums over wavelengths that know nothing of the renderer: channels by responses,
//! colors, and what white is to them.

use std::sync::Arc;

use sunstone::glam::{DVec3, Vec3};
use sunstone::internals::spectrum::color_space::rgb_of_xyz;
use sunstone::spectra::{Line, LineShape};
use sunstone::world::{Bsdf, Geometry, Lens, Material, Transform};
use sunstone::{
    Color, Curves, Error, Integrator, Mode, Options, PlacedWorld, Settings, Spectral, Spectrum,
    StokesImage, WhiteBalance, World,
};

use crate::measured::images;

/// Independent renders of each.
const REPLICATES: u32 = 12;
/// Samples per pixel of each: so many that the bias of what is divided by how often wavelengths
/// were met, which falls faster than noise, is lost in that.
const SAMPLES: u32 = 64;
/// What no score exceeds, of Student's distribution with 11 degrees of freedom or, of differences,
/// more: 40 scores or so are looked at, and one of some 2,000 runs is told without a cause.
const LIMIT: f64 = 7.0;
/// The wavelengths of the tables, in nanometers.
const NM: [f32; 4] = [390.0, 480.0, 590.0, 800.0];

fn table(values: [f32; 4]) -> Spectrum {
    Spectrum::table(&NM, &values).expect("a sound table")
}

const WALL: [f32; 4] = [0.1, 0.8, 0.3, 0.6];
const LAMP: [f32; 4] = [2.0, 9.0, 1.0, 5.0];

/// A wall and a lamp, which the camera does not see, or the lamp alone if that is all it sees.
fn world(wall: Spectrum, lamp: Spectrum, sees_lamp: bool) -> PlacedWorld {
    let world = || -> Result<World, Error> {
        let mut world = World::new("wall");
        let wall = world.add_material("wall", Bsdf::diffuse(wall))?;
        let lamp = world.add_material("lamp", Material::emitter(lamp).two_sided())?;
        let here = Transform::IDENTITY;
        let at = |z: f32| Geometry::quad(Vec3::Z * z, Vec3::X * 2.0, Vec3::Y * 2.0);
        world.add_mesh("wall", at(-1.0), wall, here)?;
        world.add_mesh("lamp", at(if sees_lamp { -0.5 } else { 1.5 }), lamp, here)?;
        let place = Transform::looking(DVec3::Z * 0.5, DVec3::ZERO, DVec3::Y);
        world.set_camera("eye", Lens::pinhole(0.5), place)?;
        world.set_resolution([4, 4])?;
        Ok(world)
    };
    PlacedWorld::new(world().expect("a sound world")).expect("a sound world")
}

fn options(color: Color, range_nm: [f32; 2], seed: u32) -> Options {
    Options {
        integrator: Some(Integrator::Path),
        mode: Mode::Scalar,
        color,
        spectral: Some(Spectral { wavelengths: 8, range_nm }),
        samples: SAMPLES,
        path_length_max: 2,
        seed,
        ..Options::default()
    }
}

/// The mean S0 of every channel, of independent renders.
fn means(world: &PlacedWorld, options: &Options) -> Vec<Vec<f64>> {
    let mean = |image: StokesImage| -> Vec<f64> {
        let plane = |channel| image.plane(0, channel).iter().map(|it| f64::from(*it));
        let pixels = image.plane(0, 0).len() as f64;
        (0..image.color.channels()).map(|it| plane(it).sum::<f64>() / pixels).collect()
    };
    images(world, options, REPLICATES).into_iter().map(mean).collect()
}

/// Mean and squared standard error.
fn estimate(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let count = f64::from(REPLICATES);
    let mean = values.clone().sum::<f64>() / count;
    let squares = values.map(|it| (it - mean).powi(2)).sum::<f64>();
    [mean, squares / (count * (count - 1.0))]
}

/// That two estimates are of one number; `rounding` is relative.
fn check([a, a_variance]: [f64; 2], [b, b_variance]: [f64; 2], what: &str) {
    let rounding = 2e-6 * a.abs().max(b.abs());
    let score = (a - b) / ((a_variance + b_variance).sqrt() + rounding);
    println!("{what}: {a} and {b}, score {score:.2}");
    assert!(score.abs() < LIMIT, "{what}: {a} and {b}, score {score:.2}");
}

/// On the line between the values of a table; zero outside.
fn between(nm: &[f32], values: &[f32], at: f64) -> f64 {
    let pairs = nm.windows(2).zip(values.windows(2));
    let on = |(nm, values): (&[f32], &[f32])| {
        let [from, to] = [nm[0], nm[1]].map(f64::from);
        let [low, high] = [values[0], values[1]].map(f64::from);
        (from..to).contains(&at).then(|| low + (high - low) * (at - from) / (to - from))
    };
    pairs.map(on).find_map(|it| it).unwrap_or(0.0)
}

/// The integral of a function over a range in a hundredth of a nanometer.
fn sum([from, to]: [f64; 2], of: impl Fn(f64) -> f64) -> f64 {
    const STEP: f64 = 0.01;
    let steps = ((to - from) / STEP).round() as u32;
    (0..steps).map(|step| of(from + STEP * (f64::from(step) + 0.5)) * STEP).sum()
}

const RESPONSES_NM: [f32; 6] = [400.0, 440.0, 500.0, 580.0, 650.0, 750.0];
const RESPONSES: [[f32; 6]; 3] = [
    [0.0, 1.0, 0.5, 0.0, 0.0, 0.0],
    [0.0, -0.3, 0.1, 1.5, 0.2, 0.0],
    [0.0, 0.0, 0.0, 0.1, 0.4, 2.0],
];

fn responses() -> Curves {
    let names = ["short", "middle", "long"].map(str::to_owned);
    let channels = names.into_iter().zip(RESPONSES.map(|values| values.to_vec()));
    Curves::new("sensor", RESPONSES_NM.to_vec(), channels.collect()).expect("sound responses")
}

fn film() -> Color {
    Color::Responses(Arc::new(responses()))
}

/// A wall in the light of a lamp, both of known spectra: what a channel has of it, over what it
/// has of a wall and a lamp that are flat, is a sum over wavelengths. Normalized, balanced, and
/// raw; over all of the responses, and cut.
#[test]
fn channels_are_sums_of_responses_times_light() {
    let (colored, flat) =
        (world(table(WALL), table(LAMP), false), world(0.5.into(), 1.0.into(), false));
    let white = WhiteBalance::new("lamp", table(LAMP)).expect("a light");
    let cases = [
        ([400.0, 750.0], false, None),
        ([450.0, 700.0], false, None),
        ([400.0, 750.0], true, None),
        ([420.0, 750.0], false, Some(white)),
    ];
    for (index, (range, raw_response, white_balance)) in cases.into_iter().enumerate() {
        let seed = 1000 * index as u32;
        let of = |seed| Options {
            raw_response,
            white_balance: white_balance.clone(),
            ..options(film(), range, seed)
        };
        let found = means(&colored, &of(seed));
        // How much of the lamp's light comes back from a wall that reflects all.
        let mono = Color::Mono { wavelength_nm: 550.0 };
        let share = Options { spectral: None, ..options(mono, range, seed + 500) };
        let [share, share_variance] =
            estimate(means(&flat, &share).into_iter().map(|it| it[0] / 0.5));
        for (channel, values) in RESPONSES.iter().enumerate() {
            let response = |nm: f64| between(&RESPONSES_NM, values, nm);
            let [lamp, wall] = [LAMP, WALL].map(|values| move |nm| between(&NM, &values, nm));
            let range = range.map(f64::from);
            let all = sum(range, |nm| response(nm) * lamp(nm) * wall(nm));
            let one = match (raw_response, &white_balance) {
                (true, _) => 1.0,
                (false, None) => sum(range, response),
                (false, Some(_)) => sum(range, |nm| response(nm) * lamp(nm)),
            };
            let factor = all / one;
            let expected = [share * factor, share_variance * factor * factor];
            let found = estimate(found.iter().map(|it| it[channel]));
            check(found, expected, &format!("case {index}, channel {channel}"));
        }
    }
}

/// X, Y and Z turned into linear sRGB are what a film of RGB has.
#[test]
fn xyz_is_the_color_that_a_film_of_rgb_has() {
    let room = world(table(WALL), table(LAMP), false);
    let range = [390.0, 780.0];
    let xyz = Curves::named("xyz").expect("a known film");
    let xyz =
        Options { raw_response: true, ..options(Color::Responses(Arc::new(xyz)), range, 9000) };
    // The integral of y (CIE 15), by which a flat spectrum of 1 has the luminance 1.
    const Y: f64 = 106.856_917;
    let turned = means(&room, &xyz)
        .into_iter()
        .map(|xyz| rgb_of_xyz(DVec3::new(xyz[0], xyz[1], xyz[2]) / Y).to_array());
    let turned: Vec<[f64; 3]> = turned.collect();
    let rgb = means(&room, &options(Color::Rgb, range, 9500));
    for channel in 0..3 {
        let found = estimate(turned.iter().map(|it| it[channel]));
        check(found, estimate(rgb.iter().map(|it| it[channel])), &format!("channel {channel}"));
    }
}

/// A lamp of lines and a wide one, looked at: white by its own balance, with the luminance it has.
#[test]
fn the_light_that_a_film_is_balanced_to_is_white() {
    let line = |center_nm, power| Line { center_nm, power, width_nm: 0.5 };
    let lines = [line(436.0, 60.0), line(546.0, 90.0), line(611.0, 120.0)];
    let lines = Spectrum::lines(&lines, LineShape::Box).expect("sound lines");
    for (index, light) in [table(LAMP), lines].into_iter().enumerate() {
        let room = world(0.0.into(), light.clone(), true);
        let white = WhiteBalance::new("lamp", light).expect("a light");
        let seed = 20_000 + 1000 * index as u32;
        let plain = options(Color::Rgb, [390.0, 780.0], seed);
        let balanced = Options { white_balance: Some(white.clone()), ..plain.clone() };
        let (plain, balanced) = (means(&room, &plain), means(&room, &balanced));
        let luminance =
            |rgb: &Vec<f64>| 0.212_639 * rgb[0] + 0.715_169 * rgb[1] + 0.072_192 * rgb[2];
        let of = |channel: usize| balanced.iter().map(move |it| it[channel]);
        for channel in [0, 2] {
            let difference = estimate(of(channel).zip(of(1)).map(|(one, two)| one - two));
            let scale = estimate(of(1))[0];
            // White by sums of another kind than those that the balance is reckoned by.
            check(difference, [0.0, (1e-4 * scale).powi(2)], &format!("{index}, {channel}"));
        }
        let expected = estimate(plain.iter().map(luminance));
        check(estimate(balanced.iter().map(luminance)), expected, "luminance");
        let not_white = (expected[0] - estimate(plain.iter().map(|it| it[2]))[0]).abs();
        assert!(not_white > 0.05 * expected[0], "{not_white}");
        let seen = options(film(), [400.0, 750.0], seed + 500);
        let seen = Options { white_balance: Some(white), ..seen };
        if index == 0 {
            for channel in 0..3 {
                let found = estimate(means(&room, &seen).into_iter().map(|it| it[channel]));
                check(found, [1.0, 0.0], &format!("response {channel}"));
            }
        }
    }
}

/// What cannot be: each with what says why.
#[test]
fn films_that_cannot_be_are_refused() {
    let range = [400.0, 750.0];
    let white = |name: &str| Some(WhiteBalance::named(name).expect("a light"));
    let mono = Color::Mono { wavelength_nm: 550.0 };
    let plain = |color| Options { spectral: None, ..options(color, range, 0) };
    let bands = sunstone::Bands::evenly(500.0, 600.0, 3).expect("sound bands");
    let bands = Color::Bands(Arc::new(bands));
    let negative = responses_of(&[-1.0, 0.5]);
    let dark = responses_of(&[0.0, 0.0]);
    for (options, words) in [
        (plain(film()), "responses go with color spectral"),
        (
            options(film(), [600.0, 750.0], 0),
            "channel short in range 600:750: it responds from 400",
        ),
        (options(dark, range, 0), "responds to nothing"),
        (options(negative.clone(), range, 0), "channel a: the integral of a flat spectrum"),
        (options(film(), [300.0, 200.0], 0), "range must go from a shorter"),
        (
            Options { raw_response: true, ..options(Color::Rgb, range, 0) },
            "raw_response goes with responses",
        ),
        (Options { raw_response: true, ..options(bands.clone(), range, 0) }, "raw_response goes"),
        (
            Options {
                raw_response: true,
                white_balance: white("D50"),
                ..options(film(), range, 0)
            },
            "white_balance goes without raw_response",
        ),
        (Options { white_balance: white("D50"), ..options(bands, range, 0) }, "bands are means"),
        (Options { white_balance: white("D50"), ..plain(mono) }, "one wavelength has none"),
        (Options { white_balance: white("D50"), ..plain(Color::Rgb) }, "there are no spectra"),
        (
            Options { white_balance: white("F2"), ..options(Color::Rgb, [360.0, 780.0], 0) },
            "F2 is known from 380 to 780 nm, and the film sees 360 nm",
        ),
    ] {
        let error = Settings::new(options).expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    }
    assert!(Settings::new(Options { raw_response: true, ..options(negative, range, 0) }).is_ok());
    let laser = Line { center_nm: 700.0, power: 1.0, width_nm: 1.0 };
    let laser = Spectrum::lines(&[laser], LineShape::Box).expect("a line");
    let laser = Some(WhiteBalance::new("laser", laser).expect("a light"));
    let of_laser = Options { white_balance: laser, ..options(Color::Rgb, range, 0) };
    let error = Settings::new(of_laser).expect_err("no white").to_string();
    assert!(error.contains("laser: needs a light that red, green and blue are in"), "{error}");
}

fn responses_of(values: &[f32; 2]) -> Color {
    let channels = vec![("a".to_owned(), values.to_vec())];
    Color::Responses(Arc::new(Curves::new("x", vec![400.0, 750.0], channels).expect("curves")))
}

/// Settings are the same when they are checked again.
#[test]
fn settings_are_checked_twice_to_the_same() {
    let white = WhiteBalance::named("3200K").expect("a light");
    for white_balance in [None, Some(white)] {
        let options = Options { white_balance, ..options(film(), [400.0, 750.0], 0) };
        let settings = Settings::new(options).expect("sound options");
        assert_eq!(Settings::new(settings.options()).expect("sound options"), settings);
        assert_ne!(settings.color, film());
    }
}
