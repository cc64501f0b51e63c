//! The verb `report`: what has become of every job stands in the page, and nothing stops it. What
//! the page shows is looked at in a browser by `.ci/view/run`.

use std::fs;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use sunstone::internals::image::{self, StokesImage};
use sunstone::internals::spectrum::Color;

use crate::program::{Run, folder, names_in, scene, sunstone};

const MONO: Color = Color::Mono { wavelength_nm: 550.0 };

/// A record as a batch would write it.
fn record(index: usize, output: &str) -> Value {
    json!({
        "jobs": "jobs.toml", "index": index, "name": format!("job {index}"),
        "values": {"angle": 10 * index}, "output": output, "seconds": 0.25, "error": null,
        "checksum": null, "key": "", "inputs": {},
    })
}

fn with(mut record: Value, key: &str, value: impl Into<Value>) -> Value {
    record[key] = value.into();
    record
}

/// Writes the results of a batch.
fn write(here: &Path, records: &[Value]) {
    let lines: String = records.iter().map(|record| format!("{record}\n")).collect();
    fs::write(here.join("results.jsonl"), lines).unwrap();
}

/// An image whose S0 is `s0` and whose other components, if there are any, half of it.
fn flat(color: Color, components: usize, s0: f32) -> StokesImage {
    let mut image = StokesImage::new(6, 4, color.clone(), components);
    for (at, plane) in image.planes.iter_mut().enumerate() {
        plane.fill(if at < color.channels() { s0 } else { 0.5 * s0 });
    }
    image
}

fn save(here: &Path, name: &str, image: &StokesImage) {
    let path = here.join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    image.save(&path).unwrap();
}

fn report(here: &Path, arguments: &[&str]) -> Run {
    sunstone(here, &[&["report", ".", "-o", "report.html"][..], arguments].concat())
}

/// The text and the data of the page.
fn page(here: &Path) -> (String, Value) {
    let text = fs::read_to_string(here.join("report.html")).unwrap();
    let data = text.split("id=\"data\">").nth(1).unwrap().split("</script>").next().unwrap();
    let data = serde_json::from_str(data).unwrap();
    (text, data)
}

fn jobs(here: &Path) -> Vec<Value> {
    page(here).1["jobs"].as_array().unwrap().clone()
}

/// The codes of the small copy of a job.
fn codes(page: &str, at: usize) -> Vec<u8> {
    let packed = page.split(&format!("id=\"pixels-{at}\">")).nth(1).unwrap();
    let packed = STANDARD.decode(packed.split('<').next().unwrap()).unwrap();
    let mut bytes = Vec::new();
    std::io::Read::read_to_end(&mut flate2::read::ZlibDecoder::new(&packed[..]), &mut bytes)
        .unwrap();
    bytes
}

#[test]
fn a_batch_of_which_some_fail_is_complete() {
    let here = folder("report-batch");
    fs::copy(scene("cornell"), here.join("lab.gltf")).unwrap();
    let defaults = "version = 1\n[defaults]\nscene = \"lab.gltf\"\nintegrator = \"path\"\n\
                    spp = 1\nwidth = 8\nheight = 8\n";
    let sweeps = [
        ("bad", "materials/glass/ior", "from = -10, to = -1, count = 10"),
        ("good", "nodes/glass ball/translation.0", "from = 0, to = 0.19, count = 20"),
    ];
    let sweeps = sweeps.map(|(name, key, values)| {
        let output = format!("name = \"{name}\"\noutput = \"{name}/{{x}}.exr\"");
        let sweep = format!("sweep = [{{ name = \"x\", key = \"{key}\", {values} }}]");
        format!("[[jobs]]\n{output}\n{sweep}\n")
    });
    fs::write(here.join("jobs.toml"), format!("{defaults}{}", sweeps.concat())).unwrap();
    let run = sunstone(&here, &["batch", "jobs.toml", "--threads", "2"]);
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(run.stderr.contains("10 jobs failed"), "{}", run.stderr);
    let run = report(&here, &[]).done();
    assert!(run.stdout.is_empty());
    assert!(run.stderr.starts_with("report.html: 30 jobs, 10 failed; 0."), "{}", run.stderr);
    let jobs = jobs(&here);
    assert_eq!(jobs.len(), 30);
    let failed = jobs.iter().filter(|job| !job["error"].is_null());
    let causes: Vec<&str> = failed.flat_map(|job| job["error"].as_str()).collect();
    assert_eq!(causes.len(), 10);
    assert!(causes.iter().all(|cause| cause.contains("ior")), "{causes:?}");
    for (index, job) in jobs.iter().enumerate() {
        assert_eq!((&job["index"], &job["changed"]), (&json!(index), &json!(false)));
        assert_eq!(job["image"].is_null(), !job["error"].is_null(), "{job}");
        assert!(job["problem"].is_null());
    }
    // Figures are the file's.
    let image = image::load(&here.join("good/0.0.exr")).unwrap();
    let found = jobs.iter().find(|job| job["output"] == json!("good/0.0.exr")).unwrap();
    for component in 0..4 {
        for channel in 0..3 {
            let plane = image.plane(component, channel);
            let mean = plane.iter().map(|value| f64::from(*value)).sum::<f64>() / 64.0;
            let shown = found["image"]["mean"][component][channel].as_f64().unwrap();
            assert!((shown - mean).abs() <= 1e-15 * mean.abs(), "{shown} {mean}");
        }
    }
}

#[test]
fn images_of_all_kinds_stand_side_by_side() {
    let here = folder("report-kinds");
    let kinds = [(Color::Rgb, 4), (Color::Rgb, 1), (MONO, 4), (MONO, 1)];
    for (at, (color, components)) in kinds.into_iter().enumerate() {
        save(&here, &format!("{at}.exr"), &flat(color, components, 0.5));
    }
    let mut odd = flat(MONO, 4, 1.0);
    odd.planes[0][0] = f32::NAN;
    odd.planes[3][5] = f32::INFINITY;
    save(&here, "4.exr", &odd);
    odd.planes[0].fill(f32::NAN);
    save(&here, "5.exr", &odd);
    save(&here, "6.hdr", &flat(Color::Rgb, 4, 0.25));
    save(&here, "7.png", &flat(Color::Rgb, 4, 0.25));
    save(&here, "8.exr", &StokesImage::new(1, 3000, Color::Rgb, 4));
    let names = ["0.exr", "1.exr", "2.exr", "3.exr", "4.exr", "5.exr", "6.hdr", "7.png", "8.exr"];
    let records: Vec<Value> = (0..).zip(names).map(|(at, name)| record(at, name)).collect();
    write(&here, &records);
    let run = report(&here, &["--thumbnails", "32"]).done();
    assert!(run.stderr.contains("9 jobs, 1 without an image to show;"), "{}", run.stderr);
    let (text, data) = page(&here);
    let image = |at: usize| &data["jobs"][at]["image"];
    assert_eq!(
        image(0)["mean"],
        json!([vec![0.5; 3], vec![0.25; 3], vec![0.25; 3], vec![0.25; 3]])
    );
    assert_eq!(image(1)["mean"], json!([[0.5, 0.5, 0.5]]));
    assert_eq!(image(3)["channels"], json!(["550 nm"]));
    assert_eq!((&image(4)["mean"][0], &image(4)["not_finite"]), (&json!([1.0]), &json!(2)));
    assert_eq!((&image(5)["mean"], &image(5)["not_finite"]), (&Value::Null, &json!(24)));
    assert_eq!(image(6)["components"], 4);
    assert_eq!(data["jobs"][6]["link"], "6.S0.hdr");
    let png = data["jobs"][7]["problem"].as_str().unwrap();
    assert!(png.contains(".png files cannot be read"), "{png}");
    assert_eq!(data["jobs"][7]["link"], "7.png");
    assert_eq!(
        (&image(8)["thumbnail"]["width"], &image(8)["thumbnail"]["height"]),
        (&json!(1), &json!(32))
    );
    // S0 by channel, then degree, angle and ellipticity.
    let lengths = [6, 3, 4, 1, 4, 4].map(|planes: usize| planes * 24);
    assert_eq!([0, 1, 2, 3, 4, 5].map(|at| codes(&text, at).len()), lengths);
    let rgb = codes(&text, 0);
    assert!(rgb[..72].iter().all(|code| *code == 255), "half is as bright as it gets");
    // S1 = S2 = S3 = S0 / 2: 22.5 degrees, and 17.6 of ellipticity.
    assert_eq!([rgb[72], rgb[96], rgb[120]], [237, 32, 127 + 50]);
    assert_eq!(codes(&text, 4)[2 * 24 + 5], 0, "no light where it is not finite");
}

#[test]
#[cfg(unix)]
fn images_that_are_not_what_was_rendered_are_told() {
    let here = folder("report-changed");
    let image = flat(MONO, 4, 0.5);
    for name in ["same.exr", "changed.exr", "damaged.exr", "empty.exr"] {
        save(&here, name, &image);
    }
    fs::write(here.join("damaged.exr"), &fs::read(here.join("same.exr")).unwrap()[..300]).unwrap();
    fs::write(here.join("empty.exr"), "").unwrap();
    fs::create_dir(here.join("folder.exr")).unwrap();
    let outside = folder("report-changed-outside");
    save(&outside, "outside.exr", &image);
    std::os::unix::fs::symlink(outside.join("outside.exr"), here.join("link.exr")).unwrap();
    let sum = "0000000000000000000000000000000000000000000000000000000000000000";
    let absolute = outside.join("outside.exr").to_string_lossy().into_owned();
    write(
        &here,
        &[
            record(0, "same.exr"),
            with(record(1, "changed.exr"), "checksum", sum),
            // Told once, whatever its checksum.
            with(record(2, "damaged.exr"), "checksum", sum),
            record(3, "empty.exr"),
            record(4, "gone.exr"),
            record(5, "folder.exr"),
            record(6, "link.exr"),
            record(7, "../report-changed-outside/outside.exr"),
            record(8, &absolute),
            record(9, "same.jpg"),
            record(10, ""),
            record(11, "/dev/zero.exr"),
            with(record(12, "failed.exr"), "error", "no such metal"),
            record(13, "nul\0.exr"),
        ],
    );
    let run = report(&here, &[]).done();
    let words = "14 jobs, 1 failed, 11 without an image to show, 1 changed since;";
    assert!(run.stderr.contains(words), "{}", run.stderr);
    let jobs = jobs(&here);
    let shown: Vec<usize> = (0..14).filter(|at| !jobs[*at]["image"].is_null()).collect();
    assert_eq!(shown, [0, 1]);
    assert_eq!(jobs[1]["changed"], true);
    for (at, words) in [
        (2, "damaged.exr is not a usable EXR file"),
        (3, "empty.exr is not a usable EXR file"),
        (4, "the image is gone"),
        (5, "it is not a file"),
        (6, "outside of the folder of the batch; allow it by --allow-outside"),
        (7, "outside of the folder of the batch"),
        (8, "outside of the folder of the batch"),
        (9, "cannot tell the format of"),
        (10, "cannot tell the format of"),
        (11, "the image is gone"),
        (13, "the image cannot be read"),
    ] {
        let problem = jobs[at]["problem"].as_str().unwrap_or("none");
        assert!(problem.contains(words), "{at}: {problem}");
    }
    assert_eq!(jobs[12]["error"], "no such metal");
    let run = report(&here, &["--allow-outside", "--thumbnails", "8"]).done();
    assert!(run.stderr.contains("8 without an image to show"), "{}", run.stderr);
}

#[test]
fn words_are_text_and_paths_are_addresses() {
    let here = folder("report-words");
    let names = [
        "<b>bold & \"quoted\".exr",
        "<script>alert(1)<.exr",
        "100% of #1?.exr",
        "ünï 漢.exr",
        "{{data}} {{pixels}}.exr",
        "a'b\\c`${1}.exr",
        "javascript:alert(1).exr",
        "line\nbreak.exr",
    ];
    let mut records = Vec::new();
    for (at, name) in names.into_iter().enumerate() {
        save(&here, &format!("out <1>/{name}"), &flat(MONO, 4, 0.5));
        let record = with(record(at, &format!("out <1>/{name}")), "name", name);
        let record =
            with(record, "values", json!({name: name, "__proto__": [1, null], "": {"a": 1}}));
        records.push(with(record, "jobs", "<i>.toml"));
    }
    let hostile = "</script><script>alert(1)</script>\u{2028}\u{202e}<!--";
    records.push(with(record(100, "x.exr"), "error", hostile));
    write(&here, &records);
    report(&here, &[]).done();
    let (text, data) = page(&here);
    let jobs = data["jobs"].as_array().unwrap();
    let all = text.matches("<script").count();
    assert_eq!(text.matches("</script>").count(), all);
    assert_eq!(all, names.len() + 2, "images, data and scripts alone");
    assert!(!text.contains("alert(1)<") && !text.contains("<b>bold"));
    for (job, name) in jobs.iter().zip(names) {
        assert_eq!(job["values"][name], name);
        let shown = name.replace('\n', "\\n");
        assert_eq!((&job["name"], &job["problem"]), (&json!(shown), &Value::Null));
    }
    let links = jobs.iter().map(|job| job["link"].as_str().unwrap_or("none"));
    let links: Vec<&str> = links.map(|link| link.trim_start_matches("out%20%3C1%3E/")).collect();
    assert_eq!(links[0], "%3Cb%3Ebold%20%26%20%22quoted%22.exr");
    assert_eq!(links[2], "100%25%20of%20%231%3F.exr");
    assert_eq!(links[6], "javascript%3Aalert%281%29.exr");
    let rest = text.replace("http://www.w3.org/2000/svg", "");
    for word in ["http:", "https:", "//cdn", " src=", "@import", "url(", "fetch(", "XMLHttp"] {
        assert!(!rest.contains(word), "{word}");
    }
    assert!(text.contains("content=\"default-src 'none';"));
    // The page elsewhere: links lead there from its folder.
    fs::create_dir(here.join("pages")).unwrap();
    sunstone(&here, &["report", "results.jsonl", "-o", "pages/all.html"]).done();
    let text = fs::read_to_string(here.join("pages/all.html")).unwrap();
    assert!(text.contains("\"link\":\"../out%20%3C1%3E/100%25%20of%20%231%3F.exr\""));
}

#[test]
fn the_last_line_of_an_output_counts() {
    let here = folder("report-lines");
    save(&here, "a.exr", &flat(MONO, 1, 0.5));
    let lines = [
        with(record(0, "a.exr"), "error", "out of luck").to_string(),
        record(1, "b.exr").to_string(),
        "no line".to_owned(),
        String::new(),
        record(2, "other.exr").to_string().replace("jobs.toml", "another.toml"),
        with(record(0, "a.exr"), "seconds", 2.5).to_string(),
        record(3, "c.exr").to_string(),
    ];
    // The last one without an end is a line, and a part of it none.
    for (cut, count) in [(0, 4), (1, 3)] {
        let text = lines.join("\n");
        fs::write(here.join("results.jsonl"), &text[..text.len() - cut]).unwrap();
        let run = report(&here, &[]).done();
        let words =
            format!("warning: ./results.jsonl: {} cannot be read", ["1 line", "2 lines"][cut]);
        assert!(run.stderr.contains(&words), "{}", run.stderr);
        let (_, data) = page(&here);
        let jobs = data["jobs"].as_array().unwrap();
        let outputs: Vec<&Value> = jobs.iter().map(|job| &job["output"]).collect();
        assert_eq!(outputs, ["other.exr", "a.exr", "b.exr", "c.exr"][..count].to_vec());
        assert_eq!((&jobs[1]["seconds"], &jobs[1]["error"]), (&json!(2.5), &Value::Null));
        assert_eq!(data["broken"], 1 + cut);
    }
}

#[test]
fn a_batch_without_jobs_has_a_page() {
    let here = folder("report-empty");
    fs::write(here.join("results.jsonl"), "").unwrap();
    let run = report(&here, &[]).done();
    assert!(run.stderr.starts_with("report.html: 0 jobs; 0."), "{}", run.stderr);
    assert_eq!(jobs(&here), Vec::<Value>::new());
}

#[test]
fn the_same_batch_gives_the_same_page() {
    let here = folder("report-same");
    let names: Vec<String> = (0..40).map(|at| format!("{at}.exr")).collect();
    for (at, name) in names.iter().enumerate() {
        save(&here, name, &flat(Color::Rgb, 4, at as f32));
    }
    let mut records: Vec<Value> =
        names.iter().enumerate().map(|(at, name)| record(at, name)).collect();
    write(&here, &records);
    report(&here, &[]).done();
    let first = page(&here).0;
    // Lines come in the order in which jobs come to an end.
    records.reverse();
    write(&here, &records);
    report(&here, &["-q"]).done();
    assert!(page(&here).0 == first);
}

fn refused(here: &Path, arguments: &[&str], code: i32, words: &[&str]) {
    let before = names_in(here);
    let run = sunstone(here, &[&["report"], arguments].concat());
    assert_eq!((run.code, run.stdout.as_str()), (code, ""), "{}", run.stderr);
    for words in words {
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
    }
    assert_eq!(names_in(here), before, "nothing is left");
}

#[test]
fn what_cannot_be_reported_is_refused_in_words() {
    let here = folder("report-refused");
    save(&here, "a.exr", &flat(MONO, 1, 0.5));
    write(&here, &[record(0, "a.exr")]);
    fs::write(here.join("jobs.toml"), "version = 1\n[[jobs]]\n").unwrap();
    fs::create_dir(here.join("empty")).unwrap();
    let words = ["empty has no results.jsonl", "`sunstone batch JOBS` writes it", "--results"];
    refused(&here, &["empty", "-o", "x.html"], 1, &words);
    refused(&here, &["gone", "-o", "x.html"], 1, &["cannot read gone: No such file"]);
    refused(&here, &["jobs.toml", "-o", "x.html"], 1, &["jobs.toml: no line is of a job"]);
    refused(&here, &[".", "-o", "x.png"], 2, &["x.png must end in .html"]);
    refused(&here, &[".", "-o", "no/x.html"], 1, &["create the folder no first"]);
    refused(&here, &[".", "-o", "empty.html", "--thumbnails", "7"], 2, &["from 8 to 512"]);
    fs::rename(here.join("results.jsonl"), here.join("results.html")).unwrap();
    let same = ["results.html", "-o", "results.html"];
    refused(&here, &same, 2, &["the output results.html is the input"]);
    // Images beside another folder.
    let elsewhere: PathBuf = here.join("empty/results.jsonl");
    fs::rename(here.join("results.html"), elsewhere).unwrap();
    let run = sunstone(&here, &["report", "empty", "-o", "x.html"]).done();
    assert!(run.stderr.contains("note: no image can be shown; --images"), "{}", run.stderr);
    let run = sunstone(&here, &["report", "empty", "-o", "x.html", "--images", "."]).done();
    assert!(run.stderr.starts_with("x.html: 1 job; "), "{}", run.stderr);
}

/// A folder in which nothing can be written. Whoever may write everywhere is no test of it.
#[test]
#[cfg(unix)]
fn a_folder_that_is_read_only_is_told_before_images_are_read() {
    use std::os::unix::fs::PermissionsExt;
    let here = folder("report-read-only");
    save(&here, "a.exr", &flat(MONO, 1, 0.5));
    write(&here, &[record(0, "a.exr")]);
    let locked = here.join("locked");
    fs::create_dir(&locked).unwrap();
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o555)).unwrap();
    if fs::write(locked.join("probe"), "").is_ok() {
        fs::remove_file(locked.join("probe")).unwrap();
        // For the superuser, a system that is read-only.
        let run = sunstone(&here, &["report", ".", "-o", "/proc/x.html"]);
        assert_eq!(run.code, 1, "{}", run.stderr);
        assert!(run.stderr.contains("cannot write /proc/x.html"), "{}", run.stderr);
    } else {
        refused(&here, &[".", "-o", "locked/x.html"], 1, &["make the folder locked writable"]);
    }
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o755)).unwrap();
}
