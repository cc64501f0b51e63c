//! What glTF's textures mean, wherever their pictures are, and what is refused of them.

use std::fs;
use std::io::Cursor;

use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use image::{ImageBuffer, ImageFormat, Rgba};
use serde_json::{Value, json};
use sunstone::internals::image::texels::Coding;
use sunstone::internals::scene::{World, bake, load};
use sunstone::internals::spectrum::Carried;
use sunstone::world::{
    Bsdf, Filter, Geometry, Lens, Parameter, Picture, Reads, Relief, ReliefFrame, ReliefOf,
    Texture, Textures, Transform, Wrap,
};

use crate::common::{data_uri, good, load_json, scratch, square_bytes};

/// A picture of 2 x 2 texels, the last half transparent.
fn encoded(format: ImageFormat) -> Vec<u8> {
    let texels = [[255_u8, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 102]];
    let image = ImageBuffer::from_fn(2, 2, |x, y| Rgba(texels[(2 * y + x) as usize]));
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// The good document, whose square has two sets of coordinates and colors, painted by a picture.
pub fn painted() -> Value {
    let mut document = good();
    let mut bytes = square_bytes();
    let first = [[0.0_f32, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    bytes.extend(first.as_flattened().iter().flat_map(|float| float.to_le_bytes()));
    let second = [[0_u16, 65535], [65535, 65535], [65535, 0], [0, 0]];
    bytes.extend(second.as_flattened().iter().flat_map(|word| word.to_le_bytes()));
    bytes.extend([[255_u8, 128, 0, 255], [0, 0, 0, 0], [1, 2, 3, 4], [255; 4]].as_flattened());
    let attributes = &mut document["meshes"][0]["primitives"][0]["attributes"];
    attributes["TEXCOORD_0"] = json!(3);
    attributes["TEXCOORD_1"] = json!(4);
    let rows = [(108, 32, 5126, "VEC2"), (140, 16, 5123, "VEC2"), (156, 16, 5121, "VEC4")];
    for (offset, length, component, kind) in rows {
        let views = document["bufferViews"].as_array_mut().unwrap();
        views.push(json!({"buffer": 0, "byteOffset": offset, "byteLength": length}));
        let view = views.len() - 1;
        document["accessors"].as_array_mut().unwrap().push(json!({"bufferView": view,
            "componentType": component, "count": 4, "type": kind,
            "normalized": component != 5126}));
    }
    document["buffers"] = json!([{"byteLength": bytes.len(), "uri": data_uri(&bytes)}]);
    document["materials"][0] = json!({"name": "painted",
        "pbrMetallicRoughness": {"metallicFactor": 0.0, "baseColorFactor": [0.5, 1, 1, 1],
            "baseColorTexture": {"index": 0}}});
    document["textures"] = json!([{"source": 0}]);
    document["images"] = json!([{"name": "tiles", "uri": data_uri(&encoded(ImageFormat::Png))}]);
    document
}

/// The textures of the painted material.
fn textures(world: &World) -> Option<Textures> {
    let material = world.find("painted").expect("it is there");
    world.entities().get::<&Textures>(material).ok().map(|textures| (*textures).clone())
}

fn color(world: &World) -> Texture {
    let textures = textures(world).expect("it is painted");
    textures.parameters[0].1.texture.clone().expect("by a picture")
}

#[test]
fn pictures_are_found_wherever_they_are() {
    let embedded = load_json(&painted()).unwrap();
    let expected = color(&embedded);
    assert_eq!((expected.coding, expected.set), (Coding::Srgb, 0));
    assert_eq!((expected.wrap, expected.filter), ([Wrap::Repeat; 2], Filter::Linear));
    assert_eq!(expected.at(Vec2::new(0.25, 0.25)), [1.0, 0.0, 0.0, 1.0]);
    assert_eq!(expected.at(Vec2::new(0.75, 0.75)), [1.0, 1.0, 1.0, 0.4]);
    assert_eq!(textures(&embedded).unwrap().parameters[0].1.factor, [0.5, 1.0, 1.0]);
    assert!(embedded.warnings().is_empty(), "{:?}", embedded.warnings());

    let mut viewed = painted();
    let png = encoded(ImageFormat::Png);
    viewed["buffers"]
        .as_array_mut()
        .unwrap()
        .push(json!({"byteLength": png.len() + 3, "uri": data_uri(&[&[7; 3], &png[..]].concat())}));
    viewed["bufferViews"]
        .as_array_mut()
        .unwrap()
        .push(json!({"buffer": 1, "byteOffset": 3, "byteLength": png.len()}));
    viewed["images"] = json!([{"bufferView": 6, "mimeType": "image/png"}]);
    assert_eq!(color(&load_json(&viewed).unwrap()).picture.texels(), expected.picture.texels());

    let folder = scratch("beside");
    fs::create_dir_all(folder.join("maps")).unwrap();
    fs::write(folder.join("maps/a b.webp"), encoded(ImageFormat::WebP)).unwrap();
    let mut beside = painted();
    beside["extensionsRequired"] = json!(["EXT_texture_webp", "KHR_texture_transform"]);
    beside["images"] = json!([{"uri": "maps/a%20b.webp"}]);
    beside["textures"] = json!([{"extensions": {"EXT_texture_webp": {"source": 0}}}]);
    fs::write(folder.join("scene.gltf"), beside.to_string()).unwrap();
    let world = load(&folder.join("scene.gltf")).unwrap();
    assert_eq!(color(&world).picture.texels(), expected.picture.texels());
    assert!(world.files().iter().any(|file| file.ends_with("a b.webp")), "{:?}", world.files());
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn samplers_transforms_and_sets_are_read() {
    let mut document = painted();
    document["samplers"] = json!([{"magFilter": 9728, "wrapS": 33648, "wrapT": 33071}]);
    document["textures"][0]["sampler"] = json!(0);
    let info = &mut document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    *info = json!({"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform": {
        "offset": [0.25, -1.0], "rotation": 0.5, "scale": [2.0, 3.0], "texCoord": 1}}});
    let way = color(&load_json(&document).unwrap());
    assert_eq!((way.filter, way.set), (Filter::Nearest, 1));
    assert_eq!(way.wrap, [Wrap::Mirror, Wrap::Clamp]);
    // The picture turns clockwise, so that the coordinates turn the other way, v downwards.
    let (sine, cosine) = 0.5_f32.sin_cos();
    let at = way.place(Vec2::new(0.3, 0.7));
    let expected = Vec2::new(0.25 + cosine * 0.6 + sine * 2.1, -1.0 - sine * 0.6 + cosine * 2.1);
    assert!(at.distance(expected) < 1e-6, "{at}, not {expected}");
}

#[test]
fn colors_of_vertices_multiply_base_color() {
    let mut document = painted();
    document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(5);
    let world = load_json(&document).unwrap();
    assert!(textures(&world).unwrap().parameters[0].1.by_vertices);
    let shapes = bake(&world, &Carried::RGB).unwrap().shapes;
    let [first, second, third] = shapes.painted(0).unwrap().colors();
    assert_eq!(first, Vec4::new(1.0, 128.0 / 255.0, 0.0, 1.0));
    assert_eq!([second, third], [Vec4::ZERO, Vec4::new(1.0, 2.0, 3.0, 4.0) / 255.0]);
    let at = shapes.painted(0).unwrap().coordinates(0, [0.25, 0.5]);
    assert!(at.distance(Vec2::new(0.75, 0.5)) < 1e-6, "{at}");
}

#[test]
fn alpha_makes_holes_where_it_counts() {
    let coverage = |edit: fn(&mut Value)| {
        let mut document = painted();
        edit(&mut document["materials"][0]);
        textures(&load_json(&document).unwrap()).unwrap().coverage
    };
    assert_eq!(coverage(|_| {}), None);
    assert_eq!(coverage(|it| it["alphaMode"] = json!("OPAQUE")), None);
    let blend = coverage(|it| it["alphaMode"] = json!("BLEND")).unwrap();
    assert_eq!((blend.cutoff, blend.paint.reads), (None, Reads::Alpha));
    assert_eq!([blend.of(0.3), blend.of(1.7)], [0.3, 1.0]);
    let mask = coverage(|it| it["alphaMode"] = json!("MASK")).unwrap();
    assert_eq!([mask.of(0.49), mask.of(0.5)], [0.0, 1.0]);
    let even = coverage(|it| {
        *it = json!({"name": "painted", "alphaMode": "MASK", "alphaCutoff": 0.2,
            "pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [1, 1, 1, 0.3]},
            "normalTexture": {"index": 0}});
    });
    assert_eq!(even, None);
}

/// What light goes straight through goes by the true surface. Panes do not: they mirror.
#[test]
fn sheets_have_no_normals_to_bend() {
    let of = |body: Value, key: &str| {
        let mut document = painted();
        document["textures"] = json!([{"source": 0}]);
        document["extras"] = json!({"sunstone": {"media":
            [{"phase": "isotropic", "sigma_a": 1, "sigma_s": 1}]}});
        if body["bsdf"] == "null" {
            let inside = json!({"interior": 0});
            document["nodes"][1]["extensions"] = json!({"SUNSTONE_polarization": inside});
        }
        let mut material = json!({"name": "painted"});
        material["extensions"]["SUNSTONE_polarization"] = body;
        match key {
            "normalTexture" => material[key] = json!({"index": 0}),
            own => material["extensions"]["SUNSTONE_polarization"][own] = json!({"index": 0}),
        }
        document["materials"][0] = material;
        load_json(&document)
    };
    let sheets = [
        json!({"bsdf": "polarizer"}),
        json!({"bsdf": "retarder", "retardance_deg": 90}),
        json!({"bsdf": "circular_polarizer"}),
        json!({"bsdf": "mueller", "matrix":
            [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}),
        json!({"bsdf": "null"}),
    ];
    for body in sheets {
        let world = of(body.clone(), "normalTexture").unwrap_or_else(|error| panic!("{error}"));
        let told = world.warnings().join("\n");
        assert!(told.contains("normalTexture is ignored: sheets and null"), "{body}: {told}");
        assert_eq!(textures(&world), None);
        let error = of(body.clone(), "bump_texture").map(drop).unwrap_err();
        let model = body["bsdf"].as_str().unwrap();
        assert!(
            error.contains(&format!("bump_texture means nothing for a {model}, which")),
            "{error}"
        );
    }
    let bumps = of(json!({"bsdf": "diffuse"}), "bump_texture").unwrap();
    let relief = textures(&bumps).and_then(|textures| textures.relief).expect("it is bent");
    for body in [json!({"bsdf": "thin_dielectric"}), json!({"bsdf": "dielectric"})] {
        let world = of(body, "bump_texture").unwrap();
        assert_eq!(textures(&world).unwrap().relief.map(|it| it.of), Some(relief.of));
    }
    // A program is told the same.
    let mut world = World::new("made");
    let sheet = world.add_material("sheet", Bsdf::polarizer(0.0)).unwrap();
    let textures = Textures { relief: Some(relief), ..Textures::default() };
    let error = world.set_textures(sheet, textures).unwrap_err().to_string();
    assert!(error.contains("`sheet`, normals are by a texture"), "{error}");
}

type Refused = (fn(&mut Value), &'static [&'static str]);

#[test]
fn what_is_wrong_with_pictures_is_said_with_a_remedy() {
    let cases: [Refused; 9] = [
        (|d| d["images"][0]["uri"] = json!("gone.png"), &["image 0 \"tiles\"", "gone.png", "put"]),
        (
            |d| d["images"][0]["uri"] = json!(data_uri(&encoded(ImageFormat::Png)[..60])),
            &["image 0 \"tiles\"", "PNG", "save it again"],
        ),
        (
            |d| d["images"][0]["uri"] = json!(data_uri(b"\xabKTX 20\xbb\r\n\x1a\n")),
            &["image 0 \"tiles\"", "KTX2", "PNG, JPEG"],
        ),
        (
            |d| d["images"][0]["uri"] = json!(data_uri(b"hello")),
            &["image 0 \"tiles\"", "not known", "PNG, JPEG"],
        ),
        (
            |d| d["textures"] = json!([{"extensions": {"KHR_texture_basisu": {"source": 0}}}]),
            &["baseColorTexture", "Basis Universal", "convert"],
        ),
        (|d| d["textures"][0]["source"] = json!(7), &["baseColorTexture", "no picture"]),
        (
            |d| {
                d["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] =
                    json!(2);
            },
            &["material 0 \"painted\", baseColorTexture", "TEXCOORD_2", "use one of these"],
        ),
        (
            |d| {
                let attributes = d["meshes"][0]["primitives"][0]["attributes"].as_object_mut();
                attributes.unwrap().remove("TEXCOORD_0");
            },
            &[
                "mesh 0 \"square\", primitive 0, TEXCOORD_0 is missing",
                "material 0 \"painted\"",
                "unwrap the mesh",
            ],
        ),
        (|d| d["images"] = json!([{}]), &["image 0", "neither `uri` nor `bufferView`"]),
    ];
    for (edit, expected) in cases {
        let mut document = painted();
        edit(&mut document);
        let error = load_json(&document).map(|_| ()).unwrap_err();
        for part in expected {
            assert!(error.contains(part), "no `{part}` in: {error}");
        }
    }
}

#[test]
fn metal_and_roughness_are_blue_and_green() {
    let mut document = painted();
    let pbr = &mut document["materials"][0]["pbrMetallicRoughness"];
    (pbr["metallicFactor"], pbr["roughnessFactor"]) = (json!(0.5), json!(0.25));
    pbr["metallicRoughnessTexture"] = json!({"index": 0, "texCoord": 1});
    document["materials"][0]["extensions"] =
        json!({"KHR_materials_sparkle": {"sparkleTexture": {"index": 0}}});
    let world = load_json(&document).unwrap();
    let said = world.warnings().join("\n");
    assert_eq!(said.matches("sparkleTexture").count(), 1, "{said}");
    let parameters = textures(&world).unwrap().parameters;
    let of = |parameter| {
        let (_, paint) = parameters.iter().find(|(it, _)| *it == parameter).expect("it is painted");
        let texture = paint.texture.as_ref().expect("by a picture");
        assert_eq!(texture.coding == Coding::Linear, parameter != Parameter::BaseColor);
        paint.color(texture.at(Vec2::new(0.25, 0.75)))
    };
    // The third texel is blue.
    assert_eq!(of(Parameter::Metallic), [0.5; 3]);
    assert_eq!(of(Parameter::Roughness), [0.0; 3]);
    assert_eq!(of(Parameter::BaseColor), [0.0, 0.0, 1.0]);
}

/// What glows by a picture, no more than white, is a mark on a model, and so is what glows more
/// where nobody says how that is to be seen: it is under a sky then, and lamps are lamps.
#[test]
fn what_glows_by_a_picture_is_no_lamp_of_a_model() {
    let put_in = |edit: fn(&mut Value)| {
        let mut document = painted();
        document["scenes"][0]["nodes"] = json!([1]);
        document["materials"][0]["emissiveFactor"] = json!([1, 1, 1]);
        edit(&mut document);
        load_json(&document).unwrap().put_in().iter().map(|it| it.what).collect::<Vec<_>>()
    };
    assert_eq!(put_in(|_| {}), ["camera"]);
    let by_picture =
        |document: &mut Value| document["materials"][0]["emissiveTexture"] = json!({"index": 0});
    assert_eq!(put_in(by_picture), ["camera", "light"]);
    let bright = |document: &mut Value| {
        document["materials"][0]["emissiveTexture"] = json!({"index": 0});
        document["materials"][0]["extensions"] =
            json!({"KHR_materials_emissive_strength": {"emissiveStrength": 5.0}});
    };
    assert_eq!(put_in(bright), ["camera", "light"]);
    // Seen by a camera of the file.
    assert_eq!(
        put_in(|document| {
            document["scenes"][0]["nodes"] = json!([0, 1]);
            document["materials"][0]["emissiveTexture"] = json!({"index": 0});
        }),
        ["light"]
    );
    let screen = |edit: fn(&mut Value)| {
        let mut document = painted();
        document["scenes"][0]["nodes"] = json!([0, 1]);
        document["materials"][0]["emissiveFactor"] = json!([1, 1, 1]);
        document["materials"][0]["emissiveTexture"] = json!({"index": 0});
        edit(&mut document);
        load_json(&document).unwrap().put_in().len()
    };
    assert_eq!(screen(bright), 0);
    assert_eq!(screen(|d| d["materials"][0]["extras"] = json!({"sunstone_emission": 1.0})), 0);
}

/// Tangents that a mesh states, and those that follow from its coordinates, wherever it stands:
/// turned, stretched, mirrored.
#[test]
fn frames_by_tangents_are_those_by_coordinates() {
    let turned = DAffine3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.1);
    let stretched = DAffine3::from_scale(DVec3::new(2.0, 0.5, 3.0));
    let mirrored = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    for place in [DAffine3::IDENTITY, turned, turned * stretched, mirrored, turned * mirrored] {
        for flipped in [1.0, -1.0] {
            let corners = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]].map(Vec2::from_array);
            let plain = Geometry {
                texture_coordinates: corners.map(|it| Vec2::new(flipped * it.x, it.y)).to_vec(),
                ..Geometry::quad(Vec3::ZERO, Vec3::X, Vec3::Y)
            };
            let tangents = vec![Vec4::new(flipped, 0.0, 0.0, flipped); 4];
            let stated = Geometry { tangents, ..plain.clone() };
            let [derived, stated] = [plain, stated].map(|geometry| frame(geometry, place));
            let to_world = |axis: Vec3| place.transform_vector3(axis.as_dvec3()).normalize();
            let expected = [to_world(Vec3::X * flipped), to_world(Vec3::Y)];
            for ((derived, stated), expected) in derived.into_iter().zip(stated).zip(expected) {
                let expected = expected.as_vec3();
                assert!(derived.distance(expected) < 1e-6, "{derived}, not {expected}: {place:?}");
                assert!(stated.distance(expected) < 1e-6, "{stated}, not {expected}: {place:?}");
            }
        }
    }
}

/// Right and up of a picture on the first triangle of a mesh in a place.
fn frame(geometry: Geometry, place: DAffine3) -> [Vec3; 2] {
    let mut world = World::new("frames");
    let material = world.add_material("relief", Bsdf::diffuse(0.5)).unwrap();
    let png = encoded(ImageFormat::Png);
    let texels = sunstone::internals::image::texels::Texels::decode(&png).unwrap();
    let texture = Texture {
        picture: Picture::new(texels, 1).into(),
        coding: Coding::Linear,
        wrap: [Wrap::Repeat; 2],
        filter: Filter::Linear,
        set: 0,
        transform: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    };
    let relief = Some(Relief { texture, scale: 1.0, of: ReliefOf::Normals(ReliefFrame::Picture) });
    world.set_textures(material, Textures { relief, ..Textures::default() }).unwrap();
    world.add_mesh("mesh", geometry, material, Transform(place)).unwrap();
    world.set_environment(1.0).unwrap();
    let eye = Transform::looking(DVec3::Z * 4.0, DVec3::ZERO, DVec3::Y);
    world.set_camera("eye", Lens::pinhole(1.0), eye).unwrap();
    let shapes = bake(&world, &Carried::RGB).unwrap().shapes;
    let triangle = shapes.triangles[0].corners;
    let middle = (triangle[0] + triangle[1] + triangle[2]) / 3.0;
    let painted = shapes.painted(0).unwrap();
    let weights = painted.weights_at(middle);
    assert!((weights[0] - 1.0 / 3.0).abs() < 1e-5 && (weights[1] - 1.0 / 3.0).abs() < 1e-5);
    let normal = shapes.geometric_normal(0, middle);
    painted.frame((0, |at| at), weights, normal).expect("coordinates change")
}

/// The color of glTF's glass is that of light that goes through: of panes, and of solids, smooth
/// and rough; alpha makes holes in panes and walls, and not in what refracts.
#[test]
fn glass_has_the_color_and_the_alpha_of_its_pictures() {
    let glass = |roughness: f32, transmission: f32, more: Value| {
        let mut document = painted();
        document["materials"][0] = json!({"name": "painted", "alphaMode": "BLEND",
            "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": roughness,
                "baseColorFactor": [0.5, 1, 1, 0.5], "baseColorTexture": {"index": 0}},
            "extensions": {"KHR_materials_transmission": {"transmissionFactor": transmission}}});
        for (extension, body) in more.as_object().into_iter().flatten() {
            document["materials"][0]["extensions"][extension] = body.clone();
        }
        load_json(&document).unwrap()
    };
    let solid = || json!({"KHR_materials_volume": {"thicknessFactor": 1}});
    for (roughness, more, has_holes) in
        [(0.0, json!({}), true), (0.0, solid(), false), (0.5, solid(), false)]
    {
        let world = glass(roughness, 1.0, more);
        let Textures { stain, coverage, parameters, .. } =
            textures(&world).expect("it has a color");
        let transmitted = stain.transmitted.expect("it has a color");
        assert_eq!((transmitted.factor, transmitted.reads), ([0.5, 1.0, 1.0], Reads::Color));
        assert!(
            transmitted.texture.is_some() && stain.reflected.is_none() && parameters.is_empty()
        );
        assert_eq!(coverage.is_some(), has_holes, "{roughness}");
        let told = world.warnings().iter().any(|text| text.contains("alpha is ignored"));
        assert_eq!(told, !has_holes, "{:?}", world.warnings());
        bake::<1>(&world, &Carried::at([550.0])).expect("it renders");
    }
    // Walls by a share have holes, too, and a color of their own.
    let world = glass(0.5, 0.5, json!({}));
    let Textures { stain, coverage, parameters, .. } = textures(&world).expect("it has a color");
    assert!(coverage.is_some() && !stain.is_some() && parameters[0].0 == Parameter::BaseColor);
    // Clear as air, it is not there to have a color.
    let world = glass(0.0, 1.0, json!({"KHR_materials_ior": {"ior": 1}}));
    assert!(world.warnings().iter().any(|text| text.contains("of the index around it is ignored")));
}

#[test]
fn image_based_lights_are_told() {
    let mut document = painted();
    document["extensions"]["EXT_lights_image_based"] = json!({"lights": []});
    let world = load_json(&document).unwrap();
    let told: Vec<_> = world.warnings().iter().filter(|text| text.contains("EXT_")).collect();
    assert!(told.len() == 1 && told[0].contains("give the scene an environment"), "{told:?}");
}
