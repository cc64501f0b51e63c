//! Scenes that are written as glTF with their pictures, and read again: they have the same
//! textures, bit for bit.

use std::fs;
use std::path::{Path, PathBuf};

use image::{ImageBuffer, Luma, Rgb, Rgba};
use serde_json::{Value, json};
use sunstone::Spectrum;
use sunstone::glam::Vec4;
use sunstone::glam::{DAffine3, DVec3};
use sunstone::internals::scene::{World, Written, load};
use sunstone::world::{
    Bsdf, Coverage, Emission, Environment, Filter, Geometry, Layers, Material, Mesh, Paint,
    Parameter, Photometry, Picture, Projection, Reads, Sides, Texture, Textures, ThinFilm, Wrap,
};

use crate::common::scratch;
use crate::mitsuba::scene;
use crate::textures::painted;

/// A folder for the files of a test.
fn folder(name: &str) -> PathBuf {
    let folder = scratch(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn loaded(path: &Path) -> World {
    load(path).unwrap_or_else(|error| panic!("{error}"))
}

/// A world as it is read from what is written of it, as .gltf in a folder of its own and as .glb.
fn again(world: &World, name: &str) -> [World; 2] {
    let written = Written::of(world).unwrap_or_else(|error| panic!("{error}"));
    ["again.gltf", "again.glb"].map(|file| {
        let path = folder(name).join(file);
        let beside = written.save(&path).unwrap();
        assert!(file.ends_with("gltf") || beside.is_empty());
        loaded(&path)
    })
}

/// A texture without its picture, and all texels of that.
fn told(texture: &Texture) -> String {
    let Texture { picture, coding, wrap, filter, set, transform } = texture;
    let size @ [width, height] = picture.texels().size();
    let at = |at: u32| picture.texels().at(at % width, at / width, *coding).map(f32::to_bits);
    let texels: Vec<[u32; 4]> = (0..width * height).map(at).collect();
    // Zeros have no sign here.
    let transform = transform.map(|row| row.map(|value| value + 0.0));
    format!("{wrap:?} {filter:?} {set} {transform:?} {size:?} {texels:?}")
}

fn told_of(paint: &Paint) -> String {
    let Paint { factor, texture, reads, by_vertices } = paint;
    // Where there is nothing to be read, it does not matter what is.
    let reads = (texture.is_some() || *by_vertices).then_some(reads);
    format!("{factor:?} {reads:?} {by_vertices} {:?}", texture.as_ref().map(told))
}

/// All textures of a world in order, with the meshes that they lie on.
fn all_textures(world: &World) -> Vec<String> {
    let mut list = Vec::new();
    let mut query = world.entities().query::<&Textures>();
    let (mut is_painted, mut is_tinted, mut has_alpha) = (false, false, true);
    for textures in query.iter() {
        is_painted |= textures.textures().next().is_some();
        is_tinted |= textures.read_vertices();
        has_alpha &= textures.coverage.as_ref().is_none_or(|it| it.paint.by_vertices);
        let mut parameters: Vec<String> = (textures.parameters.iter())
            .map(|(parameter, paint)| format!("{parameter:?} {}", told_of(paint)))
            .collect();
        parameters.sort();
        let emission = textures.emission.as_ref().map(told_of);
        let coverage =
            textures.coverage.as_ref().map(|it| format!("{:?} {}", it.cutoff, told_of(&it.paint)));
        let relief = textures.relief.as_ref();
        let relief = relief.map(|it| format!("{:?} {} {}", it.of, it.scale, told(&it.texture)));
        let stain: Vec<String> = textures.stain.paints().map(told_of).collect();
        list.push(format!("{parameters:?} {emission:?} {coverage:?} {relief:?} {stain:?}"));
    }
    let mut query = world.entities().query::<&Mesh>();
    // Coordinates of nothing need not be there.
    for Mesh(geometry) in query.iter().filter(|_| is_painted) {
        let Geometry { texture_coordinates, texture_coordinates_1, colors, tangents, .. } =
            &**geometry;
        // So need alpha that does not count.
        let color = |of: &Vec4| if has_alpha { *of } else { of.truncate().extend(1.0) };
        let colors = is_tinted.then(|| colors.iter().map(color).collect::<Vec<_>>());
        list.push(format!(
            "{texture_coordinates:?} {texture_coordinates_1:?} {colors:?} {tangents:?}"
        ));
    }
    list.sort();
    list
}

fn assert_same(world: &World, name: &str) {
    let own = all_textures(world);
    for other in again(world, name) {
        assert_eq!(own, all_textures(&other), "{name}");
        let models = |world: &World| {
            let mut models: Vec<String> =
                world.entities().query::<&Bsdf>().iter().map(|bsdf| format!("{bsdf:?}")).collect();
            models.sort();
            models
        };
        assert_eq!(models(world), models(&other), "{name}");
    }
}

/// Pictures of all widths beside the scene.
fn put_pictures(folder: &Path) {
    let of = |x: u32, y: u32, channel: u32| ((37 * x + 91 * y + 53 * channel + 7) % 256) as u8;
    ImageBuffer::from_fn(3, 2, |x, y| Rgb([0, 1, 2].map(|channel| of(x, y, channel))))
        .save(folder.join("rgb.png"))
        .unwrap();
    ImageBuffer::from_fn(2, 3, |x, y| Rgba([0, 1, 2, 3].map(|channel| of(x, y, channel))))
        .save(folder.join("a b%20c#?.webp"))
        .unwrap();
    ImageBuffer::from_fn(2, 2, |x, y| Luma([u16::from(of(x, y, 0)) * 257 + 3]))
        .save(folder.join("gray.png"))
        .unwrap();
}

/// Materials with keys of the extension, with a texture and what else there is of them.
fn of_the_extension(turned: &Value, pbr: &Value) -> Vec<Value> {
    let extension = |body: Value| json!({"SUNSTONE_polarization": body});
    vec![
        json!({"extensions": extension(json!({"bsdf": "rough_conductor", "metal": "Al",
            "alpha": 0.5, "alpha_texture": {"index": 0, "extensions": extension(json!(
            {"channel": "green", "coding": "srgb", "transform": [[1, 0.5, 0], [0, 1, 3]]}))},
            "coverage":
                {"share": 0.5, "cutoff": 0.125, "texture": {"index": 2, "texCoord": 1}}}))}),
        json!({"extensions": extension(json!({"bsdf": "dielectric", "ior": 1.4,
            "reflected": [0.5, 0.25, 1], "reflected_texture": {"index": 0, "extensions":
                extension(json!({"channel": "blue", "coding": "linear"}))},
            "transmitted": 0.75, "transmitted_texture": turned,
            "bump_texture": {"index": 2, "extensions": extension(json!({"channel": "red"}))},
            "bump_scale": -0.25}))}),
        json!({"pbrMetallicRoughness": pbr, "extensions": extension(json!({
            "bsdf": "thin_dielectric", "transmitted": [1, 0.5, 0.25]}))}),
        json!({"extensions": extension(json!({"bsdf": "conductor", "metal": "Au",
            "reflected": [0.5, 0.25, 1], "bump_texture": {"index": 1},
            "coverage": {"share": 0.5, "texture": {"index": 2}}}))}),
    ]
}

#[test]
fn textures_of_gltf_are_written_as_they_were() {
    let here = folder("of_gltf");
    put_pictures(&here);
    let transform = json!({"KHR_texture_transform":
        {"offset": [0.25, -1.5], "rotation": 0.7, "scale": [2.0, 0.3], "texCoord": 1}});
    let turned = json!({"index": 1, "extensions": transform});
    let layers = json!({
        "KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatTexture": {"index": 0},
            "clearcoatRoughnessFactor": 0.3, "clearcoatRoughnessTexture": turned},
        "KHR_materials_sheen": {"sheenColorFactor": [0.5, 0.25, 0.125],
            "sheenColorTexture": {"index": 1}, "sheenRoughnessFactor": 0.7,
            "sheenRoughnessTexture": {"index": 1}},
        "KHR_materials_specular": {"specularFactor": 0.5, "specularTexture": {"index": 1},
            "specularColorTexture": {"index": 0}},
        "KHR_materials_transmission":
            {"transmissionFactor": 0.75, "transmissionTexture": {"index": 2}},
        "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.25,
            "diffuseTransmissionTexture": {"index": 1},
            "diffuseTransmissionColorTexture": {"index": 0}},
    });
    let pbr = json!({"baseColorFactor": [0.5, 0.25, 1.0, 0.5], "baseColorTexture": turned,
        "metallicFactor": 0.9, "roughnessFactor": 0.3, "metallicRoughnessTexture": {"index": 0}});
    let extension = |body: Value| json!({"SUNSTONE_polarization": body});
    let materials = [
        json!({"pbrMetallicRoughness": pbr, "normalTexture": {"index": 0, "scale": 0.4}}),
        json!({"pbrMetallicRoughness": pbr, "extensions": layers, "alphaMode": "OPAQUE"}),
        json!({"pbrMetallicRoughness": pbr, "alphaMode": "BLEND"}),
        json!({"pbrMetallicRoughness": pbr, "alphaMode": "MASK", "alphaCutoff": 0.3}),
        json!({"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.25]}, "alphaMode": "BLEND"}),
        json!({"emissiveFactor": [0.5, 0.25, 1], "emissiveTexture": turned}),
        json!({"pbrMetallicRoughness": pbr, "alphaMode": "BLEND",
            "extensions": {"KHR_materials_unlit": {}}}),
        json!({"pbrMetallicRoughness": pbr, "extensions": extension(json!({"bsdf": "diffuse",
            "emission": [1, 2, 3]}))}),
        json!({"pbrMetallicRoughness": pbr, "extensions": extension(json!({"bsdf": "plastic",
            "alpha": 0.2}))}),
        json!({"pbrMetallicRoughness": pbr, "extensions": {"KHR_materials_transmission":
        {"transmissionFactor": 1.0}, "KHR_materials_volume": {"thicknessFactor": 1.0}},
        }),
    ];
    let all = materials.into_iter().chain(of_the_extension(&turned, &pbr));
    for (index, material) in all.enumerate() {
        for has_colors in [false, true] {
            let mut document = painted();
            document["materials"][0] = material.clone();
            if index == 9 {
                document["materials"][0]["pbrMetallicRoughness"]["metallicFactor"] = json!(0.0);
            }
            if has_colors {
                let attributes = &mut document["meshes"][0]["primitives"][0]["attributes"];
                attributes["COLOR_0"] = json!(5);
            }
            document["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}]);
            document["textures"] = json!([{"source": 0, "sampler": 0}, {"source": 1}, {"source": 2,
                "sampler": 0}]);
            document["images"] = json!([{"uri": "rgb.png"}, {"uri": "a%20b%2520c%23%3F.webp"},
                {"uri": "gray.png"}]);
            let path = here.join("scene.gltf");
            fs::write(&path, document.to_string()).unwrap();
            let world = loaded(&path);
            let count = world.entities().query::<&Textures>().iter().count();
            assert_eq!(count, 1, "material {index}");
            assert_same(&world, &format!("of_gltf_{index}_{has_colors}"));
        }
    }
}

#[test]
fn textures_of_mitsuba_are_written_with_all_that_gltf_has_no_words_for() {
    let here = folder("of_mitsuba");
    put_pictures(&here);
    let bitmap = |name: &str, inner: &str| {
        format!(
            "<texture type='bitmap' name='{name}'>{inner}<string name='filename' \
             value='rgb.png'/></texture>"
        )
    };
    let raw = "<boolean name='raw' value='true'/>";
    let sheared = format!(
        "{raw}<transform name='to_uv'><matrix value='1 0.5 0 0.25  0 2 0 0.1  0 0 1 0  0 0 0 1'/>\
         </transform><string name='wrap_mode' value='mirror'/><string name='filter_type' \
         value='nearest'/>"
    );
    let quarter = "<transform name='to_uv'><rotate z='1' angle='90'/></transform>";
    let checkers = "<texture type='checkerboard' name='reflectance'><rgb name='color0' \
                    value='0.1 0.2 0.3'/><transform name='to_uv'><scale value='8'/></transform>\
                    </texture>";
    let alpha = |inner: &str| {
        format!(
            "<texture type='bitmap' name='reflectance'>{inner}<string name='filename' \
             value='a b%20c#?.webp'/></texture>"
        )
    };
    let diffuse = format!("<bsdf type='diffuse'>{checkers}</bsdf>");
    let bodies = [
        diffuse.clone(),
        format!("<bsdf type='diffuse'>{}</bsdf>", bitmap("reflectance", &sheared)),
        format!("<bsdf type='diffuse'>{}</bsdf>", bitmap("reflectance", quarter)),
        format!("<bsdf type='pplastic'>{}</bsdf>", bitmap("diffuse_reflectance", "")),
        format!("<bsdf type='roughconductor'>{}</bsdf>", bitmap("alpha", "")),
        format!("<bsdf type='roughdielectric'>{}</bsdf>", bitmap("alpha", raw)),
        format!("<bsdf type='mask'>{}{diffuse}</bsdf>", bitmap("opacity", raw)),
        format!("<bsdf type='mask'><float name='opacity' value='0.3'/>{diffuse}</bsdf>"),
        // The alpha of the picture counts for nothing.
        format!(
            "<bsdf type='mask'><float name='opacity' value='0.3'/><bsdf type='diffuse'>{}</bsdf>\
             </bsdf>",
            alpha("")
        ),
        format!("<bsdf type='diffuse'>{}</bsdf>", alpha(raw)),
        format!("<bsdf type='normalmap'>{}{diffuse}</bsdf>", bitmap("normalmap", raw)),
        format!("<emitter type='area'>{}</emitter>", bitmap("radiance", &sheared)),
    ];
    for (index, body) in bodies.iter().enumerate() {
        for shape in ["rectangle", "sphere"] {
            let path = here.join("scene.xml");
            let body = format!("<shape type='{shape}'>{body}</shape>");
            fs::write(&path, scene(&body)).unwrap();
            let world = loaded(&path);
            assert_eq!(world.entities().query::<&Textures>().iter().count(), 1, "{body}");
            assert_same(&world, &format!("of_mitsuba_{index}_{shape}"));
        }
    }
}

#[test]
fn files_are_copied_if_they_lie_elsewhere_and_none_is_replaced() {
    let (from, to) = (folder("from"), folder("to"));
    fs::create_dir_all(from.join("deep")).unwrap();
    put_pictures(&from);
    fs::copy(from.join("gray.png"), from.join("deep/RGB.png")).unwrap();
    let texture = |file: &str| {
        format!(
            "<shape type='rectangle'><bsdf type='diffuse'><texture type='bitmap' \
             name='reflectance'><string name='filename' value='{file}'/></texture></bsdf></shape>"
        )
    };
    let body = [texture("rgb.png"), texture("deep/RGB.png"), texture("rgb.png")].concat();
    fs::write(from.join("scene.xml"), scene(&body)).unwrap();
    let world = loaded(&from.join("scene.xml"));
    let written = Written::of(&world).unwrap();
    // Where they lie, nothing is copied.
    assert_eq!(written.save(&from.join("a.gltf")).unwrap(), [] as [PathBuf; 0]);
    let document: Value = serde_json::from_slice(&fs::read(from.join("a.gltf")).unwrap()).unwrap();
    assert_eq!(document["images"], json!([{"uri": "rgb.png"}, {"uri": "deep/RGB.png"}]));
    // Elsewhere they are, once; another file of the name stays, as does one that is told apart by
    // capitals alone.
    fs::write(to.join("rgb.png"), b"mine").unwrap();
    let beside = written.save(&to.join("b.gltf")).unwrap();
    assert_eq!(beside, [to.join("rgb-1.png"), to.join("RGB-2.png")]);
    assert_eq!(fs::read(to.join("rgb.png")).unwrap(), b"mine");
    assert_eq!(all_textures(&world), all_textures(&loaded(&to.join("b.gltf"))));
    // The same once more needs no copies.
    assert_eq!(written.save(&to.join("b.gltf")).unwrap(), [] as [PathBuf; 0]);
    assert_eq!(fs::read_dir(&to).unwrap().count(), 4);
    // A file that is another by now is not taken for what was read.
    fs::write(from.join("rgb.png"), b"other").unwrap();
    let error = written.save(&folder("later").join("c.gltf")).unwrap_err().to_string();
    assert!(error.contains("rgb.png") && error.contains("has changed since"), "{error}");
    // What has no place is told by the system.
    assert!(written.save(&to.join("none/c.gltf")).is_err());
}

#[test]
fn skies_projectors_and_luminaires_come_along() {
    let here = folder("lights");
    put_pictures(&here);
    let ies = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 0.1 3 2 1 2 0 0 0\n0.3 1 0\n0 45.5 90\n0 90\n\
               1 0.7 0.1 1e-7 12345.678 3\n";
    fs::write(here.join("lamp.ies"), ies).unwrap();
    let mut document = crate::common::good();
    let mut lights = Vec::new();
    for (kind, key, file) in [("point", "ies", "lamp.ies"), ("spot", "picture", "rgb.png")] {
        lights.push(json!({"type": kind, "intensity": 5.0, "spot": {"outerConeAngle": 0.5},
            "extensions": {"SUNSTONE_polarization": {key: file}}}));
    }
    document["extensions"]["KHR_lights_punctual"]["lights"] = json!(lights);
    document["nodes"].as_array_mut().unwrap().push(json!({"translation": [1, 0, 0],
        "extensions": {"KHR_lights_punctual": {"light": 1}}}));
    document["scenes"][0]["nodes"] = json!([0, 1, 2, 3, 4]);
    let sky = json!({"uri": "rgb.png", "rotation": [0, 1, 0, 0], "radiance": [1, 2, 3]});
    document["scenes"][0]["extensions"]["SUNSTONE_polarization"] = json!({"environment": sky});
    let path = here.join("scene.gltf");
    fs::write(&path, document.to_string()).unwrap();
    let world = loaded(&path);
    let lamps = |world: &World| {
        let mut query = world.entities().query::<&sunstone::world::Luminaire>();
        query.iter().map(|it| Photometry::clone(&it.0)).collect::<Vec<_>>()
    };
    let told = |picture: &Picture| {
        let [width, height] = picture.texels().size();
        let texels = (0..width * height).map(|at| {
            picture.texels().at(
                at % width,
                at / width,
                sunstone::internals::image::texels::Coding::Srgb,
            )
        });
        texels.collect::<Vec<_>>()
    };
    let thrown = |world: &World| {
        let mut query = world.entities().query::<&Projection>();
        query.iter().map(|it| told(&it.0)).collect::<Vec<_>>()
    };
    let skies = |world: &World| {
        let mut query = world.entities().query::<&Environment>();
        let backdrop = query.iter().next().and_then(|sky| sky.backdrop.clone()).unwrap();
        (told(&backdrop.picture), backdrop.rotation)
    };
    assert_eq!(lamps(&world)[0].at(0.0, 0.0), 1.0 * (0.1 * 0.3));
    for other in again(&world, "lights_again") {
        assert_eq!(lamps(&world), lamps(&other));
        assert_eq!(thrown(&world), thrown(&other));
        assert_eq!(skies(&world), skies(&other));
    }
}

#[test]
fn pictures_without_a_file_get_one() {
    // A scene out of a .glb, and one of a program: a sky in memory that is polarized.
    let mut world = loaded(&{
        let path = folder("whole").join("scene.gltf");
        fs::write(&path, painted().to_string()).unwrap();
        path
    });
    assert_same(&world, "in_data");
    let first = again(&world, "first");
    assert_same(&first[1], "in_glb");
    let sky = sunstone::internals::image::StokesImage {
        width: 2,
        height: 1,
        color: sunstone::internals::spectrum::Color::Rgb,
        components: 4,
        planes: (0..12).map(|plane| vec![if plane < 3 { 2.0 } else { 0.25 }; 2]).collect(),
        variance: None,
        layers: Vec::new(),
        metadata: Vec::new(),
    };
    let path = folder("sky").join("sky.exr");
    sunstone::internals::image::save(&sky, &path).unwrap();
    world.set_environment_map(&fs::read(&path).unwrap(), [1.0; 3], glam::DQuat::IDENTITY).unwrap();
    for other in again(&world, "sky_again") {
        let mut query = other.entities().query::<&Environment>();
        let backdrop = query.iter().next().and_then(|sky| sky.backdrop.clone()).unwrap();
        assert_eq!(backdrop.picture.state_at(1, 0), Some(&[[0.125; 3]; 3]));
    }
}

#[test]
fn what_has_no_words_is_refused_by_name() {
    let mut document = painted();
    document["materials"][0]["pbrMetallicRoughness"]["metallicRoughnessTexture"] =
        json!({"index": 0});
    let path = folder("refused").join("scene.gltf");
    fs::write(&path, document.to_string()).unwrap();
    type Spoil = fn(&mut Textures);
    let paint_of = |textures: &mut Textures, parameter: Parameter| {
        textures.parameters.iter().position(|(own, _)| *own == parameter).unwrap()
    };
    let cases: [(Spoil, &str); 5] = [
        (|it| it.parameters[0].1.reads = Reads::Red, "color by one channel"),
        (|it| it.parameters[0].1.factor = [2.0; 3], "color of more than its picture"),
        (|it| drop(it.parameters.remove(1)), "not the blue and the green of one picture"),
        (|it| it.parameters[1].1.by_vertices = true, "colors of vertices for more than its color"),
        (
            |it| {
                let paint = Paint {
                    factor: [0.5; 3],
                    texture: it.parameters[0].1.texture.clone(),
                    reads: Reads::Color,
                    by_vertices: false,
                };
                it.coverage = Some(Coverage { paint, cutoff: None });
            },
            "a number out of a color",
        ),
    ];
    for (spoil, words) in cases {
        let mut world = loaded(&path);
        let material = world.find("painted").unwrap();
        let mut textures = Textures::clone(&world.entities().get::<&Textures>(material).unwrap());
        assert_eq!(paint_of(&mut textures, Parameter::BaseColor), 0);
        assert_eq!(paint_of(&mut textures, Parameter::Metallic), 1);
        spoil(&mut textures);
        world.set_textures(material, textures).unwrap();
        let error = Written::of(&world).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("\"painted\"") && error.contains(words), "{words}: {error}");
    }
    // Textures of one picture with other edges are several, of one image.
    let mut world = loaded(&path);
    let material = world.find("painted").unwrap();
    let mut textures = Textures::clone(&world.entities().get::<&Textures>(material).unwrap());
    let texture = textures.parameters[0].1.texture.as_mut().unwrap();
    (texture.wrap, texture.filter) = ([Wrap::Clamp, Wrap::Mirror], Filter::Nearest);
    world.set_textures(material, textures).unwrap();
    assert_same(&world, "edges");
}

/// Which sides scatter and emit, of glTF's own models too, whose backs are like their fronts where
/// a file says nothing.
#[test]
fn sides_are_written_as_they_are() {
    let plain = Layers::plain(Spectrum::Rgb([0.5, 0.25, 0.125]), 0.5, 0.25);
    let coated = Layers { coat: 0.5, ..plain.clone() };
    let open = Layers { diffuse_transmission: 0.5, ..coated.clone() };
    let Layers { base_color, metallic, alpha, ior, specular, .. } = plain;
    let own = Bsdf::MetallicRoughness { base_color, metallic, alpha, ior, specular };
    let open = Bsdf::Layered { layers: open };
    let models = [
        Bsdf::Layered { layers: coated },
        Bsdf::blend(Bsdf::diffuse(0.5), open.clone(), 0.5),
        open,
        own.clone(),
        own.filmed(ThinFilm::new(1.5, 0.0, 200.0)),
        Bsdf::diffuse(0.5),
        Bsdf::Absorber,
    ];
    let mut world = World::new("sides");
    let mut told = Vec::new();
    for (index, model) in models.into_iter().enumerate() {
        for (two_sided, emits) in [(false, false), (false, true), (true, false), (true, true)] {
            let name = format!("{index} {two_sided} {emits}");
            let material = Material::from(model.clone());
            let material = if two_sided { material.two_sided() } else { material };
            let material = if emits { material.emitting(2.0) } else { material };
            let material = world.add_material(&name, material).unwrap();
            let at = DAffine3::from_translation(told.len() as f64 * DVec3::X);
            world.add_sphere(&name, 0.25, material, at).unwrap();
            told.push((name, two_sided, emits));
        }
    }
    for read in again(&world, "sides") {
        assert_eq!(read.warnings(), [""; 0]);
        for (name, two_sided, emits) in &told {
            let material = read.find(name).expect("it is there");
            let entities = read.entities();
            let sides = *entities.get::<&Sides>(material).unwrap();
            assert_eq!(sides.two_sided, *two_sided, "{name}");
            assert_eq!(entities.get::<&Emission>(material).is_ok(), *emits, "{name}");
        }
    }
    let mut both = painted();
    both["materials"][0]["doubleSided"] = json!(true);
    both["materials"][0]["extensions"] = json!({"SUNSTONE_polarization": {"one_sided": true}});
    let error = crate::common::load_json(&both).map(drop).unwrap_err();
    assert!(error.contains("one_sided contradicts doubleSided"), "{error}");
}

#[test]
fn what_is_wrong_with_the_extensions_textures_is_told() {
    let own = |body: Value| json!({"SUNSTONE_polarization": body});
    let rough = |more: Value| {
        let mut body = json!({"bsdf": "rough_conductor", "metal": "Al", "alpha": 0.5});
        body.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        json!({"extensions": own(body)})
    };
    let texture = |body: Value| json!({"index": 0, "extensions": own(body)});
    let base = |body: Value| json!({"pbrMetallicRoughness": {"baseColorTexture": texture(body)}});
    let cases = [
        (rough(json!({"alpha_texture": {"index": 9}})), "alpha_texture has no `index` of a"),
        (rough(json!({"alpha_texture": {}})), "alpha_texture has no `index` of a"),
        (rough(json!({"alpha_texture": 3})), "alpha_texture is not an object"),
        (rough(json!({"alpha_texture": {"index": 0, "source": 0}})), "alpha_texture.source is not"),
        (
            rough(json!({"alpha_texture": texture(json!({"channel": "hue"}))})),
            "alpha_texture, SUNSTONE_polarization.channel is no channel",
        ),
        (rough(json!({"coverage": {"share": 1.5}})), "coverage.share: 1.5 must be within"),
        (rough(json!({"coverage": {"cutoff": -1}})), "coverage.cutoff: -1"),
        (rough(json!({"coverage": {"texture": {"index": 7}}})), "coverage.texture has no `index`"),
        (
            json!({"extensions": own(json!({"bsdf": "dielectric", "coverage": {"share": 0.5}}))}),
            "have no holes",
        ),
        (
            json!({"extensions": own(json!({"bsdf": "diffuse", "alpha_texture": {"index": 0}}))}),
            "alpha_texture means nothing for a diffuse",
        ),
        (base(json!({"channel": "red"})), "channel means nothing for a texture in this place"),
        (base(json!({"frame": "mesh"})), "frame means nothing for a texture in this place"),
        (base(json!({"coding": "hsv"})), "coding is no coding"),
        (base(json!({"transform": [[1, 0, 0]]})), "transform is not two rows of three numbers"),
        (base(json!({"transform": [[1, 0, 0], [0, 1, 1e300]]})), "transform is not two rows"),
        (base(json!({"gamma": 2})), "gamma is not a key of the extension"),
        (
            json!({"normalTexture": {"index": 0, "extensions": own(json!({"frame": "world"}))}}),
            "frame is no frame",
        ),
    ];
    for (mut material, words) in cases {
        let mut document = painted();
        material["name"] = json!("painted");
        document["materials"][0] = material;
        let error = crate::common::load_json(&document).map(|_| ()).unwrap_err();
        assert!(error.contains(words) && error.contains("\"painted\""), "{words}: {error}");
    }
}
