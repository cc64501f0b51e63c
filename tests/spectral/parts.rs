//! The set of wavelengths is a function of the iteration: parts, pauses, steps and threads give the
//! bits of one render.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;

use sunstone::{
    Bands, Color, Curves, Integrator, Options, Part, Photons, PlacedWorld, Renderer, Settings,
    Spectral, StokesImage, Threads, WhiteBalance, merge,
};

use crate::scenes::{longer_tabulated_room, tabulated_room};

fn options(integrator: Integrator) -> Options {
    let bands = Bands::evenly(420.0, 680.0, 14).expect("sound bands");
    let spectral = Spectral { wavelengths: 4, range_nm: [400.0, 700.0] };
    Options {
        integrator: Some(integrator),
        color: Color::Bands(Arc::new(bands)),
        spectral: Some(spectral),
        samples: 6,
        path_length_max: 4,
        width: Some(18),
        height: Some(17),
        photons: Photons { per_iteration: Some(500), samples: Some(2), ..Photons::default() },
        ..Options::default()
    }
}

fn renderer(world: &PlacedWorld, options: Options) -> Renderer {
    let settings = Settings::new(options).expect("sound options");
    Renderer::new(world, &settings).expect("a sound world")
}

fn done(mut renderer: Renderer) -> StokesImage {
    renderer.run(|_| ControlFlow::Continue(()));
    renderer.finish()
}

fn file(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("spectral");
    std::fs::create_dir_all(&folder).expect("a folder for what is tested");
    folder.join(name)
}

#[test]
fn parts_and_pauses_have_the_bits_of_the_whole() {
    let world = tabulated_room();
    for integrator in [Integrator::Path, Integrator::Bdpt, Integrator::Ppm] {
        for replicates in [1, 3] {
            let options = Options { replicates, ..options(integrator) };
            let whole = done(renderer(&world, options.clone()));
            let name = format!("{}-{replicates}", integrator.name());
            let part = |number| {
                let part = Some(Part::new(number, 3).expect("there is such a part"));
                let mut part = renderer(&world, Options { part, ..options.clone() });
                part.run(|_| ControlFlow::Continue(()));
                let path = file(&format!("{name}-{number}.part"));
                part.save(&path).expect("a file");
                path
            };
            let parts: Vec<PathBuf> = (1..=3).map(part).collect();
            let merged = merge(&parts).expect("parts of one image");
            assert_eq!(merged.planes, whole.planes, "{name}");
            assert_eq!(merged.variance, whole.variance, "{name}");
            assert_eq!(merged.color, whole.color, "{name}");
            let mut first = renderer(&world, options.clone());
            first.advance(4);
            let path = file(&format!("{name}.checkpoint"));
            first.save(&path).expect("a file");
            let mut second = renderer(&world, options.clone());
            second.resume(&path).expect("a file of this render");
            assert_eq!(done(second).planes, whole.planes, "{name}, resumed");
        }
    }
}

#[test]
fn threads_change_no_bit() {
    let world = tabulated_room();
    for integrator in [Integrator::Bdpt, Integrator::Ppm, Integrator::Light] {
        let on = |count| {
            let threads = Arc::new(Threads::start(Some(count)).expect("threads"));
            let options = Options { width: Some(70), samples: 2, ..options(integrator) };
            done(renderer(&world, options).on(&threads)).planes
        };
        // One thread takes wide tiles, and three narrow ones.
        assert!(on(1) == on(3), "{integrator:?}");
    }
}

#[test]
fn other_wavelengths_are_another_render() {
    let world = tabulated_room();
    let path = file("other.checkpoint");
    let mut first = renderer(&world, options(Integrator::Path));
    first.step();
    first.save(&path).expect("a file");
    let spectral = Some(Spectral { wavelengths: 8, range_nm: [400.0, 700.0] });
    let other = Options { spectral, ..options(Integrator::Path) };
    let error = renderer(&world, other).resume(&path).expect_err("another render").to_string();
    assert!(error.contains("spectral") && error.contains("8 wavelengths"), "{error}");
}

/// Films of responses, and colors that are balanced: parts and pauses know both.
#[test]
fn films_are_the_same_in_parts_and_after_pauses() {
    let world = tabulated_room();
    let white = |name: &str| Some(WhiteBalance::named(name).expect("a light"));
    let camera = Curves::named("nikon-d5100").expect("a known film");
    let camera = Color::Responses(Arc::new(camera));
    let spectral = Some(Spectral { wavelengths: 4, range_nm: [400.0, 700.0] });
    let of = |color: &Color, white_balance| Options {
        color: color.clone(),
        white_balance,
        spectral,
        ..options(Integrator::Path)
    };
    for (name, color) in [("camera", camera), ("rgb", Color::Rgb)] {
        let options = of(&color, white("3200K"));
        let whole = done(renderer(&world, options.clone()));
        let part = |number| {
            let part = Some(Part::new(number, 2).expect("there is such a part"));
            let mut part = renderer(&world, Options { part, ..options.clone() });
            part.run(|_| ControlFlow::Continue(()));
            let path = file(&format!("{name}-{number}.part"));
            part.save(&path).expect("a file");
            path
        };
        let merged = merge(&[part(1), part(2)]).expect("parts of one image");
        assert_eq!(merged.planes, whole.planes, "{name}");
        assert_eq!((&merged.color, &merged.metadata), (&whole.color, &whole.metadata), "{name}");
        let mut first = renderer(&world, options.clone());
        first.advance(4);
        let path = file(&format!("{name}.checkpoint"));
        first.save(&path).expect("a file");
        let mut second = renderer(&world, options);
        second.resume(&path).expect("a file of this render");
        assert_eq!(done(second).planes, whole.planes, "{name}, resumed");
        for other in [None, white("3300K")] {
            let error = renderer(&world, of(&color, other)).resume(&path).expect_err("another");
            let error = error.to_string();
            assert!(error.contains("is of another render") && error.len() < 1000, "{error}");
        }
        let told = sunstone::internals::render::describe_part(&path).expect("a part");
        assert!(told.contains("3200 K") || told.contains("nikon-d5100"), "{told}");
        assert!(told.lines().all(|line| line.len() < 300), "{told}");
    }
}

/// Tables that end within the range are told before anything is rendered.
#[test]
fn what_a_table_does_not_cover_is_refused() {
    let bands = Bands::evenly(380.0, 680.0, 16).expect("sound bands");
    let spectral = Some(Spectral { wavelengths: 8, range_nm: [370.0, 700.0] });
    let color = Color::Bands(Arc::new(bands));
    let settings = Settings::new(Options { color, spectral, ..options(Integrator::Path) });
    let world = tabulated_room();
    let error = Renderer::new(&world, &settings.expect("sound options")).err().expect("an error");
    let error = error.to_string();
    for words in ["`wall`", "reflectance", "400 to 700 nm", "370 to 690 nm", "--hold-spectra"] {
        assert!(error.contains(words), "{error}");
    }
}

/// If that is asked for, they hold at their ends, and the image says so: it is that of tables
/// which are so much longer.
#[test]
fn what_a_table_does_not_cover_is_held_if_that_is_asked_for() {
    let bands = Bands::evenly(375.0, 685.0, 32).expect("sound bands");
    let spectral = Some(Spectral { wavelengths: 8, range_nm: [370.0, 690.0] });
    let color = Color::Bands(Arc::new(bands));
    let asked = Options { color, spectral, ..options(Integrator::Path) };
    let held = done(renderer(&tabulated_room(), Options { hold_spectra: true, ..asked.clone() }));
    let said = held.metadata("held spectra").expect("it says so");
    for words in [
        "material `wall`, reflectance: below 400 nm down to 370",
        "material `plate`, eta: below",
        "material `plate`, k: below",
        "material `lamp`, what it emits: below",
    ] {
        assert!(said.contains(words), "{said}");
    }
    let longer = done(renderer(&longer_tabulated_room(), asked));
    assert_eq!(longer.metadata("held spectra"), None);
    for (plane, (held, longer)) in held.planes.iter().zip(&longer.planes).enumerate() {
        for (pixel, (held, longer)) in held.iter().zip(longer).enumerate() {
            // What is between two equal values of a table is rounded.
            let off = (held - longer).abs();
            assert!(off <= 1e-6 * longer.abs().max(1e-3), "{plane}, {pixel}: {held}, {longer}");
        }
    }
}
