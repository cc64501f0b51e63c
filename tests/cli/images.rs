//! The verbs `visualize`, `view`, `compare` and `inspect`.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::program::{folder, names_in, scene, sunstone};

/// A folder with two renders that differ in their seed.
fn folder_with_renders(name: &str) -> PathBuf {
    let here = folder(name);
    for (name, seed) in [("a.exr", "1"), ("b.exr", "2")] {
        let scene = scene("cornell");
        let arguments = ["render", &scene, "-o", name, "--seed", seed, "--width", "32"];
        let more = ["--spp", "8", "--variance", "--replicates", "8", "--quiet"];
        sunstone(&here, &[&arguments[..], &more].concat()).done();
    }
    here
}

fn is_png(path: &Path) -> bool {
    fs::read(path).unwrap().starts_with(b"\x89PNG")
}

#[test]
fn every_map_is_drawn() {
    let here = folder_with_renders("maps");
    let help = sunstone(&here, &["visualize", "-h"]).done().stdout;
    let list = help.split("[default: panels] [possible values: ").nth(1).expect("a list of maps");
    let maps: Vec<&str> = list.split(']').next().unwrap().split(", ").collect();
    assert!(maps.len() > 10, "{maps:?}");
    for map in maps {
        let picture = format!("{map}.png");
        sunstone(&here, &["visualize", "a.exr", "-o", &picture, "--map", map]).done();
        assert!(is_png(&here.join(&picture)), "{map}");
    }
}

/// A scene of a few percent of polarization: fitted scales and full scales are different pictures.
#[test]
fn scales_fit_the_image_unless_told_otherwise() {
    let here = folder("scales");
    let scene = scene("reference/cornell");
    let arguments = ["render", &scene, "-o", "a.exr", "--width", "32", "--spp", "4"];
    sunstone(&here, &arguments).done();
    let draw = |name: &str, more: &[&str]| {
        let arguments = ["visualize", "a.exr", "-o", name, "--map", "dop"];
        sunstone(&here, &[&arguments[..], more].concat()).done();
        fs::read(here.join(name)).unwrap()
    };
    let fitted = draw("fitted.png", &[]);
    let full = draw("full.png", &["--full-scale"]);
    assert_eq!(full, draw("no-fit.png", &["--no-fit"]));
    assert_eq!(full != fitted, is_weakly_polarized(&here.join("a.exr")));
}

/// What a scene's analyzer lets pass is what `visualize` lets pass of the image without: by the
/// same paths, and as a file.
#[test]
fn analyzers_show_what_a_film_behind_them_measures() {
    let here = folder("analyzers");
    let text = fs::read_to_string(scene("cornell")).unwrap();
    let mut document: Value = serde_json::from_str(&text).unwrap();
    let film = "SUNSTONE_polarization";
    document["cameras"][0]["extensions"][film]["film"]["analyzer"] =
        serde_json::json!({"kind": "linear", "axis_deg": 45});
    fs::write(here.join("behind.gltf"), document.to_string()).unwrap();
    let render = |scene: &str, name: &str, mode: &str| {
        let arguments = ["render", scene, "-o", name, "--width", "24", "--spp", "4", "--quiet"];
        let more = ["--integrator", "path", "--sampling", "intensity", "--mode", mode];
        sunstone(&here, &[&arguments[..], &more].concat()).done();
        sunstone::internals::image::load(&here.join(name))
    };
    let bare = render(&scene("cornell"), "bare.exr", "polarized").unwrap();
    let behind = render("behind.gltf", "behind.exr", "polarized").unwrap();
    let intensity = render("behind.gltf", "intensity.exr", "intensity").unwrap();
    let arguments = ["visualize", "bare.exr", "--map", "analyzer-45", "-o", "shown.exr"];
    sunstone(&here, &arguments).done();
    let shown = sunstone::internals::image::load(&here.join("shown.exr")).unwrap();
    for image in [&behind, &shown, &intensity] {
        assert_eq!(image.metadata("analyzer"), Some("linear at 45 degrees"));
    }
    assert_eq!(intensity.planes, behind.planes[..3]);
    for (a, b) in behind.planes.iter().flatten().zip(shown.planes.iter().flatten()) {
        assert!((a - b).abs() < 1e-5 * (1.0 + b.abs()), "{a} {b}");
    }
    assert_ne!(bare.planes, shown.planes);
    let described = sunstone(&here, &["inspect", "behind.gltf"]).done().stdout;
    assert!(described.contains("behind an analyzer: linear at 45 degrees"), "{described}");
}

/// Sensors are refused by option, before anything is read; the same seed gives the same file.
#[test]
fn mosaics_are_recorded() {
    let here = folder_with_renders("mosaics");
    let record = |name: &str, more: &[&str]| {
        let arguments = ["visualize", "a.exr", "-o", name, "--map", "mosaic"];
        sunstone(&here, &[&arguments[..], more].concat())
    };
    let noisy = ["--bits", "12", "--full-well", "5000", "--read-noise", "2", "--black-level", "64"];
    record("first.png", &noisy).done();
    record("second.png", &noisy).done();
    record("third.png", &[&noisy[..], &["--seed", "1"]].concat()).done();
    let [first, second, third] =
        ["first.png", "second.png", "third.png"].map(|name| fs::read(here.join(name)).unwrap());
    assert!(first == second && first != third);
    record("mono.png", &["--sensor", "mono", "--gain", "0.5", "--full-well", "100"]).done();
    let refused: [(&[&str], &str); 7] = [
        (&["--bits", "10"], "--bits: 10 must be 8, 12 or 16"),
        (&["--black-level", "255"], "--black-level: 255 must be less than 255"),
        (&["--full-well", "0"], "--full-well: 0 must be from 1 to 1e12"),
        (&["--full-well", "9", "--gain", "-1"], "--gain: -1 must be greater than 0"),
        (&["--full-well", "9", "--read-noise", "nan"], "--read-noise: NaN must be not negative"),
        (&["--exposure", "inf"], "--exposure: inf must be a finite number"),
        (&["--gain", "2"], "--full-well <ELECTRONS>"),
    ];
    for (options, words) in refused {
        let run = record("bad.png", options);
        assert_eq!(run.code, 2, "{}: {}", run.command, run.stderr);
        assert!(run.stderr.contains(words), "{}: {}", run.command, run.stderr);
    }
    for (arguments, words) in [
        (["--map", "dop", "--bits", "8", "-o", "x.png"], "--bits goes with --map mosaic"),
        (["--map", "mosaic", "--bits", "8", "-o", "x.exr"], "must end in .png"),
        (["--map", "analyzer-0", "--exposure", "1", "-o", "x.tif"], "one of .exr, .hdr, .png"),
    ] {
        let run = sunstone(&here, &[&["visualize", "missing.exr"][..], &arguments].concat());
        assert_eq!(run.code, 2, "{}: {}", run.command, run.stderr);
        assert!(run.stderr.contains(words), "{}: {}", run.command, run.stderr);
    }
    let arguments = ["render", &scene("cornell"), "-o", "odd.exr", "--width", "6", "--height", "5"];
    sunstone(&here, &[&arguments[..], &["--spp", "1"]].concat()).done();
    let run = sunstone(&here, &["visualize", "odd.exr", "-o", "odd.png", "--map", "mosaic"]);
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(run.stderr.contains("multiples of 4 pixels"), "{}", run.stderr);
    assert!(!here.join("odd.png").exists() && !here.join("bad.png").exists());
}

fn is_weakly_polarized(image: &Path) -> bool {
    use sunstone::internals::image::visualize::View;
    View::fitted(&sunstone::internals::image::load(image).unwrap()) != View::default()
}

#[test]
fn pages_are_made() {
    let here = folder_with_renders("view");
    let run = sunstone(&here, &["view", "a.exr", "-o", "one.html"]).done();
    assert!(run.stdout.is_empty() && run.stderr.starts_with("one.html: "), "{}", run.stderr);
    sunstone(&here, &["view", "a.exr", "b.exr", "-o", "two.html", "--no-variance"]).done();
    let text = |name: &str| fs::read_to_string(here.join(name)).unwrap();
    let [one, two] = [text("one.html"), text("two.html")];
    let counts = |page: &str| ["-values-", "-variances-"].map(|kind| page.matches(kind).count());
    assert_eq!(counts(&one), [12, 12]);
    assert_eq!(counts(&two), [24, 0]);
    assert!(two.contains("<title>a.exr | b.exr</title>"));

    let run = sunstone(&here, &["view", "a.exr", "-o", "page.png"]);
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(run.stderr.contains("page.png must end in .html"), "{}", run.stderr);
    let run = sunstone(&here, &["view", "a.exr", "none.exr", "-o", "page.html"]);
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(run.stderr.contains("none.exr"), "{}", run.stderr);
    let run = sunstone(&here, &["view", "a.exr", "-o", "no/folder.html"]);
    assert!(run.stderr.contains("create the folder no first"), "{}", run.stderr);
    assert_eq!(names_in(&here), ["a.exr", "b.exr", "one.html", "two.html"]);

    // Of one name in two folders, the folders tell which is which.
    fs::create_dir(here.join("more <1>")).unwrap();
    fs::copy(here.join("b.exr"), here.join("more <1>/a.exr")).unwrap();
    sunstone(&here, &["view", "a.exr", "more <1>/a.exr", "-o", "alike.html"]).done();
    assert!(text("alike.html").contains("<title>a.exr | more &lt;1&gt;/a.exr</title>"));
}

#[test]
fn images_are_compared() {
    let here = folder_with_renders("compare");
    let text = sunstone(&here, &["compare", "a.exr", "b.exr"]).done().stdout;
    assert!(text.contains("S0") && text.contains("S3"), "{text}");
    let arguments = ["compare", "a.exr", "b.exr", "--json", "--difference", "d.png"];
    let json = sunstone(&here, &arguments).done().stdout;
    let _: Value = serde_json::from_str(&json).unwrap();
    assert!(is_png(&here.join("d.png")));
}

#[test]
fn scenes_and_images_are_described() {
    let here = folder_with_renders("inspect");
    let image = sunstone(&here, &["inspect", "a.exr"]).done().stdout;
    for words in ["32 x 32 pixels", "S0 S1 S2 S3", "DoP", "seed", "variance"] {
        assert!(image.contains(words), "{image}");
    }
    let described = sunstone(&here, &["inspect", &scene("cornell")]).done().stdout;
    for words in ["smooth dielectric", "linear polarizer", "perspective"] {
        assert!(described.contains(words), "{described}");
    }
}

#[test]
fn inputs_are_not_overwritten() {
    let here = folder_with_renders("overwrite");
    let before = fs::read(here.join("a.exr")).unwrap();
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("a.exr", here.join("link.png")).unwrap();
        for arguments in [
            &["visualize", "a.exr", "-o", "link.png"][..],
            &["compare", "a.exr", "b.exr", "--difference", "./link.png"],
        ] {
            let run = sunstone(&here, arguments);
            assert_eq!(run.code, 2, "{}", run.stderr);
            assert!(run.stderr.contains("is the input a.exr"), "{}", run.stderr);
        }
        assert_eq!(names_in(&here), ["a.exr", "b.exr", "link.png"]);
    }
    let run = sunstone(&here, &["render", "a.exr", "-o", "a.exr"]);
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert_eq!(fs::read(here.join("a.exr")).unwrap(), before);
}
