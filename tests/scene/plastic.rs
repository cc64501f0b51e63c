//! Plastic: what files say of it, in glTF and in Mitsuba's XML.

use serde_json::{Value, json};
use sunstone::internals::polarization::Distribution;
use sunstone::internals::scene::world::{Coat, InternalReflection, SurfaceModel};
use sunstone::internals::scene::{Written, bake, load};
use sunstone::internals::spectrum::Carried;

use crate::common::{good, load_bytes, scratch};
use crate::errors::refused;
use crate::meaning::baked;
use crate::mitsuba::{loaded, scene};

const GREEN: Carried<1> = Carried::at([550.0]);

fn with(mut keys: Value) -> SurfaceModel<[f32; 3]> {
    keys["bsdf"] = json!("plastic");
    let mut document = good();
    document["materials"][0] = json!({"extensions": {"SUNSTONE_polarization": keys}});
    baked(&document).optics.materials[0].model.clone()
}

#[test]
fn keys_and_their_defaults() {
    let plain = with(json!({"alpha": 0.2}));
    let expected = SurfaceModel::Plastic {
        reflectance: [1.0; 3],
        coat: Coat {
            ior: 1.5,
            exterior_ior: 1.0,
            alpha: 0.2,
            distribution: Distribution::Ggx,
            specular: 1.0,
            internal_reflection: InternalReflection::Nonlinear,
        },
    };
    assert_eq!(plain, expected);
    for within in InternalReflection::ALL {
        let all = with(json!({"reflectance": [0.1, 0.2, 0.3], "ior": 1.6, "exterior_ior": 1.25,
            "roughness": 0.5, "distribution": "beckmann", "specular": 0.5,
            "internal_reflection": within.name()}));
        let expected = SurfaceModel::Plastic {
            reflectance: [0.1, 0.2, 0.3],
            coat: Coat {
                ior: 1.6,
                exterior_ior: 1.25,
                alpha: 0.25,
                distribution: Distribution::Beckmann,
                specular: 0.5,
                internal_reflection: within,
            },
        };
        assert_eq!(all, expected);
    }
}

/// glTF's own parameters are what is not said otherwise.
#[test]
fn colors_and_indices_of_gltf_are_those_of_the_base() {
    let mut document = good();
    document["materials"][0] = json!({
        "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 0.125, 1.0]},
        "extensions": {"KHR_materials_ior": {"ior": 1.75},
            "SUNSTONE_polarization": {"bsdf": "plastic", "alpha": 0.2}}});
    let model = baked(&document).optics.materials[0].model.clone();
    let SurfaceModel::Plastic { reflectance, coat } = model else { panic!("{model:?}") };
    assert_eq!((reflectance, coat.ior), ([0.5, 0.25, 0.125], 1.75));
}

/// Makes the first material plastic with these keys.
fn plastic(document: &mut Value, mut keys: Value) {
    keys["bsdf"] = json!("plastic");
    document["materials"][0]["extensions"]["SUNSTONE_polarization"] = keys;
}

#[test]
fn plastics_that_are_none() {
    refused(&[
        (
            |d| plastic(d, json!({})),
            &["SUNSTONE_polarization.alpha", "is missing", "`roughness`, its root"],
        ),
        (|d| plastic(d, json!({"alpha": -0.1})), &["alpha", "-0.1 must be within [0, 1]"]),
        (
            |d| plastic(d, json!({"alpha": 0.1, "ior": 0.9})),
            &["material 0", "ior over exterior_ior", "0.9 must be from 1 to 10"],
        ),
        (
            |d| plastic(d, json!({"alpha": 0.1, "ior": 1.5, "exterior_ior": 0.0})),
            &["exterior_ior", "0 must be"],
        ),
        (|d| plastic(d, json!({"alpha": 0.1, "ior": "glass"})), &["ior", "number"]),
        (
            |d| plastic(d, json!({"alpha": 0.1, "specular": 1.5})),
            &["specular", "1.5 must be within [0, 1]"],
        ),
        (
            |d| plastic(d, json!({"alpha": 0.1, "reflectance": [0.1, 0.2, 2.0]})),
            &["reflectance", "within [0, 1]"],
        ),
        (
            |d| plastic(d, json!({"alpha": 0.1, "internal_reflection": "twice"})),
            &["internal_reflection", "`twice`", "use one of lost, linear, nonlinear"],
        ),
        (
            |d| plastic(d, json!({"alpha": 0.1, "k": 1.0})),
            &["k", "means nothing for a plastic", "specular"],
        ),
    ]);
}

fn of_mitsuba(bsdf: &str) -> SurfaceModel<[f32; 1]> {
    let world = loaded(&format!("<shape type='sphere'>{bsdf}</shape>"));
    bake(&world, &GREEN).unwrap_or_else(|error| panic!("{error}")).optics.materials[0].model.clone()
}

#[test]
fn mitsubas_plastics() {
    let of = |alpha, distribution, internal_reflection| SurfaceModel::Plastic {
        reflectance: [0.5],
        coat: Coat {
            ior: 1.49,
            exterior_ior: 1.000_277,
            alpha,
            distribution,
            specular: 1.0,
            internal_reflection,
        },
    };
    use Distribution::{Beckmann, Ggx};
    use InternalReflection::{Linear, Lost, Nonlinear};
    let cases = [
        ("<bsdf type='pplastic'/>", of(0.1, Beckmann, Lost)),
        ("<bsdf type='roughplastic'/>", of(0.1, Beckmann, Linear)),
        ("<bsdf type='plastic'/>", of(0.0, Ggx, Linear)),
        (
            "<bsdf type='plastic'><boolean name='nonlinear' value='true'/></bsdf>",
            of(0.0, Ggx, Nonlinear),
        ),
        (
            "<bsdf type='roughplastic'><boolean name='nonlinear' value='true'/>\
             <string name='distribution' value='ggx'/><float name='alpha' value='0.3'/></bsdf>",
            of(0.3, Ggx, Nonlinear),
        ),
    ];
    for (bsdf, expected) in cases {
        assert_eq!(of_mitsuba(bsdf), expected, "{bsdf}");
    }
    let other = of_mitsuba(
        "<bsdf type='pplastic'><spectrum name='diffuse_reflectance' value='0.25'/>\
         <spectrum name='specular_reflectance' value='0.75'/>\
         <string name='int_ior' value='water'/><float name='ext_ior' value='1'/></bsdf>",
    );
    let SurfaceModel::Plastic { reflectance, coat } = other else { panic!("{other:?}") };
    assert_eq!((reflectance, coat.specular, coat.ior), ([0.25], 0.75, 1.333));
}

#[test]
fn mitsubas_plastics_that_are_none() {
    let colored = "<rgb name='specular_reflectance' value='1 0.5 0.5'/>";
    let less = "<float name='int_ior' value='1'/><float name='ext_ior' value='1.5'/>";
    let bright = "<spectrum name='diffuse_reflectance' value='1.5'/>";
    for (body, texts) in [
        (colored, ["specular_reflectance", "one number"]),
        (less, ["int_ior", "from 1 to 10"]),
        (bright, ["diffuse_reflectance", "within [0, 1]"]),
        ("<boolean name='nonlinear' value='true'/>", ["nonlinear", "pplastic"]),
    ] {
        let body = format!("<shape type='sphere'><bsdf type='pplastic'>{body}</bsdf></shape>");
        let error = load_bytes("scene.xml", scene(&body).as_bytes()).err();
        let error = error.unwrap_or_else(|| panic!("{body} is read")).to_string();
        assert!(texts.iter().all(|text| error.contains(text)), "{error}");
    }
}

#[test]
fn what_is_written_is_read_again() {
    let world = loaded(
        "<shape type='sphere'><bsdf type='pplastic'><float name='alpha' value='0.2'/>\
         <spectrum name='specular_reflectance' value='0.5'/></bsdf></shape>",
    );
    let written = Written::of(&world).unwrap_or_else(|error| panic!("{error}"));
    let path = scratch("plastic.gltf");
    written.save(&path).unwrap();
    let again = load(&path).unwrap_or_else(|error| panic!("{error}"));
    std::fs::remove_file(&path).unwrap();
    let models = [&world, &again]
        .map(|world| bake(world, &GREEN).unwrap().optics.materials[0].model.clone());
    assert_eq!(models[0], models[1]);
}
