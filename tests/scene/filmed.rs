//! Thin films on rough surfaces, and films by pictures: what files say of them, and what becomes of
//! it where it is written.

use serde_json::{Value, json};
use sunstone::internals::scene::world::{SurfaceModel, ThinFilm};
use sunstone::internals::scene::{World, Written, bake, load};
use sunstone::internals::spectrum::Carried;
use sunstone::world::{Bsdf, Parameter, Reads, Textures};

use crate::common::{good, load_json, scratch};
use crate::errors::refused;
use crate::meaning::{baked, warnings};
use crate::textures::painted;

type Model = SurfaceModel<[f32; 3]>;

fn with(material: Value) -> Value {
    let mut document = good();
    document["materials"][0] = material;
    document
}

fn own(body: Value) -> Value {
    with(json!({"extensions": {"SUNSTONE_polarization": body}}))
}

fn model(document: &Value) -> Model {
    baked(document).optics.materials[0].model.clone()
}

/// The model under a film, and the film.
fn parts(document: &Value) -> (Model, ThinFilm<[f32; 3]>) {
    match model(document) {
        SurfaceModel::Filmed { of, film } => (*of, film),
        other => panic!("{other:?}"),
    }
}

#[test]
fn rough_models_have_films_by_keys_of_the_extension() {
    let film = json!({"eta": 2.5, "thickness_nm": 100, "share": 0.25});
    let metal = own(json!({"bsdf": "rough_conductor", "metal": "Ti", "alpha": 0.3, "film": film}));
    let (of, found) = parts(&metal);
    assert!(matches!(of, SurfaceModel::RoughConductor { alpha: 0.3, .. }), "{of:?}");
    assert_eq!((found.eta, found.share, found.portion), ([2.5; 3], 0.25, 1.0));
    assert_eq!(found.thickness, [605.0, 542.0, 455.0].map(|nm| 100.0 / nm));
    let glass = own(json!({"bsdf": "rough_dielectric", "alpha_u": 0.3, "alpha_v": 0.1,
        "film": film}));
    let (of, _) = parts(&glass);
    let SurfaceModel::Brushed { of, .. } = of else { panic!("{of:?}") };
    assert!(matches!(*of, SurfaceModel::RoughDielectric { .. }), "{of:?}");
    // Metal that is not rough is smooth.
    let smooth = own(json!({"bsdf": "rough_conductor", "metal": "Ti", "alpha": 0.0, "film": film}));
    assert!(matches!(model(&smooth), SurfaceModel::FilmedConductor { .. }));
}

/// On whatever metallic-roughness is, with facets that are stretched, too.
#[test]
fn iridescence_is_on_all_of_metallic_roughness() {
    let of = |metallic: f64, roughness: f64, more: Value| {
        let mut material = json!({
            "pbrMetallicRoughness": {"metallicFactor": metallic, "roughnessFactor": roughness},
            "extensions": {"KHR_materials_iridescence": {"iridescenceFactor": 0.5,
                "iridescenceIor": 1.5, "iridescenceThicknessMaximum": 250.0}}});
        let extensions = material["extensions"].as_object_mut().unwrap();
        extensions.extend(more.as_object().unwrap().clone());
        with(material)
    };
    for metallic in [0.0, 0.5, 1.0] {
        let document = of(metallic, 0.5, json!({}));
        let (under, film) = parts(&document);
        assert!(matches!(under, SurfaceModel::MetallicRoughness { .. }), "{under:?}");
        assert_eq!((film.eta, film.share), ([1.5; 3], 0.5));
        assert!(!warnings(&document).contains("iridescence"), "{}", warnings(&document));
    }
    let stretched = json!({"KHR_materials_anisotropy": {"anisotropyStrength": 0.5}});
    let (under, _) = parts(&of(1.0, 0.5, stretched));
    assert!(matches!(under, SurfaceModel::Brushed { .. }), "{under:?}");
    let solid = json!({"KHR_materials_volume": {"thicknessFactor": 1.0},
        "KHR_materials_transmission": {"transmissionFactor": 1.0}});
    let (under, _) = parts(&of(0.0, 0.5, solid));
    assert!(matches!(under, SurfaceModel::RoughDielectric { .. }), "{under:?}");
    for more in [
        json!({"KHR_materials_clearcoat": {"clearcoatFactor": 1.0}}),
        json!({"KHR_materials_transmission": {"transmissionFactor": 1.0}}),
    ] {
        let document = of(0.0, 0.0, more);
        assert!(warnings(&document).contains("its iridescence is ignored"));
        assert!(!matches!(model(&document), SurfaceModel::Filmed { .. }));
    }
}

/// The material that [`painted`] paints.
fn textures(world: &World) -> Textures {
    let material = world.find("painted").expect("it is there");
    let found = world.entities().get::<&Textures>(material).expect("it is painted");
    (*found).clone()
}

/// By its parameters: the factor, and what is read.
fn paints(world: &World) -> Vec<(Parameter, f32, Reads)> {
    let of = textures(world);
    of.parameters.iter().map(|(it, paint)| (*it, paint.factor[0], paint.reads)).collect()
}

fn iridescent(metallic: f64, roughness: f64) -> Value {
    let mut document = painted();
    document["materials"][0] = json!({"name": "painted",
        "pbrMetallicRoughness": {"metallicFactor": metallic, "roughnessFactor": roughness},
        "extensions": {"KHR_materials_iridescence": {"iridescenceFactor": 0.5,
            "iridescenceThicknessMinimum": 400.0, "iridescenceThicknessMaximum": 200.0,
            "iridescenceTexture": {"index": 0}, "iridescenceThicknessTexture": {"index": 0}}}});
    document
}

fn film_of(world: &World) -> ThinFilm<sunstone::Spectrum> {
    let material = world.find("painted").expect("it is there");
    let found = world.entities().get::<&Bsdf>(material).expect("it has a model");
    match &*found {
        Bsdf::Filmed { film, .. } | Bsdf::FilmedConductor { film, .. } => film.clone(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn pictures_say_how_much_is_covered_and_how_thick_films_are() {
    for (metallic, roughness) in [(1.0, 0.0), (1.0, 0.5), (0.0, 0.5)] {
        let world = load_json(&iridescent(metallic, roughness)).unwrap();
        assert!(world.warnings().is_empty(), "{:?}", world.warnings());
        let expected = [
            (Parameter::FilmShare, 0.5, Reads::Red),
            (Parameter::FilmThickness, 1.0, Reads::Green),
        ];
        assert_eq!(paints(&world), expected);
        let film = film_of(&world);
        assert_eq!((film.thickness, film.portions), (400.0.into(), [1.0, 0.5]));
        // What the whole surface is like: a red and a green texel of four, and a white one.
        let mean = bake(&world, &Carried::at([500.0])).unwrap().optics.materials[0].model.clone();
        let (SurfaceModel::Filmed { film, .. } | SurfaceModel::FilmedConductor { film, .. }) = mean
        else {
            panic!("{mean:?}")
        };
        assert_eq!((film.share, film.portion), (0.25, 0.75));
    }
    // Without its picture, the film is as thick as the most.
    let mut plain = iridescent(1.0, 0.5);
    let of = &mut plain["materials"][0]["extensions"]["KHR_materials_iridescence"];
    of.as_object_mut().unwrap().remove("iridescenceThicknessTexture");
    let film = film_of(&load_json(&plain).unwrap());
    assert_eq!((film.thickness, film.portion), (200.0.into(), 1.0));
}

fn own_pictures() -> Value {
    let mut document = painted();
    document["materials"][0] = json!({"name": "painted", "extensions": {"SUNSTONE_polarization": {
        "bsdf": "rough_conductor", "metal": "Al", "alpha": 0.25, "film": {"eta": 1.5, "k": 0.125,
            "thickness_nm": 300, "thickness_black_nm": 150, "thickness_texture": {"index": 0,
                "extensions": {"SUNSTONE_polarization": {"channel": "blue"}}},
            "share": 0.75, "share_texture": {"index": 0}}}}});
    document
}

#[test]
fn pictures_are_keys_of_the_extension() {
    let world = load_json(&own_pictures()).unwrap();
    assert!(world.warnings().is_empty(), "{:?}", world.warnings());
    let expected = [
        (Parameter::FilmShare, 0.75, Reads::Luminance),
        (Parameter::FilmThickness, 1.0, Reads::Blue),
    ];
    assert_eq!(paints(&world), expected);
    assert_eq!(film_of(&world).portions, [0.5, 1.0]);
}

/// What is written is read as it was, films by pictures, too.
#[test]
fn films_are_written_as_they_are() {
    let film = json!({"eta": 2.5, "k": {"nm": [300, 900], "value": [0.1, 0.2]},
        "thickness_nm": 120, "share": 0.5});
    let plain = [
        json!({"bsdf": "rough_conductor", "metal": "Ti", "alpha_u": 0.3, "alpha_v": 0.1,
            "film": film}),
        json!({"bsdf": "rough_dielectric", "alpha": 0.3, "film": film}),
    ];
    let mut documents: Vec<Value> = plain.map(own).to_vec();
    for metallic in [0.0, 1.0] {
        documents.push(with(json!({"pbrMetallicRoughness": {"metallicFactor": metallic},
            "extensions": {"KHR_materials_iridescence": {"iridescenceFactor": 0.5}}})));
        documents.push(iridescent(metallic, 0.5));
    }
    documents.extend([iridescent(1.0, 0.0), own_pictures()]);
    for document in documents {
        let world = load_json(&document).unwrap();
        let written = Written::of(&world).unwrap_or_else(|error| panic!("{error}"));
        let path = scratch("filmed.gltf");
        written.save(&path).unwrap();
        let again = load(&path).unwrap_or_else(|error| panic!("{error}"));
        let models = [&world, &again].map(|world| {
            let carried = Carried::at([550.0]);
            bake(world, &carried).unwrap().optics.materials[0].model.clone()
        });
        assert_eq!(models[0], models[1]);
        if document["textures"].is_array() {
            assert_eq!(paints(&world), paints(&again));
        }
    }
}

/// The green of glTF's picture is the roughness of metal of the extension, too.
#[test]
fn rough_metal_has_a_roughness_by_gltfs_picture() {
    let mut document = painted();
    document["materials"][0] = json!({"name": "painted",
        "pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 0}},
        "extensions": {"SUNSTONE_polarization":
            {"bsdf": "rough_conductor", "metal": "Al", "roughness": 0.5}}});
    let world = load_json(&document).unwrap();
    assert!(world.warnings().is_empty(), "{:?}", world.warnings());
    assert_eq!(paints(&world), [(Parameter::Roughness, 0.5, Reads::Green)]);
    let written = Written::of(&world).unwrap_or_else(|error| panic!("{error}"));
    let path = scratch("rough_metal.gltf");
    written.save(&path).unwrap();
    let again = load(&path).unwrap();
    assert_eq!(paints(&again), paints(&world));
}

#[test]
fn what_is_refused_of_films() {
    fn set(document: &mut Value, film: Value) {
        *document = own(json!({"bsdf": "rough_conductor", "metal": "Al", "alpha": 0.2,
            "film": film}));
    }
    fn khr(document: &mut Value, mut of: Value) {
        of["iridescenceFactor"] = json!(1.0);
        *document = with(json!({"extensions": {"KHR_materials_iridescence": of}}));
    }
    refused(&[
        (
            |d| set(d, json!({"eta": 1.5, "thickness_nm": 5, "share": 1.5})),
            &["film.share", "1.5 must be within [0, 1]"],
        ),
        (
            |d| set(d, json!({"eta": 1.5, "thickness_nm": 5, "thickness_black_nm": 1})),
            &["film.thickness_black_nm", "means nothing", "thickness_texture"],
        ),
        (
            |d| set(d, json!({"eta": 1.5, "thickness_nm": -5})),
            &["film.thickness_nm", "-5 must be not negative"],
        ),
        (
            |d| {
                *d = own(json!({"bsdf": "rough_dielectric", "ior": "BK7", "alpha": 0.2,
                    "film": {"eta": 1.5, "thickness_nm": 5}}));
            },
            &["film", "dispersion", "indices that are numbers"],
        ),
        (
            |d| {
                *d = own(json!({"bsdf": "rough_dielectric", "ior": 1.0, "alpha": 0.2,
                    "film": {"eta": 1.5, "thickness_nm": 5}}));
            },
            &["film", "equal indices", "smooth dielectric"],
        ),
        (
            |d| khr(d, json!({"iridescenceThicknessMaximum": -1.0})),
            &["KHR_materials_iridescence.iridescenceThicknessMaximum", "-1 must be not negative"],
        ),
        (
            |d| khr(d, json!({"iridescenceThicknessMaximum": 1e6})),
            &["KHR_materials_iridescence.iridescenceThicknessMaximum", "100000 nm"],
        ),
        (
            |d| khr(d, json!({"iridescenceIor": 0.0})),
            &["KHR_materials_iridescence.iridescenceIor", "0 must be greater than 0"],
        ),
    ]);
}

/// Smooth ones are of the least rough facets there, as bare ones are; glass is none.
#[test]
fn filmed_metal_is_a_part_of_blends() {
    let film = json!({"eta": 1.5, "thickness_nm": 300});
    let blend = |part: Value| {
        let mut document = good();
        let of = |body: Value| json!({"extensions": {"SUNSTONE_polarization": body}});
        document["materials"][0] = of(json!({"bsdf": "blend", "first": "part", "second": "matte",
            "weight": 0.25}));
        let materials = document["materials"].as_array_mut().unwrap();
        for (name, body) in [("part", part), ("matte", json!({"bsdf": "diffuse"}))] {
            let mut material = of(body);
            material["name"] = json!(name);
            materials.push(material);
        }
        document
    };
    let metal = blend(json!({"bsdf": "conductor", "metal": "Ti", "film": film}));
    let SurfaceModel::Blend { parts, .. } = model(&metal) else { panic!("no blend") };
    let SurfaceModel::Filmed { of, .. } = &parts[0] else { panic!("{parts:?}") };
    assert!(matches!(**of, SurfaceModel::RoughConductor { alpha: 1e-3, .. }), "{of:?}");
    let glass = blend(json!({"bsdf": "rough_dielectric", "alpha": 0.5, "film": film}));
    let error = load_json(&glass).unwrap_err();
    assert!(error.contains("first") && error.contains("glass cannot be a part"), "{error}");
}
