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

/// The pixels of an image of a scene, bit for bit.
fn pixels(here: &Path, scene: &str, color: &[&str]) -> Vec<Vec<u32>> {
    let small = ["--width", "12", "--height", "9", "--spp", "2", "--integrator", "path"];
    let arguments = [&["render", scene, "-o", "out.exr"][..], &small, color].concat();
    sunstone(here, &arguments).done();
    let image = sunstone::internals::image::load(&here.join("out.exr")).unwrap();
    image.planes.iter().map(|plane| plane.iter().map(|it| it.to_bits()).collect()).collect()
}

#[test]
fn what_is_painted_is_written_with_its_pictures_and_has_the_same_image() {
    let here = folder("painted");
    ["in", "to"].iter().for_each(|name| fs::create_dir_all(here.join(name)).unwrap());
    let texel = |x: u32, y: u32| image::Rgb([(50 * x) as u8, (90 * y) as u8, 128]);
    image::ImageBuffer::from_fn(5, 3, texel).save(here.join("in/wall paper.png")).unwrap();
    let bitmap = |name: &str, inner: &str| {
        format!(
            "<texture type='bitmap' name='{name}'><string name='filename' value='wall paper.png'/>\
             {inner}</texture>"
        )
    };
    let (raw, turned) = (
        "<boolean name='raw' value='true'/>",
        "<transform name='to_uv'><rotate z='1' angle='30'/><scale value='2'/></transform>",
    );
    let place = |x: f32, inner: &str| {
        format!(
            "<shape type='rectangle'>{inner}<transform name='to_world'><scale value='0.5'/>\
             <translate x='{x}'/></transform></shape>"
        )
    };
    // An angle of view that single precision holds, so that all bits are the same.
    let scene = [
        "<scene version='3.0.0'><emitter type='envmap'><string name='filename' value='wall \
         paper.png'/></emitter><sensor type='perspective'><float name='fov' value='90'/><string \
         name='fov_axis' value='y'/><transform name='to_world'><lookat origin='0,0,2' \
         target='0,0,0' up='0,1,0'/></transform></sensor>"
            .to_owned(),
        place(-1.2, &format!("<bsdf type='diffuse'>{}</bsdf>", bitmap("reflectance", turned))),
        place(
            -0.2,
            &format!(
                "<bsdf type='mask'>{}<bsdf type='roughconductor'>{}</bsdf></bsdf>",
                bitmap("opacity", raw),
                bitmap("alpha", raw)
            ),
        ),
        place(
            0.9,
            &format!(
                "<bsdf type='normalmap'>{}<bsdf type='pplastic'>{}</bsdf></bsdf>",
                bitmap("normalmap", raw),
                bitmap("diffuse_reflectance", "")
            ),
        ),
        "</scene>".to_owned(),
    ]
    .concat();
    fs::write(here.join("in/scene.xml"), scene).unwrap();
    let run = sunstone(&here, &["convert", "in/scene.xml", "to/out.gltf"]).done();
    assert!(run.stderr.contains("note: beside it: to/wall paper.png"), "{}", run.stderr);
    let run = sunstone(&here, &["convert", "to/out.gltf", "whole.glb"]).done();
    assert!(!run.stderr.contains("beside"), "{}", run.stderr);
    for color in [&["--color", "rgb"][..], &["--color", "mono"]] {
        let own = pixels(&here, "in/scene.xml", color);
        assert_eq!(own, pixels(&here, "to/out.gltf", color));
        assert_eq!(own, pixels(&here, "whole.glb", color));
    }
}
