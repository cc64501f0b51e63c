//! The verb `render`: formats, integrators, modes, statistics.

use std::fs;

use serde_json::Value;
use sunstone::internals::image;
use sunstone::internals::image::StokesImage;
use sunstone::internals::spectrum::Color;

use crate::program::{folder, names_in, scene, sunstone};

const TINY: [&str; 6] = ["--width", "16", "--spp", "2", "--threads", "2"];

fn metadata<'a>(image: &'a StokesImage, key: &str) -> &'a str {
    let found = image.metadata.iter().find(|(name, _)| name == key);
    found.map_or_else(|| panic!("no {key} in {:?}", image.metadata), |(_, value)| value)
}

#[test]
fn every_integrator_renders_in_every_mode_and_color() {
    let here = folder("render-all");
    let scene = scene("cornell");
    for integrator in ["path", "light", "bdpt"] {
        for (mode, components) in [("scalar", 1), ("polarized", 4)] {
            for (color, channels) in [("rgb", 3), ("mono", 1)] {
                let name = format!("{integrator}-{mode}-{color}.exr");
                let mut arguments = vec!["render", &scene, "-o", &name, "--integrator"];
                arguments.extend([integrator, "--mode", mode, "--color", color]);
                arguments.extend(TINY);
                let run = sunstone(&here, &arguments).done();
                assert!(run.stdout.is_empty(), "{}: {}", run.command, run.stdout);

                let image = image::load(&here.join(&name)).unwrap();
                assert_eq!((image.width, image.height), (16, 16), "{name}");
                assert_eq!((image.components, image.color.channels()), (components, channels));
                assert_eq!(metadata(&image, "integrator"), integrator);
                assert_eq!(metadata(&image, "mode"), mode);
                let light: f32 = image.plane(0, 0).iter().sum();
                assert!(light.is_finite() && light > 0.0, "{name}: {light}");
            }
        }
    }
}

#[test]
fn every_format_is_written() {
    let here = folder("render-formats");
    let scene = scene("cornell");
    for name in ["a.exr", "b.hdr", "c.png", "D.EXR"] {
        let run = sunstone(&here, &[&["render", &scene, "-o", name][..], &TINY].concat()).done();
        assert!(
            run.stderr.contains("16 x 16, 2 samples a pixel of bdpt (polarized)"),
            "{}",
            run.stderr
        );
    }
    let scalar = [&["render", &scene, "-o", "e.hdr", "--mode", "scalar"][..], &TINY].concat();
    sunstone(&here, &scalar).done();
    let stokes = ["b.S0.hdr", "b.S1.hdr", "b.S2.hdr", "b.S3.hdr"];
    let expected = [&["D.EXR", "a.exr"][..], &stokes, &["c.png", "e.S0.hdr"]].concat();
    assert_eq!(names_in(&here), expected);
    assert_eq!(image::load(&here.join("b.hdr")).unwrap().components, 4);
    assert!(fs::read(here.join("c.png")).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn options_reach_the_image() {
    let here = folder("render-options");
    let scene = scene("cornell");
    let arguments = ["render", &scene, "-o", "a.exr", "--color", "mono", "--wavelength", "633"];
    let more = ["--width", "24", "--height", "8", "--variance", "--replicates", "4", "--spp", "8"];
    sunstone(&here, &[&arguments[..], &more, &["--seed", "5", "--quiet"]].concat()).done();
    let image = image::load(&here.join("a.exr")).unwrap();
    assert_eq!((image.width, image.height), (24, 8));
    assert_eq!(image.color, Color::Mono { wavelength_nm: 633.0 });
    assert!(image.variance.is_some());
    let facts = [("seed", "5"), ("iterations", "8"), ("replicates", "4"), ("rgb white", "e")];
    for (key, value) in facts {
        assert_eq!(metadata(&image, key), value);
    }
    assert!(metadata(&image, "command").contains("--wavelength 633"));
    let by_daylight = ["--seed", "5", "--quiet", "--rgb-white", "D65"];
    sunstone(&here, &[&arguments[..], &more, &by_daylight].concat()).done();
    let other = image::load(&here.join("a.exr")).unwrap();
    assert_eq!(metadata(&other, "rgb white"), "d65");
    // There is less red in daylight than in equal energy of its luminance.
    let light = |image: &StokesImage| image.planes[0].iter().map(|it| f64::from(*it)).sum::<f64>();
    let ratio = light(&other) / light(&image);
    assert!((0.8..0.95).contains(&ratio), "{ratio}");
    let name = "it's $HOME.exr";
    let run = ["render", &scene, "-o", name, "--width", "8", "--spp", "1"];
    let stderr = sunstone(&here, &run).done().stderr;
    assert!(stderr.contains("8 x 8, 1 sample a pixel of bdpt"), "{stderr}");
    // As a shell takes it.
    let image = image::load(&here.join(name)).unwrap();
    let script = format!("set -- {}; printf %s \"$5\"", metadata(&image, "command"));
    let words = std::process::Command::new("sh").args(["-c", &script]).output().unwrap();
    assert_eq!(String::from_utf8(words.stdout).unwrap(), name);
}

#[test]
fn the_last_of_equal_options_counts() {
    let here = folder("render-last");
    let scene = scene("cornell");
    let arguments = ["render", &scene, "-o", "a.exr", "--width", "99", "--width", "8"];
    sunstone(&here, &[&arguments[..], &["--spp", "9", "--spp", "1"]].concat()).done();
    assert_eq!(image::load(&here.join("a.exr")).unwrap().width, 8);
}

#[test]
fn statistics_are_json_alone_on_standard_output() {
    let here = folder("render-stats");
    let scene = scene("cornell");
    let arguments = [&["render", &scene, "-o", "a.exr", "--stats", "json"][..], &TINY].concat();
    let run = sunstone(&here, &arguments).done();
    let json: Value = serde_json::from_str(&run.stdout).unwrap();
    for (key, value) in [("width", 16), ("height", 16), ("iterations", 2), ("threads", 2)] {
        assert_eq!(json[key], value, "{key}");
    }
    let number = |key: &str| json[key].as_f64().unwrap_or_else(|| panic!("{key}: {json}"));
    assert!(number("seconds") > 0.0 && number("samples_per_second") > 0.0);
    assert!(number("rays_closest") >= 512.0);
    if cfg!(target_os = "linux") {
        assert!(number("cpu_seconds") > 0.0 && number("peak_memory_bytes") > 1e6);
    }
    let text = sunstone(&here, &[&arguments[..4], &["--stats", "text"], &TINY].concat()).done();
    assert!(text.stdout.contains("samples/s"), "{}", text.stdout);
}

#[test]
fn quiet_says_nothing() {
    let here = folder("render-quiet");
    let arguments = ["render", &scene("cornell"), "-o", "a.exr", "-q", "--integrator", "bdpt"];
    let run = sunstone(&here, &[&arguments[..], &TINY].concat()).done();
    assert_eq!(run.stdout + &run.stderr, "");
}

#[test]
fn names_may_begin_with_a_hyphen() {
    let here = folder("render-hyphen");
    for (output, name) in [("-o", "-a.exr"), ("--output", "-b.png"), ("-o", "--spp.hdr")] {
        sunstone(&here, &[&["render", &scene("cornell"), output, name][..], &TINY].concat()).done();
    }
    let names = ["--spp.S0.hdr", "--spp.S1.hdr", "--spp.S2.hdr", "--spp.S3.hdr"];
    assert_eq!(names_in(&here), [&names[..], &["-a.exr", "-b.png"]].concat());
}

#[test]
fn light_says_what_it_cannot_see() {
    let here = folder("render-light");
    let warns = |scene: &str, integrator: &str| {
        let arguments = ["render", scene, "-o", "a.exr", "-q", "--integrator", integrator];
        sunstone(&here, &[&arguments[..], &TINY].concat()).done().stderr.contains("warning: ")
    };
    assert!(warns(&scene("cornell"), "light"));
    assert!(!warns(&scene("cornell"), "bdpt"));
    assert!(warns(&scene("tank"), "path") && warns(&scene("tank"), "bdpt"));
    assert!(!warns(&scene("tank"), "ppm"));
}

/// The rule is named in the note, in the image, and by `inspect` of either.
#[test]
fn what_suits_the_scene_is_chosen_and_told() {
    let here = folder("render-auto");
    for (name, integrator, rule) in [
        ("tank", "ppm", "points or directions light mirrors or glass, and the camera sees"),
        ("caustic_glass", "bdpt", "small lamps light mirrors or glass"),
        ("reference/cornell", "path", "neither points nor small lamps"),
    ] {
        let scene = scene(name);
        let run = [&["render", &scene, "-o", "a.exr", "--mode", "scalar"][..], &TINY].concat();
        let note = format!("note: --integrator auto takes `{integrator}`: {rule}");
        let stderr = sunstone(&here, &run).done().stderr;
        assert_eq!(stderr.matches("note: ").count(), 1, "{stderr}");
        assert!(stderr.contains(&note), "{stderr}");
        let quiet = sunstone(&here, &[&run[..], &["-q"]].concat()).done().stderr;
        assert_eq!(quiet, "");
        let image = image::load(&here.join("a.exr")).unwrap();
        assert_eq!(metadata(&image, "integrator"), integrator);
        assert_eq!(metadata(&image, "integrator asked for"), "auto");
        assert!(metadata(&image, "integrator rule").starts_with(rule));
        let told = sunstone(&here, &["inspect", "a.exr"]).done().stdout;
        assert!(told.contains("integrator asked for auto") && told.contains(rule), "{told}");
        let told = sunstone(&here, &["inspect", &scene]).done().stdout;
        assert!(told.contains(&note["note: ".len()..]), "{told}");
    }
}

/// Options of photons go with `auto`, whatever it chooses.
#[test]
fn photons_may_be_given_where_they_may_be_shot() {
    let here = folder("render-photons");
    let render = |name: &str, more: &[&str]| {
        let scene = scene(name);
        let arguments = ["render", &scene, "-o", "a.exr", "--width", "8", "--mode", "scalar"];
        sunstone(&here, &[&arguments[..], more].concat())
    };
    render("tank", &["--photons", "500", "--iterations", "2"]).done();
    let image = image::load(&here.join("a.exr")).unwrap();
    let of = |key| metadata(&image, key);
    assert_eq!((of("photons an iteration"), of("samples an iteration")), ("500", "4"));
    assert_eq!(of("iterations"), "8");
    render("reference/cornell", &["--photons", "500", "--spp", "2"]).done();
    let odd = render("reference/cornell", &["--samples-per-iteration", "3", "--spp", "4"]);
    assert_eq!((odd.code, odd.stderr.contains("not a multiple")), (2, true), "{}", odd.stderr);
    let unused = render("tank", &["--integrator", "path", "--photons", "500"]);
    assert_eq!((unused.code, unused.stderr.contains("--integrator ppm")), (2, true));
}

#[test]
fn a_time_limit_ends_a_long_render() {
    let here = folder("render-time");
    let scene = scene("cornell");
    let arguments = ["render", &scene, "-o", "a.exr", "--time-limit", "0.2", "--width", "32"];
    sunstone(&here, &[&arguments[..], &["--spp", "100000000"]].concat()).done();
    let image = image::load(&here.join("a.exr")).unwrap();
    let iterations: u32 = metadata(&image, "iterations").parse().unwrap();
    assert!((1..100_000_000).contains(&iterations), "{iterations}");
}

/// The bits depend on the seed and not on the threads.
#[test]
fn threads_change_nothing() {
    let here = folder("render-threads");
    let scene = scene("cornell");
    let render = |name: &str, threads: &str, seed: &str| {
        let arguments = ["render", &scene, "-o", name, "--width", "40", "--spp", "3"];
        let more = ["--threads", threads, "--seed", seed];
        sunstone(&here, &[&arguments[..], &more].concat()).done();
        image::load(&here.join(name)).unwrap().planes
    };
    let one = render("one.exr", "1", "7");
    assert!(one == render("three.exr", "3", "7"), "the image depends on the number of threads");
    assert!(one != render("seed.exr", "1", "8"), "the image does not depend on the seed");
}

/// What errors call the ends of ranges is within them, though the nearest single precision to 0.01
/// is less.
#[test]
fn the_ends_of_ranges_are_within() {
    let here = folder("render-ends");
    let scene = scene("cornell");
    for (option, value) in [
        ("--filter-radius", "0.01"),
        ("--filter-radius", "32"),
        ("--pixel-aspect", "0.01"),
        ("--pixel-aspect", "100"),
    ] {
        let arguments = ["render", &scene, "-o", "a.exr", "--width", "8", "--height", "8"];
        sunstone(&here, &[&arguments[..], &["--spp", "1", option, value]].concat()).done();
        let light: f32 = image::load(&here.join("a.exr")).unwrap().plane(0, 0).iter().sum();
        assert!(light.is_finite(), "{option} {value}");
    }
}

/// The shortest time is enough for one iteration, so that there is an image.
#[test]
fn no_time_is_one_iteration() {
    let here = folder("render-no-time");
    let scene = scene("cornell");
    for (integrator, samples) in [("path", "1 sample a pixel"), ("ppm", "4 samples a pixel")] {
        let arguments = ["render", &scene, "-o", "a.exr", "--time-limit", "0", "--width", "8"];
        let more = ["--height", "8", "--integrator", integrator, "--spp", "64"];
        let run = sunstone(&here, &[&arguments[..], &more].concat()).done();
        assert!(run.stderr.contains(samples), "{}", run.stderr);
        let light: f32 = image::load(&here.join("a.exr")).unwrap().plane(0, 0).iter().sum();
        assert!(light > 0.0, "{integrator}: {light}");
    }
    let refused = ["render", &scene, "-o", "a.exr", "--time-limit", "-1"];
    assert!(sunstone(&here, &refused).stderr.contains("must be a number of seconds, not -1"));
}
