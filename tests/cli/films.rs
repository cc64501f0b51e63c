//! Films of bands and responses from the command line: files, names, lists, and what is wrong with
//! them.

use std::fs;
use std::path::{Path, PathBuf};

use sunstone::internals::image;

use crate::program::{Run, folder, names_in, scene, sunstone};

const RESPONSES: &str = "# a sensor\nwavelength_nm,vis,nir\n400,0,0\n550,1,0\n700,0,0.2\n780,0,0\n";
const BANDS: &str = "name,center_nm,width_nm\nred,650,30\nblue,450,20\n";

/// A folder with a scene, responses, bands and a lamp.
fn lab(name: &str) -> PathBuf {
    let here = folder(&format!("films-{name}"));
    fs::copy(scene("cornell"), here.join("lab.gltf")).unwrap();
    fs::write(here.join("sensor.csv"), RESPONSES).unwrap();
    fs::write(here.join("bands.csv"), BANDS).unwrap();
    fs::write(here.join("lamp.spd"), "300 0.5\n600 1.5\n900 2\n").unwrap();
    here
}

const SMALL: [&str; 9] =
    ["--integrator", "path", "--spp", "4", "--width", "8", "--height", "6", "--quiet"];

/// Renders the scene on a spectral film.
fn render(here: &Path, output: &str, options: &[&str]) -> Run {
    let arguments = ["render", "lab.gltf", "-o", output, "--color", "spectral"];
    sunstone(here, &[&arguments[..], &SMALL, options].concat())
}

fn channels(here: &Path, output: &str) -> Vec<String> {
    image::load(&here.join(output)).unwrap().channel_names()
}

#[test]
fn bands_are_listed_or_read() {
    let here = lab("bands");
    render(&here, "list.exr", &["--bands", "red=650x30,450x20"]).done();
    assert_eq!(channels(&here, "list.exr"), ["450 nm", "red"]);
    render(&here, "file.exr", &["--bands", "bands.csv"]).done();
    assert_eq!(channels(&here, "file.exr"), ["blue", "red"]);
    // Names alone make no difference; centers and widths do.
    sunstone(&here, &["compare", "list.exr", "file.exr"]).done();
    sunstone(&here, &["view", "list.exr", "file.exr", "-o", "pair.html"]).done();
    render(&here, "other.exr", &["--bands", "red=650x20,450x20"]).done();
    for arguments in [&["compare"][..], &["view", "-o", "other.html"]] {
        let run = sunstone(&here, &[arguments, &["list.exr", "other.exr"]].concat());
        let words = "widths: at 650 nm 30 nm in the first and 20 nm in the second";
        assert!(run.code == 1 && run.stderr.contains(words), "{}", run.stderr);
    }
    let told = sunstone(&here, &["inspect", "file.exr", "--pixel", "3,2"]).done().stdout;
    let lines: Vec<&str> = told.lines().collect();
    assert_eq!(lines[0], "channel,wavelength_nm,S0,S1,S2,S3");
    assert!(lines[1].starts_with("blue,450,") && lines[2].starts_with("red,650,"), "{told}");
    let red = image::load(&here.join("file.exr")).unwrap().plane(0, 1)[2 * 8 + 3];
    assert_eq!(lines[2].split(',').nth(2).unwrap().parse(), Ok(red));
}

#[test]
fn responses_are_films() {
    let here = lab("responses");
    let sensor = ["--responses", "sensor.csv", "--white-balance", "lamp.spd"];
    render(&here, "a.exr", &sensor).done();
    assert_eq!(channels(&here, "a.exr"), ["vis", "nir"]);
    render(&here, "b.exr", &["--responses", "nikon-d5100"]).done();
    let described = sunstone(&here, &["inspect", "a.exr"]).done().stdout;
    for words in
        ["responses of sensor.csv (vis, nir) from 400 to 780 nm", "S0.nir", "1 for lamp.spd"]
    {
        assert!(described.contains(words), "{words}: {described}");
    }
    // The scene states greys and colors under daylight by default.
    assert!(described.contains("d65"), "{described}");
    for (arguments, file) in [
        (&["visualize", "a.exr", "-o", "nir.png", "--channel", "nir"][..], "nir.png"),
        (&["visualize", "a.exr", "-o", "mean.png"], "mean.png"),
        (&["visualize", "b.exr", "-o", "rgb.png", "--map", "intensity"], "rgb.png"),
        (&["view", "a.exr", "-o", "nir.html", "--channel", "nir"], "nir.html"),
    ] {
        sunstone(&here, arguments).done();
        assert!(here.join(file).exists(), "{file}");
    }
    assert!(fs::read_to_string(here.join("nir.html")).unwrap().contains("a.exr, nir"));
    let same = sunstone(&here, &["compare", "a.exr", "a.exr", "--channel", "vis"]).done().stdout;
    assert!(same.contains("one channel"), "{same}");
    for (arguments, words) in [
        (&["compare", "a.exr", "b.exr"][..], "2 responses and the second 3 responses"),
        (&["compare", "a.exr", "a.exr", "--channel", "uv"], "`uv`; it has vis, nir"),
        (&["visualize", "a.exr", "-o", "x.png", "--wavelength", "550"], "none of that has 550 nm"),
        (&["view", "a.exr", "-o", "x.html"], "name one by --channel"),
        (&["inspect", "a.exr", "--pixel", "8,0"], "8 x 6 pixels, counted from 0,0"),
    ] {
        let run = sunstone(&here, arguments);
        assert_eq!(run.code, 1, "{}", run.stderr);
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
    }
    for (arguments, words) in [
        (&["inspect", "lab.gltf", "--pixel", "0,0"][..], "--pixel goes with images"),
        (&["inspect", "a.exr", "--pixel", "3"], "as in 12,7"),
        (&["inspect", "a.exr", "--pixel=-1,2"], "as in 12,7"),
    ] {
        let run = sunstone(&here, arguments);
        assert_eq!(run.code, 2, "{}", run.stderr);
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
    }
}

#[test]
fn a_film_goes_on_and_comes_in_parts() {
    let here = lab("parts");
    let film = ["--responses", "sensor.csv"];
    render(&here, "whole.exr", &film).done();
    for part in ["1/2", "2/2"] {
        let output = format!("{}.part", &part[..1]);
        render(&here, &output, &[&film[..], &["--part", part]].concat()).done();
    }
    sunstone(&here, &["merge", "1.part", "2.part", "-o", "merged.exr", "-q"]).done();
    let [whole, merged] =
        ["whole.exr", "merged.exr"].map(|name| image::load(&here.join(name)).unwrap());
    assert_eq!((whole.planes, whole.color), (merged.planes, merged.color));
    let told = sunstone(&here, &["inspect", "1.part"]).done().stdout;
    assert!(told.contains("sensor.csv") && told.lines().all(|it| it.len() < 300), "{told}");
}

#[test]
fn what_is_wrong_with_a_film_is_said() {
    let here = lab("wrong");
    fs::write(here.join("line.csv"), "nm,a\n400,1\n500,x\n").unwrap();
    fs::write(here.join("negative.csv"), "nm,a\n400,1\n500,-3\n").unwrap();
    fs::write(here.join("bytes.csv"), [0xff, 0xfe, 0x00]).unwrap();
    fs::write(here.join("negative.spd"), "300 1\n900 -1\n").unwrap();
    fs::write(here.join("few.csv"), "center_nm,width_nm\n500,0\n").unwrap();
    fs::create_dir(here.join("folder.csv")).unwrap();
    let before = names_in(&here);
    for (options, words) in [
        (
            &["--responses", "kodak"][..],
            "--responses kodak is not known: use one of xyz, luminance",
        ),
        (&["--responses", "none.csv"], "cannot read none.csv"),
        (&["--responses", "folder.csv"], "cannot read folder.csv: not a file"),
        (&["--responses", "bytes.csv"], "cannot read bytes.csv: it is no text in UTF-8"),
        (
            &["--responses", "line.csv"],
            "line.csv, line 3: `x` is not a finite number; write a line",
        ),
        (&["--responses", "negative.csv"], "nm is -100; take it as it is, by raw_response"),
        (&["--responses", "xyz", "--range", "700:900"], "for the channel z in range 700:900"),
        (&["--responses", "xyz", "--bands", "bands.csv"], "cannot be used with"),
        (&["--responses", "xyz", "-o", "x.hdr"], "need an output that ends in .exr, .png"),
        (&["--raw-response"], "--raw-response goes with responses"),
        (&["--bands", "450"], "as in 450x20,red=650x30"),
        (&["--bands", "450x0"], "width"),
        (&["--bands", "few.csv"], "few.csv, line 2: width: 0 must be greater than 0"),
        (&["--bands", "none.csv"], "cannot read none.csv"),
        (&["--bands", "bands.csv", "--white-balance", "D50"], "bands are means of radiance"),
        (
            &["--white-balance", "noon"],
            "no light that is called `noon`: use a temperature as 3200K",
        ),
        (&["--white-balance", "100K"], "within [500, 1000000]"),
        (&["--white-balance", "none.spd"], "cannot read none.spd"),
        (&["--white-balance", "negative.spd"], "-1 must be not negative"),
        (
            &["--white-balance", "F2", "--range", "370:780"],
            "--white-balance F2 is known from 380 to 780 nm, and the film sees 370 nm",
        ),
    ] {
        let run = render(&here, "out.exr", options);
        assert_eq!(run.code, 2, "{}: {}", run.command, run.stderr);
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
        assert!(!run.stderr.contains("panicked"), "{}", run.stderr);
        assert_eq!(names_in(&here), before, "{}", run.command);
    }
    for (options, words) in [
        (&["--responses", "xyz"][..], "--responses goes with --color spectral"),
        (&["--white-balance", "D50"], "in RGB there are no spectra"),
        (&["--color", "mono", "--white-balance", "D50"], "one wavelength has none"),
    ] {
        let arguments = [&["render", "lab.gltf", "-o", "out.exr"][..], options].concat();
        let run = sunstone(&here, &arguments);
        assert_eq!(run.code, 2, "{}", run.stderr);
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
    }
}

/// Jobs name files beside the job file, and none that lie elsewhere.
#[test]
fn jobs_have_films() {
    let above = lab("jobs");
    let here = above.join("jobs");
    fs::create_dir(&here).unwrap();
    for name in ["lab.gltf", "sensor.csv", "bands.csv", "lamp.spd"] {
        fs::copy(above.join(name), here.join(name)).unwrap();
    }
    let defaults = "version = 1\n[defaults]\nscene = \"lab.gltf\"\nintegrator = \"path\"\nspp = 4\n\
                    width = 8\nheight = 8\ncolor = \"spectral\"\nresponses = \"sensor.csv\"\n\
                    white_balance = \"lamp.spd\"\n";
    let jobs = "[[jobs]]\nname = \"a\"\noutput = \"a.exr\"\n[[jobs]]\nname = \"b\"\n\
                output = \"b.exr\"\nbands = \"bands.csv\"\n[[jobs]]\nname = \"c\"\n\
                output = \"c.exr\"\ncolor = \"rgb\"\n[[jobs]]\nname = \"d\"\noutput = \"d.exr\"\n\
                raw_response = true\n";
    fs::write(here.join("jobs.toml"), format!("{defaults}{jobs}")).unwrap();
    sunstone(&above, &["batch", "jobs/jobs.toml", "-q"]).done();
    assert_eq!(channels(&here, "a.exr"), ["vis", "nir"]);
    assert_eq!(channels(&here, "b.exr"), ["blue", "red"]);
    assert_eq!(channels(&here, "c.exr"), ["R", "G", "B"]);
    let [balanced, raw] = ["a.exr", "d.exr"].map(|name| image::load(&here.join(name)).unwrap());
    assert_ne!(balanced.color, raw.color);
    // What a file holds counts, and not its name alone.
    fs::write(here.join("sensor.csv"), RESPONSES.replace("550", "560")).unwrap();
    let again = sunstone(&above, &["batch", "jobs/jobs.toml"]).done().stderr;
    assert!(again.contains("2 images") && again.contains("2 were done before"), "{again}");
    for file in ["responses = \"../sensor.csv\"", "white_balance = \"../lamp.spd\""] {
        let jobs = format!("{defaults}[[jobs]]\nname = \"x\"\noutput = \"x.exr\"\n{file}\n");
        fs::write(here.join("out.toml"), jobs).unwrap();
        let run = sunstone(&here, &["batch", "out.toml", "--results", "o.jsonl"]);
        assert_eq!(run.code, 2, "{}", run.stderr);
        assert!(run.stderr.contains("is outside of the folder of the job file"), "{}", run.stderr);
        let allowed = ["batch", "out.toml", "--results", "o.jsonl", "--allow-outside", "-q"];
        sunstone(&here, &allowed).done();
    }
}
