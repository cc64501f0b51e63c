//! Facets that are stretched along a direction: what files say of them, in glTF and in Mitsuba's
//! XML.

use serde_json::{Value, json};
use sunstone::internals::polarization::Distribution;
use sunstone::internals::scene::world::SurfaceModel;
use sunstone::internals::scene::{Written, bake, load};
use sunstone::internals::spectrum::Carried;
use sunstone::world::{Along, Grain, Parameter, Reads, Textures};

use crate::common::{good, load_bytes, load_json, scratch};
use crate::errors::refused;
use crate::meaning::{baked, warnings};
use crate::mitsuba::{loaded, scene};
use crate::textures::painted;

const GREEN: Carried<1> = Carried::at([550.0]);

fn brushed<const N: usize>(of: SurfaceModel<[f32; N]>, grain: Grain) -> SurfaceModel<[f32; N]> {
    SurfaceModel::Brushed { of: Box::new(of), grain }
}

fn metal<const N: usize>(alpha: f32, distribution: Distribution) -> SurfaceModel<[f32; N]> {
    let (eta, k) = ([0.5; N], [2.0; N]);
    SurfaceModel::RoughConductor { eta, k, alpha, distribution, multiple_scattering: true }
}

fn with(body: Value) -> Value {
    let mut document = good();
    document["materials"][0] = json!({"extensions": {"SUNSTONE_polarization": body}});
    document
}

#[test]
fn keys_of_the_extension() {
    let model = |body| baked(&with(body)).optics.materials[0].model.clone();
    let found = model(json!({"bsdf": "rough_conductor", "eta": 0.5, "k": 2.0, "alpha_u": 0.4,
        "alpha_v": 0.1, "axis_deg": 180}));
    let grain = Grain { turn: std::f32::consts::PI, ..Grain::new(Along::Alpha(0.4)) };
    assert_eq!(found, brushed(metal(0.1, Distribution::Ggx), grain));
    let found = model(json!({"bsdf": "rough_dielectric", "ior": 1.5, "alpha_u": 0.4,
        "alpha_v": 0.1}));
    let SurfaceModel::Brushed { of, grain } = found else { panic!("{found:?}") };
    assert_eq!(grain, Grain::new(Along::Alpha(0.4)));
    assert!(matches!(*of, SurfaceModel::RoughDielectric { alpha: 0.1, .. }), "{of:?}");
    // Neither is rough.
    let found = model(json!({"bsdf": "rough_conductor", "eta": 0.5, "k": 2.0, "alpha_u": 0.0,
        "alpha_v": 5e-4}));
    assert_eq!(found, SurfaceModel::Conductor { eta: [0.5; 3], k: [2.0; 3] });
}

#[test]
fn what_is_refused_of_them() {
    fn set(document: &mut Value, mut body: Value) {
        body["bsdf"] = json!("rough_conductor");
        body["metal"] = json!("Al");
        *document = with(body);
    }
    refused(&[
        (|d| set(d, json!({"alpha_u": 0.4})), &["alpha_v", "is missing"]),
        (|d| set(d, json!({"alpha_v": 0.4})), &["alpha_u", "is missing"]),
        (
            |d| set(d, json!({"alpha_u": 0.4, "alpha_v": 0.1, "alpha": 0.2})),
            &["alpha", "contradicts alpha_u"],
        ),
        (|d| set(d, json!({"alpha": 0.2, "axis_deg": 3})), &["axis_deg", "means nothing"]),
        (
            |d| set(d, json!({"alpha_u": 1.4, "alpha_v": 0.1})),
            &["alpha_u", "1.4 must be within [0, 1]"],
        ),
        (
            |d| set(d, json!({"alpha_u": 0.4, "alpha_v": -0.1})),
            &["alpha_v", "-0.1 must be within [0, 1]"],
        ),
    ]);
}

/// glTF's, of a metal, of a smooth one too, and of a coat.
#[test]
fn anisotropy_of_gltf() {
    let of = |pbr: Value, anisotropy: Value| {
        let mut document = good();
        document["materials"][0] = json!({"pbrMetallicRoughness": pbr,
            "extensions": {"KHR_materials_anisotropy": anisotropy}});
        document
    };
    let turned = json!({"anisotropyStrength": 0.5, "anisotropyRotation": 1.5});
    for (metallic, roughness) in [(1.0, 0.5), (0.0, 0.5), (1.0, 0.0)] {
        let pbr = json!({"metallicFactor": metallic, "roughnessFactor": roughness});
        let document = of(pbr, turned.clone());
        let model = baked(&document).optics.materials[0].model.clone();
        let SurfaceModel::Brushed { of, grain } = model else { panic!("{model:?}") };
        assert_eq!(grain, Grain { turn: 1.5, ..Grain::new(Along::Strength(0.5)) });
        let SurfaceModel::MetallicRoughness { alpha, .. } = *of else { panic!("{of:?}") };
        assert_eq!(alpha, roughness * roughness);
        let said = warnings(&document);
        assert!(!said.contains("anisotropy"), "{said}");
    }
    assert_eq!(Grain::new(Along::Strength(0.5)).alphas(0.2), [0.4, 0.2]);
    let plain = of(json!({}), json!({"anisotropyRotation": 1.5}));
    let model = baked(&plain).optics.materials[0].model.clone();
    assert!(matches!(model, SurfaceModel::MetallicRoughness { .. }), "{model:?}");
    let mut coated = of(json!({}), turned);
    coated["materials"][0]["extensions"]["KHR_materials_clearcoat"] =
        json!({"clearcoatFactor": 1.0});
    let said = warnings(&coated);
    assert!(said.contains("its anisotropy is ignored"), "{said}");
    let error = load_json(&of(json!({}), json!({"anisotropyStrength": 2}))).map(|_| ());
    let error = error.unwrap_err();
    assert!(error.contains("KHR_materials_anisotropy.anisotropyStrength: 2 must be"), "{error}");
}

#[test]
fn pictures_of_anisotropy_feed_direction_and_strength() {
    let mut document = painted();
    document["materials"][0]["extensions"]["KHR_materials_anisotropy"] =
        json!({"anisotropyStrength": 0.5, "anisotropyTexture": {"index": 0}});
    let world = load_json(&document).unwrap();
    let material = world.find("painted").unwrap();
    let textures = (*world.entities().get::<&Textures>(material).unwrap()).clone();
    let found: Vec<_> = textures
        .parameters
        .iter()
        .map(|(parameter, paint)| (*parameter, paint.factor[2], paint.reads))
        .collect();
    assert_eq!(found[0].0, Parameter::BaseColor);
    let expected = [
        (Parameter::GrainRight, 1.0, Reads::Red),
        (Parameter::GrainUp, 1.0, Reads::Green),
        (Parameter::Strength, 0.5, Reads::Blue),
    ];
    assert_eq!(found[1..], expected);
    assert!(world.warnings().is_empty(), "{:?}", world.warnings());
}

fn of_mitsuba(bsdf: &str) -> SurfaceModel<[f32; 1]> {
    let world = loaded(&format!("<shape type='sphere'>{bsdf}</shape>"));
    bake(&world, &GREEN).unwrap_or_else(|error| panic!("{error}")).optics.materials[0].model.clone()
}

const ALPHAS: &str = "<float name='alpha_u' value='0.4'/><float name='alpha_v' value='0.1'/>";

#[test]
fn mitsubas_facets() {
    let found = of_mitsuba(&format!(
        "<bsdf type='roughconductor'>{ALPHAS}<spectrum name='eta' value='0.5'/>\
         <spectrum name='k' value='2'/></bsdf>"
    ));
    let SurfaceModel::Brushed { of, grain } = found else { panic!("{found:?}") };
    assert_eq!(grain, Grain::new(Along::Alpha(0.4)));
    let SurfaceModel::RoughConductor { alpha, distribution, multiple_scattering, .. } = *of else {
        panic!("{of:?}")
    };
    assert_eq!((alpha, distribution), (0.1, Distribution::Beckmann));
    assert!(!multiple_scattering);
    let found = of_mitsuba(&format!("<bsdf type='roughdielectric'>{ALPHAS}</bsdf>"));
    assert!(matches!(found, SurfaceModel::Brushed { .. }), "{found:?}");
    for (body, texts) in [
        ("<bsdf type='roughplastic'>ALPHAS</bsdf>", ["alpha_u", "plastic"]),
        (
            "<bsdf type='roughconductor'><float name='alpha_u' value='0.4'/></bsdf>",
            ["alpha_v", "is missing"],
        ),
    ] {
        let body = body.replace("ALPHAS", ALPHAS);
        let body = format!("<shape type='sphere'>{body}</shape>");
        let error = load_bytes("scene.xml", scene(&body).as_bytes()).map(|_| ()).unwrap_err();
        assert!(texts.iter().all(|text| error.contains(text)), "{error}");
    }
}

#[test]
fn what_is_written_is_read_again() {
    let of =
        |bsdf: &str| format!("<shape type='sphere'><bsdf type='{bsdf}'>{ALPHAS}</bsdf></shape>");
    let mut document = good();
    document["materials"][0] = json!({"extensions": {"KHR_materials_anisotropy":
        {"anisotropyStrength": 0.5, "anisotropyRotation": 0.25}}});
    let worlds = [
        loaded(&of("roughconductor")),
        loaded(&of("roughdielectric")),
        load_json(&document).unwrap(),
    ];
    for world in worlds {
        let written = Written::of(&world).unwrap_or_else(|error| panic!("{error}"));
        let path = scratch("brushed.gltf");
        written.save(&path).unwrap();
        let again = load(&path).unwrap_or_else(|error| panic!("{error}"));
        std::fs::remove_file(&path).unwrap();
        let models = [&world, &again]
            .map(|world| bake(world, &GREEN).unwrap().optics.materials[0].model.clone());
        assert_eq!(models[0], models[1]);
    }
}

/// The direction goes by the coordinates of meshes where nothing else does.
#[test]
fn meshes_without_pictures_say_where_the_right_is() {
    let mut document = painted();
    for key in ["textures", "images", "samplers"] {
        document.as_object_mut().unwrap().remove(key);
    }
    let path = scratch("coordinates.gltf");
    let mut has_coordinates = |extensions: Value| {
        document["materials"][0] = json!({"extensions": extensions});
        Written::of(&load_json(&document).unwrap()).unwrap().save(&path).unwrap();
        std::fs::read_to_string(&path).unwrap().contains("TEXCOORD_0")
    };
    let brushed = json!({"bsdf": "rough_conductor", "metal": "Al", "alpha_u": 0.4, "alpha_v": 0.1});
    let anisotropic = json!({"KHR_materials_anisotropy": {"anisotropyStrength": 0.5}});
    for extensions in [json!({"SUNSTONE_polarization": brushed}), anisotropic] {
        assert!(has_coordinates(extensions));
    }
    assert!(!has_coordinates(json!({})), "the test cannot fail");
}
