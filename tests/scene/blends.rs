//! Blends: what files say of them, in glTF and in Mitsuba's XML.

use serde_json::{Value, json};
use sunstone::internals::polarization::Distribution;
use sunstone::internals::scene::world::SurfaceModel;
use sunstone::internals::scene::{Written, bake, load};
use sunstone::internals::spectrum::Carried;
use sunstone::world::{Bsdf, Parameter, Reads, Textures};

use crate::common::{good, load_bytes, load_json, scratch};
use crate::errors::refused;
use crate::meaning::{baked, warnings};
use crate::mitsuba::{loaded, scene};
use crate::textures::painted;

const GREEN: Carried<1> = Carried::at([550.0]);

fn of<const N: usize>(
    first: SurfaceModel<[f32; N]>,
    second: SurfaceModel<[f32; N]>,
    weight: f32,
) -> SurfaceModel<[f32; N]> {
    SurfaceModel::Blend { parts: Box::new([first, second]), weight }
}

/// The good document, whose square is a blend with these keys, of gray and mirror.
fn blended(mut keys: Value) -> Value {
    keys["bsdf"] = json!("blend");
    let mut document = good();
    document["materials"][0] =
        json!({"name": "mix", "extensions": {"SUNSTONE_polarization": keys}});
    let materials = document["materials"].as_array_mut().unwrap();
    for (name, body) in [
        ("gray", json!({"bsdf": "diffuse", "reflectance": 0.25})),
        ("mirror", json!({"bsdf": "conductor", "eta": 0.5, "k": 2.0})),
        ("deep", json!({"bsdf": "blend", "first": "gray", "second": 2, "weight": 0.5})),
    ] {
        materials.push(json!({"name": name, "extensions": {"SUNSTONE_polarization": body}}));
    }
    document
}

fn facets<const N: usize>() -> SurfaceModel<[f32; N]> {
    SurfaceModel::RoughConductor {
        eta: [0.5; N],
        k: [2.0; N],
        alpha: 0.001,
        distribution: Distribution::Ggx,
        multiple_scattering: true,
    }
}

#[test]
fn parts_are_other_materials_by_index_or_name() {
    let gray = || SurfaceModel::Diffuse { reflectance: [0.25; 3] };
    let document = blended(json!({"first": "gray", "second": 3, "weight": 0.75}));
    let scene = baked(&document);
    assert_eq!(scene.optics.materials[0].model, of(gray(), facets(), 0.75));
    let said = warnings(&document);
    assert!(said.contains("\"mirror\" is smooth metal, which is of facets of alpha"), "{said}");
    let deep = baked(&blended(json!({"first": "deep", "second": 2, "weight": 0.25})));
    let inner = of(gray(), gray(), 0.5);
    assert_eq!(deep.optics.materials[0].model, of(inner, gray(), 0.25));
}

#[test]
fn what_cannot_be_mixed_is_refused_by_name() {
    fn mix(document: &mut Value, keys: Value) {
        *document = blended(keys);
    }
    refused(&[
        (|d| mix(d, json!({"second": 2, "weight": 0.5})), &["first", "is missing", "its name"]),
        (|d| mix(d, json!({"first": 2, "second": 2})), &["weight", "is missing"]),
        (
            |d| mix(d, json!({"first": 2, "second": 2, "weight": 1.5})),
            &["material 0 \"mix\"", "weight", "1.5 must be within [0, 1]"],
        ),
        (
            |d| mix(d, json!({"first": 2, "second": 9, "weight": 0.5})),
            &["second", "9 is not an index into the file's 5 materials"],
        ),
        (
            |d| mix(d, json!({"first": "grey", "second": 2, "weight": 0.5})),
            &["first", "no material of the file is called `grey`"],
        ),
        (
            |d| mix(d, json!({"first": 1, "second": 2, "weight": 0.5})),
            &["first (material 1 \"glass\")", "glass cannot be a part of a blend"],
        ),
        (
            |d| mix(d, json!({"first": 2, "second": "mix", "weight": 0.5})),
            &["material 0 \"mix\"", "is a part of itself"],
        ),
        (
            |d| mix(d, json!({"first": 2, "second": 2, "weight": 0.5, "alpha": 0.1})),
            &["alpha", "means nothing for a blend", "weight_texture"],
        ),
        (
            |d| mix(d, json!({"first": 2, "second": 2, "weight_texture": {"index": 0}})),
            &["weight_texture", "has no `index` of a texture of the file"],
        ),
        (
            |d| {
                mix(d, json!({"first": 2, "second": 2, "weight": 0.5}));
                let gray = &mut d["materials"][2];
                gray["alphaMode"] = json!("BLEND");
                gray["pbrMetallicRoughness"] = json!({"baseColorFactor": [1, 1, 1, 0.5]});
            },
            &["first (material 2 \"gray\")", "holes", "give them to the blend"],
        ),
    ]);
    // Deeper than four, and each twice: none is read more than it has to be.
    let mut document = blended(json!({"first": 5, "second": 5, "weight": 0.5}));
    let materials = document["materials"].as_array_mut().unwrap();
    for next in 6..60 {
        let body = json!({"bsdf": "blend", "first": next, "second": next, "weight": 0.5});
        materials.push(json!({"extensions": {"SUNSTONE_polarization": body}}));
    }
    let error = load_json(&document).map(|_| ()).unwrap_err();
    assert!(error.contains("more than 4 blends within each other"), "{error}");
    let two = |part: Bsdf| Bsdf::blend(part.clone(), part, 0.5);
    let four = two(two(two(two(Bsdf::diffuse(0.5)))));
    let mut world = sunstone::world::World::new("deep");
    world.add_material("four", four.clone()).unwrap();
    let error = world.add_material("five", two(four)).unwrap_err().to_string();
    assert!(error.contains("material `five`, first") && error.contains("more than 4"), "{error}");
}

/// The texture of the weight multiplies it; those of parts are fed to these.
#[test]
fn textures_feed_weights_and_parts() {
    let mut document = painted();
    let painted = document["materials"][0].take();
    document["materials"][0] = json!({"name": "mix", "extensions": {"SUNSTONE_polarization":
        {"bsdf": "blend", "first": 2, "second": 3, "weight": 0.5,
            "weight_texture": {"index": 0, "texCoord": 1}}}});
    let materials = document["materials"].as_array_mut().unwrap();
    materials.push(painted);
    materials.push(json!({"extensions": {"SUNSTONE_polarization": {"bsdf": "absorber"}}}));
    let world = load_json(&document).unwrap();
    let mix = world.find("mix").unwrap();
    let textures = (*world.entities().get::<&Textures>(mix).unwrap()).clone();
    let [(Parameter::Weight, weight)] = &textures.parameters[..] else { panic!("{textures:?}") };
    assert_eq!((weight.factor, weight.reads), ([0.5; 3], Reads::Luminance));
    assert_eq!(weight.texture.as_ref().map(|texture| texture.set), Some(1));
    let [(Parameter::BaseColor, color)] = &textures.parts[0].parameters[..] else {
        panic!("{textures:?}")
    };
    // Vertices have colors, which are not of the part.
    assert_eq!((color.factor, color.by_vertices), ([0.5, 1.0, 1.0], false));
    assert!(textures.parts[1].is_empty());
}

fn of_mitsuba(bsdf: &str) -> SurfaceModel<[f32; 1]> {
    let world = loaded(&format!("<shape type='sphere'>{bsdf}</shape>"));
    bake(&world, &GREEN).unwrap_or_else(|error| panic!("{error}")).optics.materials[0].model.clone()
}

const DARK: &str = "<bsdf type='diffuse'><float name='reflectance' value='0'/></bsdf>";
const GRAY: &str = "<bsdf type='diffuse'><float name='reflectance' value='0.25'/></bsdf>";

#[test]
fn mitsubas_blends() {
    let gray = |reflectance| SurfaceModel::Diffuse { reflectance: [reflectance] };
    let model = of_mitsuba(&format!(
        "<bsdf type='twosided'><bsdf type='blendbsdf'><float name='weight' value='0.75'/>\
         {GRAY}{DARK}</bsdf></bsdf>"
    ));
    assert_eq!(model, of(gray(0.25), gray(0.0), 0.75));
    // As Mitsuba has it, which takes what is beyond for its ends.
    let model = of_mitsuba(&format!(
        "<bsdf type='blendbsdf'>{GRAY}<float name='weight' value='1.5'/>{DARK}</bsdf>"
    ));
    assert_eq!(model, of(gray(0.25), gray(0.0), 1.0));
    let world = loaded(&format!(
        "<shape type='rectangle'><bsdf type='blendbsdf'>{GRAY}\
         <texture type='checkerboard' name='weight'/><bsdf type='roughconductor'>\
         <texture type='checkerboard' name='alpha'/></bsdf></bsdf></shape>"
    ));
    let mut query = world.entities().query::<&Textures>();
    let textures = query.iter().next().expect("it is painted");
    let reads = |textures: &Textures| {
        let [(parameter, paint)] = &textures.parameters[..] else { panic!("{textures:?}") };
        (*parameter, paint.reads)
    };
    assert_eq!(reads(textures), (Parameter::Weight, Reads::Luminance));
    assert_eq!(reads(&textures.parts[1]), (Parameter::Alpha, Reads::Luminance));
    let world = loaded(&format!(
        "<shape type='sphere'><bsdf type='blendbsdf'><float name='weight' value='0.5'/>\
         {GRAY}<bsdf type='conductor'/></bsdf></shape>"
    ));
    let said = world.warnings().join("\n");
    assert!(said.contains("blends smooth metal"), "{said}");
}

#[test]
fn mitsubas_blends_that_are_none() {
    let weight = "<float name='weight' value='0.5'/>";
    for (body, texts) in [
        (format!("{GRAY}{DARK}"), ["weight", "is missing"]),
        (format!("{weight}{GRAY}"), ["(blendbsdf)", "must have two bsdfs"]),
        (format!("{weight}{GRAY}{DARK}{DARK}"), ["(blendbsdf)", "must have two bsdfs"]),
        (
            format!("{weight}{GRAY}<bsdf type='dielectric'/>"),
            ["(dielectric)", "glass cannot be a part"],
        ),
        (
            format!("{weight}{GRAY}<bsdf type='mask'>{DARK}</bsdf>"),
            ["(mask)", "put the whole blendbsdf"],
        ),
        (
            format!("{weight}{GRAY}<bsdf type='twosided'>{DARK}</bsdf>"),
            ["(blendbsdf)", "twosided and the other is not"],
        ),
        (format!("{weight}<float name='mix' value='1'/>{GRAY}{DARK}"), ["mix", "no property"]),
    ] {
        let body = format!("<shape type='sphere'><bsdf type='blendbsdf'>{body}</bsdf></shape>");
        let error = load_bytes("scene.xml", scene(&body).as_bytes()).err();
        let error = error.unwrap_or_else(|| panic!("{body} is read")).to_string();
        assert!(texts.iter().all(|text| error.contains(text)), "{error}");
    }
    // Each twice, and deep.
    let mut body = String::from("<bsdf type='diffuse' id='b0'/>");
    for next in 1..40 {
        let last = next - 1;
        body += &format!(
            "<bsdf type='blendbsdf' id='b{next}'>{weight}<ref id='b{last}'/><ref id='b{last}'/>\
             </bsdf>"
        );
    }
    body += "<shape type='sphere'><ref id='b39'/></shape>";
    let error = load_bytes("scene.xml", scene(&body).as_bytes()).map(|_| ()).unwrap_err();
    assert!(error.contains("more than 4 blends within each other"), "{error}");
}

#[test]
fn what_is_written_is_read_again() {
    let world = loaded(&format!(
        "<shape type='sphere'><bsdf type='blendbsdf'><float name='weight' value='0.25'/>{GRAY}\
         <bsdf type='blendbsdf'><float name='weight' value='0.5'/>{DARK}\
         <bsdf type='roughconductor'><float name='alpha' value='0.2'/></bsdf></bsdf></bsdf></shape>"
    ));
    let written = Written::of(&world).unwrap_or_else(|error| panic!("{error}"));
    let path = scratch("blend.gltf");
    written.save(&path).unwrap();
    let again = load(&path).unwrap_or_else(|error| panic!("{error}"));
    std::fs::remove_file(&path).unwrap();
    let models = [&world, &again]
        .map(|world| bake(world, &GREEN).unwrap().optics.materials[0].model.clone());
    assert_eq!(models[0], models[1]);
}
