//! Batches of scenes of Mitsuba: their parameters, and what they ask for.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use sunstone::internals::image;

use crate::program::{folder, sunstone};

const SCENE: &str = "<scene version='3.0.0'><default name='spp' value='3'/><default name='gray' \
    value='0.5'/><default name='wide' value='6'/><integrator type='path'><integer name='max_depth' \
    value='5'/></integrator><sensor type='perspective'><sampler type='independent'><integer \
    name='sample_count' value='$spp'/><integer name='seed' value='9'/></sampler><film \
    type='hdrfilm'><integer name='width' value='$wide'/><integer name='height' value='4'/><rfilter \
    type='box'/></film></sensor><shape type='sphere'><point name='center' x='0' y='0' z='4'/><bsdf \
    type='diffuse'><rgb name='reflectance' value='$gray'/></bsdf></shape><emitter type='constant'/>\
    </scene>";

fn lab(name: &str, jobs: &str) -> PathBuf {
    let here = folder(&format!("batch-mitsuba-{name}"));
    fs::write(here.join("lab.xml"), SCENE).unwrap();
    fs::copy(crate::program::scene("cornell"), here.join("lab.gltf")).unwrap();
    fs::write(here.join("jobs.toml"), jobs).unwrap();
    here
}

/// The pixels of an image, and what it says of its making.
fn read(here: &Path, name: &str) -> (Vec<Vec<f32>>, Vec<(String, String)>) {
    let image = image::load(&here.join(name)).unwrap();
    (image.planes, image.metadata)
}

fn fact<'a>(facts: &'a [(String, String)], key: &str) -> &'a str {
    facts.iter().find(|(known, _)| known == key).map_or("", |(_, value)| value)
}

#[test]
fn parameters_are_set_and_swept_and_what_scenes_ask_for_counts() {
    let jobs = "version = 1\n[defaults]\nscene = \"lab.xml\"\ndefine = { gray = 0.25, wide = 7 }\n\
        [[jobs]]\nname = \"plain\"\noutput = \"{name}.exr\"\n\
        [[jobs]]\nname = \"own\"\noutput = \"{name}.exr\"\ndefine = { gray = [0.1, 0.2, 0.3] }\n\
        spp = 2\nset = { \"define/wide\" = 5 }\n\
        [[jobs]]\nname = \"swept\"\noutput = \"{name}-{gray}-{spp}.exr\"\nsweep = [\n\
        { name = \"gray\", key = \"define/gray\", values = [0.5, 1] },\n\
        { name = \"spp\", key = \"define/spp\", values = [1, 4] }]\n";
    let here = lab("swept", jobs);
    let run = sunstone(&here, &["batch", "jobs.toml", "--threads", "2"]).done();
    let asked = "\"plain\": as the scene asks: spp 3 seed 9 max_path_length 5 integrator path";
    assert!(run.stderr.contains(asked), "{}", run.stderr);
    let cases: [(&str, &[&str]); 4] = [
        ("plain.exr", &["-D", "gray=0.25", "-D", "wide=7"]),
        ("own.exr", &["-D", "gray=0.1, 0.2, 0.3", "-D", "wide=5", "--spp", "2"]),
        ("swept-0.5-4.exr", &["-D", "gray=0.5", "-D", "wide=7", "-D", "spp=4"]),
        ("swept-1-1.exr", &["-D", "gray=1", "-D", "wide=7", "-D", "spp=1"]),
    ];
    for (name, definitions) in cases {
        let arguments = [&["render", "lab.xml", "-o", "own-render.exr"][..], definitions].concat();
        sunstone(&here, &arguments).done();
        let (pixels, facts) = read(&here, name);
        let (rendered, of_render) = read(&here, "own-render.exr");
        assert!(pixels == rendered, "{name}");
        for key in ["seed", "iterations", "integrator"] {
            assert_eq!(fact(&facts, key), fact(&of_render, key), "{name}, {key}");
        }
    }
    let (pixels, facts) = read(&here, "plain.exr");
    assert_eq!((pixels[0].len(), fact(&facts, "seed")), (7 * 4, "9"));
    // Nothing is left to do, until the scene asks for something else.
    let run = sunstone(&here, &["batch", "jobs.toml", "--dry-run"]).done();
    assert!(run.stdout.contains("6 jobs, 0 to do"), "{}", run.stdout);
    fs::write(here.join("lab.xml"), SCENE.replace("'5'", "'6'")).unwrap();
    let run = sunstone(&here, &["batch", "jobs.toml", "--dry-run"]).done();
    assert!(run.stdout.contains("6 jobs, 6 to do"), "{}", run.stdout);
    let text = fs::read_to_string(here.join("results.jsonl")).unwrap();
    let records: Vec<Value> =
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(records.iter().any(|it| it["values"]["gray"] == 0.5 && it["values"]["spp"] == 4));
}

#[test]
fn what_is_wrong_with_parameters_is_told_before_anything_is_rendered() {
    let start = "version = 1\n[[jobs]]\nscene = \"lab.xml\"\noutput = \"a.exr\"\n";
    for (jobs, words) in [
        ("define = { grey = 1 }", "the scene has no parameter `grey`; it has gray, spp, wide"),
        ("define = { gray = { a = 1 } }", "is no value of a parameter"),
        ("define = 3", "`define` is not a table of parameters"),
        ("define = { gray = 1 }\nset = { \"define/gray\" = 2 }", "`define/gray` is stated twice"),
        (
            "define = { gray = 1 }\n\
             sweep = [{ name = \"g\", key = \"define/gray\", values = [1] }]",
            "`define/gray` is stated twice",
        ),
        ("set = { \"materials/a/ior\" = 2 }", "cannot be edited by name, but for their parameters"),
        ("define = { gray = 1 }\nunset = [\"define/gray\"]", "`define/gray` is stated twice"),
        ("spp = 0", "spp must be from 1"),
    ] {
        let here = lab("wrong", &format!("{start}{jobs}\n"));
        let run = sunstone(&here, &["batch", "jobs.toml"]);
        assert_eq!(run.code, 2, "{jobs}: {}", run.stderr);
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
        assert!(run.stderr.ends_with("nothing has been rendered\n"), "{}", run.stderr);
    }
    let jobs = format!("{start}define = {{ gray = 1 }}\n").replace("lab.xml", "lab.gltf");
    let here = lab("gltf", &jobs);
    let run = sunstone(&here, &["batch", "jobs.toml"]);
    assert!(run.stderr.contains("define/gray: glTF has no parameters"), "{}", run.stderr);
    // A value that the scene does not take is told by the job.
    let here = lab("steep", &format!("{start}define = {{ spp = \"few\" }}\n"));
    let run = sunstone(&here, &["batch", "jobs.toml"]);
    assert!(run.code != 0 && run.stderr.contains("`few` is not an integer"), "{}", run.stderr);
}
