//! Scenes of Mitsuba on the command line: parameters, what a scene asks for, and glTF out.

use std::fs;
use std::path::Path;

use crate::program::{folder, sunstone};

#[test]
fn scenes_of_mitsuba_are_rendered_as_they_ask_and_written_as_gltf() {
    let here = folder("mitsuba");
    let plate = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/plate.xml");
    fs::copy(plate, here.join("plate.xml")).unwrap();
    let small = ["--width", "8", "--height", "6"];
    let render = |scene: &str, more: &[&str]| {
        let arguments = [&["render", scene, "-o", "out.exr"][..], &small, more].concat();
        sunstone(&here, &arguments)
    };
    let run = render("plate.xml", &["-D", "spp=3"]).done();
    let asked = "note: as the scene asks: --spp 3 --max-path-length 8 --integrator path";
    assert!(run.stderr.contains(asked), "{}", run.stderr);
    assert!(run.stderr.contains("3 samples a pixel of path (polarized)"), "{}", run.stderr);
    let typed = ["--spp", "2", "--integrator", "bdpt", "--max-path-length", "4"];
    let run = render("plate.xml", &typed).done();
    assert!(run.stderr.contains("2 samples a pixel of bdpt"), "{}", run.stderr);

    sunstone(&here, &["convert", "plate.xml", "plate.gltf", "-D", "axis=30"]).done();
    let told = sunstone(&here, &["inspect", "plate.gltf"]).done().stdout;
    assert!(told.contains("linear polarizer at -30 degrees"), "{told}");

    for (scene, definition, words) in [
        ("plate.xml", "ior=2", "the scene has no parameter `ior`"),
        ("plate.xml", "angle=steep", "`steep` is not a number"),
        ("plate.gltf", "axis=1", "glTF has no parameters"),
    ] {
        let run = render(scene, &["-D", definition]);
        assert!(run.stderr.contains(words), "{definition}: {}", run.stderr);
    }
    let run = sunstone(&here, &["convert", "plate.xml", "plate.xml"]);
    assert!(run.stderr.contains("scenes are written as glTF files"), "{}", run.stderr);
}
