//! Colors of gloss (KHR_materials_pbrSpecularGlossiness): what becomes of factors and of pictures.

use std::io::Cursor;

use image::{ImageBuffer, ImageFormat, Rgba};
use serde_json::{Value, json};
use sunstone::internals::scene::world::SurfaceModel;
use sunstone::world::{Parameter, Textures};

use crate::common::{data_uri, good, load_json};
use crate::errors::refused;
use crate::meaning::{baked, warnings};
use crate::textures::painted;

fn glossy(body: Value) -> Value {
    let mut document = good();
    document["materials"][0] = json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": body}});
    document
}

/// The base color, the share of metal and the root of the roughness of the facets.
fn model(document: &Value) -> ([f32; 3], f32, f32) {
    match baked(document).optics.materials[0].model {
        SurfaceModel::MetallicRoughness { base_color, metallic, alpha, .. } => {
            (base_color, metallic, alpha.sqrt())
        }
        ref other => panic!("{other:?}"),
    }
}

#[test]
fn plastic_and_metal_are_told_apart() {
    let plastic = glossy(json!({"diffuseFactor": [0.5, 0.25, 0.125, 1.0],
        "specularFactor": [0.04, 0.04, 0.04], "glossinessFactor": 0.75}));
    let (color, metallic, roughness) = model(&plastic);
    assert!(color.iter().zip([0.5, 0.25, 0.125]).all(|(a, b)| (a - b).abs() < 1e-5), "{color:?}");
    assert!(metallic < 1e-5 && (roughness - 0.25).abs() < 1e-6, "{metallic} {roughness}");
    assert!(warnings(&plastic).contains("shares of metal"));
    let gold = glossy(json!({"diffuseFactor": [0, 0, 0, 1], "specularFactor": [1.0, 0.75, 0.3]}));
    let (color, metallic, roughness) = model(&gold);
    assert!(color.iter().zip([1.0, 0.75, 0.3]).all(|(a, b)| (a - b).abs() < 1e-5), "{color:?}");
    assert!(metallic > 0.9999 && roughness == 0.0, "{metallic} {roughness}");
}

#[test]
fn pictures_of_gloss_become_those_of_metal() {
    // The left half is white plastic, the right one is gold.
    let encoded = |texels: [[u8; 4]; 2]| {
        let mut bytes = Cursor::new(Vec::new());
        let image = ImageBuffer::from_fn(2, 1, |x, _| Rgba(texels[x as usize]));
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        json!({"uri": data_uri(&bytes.into_inner())})
    };
    let mut document = painted();
    document["images"] = json!([
        encoded([[255, 255, 255, 255], [0, 0, 0, 128]]),
        // 0.04 is 56 of 255 as sRGB has it.
        encoded([[56, 56, 56, 255], [255, 225, 149, 51]]),
    ]);
    document["textures"] = json!([{"source": 0}, {"source": 1}]);
    document["materials"][0] = json!({"name": "painted", "alphaMode": "BLEND",
        "extensions": {"KHR_materials_pbrSpecularGlossiness": {
            "diffuseTexture": {"index": 0}, "specularGlossinessTexture": {"index": 1}}}});
    let world = load_json(&document).unwrap();
    let material = world.find("painted").expect("it is there");
    let textures = world.entities().get::<&Textures>(material).map(|it| (*it).clone()).unwrap();
    let texel = |wanted: Parameter, column: u32| {
        let mut of = textures.parameters.iter().filter(|(parameter, _)| *parameter == wanted);
        let (_, paint) = of.next().expect("it is painted");
        let texture = paint.texture.clone().expect("by a picture");
        paint.color(texture.picture.texels().at(column, 0, texture.coding))
    };
    let near = |found: [f32; 3], wanted: [f32; 3]| {
        let apart = found.iter().zip(wanted).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f32::max) < 0.01, "{found:?}, not {wanted:?}");
    };
    near(texel(Parameter::BaseColor, 0), [1.0; 3]);
    near(texel(Parameter::Metallic, 0), [0.0; 3]);
    near(texel(Parameter::Roughness, 0), [0.0; 3]);
    near(texel(Parameter::BaseColor, 1), [1.0, 0.753, 0.301]);
    near(texel(Parameter::Metallic, 1), [1.0; 3]);
    near(texel(Parameter::Roughness, 1), [0.8; 3]);
    assert!(textures.coverage.is_some(), "alpha is that of the diffuse color");
}

#[test]
fn factors_that_are_none_are_refused() {
    refused(&[
        (
            |d| *d = glossy(json!({"diffuseFactor": [1, 1, 1]})),
            &["material 0", "diffuseFactor", "is not 4 numbers"],
        ),
        (
            |d| *d = glossy(json!({"specularFactor": [1, 2, 1]})),
            &["material 0", "specularFactor", "within [0, 1]"],
        ),
        (
            |d| *d = glossy(json!({"glossinessFactor": "much"})),
            &["material 0", "glossinessFactor", "within [0, 1]"],
        ),
    ]);
}
